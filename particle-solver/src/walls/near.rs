//! Which walls a grain may touch.
//!
//! A ridge acts only on grains that no meeting facet faces, so a floor made of many facets is smooth
//! to a rolling grain. Where two facets meet in a concave corner, both reach beyond it, so a grain
//! meets the next face before it is over it; but no farther than over faces that rise one from the other
//! (`concave`), or they would stick out where the wall turns away.

use space::periodic::{Image, each_image, shifted, shortest_image};
use space::{Dim, Dimension, Period, Vector, dot, norm};

use crate::error::Error;
use crate::walls::concave::beyond;
use crate::walls::facet::{Face, Facet, middle, side_of};
use crate::walls::grounds::Grounds;
use crate::walls::ridge::{Ridge, SAME};

/// A grain near a wall.
#[derive(Debug, Clone, Copy)]
pub struct WallContact<'a, const D: usize> {
    /// Number of the face, or of the ridge after all faces.
    pub feature: usize,
    /// Which periodic image.
    pub image: Image,
    /// From the wall to the grain.
    pub normal: Vector<D>,
    /// Distance of the surfaces \[m\].
    pub gap: f64,
    /// Where over a face the grain is; none of a ridge.
    pub over: Option<Over<'a, D>>,
}

/// The place of a grain over a face.
#[derive(Debug, Clone, Copy)]
pub struct Over<'a, const D: usize> {
    face: &'a Face<D>,
    /// To each side \[m\].
    left: [f64; D],
}

impl<const D: usize> Over<'_, D> {
    /// Does this displacement lead over a side at which the wall ends? It has no end at concave ones.
    pub fn leaves(&self, moved: &Vector<D>) -> bool {
        let sides = self.face.sides.iter().zip(self.left);
        sides
            .filter(|(side, _)| side.extended.is_none())
            .any(|(side, left)| -dot(moved, &side.inward) > left)
    }
}

/// All walls of a scene.
#[derive(Debug, Clone)]
pub struct Walls<const D: usize> {
    faces: Vec<Face<D>>,
    ridges: Vec<Ridge<D>>,
    grounds: Grounds<D>,
    period: Period<D>,
    /// How far faces reach beyond their corners where they reach 1 beyond their sides.
    spread: f64,
}

