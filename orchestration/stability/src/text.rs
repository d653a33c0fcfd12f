//! Tables of a scene file, as text.

use crate::dimension::Dimension;
use crate::limits::{Law, Shape, Suspension};

pub(crate) const PERIODIC: &str = "\"periodic\"";
pub(crate) const SLIP: &str = "\"slip\"";

/// A rectangle of fluid, or a box with a square floor.
pub(crate) struct Domain {
    pub dimension: Dimension,
    pub width: f64,
    pub height: f64,
    /// across, up
    pub cells: [usize; 2],
    /// those across, bottom, top
    pub sides: [&'static str; 3],
}

pub(crate) fn fluid(mixture: &Suspension, domain: &Domain, initial: f64) -> String {
    let Domain {
        dimension,
        width,
        height,
        cells: [columns, rows],
        sides: [side, bottom, top],
    } = domain;
    let corners = format!(
        "lower = {}, upper = {}, cells = {}",
        dimension.place(0.0, 0.0),
        dimension.place(*width, *height),
        dimension.vector(columns, rows)
    );
    let (mesh, others) = match dimension {
        Dimension::Plane => (
            format!("rectangle = {{ {corners}, diagonals = \"uniform\" }}"),
            String::new(),
        ),
        Dimension::Space => (
            format!("box = {{ {corners} }}"),
            format!("back = {side}\nfront = {side}\n"),
        ),
    };
    format!(
        "[fluid]\ndensity = {:e}\ndynamic_viscosity = {:e}\ninitial_velocity = {}\n\
         [fluid.domain]\n{mesh}\n\
         [fluid.boundaries]\nleft = {side}\nright = {side}\nbottom = {bottom}\ntop = {top}\n{others}",
        mixture.density,
        mixture.viscosity,
        dimension.place(0.0, initial),
    )
}

/// A side through which the fluid comes in at this velocity upward.
pub(crate) fn inflow(dimension: Dimension, speed: f64) -> String {
    let velocity = dimension.place(0.0, speed);
    format!("{{ inflow = {{ velocity = {velocity}, profile = \"uniform\" }} }}")
}

pub(crate) fn run(dimension: Dimension, step: f64, steps: usize, gravity: f64) -> String {
    format!(
        "[run]\nend_time = {:e}\ncoupling_step = {step:e}\n[gravity]\nacceleration = {}\n",
        step * steps as f64,
        dimension.place(0.0, -gravity),
    )
}

pub(crate) fn coupling(mixture: &Suspension) -> String {
    let law = match mixture.law {
        Law::Stokes => "stokes",
        Law::Dallavalle => "dallavalle",
    };
    let geometry = match mixture.shape {
        Shape::Disk => "geometry = \"disk\"\n".into(),
        // A slab that may be written; a thinner one is set on the scene that was read (`Case::thin_slab`).
        Shape::SphereInSlab { depth } => {
            let depth = depth.max(2.0 * mixture.radius);
            format!("geometry = {{ sphere = {{ depth = {depth:e} }} }}\n")
        }
        Shape::Sphere => String::new(),
    };
    format!("[contact]\ntolerance = 1e-3\n[coupling]\ndrag = \"{law}\"\n{geometry}")
}

/// Density, radius and velocity of a population, without its places.
pub(crate) fn population(dimension: Dimension, mixture: &Suspension, speed: f64) -> String {
    format!(
        "[[grains]]\ndensity = {:e}\nradius = {:e}\nvelocity = {}\n",
        mixture.grain_density,
        mixture.radius,
        dimension.place(0.0, speed),
    )
}

/// A square or cubic lattice between two corners (across, up).
pub(crate) fn lattice(dimension: Dimension, [lower, upper]: [[f64; 2]; 2], spacing: f64) -> String {
    format!(
        "lattice = {{ lower = {}, upper = {}, spacing = {spacing:e} }}\n",
        dimension.place(lower[0], lower[1]),
        dimension.place(upper[0], upper[1]),
    )
}

/// Spheres at the corners and at the middles of the faces of cubes of this edge: four cubic lattices, each a
/// population. The lowest and the highest layer are a quarter of an edge from the floor and the lid; half of one where
/// that is too little for a sphere, with a layer less.
pub(crate) fn face_centred(
    population: &str,
    [width, height]: [f64; 2],
    edge: f64,
    radius: f64,
) -> String {
    let quarter = 0.25 * edge;
    let (floors, lids) = match radius > quarter {
        true => ([0.0, 0.5 * edge], [height, height - 0.5 * edge]),
        false => ([-quarter, quarter], [height - quarter, height + quarter]),
    };
    // By layer, and by the shifts of its two lattices along x and z.
    let lattices = [
        (0, -quarter, -quarter),
        (0, quarter, quarter),
        (1, quarter, -quarter),
        (1, -quarter, quarter),
    ];
    lattices
        .map(|(layer, x, z)| {
            let (floor, lid) = (floors[layer], lids[layer]);
            format!(
                "{population}lattice = {{ lower = [{x:e}, {floor:e}, {z:e}], \
                 upper = [{:e}, {lid:e}, {:e}], spacing = {edge:e} }}\n",
                width + x,
                width + z,
            )
        })
        .concat()
}
