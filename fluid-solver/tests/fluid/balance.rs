//! Balances that hold to round-off: rest, translation, energy, and what a candidate may touch.

use fluid_solver::boundary::Condition;
use fluid_solver::candidate::Request;
use fluid_solver::config::{FluidConfig, TimeScheme};
use fluid_solver::equations::ViscousForm;
use fluid_solver::mesh::Mesh;
use fluid_solver::mesh::{Diagonals, Rectangle};
use fluid_solver::solid::SolidFields;
use fluid_solver::state::{Flow, State};
use fluid_solver::step::FluidSolver;
use space::Vector;
use space::vector::from_fn;

use crate::support::{Random, deposit, largest_difference};

/// The nodal fields of a random solid, with drag up to `drag`.
pub struct RandomSolid {
    porosity: Vec<f64>,
    drag: Vec<f64>,
    source: Vec<f64>,
    entrained: Vec<f64>,
    flux: Vec<f64>,
    mobility: Vec<f64>,
    fixed: Vec<f64>,
}

impl RandomSolid {
    pub fn new(mesh: &Mesh<2, 3>, drag: f64, seed: u64) -> RandomSolid {
        let n = mesh.node_count();
        let mut random = Random(seed);
        let mut many = |count: usize, low: f64, high: f64| -> Vec<f64> {
            (0..count).map(|_| random.between(low, high)).collect()
        };
        let porosity = many(n, 0.2, 1.0);
        let fraction = many(n, 0.0, 1.0);
        let entrained = porosity
            .iter()
            .zip(&fraction)
            .map(|(p, f)| (1.0 - p) * f)
            .collect();
        let drags = many(n, 0.0, drag);
        let fixed = fraction.iter().zip(&drags).map(|(f, b)| f * b).collect();
        RandomSolid {
            porosity,
            source: many(2 * n, -drag, drag),
            entrained,
            flux: many(2 * n, -1e-2, 1e-2),
            mobility: many(n, 0.0, 1e-4),
            fixed,
            drag: drags,
        }
    }

    pub fn fields(&self) -> SolidFields<'_> {
        SolidFields {
            porosity: Some(&self.porosity),
            drag: Some(&self.drag),
            drag_source: Some(&self.source),
            entrained_fraction: Some(&self.entrained),
            solid_flux: Some(&self.flux),
            solid_mobility: Some(&self.mobility),
            fixed_drag: Some(&self.fixed),
        }
    }
}

#[test]
fn fluid_rests_under_oblique_gravity_whatever_the_porosity() {
    let gravity = [1.3, -9.81];
    let height = 1.0;
    println!("top       scheme         beta    dt     largest v  pressure error/(rho g H)");
    for open in [false, true] {
        for (scheme, drag, dt) in [
            (TimeScheme::BackwardEuler, 0.0, 1e-3),
            (TimeScheme::BackwardEuler, 1e3, 1e-3),
            (TimeScheme::BackwardEuler, 1e8, 1e-3),
            (TimeScheme::Bdf2, 1e8, 1.0),
            (TimeScheme::Steady, 0.0, 1.0),
        ] {
            let mut rectangle = Rectangle::new([0.0; 2], [1.0, height], [24; 2]);
            rectangle.grading = [3.0, 1.0].into();
            let mesh = rectangle.mesh().unwrap();
            let solid = RandomSolid::new(&mesh, drag, 7);
            let mut config = FluidConfig::new(1000.0, 0.12).with("all", Condition::NoSlip);
            if open {
                config = config.with("top", Condition::Open(0.0));
            }
            config.gravity = gravity.into();
            config.time_scheme = scheme;
            let mut solver = FluidSolver::new(config, mesh).unwrap();
            let fields = SolidFields {
                porosity: Some(&solid.porosity),
                drag: Some(&solid.drag),
                ..SolidFields::default()
            };
            for _ in 0..3 {
                solver.advance(&Request::first(1, dt), &fields).unwrap();
                solver.commit().unwrap();
            }
            let state = solver.state();
            let v = largest_difference(&state.now.interstitial_velocity(), |_| Vector::zeros());
            let exact = |n: usize| {
                let x = solver.mesh().position[n];
                1000.0 * (gravity[0] * x[0] + gravity[1] * x[1])
            };
            let reference = exact(0) - state.pressure[0];
            let nodes = 0..solver.mesh().node_count();
            let p = nodes
                .map(|n| (state.pressure[n] - exact(n) + reference).abs())
                .fold(0.0, f64::max);
            let relative = p / (1000.0 * 9.81 * height);
            println!(
                "{:9} {scheme:?} {drag:.0e} {dt:.0e}  {v:.1e}  {relative:.1e}",
                if open { "open" } else { "closed" }
            );
            assert!(v <= 1e-10 && relative <= 1e-10);
        }
    }
}

