use super::{Draw, cumulative, quantile};

const COUNT: u64 = 1_000_000;
const BINS: usize = 100;

/// One more than the value that a chi-square of 99 degrees of freedom exceeds once in 100,000 times.
const CHI_SQUARE: f64 = 169.0;

fn draws() -> impl Iterator<Item = Draw> {
    (0..COUNT).map(|index| Draw::new([1, 2], index, 0, 0))
}

/// FNV-1a of the bits of numbers.
fn hash(numbers: impl Iterator<Item = u64>) -> u64 {
    numbers
        .flat_map(u64::to_le_bytes)
        .fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3))
}

/// The chi-square of numbers from 0 to 1, in bins of equal width.
fn chi_square(shares: impl Iterator<Item = f64>) -> f64 {
    let mut counts = [0u64; BINS];
    shares.for_each(|share| counts[(share * BINS as f64) as usize] += 1);
    let expected = COUNT as f64 / BINS as f64;
    counts.iter().map(|&count| (count as f64 - expected).powi(2) / expected).sum()
}

#[test]
fn draws_are_the_same_in_every_version() {
    let bits = |number: f64| number.to_bits();
    let hashes = [
        hash(draws().map(|draw| draw.0)),
        hash(draws().map(|draw| bits(draw.uniform(-3.0, 5.0)))),
        hash(draws().map(|draw| bits(draw.log_uniform(0.01, 1000.0)))),
        hash(draws().map(|draw| bits(draw.normal(2.0, 3.0, f64::NEG_INFINITY, f64::INFINITY)))),
        hash(draws().map(|draw| bits(draw.normal(2.0, 3.0, 4.0, 9.0)))),
        hash(draws().map(|draw| draw.below(17))),
    ];
    assert_eq!(
        hashes,
        [
            10640740231654596855,
            6920597364193841202,
            11497114745684605407,
            9309254272554489235,
            3999935928186768155,
            13004378858895085743
        ]
    );
}

#[test]
fn draws_have_their_distributions() {
    let (a, b) = (cumulative(-0.5), cumulative(2.0));
    let unlimited = (f64::NEG_INFINITY, f64::INFINITY);
    for (name, found) in [
        ("uniform", chi_square(draws().map(|draw| (draw.uniform(-3.0, 5.0) + 3.0) / 8.0))),
        ("log_uniform", chi_square(draws().map(|draw| draw.log_uniform(0.01, 1000.0).log10().mul_add(0.2, 0.4)))),
        (
            "normal",
            chi_square(
                draws().map(|draw| cumulative(draw.normal(1.0, 2.0, unlimited.0, unlimited.1) / 2.0 - 0.5)),
            ),
        ),
        (
            "clipped",
            chi_square(
                draws().map(|draw| (cumulative(draw.normal(1.0, 2.0, 0.0, 5.0) / 2.0 - 0.5) - a) / (b - a)),
            ),
        ),
        ("integers", chi_square(draws().map(|draw| (draw.below(100) as f64 + 0.5) / 100.0))),
    ] {
        assert!(found < CHI_SQUARE, "{name}: {found}");
    }
}

#[test]
fn extreme_words_stay_inside_an_interval() {
    for draw in [Draw(0), Draw(u64::MAX)] {
        for x in [draw.uniform(1.0, 2.0), draw.log_uniform(1.0, 2.0), draw.normal(0.0, 1.0, 1.0, 2.0)] {
            assert!((1.0..2.0).contains(&x), "{draw:?}: {x}");
        }
        assert!(draw.normal(0.0, 1.0, f64::NEG_INFINITY, f64::INFINITY).is_finite());
        assert!(draw.below(7) < 7);
        assert_eq!(draw.uniform(3.0, 3.0), 3.0);
    }
    assert_eq!(Draw(u64::MAX).uniform(1.0, 2.0), 2.0f64.next_down());
}

#[test]
fn a_far_tail_is_drawn_exactly() {
    let x = Draw(1 << 63).normal(0.0, 1.0, 8.0, 9.0);
    let half = (cumulative(-8.0) + cumulative(-9.0)) / 2.0;
    assert!((cumulative(-x) / half - 1.0).abs() < 1e-12, "{x}");
}

#[test]
fn the_quantile_inverts_the_distribution_function() {
    for p in [1e-300, 1e-20, 0.01, 0.3, 0.5, 0.9, 0.999_999] {
        assert!((cumulative(quantile(p)) / p - 1.0).abs() < 1e-12, "{p}");
    }
}
