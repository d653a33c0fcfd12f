//! A contact sheet of several states of a run, with one scale of colours.

use scene::Error;
use serde::{Deserialize, Serialize};

use super::axes::{self, ColourBar, TEXT, round_up};
use super::canvas::{Anchor, Canvas};
use super::colour::INK;
use super::frame::time_label;
use super::state::{Stage, State};
use super::view::View;

const LABEL: f64 = 44.0;
const GAP: f64 = 18.0;
const EDGE: f64 = 28.0;
const BAR: f64 = 170.0;
const SCALE: f64 = 90.0;
/// Panels on a sheet.
pub const PANELS: usize = 8;

/// Draw the states side by side; none when there is nothing to show.
pub fn overview(stage: &Stage, states: &[&State]) -> Option<Canvas> {
    let chosen = spread(states, PANELS);
    let (lower, upper) = shown(stage, &chosen)?;
    let size = [upper[0] - lower[0], upper[1] - lower[1]];
    let (columns, scale) = arrange(chosen.len(), size);
    let rows = chosen.len().div_ceil(columns);
    let (width, height) = (size[0] * scale, size[1] * scale);
    let sheet_width = 2.0 * EDGE + columns as f64 * (width + GAP) + BAR;
    let sheet_height =
        2.0 * EDGE + SCALE + rows as f64 * (height + LABEL) + (rows - 1) as f64 * GAP;
    let mut canvas = Canvas::new(sheet_width.ceil() as usize, sheet_height.ceil() as usize);
    let speed_max = round_up(
        chosen
            .iter()
            .map(|state| state.speed_max())
            .fold(0.0, f64::max),
    );
    for (index, state) in chosen.iter().enumerate() {
        let left = EDGE + (index % columns) as f64 * (width + GAP);
        let top = EDGE + LABEL + (index / columns) as f64 * (height + LABEL + GAP);
        let view = View {
            lower,
            upper,
            left,
            top,
            scale,
        };
        view.draw(&mut canvas, stage, state, speed_max);
        view.outline(&mut canvas, 1.5, INK);
        let middle = left + 0.5 * width;
        canvas.text(
            &time_label(state.time),
            [middle, top - 10.0],
            TEXT,
            Anchor::Above,
        );
        if index + 1 == chosen.len() {
            axes::scale_bar(&mut canvas, &view);
        }
    }
    let bar_left = EDGE + columns as f64 * (width + GAP) + 10.0;
    let bar_height = (sheet_height - 2.0 * EDGE - LABEL - SCALE).min(700.0);
    ColourBar::of(stage.mesh.is_some(), speed_max).draw(
        &mut canvas,
        bar_left,
        EDGE + LABEL,
        bar_height,
    );
    Some(canvas)
}

/// The part of the domain that is worth showing: where grains ever are, with room around them.
fn shown(stage: &Stage, states: &[&State]) -> Option<([f64; 2], [f64; 2])> {
    states.first()?;
    let (lower, upper) = stage.window;
    let mut low = [f64::MAX; 2];
    let mut high = [f64::MIN; 2];
    for state in states
        .iter()
        .filter(|state| !state.grain_position.is_empty())
    {
        let (start, end) = stage.grain_bounds(state);
        low = [low[0].min(start[0]), low[1].min(start[1])];
        high = [high[0].max(end[0]), high[1].max(end[1])];
    }
    if low[0] > high[0] {
        return Some((lower, upper));
    }
    let widest = stage.grain_radius.iter().copied().fold(0.0, f64::max);
    let margin = 0.35 * (high[0] - low[0]).max(0.25 * (high[1] - low[1]));
    let margin = margin.max(2.0 * widest);
    let clipped_low = [0, 1].map(|axis| (low[axis] - margin).max(lower[axis]));
    let clipped_high = [0, 1].map(|axis| (high[axis] + margin).min(upper[axis]));
    let visible = (0..2).all(|axis| clipped_low[axis] < clipped_high[axis]);
    Some(if visible {
        (clipped_low, clipped_high)
    } else {
        (lower, upper)
    })
}

