//! When the mesh follows the grains, and how fine it is where.
//!
//! ```text
//!   C = cells of edge `margin` that grains are in          zone = C and the two rings around it: h = near_grains
//!   follow when a grain is beyond C and one ring, or the zone is a fifth larger than one made now          (A1)
//! ```
//!
//! A grain is at least two margins from the edge of a new zone, and one margin when the mesh follows. The cells are
//! those of one lattice throughout, so that the mesh depends on where grains are and not on how they came there.

use protocol::scene::{NearGrains, REGIONS_MAX, Refinement, Region};
use serde::{Deserialize, Serialize};
use space::Period;

use crate::state::Grains;

/// Rings around the cells of grains in a new zone, and when a grain has gone too far.
const RINGS: (i64, i64) = (2, 1);
/// A zone that is larger than this many times the one made now is made anew.
const TOO_LARGE: f64 = 1.2;

/// Numbers of cells at most: what is farther away is in no mesh.
const FARTHEST: i64 = 1 << 40;

/// A cell of the lattice.
type Cell<const D: usize> = [i64; D];

/// What the mesh has been asked for, kept in checkpoints.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Asked {
    /// Epoch of the mesh since.
    pub epoch: u64,
    /// Cells of grains then, D numbers each.
    cells: Vec<i64>,
}

/// Follows the grains.
#[derive(Debug, Clone)]
pub struct Follow<const D: usize> {
    sizes: Refinement,
    near: NearGrains,
    /// Edges of a cell \[m\]: of a period a whole number.
    edge: [f64; D],
    /// Cells in a period.
    count: [Option<i64>; D],
    /// Cells of grains when the mesh was asked for, and how large the zone was.
    asked: Vec<Cell<D>>,
    within: Vec<Cell<D>>,
    zone: usize,
}

impl<const D: usize> Follow<D> {
    /// In a scene that asks for it.
    pub fn new(
        sizes: Option<&Refinement>,
        near: Option<NearGrains>,
        period: &Period<D>,
    ) -> Option<Follow<D>> {
        let (sizes, near) = (sizes?.clone(), near?);
        let count =
            period.map(|length| length.map(|length| (length / near.margin).floor().max(1.0)));
        let edge = std::array::from_fn(|d| match (period[d], count[d]) {
            (Some(length), Some(count)) => length / count,
            _ => near.margin,
        });
        Some(Follow {
            sizes,
            near,
            edge,
            count: count.map(|count| count.map(|count| count as i64)),
            asked: Vec::new(),
            within: Vec::new(),
            zone: 0,
        })
    }

    /// The sizes to ask for now, where the mesh must follow (A1).
    pub fn wish(&mut self, grains: &Grains<D>) -> Option<Refinement> {
        let cells = self.cells_of(grains);
        if cells == self.asked {
            return None;
        }
        let outside = |cell| self.within.binary_search(cell).is_err();
        if !cells.iter().any(outside) {
            let now = self.around(&cells, RINGS.0).len();
            if self.zone as f64 <= TOO_LARGE * now as f64 {
                return None;
            }
        }
        Some(self.ask(cells))
    }

    /// The sizes of a mesh that was asked for earlier; none where the cells are none.
    pub fn again(&mut self, asked: &Asked) -> Option<Refinement> {
        let cells = asked.cells.chunks_exact(D);
        let cells: Vec<Cell<D>> = cells.filter_map(|cell| cell.try_into().ok()).collect();
        let near = asked.cells.iter().all(|k| k.abs() <= FARTHEST);
        (near && cells.len() * D == asked.cells.len()).then(|| self.ask(cells))
    }

    /// What was asked for, since when the mesh is of this epoch.
    pub fn asked(&self, epoch: u64) -> Asked {
        Asked {
            epoch,
            cells: self.asked.concat(),
        }
    }

    fn ask(&mut self, cells: Vec<Cell<D>>) -> Refinement {
        self.within = self.around(&cells, RINGS.1);
        let zone = self.around(&cells, RINGS.0);
        (self.asked, self.zone) = (cells, zone.len());
        let mut sizes = self.sizes.clone();
        let most = REGIONS_MAX - sizes.regions.len().min(REGIONS_MAX);
        sizes.regions.extend(self.regions(zone, most));
        sizes
    }

