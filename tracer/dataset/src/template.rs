//! A template, and a sample of it: drawn again until it meets all constraints.

use std::mem::take;

use rtcli_plain::{PlainScene, intrinsics};
use rtcli_reader::Format;
use rtcli_sampler::{Caller, Context, Outcome, Placed, Rejections, Sampler, Shape, Try, View, mapping};
use rtcli_tracer::memory::spare;
use rtcli_tracer::world::{Camera, Projection};
use rtcli_tracer::{Monitor, Pass, Stopped};

use crate::constraints::Requirement;
use crate::files::{Array, Files, Outputs, Part, arrays, copied, files, key_of, level_shape, parts, tar};
use crate::labels::{Header, labels};
use crate::models::Models;
use crate::picture::{Engine, Picture};

/// Named like a constraint: values that do not fit each other, such as a camera that looks at where it stands.
const SCENE: &str = "scene";

/// A template.
#[derive(Debug)]
pub struct Template {
    /// Its draws and objects.
    pub sampler: Sampler,
    /// What its pictures must meet, in the order in which it is checked.
    pub requirements: Vec<Requirement>,
    /// The most tries of an object, and of a sample.
    pub tries: u64,
}

/// A sample to make.
#[derive(Clone, Copy, Debug)]
pub struct Request<'a> {
    /// Its index.
    pub index: u64,
    /// The values that the draws `factor` number, in JSON.
    pub factors: &'a [String],
    /// A bound of the tries, beside that of the template.
    pub tries: u64,
    /// The passes to write.
    pub passes: &'a [Pass],
    /// The outputs to make.
    pub outputs: Outputs,
    /// Its labels, if they are wanted: the name of the split, the values of all factors in JSON, and whether objects have
    /// labels.
    pub labels: Option<(&'a str, &'a str, bool)>,
}

/// A sample.
#[derive(Debug, Default)]
pub struct Sample {
    /// The attempt of its draws, beside those of objects.
    pub attempt: u64,
    /// The number of the group of each object.
    pub groups: Vec<usize>,
    /// Its scene in JSON.
    pub text: String,
    /// Its labels in JSON, if they are wanted.
    pub labels: Option<String>,
    /// Its files, if they are among the outputs.
    pub files: Files,
    /// The members of a tar file.
    pub tar: Vec<u8>,
    /// The files that stand in a table.
    pub parts: Vec<Part>,
    /// The picture and passes as compressed arrays.
    pub arrays: Vec<Array>,
    /// The lengths of the picture as an array, and its bytes.
    pub levels: Option<(Vec<usize>, Vec<u8>)>,
}

/// A sample that was made, if some try meets all constraints, and what was drawn again for it.
#[derive(Debug)]
pub struct Made {
    /// The sample.
    pub sample: Option<Sample>,
    /// What was drawn again.
    pub rejections: Rejections,
}

/// Why a sample was not made.
#[derive(Debug)]
pub enum Failure {
    /// The work ended early.
    Stopped(Stopped),
    /// No checked template has such a value.
    Unknown,
}

impl<E: Into<Stopped>> From<E> for Failure {
    fn from(error: E) -> Failure {
        Failure::Stopped(error.into())
    }
}

impl Template {
    /// Makes the sample of an index with the threads of the current rayon pool.
    ///
    /// # Errors
    ///
    /// If the work is cancelled or runs out of memory, an answer of the models fails, or a value is unknown.
    pub fn make(
        &self,
        request: &Request<'_>,
        engine: Engine<'_>,
        models: &mut dyn Models,
    ) -> Result<Made, Failure> {
        spare()?;
        let mut rejections = Rejections::default();
        let tries = request.tries.min(self.tries);
        for number in 0..tries {
            engine.monitor.check()?;
            let context = Context {
                index: request.index,
                attempt: number * self.tries,
                element: 0,
                factors: request.factors,
            };
            let Some(candidate) = self.candidate(&context, tries, engine.monitor, models, &mut rejections)? else {
                continue;
            };
            if let Some(sample) = self.finished(&context, candidate, request, engine, &mut rejections)? {
                return Ok(Made { sample: Some(sample), rejections });
            }
        }
        Ok(Made { sample: None, rejections })
    }
}

/// A scene that meets all constraints on objects.
struct Candidate<'a> {
    text: String,
    placed: Vec<Placed<'a>>,
    scene: PlainScene,
}

