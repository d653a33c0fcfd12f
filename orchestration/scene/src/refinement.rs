//! How large cells are: what a scene asks for, and about how many nodes that makes.

use std::f64::consts::PI;

use protocol::scene::{CouplerScene, MeshSource, NearGrains, REGIONS_MAX, Refinement, Region};

use space::{Dim, simplex};

use crate::check::Checker;
use crate::dimensions::{Cells, Scenic};
use crate::grains::GrainTable;
use crate::keys::{Fluid, RefinementKeys, SceneFile};
use crate::memory;
use crate::mesh::Mesh;

const KEY: &str = "fluid.refinement";
/// Margin of cells near grains that is left out, in cells.
const MARGIN: f64 = 2.0;
/// Radius of the largest grain at most, in margins.
const RADIUS_MAX: f64 = 25.0;
/// Halvings of a cell at most: whole coordinates of the fluid engine.
const HALVINGS_MAX: f64 = 20.0;

impl RefinementKeys {
    /// As the fluid engine takes it.
    pub fn sizes(&self) -> Refinement {
        Refinement {
            growth: self.growth,
            largest: self.largest,
            regions: self.regions.clone(),
        }
    }

    /// As the coupler takes it.
    pub fn near(&self) -> Option<NearGrains> {
        let size = self.near_grains?;
        let margin = self.margin.unwrap_or(MARGIN * size);
        Some(NearGrains { size, margin })
    }

    /// Smallest cells that are asked for \[m\].
    fn smallest(&self) -> f64 {
        let regions = self.regions.iter().map(Region::size);
        regions
            .chain(self.near_grains)
            .chain(self.indicator.map(|indicator| indicator.smallest))
            .fold(f64::INFINITY, f64::min)
    }
}

/// H: edge of a cube (in the plane a square) as large as a cell \[m\].
pub fn root(lower: &[f64], upper: &[f64], cells: &[usize]) -> f64 {
    let edges = (0..cells.len()).map(|axis| (upper[axis] - lower[axis]) / cells[axis] as f64);
    edge_of(edges.product(), cells.len())
}

/// Edge of a cube or square of this content \[m\].
fn edge_of(content: f64, dimension: usize) -> f64 {
    match dimension {
        3 => simplex::cube_edge::<3>(content),
        _ => simplex::cube_edge::<2>(content),
    }
}

/// Cells that are made where this size is asked for: H 2^(−k/D) \[m\].
fn made(root: f64, asked: f64, dimension: usize) -> f64 {
    let d = dimension as f64;
    let halvings = (d * (root / asked).log2() - 1e-9).ceil().max(0.0);
    root * (-halvings / d).exp2()
}

/// Edge of a cube (in the plane a square) as large as the cells around the grains of a rectangle or box \[m\].
pub fn near_grains(scene: &CouplerScene) -> Option<f64> {
    let (lower, upper, cells) = cells_of(&scene.fluid.as_ref()?.mesh)?;
    let root = root(lower, upper, cells);
    let asked = scene.near_grains.map_or(root, |near| near.size);
    Some(made(root, asked, cells.len()))
}

