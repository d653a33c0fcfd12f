//! The runs of `tests/recordings/`: small, a few steps each, of every kind.

use std::path::{Path, PathBuf};

use coupler::drag::{self, Shape, implicit_slip_speed};
use protocol::engine::InitialGrains;
use protocol::message::Role;
use protocol::scene::{
    Boundary, CouplerScene, DragLaw, Geometry, Nonlinear, Profile, TimeScheme, Wall,
};
use recording::{Begin, Options, Outcome, Reader, Recorder, RecordingError, summary};

use crate::grains::{Noise, disks, lattice, sunflower};
use crate::{
    box_walls, couple_recorded, fluid, particles, scene, with_boundaries, with_uniform_diagonals,
};

const GRAVITY: [f64; 2] = [0.0, -9.81];

/// A run that is recorded.
pub struct Case {
    /// Name of its files.
    pub name: &'static str,
    /// What is run, each step of the length of the scene's.
    pub scene: CouplerScene,
    /// The grains at the start.
    pub grains: InitialGrains,
    /// How many steps.
    pub steps: usize,
}

impl Case {
    /// Engines that take part.
    pub fn seats(&self) -> Vec<Role> {
        let fluid = self.scene.fluid.as_ref().map(|_| Role::Fluid);
        let particles = self.scene.particles.as_ref().map(|_| Role::Particles);
        fluid.into_iter().chain(particles).collect()
    }

    /// Its stored recording.
    pub fn stored(&self) -> PathBuf {
        folder().join(format!("{}.mcap", self.name))
    }

    /// The text beside it.
    pub fn text(&self) -> PathBuf {
        folder().join(format!("{}.txt", self.name))
    }

    /// Run it now and record it.
    pub fn record(&self, path: &Path) -> Result<Outcome, RecordingError> {
        let program = concat!("sillage-coupler ", env!("CARGO_PKG_VERSION"));
        let begin = Begin::of(&self.scene, program, None)?;
        let recorder = Recorder::create(path, Options::default(), &begin)?;
        let mut coupling = couple_recorded(self.scene.clone(), &self.grains, Some(&recorder));
        for step in 1..=self.steps {
            coupling
                .advance(self.scene.coupling_step)
                .unwrap_or_else(|error| panic!("{} step {step}: {error}", self.name));
        }
        // as for a state that is put out
        let told = match coupling.system.seats_mut() {
            (Some(seat), _) => seat.pressure().map(drop),
            _ => Ok(()),
        };
        told.and_then(|()| coupling.fetch_unread())
            .unwrap_or_else(|error| panic!("{}: {error}", self.name));
        drop(coupling);
        Ok(recorder.finish(0))
    }
}

/// `tests/recordings`.
pub fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("recordings")
}

/// What is in a recording, as it stands beside it.
pub fn text_of(path: &Path) -> Result<String, RecordingError> {
    summary(&mut Reader::open(path)?)
}

/// All of them.
pub fn cases() -> Vec<Case> {
    vec![cloud(), held_bed(), dry_collapse(), cavity(), leaving()]
}

/// Glass in glycerine, iterated.
fn cloud() -> Case {
    let (lower, upper) = ([-0.02, 0.0], [0.02, 0.06]);
    let fluid = fluid(1200.0, 0.12, GRAVITY, lower, upper, [8, 24]);
    let mut engine = particles(GRAVITY);
    engine.walls = box_walls(lower, upper);
    let grains = disks(&sunflower([0.0, 0.045], 3.7e-3, 40), &[2.6e-4; 40], 2400.0);
    Case {
        name: "cloud",
        scene: scene(Some(fluid), Some(engine), 5.5e-3, 6),
        grains,
        steps: 6,
    }
}

