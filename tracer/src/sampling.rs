//! The sample positions in a pixel.

/// 1/phi, phi the golden ratio: the fractional parts of its multiples are spaced more evenly than any other
/// number's.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

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
