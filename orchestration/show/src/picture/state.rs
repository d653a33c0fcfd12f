//! What is drawn: the stage, which does not change during a run, and the states on it.

use std::sync::Arc;

use super::colour::{self, FIXED_GRAIN, GRAIN, Rgb};
use crate::simplices::{Corners, Point, Simplices, bounds, central, grain_bounds, length};

/// What stays the same in all pictures of a run.
#[derive(Debug, Clone)]
pub struct Stage<const D: usize, const N: usize> {
    /// Name of the scene.
    pub name: String,
    /// The fluid's mesh.
    pub mesh: Option<Simplices<D, N>>,
    /// Boundaries and walls as segments \[m\].
    pub outlines: Vec<[Point<D>; 2]>,
    /// Radii of the grains \[m\].
    pub grain_radius: Vec<f64>,
    /// Grains that never move.
    pub grain_fixed: Vec<bool>,
    /// What is shown \[m\].
    pub window: Corners<D>,
}

impl<const D: usize, const N: usize> Stage<D, N> {
    /// The stage of a mesh, walls and grains, its outlines to be drawn; the walls are the window of a scene without fluid.
    pub fn new(
        name: &str,
        mesh: Option<Simplices<D, N>>,
        walls: &[[Point<D>; D]],
        grain_radius: Vec<f64>,
        grain_fixed: Vec<bool>,
    ) -> Self {
        let window = match &mesh {
            Some(mesh) => mesh.bounds(),
            None => bounds(walls.iter().flatten().copied()),
        };
        Stage {
            name: name.to_string(),
            mesh,
            outlines: Vec::new(),
            grain_radius,
            grain_fixed,
            window,
        }
    }

    /// Without walls or mesh the grains themselves span the window.
    pub fn widen(&mut self, state: &State<D, N>) {
        if (0..D).all(|axis| self.window.0[axis] < self.window.1[axis]) {
            return;
        }
        let (low, high) = self.grain_bounds(state);
        let extent = (0..D).map(|axis| high[axis] - low[axis]);
        let margin = 0.5 * extent.fold(1e-6, f64::max);
        self.window = (low.map(|x| x - margin), high.map(|x| x + margin));
    }

    /// The box around the grains, as wide as they are \[m\].
    pub fn grain_bounds(&self, state: &State<D, N>) -> Corners<D> {
        let centres = state.grain_position.iter().map(|p| p.map(f64::from));
        let radius = |grain| self.radius(state.id(grain));
        let radii: Vec<f64> = (0..state.grain_position.len()).map(radius).collect();
        grain_bounds(centres, &radii)
    }

    /// Radius of a grain of the stage \[m\]; 0 of one that is not there.
    pub fn radius(&self, id: usize) -> f64 {
        self.grain_radius.get(id).copied().unwrap_or(0.0)
    }

    /// The largest radius \[m\].
    pub fn widest(&self) -> f64 {
        self.grain_radius.iter().copied().fold(0.0, f64::max)
    }

    /// Colour of a grain over a fluid, or by its speed where there is none.
    pub fn grain_colour(&self, state: &State<D, N>, grain: usize, speed_max: f64) -> Rgb {
        let fixed = self.grain_fixed.get(state.id(grain)).copied();
        if fixed.unwrap_or(false) {
            return FIXED_GRAIN;
        }
        if self.mesh.is_some() {
            return GRAIN;
        }
        let speed = state.grain_speed.get(grain).copied().map_or(0.0, f64::from);
        colour::dry(if speed_max > 0.0 {
            speed / speed_max
        } else {
            0.0
        })
    }
}

/// A state in single precision: as exact as a picture can show, and small enough to keep.
#[derive(Debug, Clone, PartialEq)]
pub struct State<const D: usize, const N: usize> {
    /// Time \[s\].
    pub time: f64,
    /// Its mesh; none: that of the stage.
    pub mesh: Option<Arc<Simplices<D, N>>>,
    /// Interstitial velocity at each node \[m/s\].
    pub fluid_velocity: Vec<[f32; D]>,
    /// Centres of the grains \[m\].
    pub grain_position: Vec<[f32; D]>,
    /// Speeds of the grains \[m/s\].
    pub grain_speed: Vec<f32>,
    /// Their places in the stage; empty: all are there, in its order.
    pub grain_id: Vec<u32>,
}

impl<const D: usize, const N: usize> Default for State<D, N> {
    fn default() -> Self {
        State {
            time: 0.0,
            mesh: None,
            fluid_velocity: Vec::new(),
            grain_position: Vec::new(),
            grain_speed: Vec::new(),
            grain_id: Vec::new(),
        }
    }
}

/// Part of a grain's speed to which a fluid that rests may be known.
const ROUND_OFF: f64 = 1e-9;

impl<const D: usize, const N: usize> State<D, N> {
    /// The place of a grain in the stage.
    pub fn id(&self, grain: usize) -> usize {
        self.grain_id.get(grain).map_or(grain, |&id| id as usize)
    }

    /// The mesh that its velocity is on, and that velocity \[m/s\].
    pub fn flow<'a>(
        &'a self,
        stage: &'a Stage<D, N>,
    ) -> Option<(&'a Simplices<D, N>, &'a [[f32; D]])> {
        let mesh = self.mesh.as_deref().or(stage.mesh.as_ref())?;
        let fits = self.fluid_velocity.len() == mesh.node_count;
        fits.then_some((mesh, self.fluid_velocity.as_slice()))
    }

    /// The box around the grains' centres without the outermost percent, which a long tail would stretch;
    /// none without grains.
    pub fn central_bounds(&self) -> Option<Corners<D>> {
        let (mut low, mut high) = ([0.0; D], [0.0; D]);
        for axis in 0..D {
            let along = self.grain_position.iter().map(|p| f64::from(p[axis]));
            (low[axis], high[axis]) = central(along.collect())?;
        }
        Some((low, high))
    }

    /// Largest speed that colours show \[m/s\]: the fluid's, or the grains' without a fluid. A fluid that
    /// moves by no more than the round-off of its grains' speed rests.
    pub fn speed_max(&self) -> f64 {
        let speeds = self.fluid_velocity.iter().map(|v| length(v.map(f64::from)));
        let fluid = speeds.fold(0.0, f64::max);
        let grains = self.grain_speed.iter().map(|&speed| f64::from(speed));
        let grains = grains.fold(0.0, f64::max);
        match self.fluid_velocity.is_empty() {
            true => grains,
            false if fluid < ROUND_OFF * grains => 0.0,
            false => fluid,
        }
    }
}
