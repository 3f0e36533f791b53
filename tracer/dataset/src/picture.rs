//! The picture of a sample and its passes, each traced when it is first asked for.
//!
//! Passes cost a fraction of light, so a sample that a constraint on ids refuses is cheap.

use std::sync::Arc;

use rtcli_plain::PlainScene;
use rtcli_tracer::develop::{BitDepth, Developer, ToneCurve};
use rtcli_tracer::memory::{Growing, filled};
use rtcli_tracer::png::Compression;
use rtcli_tracer::render::COVERAGE_STEPS;
use rtcli_tracer::rle::{self, Mask, PixelBox};
use rtcli_tracer::{Film, Level, Monitor, Pass, Stopped, Tracer, ValueType, Values, WorkBudget, meter};

/// Returns the developer of an exposure, a tone curve and a depth.
pub type Developers = fn(f64, ToneCurve, BitDepth) -> Arc<Developer>;

/// How to trace.
#[derive(Clone, Copy)]
pub struct Engine<'a> {
    /// The SIMD level.
    pub level: Level,
    /// Makes developers, or keeps them.
    pub developers: Developers,
    /// Progress and cancellation.
    pub monitor: &'a Monitor,
    /// The name and version of the software.
    pub software: &'a str,
}

/// The values of a pass, row by row.
#[derive(Debug)]
pub enum PassValues {
    Floats(Vec<f32>),
    Ids(Vec<u32>),
}

impl PassValues {
    fn new(pass: Pass, pixels: usize) -> Result<PassValues, Stopped> {
        let count = pass.channels() * pixels;
        Ok(match pass.value_type() {
            ValueType::Float => PassValues::Floats(filled(count, 0.0, "a pass")?),
            ValueType::Integer => PassValues::Ids(filled(count, 0, "a pass")?),
        })
    }

    fn values(&mut self) -> Values<'_> {
        match self {
            PassValues::Floats(values) => Values::Floats(values),
            PassValues::Ids(values) => Values::Integers(values),
        }
    }
}

/// The picture of a scene.
pub struct Picture<'a> {
    pub scene: &'a PlainScene,
    engine: Engine<'a>,
    tracer: Tracer,
    passes: Vec<(Pass, PassValues)>,
    boxes: Vec<(usize, PixelBox)>,
    fractions: Option<Vec<Option<f64>>>,
    exposure: Option<f64>,
    levels: Option<Vec<u8>>,
    texts: Option<Vec<(String, String)>>,
}

