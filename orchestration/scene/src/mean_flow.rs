//! What holds a flow whose sides are periodic.

use std::collections::BTreeMap;

use protocol::scene::{Boundary, MeanFlow, TimeScheme};

use crate::check::Checker;
use crate::dimensions::axes;
use crate::keys::{Fluid, Numbers, SceneFile};
use crate::walls::joined;

const KEY: &str = "fluid.mean_flow";

/// Refuse a mixture that falls for ever, and a mean flow that is not free to be given.
pub fn check<const D: usize>(
    keys: &SceneFile<D>,
    fluid: &Fluid<D>,
    boundaries: &BTreeMap<String, Boundary>,
    checker: &mut Checker<'_>,
) {
    let joined: [bool; D] = joined(boundaries);
    let holds = |side: &Boundary| !matches!(side, Boundary::Periodic | Boundary::Slip);
    if !boundaries.values().any(holds) {
        check_unheld(keys, fluid, joined, checker);
    }
    let Some(mean_flow) = fluid.mean_flow.filter(MeanFlow::is_steered) else {
        return;
    };
    if joined == [false; D] {
        checker.refuse(
            KEY,
            "no side is periodic, so what flows in says what flows through: leave it out",
        );
    }
    if let MeanFlow::Velocity(Numbers(velocity)) = mean_flow {
        for (axis, name) in axes::<D>() {
            if joined.contains(&true) && !joined[axis] && velocity[axis] != 0.0 {
                let message = format!("{name} must be 0: the sides across it are not periodic");
                checker.refuse(&format!("{KEY}.velocity"), message);
            }
        }
    }
}

/// All sides are periodic, or let the mixture slip: nothing but the scene says what it does along the
/// periodic axes on the whole.
fn check_unheld<const D: usize>(
    keys: &SceneFile<D>,
    fluid: &Fluid<D>,
    axes: [bool; D],
    checker: &mut Checker<'_>,
) {
    let gravity = keys.gravity.acceleration;
    let falls = (0..D).any(|axis| axes[axis] && gravity[axis] != 0.0);
    if falls && fluid.mean_flow.is_none() {
        checker.refuse(
            KEY,
            "missing: gravity points along periodic sides and no other side holds the flow, so fluid and \
             grains fall for ever; write mean_flow = \"zero\" (as in a shut vessel) or \
             { velocity = [0.0, 0.001] } (m/s), held by a uniform pressure gradient, or \"free\" for the fall",
        );
    }
    if axes.contains(&true) && fluid.time_scheme == TimeScheme::Steady && keys.grains.is_empty() {
        checker.refuse(
            "fluid.time_scheme",
            "a steady flow that no side holds along its periodic sides is any uniform flow: make a side \
             \"no-slip\", or take \"backward-euler\"",
        );
    }
}
