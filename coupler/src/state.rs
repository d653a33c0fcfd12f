//! The accepted state of a run, and what an engine answers before it is accepted.
//!
//! Struct of arrays: a value a grain, or a value a node.

use protocol::engine::without;
use serde::{Deserialize, Serialize};
use space::Vector;

use crate::error::CouplerError;

/// How a grain touches others, from free to held.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Contact {
    /// No active contact.
    #[default]
    Free,
    /// An active contact.
    Touches,
    /// Force-connected to a wall or a fixed grain through active contacts.
    Held,
}

/// Grains held by a wall, and other grains with an active contact.
pub fn count_contacts(contact: &[Contact]) -> (usize, usize) {
    let count = |of: Contact| contact.iter().filter(|&&own| own == of).count();
    (count(Contact::Held), count(Contact::Touches))
}

/// The accepted grains.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Grains<const D: usize> {
    /// xⁿ \[m\]
    pub position: Vec<Vector<D>>,
    /// vⁿ \[m/s\]
    pub velocity: Vec<Vector<D>>,
    /// v̄ of the last step \[m/s\]
    pub mean_velocity: Vec<Vector<D>>,
    /// Who touches; where the fluid does not feel the grains it is that of the last state put out.
    pub contact: Vec<Contact>,
    /// ω, flat, of the last state put out; empty where the engine does not tell \[rad/s\]
    pub spin: Vec<f64>,
    /// Mean contact force of the last step \[N\]
    pub contact_force: Vec<Vector<D>>,
    /// What the last step owes the fluid (`coupled/carry.rs`) \[N\]
    pub carried_force: Vec<Vector<D>>,
    /// m \[kg\]
    pub mass: Vec<f64>,
    /// V \[m³\]
    pub volume: Vec<f64>,
    /// Radii \[m\]
    pub radius: Vec<f64>,
    /// Never moves
    pub fixed: Vec<bool>,
    /// Place among the first grains, kept when others leave
    pub id: Vec<u64>,
}

impl<const D: usize> Grains<D> {
    /// Number of grains.
    pub fn count(&self) -> usize {
        self.mass.len()
    }

    /// Has every grain each of its values?
    pub fn is_consistent(&self) -> bool {
        let count = self.count();
        let lengths = [
            self.position.len(),
            self.velocity.len(),
            self.mean_velocity.len(),
            self.contact.len(),
            self.contact_force.len(),
            self.carried_force.len(),
            self.volume.len(),
            self.radius.len(),
            self.fixed.len(),
            self.id.len(),
        ];
        lengths == [count; 10] && self.spin.len().is_multiple_of(count.max(1))
    }

    /// Take these out, by ascending numbers; the others keep their order.
    pub fn remove(&mut self, gone: &[usize]) {
        fn take<T: Clone>(values: &mut Vec<T>, gone: &[usize]) {
            *values = without(values, 1, gone);
        }
        // none of an engine that does not tell
        let components = self.spin.len() / self.count().max(1);
        self.spin = without(&self.spin, components, gone);
        take(&mut self.position, gone);
        take(&mut self.velocity, gone);
        take(&mut self.mean_velocity, gone);
        take(&mut self.contact, gone);
        take(&mut self.contact_force, gone);
        take(&mut self.carried_force, gone);
        take(&mut self.mass, gone);
        take(&mut self.volume, gone);
        take(&mut self.radius, gone);
        take(&mut self.fixed, gone);
        take(&mut self.id, gone);
    }

    /// Accept what the particle engine answered.
    pub fn accept(&mut self, candidate: Candidate<D>) {
        self.position = candidate.position;
        self.velocity = candidate.velocity;
        self.mean_velocity = candidate.mean_velocity;
        if !candidate.contact.is_empty() {
            self.contact = candidate.contact;
        }
        if !candidate.spin.is_empty() {
            self.spin = candidate.spin;
        }
    }
}

