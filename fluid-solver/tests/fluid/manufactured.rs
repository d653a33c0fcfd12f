//! Manufactured solutions: the source comes from exact derivatives, so that every term of the
//! equations is exercised.

use std::f64::consts::PI;
use std::sync::Arc;

use fluid_solver::boundary::Condition;
use fluid_solver::config::{FluidConfig, Nonlinear, TimeScheme};
use fluid_solver::rectangle::Rectangle;
use fluid_solver::state::{Flow, SolidFields, State};
use fluid_solver::step::FluidSolver;

use crate::jet::Jet;
use crate::support::{at_nodes, errors, order};

/// φ, v, p and β as functions of (x, y, t), for ρ and μ.
#[derive(Clone, Copy)]
struct Exact {
    density: f64,
    viscosity: f64,
    fields: fn(Jet, Jet, Jet, f64) -> Fields,
    /// Parameter handed to `fields`.
    amplitude: f64,
    steady: bool,
}

struct Fields {
    porosity: Jet,
    velocity: [Jet; 2],
    pressure: Jet,
    drag: Jet,
    /// j⁰ with ∇·(φv + j⁰) = 0
    solid_flux: [f64; 2],
}

impl Exact {
    fn at(&self, x: [f64; 2], t: f64) -> Fields {
        let jets = [
            Jet::variable(x[0], 0),
            Jet::variable(x[1], 1),
            Jet::variable(t, 2),
        ];
        (self.fields)(jets[0], jets[1], jets[2], self.amplitude)
    }

    /// ρφ(∂_t v + v·∇v) + φ∇p − ∇·(μφ(∇v + ∇vᵀ)) + βv
    fn source(&self, x: [f64; 2], t: f64) -> [f64; 2] {
        let Fields {
            porosity,
            velocity,
            pressure,
            drag,
            ..
        } = self.at(x, t);
        [0, 1].map(|d| {
            let v = velocity[d];
            let mut rate = if self.steady { 0.0 } else { v.first[2] };
            let mut stress = 0.0;
            for (f, w) in velocity.iter().enumerate() {
                rate += w.value * v.first[f];
                let strain = v.first[f] + w.first[d];
                let bend = v.second[f][f] + w.second[d][f];
                stress += self.viscosity * (porosity.first[f] * strain + porosity.value * bend);
            }
            let inertia = self.density * porosity.value * rate;
            inertia + porosity.value * pressure.first[d] - stress + drag.value * v.value
        })
    }

    fn superficial(&self, x: [f64; 2], t: f64) -> [f64; 2] {
        let fields = self.at(x, t);
        fields.velocity.map(|v| fields.porosity.value * v.value)
    }

    fn config(self) -> FluidConfig {
        let mut config = FluidConfig::new(self.density, self.viscosity);
        config.body_force = Some(Arc::new(move |x, t| self.source(x, t)));
        config.with(
            "all",
            Condition::Function(Arc::new(move |x, t| self.superficial(x, t))),
        )
    }

    /// Advance with the exact solid at the end of the step.
    fn step(&self, solver: &mut FluidSolver, dt: f64) {
        let time = solver.state().time + dt;
        let at = |value: fn(&Fields) -> f64| at_nodes(solver.mesh(), |x| value(&self.at(x, time)));
        let porosity = at(|f| f.porosity.value);
        let drag = at(|f| f.drag.value);
        let flux = at_nodes(solver.mesh(), |x| self.at(x, time).solid_flux);
        let fields = SolidFields {
            porosity: Some(&porosity),
            drag: Some(&drag),
            solid_flux: Some(flux.as_flattened()),
            ..SolidFields::default()
        };
        solver.advance(dt, &fields).unwrap();
        solver.commit().unwrap();
    }

    fn errors(&self, solver: &FluidSolver, t: f64) -> (f64, f64) {
        let velocity = |x: [f64; 2]| self.at(x, t).velocity.map(|v| v.value);
        errors(solver.mesh(), solver.state(), velocity, |x| {
            self.at(x, t).pressure.value
        })
    }
}