#[test]
fn packing_and_fluid_translate_together_through_the_mesh() {
    let uniform = [1.0, 0.5];
    let cells = 16;
    println!("grains/cell  response  phi min  largest |v-U|  pressure spread");
    for per_cell in [1, 9, 64] {
        for response in [0.0, 0.5, 0.999] {
            let mut rectangle = Rectangle::new([0.0; 2], [1.0; 2], [cells; 2]);
            rectangle.periodic = [true; 2];
            let config = FluidConfig::new(1.0, 1e-2).with("all", Condition::Periodic);
            let mut solver = FluidSolver::new(config, rectangle.mesh().unwrap()).unwrap();
            let count = per_cell * cells * cells;
            // One grain a cell at solid fraction 0.5 would leave nodes with φ < 0.
            let fraction = if per_cell == 1 { 0.1 } else { 0.4 };
            let volume = fraction / count as f64;
            let mut random = Random(3);
            let mut grains: Vec<Vector<2>> = (0..count)
                .map(|_| [random.unit(), random.unit()].into())
                .collect();
            let dt = 0.2 / cells as f64;
            let gamma = 1e4 * volume;
            let mut porosity_min = f64::INFINITY;
            for step in 0..3 {
                for x in &mut grains {
                    *x = from_fn(|d| (x[d] + dt * uniform[d]).rem_euclid(1.0));
                }
                let mesh = solver.mesh();
                let solid = deposit(mesh, &grains, |_| volume);
                let scaled = |factor: f64| -> Vec<f64> {
                    solid.iter().map(|s| s / volume * factor).collect()
                };
                let moving = |field: &[f64]| -> Vec<f64> {
                    field.iter().flat_map(|b| uniform.map(|u| b * u)).collect()
                };
                let porosity: Vec<f64> = solid.iter().map(|s| 1.0 - s).collect();
                let drag = scaled(gamma * (1.0 - response));
                let entrained = scaled(volume * response);
                let (source, flux) = (moving(&drag), moving(&scaled(volume * (1.0 - response))));
                let mobility = scaled(volume * volume * response / gamma);
                porosity_min = porosity.iter().copied().fold(porosity_min, f64::min);
                if step == 0 {
                    let velocity = porosity
                        .iter()
                        .map(|p| Vector::from(uniform.map(|u| p * u)))
                        .collect();
                    let now = Flow {
                        superficial_velocity: velocity,
                        porosity: porosity.clone(),
                    };
                    let pressure = vec![0.0; porosity.len()];
                    solver.set_state(State {
                        time: 0.0,
                        fresh: false,
                        now,
                        before: None,
                        pressure,
                        convected: false,
                        mesh_change: None,
                    });
                }
                let fields = SolidFields {
                    porosity: Some(&porosity),
                    drag: Some(&drag),
                    drag_source: Some(&source),
                    entrained_fraction: Some(&entrained),
                    solid_flux: Some(&flux),
                    solid_mobility: Some(&mobility),
                    fixed_drag: Some(&drag),
                };
                solver.advance(&Request::first(1, dt), &fields).unwrap();
                solver.commit().unwrap();
            }
            let v = solver.state().now.interstitial_velocity();
            let difference = largest_difference(&v, |_| uniform.into());
            let pressure = solver
                .state()
                .pressure
                .iter()
                .map(|p| p.abs())
                .fold(0.0, f64::max);
            println!(
                "{per_cell:11}  {response:8}  {porosity_min:.3}  {difference:.1e}  {pressure:.1e}"
            );
            assert!(difference <= 1e-10);
        }
    }
}

