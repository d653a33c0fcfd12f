//! The maps: pairs of axes with the scene at each of their points.

use crate::dimension::Dimension;
use crate::limits::{Law, Shape, Suspension};
use crate::plugs::{Packing, plug};
use crate::scenes::{self, Case};
use crate::suspended::Suspended;

/// A pair of axes.
pub struct Map {
    /// Name, of its files too.
    pub name: &'static str,
    /// What is run, and what is known of it.
    pub title: &'static str,
    /// From left to right.
    pub across: Axis,
    /// From bottom to top.
    pub up: Axis,
    /// Are there two phases, so that schemes differ?
    pub coupled: bool,
    /// In the plane or in space?
    pub dimension: Dimension,
    /// The scene at a point (value across, value up).
    scene: fn(Dimension, f64, f64) -> Case,
}

impl Map {
    /// The scene at a point, by its places on the axes.
    pub fn case(&self, across: usize, up: usize) -> Case {
        (self.scene)(
            self.dimension,
            self.across.values[across],
            self.up.values[up],
        )
    }
}

/// An axis.
pub struct Axis {
    /// What varies, with its unit.
    pub name: &'static str,
    /// Its values.
    pub values: Vec<f64>,
    /// How each is written.
    pub labels: Vec<String>,
    /// Places taken by `--quick`, the ends among them.
    pub quick: Vec<usize>,
}

impl Axis {
    fn new(name: &'static str, values: &[f64], quick: &[usize]) -> Axis {
        Axis {
            name,
            values: values.to_vec(),
            labels: values.iter().map(|value| label(*value)).collect(),
            quick: quick.to_vec(),
        }
    }

    /// Places that are run.
    pub fn places(&self, quick: bool) -> Vec<usize> {
        if quick {
            self.quick.clone()
        } else {
            (0..self.values.len()).collect()
        }
    }

    /// Is this place an end?
    pub fn is_end(&self, place: usize) -> bool {
        place == 0 || place + 1 == self.values.len()
    }
}

fn label(value: f64) -> String {
    if value == 0.0 || (1e-3 - 1e-12..1e3).contains(&value) && value != 1e-3 {
        format!("{value}")
    } else {
        format!("{value:e}")
    }
}

fn stiffness() -> Axis {
    let values: Vec<f64> = (-3..=7).map(|k| 10_f64.powi(k)).collect();
    Axis::new("Δt/τ_p", &values, &[0, 3, 6, 10])
}

fn porosity(dimension: Dimension) -> Axis {
    // Spheres in a thin slab may be denser than any packing.
    let densest: &[f64] = match dimension {
        Dimension::Plane => &[0.1, 0.2, 0.3],
        Dimension::Space => &[0.27, 0.3, 0.4],
    };
    let values = [densest, &[0.5, 0.7, 0.9, 0.99, 0.999]].concat();
    Axis::new("porosity φ", &values, &[0, 3, 7])
}

fn materials(dimension: Dimension) -> Vec<(String, Suspension)> {
    let text = include_str!("materials.csv");
    let rows = text.lines().filter(|line| !line.starts_with('#')).skip(1);
    rows.map(|line| {
        let cells: Vec<&str> = line.split(',').collect();
        let number = |column: usize| cells[column].parse().expect("a table of this crate");
        let pair = Suspension {
            law: Law::Dallavalle,
            shape: match dimension {
                Dimension::Plane => Shape::Disk,
                Dimension::Space => Shape::Sphere,
            },
            radius: number(2),
            grain_density: number(1),
            density: number(3),
            viscosity: number(4),
            porosity: 0.8,
        };
        (cells[0].to_string(), pair)
    })
    .collect()
}

fn pairs(dimension: Dimension) -> Axis {
    let materials = materials(dimension);
    let last = materials.len() - 1;
    Axis {
        name: "material pair",
        values: (0..materials.len()).map(|k| k as f64).collect(),
        labels: materials.into_iter().map(|(name, _)| name).collect(),
        quick: vec![0, 2, 4, 6, 8, 10, last],
    }
}

fn pair(dimension: Dimension, place: f64, solid_fraction: f64) -> Suspension {
    let (_, pair) = materials(dimension).swap_remove(place as usize);
    Suspension {
        porosity: 1.0 - solid_fraction,
        ..pair
    }
}

/// Every map of the plane, or of space.
pub fn all(dimension: Dimension) -> Vec<Map> {
    let maps = [
        stiffness_porosity,
        stiffness_loading,
        density_porosity,
        stiffness_reynolds,
        stiffness_size,
        courant_peclet,
        stiffness_stack,
        radius_contacts,
        step_pair,
        fraction_pair,
        grains_roughness,
        stiffness_roughness,
    ];
    maps.map(|map| map(dimension)).into()
}