impl<'a> Picture<'a> {
    /// Traces some passes of a scene.
    pub fn new(scene: &'a PlainScene, passes: &[Pass], engine: Engine<'a>) -> Result<Picture<'a>, Stopped> {
        let tracer = Tracer::new(scene.world.clone(), engine.level)?;
        let window = scene.window();
        let new = |&pass: &Pass| Ok((pass, PassValues::new(pass, window.pixels())?));
        let mut traced: Vec<_> = passes.iter().map(new).collect::<Result<_, Stopped>>()?;
        if !traced.is_empty() {
            let film =
                traced.iter_mut().fold(Film::default(), |film, (pass, values)| film.with(*pass, values.values()));
            tracer.film(window, film, engine.monitor)?;
        }
        let mut picture = Picture {
            scene,
            engine,
            tracer,
            passes: traced,
            boxes: Vec::new(),
            fractions: None,
            exposure: None,
            levels: None,
            texts: None,
        };
        picture.boxes = rle::boxes(picture.ids(), window.width as usize, scene.world.objects.len());
        Ok(picture)
    }

    /// The ids, if they are among the passes.
    fn ids(&self) -> &[u32] {
        match self.pass(Pass::ObjectId) {
            Some(PassValues::Ids(ids)) => ids,
            _ => &[],
        }
    }

    /// A pass that was traced.
    pub fn pass(&self, pass: Pass) -> Option<&PassValues> {
        self.passes.iter().find(|(known, _)| *known == pass).map(|(_, values)| values)
    }

    /// Width and height.
    pub fn size(&self) -> (u32, u32) {
        (self.scene.world.camera.width, self.scene.world.camera.height)
    }

    /// For each object, the number of pixels that show it, and the box around them.
    pub fn boxes(&self) -> &[(usize, PixelBox)] {
        &self.boxes
    }

    /// The encoding of each object's mask.
    pub fn masks(&self) -> Vec<String> {
        rle::masks(self.ids(), self.size().0 as usize, self.boxes.len())
    }

    /// The masks of some objects, as if each were alone.
    pub fn amodal_masks(&self, objects: &[u32]) -> Result<Vec<Mask>, Stopped> {
        self.tracer.amodal_masks(self.scene.window(), objects, self.engine.monitor)
    }

    /// For each object, the share of its pixels in the picture that other objects do not hide; None if it has none,
    /// or if it is too much work to find.
    pub fn fractions(&mut self) -> Result<&[Option<f64>], Stopped> {
        if self.fractions.is_none() {
            let monitor = self.engine.monitor.aside_within(Arc::new(WorkBudget::new(COVERAGE_STEPS)));
            let covered = match self.tracer.coverage(self.scene.window(), &monitor) {
                Err(Stopped::BudgetExceeded) => vec![0; self.boxes.len()],
                covered => covered?,
            };
            let share = |(&covered, &(visible, _)): (&u64, &(usize, PixelBox))| {
                (covered > 0).then(|| visible as f64 / covered as f64)
            };
            self.fractions = Some(covered.iter().zip(&self.boxes).map(share).collect());
        }
        Ok(self.fractions.as_deref().unwrap_or_default())
    }

    /// The exposure in stops.
    pub fn exposure(&mut self) -> Result<f64, Stopped> {
        if let Some(stops) = self.exposure.or(self.scene.exposure) {
            return Ok(stops);
        }
        let (reading, _) = self.tracer.exposure(meter::GRID, self.engine.monitor)?;
        self.exposure = Some(reading.stops);
        Ok(reading.stops)
    }

    /// The channels of the picture.
    pub fn channels(&self) -> usize {
        if self.scene.alpha { 4 } else { 3 }
    }

    /// The picture as 8-bit sRGB.
    pub fn levels(&mut self) -> Result<&[u8], Stopped> {
        if self.levels.is_none() {
            let developer = self.developer()?;
            let (window, monitor) = (self.scene.window(), self.engine.monitor);
            self.levels = Some(self.tracer.levels(window, &developer, self.scene.alpha, monitor)?.0);
        }
        Ok(self.levels.as_deref().unwrap_or_default())
    }

    /// The picture as a PNG.
    pub fn png(&mut self) -> Result<Vec<u8>, Stopped> {
        let developer = self.developer()?;
        let texts = self.texts()?.to_vec();
        if let Some(levels) = &self.levels {
            return Ok(self.scene.png_of(levels, developer.bits(), &texts, Compression::Fast)?);
        }
        let mut file = Growing::default();
        self.scene.write_png(
            &self.tracer,
            &developer,
            &texts,
            Compression::Fast,
            &mut file,
            self.engine.monitor,
        )?;
        Ok(file.0)
    }

    /// The texts of the files of the picture; the last is its metadata in JSON.
    pub fn texts(&mut self) -> Result<&[(String, String)], Stopped> {
        if self.texts.is_none() {
            let exposure = self.exposure()?;
            self.texts = Some(self.scene.texts(self.engine.software, &self.scene.fingerprint(), exposure));
        }
        Ok(self.texts.as_deref().unwrap_or_default())
    }

    fn developer(&mut self) -> Result<Arc<Developer>, Stopped> {
        Ok((self.engine.developers)(self.exposure()?, self.scene.tone, BitDepth::Eight))
    }
}