/// A rectangle turned by an angle, so that no wall follows an axis.
fn turned(cells: [usize; 2], angle: f64) -> Mesh<2, 3> {
    let flat = Rectangle::new([0.0; 2], [2.0, 1.0], cells).mesh().unwrap();
    let (s, c) = angle.sin_cos();
    let position = flat
        .position
        .iter()
        .map(|x| Vector::from([c * x[0] - s * x[1], s * x[0] + c * x[1]]))
        .collect();
    let named: Vec<_> = flat
        .facets
        .iter()
        .map(|facet| (facet.node, facet.boundary))
        .collect();
    Mesh::new(position, flat.simplices, flat.boundary_names, &named, |t| t).unwrap()
}

#[test]
fn plug_flow_between_oblique_slip_walls_is_exact() {
    let angle: f64 = 0.4;
    let along = [angle.cos(), angle.sin()];
    let mut config = FluidConfig::new(1.0, 0.1)
        .with("all", Condition::Slip)
        .with("left", Condition::uniform(along))
        .with("right", Condition::Open(0.0));
    config.initial_velocity = (along).into();
    let mut solver = FluidSolver::new(config, turned([12, 6], angle)).unwrap();
    let candidate = solver
        .advance(&Request::first(1, 0.1), &SolidFields::default())
        .unwrap();
    let difference = largest_difference(&candidate.interstitial_velocity, |_| along.into());
    println!("largest |v - U| {difference:.1e}");
    assert!(difference <= 1e-12);
}

#[test]
fn energy_identity_closes_to_round_off() {
    let angle: f64 = 0.3;
    let closed = FluidConfig::new(1000.0, 0.1)
        .with("all", Condition::NoSlip)
        .with(
            "top",
            Condition::uniform([0.3 * angle.cos(), 0.3 * angle.sin()]),
        );
    let channel = FluidConfig::new(1000.0, 0.1)
        .with("all", Condition::Slip)
        .with("left", Condition::Parabolic([0.2, 0.1].into()))
        .with("right", Condition::Open(50.0));
    let mut literal = channel.clone();
    literal.viscous_form = ViscousForm::PaperLiteral;
    let mut bdf2 = closed.clone();
    bdf2.time_scheme = TimeScheme::Bdf2;
    println!("case          defect    of the terms  viscous    stabilisation");
    for (name, mut config) in [
        ("closed", closed),
        ("channel", channel),
        ("literal", literal),
        ("BDF2", bdf2),
    ] {
        config.gravity = [0.5, -9.81].into();
        let mesh = turned([14, 9], angle);
        let solid = RandomSolid::new(&mesh, 1e4, 11);
        let mut solver = FluidSolver::new(config, mesh).unwrap();
        for step in 1..=3 {
            let powers = solver
                .advance(&Request::first(1, 0.01 * f64::from(step)), &solid.fields())
                .unwrap()
                .powers;
            let relative = powers.defect().abs() / powers.scale();
            println!(
                "{name:9} {step}  {:+.1e}  {relative:.1e}  {:.3e}  {:.3e}",
                powers.defect(),
                powers.viscous,
                powers.stabilisation
            );
            assert!(relative <= 1e-11);
            assert!(name == "literal" || powers.viscous >= 0.0);
            solver.commit().unwrap();
        }
    }
}

#[test]
fn another_pass_reuses_the_factor_and_leaves_the_accepted_state_alone() {
    let mut rectangle = Rectangle::new([0.0; 2], [1.0; 2], [12; 2]);
    rectangle.diagonals = Diagonals::Uniform;
    let mesh = rectangle.mesh().unwrap();
    let mut solid = RandomSolid::new(&mesh, 1e3, 5);
    let mut config = FluidConfig::new(1000.0, 0.1).with("all", Condition::NoSlip);
    config.gravity = [0.0, -9.81].into();
    let mut solver = FluidSolver::new(config, mesh).unwrap();
    solver
        .advance(&Request::first(1, 0.01), &solid.fields())
        .unwrap();
    solver.commit().unwrap();
    let accepted = solver.state().clone();

    let first = solver
        .advance(&Request::first(1, 0.01), &solid.fields())
        .unwrap()
        .clone();
    let again = solver
        .advance(&Request::first(1, 0.01), &solid.fields())
        .unwrap()
        .clone();
    assert_eq!(first.state, again.state);
    assert_eq!(
        (first.number("factorised"), again.number("factorised")),
        (Some(1.0), Some(0.0))
    );
    solid.source.iter_mut().for_each(|s| *s *= 1.5);
    let moved = solver
        .advance(&Request::first(1, 0.01), &solid.fields())
        .unwrap()
        .clone();
    assert_eq!(moved.number("factorised"), Some(0.0));
    assert_ne!(moved.state, first.state);
    let shorter = solver
        .advance(&Request::first(1, 0.005), &solid.fields())
        .unwrap()
        .clone();
    assert_eq!(shorter.number("factorised"), Some(1.0));
    assert_eq!(*solver.state(), accepted);
    // A pass with a reused factor has the bits of one computed afresh.
    solver
        .advance(&Request::first(1, 0.01), &solid.fields())
        .unwrap();
    let fresh = solver
        .advance(&Request::first(1, 0.01), &solid.fields())
        .unwrap();
    assert_eq!(fresh.state, moved.state);
}

