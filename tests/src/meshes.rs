//! Meshes for tests, written as Gmsh files.

use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::path::Path;

/// The unit square without a disk around its middle: `around` cells along the disk (a multiple of 8),
/// `rings` from it to the sides, growing outwards. Boundaries "sides" and "disk".
pub fn square_without_disk(file: &Path, radius: f64, around: usize, rings: usize) {
    let node = |ring: usize, k: usize| 1 + ring * around + k % around;
    let growth = (0.5 / radius).powf(1.0 / rings as f64);
    let mut text = String::from(
        "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n\
         $PhysicalNames\n3\n1 1 \"sides\"\n1 2 \"disk\"\n2 3 \"fluid\"\n$EndPhysicalNames\n\
         $Entities\n0 2 1 0\n1 0 0 0 1 1 0 1 1 0\n2 0 0 0 1 1 0 1 2 0\n1 0 0 0 1 1 0 1 3 0\n\
         $EndEntities\n",
    );
    let count = around * (rings + 1);
    let _ = writeln!(text, "$Nodes\n1 {count} 1 {count}\n2 1 0 {count}");
    (1..=count).for_each(|tag| text.push_str(&format!("{tag}\n")));
    for ring in 0..=rings {
        for k in 0..around {
            let (sine, cosine) = (TAU * k as f64 / around as f64).sin_cos();
            let to_side = 0.5 / sine.abs().max(cosine.abs());
            // From the circle to the square: the share of the way that a growing row of cells has made.
            let share = (growth.powi(ring as i32) - 1.0) / (growth.powi(rings as i32) - 1.0);
            let reach = radius + share * (to_side - radius);
            let (x, y) = (0.5 + reach * cosine, 0.5 + reach * sine);
            let _ = writeln!(text, "{x:e} {y:e} 0");
        }
    }
    let total = 2 * around * (rings + 1);
    let _ = writeln!(text, "$EndNodes\n$Elements\n3 {total} 1 {total}");
    let mut tag = 0;
    let mut element = |text: &mut String, nodes: &[usize]| {
        tag += 1;
        let nodes: Vec<String> = nodes.iter().map(usize::to_string).collect();
        let _ = writeln!(text, "{tag} {}", nodes.join(" "));
    };
    for (curve, ring) in [(1, rings), (2, 0)] {
        let _ = writeln!(text, "1 {curve} 1 {around}");
        (0..around).for_each(|k| element(&mut text, &[node(ring, k), node(ring, k + 1)]));
    }
    let _ = writeln!(text, "2 1 2 {}", 2 * around * rings);
    for (ring, k) in (0..rings).flat_map(|ring| (0..around).map(move |k| (ring, k))) {
        let [a, b] = [node(ring, k), node(ring, k + 1)];
        let [d, c] = [node(ring + 1, k), node(ring + 1, k + 1)];
        element(&mut text, &[a, d, c]);
        element(&mut text, &[a, c, b]);
    }
    text.push_str("$EndElements\n");
    std::fs::write(file, text).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
}
