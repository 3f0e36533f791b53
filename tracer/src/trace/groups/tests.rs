use super::*;
use crate::tile::{SIDE, View};
use crate::world::Window;
use proptest::prelude::*;

/// A tile in the corner of a picture, with a window.
fn tile(window: Window) -> Tile {
    let view = View::centered(100, 100, 0.01);
    Tile { view, corner: (SIDE, SIDE), window }
}

const WHOLE: Window = Window { x: 0, y: 0, width: 100, height: 100 };

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

/// What a tile meets: anything from one face to a different one for each ray.
fn any_hits() -> impl Strategy<Value = HitBuffer> {
    let faces = prop_oneof![1_u32..4, 4_u32..256, Just(1 << 29)];
    faces
        .prop_flat_map(|faces| {
            let face = any::<u32>().prop_map(
                move |face| {
                    if face.is_multiple_of(17) { u32::MAX } else { face % faces * 8 }
                },
            );
            prop::collection::vec((face, 0.1_f32..100.0), LANES)
        })
        .prop_map(|hits| {
            let mut buffer = HitBuffer::new();
            for (lane, (face, t)) in hits.into_iter().enumerate() {
                buffer.face[lane] = face;
                buffer.t[lane] = t;
            }
            buffer
        })
}

fn check(hits: &HitBuffer, tile: Tile) -> Result<(), TestCaseError> {
    let mut groups = Groups::new();
    // What was there before does not matter.
    groups.collect(&HitBuffer::new(), tile);
    groups.collect(hits, tile);
    let mut seen = [0; LANES];
    let mut faces = Vec::new();
    for (group, &Group { face, t, .. }) in groups.list.iter().enumerate() {
        faces.push(face);
        let depths = (0..LANES).filter(|&lane| hits.face[lane] == face);
        let smallest = depths.map(|lane| hits.t[lane]).fold(f32::INFINITY, f32::min);
        prop_assert_eq!(t, smallest, "of face {}", face);
        prop_assert!(groups.lanes(group).is_sorted());
        for &lane in groups.lanes(group) {
            prop_assert_eq!(hits.face[usize::from(lane)], face);
            seen[usize::from(lane)] += 1;
        }
    }
    for (lane, times) in seen.into_iter().enumerate() {
        prop_assert_eq!(times, u32::from(tile.wants(lane)), "lane {}", lane);
    }
    let first = |face: &u32| hits.face.iter().position(|f| f == face).unwrap();
    prop_assert!(faces.iter().map(first).is_sorted_by(|a, b| a < b), "{:?}", faces);
    Ok(())
}

proptest! {
    #[test]
    fn each_wanted_ray_is_in_the_one_group_of_its_face(hits in any_hits(), window in any_window()) {
        check(&hits, tile(window))?;
    }
}

#[test]
fn every_ray_may_meet_another_face() {
    let mut hits = HitBuffer::new();
    for lane in 0..LANES {
        hits.face[lane] = 1000 - lane as u32;
        hits.t[lane] = lane as f32;
    }
    check(&hits, tile(WHOLE)).unwrap();
}

#[test]
fn all_rays_may_miss() {
    check(&HitBuffer::new(), tile(WHOLE)).unwrap();
}

/// As many as fit keep the same index in the table of faces.
#[test]
fn faces_may_collide_in_the_table() {
    let inverse = (0..31).fold(1_u32, |x, _| x.wrapping_mul(2_u32.wrapping_sub(0x9e37_79b1_u32.wrapping_mul(x))));
    assert_eq!(inverse.wrapping_mul(0x9e37_79b1), 1);
    let mut hits = HitBuffer::new();
    for lane in 0..LANES {
        hits.face[lane] = (0xff80_0000 | lane as u32).wrapping_mul(inverse);
        hits.t[lane] = 1.0;
    }
    check(&hits, tile(WHOLE)).unwrap();
}
