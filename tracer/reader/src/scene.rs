//! A whole scene file.

use std::collections::HashSet;

use crate::row::{Counter, Row, field_of, read_component, read_row, read_value};
use crate::schema::{Kind, Mapping, Value};
use crate::source::json::Json;
use crate::source::yaml::Yaml;
use crate::source::{Source, text_of};
use crate::table::{CARRIED_LIGHT, CHECKER, LIGHT, LIGHTS, OBJECT, SCENE, SHAPES};

/// The formats of scene files.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Format {
    /// RFC 8259.
    Json,
    /// YAML 1.2, as libyaml reads it.
    Yaml,
}

/// A step of the path to a value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Step<'a> {
    /// A key, or the name of an object.
    Key(&'a str),
    /// A place in a list, from 0.
    Index(usize),
}

/// A change to a file before it is checked.
#[derive(Clone, Debug)]
pub struct Edit<'a> {
    /// The path to the value.
    pub path: Vec<Step<'a>>,
    /// The new value, as YAML in one line.
    pub value: &'a str,
}

/// The value of a key of a section.
#[derive(Clone, Debug, PartialEq)]
pub enum Setting {
    /// True or false.
    Boolean(bool),
    /// An integer.
    Integer(i64),
    /// A number.
    Number(f64),
    /// A vector or color.
    Numbers(Vec<f64>),
    /// Several integers.
    Integers(Vec<i64>),
    /// A word.
    Word(&'static str),
    /// The key is left out, and has no default.
    Missing,
}

/// A section of a file, such as its camera: each key with its value.
pub type Section = Vec<(&'static str, Setting)>;

/// The objects of a scene, one row each, in the order of the file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Objects {
    /// Indices into [`shapes`].
    pub kind: Vec<u8>,
    /// Three numbers each.
    pub position: Vec<f64>,
    /// The parameters of the first object, then those of the second, and so on.
    pub parameters: Vec<f64>,
    /// Three numbers each.
    pub color: Vec<f64>,
    /// For each object `-`, or the length of its name in characters, a colon, and the name.
    pub names: Vec<u8>,
}

/// The checkers of objects, one row each, in the order of the objects.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Checkers {
    /// The index of the object.
    pub object: Vec<i64>,
    /// One number each.
    pub size: Vec<f64>,
    /// Three numbers each.
    pub color: Vec<f64>,
}

/// The lights of a scene, one row each, those that objects carry after the others.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Lights {
    /// Indices into [`light_kinds`].
    pub kind: Vec<u8>,
    /// As those of objects.
    pub parameters: Vec<f64>,
    /// Three numbers each.
    pub color: Vec<f64>,
    /// One number each: the intensity, or what a kind has in its place.
    pub intensity: Vec<f64>,
    /// The index of the object that carries it, or -1.
    pub carrier: Vec<i64>,
}

/// A valid scene, but for the rules that look at several keys of the camera.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// The sections by their keys in the file, with defaults for all that is left out.
    pub sections: Vec<(&'static str, Section)>,
    /// The objects.
    pub objects: Objects,
    /// The checkers.
    pub checkers: Checkers,
    /// The lights.
    pub lights: Lights,
}

/// The kind of the lights that objects carry: point lights.
const CARRIED_KIND: u8 = 0;

/// Returns the names of the shapes, in the order of `Objects::kind`.
pub fn shapes() -> impl Iterator<Item = &'static str> {
    SHAPES.iter().map(|kind| kind.name)
}

/// Returns the names of the kinds of lights, in the order of `Lights::kind`.
pub fn light_kinds() -> impl Iterator<Item = &'static str> {
    LIGHTS.iter().map(|kind| kind.name)
}

/// Reads a scene file with some changes; None if it is not plainly valid, or memory runs out.
pub fn read(bytes: &[u8], format: Format, edits: &[Edit<'_>]) -> Option<Scene> {
    let text = str::from_utf8(text_of(bytes)).ok()?;
    match format {
        Format::Json => Reader::new(edits).read(&mut Json::new(text)),
        Format::Yaml => Reader::new(edits).read(&mut Yaml::new(text)?),
    }
}

/// Reads a valid scene file for what its source keeps.
pub(crate) fn read_from<'a>(source: &mut impl Source<'a>) -> Option<()> {
    Reader::new(&[]).read(source).map(drop)
}

/// Reads one object of a scene in JSON; None if it is not plainly valid.
pub fn read_object(json: &str) -> Option<Objects> {
    let mut reader = Reader::new(&[]);
    let mut source = Json::new(json);
    reader.read_object(&mut source, &mut ObjectRows::new(), &mut Counter::default())?;
    source.at_end().then_some(reader.objects)
}

