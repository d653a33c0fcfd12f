//! A mesh as it is drawn, in the plane or in space.

use run::vtu::mesh::Mesh;
use run::vtu::read::State;
use scene::Error;

/// A point or vector.
pub type Point<const D: usize> = [f64; D];

/// Two opposite corners of a box: the lower along every axis, and the upper.
pub type Corners<const D: usize> = (Point<D>, Point<D>);

/// A mesh of simplices that all lie where they are drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct Simplices<const D: usize, const N: usize> {
    /// Points \[m\]: the nodes, then copies of nodes beyond periodic sides.
    pub points: Vec<Point<D>>,
    /// The node of each point.
    pub node_of: Vec<u32>,
    /// Corners of the simplices, as points.
    pub simplices: Vec<[u32; N]>,
    /// Number of nodes: the length of nodal fields.
    pub node_count: usize,
}

/// Those of the plane.
pub type Triangles = Simplices<2, 3>;
/// Those of space.
pub type Tetrahedra = Simplices<3, 4>;

impl<const D: usize, const N: usize> Simplices<D, N> {
    /// A mesh of as many dimensions; none for any other.
    pub fn of(mesh: Mesh) -> Option<Self> {
        (mesh.dimension == D).then(|| Simplices {
            points: chunks(&mesh.points),
            simplices: chunks(&mesh.corners),
            node_of: mesh.node_of,
            node_count: mesh.node_count,
        })
    }

    /// Those of a state that was written: every point is a node of its own; none in a state without them.
    pub fn of_state(state: &State) -> Result<Option<Self>, Error> {
        let points = state.vectors::<D>("position")?;
        let corners = state.indices("connectivity")?;
        let (Some(points), Some(corners)) = (points, corners) else {
            return Ok(None);
        };
        let outside = |&corner: &i64| corner < 0 || corner as usize >= points.len();
        if corners.iter().any(outside) {
            let why = "a simplex names a point that is not there";
            return Err(state.refuse("connectivity", why));
        }
        let corners: Vec<u32> = corners.iter().map(|&corner| corner as u32).collect();
        Ok(Some(Simplices {
            node_of: (0..points.len() as u32).collect(),
            node_count: points.len(),
            simplices: chunks(&corners),
            points,
        }))
    }

    /// The box around all points \[m\].
    pub fn bounds(&self) -> Corners<D> {
        bounds(self.points.iter().copied())
    }

    /// Facets of one simplex only, the boundary; their corners ascend.
    pub fn boundary(&self) -> Vec<[u32; D]> {
        let facet = |simplex: &[u32; N], without: usize| {
            let mut facet: [u32; D] =
                std::array::from_fn(|corner| simplex[corner + usize::from(corner >= without)]);
            facet.sort_unstable();
            facet
        };
        let mut facets: Vec<[u32; D]> = self
            .simplices
            .iter()
            .flat_map(|simplex| (0..N).map(move |without| facet(simplex, without)))
            .collect();
        facets.sort_unstable();
        let single = facets.chunk_by(|a, b| a == b);
        single
            .filter(|same| same.len() == 1)
            .map(|same| same[0])
            .collect()
    }
}

/// Flat numbers in groups, what is left over without.
pub fn chunks<T: Copy, const WIDTH: usize>(numbers: &[T]) -> Vec<[T; WIDTH]> {
    let group = |chunk: &[T]| std::array::from_fn(|index| chunk[index]);
    numbers.chunks_exact(WIDTH).map(group).collect()
}

/// Length of a vector.
pub fn length<const D: usize>(vector: Point<D>) -> f64 {
    vector.into_iter().fold(0.0, f64::hypot)
}

/// a × b.
pub fn cross(a: Point<3>, b: Point<3>) -> Point<3> {
    std::array::from_fn(|k| {
        let (next, last) = ((k + 1) % 3, (k + 2) % 3);
        a[next] * b[last] - a[last] * b[next]
    })
}

/// The smallest and the largest number without the outermost percent on either side; none of none.
pub fn central(mut numbers: Vec<f64>) -> Option<(f64, f64)> {
    numbers.sort_by(f64::total_cmp);
    let skipped = numbers.len() / 100;
    let last = numbers.len().checked_sub(1 + skipped)?;
    Some((numbers[skipped], numbers[last]))
}

/// The box around points.
pub fn bounds<const D: usize>(points: impl Iterator<Item = Point<D>>) -> Corners<D> {
    points.fold(([f64::MAX; D], [f64::MIN; D]), |(low, high), point| {
        (
            std::array::from_fn(|axis| low[axis].min(point[axis])),
            std::array::from_fn(|axis| high[axis].max(point[axis])),
        )
    })
}

/// The box around disks or spheres.
pub fn grain_bounds<const D: usize>(
    centres: impl Iterator<Item = Point<D>>,
    radius: &[f64],
) -> Corners<D> {
    let radii = radius.iter().copied().chain(std::iter::repeat(0.0));
    bounds(
        centres
            .zip(radii)
            .flat_map(|(centre, radius)| [centre.map(|x| x - radius), centre.map(|x| x + radius)]),
    )
}

/// The part of a segment inside a box (Liang and Barsky).
pub fn clip<const D: usize>(
    a: Point<D>,
    b: Point<D>,
    lower: Point<D>,
    upper: Point<D>,
) -> Option<(Point<D>, Point<D>)> {
    let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
    for axis in 0..D {
        let step = b[axis] - a[axis];
        for (direction, room) in [
            (-step, a[axis] - lower[axis]),
            (step, upper[axis] - a[axis]),
        ] {
            if direction == 0.0 {
                if room < -1e-12 * (upper[axis] - lower[axis]) {
                    return None;
                }
            } else if direction < 0.0 {
                enter = enter.max(room / direction);
            } else {
                leave = leave.min(room / direction);
            }
        }
    }
    let at = |share: f64| std::array::from_fn(|axis| a[axis] + share * (b[axis] - a[axis]));
    (enter <= leave).then(|| (at(enter), at(leave)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_simplices_that_share_a_facet_have_all_others_as_boundary() {
        let plane = Triangles {
            points: vec![[0.0; 2]; 4],
            node_of: vec![0, 1, 2, 3],
            simplices: vec![[0, 1, 2], [0, 2, 3]],
            node_count: 4,
        };
        assert_eq!(plane.boundary(), [[0, 1], [0, 3], [1, 2], [2, 3]]);
        let space = Tetrahedra {
            points: vec![[0.0; 3]; 5],
            node_of: vec![0, 1, 2, 3, 4],
            simplices: vec![[3, 1, 2, 0], [1, 2, 3, 4]],
            node_count: 5,
        };
        let facets = space.boundary();
        println!("{facets:?}");
        assert_eq!(facets.len(), 6);
        assert!(!facets.contains(&[1, 2, 3]));
    }
}
