//! How large the cells of a mesh are to be, where that is asked for.
//!
//! ```text
//!   h(x) = min(largest, min over regions of (size + growth · distance))
//! ```

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::door::fits;

/// Regions in one size function, so that it fits a message.
pub const REGIONS_MAX: usize = 512;

/// A size function h(x).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Refinement {
    /// By how much cells grow away from a region, in metres a metre.
    pub growth: f64,
    /// Largest cells \[m\]; none: those that the mesh begins with.
    pub largest: Option<f64>,
    /// Where they are small.
    pub regions: Vec<Region>,
}

/// A place where cells are small.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub enum Region {
    /// A ball; a point where its radius is 0.
    Ball {
        /// Its centre (m).
        centre: Vec<f64>,
        /// Its radius (m).
        #[schemars(range(min = 0))]
        radius: f64,
        /// Cells in it (m).
        #[schemars(extend("exclusiveMinimum" = 0))]
        size: f64,
    },
    /// A box along the axes.
    Box {
        /// Its lower corner (m).
        lower: Vec<f64>,
        /// Its upper corner (m).
        upper: Vec<f64>,
        /// Cells in it (m).
        #[schemars(extend("exclusiveMinimum" = 0))]
        size: f64,
    },
}

/// Cells near grains, which the coupler knows.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NearGrains {
    /// Cells near grains \[m\].
    pub size: f64,
    /// How far grains may go before the mesh follows \[m\].
    pub margin: f64,
}

/// Cells where the flow bends, which the coupler sees.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Indicator {
    /// Change of ∇v from a cell to the next, times the size of a cell, over the largest speed: where it is more, cells
    /// become smaller.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub jump: f64,
    /// Smallest cells (m).
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub smallest: f64,
}

impl Region {
    /// Cells in it \[m\].
    pub fn size(&self) -> f64 {
        match self {
            Region::Ball { size, .. } | Region::Box { size, .. } => *size,
        }
    }
}

impl Refinement {
    /// Is every number one that a mesh can be made with? An error names what is not.
    pub fn check(&self, dimension: usize) -> Result<(), String> {
        let growth = self.growth;
        if !(growth.is_finite() && growth > 0.0) {
            return Err(format!("growth is {growth}, must be positive"));
        }
        if let Some(largest) = self.largest.filter(|h| !(h.is_finite() && *h > 0.0)) {
            return Err(format!("largest is {largest} m, must be positive"));
        }
        if self.regions.len() > REGIONS_MAX {
            let count = self.regions.len();
            return Err(format!(
                "{count} regions, at most {REGIONS_MAX} are possible"
            ));
        }
        let mut regions = self.regions.iter().enumerate();
        regions.try_for_each(|(k, region)| {
            let checked = region.check(dimension);
            checked.map_err(|why| format!("regions[{k}]: {why}"))
        })
    }
}

impl Region {
    fn check(&self, dimension: usize) -> Result<(), String> {
        let size = self.size();
        if !(size.is_finite() && size > 0.0) {
            return Err(format!("size is {size} m, must be positive"));
        }
        match self {
            Region::Ball { centre, radius, .. } => {
                fits(dimension, "centre", centre)?;
                finite("centre", centre)?;
                match radius.is_finite() && *radius >= 0.0 {
                    true => Ok(()),
                    false => Err(format!("radius is {radius} m, must be 0 or more")),
                }
            }
            Region::Box { lower, upper, .. } => {
                fits(dimension, "lower", lower)?;
                fits(dimension, "upper", upper)?;
                finite("lower", lower)?;
                finite("upper", upper)?;
                match lower.iter().zip(upper).find(|(low, high)| low > high) {
                    None => Ok(()),
                    Some((low, high)) => Err(format!("upper {high} m is below lower {low} m")),
                }
            }
        }
    }
}

fn finite(name: &str, numbers: &[f64]) -> Result<(), String> {
    match numbers.iter().find(|number| !number.is_finite()) {
        None => Ok(()),
        Some(number) => Err(format!("{name} has {number}, must be finite")),
    }
}
