//! Boundary conditions by name: "all" spread over the names that exist, a name going before it.

use std::collections::BTreeMap;

use protocol::scene::{Boundary, Profile};

use crate::check::Checker;
use crate::keys::Rectangle;
use crate::read::nearest;

/// Sides of a rectangle: the names of its boundaries.
pub const SIDES: [&str; 4] = ["left", "right", "bottom", "top"];

/// A condition for each of `names`; refuses unknown names and names without a condition.
pub fn by_name(
    keys: &BTreeMap<String, Boundary<[f64; 2]>>,
    names: &[String],
    checker: &mut Checker<'_>,
) -> BTreeMap<String, Boundary> {
    let known: Vec<&str> = names.iter().map(String::as_str).chain(["all"]).collect();
    for name in keys.keys().filter(|name| !known.contains(&name.as_str())) {
        let meant =
            nearest(name, &known).map_or(String::new(), |name| format!("; did you mean {name}?"));
        checker.refuse(
            &format!("fluid.boundaries.{name}"),
            format!(
                "no boundary has this name{meant} (boundaries: {})",
                known.join(", ")
            ),
        );
    }
    if keys.contains_key("all") && names.iter().all(|name| keys.contains_key(name)) {
        checker.refuse(
            "fluid.boundaries.all",
            "every boundary is also named, so \"all\" would apply to none: leave it out",
        );
    }
    let mut boundaries = BTreeMap::new();
    for name in names {
        match keys.get(name).or_else(|| keys.get("all")) {
            Some(boundary) => {
                boundaries.insert(name.clone(), boundary.map(|velocity| velocity.to_vec()));
            }
            None => checker.refuse(
                &format!("fluid.boundaries.{name}"),
                "missing: give this boundary a condition, or write all = \"no-slip\" for the rest",
            ),
        }
    }
    boundaries
}

/// What a rectangle adds: periodic sides come in pairs, and what flows in must leave.
pub fn check_rectangle(
    boundaries: &BTreeMap<String, Boundary>,
    rectangle: &Rectangle,
    checker: &mut Checker<'_>,
) {
    for (one, other) in [("left", "right"), ("bottom", "top")] {
        let periodic = |name| boundaries.get(name) == Some(&Boundary::Periodic);
        for (lonely, partner) in [(one, other), (other, one)] {
            if periodic(lonely) && !periodic(partner) {
                checker.refuse(
                    &format!("fluid.boundaries.{lonely}"),
                    format!("periodic needs its opposite side, {partner}, to be periodic as well"),
                );
            }
        }
    }
    let open = boundaries
        .values()
        .any(|boundary| matches!(boundary, Boundary::Open { .. }));
    let (net, largest) = net_inflow(boundaries, rectangle);
    if !open && net.abs() > 1e-12 * largest {
        checker.refuse(
            "fluid.boundaries",
            format!(
                "{net:e} m²/s flow in and nothing lets them out: open a boundary \
                 ({{ open = {{ pressure = 0.0 }} }}), or balance the inflows"
            ),
        );
    }
}

/// Longest edge over shortest height from which a mesh is told to be too flat.
const ASPECT_MAX: f64 = 50.0;

/// Warn of cells that are too flat; `place` says where the flattest is.
pub fn warn_of_aspect(
    key: &str,
    aspect: f64,
    checker: &mut Checker<'_>,
    place: impl FnOnce() -> String,
) {
    if aspect >= ASPECT_MAX {
        let place = place();
        checker.warn(format!(
            "{key}: {place} is {aspect:.0} times as long as high: the solution may be poor there (below \
             {ASPECT_MAX:.0} is good; more cells along the long side, or less grading)"
        ));
    }
}

/// Warn of the flattest cell of a rectangle.
pub fn warn_of_cells(rectangle: &Rectangle, checker: &mut Checker<'_>) {
    let [x, y] = [0, 1].map(|axis| cell_sizes(rectangle, axis));
    let (wide, high) = (x[1] / y[0], y[1] / x[0]);
    warn_of_aspect("fluid.domain.rectangle", wide.max(high), checker, || {
        let cell = if wide > high {
            [x[1], y[0]]
        } else {
            [x[0], y[1]]
        };
        format!("a cell of {:.3e} × {:.3e} m", cell[0], cell[1])
    });
}

/// Smallest and largest cell along an axis: cell k from the nearer end has the size s·r^(k/m), m the middle
/// cell, r the grading.
fn cell_sizes(rectangle: &Rectangle, axis: usize) -> [f64; 2] {
    let (count, grading) = (rectangle.cells[axis], rectangle.grading[axis]);
    let middle = (count.saturating_sub(1) / 2).max(1) as f64;
    let size = |k: usize| grading.powf(k.min(count - 1 - k) as f64 / middle);
    let sum: f64 = (0..count).map(size).sum();
    let unit = (rectangle.upper[axis] - rectangle.lower[axis]) / sum;
    [unit, unit * size(count / 2)]
}

/// A mesh has no opposite sides.
pub fn check_mesh(boundaries: &BTreeMap<String, Boundary>, checker: &mut Checker<'_>) {
    for (name, boundary) in boundaries {
        if *boundary == Boundary::Periodic {
            checker.refuse(
                &format!("fluid.boundaries.{name}"),
                "periodic is for the sides of a rectangle, not for a mesh",
            );
        }
    }
}

/// Net inflow \[m²/s\] through the sides, and the sum of its absolute parts.
fn net_inflow(boundaries: &BTreeMap<String, Boundary>, rectangle: &Rectangle) -> (f64, f64) {
    let width = rectangle.upper[0] - rectangle.lower[0];
    let height = rectangle.upper[1] - rectangle.lower[1];
    let mut net = 0.0;
    let mut largest = 0.0;
    for (name, inward, length) in [
        ("left", [1.0, 0.0], height),
        ("right", [-1.0, 0.0], height),
        ("bottom", [0.0, 1.0], width),
        ("top", [0.0, -1.0], width),
    ] {
        if let Some(Boundary::Inflow { velocity, profile }) = boundaries.get(name) {
            // The mean of a parabola is two thirds of its maximum.
            let mean = if *profile == Profile::Parabolic {
                2.0 / 3.0
            } else {
                1.0
            };
            let flow = mean * length * (velocity[0] * inward[0] + velocity[1] * inward[1]);
            net += flow;
            largest += flow.abs();
        }
    }
    (net, largest)
}
