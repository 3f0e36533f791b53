//! Developing against an oracle that computes in integers of any length, where nothing is rounded.

use super::*;
use proptest::prelude::*;

const TONES: [ToneCurve; 3] = [ToneCurve::Clip, ToneCurve::Reinhard, ToneCurve::Aces];
const DEPTHS: [BitDepth; 2] = [BitDepth::Eight, BitDepth::Sixteen];

/// A natural number: digits of 32 bits, the least first, no zeros at the end.
#[derive(Clone, PartialEq, Eq)]
struct Natural(Vec<u32>);

impl Natural {
    fn of(n: u64) -> Natural {
        Natural(vec![n as u32, (n >> 32) as u32]).trimmed()
    }

    fn trimmed(mut self) -> Natural {
        while self.0.last() == Some(&0) {
            self.0.pop();
        }
        self
    }

    fn plus(&self, other: &Natural) -> Natural {
        let mut carry = 0;
        let digits = 0..=self.0.len().max(other.0.len());
        let sums = digits.map(|i| {
            let digit = |n: &Natural| u64::from(n.0.get(i).copied().unwrap_or(0));
            carry = digit(self) + digit(other) + (carry >> 32);
            carry as u32
        });
        Natural(sums.collect()).trimmed()
    }

    fn times(&self, other: &Natural) -> Natural {
        let mut product = vec![0u32; self.0.len() + other.0.len()];
        for (i, &a) in self.0.iter().enumerate() {
            let mut carry = 0u64;
            for (j, &b) in other.0.iter().enumerate() {
                carry = u64::from(a) * u64::from(b) + u64::from(product[i + j]) + (carry >> 32);
                product[i + j] = carry as u32;
            }
            product[i + other.0.len()] = (carry >> 32) as u32;
        }
        Natural(product).trimmed()
    }

    fn scaled(&self, n: u64) -> Natural {
        self.times(&Natural::of(n))
    }

    fn squared(&self) -> Natural {
        self.times(self)
    }

    /// Return n 2^bits.
    fn shifted(&self, bits: u32) -> Natural {
        let mut digits = vec![0; bits as usize / 32];
        digits.extend(&self.scaled(1 << (bits % 32)).0);
        Natural(digits).trimmed()
    }

    fn at_least(&self, other: &Natural) -> bool {
        let digits = self.0.len().cmp(&other.0.len());
        digits.then_with(|| self.0.iter().rev().cmp(other.0.iter().rev())).is_ge()
    }
}

/// Return (m, e) with x = m 2^e, for a positive number.
fn parts(x: f64) -> (u64, i32) {
    let (mantissa, exponent) = (x.to_bits() & ((1 << 52) - 1), (x.to_bits() >> 52) as i32);
    assert!(exponent > 0, "{x} is subnormal");
    (mantissa | 1 << 52, exponent - 1075)
}

/// Return whether x = radiance * factor is developed to k or more: tone(x) >= linear((k - 1/2) / max).
fn reaches(radiance: f32, factor: f64, tone: ToneCurve, bits: BitDepth, k: u32) -> bool {
    // x = a / b
    let ((m, e), (n, f)) = (parts(f64::from(radiance)), parts(factor));
    let x = Natural::of(m).scaled(n);
    let a = x.shifted((e + f).max(0) as u32);
    let b = Natural::of(1).shifted((-e - f).max(0) as u32);
    // tone(x) = y / z
    let (y, z) = match tone {
        ToneCurve::Clip => (a, b),
        ToneCurve::Reinhard => (a.clone(), a.plus(&b)),
        ToneCurve::Aces => (
            a.times(&a.scaled(251).plus(&b.scaled(3))),
            a.times(&a.scaled(243).plus(&b.scaled(59))).plus(&b.squared().scaled(14)),
        ),
    };
    // v = (2 k - 1) / (2 max); v / 12.92, or ((v + 0.055) / 1.055)^(12/5)
    let (v, twice_white) = (2 * u64::from(k) - 1, 2 * u64::from(bits.white()));
    if v * 100_000 <= 4045 * twice_white {
        return y.scaled(1292 * twice_white).at_least(&z.scaled(100 * v));
    }
    let fifth = |n: &Natural| n.squared().squared().times(n);
    let twelfth = |n: u64| Natural::of(n).squared().times(&Natural::of(n)).squared().squared();
    let (above, below) = (v * 1000 + 55 * twice_white, 1055 * twice_white);
    fifth(&y).times(&twelfth(below)).at_least(&fifth(&z).times(&twelfth(above)))
}

/// Return the exact value of any radiance.
fn exact(radiance: f32, exposure: f64, tone: ToneCurve, bits: BitDepth) -> u32 {
    if radiance.is_nan() || radiance <= 0.0 {
        return 0;
    }
    if radiance.is_infinite() {
        return bits.white();
    }
    let factor = libm::exp2(exposure);
    let (mut known, mut beyond) = (0, bits.white() + 1);
    while beyond - known > 1 {
        let k = u32::midpoint(known, beyond);
        if reaches(radiance, factor, tone, bits, k) {
            known = k;
        } else {
            beyond = k;
        }
    }
    known
}

