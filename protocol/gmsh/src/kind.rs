//! Which elements there are.

/// What an element type is: of which dimension, how many corners, how many nodes (corners first).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Kind {
    pub(crate) dimension: usize,
    pub(crate) corners: usize,
    pub(crate) nodes: usize,
}

/// Type, dimension, corners, nodes: the types of the Gmsh manual up to the fifth order.
const KINDS: [(i64, usize, usize, usize); 36] = [
    (15, 0, 1, 1),
    (1, 1, 2, 2),
    (8, 1, 2, 3),
    (26, 1, 2, 4),
    (27, 1, 2, 5),
    (28, 1, 2, 6),
    (2, 2, 3, 3),
    (9, 2, 3, 6),
    (20, 2, 3, 9),
    (21, 2, 3, 10),
    (22, 2, 3, 12),
    (23, 2, 3, 15),
    (24, 2, 3, 15),
    (25, 2, 3, 21),
    (3, 2, 4, 4),
    (10, 2, 4, 9),
    (16, 2, 4, 8),
    (36, 2, 4, 16),
    (37, 2, 4, 25),
    (38, 2, 4, 36),
    (39, 2, 4, 12),
    (40, 2, 4, 16),
    (41, 2, 4, 20),
    (4, 3, 4, 4),
    (11, 3, 4, 10),
    (29, 3, 4, 20),
    (30, 3, 4, 35),
    (31, 3, 4, 56),
    (5, 3, 8, 8),
    (12, 3, 8, 27),
    (17, 3, 8, 20),
    (6, 3, 6, 6),
    (13, 3, 6, 18),
    (18, 3, 6, 15),
    (7, 3, 5, 5),
    (14, 3, 5, 14),
];

/// The kind of an element type.
pub(crate) fn kind(number: i64) -> Option<Kind> {
    let found = KINDS.iter().find(|kind| kind.0 == number);
    found.map(|&(_, dimension, corners, nodes)| Kind {
        dimension,
        corners,
        nodes,
    })
}
