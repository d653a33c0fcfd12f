//! The boundary, by what the file says of it, and what lies between surfaces.

use std::collections::{BTreeMap, BTreeSet};

use space::simplex::facet_corners;
use space::{Dim, Dimension};

use crate::cells::triangles;
use crate::error::Faults;
use crate::file::{Element, File};
use crate::mesh::{Border, Mesh, Options, Pieces};
use crate::sides::{Side, Sides, ordered};
use crate::topology;

/// Sides without a name that are told one by one.
const TOLD: usize = 3;

/// Elements on sides, by their nodes, ascending.
type OnSides<'a, const D: usize> = BTreeMap<[usize; D], Vec<&'a Element>>;

/// Several surfaces are one fluid only where the scene says so: told with what lies between them.
pub(crate) fn check_regions<const D: usize, const N: usize>(
    sides: &Sides<D>,
    mesh: &Mesh<D, N>,
    file: &File,
    pieces: &Pieces<N>,
    options: &Options,
    faults: &mut Faults,
) where
    Dim<D>: Dimension<D>,
{
    let mut count: BTreeMap<&[String], usize> = BTreeMap::new();
    for labels in &pieces.labels {
        *count.entry(labels).or_default() += 1;
    }
    let common = |label: &&String| count.keys().all(|labels| labels.contains(label));
    let one = count
        .keys()
        .next()
        .is_some_and(|first| first.iter().any(|l| common(&l)));
    if !options.surfaces.is_empty() || one {
        return;
    }
    let simplex = Dim::<D>::SIMPLEX;
    let told = count
        .iter()
        .map(|(labels, n)| format!("{labels:?} ({n} {simplex}s)"));
    let told: Vec<String> = told.collect();
    let names: BTreeSet<&String> = count.keys().filter_map(|labels| labels.first()).collect();
    faults.note(format!(
        "several surfaces, {}{}: write those that are filled with fluid, e.g. surfaces = {names:?}, in \
         [fluid.domain]",
        told.join(", "),
        between(sides, mesh, file, pieces)
    ));
}

/// What lies between surfaces.
fn between<const D: usize, const N: usize>(
    sides: &Sides<D>,
    mesh: &Mesh<D, N>,
    file: &File,
    pieces: &Pieces<N>,
) -> String
where
    Dim<D>: Dimension<D>,
{
    let on = on_sides(mesh, file);
    let parted = |group: &&[Side<D>]| {
        group.len() == 2 && pieces.labels[group[0].simplex] != pieces.labels[group[1].simplex]
    };
    let (mut count, mut curves) = (0, BTreeSet::new());
    for group in sides.groups().filter(parted) {
        count += 1;
        let elements = on.get(&group[0].nodes);
        curves.extend(elements.into_iter().flatten().flat_map(|e| file.labels(e)));
    }
    let facet = Dim::<D>::FACET;
    match (count, curves.is_empty()) {
        (0, _) => String::new(),
        (_, true) => {
            format!(" that meet in {count} {facet}s, whose curve the file does not have")
        }
        (_, false) => format!(" that meet in {count} {facet}s (curve {curves:?})"),
    }
}

/// The boundary: sides of single simplices, by what the file says of them.
pub(crate) fn find<const D: usize, const N: usize>(
    sides: &Sides<D>,
    mesh: &Mesh<D, N>,
    file: &File,
    pieces: &Pieces<N>,
    options: &Options,
    faults: &mut Faults,
) -> Vec<Border<D>>
where
    Dim<D>: Dimension<D>,
{
    let mut on = on_sides(mesh, file);
    let mut borders: BTreeMap<Vec<String>, Border<D>> = BTreeMap::new();
    let (mut inside, mut unnamed) = (BTreeMap::new(), Vec::new());
    for group in sides.groups() {
        let elements = on.remove(&group[0].nodes).unwrap_or_default();
        match group {
            [side] => match labelled(file, &elements) {
                Some(labels) => {
                    let nodes = mesh.simplices[side.simplex];
                    let outward = facet_corners::<D>(side.corner).map(|k| nodes[k]);
                    note_border(&mut borders, labels, &elements, outward);
                }
                None => unnamed.push(*side),
            },
            [one, other] => {
                let parted = pieces.labels[one.simplex] != pieces.labels[other.simplex];
                let grouped = elements.iter().filter(|element| file.is_grouped(element));
                for element in grouped.filter(|_| !parted || options.surfaces.is_empty()) {
                    *inside
                        .entry((element.entity, file.labels(element)))
                        .or_insert(0) += 1;
                }
            }
            _ => {}
        }
    }
    for ((curve, labels), count) in inside {
        let (facet, simplex) = (Dim::<D>::FACET, Dim::<D>::SIMPLEX);
        faults.note(format!(
            "curve {curve}, {labels:?}, lies inside the domain ({count} {facet}s); only {facet}s of a \
             single {simplex} can carry a condition"
        ));
    }
    tell_unnamed(mesh, &unnamed, faults);
    if options.surfaces.is_empty() {
        tell_stray(file, on.into_values().flatten(), faults);
    }
    borders.into_values().collect()
}

