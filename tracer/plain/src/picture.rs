//! A scene file as the file of a picture.

use std::io::{self, BufWriter, Write};
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use rtcli_reader::{Edit, Format};
use rtcli_tracer::develop::{BitDepth, Developer, ToneCurve};
use rtcli_tracer::png::{self, Color, Compression, Header, PngWriter};
use rtcli_tracer::render::RenderStats;
use rtcli_tracer::world::Window;
use rtcli_tracer::{Level, Monitor, Stopped, Tracer, meter};

use crate::file::AtomicFile;
use crate::scene::PlainScene;

/// Bytes that are written at a time.
const BUFFER: usize = 1 << 16;

/// The seconds of each stage, by name.
pub type Seconds = Vec<(&'static str, f64)>;

/// A picture to make.
pub struct Picture<'a> {
    /// The bytes of a scene file.
    pub scene: &'a [u8],
    /// Its format.
    pub format: Format,
    /// The changes to it.
    pub edits: &'a [Edit<'a>],
    /// The depth of a channel.
    pub bits: BitDepth,
    /// The compression of the file.
    pub compression: Compression,
    /// The file to write.
    pub target: &'a Path,
    /// A file that is not there, on the same file system.
    pub temporary: &'a Path,
    /// The name and version of the software.
    pub software: &'a str,
}

/// A picture that was made.
pub struct PictureFile {
    /// The fingerprint of the scene.
    pub fingerprint: String,
    /// The SHA-256 of the file, in hexadecimal digits.
    pub sha256: String,
    /// Its size.
    pub bytes: u64,
    /// Width and height, pixels.
    pub size: (u32, u32),
    /// The seconds of each stage.
    pub seconds: Seconds,
}

/// Why a picture was not made.
pub enum FileError {
    /// The work ended early.
    Stopped(Stopped),
    /// The file could not be written.
    Io(std::io::Error),
}

impl PlainScene {
    /// The whole picture.
    pub fn window(&self) -> Window {
        let (width, height) = (self.world.camera.width, self.world.camera.height);
        Window { x: 0, y: 0, width, height }
    }

    /// Returns the picture as a PNG of levels that `Tracer::levels` developed.
    ///
    /// # Errors
    ///
    /// If memory runs out.
    pub fn png_of(
        &self,
        levels: &[u8],
        bits: BitDepth,
        texts: &[(String, String)],
        compression: Compression,
    ) -> io::Result<Vec<u8>> {
        png::encode(self.header(bits, texts), levels, compression)
    }

    /// The data before the pixels of a PNG.
    fn header<'a>(&self, bits: BitDepth, texts: &'a [(String, String)]) -> Header<'a> {
        let Window { width, height, .. } = self.window();
        let color = if self.alpha { Color::SrgbAlpha } else { Color::Srgb };
        Header { width, height, color, bits, texts }
    }

    /// Traces and develops the picture with the threads of the current rayon pool, and writes it as a PNG.
    ///
    /// # Errors
    ///
    /// If the work is cancelled or runs out of memory, or the sink fails.
    pub fn write_png(
        &self,
        tracer: &Tracer,
        developer: &Developer,
        texts: &[(String, String)],
        compression: Compression,
        sink: impl Write + Send,
        monitor: &Monitor,
    ) -> Result<RenderStats, Stopped> {
        if !self.alpha {
            return tracer.write_png(self.window(), developer, texts, compression, sink, monitor);
        }
        let (levels, stats) = tracer.levels(self.window(), developer, true, monitor)?;
        let mut writer = PngWriter::new(sink, self.header(developer.bits(), texts), compression)?;
        writer.write_rows(&levels)?;
        let write = writer.encoding();
        writer.finish()?;
        Ok(RenderStats { write, ..stats })
    }
}

