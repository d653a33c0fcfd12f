//! Nested dissection of the mesh: in which order nodes are eliminated, and in which groups.
//!
//! A set of nodes is cut across its longest side; the nodes of one half that touch the other half
//! are its separator and are eliminated last. Each separator, and each piece too small to cut, is
//! a *front*: its nodes are eliminated together. After George (1973). Among cuts near the middle
//! the one with the smallest separator is taken; ties fall to the first, so the order is the same
//! every time. Where cells are so flat that a cut across the longest side meets many nodes, the other
//! sides are tried too.

use std::cmp::Ordering;

use space::Vector;

use super::pattern::Pattern;

/// Pieces of at most this many nodes are not cut.
const PIECE: usize = 16;
/// Where cuts are tried, as fractions of the sorted nodes.
const CUTS: [f64; 7] = [0.5, 0.47, 0.53, 0.44, 0.56, 0.41, 0.59];

/// A separator of this many times n^((D − 1)/D) of n nodes is a bad one; a cube has once as many, one that
/// is periodic twice.
const BAD: f64 = 2.0;

/// A group of nodes that are eliminated together, with what that touches.
#[derive(Debug, Clone, Default)]
pub struct Front {
    /// Nodes eliminated here.
    pub pivots: Vec<usize>,
    /// Nodes eliminated later that the elimination couples, in the order of their elimination.
    pub boundary: Vec<usize>,
    /// Fronts whose remainder is added here.
    pub children: Vec<usize>,
    /// First front of the subtree that ends here; the subtree is a contiguous range.
    pub first: usize,
}

/// The fronts, children before parents.
pub fn fronts<const D: usize, const N: usize>(
    pattern: &Pattern<N>,
    position: &[Vector<D>],
) -> Vec<Front> {
    let mut cutter = Cutter {
        pattern,
        position,
        side: vec![0; position.len()],
        stamp: 0,
        fronts: Vec::new(),
    };
    cutter.cut((0..position.len()).collect());
    let mut fronts = cutter.fronts;
    find_boundaries(pattern, &mut fronts);
    fronts
}

struct Cutter<'a, const D: usize, const N: usize> {
    pattern: &'a Pattern<N>,
    position: &'a [Vector<D>],
    /// Mark of a node that lies in the upper part of the present cut.
    side: Vec<u32>,
    stamp: u32,
    fronts: Vec<Front>,
}

impl<const D: usize, const N: usize> Cutter<'_, D, N> {
    /// Append the fronts of a set of nodes; returns the last of them.
    fn cut(&mut self, mut nodes: Vec<usize>) -> usize {
        let first = self.fronts.len();
        if nodes.len() <= PIECE {
            return self.push(nodes, Vec::new(), first);
        }
        let middle = self.arrange(&mut nodes);
        let mut separator = self.separator(&nodes[..middle], &nodes[middle..]);
        if separator.is_empty() {
            // Halves that do not touch: any node will do, and every front has a pivot.
            separator.push(nodes[middle - 1]);
        }
        let inside = |node: &usize| separator.binary_search(node).is_err();
        let low: Vec<usize> = nodes[..middle].iter().copied().filter(inside).collect();
        let high = nodes[middle..].to_vec();
        if low.is_empty() || high.is_empty() {
            return self.push(nodes, Vec::new(), first);
        }
        let children = vec![self.cut(low), self.cut(high)];
        self.push(separator, children, first)
    }

    fn push(&mut self, pivots: Vec<usize>, children: Vec<usize>, first: usize) -> usize {
        self.fronts.push(Front {
            pivots,
            boundary: Vec::new(),
            children,
            first,
        });
        self.fronts.len() - 1
    }

    /// Sort the nodes along the side to cut; returns where.
    fn arrange(&mut self, nodes: &mut [usize]) -> usize {
        let along = self.longest(nodes);
        self.sort(nodes, along);
        let (mut least, mut middle) = self.best(nodes);
        let count = nodes.len() as f64;
        if least as f64 <= BAD * count.powf(1.0 - 1.0 / D as f64) {
            return middle;
        }
        let mut kept = along;
        for other in (0..D).filter(|&axis| axis != along) {
            self.sort(nodes, other);
            let (size, cut) = self.best(nodes);
            if size < least {
                (least, middle, kept) = (size, cut, other);
            }
        }
        self.sort(nodes, kept);
        middle
    }

    fn longest(&self, nodes: &[usize]) -> usize {
        let extent = |d: usize| {
            let values = || nodes.iter().map(|&n| self.position[n][d]);
            values().fold(f64::NEG_INFINITY, f64::max) - values().fold(f64::INFINITY, f64::min)
        };
        let longer = |along, axis| {
            if extent(axis) > extent(along) {
                axis
            } else {
                along
            }
        };
        (1..D).fold(0, longer)
    }

    fn sort(&self, nodes: &mut [usize], along: usize) {
        nodes.sort_unstable_by(|&a, &b| {
            let (p, q) = (&self.position[a], &self.position[b]);
            let axes = (0..D).map(|k| (along + k) % D);
            let order = axes.fold(Ordering::Equal, |order, axis| {
                order.then_with(|| p[axis].total_cmp(&q[axis]))
            });
            order.then(a.cmp(&b))
        });
    }

    /// Nodes of the smallest separator, and where its cut lies.
    fn best(&mut self, nodes: &[usize]) -> (usize, usize) {
        let place = |fraction: f64| ((nodes.len() as f64 * fraction) as usize).max(1);
        let mut best = (usize::MAX, 0);
        for cut in CUTS.map(place) {
            let size = self.separator(&nodes[..cut], &nodes[cut..]).len();
            if size < best.0 {
                best = (size, cut);
            }
        }
        best
    }

    /// Nodes of `low` with a neighbour in `high`, ascending.
    fn separator(&mut self, low: &[usize], high: &[usize]) -> Vec<usize> {
        self.stamp += 1;
        for &node in high {
            self.side[node] = self.stamp;
        }
        let touches = |node: &usize| {
            self.pattern
                .neighbours(*node)
                .iter()
                .any(|&other| self.side[other] == self.stamp)
        };
        let mut separator: Vec<usize> = low.iter().copied().filter(touches).collect();
        separator.sort_unstable();
        separator
    }
}

