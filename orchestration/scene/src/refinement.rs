//! How large cells are: what a scene asks for, and about how many nodes that makes.

use protocol::scene::{CouplerScene, MeshSource, NearGrains, REGIONS_MAX, Refinement, Region};

use crate::check::Checker;
use crate::grains::GrainTable;
use crate::keys::{Fluid, Rectangle, RefinementKeys, SceneFile};
use crate::memory;
use crate::mesh_file::Mesh;

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

/// H: edge of a square as large as a cell of the rectangle \[m\].
fn root(rectangle: &Rectangle) -> f64 {
    let edge = |d: usize| (rectangle.upper[d] - rectangle.lower[d]) / rectangle.cells[d] as f64;
    (edge(0) * edge(1)).sqrt()
}

/// H: edge of a square as large as two of the largest triangle of a mesh \[m\].
fn root_of_mesh(mesh: &Mesh) -> f64 {
    let area = |nodes: &[usize; 3]| {
        let [a, b, c] = nodes.map(|node| mesh.position[node]);
        ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])).abs()
    };
    mesh.simplices.iter().map(area).fold(0.0, f64::max).sqrt()
}

/// Cells that are made where this size is asked for: H 2^(−k/2) \[m\].
fn made(root: f64, asked: f64) -> f64 {
    let halvings = (2.0 * (root / asked).log2() - 1e-9).ceil().max(0.0);
    root * (-halvings / 2.0).exp2()
}

/// Refuse what no mesh can be made of; `mesh` is that of the file, where there is one.
pub fn check(keys: &SceneFile, fluid: &Fluid, mesh: Option<&Mesh>, checker: &mut Checker<'_>) {
    let Some(asked) = &fluid.refinement else {
        return;
    };
    if let Err(why) = asked.sizes().check(2) {
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
    let rectangle = fluid.domain.rectangle.as_ref();
    if rectangle.is_some_and(|rectangle| rectangle.grading != [1.0, 1.0]) {
        checker.refuse(
            "fluid.domain.rectangle.grading",
            "a rectangle is refined from cells of one size: leave it out, or fluid.refinement",
        );
    }
    let root = rectangle.map(root).or_else(|| mesh.map(root_of_mesh));
    if let Some(root) = root.filter(|_| checker.problems.is_empty()) {
        check_sizes(asked, (root, rectangle.is_some()), checker);
    }
}

fn check_sizes(asked: &RefinementKeys, (root, all_alike): (f64, bool), checker: &mut Checker<'_>) {
    let smallest = asked.smallest();
    let (cells, coarser) = match all_alike {
        true => ("cells of the rectangle", "fewer cells"),
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
        let made = made(root, size);
        if all_alike && made < 0.9 * size && size <= root {
            checker.warn(format!(
                "{key} = {size:e} m makes cells of {made:.4e} m: sizes come in steps of 1/√2 from the cells of \
                 the rectangle, {root:.4e} m"
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

/// About how many nodes the first mesh of a scene has; none where nothing is refined.
///
/// ```text
///   ∫ dA/h² over the zones, the cells that grow around them, and the rest; zones of grains: squares of edge
///   `margin` that grains are in, with two rings around
/// ```
pub fn nodes(scene: &CouplerScene, grains: &GrainTable) -> Option<f64> {
    let fluid = scene.fluid.as_ref()?;
    let asked = fluid.refinement.as_ref()?;
    let MeshSource::Rectangle {
        lower,
        upper,
        cells,
        ..
    } = &fluid.mesh
    else {
        return None;
    };
    let extent = [0, 1].map(|d| upper[d] - lower[d]);
    let domain = extent[0] * extent[1];
    let root = (domain / (cells[0] * cells[1]) as f64).sqrt();
    let largest = made(root, asked.largest.unwrap_or(root));
    let mut nodes = domain / (largest * largest);
    let mut add = |size: f64, area: f64, perimeter: f64| {
        let (size, growth) = (made(root, size), asked.growth);
        let far = (largest / size).ln().max(0.0);
        let around = perimeter / (growth * size) * (1.0 - size / largest);
        let beyond = 2.0 * std::f64::consts::PI / (growth * growth) * (far - 1.0 + size / largest);
        // sizes come in steps of 1/√2: on average cells are 2^¼ smaller than asked for
        nodes += area / (size * size) + std::f64::consts::SQRT_2 * (around + beyond).max(0.0);
    };
    for region in &asked.regions {
        match region {
            Region::Ball { radius, size, .. } => {
                let circle = 2.0 * std::f64::consts::PI * radius;
                add(*size, 0.5 * circle * radius, circle);
            }
            Region::Box { lower, upper, size } => {
                let edge = |d: usize| (upper[d] - lower[d]).min(extent[d]);
                add(*size, edge(0) * edge(1), 2.0 * (edge(0) + edge(1)));
            }
        }
    }
    if let Some(near) = scene.near_grains {
        let area = (zone(&near, grains) as f64 * near.margin * near.margin).min(domain);
        add(near.size, area, 4.0 * area.sqrt());
    }
    Some(nodes)
}

/// Squares of edge `margin` of the zone around grains.
fn zone(near: &NearGrains, grains: &GrainTable) -> usize {
    let cell = |x: f64| (x / near.margin).floor() as i64;
    let mut cells: Vec<[i64; 2]> = grains.position.iter().map(|x| x.map(cell)).collect();
    cells.sort_unstable();
    cells.dedup();
    let rings = |cell: &[i64; 2]| {
        let [x, y] = *cell;
        (-2..=2).flat_map(move |i| (-2..=2).map(move |j| [x + i, y + j]))
    };
    let mut zone: Vec<[i64; 2]> = cells.iter().flat_map(rings).collect();
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
