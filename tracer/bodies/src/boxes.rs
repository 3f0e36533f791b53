//! Boxes around many objects: to find those that one place or one view concerns, without a look at all of them.

/// What rounding may add to a distance, as a share of the coordinates and sizes.
const ROUNDING: f64 = 1.0 / (1u64 << 40) as f64;

/// A point, or half the size of a box along each axis.
pub type Triple = [f64; 3];

/// All points whose distance above a plane is at most a limit: those with n.(p - eye) + offset <= limit.
#[derive(Clone, Copy, Debug)]
pub struct Beyond {
    /// The normal of the plane, a unit vector.
    pub normal: Triple,
    /// The distance of the eye above the plane.
    pub offset: f64,
    /// The largest distance.
    pub limit: f64,
}

/// The smallest box along the axes around each of many objects; infinite around one without an end.
#[derive(Clone, Debug)]
pub struct Boxes {
    centers: Vec<Triple>,
    halves: Vec<Triple>,
}

impl Boxes {
    /// Returns the boxes with some centers and halves of their sizes, which are as many.
    pub fn new(centers: Vec<Triple>, halves: Vec<Triple>) -> Boxes {
        assert_eq!(centers.len(), halves.len(), "each box has a center and a size");
        Boxes { centers, halves }
    }

    /// Returns the number of boxes.
    pub fn len(&self) -> usize {
        self.centers.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.centers.is_empty()
    }

    /// Returns the center of a box, and half its size.
    pub fn get(&self, index: usize) -> (Triple, Triple) {
        (self.centers[index], self.halves[index])
    }

    /// Returns the indices of all boxes that meet another; more where rounding hides whether they do.
    pub fn meeting(&self, center: Triple, half: Triple) -> Vec<usize> {
        self.indices(|own, own_half| {
            let rounding = ROUNDING * (size(own) + size(own_half) + size(center) + size(half));
            (0..3).all(|i| {
                let gap = (own[i] - center[i]).abs() - own_half[i] - half[i];
                // Where numbers overflow, a box is near.
                !(gap > rounding && gap.is_finite())
            })
        })
    }

    /// Returns the indices of all boxes with a point beyond one of some planes; more where rounding hides it.
    pub fn beyond(&self, eye: Triple, planes: &[Beyond]) -> Vec<usize> {
        self.indices(|center, half| {
            planes.iter().any(|&Beyond { normal, offset, limit }| {
                let lowest = offset
                    + (0..3).map(|i| normal[i] * (center[i] - eye[i]) - normal[i].abs() * half[i]).sum::<f64>();
                let rounding = ROUNDING * (size(center) + size(half) + size(eye) + offset.abs());
                !(lowest > limit + rounding && lowest.is_finite())
            })
        })
    }

    fn indices(&self, is_wanted: impl Fn(Triple, Triple) -> bool) -> Vec<usize> {
        (0..self.len()).filter(|&index| is_wanted(self.centers[index], self.halves[index])).collect()
    }
}

/// The sum of the coordinates, to which rounding is proportional.
fn size(vector: Triple) -> f64 {
    vector[0].abs() + vector[1].abs() + vector[2].abs()
}

#[cfg(test)]
mod tests {
    use super::{Beyond, Boxes};

    fn row() -> Boxes {
        Boxes::new((0..5).map(|i| [f64::from(i) * 10.0, 0.0, 0.0]).collect(), vec![[1.0, 2.0, 3.0]; 5])
    }

    #[test]
    fn boxes_meet_if_they_do_along_each_axis() {
        assert_eq!(row().meeting([10.0, 0.0, 0.0], [0.0; 3]), [1]);
        assert_eq!(row().meeting([15.0, 4.0, -5.0], [4.0, 2.0, 2.0]), [1, 2]);
        assert_eq!(row().meeting([15.0, 4.1, -5.0], [4.0, 2.0, 2.0]), [] as [usize; 0]);
        assert_eq!(row().meeting([15.0, 4.0, -5.0], [3.9, 2.0, 2.0]), [] as [usize; 0]);
    }

    #[test]
    fn boxes_meet_far_away_where_coordinates_are_rounded() {
        let far = Boxes::new(vec![[0.0, 1e9, 0.0]], vec![[1.0; 3]]);
        assert_eq!(far.meeting([1.0 + 1e-5, 1e9, 0.0], [0.0; 3]), [0]);
        assert_eq!(far.meeting([1.1, 1e9, 0.0], [0.0; 3]), [] as [usize; 0]);
    }

    #[test]
    fn boxes_are_beyond_a_plane_if_a_corner_is() {
        let plane = |offset, limit| [Beyond { normal: [0.6, 0.8, 0.0], offset, limit }];
        // The lowest corner of the first is 2.2 below its center.
        assert_eq!(row().beyond([0.0; 3], &plane(0.0, 0.0)), [0]);
        assert_eq!(row().beyond([0.0; 3], &plane(2.3, 0.0)), [] as [usize; 0]);
        assert_eq!(row().beyond([0.0; 3], &plane(0.0, 4.0)), [0, 1]);
        assert_eq!(row().beyond([0.0; 3], &plane(0.0, 3.7)), [0]);
        assert_eq!(row().beyond([10.0, 0.0, 0.0], &plane(0.0, 0.0)), [0, 1]);
    }

    #[test]
    fn what_has_no_end_or_overflows_is_everywhere() {
        let (huge, endless) = ([f64::MAX; 3], [f64::INFINITY; 3]);
        let boxes = Boxes::new(vec![[0.0; 3], huge], vec![endless, [1.0; 3]]);
        assert_eq!(boxes.meeting([-f64::MAX; 3], [1.0; 3]), [0, 1]);
        let plane = Beyond { normal: [0.0, 1.0, 0.0], offset: 0.0, limit: 0.0 };
        assert_eq!(boxes.beyond([0.0, -f64::MAX, 0.0], &[plane]), [0, 1]);
        assert_eq!(Boxes::new(vec![[0.0; 3]], vec![[1.0; 3]]).meeting([0.0; 3], [f64::INFINITY; 3]), [0]);
    }
}
