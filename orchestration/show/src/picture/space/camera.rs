//! Where a point of space is seen.

use crate::simplices::{Corners, Point, cross, length};

/// How far to the right of the z axis the camera stands \[rad\].
const AZIMUTH: f64 = 0.5;
/// How far above the level \[rad\].
const ELEVATION: f64 = 0.33;
/// Its distance from the middle of what it looks at, in half diagonals of that.
const DISTANCE: f64 = 5.0;

/// Looks at the middle of a box, from in front of it (+z), right of it (+x) and slightly above (+y).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    eye: Point<3>,
    right: Point<3>,
    up: Point<3>,
    ahead: Point<3>,
}

impl Camera {
    /// The camera of a box.
    pub fn of((low, high): Corners<3>) -> Camera {
        let toward = [
            AZIMUTH.sin() * ELEVATION.cos(),
            ELEVATION.sin(),
            AZIMUTH.cos() * ELEVATION.cos(),
        ];
        let half: Point<3> = std::array::from_fn(|axis| 0.5 * (high[axis] - low[axis]));
        let distance = DISTANCE * length(half);
        let eye = std::array::from_fn(|axis| low[axis] + half[axis] + distance * toward[axis]);
        let right = [AZIMUTH.cos(), 0.0, -AZIMUTH.sin()];
        Camera {
            eye,
            right,
            up: cross(toward, right),
            ahead: toward.map(|x| -x),
        }
    }

    /// A point as the camera has it \[m\]: to its right, above it, before it.
    pub fn see(&self, point: Point<3>) -> Point<3> {
        let from_eye: Point<3> = std::array::from_fn(|axis| point[axis] - self.eye[axis]);
        [self.right, self.up, self.ahead].map(|axis| dot(axis, from_eye))
    }
}

fn dot(a: Point<3>, b: Point<3>) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
