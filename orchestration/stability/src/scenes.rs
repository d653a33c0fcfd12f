//! The small scenes, and what each must come to. A scene is the text of a TOML file; the scheme is
//! set on top of it.

use crate::limits::{Law, Shape, Suspension};

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

pub(crate) struct Domain {
    pub width: f64,
    pub height: f64,
    pub cells: [usize; 2],
    /// left and right, bottom, top
    pub sides: [&'static str; 3],
}

pub(crate) fn fluid(mixture: &Suspension, domain: &Domain, initial: f64) -> String {
    let Domain {
        width,
        height,
        cells: [columns, rows],
        sides: [side, bottom, top],
    } = domain;
    format!(
        "[fluid]\ndensity = {:e}\ndynamic_viscosity = {:e}\ninitial_velocity = [0.0, {initial:e}]\n\
         [fluid.domain]\nrectangle = {{ lower = [0.0, 0.0], upper = [{width:e}, {height:e}], \
         cells = [{columns}, {rows}], diagonals = \"uniform\" }}\n\
         [fluid.boundaries]\nleft = {side}\nright = {side}\nbottom = {bottom}\ntop = {top}\n",
        mixture.density, mixture.viscosity,
    )
}

pub(crate) fn run(step: f64, steps: usize, gravity: f64) -> String {
    format!(
        "[run]\nend_time = {:e}\ncoupling_step = {step:e}\n[gravity]\nacceleration = [0.0, {:e}]\n",
        step * steps as f64,
        -gravity,
    )
}

pub(crate) fn coupling(mixture: &Suspension) -> String {
    let law = match mixture.law {
        Law::Stokes => "stokes",
        Law::Dallavalle => "dallavalle",
    };
    let geometry = match mixture.shape {
        Shape::Disk => "\"disk\"".into(),
        // A slab that may be written; a thinner one is set on the scene that was read (`Case::thin_slab`).
        Shape::Sphere { depth } => {
            let depth = depth.max(2.0 * mixture.radius);
            format!("{{ sphere = {{ depth = {depth:e} }} }}")
        }
    };
    format!("[contact]\ntolerance = 1e-3\n[coupling]\ndrag = \"{law}\"\ngeometry = {geometry}\n")
}

fn lattice(mixture: &Suspension, upper: [f64; 2], spacing: f64, speed: f64) -> String {
    format!(
        "[[grains]]\ndensity = {:e}\nradius = {:e}\nvelocity = [0.0, {speed:e}]\n\
         lattice = {{ lower = [0.0, 0.0], upper = [{:e}, {:e}], spacing = {spacing:e} }}\n",
        mixture.grain_density, mixture.radius, upper[0], upper[1],
    )
}

const PERIODIC: &str = "\"periodic\"";
pub(crate) const SLIP: &str = "\"slip\"";

/// Depth of a slab in which spheres of this radius on a square lattice make this porosity.
fn depth(radius: f64, spacing: f64, porosity: f64) -> f64 {
    4.0 / 3.0 * std::f64::consts::PI * radius.powi(3) / ((1.0 - porosity) * spacing * spacing)
}

/// A suspension of spheres on a lattice in a slab so thin that no porosity brings them to touch.
fn spheres(radius: f64, spacing: f64, porosity: f64, ratio: f64) -> Suspension {
    Suspension {
        law: Law::Stokes,
        shape: Shape::Sphere {
            depth: depth(radius, spacing, porosity),
        },
        radius,
        grain_density: 1000.0 * ratio,
        density: 1000.0,
        viscosity: 0.1,
        porosity,
    }
}

/// A closed column that settles in gravity so weak that no grain leaves its place:
/// `stiffness` = Δt/τ_p, `ratio` = ρ_p/ρ, `size` = d/h.
pub fn column(stiffness: f64, porosity: f64, ratio: f64, size: f64) -> Case {
    let cell = 1e-3;
    let radius = 0.5 * size * cell;
    // Sixteen grains a cell, fewer where they would touch.
    let spacing = (0.25 * cell).max(4.0 * radius);
    let columns = (spacing / cell).ceil().max(1.0) as usize;
    let rows = 32.max(8 * columns);
    let mixture = spheres(radius, spacing, porosity, ratio);
    let step = stiffness * mixture.mass() / mixture.drag(0.0);
    let weight = mixture.volume() * mixture.density * (ratio - 1.0).abs().max(1e-12);
    let slip = 1e-10 * cell / (step * STEPS as f64);
    let neutral = ratio == 1.0;
    let gravity =
        slip * mixture.drag(0.0) / (porosity * if neutral { mixture.mass() } else { weight });
    let (width, height) = (columns as f64 * cell, rows as f64 * cell);
    let domain = Domain {
        width,
        height,
        cells: [columns, rows],
        sides: [PERIODIC, SLIP, SLIP],
    };
    let time = step * STEPS as f64;
    let (value, _) = mixture.settling(gravity, time);
    let settled = porosity * slip;
    Case {
        text: run(step, STEPS, gravity)
            + &fluid(&mixture, &domain, 0.0)
            + "[particles]\nwalls = \"none\"\n"
            + &lattice(&mixture, [width, height], spacing, 0.0)
            + &coupling(&mixture),
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
pub fn drift(reynolds: f64, stiffness: f64) -> Case {
    let (cell, cells, porosity) = (1e-3, 4, 0.9);
    let (radius, spacing) = (0.05 * cell, 0.25 * cell);
    let mixture = Suspension {
        law: Law::Dallavalle,
        viscosity: 1e-3,
        ..spheres(radius, spacing, porosity, 2.5)
    };
    let speed =
        reynolds.max(1e-6) * mixture.viscosity / (mixture.density * porosity * 2.0 * radius);
    let step = stiffness * mixture.mass() / mixture.drag(speed);
    let side = cells as f64 * cell;
    let domain = Domain {
        width: side,
        height: side,
        cells: [cells, cells],
        sides: [PERIODIC, PERIODIC, PERIODIC],
    };
    let value = mixture.drifting(speed, step * STEPS as f64);
    Case {
        text: run(step, STEPS, 0.0)
            + &fluid(&mixture, &domain, 0.0)
            + &lattice(&mixture, [side, side], spacing, -speed)
            + &coupling(&mixture),
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
pub fn translation(courant: f64, peclet: f64) -> Case {
    let (cell, cells, solid, speed) = (1e-3, 8, 0.2, 1.0);
    let mixture = Suspension {
        law: Law::Dallavalle,
        shape: Shape::Disk,
        radius: 0.1 * cell,
        grain_density: 2500.0,
        density: 1000.0,
        viscosity: 1000.0 * speed * cell / peclet,
        porosity: 1.0 - solid,
    };
    let side = cells as f64 * cell;
    let domain = Domain {
        width: side,
        height: side,
        cells: [cells, cells],
        sides: [PERIODIC, PERIODIC, PERIODIC],
    };
    let step = courant * cell / speed;
    let grains = format!(
        "[[grains]]\ndensity = {:e}\nradius = {:e}\nvelocity = [0.0, {:e}]\n\
         lattice = {{ lower = [0.0, 0.0], upper = [{side:e}, {side:e}], \
         solid_fraction = {solid}, pattern = \"hexagonal\" }}\n",
        mixture.grain_density, mixture.radius, -speed,
    );
    Case {
        text: run(step, STEPS, 0.0)
            + &fluid(&mixture, &domain, -speed * mixture.porosity)
            + &grains
            + &coupling(&mixture),
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

/// A stack of touching disks on a floor, water rising at half the velocity that lifts it:
/// layers, Δt/τ_p.
pub fn held(layers: f64, stiffness: f64) -> Case {
    let (radius, gravity, share) = (5e-5, 9.81, 0.5);
    let bed = Suspension {
        law: Law::Dallavalle,
        shape: Shape::Disk,
        radius,
        grain_density: 2500.0,
        density: 1000.0,
        viscosity: 1e-3,
        porosity: 1.0 - std::f64::consts::FRAC_PI_4,
    };
    let (gradient, speed) = bed.bed(share, gravity);
    let step = stiffness * bed.mass() / bed.drag(speed / bed.porosity);
    let steps = 6;
    let (width, height) = (2.0 * radius, 2.0 * radius * layers);
    // A little room, so that the side walls hold the stack straight and carry nothing.
    let slack = 1e-9 * radius;
    let walls = format!(
        "[particles]\ndomain = {{ lower = [{:e}, 0.0], upper = [{:e}, {:e}], open = [\"top\"] }}\n",
        -slack,
        width + slack,
        2.0 * height,
    );
    let text = run(step, steps, gravity)
        + &fluid(
            &bed,
            &Domain {
                width,
                height,
                cells: [1, (layers / 4.0).ceil() as usize],
                sides: [PERIODIC, "INFLOW", "{ open = { pressure = 0.0 } }"],
            },
            speed,
        )
        .replace(
            "INFLOW",
            &format!("{{ inflow = {{ velocity = [0.0, {speed:e}] }} }}"),
        )
        + &walls
        + &lattice(&bed, [width, height], 2.0 * radius, 0.0)
        + &coupling(&bed);
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

/// Disks of radii r to `ratio` r that fall dry into a box and come to rest; about two contacts a grain.
pub fn pile(ratio: f64, contacts: f64) -> Case {
    let (smallest, gravity, steps) = (1e-3, 9.81, 60);
    let count = (0.5 * contacts).ceil();
    let mean_square = smallest * smallest * (1.0 + ratio + ratio * ratio) / 3.0;
    let side = (count * std::f64::consts::PI * mean_square / 0.35)
        .sqrt()
        .max(4.0 * ratio * smallest);
    let fall = (2.0 * side / gravity).sqrt();
    let speed = (2.0 * gravity * side).sqrt();
    let radius = format!("{{ min = {smallest:e}, max = {:e} }}", ratio * smallest);
    Case {
        text: run(fall / 12.0, steps, gravity)
            + &format!(
                "[particles]\ndomain = {{ lower = [0.0, 0.0], upper = [{side:e}, {side:e}] }}\n\
                 [[grains]]\ndensity = 2500.0\nradius = {radius}\n\
                 box = {{ lower = [0.0, 0.0], upper = [{side:e}, {side:e}], count = {count} }}\n\
                 [contact]\ntolerance = 1e-3\n"
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

/// A real pair of materials on a square lattice of disks in a closed column under real gravity.
pub fn pair(mixture: Suspension, step: f64) -> Case {
    const ROWS_MAX: f64 = 120.0;
    let gravity = 9.81;
    let spacing = mixture.radius * (std::f64::consts::PI / (1.0 - mixture.porosity)).sqrt();
    let cell = 4.0 * spacing;
    // So high that what lies on the floor by the end is a fortieth.
    let way = |steps: usize| 40.0 * mixture.settling(gravity, step * steps as f64).1.abs() / cell;
    let steps = [STEPS, 10, 5, 3, 2]
        .into_iter()
        .find(|&steps| way(steps) <= ROWS_MAX);
    let steps = steps.unwrap_or(1);
    let rows = way(steps).min(4.0 * ROWS_MAX).ceil().max(16.0) as usize;
    let (width, height) = (cell, rows as f64 * cell);
    let domain = Domain {
        width,
        height,
        cells: [1, rows],
        sides: [PERIODIC, SLIP, SLIP],
    };
    let (value, _) = mixture.settling(gravity, step * steps as f64);
    let slip = mixture.settled(gravity).abs() / mixture.porosity;
    Case {
        text: run(step, steps, gravity)
            + &fluid(&mixture, &domain, 0.0)
            + &lattice(&mixture, [width, height], spacing, 0.0)
            + &coupling(&mixture),
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
