//! The exposure meter behind `exposure: auto`.

use crate::memory::{OutOfMemory, collect};

/// The 95th percentile of luminance becomes this share of white; brighter points, mostly lights, may clip.
const TARGET: f64 = 0.8;
const QUANTILE: f64 = 0.95;

/// The side of the square grid of points that are metered. It spans the whole picture, so the points do not depend
/// on the resolution, and move only a little if the picture gets a little wider.
pub const GRID: u32 = 256;

/// The result of metering.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeterReading {
    /// The 95th percentile of the luminance of the points that are not black; None if all are black.
    pub percentile: Option<f64>,
    /// The stops that expose the picture well, 0 if it is all black: 2^EV * P95 = 0.8.
    pub stops: f64,
}

/// Return the exposure for the `radiance` of points, interleaved linear RGB.
///
/// # Errors
///
/// If there is not enough memory to sort them.
pub fn meter(radiance: &[f32]) -> Result<MeterReading, OutOfMemory> {
    let (points, _) = radiance.as_chunks();
    let lit = points.iter().map(luminance).filter(|&y| y > 0.0);
    // Infinite radiance counts as the largest f32, so that the exposure is finite.
    let mut lit = collect(lit.map(|y| y.min(f64::from(f32::MAX))), "the exposure meter")?;
    let percentile = (!lit.is_empty()).then(|| quantile(&mut lit, QUANTILE));
    Ok(MeterReading { percentile, stops: percentile.map_or(0.0, |p95| libm::log2(TARGET / p95)) })
}

/// Y = 0.2126 R + 0.7152 G + 0.0722 B (Rec. 709).
fn luminance(&[r, g, b]: &[f32; 3]) -> f64 {
    f64::from(r) * 0.2126 + f64::from(g) * 0.7152 + f64::from(b) * 0.0722
}

/// Return a quantile, with linear interpolation between its neighbours in order: NumPy's default (R. Hyndman and
/// Y. Fan, "Sample Quantiles in Statistical Packages", 1996, definition 7), and in NumPy's order of operations.
fn quantile(values: &mut [f64], share: f64) -> f64 {
    let position = (values.len() - 1) as f64 * share;
    let weight = position.fract();
    let (_, &mut below, rest) = values.select_nth_unstable_by(position as usize, f64::total_cmp);
    let above = rest.iter().copied().fold(f64::INFINITY, f64::min);
    if rest.is_empty() {
        below
    } else if weight < 0.5 {
        below + (above - below) * weight
    } else {
        above - (above - below) * (1.0 - weight)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn meter(radiance: &[f32]) -> MeterReading {
        super::meter(radiance).unwrap()
    }

    #[test]
    fn a_black_picture_needs_no_exposure() {
        let black = MeterReading { percentile: None, stops: 0.0 };
        assert_eq!(meter(&[0.0; 30]), black);
        assert_eq!(meter(&[]), black);
    }

    #[test]
    fn an_even_picture_comes_out_at_four_fifths_of_white() {
        let stops = meter(&[0.2; 300]).stops;
        assert!((stops - 2.0).abs() < 1e-6, "{stops} stops");
    }

    #[test]
    fn what_is_not_lit_does_not_count() {
        let lit = [0.2, 0.4, 0.1, 0.7, 0.3, 0.5];
        let mut framed = vec![0.0; 30];
        framed.extend(lit);
        framed.extend([f32::NAN, 0.0, 0.0, -1.0, -1.0, -1.0]);
        assert_eq!(meter(&framed), meter(&lit));
    }

    #[test]
    fn infinite_light_gives_a_finite_exposure() {
        let stops = meter(&[f32::INFINITY; 30]).stops;
        assert!((stops + 128.3).abs() < 0.1, "{stops} stops");
    }

    #[test]
    fn the_stops_are_those_that_numpy_gives() {
        // For ((7919 i) mod 1000) / 250, i = 0, 1 .. 3 n - 1: math.log2(0.8 / np.percentile(luminance, 95)).
        let cases = [
            (1, -1.8435264917069618),
            (2, -1.8404681091786688),
            (3, -1.8374032293809759),
            (10, -1.9282232845809675),
            (21, -1.951909301270767),
            (1000, -2.136556248986855),
        ];
        for (pixels, expected) in cases {
            let radiance: Vec<f32> = (0..3 * pixels).map(|i| (7919 * i % 1000) as f32 / 250.0).collect();
            let MeterReading { stops, percentile } = meter(&radiance);
            assert!((stops - expected).abs() <= 4e-16, "{stops} for {pixels} pixels");
            assert!((percentile.unwrap() * 2.0_f64.powf(stops) - 0.8).abs() < 1e-15);
        }
    }

    proptest! {
        #[test]
        fn a_quantile_lies_where_sorting_puts_it(mut values in prop::collection::vec(0.0..1e3, 1..60)) {
            let rank = (values.len() - 1) as f64 * 0.95;
            let found = quantile(&mut values, 0.95);
            values.sort_by(f64::total_cmp);
            let (below, above) = (values[rank.floor() as usize], values[rank.ceil() as usize]);
            prop_assert!((below..=above).contains(&found));
        }

        #[test]
        fn twice_the_light_needs_one_stop_less(radiance in prop::collection::vec(1e-3f32..1e3, 3..90)) {
            let doubled: Vec<f32> = radiance.iter().map(|x| 2.0 * x).collect();
            prop_assert!((meter(&radiance).stops - meter(&doubled).stops - 1.0).abs() < 1e-12);
        }
    }
}
