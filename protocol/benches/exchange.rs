//! Round trips between two processes: the protocol over shared memory beside a Unix socket that
//! carries the same bytes. `cargo bench -p protocol`
//!
//! `field`: n numbers there, n numbers back, one message each way; the engine reads and writes in
//! the shared buffers. `step`: one whole `Advance` of a particle engine, n numbers there and 3.5 n
//! back (positions, velocities, mean velocities, contacts), as the coupler calls it. Everybody
//! writes every number it sends and checks every number it receives for NaN.

use std::hint::black_box;
use std::io::{Read, Write};
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::{Path, PathBuf};
use std::process::{Child, Command};
use std::time::Duration;

use criterion::{BenchmarkId, Criterion};
use protocol::Error;
use protocol::channel::{Channel, Wait};
use protocol::configure::ParticleScene;
use protocol::engine::{FluidForces, GrainAnswer, InitialGrains, ParticleEngine, serve_particles};
use protocol::field::Field;
use protocol::header::{Expected, FieldHeader, Stage, require_finite};
use protocol::ipc::{coupler_link, engine_link};
use protocol::local::LIMITS;
use protocol::messages::{Advance, Capability, Diagnostic, Failure, Role};
use protocol::partner::Partner;
use protocol::process;
use protocol::runspace::RunSpace;

const ROLE: &str = "SILLAGE_BENCH_ROLE";
const SOCKET: &str = "SILLAGE_BENCH_SOCKET";
const SIZES: [usize; 3] = [100, 10_000, 1_000_000];
const LIMIT: Duration = Duration::from_secs(20);

/// Twice the input, over and over.
fn double(from: &[f64], to: &mut [f64]) {
    for part in to.chunks_mut(from.len().max(1)) {
        for (to, from) in part.iter_mut().zip(from) {
            *to = 2.0 * from;
        }
    }
}

/// Answers with twice the force.
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
        let force = fluid.force.unwrap_or_default();
        double(force, answer.position);
        double(force, answer.velocity);
        double(force, answer.mean_velocity);
        double(force, answer.contact);
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

fn expected(field: Field, count: usize) -> Expected {
    Expected {
        field,
        epoch: 1,
        step: 1,
        pass: 0,
        stage: Stage::Advance,
        entities: count / 2,
        time: 0.0,
    }
}

/// One field and one message to the partner.
fn send(link: &mut dyn Channel, field: Field, values: &[f64]) -> Result<(), Error> {
    link.send_field(field, expected(field, values.len()).header(), values)?;
    link.send_message(FieldHeader::message(1, 0, 1), &[0])?;
    Ok(())
}

/// Answers every field with one field, in the shared buffers.
fn serve_fields(link: &mut dyn Channel) -> Result<(), Error> {
    while !link.send_message(FieldHeader::message(0, 0, 1), &[0])? {
        link.idle(
            Wait::new(0, "the coupler", LIMIT),
            Duration::from_millis(20),
        )?;
    }
    loop {
        let wait = Wait::new(1, "a request", LIMIT);
        if link.receive_message(wait)?.1 != [0] {
            return Ok(());
        }
        let input = link.receive_field(Field::GrainForce, wait)?;
        let count = input.values().len();
        input.header().validate(
            "coupler",
            &expected(Field::GrainForce, count),
            input.values(),
        )?;
        let header = expected(Field::GrainVelocity, count).header();
        let mut output = link.loan_field(Field::GrainVelocity, header)?;
        double(input.values(), output.values());
        output.send()?;
        link.send_message(FieldHeader::message(1, 0, 1), &[0])?;
    }
}

fn fields(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("field");
    for count in SIZES {
        let run = RunSpace::create().unwrap();
        let mut engine = start("fields", &run.to_environment());
        let mut link = coupler_link(&run, Role::Particles).unwrap();
        let force: Vec<f64> = (0..count).map(|k| k as f64).collect();
        let wait = Wait::new(1, "the answer", Duration::from_secs(600));
        link.receive_message(wait).unwrap();
        group.bench_function(BenchmarkId::new("protocol", count), |bencher| {
            bencher.iter(|| {
                send(&mut *link, Field::GrainForce, black_box(&force)).unwrap();
                link.receive_message(wait).unwrap();
                let answer = link.receive_field(Field::GrainVelocity, wait).unwrap();
                let expected = expected(Field::GrainVelocity, count);
                answer
                    .header()
                    .validate("particles", &expected, answer.values())
                    .unwrap();
                answer.values()[count - 1]
            });
        });
        link.send_message(FieldHeader::message(1, 0, 1), &[1])
            .unwrap();
        engine.wait().unwrap();
        socket(&mut group, count, count);
    }
}

