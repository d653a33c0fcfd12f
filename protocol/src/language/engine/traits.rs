//! What an engine implements; the loop that connects it to the coupler is in `lockstep`.

use std::path::Path;

use crate::language::field::Field;
use crate::language::message::{Advance, Capability, Diagnostic, Failure};
use crate::language::scene::{FluidScene, ParticleScene};

/// The mesh of a fluid engine, as it is told to the coupler. Shapes: see `Field`.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct MeshDescription {
    /// Interleaved node coordinates \[m\].
    pub node_position: Vec<f64>,
    /// Corners of each triangle, counter-clockwise.
    pub triangles: Vec<[u32; 3]>,
    /// Corner coordinates of each triangle \[m\], unwrapped across periodic boundaries.
    pub triangle_position: Vec<[f64; 6]>,
    /// Lumped mass of each node \[m²\].
    pub nodal_mass: Vec<f64>,
    /// Period in x and y \[m\].
    pub period: [Option<f64>; 2],
}

/// Grains as they are when a run begins. Vectors are interleaved; shapes: see `Field`.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct InitialGrains {
    /// Centres \[m\].
    pub position: Vec<f64>,
    /// Velocities \[m/s\].
    pub velocity: Vec<f64>,
    /// Radii \[m\].
    pub radius: Vec<f64>,
    /// Masses \[kg\].
    pub mass: Vec<f64>,
    /// Volumes \[m³\] (disk: m²).
    pub volume: Vec<f64>,
    /// 1 for a grain that never moves.
    pub fixed: Vec<f64>,
}

impl InitialGrains {
    /// The fields in the order of [`GRAINS`](crate::language::field::GRAINS).
    pub fn slices(&self) -> [(Field, &[f64]); 6] {
        [
            (Field::GrainPosition, &self.position),
            (Field::GrainVelocity, &self.velocity),
            (Field::GrainRadius, &self.radius),
            (Field::GrainMass, &self.mass),
            (Field::GrainVolume, &self.volume),
            (Field::GrainFixed, &self.fixed),
        ]
    }
}

/// What the coupler tells the fluid about the grains; `None` is the default of the
/// field: porosity 1, everything else 0. Read in place in shared memory.
#[derive(Debug, Clone, Copy, Default)]
pub struct SolidResponse<'a> {
    /// φ
    pub porosity: Option<&'a [f64]>,
    /// β \[kg/(m³ s)\]
    pub drag: Option<&'a [f64]>,
    /// s \[N/m³\], interleaved
    pub drag_source: Option<&'a [f64]>,
    /// c
    pub entrained_fraction: Option<&'a [f64]>,
    /// j⁰ \[m/s\], interleaved
    pub solid_flux: Option<&'a [f64]>,
    /// κ \[m³ s/kg\]
    pub solid_mobility: Option<&'a [f64]>,
}

/// What a fluid engine fills; written in place in shared memory.
#[derive(Debug)]
pub struct FluidAnswer<'a> {
    /// v_α = u_α/φ_α \[m/s\], interleaved
    pub interstitial_velocity: &'a mut [f64],
    /// ℓ_α⁻¹ ∫N_α ∇p \[Pa/m\], interleaved
    pub pressure_gradient: &'a mut [f64],
    /// p \[Pa\]
    pub pressure: &'a mut [f64],
}

/// What the coupler tells the grains about the fluid; `None` is zero (no fluid).
#[derive(Debug, Clone, Copy, Default)]
pub struct FluidForces<'a> {
    /// γ \[kg/s\], constant over the step, to be taken implicitly
    pub drag: Option<&'a [f64]>,
    /// q = γ v_f − V∇p \[N\], interleaved
    pub force: Option<&'a [f64]>,
}

/// What a particle engine fills.
#[derive(Debug)]
pub struct GrainAnswer<'a> {
    /// Centres at the end of the step \[m\], interleaved
    pub position: &'a mut [f64],
    /// Velocities at the end of the step \[m/s\], interleaved
    pub velocity: &'a mut [f64],
    /// (xⁿ⁺¹ − xⁿ)/Δt \[m/s\], interleaved, before any periodic wrapping
    pub mean_velocity: &'a mut [f64],
    /// 0 free, 1 touches, 2 force-connected to a wall or a fixed grain
    pub contact: &'a mut [f64],
}

/// A solver that takes the fluid seat.
pub trait FluidEngine {
    /// Name and version, for the hello.
    fn identity(&self) -> (&'static str, &'static str);
    /// What it can do.
    fn capabilities(&self) -> Vec<Capability>;
    /// Take the scene's part, build the mesh and the initial state.
    fn configure(&mut self, scene: &FluidScene) -> Result<MeshDescription, Failure>;
    /// Compute a candidate from the accepted state, which it must not change.
    fn advance(
        &mut self,
        request: &Advance,
        solid: &SolidResponse<'_>,
        answer: FluidAnswer<'_>,
    ) -> Result<Vec<Diagnostic>, Failure>;
    /// Accept the last candidate.
    fn commit(&mut self) -> Result<(), Failure>;
    /// Write the accepted state.
    fn save(&mut self, path: &Path) -> Result<(), Failure>;
    /// Read the accepted state.
    fn restore(&mut self, path: &Path) -> Result<(), Failure>;
}

/// A solver that takes the particle seat.
pub trait ParticleEngine {
    /// Name and version, for the hello.
    fn identity(&self) -> (&'static str, &'static str);
    /// What it can do.
    fn capabilities(&self) -> Vec<Capability>;
    /// Take the scene's part and the initial grains; answer with the grains that will be run.
    fn configure(
        &mut self,
        scene: &ParticleScene,
        grains: InitialGrains,
    ) -> Result<InitialGrains, Failure>;
    /// Compute a candidate from the accepted state, which it must not change.
    fn advance(
        &mut self,
        request: &Advance,
        fluid: &FluidForces<'_>,
        answer: GrainAnswer<'_>,
    ) -> Result<Vec<Diagnostic>, Failure>;
    /// Accept the last candidate.
    fn commit(&mut self) -> Result<(), Failure>;
    /// Write the accepted state.
    fn save(&mut self, path: &Path) -> Result<(), Failure>;
    /// Read the accepted state.
    fn restore(&mut self, path: &Path) -> Result<(), Failure>;
}
