//! A mesh of simplices made of what a file says.
//!
//! Quadrilaterals are cut along their shorter diagonal, hexahedra, prisms and pyramids into tetrahedra, curved elements have straight sides between their
//! corners, left-handed (clockwise) elements are turned, nodes that nothing uses are left out. Nodes are
//! numbered in the order of their numbers in the file.

use std::collections::BTreeSet;
use std::path::Path;

use space::simplex::determinant;
use space::{Dim, Dimension, Vector, hypot};

use crate::cells::tetrahedra;
use crate::error::{Error, Faults};
use crate::file::{Element, File};
use crate::filling::Filling;
use crate::mesh::{Mesh, Options, Pieces};
use crate::sides::Sides;
use crate::{borders, topology};

/// Distances out of the plane, of the extent of the mesh, that are round-off.
const PLANE: f64 = 1e-9;
/// D! times the volume over the D-th power of the longest edge below which an element is flat.
const FLAT: f64 = 1e-10;

impl<const D: usize, const N: usize> Mesh<D, N>
where
    Dim<D>: Dimension<D>,
{
    /// Read a file. Everything that is wrong with the mesh is told at once.
    pub fn read(path: &Path, options: &Options) -> Result<Mesh<D, N>, Error> {
        Mesh::of(&File::read(path)?, options)
    }

    /// The mesh of a file.
    pub fn of(file: &File, options: &Options) -> Result<Mesh<D, N>, Error> {
        let mut faults = Faults::default();
        let mesh = Mesh::build(file, options, &mut faults);
        match mesh {
            Some(mesh) if faults.is_empty() => Ok(mesh),
            _ => Err(Error::Unusable {
                path: file.path.clone(),
                faults,
            }),
        }
    }

    fn build(file: &File, options: &Options, faults: &mut Faults) -> Option<Mesh<D, N>> {
        let filling = Filling::of::<D>(file, options, faults);
        if filling.elements.is_empty() {
            let (simplex, measure) = (Dim::<D>::SIMPLEX, ["volume", "surface"][usize::from(N < 4)]);
            if faults.is_empty() {
                faults.note(format!(
                    "no {simplex}s: does a physical {measure} cover the domain, and was the mesh made in \
                     {D} dimensions (gmsh -{D})?"
                ));
            }
            return None;
        }
        let mut mesh = Mesh {
            position: Vec::new(),
            node_number: Vec::new(),
            simplices: Vec::new(),
            element: Vec::new(),
            borders: Vec::new(),
            notes: Vec::new(),
        };
        check_flat_space::<D>(file, &filling, faults);
        let pieces = mesh.cut(file, &filling, faults);
        mesh.number(file, options.scale, &pieces);
        if !faults.is_empty() {
            return None;
        }
        let sides = Sides::of(&mesh.simplices);
        borders::check_regions(&sides, &mesh, file, &pieces, options, faults);
        topology::check(&mesh, &sides, faults);
        mesh.borders = borders::find(&sides, &mesh, file, &pieces, options, faults);
        Some(mesh)
    }

    /// Simplices of the elements, turned where they are left-handed.
    fn cut(&mut self, file: &File, filling: &Filling<'_>, faults: &mut Faults) -> Pieces<N> {
        let mut pieces = Pieces {
            nodes: Vec::new(),
            element: Vec::new(),
            labels: Vec::new(),
        };
        let (mut turned, mut curved, mut cut) = (0, 0, 0);
        for (element, labels) in &filling.elements {
            let corners = element.nodes.map(|n| place::<D>(file, n));
            let Some(parts) = parts::<D, N>(element, &corners) else {
                let (number, simplex) = (element.number, Dim::<D>::SIMPLEX);
                let count = element.corners;
                faults.note(format!(
                    "element {number} has {count} corners; {simplex}s are read, in the plane quadrilaterals, in space \
                     hexahedra, prisms and pyramids"
                ));
                continue;
            };
            curved += usize::from(element.curved);
            cut += usize::from(parts.len() > 1);
            for part in parts {
                let mut nodes = part.map(|k| element.nodes[k]);
                let measure = determinant(&part.map(|k| corners[k]));
                let longest = longest_edge(&part.map(|k| corners[k]));
                if measure.abs() <= FLAT * longest.powi(D as i32) {
                    faults.note(flat::<D, N>(file, element.number, &nodes, measure));
                }
                if measure < 0.0 {
                    nodes.swap(N - 2, N - 1);
                    turned += usize::from(D < 3 || element.corners == N);
                }
                pieces.nodes.push(nodes);
                pieces.element.push(element.number);
                pieces.labels.push(labels.clone());
            }
        }
        let mut tell = |count: usize, what: &str| {
            if count > 0 {
                self.notes.push(format!("{count} {what}"));
            }
        };
        tell(turned, "elements are left-handed (clockwise): turned");
        tell(
            cut,
            [
                "quadrilaterals: each cut in two",
                "cells cut into tetrahedra",
            ][D - 2],
        );
        tell(
            curved,
            "elements have curved sides: straight between their corners",
        );
        pieces
    }

    /// Number the nodes that are used.
    fn number(&mut self, file: &File, scale: f64, pieces: &Pieces<N>) {
        let used: BTreeSet<u64> = pieces.nodes.iter().flatten().copied().collect();
        self.node_number = used.into_iter().collect();
        let at = |number: &u64| place::<D>(file, *number).map(|x| scaled(x, scale));
        self.position = self.node_number.iter().map(at).collect();
        let index = |number| self.node_number.partition_point(|&known| known < number);
        self.simplices = pieces.nodes.iter().map(|nodes| nodes.map(index)).collect();
        self.element.clone_from(&pieces.element);
        let unused = file.nodes.len() - self.node_number.len();
        if unused > 0 {
            self.notes.push(format!(
                "{unused} nodes belong to no element of the domain: left out"
            ));
        }
    }
}

