//! What every process of a run does first.

use crate::error::Error;
use crate::runspace::RunSpace;

/// Enter the run named by the environment and take `seat` ("coupler", "fluid", "particles"):
/// log to stderr, report a full shared memory, watch the partners.
pub fn enter(_seat: &str) -> Result<RunSpace, Error> {
    RunSpace::from_environment()
}