/// What has left so far (`exits.rs`, X1).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Removed<const D: usize> {
    /// How many grains.
    pub grains: u64,
    /// Σ V \[m³\] (disks: m²).
    pub volume: f64,
    /// Σ m \[kg\] (disks: kg/m).
    pub mass: f64,
    /// Σ m v \[kg m/s\].
    pub momentum: Vector<D>,
    /// Σ m (½ v² − g·x) \[J\].
    pub energy: f64,
}

impl<const D: usize> Default for Removed<D> {
    fn default() -> Removed<D> {
        Removed {
            grains: 0,
            volume: 0.0,
            mass: 0.0,
            momentum: Vector::zeros(),
            energy: 0.0,
        }
    }
}

impl<const D: usize> Removed<D> {
    /// These grains leave.
    pub fn add(&mut self, grains: &Grains<D>, gone: &[usize], gravity: &Vector<D>) {
        for &grain in gone {
            let mass = grains.mass[grain];
            self.grains += 1;
            self.volume += grains.volume[grain];
            self.mass += mass;
            for axis in 0..D {
                let (speed, place) = (grains.velocity[grain][axis], grains.position[grain][axis]);
                self.momentum[axis] += mass * speed;
                self.energy += mass * (0.5 * speed * speed - gravity[axis] * place);
            }
        }
    }
}

/// Nodal fields of the fluid, as the grains feel them.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Flow<const D: usize> {
    /// w = u/φ \[m/s\]
    pub velocity: Vec<Vector<D>>,
    /// G = ℓ⁻¹∫N ∇p \[Pa/m\]
    pub pressure_gradient: Vec<Vector<D>>,
}

/// The solid's response (`coupled/response.rs`): nodal fields that the fluid receives.
#[derive(Debug, Clone, Default)]
pub struct Response<const D: usize> {
    /// φ
    pub porosity: Vec<f64>,
    /// β \[kg/(m³ s)\]
    pub drag: Vec<f64>,
    /// s \[N/m³\]
    pub drag_source: Vec<Vector<D>>,
    /// c
    pub entrained_fraction: Vec<f64>,
    /// j⁰ \[m/s\]
    pub solid_flux: Vec<Vector<D>>,
    /// κ \[m³ s/kg\]
    pub solid_mobility: Vec<f64>,
    /// β of the fixed grains \[kg/(m³ s)\]
    pub fixed_drag: Vec<f64>,
}

/// What the particle engine answers.
#[derive(Debug, Clone, Default)]
pub struct Candidate<const D: usize> {
    /// x at the end \[m\]
    pub position: Vec<Vector<D>>,
    /// v at the end \[m/s\]
    pub velocity: Vec<Vector<D>>,
    /// v̄ = (xⁿ⁺¹ − xⁿ)/Δt \[m/s\]
    pub mean_velocity: Vec<Vector<D>>,
    /// Who touches; empty where nobody reads it with every candidate
    pub contact: Vec<Contact>,
    /// ω at the end, flat; empty where it is not told with every candidate \[rad/s\]
    pub spin: Vec<f64>,
    /// Sub-steps used
    pub sub_steps: u32,
}

/// All that a step starts from.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct State<const D: usize> {
    /// Accepted steps.
    pub step: u64,
    /// Accepted time \[s\].
    pub time: f64,
    /// Accepted grains; none in a scene without.
    pub grains: Grains<D>,
    /// Accepted nodal fields; no nodes in a scene without fluid.
    pub flow: Flow<D>,
    /// φ of the last accepted step.
    pub porosity: Vec<f64>,
    /// Grains that have left.
    pub removed: Removed<D>,
}

/// An error of this step where a component is not finite.
pub fn require_finite<const D: usize>(
    vectors: &[Vector<D>],
    step: u64,
    what: &str,
) -> Result<(), CouplerError> {
    let broken = |vector: &Vector<D>| !vector.iter().all(|component| component.is_finite());
    match vectors.iter().position(broken) {
        Some(place) => Err(CouplerError::NotFinite {
            step,
            what: format!("{what} (number {place})"),
        }),
        None => Ok(()),
    }
}
