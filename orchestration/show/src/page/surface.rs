//! What fields are painted on: the mesh itself in the plane, in space an upright plane across it.

use run::vtu::read::State;
use scene::Error;
use serde::Serialize;

use super::encode::{singles, words};
use crate::cut::Cut;
use crate::outline::{creases, edges, of_facets};
use crate::simplices::{Corners, Point, Tetrahedra, Triangles, cross};

/// A mesh and what of it is shown.
pub enum Surface {
    /// All of it.
    Plane(Triangles),
    /// The plane z = … \[m\].
    Space(Tetrahedra, Cut, f64),
}

/// A surface as the page takes it.
#[derive(Debug, Clone, Serialize)]
pub struct Drawn {
    /// Places \[m\], in single precision.
    points: String,
    /// Corners of the triangles.
    triangles: String,
}

impl Surface {
    /// That of a state, in space at this height z \[m\]; none of one without a mesh.
    pub fn of_state(state: &State, dimension: usize, level: f64) -> Result<Option<Surface>, Error> {
        let space = |mesh: Tetrahedra| {
            let cut = Cut::of(&mesh, 2, level);
            Surface::Space(mesh, cut, level)
        };
        Ok(match dimension {
            2 => Triangles::of_state(state)?.map(Surface::Plane),
            3 => Tetrahedra::of_state(state)?.map(space),
            _ => None,
        })
    }

    /// The same of another state.
    pub fn again(&self, state: &State) -> Result<Option<Surface>, Error> {
        match self {
            Surface::Plane(_) => Surface::of_state(state, 2, 0.0),
            Surface::Space(_, _, level) => Surface::of_state(state, 3, *level),
        }
    }

    /// As the page takes it.
    pub fn drawn(&self) -> Drawn {
        match self {
            Surface::Plane(mesh) => Drawn {
                points: singles(mesh.points.iter().flatten().copied()),
                triangles: words(mesh.simplices.iter().flatten().copied()),
            },
            Surface::Space(_, cut, _) => Drawn {
                points: singles(cut.points.iter().flatten().copied()),
                triangles: words(cut.triangles.iter().flatten().copied()),
            },
        }
    }

    fn point_count(&self) -> usize {
        match self {
            Surface::Plane(mesh) => mesh.points.len(),
            Surface::Space(mesh, ..) => mesh.points.len(),
        }
    }

    /// A field at the points of the mesh where it is shown; none of one of another length.
    pub fn at(&self, values: Vec<f64>) -> Option<Vec<f64>> {
        if values.len() != self.point_count() {
            return None;
        }
        Some(match self {
            Surface::Plane(_) => values,
            Surface::Space(_, cut, _) => {
                let found = cut.at(|node| [values[node as usize]]);
                found.into_iter().map(|[value]| value).collect()
            }
        })
    }

    /// ∂v/∂x − ∂u/∂y at the points of the mesh; none where there are other velocities than points.
    pub fn vorticity(&self, velocity: &[Point<3>]) -> Option<Vec<f64>> {
        (velocity.len() == self.point_count()).then(|| match self {
            Surface::Plane(mesh) => vorticity(mesh, velocity),
            Surface::Space(mesh, ..) => vorticity_across(mesh, velocity),
        })
    }
}

/// Walls and boundaries as segments; of space without either the window's own edges.
pub fn outline(
    surface: Option<&Surface>,
    walls: &[Vec<Point<3>>],
    window: Corners<3>,
    dimension: usize,
) -> Vec<[Point<3>; 2]> {
    let mut outline: Vec<[Point<3>; 2]> = Vec::new();
    outline.extend(
        walls
            .iter()
            .filter_map(|wall| <[_; 2]>::try_from(&wall[..]).ok()),
    );
    let facets = walls
        .iter()
        .filter_map(|wall| <[_; 3]>::try_from(&wall[..]).ok());
    outline.extend(of_facets(&facets.collect::<Vec<_>>()));
    match surface {
        Some(Surface::Plane(mesh)) => {
            let at = |point: u32| {
                let [x, y] = mesh.points[point as usize];
                [x, y, 0.0]
            };
            outline.extend(mesh.boundary().into_iter().map(|side| side.map(at)));
        }
        Some(Surface::Space(mesh, ..)) => outline.extend(creases(&mesh.points, &mesh.boundary())),
        None => {}
    }
    if outline.is_empty() && dimension == 3 {
        outline = edges(window);
    }
    outline
}