/// The solenoidal field and the three cases of lethe's 2D VANS verification (ν = ρ = 1).
fn lethe(case: usize) -> Exact {
    fn swirl(x: Jet, y: Jet, amplitude: f64) -> [Jet; 2] {
        let (sx, sy, cx, cy) = (
            (x * PI).sin(),
            (y * PI).sin(),
            (x * PI).cos(),
            (y * PI).cos(),
        );
        [
            sx * sx * cy * sy * amplitude,
            cx * sx * sy * sy * -amplitude,
        ]
    }
    fn bump(x: Jet, y: Jet) -> Jet {
        (x * PI).sin() * (y * PI).sin()
    }
    let fields = [
        |x: Jet, y: Jet, _: Jet, _: f64| Fields {
            porosity: Jet::constant(0.5),
            velocity: swirl(x, y, 1.0),
            pressure: bump(x, y) * 0.5 + 0.5,
            drag: Jet::constant(0.0),
            solid_flux: [0.0; 2],
        },
        |x: Jet, y: Jet, _: Jet, _: f64| Fields {
            porosity: bump(x, y) * 0.25 + 0.5,
            velocity: swirl(x, y, -2.0),
            pressure: bump(x, y),
            drag: Jet::constant(0.0),
            solid_flux: [0.0; 2],
        },
        |x: Jet, y: Jet, _: Jet, _: f64| Fields {
            porosity: (bump(x, y) * -1.0 + -1.0).exp(),
            velocity: [(bump(x, y) + -1.0).exp(); 2],
            pressure: bump(x, y) * 0.5 + 0.5,
            drag: Jet::constant(0.0),
            solid_flux: [0.0; 2],
        },
    ][case];
    Exact {
        density: 1.0,
        viscosity: 1.0,
        fields,
        amplitude: 0.0,
        steady: true,
    }
}

const NEWTON: Nonlinear = Nonlinear::Newton {
    tolerance: 1e-11,
    iterations_max: 20,
};

#[test]
fn velocity_is_within_twice_lethe_q1_with_orders_two_and_one_and_a_half() {
    // L2 velocity errors printed by lethe's lethe-fluid-vans tests case0_vans_A … case2_vans_A.
    let published = [
        [3.790e-2, 1.010e-2, 2.595e-3],
        [7.471e-2, 1.992e-2, 5.120e-3],
        [4.581e-2, 1.205e-2, 3.052e-3],
    ];
    println!("case   n   error v     lethe   ratio  error p   order v  order p");
    for (case, published) in published.iter().enumerate() {
        let exact = lethe(case);
        let mut last: Option<(f64, f64)> = None;
        for (n, reference) in [16, 32, 64].into_iter().zip(published) {
            let mesh = Rectangle::new([-1.0; 2], [1.0; 2], [n; 2]).mesh().unwrap();
            let mut config = exact.config();
            config.time_scheme = TimeScheme::Steady;
            config.nonlinear = NEWTON;
            let mut solver = FluidSolver::new(config, mesh).unwrap();
            exact.step(&mut solver, 1.0);
            let (ev, ep) = exact.errors(&solver, 1.0);
            let orders = last.map(|(v, p)| (order(v, ev), order(p, ep)));
            let ratio = ev / reference;
            println!(
                "{case:4} {n:3}  {ev:.3e} {reference:.3e}  {ratio:.2}  {ep:.3e}  {orders:.2?}"
            );
            assert!(ratio <= 2.0);
            if n == 64 {
                let (v, p) = orders.unwrap();
                assert!(v >= 1.9 && p >= 1.5, "orders {v} {p}");
            }
            last = Some((ev, ep));
        }
    }
}

/// Flow through grains whose porosity changes in time, with β = b (1 + ½ sin πx cos πy).
///
/// φ = 0.6 + 0.2 cos πx cos πy cos ωt;  φ v = curl ψ + ∇χ with χ = ∂_tφ/(2π²), so that
/// ∇·(φv) = −∂_tφ, which the solid flux j⁰ = −∇χ carries.
fn suspension(drag: f64, steady: bool) -> Exact {
    fn fields(x: Jet, y: Jet, t: Jet, drag: f64) -> Fields {
        let w = 2.0 * PI;
        let ((sx, cx), (sy, cy)) = (
            ((x * PI).sin(), (x * PI).cos()),
            ((y * PI).sin(), (y * PI).cos()),
        );
        let (sine, cosine) = ((t * w).sin(), (t * w).cos());
        let porosity = cx * cy * cosine * 0.2 + 0.6;
        let pulse = sine * 0.5 + 1.0;
        // χ = −a cos πx cos πy sin ωt
        let a = 0.2 * w / (2.0 * PI * PI);
        let chi = [sx * cy * sine * (a * PI), cx * sy * sine * (a * PI)];
        let psi = [
            sx * cx * sy * sy * pulse * 2.0,
            sx * sx * sy * cy * pulse * 2.0,
        ];
        let flux = [psi[1] + chi[0], chi[1] - psi[0]];
        Fields {
            porosity,
            velocity: flux.map(|u| u * porosity.recip()),
            pressure: cx * sy * (cosine * 0.5 + 1.0),
            drag: (sx * cy * 0.5 + 1.0) * drag,
            solid_flux: chi.map(|u| -u.value),
        }
    }
    Exact {
        density: 1.0,
        viscosity: 0.1,
        fields,
        amplitude: drag,
        steady,
    }
}