fn stiffness_porosity(dimension: Dimension) -> Map {
    Map {
        name: "stiffness-porosity",
        title: "closed column, ρ_p/ρ = 2.5; limit: slip of zero volume flux",
        across: stiffness(),
        up: porosity(dimension),
        coupled: true,
        dimension,
        scene: |dimension, stiffness, porosity| {
            scenes::column(&Suspended::fine(dimension, porosity, 2.5), stiffness)
        },
    }
}

fn stiffness_loading(dimension: Dimension) -> Map {
    Map {
        name: "stiffness-loading",
        title: "closed column, φ = 0.7; limit: slip of zero volume flux",
        across: stiffness(),
        up: Axis::new(
            "mass loading",
            &[3e-4, 3e-3, 3e-2, 0.3, 3.0, 30.0, 400.0, 4e3],
            &[0, 3, 7],
        ),
        coupled: true,
        dimension,
        scene: |dimension, stiffness, loading| {
            let ratio = loading * 0.7 / 0.3;
            scenes::column(&Suspended::fine(dimension, 0.7, ratio), stiffness)
        },
    }
}

fn density_porosity(dimension: Dimension) -> Map {
    Map {
        name: "density-porosity",
        title: "closed column, Δt/τ_p = 1e3; limit: slip of zero volume flux",
        across: Axis::new(
            "density ratio ρ_p/ρ",
            &[1e-3, 1e-2, 0.1, 0.5, 1.0, 2.0, 10.0, 1e2, 1e3, 1e4],
            &[0, 4, 5, 9],
        ),
        up: porosity(dimension),
        coupled: true,
        dimension,
        scene: |dimension, ratio, porosity| {
            scenes::column(&Suspended::fine(dimension, porosity, ratio), 1e3)
        },
    }
}

fn stiffness_reynolds(dimension: Dimension) -> Map {
    Map {
        name: "stiffness-reynolds",
        title: "grains shot into fluid at rest, periodic, φ = 0.9; limit: common velocity",
        across: stiffness(),
        up: Axis::new(
            "grain Reynolds number",
            &[0.0, 1e-2, 1.0, 1e2, 1e3, 1e4],
            &[0, 2, 5],
        ),
        coupled: true,
        dimension,
        scene: |dimension, stiffness, reynolds| scenes::drift(dimension, reynolds, stiffness),
    }
}

fn stiffness_size(dimension: Dimension) -> Map {
    Map {
        name: "stiffness-size",
        title: "closed column, φ = 0.8, ρ_p/ρ = 2.5; limit: slip of zero volume flux",
        across: stiffness(),
        up: match dimension {
            Dimension::Plane => {
                let sizes = [2e-3, 2e-2, 0.125, 0.25, 0.5, 1.0, 2.0];
                Axis::new("grain/cell size d/h", &sizes, &[0, 3, 6])
            }
            // As many as make whole cubes of a cell, or whole cells of a cube.
            Dimension::Space => {
                let sizes = [0.11, 0.15, 0.23, 0.46, 0.91, 1.8];
                Axis::new("grain/cell size d/h", &sizes, &[0, 3, 5])
            }
        },
        coupled: true,
        dimension,
        scene: |dimension, stiffness, size| {
            scenes::column(&Suspended::of_size(dimension, 0.8, 2.5, size), stiffness)
        },
    }
}

fn courant_peclet(dimension: Dimension) -> Map {
    Map {
        name: "courant-peclet",
        title: "a lattice that moves with the fluid, periodic; limit: it goes on",
        across: Axis::new(
            "CFL number v Δt/h",
            &[1e-2, 0.1, 0.5, 1.0, 2.0, 10.0, 1e2],
            &[0, 3, 6],
        ),
        up: Axis::new(
            "cell Péclet number ρvh/μ",
            &[1e-4, 1e-2, 1.0, 10.0, 1e2, 1e3],
            &[0, 2, 5],
        ),
        coupled: true,
        dimension,
        scene: scenes::translation,
    }
}

fn stiffness_stack(dimension: Dimension) -> Map {
    Map {
        name: "stiffness-stack",
        title: "stack held by its floor at U_mf/2; limit: its pressure drop",
        across: stiffness(),
        up: Axis::new(
            "stack height [grains]",
            &[4.0, 16.0, 64.0, 256.0],
            &[0, 1, 2],
        ),
        coupled: true,
        dimension,
        scene: |dimension, stiffness, layers| scenes::held(dimension, layers, stiffness),
    }
}

