//! The fields that cross a process boundary: **one table**, a row a field.
//!
//! Ids, names, units, defaults, the lists of each exchange, the queues of a link and the table of
//! `README.md` are derived from it. A new field is one row, the place that fills it and the place that
//! reads it. Values are `f64` in SI units; vectors are interleaved (x₀, y₀, x₁, y₁, …).

use serde::{Deserialize, Serialize};

/// What the values of a field belong to; decides how many there must be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Support {
    /// A node of the mesh.
    Node,
    /// A simplex of the mesh: a triangle in the plane, a tetrahedron in space.
    Simplex,
    /// A grain.
    Grain,
    /// A facet of the mesh's boundary: an edge in the plane, a triangle in space.
    Facet,
}

/// How many numbers there are for each node, simplex, grain or facet.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rank {
    /// One.
    Scalar,
    /// One a dimension.
    Vector,
    /// One a corner of the simplex.
    Corners,
    /// A vector a corner of the simplex.
    CornerVectors,
    /// A vector a corner of the facet.
    FacetVectors,
    /// One a plane of rotation: a number in the plane, a vector in space.
    Spin,
}

/// The SI unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unit {
    /// The same in every dimension.
    Of(&'static str),
    /// Of the volume of the space that the mesh is in: m² in the plane, m³ in space.
    Measure,
    /// Another one for disks, which are per metre of depth.
    Grain {
        /// Of a ball.
        ball: &'static str,
        /// Of a disk.
        disk: &'static str,
    },
}

/// Who sends a field to whom, with which message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Exchange {
    /// The mesh: fluid → coupler with `Ready` (and coupler → orchestrator with `Started`).
    Mesh,
    /// Coupler → fluid, with `Advance`.
    ToFluid,
    /// A fluid candidate, with `Done`.
    FromFluid,
    /// Grains, both ways with `Configure` and `Ready`.
    Grains,
    /// Coupler → particles, with `Advance`.
    ToParticles,
    /// A particle candidate, with `Done`.
    FromParticles,
    /// The same, from engines that declare it ([`Hello::answer`](crate::message::Hello::answer)).
    MaybeFromParticles,
    /// The boundary of the mesh: fluid → coupler with `Ready`, where it tells facets.
    Boundary,
    /// Coupler → orchestrator with `Snapshot`, and no engine.
    Shown,
}

/// A row of the table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FieldSpec {
    /// The field; its place in the declaration is its number within messages.
    pub field: Field,
    /// Number in headers; never changes its meaning.
    pub id: u32,
    /// Name in scenes, files, plots and services.
    pub name: &'static str,
    /// What the values belong to.
    pub support: Support,
    /// Numbers for each of them.
    pub rank: Rank,
    /// Unit of the numbers.
    pub unit: Unit,
    /// Value where the field is not sent; none: it is always sent, or nobody needs it.
    pub default: Option<f64>,
    /// Who sends it, with what.
    pub sent: &'static [Exchange],
    /// What it is.
    pub meaning: &'static str,
}

