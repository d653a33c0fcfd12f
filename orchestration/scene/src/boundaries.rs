//! Boundary conditions by name: "all" spread over the names that exist, a name going before it.

use std::collections::BTreeMap;

use protocol::scene::{Boundary, Profile};

use crate::check::Checker;
use crate::dimensions::{Cells, sides};
use crate::read::nearest;

/// A condition for each of `names`; refuses unknown names and names without a condition.
pub fn by_name<const D: usize>(
    keys: &BTreeMap<String, Boundary<[f64; D]>>,
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

/// What a rectangle or box adds: periodic sides come in pairs, and what flows in must leave.
pub fn check_box<const D: usize>(
    boundaries: &BTreeMap<String, Boundary>,
    cells: &Cells<D>,
    checker: &mut Checker<'_>,
) {
    for pair in sides::<D>().chunks_exact(2) {
        let periodic = |name| boundaries.get(name) == Some(&Boundary::Periodic);
        for (lonely, partner) in [(pair[0], pair[1]), (pair[1], pair[0])] {
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
    let (net, largest) = net_inflow(boundaries, cells);
    if !open && net.abs() > 1e-12 * largest {
        let power = ["²", "³"][D - 2];
        checker.refuse(
            "fluid.boundaries",
            format!(
                "{net:e} m{power}/s flow in and nothing lets them out: open a boundary \
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

/// Warn of the flattest cell of a rectangle or box.
pub fn warn_of_cells<const D: usize>(cells: &Cells<D>, checker: &mut Checker<'_>) {
    let sizes: [[f64; 2]; D] = std::array::from_fn(|axis| cell_sizes(cells, axis));
    let pairs = (0..D).flat_map(|long| (0..D).map(move |short| (long, short)));
    let aspect = |&(long, short): &(usize, usize)| sizes[long][1] / sizes[short][0];
    let pairs = pairs.filter(|(long, short)| long != short);
    let Some((long, short)) = pairs.max_by(|a, b| aspect(a).total_cmp(&aspect(b))) else {
        return;
    };
    warn_of_aspect(cells.key, aspect(&(long, short)), checker, || {
        let edge = |axis: usize| sizes[axis][usize::from(axis != short)];
        let edges: Vec<String> = (0..D).map(|axis| format!("{:.3e}", edge(axis))).collect();
        format!("a cell of {} m", edges.join(" × "))
    });
}

/// Smallest and largest cell along an axis: cell k from the nearer end has the size s·r^(k/m), m the middle
/// cell, r the grading.
fn cell_sizes<const D: usize>(cells: &Cells<D>, axis: usize) -> [f64; 2] {
    let (count, grading) = (cells.cells[axis], cells.grading[axis]);
    let middle = (count.saturating_sub(1) / 2).max(1) as f64;
    let size = |k: usize| grading.powf(k.min(count - 1 - k) as f64 / middle);
    let sum: f64 = (0..count).map(size).sum();
    let unit = (cells.upper[axis] - cells.lower[axis]) / sum;
    [unit, unit * size(count / 2)]
}

/// A mesh has no opposite sides.
pub fn check_mesh(boundaries: &BTreeMap<String, Boundary>, checker: &mut Checker<'_>) {
    for (name, boundary) in boundaries {
        if *boundary == Boundary::Periodic {
            checker.refuse(
                &format!("fluid.boundaries.{name}"),
                "periodic is for the sides of a rectangle or box, not for a mesh",
            );
        }
    }
}

/// Net inflow \[m²/s, m³/s\] through the sides, and the sum of its absolute parts.
fn net_inflow<const D: usize>(
    boundaries: &BTreeMap<String, Boundary>,
    cells: &Cells<D>,
) -> (f64, f64) {
    let mut net = 0.0;
    let mut largest = 0.0;
    for (side, name) in sides::<D>().iter().enumerate() {
        let (axis, inward) = (side / 2, [1.0, -1.0][side % 2]);
        let others = (0..D).filter(|&other| other != axis);
        let size: f64 = others
            .map(|other| cells.upper[other] - cells.lower[other])
            .product();
        if let Some(Boundary::Inflow { velocity, profile }) = boundaries.get(*name) {
            let flow = mean_of(*profile, D) * size * velocity[axis] * inward;
            net += flow;
            largest += flow.abs();
        }
    }
    (net, largest)
}

/// The mean of a profile, of its maximum: of a parabola two thirds, in space one along each of two directions.
pub fn mean_of(profile: Profile, dimension: usize) -> f64 {
    match (profile, dimension) {
        (Profile::Uniform, _) => 1.0,
        (Profile::Parabolic, 2) => 2.0 / 3.0,
        (Profile::Parabolic, _) => 4.0 / 9.0,
    }
}
