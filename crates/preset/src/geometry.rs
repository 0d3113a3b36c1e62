//! Vectors in float64 for the checks of a preset.

/// A vector in float64.
pub(crate) type Vector = [f64; 3];

pub(crate) fn vector(v: [f32; 3]) -> Vector {
    v.map(f64::from)
}

pub(crate) fn difference(a: Vector, b: Vector) -> Vector {
    [0, 1, 2].map(|i| a[i] - b[i])
}

pub(crate) fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn length(a: Vector) -> f64 {
    dot(a, a).sqrt()
}

/// The vector of length 1; none where it has no direction.
pub(crate) fn unit(v: Vector) -> Option<Vector> {
    let length = length(v);
    (length > 0.0).then(|| v.map(|c| c / length))
}

/// The sine of the angle between two unit vectors, 0 to 1.
pub(crate) fn sine(a: Vector, b: Vector) -> f64 {
    length([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])
}