/// The parts of a scene that are read so far.
struct Reader<'a, 'e> {
    edits: &'e [Edit<'a>],
    /// Whether each edit is made.
    is_made: Vec<bool>,
    counter: Counter,
    sections: Vec<(&'static str, &'static Mapping, Row<'a>)>,
    objects: Objects,
    checkers: Checkers,
    lights: Lights,
    /// Their parameters are the positions of the objects.
    carried: Lights,
    names: HashSet<&'a str>,
}

/// The numbers of an object and its parts.
struct ObjectRows<'a> {
    object: Row<'a>,
    light: Part<'a>,
    checker: Part<'a>,
}

impl ObjectRows<'_> {
    fn new() -> Self {
        ObjectRows { object: Row::new(&OBJECT), light: Part::new(&CARRIED_LIGHT), checker: Part::new(&CHECKER) }
    }
}

/// A mapping that an object may have.
struct Part<'a> {
    mapping: &'static Mapping,
    row: Row<'a>,
    is_there: bool,
}

impl<'a> Part<'a> {
    fn new(mapping: &'static Mapping) -> Self {
        Part { mapping, row: Row::new(mapping), is_there: false }
    }

    fn reset(&mut self, is_there: bool) {
        self.row.reset(self.mapping);
        self.is_there = is_there;
    }

    /// Whether it is not there, or has all keys that it must have.
    fn is_valid(&self) -> bool {
        !self.is_there || self.row.has(self.mapping.required)
    }
}

/// Returns that of the parts of an object which is the value of a key.
fn part_of<'p, 'a>(parts: [&'p mut Part<'a>; 2], value: &Value) -> Option<&'p mut Part<'a>> {
    let Value::Mapping(mapping) = value else { return None };
    parts.into_iter().find(|part| std::ptr::eq(part.mapping, *mapping))
}

