//! An exact flow: its source, its start, and errors against it.

use std::sync::Arc;

use space::simplex::{combine, interpolate};
use space::vector::from_fn;
use space::{Dim, Dimension, Vector, flat, quadrature};

use super::jet::Jet;
use crate::boundary::condition::Condition;
use crate::candidate::Request;
use crate::config::FluidConfig;
use crate::equations::element::components;
use crate::error::FluidError;
use crate::mesh::simplices::Mesh;
use crate::solid::SolidFields;
use crate::state::{Flow, State};
use crate::step::FluidSolver;

/// φ, v, p and β as functions of (x, t), for ρ and μ.
#[derive(Clone, Copy)]
pub struct Exact<const D: usize, const N: usize> {
    /// ρ \[kg/m³\].
    pub density: f64,
    /// μ \[Pa s\].
    pub viscosity: f64,
    pub(super) fields: fn([Jet<N>; N], f64) -> Fields<D, N>,
    /// Parameter handed to `fields`.
    pub(super) amplitude: f64,
    /// Is the time derivative left out?
    pub steady: bool,
}

/// The fields at a point and a time.
pub(super) struct Fields<const D: usize, const N: usize> {
    pub porosity: Jet<N>,
    pub velocity: [Jet<N>; D],
    pub pressure: Jet<N>,
    pub drag: Jet<N>,
    /// j⁰ with ∇·(φv + j⁰) = 0
    pub solid_flux: Vector<D>,
}

impl<const D: usize, const N: usize> Exact<D, N>
where
    Dim<D>: Dimension<D>,
{
    fn at(&self, x: &Vector<D>, t: f64) -> Fields<D, N> {
        let value = |k: usize| if k < D { x[k] } else { t };
        let variables = std::array::from_fn(|k| Jet::variable(value(k), k));
        (self.fields)(variables, self.amplitude)
    }

    /// ρφ(∂_t v + v·∇v) + φ∇p − ∇·(μφ(∇v + ∇vᵀ)) + βv
    fn source(&self, x: &Vector<D>, t: f64) -> Vector<D> {
        let Fields {
            porosity,
            velocity,
            pressure,
            drag,
            ..
        } = self.at(x, t);
        from_fn(|d| {
            let v = velocity[d];
            let mut rate = if self.steady { 0.0 } else { v.first[D] };
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
    pub fn superficial(&self, x: &Vector<D>, t: f64) -> Vector<D> {
        let fields = self.at(x, t);
        from_fn(|d| fields.porosity.value * fields.velocity[d].value)
    }

    /// Its fluid, its source, and its velocity on every boundary.
    pub fn config(self) -> FluidConfig<D> {
        let mut config = FluidConfig::new(self.density, self.viscosity);
        config.body_force = Some(Arc::new(move |x, t| self.source(&x, t)));
        config.with(
            "all",
            Condition::Function(Arc::new(move |x, t| self.superficial(&x, t))),
        )
    }

    /// The exact flow at t = 0, the pressure unknown.
    pub fn start(&self, mesh: &Mesh<D, N>) -> State<D> {
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
            mesh_change: None,
        }
    }

    /// Advance with the exact solid at the end of the step.
    pub fn step(&self, solver: &mut FluidSolver<D, N>, dt: f64) -> Result<(), FluidError> {
        let time = solver.state().time + dt;
        let at =
            |value: fn(&Fields<D, N>) -> f64| at_nodes(solver.mesh(), |x| value(&self.at(x, time)));
        let porosity = at(|f| f.porosity.value);
        let drag = at(|f| f.drag.value);
        let flux = at_nodes(solver.mesh(), |x| self.at(x, time).solid_flux);
        let fields = SolidFields {
            porosity: Some(&porosity),
            drag: Some(&drag),
            solid_flux: Some(flat::numbers(&flux)),
            ..SolidFields::default()
        };
        solver.advance(&Request::first(1, dt), &fields)?;
        solver.commit()?;
        Ok(())
    }

    /// L2 errors of v and p at time t.
    pub fn errors(&self, solver: &FluidSolver<D, N>, t: f64) -> (f64, f64) {
        let velocity = |x: &Vector<D>| self.at(x, t).velocity.map(|v| v.value).into();
        errors(solver.mesh(), solver.state(), velocity, |x| {
            self.at(x, t).pressure.value
        })
    }
}

/// L2 errors of v = u_h/φ_h and of p without its mean.
pub fn errors<const D: usize, const N: usize>(
    mesh: &Mesh<D, N>,
    state: &State<D>,
    velocity: impl Fn(&Vector<D>) -> Vector<D>,
    pressure: impl Fn(&Vector<D>) -> f64,
) -> (f64, f64) {
    let (mut square, mut volume, mut mean) = (0.0, 0.0, 0.0);
    let mut pressure_square = 0.0;
    for (t, nodes) in mesh.simplices.iter().enumerate() {
        let porosity = nodes.map(|n| state.now.porosity[n]);
        let u = components(nodes, &state.now.superficial_velocity);
        let p = nodes.map(|n| state.pressure[n]);
        for (shape, weight) in quadrature::points::<N>() {
            let w = weight * mesh.geometry[t].volume;
            let x = combine(&shape, &mesh.corners[t]);
            let exact = velocity(&x);
            for d in 0..D {
                let v = interpolate(&shape, &u[d]) / interpolate(&shape, &porosity);
                square += w * (v - exact[d]).powi(2);
            }
            let difference = interpolate(&shape, &p) - pressure(&x);
            volume += w;
            mean += w * difference;
            pressure_square += w * difference * difference;
        }
    }
    (
        square.sqrt(),
        (pressure_square - mean * mean / volume).max(0.0).sqrt(),
    )
}

/// Values at the nodes.
pub fn at_nodes<T, const D: usize, const N: usize>(
    mesh: &Mesh<D, N>,
    value: impl Fn(&Vector<D>) -> T,
) -> Vec<T> {
    mesh.position.iter().map(value).collect()
}
