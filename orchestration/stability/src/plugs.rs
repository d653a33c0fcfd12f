//! Plugs of fixed grains in a channel, packed in rows, at random or with a rough edge. Whatever the drag,
//! the flow must be the uniform one that comes in; at a rough edge also that of its corners at the sides.

use std::f64::consts::PI;

use crate::limits::{Law, Shape, Suspension};
use crate::scenes::{self, Case, Domain, Limit};

/// How the grains of a plug lie.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Packing {
    /// On a square lattice whose edges follow the mesh.
    Lattice,
    /// At random.
    Random,
    /// On a square lattice cut off along an oblique line.
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
    /// corners at slip sides make of a rough edge.
    fn tolerance(self, per_cell: f64) -> f64 {
        match self {
            Packing::Lattice => 0.15,
            Packing::Random => 0.07 + 1.8 / per_cell.sqrt(),
            Packing::Oblique => 0.8,
        }
    }
}

/// Cells across the channel; the plug is as long.
const CELLS: usize = 8;
const CELL: f64 = 1e-3;
const SPEED: f64 = 1e-6;
const STEPS: usize = 20;

/// A plug of so many grains a cell, in steps of `stiffness` relaxation times ρφ/β of its fluid.
pub fn plug(packing: Packing, per_cell: f64, stiffness: f64) -> Case {
    let solid = packing.solid_fraction();
    let side = (per_cell.sqrt() * CELLS as f64).round();
    let width = CELLS as f64 * CELL;
    let spacing = width / side;
    let mixture = Suspension {
        law: Law::Stokes,
        shape: Shape::Disk,
        radius: spacing * (solid / PI).sqrt(),
        grain_density: 2500.0,
        density: 1000.0,
        viscosity: 1e-3,
        porosity: 1.0 - solid,
    };
    let drag = mixture.drag(0.0) / (spacing * spacing);
    let step = stiffness * mixture.density * mixture.porosity / drag;
    let domain = Domain {
        width,
        height: 3.0 * width,
        cells: [CELLS, 3 * CELLS],
        sides: [scenes::SLIP, "INFLOW", "{ open = { pressure = 0.0 } }"],
    };
    let inflow = format!("{{ inflow = {{ velocity = [0.0, {SPEED:e}] }} }}");
    let speed = SPEED / mixture.porosity;
    Case {
        text: scenes::run(step, STEPS, 0.0)
            + &scenes::fluid(&mixture, &domain, SPEED).replace("INFLOW", &inflow)
            + &grains(packing, &mixture, width, side as usize)
            + &scenes::coupling(&mixture),
        steps: STEPS,
        limit: Limit {
            column: "fluid_speed_max",
            value: speed,
            scale: speed,
            tolerance: packing.tolerance(per_cell),
        },
        speed: (1.0 + packing.tolerance(per_cell)) * speed,
        weighs: false,
        thin_slab: None,
    }
}

fn grains(packing: Packing, mixture: &Suspension, width: f64, side: usize) -> String {
    let kind = format!(
        "[[grains]]\nfixed = true\ndensity = {:e}\nradius = {:e}\n",
        mixture.grain_density, mixture.radius
    );
    let spacing = width / side as f64;
    let column = |left: f64, right: f64, low: f64| {
        format!(
            "{kind}lattice = {{ lower = [{left:e}, {low:e}], upper = [{right:e}, {:e}], \
             spacing = {spacing:e} }}\n",
            low + width
        )
    };
    match packing {
        Packing::Lattice => column(0.0, width, width),
        Packing::Random => format!(
            "{kind}box = {{ lower = [0.0, {width:e}], upper = [{width:e}, {:e}], count = {} }}\n",
            2.0 * width,
            side * side
        ),
        // a column of grains at a time, each a little lower than the one before
        Packing::Oblique => (0..side)
            .map(|k| {
                let left = k as f64 * spacing;
                let low = width + 0.7 * (0.5 * width - left - 0.5 * spacing);
                column(left, left + spacing, (low / spacing).round() * spacing)
            })
            .collect(),
    }
}
