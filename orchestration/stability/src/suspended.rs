//! Uniform suspensions: what is suspended, on which lattice, and the cells that the lattice fits.
//!
//! In the plane grains are spheres in a slab so thin that no porosity brings them to touch. In space they are what
//! they are: spheres of the porosity that is asked for, on a face-centred cubic lattice, four to a cube of edge a,
//!
//! ```text
//!   1 − φ = 4 · ⁴⁄₃πr³/a³                     (touching where r = a/√8: φ = 0.26)
//! ```

use std::f64::consts::PI;

use crate::dimension::Dimension;
use crate::limits::{Law, Shape, Suspension};
use crate::text::{self, Domain};

/// A cell \[m\].
const CELL: f64 = 1e-3;
/// Diameter over cell, where nothing else is asked for in the plane.
const SIZE: f64 = 0.125;
/// Cubes along a cell, where nothing else is asked for in space: 108 spheres, all narrower than a quarter of it.
const CUBES: f64 = 3.0;

/// A suspension on its lattice.
pub struct Suspended {
    /// The plane or space.
    pub(crate) dimension: Dimension,
    /// Fluid and grains.
    pub mixture: Suspension,
    /// Size of a cell \[m\].
    pub(crate) cell: f64,
    /// Cells across.
    pub(crate) columns: usize,
    /// Distance between neighbours in the plane, edge of a cube in space \[m\].
    spacing: f64,
}

/// Radius of spheres of this porosity in cubes of edge 1.
fn radius_in_cube(porosity: f64) -> f64 {
    (3.0 * (1.0 - porosity) / (16.0 * PI)).cbrt()
}

/// Stokes drag in a fluid of unlike density: φ, ρ_p/ρ.
fn creeping(shape: Shape, radius: f64, porosity: f64, ratio: f64) -> Suspension {
    Suspension {
        law: Law::Stokes,
        shape,
        radius,
        grain_density: 1000.0 * ratio,
        density: 1000.0,
        viscosity: 0.1,
        porosity,
    }
}

/// Spheres of this radius on a square lattice, in a slab of the depth that makes this porosity.
fn in_slab(radius: f64, spacing: f64, porosity: f64, ratio: f64) -> Suspension {
    let volume = 4.0 / 3.0 * PI * radius.powi(3);
    let depth = volume / ((1.0 - porosity) * spacing * spacing);
    creeping(Shape::SphereInSlab { depth }, radius, porosity, ratio)
}

impl Suspended {
    /// Grains much smaller than cells: φ, ρ_p/ρ.
    pub fn fine(dimension: Dimension, porosity: f64, ratio: f64) -> Suspended {
        match dimension {
            Dimension::Plane => Suspended::of_size(dimension, porosity, ratio, SIZE),
            Dimension::Space => Suspended::in_cubes(porosity, ratio, CELL / CUBES),
        }
    }

    /// Grains of this size d/h; in space of the nearest one whose lattice fits the cells.
    pub fn of_size(dimension: Dimension, porosity: f64, ratio: f64, size: f64) -> Suspended {
        let radius = 0.5 * size * CELL;
        match dimension {
            Dimension::Plane => {
                // Sixteen grains a cell, fewer where they would touch.
                let spacing = (0.25 * CELL).max(4.0 * radius);
                Suspended {
                    dimension,
                    mixture: in_slab(radius, spacing, porosity, ratio),
                    cell: CELL,
                    columns: (spacing / CELL).ceil().max(1.0) as usize,
                    spacing,
                }
            }
            Dimension::Space => {
                let cells = radius / (radius_in_cube(porosity) * CELL);
                let whole = match cells < 1.0 {
                    true => 1.0 / (1.0 / cells).round(),
                    false => cells.round(),
                };
                Suspended::in_cubes(porosity, ratio, whole * CELL)
            }
        }
    }

    fn in_cubes(porosity: f64, ratio: f64, edge: f64) -> Suspended {
        let radius = radius_in_cube(porosity) * edge;
        Suspended {
            dimension: Dimension::Space,
            mixture: creeping(Shape::Sphere, radius, porosity, ratio),
            cell: CELL,
            columns: (edge / CELL).round().max(1.0) as usize,
            spacing: edge,
        }
    }

    /// Of porosity 0.9 in a few cells each way.
    pub fn drifting(dimension: Dimension) -> Suspended {
        let (porosity, ratio) = (0.9, 2.5);
        match dimension {
            Dimension::Plane => {
                let (radius, spacing) = (0.05 * CELL, 0.25 * CELL);
                Suspended {
                    dimension,
                    mixture: in_slab(radius, spacing, porosity, ratio),
                    cell: CELL,
                    columns: 4,
                    spacing,
                }
            }
            Dimension::Space => Suspended {
                columns: 3,
                ..Suspended::in_cubes(porosity, ratio, 0.5 * CELL)
            },
        }
    }

    /// A real mixture, in cells that its lattice fits.
    pub fn one_cell_wide(dimension: Dimension, mixture: Suspension) -> Suspended {
        let (spacing, count) = match dimension {
            Dimension::Plane => {
                let spacing = mixture.radius * (PI / (1.0 - mixture.porosity)).sqrt();
                (spacing, 4.0)
            }
            Dimension::Space => (mixture.radius / radius_in_cube(mixture.porosity), CUBES),
        };
        Suspended {
            dimension,
            mixture,
            cell: count * spacing,
            columns: 1,
            spacing,
        }
    }

    /// So many rows of cells.
    pub(crate) fn domain(&self, rows: usize, sides: [&'static str; 3]) -> Domain {
        Domain {
            dimension: self.dimension,
            width: self.columns as f64 * self.cell,
            height: rows as f64 * self.cell,
            cells: [self.columns, rows],
            sides,
        }
    }

    /// Its grains with this velocity upward, all over a domain.
    pub(crate) fn grains(&self, domain: &Domain, speed: f64) -> String {
        let population = text::population(self.dimension, &self.mixture, speed);
        let upper = [domain.width, domain.height];
        match self.dimension {
            Dimension::Plane => {
                population + &text::lattice(self.dimension, [[0.0; 2], upper], self.spacing)
            }
            Dimension::Space => {
                text::face_centred(&population, upper, self.spacing, self.mixture.radius)
            }
        }
    }
}
