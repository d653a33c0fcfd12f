//! Groups, sizes and qualities of a mesh, for people.

use std::collections::{BTreeMap, BTreeSet};

use space::simplex::determinant;
use space::{Dim, Dimension, Vector, hypot};

use crate::cells::tetrahedra;
use crate::file::{Element, File};
use crate::mesh::Mesh;

/// A surface or a curve, by what the file says of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Group {
    /// Of its elements.
    pub dimension: usize,
    /// Names or numbers of its physical groups, or the number of its entity.
    pub labels: Vec<String>,
    /// Numbers of its entities.
    pub entities: BTreeSet<i64>,
    /// Elements.
    pub elements: usize,
    /// Their length, area or volume, in the units of the file.
    pub size: f64,
}

/// How good the simplices of a mesh are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quality {
    /// Volume over that of a regular simplex with the same mean square of edges: 1 is the best.
    pub least: f64,
    /// Mean of that.
    pub mean: f64,
    /// Its element.
    pub worst: u64,
    /// Longest edge over the shortest height: of right-angled halves of a cell its aspect.
    pub aspect: f64,
    /// Its element.
    pub longest: u64,
    /// Shortest and longest edge \[m\].
    pub edges: [f64; 2],
}

/// The groups of a file that may be domain or boundary in `D` dimensions.
pub fn groups<const D: usize>(file: &File) -> Vec<Group> {
    let mut groups: BTreeMap<(usize, Vec<String>), Group> = BTreeMap::new();
    let wanted = |element: &&Element| element.dimension == D || element.dimension + 1 == D;
    for element in file.elements.iter().filter(wanted) {
        let labels = file.labels(element);
        let key = (D - element.dimension, labels.clone());
        let group = groups.entry(key).or_insert_with(|| Group {
            dimension: element.dimension,
            labels,
            entities: BTreeSet::new(),
            elements: 0,
            size: 0.0,
        });
        group.entities.insert(element.entity);
        group.elements += 1;
        group.size += size(file, element);
    }
    groups.into_values().collect()
}

/// Length, area or volume of an element with straight sides; 0 of points.
fn size(file: &File, element: &Element) -> f64 {
    let at = |k: usize| Vector::<3>::from(file.nodes[&element.nodes[k]]);
    match (element.dimension, element.corners) {
        (1, _) => hypot(&(at(1) - at(0))),
        (2, 3) => 0.5 * hypot(&(at(1) - at(0)).cross(&(at(2) - at(0)))),
        (2, 4) => 0.5 * hypot(&(at(2) - at(0)).cross(&(at(3) - at(1)))),
        (3, 4) => volume([0, 1, 2, 3].map(at)),
        _ => {
            let parts = tetrahedra(element).unwrap_or_default();
            parts.iter().map(|part| volume(part.map(at))).sum()
        }
    }
}

fn volume([a, b, c, d]: [Vector<3>; 4]) -> f64 {
    (b - a).dot(&(c - a).cross(&(d - a))).abs() / 6.0
}

/// How good the simplices are.
pub fn quality<const D: usize, const N: usize>(mesh: &Mesh<D, N>) -> Quality
where
    Dim<D>: Dimension<D>,
{
    let mut quality = Quality {
        least: f64::INFINITY,
        mean: 0.0,
        worst: 0,
        aspect: 0.0,
        longest: 0,
        edges: [f64::INFINITY, 0.0],
    };
    for (nodes, &element) in mesh.simplices.iter().zip(&mesh.element) {
        let corners = nodes.map(|n| mesh.position[n]);
        let (own, aspect) = quality.see(&corners);
        quality.mean += own / mesh.simplices.len() as f64;
        if own < quality.least {
            (quality.least, quality.worst) = (own, element);
        }
        if aspect > quality.aspect {
            (quality.aspect, quality.longest) = (aspect, element);
        }
    }
    quality
}

impl Quality {
    /// Quality and aspect of a simplex, whose edges are noted.
    fn see<const D: usize, const N: usize>(&mut self, corners: &[Vector<D>; N]) -> (f64, f64)
    where
        Dim<D>: Dimension<D>,
    {
        let pairs = (0..N).flat_map(|a| (0..a).map(move |b| (a, b)));
        let lengths: Vec<f64> = pairs
            .map(|(a, b)| hypot(&(corners[a] - corners[b])))
            .collect();
        let longest = lengths.iter().copied().fold(0.0, f64::max);
        self.edges[0] = lengths.iter().copied().fold(self.edges[0], f64::min);
        self.edges[1] = self.edges[1].max(longest);
        let squares = lengths.iter().map(|l| l * l).sum::<f64>() / lengths.len() as f64;
        let measure = determinant(corners);
        // D! V = √((D + 1)/2^D) l^D of a regular simplex.
        let regular = (N as f64 / 2f64.powi(D as i32)).sqrt() * squares.powf(D as f64 / 2.0);
        let facets = space::simplex::cofactors(corners);
        let largest = facets.iter().map(hypot).fold(0.0, f64::max);
        (measure / regular, longest * largest / measure)
    }
}
