//! In which order nodes are eliminated, and in which groups.
//!
//! The order is one of approximate minimum degree (Amestoy, Davis and Duff 1996, faer's). Nodes with the same boundary,
//! and those that are cheaper together, are a *front* and are eliminated together (Liu, Ng and Peyton 1993): zeros
//! cost less than another small front.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::SymbolicSparseColMatRef;
use faer::sparse::linalg::amd;

use super::pattern::Pattern;
use super::real::PANEL;
use crate::error::FluidError;

/// What a front costs beside its entries and operations, in nanoseconds.
const FRONT: f64 = 400.0;
/// Of an entry.
const ENTRY: f64 = 0.4;
/// Of an operation.
const OPERATION: f64 = 1.0 / 40.0;

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

/// Operations of a front with so many unknowns that are eliminated and that stay.
pub fn operations(pivots: usize, boundary: usize) -> f64 {
    let (k, m) = (pivots as f64, boundary as f64);
    2.0 * k * (k * k / 3.0 + k * m + m * m)
}

/// Nanoseconds that a front costs, N unknowns a node.
fn cost<const N: usize>(pivots: usize, boundary: usize) -> f64 {
    let entries = (N * (pivots + boundary)).pow(2) as f64;
    let panels = (N * pivots).next_multiple_of(PANEL);
    FRONT + OPERATION * operations(panels, N * boundary) + ENTRY * entries
}

/// The fronts, children before parents; each tree ends where the next begins.
pub fn fronts<const N: usize>(pattern: &Pattern<N>) -> Result<Vec<Front>, FluidError> {
    let order = minimum_degree(pattern)?;
    let groups = Groups::new(pattern, &order);
    Ok(groups.fronts(&order))
}

/// Node eliminated at each place.
fn minimum_degree<const N: usize>(pattern: &Pattern<N>) -> Result<Vec<usize>, FluidError> {
    let n = pattern.nodes();
    let entries = pattern.blocks();
    let graph =
        SymbolicSparseColMatRef::new_checked(n, n, &pattern.start, None, &pattern.neighbour);
    let (mut order, mut place) = (vec![0; n], vec![0; n]);
    let failed = |error: String| FluidError::Factorisation(format!("order: {error}"));
    let mut memory = MemBuffer::try_new(amd::order_scratch::<usize>(n, entries))
        .map_err(|_| failed("out of memory".into()))?;
    let stack = MemStack::new(&mut memory);
    amd::order(&mut order, &mut place, graph, Default::default(), stack)
        .map_err(|error| failed(format!("{error:?}")))?;
    Ok(order)
}

/// Groups of places, each known by its last.
struct Groups {
    /// Places, none where a group has come into another.
    pivots: Vec<Vec<usize>>,
    /// Later places that the group touches, ascending.
    boundary: Vec<Vec<usize>>,
    children: Vec<Vec<usize>>,
    /// Groups that are no child.
    roots: Vec<usize>,
}

impl Groups {
    fn new<const N: usize>(pattern: &Pattern<N>, order: &[usize]) -> Groups {
        let n = order.len();
        let mut place = vec![0; n];
        for (k, &node) in order.iter().enumerate() {
            place[node] = k;
        }
        let parent = elimination_tree(pattern, order, &place);
        let mut groups = Groups {
            pivots: (0..n).map(|k| vec![k]).collect(),
            boundary: vec![Vec::new(); n],
            children: vec![Vec::new(); n],
            roots: (0..n).filter(|&k| parent[k].is_none()).collect(),
        };
        let mut below = vec![Vec::new(); n];
        let mut seen = vec![usize::MAX; n];
        for j in 0..n {
            let own = pattern.neighbours(order[j]).iter().map(|&node| place[node]);
            let of_children = below[j]
                .iter()
                .flat_map(|&c: &usize| groups.boundary[c].iter());
            let touched = own.chain(of_children.copied());
            let new = |&k: &usize| k > j && std::mem::replace(&mut seen[k], j) != j;
            let mut boundary: Vec<usize> = touched.filter(new).collect();
            boundary.sort_unstable();
            groups.boundary[j] = boundary;
            groups.merge::<N>(j, std::mem::take(&mut below[j]));
            if let Some(parent) = parent[j] {
                below[parent].push(j);
            }
        }
        groups
    }

    /// Take in those children of a group with which it is cheaper together.
    fn merge<const N: usize>(&mut self, j: usize, mut children: Vec<usize>) {
        children.sort_by_key(|&c| std::cmp::Reverse(self.boundary[c].len()));
        let stays = self.boundary[j].len();
        for child in children {
            let (own, theirs) = (self.pivots[j].len(), self.pivots[child].len());
            let apart = cost::<N>(theirs, self.boundary[child].len()) + cost::<N>(own, stays);
            if cost::<N>(theirs + own, stays) > apart {
                self.children[j].push(child);
                continue;
            }
            let own = std::mem::take(&mut self.pivots[j]);
            self.pivots[j] = std::mem::take(&mut self.pivots[child]);
            self.pivots[j].extend(own);
            self.boundary[child] = Vec::new();
            let theirs = std::mem::take(&mut self.children[child]);
            self.children[j].extend(theirs);
        }
    }

