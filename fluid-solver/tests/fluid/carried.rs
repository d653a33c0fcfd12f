//! What a change of mesh does to velocity, momentum and energy: interpolation, as the engine carries over, beside an
//! L2 projection of u and φ, which keeps ∫φ and ∫φv.

use std::f64::consts::PI;

use fluid_solver::boundary::Condition;
use fluid_solver::candidate::Request;
use fluid_solver::config::FluidConfig;
use fluid_solver::diagnostics::Content;
use fluid_solver::mesh::{Bisection, Mesh, Place, Root, Sizes, Zone};
use fluid_solver::refined::{self, Refined, Refinement};
use fluid_solver::solid::SolidFields;
use fluid_solver::state::{Flow, State};
use fluid_solver::step::FluidSolver;
use space::{Vector, dot};

use crate::projection::{Found, at, projected_flow};
use crate::support::{at_nodes, errors, order};

const DENSITY: f64 = 2.0;

/// A square of n × n cells.
fn root(n: usize) -> Root<2> {
    Root {
        lower: [0.0; 2].into(),
        upper: [1.0; 2].into(),
        cells: [n; 2],
        periodic: [false; 2],
    }
}

/// Cells a quarter as large in a disk that goes around the middle, a turn in forty epochs.
fn fine(root: &Root<2>, epoch: usize) -> Refinement<2> {
    let (sine, cosine) = (2.0 * PI * epoch as f64 / 40.0).sin_cos();
    let place = Place::Ball {
        centre: [0.5 + 0.25 * cosine, 0.5 + 0.25 * sine].into(),
        radius: 0.15,
    };
    Refinement {
        zones: vec![Zone {
            place,
            size: 0.25 * root.size(),
        }],
        growth: 0.5,
        largest: None,
    }
}

fn bisect(root: &Root<2>, sizes: &Refinement<2>) -> (Bisection<Root<2>, 2, 3>, Mesh<2, 3>) {
    let zones = sizes.zones.clone();
    let sizes = Sizes::new(zones, sizes.growth, f64::INFINITY, root.period());
    Bisection::new(root, &sizes, 1_000_000).unwrap()
}

/// Porosity of a loose suspension, smooth.
fn porosity(x: &Vector<2>) -> f64 {
    0.7 + 0.2 * (PI * x[0]).sin() * (PI * x[1]).cos()
}

/// A vortex that is at rest at the walls: u = curl sin²πx sin²πy, of speed 1.
fn superficial(x: &Vector<2>) -> Vector<2> {
    let [sx, sy] = [x[0], x[1]].map(|x| (PI * x).sin());
    let [dx, dy] = [x[0], x[1]].map(|x| (2.0 * PI * x).sin());
    [sx * sx * dy, -dx * sy * sy].into()
}

/// A viscous fluid between walls.
fn viscous(convection: bool) -> FluidConfig<2> {
    let mut config = FluidConfig::new(DENSITY, 0.02).with("all", Condition::NoSlip);
    config.convection = convection;
    config
}

