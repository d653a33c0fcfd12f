//! A mesh of simplices, and what is said about it.

use std::collections::BTreeSet;

use space::Vector;

/// What a scene says about a file.
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    /// Metres of a unit of the file.
    pub scale: f64,
    /// Names or numbers of the surfaces (in space: volumes) that are filled; none: the only one.
    pub surfaces: Vec<String>,
}

impl Default for Options {
    fn default() -> Options {
        Options {
            scale: 1.0,
            surfaces: Vec::new(),
        }
    }
}

/// A mesh of simplices with `N = D + 1` corners.
#[derive(Debug, Clone, PartialEq)]
pub struct Mesh<const D: usize, const N: usize> {
    /// Coordinates of each node \[m\].
    pub position: Vec<Vector<D>>,
    /// The number of each node in the file.
    pub node_number: Vec<u64>,
    /// Nodes of each simplex, right-handed.
    pub simplices: Vec<[usize; N]>,
    /// The number in the file of the element that each simplex is (a part of).
    pub element: Vec<u64>,
    /// The boundary, by what the file says of it.
    pub borders: Vec<Border<D>>,
    /// What was read otherwise than written, for people.
    pub notes: Vec<String>,
}

/// A part of the boundary.
#[derive(Debug, Clone, PartialEq)]
pub struct Border<const D: usize> {
    /// Its physical groups, by name or number; without a group the number of its curve.
    pub labels: Vec<String>,
    /// Numbers of its curves (in space: surfaces).
    pub entities: BTreeSet<i64>,
    /// Nodes of its facets, so that their normals point outward: in the plane the domain is on the left.
    pub facets: Vec<[usize; D]>,
}

impl<const D: usize> Border<D> {
    /// Which of its labels counts: the first that has a condition of its own, else the first.
    pub fn name(&self, has_condition: impl Fn(&str) -> bool) -> &str {
        let own = self.labels.iter().find(|label| has_condition(label));
        own.unwrap_or(&self.labels[0])
    }
}

/// Simplices while they are made: nodes by their numbers in the file.
pub(crate) struct Pieces<const N: usize> {
    pub(crate) nodes: Vec<[u64; N]>,
    pub(crate) element: Vec<u64>,
    pub(crate) labels: Vec<Vec<String>>,
}
