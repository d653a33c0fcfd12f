//! The mesh file of a scene: everything that makes it unusable, and the condition of each boundary.

use std::collections::BTreeMap;
use std::path::Path;

use gmsh::{Border, Options};
use protocol::scene::{Boundary, MeshSource, Profile, fixed};
use space::{Dim, Dimension, Vector, dot, hypot};

use crate::boundaries::{self, mean_of};
use crate::check::Checker;
use crate::dimensions::Scenic;
use crate::keys::{Domain, Fluid};
use crate::mesh::Mesh;
use crate::outline::Facet;

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
pub fn read<const D: usize>(
    domain: &Domain,
    folder: &Path,
    checker: &mut Checker<'_>,
) -> Option<Mesh<D>>
where
    Dim<D>: Scenic<D>,
{
    let path = folder.join(domain.mesh.clone().unwrap_or_default());
    match Dim::<D>::read_mesh(&path, &options(domain)) {
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
pub fn boundaries<const D: usize>(
    fluid: &Fluid<D>,
    mesh: &Mesh<D>,
    checker: &mut Checker<'_>,
) -> BTreeMap<String, Boundary>
where
    Dim<D>: Dimension<D>,
{
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
fn check_flows<const D: usize>(
    mesh: &Mesh<D>,
    own: impl Fn(&str) -> bool,
    resolved: &BTreeMap<String, Boundary>,
    checker: &mut Checker<'_>,
) where
    Dim<D>: Dimension<D>,
{
    let (mut net, mut gross) = (0.0, 0.0);
    for (name, boundary) in resolved {
        let Boundary::Inflow { velocity, profile } = boundary else {
            continue;
        };
        let Ok(velocity) = fixed::<D, f64>(velocity).map(Vector::from) else {
            continue;
        };
        let borders = mesh
            .borders
            .iter()
            .filter(|border| border.name(&own) == name);
        let facets: Vec<[usize; D]> = borders.flat_map(|b| b.facets.iter().copied()).collect();
        if *profile == Profile::Parabolic {
            check_ends(name, &facets, checker);
        }
        let mean = mean_of(*profile, D) / space::dimension::factorial(D - 1) as f64;
        for facet in &facets {
            let normal = Dim::<D>::facet_normal(&facet.map(|node| mesh.position[node]));
            net -= mean * dot(&normal, &velocity);
            gross += mean * hypot(&normal) * hypot(&velocity);
        }
    }
    let open = |boundary: &Boundary| matches!(boundary, Boundary::Open { .. });
    if net.abs() > LEFT_OVER_MAX * gross && !resolved.values().any(open) {
        let power = ["²", "³"][D - 2];
        checker.refuse(
            "fluid.boundaries",
            format!(
                "{net:e} m{power}/s flow in and nothing lets them out: open a boundary \
                 ({{ open = {{ pressure = 0.0 }} }}), or balance the inflows"
            ),
        );
    }
}

/// A parabolic inflow is along one open line, of which two nodes belong to one facet only; in space its side is a
/// rectangle, which the engine finds.
fn check_ends<const D: usize>(name: &str, facets: &[[usize; D]], checker: &mut Checker<'_>) {
    if D > 2 {
        return;
    }
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
fn check_shared<const D: usize>(
    border: &Border<D>,
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

/// The outline of the mesh, each facet with the name of its boundary.
pub(crate) fn facets<const D: usize>(
    mesh: &Mesh<D>,
    has_condition: impl Fn(&str) -> bool,
) -> Vec<Facet<D>>
where
    Dim<D>: Dimension<D>,
{
    let of_border = |border: &Border<D>| -> Vec<Facet<D>> {
        let boundary = border.name(&has_condition);
        let facet = |nodes: &[usize; D]| Facet {
            corners: nodes.map(|node| mesh.position[node].into()),
            boundary: boundary.to_owned(),
        };
        border.facets.iter().map(facet).collect()
    };
    mesh.borders.iter().flat_map(of_border).collect()
}

/// What is unusual in a mesh that can be used.
pub fn warn<const D: usize>(mesh: &Mesh<D>, checker: &mut Checker<'_>) {
    for note in &mesh.notes {
        checker.warn(format!("{KEY}: {note}"));
    }
    let (aspect, element) = mesh.aspect;
    boundaries::warn_of_aspect(KEY, aspect, checker, || format!("element {element}"));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::outline::Outline;

    #[test]
    fn the_shipped_mesh_of_a_cylinder_has_its_sides_and_its_hole() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/meshes");
        let mesh = <Dim<2>>::read_mesh(&folder.join("cylinder.msh"), &Options::default());
        let edges = facets(&mesh.expect("a mesh"), |_| true);
        let mut names: Vec<&str> = edges.iter().map(|edge| edge.boundary.as_str()).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names, ["cylinder", "inlet", "outlet", "walls"]);
        let outline = Outline::new(edges, [false; 2]);
        assert!(outline.contains(&[0.3, 0.2]) && outline.contains(&[2.1, 0.41]));
        assert!(!outline.contains(&[0.2, 0.2]) && !outline.contains(&[0.2, 0.42]));
        let inside = |edge: &Facet<2>| {
            let (middle, inward) = (edge.middle(), edge.inward());
            outline.contains(&[0, 1].map(|axis| middle[axis] + 1e-4 * inward[axis]))
        };
        assert!(outline.facets.iter().all(inside));
    }
}
