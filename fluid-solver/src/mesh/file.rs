//! Meshes of files, read by the crate `gmsh`.

use std::collections::BTreeSet;
use std::path::Path;

use gmsh::Options;
use space::{Dim, Dimension};

use super::simplices::Mesh;
use crate::error::FluidError;

/// Read a mesh; `has_condition` decides which group a curve in several belongs to.
pub fn read<const D: usize, const N: usize>(
    path: &Path,
    options: &Options,
    has_condition: impl Fn(&str) -> bool,
) -> Result<Mesh<D, N>, FluidError>
where
    Dim<D>: Dimension<D>,
{
    of(gmsh::Mesh::read(path, options)?, has_condition)
}

/// The mesh of what was read.
pub fn of<const D: usize, const N: usize>(
    read: gmsh::Mesh<D, N>,
    has_condition: impl Fn(&str) -> bool,
) -> Result<Mesh<D, N>, FluidError>
where
    Dim<D>: Dimension<D>,
{
    let borders = read.borders.iter();
    let names: BTreeSet<String> = borders
        .map(|border| border.name(&has_condition).to_owned())
        .collect();
    let names: Vec<String> = names.into_iter().collect();
    let mut named = Vec::new();
    for border in &read.borders {
        let name = border.name(&has_condition);
        let boundary = names.partition_point(|known| known.as_str() < name);
        named.extend(border.facets.iter().map(|&facet| (facet, boundary)));
    }
    let number = |t: usize| read.element[t] as usize;
    Mesh::new(read.position, read.simplices, names, &named, number)
}
