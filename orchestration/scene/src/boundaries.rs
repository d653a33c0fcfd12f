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
