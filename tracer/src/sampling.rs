//! Fixed patterns: the sample positions in a pixel, and the places of an emitter.

use crate::vector::Vector;
use std::f64::consts::PI;

/// 1/phi, phi the golden ratio: the fractional parts of its multiples are spaced more evenly than any other
/// number's.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// sqrt(2) - 1 and sqrt(3) - 1: their multiples fill a square evenly.
const ACROSS: f64 = 0.414_213_562_373_095_05;
const ALONG: f64 = 0.732_050_807_568_877_2;

/// Return the offsets of a pixel's samples from its left and top edge, each 0..1; a single sample is the centre.
///
/// (x_i, y_i) = (i + 1/2, rank_i + 1/2) / n, where rank_i counts the numbers frac(1/2 + k / phi), k < n, that are
/// below the i-th: a golden lattice (a rank-1 lattice, S. Dammertz and A. Keller, "Image Synthesis by Rank-1
/// Lattices", 2008) with its rows spaced as evenly as its columns. So a vertical or horizontal edge is resolved to
/// 1/n of a pixel; four samples form the rotated grid.
pub fn sample_offsets(count: u32) -> Vec<(f64, f64)> {
    let height = |i: u32| {
        let value = 0.5 + f64::from(i) * GOLDEN;
        value - value.floor()
    };
    let mut by_height: Vec<u32> = (0..count).collect();
    by_height.sort_by(|&a, &b| height(a).total_cmp(&height(b)));
    let middle = |index: u32| (f64::from(index) + 0.5) / f64::from(count);
    let mut offsets = vec![(0.0, 0.0); count as usize];
    for (rank, &i) in (0..).zip(&by_height) {
        offsets[i as usize] = (middle(i), middle(rank));
    }
    offsets
}

/// Return the places of an emitter in a ball of radius 1 around the origin, in pairs opposite to each other; a single
/// one, and the first of an odd number, is the centre.
///
/// Their density in the ball grows toward its surface as 1 / sqrt(1 - r^2), so that a straight line through the ball
/// meets as much of it wherever it passes: from everywhere they look like a disk of even brightness, as a Lambertian
/// sphere does. This is a sphere in four dimensions, spread evenly, seen in three. With s even in 0..1 and the angles
/// a, b even:
///
/// (x, y, z) = (sqrt(s) cos(a), sqrt(s) sin(a), sqrt(1 - s) cos(b))
///
/// Of half of the places s is a row of even steps, and a and b are multiples of irrational numbers, a Kronecker
/// sequence.
pub fn emitter_places(count: u32) -> Vec<Vector> {
    let pairs = count / 2;
    let mut places = Vec::with_capacity(count as usize);
    if count % 2 == 1 {
        places.push([0.0; 3]);
    }
    for i in 0..pairs {
        let fraction = |step: f64| (0.5 + f64::from(i) * step) % 1.0;
        let s = (f64::from(i) + 0.5) / f64::from(pairs);
        let (a, b) = (2.0 * PI * fraction(ACROSS), PI / 2.0 * fraction(ALONG));
        let (ring, height) = (s.sqrt(), (1.0 - s).sqrt());
        let place = [ring * libm::cos(a), ring * libm::sin(a), height * libm::cos(b)];
        places.extend([place, place.map(|component| -component)]);
    }
    places
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_sample_goes_through_the_centre_and_four_are_the_rotated_grid() {
        assert_eq!(sample_offsets(1), [(0.5, 0.5)]);
        assert_eq!(sample_offsets(4), [(0.125, 0.625), (0.375, 0.125), (0.625, 0.875), (0.875, 0.375)]);
    }

    #[test]
    fn each_row_and_each_column_of_a_pixel_has_one_sample() {
        for count in 1..=1024 {
            let mut rows: Vec<f64> = sample_offsets(count).iter().map(|offset| offset.1).collect();
            rows.sort_by(f64::total_cmp);
            let columns: Vec<f64> = sample_offsets(count).iter().map(|offset| offset.0).collect();
            assert_eq!(rows, columns);
        }
    }
}