/// Boundary of a front: later nodes that its pivots or its children's boundaries touch.
fn find_boundaries<const N: usize>(pattern: &Pattern<N>, fronts: &mut [Front]) {
    let rank = ranks(fronts);
    for k in 0..fronts.len() {
        let last = fronts[k]
            .pivots
            .iter()
            .map(|&node| rank[node])
            .max()
            .unwrap_or(0);
        let touched = fronts[k]
            .pivots
            .iter()
            .flat_map(|&node| pattern.neighbours(node));
        let inherited = fronts[k]
            .children
            .iter()
            .flat_map(|&child| &fronts[child].boundary);
        let later = touched
            .chain(inherited)
            .copied()
            .filter(|&node| rank[node] > last);
        let mut boundary: Vec<usize> = later.collect();
        boundary.sort_unstable_by_key(|&node| rank[node]);
        boundary.dedup();
        fronts[k].boundary = boundary;
    }
}

/// Place of each node in the order of elimination.
pub fn ranks(fronts: &[Front]) -> Vec<usize> {
    let count = fronts.iter().map(|front| front.pivots.len()).sum();
    let mut rank = vec![0; count];
    for (place, &node) in fronts.iter().flat_map(|front| &front.pivots).enumerate() {
        rank[node] = place;
    }
    rank
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::rectangle::Rectangle;

    /// The order of a mesh is one of elimination: every node once, every front with a pivot, and only
    /// ancestors touched.
    fn check(simplices: &[[usize; 3]], position: &[Vector<2>]) {
        let pattern = Pattern::new(position.len(), simplices);
        let fronts = fronts(&pattern, position);
        let mut all: Vec<_> = fronts.iter().flat_map(|f| f.pivots.clone()).collect();
        all.sort_unstable();
        assert!(all.iter().copied().eq(0..position.len()));
        let mut of_node = vec![0; position.len()];
        for (k, front) in fronts.iter().enumerate() {
            assert!(!front.pivots.is_empty());
            front.pivots.iter().for_each(|&node| of_node[node] = k);
        }
        for (k, front) in fronts.iter().enumerate() {
            for &node in &front.boundary {
                let ancestor = &fronts[of_node[node]];
                assert!(ancestor.first <= k && k < of_node[node]);
            }
        }
        assert!(fronts.last().unwrap().boundary.is_empty());
    }

    #[test]
    fn every_node_is_eliminated_once_and_only_ancestors_are_touched() {
        for periodic in [false, true] {
            let mut rectangle = Rectangle::new([0.0; 2], [1.0, 3.0], [20, 60]);
            rectangle.periodic = [periodic; 2];
            let mesh = rectangle.mesh().unwrap();
            check(&mesh.simplices, &mesh.position);
        }
    }

    /// Entries of the factors of one unknown a node.
    fn fill(cells: [usize; 2], upper: [f64; 2]) -> usize {
        let mesh = Rectangle::new([0.0; 2], upper, cells).mesh().unwrap();
        let pattern = Pattern::new(mesh.node_count(), &mesh.simplices);
        let fronts = fronts(&pattern, &mesh.position);
        let of_front = |f: &Front| f.pivots.len() * (f.pivots.len() + 2 * f.boundary.len());
        fronts.iter().map(of_front).sum()
    }

    #[test]
    fn the_order_of_flat_cells_costs_what_that_of_square_ones_costs() {
        for cells in [[10, 400], [400, 10], [60, 60]] {
            let square = fill(cells, [cells[0] as f64, cells[1] as f64]);
            for flat in [30.0, 183.0, 10000.0] {
                let across = fill(cells, [cells[0] as f64 * flat, cells[1] as f64]);
                let upright = fill(cells, [cells[0] as f64, cells[1] as f64 * flat]);
                let ratio = across.max(upright) as f64 / square as f64;
                println!("{cells:?} cells, {flat}: 1 at most: {ratio:.2}");
                assert!(
                    ratio < 1.6,
                    "{cells:?}, {flat}: {across} {upright}, {square}"
                );
            }
        }
    }

    #[test]
    fn flat_cells_and_parts_that_do_not_touch_have_an_order() {
        for (cells, grading) in [([60, 60], 100.0), ([200, 4], 1.0), ([7, 90], 1000.0)] {
            let mut rectangle = Rectangle::new([0.0; 2], [1.0; 2], cells);
            rectangle.grading = [1.0, grading].into();
            let mesh = rectangle.mesh().unwrap();
            check(&mesh.simplices, &mesh.position);
            // The same beside itself, on the same places or apart.
            for away in [0.0, 10.0] {
                let n = mesh.node_count();
                let (mut simplices, mut position) = (mesh.simplices.clone(), mesh.position.clone());
                simplices.extend(mesh.simplices.iter().map(|t| t.map(|node| node + n)));
                position.extend(mesh.position.iter().map(|x| x + Vector::from([away, 0.0])));
                check(&simplices, &position);
            }
        }
    }
}
