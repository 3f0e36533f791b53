//! A scene file as a world, with what its metadata needs beside.

use rtcli_reader::scene::{Setting, light_kinds, shapes};
use rtcli_reader::{Lights, Objects, Scene, Section};
use rtcli_tracer::develop::ToneCurve;
use rtcli_tracer::half_tangent;
use rtcli_tracer::world::{
    Camera, CheckerDesc, Kind, LightDesc, LightSource, Object, Projection, Settings, ShapeDesc, Vector, World,
};

use crate::vector::{are_parallel, cross, direction, unit};

/// A scene that is plainly valid.
#[derive(Debug)]
pub struct PlainScene {
    /// The input of the tracer.
    pub world: World,
    /// Stops; None to meter them.
    pub exposure: Option<f64>,
    /// A tone curve.
    pub tone: ToneCurve,
    /// Whether the picture has alpha in place of the background, which then is black in `world`.
    pub alpha: bool,
    /// The vertical field of view in degrees, if the camera has it.
    pub fov: Option<f64>,
    /// How often light is followed.
    pub max_depth: i64,
    /// The columns that the world was made of, with the tracer's kinds.
    pub objects: Objects,
    /// The same of the lights.
    pub lights: Lights,
}

impl PlainScene {
    /// Returns a scene that was read; None if its camera is not plainly valid.
    pub fn new(scene: Scene) -> Option<PlainScene> {
        let Scene { sections, mut objects, checkers, mut lights } = scene;
        let (render, image) = (section(&sections, "render")?, section(&sections, "image")?);
        let alpha = image.boolean("alpha")?;
        objects.kind = tags(&objects.kind, shapes(), ShapeDesc::KINDS)?;
        lights.kind = tags(&lights.kind, light_kinds(), LightSource::KINDS)?;
        let checkers = checkers.object.iter().zip(&checkers.size).zip(checkers.color.as_chunks().0);
        let checker =
            |((&object, &size), &color): ((&i64, _), _)| CheckerDesc { object: object as usize, size, color };
        let (camera, lens) = camera(&sections)?;
        let max_depth = render.integer("max_depth")?;
        let world = World {
            camera,
            objects: world_objects(&objects)?,
            checkers: checkers.map(checker).collect(),
            lights: world_lights(&lights)?,
            settings: Settings {
                samples: render.integer("samples")? as u32,
                background: if alpha { [0.0; 3] } else { render.vector("background")? },
                ambient: render.vector("ambient")?,
                direct_light: max_depth > 0,
                shadow_samples: render.integer("shadow_samples")? as u32,
                eye_falloff: render.boolean("eye_falloff")?,
            },
        };
        Some(PlainScene {
            world,
            exposure: image.number("exposure"),
            tone: image.word("tone")?.parse().ok()?,
            alpha,
            fov: lens.fov,
            max_depth,
            objects,
            lights,
        })
    }
}

impl PlainScene {
    /// Returns the name of each object, in the order of the file.
    pub fn names(&self) -> Vec<Option<&str>> {
        let mut names = Vec::new();
        let mut rest = str::from_utf8(&self.objects.names).unwrap_or_default();
        while !rest.is_empty() {
            if let Some(after) = rest.strip_prefix('-') {
                names.push(None);
                rest = after;
                continue;
            }
            let (length, after) = rest.split_once(':').unwrap_or(("", ""));
            let end = after.char_indices().nth(length.parse().unwrap_or(0)).map_or(after.len(), |(end, _)| end);
            names.push(Some(&after[..end]));
            rest = &after[end..];
        }
        names
    }
}

/// The values of a section.
struct Values<'a>(&'a Section);

impl Values<'_> {
    fn get(&self, name: &str) -> Option<&Setting> {
        self.0.iter().find(|(key, _)| *key == name).map(|(_, setting)| setting)
    }

    fn boolean(&self, name: &str) -> Option<bool> {
        if let Setting::Boolean(value) = self.get(name)? { Some(*value) } else { None }
    }

    fn integer(&self, name: &str) -> Option<i64> {
        if let Setting::Integer(value) = self.get(name)? { Some(*value) } else { None }
    }

    fn number(&self, name: &str) -> Option<f64> {
        if let Setting::Number(value) = self.get(name)? { Some(*value) } else { None }
    }

    fn vector(&self, name: &str) -> Option<Vector> {
        if let Setting::Numbers(values) = self.get(name)? { values[..].try_into().ok() } else { None }
    }

    fn word(&self, name: &str) -> Option<&'static str> {
        if let Setting::Word(word) = self.get(name)? { Some(*word) } else { None }
    }
}