/// A coordinate in metres; the same bits where the file has metres.
fn scaled(x: f64, scale: f64) -> f64 {
    if scale == 1.0 { x } else { x * scale }
}

/// Coordinates of a node, as the file has them.
fn place<const D: usize>(file: &File, number: u64) -> Vector<D> {
    let at = file.nodes.get(&number).copied().unwrap_or_default();
    std::array::from_fn(|d| at[d]).into()
}

/// Corners of the simplices that an element is cut into.
fn parts<const D: usize, const N: usize>(
    element: &Element,
    corners: &[Vector<D>; 8],
) -> Option<Vec<[usize; N]>>
where
    Dim<D>: Dimension<D>,
{
    if element.corners == N {
        return Some(vec![std::array::from_fn(|k| k)]);
    }
    if let Some(parts) = tetrahedra(element) {
        let part = |corners: [usize; 4]| std::array::from_fn(|k| corners[k]);
        return Some(parts.into_iter().map(part).collect());
    }
    if element.dimension != 2 || element.corners != 4 {
        return None;
    }
    let halves = |shift: usize| {
        let half = |ends: [usize; 3]| -> [usize; N] {
            std::array::from_fn(|k| (ends[k.min(2)] + shift) % 4)
        };
        [half([0, 1, 2]), half([0, 2, 3])]
    };
    let least = |halves: &[[usize; N]; 2]| {
        let size = halves.map(|half| determinant(&half.map(|k| corners[k])));
        // Halves of different hands: that diagonal lies outside.
        size[0].signum() * size[1].signum() * size[0].abs().min(size[1].abs())
    };
    let length = |a: usize, b: usize| hypot(&(corners[a] - corners[b]));
    let (one, other) = (halves(0), halves(1));
    let shorter = length(0, 2) <= length(1, 3);
    let (first, second) = if shorter { (one, other) } else { (other, one) };
    let chosen = if least(&first) > 0.0 { first } else { second };
    Some(chosen.to_vec())
}

fn longest_edge<const D: usize, const N: usize>(corners: &[Vector<D>; N]) -> f64 {
    let pairs = (0..N).flat_map(|a| (0..a).map(move |b| (a, b)));
    pairs
        .map(|(a, b)| hypot(&(corners[a] - corners[b])))
        .fold(0.0, f64::max)
}

fn flat<const D: usize, const N: usize>(
    file: &File,
    element: u64,
    nodes: &[u64; N],
    measure: f64,
) -> String
where
    Dim<D>: Dimension<D>,
{
    let corners: Vec<String> = nodes
        .iter()
        .map(|&n| format!("{n} at {:?}", place::<D>(file, n).as_slice()))
        .collect();
    let (what, size) = (
        Dim::<D>::MEASURE,
        measure / space::dimension::factorial(D) as f64,
    );
    let corners = corners.join(", ");
    format!("element {element} is flat: nodes {corners} have the {what} {size:e}")
}

/// Coordinates beyond the first D must be the same for all nodes that are used, but for round-off.
fn check_flat_space<const D: usize>(file: &File, filling: &Filling<'_>, faults: &mut Faults) {
    let corners =
        |(element, _): &(&Element, Vec<String>)| element.nodes[..element.corners].to_vec();
    let used: BTreeSet<u64> = filling.elements.iter().flat_map(corners).collect();
    let axis = |k: usize| {
        let values = used.iter().map(|n| file.nodes[n][k]);
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
            (low.min(x), high.max(x))
        })
    };
    let extent = (0..3)
        .map(axis)
        .map(|(low, high)| high - low)
        .fold(0.0, f64::max);
    for k in D..3 {
        let (low, high) = axis(k);
        if high - low > PLANE * extent {
            let first = used.iter().next().map_or(0.0, |n| file.nodes[n][k]);
            let far = used
                .iter()
                .find(|n| (file.nodes[n][k] - first).abs() > PLANE * extent);
            let far = far.copied().unwrap_or_default();
            let value = file.nodes.get(&far).map_or(0.0, |at| at[k]);
            faults.note(format!(
                "node {far}: z = {value} differs from {first}; the mesh must be plane"
            ));
        }
    }
}
