//! What the coupler itself costs in a step: placing, depositing and sampling grains.
//!
//! `cargo bench -p coupler`: 10 000 grains on the mesh of `scenes/cloud.toml` (80 × 240 cells).

#![allow(missing_docs, reason = "criterion's macro makes a public function")]

use std::hint::black_box;

use coupler::transfer::Transfer;
use criterion::{Criterion, criterion_group, criterion_main};
use protocol::engine::MeshDescription;

const GRAINS: usize = 10_000;
const COLUMNS: usize = 80;
const ROWS: usize = 240;

/// A rectangle of unit cells, each cut into two triangles.
fn rectangle() -> MeshDescription {
    let node = |i: usize, j: usize| (j * (COLUMNS + 1) + i) as u32;
    let mut mesh = MeshDescription::default();
    for j in 0..=ROWS {
        for i in 0..=COLUMNS {
            mesh.node_position.extend([i as f64, j as f64]);
        }
    }
    for j in 0..ROWS {
        for i in 0..COLUMNS {
            let [a, b, c, d] = [
                node(i, j),
                node(i + 1, j),
                node(i + 1, j + 1),
                node(i, j + 1),
            ];
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    mesh.nodal_mass = vec![0.0; mesh.node_position.len() / 2];
    for corners in &mesh.triangles {
        let place = |k: u32| {
            let k = k as usize;
            [mesh.node_position[2 * k], mesh.node_position[2 * k + 1]]
        };
        let [a, b, c] = corners.map(place);
        mesh.triangle_position
            .push([a[0], a[1], b[0], b[1], c[0], c[1]]);
        for &corner in corners {
            mesh.nodal_mass[corner as usize] += 0.5 / 3.0;
        }
    }
    mesh
}

fn bench(criterion: &mut Criterion) {
    let mesh = rectangle();
    let golden = 0.618_033_988_749_894_9_f64;
    let positions: Vec<f64> = (0..GRAINS)
        .flat_map(|k| {
            let across = (k as f64 * golden).fract() * COLUMNS as f64;
            [across, (k as f64 + 0.5) / GRAINS as f64 * ROWS as f64]
        })
        .collect();
    let field: Vec<f64> = (0..mesh.node_position.len())
        .map(|k| (k as f64).sin())
        .collect();
    let mut group = criterion.benchmark_group("transfer of 1e4 grains");
    for (name, length) in [("lumped mass", 0.0), ("smoothed over two cells", 2.0)] {
        let transfer = Transfer::new(&mesh, length, 1.0).expect("a transfer");
        let placement = transfer.place(&positions).expect("inside");
        if length == 0.0 {
            group.bench_function("place", |bencher| {
                bencher.iter(|| transfer.place(black_box(&positions)).expect("inside"));
            });
        }
        group.bench_function(format!("deposit a vector, {name}"), |bencher| {
            bencher.iter(|| transfer.deposit_vector(&placement, |i| [i as f64, 1.0]));
        });
        group.bench_function(format!("sample a vector, {name}"), |bencher| {
            bencher.iter(|| transfer.sample_vector(&placement, black_box(&field)));
        });
    }
    group.finish();
}

criterion_group!(benches, bench);
criterion_main!(benches);
