//! The parts of a scene that engines receive: plain data, SI units, already validated for range.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::field::Field;
use crate::messages::Role;

pub use crate::convection::Convection;

/// What the fluid engine needs to know.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FluidScene {
    /// ρ \[kg/m³\].
    pub density: f64,
    /// μ \[Pa s\].
    pub dynamic_viscosity: f64,
    /// g \[m/s²\].
    pub gravity: [f64; 2],
    /// The mesh.
    pub mesh: MeshSource,
    /// Condition on every named boundary.
    pub boundaries: BTreeMap<String, Boundary>,
    /// Is ρφ v·∇v there?
    pub convection: Convection,
    /// Time scheme.
    pub time_scheme: TimeScheme,
    /// How the convection is solved within a step.
    pub nonlinear: Nonlinear,
    /// Form of the viscous term.
    pub viscous_form: ViscousForm,
    /// Factor of the grad-div stabilisation; 1 for suspensions, 0.1 for clear flow around bodies.
    pub grad_div: f64,
    /// Uniform initial superficial velocity \[m/s\].
    pub initial_velocity: [f64; 2],
    /// Threads the engine may use.
    pub threads: usize,
}

/// Where the mesh comes from.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub enum MeshSource {
    /// A rectangle cut into cells, each into two triangles. Boundaries: left, right, bottom, top.
    Rectangle {
        /// Lower left corner \[m\].
        lower: [f64; 2],
        /// Upper right corner \[m\].
        upper: [f64; 2],
        /// Cells in x and y.
        cells: [usize; 2],
        /// How cells are cut.
        diagonals: Diagonals,
        /// Ratio of the largest to the smallest cell in x and y (both ends refined); 1: uniform.
        grading: [f64; 2],
    },
    /// A Gmsh 4.1 file with named physical curves.
    File {
        /// Path, absolute or relative to the scene.
        path: String,
    },
}

/// Diagonals of the cells of a rectangle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Diagonals {
    /// Alternate from cell to cell: no preferred direction.
    Alternate,
    /// All the same: translation invariant, every node has the same mass.
    Uniform,
}

/// A boundary condition of the fluid. Velocities are superficial.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub enum Boundary {
    /// u = 0.
    NoSlip,
    /// u·n = 0, no tangential traction.
    Slip,
    /// Joined with the opposite side of the rectangle.
    Periodic,
    /// u given; also a moving wall.
    Inflow {
        /// Superficial velocity \[m/s\]; of the maximum when parabolic.
        velocity: [f64; 2],
        /// Shape across the boundary.
        profile: Profile,
    },
    /// Pressure given at the boundary's highest point \[Pa\]; hydrostatic (ρ g) along it.
    Open {
        /// Pressure \[Pa\].
        pressure: f64,
    },
}

/// Shape of an inflow across its boundary.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Profile {
    /// The same everywhere.
    Uniform,
    /// Zero at both ends, `velocity` in the middle.
    Parabolic,
}

/// Time scheme of the fluid.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum TimeScheme {
    /// First order.
    BackwardEuler,
    /// Second order; the first step is backward Euler.
    Bdf2,
    /// No time derivative: one `Advance` is the steady state.
    Steady,
}

/// Nonlinear solve of one `Advance`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub enum Nonlinear {
    /// Convecting velocity extrapolated from accepted steps: one linear solve.
    Picard,
    /// Newton to a relative residual.
    Newton {
        /// Relative residual at which it stops.
        tolerance: f64,
        /// Iterations allowed.
        iterations_max: usize,
    },
}

/// Form of the viscous term.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ViscousForm {
    /// −∇·(2μφ D(v)): Galilean invariant.
    Symmetric,
    /// −∇·(μφ∇v) − μ v ∇²φ: the paper's three terms as printed.
    PaperLiteral,
}

/// What the particle engine needs to know.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ParticleScene {
    /// g \[m/s²\]; the engine applies the full weight m g.
    pub gravity: [f64; 2],
    /// Wall segments; grains stay on the left of a → b, and off both ends.
    pub walls: Vec<Wall>,
    /// Period in x and y \[m\], where the domain is periodic.
    pub period: [Option<f64>; 2],
    /// Coulomb coefficient between grains.
    pub friction: f64,
    /// Coulomb coefficient between grains and walls.
    pub wall_friction: f64,
    /// Moment of inertia over m r²: 1/2 for disks, 2/5 for spheres.
    pub inertia_factor: f64,
    /// Contact residual (natural map) at which a solve stops, relative to |g|Δt.
    pub tolerance: f64,
    /// Sweeps allowed; more is an error.
    pub sweeps_max: usize,
    /// Sub-steps allowed in a coupling step; more is an error.
    pub sub_steps_max: u32,
    /// Threads the engine may use.
    pub threads: usize,
}

/// A wall segment from a to b \[m\]; solid on its right.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Wall {
    /// Start.
    pub a: [f64; 2],
    /// End.
    pub b: [f64; 2],
}