/// Changes a value of an object or of one of its parts.
fn edit_object<'a>(
    object: &mut Row<'a>,
    parts: [&mut Part<'a>; 2],
    path: &[Step<'a>],
    value: &'a str,
) -> Option<()> {
    let (&Step::Key(key), inner) = path.split_first()? else { return None };
    let (index, field) = field_of(&OBJECT, key.as_bytes())?;
    if let Value::Text(..) = field.value {
        return None; // another name, by which later edits would find it
    }
    let Some(part) = part_of(parts, &field.value) else {
        return edit_row(&OBJECT, object, path, value);
    };
    if !part.is_there {
        part.reset(true);
        object.keys |= 1 << index;
    }
    edit_row(part.mapping, &mut part.row, inner, value)
}

impl<'a, 'e> Reader<'a, 'e> {
    fn new(edits: &'e [Edit<'a>]) -> Self {
        let section = |field: &crate::schema::Field| match field.value {
            Value::Mapping(mapping) => Some((field.key, mapping, Row::new(mapping))),
            _ => None,
        };
        Reader {
            edits,
            is_made: vec![false; edits.len()],
            counter: Counter::default(),
            sections: SCENE.fields.iter().filter_map(section).collect(),
            objects: Objects::default(),
            checkers: Checkers::default(),
            lights: Lights::default(),
            carried: Lights::default(),
            names: HashSet::default(),
        }
    }

    fn read<S: Source<'a>>(mut self, source: &mut S) -> Option<Scene> {
        self.counter.add(1)?;
        let mut row = Row::new(&SCENE);
        let mut counter = std::mem::take(&mut self.counter);
        read_row(source, &SCENE, &mut row, &mut counter, |source, field, counter| match field.value {
            Value::List(mapping) if std::ptr::eq(mapping, &OBJECT) => self.read_objects(source, counter),
            Value::List(_) => self.read_lights(source, counter),
            _ => {
                let (_, mapping, row) = self.section(field.key)?;
                read_row(source, mapping, row, counter, |_, _, _| None)
            }
        })?;
        if !source.at_end() {
            return None;
        }
        self.edit_sections()?;
        self.finish()
    }

    fn section(&mut self, name: &str) -> Option<&mut (&'static str, &'static Mapping, Row<'a>)> {
        self.sections.iter_mut().find(|(key, _, _)| *key == name)
    }

    /// Makes the edits that those of lists have left.
    fn edit_sections(&mut self) -> Option<()> {
        for (edit, is_made) in self.edits.iter().zip(self.is_made.clone()) {
            if !is_made {
                let (&Step::Key(name), path) = edit.path.split_first()? else { return None };
                let (_, mapping, row) = self.section(name)?;
                edit_row(mapping, row, path, edit.value)?;
            }
        }
        Some(())
    }

    /// Makes the edits of an item of a list, which has an index and perhaps a name.
    fn edit_item(
        &mut self,
        list: &str,
        (index, name): (usize, Option<&str>),
        mut edit: impl FnMut(&[Step<'a>], &'a str) -> Option<()>,
    ) -> Option<()> {
        for (wanted, is_made) in self.edits.iter().zip(&mut self.is_made) {
            let [Step::Key(key), item, path @ ..] = &wanted.path[..] else { continue };
            if *key != list {
                continue;
            }
            let is_meant = match item {
                Step::Index(at) => *at == index,
                // Without quotes, a longer name may be meant.
                Step::Key(_) if name.is_some_and(|name| name.contains(['.', '[', ']', '='])) => return None,
                Step::Key(key) => name == Some(*key),
            };
            if is_meant {
                edit(path, wanted.value)?;
                *is_made = true;
            }
        }
        Some(())
    }

    fn read_lights<S: Source<'a>>(&mut self, source: &mut S, counter: &mut Counter) -> Option<()> {
        let kind_slot = slot(&LIGHT, "type")?;
        let mut list = source.open_list()?;
        let mut row = Row::new(&LIGHT);
        while source.item(&mut list)? {
            counter.add(1)?;
            row.reset(&LIGHT);
            read_row(source, &LIGHT, &mut row, counter, |_, _, _| None)?;
            let place = (self.lights.kind.len(), None);
            self.edit_item("lights", place, |path, value| edit_row(&LIGHT, &mut row, path, value))?;
            let index = row.numbers[kind_slot] as u8;
            let kind = &LIGHTS[usize::from(index)];
            if !row.fits(kind) {
                return None;
            }
            let parameters = kind.parameters.iter().map(|&slot| row.numbers[slot]);
            extend(&mut self.lights.kind, [index])?;
            extend(&mut self.lights.parameters, parameters)?;
            self.lights.add(&LIGHT, &row, kind.strength?, -1)?;
        }
        Some(())
    }

    fn read_objects<S: Source<'a>>(&mut self, source: &mut S, counter: &mut Counter) -> Option<()> {
        let mut list = source.open_list()?;
        let mut rows = ObjectRows::new();
        while source.item(&mut list)? {
            self.read_object(source, &mut rows, counter)?;
        }
        Some(())
    }

    fn read_object<S: Source<'a>>(
        &mut self,
        source: &mut S,
        ObjectRows { object: row, light, checker }: &mut ObjectRows<'a>,
        counter: &mut Counter,
    ) -> Option<()> {
        let position = slot(&OBJECT, "position")?;
        let color = slot(&OBJECT, "color")?;
        let kind_slot = slot(&OBJECT, "type")?;
        let (intensity, radius) = (slot(&CARRIED_LIGHT, "intensity")?, slot(&CARRIED_LIGHT, "radius")?);
        counter.add(1)?;
        row.reset(&OBJECT);
        light.reset(false);
        checker.reset(false);
        read_row(source, &OBJECT, row, counter, |source, field, counter| {
            let part = part_of([&mut *light, &mut *checker], &field.value)?;
            part.reset(true);
            read_row(source, part.mapping, &mut part.row, counter, |_, _, _| None)
        })?;
        let place = (self.objects.kind.len(), row.text);
        self.edit_item("objects", place, |path, value| {
            edit_object(row, [&mut *light, &mut *checker], path, value)
        })?;
        if !light.is_valid() || !checker.is_valid() {
            return None;
        }
        let numbers = &row.numbers;
        let index = numbers[kind_slot];
        // NaN without a type.
        let kind: &Kind = if index >= 0.0 { &SHAPES[index as usize] } else { return None };
        if !row.fits(kind) {
            return None;
        }
        extend(&mut self.objects.kind, [index as u8])?;
        extend(&mut self.objects.position, numbers[position..position + 3].iter().copied())?;
        extend(&mut self.objects.parameters, kind.parameters.iter().map(|&slot| numbers[slot]))?;
        extend(&mut self.objects.color, numbers[color..color + 3].iter().copied())?;
        if checker.is_there {
            let index = self.objects.kind.len() as i64 - 1;
            let (size, color) = (slot(&CHECKER, "size")?, slot(&CHECKER, "color")?);
            extend(&mut self.checkers.object, [index])?;
            extend(&mut self.checkers.size, [checker.row.numbers[size]])?;
            extend(&mut self.checkers.color, checker.row.numbers[color..color + 3].iter().copied())?;
        }
        if light.is_there {
            extend(&mut self.carried.kind, [CARRIED_KIND])?;
            extend(&mut self.carried.parameters, numbers[position..position + 3].iter().copied())?;
            extend(&mut self.carried.parameters, [light.row.numbers[radius]])?;
            self.carried.add(&CARRIED_LIGHT, &light.row, intensity, self.objects.kind.len() as i64 - 1)?;
        }
        self.add_name(row.text)
    }

    /// Adds the name of an object; gives up if it is taken.
    fn add_name(&mut self, name: Option<&'a str>) -> Option<()> {
        let Some(name) = name else {
            return extend(&mut self.objects.names, [b'-']);
        };
        self.names.try_reserve(1).ok()?;
        if !self.names.insert(name) {
            return None;
        }
        extend(&mut self.objects.names, format!("{}:{name}", name.chars().count()).into_bytes())
    }

    fn finish(mut self) -> Option<Scene> {
        let mut sections = Vec::new();
        for (key, mapping, row) in &self.sections {
            if !row.has(mapping.required) {
                return None;
            }
            sections.push((*key, settings(mapping, row)));
        }
        let Lights { kind, parameters, color, intensity, carrier } = self.carried;
        extend(&mut self.lights.kind, kind)?;
        extend(&mut self.lights.parameters, parameters)?;
        extend(&mut self.lights.color, color)?;
        extend(&mut self.lights.intensity, intensity)?;
        extend(&mut self.lights.carrier, carrier)?;
        Some(Scene { sections, objects: self.objects, checkers: self.checkers, lights: self.lights })
    }
}

