//! The outline of the fluid: the sides of its rectangle, or the edges of its mesh that belong to one
//! triangle. What lies inside, and what lies on it.

/// Part of the size of an outline within which a point lies on an edge.
const ON_EDGE: f64 = 1e-9;

/// A piece of the outline; the fluid is on the left of a → b.
#[derive(Debug, Clone, PartialEq)]
pub struct Edge {
    /// Where it begins \[m\].
    pub a: [f64; 2],
    /// Where it ends \[m\].
    pub b: [f64; 2],
    /// Name of its boundary.
    pub boundary: String,
}

/// All edges, sorted into strips across y.
#[derive(Debug, Clone)]
pub struct Outline {
    /// The edges.
    pub edges: Vec<Edge>,
    /// Axes along which there is no outside: the fluid is periodic.
    periodic: [bool; 2],
    /// Lowest y, height of a strip \[m\].
    strips: [f64; 2],
    /// Numbers of the edges that reach into each strip.
    members: Vec<Vec<u32>>,
    /// Distance at which a point lies on an edge \[m\].
    tolerance: f64,
}

/// Smallest and largest coordinate of all ends along each axis \[m\].
fn ranges(edges: &[Edge]) -> [[f64; 2]; 2] {
    [0, 1].map(|axis| {
        let values = edges.iter().flat_map(|edge| [edge.a[axis], edge.b[axis]]);
        values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| {
            [low.min(value), high.max(value)]
        })
    })
}

impl Outline {
    /// Of a rectangle, with sides left, right, bottom, top.
    pub fn of_rectangle(lower: [f64; 2], upper: [f64; 2], periodic: [bool; 2]) -> Outline {
        let ([left, bottom], [right, top]) = (lower, upper);
        let sides = [
            ([left, top], [left, bottom], "left"),
            ([right, bottom], [right, top], "right"),
            ([left, bottom], [right, bottom], "bottom"),
            ([right, top], [left, top], "top"),
        ];
        let edges = sides.map(|(a, b, name)| Edge {
            a,
            b,
            boundary: name.to_string(),
        });
        Outline::new(edges.into(), periodic)
    }

    /// Of these edges.
    pub fn new(edges: Vec<Edge>, periodic: [bool; 2]) -> Outline {
        let [[left, right], [bottom, top]] = ranges(&edges);
        let tolerance = ON_EDGE * (right - left).max(top - bottom);
        let count = edges.len().clamp(1, 4096);
        let strips = [bottom, (top - bottom) / count as f64];
        let mut outline = Outline {
            edges,
            periodic,
            strips,
            members: vec![Vec::new(); count],
            tolerance,
        };
        for number in 0..outline.edges.len() {
            let Edge { a, b, .. } = &outline.edges[number];
            let (low, high) = (a[1].min(b[1]) - tolerance, a[1].max(b[1]) + tolerance);
            for strip in outline.strip(low)..=outline.strip(high) {
                outline.members[strip].push(number as u32);
            }
        }
        outline
    }

    /// Distance at which a point lies on an edge \[m\].
    pub fn tolerance(&self) -> f64 {
        self.tolerance
    }

    fn strip(&self, y: f64) -> usize {
        let strip = (y - self.strips[0]) / self.strips[1];
        strip.clamp(0.0, (self.members.len() - 1) as f64) as usize
    }

    /// Is there fluid at a point, its edge included?
    pub fn contains(&self, point: [f64; 2]) -> bool {
        match self.periodic {
            [false, false] => self.winds(point) || self.edge_at(point).is_some(),
            // Only rectangles are periodic.
            periodic => (0..2).all(|axis| periodic[axis] || self.within(point, axis)),
        }
    }

    /// Width and height \[m\].
    pub fn size(&self) -> [f64; 2] {
        ranges(&self.edges).map(|[low, high]| high - low)
    }

    /// Is a point between the smallest and the largest coordinate along an axis?
    fn within(&self, point: [f64; 2], axis: usize) -> bool {
        let [low, high] = ranges(&self.edges)[axis];
        (low - self.tolerance..=high + self.tolerance).contains(&point[axis])
    }

    /// Does a ray along x leave an odd number of times?
    fn winds(&self, [x, y]: [f64; 2]) -> bool {
        let crossed = self.members[self.strip(y)].iter().filter(|&&number| {
            let Edge { a, b, .. } = &self.edges[number as usize];
            (a[1] > y) != (b[1] > y) && x < a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
        });
        crossed.count() % 2 == 1
    }

    /// The edge that a point lies on.
    pub fn edge_at(&self, point: [f64; 2]) -> Option<&Edge> {
        let members = self.members[self.strip(point[1])].iter();
        let mut edges = members.map(|&number| &self.edges[number as usize]);
        edges.find(|edge| edge.distance(point) <= self.tolerance)
    }

