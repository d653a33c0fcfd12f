//! Where grains are on the mesh: the triangle around a point and its three linear shape functions.

use protocol::engine::MeshDescription;

use crate::error::CouplerError;

/// The nodes around one point and their shape functions; the weights sum to one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stencil {
    /// Corner nodes of the triangle.
    pub nodes: [u32; 3],
    /// Linear shape functions at the point, ≥ 0.
    pub weights: [f64; 3],
}

/// A grid of bins over the mesh, each with the triangles that reach into it.
#[derive(Debug)]
pub struct Locator {
    lower: [f64; 2],
    bin_size: [f64; 2],
    bin_counts: [usize; 2],
    /// Triangles of bin b: `bin_triangles[bin_start[b]..bin_start[b + 1]]`.
    bin_start: Vec<usize>,
    bin_triangles: Vec<u32>,
    triangles: Vec<[u32; 3]>,
    corners: Vec<[f64; 6]>,
    period: [Option<f64>; 2],
    /// How far outside the mesh a point may lie [m]: one triangle.
    outside_max: f64,
}

impl Locator {
    /// Sort the triangles of a mesh into bins of about one triangle each.
    pub fn new(mesh: &MeshDescription) -> Locator {
        let corners = mesh.triangle_position.clone();
        let (mut lower, mut upper) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        let mut outside_max = 0.0_f64;
        for triangle in &corners {
            let (low, high) = bounds(triangle);
            for axis in 0..2 {
                lower[axis] = lower[axis].min(low[axis]);
                upper[axis] = upper[axis].max(high[axis]);
                outside_max = outside_max.max(high[axis] - low[axis]);
            }
        }
        let extent = [upper[0] - lower[0], upper[1] - lower[1]];
        let bin_edge = (extent[0] * extent[1] / (0.5 * corners.len().max(1) as f64)).sqrt();
        let bin_counts = extent.map(|length| ((length / bin_edge).ceil() as usize).max(1));
        let bin_size = [
            extent[0] / bin_counts[0] as f64,
            extent[1] / bin_counts[1] as f64,
        ];
        let mut locator = Locator {
            lower,
            bin_size,
            bin_counts,
            bin_start: Vec::new(),
            bin_triangles: Vec::new(),
            triangles: mesh.triangles.clone(),
            corners,
            period: mesh.period,
            outside_max,
        };
        locator.fill_bins();
        locator
    }

    fn fill_bins(&mut self) {
        let mut bins = vec![Vec::new(); self.bin_counts[0] * self.bin_counts[1]];
        for (index, triangle) in self.corners.iter().enumerate() {
            let (low, high) = bounds(triangle);
            let (first, last) = (self.bin_of(low), self.bin_of(high));
            for row in first[1]..=last[1] {
                for column in first[0]..=last[0] {
                    bins[row * self.bin_counts[0] + column].push(index as u32);
                }
            }
        }
        self.bin_start = vec![0];
        for bin in bins {
            self.bin_triangles.extend(bin);
            self.bin_start.push(self.bin_triangles.len());
        }
    }

    fn bin_of(&self, point: [f64; 2]) -> [usize; 2] {
        [0, 1].map(|axis| {
            let bin = (point[axis] - self.lower[axis]) / self.bin_size[axis];
            (bin.max(0.0) as usize).min(self.bin_counts[axis] - 1)
        })
    }

    /// The stencil of a point. Just outside the mesh it is that of the nearest triangle, clipped.
    pub fn locate(&self, grain: usize, point: [f64; 2]) -> Result<Stencil, CouplerError> {
        if !(point[0].is_finite() && point[1].is_finite()) {
            return Err(CouplerError::GrainOutside {
                grain,
                x: point[0],
                y: point[1],
            });
        }
        let inside = self.wrap(point);
        let centre = self.bin_of(inside);
        let mut nearest = (f64::INFINITY, 0_u32, [0.0; 3]);
        for ring in 0..3 {
            for triangle in self.ring(centre, ring) {
                let (weights, distance) = project(&self.corners[triangle as usize], inside);
                if distance < nearest.0 {
                    nearest = (distance, triangle, weights);
                }
                if distance == 0.0 {
                    return Ok(self.stencil(triangle, weights));
                }
            }
        }
        if nearest.0 <= self.outside_max {
            Ok(self.stencil(nearest.1, nearest.2))
        } else {
            Err(CouplerError::GrainOutside {
                grain,
                x: point[0],
                y: point[1],
            })
        }
    }

    fn stencil(&self, triangle: u32, weights: [f64; 3]) -> Stencil {
        Stencil {
            nodes: self.triangles[triangle as usize],
            weights,
        }
    }

    fn wrap(&self, point: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|axis| match self.period[axis] {
            Some(length) => {
                let turns = ((point[axis] - self.lower[axis]) / length).floor();
                point[axis] - turns * length
            }
            None => point[axis],
        })
    }

    /// Triangles of the bins at this distance (in bins) from a bin.
    fn ring(&self, centre: [usize; 2], distance: usize) -> impl Iterator<Item = u32> + '_ {
        let range = |axis: usize| {
            let last = self.bin_counts[axis] - 1;
            centre[axis].saturating_sub(distance)..=(centre[axis] + distance).min(last)
        };
        let (columns, rows) = (range(0), range(1));
        rows.flat_map(move |row| columns.clone().map(move |column| [column, row]))
            .filter(move |bin| {
                bin[0].abs_diff(centre[0]).max(bin[1].abs_diff(centre[1])) == distance
            })
            .flat_map(move |bin| {
                let index = bin[1] * self.bin_counts[0] + bin[0];
                self.bin_triangles[self.bin_start[index]..self.bin_start[index + 1]]
                    .iter()
                    .copied()
            })
    }
}

fn bounds(corners: &[f64; 6]) -> ([f64; 2], [f64; 2]) {
    let axis = |a: usize| [corners[a], corners[a + 2], corners[a + 4]];
    let low = [0, 1].map(|a| axis(a).into_iter().fold(f64::INFINITY, f64::min));
    let high = [0, 1].map(|a| axis(a).into_iter().fold(f64::NEG_INFINITY, f64::max));
    (low, high)
}

/// Barycentric coordinates of a point, clipped to the triangle, and its distance from the triangle
/// (an estimate: distance to the clipped point; exactly 0 inside, with a tolerance of 1e-12).
fn project(corners: &[f64; 6], point: [f64; 2]) -> ([f64; 3], f64) {
    let [ax, ay, bx, by, cx, cy] = *corners;
    let doubled_area = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay);
    let second = ((point[0] - ax) * (cy - ay) - (cx - ax) * (point[1] - ay)) / doubled_area;
    let third = ((bx - ax) * (point[1] - ay) - (point[0] - ax) * (by - ay)) / doubled_area;
    let weights = [1.0 - second - third, second, third];
    let clipped = weights.map(|weight| weight.max(0.0));
    let sum: f64 = clipped.iter().sum();
    let clipped = clipped.map(|weight| weight / sum);
    if weights.iter().all(|&weight| weight >= -1e-12) {
        return (clipped, 0.0);
    }
    let x = clipped[0] * ax + clipped[1] * bx + clipped[2] * cx;
    let y = clipped[0] * ay + clipped[1] * by + clipped[2] * cy;
    (
        clipped,
        (point[0] - x).hypot(point[1] - y).max(f64::MIN_POSITIVE),
    )
}
