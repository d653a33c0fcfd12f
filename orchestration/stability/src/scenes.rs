//! The small scenes, and what each must come to. A scene is the text of a TOML file; the scheme is
//! set on top of it.

use std::f64::consts::PI;

use crate::dimension::Dimension;
use crate::limits::{Law, Shape, Suspension};
use crate::suspended::Suspended;
use crate::text::{self, Domain, PERIODIC, SLIP};

/// Steps of a run, where the scene does not say otherwise.
const STEPS: usize = 20;
/// Largest relative error of a limit: backward Euler leaves up to 1.6 % of a linear law after twenty
/// steps of any length, and up to 3.6 % of what is left of a velocity that decays.
const TOLERANCE: f64 = 0.05;

/// A scene with its limit.
#[derive(Debug, Clone)]
pub struct Case {
    /// Text of the scene without its scheme.
    pub text: String,
    /// Coupling steps, unless the run halves some.
    pub steps: usize,
    /// What its last step must show.
    pub limit: Limit,
    /// Largest speed that the exact solution has on its way \[m/s\].
    pub speed: f64,
    /// Do the grains weigh something in the fluid? The third law is reported relative to that.
    pub weighs: bool,
    /// Depth of the slab \[m\], where it is thinner than a sphere is wide: `check` refuses that to others.
    pub thin_slab: Option<f64>,
}

/// The closed form of a column of `steps.csv` at the end of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Limit {
    /// Column.
    pub column: &'static str,
    /// Its value.
    pub value: f64,
    /// What an error is relative to.
    pub scale: f64,
    /// Largest relative error.
    pub tolerance: f64,
}

/// A closed column that settles in gravity so weak that no grain leaves its place:
/// `stiffness` = Δt/τ_p.
pub fn column(suspended: &Suspended, stiffness: f64) -> Case {
    let Suspended {
        dimension,
        cell,
        columns,
        mixture,
        ..
    } = suspended;
    let rows = match dimension {
        Dimension::Plane => 32.max(8 * columns),
        Dimension::Space => 16.max(6 * columns),
    };
    let (porosity, ratio) = (mixture.porosity, mixture.grain_density / mixture.density);
    let step = stiffness * mixture.mass() / mixture.drag(0.0);
    let weight = mixture.volume() * mixture.density * (ratio - 1.0).abs().max(1e-12);
    let slip = 1e-10 * cell / (step * STEPS as f64);
    let neutral = ratio == 1.0;
    let gravity =
        slip * mixture.drag(0.0) / (porosity * if neutral { mixture.mass() } else { weight });
    let domain = suspended.domain(rows, [PERIODIC, SLIP, SLIP]);
    let time = step * STEPS as f64;
    let (value, _) = mixture.settling(gravity, time);
    let settled = porosity * slip;
    Case {
        text: text::run(*dimension, step, STEPS, gravity)
            + &text::fluid(mixture, &domain, 0.0)
            + "[particles]\nwalls = \"none\"\n"
            + &suspended.grains(&domain, 0.0)
            + &text::coupling(mixture),
        steps: STEPS,
        limit: Limit {
            column: "fall_speed_median",
            value,
            scale: if neutral { settled } else { value.abs() },
            tolerance: TOLERANCE,
        },
        speed: slip,
        weighs: !neutral,
        thin_slab: mixture.thin_slab(),
    }
}

/// Grains shot into fluid at rest, in a periodic box without gravity: Re of the start, Δt/τ_p.
pub fn drift(dimension: Dimension, reynolds: f64, stiffness: f64) -> Case {
    let mut suspended = Suspended::drifting(dimension);
    let porosity = suspended.mixture.porosity;
    let mixture = &mut suspended.mixture;
    mixture.law = Law::Dallavalle;
    mixture.viscosity = 1e-3;
    let mixture = &suspended.mixture;
    let speed = reynolds.max(1e-6) * mixture.viscosity
        / (mixture.density * porosity * 2.0 * mixture.radius);
    let step = stiffness * mixture.mass() / mixture.drag(speed);
    let domain = suspended.domain(suspended.columns, [PERIODIC, PERIODIC, PERIODIC]);
    let value = mixture.drifting(speed, step * STEPS as f64);
    Case {
        text: text::run(dimension, step, STEPS, 0.0)
            + &text::fluid(mixture, &domain, 0.0)
            + &suspended.grains(&domain, -speed)
            + &text::coupling(mixture),
        steps: STEPS,
        limit: Limit {
            column: "fall_speed",
            value,
            scale: value,
            tolerance: TOLERANCE,
        },
        speed,
        weighs: false,
        thin_slab: mixture.thin_slab(),
    }
}