fn steps(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("step");
    for count in SIZES {
        let run = RunSpace::create().unwrap();
        let mut engine = start("steps", &run.to_environment());
        let mut link = Partner::accept(Role::Particles, &run, &LIMITS).unwrap();
        configure(&mut link, count / 2);
        let force: Vec<f64> = (0..count).map(|k| k as f64).collect();
        let [mut position, mut velocity, mut mean, mut contact] = [const { Vec::new() }; 4];
        let mut request = Advance {
            step: 1,
            pass: 0,
            time: 0.0,
            dt: 1.0,
            sub_steps: 0,
            tolerance: 1.0,
            fields: Vec::new(),
        };
        group.bench_function(BenchmarkId::new("protocol", count), |bencher| {
            bencher.iter(|| {
                request.pass += 1;
                let mut outputs = [
                    (Field::GrainPosition, &mut position),
                    (Field::GrainVelocity, &mut velocity),
                    (Field::GrainMeanVelocity, &mut mean),
                    (Field::GrainContact, &mut contact),
                ];
                let inputs = [(Field::GrainForce, black_box(force.as_slice()))];
                link.advance(&request, &inputs, &mut outputs).unwrap()
            });
        });
        link.finish().unwrap();
        engine.wait().unwrap();
        socket(&mut group, count, 7 * count / 2);
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

type Group<'a> = criterion::BenchmarkGroup<'a, criterion::measurement::WallTime>;

/// `there` numbers to a process, `back` numbers from it.
fn socket(group: &mut Group<'_>, there: usize, back: usize) {
    let path: PathBuf = std::env::temp_dir().join(format!("sillage-bench-{}", std::process::id()));
    let listener = UnixListener::bind(&path).unwrap();
    let name = (SOCKET.to_owned(), path.to_string_lossy().into_owned());
    let mut engine = start("socket", &[name]);
    let (mut stream, _) = listener.accept().unwrap();
    stream
        .write_all(bytes(&[there as f64, back as f64]))
        .unwrap();
    let force: Vec<f64> = (0..there).map(|k| k as f64).collect();
    let mut answer = vec![0.0; back];
    group.bench_function(BenchmarkId::new("unix socket", there), |bencher| {
        bencher.iter(|| {
            stream.write_all(bytes(black_box(&force))).unwrap();
            stream.read_exact(bytes_mut(&mut answer)).unwrap();
            require_finite("socket", 1, Field::GrainVelocity, &answer).unwrap();
            answer[back - 1]
        });
    });
    drop(stream);
    engine.wait().unwrap();
    std::fs::remove_file(&path).unwrap();
}

fn serve_socket() -> i32 {
    let mut stream = UnixStream::connect(std::env::var(SOCKET).unwrap()).unwrap();
    let mut counts = [0.0; 2];
    stream.read_exact(bytes_mut(&mut counts)).unwrap();
    let (mut input, mut output) = (vec![0.0; counts[0] as usize], vec![0.0; counts[1] as usize]);
    while stream.read_exact(bytes_mut(&mut input)).is_ok() {
        require_finite("socket", 1, Field::GrainForce, &input).unwrap();
        double(&input, &mut output);
        stream.write_all(bytes(&output)).unwrap();
    }
    0
}

fn bytes(values: &[f64]) -> &[u8] {
    // SAFETY: every f64 is eight initialised bytes.
    unsafe { std::slice::from_raw_parts(values.as_ptr().cast(), size_of_val(values)) }
}

fn bytes_mut(values: &mut [f64]) -> &mut [u8] {
    // SAFETY: every pattern of eight bytes is an f64.
    unsafe { std::slice::from_raw_parts_mut(values.as_mut_ptr().cast(), size_of_val(values)) }
}

fn start(role: &str, environment: &[(String, String)]) -> Child {
    let command = std::env::current_exe().unwrap();
    Command::new(command)
        .envs(environment.iter().cloned())
        .env(ROLE, role)
        .spawn()
        .unwrap()
}

fn main() {
    let particles = |work: fn(Box<dyn Channel>) -> Result<(), Error>| {
        process::exit_code("particles", |run| work(engine_link(run, Role::Particles)?))
    };
    match std::env::var(ROLE).as_deref() {
        Ok("socket") => std::process::exit(serve_socket()),
        Ok("fields") => std::process::exit(particles(|mut link| serve_fields(&mut *link))),
        Ok(_) => std::process::exit(particles(|link| serve_particles(&mut Doubler, link))),
        Err(_) => {}
    }
    let mut criterion = Criterion::default()
        .sample_size(20)
        .warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_secs(1))
        .configure_from_args();
    fields(&mut criterion);
    steps(&mut criterion);
    criterion.final_summary();
}
