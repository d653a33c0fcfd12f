//! Wall segments, one-sided: grains stay on the left of a → b; ends act as points.
//!
//! Each segment is a face; each end is a corner, one for all segments that meet there. A corner
//! acts only on grains that no meeting segment faces, so a floor made of many segments is smooth
//! to a rolling grain. Where two segments turn left (a concave corner), both faces reach beyond
//! the corner, so a grain meets the next face before it is over it.

use crate::error::Error;
use crate::vector::{Vector, add, cross, dot, left, norm, scale, shortest_image, sub};

/// A wall from a to b \[m\]; solid on its right.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Segment {
    /// Start.
    pub a: Vector,
    /// End.
    pub b: Vector,
}

/// A segment seen by the grains.
#[derive(Debug, Clone)]
struct Face {
    middle: Vector,
    tangent: Vector,
    normal: Vector,
    half_length: f64,
    /// Reaches beyond its start and its end, which are concave corners.
    extended: [bool; 2],
}

/// An end of one or more segments.
#[derive(Debug, Clone)]
struct Corner {
    point: Vector,
    /// Unit vectors from the corner into the segments that meet there.
    inward: Vec<Vector>,
}

/// A grain near a wall.
#[derive(Debug, Clone, Copy)]
pub struct WallContact {
    /// Number of the face, or of the corner after all faces.
    pub feature: usize,
    /// Which periodic image, 4 is the nearest one.
    pub image: u8,
    /// From the wall to the grain.
    pub normal: Vector,
    /// Distance of the surfaces \[m\].
    pub gap: f64,
    /// How far a face reaches from here, backwards and forwards \[m\]; no end at concave corners.
    pub along: Option<[f64; 2]>,
}

/// All walls of a scene.
#[derive(Debug, Clone, Default)]
pub struct Walls {
    faces: Vec<Face>,
    corners: Vec<Corner>,
    period: [Option<f64>; 2],
}

/// Ends closer than this part of the longest segment are one corner.
const SAME_CORNER: f64 = 1e-9;

impl Walls {
    /// Prepare the walls.
    pub fn new(segments: &[Segment], period: [Option<f64>; 2]) -> Result<Walls, Error> {
        let mut walls = Walls {
            period,
            ..Walls::default()
        };
        for (number, segment) in segments.iter().enumerate() {
            let along = sub(segment.b, segment.a);
            let length = norm(along);
            if !(length.is_finite() && length > 0.0) {
                return Err(Error::Setup(format!(
                    "wall {number} from {:?} to {:?} has length {length}, must be positive and finite",
                    segment.a, segment.b
                )));
            }
            let tangent = scale(1.0 / length, along);
            walls.faces.push(Face {
                middle: scale(0.5, add(segment.a, segment.b)),
                tangent,
                normal: left(tangent),
                half_length: 0.5 * length,
                extended: [false; 2],
            });
        }
        walls.join(segments);
        Ok(walls)
    }

    /// How many faces and corners.
    pub fn feature_count(&self) -> usize {
        self.faces.len() + self.corners.len()
    }

    /// Find the corners and which of them are concave.
    fn join(&mut self, segments: &[Segment]) {
        let longest = self
            .faces
            .iter()
            .map(|face| 2.0 * face.half_length)
            .fold(0.0, f64::max);
        let mut end_corner = Vec::new();
        for (face, segment) in self.faces.iter().zip(segments) {
            for (point, inward) in [
                (segment.a, face.tangent),
                (segment.b, scale(-1.0, face.tangent)),
            ] {
                let known = self.corners.iter().position(|corner| {
                    norm(shortest_image(sub(point, corner.point), self.period))
                        < SAME_CORNER * longest
                });
                let corner = known.unwrap_or(self.corners.len());
                if known.is_none() {
                    self.corners.push(Corner {
                        point,
                        inward: Vec::new(),
                    });
                }
                self.corners[corner].inward.push(inward);
                end_corner.push(corner);
            }
        }
        for first in 0..self.faces.len() {
            for second in 0..self.faces.len() {
                let turn = cross(self.faces[first].tangent, self.faces[second].tangent);
                if end_corner[2 * first + 1] == end_corner[2 * second] && turn > SAME_CORNER {
                    self.faces[first].extended[1] = true;
                    self.faces[second].extended[0] = true;
                }
            }
        }
    }

