//! Vectors, computed in the order of `rtcli.scene.vectors`, to the same bits.

use rtcli_tracer::world::Vector;

/// Directions are parallel if the sine of the angle between them is not above this.
const LEAST_SINE: f64 = 1e-9;

/// Returns the unit vector, scaled first so that no square overflows or vanishes.
pub fn unit(vector: Vector) -> Vector {
    let largest = vector.iter().fold(0.0, |largest: f64, component| largest.max(component.abs()));
    let scaled = vector.map(|component| component / largest);
    let length = length(scaled);
    scaled.map(|component| component / length)
}

/// Returns the cross product.
pub fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Returns the opposite vector, with 0 for the opposite of 0.
pub fn negative(vector: Vector) -> Vector {
    vector.map(|component| 0.0 - component)
}

/// Returns the vector from start to end, or half of it where it would overflow.
pub fn direction(start: Vector, end: Vector) -> Vector {
    let difference = |scale: f64| [0, 1, 2].map(|axis| end[axis] / scale - start[axis] / scale);
    let whole = difference(1.0);
    if whole.iter().any(|component| component.is_infinite()) { difference(2.0) } else { whole }
}

/// Whether two vectors of any length but 0 point the same way, or opposite ways.
pub fn are_parallel(a: Vector, b: Vector) -> bool {
    length(cross(unit(a), unit(b))) <= LEAST_SINE
}

fn length([x, y, z]: Vector) -> f64 {
    (x * x + y * y + z * z).sqrt()
}