    /// Edges that a segment lies on, from its middle and both ends.
    pub fn along(&self, a: [f64; 2], b: [f64; 2]) -> Option<&Edge> {
        let ends = [a, b].iter().all(|end| self.edge_at(*end).is_some());
        self.edge_at(halfway(a, b)).filter(|_| ends)
    }
}

impl Edge {
    /// From a point to the nearest one of the edge \[m\].
    fn distance(&self, point: [f64; 2]) -> f64 {
        let way: [f64; 2] = std::array::from_fn(|axis| self.b[axis] - self.a[axis]);
        let away: [f64; 2] = std::array::from_fn(|axis| point[axis] - self.a[axis]);
        let squared = way[0] * way[0] + way[1] * way[1];
        let along = ((away[0] * way[0] + away[1] * way[1]) / squared).clamp(0.0, 1.0);
        f64::hypot(away[0] - along * way[0], away[1] - along * way[1])
    }

    /// Its middle \[m\].
    pub fn middle(&self) -> [f64; 2] {
        halfway(self.a, self.b)
    }

    /// Unit vector into the fluid.
    pub fn inward(&self) -> [f64; 2] {
        let way: [f64; 2] = std::array::from_fn(|axis| self.b[axis] - self.a[axis]);
        let length = f64::hypot(way[0], way[1]);
        [-way[1] / length, way[0] / length]
    }
}

fn halfway(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    std::array::from_fn(|axis| 0.5 * (a[axis] + b[axis]))
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;

    /// Edges of triangles that belong to one of them, each with the name that `named` has for its nodes.
    fn single_edges(
        position: &[[f64; 2]],
        triangles: &[[usize; 3]],
        named: &BTreeMap<[usize; 2], String>,
    ) -> Vec<Edge> {
        let mut sides: Vec<([usize; 2], [usize; 2])> = Vec::with_capacity(3 * triangles.len());
        for &[i, j, k] in triangles {
            let triangle = if is_clockwise([i, j, k].map(|n| position[n])) {
                [i, k, j]
            } else {
                [i, j, k]
            };
            for corner in 0..3 {
                let side = [triangle[corner], triangle[(corner + 1) % 3]];
                sides.push(([side[0].min(side[1]), side[0].max(side[1])], side));
            }
        }
        sides.sort_unstable();
        let single = sides.chunk_by(|p, q| p.0 == q.0).filter(|c| c.len() == 1);
        single
            .map(|group| {
                let (key, [a, b]) = group[0];
                Edge {
                    a: position[a],
                    b: position[b],
                    boundary: named.get(&key).cloned().unwrap_or_default(),
                }
            })
            .collect()
    }

    fn is_clockwise([a, b, c]: [[f64; 2]; 3]) -> bool {
        (b[0] - a[0]) * (c[1] - a[1]) < (c[0] - a[0]) * (b[1] - a[1])
    }

    #[test]
    fn a_hole_is_outside_and_its_rim_is_not() {
        // A square ring of side 3 around a square hole of side 1, in triangles.
        let place = |n: usize| [(n % 4) as f64, (n / 4) as f64];
        let position: Vec<[f64; 2]> = (0..16).map(place).collect();
        let cells = (0..9).filter(|&cell| cell != 4);
        let corner = |cell: usize| cell % 3 + 4 * (cell / 3);
        let triangles: Vec<[usize; 3]> = cells
            .map(corner)
            .flat_map(|n| [[n, n + 1, n + 5], [n, n + 5, n + 4]])
            .collect();
        let named = BTreeMap::from([([5, 6], "hole".to_string())]);
        let outline = Outline::new(single_edges(&position, &triangles, &named), [false; 2]);
        assert_eq!(outline.edges.len(), 16);
        for (point, inside) in [
            ([0.5, 0.5], true),
            ([1.5, 1.5], false),
            ([1.5, 1.0], true),
            ([3.1, 1.5], false),
            ([2.9, 1.5], true),
            ([1.0, 1.0], true),
        ] {
            assert_eq!(outline.contains(point), inside, "{point:?}");
        }
        let rim = outline.along([1.2, 1.0], [1.8, 1.0]).expect("on the rim");
        println!("{rim:?}");
        assert_eq!((rim.boundary.as_str(), rim.inward()), ("hole", [0.0, -1.0]));
        assert!(outline.along([0.5, 1.0], [1.8, 1.0]).is_none());
    }

    #[test]
    fn a_periodic_rectangle_has_no_outside_along_its_period() {
        let outline = Outline::of_rectangle([0.0, 0.0], [1.0, 2.0], [true, false]);
        assert!(outline.contains([7.0, 1.0]) && !outline.contains([0.5, 2.1]));
    }
}
