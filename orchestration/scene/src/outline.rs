//! The outline of the fluid: the sides of its rectangle or box, or the facets of its mesh that belong to one
//! simplex. What lies inside, and what lies on it.

use protocol::scene::Wall;
use space::{Dim, Dimension, Vector};

use crate::dimensions::{Corners, Scenic, sides};

/// Part of the size of an outline within which a point lies on a facet.
const ON_FACET: f64 = 1e-9;
/// The axis across which facets are sorted.
const ACROSS: usize = 1;

/// A piece of the outline; the fluid is on the left of a → b, in space where its corners are seen clockwise.
#[derive(Debug, Clone, PartialEq)]
pub struct Facet<const D: usize> {
    /// Its corners \[m\].
    pub corners: Corners<D>,
    /// Name of its boundary.
    pub boundary: String,
}

/// All facets, sorted into strips across y.
#[derive(Debug, Clone)]
pub struct Outline<const D: usize> {
    /// The facets.
    pub facets: Vec<Facet<D>>,
    /// Axes along which there is no outside: the fluid is periodic.
    periodic: [bool; D],
    /// Lowest y, height of a strip \[m\].
    strips: [f64; 2],
    /// Numbers of the facets that reach into each strip.
    members: Vec<Vec<u32>>,
    /// Distance at which a point lies on a facet \[m\].
    tolerance: f64,
}

/// Smallest and largest coordinate of all corners along each axis \[m\].
fn ranges<const D: usize>(facets: &[Facet<D>]) -> [[f64; 2]; D] {
    std::array::from_fn(|axis| {
        let corners = facets.iter().flat_map(|facet| &facet.corners);
        let values = corners.map(|corner| corner[axis]);
        values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| {
            [low.min(value), high.max(value)]
        })
    })
}

impl<const D: usize> Outline<D>
where
    Dim<D>: Scenic<D>,
{
    /// Of a rectangle or box, with its sides.
    pub fn of_box(lower: &[f64; D], upper: &[f64; D], periodic: [bool; D]) -> Outline<D> {
        let names = sides::<D>().iter().enumerate();
        let facets = names.flat_map(|(side, name)| {
            let of_side = Dim::<D>::side(lower, upper, side).into_iter();
            of_side.map(|corners| Facet {
                corners,
                boundary: (*name).to_string(),
            })
        });
        Outline::new(facets.collect(), periodic)
    }

    /// Of these facets.
    pub fn new(facets: Vec<Facet<D>>, periodic: [bool; D]) -> Outline<D> {
        let ranges = ranges(&facets);
        let extent = ranges.map(|[low, high]| high - low);
        let tolerance = ON_FACET * extent.into_iter().fold(f64::NEG_INFINITY, f64::max);
        let count = facets.len().clamp(1, 4096);
        let strips = [ranges[ACROSS][0], extent[ACROSS] / count as f64];
        let mut outline = Outline {
            facets,
            periodic,
            strips,
            members: vec![Vec::new(); count],
            tolerance,
        };
        for number in 0..outline.facets.len() {
            let along = outline.facets[number].corners.map(|corner| corner[ACROSS]);
            let low = along.into_iter().fold(f64::INFINITY, f64::min) - tolerance;
            let high = along.into_iter().fold(f64::NEG_INFINITY, f64::max) + tolerance;
            for strip in outline.strip(low)..=outline.strip(high) {
                outline.members[strip].push(number as u32);
            }
        }
        outline
    }

    /// Distance at which a point lies on a facet \[m\].
    pub fn tolerance(&self) -> f64 {
        self.tolerance
    }

    fn strip(&self, y: f64) -> usize {
        let strip = (y - self.strips[0]) / self.strips[1];
        strip.clamp(0.0, (self.members.len() - 1) as f64) as usize
    }

    /// Is there fluid at a point, its edge included?
    pub fn contains(&self, point: &[f64; D]) -> bool {
        match self.periodic.contains(&true) {
            false => self.winds(point) || self.facet_at(point).is_some(),
            // Only rectangles and boxes are periodic.
            true => (0..D).all(|axis| self.periodic[axis] || self.within(point, axis)),
        }
    }

    /// Its extent along each axis \[m\].
    pub fn size(&self) -> [f64; D] {
        ranges(&self.facets).map(|[low, high]| high - low)
    }

    /// Is a point between the smallest and the largest coordinate along an axis?
    fn within(&self, point: &[f64; D], axis: usize) -> bool {
        let [low, high] = ranges(&self.facets)[axis];
        (low - self.tolerance..=high + self.tolerance).contains(&point[axis])
    }

    /// Facets of the strip that a point is in.
    fn near(&self, point: &[f64; D]) -> impl Iterator<Item = &Facet<D>> {
        let members = self.members[self.strip(point[ACROSS])].iter();
        members.map(|&number| &self.facets[number as usize])
    }

    /// Does a ray along x leave an odd number of times?
    fn winds(&self, point: &[f64; D]) -> bool {
        let ahead = |facet: &&Facet<D>| Dim::<D>::is_ahead(&facet.corners, point);
        self.near(point).filter(ahead).count() % 2 == 1
    }

    /// The facet that a point lies on.
    pub fn facet_at(&self, point: &[f64; D]) -> Option<&Facet<D>> {
        self.near(point)
            .find(|facet| facet.distance(point) <= self.tolerance)
    }

    /// Facets that a flat wall lies on, from its middle and its corners.
    pub fn along(&self, corners: &Corners<D>) -> Option<&Facet<D>> {
        let all = corners.iter().all(|corner| self.facet_at(corner).is_some());
        self.facet_at(&middle(corners)).filter(|_| all)
    }
}