fn radius_contacts(dimension: Dimension) -> Map {
    Map {
        name: "radius-contacts",
        title: "dry grains falling into a box; limit: rest",
        across: Axis::new(
            "radius ratio",
            &[1.0, 2.0, 5.0, 10.0, 30.0, 100.0],
            &[0, 3, 5],
        ),
        up: Axis::new(
            "contacts",
            &[10.0, 30.0, 100.0, 300.0, 1e3, 3e3],
            &[0, 2, 3],
        ),
        coupled: false,
        dimension,
        scene: scenes::pile,
    }
}

fn step_pair(dimension: Dimension) -> Map {
    Map {
        name: "step-pair",
        title: "closed column under real gravity, c = 0.2; limit: fall at zero volume flux",
        across: Axis::new("Δt [s]", &[1e-6, 1e-5, 1e-4, 1e-3, 1e-2], &[0, 3, 4]),
        up: pairs(dimension),
        coupled: true,
        dimension,
        scene: |dimension, step, place| scenes::pair(dimension, pair(dimension, place, 0.2), step),
    }
}

fn fraction_pair(dimension: Dimension) -> Map {
    Map {
        name: "fraction-pair",
        title: "closed column under real gravity, Δt = 1 ms; limit: fall at zero volume flux",
        // 0.8 of the table is denser than disks on a square lattice.
        across: Axis::new("solid fraction", &[0.01, 0.05, 0.2, 0.6], &[0, 3]),
        up: pairs(dimension),
        coupled: true,
        dimension,
        scene: |dimension, fraction, place| {
            scenes::pair(dimension, pair(dimension, place, fraction), 1e-3)
        },
    }
}

fn packings() -> Axis {
    Axis {
        name: "packing",
        values: (0..Packing::ALL.len()).map(|k| k as f64).collect(),
        labels: Packing::ALL.map(|packing| packing.name().to_owned()).into(),
        quick: (0..Packing::ALL.len()).collect(),
    }
}

fn packing(place: f64) -> Packing {
    Packing::ALL[place as usize]
}

fn grains_roughness(dimension: Dimension) -> Map {
    Map {
        name: "grains-roughness",
        title: "plug of fixed grains in a channel, Δt/τ_f = 1e3; limit: the uniform flow that comes in",
        across: match dimension {
            Dimension::Plane => {
                let counts = [16.0, 64.0, 160.0, 400.0, 630.0];
                Axis::new("grains a cell", &counts, &[0, 2, 4])
            }
            Dimension::Space => {
                let counts = [64.0, 125.0, 216.0, 343.0, 512.0];
                Axis::new("grains a cell", &counts, &[0, 2, 4])
            }
        },
        up: packings(),
        coupled: true,
        dimension,
        scene: |dimension, per_cell, place| plug(dimension, packing(place), per_cell, 1e3),
    }
}

fn stiffness_roughness(dimension: Dimension) -> Map {
    let values: Vec<f64> = (-2..=7).map(|k| 10_f64.powi(k)).collect();
    Map {
        name: "stiffness-roughness",
        title: "plug of 64 fixed grains a cell in a channel; limit: the uniform flow that comes in",
        across: Axis::new("Δt/τ_f", &values, &[0, 3, 9]),
        up: packings(),
        coupled: true,
        dimension,
        scene: |dimension, stiffness, place| plug(dimension, packing(place), 64.0, stiffness),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_span_the_ranges_asked_for() {
        let maps = all(Dimension::Plane);
        let ends = |axis: &str| {
            let found = maps.iter().flat_map(|map| [&map.across, &map.up]);
            let axis = found
                .into_iter()
                .find(|own| own.name.starts_with(axis))
                .expect("an axis");
            (axis.values[0], axis.values[axis.values.len() - 1])
        };
        assert_eq!(ends("Δt/τ_p"), (1e-3, 1e7));
        assert_eq!(ends("mass loading"), (3e-4, 4e3));
        assert_eq!(ends("density ratio"), (1e-3, 1e4));
        assert_eq!(ends("porosity"), (0.1, 0.999));
        assert_eq!(ends("grain Reynolds"), (0.0, 1e4));
        assert_eq!(ends("grain/cell"), (2e-3, 2.0));
        assert_eq!(ends("cell Péclet"), (1e-4, 1e3));
    }

    #[test]
    fn quick_begins_at_the_lower_end() {
        for map in [Dimension::Plane, Dimension::Space]
            .into_iter()
            .flat_map(all)
        {
            for axis in [&map.across, &map.up] {
                assert_eq!(axis.quick[0], 0, "{}: {}", map.name, axis.name);
                assert!(axis.quick.iter().all(|&place| place < axis.values.len()));
            }
        }
    }
}
