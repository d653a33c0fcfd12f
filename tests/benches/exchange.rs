//! Round trips between two processes: the protocol over shared memory beside a Unix socket that
//! carries the same bytes. `cargo bench -p tests`
//!
//! `field`: n numbers there, n numbers back, one message each way; the engine reads and writes in
//! the shared buffers. `step`: one whole `Advance` of a particle engine, n numbers there and 3.5 n
//! back (positions, velocities, mean velocities, contacts), as the coupler calls it. Everybody
//! writes every number it sends and checks every number it receives for NaN. `memory`: writing n
//! numbers once and reading them once, in one process: what no exchange can beat.

use std::hint::black_box;
use std::process::ExitCode;
use std::time::Duration;

use criterion::{BenchmarkId, Criterion};
use tests::exchange::{Fields, Socket, Steps, be_the_partner_if_asked, double};

const SIZES: [usize; 3] = [100, 10_000, 1_000_000];

fn fields(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("field");
    for count in SIZES {
        let mut link = Fields::to_process(count).unwrap();
        group.bench_function(BenchmarkId::new("protocol", count), |bencher| {
            bencher.iter(|| link.round_trip().unwrap());
        });
        link.finish().unwrap();
        let mut link = Socket::to_process(count, count).unwrap();
        group.bench_function(BenchmarkId::new("unix socket", count), |bencher| {
            bencher.iter(|| link.round_trip().unwrap());
        });
        link.finish().unwrap();
        let from: Vec<f64> = (0..count).map(|k| k as f64).collect();
        let mut to = vec![0.0; count];
        group.bench_function(BenchmarkId::new("memory", count), |bencher| {
            bencher.iter(|| {
                double(black_box(&from), &mut to);
                black_box(&to).iter().all(|value| value.is_finite())
            });
        });
    }
}

fn steps(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("step");
    for count in SIZES {
        let mut link = Steps::to_process(count).unwrap();
        group.bench_function(BenchmarkId::new("protocol", count), |bencher| {
            bencher.iter(|| link.round_trip().unwrap());
        });
        link.finish().unwrap();
        let mut link = Socket::to_process(count, 7 * count / 2).unwrap();
        group.bench_function(BenchmarkId::new("unix socket", count), |bencher| {
            bencher.iter(|| link.round_trip().unwrap());
        });
        link.finish().unwrap();
    }
}

fn main() -> ExitCode {
    if let Some(code) = be_the_partner_if_asked() {
        return code;
    }
    let mut criterion = Criterion::default()
        .sample_size(20)
        .warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_secs(1))
        .configure_from_args();
    fields(&mut criterion);
    steps(&mut criterion);
    criterion.final_summary();
    ExitCode::SUCCESS
}