/// Glass beads in water, one column of touching disks on a floor, at half the flow that lifts them.
fn held_bed() -> Case {
    const LAYERS: usize = 32;
    const RADIUS: f64 = 5e-5;
    let (density, viscosity, glass) = (1000.0, 1e-3, 2500.0);
    let centres: Vec<[f64; 2]> = (0..LAYERS)
        .map(|k| [RADIUS, (2 * k + 1) as f64 * RADIUS])
        .collect();
    let (width, height) = (2.0 * RADIUS, 2.0 * LAYERS as f64 * RADIUS);
    let porosity = 1.0 - std::f64::consts::FRAC_PI_4;
    let shape = Shape::new(Geometry::Disk, RADIUS, 1.0);
    let water = drag::Fluid {
        density,
        dynamic_viscosity: viscosity,
    };
    let carried = porosity * shape.volume * (glass - density) * 9.81;
    let slip = implicit_slip_speed(DragLaw::Dallavalle, &water, porosity, &shape, 0.0, carried);
    let speed = 0.5 * porosity * slip;
    let (lower, upper) = ([0.0, 0.0], [width, height]);
    let fluid = fluid(density, viscosity, GRAVITY, lower, upper, [1, LAYERS / 4]);
    let inflow = Boundary::Inflow {
        velocity: vec![0.0, speed],
        profile: Profile::Uniform,
    };
    let conditions = [
        ("left", Boundary::Periodic),
        ("right", Boundary::Periodic),
        ("bottom", inflow),
        ("top", Boundary::Open { pressure: 0.0 }),
    ];
    let mut fluid = with_uniform_diagonals(with_boundaries(fluid, &conditions));
    fluid.initial_velocity = vec![0.0, speed];
    let mut engine = particles(GRAVITY);
    let slack = 1e-9 * RADIUS;
    engine.walls = vec![
        Wall::segment([-slack, 2.0 * height], [-slack, 0.0]),
        Wall::segment([-slack, 0.0], [width + slack, 0.0]),
        Wall::segment([width + slack, 0.0], [width + slack, 2.0 * height]),
    ];
    let scene = scene(Some(fluid), Some(engine), 1e-4, 4);
    Case {
        name: "held-bed",
        scene,
        grains: disks(&centres, &[RADIUS; LAYERS], glass),
        steps: 4,
    }
}

/// A pile of rough grains of two sizes that falls apart, no fluid.
fn dry_collapse() -> Case {
    let mut noise = Noise::new(1);
    let centres = lattice([0.0, 0.0], 0.0125, [5, 10]);
    let radii: Vec<f64> = centres.iter().map(|_| 5e-3 + noise.around(1e-3)).collect();
    let mut engine = particles(GRAVITY);
    engine.walls = box_walls([0.0, 0.0], [0.3, 0.3]);
    (engine.friction, engine.wall_friction) = (0.3, 0.3);
    Case {
        name: "dry-collapse",
        scene: scene(None, Some(engine), 4e-3, 40),
        grains: disks(&centres, &radii, 2500.0),
        steps: 40,
    }
}

/// The lid-driven cavity with convection by Newton and BDF2, no grains.
fn cavity() -> Case {
    let lid = Boundary::Inflow {
        velocity: vec![1.0, 0.0],
        profile: Profile::Uniform,
    };
    let fluid = fluid(1.0, 1e-2, [0.0, 0.0], [0.0, 0.0], [1.0, 1.0], [12, 12]);
    let mut fluid = with_boundaries(fluid, &[("top", lid)]);
    fluid.convection = true.into();
    fluid.time_scheme = TimeScheme::Bdf2;
    fluid.nonlinear = Nonlinear::Newton {
        tolerance: 1e-10,
        iterations_max: 20,
    };
    Case {
        name: "cavity",
        scene: scene(Some(fluid), None, 0.1, 6),
        grains: InitialGrains::default(),
        steps: 6,
    }
}

/// A pile of heavy grains of two sizes that slides out of an open bottom, walls on both sides.
pub fn leaving() -> Case {
    const WIDTH: f64 = 0.02;
    let mut noise = Noise::new(2);
    let centres = lattice([0.0, 0.0], 2e-3, [10, 5]);
    let radii: Vec<f64> = centres.iter().map(|_| 9e-4 + noise.around(1e-4)).collect();
    let (lower, upper) = ([0.0, 0.0], [WIDTH, 2.0 * WIDTH]);
    let open = |pressure| Boundary::Open { pressure };
    let fluid = fluid(1000.0, 1e-2, GRAVITY, lower, upper, [5, 10]);
    let conditions = [
        ("bottom", open(1000.0 * 9.81 * 2.0 * WIDTH)),
        ("top", open(0.0)),
    ];
    let mut engine = particles(GRAVITY);
    (engine.friction, engine.wall_friction) = (0.3, 0.3);
    engine.walls = vec![
        Wall::segment([0.0, 2.0 * WIDTH], [0.0, 0.0]),
        Wall::segment([WIDTH, 0.0], [WIDTH, 2.0 * WIDTH]),
    ];
    let fluid = with_boundaries(fluid, &conditions);
    let mut scene = scene(Some(fluid), Some(engine), 5e-3, 12);
    scene.grain_exits = vec!["bottom".to_owned(), "top".to_owned()];
    Case {
        name: "leaving",
        scene,
        grains: disks(&centres, &radii, 2500.0),
        steps: 12,
    }
}