impl Template {
    /// Returns a scene whose objects are drawn until they meet their constraints; None if one never does.
    fn candidate(
        &self,
        context: &Context<'_>,
        tries: u64,
        monitor: &Monitor,
        models: &mut dyn Models,
        rejections: &mut Rejections,
    ) -> Result<Option<Candidate<'_>>, Failure> {
        let mut sections = self.sampler.sections(context).ok_or(Failure::Unknown)?;
        let camera = sections.iter().find(|(key, _)| *key == "camera").map_or("{}", |(_, camera)| camera);
        let camera = plain_camera(camera).map_or_else(|| models.camera_of(camera), Ok);
        let Some(camera) = valid(camera, models, rejections)? else { return Ok(None) };
        let view = view_of(&camera);
        let mut caller = Asking { models, monitor };
        let own = Try { attempts: tries, view: &view, caller: &mut caller, rejections };
        let placed = match self.sampler.place(context, own).ok_or(Failure::Unknown)? {
            Outcome::Placed(placed) => Ok(placed),
            Outcome::Invalid(reason) => Err(reason),
            Outcome::Failed => {
                monitor.check()?;
                return Ok(None);
            }
        };
        let Some(placed) = valid(placed, models, rejections)? else { return Ok(None) };
        rejections.check(SCENE);
        let objects: Vec<_> = placed.iter().map(|object| mapping(&object.keys)).collect();
        sections.push(("objects", format!("[{}]", objects.join(","))));
        let text = mapping(&sections);
        let scene = rtcli_reader::read(text.as_bytes(), Format::Json, &[]).and_then(PlainScene::new);
        let scene = scene.map_or_else(|| models.scene_of(&text), Ok);
        Ok(valid(scene, models, rejections)?.map(|scene| Candidate { text, placed, scene }))
    }

    /// Returns the sample of a scene with its outputs; None if a constraint refuses its picture.
    fn finished(
        &self,
        context: &Context<'_>,
        candidate: Candidate<'_>,
        request: &Request<'_>,
        engine: Engine<'_>,
        rejections: &mut Rejections,
    ) -> Result<Option<Sample>, Failure> {
        let Candidate { text, placed, scene } = candidate;
        let Request { outputs, passes, .. } = *request;
        let mut sample = Sample {
            attempt: context.attempt,
            groups: placed.iter().map(|object| object.group).collect(),
            text,
            ..Sample::default()
        };
        let is_checked = !self.requirements.is_empty();
        if !is_checked && request.labels.is_none() && !outputs.any() {
            return Ok(Some(sample));
        }
        let mut traced = passes.to_vec();
        let needs_ids = is_checked || matches!(request.labels, Some((_, _, true)));
        if needs_ids && !traced.contains(&Pass::ObjectId) {
            traced.push(Pass::ObjectId);
        }
        let mut picture = Picture::new(&scene, &traced, engine)?;
        rejections.draws += usize::from(is_checked);
        for requirement in &self.requirements {
            rejections.check(requirement.kind());
            for (number, object) in
                placed.iter().enumerate().filter(|(_, object)| object.group == requirement.group)
            {
                if !requirement.is_met(&mut picture, number)? {
                    rejections.refuse(requirement.kind(), object.label(), true);
                    return Ok(None);
                }
            }
        }
        if let Some((split, factors, has_objects)) = request.labels {
            let Request { index, .. } = *request;
            let header = Header { software: engine.software, index, split, attempt: context.attempt, factors };
            let placed = has_objects.then_some(&placed[..]);
            sample.labels = Some(labels(header, &self.sampler, placed, &mut picture)?);
        }
        if outputs.arrays {
            sample.arrays = arrays(passes, &mut picture)?;
        }
        if outputs.levels {
            sample.levels = Some((level_shape(&picture), picture.levels()?.to_vec()));
        }
        if outputs.files || outputs.tar || outputs.parts {
            let mut png = picture.png()?;
            let labels = sample.labels.as_deref().unwrap_or("{}");
            if outputs.tar || outputs.parts {
                let own = if outputs.files { copied(&png)? } else { take(&mut png) };
                let parts = parts(own, passes, &picture)?;
                if outputs.tar {
                    sample.tar = tar(&key_of(request.index), labels, &parts)?;
                }
                if outputs.parts {
                    sample.parts = parts;
                }
            }
            if outputs.files {
                sample.files = files(png, labels, passes, &mut picture)?;
            }
        }
        Ok(Some(sample))
    }
}

/// Returns a value, or None if it is not valid, which is counted.
fn valid<T>(
    found: Result<T, String>,
    models: &dyn Models,
    rejections: &mut Rejections,
) -> Result<Option<T>, Failure> {
    if models.has_failed() {
        return Err(Failure::Stopped(Stopped::Cancelled));
    }
    Ok(found.map_err(|reason| rejections.refuse(SCENE, reason, true)).ok())
}

/// Answers the questions of a sampler while it places objects.
struct Asking<'a> {
    models: &'a mut dyn Models,
    monitor: &'a Monitor,
}

impl Caller for Asking<'_> {
    fn shape_of(&mut self, json: &str) -> Result<Shape, String> {
        self.models.shape_of(json)
    }

    fn is_cancelled(&mut self) -> bool {
        self.monitor.cancelled()
    }
}

/// Returns a camera in JSON; None if it is not plainly valid.
fn plain_camera(camera: &str) -> Option<Camera> {
    let scene = rtcli_reader::read(format!("{{\"camera\":{camera}}}").as_bytes(), Format::Json, &[])?;
    rtcli_plain::camera(&scene.sections).map(|(camera, _)| camera)
}

/// Returns what a camera shows.
fn view_of(camera: &Camera) -> View {
    let (focal_lengths, principal_point) = intrinsics(camera);
    View {
        size: [camera.width.into(), camera.height.into()],
        focal_lengths,
        principal_point,
        is_orthographic: camera.projection == Projection::Orthographic,
        position: camera.position,
        right: camera.right,
        up: camera.up,
        forward: camera.forward,
    }
}

#[cfg(test)]
mod tests;
