//! The mesh file of a scene: everything that makes it unusable, and the condition of each boundary.

use std::collections::BTreeMap;
use std::path::Path;

use gmsh::{Border, Options, survey};
use protocol::scene::{Boundary, MeshSource, Profile};
use space::{Dim, Dimension, hypot};

use crate::boundaries;
use crate::check::Checker;
use crate::keys::{Domain, Fluid};
use crate::outline::Edge;

/// A mesh in the plane.
pub type Mesh = gmsh::Mesh<2, 3>;

/// Largest share of what crosses the boundary of a closed domain that may be left over, as for an engine.
const LEFT_OVER_MAX: f64 = 0.01;
/// Key of the file.
const KEY: &str = "fluid.domain.mesh";

/// Where the mesh is, with an absolute path.
pub fn source(domain: &Domain, folder: &Path) -> MeshSource {
    let path = folder.join(domain.mesh.clone().unwrap_or_default());
    let path = std::path::absolute(&path).unwrap_or(path);
    MeshSource::File {
        path: path.to_string_lossy().into_owned(),
        scale: domain.scale.unwrap_or(1.0),
        surfaces: domain.surfaces.clone(),
    }
}

/// What the scene says about the file.
pub fn options(domain: &Domain) -> Options {
    Options {
        scale: domain.scale.unwrap_or(1.0),
        surfaces: domain.surfaces.clone(),
    }
}

/// Read the file as the engine will; its faults go to `checker`.
pub fn read(domain: &Domain, folder: &Path, checker: &mut Checker<'_>) -> Option<Mesh> {
    let path = folder.join(domain.mesh.clone().unwrap_or_default());
    match Mesh::read(&path, &options(domain)) {
        Ok(mesh) => Some(mesh),
        Err(gmsh::Error::Unusable { path, faults }) => {
            for fault in faults.0 {
                checker.refuse(KEY, format!("{}: {fault}", path.display()));
            }
            None
        }
        Err(error) => {
            checker.refuse(KEY, error.to_string());
            None
        }
    }
}

/// A condition for each boundary. A curve in several groups takes that of the group that has one; where
/// several have, they must be the same.
pub fn boundaries(
    fluid: &Fluid,
    mesh: &Mesh,
    checker: &mut Checker<'_>,
) -> BTreeMap<String, Boundary> {
    let own = |name: &str| fluid.boundaries.contains_key(name);
    let mut names: Vec<String> = mesh
        .borders
        .iter()
        .map(|b| b.name(own).to_owned())
        .collect();
    // A group that only shares its curves may have a condition of its own as well.
    let labels = mesh.borders.iter().flat_map(|border| &border.labels);
    names.extend(labels.filter(|label| own(label)).cloned());
    names.sort();
    names.dedup();
    let resolved = boundaries::by_name(&fluid.boundaries, &names, checker);
    for border in mesh.borders.iter().filter(|border| border.labels.len() > 1) {
        check_shared(border, own, &resolved, checker);
    }
    if checker.problems.is_empty() {
        check_flows(mesh, own, &resolved, checker);
    }
    resolved
}

/// What flows in must leave, and a parabola needs two ends.
fn check_flows(
    mesh: &Mesh,
    own: impl Fn(&str) -> bool,
    resolved: &BTreeMap<String, Boundary>,
    checker: &mut Checker<'_>,
) {
    let (mut net, mut gross) = (0.0, 0.0);
    for (name, boundary) in resolved {
        let Boundary::Inflow { velocity, profile } = boundary else {
            continue;
        };
        let borders = mesh
            .borders
            .iter()
            .filter(|border| border.name(&own) == name);
        let facets: Vec<[usize; 2]> = borders.flat_map(|b| b.facets.iter().copied()).collect();
        let mean = match profile {
            Profile::Uniform => 1.0,
            // The mean of a parabola is two thirds of its maximum.
            Profile::Parabolic => {
                check_ends(name, &facets, checker);
                2.0 / 3.0
            }
        };
        for facet in &facets {
            let normal = Dim::<2>::facet_normal(&facet.map(|node| mesh.position[node]));
            net -= mean * (normal[0] * velocity[0] + normal[1] * velocity[1]);
            gross += mean * hypot(&normal) * velocity[0].hypot(velocity[1]);
        }
    }
    let open = |boundary: &Boundary| matches!(boundary, Boundary::Open { .. });
    if net.abs() > LEFT_OVER_MAX * gross && !resolved.values().any(open) {
        checker.refuse(
            "fluid.boundaries",
            format!(
                "{net:e} m²/s flow in and nothing lets them out: open a boundary \
                 ({{ open = {{ pressure = 0.0 }} }}), or balance the inflows"
            ),
        );
    }
}

