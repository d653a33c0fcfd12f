//! What a scene has of its own in the plane and in space; everything else is written once.

use std::f64::consts::PI;
use std::path::Path;

use gmsh::Options;
use protocol::scene::{Diagonals, Geometry, MeshSource};
use space::{Dim, Dimension, Vector, dot, hypot};

use crate::flat_walls::{polygon, tube};
use crate::keys::{Coupling, Domain, Pattern, WallKeys};
use crate::mesh::Mesh;

/// Names of the sides of a box, two an axis; a rectangle has the first four.
const SIDES: [&str; 6] = ["left", "right", "bottom", "top", "back", "front"];
/// Names of the axes.
pub const AXES: [&str; 3] = ["x", "y", "z"];

/// Names of the boundaries of a rectangle or box, two an axis.
pub fn sides<const D: usize>() -> &'static [&'static str] {
    &SIDES[..2 * D]
}

/// The axes that a scene has, with their names.
pub fn axes<const D: usize>() -> impl Iterator<Item = (usize, &'static str)> {
    AXES.into_iter().take(D).enumerate()
}

/// A point in words: (x, y) or (x, y, z).
pub fn words(point: &[f64]) -> String {
    let numbers: Vec<String> = point.iter().map(|x| format!("{x:e}")).collect();
    format!("({})", numbers.join(", "))
}

/// Does a velocity lead along a boundary with this normal, but for round-off?
pub fn is_along<const D: usize>(velocity: &[f64; D], normal: &Vector<D>) -> bool {
    let velocity = Vector::from(*velocity);
    dot(&velocity, normal).abs() <= 1e-6 * hypot(&velocity)
}

/// A rectangle or box of cells.
#[derive(Debug, Clone, PartialEq)]
pub struct Cells<const D: usize> {
    /// Its key.
    pub key: &'static str,
    /// Lower corner \[m\].
    pub lower: [f64; D],
    /// Upper corner \[m\].
    pub upper: [f64; D],
    /// Cells along each axis.
    pub cells: [usize; D],
    /// Ratio of the largest to the smallest cell along each axis.
    pub grading: [f64; D],
    /// How cells are cut, where that can be chosen.
    pub diagonals: Option<Diagonals>,
}

/// Corners of a flat wall or facet.
pub type Corners<const D: usize> = [[f64; D]; D];

/// What is of one dimension only.
pub trait Scenic<const D: usize>: Dimension<D> {
    /// What its grains are.
    const GRAINS: &'static str;
    /// What the content of a domain is called.
    const CONTENT: &'static str;
    /// Solid fraction of the densest packing of equal grains.
    const DENSEST: f64;
    /// Solid fraction above which random placing of equal grains becomes hopeless (disks jam at 0.547, spheres
    /// at 0.384).
    const RANDOM_FRACTION_MAX: f64;

    /// Content of a grain \[m^D\].
    fn grain(radius: f64) -> f64;

    /// Its mean over radii that are uniformly distributed between two.
    fn mean_grain(low: f64, high: f64) -> f64;

    /// A point of a ball, every content with the same chance, from uniform numbers of [0, 1).
    fn in_ball(centre: &[f64; D], radius: f64, unit: impl FnMut() -> f64) -> [f64; D];

    /// The cells of a scene's domain.
    fn cells(domain: &Domain) -> Option<Cells<D>>;

    /// As the fluid engine takes them.
    fn mesh(cells: &Cells<D>) -> MeshSource;

    /// The mesh of a file.
    fn read_mesh(path: &Path, options: &Options) -> Result<Mesh<D>, gmsh::Error>;

    /// A side of a box as facets; what is inside is on their left, in space where they are seen clockwise.
    fn side(lower: &[f64; D], upper: &[f64; D], side: usize) -> Vec<Corners<D>>;

    /// A wall of a scene as facets; an error names the key within it.
    fn wall(keys: &WallKeys<D>) -> Result<Vec<Corners<D>>, (&'static str, String)>;

    /// Does the ray from a point along x pass through a facet?
    fn is_ahead(facet: &Corners<D>, point: &[f64; D]) -> bool;

    /// Distance between neighbours of a lattice along an axis, of the distance between two.
    fn pitch(pattern: Pattern, axis: usize) -> f64;

    /// How far a point of a lattice is shifted, by its number along each axis, in pitches.
    fn shift(pattern: Pattern, number: &[usize; D]) -> [f64; D];

    /// What a grain is.
    fn geometry(coupling: Option<&Coupling>) -> Geometry;
}

impl Scenic<2> for Dim<2> {
    const GRAINS: &'static str = "disks";
    const CONTENT: &'static str = "area";
    const DENSEST: f64 = 0.9069;
    const RANDOM_FRACTION_MAX: f64 = 0.5;

