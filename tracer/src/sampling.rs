//! Where in a pixel its rays go.

/// 1/g and 1/g^2, where the plastic number g solves g^3 = g + 1: the two-dimensional relatives of the golden ratio
/// (M. Roberts, "The Unreasonable Effectiveness of Quasirandom Sequences", 2018: the R2 sequence).
const R2: (f64, f64) = (0.7548776662466927, 0.5698402909980532);

/// The place of a pixel's sample, each in 0..1 from its left and top edge: frac((0.5, 0.5) + i (1/g, 1/g^2)).
/// The first is the centre.
pub(crate) fn sample_offset(sample: u32) -> (f64, f64) {
    let i = f64::from(sample);
    let fraction = |value: f64| value - value.floor();
    (fraction(0.5 + i * R2.0), fraction(0.5 + i * R2.1))
}