impl Picture<'_> {
    /// Reads the scene, traces it with the threads of the current rayon pool, and writes it as a PNG; None if it is not
    /// plainly valid.
    ///
    /// # Errors
    ///
    /// If the work is cancelled or runs out of memory, or the file cannot be written.
    pub fn write(
        &self,
        level: Level,
        developer: impl FnOnce(f64, ToneCurve, BitDepth) -> Arc<Developer>,
        monitor: &Monitor,
    ) -> Result<Option<PictureFile>, FileError> {
        let start = Instant::now();
        let Some(scene) = rtcli_reader::read(self.scene, self.format, self.edits) else { return Ok(None) };
        let parsed = start.elapsed();
        let Some(scene) = PlainScene::new(scene) else { return Ok(None) };
        let validated = start.elapsed();
        let fingerprint = scene.fingerprint();
        let packed = start.elapsed();
        // The file first: an error with it must not cost the picture.
        let mut file = AtomicFile::create(self.temporary, self.target).map_err(FileError::Io)?;
        let (width, height) = (scene.world.camera.width, scene.world.camera.height);
        let tracer = Tracer::new(scene.world.clone(), level).map_err(|error| FileError::Stopped(error.into()))?;
        let built = start.elapsed();
        let exposure = match scene.exposure {
            Some(exposure) => exposure,
            None => tracer.exposure(meter::GRID, monitor).map_err(FileError::Stopped)?.0.stops,
        };
        let texts = scene.texts(self.software, &fingerprint, exposure);
        let developer = developer(exposure, scene.tone, self.bits);
        let metered = start.elapsed();
        let mut sink = BufWriter::with_capacity(BUFFER, &mut file);
        let stats = scene.write_png(&tracer, &developer, &texts, self.compression, &mut sink, monitor).map_err(
            |error| match error {
                Stopped::Io(error) => FileError::Io(error),
                other => FileError::Stopped(other),
            },
        )?;
        sink.into_inner().map_err(|error| FileError::Io(error.into_error()))?;
        let (sha256, bytes) = file.finish().map_err(FileError::Io)?;
        let write = (start.elapsed() - metered).saturating_sub(stats.trace + stats.develop);
        let seconds = [
            ("parse", parsed),
            ("validate", validated - parsed),
            ("pack", packed - validated),
            ("build", built - packed),
            ("trace", metered - built + stats.trace),
            ("develop", stats.develop),
            ("write", write),
        ];
        let seconds = seconds.map(|(stage, time)| (stage, time.as_secs_f64())).into();
        Ok(Some(PictureFile { fingerprint, sha256, bytes, size: (width, height), seconds }))
    }
}

#[cfg(test)]
mod tests {
    use std::io::{self, Write};
    use std::time::Duration;

    use rtcli_reader::Format;
    use rtcli_tracer::develop::{BitDepth, Developer, ToneCurve};
    use rtcli_tracer::png::Compression;
    use rtcli_tracer::{Level, Monitor, Tracer};

    use crate::scene::PlainScene;

    /// Counts the pieces of a file.
    #[derive(Default)]
    struct Pieces {
        count: usize,
        file: Vec<u8>,
    }

    impl Write for Pieces {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            self.count += 1;
            self.file.write(bytes)
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn a_picture_is_written_in_pieces_and_timed_with_alpha_and_without() {
        let compressions = [Compression::Fast, Compression::Small];
        for (alpha, compression) in
            [false, true].into_iter().flat_map(|alpha| compressions.map(|each| (alpha, each)))
        {
            let scene = format!(
                r#"{{"camera":{{"resolution":[300,200],"fov":60}},"image":{{"exposure":0,"alpha":{alpha}}},"objects":[
                {{"type":"sphere","position":[0,0,-3],"radius":1,"color":"red"}}]}}"#
            );
            let scene = rtcli_reader::read(scene.as_bytes(), Format::Json, &[]).and_then(PlainScene::new).unwrap();
            let tracer = Tracer::new(scene.world.clone(), Level::best()).unwrap();
            let developer = Developer::new(0.0, ToneCurve::Clip, BitDepth::Sixteen);
            let (mut sink, monitor) = (Pieces::default(), Monitor::default());
            let stats = scene.write_png(&tracer, &developer, &[], compression, &mut sink, &monitor).unwrap();
            assert!(sink.count > 2, "{} pieces", sink.count);
            assert!(stats.rays >= 300 * 200);
            assert!(
                [stats.trace, stats.develop, stats.write].iter().all(|&time| time > Duration::ZERO),
                "{stats:?}"
            );
            let (levels, _) = tracer.levels(scene.window(), &developer, alpha, &monitor).unwrap();
            assert_eq!(sink.file, scene.png_of(&levels, BitDepth::Sixteen, &[], compression).unwrap());
        }
    }
}
