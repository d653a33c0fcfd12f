//! A contact sheet of several states of a run, with one scale of colours.

use super::view::{Sight, View};
use super::{Stage, State, axes};
use crate::picture::axes::{ColourBar, TEXT, round_up, time_label};
use crate::picture::canvas::{Anchor, Canvas};
use crate::picture::sheet::{BAR, EDGE, GAP, LABEL, PANELS, SCALE, arrange, shown, spread};

/// Draw the states side by side; none when there is nothing to show.
pub fn overview(stage: &Stage, states: &[&State]) -> Option<Canvas> {
    let chosen = spread(states, PANELS);
    let sight = Sight::of(shown(stage, &chosen)?);
    let (columns, scale) = arrange(chosen.len(), sight.size());
    let rows = chosen.len().div_ceil(columns);
    let [width, height] = sight.size().map(|size| size * scale);
    let sheet_width = 2.0 * EDGE + columns as f64 * (width + GAP) + BAR;
    let sheet_height =
        2.0 * EDGE + SCALE + rows as f64 * (height + LABEL) + (rows - 1) as f64 * GAP;
    let mut canvas = Canvas::new(sheet_width.ceil() as usize, sheet_height.ceil() as usize);
    let speeds = chosen.iter().map(|state| state.speed_max());
    let speed_max = round_up(speeds.fold(0.0, f64::max));
    for (index, state) in chosen.iter().enumerate() {
        let view = View {
            sight,
            left: EDGE + (index % columns) as f64 * (width + GAP),
            top: EDGE + LABEL + (index / columns) as f64 * (height + LABEL + GAP),
            scale,
        };
        view.draw(&mut canvas, stage, state, speed_max, None);
        let middle = [view.left + 0.5 * width, view.top - 10.0];
        canvas.text(&time_label(state.time), middle, TEXT, Anchor::Above);
        if index + 1 == chosen.len() {
            axes::scale_bar(&mut canvas, &view);
        }
    }
    let bar_left = EDGE + columns as f64 * (width + GAP) + 10.0;
    let bar_height = (sheet_height - 2.0 * EDGE - LABEL - SCALE).min(700.0);
    let bar = ColourBar::of(stage.mesh.is_some(), speed_max);
    bar.draw(&mut canvas, bar_left, EDGE + LABEL, bar_height);
    Some(canvas)
}
