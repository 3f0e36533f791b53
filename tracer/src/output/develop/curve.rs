//! Tone curves, the sRGB transfer function, and their inverses, in f64.
//!
//! These functions decide pixels, so their results must be the same on every machine. They use `+ - * /`
//! and `sqrt`, which IEEE 754 rounds exactly, and `pow` of the `libm` crate: FreeBSD's `e_pow.c` in Rust, built of
//! the same operations and of table look-ups, without fused multiply-add or anything of the platform's C library,
//! and within 0.7 units in the last place. The developed values are f32, with 29 bits less.

use crate::names::UnknownName;
use std::str::FromStr;

/// How radiance beyond white is compressed into the range of a picture. To add a curve, add it to `ToneCurve` and
/// `CURVES`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ToneCurve {
    /// Y = x, clipped at white.
    Clip,
    /// Y = x / (1 + x) (E. Reinhard et al., "Photographic Tone Reproduction", 2002, equation 3, per channel).
    Reinhard,
    /// Y = x (2.51 x + 0.03) / (x (2.43 x + 0.59) + 0.14) (K. Narkowicz's fit of the ACES curve, 2016).
    Aces,
}

/// A curve: its name in scene files, Y of exposed light x, and x of Y.
struct CurveSpec {
    curve: ToneCurve,
    name: &'static str,
    y: fn(f64) -> f64,
    x: fn(f64) -> f64,
}

const CURVES: [CurveSpec; 3] = [
    CurveSpec { curve: ToneCurve::Clip, name: "clip", y: |x| x, x: |y| y },
    CurveSpec { curve: ToneCurve::Reinhard, name: "reinhard", y: |x| x / (1.0 + x), x: |y| y / (1.0 - y) },
    CurveSpec { curve: ToneCurve::Aces, name: "aces", y: aces, x: inverse_aces },
];

/// The ACES curve is white well before this, and larger squares might overflow.
const ACES_WHITE: f64 = 1e6;

fn aces(x: f64) -> f64 {
    let x = x.min(ACES_WHITE);
    x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14)
}

/// The root above 0 of a x² + b x + c = 0, a = 2.51 - 2.43 y, b = 0.03 - 0.59 y, c = -0.14 y.
fn inverse_aces(y: f64) -> f64 {
    let (a, b, c) = (2.51 - 2.43 * y, 0.03 - 0.59 * y, -0.14 * y);
    ((b * b - 4.0 * a * c).sqrt() - b) / (2.0 * a)
}

impl FromStr for ToneCurve {
    type Err = UnknownName;

    fn from_str(name: &str) -> Result<ToneCurve, UnknownName> {
        CURVES.iter().find(|spec| spec.name == name).map(|spec| spec.curve).ok_or(UnknownName)
    }
}

impl ToneCurve {
    /// Its name in scene files.
    pub fn name(self) -> &'static str {
        CURVES[self as usize].name
    }

    /// Return Y for exposed light x, 0 or more.
    pub(super) fn apply(self, x: f64) -> f64 {
        (CURVES[self as usize].y)(x)
    }

    /// Return the light x that the curve maps to y, 0 < y < 1, but for rounding.
    pub(super) fn invert(self, y: f64) -> f64 {
        (CURVES[self as usize].x)(y)
    }
}

/// Return the linear value of an sRGB value v, 0..1.
///
/// linear = v / 12.92 up to v = 0.04045, else ((v + 0.055) / 1.055)^2.4 (IEC 61966-2-1).
pub(super) fn linear_of(v: f64) -> f64 {
    if v <= 0.04045 { v / 12.92 } else { libm::pow((v + 0.055) / 1.055, 2.4) }
}

/// Return the sRGB value of a linear value, which may be beyond white: the inverse of `linear_of`.
pub(super) fn srgb_of(linear: f64) -> f64 {
    if linear <= 0.04045 / 12.92 { linear * 12.92 } else { 1.055 * libm::pow(linear, 1.0 / 2.4) - 0.055 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const TONES: [ToneCurve; 3] = [ToneCurve::Clip, ToneCurve::Reinhard, ToneCurve::Aces];

    #[test]
    fn the_table_is_in_the_order_of_the_curves() {
        for (index, spec) in CURVES.iter().enumerate() {
            assert_eq!(spec.curve as usize, index);
        }
    }

    #[test]
    fn a_tone_curve_goes_by_the_name_of_the_scene_file() {
        assert_eq!(["clip", "reinhard", "aces"].map(str::parse), TONES.map(Ok));
        assert_eq!("Clip".parse::<ToneCurve>(), Err(UnknownName));
    }

    #[test]
    fn huge_light_is_white_on_every_curve() {
        for tone in TONES {
            let y = tone.apply(2f64.powi(600));
            assert!(y >= 1.0, "{tone:?} gives {y}");
        }
    }

    proptest! {
        #[test]
        fn the_inverse_of_a_tone_curve_undoes_it(y in 1e-7..0.99999) {
            for tone in TONES {
                let back = tone.apply(tone.invert(y));
                prop_assert!((back - y).abs() <= 1e-12 * y, "{tone:?}: {y} became {back}");
            }
        }

        #[test]
        fn srgb_undoes_linear(v in 0.0..1.0) {
            prop_assert!((srgb_of(linear_of(v)) - v).abs() < 1e-7);
        }
    }
}
