//! One picture of one state: the whole domain, and beside it the grains from near when they take
//! a small part of it.

use super::axes::{self, ColourBar, TEXT, length_unit, round_up};
use super::canvas::{Anchor, Canvas};
use super::colour::{GREY, INK};
use super::state::{Stage, State};
use super::view::View;

const TITLE: f64 = 70.0;
const LEFT: f64 = 104.0;
const BOTTOM: f64 = 104.0;
const BAR: f64 = 150.0;
const GAP: f64 = 36.0;

/// Draw a state; `speed_max` is the speed of the deepest colour.
pub fn frame(stage: &Stage, state: &State, speed_max: f64) -> Canvas {
    let (lower, upper) = stage.window;
    let aspect = (upper[0] - lower[0]) / (upper[1] - lower[1]);
    let near = near_window(stage, state);
    // The near view is a square as high as the whole.
    let wide = aspect + if near.is_some() { 1.0 } else { 0.0 };
    let height = (1400.0 / wide).min(880.0);
    let whole = View {
        lower,
        upper,
        left: LEFT,
        top: TITLE,
        scale: height / (upper[1] - lower[1]),
    };
    let near = near.map(|(low, high)| View {
        lower: low,
        upper: high,
        left: whole.right() + GAP,
        top: TITLE,
        scale: height / (high[1] - low[1]),
    });
    let right = near.as_ref().map_or(whole.right(), View::right);
    let width = (right + GAP + BAR).max(560.0);
    let mut canvas = Canvas::new(
        width.ceil() as usize,
        (TITLE + height + BOTTOM).ceil() as usize,
    );
    whole.draw(&mut canvas, stage, state, speed_max);
    if let Some(near) = &near {
        near.draw(&mut canvas, stage, state, speed_max);
        mark(&mut canvas, &whole, near);
        near.outline(&mut canvas, 1.5, INK);
        axes::scale_bar(&mut canvas, near);
    } else {
        axes::scale_bar(&mut canvas, &whole);
    }
    let extent = (upper[0] - lower[0]).max(upper[1] - lower[1]);
    axes::axes(&mut canvas, &whole, length_unit(extent));
    ColourBar::of(stage.mesh.is_some(), speed_max).draw(&mut canvas, right + GAP, TITLE, height);
    let title = format!(
        "{}    {}",
        stage.name.replace('-', " "),
        time_label(state.time)
    );
    canvas.text(&title, [LEFT, 36.0], 1.35 * TEXT, Anchor::Left);
    canvas
}

/// "t = 0.055 s", or in ms when the time is short.
pub fn time_label(time: f64) -> String {
    if time > 0.0 && time < 0.01 {
        return format!("t = {:.3} ms", 1e3 * time);
    }
    format!("t = {time:.3} s")
}

/// The rectangle of the near view in the whole one, and what connects them.
fn mark(canvas: &mut Canvas, whole: &View, near: &View) {
    let corner = |x: f64, y: f64| {
        let inside = [
            x.clamp(whole.lower[0], whole.upper[0]),
            y.clamp(whole.lower[1], whole.upper[1]),
        ];
        whole.place(inside)
    };
    let ([left, low], [right, high]) = (near.lower, near.upper);
    let corners = [
        corner(left, low),
        corner(right, low),
        corner(right, high),
        corner(left, high),
    ];
    for side in 0..4 {
        canvas.line(corners[side], corners[(side + 1) % 4], 1.5, INK);
    }
    canvas.line(corners[2], [near.left, near.top], 1.0, GREY);
    canvas.line(corners[1], [near.left, near.bottom()], 1.0, GREY);
}

/// A square around the grains, when it shows them at least twice as large.
fn near_window(stage: &Stage, state: &State) -> Option<([f64; 2], [f64; 2])> {
    if state.grain_position.is_empty() {
        return None;
    }
    let (low, high) = central_bounds(state);
    let (lower, upper) = stage.window;
    let extent = (high[0] - low[0]).max(high[1] - low[1]);
    let radius = stage.grain_radius.iter().copied().fold(0.0, f64::max);
    // Round sizes change seldom, so that successive pictures can be compared.
    let side = round_up((1.4 * extent).max(40.0 * radius));
    if side > 0.5 * (upper[1] - lower[1]) || side > upper[0] - lower[0] {
        return None;
    }
    let start = [0, 1].map(|axis| {
        let start = 0.5 * (low[axis] + high[axis] - side);
        start.clamp(lower[axis], upper[axis] - side)
    });
    Some((start, start.map(|x| x + side)))
}

/// Bounds of the grains without the outermost percent, which a long tail would stretch.
fn central_bounds(state: &State) -> ([f64; 2], [f64; 2]) {
    let mut low = [0.0; 2];
    let mut high = [0.0; 2];
    for axis in 0..2 {
        let mut along: Vec<f64> = state
            .grain_position
            .iter()
            .map(|position| f64::from(position[axis]))
            .collect();
        along.sort_by(f64::total_cmp);
        let skipped = along.len() / 100;
        low[axis] = along[skipped];
        high[axis] = along[along.len() - 1 - skipped];
    }
    (low, high)
}
