//! What a flow through periodic sides does on the whole.

use std::convert::Infallible;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The mean flux of the mixture, fluid and grains together, through sides that are periodic. `V` is a
/// vector: flat numbers on the way, of a fixed length in a scene.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum MeanFlow<V = Vec<f64>> {
    /// As the forces have it: nothing steers it.
    #[default]
    Free,
    /// None, as in a shut vessel: steered by a uniform pressure gradient.
    Zero,
    /// This flux through unit area (m/s), steered likewise; 0 along an axis that is not periodic.
    Velocity(V),
}

impl<V> MeanFlow<V> {
    /// The same with its vector in another form.
    pub fn map<W>(&self, vector: impl FnOnce(&V) -> W) -> MeanFlow<W> {
        let Ok(mapped) = self.try_map(|v| Ok::<W, Infallible>(vector(v)));
        mapped
    }

    /// The same with its vector in another form; the error of a vector that has none.
    pub fn try_map<W, E>(&self, vector: impl FnOnce(&V) -> Result<W, E>) -> Result<MeanFlow<W>, E> {
        Ok(match self {
            MeanFlow::Free => MeanFlow::Free,
            MeanFlow::Zero => MeanFlow::Zero,
            MeanFlow::Velocity(velocity) => MeanFlow::Velocity(vector(velocity)?),
        })
    }

    /// Is it steered?
    pub fn is_steered(&self) -> bool {
        !matches!(self, MeanFlow::Free)
    }
}
