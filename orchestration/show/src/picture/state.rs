//! What is drawn: the stage, which does not change during a run, and the states on it.

use std::sync::Arc;

use crate::plane::{Triangles, bounds, grain_bounds};

/// What stays the same in all pictures of a run.
#[derive(Debug, Clone)]
pub struct Stage {
    /// Name of the scene.
    pub name: String,
    /// The fluid's mesh.
    pub mesh: Option<Triangles>,
    /// Boundaries and walls as segments \[m\].
    pub outlines: Vec<[[f64; 2]; 2]>,
    /// Radii of the grains \[m\].
    pub grain_radius: Vec<f64>,
    /// Grains that never move.
    pub grain_fixed: Vec<bool>,
    /// Lower left and upper right corner of what is shown \[m\].
    pub window: ([f64; 2], [f64; 2]),
}

impl Stage {
    /// The stage of a mesh, walls and grains; `room` is the rectangle of a scene without fluid.
    pub fn new(
        name: &str,
        mesh: Option<Triangles>,
        walls: &[[[f64; 2]; 2]],
        grain_radius: Vec<f64>,
        grain_fixed: Vec<bool>,
    ) -> Self {
        let mut outlines = walls.to_vec();
        if let Some(mesh) = &mesh {
            let at = |point: u32| mesh.points[point as usize];
            outlines.extend(mesh.boundary().iter().map(|[a, b]| [at(*a), at(*b)]));
        }
        let window = match &mesh {
            Some(mesh) => mesh.bounds(),
            None => bounds(walls.iter().flatten().copied()),
        };
        Stage {
            name: name.to_string(),
            mesh,
            outlines,
            grain_radius,
            grain_fixed,
            window,
        }
    }

    /// Without walls or mesh the grains themselves span the window.
    pub fn widen(&mut self, state: &State) {
        if self.window.0[0] < self.window.1[0] && self.window.0[1] < self.window.1[1] {
            return;
        }
        let (low, high) = self.grain_bounds(state);
        let margin = 0.5 * (high[0] - low[0]).max(high[1] - low[1]).max(1e-6);
        self.window = (low.map(|x| x - margin), high.map(|x| x + margin));
    }

    /// Lower left and upper right corner of the grains, as wide as they are \[m\].
    pub fn grain_bounds(&self, state: &State) -> ([f64; 2], [f64; 2]) {
        let centres = state.grain_position.iter().map(|p| p.map(f64::from));
        let radius = |grain| self.radius(state.id(grain));
        let radii: Vec<f64> = (0..state.grain_position.len()).map(radius).collect();
        grain_bounds(centres, &radii)
    }

    /// Radius of a grain of the stage \[m\]; 0 of one that is not there.
    pub fn radius(&self, id: usize) -> f64 {
        self.grain_radius.get(id).copied().unwrap_or(0.0)
    }
}

/// A state in single precision: as exact as a picture can show, and small enough to keep.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct State {
    /// Time \[s\].
    pub time: f64,
    /// Its mesh; none: that of the stage.
    pub mesh: Option<Arc<Triangles>>,
    /// Interstitial velocity at each node \[m/s\].
    pub fluid_velocity: Vec<[f32; 2]>,
    /// Centres of the grains \[m\].
    pub grain_position: Vec<[f32; 2]>,
    /// Speeds of the grains \[m/s\].
    pub grain_speed: Vec<f32>,
    /// Their places in the stage; empty: all are there, in its order.
    pub grain_id: Vec<u32>,
}

/// Part of a grain's speed to which a fluid that rests may be known.
const ROUND_OFF: f64 = 1e-9;

impl State {
    /// The place of a grain in the stage.
    pub fn id(&self, grain: usize) -> usize {
        self.grain_id.get(grain).map_or(grain, |&id| id as usize)
    }

    /// Largest speed that colours show \[m/s\]: the fluid's, or the grains' without a fluid. A fluid that
    /// moves by no more than the round-off of its grains' speed rests.
    pub fn speed_max(&self) -> f64 {
        let fluid = self
            .fluid_velocity
            .iter()
            .map(|v| f64::from(v[0]).hypot(f64::from(v[1])));
        let fluid = fluid.fold(0.0, f64::max);
        let grains = self.grain_speed.iter().map(|&speed| f64::from(speed));
        let grains = grains.fold(0.0, f64::max);
        match self.fluid_velocity.is_empty() {
            true => grains,
            false if fluid < ROUND_OFF * grains => 0.0,
            false => fluid,
        }
    }
}
