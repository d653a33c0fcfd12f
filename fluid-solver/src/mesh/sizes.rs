//! How large cells are to be.
//!
//! ```text
//!   h(x) = min(h_max, min_z (h_z + growth · |x − z|))         |x − z|: distance to zone z, 0 inside    (Z1)
//! ```
//!
//! Zones are found by a tree of boxes, each with the smallest size in it: (Z1) of the box and that size is a lower
//! bound, so that most zones are never looked at.

use space::periodic::{each_image, shifted};
use space::{Period, Vector, norm, vector};

/// Zones at the end of a branch.
const LEAF: usize = 8;

/// A place where cells are to be small.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Place<const D: usize> {
    /// A ball, or a point where the radius is 0.
    Ball {
        /// Its centre \[m\].
        centre: Vector<D>,
        /// Its radius \[m\].
        radius: f64,
    },
    /// A box along the axes.
    Box {
        /// Its lower corner \[m\].
        lower: Vector<D>,
        /// Its upper corner \[m\].
        upper: Vector<D>,
    },
}

impl<const D: usize> Place<D> {
    /// The box around it.
    fn bounds(&self) -> [Vector<D>; 2] {
        match self {
            Place::Ball { centre, radius } => {
                [centre.add_scalar(-radius), centre.add_scalar(*radius)]
            }
            Place::Box { lower, upper } => [*lower, *upper],
        }
    }

    /// From a point; 0 inside \[m\].
    fn distance(&self, point: &Vector<D>) -> f64 {
        match self {
            Place::Ball { centre, radius } => (norm(&(point - centre)) - radius).max(0.0),
            Place::Box { lower, upper } => beyond(&[*lower, *upper], point),
        }
    }
}

/// From a point to a box; 0 inside \[m\].
fn beyond<const D: usize>([lower, upper]: &[Vector<D>; 2], point: &Vector<D>) -> f64 {
    let outside = |d: usize| (lower[d] - point[d]).max(point[d] - upper[d]).max(0.0);
    norm::<D>(&vector::from_fn(outside))
}

/// A place, and how large cells are there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Zone<const D: usize> {
    /// Where.
    pub place: Place<D>,
    /// h in it \[m\].
    pub size: f64,
}

/// A part of the tree: all zones of a range, the box around them, the smallest of their sizes.
#[derive(Debug, Clone)]
struct Branch<const D: usize> {
    bounds: [Vector<D>; 2],
    size: f64,
    zones: std::ops::Range<usize>,
    /// The two parts of it, the second one behind all of the first; none at the end.
    second: Option<usize>,
}

/// (Z1).
#[derive(Debug, Clone)]
pub struct Sizes<const D: usize> {
    zones: Vec<Zone<D>>,
    branches: Vec<Branch<D>>,
    growth: f64,
    largest: f64,
    period: Period<D>,
}

impl<const D: usize> Sizes<D> {
    /// Of these zones, `growth` in metres a metre, `largest` where no zone is near \[m\].
    pub fn new(zones: Vec<Zone<D>>, growth: f64, largest: f64, period: Period<D>) -> Sizes<D> {
        let mut sizes = Sizes {
            branches: Vec::new(),
            growth,
            largest,
            period,
            zones,
        };
        if !sizes.zones.is_empty() {
            sizes.divide(0..sizes.zones.len());
        }
        sizes
    }

    /// A multiple of these sizes.
    pub fn times(&self, factor: f64) -> Sizes<D> {
        let mut sizes = self.clone();
        sizes.growth *= factor;
        sizes.largest *= factor;
        (sizes.zones.iter_mut()).for_each(|zone| zone.size *= factor);
        (sizes.branches.iter_mut()).for_each(|branch| branch.size *= factor);
        sizes
    }

