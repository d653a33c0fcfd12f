//! Manufactured solutions: the source comes from exact derivatives, so that every term of the
//! equations is exercised. For tests, and for the study of what accuracy costs.

mod jet;

use std::f64::consts::PI;
use std::sync::Arc;

use crate::boundary::Condition;
use crate::config::FluidConfig;
use crate::element::{QUADRATURE, interpolate};
use crate::error::FluidError;
use crate::mesh::Mesh;
use crate::state::{Flow, SolidFields, State};
use crate::step::{FluidSolver, Request};
use jet::Jet;

/// φ, v, p and β as functions of (x, y, t), for ρ and μ.
#[derive(Clone, Copy)]
pub struct Exact {
    /// ρ \[kg/m³\].
    pub density: f64,
    /// μ \[Pa s\].
    pub viscosity: f64,
    fields: fn(Jet, Jet, Jet, f64) -> Fields,
    /// Parameter handed to `fields`.
    amplitude: f64,
    /// Is the time derivative left out?
    pub steady: bool,
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

    /// u = φ v.
    pub fn superficial(&self, x: [f64; 2], t: f64) -> [f64; 2] {
        let fields = self.at(x, t);
        fields.velocity.map(|v| fields.porosity.value * v.value)
    }

    /// Its fluid, its source, and its velocity on every boundary.
    pub fn config(self) -> FluidConfig {
        let mut config = FluidConfig::new(self.density, self.viscosity);
        config.body_force = Some(Arc::new(move |x, t| self.source(x, t)));
        config.with(
            "all",
            Condition::Function(Arc::new(move |x, t| self.superficial(x, t))),
        )
    }

    /// The exact flow at t = 0, the pressure unknown.
    pub fn start(&self, mesh: &Mesh) -> State {
        let now = Flow {
            superficial_velocity: at_nodes(mesh, |x| self.superficial(x, 0.0)),
            porosity: at_nodes(mesh, |x| self.at(x, 0.0).porosity.value),
        };
        State {
            time: 0.0,
            fresh: false,
            now,
            before: None,
            pressure: vec![0.0; mesh.node_count()],
            convected: false,
        }
    }

    /// Advance with the exact solid at the end of the step.
    pub fn step(&self, solver: &mut FluidSolver, dt: f64) -> Result<(), FluidError> {
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
        solver.advance(&Request::first(1, dt), &fields)?;
        solver.commit()?;
        Ok(())
    }

    /// L2 errors of v and p at time t.
    pub fn errors(&self, solver: &FluidSolver, t: f64) -> (f64, f64) {
        let velocity = |x: [f64; 2]| self.at(x, t).velocity.map(|v| v.value);
        errors(solver.mesh(), solver.state(), velocity, |x| {
            self.at(x, t).pressure.value
        })
    }
}

/// The solenoidal field and the three cases of lethe's 2D VANS verification (ν = ρ = 1).
pub fn lethe(case: usize) -> Exact {
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

/// Flow through grains whose porosity changes in time, with β = b (1 + ½ sin πx cos πy).
///
/// φ = 0.6 + 0.2 cos πx cos πy cos ωt;  φ v = curl ψ + ∇χ with χ = ∂_tφ/(2π²), so that
/// ∇·(φv) = −∂_tφ, which the solid flux j⁰ = −∇χ carries.
pub fn suspension(drag: f64, steady: bool) -> Exact {
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

/// L2 errors of v = u_h/φ_h and of p without its mean.
pub fn errors(
    mesh: &Mesh,
    state: &State,
    velocity: impl Fn([f64; 2]) -> [f64; 2],
    pressure: impl Fn([f64; 2]) -> f64,
) -> (f64, f64) {
    let (mut square, mut area, mut mean) = (0.0, 0.0, 0.0);
    let mut pressure_square = 0.0;
    for (t, nodes) in mesh.triangles.iter().enumerate() {
        let porosity = nodes.map(|n| state.now.porosity[n]);
        let u = [0, 1].map(|d| nodes.map(|n| state.now.superficial_velocity[n][d]));
        let p = nodes.map(|n| state.pressure[n]);
        for (shape, weight) in &QUADRATURE {
            let w = weight * mesh.geometry[t].area;
            let x = [0, 1].map(|d| (0..3).map(|k| shape[k] * mesh.corners[t][k][d]).sum());
            let exact = velocity(x);
            for d in 0..2 {
                let v = interpolate(shape, &u[d]) / interpolate(shape, &porosity);
                square += w * (v - exact[d]).powi(2);
            }
            let difference = interpolate(shape, &p) - pressure(x);
            area += w;
            mean += w * difference;
            pressure_square += w * difference * difference;
        }
    }
    (
        square.sqrt(),
        (pressure_square - mean * mean / area).max(0.0).sqrt(),
    )
}

/// Values at the nodes.
pub fn at_nodes<T>(mesh: &Mesh, value: impl Fn([f64; 2]) -> T) -> Vec<T> {
    mesh.position.iter().map(|x| value(*x)).collect()
}
