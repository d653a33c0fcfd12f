//! Hexahedra, prisms and pyramids as tetrahedra.
//!
//! Every face is cut along the diagonal from the one of its corners with the smallest number, so that two cells that
//! share it cut it alike. A cell is its corner of the smallest number before the triangles of all faces that it is not
//! on: those it is on are cut from it, too.

use crate::file::Element;

/// Faces by their corners, one after the other (Gmsh's order of nodes); three or four corners each.
const HEXAHEDRON: [&[usize]; 6] = [
    &[0, 3, 2, 1],
    &[4, 5, 6, 7],
    &[0, 1, 5, 4],
    &[1, 2, 6, 5],
    &[2, 3, 7, 6],
    &[3, 0, 4, 7],
];
const PRISM: [&[usize]; 5] = [
    &[0, 2, 1],
    &[3, 4, 5],
    &[0, 1, 4, 3],
    &[1, 2, 5, 4],
    &[2, 0, 3, 5],
];
const PYRAMID: [&[usize]; 5] = [
    &[0, 3, 2, 1],
    &[0, 1, 4],
    &[1, 2, 4],
    &[2, 3, 4],
    &[3, 0, 4],
];

/// Triangles of a face, as corners of its cell.
pub(crate) fn triangles(face: &[usize], node: impl Fn(usize) -> u64) -> Vec<[usize; 3]> {
    let count = face.len();
    let first = (0..count).min_by_key(|&k| node(face[k])).unwrap_or(0);
    let corner = |k: usize| face[(first + k) % count];
    (1..count - 1)
        .map(|k| [corner(0), corner(k), corner(k + 1)])
        .collect()
}

/// Corners of the tetrahedra that a cell is cut into; none of an element that is no such cell.
pub(crate) fn tetrahedra(element: &Element) -> Option<Vec<[usize; 4]>> {
    let faces: &[&[usize]] = match (element.dimension, element.corners) {
        (3, 8) => &HEXAHEDRON,
        (3, 6) => &PRISM,
        (3, 5) => &PYRAMID,
        _ => return None,
    };
    let node = |k: usize| element.nodes[k];
    let first = (0..element.corners).min_by_key(|&k| node(k))?;
    let beyond = faces.iter().filter(|face| !face.contains(&first));
    let parts = beyond.flat_map(|face| triangles(face, node));
    Some(parts.map(|[a, b, c]| [first, a, b, c]).collect())
}