/// A hexagonal lattice and fluid that move alike through a periodic box: cells crossed in a step, and
/// ρ v h/μ. The lattice does not fit the mesh, so the porosity of every node changes from step to
/// step; they go on all the same.
pub fn translation(dimension: Dimension, courant: f64, peclet: f64) -> Case {
    let (cell, solid, speed) = (1e-3, 0.2, 1.0);
    let (cells, shape, size) = match dimension {
        Dimension::Plane => (8, Shape::Disk, 0.1),
        Dimension::Space => (5, Shape::Sphere, 0.12),
    };
    let mixture = Suspension {
        law: Law::Dallavalle,
        shape,
        radius: size * cell,
        grain_density: 2500.0,
        density: 1000.0,
        viscosity: 1000.0 * speed * cell / peclet,
        porosity: 1.0 - solid,
    };
    let side = cells as f64 * cell;
    let domain = Domain {
        dimension,
        width: side,
        height: side,
        cells: [cells, cells],
        sides: [PERIODIC, PERIODIC, PERIODIC],
    };
    let step = courant * cell / speed;
    let grains = format!(
        "{}lattice = {{ lower = {}, upper = {}, solid_fraction = {solid}, pattern = \"hexagonal\" }}\n",
        text::population(dimension, &mixture, -speed),
        dimension.place(0.0, 0.0),
        dimension.place(side, side),
    );
    Case {
        text: text::run(dimension, step, STEPS, 0.0)
            + &text::fluid(&mixture, &domain, -speed * mixture.porosity)
            + &grains
            + &text::coupling(&mixture),
        steps: STEPS,
        limit: Limit {
            column: "fall_speed",
            value: speed,
            scale: speed,
            tolerance: TOLERANCE,
        },
        // the initial velocity is the superficial one: some cells begin faster
        speed: 2.0 * speed,
        weighs: false,
        thin_slab: None,
    }
}

/// A stack of touching grains on a floor, one grain wide, water rising at half the velocity that lifts it:
/// layers, Δt/τ_p.
pub fn held(dimension: Dimension, layers: f64, stiffness: f64) -> Case {
    let (radius, gravity, share) = (5e-5, 9.81, 0.5);
    let (shape, solid) = match dimension {
        Dimension::Plane => (Shape::Disk, PI / 4.0),
        Dimension::Space => (Shape::Sphere, PI / 6.0),
    };
    let bed = Suspension {
        law: Law::Dallavalle,
        shape,
        radius,
        grain_density: 2500.0,
        density: 1000.0,
        viscosity: 1e-3,
        porosity: 1.0 - solid,
    };
    let (gradient, speed) = bed.bed(share, gravity);
    let step = stiffness * bed.mass() / bed.drag(speed / bed.porosity);
    let steps = 6;
    let (width, height) = (2.0 * radius, 2.0 * radius * layers);
    // A little room, so that the side walls hold the stack straight and carry nothing.
    let slack = 1e-9 * radius;
    let walls = format!(
        "[particles]\ndomain = {{ lower = {}, upper = {}, open = [\"top\"] }}\n",
        dimension.place(-slack, 0.0),
        dimension.place(width + slack, 2.0 * height),
    );
    let domain = Domain {
        dimension,
        width,
        height,
        cells: [1, (layers / 4.0).ceil() as usize],
        sides: [PERIODIC, "INFLOW", "{ open = { pressure = 0.0 } }"],
    };
    let inflow = text::inflow(dimension, speed);
    let text = text::run(dimension, step, steps, gravity)
        + &text::fluid(&bed, &domain, speed).replace("INFLOW", &inflow)
        + &walls
        + &text::population(dimension, &bed, 0.0)
        + &text::lattice(dimension, [[0.0; 2], [width, height]], 2.0 * radius)
        + &text::coupling(&bed);
    let weight = bed.density * gravity * height;
    Case {
        text,
        steps,
        limit: Limit {
            column: "pressure_drop",
            value: gradient * height,
            scale: gradient * height - weight,
            tolerance: TOLERANCE,
        },
        speed: speed / bed.porosity,
        weighs: true,
        thin_slab: None,
    }
}

