//! Where facets end or meet: a corner, in space an edge too.

use space::periodic::shortest_image;
use space::{Dim, Dimension, Period, Vector, dot, norm};

use crate::walls::facet::middle;

/// Ends closer than this part of the largest wall are one, and directions that differ by less.
pub const SAME: f64 = 1e-9;

/// A corner or an edge of one or more facets.
#[derive(Debug, Clone)]
pub struct Ridge<const D: usize> {
    /// The corner, or the middle of the edge \[m\].
    pub middle: Vector<D>,
    /// Direction and half length of an edge.
    along: Option<(Vector<D>, f64)>,
    /// Unit vectors from it into the facets (from a corner in space: along the edges) that meet there.
    pub inward: Vec<Vector<D>>,
    /// Numbers of those facets, one each time.
    pub faces: Vec<usize>,
}

impl<const D: usize> Ridge<D>
where
    Dim<D>: Dimension<D>,
{
    /// With these ends: one of a corner, two of an edge.
    pub fn new(ends: &[Vector<D>]) -> Ridge<D> {
        let along = ends.get(1).map(|end| {
            let edge = end - ends[0];
            let length = norm(&edge);
            (edge * (1.0 / length), 0.5 * length)
        });
        Ridge {
            middle: middle(ends),
            along,
            inward: Vec::new(),
            faces: Vec::new(),
        }
    }

    /// Do both lie in the same place, up to a period?
    pub fn is(&self, other: &Ridge<D>, period: &Period<D>, tolerance: f64) -> bool {
        let apart = norm(&shortest_image(other.middle - self.middle, period));
        let parallel = match (self.along, other.along) {
            (None, None) => true,
            (Some((one, _)), Some((two, _))) => Dim::<D>::cross_length(&one, &two) < SAME,
            _ => false,
        };
        parallel && apart < tolerance
    }

    /// To the nearest point of the ridge \[m\].
    pub fn distance(&self, offset: &Vector<D>) -> f64 {
        let nearest = match self.along {
            Some((unit, half_length)) => unit * dot(offset, &unit).clamp(-half_length, half_length),
            None => Vector::zeros(),
        };
        norm(&(offset - nearest))
    }

    /// From the nearest point of the ridge to a grain that touches nothing nearer than it: none
    /// beyond the ends of an edge, and over a facet.
    #[inline]
    pub fn across(&self, offset: &Vector<D>) -> Option<Vector<D>> {
        let mut across = *offset;
        if let Some((unit, half_length)) = self.along {
            let place = dot(offset, &unit);
            if place.abs() > half_length {
                return None;
            }
            across -= unit * place;
        }
        let over = |inward: &Vector<D>| dot(&across, inward) >= 0.0;
        (!self.inward.iter().any(over)).then_some(across)
    }
}
