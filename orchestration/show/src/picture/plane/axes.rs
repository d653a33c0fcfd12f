//! Axes and the scale bar of a view.

use super::view::View;
use crate::picture::axes::{TEXT, Unit, number, scale_length, ticks};
use crate::picture::canvas::{Anchor, Canvas};
use crate::picture::colour::INK;

/// Axes with ticks along the left and the lower edge of a view.
pub fn axes(canvas: &mut Canvas, view: &View, unit: Unit) {
    view.outline(canvas, 1.5, INK);
    let ([left, low], [right, high]) = (view.lower, view.upper);
    // Few enough that the numbers of a narrow picture do not touch.
    let across = ticks(
        left / unit.size,
        right / unit.size,
        (view.width() / 75.0).clamp(2.0, 9.0),
    );
    for x in across {
        let at = view.place([x * unit.size, low]);
        canvas.line(at, [at[0], at[1] + 7.0], 1.5, INK);
        canvas.text(&number(x), [at[0], at[1] + 11.0], TEXT, Anchor::Below);
    }
    for y in ticks(
        low / unit.size,
        high / unit.size,
        (view.height() / 60.0).clamp(1.0, 9.0),
    ) {
        let at = view.place([left, y * unit.size]);
        canvas.line(at, [at[0] - 7.0, at[1]], 1.5, INK);
        canvas.text(&number(y), [at[0] - 11.0, at[1]], TEXT, Anchor::Right);
    }
    let middle = 0.5 * (view.left + view.right());
    canvas.text(
        &format!("x [{}]", unit.name),
        [middle, view.bottom() + 38.0],
        TEXT,
        Anchor::Below,
    );
    let middle = 0.5 * (view.top + view.bottom());
    canvas.text(
        &format!("y [{}]", unit.name),
        [view.left - 78.0, middle],
        TEXT,
        Anchor::Upright,
    );
}

/// A bar of a round length under a view, where it hides nothing; it ends at the view's right edge.
pub fn scale_bar(canvas: &mut Canvas, view: &View) {
    let (length, label) = scale_length(view.upper[0] - view.lower[0]);
    let pixels = length * view.scale;
    let (right, level) = (view.right() - 2.0, view.bottom() + 84.0);
    canvas.line([right - pixels, level], [right, level], 4.0, INK);
    canvas.text(&label, [right - pixels - 12.0, level], TEXT, Anchor::Right);
}
