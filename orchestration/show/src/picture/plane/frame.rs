//! One picture of one state: the whole domain, and beside it the grains from near when they take
//! a small part of it.

use super::view::View;
use super::{Stage, State, axes};
use crate::picture::axes::{ColourBar, TEXT, length_unit, round_up, time_label};
use crate::picture::canvas::{Anchor, Canvas};
use crate::picture::colour::{GREY, INK};

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
    let (low, high) = state.central_bounds()?;
    let (lower, upper) = stage.window;
    let extent = (high[0] - low[0]).max(high[1] - low[1]);
    // Round sizes change seldom, so that successive pictures can be compared.
    let side = round_up((1.4 * extent).max(40.0 * stage.widest()));
    if side > 0.5 * (upper[1] - lower[1]) || side > upper[0] - lower[0] {
        return None;
    }
    let start = [0, 1].map(|axis| {
        let start = 0.5 * (low[axis] + high[axis] - side);
        start.clamp(lower[axis], upper[axis] - side)
    });
    Some((start, start.map(|x| x + side)))
}
