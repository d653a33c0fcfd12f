//! Edges that show the shape of a surface of triangles, or of a box.

use std::collections::BTreeMap;

use crate::simplices::{Corners, Point, cross, length};

/// Cosine of the angle by which a surface bends at an edge that is drawn: 30 degrees.
const BEND: f64 = 0.866;

/// Edges at which a surface bends sharply or ends; facets are triangles.
pub fn creases(points: &[Point<3>], facets: &[[u32; 3]]) -> Vec<[Point<3>; 2]> {
    let mut sides: Vec<([u32; 2], usize)> = Vec::new();
    for (index, facet) in facets.iter().enumerate() {
        for side in 0..3 {
            let (a, b) = (facet[side], facet[(side + 1) % 3]);
            sides.push(([a.min(b), a.max(b)], index));
        }
    }
    sides.sort_unstable();
    let normal = |facet: usize| normal(facets[facet].map(|corner| points[corner as usize]));
    let bends = |same: &&[([u32; 2], usize)]| match same {
        [(_, a), (_, b)] => {
            let (a, b) = (normal(*a), normal(*b));
            // Which side of a facet is outside is not known: a fold by more than 90° is not looked for.
            (0..3).map(|k| a[k] * b[k]).sum::<f64>().abs() < BEND
        }
        _ => true,
    };
    let edges = sides.chunk_by(|a, b| a.0 == b.0).filter(bends);
    edges
        .map(|same| same[0].0.map(|end| points[end as usize]))
        .collect()
}

/// The same of triangles that share corners without saying so.
pub fn of_facets(facets: &[[Point<3>; 3]]) -> Vec<[Point<3>; 2]> {
    let mut points = Vec::new();
    let mut known: BTreeMap<[u64; 3], u32> = BTreeMap::new();
    let mut number = |corner: &Point<3>| {
        // Adding zero makes −0 the 0 that it is.
        let key = corner.map(|x| (x + 0.0).to_bits());
        *known.entry(key).or_insert_with(|| {
            points.push(*corner);
            points.len() as u32 - 1
        })
    };
    let numbers: Vec<[u32; 3]> = facets
        .iter()
        .map(|facet| facet.each_ref().map(&mut number))
        .collect();
    creases(&points, &numbers)
}

/// The eight corners of a box, x fastest, then y.
pub fn corners((low, high): Corners<3>) -> [Point<3>; 8] {
    std::array::from_fn(|corner| std::array::from_fn(|axis| [low, high][corner >> axis & 1][axis]))
}

/// The twelve edges of a box.
pub fn edges(shown: Corners<3>) -> Vec<[Point<3>; 2]> {
    let all = corners(shown);
    let pairs =
        (0..8_usize).flat_map(|corner| (0..3).map(move |axis| (corner, corner | 1 << axis)));
    let different = pairs.filter(|(from, to)| from != to);
    different.map(|(from, to)| [all[from], all[to]]).collect()
}

fn normal([a, b, c]: [Point<3>; 3]) -> Point<3> {
    let between = |end: Point<3>| -> Point<3> { std::array::from_fn(|k| end[k] - a[k]) };
    let normal = cross(between(b), between(c));
    let size = length(normal).max(f64::MIN_POSITIVE);
    normal.map(|component| component / size)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cut::tests::cells;

    #[test]
    fn of_a_box_its_twelve_edges_are_drawn_and_no_diagonal() {
        let mesh = cells([0.0; 3], [1.0, 2.0, 3.0], [2, 3, 4]);
        let edges = creases(&mesh.points, &mesh.boundary());
        let total: f64 = edges
            .iter()
            .map(|[a, b]| length([0, 1, 2].map(|k| b[k] - a[k])))
            .sum();
        println!("{} edges, {total} m", edges.len());
        assert_eq!(edges.len(), 4 * (2 + 3 + 4));
        assert!((total - 24.0).abs() < 1e-12);
        let corners = [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 0.0, 1.0], [0.0, -0.0, 1.0]];
        let wall = [[0, 1, 2], [0, 2, 3]].map(|facet| facet.map(|corner: usize| corners[corner]));
        assert_eq!(of_facets(&wall).len(), 4);
    }
}