    /// Cells that grains are in, in ascending order.
    fn cells_of(&self, grains: &Grains<D>) -> Vec<Cell<D>> {
        let mut cells = Vec::with_capacity(grains.count());
        for (position, radius) in grains.position.iter().zip(&grains.radius) {
            let cell = |d: usize, x: f64| {
                let cell = (x / self.edge[d]).floor() as i64;
                cell.clamp(-FARTHEST, FARTHEST)
            };
            let middle: Cell<D> = std::array::from_fn(|d| self.wrap(d, cell(d, position[d])));
            let reach: [i64; D] = std::array::from_fn(|d| {
                let [low, high] = [-radius, *radius].map(|r| cell(d, position[d] + r));
                (high - low + 1) / 2
            });
            self.box_around(&middle, reach, &mut cells);
        }
        sorted(cells)
    }

    fn wrap(&self, axis: usize, cell: i64) -> i64 {
        self.count[axis].map_or(cell, |count| cell.rem_euclid(count))
    }

    /// Cells and the rings around them.
    fn around(&self, cells: &[Cell<D>], rings: i64) -> Vec<Cell<D>> {
        let mut all = Vec::new();
        for cell in cells {
            self.box_around(cell, [rings; D], &mut all);
        }
        sorted(all)
    }

    fn box_around(&self, cell: &Cell<D>, reach: [i64; D], all: &mut Vec<Cell<D>>) {
        let mut offset: Cell<D> = reach.map(|reach| -reach);
        loop {
            all.push(std::array::from_fn(|d| self.wrap(d, cell[d] + offset[d])));
            let Some(axis) = (0..D).find(|&d| offset[d] < reach[d]) else {
                return;
            };
            offset[axis] += 1;
            for before in 0..axis {
                offset[before] = -reach[before];
            }
        }
    }

    /// The cells as few boxes: of a coarser lattice where they are too many.
    fn regions(&self, mut cells: Vec<Cell<D>>, most: usize) -> Vec<Region> {
        let mut scale = 1;
        let mut boxes = merged(cells.clone());
        while boxes.len() > most {
            scale *= 2;
            let coarser = cells.iter().map(|cell| cell.map(|k| k.div_euclid(2)));
            cells = sorted(coarser.collect());
            boxes = merged(cells.clone());
        }
        let corner = |cell: Cell<D>| -> Vec<f64> {
            let along = |d: usize| (cell[d] * scale) as f64 * self.edge[d];
            (0..D).map(along).collect()
        };
        let region = |[low, high]: [Cell<D>; 2]| Region::Box {
            lower: corner(low),
            upper: corner(high),
            size: self.near.size,
        };
        boxes.into_iter().map(region).collect()
    }
}

fn sorted<const D: usize>(mut cells: Vec<Cell<D>>) -> Vec<Cell<D>> {
    cells.sort_unstable();
    cells.dedup();
    cells
}