impl<const D: usize> Facet<D>
where
    Dim<D>: Scenic<D>,
{
    /// From a point to the nearest one of the facet \[m\].
    fn distance(&self, point: &[f64; D]) -> f64 {
        Wall::of(&self.corners, None).distance(point)
    }

    /// Its middle \[m\].
    pub fn middle(&self) -> [f64; D] {
        middle(&self.corners)
    }

    /// Unit vector into the fluid.
    pub fn inward(&self) -> Vector<D> {
        let normal = Dim::<D>::inward_normal(&self.corners.map(Vector::from));
        normal / space::hypot(&normal)
    }
}

/// The middle of a flat wall \[m\].
fn middle<const D: usize>(corners: &Corners<D>) -> [f64; D] {
    std::array::from_fn(|axis| corners.iter().map(|corner| corner[axis]).sum::<f64>() / D as f64)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;

    /// Edges of triangles that belong to one of them, each with the name that `named` has for its nodes.
    fn single_edges(
        position: &[[f64; 2]],
        triangles: &[[usize; 3]],
        named: &BTreeMap<[usize; 2], String>,
    ) -> Vec<Facet<2>> {
        let mut sides: Vec<([usize; 2], [usize; 2])> = Vec::with_capacity(3 * triangles.len());
        for &[i, j, k] in triangles {
            let triangle = if is_clockwise([i, j, k].map(|n| position[n])) {
                [i, k, j]
            } else {
                [i, j, k]
            };
            for corner in 0..3 {
                let side = [triangle[corner], triangle[(corner + 1) % 3]];
                sides.push(([side[0].min(side[1]), side[0].max(side[1])], side));
            }
        }
        sides.sort_unstable();
        let single = sides.chunk_by(|p, q| p.0 == q.0).filter(|c| c.len() == 1);
        single
            .map(|group| {
                let (key, [a, b]) = group[0];
                Facet {
                    corners: [position[a], position[b]],
                    boundary: named.get(&key).cloned().unwrap_or_default(),
                }
            })
            .collect()
    }

    fn is_clockwise([a, b, c]: [[f64; 2]; 3]) -> bool {
        (b[0] - a[0]) * (c[1] - a[1]) < (c[0] - a[0]) * (b[1] - a[1])
    }

    #[test]
    fn a_hole_is_outside_and_its_rim_is_not() {
        // A square ring of side 3 around a square hole of side 1, in triangles.
        let place = |n: usize| [(n % 4) as f64, (n / 4) as f64];
        let position: Vec<[f64; 2]> = (0..16).map(place).collect();
        let cells = (0..9).filter(|&cell| cell != 4);
        let corner = |cell: usize| cell % 3 + 4 * (cell / 3);
        let triangles: Vec<[usize; 3]> = cells
            .map(corner)
            .flat_map(|n| [[n, n + 1, n + 5], [n, n + 5, n + 4]])
            .collect();
        let named = BTreeMap::from([([5, 6], "hole".to_string())]);
        let outline = Outline::new(single_edges(&position, &triangles, &named), [false; 2]);
        assert_eq!(outline.facets.len(), 16);
        for (point, inside) in [
            ([0.5, 0.5], true),
            ([1.5, 1.5], false),
            ([1.5, 1.0], true),
            ([3.1, 1.5], false),
            ([2.9, 1.5], true),
            ([1.0, 1.0], true),
        ] {
            assert_eq!(outline.contains(&point), inside, "{point:?}");
        }
        let rim = outline
            .along(&[[1.2, 1.0], [1.8, 1.0]])
            .expect("on the rim");
        println!("{rim:?}");
        assert_eq!(
            (rim.boundary.as_str(), rim.inward().into()),
            ("hole", [0.0, -1.0])
        );
        assert!(outline.along(&[[0.5, 1.0], [1.8, 1.0]]).is_none());
    }

    #[test]
    fn a_periodic_rectangle_has_no_outside_along_its_period() {
        let outline = Outline::of_box(&[0.0, 0.0], &[1.0, 2.0], [true, false]);
        assert!(outline.contains(&[7.0, 1.0]) && !outline.contains(&[0.5, 2.1]));
    }

    #[test]
    fn a_box_with_a_box_cut_out_has_an_inside() {
        let mut facets = Outline::of_box(&[0.0; 3], &[3.0; 3], [false; 3]).facets;
        let hole = Outline::of_box(&[1.0; 3], &[2.0; 3], [false; 3]).facets;
        facets.extend(hole.into_iter().map(|mut facet| {
            facet.corners.swap(1, 2);
            facet
        }));
        let outline = Outline::new(facets, [false; 3]);
        let mut inside = 0;
        for number in 0..4096_u32 {
            // points on diagonals of the facets, too
            let place = |k: u32| f64::from(number >> (4 * k) & 15) * 0.25 - 0.375;
            let point = [place(0), place(1), place(2)];
            let within = |low: f64, high: f64| point.iter().all(|x| (low..=high).contains(x));
            let expected = within(0.0, 3.0) && !within(1.0, 2.0);
            assert_eq!(outline.contains(&point), expected, "{point:?}");
            inside += usize::from(expected);
        }
        assert_eq!(inside, 12 * 12 * 12 - 4 * 4 * 4);
        let wall = outline.along(&[[0.1, 0.0, 0.1], [2.9, 0.0, 0.2], [0.3, 0.0, 2.9]]);
        let wall = wall.expect("on the floor");
        assert_eq!((wall.boundary.as_str(), wall.inward()[1]), ("bottom", 1.0));
    }
}