/// ∂v/∂x − ∂u/∂y at the points: the gradient of each triangle, averaged by area.
fn vorticity(mesh: &Triangles, velocity: &[Point<3>]) -> Vec<f64> {
    let mut sum = vec![0.0; mesh.points.len()];
    let mut area = vec![0.0; mesh.points.len()];
    for corners in &mesh.simplices {
        let [a, b, c] = corners.map(|corner| corner as usize);
        let [pa, pb, pc] = [a, b, c].map(|point| mesh.points[point]);
        let (ux, uy) = (pb[0] - pa[0], pb[1] - pa[1]);
        let (vx, vy) = (pc[0] - pa[0], pc[1] - pa[1]);
        let twice = ux * vy - uy * vx;
        let [va, vb, vc] = [a, b, c].map(|point| velocity[point]);
        let (d1, d2) = (
            [vb[0] - va[0], vb[1] - va[1]],
            [vc[0] - va[0], vc[1] - va[1]],
        );
        // Twice the area times ∂v/∂x − ∂u/∂y.
        let curl = (d1[1] * vy - d2[1] * uy) - (ux * d2[0] - vx * d1[0]);
        for point in [a, b, c] {
            sum[point] += curl;
            area[point] += twice;
        }
    }
    let mean = |(sum, area): (f64, f64)| if area == 0.0 { 0.0 } else { sum / area };
    sum.into_iter().zip(area).map(mean).collect()
}

/// The same component in space: the gradient of each tetrahedron, averaged by volume.
///
/// With edges e₁, e₂, e₃ from one corner and the differences d of a number along them, its gradient is
/// (d₁ e₂×e₃ + d₂ e₃×e₁ + d₃ e₁×e₂)/(e₁·e₂×e₃).
fn vorticity_across(mesh: &Tetrahedra, velocity: &[Point<3>]) -> Vec<f64> {
    let mut sum = vec![0.0; mesh.points.len()];
    let mut volume = vec![0.0; mesh.points.len()];
    let minus = |a: Point<3>, b: Point<3>| -> Point<3> { std::array::from_fn(|k| a[k] - b[k]) };
    for corners in &mesh.simplices {
        let at = corners.map(|corner| mesh.points[corner as usize]);
        let v = corners.map(|corner| velocity[corner as usize]);
        let edges = [1, 2, 3].map(|end| minus(at[end], at[0]));
        let differences = [1, 2, 3].map(|end| minus(v[end], v[0]));
        let areas = [0, 1, 2].map(|k| cross(edges[(k + 1) % 3], edges[(k + 2) % 3]));
        let six = (0..3)
            .map(|axis| edges[0][axis] * areas[0][axis])
            .sum::<f64>();
        // Six times the volume times ∂v/∂x − ∂u/∂y.
        let terms =
            (0..3).map(|k| differences[k][1] * areas[k][0] - differences[k][0] * areas[k][1]);
        let curl = terms.sum::<f64>() * six.signum();
        for &point in corners {
            sum[point as usize] += curl;
            volume[point as usize] += six.abs();
        }
    }
    let mean = |(sum, volume): (f64, f64)| if volume == 0.0 { 0.0 } else { sum / volume };
    sum.into_iter().zip(volume).map(mean).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_vorticity_of_a_rotation_is_twice_its_rate() {
        let points = vec![[0.0, 0.0], [1.0, 0.0], [1.0, 2.0], [0.0, 1.0]];
        let velocity: Vec<Point<3>> = points
            .iter()
            .map(|x: &[f64; 2]| [-3.0 * x[1], 3.0 * x[0], 0.0])
            .collect();
        let mesh = Triangles {
            node_of: vec![0, 1, 2, 3],
            node_count: 4,
            simplices: vec![[0, 1, 2], [0, 2, 3]],
            points,
        };
        let found = vorticity(&mesh, &velocity);
        println!("{found:?}");
        assert!(found.iter().all(|curl| (curl - 6.0).abs() < 1e-12));
    }

    #[test]
    fn across_the_plane_too() {
        let mesh = crate::cut::tests::cells([0.0; 3], [1.0, 2.0, 1.5], [2, 2, 3]);
        let turn = |x: &Point<3>| [-3.0 * x[1] + x[2], 3.0 * x[0], 5.0 * x[0]];
        let velocity: Vec<Point<3>> = mesh.points.iter().map(turn).collect();
        let found = vorticity_across(&mesh, &velocity);
        println!("{found:?}");
        assert!(found.iter().all(|curl| (curl - 6.0).abs() < 1e-12));
    }
}