fn developed(developer: &Developer, radiance: &[f32]) -> Vec<u32> {
    // Whole pixels: the rest is padded with black.
    let mut pixels = radiance.to_vec();
    pixels.resize(radiance.len().next_multiple_of(3), 0.0);
    let mut bytes = vec![0; pixels.len() / 3 * developer.bytes_per_pixel()];
    developer.develop(&pixels, &mut bytes);
    let values = bytes.chunks(developer.bytes_per_pixel() / 3);
    let number = |bytes: &[u8]| bytes.iter().fold(0, |n, &byte| n << 8 | u32::from(byte));
    values.map(number).take(radiance.len()).collect()
}

/// Check every `stride`th step of a curve.
fn check_steps(exposure: f64, bits: BitDepth, stride: usize) {
    let factor = libm::exp2(exposure);
    for tone in TONES {
        let steps = steps(factor, tone, bits);
        for k in (1..steps.len()).step_by(stride) {
            let (step, value) = (steps[k], k as u32);
            let rightly =
                reaches(step, factor, tone, bits, value) && !reaches(step.next_down(), factor, tone, bits, value);
            assert!(rightly, "step {value} is not {step} for {tone:?} at {exposure} stops");
        }
    }
}

#[test]
fn each_of_the_255_steps_is_the_smallest_f32_that_reaches_its_value() {
    for exposure in [-0.5, -0.31, 0.0, 0.25, 0.499] {
        check_steps(exposure, BitDepth::Eight, 1);
    }
}

#[test]
fn each_of_the_65535_steps_is_the_smallest_f32_that_reaches_its_value() {
    check_steps(0.0, BitDepth::Sixteen, 1);
    for exposure in [-0.5, 0.123, 0.499] {
        check_steps(exposure, BitDepth::Sixteen, 127);
    }
}

/// Check the look-up on both sides of every step and of every bucket's start.
fn check_lookup(exposure: f64, tone: ToneCurve, bits: BitDepth) {
    let steps = steps(libm::exp2(exposure), tone, bits);
    let buckets = (0..0x7F80u32).map(|bucket| f32::from_bits(bucket << 16));
    let sides = |x: f32| [x.next_down(), x, x.next_up()];
    let radiance: Vec<f32> = steps.iter().copied().chain(buckets).flat_map(sides).collect();
    let values = developed(&Developer::new(exposure, tone, bits), &radiance);
    for (x, value) in radiance.into_iter().zip(values) {
        let reached = steps[1..].partition_point(|&step| step <= x);
        assert_eq!(value as usize, reached, "for {x:e}, {tone:?} at {exposure} stops");
    }
}

#[test]
fn developing_counts_the_steps_up_to_the_radiance() {
    for tone in TONES {
        // Up to half a stop the exposure is all in the steps; a fine comb puts white anywhere in its octave.
        for comb in -15..=15 {
            check_lookup(f64::from(comb) / 30.0, tone, BitDepth::Eight);
        }
        for exposure in [-0.5, -0.01, 0.0, 0.33] {
            check_lookup(exposure, tone, BitDepth::Sixteen);
        }
    }
}

#[test]
fn well_known_values_come_out() {
    let radiance = [0.0, 0.18, 0.5, 1.0];
    let cases = [
        (ToneCurve::Clip, BitDepth::Eight, [0, 118, 188, 255]),
        (ToneCurve::Reinhard, BitDepth::Eight, [0, 109, 156, 188]),
        (ToneCurve::Aces, BitDepth::Eight, [0, 141, 206, 232]),
        (ToneCurve::Clip, BitDepth::Sixteen, [0, 30235, 48192, 65535]),
    ];
    for (tone, bits, expected) in cases {
        let values = developed(&Developer::new(0.0, tone, bits), &radiance);
        assert_eq!(values, expected, "{tone:?} {bits:?}");
    }
}

#[test]
fn a_channel_of_16_bits_has_its_high_byte_first() {
    let mut bytes = [0; 6];
    Developer::new(0.0, ToneCurve::Clip, BitDepth::Sixteen).develop(&[0.5, 0.0, 1.0], &mut bytes);
    assert_eq!(bytes, [0xBC, 0x40, 0, 0, 0xFF, 0xFF]);
}

#[test]
fn what_is_no_light_is_black_and_infinite_light_white() {
    let odd = [f32::NAN, -f32::NAN, -1.0, -0.0, 0.0, f32::NEG_INFINITY, f32::INFINITY];
    for exposure in [-1e300, -400.0, 0.0, 3.7, 400.0, f64::INFINITY] {
        for (tone, bits) in TONES.into_iter().flat_map(|tone| DEPTHS.map(|bits| (tone, bits))) {
            let values = developed(&Developer::new(exposure, tone, bits), &odd);
            assert_eq!(values, [0, 0, 0, 0, 0, 0, bits.white()], "{tone:?} at {exposure} stops");
        }
    }
}