    /// Number them, children before parents.
    fn fronts(self, order: &[usize]) -> Vec<Front> {
        let mut fronts: Vec<Front> = Vec::new();
        let mut number = vec![0; order.len()];
        let mut stack: Vec<(usize, usize, usize)> = Vec::new();
        for &root in &self.roots {
            stack.push((root, 0, fronts.len()));
            while let Some((group, next, first)) = stack.pop() {
                if let Some(&child) = self.children[group].get(next) {
                    stack.push((group, next + 1, first));
                    stack.push((child, 0, fronts.len()));
                    continue;
                }
                number[group] = fronts.len();
                let nodes = |places: &[usize]| places.iter().map(|&k| order[k]).collect();
                let children = self.children[group].iter().map(|&child| number[child]);
                fronts.push(Front {
                    pivots: nodes(&self.pivots[group]),
                    boundary: nodes(&self.boundary[group]),
                    children: children.collect(),
                    first,
                });
            }
        }
        let rank = ranks(&fronts);
        for front in &mut fronts {
            front.boundary.sort_unstable_by_key(|&node| rank[node]);
        }
        fronts
    }
}

/// For each place the next one that its elimination touches (Liu 1990).
fn elimination_tree<const N: usize>(
    pattern: &Pattern<N>,
    order: &[usize],
    place: &[usize],
) -> Vec<Option<usize>> {
    let mut parent = vec![None; order.len()];
    let mut ancestor: Vec<Option<usize>> = vec![None; order.len()];
    for k in 0..order.len() {
        for &node in pattern.neighbours(order[k]) {
            let mut at = place[node];
            while at < k {
                match ancestor[at].replace(k) {
                    Some(next) => at = next,
                    None => {
                        parent[at] = Some(k);
                        break;
                    }
                }
            }
        }
    }
    parent
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
    fn check(simplices: &[[usize; 3]], nodes: usize) -> Vec<Front> {
        let pattern = Pattern::new(nodes, simplices);
        let fronts = fronts(&pattern).unwrap();
        let mut all: Vec<_> = fronts.iter().flat_map(|f| f.pivots.clone()).collect();
        all.sort_unstable();
        assert!(all.iter().copied().eq(0..nodes));
        let mut of_node = vec![0; nodes];
        for (k, front) in fronts.iter().enumerate() {
            assert!(!front.pivots.is_empty());
            front.pivots.iter().for_each(|&node| of_node[node] = k);
        }
        for (k, front) in fronts.iter().enumerate() {
            for &node in &front.boundary {
                let ancestor = &fronts[of_node[node]];
                assert!(ancestor.first <= k && k < of_node[node]);
            }
            for &child in &front.children {
                assert!(front.first <= fronts[child].first && child < k);
            }
        }
        fronts
    }

    /// Entries of the factors of one unknown a node.
    fn fill(fronts: &[Front]) -> usize {
        let of_front = |f: &Front| f.pivots.len() * (f.pivots.len() + 2 * f.boundary.len());
        fronts.iter().map(of_front).sum()
    }

    #[test]
    fn every_node_is_eliminated_once_and_only_ancestors_are_touched() {
        for periodic in [false, true] {
            let mut rectangle = Rectangle::new([0.0; 2], [1.0, 3.0], [20, 60]);
            rectangle.periodic = [periodic; 2];
            let mesh = rectangle.mesh().unwrap();
            check(&mesh.simplices, mesh.node_count());
        }
    }

    #[test]
    fn parts_that_do_not_touch_have_an_order() {
        let mesh = Rectangle::new([0.0; 2], [1.0; 2], [7, 90]).mesh().unwrap();
        let n = mesh.node_count();
        let mut simplices = mesh.simplices.clone();
        simplices.extend(mesh.simplices.iter().map(|t| t.map(|node| node + n)));
        let roots = |fronts: &[Front]| fronts.iter().filter(|f| f.boundary.is_empty()).count();
        assert_eq!(roots(&check(&simplices, 2 * n)), 2);
    }

    /// In a square, the least fill is of the order n log2 n (George 1973). Minimum degree has less than that of a
    /// nested dissection here, and grows faster.
    #[test]
    fn fill_is_that_of_a_good_order() {
        for cells in [20, 40, 80, 160] {
            let mesh = Rectangle::new([0.0; 2], [1.0; 2], [cells; 2])
                .mesh()
                .unwrap();
            let n = mesh.node_count() as f64;
            let fronts = check(&mesh.simplices, mesh.node_count());
            let ratio = fill(&fronts) as f64 / (n * n.log2());
            println!(
                "{n} nodes: {} fronts, fill {ratio:.2} n log2 n",
                fronts.len()
            );
            assert!(ratio < 4.5, "{ratio}");
        }
    }
}