fn section<'a>(sections: &'a [(&str, Section)], name: &str) -> Option<Values<'a>> {
    sections.iter().find(|(key, _)| *key == name).map(|(_, section)| Values(section))
}

/// How a scene gives the lens of its camera.
pub struct Lens {
    /// The vertical field of view in degrees, if the camera has it.
    pub fov: Option<f64>,
    /// The name of the projection.
    pub projection: &'static str,
}

/// Returns the camera of a scene that was read, and its lens; None if its keys do not plainly fit each other.
///
/// right = view x up, up' = right x view, as in `rtcli.rendering.pack`.
pub fn camera(sections: &[(&str, Section)]) -> Option<(Camera, Lens)> {
    let camera = section(sections, "camera")?;
    let Setting::Integers(resolution) = camera.get("resolution")? else { return None };
    let &[width, height] = &resolution[..] else { return None };
    let lens = Lens { fov: camera.number("fov"), projection: camera.word("projection")? };
    let projection: Projection = lens.projection.parse().ok()?;
    let half_height = match (lens.fov, camera.number("fov_x"), camera.number("height"), projection) {
        (None, None, Some(height), Projection::Orthographic) => height / 2.0,
        (Some(fov), None, None, Projection::Perspective) => half_tangent(fov),
        (None, Some(fov_x), None, Projection::Perspective) => half_tangent(fov_x) * height as f64 / width as f64,
        _ => return None,
    };
    let (position, up) = (camera.vector("position")?, camera.vector("up")?);
    let view = match camera.vector("look_at") {
        Some(look_at) if look_at == position => return None,
        Some(look_at) => direction(position, look_at),
        None => [0.0, 0.0, -1.0],
    };
    if are_parallel(view, up) {
        return None;
    }
    let forward = unit(view);
    let right = unit(cross(forward, unit(up)));
    let frame = Camera {
        width: width as u32,
        height: height as u32,
        projection,
        half_height,
        pixel_aspect: 1.0,
        center: (0.0, 0.0),
        position,
        right,
        up: cross(right, forward),
        forward,
    };
    Some((frame, lens))
}

/// Returns the tracer's tags of the reader's kinds.
fn tags(kinds: &[u8], names: impl Iterator<Item = &'static str>, known: &[Kind]) -> Option<Vec<u8>> {
    let tag = |name| known.iter().position(|kind| kind.name == name).map(|tag| tag as u8);
    let tags: Vec<u8> = names.map(tag).collect::<Option<_>>()?;
    Some(kinds.iter().map(|&kind| tags[usize::from(kind)]).collect())
}

fn world_objects(objects: &Objects) -> Option<Vec<Object>> {
    let mut rest = &objects.parameters[..];
    let columns = objects.kind.iter().zip(objects.position.as_chunks().0).zip(objects.color.as_chunks().0);
    let object = |((&tag, &position), &color)| {
        let kind = usize::from(tag);
        let parameters = rest.split_off(..ShapeDesc::KINDS[kind].parameters)?;
        Some(Object { position, color, shape: ShapeDesc::new(kind, parameters) })
    };
    columns.map(object).collect()
}

fn world_lights(lights: &Lights) -> Option<Vec<LightDesc>> {
    let mut rest = &lights.parameters[..];
    let numbers = lights.color.as_chunks().0.iter().zip(&lights.intensity).zip(&lights.carrier);
    let light = |(&tag, ((&color, &intensity), &carrier)): (&u8, ((_, _), &i64))| {
        let kind = usize::from(tag);
        let source = LightSource::new(kind, rest.split_off(..LightSource::KINDS[kind].parameters)?);
        Some(LightDesc { source, color, intensity, carrier: usize::try_from(carrier).ok() })
    };
    lights.kind.iter().zip(numbers).map(light).collect()
}

#[cfg(test)]
mod tests;