/// Refuse what no mesh can be made of; `mesh` is that of the file, where there is one.
pub fn check<const D: usize>(
    keys: &SceneFile<D>,
    fluid: &Fluid<D>,
    mesh: Option<&Mesh<D>>,
    checker: &mut Checker<'_>,
) where
    Dim<D>: Scenic<D>,
{
    let Some(asked) = &fluid.refinement else {
        return;
    };
    if let Err(why) = asked.sizes().check(D) {
        checker.refuse(KEY, why);
        return;
    }
    let indicator = asked.indicator;
    for (key, value) in [
        ("near_grains", asked.near_grains),
        ("margin", asked.margin),
        ("indicator.smallest", indicator.map(|of| of.smallest)),
    ] {
        if value.is_some_and(|value| !(value > 0.0 && value.is_finite())) {
            let key = format!("{KEY}.{key}");
            checker.refuse(&key, "must be a finite number greater than 0 m");
            return;
        }
    }
    if indicator.is_some_and(|of| !(of.jump > 0.0 && of.jump.is_finite())) {
        let key = format!("{KEY}.indicator.jump");
        checker.refuse(&key, "must be a finite number greater than 0");
        return;
    }
    if asked.near_grains.is_none() && asked.regions.is_empty() && indicator.is_none() {
        checker.refuse(
            KEY,
            "says nowhere how large cells are: write near_grains (m), regions or indicator",
        );
    }
    let follows = asked.near_grains.is_some() || indicator.is_some();
    if follows && asked.regions.len() > REGIONS_MAX / 2 {
        let (count, most) = (asked.regions.len(), REGIONS_MAX / 2);
        checker.refuse(
            &format!("{KEY}.regions"),
            format!(
                "are {count}: beside near_grains or indicator, whose places are as many, at most {most} are possible"
            ),
        );
    }
    if asked.near_grains.is_some() && keys.grains.is_empty() {
        let key = format!("{KEY}.near_grains");
        checker.refuse(
            &key,
            "the scene has no grains: leave it out, or write [[grains]]",
        );
    }
    if asked.margin.is_some() && asked.near_grains.is_none() {
        let key = format!("{KEY}.margin");
        checker.refuse(&key, "is the margin of near_grains: leave it out");
    }
    let cells = Dim::<D>::cells(&fluid.domain);
    if let Some(cells) = cells.as_ref().filter(|cells| cells.grading != [1.0; D]) {
        checker.refuse(
            &format!("{}.grading", cells.key),
            "a rectangle is refined from cells of one size: leave it out, or fluid.refinement",
        );
    }
    let of_cells = |cells: &Cells<D>| root(&cells.lower, &cells.upper, &cells.cells);
    let all_alike = cells.is_some();
    let root = cells
        .as_ref()
        .map(of_cells)
        .or(mesh.map(|mesh| mesh.largest_cell));
    if let Some(root) = root.filter(|_| checker.problems.is_empty()) {
        check_sizes(asked, (root, all_alike, D), checker);
    }
}

fn check_sizes(
    asked: &RefinementKeys,
    (root, all_alike, dimension): (f64, bool, usize),
    checker: &mut Checker<'_>,
) {
    let smallest = asked.smallest();
    let step = ["√2", "∛2"][dimension - 2];
    let (cells, coarser) = match all_alike {
        true => ("cells of the domain", "fewer cells"),
        false => ("largest cells of the mesh", "a mesh of larger ones"),
    };
    let sizes = asked.regions.iter().enumerate();
    let sizes = sizes.map(|(k, region)| (format!("{KEY}.regions[{k}]"), region.size()));
    let near = asked
        .near_grains
        .map(|size| (format!("{KEY}.near_grains"), size));
    let flow = asked
        .indicator
        .map(|of| (format!("{KEY}.indicator.smallest"), of.smallest));
    for (key, size) in sizes.chain(near).chain(flow) {
        if size > root {
            checker.refuse(
                &key,
                format!(
                    "{size:e} m is larger than the {cells}, {root:.4e} m, which are only divided: write a smaller size, \
                     or {coarser}"
                ),
            );
        }
        let made = made(root, size, dimension);
        if all_alike && made < 0.9 * size && size <= root {
            checker.warn(format!(
                "{key} = {size:e} m makes cells of {made:.4e} m: sizes come in steps of 1/{step} from the cells of \
                 the domain, {root:.4e} m"
            ));
        }
    }
    if smallest < root * (-HALVINGS_MAX).exp2() {
        let least = root * (-HALVINGS_MAX).exp2();
        let why = format!(
            "cells of {smallest:e} m are smaller than the smallest possible, {least:.1e} m"
        );
        checker.refuse(KEY, why);
    }
}

/// Content of the unit ball of 0 to 3 dimensions.
const BALLS: [f64; 4] = [1.0, 2.0, PI, 4.0 / 3.0 * PI];

/// Content of all that is within `far` of a box with these edges (Steiner 1840).
fn around(edges: &[f64], far: f64) -> f64 {
    // elementary symmetric polynomials of the edges
    let mut symmetric = vec![1.0];
    for edge in edges {
        symmetric.push(0.0);
        for k in (1..symmetric.len()).rev() {
            symmetric[k] += symmetric[k - 1] * edge;
        }
    }
    let terms =
        (0..=edges.len()).map(|k| symmetric[edges.len() - k] * BALLS[k] * far.powi(k as i32));
    terms.sum()
}

