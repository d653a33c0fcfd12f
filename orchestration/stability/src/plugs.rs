//! Plugs of fixed grains in a channel, packed in rows, at random or with a rough edge. Whatever the drag,
//! the flow must be the uniform one that comes in; at a rough edge also that of its corners at the sides.

use std::f64::consts::PI;

use crate::dimension::Dimension;
use crate::limits::{Law, Shape, Suspension};
use crate::scenes::{Case, Limit};
use crate::text::{self, Domain, SLIP};

/// How the grains of a plug lie.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Packing {
    /// On a square or cubic lattice whose edges follow the mesh.
    Lattice,
    /// At random.
    Random,
    /// On the same, cut off along an oblique line or plane.
    Oblique,
}

impl Packing {
    /// All, in the order of their places on an axis.
    pub const ALL: [Packing; 3] = [Packing::Lattice, Packing::Random, Packing::Oblique];

    /// On an axis.
    pub fn name(self) -> &'static str {
        match self {
            Packing::Lattice => "lattice",
            Packing::Random => "random",
            Packing::Oblique => "oblique edge",
        }
    }

    fn solid_fraction(self) -> f64 {
        match self {
            Packing::Oblique => 0.5,
            _ => 0.2,
        }
    }

    /// Largest |v − U/φ| of a node, of U/φ: what the deposit of so many grains a cell scatters, and what
    /// corners at slip sides make of a rough edge. Nodes on edges of a channel in space have a sixth of a cell, and
    /// scatter the more.
    fn tolerance(self, dimension: Dimension, per_cell: f64) -> f64 {
        let scatter = match dimension {
            Dimension::Plane => 1.8,
            Dimension::Space => 1.8 * 6_f64.sqrt(),
        };
        match self {
            Packing::Lattice => 0.15,
            Packing::Random => 0.07 + scatter / per_cell.sqrt(),
            Packing::Oblique => 0.8,
        }
    }
}

const CELL: f64 = 1e-3;
const SPEED: f64 = 1e-6;
const STEPS: usize = 20;

/// Cells across the channel; the plug is as long.
fn cells(dimension: Dimension) -> usize {
    match dimension {
        Dimension::Plane => 8,
        Dimension::Space => 4,
    }
}

/// A plug of so many grains a cell, in steps of `stiffness` relaxation times ρφ/β of its fluid.
pub fn plug(dimension: Dimension, packing: Packing, per_cell: f64, stiffness: f64) -> Case {
    let (solid, cells) = (packing.solid_fraction(), cells(dimension));
    let side = (dimension.edge(per_cell) * cells as f64).round();
    let width = cells as f64 * CELL;
    let spacing = width / side;
    let content = spacing.powi(dimension.axes() as i32);
    let (shape, radius) = match dimension {
        Dimension::Plane => (Shape::Disk, spacing * (solid / PI).sqrt()),
        Dimension::Space => (Shape::Sphere, spacing * (0.75 * solid / PI).cbrt()),
    };
    let mixture = Suspension {
        law: Law::Stokes,
        shape,
        radius,
        grain_density: 2500.0,
        density: 1000.0,
        viscosity: 1e-3,
        porosity: 1.0 - solid,
    };
    let drag = mixture.drag(0.0) / content;
    let step = stiffness * mixture.density * mixture.porosity / drag;
    let domain = Domain {
        dimension,
        width,
        height: 3.0 * width,
        cells: [cells, 3 * cells],
        sides: [SLIP, "INFLOW", "{ open = { pressure = 0.0 } }"],
    };
    let inflow = text::inflow(dimension, SPEED);
    let speed = SPEED / mixture.porosity;
    let population = format!(
        "{}fixed = true\n",
        text::population(dimension, &mixture, 0.0)
    );
    Case {
        text: text::run(dimension, step, STEPS, 0.0)
            + &text::fluid(&mixture, &domain, SPEED).replace("INFLOW", &inflow)
            + &grains(packing, &population, &domain, side as usize)
            + &text::coupling(&mixture),
        steps: STEPS,
        limit: Limit {
            column: "fluid_speed_max",
            value: speed,
            scale: speed,
            tolerance: packing.tolerance(dimension, per_cell),
        },
        speed: (1.0 + packing.tolerance(dimension, per_cell)) * speed,
        weighs: false,
        thin_slab: None,
    }
}

fn grains(packing: Packing, population: &str, domain: &Domain, side: usize) -> String {
    let Domain {
        dimension, width, ..
    } = *domain;
    let spacing = width / side as f64;
    // What lies between two places across the channel, so high as it is wide.
    let column = |left: f64, right: f64, low: f64| {
        let corners = match dimension {
            Dimension::Plane => format!(
                "lower = [{left:e}, {low:e}], upper = [{right:e}, {:e}]",
                low + width
            ),
            Dimension::Space => format!(
                "lower = [{left:e}, {low:e}, 0.0], upper = [{right:e}, {:e}, {width:e}]",
                low + width
            ),
        };
        format!("{population}lattice = {{ {corners}, spacing = {spacing:e} }}\n")
    };
    match packing {
        Packing::Lattice => column(0.0, width, width),
        Packing::Random => format!(
            "{population}box = {{ lower = {}, upper = {}, count = {} }}\n",
            dimension.place(0.0, width),
            dimension.place(width, 2.0 * width),
            side.pow(dimension.axes() as u32)
        ),
        // a column or slice of grains at a time, each a little lower than the one before
        Packing::Oblique => (0..side)
            .map(|k| {
                let left = k as f64 * spacing;
                let low = width + 0.7 * (0.5 * width - left - 0.5 * spacing);
                column(left, left + spacing, (low / spacing).round() * spacing)
            })
            .collect(),
    }
}