impl Wall {
    /// From a point to the nearest point of the segment \[m\].
    pub fn distance(&self, [x, y]: [f64; 2]) -> f64 {
        let ([ax, ay], [bx, by]) = (self.a, self.b);
        let (tx, ty) = (bx - ax, by - ay);
        let along = ((x - ax) * tx + (y - ay) * ty) / (tx * tx + ty * ty);
        let along = along.clamp(0.0, 1.0);
        (x - ax - along * tx).hypot(y - ay - along * ty)
    }
}

/// What the coupler needs to know: the resolved scene, written to the run folder as JSON.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CouplerScene {
    /// When the run ends \[s\].
    pub end_time: f64,
    /// Coupling step \[s\].
    pub coupling_step: f64,
    /// Adaptive step, when asked for.
    pub adaptive: Option<AdaptiveStep>,
    /// g \[m/s²\].
    pub gravity: [f64; 2],
    /// The fluid engine's part; none: no fluid process.
    pub fluid: Option<FluidScene>,
    /// The particle engine's part; none: no particle process.
    pub particles: Option<ParticleScene>,
    /// No grain moves and there is no particle process: the coupler answers for them.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub grains_stay: bool,
    /// CSV with the initial grains: x,y,radius,density,vx,vy,fixed; relative to the run folder.
    pub grains_file: Option<String>,
    /// Coupling scheme.
    pub scheme: Scheme,
    /// Drag law.
    pub drag: DragLaw,
    /// What a grain is.
    pub geometry: Geometry,
    /// Does the fluid feel the grains?
    pub reaction: bool,
    /// Smoothing length L of deposited fields \[m\]; 0: lumped mass. None: 2d where d/h > 0.25.
    pub smoothing_length: Option<f64>,
    /// Time between snapshots \[s\]; none: only the last state.
    pub output_every: Option<f64>,
    /// Limits on waiting for an engine.
    pub limits: Limits,
}

impl CouplerScene {
    /// Is there a process in this seat?
    pub fn has_process(&self, role: Role) -> bool {
        match role {
            Role::Fluid => self.fluid.is_some(),
            Role::Particles => self.particles.is_some() && !self.grains_stay,
        }
    }

    /// Fields of this engine's candidates that are not read in every pass: pressure and, where the fluid
    /// does not feel the grains, contact states with a state that is put out; the pressure gradient, which
    /// only grains feel, never.
    pub fn unread(&self, role: Role) -> &'static [Field] {
        let felt = self.fluid.is_some() && self.reaction;
        match role {
            _ if !self.has_process(role) => &[],
            Role::Fluid if self.particles.is_some() => &[Field::Pressure],
            Role::Fluid => &[Field::Pressure, Field::PressureGradient],
            Role::Particles if felt => &[],
            Role::Particles => &[Field::GrainContact],
        }
    }
}

/// Limits on waiting, all \[s\].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Limits {
    /// Until an engine says hello.
    pub connect: f64,
    /// Until an engine is ready after `Configure`.
    pub configure: f64,
    /// Until an engine answers an `Advance`.
    pub step: f64,
}

/// Bounds of an adaptive coupling step.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AdaptiveStep {
    /// Smallest step \[s\]; below it the run ends.
    pub step_min: f64,
    /// Largest step \[s\].
    pub step_max: f64,
    /// Cells a grain may cross in a step.
    pub courant: f64,
}

/// Coupling scheme.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub enum Scheme {
    /// Exactly one pass (the paper).
    Staggered,
    /// Passes until the interaction defect is below `tolerance`.
    Iterated {
        /// Force defect over the net force scale of the grains.
        tolerance: f64,
        /// Passes allowed; more is an error.
        passes_max: u32,
    },
    /// For comparison: the drag is implicit on either side, each with the other's velocity of the
    /// start of the step, and the solid's flux is that of the start. Unstable where dense and stiff.
    SemiImplicit,
    /// For comparison: the drag is evaluated with both velocities of the start of the step. Unstable
    /// once the step is longer than the relaxation times.
    Explicit,
}

/// Drag law.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum DragLaw {
    /// Dallavalle with φ^−1.8 (paper, eq. 5).
    Dallavalle,
    /// Di Felice 1994.
    DiFelice,
    /// Wen and Yu 1966.
    WenYu,
    /// Gidaspow 1994.
    Gidaspow,
    /// Beetstra 2007 with the polydisperse correction.
    Beetstra,
    /// Stokes, no hindrance.
    Stokes,
    /// The hindrance of MigFlow 1.4, for comparison runs.
    Migflow,
}

/// What a grain is.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub enum Geometry {
    /// A disk, per metre of depth: A = 2r, V = πr².
    Disk,
    /// A sphere in a slab of this depth: A = πr², V = 4/3 πr³.
    Sphere {
        /// Depth of the slab \[m\].
        depth: f64,
    },
}
