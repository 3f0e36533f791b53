//! The objects that are so far away that float32 cannot tell what they hide.

use crate::bounds::BoundingSphere;
use crate::camera_space::MAX_RANGE;
use crate::memory::{OutOfMemory, collect};
use crate::shapes::OBJECTS;
use crate::vector::length;

/// Bounded objects of which nothing is within range of the eye, in order.
#[derive(Debug, Default)]
pub(crate) struct FarObjects {
    /// Those that are where they were.
    in_place: Vec<u32>,
    /// Those that were moved toward the eye.
    moved: Vec<u32>,
}

/// Whether an object with a range scale is far, and not in the way of what is near.
pub(crate) fn is_far(bounds: Option<BoundingSphere>, range_scale: f64) -> bool {
    let is_beyond = |bounds: BoundingSphere| length(bounds.center) - bounds.radius > MAX_RANGE;
    bounds.is_some_and(|bounds| range_scale < 1.0 || is_beyond(bounds))
}

impl FarObjects {
    /// Make the lists from the far objects and their range scales.
    ///
    /// # Errors
    ///
    /// If memory runs out.
    pub(crate) fn new(objects: impl Iterator<Item = (u32, f64)> + Clone) -> Result<FarObjects, OutOfMemory> {
        let list = |moved: bool| {
            let own = objects.clone().filter(|(_, range_scale)| (*range_scale < 1.0) == moved);
            collect(own.map(|(index, _)| index), OBJECTS)
        };
        Ok(FarObjects { in_place: list(false)?, moved: list(true)? })
    }

    /// Return the objects whose shadows in a light are found in float64, in two lists in order: those that were moved
    /// are among them only if the light was. Else float32 holds them.
    #[inline(always)]
    pub(crate) fn before(&self, light_was_moved: bool) -> FarBefore<'_> {
        FarBefore { in_place: &self.in_place, moved: if light_was_moved { &self.moved } else { &[] } }
    }
}

/// The far objects whose shadows in one light are found in float64.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FarBefore<'a> {
    in_place: &'a [u32],
    moved: &'a [u32],
}

impl FarBefore<'_> {
    pub(crate) fn iter(&self) -> impl Iterator<Item = u32> {
        self.in_place.iter().chain(self.moved).copied()
    }

    #[inline(always)]
    pub(crate) fn is_empty(&self) -> bool {
        self.len() == 0
    }

    #[inline(always)]
    pub(crate) fn len(&self) -> u64 {
        (self.in_place.len() + self.moved.len()) as u64
    }

    #[inline(always)]
    pub(crate) fn contains(&self, object: u32) -> bool {
        !self.is_empty()
            && (self.in_place.binary_search(&object).is_ok() || self.moved.binary_search(&object).is_ok())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_moved_is_far_only_before_a_light_that_was_moved_too() {
        let far = FarObjects::new([(2, 1.0), (5, 0.25), (7, 1.0)].into_iter()).unwrap();
        for (light_was_moved, expected) in [(false, &[2, 7][..]), (true, &[2, 7, 5])] {
            let before = far.before(light_was_moved);
            assert_eq!(before.iter().collect::<Vec<_>>(), expected);
            assert_eq!((0..9).filter(|&object| before.contains(object)).count(), expected.len());
            assert_eq!(before.len(), expected.len() as u64);
        }
    }

    #[test]
    fn an_object_is_far_if_none_of_it_is_within_range() {
        let at = |z: f64, radius: f64| Some(BoundingSphere { center: [0.0, 0.0, z], radius });
        assert!(is_far(at(1e30, 9e29), 1.0) && is_far(at(MAX_RANGE, 0.1 * MAX_RANGE), 1e-10));
        assert!(!is_far(at(1e30, 1e30), 1.0) && !is_far(at(1e10, 1.0), 1.0) && !is_far(None, 1e-10));
    }
}
