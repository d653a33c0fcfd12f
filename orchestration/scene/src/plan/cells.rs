//! The cells of a rectangle or box, for people.

use protocol::scene::MeshSource;

use crate::refinement;
use crate::scene::Scene;

/// A rectangle or box of cells in words.
pub fn in_words(scene: &Scene, mesh: &MeshSource) -> Option<String> {
    let (lower, upper, cells) = refinement::cells_of(mesh)?;
    let by = |numbers: Vec<String>| numbers.join(" × ");
    let extent: Vec<f64> = lower
        .iter()
        .zip(upper)
        .map(|(low, high)| high - low)
        .collect();
    let edges = extent
        .iter()
        .zip(cells)
        .map(|(extent, &count)| extent / count as f64);
    let nodes: usize = cells.iter().map(|count| count + 1).product();
    let refined = refinement::nodes(&scene.coupler, &scene.grains);
    let nodes = refined.map_or(nodes, |nodes| nodes.round() as usize);
    Some(format!(
        "fluid: {} m, {} cells of {} m, {}about {nodes} nodes and {} unknowns",
        by(extent.iter().map(|x| format!("{x:.5e}")).collect()),
        by(cells.iter().map(ToString::to_string).collect()),
        by(edges.map(|x| format!("{x:.3e}")).collect()),
        match refined {
            Some(_) => "divided where cells are to be small, ",
            None => "",
        },
        (cells.len() + 1) * nodes
    ))
}
