//! The catalogue of fields that cross a process boundary, and the header that travels with each.
//!
//! Values are `f64` in SI units; vector fields are interleaved (x₀, y₀, x₁, y₁, …). Grains are
//! disks per metre of depth, or spheres in a slab (the coupler divides by its depth).

use serde::{Deserialize, Serialize};

/// What the values of a field belong to; decides how many there must be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Support {
    /// One value a mesh node.
    Node,
    /// One value a triangle.
    Triangle,
    /// One value a grain.
    Grain,
}

/// Every field of the protocol; the number is its id on the wire and never changes meaning.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[repr(u32)]
pub enum Field {
    /// Node coordinates \[m\].
    NodePosition = 1,
    /// Node numbers of each triangle's corners (whole numbers stored as f64), counter-clockwise.
    TriangleNodes = 2,
    /// Corner coordinates of each triangle \[m\]; across a periodic boundary they are unwrapped,
    /// so shape functions always come from these.
    TrianglePosition = 3,
    /// Lumped mass ∫N_α of each node \[m²\].
    NodalMass = 4,

    /// Porosity φ; 1 when not sent.
    Porosity = 10,
    /// Drag coefficient β per mixture volume \[kg/(m³ s)\]; 0 when not sent.
    Drag = 11,
    /// Drag source s \[N/m³\]; 0 when not sent.
    DragSource = 12,
    /// Entrained solid fraction c; 0 when not sent.
    EntrainedFraction = 13,
    /// Solid flux j⁰ \[m/s\]; 0 when not sent.
    SolidFlux = 14,
    /// Solid mobility κ \[m³ s/kg\]; 0 when not sent.
    SolidMobility = 15,

    /// Interstitial fluid velocity v_α = u_α/φ_α \[m/s\].
    InterstitialVelocity = 20,
    /// Mass-averaged pressure gradient ℓ_α⁻¹ ∫N_α ∇p \[Pa/m\].
    PressureGradient = 21,
    /// Pressure p \[Pa\].
    Pressure = 22,

    /// Grain centres \[m\].
    GrainPosition = 30,
    /// Grain velocities at the end of the step \[m/s\].
    GrainVelocity = 31,
    /// Grain velocities averaged over the step, (xⁿ⁺¹ − xⁿ)/Δt \[m/s\].
    GrainMeanVelocity = 32,
    /// Grain radii \[m\].
    GrainRadius = 33,
    /// Grain masses \[kg\] (disk: kg per metre of depth).
    GrainMass = 34,
    /// Grain volumes \[m³\] (disk: m² , per metre of depth).
    GrainVolume = 35,
    /// 1 for a grain that never moves, else 0.
    GrainFixed = 36,
    /// Angular velocities \[rad/s\], counter-clockwise.
    GrainSpin = 37,

    /// Drag coefficient γ of each grain \[kg/s\], constant over the step.
    GrainDrag = 40,
    /// Force that does not depend on the grain's velocity, q = γ v_f − V∇p \[N\].
    GrainForce = 41,
    /// 0: no active contact; 1: touches; 2: force-connected to a wall or a fixed grain.
    GrainContact = 42,
}

impl Field {
    /// All fields, in the order of their ids.
    pub const ALL: [Field; 24] = [
        Field::NodePosition,
        Field::TriangleNodes,
        Field::TrianglePosition,
        Field::NodalMass,
        Field::Porosity,
        Field::Drag,
        Field::DragSource,
        Field::EntrainedFraction,
        Field::SolidFlux,
        Field::SolidMobility,
        Field::InterstitialVelocity,
        Field::PressureGradient,
        Field::Pressure,
        Field::GrainPosition,
        Field::GrainVelocity,
        Field::GrainMeanVelocity,
        Field::GrainRadius,
        Field::GrainMass,
        Field::GrainVolume,
        Field::GrainFixed,
        Field::GrainSpin,
        Field::GrainDrag,
        Field::GrainForce,
        Field::GrainContact,
    ];

    /// The id on the wire.
    pub fn id(self) -> u32 {
        self as u32
    }

    /// The field with this id, if there is one.
    pub fn from_id(id: u32) -> Option<Field> {
        Field::ALL.into_iter().find(|field| field.id() == id)
    }

    /// The name in scenes, files, plots and service names.
    pub fn name(self) -> &'static str {
        match self {
            Field::NodePosition => "node_position",
            Field::TriangleNodes => "triangle_nodes",
            Field::TrianglePosition => "triangle_position",
            Field::NodalMass => "nodal_mass",
            Field::Porosity => "porosity",
            Field::Drag => "drag",
            Field::DragSource => "drag_source",
            Field::EntrainedFraction => "entrained_fraction",
            Field::SolidFlux => "solid_flux",
            Field::SolidMobility => "solid_mobility",
            Field::InterstitialVelocity => "interstitial_velocity",
            Field::PressureGradient => "pressure_gradient",
            Field::Pressure => "pressure",
            Field::GrainPosition => "grain_position",
            Field::GrainVelocity => "grain_velocity",
            Field::GrainMeanVelocity => "grain_mean_velocity",
            Field::GrainRadius => "grain_radius",
            Field::GrainMass => "grain_mass",
            Field::GrainVolume => "grain_volume",
            Field::GrainFixed => "grain_fixed",
            Field::GrainSpin => "grain_spin",
            Field::GrainDrag => "grain_drag",
            Field::GrainForce => "grain_force",
            Field::GrainContact => "grain_contact",
        }
    }

    /// The SI unit.
    pub fn unit(self) -> &'static str {
        match self {
            Field::NodePosition
            | Field::TrianglePosition
            | Field::GrainPosition
            | Field::GrainRadius => "m",
            Field::NodalMass => "m²",
            Field::Drag => "kg/(m³ s)",
            Field::DragSource => "N/m³",
            Field::SolidFlux
            | Field::InterstitialVelocity
            | Field::GrainVelocity
            | Field::GrainMeanVelocity => "m/s",
            Field::SolidMobility => "m³ s/kg",
            Field::PressureGradient => "Pa/m",
            Field::Pressure => "Pa",
            Field::GrainMass => "kg",
            Field::GrainVolume => "m³",
            Field::GrainSpin => "rad/s",
            Field::GrainDrag => "kg/s",
            Field::GrainForce => "N",
            Field::TriangleNodes
            | Field::Porosity
            | Field::EntrainedFraction
            | Field::GrainFixed
            | Field::GrainContact => "–",
        }
    }

    /// Numbers per node, triangle or grain.
    pub fn components(self) -> usize {
        match self {
            Field::TriangleNodes => 3,
            Field::TrianglePosition => 6,
            Field::NodePosition
            | Field::DragSource
            | Field::SolidFlux
            | Field::InterstitialVelocity
            | Field::PressureGradient
            | Field::GrainPosition
            | Field::GrainVelocity
            | Field::GrainMeanVelocity
            | Field::GrainForce => 2,
            _ => 1,
        }
    }

    /// What the values belong to.
    pub fn support(self) -> Support {
        match self.id() {
            2 | 3 => Support::Triangle,
            0..30 => Support::Node,
            _ => Support::Grain,
        }
    }
}
