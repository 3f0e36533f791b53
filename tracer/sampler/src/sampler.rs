//! A template: its sections, and its objects, placed one by one.

use rtcli_reader::json::write_numbers;
use rtcli_reader::read_object;
use rtcli_reader::scene::shapes;

use crate::constraints::{Placed, Requirement, Shape, Surroundings, View, difference, dot, negative, unit};
use crate::json::{mapping, write_text};
use crate::value::{Context, Value};

/// An item under `objects`: one object, or several.
#[derive(Debug)]
pub struct Group {
    /// The name of the object or the group.
    pub name: Option<String>,
    /// The number of objects; None for a single one, whose name has no number.
    pub repeat: Option<Value>,
    /// The group of the plane that they rest on.
    pub rest_on: Option<usize>,
    /// The number of the alternative that an object has.
    pub form: Value,
    /// The alternatives, each with all keys of an object.
    pub alternatives: Vec<Vec<(String, Value)>>,
    /// What each of its objects must meet.
    pub requirements: Vec<Requirement>,
}

/// A template.
#[derive(Debug)]
pub struct Sampler {
    /// The values of a scene beside `objects`, by key.
    pub sections: Vec<(String, Value)>,
    /// The items under `objects`.
    pub groups: Vec<Group>,
    /// The numbers of the groups in the order in which their objects are placed.
    pub order: Vec<usize>,
}

/// How often a constraint refused an object.
#[derive(Clone, Debug, PartialEq)]
pub struct Refusal {
    /// The name of the constraint.
    pub kind: &'static str,
    /// How often.
    pub count: usize,
    /// How often it refused the last try of an object.
    pub ended: usize,
    /// The objects that last did not meet it.
    pub last: String,
}

/// What was drawn again for a sample.
#[derive(Debug, Default)]
pub struct Rejections {
    /// The number of objects and scenes that a constraint decided on.
    pub draws: usize,
    /// How often each constraint was asked, by its name.
    pub checks: Vec<(&'static str, usize)>,
    /// The constraints that refused, in the order of their first refusals.
    pub refusals: Vec<Refusal>,
}

impl Rejections {
    /// Counts that a constraint is asked.
    pub fn check(&mut self, kind: &'static str) {
        match self.checks.iter_mut().find(|(known, _)| *known == kind) {
            Some((_, count)) => *count += 1,
            None => self.checks.push((kind, 1)),
        }
    }

    /// Counts a refusal for some objects, which may be the end of a try.
    pub fn refuse(&mut self, kind: &'static str, objects: String, is_end: bool) {
        let place = self.refusals.iter().position(|refusal| refusal.kind == kind).unwrap_or_else(|| {
            self.refusals.push(Refusal { kind, count: 0, ended: 0, last: String::new() });
            self.refusals.len() - 1
        });
        let refusal = &mut self.refusals[place];
        refusal.count += 1;
        refusal.ended += usize::from(is_end);
        refusal.last = objects;
    }
}

/// A try to place the objects of a sample.
pub struct Try<'a> {
    /// The most attempts of an object.
    pub attempts: u64,
    /// What the picture shows.
    pub view: &'a View,
    /// Answers questions.
    pub caller: &'a mut dyn Caller,
    /// Where to count.
    pub rejections: &'a mut Rejections,
}

/// How a try ended.
pub enum Outcome<'a> {
    /// All objects, in the order of the file.
    Placed(Vec<Placed<'a>>),
    /// An object is not valid, for a reason.
    Invalid(String),
    /// An object never met its constraints, or the caller cancelled.
    Failed,
}

/// Answers the questions of a sampler while it places objects.
pub trait Caller {
    /// Returns the shape of an object in JSON that is not plainly valid; as an error, why it is not valid at all.
    fn shape_of(&mut self, json: &str) -> Result<Shape, String>;

    /// Returns whether to stop, asked before each draw of an object.
    fn is_cancelled(&mut self) -> bool;
}

impl Sampler {
    /// Returns the sections in a sample as JSON, by key.
    pub fn sections(&self, context: &Context<'_>) -> Option<Vec<(&str, String)>> {
        self.sections.iter().map(|(key, value)| Some((key.as_str(), value.json(context)?))).collect()
    }

    /// Places the objects of a sample one by one, each drawn again until it meets its constraints.
    pub fn place<'s>(&'s self, context: &Context<'_>, own: Try<'_>) -> Option<Outcome<'s>> {
        // The number of objects is never drawn again.
        let first = Context { attempt: 0, element: 0, ..*context };
        let count = |group: &Group| group.repeat.as_ref().map_or(Some(1), |repeat| repeat.number(&first));
        let counts: Vec<usize> = self.groups.iter().map(count).collect::<Option<_>>()?;
        let mut placer = Placer { sampler: self, context, own, placed: Vec::new() };
        for &group in &self.order {
            let before: usize = counts[..group].iter().sum();
            for element in 0..counts[group] {
                match placer.place(Slot { number: before + element, group, element })? {
                    Found::Placed => (),
                    Found::Invalid(reason) => return Some(Outcome::Invalid(reason)),
                    Found::Nothing => return Some(Outcome::Failed),
                }
            }
        }
        let Placer { mut placed, .. } = placer;
        placed.sort_by_key(|object| object.number);
        Some(Outcome::Placed(placed))
    }
}