/// Cells as boxes that cover them and no other, from the lower corner to the one beyond the upper: along one axis
/// after the other, boxes that continue each other are one.
fn merged<const D: usize>(cells: Vec<Cell<D>>) -> Vec<[Cell<D>; 2]> {
    let mut boxes: Vec<[Cell<D>; 2]> = cells.into_iter().map(|c| [c, c.map(|k| k + 1)]).collect();
    for axis in 0..D {
        // those that agree along the other axes beside each other, in the order of this one
        let key = |[low, high]: &[Cell<D>; 2]| {
            let others = |d: usize| match d == axis {
                true => [0, 0],
                false => [low[d], high[d]],
            };
            (std::array::from_fn::<_, D, _>(others), low[axis])
        };
        boxes.sort_unstable_by_key(key);
        let mut fewer: Vec<[Cell<D>; 2]> = Vec::with_capacity(boxes.len());
        for next in boxes {
            match fewer.last_mut() {
                Some(last) if key(last).0 == key(&next).0 && last[1][axis] == next[0][axis] => {
                    last[1][axis] = next[1][axis];
                }
                _ => fewer.push(next),
            }
        }
        boxes = fewer;
    }
    boxes
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZES: Refinement = Refinement {
        growth: 0.2,
        largest: None,
        regions: Vec::new(),
    };

    fn grains(positions: &[[f64; 2]]) -> Grains<2> {
        Grains {
            position: positions.iter().map(|&x| x.into()).collect(),
            radius: vec![1e-4; positions.len()],
            mass: vec![1.0; positions.len()],
            ..Grains::default()
        }
    }

    const NEAR: NearGrains = NearGrains {
        size: 0.02,
        margin: 0.1,
    };

    fn is_in(region: &Region, point: [f64; 2]) -> bool {
        let Region::Box { lower, upper, .. } = region else {
            return false;
        };
        (0..2).all(|d| lower[d] - 1e-12 <= point[d] && point[d] <= upper[d] + 1e-12)
    }

    #[test]
    fn the_mesh_follows_when_a_grain_has_gone_a_margin_or_the_zone_is_too_large() {
        let mut follow = Follow::new(Some(&SIZES), Some(NEAR), &[None; 2]).expect("asked for");
        let first = follow.wish(&grains(&[[0.55, 0.55]])).expect("never asked");
        for reach in [[0.2, 0.0], [0.0, -0.2], [0.2, 0.2]] {
            let point = [0.55 + reach[0], 0.55 + reach[1]];
            assert!(first.regions.iter().any(|region| is_in(region, point)));
        }
        assert_eq!(first.regions.len(), 1);
        assert_eq!(follow.wish(&grains(&[[0.64, 0.46]])), None);
        let there = grains(&[[0.55, 0.34]]);
        let asked = follow.wish(&there).expect("it is beyond the ring");
        assert_eq!(follow.wish(&there), None);
        // the same wherever it came from, and from a checkpoint
        let mut other = Follow::new(Some(&SIZES), Some(NEAR), &[None; 2]).expect("asked for");
        assert_eq!(other.wish(&there).as_ref(), Some(&asked));
        let kept = follow.asked(7);
        assert_eq!(other.again(&kept).as_ref(), Some(&asked));
        // two grains that have come together
        follow
            .wish(&grains(&[[0.15, 0.15], [0.85, 0.85]]))
            .expect("far");
        let near = follow.wish(&grains(&[[0.15, 0.15], [0.16, 0.15]]));
        assert_eq!(near.map(|sizes| sizes.regions.len()), Some(1));
    }

    #[test]
    fn across_a_period_and_with_many_grains_every_grain_is_in_a_region() {
        let period = [Some(1.0), None];
        let mut follow = Follow::new(Some(&SIZES), Some(NEAR), &period).expect("asked for");
        let number = |k: usize| (k as f64 * 0.618_033_988_75).fract();
        let at = |k: usize| [number(k), 300.0 * number(7 * k)];
        let positions: Vec<[f64; 2]> = (0..3000).map(at).collect();
        let asked = follow.wish(&grains(&positions)).expect("never asked");
        println!("{} regions", asked.regions.len());
        assert!(asked.regions.len() <= REGIONS_MAX);
        for point in positions {
            assert!(asked.regions.iter().any(|region| is_in(region, point)));
        }
        // nobody is left: a mesh without a zone, asked for once
        assert_eq!(
            follow.wish(&grains(&[])).map(|sizes| sizes.regions.len()),
            Some(0)
        );
        assert_eq!(follow.wish(&grains(&[])), None);
        let lost = grains(&[[1e300, f64::NAN], [-1e300, 0.0]]);
        assert!(follow.wish(&lost).is_some());
        let moved = grains(&[[-0.01, 0.0], [0.99, 0.0], [1.99, 0.0]]);
        let few = Follow::new(Some(&SIZES), Some(NEAR), &period).and_then(|mut f| f.wish(&moved));
        println!("{few:?}");
        let count = few.map(|sizes| sizes.regions.len());
        assert_eq!(count, Some(2), "both ends of the period");
    }
}