/// Elements of the file on sides whose nodes are all used.
fn on_sides<'a, const D: usize, const N: usize>(
    mesh: &Mesh<D, N>,
    file: &'a File,
) -> OnSides<'a, D> {
    let mut on: OnSides<'a, D> = BTreeMap::new();
    for element in file.elements.iter().filter(|e| e.dimension + 1 == D) {
        for corners in facets::<D>(element) {
            let index = |k: usize| mesh.node_number.binary_search(&element.nodes[k]);
            let nodes = corners.map(index);
            if nodes.iter().all(Result::is_ok) {
                let nodes = ordered(nodes.map(|node| node.unwrap_or_default()));
                on.entry(nodes).or_default().push(element);
            }
        }
    }
    on
}

/// Corners of the facets that an element on a side is, or is cut into.
fn facets<const D: usize>(element: &Element) -> Vec<[usize; D]> {
    if element.corners == D {
        return vec![std::array::from_fn(|k| k)];
    }
    if D < 3 || element.corners != 4 {
        return Vec::new();
    }
    let parts = triangles(&[0, 1, 2, 3], |k| element.nodes[k]).into_iter();
    parts.map(|part| std::array::from_fn(|k| part[k])).collect()
}

/// What the file says of a side: the groups of all elements there, or else the first entity.
fn labelled(file: &File, elements: &[&Element]) -> Option<Vec<String>> {
    let grouped = elements.iter().filter(|element| file.is_grouped(element));
    let mut labels: Vec<String> = grouped.flat_map(|element| file.labels(element)).collect();
    labels.sort();
    labels.dedup();
    if !labels.is_empty() {
        return Some(labels);
    }
    let bare = elements.iter().map(|element| file.labels(element));
    bare.into_iter().find(|labels| !labels.is_empty())
}

fn note_border<const D: usize>(
    borders: &mut BTreeMap<Vec<String>, Border<D>>,
    labels: Vec<String>,
    elements: &[&Element],
    nodes: [usize; D],
) {
    let border = borders.entry(labels.clone()).or_insert_with(|| Border {
        labels,
        entities: BTreeSet::new(),
        facets: Vec::new(),
    });
    border
        .entities
        .extend(elements.iter().map(|element| element.entity));
    border.facets.push(nodes);
}

/// Sides of the boundary that the file says nothing of.
fn tell_unnamed<const D: usize, const N: usize>(
    mesh: &Mesh<D, N>,
    unnamed: &[Side<D>],
    faults: &mut Faults,
) where
    Dim<D>: Dimension<D>,
{
    let hanging = topology::hanging(mesh, unnamed);
    let found = hanging.len();
    hanging.into_iter().for_each(|fault| faults.note(fault));
    if found > 0 || unnamed.is_empty() {
        return;
    }
    let (facet, simplex) = (Dim::<D>::FACET, Dim::<D>::SIMPLEX);
    for side in unnamed.iter().take(TOLD) {
        let element = mesh.element[side.simplex];
        let ends = side
            .nodes
            .map(|n| format!("{:?}", mesh.position[n].as_slice()));
        faults.note(format!(
            "the {facet} of element {element} from {} belongs to no curve",
            ends.join(" to ")
        ));
    }
    let count = unnamed.len();
    faults.note(format!(
        "{count} {facet}s of the boundary belong to no curve, so they have no condition: give their curves \
         physical names, or save all elements (gmsh: Mesh.SaveAll = 1); or {simplex}s are missing there"
    ));
}

/// Elements in a group that are a side of nothing.
fn tell_stray<'a>(file: &File, elements: impl Iterator<Item = &'a Element>, faults: &mut Faults) {
    let mut count: BTreeMap<(i64, Vec<String>), (u64, usize)> = BTreeMap::new();
    for element in elements.filter(|element| file.is_grouped(element)) {
        let key = (element.entity, file.labels(element));
        count.entry(key).or_insert((element.number, 0)).1 += 1;
    }
    for ((curve, labels), (number, count)) in count {
        faults.note(format!(
            "{count} elements of curve {curve}, {labels:?}, are sides of no element of the domain (the first: \
             {number})"
        ));
    }
}
