//! What the particle engine needs to know.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::door::{dimension, fits};

/// What the particle engine needs to know.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ParticleScene {
    /// Dimension of the space: 2 or 3; every vector has as many numbers.
    pub dimension: usize,
    /// g \[m/s²\]; the engine applies the full weight m g.
    pub gravity: Vec<f64>,
    /// Walls; grains stay on the side that the facet looks to, and off its rim.
    pub walls: Vec<Wall>,
    /// Period along each axis \[m\], where the domain is periodic.
    pub period: Vec<Option<f64>>,
    /// Coulomb coefficient between grains.
    pub friction: f64,
    /// Coulomb coefficient between grains and walls.
    pub wall_friction: f64,
    /// Moment of inertia over m r²: 1/2 for disks, 2/5 for spheres.
    pub inertia_factor: f64,
    /// Contact residual (natural map) at which a solve stops, relative to |g|Δt.
    pub tolerance: f64,
    /// Sweeps allowed; more is an error.
    pub sweeps_max: usize,
    /// Sub-steps allowed in a coupling step; more is an error.
    pub sub_steps_max: u32,
    /// Threads the engine may use.
    pub threads: usize,
    /// How the built-in engine solves contacts; none: as the state of the grains suggests.
    #[serde(default)]
    pub solver: Option<ContactSolver>,
}

/// How contacts are solved.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ContactSolver {
    /// Many sub-steps with one relaxed sweep each.
    SmallSteps,
    /// Sweeps until the laws of contact hold to the tolerance.
    Converged,
}

impl ParticleScene {
    /// Do all vectors have as many numbers as the space has dimensions, and walls as many corners? An
    /// error names what has not.
    pub fn check(&self) -> Result<(), String> {
        let d = dimension(self.dimension)?;
        fits(d, "gravity", &self.gravity)?;
        fits(d, "period", &self.period)?;
        for (number, wall) in self.walls.iter().enumerate() {
            let corners = wall.corners.len();
            if corners != d {
                return Err(format!(
                    "wall {number} has {corners} corners, must have {d}"
                ));
            }
            let what = format!("a corner of wall {number}");
            for corner in &wall.corners {
                fits(d, &what, corner)?;
            }
            let what = format!("the velocity of wall {number}");
            wall.velocity.iter().try_for_each(|v| fits(d, &what, v))?;
        }
        Ok(())
    }
}

/// A flat wall with as many corners as the space has dimensions: a segment in the plane, a triangle in
/// space. Grains are on the left of the way from the first corner to the second, in space on the side from
/// which its corners are seen clockwise.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Wall {
    /// Corners \[m\].
    pub corners: Vec<Vec<f64>>,
    /// Velocity along itself \[m/s\], which rubs on the grains; none: it rests. Where it is does not change.
    #[serde(default)]
    pub velocity: Option<Vec<f64>>,
}

impl Wall {
    /// The wall with these corners, which may move along itself.
    pub fn of<const D: usize>(corners: &[[f64; D]; D], velocity: Option<[f64; D]>) -> Wall {
        Wall {
            corners: corners.iter().map(|corner| corner.to_vec()).collect(),
            velocity: velocity.map(Vec::from),
        }
    }

    /// The segment from `a` to `b`, a wall in the plane.
    pub fn segment(a: [f64; 2], b: [f64; 2]) -> Wall {
        Wall::of(&[a, b], None)
    }

    /// From a point to the nearest point of the wall \[m\].
    pub fn distance(&self, point: &[f64]) -> f64 {
        let [a, b, c] = match &self.corners[..] {
            [a, b] => return to_segment(point, a, b),
            [a, b, c] => [a, b, c],
            _ => return f64::NAN,
        };
        if let Some(height) = to_plane(point, a, b, c) {
            return height;
        }
        let rim = [(a, b), (b, c), (c, a)].map(|(from, to)| to_segment(point, from, to));
        rim.into_iter().fold(f64::INFINITY, f64::min)
    }
}

fn between(from: &[f64], to: &[f64]) -> Vec<f64> {
    to.iter().zip(from).map(|(to, from)| to - from).collect()
}

/// Summed in the order of the components.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let products = a.iter().zip(b).map(|(a, b)| a * b);
    products.reduce(|sum, next| sum + next).unwrap_or(0.0)
}

fn to_segment(point: &[f64], a: &[f64], b: &[f64]) -> f64 {
    let (way, away) = (between(a, b), between(a, point));
    let along = (dot(&away, &way) / dot(&way, &way)).clamp(0.0, 1.0);
    let rest = away.iter().zip(&way).map(|(away, way)| away - along * way);
    rest.fold(0.0, f64::hypot)
}

/// Height over the plane of a triangle in space, where its foot lies within the triangle.
fn to_plane(point: &[f64], a: &[f64], b: &[f64], c: &[f64]) -> Option<f64> {
    let (u, v, away) = (between(a, b), between(a, c), between(a, point));
    let (uu, uv, vv) = (dot(&u, &u), dot(&u, &v), dot(&v, &v));
    let (du, dv) = (dot(&away, &u), dot(&away, &v));
    let scale = uu * vv - uv * uv;
    let (s, t) = ((du * vv - dv * uv) / scale, (dv * uu - du * uv) / scale);
    let within = s >= 0.0 && t >= 0.0 && s + t <= 1.0;
    let foot = u.iter().zip(&v).map(|(u, v)| s * u + t * v);
    let rest = away.iter().zip(foot).map(|(away, foot)| away - foot);
    within.then(|| rest.fold(0.0, f64::hypot))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_to_a_segment_and_to_a_triangle() {
        let segment = Wall::segment([0.0, 0.0], [4.0, 0.0]);
        assert_eq!(segment.distance(&[1.0, -2.0]), 2.0);
        assert_eq!(segment.distance(&[7.0, 4.0]), 5.0);
        let triangle = Wall {
            corners: vec![
                vec![0.0, 0.0, 1.0],
                vec![4.0, 0.0, 1.0],
                vec![0.0, 4.0, 1.0],
            ],
            velocity: None,
        };
        assert_eq!(triangle.distance(&[1.0, 1.0, 3.0]), 2.0);
        assert_eq!(triangle.distance(&[1.0, -3.0, 5.0]), 5.0);
        assert_eq!(triangle.distance(&[0.0, 0.0, 1.0]), 0.0);
        // A point of a plane is on it to round-off, not to its root.
        let third = [-0.1, 0.4, 0.3].map(|x| x / 3.0);
        let oblique = Wall::of(&[[-0.1, 0.1, 0.0], [0.2, 0.0, 0.1], [-0.2, 0.3, 0.2]], None);
        assert!(oblique.distance(&third) < 1e-16);
    }
}
