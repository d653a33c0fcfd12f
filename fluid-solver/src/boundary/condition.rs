//! Conditions by the name of their boundary.

use std::collections::BTreeMap;
use std::sync::Arc;

use space::Vector;

use crate::error::FluidError;

/// A velocity that depends on position and time \[m/s\].
pub type VelocityFunction<const D: usize> = dyn Fn(Vector<D>, f64) -> Vector<D> + Send + Sync;

/// A condition on one boundary. Velocities are superficial.
#[derive(Clone)]
pub enum Condition<const D: usize> {
    /// u = 0.
    NoSlip,
    /// u·n = 0, no tangential traction.
    Slip,
    /// Joined with the opposite side of a rectangle.
    Periodic,
    /// The same velocity everywhere \[m/s\].
    Uniform(Vector<D>),
    /// Zero at both ends, this velocity in the middle \[m/s\].
    Parabolic(Vector<D>),
    /// Any velocity.
    Function(Arc<VelocityFunction<D>>),
    /// Pressure at the highest point \[Pa\], hydrostatic along the boundary.
    Open(f64),
    /// A wall that moves along itself at this velocity \[m/s\].
    MovingWall(Vector<D>),
}

impl<const D: usize> Condition<D> {
    /// The same velocity everywhere \[m/s\].
    pub fn uniform(velocity: [f64; D]) -> Condition<D> {
        Condition::Uniform(velocity.into())
    }

    /// Is the velocity given, and not zero?
    pub fn carries_fluid(&self) -> bool {
        match self {
            Condition::Uniform(_) | Condition::Parabolic(_) | Condition::Function(_) => true,
            Condition::NoSlip
            | Condition::Slip
            | Condition::Periodic
            | Condition::Open(_)
            | Condition::MovingWall(_) => false,
        }
    }

    /// Is it a wall, which the fluid presses and shears?
    pub fn is_wall(&self) -> bool {
        match self {
            Condition::NoSlip | Condition::Slip | Condition::MovingWall(_) => true,
            Condition::Periodic
            | Condition::Uniform(_)
            | Condition::Parabolic(_)
            | Condition::Function(_)
            | Condition::Open(_) => false,
        }
    }

    /// The velocity where it is given, before a profile's factor \[m/s\].
    pub fn velocity(&self, at: &Vector<D>, time: f64) -> Vector<D> {
        match self {
            Condition::Uniform(u) | Condition::Parabolic(u) | Condition::MovingWall(u) => *u,
            Condition::Function(u) => u(*at, time),
            Condition::NoSlip | Condition::Slip | Condition::Periodic | Condition::Open(_) => {
                Vector::zeros()
            }
        }
    }
}

impl<const D: usize> std::fmt::Debug for Condition<D> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Condition::NoSlip => f.write_str("NoSlip"),
            Condition::Slip => f.write_str("Slip"),
            Condition::Periodic => f.write_str("Periodic"),
            Condition::Uniform(u) => write!(f, "Uniform({:?})", u.as_slice()),
            Condition::Parabolic(u) => write!(f, "Parabolic({:?})", u.as_slice()),
            Condition::Function(_) => f.write_str("Function"),
            Condition::Open(p) => write!(f, "Open({p})"),
            Condition::MovingWall(u) => write!(f, "MovingWall({:?})", u.as_slice()),
        }
    }
}

/// Conditions by boundary, from a list by name; "all" stands for every boundary not named.
pub fn resolve_names<const D: usize>(
    named: &BTreeMap<String, Condition<D>>,
    known: &[String],
) -> Result<Vec<Condition<D>>, FluidError> {
    let unknown = |name: &&String| *name != "all" && !known.contains(name);
    if let Some(name) = named.keys().find(unknown) {
        return Err(FluidError::UnknownBoundary {
            name: name.clone(),
            allowed: known.to_vec(),
        });
    }
    let condition = |name: &String| named.get(name).or_else(|| named.get("all")).cloned();
    let missing = |name: &String| FluidError::MissingCondition { name: name.clone() };
    known
        .iter()
        .map(|name| condition(name).ok_or_else(|| missing(name)))
        .collect()
}

/// Names of opposite sides of a rectangle, axis by axis.
const OPPOSITE: [[&str; 2]; 3] = [["left", "right"], ["bottom", "top"], ["back", "front"]];

/// Directions in which a rectangle with these conditions is joined: both sides must say so.
pub fn periodic_directions<const D: usize>(
    named: &BTreeMap<String, Condition<D>>,
) -> Result<[bool; D], FluidError> {
    let joined = |name: &str| {
        matches!(
            named.get(name).or_else(|| named.get("all")),
            Some(Condition::Periodic)
        )
    };
    let mut periodic = [false; D];
    for (direction, [a, b]) in OPPOSITE.into_iter().take(D).enumerate() {
        if joined(a) != joined(b) {
            let (name, other) = if joined(a) { (a, b) } else { (b, a) };
            let why = format!("periodic here needs periodic on {other:?} as well");
            return Err(FluidError::Boundary {
                name: name.into(),
                why,
            });
        }
        periodic[direction] = joined(a);
    }
    Ok(periodic)
}
