//! The parts of a scene that processes receive: plain data, SI units, already validated for range.
//! Read `fluid` with `boundary`, `convection`, `mean_flow` and `refinement`, `particles`, then `coupling`, the resolved
//! scene as a whole.

mod boundary;
mod convection;
mod coupling;
mod door;
mod fluid;
mod mean_flow;
mod particles;
mod refinement;

pub use boundary::{Boundary, GrainBoundary, Profile};
pub use convection::{CREEPING_REYNOLDS, Convection};
pub use coupling::{
    AdaptiveStep, CouplerScene, DragLaw, Geometry, LUMPED_RATIO_MAX, Limits, Scheme, is_over,
};
pub use door::fixed;
pub use fluid::{Diagonals, FluidScene, MeshSource, Nonlinear, TimeScheme, ViscousForm};
pub use mean_flow::MeanFlow;
pub use particles::{ContactSolver, ParticleScene, Wall};
pub use refinement::{Indicator, NearGrains, REGIONS_MAX, Refinement, Region};
