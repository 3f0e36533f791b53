use super::*;
use crate::oracle::*;
use crate::shapes::cuboid::Cuboid;
use crate::shapes::plane::Plane;
use crate::vector::{add, length, perpendicular, scale};
use proptest::prelude::*;

/// A point on the surface of a shape: on a face, or an edge or corner.
fn any_point_on(shape: &OracleShape, direction: Vector, shares: Vector, fixed: [bool; 3]) -> Vector {
    match *shape {
        OracleShape::Sphere { center, radius } => add(center, scale(direction, radius)),
        OracleShape::Plane { .. } => unreachable!(),
        OracleShape::Box { center, axes, half } => {
            let fixed = if fixed.contains(&true) { fixed } else { [false, true, false] };
            let along = |i: usize| half[i] * if fixed[i] { shares[i].signum() } else { shares[i] };
            (0..3).fold(center, |point, i| add(point, scale(axes[i], along(i))))
        }
        OracleShape::Frustum { center, axis, radii, half } => {
            let z = half * if fixed[0] { shares[0].signum() } else { shares[0] };
            let radius = radii[0] + (radii[1] - radii[0]) * (z + half) / (2.0 * half);
            let away = radius * if fixed[0] && fixed[1] { shares[1].abs() } else { 1.0 };
            add(center, add(scale(axis, z), scale(across(axis, direction), away)))
        }
        OracleShape::Capsule { center, axis, radius, half } => {
            let aside = across(axis, direction);
            let (z, way) = if fixed[0] {
                let end = shares[0].signum();
                let along = scale(axis, end * dot(axis, direction).abs());
                (half * end, add(along, scale(aside, (1.0 - dot(along, along)).sqrt())))
            } else {
                (half * shares[0], aside)
            };
            add(center, add(scale(axis, z), scale(way, radius)))
        }
    }
}

/// A unit vector at right angles to an axis, in the plane of a direction.
fn across(axis: Vector, direction: Vector) -> Vector {
    let aside = sub(direction, scale(axis, dot(axis, direction)));
    if length(aside) > 1e-3 { scale(aside, 1.0 / length(aside)) } else { perpendicular(axis) }
}

proptest! {
    #[test]
    fn places_on_a_surface_are_on_it_wherever_it_is(
        shape in any_tile().prop_flat_map(|tile| shape_before(tile, -1.0..5.0)),
        direction in any_direction(),
        shares in [-1.0..1.0, -1.0..1.0, -1.0..1.0],
        fixed in any::<[bool; 3]>(),
    ) {
        let point = any_point_on(&shape, direction, shares, fixed);
        prop_assert_eq!(shape.contact(point).side, Side::On);
    }

    #[test]
    fn places_off_a_surface_are_inside_or_outside(
        shape in any_tile().prop_flat_map(|tile| shape_before(tile, -1.0..1.0)),
        direction in any_direction(),
        shares in [-1.0..1.0, -1.0..1.0, -1.0..1.0],
    ) {
        let point = any_point_on(&shape, direction, shares, [false, true, false]);
        for (share, side) in [(1e-11, Side::Outside), (-1e-11, Side::Inside)] {
            let outward = sub(point, shape.center());
            prop_assert_eq!(shape.contact(add(point, scale(outward, share))).side, side);
        }
    }
}

#[test]
fn a_place_on_an_edge_has_the_coordinates_of_both_faces() {
    let third = 1.0 / 3.0;
    let axes = [[0.6, 0.0, -0.8], [0.0, 1.0, 0.0], [0.8, 0.0, 0.6]];
    let half = [third, 2.0 * third, 5.0];
    let center = [1e3, -2e3, 7.7];
    let point = add(center, add(scale(axes[0], third), scale(axes[1], -2.0 * third)));
    let contact = Cuboid::contact(point, center, &axes, half);
    assert_eq!(contact.side, Side::On);
    assert_eq!(contact.local[..2], [third, -2.0 * third]);
}

#[test]
fn a_place_in_the_plane_of_a_face_beside_it_is_outside() {
    let straight = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let contact = Cuboid::contact([5.0, 1.0, 0.0], [0.0; 3], &straight, [1.0; 3]);
    assert_eq!((contact.side, contact.local), (Side::Outside, [5.0, 1.0, 0.0]));
}

#[test]
fn a_plane_given_by_a_far_point_is_where_it_is() {
    for away in [1e10, 1e15, 1e22] {
        let contact = |height| Plane::contact([0.0, height, 0.0], [away, 0.0, -away], [0.0, 1.0, 0.0]);
        assert_eq!(contact(1e-9).side, Side::Outside);
        assert_eq!(contact(0.0).side, Side::On);
        assert_eq!(contact(-1e-9).side, Side::Inside);
    }
}
