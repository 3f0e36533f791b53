//! Vector algebra in float64, for the constants of the float32 kernel.

/// Three numbers: a point, a direction, or linear RGB.
pub type Vector = [f64; 3];

/// Scalar product.
#[inline(always)]
pub(crate) fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Vector product.
#[inline(always)]
pub(crate) fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// a - b
#[inline(always)]
pub(crate) fn sub(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// a + b
#[inline(always)]
pub(crate) fn add(a: Vector, b: Vector) -> Vector {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// s a
#[inline(always)]
pub(crate) fn scale(a: Vector, s: f64) -> Vector {
    [a[0] * s, a[1] * s, a[2] * s]
}

/// Euclidean length.
#[inline(always)]
pub(crate) fn length(a: Vector) -> f64 {
    dot(a, a).sqrt()
}

/// The unit vector of a vector of any length but 0.
pub(crate) fn normalized(a: Vector) -> Vector {
    let largest = largest(a);
    let scaled = a.map(|component| component / largest); // so that no square overflows or underflows
    let size = length(scaled);
    scaled.map(|component| component / size)
}

/// A unit vector at right angles to another.
pub(crate) fn perpendicular(a: Vector) -> Vector {
    let least = (0..3).fold(0, |least, i| if a[i].abs() < a[least].abs() { i } else { least });
    let mut other = [0.0; 3];
    other[least] = 1.0;
    normalized(cross(a, other))
}

/// The sum of the absolute components: between the length of the vector and twice that, without a root.
#[inline(always)]
pub(crate) fn l1_norm(vector: Vector) -> f64 {
    vector[0].abs() + vector[1].abs() + vector[2].abs()
}

/// The largest absolute component.
#[inline(always)]
pub(crate) fn largest(vector: Vector) -> f64 {
    vector.iter().fold(0.0, |a: f64, b| a.max(b.abs()))
}

/// The components in another frame, whose axes are the rows.
#[inline(always)]
pub(crate) fn rotate(rows: &[Vector; 3], a: Vector) -> Vector {
    [dot(rows[0], a), dot(rows[1], a), dot(rows[2], a)]
}

/// The same components in float32.
#[inline(always)]
pub(crate) fn to_f32(a: Vector) -> [f32; 3] {
    a.map(|component| component as f32)
}