#[test]
fn linear_solves_stay_accurate_at_any_contrast_of_drag() {
    println!("density  viscosity  dt     largest backward error  factors that were not enough");
    for (density, viscosity) in [(1.0, 1e-5), (1000.0, 1e-3), (1200.0, 0.12), (1.0, 10.0)] {
        for dt in [1e-6, 1e-3, 1.0, 1e3] {
            let mesh = Rectangle::new([0.0; 2], [0.1, 0.2], [16, 32])
                .mesh()
                .unwrap();
            let mut solid = RandomSolid::new(&mesh, 1.0, 17);
            // Drag from 1e-3 to 1e12 from one node to the next, none at a third of them.
            let mut random = Random(18);
            for (k, drag) in solid.drag.iter_mut().enumerate() {
                *drag = if k % 3 == 0 {
                    0.0
                } else {
                    10f64.powf(random.between(-3.0, 12.0))
                };
            }
            let mut config = FluidConfig::new(density, viscosity).with("all", Condition::NoSlip);
            config.gravity = [0.0, -9.81].into();
            let mut solver = FluidSolver::new(config, mesh).unwrap();
            let (mut worst, mut fallbacks): (f64, f64) = (0.0, 0.0);
            for _ in 0..3 {
                let candidate = solver
                    .advance(&Request::first(1, dt), &solid.fields())
                    .unwrap();
                worst = worst.max(candidate.number("linear_residual").unwrap());
                fallbacks += candidate.number("factor_fallbacks").unwrap();
                solver.commit().unwrap();
            }
            println!("{density:7}  {viscosity:9}  {dt:.0e}  {worst:.1e}  {fallbacks}");
            assert!(worst < 1e-10);
        }
    }
}

#[test]
fn threads_do_not_change_a_bit() {
    let step = |threads: usize| {
        let mesh = Rectangle::new([0.0; 2], [1.0, 2.0], [20, 40])
            .mesh()
            .unwrap();
        let solid = RandomSolid::new(&mesh, 1e5, 21);
        let mut config = FluidConfig::new(1000.0, 0.1).with("all", Condition::NoSlip);
        config.gravity = [0.0, -9.81].into();
        config.threads = threads;
        let mut solver = FluidSolver::new(config, mesh).unwrap();
        let candidate = solver
            .advance(&Request::first(1, 0.01), &solid.fields())
            .unwrap();
        (
            candidate.state.clone(),
            candidate.powers.viscous,
            candidate.powers.boundary,
        )
    };
    let alone = step(1);
    assert!((2..=4).all(|threads| step(threads) == alone));
}

#[test]
fn a_checkpoint_brings_back_the_same_bits() {
    let mesh = Rectangle::new([0.0; 2], [1.0; 2], [10; 2]).mesh().unwrap();
    let solid = RandomSolid::new(&mesh, 1e3, 9);
    let mut config = FluidConfig::new(1000.0, 0.1).with("all", Condition::NoSlip);
    config.gravity = [0.0, -9.81].into();
    config.time_scheme = TimeScheme::Bdf2;
    let mut solver = FluidSolver::new(config.clone(), mesh.clone()).unwrap();
    let step = |solver: &mut FluidSolver<2, 3>| {
        solver
            .advance(&Request::first(1, 0.01), &solid.fields())
            .unwrap();
        solver.commit().unwrap();
    };
    step(&mut solver);
    step(&mut solver);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("fluid.state");
    solver.state().save(&path).unwrap();
    step(&mut solver);
    let mut other = FluidSolver::new(config, mesh).unwrap();
    other.set_state(State::load(&path, other.mesh().node_count()).unwrap());
    step(&mut other);
    assert_eq!(solver.state(), other.state());
}
