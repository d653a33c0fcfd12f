//! A mesh of tetrahedra cut by a plane: triangles, and what lies between two nodes at their corners.

use crate::simplices::{Point, Tetrahedra};

/// A plane across a mesh.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Cut {
    /// Points \[m\].
    pub points: Vec<Point<3>>,
    /// The two nodes that a point lies between, and its way from the first to the second, from 0 to 1.
    pub between: Vec<([u32; 2], f64)>,
    /// Corners of the triangles, as points.
    pub triangles: Vec<[u32; 3]>,
}

/// Where an upright plane z = … lies \[m\] in a window that reaches so far along z: in the middle of the grains, or of
/// the window where there are none.
pub fn level(grains: Option<(f64, f64)>, window: (f64, f64)) -> f64 {
    let (low, high) = grains.unwrap_or(window);
    // On the window's own side there would be nothing to cut.
    let room = 1e-6 * (window.1 - window.0);
    (0.5 * (low + high))
        .max(window.0 + room)
        .min(window.1 - room)
}

/// An edge by its end points in ascending order; a point that lies on the plane itself, twice.
type Edge = [u32; 2];

impl Cut {
    /// The plane x_`axis` = `level` \[m\]. A point on it counts as above, so that a facet in the plane is there once.
    pub fn of(mesh: &Tetrahedra, axis: usize, level: f64) -> Cut {
        let height = |point: u32| mesh.points[point as usize][axis] - level;
        let edge = |above: u32, below: u32| -> Edge {
            if height(above) == 0.0 {
                return [above; 2];
            }
            [above.min(below), above.max(below)]
        };
        let mut triangles: Vec<[Edge; 3]> = Vec::new();
        for simplex in &mesh.simplices {
            let above = || {
                simplex
                    .iter()
                    .copied()
                    .filter(|&point| height(point) >= 0.0)
            };
            let below = || simplex.iter().copied().filter(|&point| height(point) < 0.0);
            let (count, mut corners) = (above().count(), [[0; 2]; 4]);
            let pairs = above().flat_map(|a| below().map(move |b| edge(a, b)));
            let found = corners
                .iter_mut()
                .zip(pairs)
                .map(|(corner, pair)| *corner = pair);
            let found = found.count();
            // Of two above and two below: 0 and 3 lie across from one another.
            let parts = match found {
                3 => &[[0, 1, 2]][..],
                4 if count == 2 => &[[0, 1, 2], [1, 3, 2]],
                _ => &[],
            };
            for part in parts {
                let [a, b, c] = part.map(|corner: usize| corners[corner]);
                if a != b && b != c && c != a {
                    triangles.push([a, b, c]);
                }
            }
        }
        let mut edges: Vec<Edge> = triangles.iter().flatten().copied().collect();
        edges.sort_unstable();
        edges.dedup();
        // Every edge of a triangle is in the list.
        let place = |edge: &Edge| edges.binary_search(edge).unwrap_or_default() as u32;
        let triangles = triangles
            .iter()
            .map(|corners| corners.each_ref().map(place));
        let triangles = triangles.collect();
        let way = |&[a, b]: &Edge| {
            let (from, to) = (height(a), height(b));
            if from == to { 0.0 } else { from / (from - to) }
        };
        let point = |edge: &Edge| {
            let [a, b] = edge.map(|end| mesh.points[end as usize]);
            let mut point = std::array::from_fn(|k| a[k] + way(edge) * (b[k] - a[k]));
            point[axis] = level;
            point
        };
        let nodes = |edge: &Edge| edge.map(|end| mesh.node_of[end as usize]);
        Cut {
            points: edges.iter().map(point).collect(),
            between: edges.iter().map(|edge| (nodes(edge), way(edge))).collect(),
            triangles,
        }
    }

    /// A nodal field at the points.
    pub fn at<const K: usize>(&self, nodal: impl Fn(u32) -> [f64; K]) -> Vec<[f64; K]> {
        let value = |&([a, b], way): &([u32; 2], f64)| {
            let (from, to) = (nodal(a), nodal(b));
            std::array::from_fn(|k| from[k] + way * (to[k] - from[k]))
        };
        self.between.iter().map(value).collect()
    }
}

#[cfg(test)]
pub mod tests {
    use super::*;

    /// A box of cells, each cut into six tetrahedra.
    pub fn cells(low: Point<3>, high: Point<3>, count: [usize; 3]) -> Tetrahedra {
        let [nx, ny, nz] = count.map(|count| count + 1);
        let mut points = Vec::new();
        for (k, j) in (0..nz).flat_map(|k| (0..ny).map(move |j| (k, j))) {
            for i in 0..nx {
                let share = [i, j, k].map(|index| index as f64);
                points.push(std::array::from_fn(|axis| {
                    low[axis] + (high[axis] - low[axis]) * share[axis] / count[axis] as f64
                }));
            }
        }
        let node = |at: [usize; 3]| ((at[2] * ny + at[1]) * nx + at[0]) as u32;
        let mut simplices = Vec::new();
        for cell in 0..count[0] * count[1] * count[2] {
            let mut corner = [
                cell % count[0],
                cell / count[0] % count[1],
                cell / count[0] / count[1],
            ];
            let start = corner;
            for way in [
                [0, 1, 2],
                [1, 2, 0],
                [2, 0, 1],
                [1, 0, 2],
                [0, 2, 1],
                [2, 1, 0],
            ] {
                let mut simplex = [node(start); 4];
                corner = start;
                for (place, axis) in way.into_iter().enumerate() {
                    corner[axis] += 1;
                    simplex[place + 1] = node(corner);
                }
                simplices.push(simplex);
            }
        }
        Tetrahedra {
            node_of: (0..points.len() as u32).collect(),
            node_count: points.len(),
            points,
            simplices,
        }
    }

    #[test]
    fn a_cut_covers_the_section_once_and_a_linear_field_on_it_is_exact() {
        let mesh = cells([-1.0, 0.0, -2.0], [1.0, 3.0, 2.0], [4, 5, 4]);
        println!("| axis | level | points | triangles | area | error |");
        for (axis, level, area) in [
            (2, 0.1, 6.0),
            (2, 0.0, 6.0),
            (0, 0.3, 12.0),
            (1, 1.7, 8.0),
            (1, 3.5, 0.0),
        ] {
            let cut = Cut::of(&mesh, axis, level);
            let of = |corners: &[u32; 3]| {
                let [a, b, c] = corners.map(|corner| cut.points[corner as usize]);
                let [u, v] = [b, c].map(|end| [0, 1, 2].map(|k| end[k] - a[k]));
                let cross = [0, 1, 2]
                    .map(|k| u[(k + 1) % 3] * v[(k + 2) % 3] - u[(k + 2) % 3] * v[(k + 1) % 3]);
                0.5 * crate::simplices::length(cross)
            };
            let sum: f64 = cut.triangles.iter().map(of).sum();
            let linear = |x: &Point<3>| 2.0 * x[0] - x[1] + 0.5 * x[2];
            let values = cut.at(|node| [linear(&mesh.points[node as usize])]);
            let error = values
                .iter()
                .zip(&cut.points)
                .map(|(value, x)| (value[0] - linear(x)).abs());
            let error = error.fold(0.0, f64::max);
            println!(
                "| {axis} | {level} | {} | {} | {sum} | {error:.1e} |",
                cut.points.len(),
                cut.triangles.len()
            );
            assert!((sum - area).abs() < 1e-12 && error < 1e-13);
        }
        assert_eq!(Cut::of(&mesh, 2, 0.0).points.len(), 5 * 6);
    }
}