    /// Sort a range of zones into branches; returns the number of the first.
    fn divide(&mut self, range: std::ops::Range<usize>) -> usize {
        let own = &mut self.zones[range.clone()];
        let mut bounds = own[0].place.bounds();
        let mut size = own[0].size;
        for zone in own.iter() {
            let [lower, upper] = zone.place.bounds();
            bounds = [bounds[0].inf(&lower), bounds[1].sup(&upper)];
            size = size.min(zone.size);
        }
        let number = self.branches.len();
        self.branches.push(Branch {
            bounds,
            size,
            zones: range.clone(),
            second: None,
        });
        if range.len() > LEAF {
            let extent = bounds[1] - bounds[0];
            let middle = |zone: &Zone<D>| {
                let [lower, upper] = zone.place.bounds();
                lower[extent.imax()] + upper[extent.imax()]
            };
            let half = range.len() / 2;
            own.select_nth_unstable_by(half, |a, b| middle(a).total_cmp(&middle(b)));
            self.divide(range.start..range.start + half);
            let second = self.divide(range.start + half..range.end);
            self.branches[number].second = Some(second);
        }
        number
    }

    /// h of a point \[m\].
    pub fn at(&self, point: &Vector<D>) -> f64 {
        self.at_most(point, self.largest)
    }

    /// Are cells at a point smaller than this \[m\]? Told sooner than h itself.
    pub fn are_below(&self, size: f64, point: &Vector<D>) -> bool {
        size > self.largest || self.at_most(point, size) < size
    }

    /// By how much h can change over this distance \[m\].
    pub fn change(&self, distance: f64) -> f64 {
        self.growth * distance
    }

    /// The lesser of h and `least`.
    fn at_most(&self, point: &Vector<D>, mut least: f64) -> f64 {
        if let Some(all) = self.branches.first() {
            each_image(&self.period, |shift| {
                let point = shifted(point, shift, &self.period);
                self.lower(0, self.bound(all, &point), &point, &mut least);
            });
        }
        least
    }

    /// A lower bound of h of the zones of a branch.
    fn bound(&self, branch: &Branch<D>, point: &Vector<D>) -> f64 {
        branch.size + self.growth * beyond(&branch.bounds, point)
    }

    /// Lower `least` to h of the zones of a branch, which is not below `bound`; what may be nearer first.
    fn lower(&self, number: usize, bound: f64, point: &Vector<D>, least: &mut f64) {
        if bound >= *least {
            return;
        }
        let branch = &self.branches[number];
        match branch.second {
            Some(second) => {
                let both = [number + 1, second];
                let mut both = both.map(|part| (self.bound(&self.branches[part], point), part));
                if both[1].0 < both[0].0 {
                    both.swap(0, 1);
                }
                for (bound, part) in both {
                    self.lower(part, bound, point, least);
                }
            }
            None => {
                for zone in &self.zones[branch.zones.clone()] {
                    let size = zone.size + self.growth * zone.place.distance(point);
                    *least = least.min(size);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tree_finds_what_looking_at_all_zones_finds() {
        let number = |k: usize| (k as f64 * 0.618_033_988_75).fract();
        let zone = |k: usize| {
            let at = Vector::from([number(3 * k), number(5 * k + 1)]);
            let place = match k % 2 {
                0 => Place::Ball {
                    centre: at,
                    radius: 0.01 * number(k),
                },
                _ => Place::Box {
                    lower: at,
                    upper: at.add_scalar(0.02),
                },
            };
            Zone {
                place,
                size: 0.01 + 0.02 * number(7 * k),
            }
        };
        let zones: Vec<Zone<2>> = (0..200).map(zone).collect();
        for period in [[None; 2], [Some(1.0), None]] {
            let sizes = Sizes::new(zones.clone(), 0.3, 0.2, period);
            for k in 0..500 {
                let point = Vector::from([number(k), 1.2 * number(11 * k)]);
                let mut least = 0.2_f64;
                for shift in [-1.0, 0.0, 1.0] {
                    let across = period[0].map_or(0.0, |length| shift * length);
                    let image = point + Vector::from([across, 0.0]);
                    for zone in &zones {
                        least = least.min(zone.size + 0.3 * zone.place.distance(&image));
                    }
                }
                assert_eq!(sizes.at(&point), least);
                for size in [0.5 * least, least, least * (1.0 + 1e-15), 0.2, 0.3] {
                    assert_eq!(sizes.are_below(size, &point), least < size, "{size}");
                }
            }
        }
        assert_eq!(
            Sizes::new(vec![], 0.3, 0.2, [None; 2]).at(&Vector::zeros()),
            0.2
        );
    }
}