#[test]
fn velocity_order_two_does_not_depend_on_the_drag() {
    println!("beta     n   error v    error p    order v  order p");
    for drag in [1e-3, 1.0, 1e3, 1e6, 1e9, 1e12] {
        let exact = suspension(drag, true);
        let mut last: Option<(f64, f64)> = None;
        for n in [16, 32, 64] {
            let mesh = Rectangle::new([0.0; 2], [1.0; 2], [n; 2]).mesh().unwrap();
            let mut config = exact.config();
            config.time_scheme = TimeScheme::Steady;
            config.nonlinear = NEWTON;
            let mut solver = FluidSolver::new(config, mesh).unwrap();
            exact.step(&mut solver, 0.3);
            let (ev, ep) = exact.errors(&solver, 0.3);
            let orders = last.map(|(v, p)| (order(v, ev), order(p, ep)));
            println!("{drag:6.0e} {n:3}  {ev:.3e}  {ep:.3e}  {orders:.2?}");
            if n == 64 {
                assert!(orders.unwrap().0 >= 1.9 && ev < 5e-3);
            }
            last = Some((ev, ep));
        }
    }
}

/// Nodal v at t = 0.5 with step `dt`, from exact data at t = 0.
fn end_velocity(scheme: TimeScheme, dt: f64) -> Vec<[f64; 2]> {
    // τ depends on Δt, so the error in space does too; where 12μ/h² ≫ ρ/Δt that is negligible.
    let exact = Exact {
        viscosity: 1.0,
        ..suspension(10.0, false)
    };
    let mesh = Rectangle::new([0.0; 2], [1.0; 2], [32; 2]).mesh().unwrap();
    let mut config = exact.config();
    config.time_scheme = scheme;
    let porosity = at_nodes(&mesh, |x| exact.at(x, 0.0).porosity.value);
    let superficial_velocity = at_nodes(&mesh, |x| exact.superficial(x, 0.0));
    let pressure = vec![0.0; mesh.node_count()];
    let now = Flow {
        superficial_velocity,
        porosity,
    };
    let mut solver = FluidSolver::new(config, mesh).unwrap();
    solver.set_state(State {
        time: 0.0,
        fresh: false,
        now,
        before: None,
        pressure,
        convected: false,
    });
    for _ in 0..(0.5 / dt).round() as usize {
        exact.step(&mut solver, dt);
    }
    solver.state().now.interstitial_velocity()
}

#[test]
fn backward_euler_is_first_and_bdf2_second_order_in_time() {
    // Against a fine step of BDF2 on the same mesh: the error in space is the same and cancels.
    let reference = end_velocity(TimeScheme::Bdf2, 0.5 / 256.0);
    println!("scheme         dt        error     order");
    for (scheme, bound) in [(TimeScheme::BackwardEuler, 0.95), (TimeScheme::Bdf2, 1.9)] {
        let mut last: Option<f64> = None;
        for steps in [8, 16, 32] {
            let dt = 0.5 / f64::from(steps);
            let v = end_velocity(scheme, dt);
            let square: f64 = v
                .iter()
                .zip(&reference)
                .flat_map(|(a, b)| [0, 1].map(|d| (a[d] - b[d]).powi(2)))
                .sum();
            let error = (square / v.len() as f64).sqrt();
            let observed = last.map(|coarse| order(coarse, error));
            println!("{scheme:?} {dt:.5}  {error:.3e}  {observed:.2?}");
            if steps == 32 {
                assert!(observed.unwrap() >= bound);
            }
            last = Some(error);
        }
    }
}
