//! A contact sheet: which states, which part of the domain, and how panels lie on the paper.

use super::state::{Stage, State};
use crate::simplices::Corners;

/// Height of the line above a panel \[pixels\].
pub const LABEL: f64 = 44.0;
/// Between panels \[pixels\].
pub const GAP: f64 = 18.0;
/// Around all \[pixels\].
pub const EDGE: f64 = 28.0;
/// Width of the colour bar \[pixels\].
pub const BAR: f64 = 170.0;
/// Height of the scale bar \[pixels\].
pub const SCALE: f64 = 90.0;
/// Panels on a sheet.
pub const PANELS: usize = 8;

/// The part of the domain that is worth showing: where grains ever are, with room around them.
pub fn shown<const D: usize, const N: usize>(
    stage: &Stage<D, N>,
    states: &[&State<D, N>],
) -> Option<Corners<D>> {
    states.first()?;
    let (lower, upper) = stage.window;
    let (mut low, mut high) = ([f64::MAX; D], [f64::MIN; D]);
    for state in states
        .iter()
        .filter(|state| !state.grain_position.is_empty())
    {
        let (start, end) = stage.grain_bounds(state);
        low = std::array::from_fn(|axis| low[axis].min(start[axis]));
        high = std::array::from_fn(|axis| high[axis].max(end[axis]));
    }
    if low[0] > high[0] {
        return Some((lower, upper));
    }
    // The way down is longer than the cloud is wide.
    let weight = |axis: usize| if axis == 1 { 0.25 } else { 1.0 };
    let extents = (0..D).map(|axis| weight(axis) * (high[axis] - low[axis]));
    let margin = (0.35 * extents.fold(0.0, f64::max)).max(2.0 * stage.widest());
    let low: [f64; D] = std::array::from_fn(|axis| (low[axis] - margin).max(lower[axis]));
    let high: [f64; D] = std::array::from_fn(|axis| (high[axis] + margin).min(upper[axis]));
    let visible = (0..D).all(|axis| low[axis] < high[axis]);
    Some(if visible { (low, high) } else { (lower, upper) })
}

/// Columns, and pixels a unit of `size`, that make the panels largest on a sheet of 1800 × 1050.
pub fn arrange(count: usize, size: [f64; 2]) -> (usize, f64) {
    let scale_of = |columns: usize| {
        let rows = count.div_ceil(columns);
        let across = (1800.0 - columns as f64 * GAP) / columns as f64 / size[0];
        let up = (1050.0 - rows as f64 * (LABEL + GAP)) / rows as f64 / size[1];
        across.min(up)
    };
    // Among equals the fewest columns: rows are then as full as they can be.
    let best = (2..=count).fold(1, |best, columns| {
        if scale_of(columns) > 1.02 * scale_of(best) {
            columns
        } else {
            best
        }
    });
    (best, scale_of(best))
}

/// `count` states at even distances, the first and the last among them.
pub fn spread<'a, State>(states: &[&'a State], count: usize) -> Vec<&'a State> {
    if states.len() <= count {
        return states.to_vec();
    }
    let step = (states.len() - 1) as f64 / (count - 1) as f64;
    (0..count)
        .map(|index| states[(index as f64 * step).round() as usize])
        .collect()
}