    /// From a point to the nearest point of all walls \[m\]; infinite without walls.
    pub fn distance(&self, centre: Vector) -> f64 {
        let mut nearest = f64::INFINITY;
        for face in &self.faces {
            let offset = shortest_image(sub(centre, face.middle), self.period);
            self.each_image(offset, |offset, _| {
                let along = dot(offset, face.tangent).clamp(-face.half_length, face.half_length);
                nearest = nearest.min(norm(sub(offset, scale(along, face.tangent))));
            });
        }
        nearest
    }

    /// Call `visit` for every wall closer than `reach` to the surface of a grain.
    pub fn near(
        &self,
        centre: Vector,
        radius: f64,
        reach: f64,
        mut visit: impl FnMut(WallContact),
    ) {
        for (feature, face) in self.faces.iter().enumerate() {
            let nearest = shortest_image(sub(centre, face.middle), self.period);
            self.each_image(nearest, |offset, image| {
                let height = dot(offset, face.normal);
                if height < 0.0 || height - radius > reach {
                    return;
                }
                let place = dot(offset, face.tangent);
                let slack = 1e-9 * face.half_length;
                let left = [face.half_length + place, face.half_length - place];
                let beyond = |extended: bool| if extended { radius + reach } else { slack };
                if left[0] < -beyond(face.extended[0]) || left[1] < -beyond(face.extended[1]) {
                    return;
                }
                let open = |end: usize| {
                    if face.extended[end] {
                        f64::INFINITY
                    } else {
                        left[end]
                    }
                };
                let along = [open(0), open(1)];
                let gap = height - radius;
                visit(WallContact {
                    feature,
                    image,
                    normal: face.normal,
                    gap,
                    along: Some(along),
                });
            });
        }
        for (number, corner) in self.corners.iter().enumerate() {
            let feature = self.faces.len() + number;
            let nearest = shortest_image(sub(centre, corner.point), self.period);
            self.each_image(nearest, |offset, image| {
                let distance = norm(offset);
                if distance - radius > reach
                    || corner
                        .inward
                        .iter()
                        .any(|&inward| dot(offset, inward) >= 0.0)
                {
                    return;
                }
                let normal = scale(1.0 / distance, offset);
                visit(WallContact {
                    feature,
                    image,
                    normal,
                    gap: distance - radius,
                    along: None,
                });
            });
        }
    }

    /// The nearest image and, where the domain is periodic, those beside it.
    fn each_image(&self, nearest: Vector, mut visit: impl FnMut(Vector, u8)) {
        let range = |axis: usize| {
            if self.period[axis].is_some() {
                -1..=1i8
            } else {
                0..=0
            }
        };
        for kx in range(0) {
            for ky in range(1) {
                let shift = [
                    f64::from(kx) * self.period[0].unwrap_or(0.0),
                    f64::from(ky) * self.period[1].unwrap_or(0.0),
                ];
                visit(add(nearest, shift), image_code(kx, ky));
            }
        }
    }

    /// A grain whose centre lies a little behind a face has been placed in the solid.
    pub fn behind(&self, centre: Vector, radius: f64) -> Option<(usize, f64)> {
        self.faces.iter().enumerate().find_map(|(number, face)| {
            let offset = shortest_image(sub(centre, face.middle), self.period);
            let height = dot(offset, face.normal);
            let inside = dot(offset, face.tangent).abs() < face.half_length;
            (inside && height < 0.0 && height > -0.5 * radius).then_some((number, -height))
        })
    }
}

/// One number for a shift by −1, 0 or 1 period along x and y; 4 is none.
pub fn image_code(kx: i8, ky: i8) -> u8 {
    (3 * (kx + 1) + ky + 1) as u8
}
