//! The outline of a Gmsh 4.1 text file: nodes, triangles, and lines with the names of their curves.

use std::collections::BTreeMap;
use std::path::Path;
use std::str::FromStr;

use crate::mesh_names::{physical_curves, section};
use crate::outline::{Edge, single_edges};

/// Element types of Gmsh.
const LINE: usize = 1;
const TRIANGLE: usize = 2;

/// The edges of a mesh; none where the file cannot be read so far, which the fluid engine tells better.
pub fn edges(path: &Path) -> Option<Vec<Edge>> {
    let text = std::fs::read_to_string(path).ok()?;
    let (numbers, position) = nodes(&mut Words::of(section(&text, "Nodes")?))?;
    let names = physical_curves(section(&text, "PhysicalNames").unwrap_or_default());
    let curves = curve_names(&mut Words::of(section(&text, "Entities")?), &names)?;
    let elements = elements(&mut Words::of(section(&text, "Elements")?), &numbers)?;
    let lines = elements.lines.into_iter();
    let named = lines.filter_map(|([a, b], curve)| {
        let name = curves.get(&curve)?.clone();
        Some(([a.min(b), a.max(b)], name))
    });
    let edges = single_edges(&position, &elements.triangles, &named.collect());
    (!edges.is_empty()).then_some(edges)
}

/// The numbers of a section, one after the other.
struct Words<'a>(std::str::SplitAsciiWhitespace<'a>);

impl<'a> Words<'a> {
    fn of(section: &'a str) -> Words<'a> {
        Words(section.split_ascii_whitespace())
    }

    fn next<T: FromStr>(&mut self) -> Option<T> {
        self.0.next()?.parse().ok()
    }

    fn skip(&mut self, count: usize) -> Option<()> {
        (0..count).try_for_each(|_| self.0.next().map(drop))
    }
}

/// Where the node with a number of the file stands.
type Places = BTreeMap<usize, usize>;

/// Places of the nodes, and where each node of the file stands among them.
fn nodes(words: &mut Words<'_>) -> Option<(Places, Vec<[f64; 2]>)> {
    let blocks: usize = words.next()?;
    words.skip(3)?;
    let (mut numbers, mut position) = (BTreeMap::new(), Vec::new());
    for _ in 0..blocks {
        words.skip(3)?;
        let count: usize = words.next()?;
        for place in 0..count {
            numbers.insert(words.next()?, position.len() + place);
        }
        for _ in 0..count {
            position.push([words.next()?, words.next()?]);
            words.skip(1)?;
        }
    }
    Some((numbers, position))
}

/// Names of the curves that have one, by their numbers.
fn curve_names(
    words: &mut Words<'_>,
    names: &BTreeMap<i64, String>,
) -> Option<BTreeMap<i64, String>> {
    let (points, curves): (usize, usize) = (words.next()?, words.next()?);
    words.skip(2)?;
    for _ in 0..points {
        words.skip(4)?;
        let groups = words.next()?;
        words.skip(groups)?;
    }
    let mut found = BTreeMap::new();
    for _ in 0..curves {
        let curve: i64 = words.next()?;
        words.skip(6)?;
        for _ in 0..words.next::<usize>()? {
            let group: i64 = words.next()?;
            if let Some(name) = names.get(&group.abs()) {
                found.insert(curve, name.clone());
            }
        }
        let ends = words.next()?;
        words.skip(ends)?;
    }
    Some(found)
}

/// Elements by their nodes; lines with their curve.
#[derive(Default)]
struct Elements {
    lines: Vec<([usize; 2], i64)>,
    triangles: Vec<[usize; 3]>,
}

fn elements(words: &mut Words<'_>, numbers: &Places) -> Option<Elements> {
    let blocks: usize = words.next()?;
    words.skip(3)?;
    let mut found = Elements::default();
    for _ in 0..blocks {
        words.skip(1)?;
        let (entity, kind): (i64, usize) = (words.next()?, words.next()?);
        for _ in 0..words.next::<usize>()? {
            words.skip(1)?;
            let mut node = || numbers.get(&words.next()?).copied();
            match kind {
                LINE => found.lines.push(([node()?, node()?], entity)),
                TRIANGLE => found.triangles.push([node()?, node()?, node()?]),
                15 => drop(node()?),
                _ => return None,
            }
        }
    }
    Some(found)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::outline::Outline;

    #[test]
    fn the_shipped_mesh_of_a_cylinder_has_its_sides_and_its_hole() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/meshes");
        let edges = edges(&folder.join("cylinder.msh")).expect("a mesh");
        let mut names: Vec<&str> = edges.iter().map(|edge| edge.boundary.as_str()).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names, ["cylinder", "inlet", "outlet", "walls"]);
        let outline = Outline::new(edges, [false; 2]);
        assert!(outline.contains([0.3, 0.2]) && outline.contains([2.1, 0.41]));
        assert!(!outline.contains([0.2, 0.2]) && !outline.contains([0.2, 0.42]));
    }
}