impl Lights {
    /// Adds a light, but for its kind and its parameters.
    fn add(&mut self, mapping: &'static Mapping, row: &Row<'_>, strength: usize, carrier: i64) -> Option<()> {
        let color = slot(mapping, "color")?;
        extend(&mut self.color, row.numbers[color..color + 3].iter().copied())?;
        extend(&mut self.intensity, [row.numbers[strength]])?;
        extend(&mut self.carrier, [carrier])
    }
}

fn slot(mapping: &'static Mapping, key: &str) -> Option<usize> {
    field_of(mapping, key.as_bytes()).map(|(_, field)| field.slot)
}

/// Changes a value of a mapping, or one number of a list of numbers that it has.
fn edit_row<'a>(mapping: &'static Mapping, row: &mut Row<'a>, path: &[Step<'a>], value: &'a str) -> Option<()> {
    if value.contains(['\n', '\r']) {
        return None;
    }
    let mut source = Yaml::new(value)?;
    let (&Step::Key(key), inner) = path.split_first()? else { return None };
    let (index, field) = field_of(mapping, key.as_bytes())?;
    match *inner {
        [] => {
            read_value(&mut source, field, row, &mut Counter::default())?;
            row.keys |= 1 << index;
        }
        [Step::Index(at)] if row.has(1 << index) => read_component(&mut source, field, row, at)?,
        _ => return None,
    }
    source.at_end().then_some(())
}

/// Returns the values of a section by key.
fn settings(mapping: &'static Mapping, row: &Row<'_>) -> Section {
    mapping.fields.iter().map(|field| (field.key, setting(&field.value, &row.numbers[field.slot..]))).collect()
}

fn setting(value: &'static Value, slots: &[f64]) -> Setting {
    let slots = &slots[..value.slots()];
    match value {
        Value::Boolean => Setting::Boolean(slots[0] != 0.0),
        Value::NumberOr(word, _) if slots[0].is_nan() => Setting::Word(word),
        Value::Choice(words) => Setting::Word(words[slots[0] as usize]),
        _ if slots.is_empty() || slots[0].is_nan() => Setting::Missing,
        Value::Number(range) if range.is_integer => Setting::Integer(slots[0] as i64),
        Value::Numbers(_, range) if range.is_integer => {
            Setting::Integers(slots.iter().map(|&slot| slot as i64).collect())
        }
        Value::Number(_) | Value::NumberOr(..) => Setting::Number(slots[0]),
        _ => Setting::Numbers(slots.to_vec()),
    }
}

/// Adds items to a list; gives up if memory runs out.
fn extend<T>(list: &mut Vec<T>, items: impl IntoIterator<Item = T, IntoIter: ExactSizeIterator>) -> Option<()> {
    let items = items.into_iter();
    list.try_reserve(items.len()).ok()?;
    list.extend(items);
    Some(())
}

#[cfg(test)]
mod tests;
