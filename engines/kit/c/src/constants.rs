//! Numbers that both sides of the C interface know by name.

/// Version of this interface; compare with sillage_abi_version().
pub const SILLAGE_ABI_VERSION: u32 = 3;

/// Fluid: the entrained fraction and the solid mobility are used, not only drag and source.
pub const SILLAGE_AFFINE_RESPONSE: u32 = 0;
/// Particles: the drag is taken implicitly, in the free motion and in the contacts.
pub const SILLAGE_IMPLICIT_DRAG: u32 = 1;
/// Particles: contact 2 tells grains that a wall or a fixed grain holds.
pub const SILLAGE_CONTACT_STATE: u32 = 2;
/// Both: save and restore bring back the same bits.
pub const SILLAGE_CHECKPOINT: u32 = 3;
/// Particles: every candidate has the spins.
pub const SILLAGE_SPIN: u32 = 4;
/// Particles: remove() is there; a scene that grains may leave is refused without it.
pub const SILLAGE_REMOVES_GRAINS: u32 = 5;
/// Fluid: goes by `refinement` of its scene, and adapt() is there; such a scene is refused without it.
pub const SILLAGE_ADAPTS: u32 = 6;

/// The scene's part is not usable (exit code 2).
pub const SILLAGE_FAILURE_SCENE: u32 = 2;
/// The engine cannot do this, or broke (exit code 4).
pub const SILLAGE_FAILURE_ENGINE: u32 = 4;
/// A value is not finite, or an invariant is broken (exit code 7).
pub const SILLAGE_FAILURE_NOT_FINITE: u32 = 7;
/// An iteration did not converge (exit code 8).
pub const SILLAGE_FAILURE_NOT_CONVERGED: u32 = 8;
