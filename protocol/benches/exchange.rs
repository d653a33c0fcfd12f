//! Round trip of n numbers there and n numbers back between two processes: the protocol over
//! shared memory beside a Unix socket that carries the same bytes.
//!
//! Both ends do the same work in both cases: the caller hands over a slice and gets a vector, the
//! engine reads every number and writes every number. `cargo bench -p protocol`

use std::hint::black_box;
use std::io::{Read, Write};
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::{Path, PathBuf};
use std::process::{Child, Command};
use std::time::Duration;

use criterion::{BenchmarkId, Criterion, Throughput};
use protocol::configure::ParticleScene;
use protocol::engine::{FluidForces, GrainAnswer, InitialGrains, ParticleEngine, serve_particles};
use protocol::field::Field;
use protocol::ipc::engine_link;
use protocol::local::LIMITS;
use protocol::messages::{Advance, Capability, Diagnostic, Failure, Role};
use protocol::partner::Partner;
use protocol::process;
use protocol::runspace::RunSpace;

const ROLE: &str = "SILLAGE_BENCH_ROLE";
const SOCKET: &str = "SILLAGE_BENCH_SOCKET";
const SIZES: [usize; 3] = [100, 10_000, 1_000_000];

/// Doubles `GrainForce` into `GrainVelocity`; the other answers are zero.
struct Doubler;

impl ParticleEngine for Doubler {
    fn identity(&self) -> (&'static str, &'static str) {
        ("doubler", "1")
    }
    fn capabilities(&self) -> Vec<Capability> {
        Vec::new()
    }
    fn configure(
        &mut self,
        _: &ParticleScene,
        grains: InitialGrains,
    ) -> Result<InitialGrains, Failure> {
        Ok(grains)
    }
    fn advance(
        &mut self,
        _: &Advance,
        fluid: &FluidForces<'_>,
        answer: GrainAnswer<'_>,
    ) -> Result<Vec<Diagnostic>, Failure> {
        double(fluid.force.unwrap_or_default(), answer.velocity);
        answer.position.fill(0.0);
        answer.mean_velocity.fill(0.0);
        answer.contact.fill(0.0);
        Ok(Vec::new())
    }
    fn commit(&mut self) -> Result<(), Failure> {
        Ok(())
    }
    fn save(&mut self, _: &Path) -> Result<(), Failure> {
        Ok(())
    }
    fn restore(&mut self, _: &Path) -> Result<(), Failure> {
        Ok(())
    }
}

fn double(from: &[f64], to: &mut [f64]) {
    for (to, from) in to.iter_mut().zip(from) {
        *to = 2.0 * from;
    }
}

fn bytes(values: &[f64]) -> &[u8] {
    // SAFETY: every f64 is eight initialised bytes.
    unsafe { std::slice::from_raw_parts(values.as_ptr().cast(), size_of_val(values)) }
}

fn bytes_mut(values: &mut [f64]) -> &mut [u8] {
    // SAFETY: every pattern of eight bytes is an f64.
    unsafe { std::slice::from_raw_parts_mut(values.as_mut_ptr().cast(), size_of_val(values)) }
}

/// The socket's engine: a count, then that many numbers, answered by as many.
fn serve_socket() -> i32 {
    let mut stream = UnixStream::connect(std::env::var(SOCKET).unwrap()).unwrap();
    let (mut input, mut output) = (Vec::new(), Vec::new());
    let mut count = [0; 8];
    while stream.read_exact(&mut count).is_ok() {
        let count = u64::from_ne_bytes(count) as usize;
        input.resize(count, 0.0);
        output.resize(count, 0.0);
        stream.read_exact(bytes_mut(&mut input)).unwrap();
        double(&input, &mut output);
        stream.write_all(bytes(&output)).unwrap();
    }
    0
}

fn start(role: &str, environment: &[(String, String)]) -> Child {
    let command = std::env::current_exe().unwrap();
    Command::new(command)
        .envs(environment.iter().cloned())
        .env(ROLE, role)
        .spawn()
        .unwrap()
}

