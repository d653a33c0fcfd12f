//! Numbers of the fields of a candidate; a test tells the lines.

/// Porosity φ. (–; scalar)
pub const SILLAGE_FIELD_POROSITY: u32 = 10;

/// Drag coefficient β per volume of the mixture. (kg/(m³ s); scalar)
pub const SILLAGE_FIELD_DRAG: u32 = 11;

/// Drag source s. (N/m³; vector)
pub const SILLAGE_FIELD_DRAG_SOURCE: u32 = 12;

/// Entrained solid fraction c. (–; scalar)
pub const SILLAGE_FIELD_ENTRAINED_FRACTION: u32 = 13;

/// Solid flux j⁰. (m/s; vector)
pub const SILLAGE_FIELD_SOLID_FLUX: u32 = 14;

/// Solid mobility κ. (m³ s/kg; scalar)
pub const SILLAGE_FIELD_SOLID_MOBILITY: u32 = 15;

/// Interstitial velocity v_α = u_α/φ_α. (m/s; vector)
pub const SILLAGE_FIELD_INTERSTITIAL_VELOCITY: u32 = 20;

/// Pressure gradient ℓ_α⁻¹ ∫N_α ∇p. (Pa/m; vector)
pub const SILLAGE_FIELD_PRESSURE_GRADIENT: u32 = 21;

/// Pressure p. (Pa; scalar)
pub const SILLAGE_FIELD_PRESSURE: u32 = 22;

/// Centres. (m; vector)
pub const SILLAGE_FIELD_GRAIN_POSITION: u32 = 30;

/// Velocities, of the end of the step. (m/s; vector)
pub const SILLAGE_FIELD_GRAIN_VELOCITY: u32 = 31;

/// (xⁿ⁺¹ − xⁿ)/Δt, before wrapping. (m/s; vector)
pub const SILLAGE_FIELD_GRAIN_MEAN_VELOCITY: u32 = 32;

/// Drag coefficient γ, constant over the step, taken implicitly. (kg/s; scalar)
pub const SILLAGE_FIELD_GRAIN_DRAG: u32 = 40;

/// Force q = γ v_f − V∇p, which does not depend on the grain's velocity. (N; vector)
pub const SILLAGE_FIELD_GRAIN_FORCE: u32 = 41;

/// 0 free, 1 touches, 2 held by a wall or a fixed grain. (–; scalar)
pub const SILLAGE_FIELD_GRAIN_CONTACT: u32 = 42;