    fn grain(radius: f64) -> f64 {
        PI * radius * radius
    }

    fn mean_grain(low: f64, high: f64) -> f64 {
        PI * (low * low + low * high + high * high) / 3.0
    }

    fn in_ball(centre: &[f64; 2], radius: f64, mut unit: impl FnMut() -> f64) -> [f64; 2] {
        // Area grows with the square of the distance.
        let distance = radius * unit().sqrt();
        let angle = 2.0 * PI * unit();
        [
            centre[0] + distance * angle.cos(),
            centre[1] + distance * angle.sin(),
        ]
    }

    fn cells(domain: &Domain) -> Option<Cells<2>> {
        let rectangle = domain.rectangle.as_ref()?;
        Some(Cells {
            key: "fluid.domain.rectangle",
            lower: rectangle.lower,
            upper: rectangle.upper,
            cells: rectangle.cells,
            grading: rectangle.grading,
            diagonals: Some(rectangle.diagonals),
        })
    }

    fn mesh(cells: &Cells<2>) -> MeshSource {
        MeshSource::Rectangle {
            lower: cells.lower.to_vec(),
            upper: cells.upper.to_vec(),
            cells: cells.cells.to_vec(),
            diagonals: cells.diagonals.unwrap_or(Diagonals::Alternate),
            grading: cells.grading.to_vec(),
        }
    }

    fn read_mesh(path: &Path, options: &Options) -> Result<Mesh<2>, gmsh::Error> {
        gmsh::Mesh::<2, 3>::read(path, options).map(|mesh| Mesh::of(&mesh))
    }

    fn side(lower: &[f64; 2], upper: &[f64; 2], side: usize) -> Vec<Corners<2>> {
        let ([left, bottom], [right, top]) = (*lower, *upper);
        vec![match side {
            0 => [[left, top], [left, bottom]],
            1 => [[right, bottom], [right, top]],
            2 => [[left, bottom], [right, bottom]],
            _ => [[right, top], [left, top]],
        }]
    }

    fn wall(keys: &WallKeys<2>) -> Result<Vec<Corners<2>>, (&'static str, String)> {
        match (keys.from.map(|end| end.0), keys.to.map(|end| end.0)) {
            _ if !keys.corners.is_empty() => Err((
                "corners",
                "is of space: in the plane write from and to".to_owned(),
            )),
            _ if keys.cylinder.is_some() => Err(("cylinder", "is of space".to_owned())),
            (Some(from), Some(to)) if from != to => Ok(vec![[from, to]]),
            (Some(_), Some(_)) => Err(("to", "must differ from the start, `from`".to_owned())),
            (Some(_), None) => Err(("to", "missing, and it has no default (m)".to_owned())),
            (None, _) => Err(("from", "missing, and it has no default (m)".to_owned())),
        }
    }

    fn is_ahead([a, b]: &Corners<2>, [x, y]: &[f64; 2]) -> bool {
        (a[1] > *y) != (b[1] > *y) && *x < a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
    }

    fn pitch(pattern: Pattern, axis: usize) -> f64 {
        match (pattern, axis) {
            (Pattern::Hexagonal, 1) => 0.75_f64.sqrt(),
            _ => 1.0,
        }
    }

    fn shift(pattern: Pattern, number: &[usize; 2]) -> [f64; 2] {
        match pattern {
            Pattern::Square | Pattern::Cubic => [0.0; 2],
            Pattern::Hexagonal => [0.5 * (number[1] % 2) as f64, 0.0],
        }
    }

    fn geometry(coupling: Option<&Coupling>) -> Geometry {
        coupling.and_then(|c| c.geometry).unwrap_or(Geometry::Disk)
    }
}

impl Scenic<3> for Dim<3> {
    const GRAINS: &'static str = "spheres";
    const CONTENT: &'static str = "volume";
    const DENSEST: f64 = 0.7405;
    const RANDOM_FRACTION_MAX: f64 = 0.35;

    fn grain(radius: f64) -> f64 {
        4.0 / 3.0 * PI * radius.powi(3)
    }

    fn mean_grain(low: f64, high: f64) -> f64 {
        PI / 3.0 * (low + high) * (low * low + high * high)
    }

    fn in_ball(centre: &[f64; 3], radius: f64, mut unit: impl FnMut() -> f64) -> [f64; 3] {
        // Volume grows with the cube of the distance, the area of a sphere with height along an axis.
        let distance = radius * unit().cbrt();
        let height = 2.0 * unit() - 1.0;
        let angle = 2.0 * PI * unit();
        let across = (1.0 - height * height).sqrt();
        let direction = [across * angle.cos(), height, across * angle.sin()];
        std::array::from_fn(|axis| centre[axis] + distance * direction[axis])
    }

