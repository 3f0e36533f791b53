//! `rtcli.tracer._native`: the tracer as a Python module.
//!
//! - `tracer`: the class `Tracer`, which renders a world to a film or a picture
//! - `world`: the conversion of packed columns to a `World`
//! - `scene`: valid scene files as packed columns
//! - `spans`: where the values of a scene file stand
//! - `scene_file`: how both name the parts of a file, and its format
//! - `arrays`: the arrays of a film, which NumPy owns
//! - `interruptible`: work in a thread pool while the calling thread listens to Python
//! - `byte_channel`: bytes on their way from the pool to the calling thread
//! - `columns`: bytes of Python as numbers
//! - `display`: developing and metering radiance from any engine
//! - `boxes`: the boxes around objects, and those that hold others
//! - `draws`: the random words of templates, and the bodies that are measured
//! - `sampler`: templates, with their draws and their samples
//! - `png`: PNG files of values that are already developed, or are no colors
//! - `errors`: the core's errors as Python exceptions
//!
//! `rtcli/tracer/_native.pyi` documents the interface that Python sees.

#![forbid(unsafe_code)]

mod arrays;
mod boxes;
mod byte_channel;
mod columns;
mod display;
mod draws;
mod errors;
mod interruptible;
mod picture;
mod png;
mod sampler;
mod scene;
mod scene_file;
mod spans;
mod tracer;
mod world;

/// The compiled part of rtcli.
#[pyo3::pymodule]
mod _native {
    use pyo3::prelude::*;
    use pyo3::types::IntoPyDict;
    use rtcli_tracer::world::{LightSource, ShapeDesc};

    #[pymodule_export]
    use crate::boxes::{Boxes, Enclosures};
    #[pymodule_export]
    use crate::display::{PngEncoder, develop, half_tangent, meter};
    #[pymodule_export]
    use crate::draws::{Body, draw_word};
    #[pymodule_export]
    use crate::errors::BudgetExceededError;
    #[pymodule_export]
    use crate::picture::write_picture;
    #[pymodule_export]
    use crate::png::{decode_png, encode_png, id_boxes, pass_picture};
    #[pymodule_export]
    use crate::sampler::{Drawn, Sample, Sampler};
    #[pymodule_export]
    use crate::scene::{by_threes, read_scene};
    #[pymodule_export]
    use crate::spans::FileSpans;
    #[pymodule_export]
    use crate::tracer::{Tracer, WorkBudget, camera_matrices, emitter_places, sample_offsets, simd_level};

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        let shapes = ShapeDesc::KINDS.iter().map(|kind| (kind.name, kind.parameters));
        module.add("SHAPE_PARAMETERS", shapes.into_py_dict(module.py())?)?;
        let lights = LightSource::KINDS.iter().map(|kind| (kind.name, kind.parameters));
        module.add("LIGHT_PARAMETERS", lights.into_py_dict(module.py())?)?;
        module.add("LEVEL_FORMULAS", rtcli_tracer::pass_picture::FORMULAS.into_py_dict(module.py())?)?;
        module.add("METER_GRID", rtcli_tracer::meter::GRID)?;
        module.add("TILE_SIDE", rtcli_tracer::TILE_SIDE)?;
        module.add("COVERAGE_STEPS", rtcli_tracer::render::COVERAGE_STEPS)?;
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