/// Grains of radii r to `ratio` r that fall dry into a box and come to rest; about two contacts a disk, three
/// a sphere.
pub fn pile(dimension: Dimension, ratio: f64, contacts: f64) -> Case {
    let (smallest, gravity, steps) = (1e-3_f64, 9.81, 60);
    // mean content of a grain of unit smallest radius, contacts of a grain, share of the box at random
    let (mean, of_one, share) = match dimension {
        Dimension::Plane => (PI * (1.0 + ratio + ratio * ratio) / 3.0, 2.0, 0.35),
        Dimension::Space => (PI * (1.0 + ratio) * (1.0 + ratio * ratio) / 3.0, 3.0, 0.2),
    };
    let count = (contacts / of_one).ceil();
    let side = dimension.edge(count * mean / share).max(4.0 * ratio) * smallest;
    let fall = (2.0 * side / gravity).sqrt();
    let speed = (2.0 * gravity * side).sqrt();
    let radius = format!("{{ min = {smallest:e}, max = {:e} }}", ratio * smallest);
    let corners = format!(
        "lower = {}, upper = {}",
        dimension.place(0.0, 0.0),
        dimension.place(side, side)
    );
    Case {
        text: text::run(dimension, fall / 12.0, steps, gravity)
            + &format!(
                "[particles]\ndomain = {{ {corners} }}\n\
                 [[grains]]\ndensity = 2500.0\nradius = {radius}\n\
                 box = {{ {corners}, count = {count} }}\n[contact]\ntolerance = 1e-3\n"
            ),
        steps,
        limit: Limit {
            column: "fall_speed",
            value: 0.0,
            scale: speed,
            tolerance: TOLERANCE,
        },
        speed,
        weighs: true,
        thin_slab: None,
    }
}

/// A real pair of materials in a closed column under real gravity, one cell wide: disks on a square lattice,
/// spheres on a face-centred cubic one.
pub fn pair(dimension: Dimension, mixture: Suspension, step: f64) -> Case {
    let suspended = Suspended::one_cell_wide(dimension, mixture);
    // Dense lattices of space have a layer less: what that does creeps inward, by less than a row a step.
    let (rows_least, rows_max) = match dimension {
        Dimension::Plane => (16.0, 120.0),
        Dimension::Space => (48.0, 60.0),
    };
    let gravity = 9.81;
    // So high that what lies on the floor by the end is a fortieth.
    let way = |steps: usize| {
        40.0 * mixture.settling(gravity, step * steps as f64).1.abs() / suspended.cell
    };
    let steps = [STEPS, 10, 5, 3, 2]
        .into_iter()
        .find(|&steps| way(steps) <= rows_max);
    let steps = steps.unwrap_or(1);
    let rows = way(steps).min(4.0 * rows_max).ceil().max(rows_least) as usize;
    let domain = suspended.domain(rows, [PERIODIC, SLIP, SLIP]);
    let (value, _) = mixture.settling(gravity, step * steps as f64);
    let slip = mixture.settled(gravity).abs() / mixture.porosity;
    Case {
        text: text::run(dimension, step, steps, gravity)
            + &text::fluid(&mixture, &domain, 0.0)
            + &suspended.grains(&domain, 0.0)
            + &text::coupling(&mixture),
        steps,
        limit: Limit {
            column: "fall_speed_median",
            value,
            scale: value.abs(),
            tolerance: TOLERANCE,
        },
        speed: slip,
        weighs: true,
        thin_slab: None,
    }
}
