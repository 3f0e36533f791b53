use super::*;
use crate::grid::SIDE;
use crate::place::View;
use crate::world::Window;
use proptest::prelude::*;

/// A block in the corner of a picture, of which a window is wanted.
fn place(window: Window) -> Place {
    let view = View {
        width: 100,
        height: 100,
        half_pixel: (0.01, 0.01),
    };
    Place {
        view,
        corner: (SIDE, SIDE),
        window,
    }
}

const WHOLE: Window = Window {
    x: 0,
    y: 0,
    width: 100,
    height: 100,
};

fn any_window() -> impl Strategy<Value = Window> {
    prop_oneof![
        Just(WHOLE),
        (0_u32..40, 0_u32..40, 1_u32..40, 1_u32..40).prop_map(|(x, y, width, height)| Window {
            x,
            y,
            width,
            height
        })
    ]
}

/// What a block meets: anything from one face to a different one for each ray.
fn any_hits() -> impl Strategy<Value = Nearest> {
    let faces = prop_oneof![1_u32..4, 4_u32..256, Just(1 << 29)];
    faces
        .prop_flat_map(|faces| {
            let face = any::<u32>().prop_map(move |face| {
                if face.is_multiple_of(17) {
                    u32::MAX
                } else {
                    face % faces * 8
                }
            });
            prop::collection::vec((face, 0.1_f32..100.0), LANES)
        })
        .prop_map(|hits| {
            let mut nearest = Nearest::new();
            for (lane, (face, t)) in hits.into_iter().enumerate() {
                nearest.face[lane] = face;
                nearest.t[lane] = t;
            }
            nearest
        })
}

fn check(nearest: &Nearest, place: Place) -> Result<(), TestCaseError> {
    let mut groups = Groups::new();
    // What was there before does not matter.
    groups.collect(&Nearest::new(), place);
    groups.collect(nearest, place);
    let mut seen = [0; LANES];
    let mut faces = Vec::new();
    for (group, &Group { face, t, .. }) in groups.list.iter().enumerate() {
        faces.push(face);
        let depths = (0..LANES).filter(|&lane| nearest.face[lane] == face);
        let smallest = depths.map(|lane| nearest.t[lane]).fold(f32::INFINITY, f32::min);
        prop_assert_eq!(t, smallest, "of face {}", face);
        prop_assert!(groups.lanes(group).is_sorted());
        for &lane in groups.lanes(group) {
            prop_assert_eq!(nearest.face[usize::from(lane)], face);
            seen[usize::from(lane)] += 1;
        }
    }
    for (lane, times) in seen.into_iter().enumerate() {
        prop_assert_eq!(times, u32::from(place.wants(lane)), "lane {}", lane);
    }
    let first = |face: &u32| nearest.face.iter().position(|f| f == face).unwrap();
    prop_assert!(faces.iter().map(first).is_sorted_by(|a, b| a < b), "{:?}", faces);
    Ok(())
}

proptest! {
    #[test]
    fn each_wanted_ray_is_in_the_one_group_of_its_face(nearest in any_hits(), window in any_window()) {
        check(&nearest, place(window))?;
    }
}

#[test]
fn every_ray_may_meet_another_face() {
    let mut nearest = Nearest::new();
    for lane in 0..LANES {
        nearest.face[lane] = 1000 - lane as u32;
        nearest.t[lane] = lane as f32;
    }
    check(&nearest, place(WHOLE)).unwrap();
}

#[test]
fn all_rays_may_miss() {
    check(&Nearest::new(), place(WHOLE)).unwrap();
}

/// As many as fit keep the same place in the table of faces.
#[test]
fn faces_may_collide_in_the_table() {
    let inverse = (0..31).fold(1_u32, |x, _| {
        x.wrapping_mul(2_u32.wrapping_sub(0x9e37_79b1_u32.wrapping_mul(x)))
    });
    assert_eq!(inverse.wrapping_mul(0x9e37_79b1), 1);
    let mut nearest = Nearest::new();
    for lane in 0..LANES {
        nearest.face[lane] = (0xff80_0000 | lane as u32).wrapping_mul(inverse);
        nearest.t[lane] = 1.0;
    }
    check(&nearest, place(WHOLE)).unwrap();
}
