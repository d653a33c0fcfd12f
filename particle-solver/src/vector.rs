//! Vectors of the plane, as arrays.

/// A point \[m\] or a vector of the plane.
pub type Vector = [f64; 2];

/// a + b
pub fn add(a: Vector, b: Vector) -> Vector {
    [a[0] + b[0], a[1] + b[1]]
}

/// a − b
pub fn sub(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1]]
}

/// s a
pub fn scale(s: f64, a: Vector) -> Vector {
    [s * a[0], s * a[1]]
}

/// a·b
pub fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

/// a × b, positive when b lies to the left of a.
pub fn cross(a: Vector, b: Vector) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

/// |a|, without `hypot`: lengths here are far from the ends of the range.
pub fn norm(a: Vector) -> f64 {
    dot(a, a).sqrt()
}

/// a turned by a quarter to the left.
pub fn left(a: Vector) -> Vector {
    [-a[1], a[0]]
}

/// The shortest of the periodic images of `a`.
pub fn shortest_image(a: Vector, period: [Option<f64>; 2]) -> Vector {
    let mut image = a;
    for axis in 0..2 {
        if let Some(length) = period[axis] {
            image[axis] -= length * (image[axis] / length).round();
        }
    }
    image
}