/// Declares [`Field`] and [`FIELDS`] from one list of rows, so that neither can lack a field.
macro_rules! fields {
    ($($(#[doc = $meaning:literal])+ $field:ident = $id:literal $name:literal
        $support:ident $rank:ident $unit:expr, $default:expr, [$($exchange:ident)+];)+) => {
        /// Every field of the protocol; the number is its id on the wire and never changes meaning.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
        #[repr(u32)]
        pub enum Field {
            $($(#[doc = $meaning])+ $field = $id,)+
        }

        /// The table, in the order of the declaration.
        pub const FIELDS: [FieldSpec; [$($id),+].len()] = [$(FieldSpec {
            field: Field::$field,
            id: $id,
            name: $name,
            support: Support::$support,
            rank: Rank::$rank,
            unit: $unit,
            default: $default,
            sent: &[$(Exchange::$exchange),+],
            meaning: concat!($($meaning),+),
        }),+];
    };
}

fields! {
    /// Coordinates of each node.
    NodePosition = 1 "node_position" Node Vector Unit::Of("m"), None, [Mesh];
    /// Nodes of each simplex's corners: whole numbers from 0, positively oriented (in the plane
    /// counter-clockwise).
    SimplexNodes = 2 "simplex_nodes" Simplex Corners Unit::Of("–"), None, [Mesh];
    /// Coordinates of each simplex's corners, unwrapped across periodic boundaries; shape functions
    /// always come from these.
    SimplexPosition = 3 "simplex_position" Simplex CornerVectors Unit::Of("m"), None, [Mesh];
    /// Lumped mass ∫N_α, positive.
    NodalMass = 4 "nodal_mass" Node Scalar Unit::Measure, None, [Mesh];

    /// Porosity φ.
    Porosity = 10 "porosity" Node Scalar Unit::Of("–"), Some(1.0), [ToFluid];
    /// Drag coefficient β per volume of the mixture.
    Drag = 11 "drag" Node Scalar Unit::Of("kg/(m³ s)"), Some(0.0), [ToFluid];
    /// Drag source s.
    DragSource = 12 "drag_source" Node Vector Unit::Of("N/m³"), Some(0.0), [ToFluid];
    /// Entrained solid fraction c.
    EntrainedFraction = 13 "entrained_fraction" Node Scalar Unit::Of("–"), Some(0.0), [ToFluid];
    /// Solid flux j⁰.
    SolidFlux = 14 "solid_flux" Node Vector Unit::Of("m/s"), Some(0.0), [ToFluid];
    /// Solid mobility κ.
    SolidMobility = 15 "solid_mobility" Node Scalar Unit::Of("m³ s/kg"), Some(0.0), [ToFluid];

    /// Interstitial velocity v_α = u_α/φ_α.
    InterstitialVelocity = 20 "interstitial_velocity" Node Vector Unit::Of("m/s"), None, [FromFluid];
    /// Pressure gradient ℓ_α⁻¹ ∫N_α ∇p.
    PressureGradient = 21 "pressure_gradient" Node Vector Unit::Of("Pa/m"), None, [FromFluid];
    /// Pressure p.
    Pressure = 22 "pressure" Node Scalar Unit::Of("Pa"), None, [FromFluid];

    /// Centres.
    GrainPosition = 30 "grain_position" Grain Vector Unit::Of("m"), None, [Grains FromParticles];
    /// Velocities, of the end of the step.
    GrainVelocity = 31 "grain_velocity" Grain Vector Unit::Of("m/s"), None, [Grains FromParticles];
    /// (xⁿ⁺¹ − xⁿ)/Δt, before wrapping.
    GrainMeanVelocity = 32 "grain_mean_velocity" Grain Vector Unit::Of("m/s"), None, [FromParticles];
    /// Radii, positive.
    GrainRadius = 33 "grain_radius" Grain Scalar Unit::Of("m"), None, [Grains];
    /// Masses, positive.
    GrainMass = 34 "grain_mass" Grain Scalar Unit::Grain { ball: "kg", disk: "kg/m" }, None, [Grains];
    /// Volumes, positive.
    GrainVolume = 35 "grain_volume" Grain Scalar Unit::Grain { ball: "m³", disk: "m²" }, None, [Grains];
    /// 1: never moves, else 0.
    GrainFixed = 36 "grain_fixed" Grain Scalar Unit::Of("–"), None, [Grains];
    /// Angular velocities of the end of the step, in the plane counter-clockwise; 0 before the first.
    GrainSpin = 37 "grain_spin" Grain Spin Unit::Of("rad/s"), None, [MaybeFromParticles];

    /// Drag coefficient γ, constant over the step, taken implicitly.
    GrainDrag = 40 "grain_drag" Grain Scalar Unit::Of("kg/s"), Some(0.0), [ToParticles];
    /// Force q = γ v_f − V∇p, which does not depend on the grain's velocity.
    GrainForce = 41 "grain_force" Grain Vector Unit::Of("N"), Some(0.0), [ToParticles];
    /// 0 free, 1 touches, 2 held by a wall or a fixed grain.
    GrainContact = 42 "grain_contact" Grain Scalar Unit::Of("–"), None, [FromParticles];

    /// Part of `drag` that is of fixed grains; at most `drag`.
    FixedDrag = 50 "fixed_drag" Node Scalar Unit::Of("kg/(m³ s)"), Some(0.0), [ToFluid];

    /// Coordinates of each facet's corners, unwrapped across periodic boundaries: in the plane with the
    /// fluid on the left of the way, in space seen counter-clockwise from outside.
    FacetPosition = 5 "facet_position" Facet FacetVectors Unit::Of("m"), None, [Boundary];
    /// Which boundary of `Ready` each facet belongs to: whole numbers from 0.
    FacetBoundary = 6 "facet_boundary" Facet Scalar Unit::Of("–"), None, [Boundary];
    /// Velocity that the boundary gives the fluid at the middle of each facet, 0 where it gives none.
    FacetVelocity = 7 "facet_velocity" Facet Vector Unit::Of("m/s"), None, [Boundary];
    /// Number that a grain keeps when others leave: its place among the first grains, from 0.
    GrainId = 38 "grain_id" Grain Scalar Unit::Of("–"), None, [Shown];
}

/// Coupler → fluid.
pub const TO_FLUID: [Field; count(&[Exchange::ToFluid])] = sent_in(&[Exchange::ToFluid]);
/// The mesh, fluid → coupler (and coupler → orchestrator).
pub const MESH: [Field; count(&[Exchange::Mesh])] = sent_in(&[Exchange::Mesh]);
/// The boundary of the mesh, fluid → coupler.
pub const BOUNDARY: [Field; count(&[Exchange::Boundary])] = sent_in(&[Exchange::Boundary]);
/// A fluid candidate.
pub const FROM_FLUID: [Field; count(&[Exchange::FromFluid])] = sent_in(&[Exchange::FromFluid]);
/// Coupler → particles.
pub const TO_PARTICLES: [Field; count(&[Exchange::ToParticles])] =
    sent_in(&[Exchange::ToParticles]);
/// Grains, both ways with `Configure` and `Ready`.
pub const GRAINS: [Field; count(&[Exchange::Grains])] = sent_in(&[Exchange::Grains]);
/// A particle candidate.
pub const FROM_PARTICLES: [Field; count(&[Exchange::FromParticles])] =
    sent_in(&[Exchange::FromParticles]);

impl FieldSpec {
    /// Is it sent in one of these exchanges?
    const fn is_sent_in(&self, exchanges: &[Exchange]) -> bool {
        let mut own = 0;
        while own < self.sent.len() {
            let mut other = 0;
            while other < exchanges.len() {
                if self.sent[own] as u32 == exchanges[other] as u32 {
                    return true;
                }
                other += 1;
            }
            own += 1;
        }
        false
    }
}

/// How many fields are sent in these exchanges.
pub const fn count(exchanges: &[Exchange]) -> usize {
    let (mut row, mut count) = (0, 0);
    while row < FIELDS.len() {
        count += FIELDS[row].is_sent_in(exchanges) as usize;
        row += 1;
    }
    count
}

/// The fields that are sent in these exchanges, in the order of the table; `COUNT` is their [`count`].
pub const fn sent_in<const COUNT: usize>(exchanges: &[Exchange]) -> [Field; COUNT] {
    let mut fields = [FIELDS[0].field; COUNT];
    let (mut row, mut place) = (0, 0);
    while row < FIELDS.len() {
        if FIELDS[row].is_sent_in(exchanges) {
            fields[place] = FIELDS[row].field;
            place += 1;
        }
        row += 1;
    }
    assert!(place == COUNT);
    fields
}

impl Field {
    /// All fields, in the order of the table.
    pub const ALL: [Field; FIELDS.len()] = {
        let mut fields = [FIELDS[0].field; FIELDS.len()];
        let mut row = 0;
        while row < FIELDS.len() {
            fields[row] = FIELDS[row].field;
            row += 1;
        }
        fields
    };

    /// Its row.
    pub fn spec(self) -> &'static FieldSpec {
        static TABLE: [FieldSpec; FIELDS.len()] = FIELDS;
        let row = TABLE.iter().position(|spec| spec.field == self);
        &TABLE[row.unwrap_or(0)] // every field has its row
    }

    /// The id on the wire.
    pub fn id(self) -> u32 {
        self as u32
    }

    /// The field with this id, if there is one.
    pub fn from_id(id: u32) -> Option<Field> {
        Field::ALL.into_iter().find(|field| field.id() == id)
    }

    /// The field with this name, if there is one.
    pub fn from_name(name: &str) -> Option<Field> {
        Field::ALL.into_iter().find(|field| field.name() == name)
    }

    /// The name in scenes, files, plots and service names.
    pub fn name(self) -> &'static str {
        self.spec().name
    }

    /// The SI unit in a space of this dimension; for grains that of balls.
    pub fn unit(self, dimension: usize) -> &'static str {
        self.unit_among(dimension, false)
    }

    /// The same where grains may be disks.
    pub fn unit_among(self, dimension: usize, disks: bool) -> &'static str {
        match self.spec().unit {
            Unit::Of(unit) => unit,
            Unit::Measure if dimension == 2 => "m²",
            Unit::Measure => "m³",
            Unit::Grain { disk, .. } if disks => disk,
            Unit::Grain { ball, .. } => ball,
        }
    }

    /// Numbers for each node, simplex, grain or facet in a space of this dimension.
    pub fn components(self, dimension: usize) -> usize {
        self.spec().rank.components(dimension)
    }

    /// What the values belong to.
    pub fn support(self) -> Support {
        self.spec().support
    }
}

impl Support {
    /// "node", "simplex", "grain" or "facet".
    pub fn name(self) -> &'static str {
        match self {
            Support::Node => "node",
            Support::Simplex => "simplex",
            Support::Grain => "grain",
            Support::Facet => "facet",
        }
    }
}

impl Rank {
    /// Numbers in a space of this dimension.
    pub const fn components(self, dimension: usize) -> usize {
        match self {
            Rank::Scalar => 1,
            Rank::Vector => dimension,
            Rank::Corners => dimension + 1,
            Rank::CornerVectors => dimension * (dimension + 1),
            Rank::FacetVectors => dimension * dimension,
            Rank::Spin => dimension * (dimension - 1) / 2,
        }
    }
}
