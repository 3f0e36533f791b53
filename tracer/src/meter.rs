//! The exposure meter behind `exposure: auto`.

/// The picture that is metered has this many rows, so that the exposure does not depend on the resolution.
const ROWS: u32 = 120;
/// Unless it is so wide that these columns leave it fewer.
const COLUMNS: u32 = 1920;

/// Nineteen of twenty lit pixels stay below this share of white; the rest, lamps mostly, may burn out.
const TARGET: f64 = 0.8;
const QUANTILE: f64 = 0.95;

/// Returns the size of the picture to meter for a picture of `width` x `height` pixels: the same view, but small.
pub fn meter_size(width: u32, height: u32) -> (u32, u32) {
    let (width, height) = (f64::from(width), f64::from(height));
    let scale = (f64::from(ROWS) / height).min(f64::from(COLUMNS) / width);
    let scaled = |side: f64| (side * scale).round_ties_even().max(1.0) as u32;
    (scaled(width), scaled(height))
}

/// Returns the stops that expose a picture well, 0 for one that is all black.
///
/// 2^EV * P95 = 0.8, where P95 is the 95th percentile of the luminance of all pixels that are not black.
///
/// `radiance` is interleaved linear RGB, the whole picture in the size that [`meter_size`] gives.
pub fn auto_exposure(radiance: &[f32]) -> f64 {
    let (pixels, _) = radiance.as_chunks();
    let lit = pixels.iter().map(luminance).filter(|&y| y > 0.0);
    // Infinite light counts as the most that an f32 holds, so that the exposure is finite.
    let mut lit: Vec<f64> = lit.map(|y| y.min(f64::from(f32::MAX))).collect();
    if lit.is_empty() {
        return 0.0;
    }
    libm::log2(TARGET / quantile(&mut lit, QUANTILE))
}

/// Y = 0.2126 R + 0.7152 G + 0.0722 B (Rec. 709).
fn luminance(&[r, g, b]: &[f32; 3]) -> f64 {
    f64::from(r) * 0.2126 + f64::from(g) * 0.7152 + f64::from(b) * 0.0722
}

/// Returns a quantile, with linear interpolation between its neighbours in order: NumPy's default (R. Hyndman and
/// Y. Fan, "Sample Quantiles in Statistical Packages", 1996, definition 7), and in NumPy's order of operations.
fn quantile(values: &mut [f64], share: f64) -> f64 {
    let place = (values.len() - 1) as f64 * share;
    let weight = place.fract();
    let (_, &mut below, rest) = values.select_nth_unstable_by(place as usize, f64::total_cmp);
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

    #[test]
    fn the_metered_picture_has_120_rows_but_at_most_1920_columns() {
        let cases = [
            ((1920, 1080), (213, 120)),
            ((64, 64), (120, 120)),
            ((1, 1), (120, 120)),
            ((32768, 1024), (1920, 60)),
            ((65535, 1), (1920, 1)),
            ((1, 65535), (1, 120)),
        ];
        for ((width, height), expected) in cases {
            assert_eq!(meter_size(width, height), expected, "for {width}x{height}");
        }
    }

    #[test]
    fn half_a_pixel_is_rounded_to_the_even_number() {
        assert_eq!(meter_size(5, 240), (2, 120));
        assert_eq!(meter_size(7, 240), (4, 120));
    }

    #[test]
    fn a_black_picture_needs_no_exposure() {
        assert_eq!(auto_exposure(&[0.0; 30]), 0.0);
        assert_eq!(auto_exposure(&[]), 0.0);
    }

    #[test]
    fn an_even_picture_comes_out_at_four_fifths_of_white() {
        let stops = auto_exposure(&[0.2; 300]);
        assert!((stops - 2.0).abs() < 1e-6, "{stops} stops");
    }

    #[test]
    fn what_is_not_lit_does_not_count() {
        let lit = [0.2, 0.4, 0.1, 0.7, 0.3, 0.5];
        let mut framed = vec![0.0; 30];
        framed.extend(lit);
        framed.extend([f32::NAN, 0.0, 0.0, -1.0, -1.0, -1.0]);
        assert_eq!(auto_exposure(&framed), auto_exposure(&lit));
    }

    #[test]
    fn infinite_light_gives_a_finite_exposure() {
        let stops = auto_exposure(&[f32::INFINITY; 30]);
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
            let stops = auto_exposure(&radiance);
            assert!((stops - expected).abs() <= 4e-16, "{stops} for {pixels} pixels");
        }
    }

    proptest! {
        #[test]
        fn a_quantile_lies_where_sorting_puts_it(mut values in prop::collection::vec(0.0..1e3, 1..60)) {
            let place = (values.len() - 1) as f64 * 0.95;
            let found = quantile(&mut values, 0.95);
            values.sort_by(f64::total_cmp);
            let (below, above) = (values[place.floor() as usize], values[place.ceil() as usize]);
            prop_assert!((below..=above).contains(&found));
        }

        #[test]
        fn twice_the_light_needs_one_stop_less(radiance in prop::collection::vec(1e-3f32..1e3, 3..90)) {
            let doubled: Vec<f32> = radiance.iter().map(|x| 2.0 * x).collect();
            prop_assert!((auto_exposure(&radiance) - auto_exposure(&doubled) - 1.0).abs() < 1e-12);
        }
    }
}