/// A parabolic inflow along one open line: two nodes belong to one facet only.
fn check_ends(name: &str, facets: &[[usize; 2]], checker: &mut Checker<'_>) {
    let mut nodes: Vec<usize> = facets.iter().flatten().copied().collect();
    nodes.sort_unstable();
    let ends = nodes
        .chunk_by(|a, b| a == b)
        .filter(|group| group.len() == 1);
    let ends = ends.count();
    if ends != 2 {
        let message = format!("a parabolic inflow needs one open line with 2 ends; it has {ends}");
        checker.refuse(&format!("fluid.boundaries.{name}"), message);
    }
}

/// The condition of a curve in several groups must be the same whoever reads the scene.
fn check_shared(
    border: &Border<2>,
    own: impl Fn(&str) -> bool,
    resolved: &BTreeMap<String, Boundary>,
    checker: &mut Checker<'_>,
) {
    let (labels, curves) = (&border.labels, &border.entities);
    let chosen = border.name(own);
    let there = labels.iter().filter(|label| resolved.contains_key(*label));
    let differs = |label: &&String| resolved.get(*label) != resolved.get(chosen);
    match there.clone().find(differs) {
        Some(other) => checker.refuse(
            &format!("fluid.boundaries.{chosen}"),
            format!(
                "the curves {curves:?} belong to this group and to {other:?}, whose condition differs: give both \
                 the same, or take the curves out of one group"
            ),
        ),
        None => checker.warn(format!(
            "{KEY}: the curves {curves:?} belong to {labels:?}: they are {chosen:?}"
        )),
    }
}

/// The outline of the mesh, each edge with the name of its boundary.
pub(crate) fn edges(mesh: &Mesh, has_condition: impl Fn(&str) -> bool) -> Vec<Edge> {
    let of_border = |border: &Border<2>| -> Vec<Edge> {
        let boundary = border.name(&has_condition);
        let edge = |facet: &[usize; 2]| {
            let [a, b] = facet.map(|node| mesh.position[node].into());
            Edge {
                a,
                b,
                boundary: boundary.to_owned(),
            }
        };
        border.facets.iter().map(edge).collect()
    };
    mesh.borders.iter().flat_map(of_border).collect()
}

/// What is unusual in a mesh that can be used.
pub fn warn(mesh: &Mesh, checker: &mut Checker<'_>) {
    for note in &mesh.notes {
        checker.warn(format!("{KEY}: {note}"));
    }
    let quality = survey::quality(mesh);
    boundaries::warn_of_aspect(KEY, quality.aspect, checker, || {
        format!("element {}", quality.longest)
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::outline::Outline;

    #[test]
    fn the_shipped_mesh_of_a_cylinder_has_its_sides_and_its_hole() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/meshes");
        let mesh = Mesh::read(&folder.join("cylinder.msh"), &Options::default());
        let edges = edges(&mesh.expect("a mesh"), |_| true);
        let mut names: Vec<&str> = edges.iter().map(|edge| edge.boundary.as_str()).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names, ["cylinder", "inlet", "outlet", "walls"]);
        let outline = Outline::new(edges, [false; 2]);
        assert!(outline.contains([0.3, 0.2]) && outline.contains([2.1, 0.41]));
        assert!(!outline.contains([0.2, 0.2]) && !outline.contains([0.2, 0.42]));
        let inside = |edge: &Edge| {
            let (middle, inward) = (edge.middle(), edge.inward());
            outline.contains([0, 1].map(|axis| middle[axis] + 1e-4 * inward[axis]))
        };
        assert!(outline.edges.iter().all(inside));
    }
}
