use super::*;
use proptest::prelude::*;

fn view(width: u32, height: u32) -> View {
    View::centered(width, height, 0.01)
}

/// Check that the tiles of a window cover each of its pixels once, with the lane that belongs to it.
fn check(window: Window) -> Result<(), TestCaseError> {
    let mut covered = vec![0_u8; window.width as usize * window.height as usize];
    for tile in Tile::all(view(65535, 65535), window) {
        prop_assert_eq!((tile.corner.0 % SIDE, tile.corner.1 % SIDE), (0, 0));
        let mut wanted = [false; LANES];
        for Span { pixel, lane, count } in tile.spans() {
            prop_assert!(count > 0 && lane as u32 % SIDE + count as u32 <= SIDE);
            for i in 0..count {
                covered[pixel + i] += 1;
                wanted[lane + i] = true;
                let (x, y) = ((lane + i) as u32 % SIDE, (lane + i) as u32 / SIDE);
                let (column, row) = ((pixel + i) as u32 % window.width, (pixel + i) as u32 / window.width);
                prop_assert_eq!(tile.corner.0 + x, window.x + column);
                prop_assert_eq!(tile.corner.1 + y, window.y + row);
            }
        }
        for (lane, wanted) in wanted.into_iter().enumerate() {
            prop_assert_eq!(tile.wants(lane), wanted, "lane {}", lane);
        }
        prop_assert_eq!(tile.is_whole(), wanted == [true; LANES]);
    }
    prop_assert!(covered.iter().all(|&times| times == 1));
    Ok(())
}

proptest! {
    #[test]
    fn the_blocks_of_a_window_cover_each_pixel_once(
        x in 0_u32..200, y in 0_u32..200, width in 1_u32..100, height in 1_u32..100
    ) {
        check(Window { x, y, width, height })?;
    }
}

#[test]
fn windows_may_be_one_pixel_or_the_widest_picture() {
    for (x, y, width, height) in [
        (0, 0, 1, 1),
        (65534, 65534, 1, 1),
        (0, 65530, 65535, 5),
        (65530, 0, 5, 65535),
        (15, 15, 2, 2),
        (16, 16, 16, 16),
    ] {
        check(Window { x, y, width, height }).unwrap();
    }
}

#[test]
fn half_a_pixel_is_the_tangent_of_half_the_view_over_the_height() {
    let camera = Camera::along_z(7, 10, 90.0);
    let view = View::new(&camera, 1.0);
    assert_eq!((view.width, view.height), (7, 10));
    assert!((view.half_pixel.0 - 0.1).abs() < 1e-16);
    assert_eq!(view.half_pixel.0, view.half_pixel.1);
    let grid = View::in_grid(&camera, 1.0, 5);
    assert_eq!((grid.width, grid.height), (5, 5));
    assert!((grid.half_pixel.0 - 0.14).abs() < 1e-16);
    assert!((grid.half_pixel.1 - 0.2).abs() < 1e-16);
}

#[test]
fn a_picture_off_the_view_has_its_middle_there_whatever_its_grid() {
    let camera = Camera { center: (3.0, -2.0), pixel_aspect: 0.5, ..Camera::along_z(6, 4, 90.0) };
    for view in [View::new(&camera, 1.0), View::in_grid(&camera, 1.0, 8)] {
        let mut rays = crate::tile::rays::Rays::new();
        rays.generate(view, (0, 0), CENTRE);
        // Half the width of 6 pixels is 1.5 of the half height of 4, times the pixel aspect.
        assert_eq!(rays.middle, [3.0, -2.0, 1.0]);
        assert!((rays.half_size.0 - 0.75).abs() < 1e-15 && (rays.half_size.1 - 1.0).abs() < 1e-15);
    }
}