/// What was found for a place.
enum Found {
    Placed,
    Invalid(String),
    Nothing,
}

/// The place of an object: among all objects of a sample, and in its group.
#[derive(Clone, Copy)]
struct Slot {
    number: usize,
    group: usize,
    element: usize,
}

/// A sample whose objects are being placed.
struct Placer<'s, 'c, 't> {
    sampler: &'s Sampler,
    context: &'c Context<'c>,
    own: Try<'t>,
    placed: Vec<Placed<'s>>,
}

impl<'s> Placer<'s, '_, '_> {
    /// Draws an object until it meets its constraints.
    fn place(&mut self, slot: Slot) -> Option<Found> {
        let requirements = &self.sampler.groups[slot.group].requirements;
        for number in 0..self.own.attempts {
            if self.own.caller.is_cancelled() {
                return Some(Found::Nothing);
            }
            self.own.rejections.draws += usize::from(!requirements.is_empty());
            let context =
                Context { attempt: self.context.attempt + number, element: slot.element as u64, ..*self.context };
            let candidate = match self.candidate(slot, &context)? {
                Ok(candidate) => candidate,
                Err(reason) => return Some(Found::Invalid(reason)),
            };
            let around = Surroundings { others: &self.placed, view: self.own.view };
            let mut meets_all = true;
            for requirement in requirements {
                self.own.rejections.check(requirement.kind());
                if let Some(objects) = requirement.refused(&candidate, &around) {
                    let is_end = number + 1 == self.own.attempts;
                    self.own.rejections.refuse(requirement.kind(), objects, is_end);
                    meets_all = false;
                    break;
                }
            }
            if meets_all {
                self.placed.push(candidate);
                return Some(Found::Placed);
            }
        }
        Some(Found::Nothing)
    }

    /// Returns an object as it is drawn, at rest on its plane; as an error, why it is not valid.
    fn candidate(&mut self, slot: Slot, context: &Context<'_>) -> Option<Result<Placed<'s>, String>> {
        let group = &self.sampler.groups[slot.group];
        let form = group.alternatives.get(group.form.number::<usize>(context)?)?;
        let mut keys: Vec<(&str, String)> =
            form.iter().map(|(key, value)| Some((key.as_str(), value.json(context)?))).collect::<Option<_>>()?;
        let name = group.name.as_ref().map(|name| match group.repeat {
            Some(_) => format!("{name}[{}]", slot.element),
            None => name.clone(),
        });
        if let Some(name) = &name {
            set(&mut keys, "name", |json| write_text(name, json));
        }
        let json = mapping(&keys);
        let mut shape = match plain_shape(&json).map_or_else(|| self.own.caller.shape_of(&json), Ok) {
            Ok(shape) => shape,
            Err(reason) => return Some(Err(reason)),
        };
        let mut body = shape.body();
        if let (Some(plane), Some(solid)) = (group.rest_on, &body) {
            let plane = &self.placed.iter().find(|other| other.group == plane)?.shape;
            let up = unit(plane.parameters[..].try_into().ok()?);
            let way = solid.reach(negative(up)) - dot(up, difference(shape.position, plane.position));
            shape.position = [0, 1, 2].map(|axis| shape.position[axis] + way * up[axis]);
            body = shape.body();
            set(&mut keys, "position", |json| write_numbers(&shape.position, ",", json));
        }
        Some(Ok(Placed { number: slot.number, name, group: slot.group, shape, body, keys }))
    }
}

/// Sets a key to a value, in its place if it is there.
fn set<'a>(keys: &mut Vec<(&'a str, String)>, key: &'a str, write: impl FnOnce(&mut String)) {
    let mut json = String::new();
    write(&mut json);
    match keys.iter_mut().find(|(known, _)| *known == key) {
        Some((_, value)) => *value = json,
        None => keys.push((key, json)),
    }
}

/// Returns the shape of an object in JSON; None if it is not plainly valid.
fn plain_shape(json: &str) -> Option<Shape> {
    let objects = read_object(json)?;
    let kind = shapes().nth(usize::from(*objects.kind.first()?))?;
    Some(Shape {
        kind: kind.into(),
        position: objects.position[..].try_into().ok()?,
        parameters: objects.parameters,
    })
}

#[cfg(test)]
mod tests;
