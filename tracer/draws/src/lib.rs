//! Random numbers that are pure functions of a key and a counter, so that none depends on those drawn before it.
//!
//! - `philox`: the generator
//! - `Draw`: one word of it as a number of a distribution

#![forbid(unsafe_code)]

mod distributions;
mod philox;

pub use distributions::Draw;
pub use philox::philox;