impl<const D: usize> Walls<D>
where
    Dim<D>: Dimension<D>,
{
    /// Prepare the walls.
    pub fn new(facets: &[Facet<D>], period: &Period<D>) -> Result<Walls<D>, Error> {
        let mut faces = Vec::with_capacity(facets.len());
        for (number, facet) in facets.iter().enumerate() {
            let face = Face::new(facet).map_err(|size| {
                let corners = facet.corners.map(<[f64; D]>::from);
                Error::Setup(format!(
                    "wall {number} with corners {corners:?} has size {size}, must be positive and finite"
                ))
            })?;
            if !face.moves_along() {
                let velocity = facet.velocity.as_slice();
                return Err(Error::Setup(format!(
                    "wall {number} moves at {velocity:?} m/s, which is not along it"
                )));
            }
            faces.push(face);
        }
        let spread = faces.iter().map(Face::spread).fold(1.0, f64::max);
        let mut walls = Walls {
            faces,
            ridges: Vec::new(),
            grounds: Grounds::default(),
            period: *period,
            spread,
        };
        walls.join(facets);
        walls.tell_grounds(facets);
        Ok(walls)
    }

    /// How many faces and ridges.
    pub fn feature_count(&self) -> usize {
        self.faces.len() + self.ridges.len()
    }

    /// Find the ridges, and at which sides the wall goes on towards the grains.
    fn join(&mut self, facets: &[Facet<D>]) {
        let sides = self.faces.iter().flat_map(|face| &face.sides);
        let largest = sides.map(|side| 2.0 * side.distance).fold(0.0, f64::max);
        let tolerance = SAME * largest;
        let mut ridge_of_side = Vec::new();
        for (number, facet) in facets.iter().enumerate() {
            for k in 0..D {
                let inward = self.faces[number].sides[k].inward;
                let ends = side_of(&facet.corners, k);
                ridge_of_side.push(self.add_ridge(&ends, number, inward, tolerance));
            }
        }
        self.extend_concave_sides(&ridge_of_side);
        for (number, facet) in facets.iter().enumerate() {
            for &[k, l] in Dim::<D>::FACET_EDGES {
                let edge = facet.corners[l] - facet.corners[k];
                let unit = edge * (1.0 / norm(&edge));
                self.add_ridge(&[facet.corners[k]], number, unit, tolerance);
                self.add_ridge(&[facet.corners[l]], number, -unit, tolerance);
            }
        }
    }

    /// What a grain rubs on: a face at its velocity, a ridge at the mean of the faces that meet there.
    fn tell_grounds(&mut self, facets: &[Facet<D>]) {
        let velocities = facets.iter().map(|facet| facet.velocity);
        let mut of_feature: Vec<Vector<D>> = velocities.collect();
        for ridge in &self.ridges {
            let meeting: Vec<Vector<D>> = ridge.faces.iter().map(|&f| of_feature[f]).collect();
            let same = meeting.iter().all(|velocity| *velocity == meeting[0]);
            of_feature.push(if same { meeting[0] } else { middle(&meeting) });
        }
        self.grounds = Grounds::new(&of_feature);
    }

    /// What grains rub on.
    pub fn grounds(&self) -> &Grounds<D> {
        &self.grounds
    }

    /// Number of the ridge with these ends, a new one if there was none.
    fn add_ridge(
        &mut self,
        ends: &[Vector<D>],
        face: usize,
        inward: Vector<D>,
        tolerance: f64,
    ) -> usize {
        let ridge = Ridge::new(ends);
        let is = |old: &Ridge<D>| old.is(&ridge, &self.period, tolerance);
        let number = self.ridges.iter().position(is).unwrap_or_else(|| {
            self.ridges.push(ridge);
            self.ridges.len() - 1
        });
        self.ridges[number].inward.push(inward);
        self.ridges[number].faces.push(face);
        number
    }

    /// A side is concave where another facet of the same orientation rises from it.
    fn extend_concave_sides(&mut self, ridge_of_side: &[usize]) {
        let rises = |from: &Face<D>, to: &Face<D>, side: usize| {
            dot(&from.normal, &to.sides[side].inward) > SAME
        };
        let mut rising = vec![Vec::new(); ridge_of_side.len()];
        for (place, ridge) in ridge_of_side.iter().enumerate() {
            let (first, k) = (place / D, place % D);
            for (other, _) in ridge_of_side
                .iter()
                .enumerate()
                .filter(|(_, o)| *o == ridge)
            {
                let (second, l) = (other / D, other % D);
                let (one, two) = (&self.faces[first], &self.faces[second]);
                if rises(one, two, l) && rises(two, one, k) {
                    rising[place].push(second);
                }
            }
        }
        let periodic = self.period.iter().any(Option::is_some);
        for place in 0..rising.len() {
            let beyond = match periodic {
                _ if rising[place].is_empty() => continue,
                true => f64::INFINITY,
                false => beyond(&self.faces, &rising, place),
            };
            self.faces[place / D].sides[place % D].extended = Some(beyond);
        }
    }

    /// From a point to the nearest point of all walls \[m\]; infinite without walls.
    pub fn distance(&self, centre: &Vector<D>) -> f64 {
        let mut nearest = f64::INFINITY;
        for face in &self.faces {
            self.each_offset(centre, &face.middle, |offset, _| {
                if norm(&offset) - face.extent < nearest {
                    nearest = nearest.min(face.distance(&offset));
                }
            });
        }
        nearest
    }

    /// How far from all walls a grain may be \[m\] that is within `reach` of a face: a face reaches
    /// beyond its end by as much as the grain does.
    pub fn reach_of_faces(&self, reach: f64) -> f64 {
        (1.0 + self.spread * self.spread).sqrt() * reach
    }

    /// Call `visit` for every wall closer than `reach` to the surface of a grain.
    pub fn near(
        &self,
        centre: &Vector<D>,
        radius: f64,
        reach: f64,
        mut visit: impl FnMut(WallContact<'_, D>),
    ) {
        for (feature, face) in self.faces.iter().enumerate() {
            self.each_offset(centre, &face.middle, |offset, image| {
                if let Some((gap, over)) = face_near(face, &offset, radius, reach) {
                    visit(WallContact {
                        feature,
                        image,
                        normal: face.normal,
                        gap,
                        over: Some(over),
                    });
                }
            });
        }
        for (number, ridge) in self.ridges.iter().enumerate() {
            self.each_offset(centre, &ridge.middle, |offset, image| {
                if let Some((gap, normal)) = ridge_near(ridge, &offset, radius, reach) {
                    visit(WallContact {
                        feature: self.faces.len() + number,
                        image,
                        normal,
                        gap,
                        over: None,
                    });
                }
            });
        }
    }

    /// Call `visit` with number, offset and image of every face and ridge within `reach` \[m\] of a point, over which
    /// it may or may not be.
    pub fn around(
        &self,
        centre: &Vector<D>,
        reach: f64,
        mut visit: impl FnMut(usize, Vector<D>, Image),
    ) {
        let of_faces = self.reach_of_faces(reach);
        for (number, face) in self.faces.iter().enumerate() {
            self.each_offset(centre, &face.middle, |offset, image| {
                if norm(&offset) - face.extent < of_faces && face.distance(&offset) < of_faces {
                    visit(number, offset, image);
                }
            });
        }
        for (number, ridge) in self.ridges.iter().enumerate() {
            self.each_offset(centre, &ridge.middle, |offset, image| {
                if ridge.distance(&offset) < reach {
                    visit(self.faces.len() + number, offset, image);
                }
            });
        }
    }

    /// Middle of a face or ridge, of which an offset is counted \[m\].
    #[inline]
    pub fn middle(&self, feature: usize) -> &Vector<D> {
        match self.faces.get(feature) {
            Some(face) => &face.middle,
            None => &self.ridges[feature - self.faces.len()].middle,
        }
    }

    /// Gap \[m\] and normal of a grain at this offset from a face or ridge; none where it is not over it, or its
    /// surface farther than `reach`.
    #[inline]
    pub fn touched_by(
        &self,
        feature: usize,
        offset: &Vector<D>,
        radius: f64,
        reach: f64,
    ) -> Option<(f64, Vector<D>)> {
        match self.faces.get(feature) {
            Some(face) => face_near(face, offset, radius, reach).map(|(gap, _)| (gap, face.normal)),
            None => ridge_near(
                &self.ridges[feature - self.faces.len()],
                offset,
                radius,
                reach,
            ),
        }
    }

    /// From the nearest image and, where the domain is periodic, those beside it.
    #[inline]
    fn each_offset(
        &self,
        centre: &Vector<D>,
        from: &Vector<D>,
        mut visit: impl FnMut(Vector<D>, Image),
    ) {
        let nearest = shortest_image(centre - from, &self.period);
        each_image(&self.period, |shift| {
            visit(shifted(&nearest, shift, &self.period), Image::of(shift));
        });
    }

    /// A grain whose centre lies a little behind a face has been placed in the solid: the face, and
    /// how far behind it \[m\].
    pub fn behind(&self, centre: &Vector<D>, radius: f64) -> Option<(usize, f64)> {
        self.faces.iter().enumerate().find_map(|(number, face)| {
            let offset = shortest_image(centre - face.middle, &self.period);
            let height = face.height(&offset);
            let inside = face.left(&offset).iter().all(|&left| left > 0.0);
            (inside && height < 0.0 && height > -0.5 * radius).then_some((number, -height))
        })
    }
}

/// Gap and place of a grain within `reach` of a face.
#[inline]
fn face_near<'a, const D: usize>(
    face: &'a Face<D>,
    offset: &Vector<D>,
    radius: f64,
    reach: f64,
) -> Option<(f64, Over<'a, D>)>
where
    Dim<D>: Dimension<D>,
{
    let height = face.height(offset);
    if height < 0.0 || height - radius > reach {
        return None;
    }
    let left = face.left(offset);
    let beyond = face.sides.iter().zip(left).any(|(side, left)| {
        let slack = 1e-9 * side.distance;
        left < -match side.extended {
            Some(beyond) => (radius + reach).min(beyond + slack),
            None => slack,
        }
    });
    (!beyond).then_some((height - radius, Over { face, left }))
}

/// Gap and normal of a grain within `reach` of a ridge.
#[inline]
fn ridge_near<const D: usize>(
    ridge: &Ridge<D>,
    offset: &Vector<D>,
    radius: f64,
    reach: f64,
) -> Option<(f64, Vector<D>)>
where
    Dim<D>: Dimension<D>,
{
    let across = ridge.across(offset)?;
    let distance = norm(&across);
    if distance - radius > reach {
        return None;
    }
    Some((distance - radius, across * (1.0 / distance)))
}