fn over_shared_memory(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("round trip");
    for count in SIZES {
        let run = RunSpace::create().unwrap();
        let mut engine = start("particles", &run.to_environment());
        let mut link = Partner::accept(Role::Particles, &run, &LIMITS).unwrap();
        configure(&mut link, count / 2);
        let force: Vec<f64> = (0..count).map(|k| k as f64).collect();
        let mut velocity = Vec::new();
        let mut pass = 0;
        group.throughput(Throughput::Bytes(16 * count as u64));
        group.bench_with_input(BenchmarkId::new("protocol", count), &count, |bencher, _| {
            bencher.iter(|| {
                pass += 1;
                let request = Advance {
                    step: 1,
                    pass,
                    time: 0.0,
                    dt: 1.0,
                    sub_steps: 0,
                    tolerance: 1.0,
                    fields: Vec::new(),
                };
                let inputs = [(Field::GrainForce, black_box(force.as_slice()))];
                link.advance(
                    &request,
                    &inputs,
                    &mut [(Field::GrainVelocity, &mut velocity)],
                )
                .unwrap();
                velocity[count - 1]
            });
        });
        link.finish().unwrap();
        engine.wait().unwrap();
    }
}

fn configure(link: &mut Partner, grains: usize) {
    let scene = ParticleScene {
        gravity: [0.0, 0.0],
        walls: Vec::new(),
        period: [None, None],
        friction: 0.0,
        wall_friction: 0.0,
        inertia_factor: 0.5,
        tolerance: 1.0,
        sweeps_max: 1,
        sub_steps_max: 1,
        threads: 1,
    };
    let grains = InitialGrains {
        position: vec![0.0; 2 * grains],
        velocity: vec![0.0; 2 * grains],
        radius: vec![1.0; grains],
        mass: vec![1.0; grains],
        volume: vec![1.0; grains],
        fixed: vec![0.0; grains],
    };
    link.configure_particles(&scene, &grains).unwrap();
}

fn over_a_socket(criterion: &mut Criterion) {
    let path: PathBuf = std::env::temp_dir().join(format!("sillage-bench-{}", std::process::id()));
    let listener = UnixListener::bind(&path).unwrap();
    let mut group = criterion.benchmark_group("round trip");
    for count in SIZES {
        let mut engine = start(
            "socket",
            &[(SOCKET.to_owned(), path.to_string_lossy().into_owned())],
        );
        let (mut stream, _) = listener.accept().unwrap();
        let force: Vec<f64> = (0..count).map(|k| k as f64).collect();
        let mut velocity = vec![0.0; count];
        group.throughput(Throughput::Bytes(16 * count as u64));
        group.bench_with_input(
            BenchmarkId::new("unix socket", count),
            &count,
            |bencher, _| {
                bencher.iter(|| {
                    stream.write_all(&(count as u64).to_ne_bytes()).unwrap();
                    stream.write_all(bytes(black_box(&force))).unwrap();
                    stream.read_exact(bytes_mut(&mut velocity)).unwrap();
                    velocity[count - 1]
                });
            },
        );
        drop(stream);
        engine.wait().unwrap();
    }
    std::fs::remove_file(&path).unwrap();
}

fn main() {
    match std::env::var(ROLE).as_deref() {
        Ok("socket") => std::process::exit(serve_socket()),
        Ok(_) => std::process::exit(process::exit_code("particles", |run| {
            serve_particles(&mut Doubler, engine_link(run, Role::Particles)?)
        })),
        Err(_) => {}
    }
    let mut criterion = Criterion::default()
        .sample_size(20)
        .warm_up_time(Duration::from_millis(500))
        .measurement_time(Duration::from_secs(2))
        .configure_from_args();
    over_shared_memory(&mut criterion);
    over_a_socket(&mut criterion);
    criterion.final_summary();
}
