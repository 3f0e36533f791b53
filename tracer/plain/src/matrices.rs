//! The focal lengths of a camera, and its matrices in metadata and labels.

use rtcli_reader::json::{write_number, write_numbers};
use rtcli_tracer::world::{Camera, Projection, Vector, Window};

use crate::vector::negative;

/// Keeps the focal length of the narrowest field of view finite, as in `rtcli.tracer.world`.
const SMALLEST: f64 = 1e-300;

/// Returns the focal lengths of a camera in pixels, and the principal point in pixels from the left and top edge; of an
/// orthographic camera, the former are pixels per unit of the world.
///
/// f_y = height / (2 half_height), f_x = f_y / pixel_aspect
pub fn intrinsics(camera: &Camera) -> ([f64; 2], [f64; 2]) {
    let (width, height) = (f64::from(camera.width), f64::from(camera.height));
    let focal = height / (2.0 * camera.half_height).max(SMALLEST);
    let [focal_x, focal_y] = [focal / camera.pixel_aspect, focal];
    let (x, y) = camera.center;
    ([focal_x, focal_y], [width / 2.0 - x * focal_x, height / 2.0 + y * focal_y])
}

/// Returns a camera as matrices in JSON, for the pixels of a window; `rtcli.rendering.metadata` has the equations.
pub fn camera_matrices(camera: &Camera, window: Window) -> String {
    let ([focal_x, focal_y], [principal_x, principal_y]) = intrinsics(camera);
    let (left, top) = (f64::from(window.x), f64::from(window.y));
    let (width, height) = (f64::from(window.width), f64::from(window.height));
    let Camera { right, up, forward, mut position, .. } = *camera;
    let mut json = format!(r#"{{"resolution":[{},{}],"projection":""#, window.width, window.height);
    match camera.projection {
        Projection::Orthographic => {
            let x = (left + width / 2.0 - principal_x) / focal_x;
            let y = (principal_y - top - height / 2.0) / focal_y;
            position = [0, 1, 2].map(|axis| position[axis] + right[axis] * x + up[axis] * y);
            json.push_str(r#"orthographic","height":"#);
            write_number(height / focal_y, &mut json);
        }
        Projection::Perspective => {
            let (center_x, center_y) = (principal_x - 0.5 - left, principal_y - 0.5 - top);
            json.push_str(r#"perspective","intrinsics":"#);
            let rows = [[focal_x, 0.0, center_x], [0.0, focal_y, center_y], [0.0, 0.0, 1.0]];
            write_matrix(&rows, &mut json);
        }
    }
    for (name, axes) in [("opencv", [right, negative(up), forward]), ("opengl", [right, up, negative(forward)])] {
        json.extend([",\"", name, "\":"]);
        write_extrinsics(axes, position, &mut json);
    }
    json.push('}');
    json
}

/// Writes x' = A (x - eye), the axes as rows of A, and x = A^T x' + eye.
fn write_extrinsics(axes: [Vector; 3], eye: Vector, json: &mut String) {
    let last = [0.0, 0.0, 0.0, 1.0];
    let to_camera = axes.map(|[x, y, z]| [x, y, z, -(0.0 + x * eye[0] + y * eye[1] + z * eye[2]) + 0.0]);
    let to_world = [0, 1, 2].map(|row| [axes[0][row], axes[1][row], axes[2][row], eye[row]]);
    for (name, [a, b, c]) in [("{\"world_to_camera\":", to_camera), (",\"camera_to_world\":", to_world)] {
        json.push_str(name);
        write_matrix(&[a, b, c, last], json);
    }
    json.push('}');
}

fn write_matrix<const N: usize>(rows: &[[f64; N]], json: &mut String) {
    for (place, row) in rows.iter().enumerate() {
        json.push(if place == 0 { '[' } else { ',' });
        write_numbers(row, ",", json);
    }
    json.push(']');
}

#[cfg(test)]
mod tests {
    use rtcli_tracer::world::{Camera, Projection, Window};

    use super::{camera_matrices, intrinsics};

    fn camera(projection: Projection) -> Camera {
        Camera {
            width: 4,
            height: 2,
            projection,
            half_height: 0.5,
            pixel_aspect: 2.0,
            center: (0.5, 0.25),
            position: [1.0, 2.0, 3.0],
            right: [1.0, 0.0, 0.0],
            up: [0.0, 1.0, 0.0],
            forward: [0.0, 0.0, -1.0],
        }
    }

    #[test]
    fn focal_lengths_are_in_pixels() {
        assert_eq!(intrinsics(&camera(Projection::Perspective)), ([1.0, 2.0], [1.5, 1.5]));
        let narrow = Camera { half_height: 0.0, ..camera(Projection::Perspective) };
        assert!(intrinsics(&narrow).0[1].is_finite());
    }

    #[test]
    fn a_window_moves_the_principal_point_or_the_position() {
        let window = Window { x: 1, y: 0, width: 2, height: 2 };
        let json = camera_matrices(&camera(Projection::Perspective), window);
        let start = r#"{"resolution":[2,2],"projection":"perspective","intrinsics":[[1.0,0.0,0.0],[0.0,2.0,1.0],"#;
        assert!(json.starts_with(start), "{json}");
        let json = camera_matrices(&camera(Projection::Orthographic), window);
        let start =
            r#"{"resolution":[2,2],"projection":"orthographic","height":1.0,"opencv":{"world_to_camera":[["#;
        assert!(json.starts_with(start), "{json}");
        let end =
            r#""camera_to_world":[[1.0,0.0,0.0,1.5],[0.0,1.0,0.0,2.25],[0.0,0.0,1.0,3.0],[0.0,0.0,0.0,1.0]]}}"#;
        assert!(json.ends_with(end), "{json}");
    }
}