/// About how many nodes the first mesh of a scene has; none where nothing is refined.
///
/// ```text
///   ∫ dV/h^D over the zones, the cells that grow around them, and the rest; zones of grains: cubes of edge
///   `margin` that grains are in, with two rings around
/// ```
pub fn nodes(scene: &CouplerScene, grains: &GrainTable) -> Option<f64> {
    let fluid = scene.fluid.as_ref()?;
    let asked = fluid.refinement.as_ref()?;
    let (lower, upper, cells) = cells_of(&fluid.mesh)?;
    let extent: Vec<f64> = lower
        .iter()
        .zip(upper)
        .map(|(low, high)| high - low)
        .collect();
    let d = extent.len();
    let domain: f64 = extent.iter().product();
    let root = root(lower, upper, cells);
    let largest = made(root, asked.largest.unwrap_or(root), d);
    let density = |size: f64| size.powi(-(d as i32));
    let mut nodes = domain * density(largest);
    let mut add = |size: f64, edges: &[f64], inner: f64| {
        let (size, growth) = (made(root, size, d), asked.growth);
        let end = ((largest - size) / growth).max(0.0);
        let layers = 200;
        let content = |layer: usize| around(edges, inner + end * layer as f64 / layers as f64);
        let of_layer = |layer: usize| {
            let middle = size + (layer as f64 + 0.5) * (largest - size).max(0.0) / layers as f64;
            (content(layer + 1) - content(layer)) * (density(middle) - density(largest)).max(0.0)
        };
        let grown: f64 = (0..layers).map(of_layer).sum();
        // sizes come in steps, and a cell is divided where one of its D + 1 corners asks for it
        let finer = std::f64::consts::SQRT_2.powi(d as i32 - 1);
        nodes += content(0) * density(size) + finer * grown;
    };
    let point = vec![0.0; d];
    for region in &asked.regions {
        match region {
            Region::Ball { radius, size, .. } => add(*size, &point, *radius),
            Region::Box { lower, upper, size } => {
                let edge = |k: usize| (upper[k] - lower[k]).min(extent[k]);
                let edges: Vec<f64> = (0..d).map(edge).collect();
                add(*size, &edges, 0.0);
            }
        }
    }
    if let Some(near) = scene.near_grains {
        let content = (zone(&near, grains) as f64 * near.margin.powi(d as i32)).min(domain);
        let edge = edge_of(content, d);
        add(near.size, &vec![edge; d], 0.0);
    }
    Some(nodes)
}

/// Corners and cells of a rectangle or box.
pub fn cells_of(mesh: &MeshSource) -> Option<(&[f64], &[f64], &[usize])> {
    match mesh {
        MeshSource::Rectangle {
            lower,
            upper,
            cells,
            ..
        }
        | MeshSource::Box {
            lower,
            upper,
            cells,
        } => Some((lower, upper, cells)),
        MeshSource::File { .. } => None,
    }
}

/// Cubes (in the plane squares) of edge `margin` of the zone around grains.
fn zone(near: &NearGrains, grains: &GrainTable) -> usize {
    match grains.dimension {
        3 => cubes::<3>(near, grains),
        _ => cubes::<2>(near, grains),
    }
}

fn cubes<const D: usize>(near: &NearGrains, grains: &GrainTable) -> usize {
    let cell = |x: &f64| (x / near.margin).floor() as i64;
    let places = grains.position.chunks_exact(D);
    let of = |place: &[f64]| -> [i64; D] { std::array::from_fn(|k| cell(&place[k])) };
    let mut cells: Vec<[i64; D]> = places.map(of).collect();
    cells.sort_unstable();
    cells.dedup();
    let rings = |cell: &[i64; D]| {
        let cell = *cell;
        (0..5_i64.pow(D as u32)).map(move |code| -> [i64; D] {
            std::array::from_fn(|k| cell[k] + code / 5_i64.pow(k as u32) % 5 - 2)
        })
    };
    let mut zone: Vec<[i64; D]> = cells.iter().flat_map(rings).collect();
    zone.sort_unstable();
    zone.dedup();
    zone.len()
}

/// Refuse a zone around grains that are large beside its margin, and a mesh that no memory holds.
pub fn check_grains(scene: &CouplerScene, grains: &GrainTable, checker: &mut Checker<'_>) {
    let largest = grains.radius.iter().copied().fold(0.0, f64::max);
    let margin = scene.near_grains.map(|near| near.margin);
    if let Some(margin) = margin.filter(|margin| largest > RADIUS_MAX * margin) {
        checker.refuse(
            &format!("{KEY}.margin"),
            format!(
                "{margin:e} m is less than {:.1e} m, 1/{RADIUS_MAX} of the radius of the largest grain: write a larger one; \
                 grains are spread over 2.75 radii, and cells far below that show nothing new",
                largest / RADIUS_MAX
            ),
        );
        return;
    }
    let why = nodes(scene, grains).and_then(|nodes| memory::refusal("nodes", nodes, memory::NODE));
    if let Some(why) = why {
        checker.refuse(
            KEY,
            format!("{why}; ask for larger cells, or for small ones in fewer places"),
        );
    }
}
