//! What is put out: fields of a state, and columns of `steps.csv` that its writer, its reader and an engine
//! know by name.
//!
//! The other columns are only put out. Columns of cost, and no others, start with [`COST`].

use crate::language::field::Field;

/// Fields of a state in the files for ParaView, where the scene has nodes or grains.
pub const WRITTEN: [Field; 11] = [
    Field::InterstitialVelocity,
    Field::Pressure,
    Field::Porosity,
    Field::GrainPosition,
    Field::GrainVelocity,
    Field::GrainSpin,
    Field::GrainContact,
    Field::GrainRadius,
    Field::GrainMass,
    Field::GrainFixed,
    Field::GrainId,
];

/// Number of the step.
pub const STEP: &str = "step";
/// End of the step \[s\].
pub const TIME: &str = "time";
/// Lengths that failed before that of the step.
pub const FAILED_TRIES: &str = "failed_tries";
/// Passes of the coupling.
pub const PASSES: &str = "passes";
/// Sub-steps of the last pass.
pub const SUB_STEPS: &str = "sub_steps";
/// Contacts that touch.
pub const CONTACTS: &str = "contacts";
/// Is the convection there? 0 or 1.
pub const CONVECTION: &str = "convection";
/// How far the impulses are from the contact laws, where they are solved to the end.
pub const CONTACT_RESIDUAL: &str = "contact_residual";
/// How far contacts sink before they carry their load, of the radius; 0: solved to the end.
pub const CONTACT_SINKING: &str = "contact_sinking";
/// Deepest overlap \[m\].
pub const PENETRATION_MAX: &str = "penetration_max";
/// Smallest porosity of a node.
pub const POROSITY_MIN: &str = "porosity_min";

/// Nodes of the mesh, where it follows the grains.
pub const NODES: &str = "nodes";
/// Which mesh it is.
pub const EPOCH: &str = "epoch";

/// Grains that are left.
pub const GRAINS: &str = "grains";
/// Grains that have left so far.
pub const REMOVED_GRAINS: &str = "removed_grains";

/// Pairs that may touch in the step; 0: the step did without contacts.
pub const CONTACT_CANDIDATES: &str = "contact_candidates";
/// Searches for such pairs.
pub const CONTACT_SEARCHES: &str = "contact_searches";
/// Sweeps of the contact solver.
pub const CONTACT_SWEEPS: &str = "contact_sweeps";
/// How often grains were held against walls; 0: the step did without walls.
pub const CONTACT_WALL_LOOKS: &str = "contact_wall_looks";

/// Numbers of the particle engine that are columns where it counts them.
pub const COUNTERS: [&str; 4] = [
    CONTACT_CANDIDATES,
    CONTACT_SEARCHES,
    CONTACT_SWEEPS,
    CONTACT_WALL_LOOKS,
];

/// How the names of CPU and wall-clock seconds start.
pub const COST: [&str; 2] = ["cpu_", "wall_"];
/// How the names of what a budget leaves end.
pub const DEFECT: &str = "_defect";

/// Is it seconds of CPU or wall clock, which differ from run to run?
pub fn is_cost(name: &str) -> bool {
    COST.iter().any(|prefix| name.starts_with(prefix))
}

/// Is it a whole number?
pub fn is_count(name: &str) -> bool {
    let counts = [
        STEP,
        FAILED_TRIES,
        PASSES,
        SUB_STEPS,
        CONTACTS,
        CONVECTION,
        GRAINS,
        REMOVED_GRAINS,
        NODES,
        EPOCH,
    ];
    counts.contains(&name) || COUNTERS.contains(&name)
}

/// What the numbers of a column are told of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A plane of disks, per metre of depth.
    Disks,
    /// A plane with balls in a slab: what is told of the fluid is per metre of depth.
    Slab,
    /// Space.
    Space,
}

/// The unit of a column; "–" for a number without one, none for a column that is not ours.
pub fn unit(name: &str, kind: Kind) -> Option<&'static str> {
    let grains = |disk: &'static str, ball: &'static str| match kind {
        Kind::Disks => disk,
        Kind::Slab | Kind::Space => ball,
    };
    let fluid = |plane: &'static str, space: &'static str| match kind {
        Kind::Disks | Kind::Slab => plane,
        Kind::Space => space,
    };
    let starts = |prefix: &str| name.starts_with(prefix);
    Some(match name {
        TIME | "dt" => "s",
        "front" | "rear" | "width" | "width98" => "m",
        "fluid_speed_max" => "m/s",
        "kinetic_energy" | "mechanical_energy" => grains("J/m", "J"),
        "removed_energy" => grains("J/m", "J"),
        "removed_volume" => grains("m²", "m³"),
        "removed_mass" => grains("kg/m", "kg"),
        "inflow" | "outflow" => fluid("m²/s", "m³/s"),
        "mesh_volume" => fluid("m²", "m³"),
        "mesh_energy" => fluid("J/m", "J"),
        "pressure_drop" => "Pa",
        CONTACT_RESIDUAL | CONTACT_SINKING | PENETRATION_MAX | POROSITY_MIN => "–",
        "transfer_loss" | "reynolds" => "–",
        _ if is_cost(name) => "s",
        _ if is_count(name) || name.ends_with(DEFECT) => "–",
        _ if starts("centre_") => "m",
        _ if starts("fall_speed") => "m/s",
        _ if starts("momentum_") || starts("removed_momentum_") => grains("kg/s", "kg m/s"),
        _ if starts("mesh_momentum_") => fluid("kg/s", "kg m/s"),
        _ if starts("force_") => fluid("N/m", "N"),
        _ if starts("mean_pressure_gradient_") => "Pa/m",
        _ => return None,
    })
}
