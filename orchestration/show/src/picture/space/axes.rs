//! Axes along three edges of a box that nothing hides, and a bar of a round length.

use super::view::View;
use crate::picture::axes::{TEXT, length_unit, number, scale_length, ticks};
use crate::picture::canvas::{Anchor, Canvas};
use crate::picture::colour::INK;
use crate::simplices::{Point, length};

/// Room beside a view for its y axis \[pixels\].
pub const LEFT: f64 = 104.0;
/// Room beside a view for its z axis \[pixels\].
pub const RIGHT: f64 = 60.0;
/// Room below a view for its x axis \[pixels\].
pub const BOTTOM: f64 = 84.0;

/// Axes with ticks along the lower front, the lower right and the left front edge.
pub fn axes(canvas: &mut Canvas, view: &View) {
    let (low, high) = view.sight.shown;
    let extents = (0..3).map(|axis| high[axis] - low[axis]);
    let unit = length_unit(extents.fold(0.0, f64::max));
    let front = [low[0], low[1], high[2]];
    let right = [high[0], low[1], high[2]];
    for (axis, start, label) in [(0, front, "x"), (1, front, "y"), (2, right, "z")] {
        let at = |value: f64| {
            let mut point: Point<3> = start;
            point[axis] = value;
            view.place(point)
        };
        let (from, to) = (at(low[axis]), at(high[axis]));
        let corner = view.place(start);
        let outward = outward(view, from, to);
        let along = length([to[0] - from[0], to[1] - from[1]]);
        let room = if axis == 1 { 60.0 } else { 75.0 };
        let marks = ticks(
            low[axis] / unit.size,
            high[axis] / unit.size,
            (along / room).clamp(1.0, 9.0),
        );
        for mark in marks {
            let foot = at(mark * unit.size);
            // Two axes meet in a corner: one of them has its number there.
            if axis != 1 && length([foot[0] - corner[0], foot[1] - corner[1]]) < 26.0 {
                continue;
            }
            let beside = |pixels: f64| [0, 1].map(|k| foot[k] + pixels * outward[k]);
            canvas.line(foot, beside(7.0), 1.5, INK);
            canvas.text(&number(mark), beside(12.0), TEXT, anchor(outward));
        }
        let away = if axis == 1 { 78.0 } else { 52.0 };
        let middle = [0, 1].map(|k| 0.5 * (from[k] + to[k]) + away * outward[k]);
        let anchor = if axis == 1 {
            Anchor::Upright
        } else {
            anchor(outward)
        };
        canvas.text(&format!("{label} [{}]", unit.name), middle, TEXT, anchor);
    }
}

/// The direction across an edge of a box, away from the middle of its view.
fn outward(view: &View, from: Point<2>, to: Point<2>) -> Point<2> {
    let way = [to[0] - from[0], to[1] - from[1]];
    let size = length(way).max(f64::MIN_POSITIVE);
    let across = [way[1] / size, -way[0] / size];
    let middle = [
        0.5 * (view.left + view.right()),
        0.5 * (view.top + view.bottom()),
    ];
    let away = (0..2).map(|k| across[k] * (0.5 * (from[k] + to[k]) - middle[k]));
    if away.sum::<f64>() < 0.0 {
        across.map(|x| -x)
    } else {
        across
    }
}

/// How text sits that must keep off what lies against this direction.
fn anchor(outward: Point<2>) -> Anchor {
    match outward {
        [x, _] if x < -0.7 => Anchor::Right,
        [x, _] if x > 0.4 => Anchor::Left,
        _ => Anchor::Below,
    }
}

/// A bar of a round length along x, below the lower front edge of a view.
pub fn scale_bar(canvas: &mut Canvas, view: &View) {
    let (low, high) = view.sight.shown;
    let (round, label) = scale_length(high[0] - low[0]);
    let below = |x: f64| {
        let [right, down] = view.place([x, low[1], high[2]]);
        [right, down + 22.0]
    };
    let (from, to) = (below(low[0]), below(low[0] + round));
    canvas.line(from, to, 4.0, INK);
    canvas.text(
        &label,
        [0.5 * (from[0] + to[0]), to[1] + 8.0],
        TEXT,
        Anchor::Below,
    );
}