#[test]
fn at_400_stops_the_faintest_light_is_white_and_at_minus_400_the_brightest_black() {
    for (tone, bits) in TONES.into_iter().flat_map(|tone| DEPTHS.map(|bits| (tone, bits))) {
        let faintest = developed(&Developer::new(400.0, tone, bits), &[f32::from_bits(1)]);
        let brightest = developed(&Developer::new(-400.0, tone, bits), &[f32::MAX]);
        assert_eq!((faintest[0], brightest[0]), (bits.white(), 0), "{tone:?}");
    }
}

#[test]
#[should_panic(expected = "bytes for the values to develop")]
fn a_buffer_of_the_wrong_length_is_refused() {
    Developer::new(0.0, ToneCurve::Clip, BitDepth::Sixteen).develop(&[0.0; 6], &mut [0; 6]);
}

#[test]
#[should_panic(expected = "not a number")]
fn an_exposure_that_is_not_a_number_is_refused() {
    Developer::new(f64::NAN, ToneCurve::Clip, BitDepth::Eight);
}

fn any_tone() -> impl Strategy<Value = ToneCurve> {
    prop::sample::select(TONES.to_vec())
}

/// Any f32, and often one that the exposure brings near the visible range.
fn any_radiance(exposure: f64) -> impl Strategy<Value = f32> {
    let visible = (-22.0..18.0).prop_map(move |stops: f64| libm::exp2(stops - exposure) as f32);
    prop_oneof![3 => visible, 1 => any::<u32>().prop_map(f32::from_bits)]
}

proptest! {
    #[test]
    fn any_light_at_any_exposure_has_its_exact_value(
        (exposure, radiance) in (-420.0..420.0).prop_flat_map(|exposure| {
            (Just(exposure), prop::collection::vec(any_radiance(exposure), 12))
        }),
        tone in any_tone(),
    ) {
        let exactly: Vec<u32> = radiance.iter().map(|&x| exact(x, exposure, tone, BitDepth::Eight)).collect();
        prop_assert_eq!(developed(&Developer::new(exposure, tone, BitDepth::Eight), &radiance), exactly);
    }

    #[test]
    fn more_light_is_never_darker(exposure in -20.0..20.0, tone in any_tone(), seed in any::<u64>()) {
        let developer = Developer::new(exposure, tone, BitDepth::Eight);
        let mut radiance: Vec<f32> = (1..1000u64)
            .map(|i| f32::from_bits((seed.wrapping_mul(2 * i + 1) >> 33) as u32 % 0x7F80_0000))
            .collect();
        radiance.sort_by(f32::total_cmp);
        prop_assert!(developed(&developer, &radiance).is_sorted());
    }
}

#[test]
fn with_alpha_a_color_is_that_of_the_samples_that_hit() {
    let developer = Developer::new(0.0, ToneCurve::Clip, BitDepth::Eight);
    let mut radiance = [0.25, 0.5, f32::NAN, 0.7, 0.7, 0.7, 1e38, 0.0, 0.0];
    let mut levels = [9; 12];
    developer.develop_straight(&mut radiance, &[0.5, 0.0, 1e-3], &mut levels);
    let [half, white] = [0.5, 1.0].map(|x| exact(x, 0.0, ToneCurve::Clip, BitDepth::Eight) as u8);
    assert_eq!(levels, [half, white, 0, 128, 0, 0, 0, 0, white, 0, 0, 0]);
}

proptest! {
    // The tables of 16 bits take their time.
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn any_light_at_any_exposure_has_its_exact_value_in_16_bits(
        (exposure, radiance) in (-170.0..170.0).prop_flat_map(|exposure| {
            (Just(exposure), prop::collection::vec(any_radiance(exposure), 30))
        }),
        tone in any_tone(),
    ) {
        let exactly: Vec<u32> = radiance.iter().map(|&x| exact(x, exposure, tone, BitDepth::Sixteen)).collect();
        prop_assert_eq!(developed(&Developer::new(exposure, tone, BitDepth::Sixteen), &radiance), exactly);
    }

    #[test]
    fn opaque_pixels_are_those_without_alpha(
        mut radiance in prop::collection::vec(0.0_f32..1.5, 3 * 600),
        bits in prop::sample::select(&DEPTHS[..]),
    ) {
        let developer = Developer::new(0.0, ToneCurve::Clip, bits);
        let mut plain = vec![0; 600 * developer.bytes_per_pixel()];
        developer.develop(&radiance, &mut plain);
        let mut levels = vec![0; 600 * (developer.bytes_per_pixel() + bits.bytes())];
        developer.develop_straight(&mut radiance, &[1.0; 600], &mut levels);
        for (pixel, plain) in levels.chunks(4 * bits.bytes()).zip(plain.chunks(3 * bits.bytes())) {
            prop_assert_eq!(&pixel[..plain.len()], plain);
            prop_assert!(pixel[plain.len()..].iter().all(|&byte| byte == 255));
        }
    }
}
