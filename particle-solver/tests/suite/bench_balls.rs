//! Builders for tests in space.

use std::f64::consts::PI;

use crate::bench_box::empty;
use particle_solver::{Candidate, ContactEngine, Facet, Forces, Grains, Request, Setup, State};
use space::Vector;

/// Acceleration of gravity.
pub const G: f64 = 9.81;
/// Components of a vector.
pub type V3 = [f64; 3];

/// A ball to place.
#[derive(Clone, Copy)]
pub struct Ball {
    pub position: V3,
    pub velocity: V3,
    pub spin: V3,
    pub radius: f64,
    pub mass: f64,
    /// Never moves.
    pub fixed: bool,
}

/// A ball of unit density at rest.
pub fn ball(position: V3, radius: f64) -> Ball {
    Ball {
        position,
        velocity: [0.0; 3],
        spin: [0.0; 3],
        radius,
        mass: 4.0 / 3.0 * PI * radius.powi(3),
        fixed: false,
    }
}

impl Ball {
    /// Of this velocity.
    pub fn moving(self, velocity: V3) -> Ball {
        Ball { velocity, ..self }
    }
}

/// No walls, no gravity, no friction; full balls.
pub fn nothing() -> Setup<3> {
    let plane = empty();
    Setup {
        gravity: Vector::zeros(),
        walls: Vec::new(),
        period: [None; 3],
        friction: 0.0,
        wall_friction: 0.0,
        inertia_factor: 0.4,
        tolerance: plane.tolerance,
        solver: plane.solver,
        sweeps_max: plane.sweeps_max,
        sub_steps_max: plane.sub_steps_max,
    }
}

/// An engine with these balls.
pub fn engine(setup: Setup<3>, balls: &[Ball]) -> ContactEngine<3> {
    let grains = Grains {
        radius: balls.iter().map(|ball| ball.radius).collect(),
        mass: balls.iter().map(|ball| ball.mass).collect(),
        fixed: balls.iter().map(|ball| ball.fixed).collect(),
    };
    let of = |part: fn(&Ball) -> V3| balls.iter().map(|ball| Vector::from(part(ball))).collect();
    let mut state = State::new(&grains, of(|b| b.position), of(|b| b.velocity)).expect("finite");
    state.spin = of(|b| b.spin);
    ContactEngine::new(setup, grains, state).expect("the setup is valid")
}

/// Advance without fluid and accept; the accepted candidate.
pub fn step(engine: &mut ContactEngine<3>, request: &Request) -> Candidate<3> {
    let candidate = engine.advance(request, &Forces::default());
    let candidate = candidate.unwrap_or_else(|error| panic!("step {}: {error}", request.step));
    let candidate = candidate.clone();
    engine.commit().unwrap();
    candidate
}

/// Triangles of a flat quadrilateral whose corners are seen clockwise by the grains.
pub fn quad([a, b, c, d]: [V3; 4]) -> [Facet<3>; 2] {
    [[a, b, c], [a, c, d]].map(|corners| Facet::at_rest(corners.map(Vector::from)))
}

/// A floor z = 0 from −`half` to `half` along x and y, in n × n squares.
pub fn floor(half: f64, n: usize) -> Vec<Facet<3>> {
    let at = |i: usize, j: usize| {
        let along = |k: usize| half * (2.0 * k as f64 / n as f64 - 1.0);
        [along(i), along(j), 0.0]
    };
    let square = |k: usize| {
        let (i, j) = (k / n, k % n);
        quad([at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)])
    };
    (0..n * n).flat_map(square).collect()
}

/// Floor and four walls around a width × width square, open above.
pub fn open_box(width: f64, height: f64) -> Vec<Facet<3>> {
    let (w, h) = (width, height);
    let sides = [
        [[0.0, 0.0, 0.0], [0.0, w, 0.0], [w, w, 0.0], [w, 0.0, 0.0]],
        [[0.0, 0.0, 0.0], [0.0, 0.0, h], [0.0, w, h], [0.0, w, 0.0]],
        [[w, 0.0, 0.0], [w, w, 0.0], [w, w, h], [w, 0.0, h]],
        [[0.0, 0.0, 0.0], [w, 0.0, 0.0], [w, 0.0, h], [0.0, 0.0, h]],
        [[0.0, w, 0.0], [0.0, w, h], [w, w, h], [w, w, 0.0]],
    ];
    sides.into_iter().flat_map(quad).collect()
}
