//! A particle engine that computes almost nothing, reached over each transport: what an exchange
//! costs by itself. Everybody writes every number sent and checks every number received for NaN.

use std::io::{Read, Write};
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::Path;
use std::process::{Child, Command, ExitCode};
use std::time::Duration;

use protocol::Error;
use protocol::channel::{Channel, Wait};
use protocol::engine::{Computed, InitialGrains, Inputs, Outputs, ParticleEngine, serve_particles};
use protocol::field::Field;
use protocol::header::{Expected, FieldHeader, Stage, require_finite};
use protocol::ipc::{coupler_link, engine_link};
use protocol::local::{self, LIMITS};
use protocol::message::{Advance, Capability, Failure, Role};
use protocol::partner::Partner;
use protocol::process;
use protocol::report::ParticleReport;
use protocol::runspace::RunSpace;
use protocol::scene::ParticleScene;

/// Says which partner a child of this program is.
const ROLE: &str = "SILLAGE_EXCHANGE_ROLE";
/// Longest wait for the partner of [`Fields`].
const LIMIT: Duration = Duration::from_secs(60);
const SOCKET: &str = "SILLAGE_EXCHANGE_SOCKET";

/// Answers with twice the force.
struct Doubler;

/// Twice the input, over and over.
pub fn double(from: &[f64], to: &mut [f64]) {
    for part in to.chunks_mut(from.len().max(1)) {
        for (to, from) in part.iter_mut().zip(from) {
            *to = 2.0 * from;
        }
    }
}

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
        inputs: &Inputs<'_>,
        outputs: Outputs<'_>,
    ) -> Result<Computed<ParticleReport>, Failure> {
        let force = inputs.get(Field::GrainForce).unwrap_or_default();
        for (_, room) in outputs.into_all() {
            double(force, room);
        }
        Ok(ParticleReport::one_step().into())
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

/// One whole `Advance` at a time: n numbers there, 3.5 n back (positions, velocities, mean
/// velocities, contacts), as the coupler calls it.
pub struct Steps {
    link: Partner,
    /// The process at the other end, if it is one; and its run.
    process: Option<(Other, RunSpace)>,
    force: Vec<f64>,
    answers: [Vec<f64>; 4],
    request: Advance,
}

impl Steps {
    /// Through shared memory to another process, which is this program again.
    pub fn to_process(numbers: usize) -> Result<Steps, Error> {
        let run = RunSpace::create()?;
        let child = start("steps", &run.to_environment());
        let link = Partner::accept(Role::Particles, &run, &LIMITS)?;
        Steps::with(link, Some((child, run)), numbers)
    }

    /// To a thread of this process.
    pub fn to_thread(numbers: usize) -> Result<Steps, Error> {
        Steps::with(local::spawn_particles(|| Doubler)?, None, numbers)
    }

    fn with(
        mut link: Partner,
        process: Option<(Other, RunSpace)>,
        numbers: usize,
    ) -> Result<Steps, Error> {
        let grains = numbers / 2;
        let scene = ParticleScene {
            dimension: 2,
            gravity: vec![0.0, 0.0],
            walls: Vec::new(),
            period: vec![None, None],
            friction: 0.0,
            wall_friction: 0.0,
            inertia_factor: 0.5,
            tolerance: 1.0,
            solver: None,
            sweeps_max: 1,
            sub_steps_max: 1,
            threads: 1,
        };
        let at_rest = InitialGrains {
            dimension: 2,
            position: vec![0.0; 2 * grains],
            velocity: vec![0.0; 2 * grains],
            radius: vec![1.0; grains],
            mass: vec![1.0; grains],
            volume: vec![1.0; grains],
            fixed: vec![0.0; grains],
        };
        link.configure_particles(&scene, &at_rest)?;
        Ok(Steps {
            link,
            process,
            force: (0..2 * grains).map(|k| k as f64).collect(),
            answers: [const { Vec::new() }; 4],
            request: Advance {
                step: 1,
                pass: 0,
                time: 0.0,
                dt: 1.0,
                sub_steps: 0,
                tolerance: 1.0,
                fields: Vec::new(),
            },
        })
    }

    /// There and back.
    pub fn round_trip(&mut self) -> Result<(), Error> {
        self.request.pass += 1;
        let [position, velocity, mean, contact] = &mut self.answers;
        let mut outputs = [
            (Field::GrainPosition, position),
            (Field::GrainVelocity, velocity),
            (Field::GrainMeanVelocity, mean),
            (Field::GrainContact, contact),
        ];
        let inputs = [(Field::GrainForce, self.force.as_slice())];
        self.link
            .advance(&self.request, &inputs, &mut outputs)
            .map(|_| ())
    }

    /// Let the partner go.
    pub fn finish(mut self) -> Result<(), Error> {
        self.link.finish()?;
        if let Some((child, _)) = &mut self.process {
            child.wait();
        }
        Ok(())
    }
}

/// One field of n numbers there and one back through shared memory, a message each way: the link
/// alone, without the meaning of a step.
pub struct Fields {
    link: Box<dyn Channel>,
    process: (Other, RunSpace),
    force: Vec<f64>,
}

impl Fields {
    /// To another process, which is this program again.
    pub fn to_process(numbers: usize) -> Result<Fields, Error> {
        let run = RunSpace::create()?;
        let child = start("fields", &run.to_environment());
        let mut link = coupler_link(&run, Role::Particles)?;
        link.receive_message(Wait::new(1, "the partner", LIMIT))?;
        Ok(Fields {
            link,
            process: (child, run),
            force: (0..numbers).map(|k| k as f64).collect(),
        })
    }

    /// There and back.
    pub fn round_trip(&mut self) -> Result<(), Error> {
        let count = self.force.len();
        let header = expected(Field::GrainForce, count).header();
        self.link
            .send_field(Field::GrainForce, header, &self.force)?;
        self.link
            .send_message(FieldHeader::message(1, 0, 1), &[0])?;
        let wait = Wait::new(1, "the answer", LIMIT);
        self.link.receive_message(wait)?;
        let answer = self.link.receive_field(Field::GrainVelocity, wait)?;
        let expected = expected(Field::GrainVelocity, count);
        answer
            .header()
            .validate("particles", &expected, answer.values())
    }

    /// Let the partner go.
    pub fn finish(mut self) -> Result<(), Error> {
        self.link
            .send_message(FieldHeader::message(1, 0, 1), &[1])?;
        self.process.0.wait();
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
        dimension: 2,
        entities: count / 2,
        time: 0.0,
    }
}

/// Answers every field with one field, in the shared buffers.
fn serve_fields(link: &mut dyn Channel) -> Result<(), Error> {
    while !link.send_message(FieldHeader::message(0, 0, 1), &[0])? {
        let wait = Wait::new(0, "the coupler", LIMIT);
        link.idle(wait, Duration::from_millis(20))?;
    }
    loop {
        let wait = Wait::new(1, "a request", LIMIT);
        if link.receive_message(wait)?.1 != [0] {
            return Ok(());
        }
        let input = link.receive_field(Field::GrainForce, wait)?;
        let count = input.values().len();
        let expected_input = expected(Field::GrainForce, count);
        input
            .header()
            .validate("coupler", &expected_input, input.values())?;
        let header = expected(Field::GrainVelocity, count).header();
        let mut output = link.loan_field(Field::GrainVelocity, header)?;
        double(input.values(), output.values());
        output.send()?;
        link.send_message(FieldHeader::message(1, 0, 1), &[0])?;
    }
}

/// A Unix socket to another process that carries the same bytes.
pub struct Socket {
    stream: UnixStream,
    child: Other,
    force: Vec<f64>,
    answer: Vec<f64>,
}

impl Socket {
    /// `there` numbers to a process, `back` numbers from it.
    pub fn to_process(there: usize, back: usize) -> std::io::Result<Socket> {
        let folder = tempfile::tempdir()?;
        let path = folder.path().join("exchange");
        let listener = UnixListener::bind(&path)?;
        let name = (SOCKET.to_owned(), path.to_string_lossy().into_owned());
        let child = start("socket", &[name]);
        let (mut stream, _) = listener.accept()?;
        stream.write_all(bytes(&[there as f64, back as f64]))?;
        Ok(Socket {
            stream,
            child,
            force: (0..there).map(|k| k as f64).collect(),
            answer: vec![0.0; back],
        })
    }

    /// There and back.
    pub fn round_trip(&mut self) -> std::io::Result<()> {
        self.stream.write_all(bytes(&self.force))?;
        self.stream.read_exact(bytes_mut(&mut self.answer))?;
        require_finite("socket", 1, (Field::GrainVelocity, 2), &self.answer)
            .map_err(std::io::Error::other)
    }

    /// Let the partner go.
    pub fn finish(mut self) -> std::io::Result<()> {
        drop(self.stream);
        self.child.wait();
        Ok(())
    }
}

fn serve_socket() -> std::io::Result<()> {
    let path = std::env::var(SOCKET).map_err(std::io::Error::other)?;
    let mut stream = UnixStream::connect(path)?;
    let mut counts = [0.0; 2];
    stream.read_exact(bytes_mut(&mut counts))?;
    let (mut input, mut output) = (vec![0.0; counts[0] as usize], vec![0.0; counts[1] as usize]);
    while stream.read_exact(bytes_mut(&mut input)).is_ok() {
        require_finite("socket", 1, (Field::GrainForce, 2), &input)
            .map_err(std::io::Error::other)?;
        double(&input, &mut output);
        stream.write_all(bytes(&output))?;
    }
    Ok(())
}

fn bytes(values: &[f64]) -> &[u8] {
    // SAFETY: every f64 is eight initialised bytes.
    unsafe { std::slice::from_raw_parts(values.as_ptr().cast(), size_of_val(values)) }
}

fn bytes_mut(values: &mut [f64]) -> &mut [u8] {
    // SAFETY: every pattern of eight bytes is an f64.
    unsafe { std::slice::from_raw_parts_mut(values.as_mut_ptr().cast(), size_of_val(values)) }
}

/// The process at the other end: this program again. Gone, at the latest, with this.
struct Other(Child);

impl Other {
    /// Wait for its end, after it was told to leave.
    fn wait(&mut self) {
        // It is ours to wait for: nothing can be wrong but that it is gone already.
        let _ = self.0.wait();
    }
}

impl Drop for Other {
    fn drop(&mut self) {
        let _ = self.0.kill();
        self.wait();
    }
}

fn start(role: &str, environment: &[(String, String)]) -> Other {
    let command = std::env::current_exe().expect("this program");
    let child = Command::new(command)
        .envs(environment.iter().cloned())
        .env(ROLE, role)
        .spawn();
    Other(child.expect("started again"))
}

/// First thing in `main`: a child of this program is the partner, and ends with this code.
pub fn be_the_partner_if_asked() -> Option<ExitCode> {
    let code = match std::env::var(ROLE).as_deref() {
        Ok("socket") => i32::from(serve_socket().is_err()),
        Ok("fields") => process::exit_code("particles", |run| {
            serve_fields(&mut *engine_link(run, Role::Particles)?)
        }),
        Ok(_) => process::exit_code("particles", |run| {
            serve_particles(&mut Doubler, engine_link(run, Role::Particles)?)
        }),
        Err(_) => return None,
    };
    Some(ExitCode::from(u8::try_from(code).unwrap_or(1)))
}