fn vortex(mesh: &Mesh<2, 3>, porosity: impl Fn(&Vector<2>) -> f64) -> State<2> {
    let mut state = State::uniform(mesh.node_count(), Vector::zeros());
    state.fresh = false;
    state.now = Flow {
        superficial_velocity: at_nodes(mesh, superficial),
        porosity: at_nodes(mesh, porosity),
    };
    state
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Carry {
    Interpolated,
    Projected,
}

/// A solver whose mesh follows, with either way to carry over.
struct Followed {
    solver: FluidSolver<2, 3>,
    follows: Refined<2, 3>,
    root: Root<2>,
    epoch: usize,
    carry: Carry,
    iterations: usize,
}

impl Followed {
    fn new(config: FluidConfig<2>, root: Root<2>, carry: Carry) -> Followed {
        let (solver, follows) = refined::solver(config, &root, &fine(&root, 0)).unwrap();
        Followed {
            solver,
            follows,
            root,
            epoch: 0,
            carry,
            iterations: 0,
        }
    }

    fn content(&self) -> Content<2> {
        self.solver.state().content(self.solver.mesh(), DENSITY)
    }

    /// The mesh of so many epochs later; what is held before and after.
    fn adapt(&mut self, epochs: usize) -> [Content<2>; 2] {
        let before = self.content();
        let (from, to) = (
            fine(&self.root, self.epoch),
            fine(&self.root, self.epoch + epochs),
        );
        let flow = self.solver.state().now.clone();
        self.follows.adapt(&mut self.solver, &to).unwrap();
        self.epoch += epochs;
        if self.carry == Carry::Projected {
            let mut both = from.clone();
            both.zones.extend(to.zones.clone());
            let (from, to) = (bisect(&self.root, &from), bisect(&self.root, &to));
            let (from, to) = (Found(&from.0, &from.1), Found(&to.0, &to.1));
            let common = bisect(&self.root, &both);
            let common = Found(&common.0, &common.1);
            let (flow, iterations) = projected_flow(&common, &from, &to, &flow);
            self.iterations = self.iterations.max(iterations);
            self.solver.set_state(State {
                now: flow,
                ..self.solver.state().clone()
            });
        }
        [before, self.content()]
    }
}

/// Sums over the epochs of a run.
#[derive(Debug, Default, Clone, Copy)]
struct Sums {
    epochs: f64,
    /// |ΔV|, |ΔM|, |ΔT| of (Z3), each of what was there.
    sizes: [f64; 3],
    /// Σ ΔT over T at the start.
    energy: f64,
}

impl Sums {
    fn add(&mut self, [before, after]: [Content<2>; 2], start: f64) {
        let change = after.kinetic_energy - before.kinetic_energy;
        self.epochs += 1.0;
        self.sizes[0] += (after.volume - before.volume).abs() / before.solid_volume;
        self.sizes[1] += (after.momentum - before.momentum).norm() / before.momentum_size;
        self.sizes[2] += change.abs() / before.kinetic_energy;
        self.energy += change / start;
    }

    /// Means of an epoch.
    fn means(&self) -> [f64; 3] {
        self.sizes.map(|sum| sum / self.epochs)
    }
}

#[test]
fn a_vortex_that_is_carried_through_forty_epochs_keeps_what_its_coarsest_mesh_can_hold() {
    println!(
        "carry          n  error v: start  1 epoch    40 epochs  ΔV         ΔM         ΔT an epoch  Σ ΔT       iterations"
    );
    for carry in [Carry::Interpolated, Carry::Projected] {
        let mut last: Option<[f64; 2]> = None;
        for n in [8, 16, 32] {
            let mut followed = Followed::new(viscous(true), root(n), carry);
            let state = vortex(followed.solver.mesh(), porosity);
            followed.solver.set_state(state);
            let error = |followed: &Followed| {
                let solver = &followed.solver;
                let exact = |x: &Vector<2>| superficial(x) / porosity(x);
                errors(solver.mesh(), solver.state(), exact, |_| 0.0).0
            };
            let start = followed.content().kinetic_energy;
            let (mut of_v, mut sums) = (vec![error(&followed)], Sums::default());
            for _ in 0..40 {
                sums.add(followed.adapt(1), start);
                of_v.push(error(&followed));
            }
            let [volume, momentum, energy] = sums.means();
            println!(
                "{carry:<13?} {n:2}  {:.3e}       {:.3e}  {:.3e}  {volume:.1e}    {momentum:.1e}    {energy:.1e}      {:+.1e}   {}",
                of_v[0], of_v[1], of_v[40], sums.energy, followed.iterations
            );
            if let Some([error, change]) = last {
                let orders = [order(error, of_v[40]), order(change, energy)];
                println!("                  orders of the error and of ΔT: {orders:.2?}");
                assert!(orders.iter().all(|&order| order > 1.8));
            }
            // as on a mesh that never was as fine anywhere: nothing piles up
            assert!(of_v[40] < 2.0 * of_v[1]);
            let kept = momentum < 1e-13 && volume < 1e-13;
            assert_eq!(kept, carry == Carry::Projected);
            last = Some([of_v[40], energy]);
        }
    }
}

#[test]
fn projected_porosity_leaves_its_bounds_at_a_steep_edge_and_interpolated_does_not() {
    let cloud = |x: &Vector<2>| match (x - Vector::from([0.75, 0.5])).norm() < 0.1 {
        true => 0.6,
        false => 1.0,
    };
    println!(
        "carry          smallest φ  largest φ, where the small cells leave a cloud of φ = 0.6"
    );
    for carry in [Carry::Interpolated, Carry::Projected] {
        let mut followed = Followed::new(viscous(true), root(16), carry);
        let state = vortex(followed.solver.mesh(), cloud);
        followed.solver.set_state(state);
        followed.adapt(20);
        let porosity = &followed.solver.state().now.porosity;
        let low = porosity.iter().copied().fold(f64::INFINITY, f64::min);
        let high = porosity.iter().copied().fold(0.0, f64::max);
        println!("{carry:<13?}  {low:.4}      {high:.4}");
        let inside = low >= 0.6 - 1e-12 && high <= 1.0 + 1e-12;
        assert_eq!(inside, carry == Carry::Interpolated);
    }
}

/// A step in fluid of this porosity, and the work of all forces in it \[J/m\].
fn step(solver: &mut FluidSolver<2, 3>, dt: f64, porosity: impl Fn(&Vector<2>) -> f64) -> [f64; 2] {
    let porosity = at_nodes(solver.mesh(), porosity);
    let fields = SolidFields {
        porosity: Some(&porosity),
        ..SolidFields::default()
    };
    let told = [0, 1].map(|pass| {
        let request = Request { step: 1, pass, dt };
        let candidate = solver.advance(&request, &fields).unwrap();
        let powers = candidate.powers;
        let work = powers.gravity + powers.solid + powers.source + powers.boundary;
        let mesh = candidate.number("mesh_energy").unwrap_or(0.0);
        [dt * (work - powers.viscous - powers.stabilisation), mesh]
    });
    // of every pass the same, of a step once
    assert_eq!(told[0][1], told[1][1]);
    solver.commit().unwrap();
    told[1]
}

#[test]
fn a_flow_that_decays_through_epochs_is_that_of_a_mesh_that_stays() {
    const STEPS: usize = 40;
    const DT: f64 = 0.01;
    println!("mesh            n  T/T₀      error v    ΔM         ΔT an epoch  Σ ΔT");
    for n in [8, 16] {
        let cells = root(n);
        let everywhere = Refinement {
            zones: vec![Zone {
                place: Place::Ball {
                    centre: [0.5; 2].into(),
                    radius: 1.0,
                },
                size: 0.25 * cells.size(),
            }],
            ..fine(&cells, 0)
        };
        let (mut reference, _) = refined::solver(viscous(true), &cells, &everywhere).unwrap();
        let state = vortex(reference.mesh(), porosity);
        reference.set_state(state);
        for _ in 0..STEPS {
            step(&mut reference, DT, porosity);
        }
        let exact = reference.state().now.interstitial_velocity();
        let mut found = Vec::new();
        for (name, carry, every) in [
            ("stays", Carry::Interpolated, STEPS),
            ("interpolated", Carry::Interpolated, 2),
            ("projected", Carry::Projected, 2),
        ] {
            let mut followed = Followed::new(viscous(true), cells.clone(), carry);
            let state = vortex(followed.solver.mesh(), porosity);
            followed.solver.set_state(state);
            let start = followed.content().kinetic_energy;
            let mut sums = Sums::default();
            for index in 0..STEPS {
                if index > 0 && index % every == 0 {
                    sums.add(followed.adapt(1), start);
                }
                step(&mut followed.solver, DT, porosity);
            }
            let (bisection, _) = bisect(&cells, &fine(&cells, followed.epoch));
            let spots = bisection.spots_of(&bisect(&cells, &everywhere).0);
            let now = &followed.solver.state().now;
            let square = |(spot, exact): (&_, &Vector<2>)| {
                let v = at(&now.superficial_velocity, spot) / at(&now.porosity, spot);
                dot(&(v - exact), &(v - exact))
            };
            let pairs = spots.iter().zip(&exact);
            let weighted = pairs.map(square).zip(&reference.mesh().nodal_mass);
            let error = weighted
                .map(|(square, mass)| square * mass)
                .sum::<f64>()
                .sqrt();
            let [_, momentum, energy] = match every == STEPS {
                true => [0.0; 3],
                false => sums.means(),
            };
            println!(
                "{name:<13} {n:3}  {:.5}   {error:.2e}   {momentum:.1e}    {energy:.1e}      {:+.1e}",
                followed.content().kinetic_energy / start,
                sums.energy
            );
            found.push(error);
        }
        let [stays, interpolated, projected] = found[..] else {
            unreachable!("three meshes")
        };
        println!(
            "over that of the mesh that stays: {:.2}, {:.2}",
            interpolated / stays,
            projected / stays
        );
        assert!(interpolated < 1.5 * stays);
    }
}

#[test]
fn the_energy_of_a_run_through_epochs_is_accounted_for_with_what_meshes_change() {
    // T_end − T_0 = Σ Δt P − Σ ½ρ∫φ|vⁿ⁺¹ − vⁿ|² + Σ ΔT: of backward Euler without convection, where φ is linear
    // and stays; every step in two passes
    let linear = |x: &Vector<2>| 0.6 + 0.3 * x[0];
    const DT: f64 = 0.01;
    println!(" n  T_0 − T_end  Σ ΔT        left over with it  without  [J/m]");
    for n in [6, 12] {
        let mut followed = Followed::new(viscous(false), root(n), Carry::Interpolated);
        let state = vortex(followed.solver.mesh(), linear);
        followed.solver.set_state(state);
        let start = followed.content().kinetic_energy;
        let (mut work, mut by_meshes, mut of_scheme) = (0.0, 0.0, 0.0);
        for index in 0..30 {
            let mut jump = 0.0;
            if index % 3 == 2 {
                let [before, after] = followed.adapt(1);
                jump = after.kinetic_energy - before.kinetic_energy;
            }
            let before = followed.solver.state().now.clone();
            let [done, told] = step(&mut followed.solver, DT, linear);
            assert_eq!(told, jump, "step {index}");
            let (mesh, now) = (followed.solver.mesh(), &followed.solver.state().now);
            let pairs = now
                .superficial_velocity
                .iter()
                .zip(&before.superficial_velocity);
            let change: Vec<Vector<2>> = pairs.map(|(new, old)| new - old).collect();
            of_scheme += Content::new(mesh, &now.porosity, &change, DENSITY).kinetic_energy;
            (work, by_meshes) = (work + done, by_meshes + told);
        }
        let end = followed.content().kinetic_energy;
        let without = end - start - (work - of_scheme);
        let left = without - by_meshes;
        println!(
            "{n:2}  {:.4e}   {by_meshes:+.2e}   {left:+.1e}           {without:+.1e}",
            start - end
        );
        assert!(left.abs() < 1e-11 * start && without.abs() > 1e-4 * start);
    }
}

#[test]
fn what_a_mesh_has_changed_is_told_until_a_step_is_accepted_and_kept_with_the_state() {
    let mut followed = Followed::new(viscous(true), root(8), Carry::Interpolated);
    let state = vortex(followed.solver.mesh(), porosity);
    followed.solver.set_state(state);
    let [before, after] = followed.adapt(1);
    let change = followed.solver.state().mesh_change.unwrap();
    assert_eq!([change.from, change.to], [before, after]);
    let told = |solver: &mut FluidSolver<2, 3>, dt: f64| {
        let request = Request::first(1, dt);
        let candidate = solver.advance(&request, &SolidFields::default()).unwrap();
        [
            "mesh_volume",
            "mesh_momentum_x",
            "mesh_momentum_y",
            "mesh_energy",
        ]
        .map(|name| candidate.number(name).unwrap())
    };
    let momentum = after.momentum - before.momentum;
    let expected = [
        after.volume - before.volume,
        momentum[0],
        momentum[1],
        after.kinetic_energy - before.kinetic_energy,
    ];
    println!("{expected:?}");
    assert_eq!(told(&mut followed.solver, 0.1), expected);
    // a step that is tried again, by an engine that goes on from what was kept
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("state");
    followed.solver.state().save(&path).unwrap();
    let kept = State::load(&path, followed.solver.mesh().node_count()).unwrap();
    assert_eq!(&kept, followed.solver.state());
    followed.solver.set_state(kept);
    assert_eq!(told(&mut followed.solver, 0.05), expected);
    followed.solver.commit().unwrap();
    assert_eq!(told(&mut followed.solver, 0.05), [0.0; 4]);
}
