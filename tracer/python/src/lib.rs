//! `rtcli.tracer._native`: the tracer as a Python module.
//!
//! - `tracer`: the class `Tracer`, a world that is rendered to a film or to a picture
//! - `world`: what Python packs, as the tracer's `World`
//! - `arrays`: the arrays of a film, which Python owns
//! - `attend`: work in a pool of threads, while the calling thread listens to Python
//! - `errors`: errors of the core, as Python has them
//! - `channel`: bytes on their way from the pool to the calling thread
//! - `look`: from radiance to an image, for films of any engine
//! - `png`: PNG files of numbers that are developed already, or are no color at all
//!
//! `rtcli/tracer/_native.pyi` says what Python sees.

#![forbid(unsafe_code)]

mod arrays;
mod byte_channel;
mod display;
mod errors;
mod interruptible;
mod png;
mod tracer;
mod world;

/// The compiled part of rtcli.
#[pyo3::pymodule]
mod _native {
    use pyo3::prelude::*;
    use pyo3::types::{PyDict, PyTuple};
    use rtcli_tracer::world::{LightKind, ShapeDesc};

    #[pymodule_export]
    use crate::display::{PngEncoder, develop, focal_length, meter};
    #[pymodule_export]
    use crate::errors::BudgetExceededError;
    #[pymodule_export]
    use crate::png::{decode_png, encode_png};
    #[pymodule_export]
    use crate::tracer::{Tracer, WorkBudget, sample_offsets, simd_level};

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        let shapes = PyDict::new(module.py());
        for kind in ShapeDesc::KINDS {
            shapes.set_item(kind.name, kind.parameters)?;
        }
        module.add("SHAPE_PARAMETERS", shapes)?;
        let lights = LightKind::ALL.map(|(name, _)| name);
        module.add("LIGHT_KINDS", PyTuple::new(module.py(), lights)?)?;
        module.add("METER_GRID", rtcli_tracer::meter::GRID)?;
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
