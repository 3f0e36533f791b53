use super::*;

/// Candidates of a lane, with the objects' numbers for faces: depths in float64 and in float32, and the slack of
/// all.
fn candidates(depths: &[(f64, f32)], slack: f64) -> Vec<Candidate> {
    let candidate = |(i, &(depth, t)): (usize, &(f64, f32))| Candidate {
        lane: 7,
        number: i as u32,
        face: i as u32,
        t,
        depth,
        slack,
    };
    depths.iter().enumerate().map(candidate).collect()
}

fn seen(depths: &[(f64, f32)], slack: f64, blur: f64) -> Option<u32> {
    first_of_the_nearest(&candidates(depths, slack), |depth| blur * depth).map(|candidate| candidate.face)
}

#[test]
fn what_float64_finds_nearer_is_seen_whatever_float32_said() {
    assert_eq!(seen(&[(1e7, 1.0e7), (1e7 - 1e-3, 1.0e7)], 0.0, 0.0), Some(1));
    assert_eq!(seen(&[(1e7, 1.0e7), (1e7 + 1e-3, 9_999_999.0)], 0.0, 0.0), Some(0));
}

#[test]
fn of_faces_in_one_place_the_first_is_seen() {
    let (near, nearer) = (5.0 * (1.0 + 1e-14), 5.0);
    assert_eq!(seen(&[(6.0, 5.0), (near, 5.0), (nearer, 5.0)], 0.0, 0.0), Some(1));
    // Rounding at a slant may be more than a share of the depth.
    assert_eq!(seen(&[(5.0 + 1e-9, 5.0), (5.0, 5.0)], 1e-9, 0.0), Some(0));
    assert_eq!(seen(&[(5.0 + 3e-9, 5.0), (5.0, 5.0)], 1e-9, 0.0), Some(1));
}

#[test]
fn where_surfaces_cross_float32_decides_but_not_where_they_are_in_one_place() {
    let crossing = [(5.0, 5.000_001), (5.0 + 1e-7, 5.0)];
    assert_eq!(seen(&crossing, 0.0, 1e-7), Some(1));
    assert_eq!(seen(&crossing, 0.0, 1e-9), Some(0));
    assert_eq!(seen(&[(5.0, 5.000_001), (5.0, 5.0)], 0.0, 1e-7), Some(0));
}

#[test]
fn a_face_alone_and_one_that_float64_misses_are_left_as_they_are() {
    assert_eq!(seen(&[(5.0, 5.0)], 0.0, 0.0), None);
    assert_eq!(seen(&[(f64::INFINITY, 5.0), (f64::INFINITY, 5.0)], 0.0, 0.0), None);
    assert_eq!(seen(&[(f64::INFINITY, 5.0), (5.5, 5.5)], 0.0, 0.0), Some(1));
}
