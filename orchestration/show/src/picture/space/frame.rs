//! One picture of one state: the whole domain, and beside it the grains from near when they take
//! a small part of it.

use super::axes::{self, BOTTOM, LEFT, RIGHT};
use super::view::{Sight, View, cut_level};
use super::{Stage, State};
use crate::picture::axes::{ColourBar, TEXT, length_unit, number, round_up, time_label};
use crate::picture::canvas::{Anchor, Canvas};
use crate::picture::colour::GREY;
use crate::simplices::Corners;

const TITLE: f64 = 70.0;
const BAR: f64 = 150.0;

/// Draw a state; `speed_max` is the speed of the deepest colour.
pub fn frame(stage: &Stage, state: &State, speed_max: f64) -> Canvas {
    let whole = Sight::of(stage.window);
    let near = near_box(stage, state);
    let aspect = |sight: &Sight| sight.size()[0] / sight.size()[1];
    let wide = aspect(&whole) + near.map(Sight::of).as_ref().map_or(0.0, aspect);
    let height = (1400.0 / wide).min(880.0);
    let view = |sight: Sight, left: f64| View {
        sight,
        left,
        top: TITLE,
        scale: height / sight.size()[1],
    };
    let whole = view(whole, LEFT);
    let close = near.map(|near| view(Sight::of(near), whole.right() + RIGHT + LEFT));
    let right = close.as_ref().map_or(whole.right(), View::right) + RIGHT;
    let width = (right + BAR).max(640.0);
    let mut canvas = Canvas::new(
        width.ceil() as usize,
        (TITLE + height + BOTTOM).ceil() as usize,
    );
    whole.draw(&mut canvas, stage, state, speed_max, near);
    axes::axes(&mut canvas, &whole);
    if let Some(close) = &close {
        close.draw(&mut canvas, stage, state, speed_max, None);
        axes::axes(&mut canvas, close);
        connect(&mut canvas, &whole, close);
    }
    ColourBar::of(stage.mesh.is_some(), speed_max).draw(&mut canvas, right, TITLE, height);
    let title = format!(
        "{}    {}{}",
        stage.name.replace('-', " "),
        time_label(state.time),
        cut_label(stage, state)
    );
    canvas.text(&title, [LEFT, 36.0], 1.35 * TEXT, Anchor::Left);
    canvas
}

/// Which plane the speed is shown on.
fn cut_label(stage: &Stage, state: &State) -> String {
    if state.flow(stage).is_none() {
        return String::new();
    }
    let (lower, upper) = stage.window;
    let unit = length_unit(upper[2] - lower[2]);
    let level = (cut_level(stage, state) / unit.size * 100.0).round() / 100.0;
    format!("    plane at z = {} {}", number(level), unit.name)
}

/// What connects the near view to the box that it shows.
fn connect(canvas: &mut Canvas, whole: &View, near: &View) {
    let (low, high) = near.sight.shown;
    for y in [low[1], high[1]] {
        let from = whole.place([high[0], y, low[2]]);
        let to = near.place([low[0], y, high[2]]);
        canvas.line(from, to, 1.0, GREY);
    }
}

/// A cube around the grains, when it shows them at least twice as large.
fn near_box(stage: &Stage, state: &State) -> Option<Corners<3>> {
    let (low, high) = state.central_bounds()?;
    let (lower, upper) = stage.window;
    let extents = (0..3).map(|axis| high[axis] - low[axis]);
    // Round sizes change seldom, so that successive pictures can be compared.
    let side = round_up((1.4 * extents.fold(0.0, f64::max)).max(40.0 * stage.widest()));
    let fits = (0..3).all(|axis| side <= upper[axis] - lower[axis]);
    if side > 0.5 * (upper[1] - lower[1]) || !fits {
        return None;
    }
    let start: [f64; 3] = std::array::from_fn(|axis| {
        let start = 0.5 * (low[axis] + high[axis] - side);
        start.clamp(lower[axis], upper[axis] - side)
    });
    Some((start, start.map(|x| x + side)))
}
