//! What the coupler itself costs in a step: placing, depositing and sampling grains.
//!
//! `cargo bench -p coupler`: 10 000 grains on the mesh of `scenes/cloud-uniform.toml` (80 × 240 cells).

#![allow(missing_docs, reason = "criterion's macro makes a public function")]

use std::hint::black_box;

use coupler::transfer::{Mesh, Transfer};
use criterion::{Criterion, criterion_group, criterion_main};
use space::Vector;

const GRAINS: usize = 10_000;
const COLUMNS: usize = 80;
const ROWS: usize = 240;

/// A rectangle of unit cells, each cut into two triangles.
fn rectangle() -> Mesh<2, 3> {
    let node = |i: usize, j: usize| (j * (COLUMNS + 1) + i) as u32;
    let nodes = (0..(ROWS + 1) * (COLUMNS + 1)).map(|k| (k % (COLUMNS + 1), k / (COLUMNS + 1)));
    let cells = (0..ROWS * COLUMNS).map(|k| (k % COLUMNS, k / COLUMNS));
    let cut = |(i, j)| {
        let [a, b] = [node(i, j), node(i + 1, j)];
        let [c, d] = [node(i + 1, j + 1), node(i, j + 1)];
        [[a, b, c], [a, c, d]]
    };
    let node_position: Vec<Vector<2>> = nodes
        .map(|(i, j)| Vector::from([i as f64, j as f64]))
        .collect();
    let simplices: Vec<[u32; 3]> = cells.flat_map(cut).collect();
    let place = |corners: &[u32; 3]| corners.map(|node| node_position[node as usize]);
    let mut nodal_mass = vec![0.0; node_position.len()];
    for &corner in simplices.as_flattened() {
        nodal_mass[corner as usize] += 0.5 / 3.0;
    }
    Mesh {
        corners: simplices.iter().map(place).collect(),
        node_position,
        simplices,
        nodal_mass,
        period: [None, None],
    }
}

fn bench(criterion: &mut Criterion) {
    let mesh = rectangle();
    let golden = 0.618_033_988_749_894_9_f64;
    let positions: Vec<Vector<2>> = (0..GRAINS)
        .map(|k| {
            let across = (k as f64 * golden).fract() * COLUMNS as f64;
            Vector::from([across, (k as f64 + 0.5) / GRAINS as f64 * ROWS as f64])
        })
        .collect();
    let field: Vec<Vector<2>> = (0..mesh.node_position.len())
        .map(|k| Vector::from([(2 * k) as f64, (2 * k + 1) as f64]).map(f64::sin))
        .collect();
    let mut group = criterion.benchmark_group("transfer of 1e4 grains");
    let transfer = Transfer::new(&mesh, 1.0);
    for (name, radius) in [("of 0.2 cells", 0.1), ("of one cell", 0.5)] {
        let radii = vec![radius; GRAINS];
        let placement = transfer.place(&positions, &radii).expect("inside");
        group.bench_function(format!("place grains {name}"), |bencher| {
            bencher.iter(|| {
                transfer
                    .place(black_box(&positions), &radii)
                    .expect("inside")
            });
        });
        group.bench_function(format!("deposit a vector, grains {name}"), |bencher| {
            bencher.iter(|| transfer.deposit(&placement, |i| Vector::from([i as f64, 1.0])));
        });
        group.bench_function(format!("sample a vector, grains {name}"), |bencher| {
            bencher.iter(|| transfer.sample(&placement, black_box(&field)));
        });
    }
    group.finish();
}

criterion_group!(benches, bench);
criterion_main!(benches);
