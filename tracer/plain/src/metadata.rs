//! The fingerprint of a scene, and the texts of its pictures, as `rtcli.rendering.metadata` and
//! `rtcli.rendering.job` make them.

use rtcli_reader::json::{write_number, write_numbers};
use rtcli_tracer::world::{Projection, ShapeDesc};
use sha2::{Digest, Sha256};

use crate::file::hexadecimal;
use crate::scene::PlainScene;

/// The parameters of a light: three for its position or direction, and its size.
const LIGHT_PARAMETERS: usize = 4;

/// The parameters of shapes that fingerprints always hold, three and a fourth; and the number of places of a light that
/// they leave out.
const FIRST_PARAMETERS: usize = 4;
const SHADOW_SAMPLES: u32 = 64;

impl PlainScene {
    /// Returns the SHA-256 of the scene's numbers and names.
    pub fn fingerprint(&self) -> String {
        let (camera, objects, lights) = (&self.world.camera, &self.objects, &self.lights);
        let lens = match (self.fov, camera.projection) {
            (Some(fov), _) => vec![fov],
            (None, Projection::Orthographic) => vec![camera.half_height, camera.pixel_aspect],
            (None, _) => vec![camera.half_height, camera.pixel_aspect, camera.center.0, camera.center.1],
        };
        let (mut threes, mut fourths, mut others) = (Vec::new(), Vec::new(), Vec::new());
        let mut rest = &objects.parameters[..];
        for &tag in &objects.kind {
            let own;
            (own, rest) = rest.split_at(ShapeDesc::KINDS[usize::from(tag)].parameters);
            threes.extend(own.iter().cycle().take(3));
            fourths.push(own.get(3).copied().unwrap_or_default());
            others.extend(own.iter().skip(FIRST_PARAMETERS));
        }
        let parameters = lights.parameters.chunks(LIGHT_PARAMETERS);
        let places: Vec<f64> = parameters.flat_map(|own| own[..3].iter().copied()).collect();
        let sizes: Vec<f64> = lights.parameters.iter().skip(3).step_by(LIGHT_PARAMETERS).copied().collect();

        let mut hash = Numbers(Sha256::new());
        hash.0.update(camera.width.to_le_bytes());
        hash.0.update(camera.height.to_le_bytes());
        for vector in [&lens[..], &camera.position, &camera.right, &camera.up, &camera.forward] {
            hash.floats(vector);
        }
        hash.bytes(&objects.kind);
        for column in [&objects.position, &threes, &fourths, &objects.color] {
            hash.floats(column);
        }
        if others.iter().any(|&number| number != 0.0) {
            hash.floats(&others);
        }
        for column in [&places, &lights.color, &lights.intensity] {
            hash.floats(column);
        }
        hash.integers(lights.carrier.iter().copied());
        if lights.kind.iter().any(|&kind| kind != 0) {
            hash.bytes(&lights.kind);
        }
        if sizes.iter().any(|&size| size != 0.0) {
            hash.floats(&sizes);
        }
        let checkers = &self.world.checkers;
        if !checkers.is_empty() {
            hash.integers(checkers.iter().map(|checker| checker.object as i64));
            hash.floats(&checkers.iter().map(|checker| checker.size).collect::<Vec<_>>());
            hash.floats(&checkers.iter().flat_map(|checker| checker.color).collect::<Vec<_>>());
        }
        hash.0.update(&objects.names);
        hash.0.update(self.settings());
        format!("sha256:{}", hexadecimal(&hash.0.finalize()))
    }

    /// Returns the settings of light and image as `json.dumps` writes them with sorted keys.
    fn settings(&self) -> String {
        let settings = &self.world.settings;
        let light = [
            has_light(&settings.ambient).then(|| ("ambient", list(&settings.ambient, ", "))),
            Some(("background", list(&settings.background, ", "))),
            Some(("eye_falloff", settings.eye_falloff.to_string())),
            Some(("max_depth", self.max_depth.to_string())),
            Some(("samples", settings.samples.to_string())),
            (settings.shadow_samples != SHADOW_SAMPLES)
                .then(|| ("shadow_samples", settings.shadow_samples.to_string())),
        ];
        let exposure = self.exposure.map_or("\"auto\"".into(), number);
        let image =
            [self.alpha_key(), Some(("exposure", exposure)), Some(("tone", format!("\"{}\"", self.tone.name())))];
        format!("[{}, {}]", mapping(light, ", ", ": "), mapping(image, ", ", ": "))
    }

    fn alpha_key(&self) -> Option<(&'static str, String)> {
        self.alpha.then(|| ("alpha", "true".into()))
    }

    /// Returns the texts of a picture by their keywords: the software, and the metadata as compact JSON.
    pub fn texts(&self, software: &str, fingerprint: &str, exposure: f64) -> Vec<(String, String)> {
        let (camera, settings) = (&self.world.camera, &self.world.settings);
        let (width, height) = (camera.width, camera.height);
        let has_sizes = self.lights.parameters.iter().skip(3).step_by(LIGHT_PARAMETERS).any(|&size| size != 0.0);
        let keys = [
            Some(("engine", "\"native\"".into())),
            Some(("resolution", format!("[{width},{height}]"))),
            Some(("crop", format!("[0,0,{width},{height}]"))),
            Some(("samples", settings.samples.to_string())),
            has_light(&settings.ambient).then(|| ("ambient", list(&settings.ambient, ","))),
            Some(("max_depth", self.max_depth.to_string())),
            has_sizes.then(|| ("shadow_samples", settings.shadow_samples.to_string())),
            Some(("eye_falloff", settings.eye_falloff.to_string())),
            Some(("exposure", number(exposure))),
            Some(("tone", format!("\"{}\"", self.tone.name()))),
            self.alpha_key(),
        ];
        let settings = mapping(keys, ",", ":");
        let metadata = format!(r#"{{"software":"{software}","scene":"{fingerprint}","settings":{settings}}}"#);
        vec![("Software".into(), software.into()), ("rtcli".into(), metadata)]
    }
}

/// A hash of columns: for each, the number of its items and then themselves, the low byte first.
struct Numbers(Sha256);

impl Numbers {
    fn bytes(&mut self, column: &[u8]) {
        self.0.update((column.len() as i64).to_le_bytes());
        self.0.update(column);
    }

    fn floats(&mut self, column: &[f64]) {
        self.0.update((column.len() as i64).to_le_bytes());
        for number in column {
            self.0.update(number.to_le_bytes());
        }
    }

    fn integers(&mut self, column: impl ExactSizeIterator<Item = i64>) {
        self.0.update((column.len() as i64).to_le_bytes());
        for number in column {
            self.0.update(number.to_le_bytes());
        }
    }
}

fn has_light(color: &[f64; 3]) -> bool {
    color.iter().any(|&component| component != 0.0)
}

// --- JSON as Python writes it ---------------------------------------------------------------------------------

fn mapping<const N: usize>(entries: [Option<(&str, String)>; N], between: &str, colon: &str) -> String {
    let entries: Vec<_> =
        entries.into_iter().flatten().map(|(key, value)| format!("\"{key}\"{colon}{value}")).collect();
    format!("{{{}}}", entries.join(between))
}

fn list(numbers: &[f64], between: &str) -> String {
    let mut json = String::new();
    write_numbers(numbers, between, &mut json);
    json
}

fn number(value: f64) -> String {
    let mut json = String::new();
    write_number(value, &mut json);
    json
}
