//! The transfer between grains and mesh: what it conserves, and that sampling is its adjoint.

use coupler::transfer::Transfer;
use protocol::engine::MeshDescription;

/// A unit square of n×n cells, each cut along the same diagonal.
fn square(cells: usize) -> MeshDescription {
    let edge = 1.0 / cells as f64;
    let side = cells + 1;
    let mut mesh = MeshDescription {
        nodal_mass: vec![0.0; side * side],
        ..MeshDescription::default()
    };
    for node in 0..side * side {
        mesh.node_position
            .extend([(node % side) as f64 * edge, (node / side) as f64 * edge]);
    }
    for cell in 0..cells * cells {
        let corner = (cell / cells) * side + cell % cells;
        for nodes in [
            [corner, corner + 1, corner + side + 1],
            [corner, corner + side + 1, corner + side],
        ] {
            let mut corners = [0.0; 6];
            for (place, node) in nodes.into_iter().enumerate() {
                corners[2 * place] = mesh.node_position[2 * node];
                corners[2 * place + 1] = mesh.node_position[2 * node + 1];
                mesh.nodal_mass[node] += edge * edge / 6.0;
            }
            mesh.triangles.push(nodes.map(|node| node as u32));
            mesh.triangle_position.push(corners);
        }
    }
    mesh
}

/// Numbers in (0, 1) that repeat.
fn noise(seed: usize) -> f64 {
    (seed as f64 * 12.9898 + 78.233)
        .sin()
        .mul_add(43758.5453, 0.0)
        .rem_euclid(1.0)
}

#[test]
fn deposited_volume_is_the_grains_volume_and_sampling_is_the_adjoint_of_deposit() {
    let mesh = square(16);
    let count = 1000;
    let positions: Vec<f64> = (0..2 * count).map(noise).collect();
    let values: Vec<f64> = (0..count)
        .map(|i| 10_f64.powf(6.0 * noise(3 * i + 1)))
        .collect();
    let rough: Vec<f64> = (0..mesh.nodal_mass.len())
        .map(|a| 1e6 * (noise(7 * a + 5) - 0.5))
        .collect();
    println!("| L/h | volume defect | action + reaction |");
    for ratio in [0.0, 0.5, 2.0, 6.0] {
        let transfer = Transfer::new(&mesh, ratio / 16.0, 1.0).expect("a transfer");
        let placement = transfer.place(&positions).expect("all inside");
        let nodal = transfer.deposit(&placement, |i| values[i]);
        let total: f64 = values.iter().sum();
        let deposited: f64 = nodal.iter().zip(&mesh.nodal_mass).map(|(c, l)| c * l).sum();
        let sampled = transfer.sample(&placement, &rough);
        let on_fluid: f64 = (0..rough.len())
            .map(|a| mesh.nodal_mass[a] * nodal[a] * rough[a])
            .sum();
        let on_grains: f64 = (0..count).map(|i| values[i] * sampled[i]).sum();
        let size: f64 = (0..count).map(|i| (values[i] * sampled[i]).abs()).sum();
        let (volume, force) = (
            (deposited / total - 1.0).abs(),
            (on_fluid - on_grains).abs() / size,
        );
        println!("| {ratio} | {volume:.1e} | {force:.1e} |");
        assert!(volume <= 1e-14, "L/h {ratio}: volume defect {volume}");
        assert!(force <= 1e-12, "L/h {ratio}: force defect {force}");
    }
}

#[test]
fn shape_functions_reproduce_a_linear_field_and_points_just_outside_are_clipped() {
    let mesh = square(7);
    let transfer = Transfer::new(&mesh, 0.0, 1.0).expect("a transfer");
    let linear: Vec<f64> = mesh
        .node_position
        .chunks_exact(2)
        .map(|x| 2.0 + 3.0 * x[0] - x[1])
        .collect();
    let points = [0.3, 0.7, 0.0, 1.0, 1.0, 0.0, 0.5, 0.5, 1.01, 0.4];
    let placement = transfer.place(&points).expect("near the mesh");
    let sampled = transfer.sample(&placement, &linear);
    for (value, point) in sampled.iter().zip(points.chunks_exact(2)).take(4) {
        assert!((value - (2.0 + 3.0 * point[0] - point[1])).abs() < 1e-13);
    }
    assert!(
        (sampled[4] - (2.0 + 3.0 - 0.4)).abs() < 0.05,
        "clipped to the boundary: {}",
        sampled[4]
    );
    let error = transfer
        .place(&[0.5, 0.5, 3.0, 0.5])
        .expect_err("far outside");
    assert!(error.to_string().contains("grain 1"), "{error}");
    assert!(transfer.place(&[f64::NAN, 0.5]).is_err());
}