/// Columns and pixels a metre that make the panels largest on a sheet of 1800 × 1050.
fn arrange(count: usize, size: [f64; 2]) -> (usize, f64) {
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
fn spread<'a>(states: &[&'a State], count: usize) -> Vec<&'a State> {
    if states.len() <= count {
        return states.to_vec();
    }
    let step = (states.len() - 1) as f64 / (count - 1) as f64;
    (0..count)
        .map(|index| states[(index as f64 * step).round() as usize])
        .collect()
}

/// States kept for the sheet: at most twice `PANELS` and a few, always evenly spread.
#[derive(Debug, Default)]
pub struct Album {
    kept: Vec<State>,
    last: Option<State>,
    stride: usize,
    seen: usize,
}

/// Which states an album has.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Shown {
    stride: usize,
    seen: usize,
}

impl Album {
    /// Which states it has.
    pub fn shown(&self) -> Shown {
        Shown {
            stride: self.stride.max(1),
            seen: self.seen,
        }
    }

    /// The album of these states, each by its number.
    pub fn again(
        shown: Shown,
        state: impl Fn(usize) -> Result<State, Error>,
    ) -> Result<Album, Error> {
        let Shown { stride, seen } = shown;
        let numbers = (0..seen).step_by(stride.max(1));
        let last = seen.checked_sub(1).filter(|last| last % stride.max(1) != 0);
        Ok(Album {
            kept: numbers.map(&state).collect::<Result<_, _>>()?,
            last: last.map(&state).transpose()?,
            stride,
            seen,
        })
    }

    /// Keep a state, or drop every second one when there are too many.
    pub fn add(&mut self, state: State) {
        let stride = self.stride.max(1);
        if self.seen.is_multiple_of(stride) {
            self.kept.push(state);
            self.last = None;
        } else {
            self.last = Some(state);
        }
        self.seen += 1;
        // An odd number stays even in time when every second one goes.
        if self.kept.len() > 4 * PANELS {
            let mut index = 0;
            self.kept.retain(|_| {
                index += 1;
                index % 2 == 1
            });
            self.stride = 2 * stride;
        }
    }

    /// The states kept, and the last one in any case.
    pub fn states(&self) -> Vec<&State> {
        self.kept.iter().chain(&self.last).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::colour::GRAIN;

    #[test]
    fn one_grain_at_rest_lies_whole_within_each_panel() {
        let mut stage = Stage::new("rest", None, &[], vec![1e-3], vec![false]);
        stage.mesh = crate::plane::Triangles::of(run::vtu::mesh::Mesh {
            dimension: 2,
            points: vec![0.0, 0.0, 1.0, 0.0, 0.0, 1.0],
            node_of: vec![0, 1, 2],
            corners: vec![0, 1, 2],
            node_count: 3,
        });
        stage.window = ([0.0; 2], [1.0; 2]);
        let state = |time: f64| State {
            time,
            grain_position: vec![[0.3, 0.3]],
            grain_speed: vec![0.0],
            grain_id: Vec::new(),
            ..State::default()
        };
        let states = [state(0.0), state(1.0)];
        let (low, high) = shown(&stage, &[&states[0], &states[1]]).expect("something");
        println!("{low:?} {high:?}");
        assert!(low[0] <= 0.3 - 2.9e-3 && high[0] >= 0.3 + 2.9e-3);
        let begun = std::time::Instant::now();
        let mut sheet = overview(&stage, &[&states[0], &states[1]]).expect("a sheet");
        assert!(begun.elapsed() < std::time::Duration::from_secs(5));
        let width = sheet.width;
        let inked = |pixel: &[u8]| pixel == GRAIN;
        let rows = sheet.pixels_mut().chunks_exact(3 * width);
        // seen from left to right: paper, grain, paper, grain, paper
        let changes = rows.map(|row| {
            let row: Vec<bool> = row.chunks_exact(3).map(inked).collect();
            row.windows(2).filter(|pair| pair[0] != pair[1]).count()
        });
        assert_eq!(changes.max(), Some(4));
    }
}
