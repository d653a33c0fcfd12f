//! What makes simplices no mesh: places that two of them claim, nodes that are there twice or hang.

use space::simplex::determinant;
use space::{Dim, Dimension, dot, hypot};

use crate::error::Faults;
use crate::mesh::Mesh;
use crate::sides::{Side, Sides};

/// Distance, of the extent of the mesh, below which two nodes are at one place.
const NEAR: f64 = 1e-12;
/// Sides that are searched for a node that hangs there.
const SEARCHED: usize = 50;

/// Note what is wrong with the simplices of a mesh.
pub(crate) fn check<const D: usize, const N: usize>(
    mesh: &Mesh<D, N>,
    sides: &Sides<D>,
    faults: &mut Faults,
) where
    Dim<D>: Dimension<D>,
{
    twice(mesh, faults);
    for group in sides.groups() {
        match group {
            [_] => {}
            [one, other] => {
                if is_above(mesh, one) == is_above(mesh, other) {
                    let [a, b] = [one, other].map(|side| mesh.element[side.simplex]);
                    let nodes = one.nodes.map(|n| mesh.node_number[n]);
                    faults.note(format!(
                        "elements {a} and {b} lie on the same side of the {} of nodes {nodes:?} that they share",
                        Dim::<D>::FACET
                    ));
                }
            }
            many => {
                let elements: Vec<u64> = many.iter().map(|s| mesh.element[s.simplex]).collect();
                let nodes = many[0].nodes.map(|n| mesh.node_number[n]);
                faults.note(format!(
                    "the {} of nodes {nodes:?} belongs to {} elements, {elements:?}; at most 2",
                    Dim::<D>::FACET,
                    many.len()
                ));
            }
        }
    }
}

/// On which side of the nodes of a side, as they are ordered, the simplex lies.
fn is_above<const D: usize, const N: usize>(mesh: &Mesh<D, N>, side: &Side<D>) -> bool
where
    Dim<D>: Dimension<D>,
{
    let opposite = mesh.simplices[side.simplex][side.corner];
    let corners: [_; N] = std::array::from_fn(|k| {
        let node = side.nodes.get(k).copied().unwrap_or(opposite);
        mesh.position[node]
    });
    determinant(&corners) > 0.0
}

/// Extent of the mesh \[m\].
fn extent<const D: usize, const N: usize>(mesh: &Mesh<D, N>) -> f64 {
    let side = |d: usize| {
        let values = || mesh.position.iter().map(|x| x[d]);
        values().fold(f64::NEG_INFINITY, f64::max) - values().fold(f64::INFINITY, f64::min)
    };
    (0..D).map(side).fold(0.0, f64::max)
}

/// Nodes at the place of another.
fn twice<const D: usize, const N: usize>(mesh: &Mesh<D, N>, faults: &mut Faults) {
    let near = (NEAR * extent(mesh)).max(f64::MIN_POSITIVE);
    let mut found = Vec::new();
    // Cells of twice the distance, and the same shifted by half of one.
    for shift in [0.0, 0.5] {
        let cell = |x: f64| (x / (2.0 * near) + shift).floor();
        let key = |n: usize| mesh.position[n].map(cell);
        let order = |a: usize, b: usize| {
            let (p, q) = (key(a), key(b));
            let pairs = p.iter().zip(q.iter());
            pairs.fold(std::cmp::Ordering::Equal, |order, (x, y)| {
                order.then(x.total_cmp(y))
            })
        };
        let mut nodes: Vec<usize> = (0..mesh.position.len()).collect();
        nodes.sort_by(|&a, &b| order(a, b));
        let pairs = nodes
            .windows(2)
            .filter(|pair| order(pair[0], pair[1]).is_eq());
        found.extend(pairs.map(|pair| (pair[0].min(pair[1]), pair[0].max(pair[1]))));
    }
    found.sort_unstable();
    found.dedup();
    for (a, b) in found {
        let place = mesh.position[a].as_slice();
        let [a, b] = [a, b].map(|n| mesh.node_number[n]);
        faults.note(format!(
            "nodes {a} and {b} are both at {place:?}: merge them"
        ));
    }
}

/// Nodes that lie on a side of the boundary without being one of its corners.
pub(crate) fn hanging<const D: usize, const N: usize>(
    mesh: &Mesh<D, N>,
    sides: &[Side<D>],
) -> Vec<String> {
    let mut found = Vec::new();
    for side in sides.iter().take(SEARCHED) {
        let corners = side.nodes.map(|n| mesh.position[n]);
        // Along the first edge of the side: in the plane the side itself.
        let along = corners[1] - corners[0];
        let squared = dot(&along, &along);
        for (node, at) in mesh.position.iter().enumerate() {
            let t = dot(&(at - corners[0]), &along) / squared;
            let off = hypot(&(at - (corners[0] + along * t)));
            if t > 1e-9 && t < 1.0 - 1e-9 && off < 1e-9 * squared.sqrt() {
                let [a, b] = [0, 1].map(|k| mesh.node_number[side.nodes[k]]);
                found.push(format!(
                    "node {} hangs on the side of element {} between nodes {a} and {b}, which is not divided \
                     there",
                    mesh.node_number[node], mesh.element[side.simplex]
                ));
            }
        }
    }
    found
}
