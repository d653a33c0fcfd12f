//! Fields along a column: means across it, and where they fall through a value.

use coupler::simulation::Simulation;
use space::{Dim, Dimension};

/// Mean of a nodal field over each level of nodes, from the lowest up: (y, mean).
pub fn levels<const D: usize, const N: usize>(
    coupling: &Simulation<D, N>,
    values: &[f64],
) -> Vec<(f64, f64)>
where
    Dim<D>: Dimension<D>,
{
    let mesh = &coupling.system.fluid().expect("a fluid").mesh;
    let nodes = mesh.node_position.iter().zip(values);
    let mut sorted: Vec<(f64, f64)> = nodes.map(|(x, value)| (x[1], *value)).collect();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    let rows = sorted.chunk_by(|a, b| b.0 - a.0 < 1e-9 * (1.0 + b.0.abs()));
    let mean = |row: &[(f64, f64)]| row.iter().map(|node| node.1).sum::<f64>() / row.len() as f64;
    rows.map(|row| (row[0].0, mean(row))).collect()
}

/// Solid fraction of the accepted state by levels of nodes.
pub fn solid_levels<const D: usize, const N: usize>(coupling: &Simulation<D, N>) -> Vec<(f64, f64)>
where
    Dim<D>: Dimension<D>,
{
    let porosity = levels(coupling, &coupling.state.porosity);
    let solid = porosity
        .into_iter()
        .map(|(y, porosity)| (y, 1.0 - porosity));
    solid.collect()
}

/// Highest level at which a profile falls through this value.
pub fn front(profile: &[(f64, f64)], value: f64) -> f64 {
    let pair = profile
        .windows(2)
        .rev()
        .find(|pair| pair[0].1 >= value && pair[1].1 < value)
        .expect("a front");
    let share = (pair[0].1 - value) / (pair[0].1 - pair[1].1);
    pair[0].0 + share * (pair[1].0 - pair[0].0)
}
