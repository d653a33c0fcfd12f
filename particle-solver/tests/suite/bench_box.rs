//! Builders that the tests share.

use particle_solver::small::choice::Solver;
use particle_solver::{
    Candidate, ContactEngine, Error, Facet, Forces, Grains, Request, Setup, State,
};
use rustix::time::{ClockId, clock_gettime};
use space::Vector;
use std::f64::consts::PI;
use std::time::Duration;

/// Components of a vector.
pub fn xy(vector: Vector<2>) -> [f64; 2] {
    vector.into()
}

/// The engine in the plane.
pub type Engine = ContactEngine<2>;

/// No walls, no gravity, no friction; a tight tolerance.
pub fn empty() -> Setup<2> {
    Setup {
        gravity: Vector::zeros(),
        walls: Vec::new(),
        period: [None; 2],
        friction: 0.0,
        wall_friction: 0.0,
        inertia_factor: 0.5,
        tolerance: 1e-13,
        solver: Some(Solver::Converged),
        sweeps_max: 20_000,
        sub_steps_max: 1000,
    }
}

/// A wall from a to b.
pub fn wall(a: [f64; 2], b: [f64; 2]) -> Facet<2> {
    Facet::at_rest([a, b].map(Vector::from))
}

/// Floor y = 0 and walls x = 0, x = `width`, all inside facing.
pub fn box_walls(width: f64, height: f64) -> Vec<Facet<2>> {
    vec![
        wall([0.0, height], [0.0, 0.0]),
        wall([0.0, 0.0], [width, 0.0]),
        wall([width, 0.0], [width, height]),
    ]
}

/// A disk to place: centre, velocity, radius, mass.
pub struct Disk {
    pub position: [f64; 2],
    pub velocity: [f64; 2],
    pub radius: f64,
    pub mass: f64,
}

/// A disk of unit density.
pub fn disk(x: f64, y: f64, radius: f64) -> Disk {
    Disk {
        position: [x, y],
        velocity: [0.0; 2],
        radius,
        mass: PI * radius * radius,
    }
}

impl Disk {
    pub fn moving(self, vx: f64, vy: f64) -> Disk {
        Disk {
            velocity: [vx, vy],
            ..self
        }
    }
    pub fn of_mass(self, mass: f64) -> Disk {
        Disk { mass, ..self }
    }
}

/// An engine with these disks, those listed in `fixed` never move.
pub fn engine_with_fixed(setup: Setup<2>, disks: &[Disk], fixed: &[usize]) -> Engine {
    let grains = Grains {
        radius: disks.iter().map(|disk| disk.radius).collect(),
        mass: disks.iter().map(|disk| disk.mass).collect(),
        fixed: (0..disks.len())
            .map(|grain| fixed.contains(&grain))
            .collect(),
    };
    let position = disks
        .iter()
        .map(|disk| Vector::from(disk.position))
        .collect();
    let velocity = disks
        .iter()
        .map(|disk| Vector::from(disk.velocity))
        .collect();
    let state = State::new(&grains, position, velocity).expect("disks are finite");
    ContactEngine::new(setup, grains, state).expect("the setup is valid")
}

/// An engine with these disks.
pub fn engine(setup: Setup<2>, disks: &[Disk]) -> Engine {
    engine_with_fixed(setup, disks, &[])
}

/// A request for one sub-step of length `dt`.
pub fn request(step: u64, dt: f64) -> Request {
    Request {
        step,
        pass: 0,
        dt,
        sub_steps: 1,
        tolerance: 0.0,
    }
}

/// A request for a step of length `dt` in as many sub-steps as the engine chooses.
pub fn choose(step: u64, dt: f64) -> Request {
    Request {
        sub_steps: 0,
        ..request(step, dt)
    }
}

/// Advance without fluid and accept; the accepted candidate.
pub fn try_step(engine: &mut Engine, request: &Request) -> Result<Candidate<2>, Error> {
    let candidate = engine.advance(request, &Forces::default())?.clone();
    engine.commit()?;
    Ok(candidate)
}

/// As `try_step`, for steps that must succeed.
pub fn step(engine: &mut Engine, request: &Request) -> Candidate<2> {
    try_step(engine, request).unwrap_or_else(|error| panic!("step {}: {error}", request.step))
}

/// ½ Σ m v² + ½ I ω² of the accepted state.
pub fn kinetic_energy(engine: &Engine) -> f64 {
    engine
        .accepted()
        .kinetic_energy(engine.grains(), engine.setup().inertia_factor)
}

/// A small generator of numbers in [0, 1).
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// Disks of radius 1 ± `spread` on a loose, jittered lattice `columns` wide.
pub fn loose_disks(count: usize, columns: usize, spread: f64, seed: u64) -> Vec<Disk> {
    let mut random = Random(seed);
    let pitch = 2.0 * (1.0 + spread) + 0.2;
    (0..count)
        .map(|place| {
            let jitter = 0.1 * (random.next() - 0.5);
            let x = pitch * ((place % columns) as f64 + 0.5) + jitter;
            let y = pitch * ((place / columns) as f64 + 0.5);
            disk(x, y, 1.0 + spread * (2.0 * random.next() - 1.0))
        })
        .collect()
}

/// Nanoseconds of this thread's CPU that a call takes.
pub fn cost(mut call: impl FnMut()) -> f64 {
    let now = || {
        let time = clock_gettime(ClockId::ThreadCPUTime);
        Duration::new(time.tv_sec as u64, time.tv_nsec as u32)
    };
    let before = now();
    call();
    (now() - before).as_nanos() as f64
}

/// The middle one.
pub fn median(samples: &mut [f64]) -> f64 {
    samples.sort_by(f64::total_cmp);
    samples[samples.len() / 2]
}