    fn cells(domain: &Domain) -> Option<Cells<3>> {
        let cells = domain.cells.as_ref()?;
        Some(Cells {
            key: "fluid.domain.box",
            lower: cells.lower,
            upper: cells.upper,
            cells: cells.cells,
            grading: [1.0; 3],
            diagonals: None,
        })
    }

    fn mesh(cells: &Cells<3>) -> MeshSource {
        MeshSource::Box {
            lower: cells.lower.to_vec(),
            upper: cells.upper.to_vec(),
            cells: cells.cells.to_vec(),
        }
    }

    fn read_mesh(path: &Path, options: &Options) -> Result<Mesh<3>, gmsh::Error> {
        gmsh::Mesh::<3, 4>::read(path, options).map(|mesh| Mesh::of(&mesh))
    }

    fn side(lower: &[f64; 3], upper: &[f64; 3], side: usize) -> Vec<Corners<3>> {
        let (axis, end) = (side / 2, side % 2);
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let corner = |along_u: bool, along_v: bool| {
            let mut corner = *lower;
            corner[axis] = [lower, upper][end][axis];
            corner[u] = [lower, upper][usize::from(along_u)][u];
            corner[v] = [lower, upper][usize::from(along_v)][v];
            corner
        };
        // Clockwise about the inward normal: +axis at the lower end, −axis at the upper one.
        let [a, b, c, d] = [
            corner(false, false),
            corner(false, true),
            corner(true, true),
            corner(true, false),
        ];
        match end {
            0 => vec![[a, b, c], [a, c, d]],
            _ => vec![[a, c, b], [a, d, c]],
        }
    }

    fn wall(keys: &WallKeys<3>) -> Result<Vec<Corners<3>>, (&'static str, String)> {
        if keys.from.is_some() || keys.to.is_some() {
            let why = "a segment is of the plane: in space write corners or cylinder";
            return Err((
                if keys.from.is_some() { "from" } else { "to" },
                why.to_owned(),
            ));
        }
        match &keys.cylinder {
            Some(cylinder) => tube(cylinder).map_err(|why| ("cylinder", why)),
            None => {
                let corners: Vec<[f64; 3]> = keys.corners.iter().map(|corner| corner.0).collect();
                polygon(&corners).map_err(|why| ("corners", why))
            }
        }
    }

    fn is_ahead(facet: &Corners<3>, [x, y, z]: &[f64; 3]) -> bool {
        // A ray meets the facet where its shadow along x holds the point; an edge that two facets share is
        // told the same way by both, from its lower end.
        let mut inside = false;
        for k in 0..3 {
            let (mut a, mut b) = (&facet[k], &facet[(k + 1) % 3]);
            if (a[2], a[1], a[0]) > (b[2], b[1], b[0]) {
                std::mem::swap(&mut a, &mut b);
            }
            let crosses = (a[2] > *z) != (b[2] > *z);
            inside ^= crosses && *y < a[1] + (z - a[2]) / (b[2] - a[2]) * (b[1] - a[1]);
        }
        let corners = facet.map(Vector::from);
        let normal = <Dim<3>>::facet_normal(&corners);
        let height = dot(&normal, &(Vector::from([*x, *y, *z]) - corners[0]));
        inside && height * normal[0] < 0.0
    }

    fn pitch(pattern: Pattern, axis: usize) -> f64 {
        match (pattern, axis) {
            (Pattern::Hexagonal, 1) => (2.0_f64 / 3.0).sqrt(),
            (Pattern::Hexagonal, 2) => 0.75_f64.sqrt(),
            _ => 1.0,
        }
    }

    fn shift(pattern: Pattern, number: &[usize; 3]) -> [f64; 3] {
        match pattern {
            Pattern::Square | Pattern::Cubic => [0.0; 3],
            // A layer's rows are shifted along x, and the layer itself into the hollows of the one below.
            Pattern::Hexagonal => {
                let [row, layer] = [number[2] % 2, number[1] % 2].map(|odd| odd as f64);
                [0.5 * ((row + layer) % 2.0), 0.0, layer / 3.0]
            }
        }
    }

    fn geometry(_: Option<&Coupling>) -> Geometry {
        Geometry::Sphere { depth: 1.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sides_of_a_box_look_inside() {
        for side in 0..6 {
            for facet in <Dim<3>>::side(&[0.0; 3], &[1.0, 2.0, 3.0], side) {
                let normal = <Dim<3>>::inward_normal(&facet.map(Vector::from));
                let expected = if side % 2 == 0 { 1.0 } else { -1.0 };
                assert!(normal[side / 2] * expected > 0.0, "{side} {facet:?}");
            }
        }
    }
}
