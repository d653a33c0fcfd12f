//! A particle engine written by hand on the transport alone: grains that fall through everything.
//! It can be told to break any one rule of the protocol, named by the check that must notice it.

use std::fmt::Display;
use std::time::Duration;

use nix::sys::signal::{SigHandler, Signal, signal};
use protocol::channel::{Channel, Wait};
use protocol::codec;
use protocol::engine::InitialGrains;
use protocol::error::Error;
use protocol::field::Field;
use protocol::field::GRAINS;
use protocol::header::{Expected, FieldHeader, Stage};
use protocol::ipc::engine_link;
use protocol::message::{
    Advance, Capability, Configure, Done, Failure, FailureKind, Hello, Ready, Role, ToCoupler,
    ToEngine,
};
use protocol::report::{ParticleReport, Report};
use protocol::runspace::{ENV_RUN, RunSpace};
use protocol::{PROTOCOL_VERSION, process};

/// Which rule is broken; "none" keeps them all.
pub const FAULT: &str = "SILLAGE_TEST_FAULT";

/// Entry of the engine's process; as a test it does nothing.
#[test]
fn child() {
    let Ok(fault) = std::env::var(FAULT) else {
        return;
    };
    let mut entered = false;
    let code = process::exit_code("particles", |run| {
        entered = true;
        serve(run, &fault)
    });
    let well_all_the_same = !entered
        && match std::env::var_os(ENV_RUN) {
            None => fault == "no-run",
            Some(_) => fault == "seat-taken",
        };
    std::process::exit(if well_all_the_same { 0 } else { code });
}

/// What is asked again must be answered the same: what an engine that fails at it would look at.
#[derive(Default)]
struct History {
    in_step: u32,
    last: Option<Advance>,
    smallest: f64,
    largest: f64,
}

/// Fields of a candidate.
type Answer = Vec<(Field, Vec<f64>)>;

struct Toy {
    link: Box<dyn Channel>,
    fault: String,
    accepted: InitialGrains,
    candidate: Option<(u64, InitialGrains)>,
    withheld: Vec<Field>,
    /// The last request, and its answer.
    kept: Option<(Advance, Answer)>,
    committed: Option<u64>,
    /// Of its grains.
    epoch: u64,
    configured: bool,
    history: History,
    /// What it was doing, named as the check of a death then.
    state: &'static str,
}

/// Why a request is not served.
enum Trouble {
    Refused(Failure),
    Broken(Failure),
    Link(Error),
}

fn broken(why: impl Display) -> Trouble {
    Trouble::Broken(Failure::new(FailureKind::Engine, why.to_string()))
}

impl From<Error> for Trouble {
    fn from(error: Error) -> Trouble {
        match error {
            Error::Invalid { .. } | Error::NotFinite { .. } => {
                Trouble::Refused(Failure::new(FailureKind::NotFinite, error.to_string()))
            }
            other => Trouble::Link(other),
        }
    }
}

fn seconds(name: &str, default: f64) -> Duration {
    let text = std::env::var(name).ok();
    Duration::from_secs_f64(text.and_then(|text| text.parse().ok()).unwrap_or(default))
}

fn serve(run: &RunSpace, fault: &str) -> Result<(), Error> {
    if fault == "told-to-end" {
        // SAFETY: ignoring a signal runs no code.
        let _ = unsafe { signal(Signal::SIGTERM, SigHandler::SigIgn) };
    }
    let mut toy = Toy {
        link: engine_link(run, Role::Particles)?,
        fault: fault.to_owned(),
        accepted: InitialGrains::default(),
        candidate: None,
        withheld: Vec::new(),
        kept: None,
        committed: None,
        epoch: 1,
        configured: false,
        history: History::default(),
        state: "death-before-hello",
    };
    match toy.live() {
        Err(Error::PartnerLost { .. }) if fault == toy.state => Ok(()),
        Err(Error::TimeLimit { .. }) if toy.is("no-coupler") && toy.knocks() => Ok(()),
        other => other,
    }
}

impl Toy {
    fn is(&self, fault: &str) -> bool {
        self.fault == fault
    }

    fn knocks(&self) -> bool {
        self.state == "death-before-hello"
    }

    fn send(&mut self, message: &ToCoupler) -> Result<bool, Error> {
        let bytes = codec::encode(message).expect("small");
        let header = FieldHeader::message(0, 0, bytes.len());
        self.link.send_message(header, &bytes)
    }

    fn live(&mut self) -> Result<(), Error> {
        let version = if self.is("hello") { "" } else { "1" };
        let hello = ToCoupler::Hello(Hello {
            role: Role::Particles,
            engine: "toy".to_owned(),
            version: version.to_owned(),
            protocol: PROTOCOL_VERSION,
            process: std::process::id(),
            capabilities: vec![
                Capability::ImplicitDrag,
                Capability::Checkpoint,
                Capability::FieldsOnRequest,
                Capability::RemovesGrains,
            ],
            token: self.link.token().map(str::to_owned),
        });
        let wait = Wait::new(0, "an ear", seconds("SILLAGE_CONNECT_LIMIT", 60.0));
        while !self.send(&hello)? {
            self.link.idle(wait, Duration::from_millis(20))?;
        }
        self.state = "death-after-hello";
        loop {
            let Some(message) = self.receive()? else {
                continue;
            };
            if message == ToEngine::Finish {
                let well = !self.is("finish") || self.committed.is_some();
                return if well { Ok(()) } else { Err(out_of_sorts()) };
            }
            match self.handle(message) {
                Ok(None) => {}
                Ok(Some(answer)) => {
                    if !(self.is("death-within-advance") && matches!(answer, ToCoupler::Done(_))) {
                        self.send(&answer)?;
                    } else if self.send(&answer).is_err() {
                        return Ok(());
                    }
                }
                Err(Trouble::Link(error)) => return Err(error),
                Err(Trouble::Refused(failure)) => {
                    self.send(&ToCoupler::Failed(failure))?;
                }
                Err(Trouble::Broken(failure)) => return self.stay_broken(failure),
            }
        }
    }

    fn receive(&mut self) -> Result<Option<ToEngine>, Error> {
        let idle = if self.is("silent-coupler") {
            Duration::from_secs(60)
        } else {
            seconds("SILLAGE_IDLE_LIMIT", 60.0)
        };
        let (header, bytes) = self.link.receive_message(Wait::new(0, "a request", idle))?;
        if self.is("protocol-of-message") && header.protocol != PROTOCOL_VERSION {
            return Ok(None);
        }
        let decoded = header
            .validate_message("coupler", bytes.len())
            .and_then(|()| {
                codec::decode(&bytes).map_err(|error| Error::Invalid {
                    who: "coupler".to_owned(),
                    step: 0,
                    what: "message".to_owned(),
                    why: error.to_string(),
                })
            });
        match decoded {
            Err(Error::Invalid { .. }) if self.is("garbage") => Ok(None),
            other => other.map(Some),
        }
    }

    fn stay_broken(&mut self, failure: Failure) -> Result<(), Error> {
        let (who, step) = ("particles".to_owned(), 0);
        let error = Error::Engine {
            who,
            step,
            failure: failure.clone(),
        };
        self.send(&ToCoupler::Failed(failure.clone()))?;
        while let Ok(Some(message)) = self.receive() {
            match message {
                ToEngine::Finish => break,
                ToEngine::Commit { .. } => {}
                _ => drop(self.send(&ToCoupler::Failed(failure.clone()))),
            }
        }
        Err(error)
    }

    fn handle(&mut self, message: ToEngine) -> Result<Option<ToCoupler>, Trouble> {
        match message {
            ToEngine::Configure(Configure::Fluid(_)) if self.is("other-seat") => {
                Ok(Some(ToCoupler::Stored))
            }
            ToEngine::Configure(Configure::Fluid(_)) => Err(broken("not for this seat")),
            ToEngine::Configure(Configure::Particles { .. }) if self.configured => {
                if self.is("configure-twice") {
                    return Ok(Some(ToCoupler::Stored));
                }
                Err(broken("Configure twice"))
            }
            ToEngine::Configure(Configure::Particles { grain_count, .. }) => {
                let ready = self.configure(grain_count as usize);
                // Only a failed `Advance` is survived.
                ready.map(Some).map_err(|trouble| match trouble {
                    Trouble::Refused(failure) => Trouble::Broken(failure),
                    other => other,
                })
            }
            ToEngine::Advance(request) => self.advance(&request).map(Some),
            ToEngine::Commit { step } => self.commit(step).map(|()| None),
            ToEngine::Save { path } => {
                let mut state = self.accepted.clone();
                if self.is("checkpoint") {
                    state.velocity.fill(0.0);
                }
                let numbers = [state.position, state.velocity].concat();
                let bytes: Vec<u8> = numbers.iter().flat_map(|v| v.to_le_bytes()).collect();
                std::fs::write(path, bytes).map_err(broken)?;
                Ok(Some(ToCoupler::Stored))
            }
            ToEngine::Restore { path } => self.restore(&path).map(Some),
            ToEngine::Finish => Ok(None),
            ToEngine::Withhold { fields } => {
                self.withheld = fields;
                Ok(None)
            }
            ToEngine::Tell { fields } => self.tell(fields).map(Some),
            ToEngine::Remove { grains } => self.remove(&grains).map(Some),
            ToEngine::Adapt { .. } => Err(broken("grains have no mesh")),
        }
    }

    fn remove(&mut self, grains: &[u64]) -> Result<ToCoupler, Trouble> {
        let count = self.accepted.count();
        let mut gone: Vec<usize> = grains.iter().map(|&grain| grain as usize).collect();
        if gone.iter().any(|&grain| grain >= count) {
            return Err(broken(format!("Remove of {gone:?} of {count} grains")));
        }
        if self.is("remove") {
            gone = vec![count - 1];
        }
        self.accepted = self.accepted.without(&gone);
        (self.epoch, self.kept) = (self.epoch + 1, None);
        let left = self.accepted.clone();
        for (field, values) in left.slices() {
            let expected = self.at(field, &request_at(0.0), Stage::Ready);
            self.link.send_field(field, expected.header(), values)?;
        }
        Ok(ToCoupler::Ready(Ready::Grains {
            epoch: self.epoch,
            dimension: 2,
            grains: left.count() as u64,
        }))
    }

    /// What a header must say of the present grains.
    fn at(&self, field: Field, request: &Advance, stage: Stage) -> Expected {
        Expected {
            epoch: self.epoch,
            ..at(field, request, self.accepted.count(), stage)
        }
    }

    fn configure(&mut self, count: usize) -> Result<ToCoupler, Trouble> {
        let mut arrays = Vec::new();
        for field in GRAINS {
            let expected = Expected {
                epoch: 0,
                ..at(field, &request_at(0.0), count, Stage::Configure)
            };
            arrays.push(self.field(field, &expected)?);
        }
        let arrays = <[Vec<f64>; 6]>::try_from(arrays).expect("six");
        self.accepted = InitialGrains::from_arrays(2, arrays);
        let grains = self.accepted.clone();
        let mut fixed = grains.fixed.clone();
        if self.is("ready") {
            fixed[0] = 0.5;
        }
        for (field, values) in [
            (Field::GrainPosition, &grains.position),
            (Field::GrainVelocity, &grains.velocity),
            (Field::GrainRadius, &grains.radius),
            (Field::GrainMass, &grains.mass),
            (Field::GrainVolume, &grains.volume),
            (Field::GrainFixed, &fixed),
        ] {
            let header = at(field, &request_at(0.0), count, Stage::Ready).header();
            self.link.send_field(field, header, values)?;
        }
        self.configured = true;
        self.state = "death-configured";
        Ok(ToCoupler::Ready(Ready::Grains {
            epoch: 1,
            dimension: 2,
            grains: count as u64,
        }))
    }

    /// An input, checked; with a fault the check does not see what it must see.
    fn field(&mut self, field: Field, expected: &Expected) -> Result<Vec<f64>, Trouble> {
        let wait = Wait::new(0, field.name(), Duration::from_secs(5));
        let received = self.link.receive_field(field, wait)?;
        let (mut header, mut values) = (*received.header(), received.values().to_vec());
        drop(received);
        let right = expected.header();
        match self.fault.as_str() {
            "epoch" => header.epoch = right.epoch,
            "protocol-of-field" => header.protocol = right.protocol,
            "header" => {
                let FieldHeader {
                    protocol,
                    epoch,
                    count,
                    ..
                } = header;
                header = FieldHeader {
                    protocol,
                    epoch,
                    count,
                    ..right
                };
            }
            "count" if expected.stage == Stage::Advance => {
                values.resize(expected.count(), 0.0);
                header.count = right.count;
            }
            "grain-count" if expected.stage == Stage::Configure => {
                values.resize(expected.count(), 1.0);
                header.count = right.count;
            }
            _ => {}
        }
        match header.validate("coupler", expected, &values) {
            Err(Error::NotFinite { value, .. })
                if self.is(if value == "NaN" { "nan" } else { "infinity" }) => {}
            other => other?,
        }
        Ok(values)
    }

    fn advance(&mut self, request: &Advance) -> Result<ToCoupler, Trouble> {
        self.state = "death-within-advance";
        let mut inputs = Vec::new();
        let mut refusal = None;
        for &field in &request.fields {
            let expected = self.at(field, request, Stage::Advance);
            match self.field(field, &expected) {
                Ok(values) => inputs.push((field, values)),
                Err(trouble) => refusal = Some(trouble),
            }
        }
        if !self.configured {
            let why = "Advance before Configure";
            let lenient = self.is("advance-first");
            return if lenient {
                Ok(ToCoupler::Stored)
            } else {
                Err(broken(why))
            };
        }
        let next = self.committed.map_or(request.step, |step| step + 1);
        if request.step != next && !self.is("step-left-out") {
            return Err(broken(format!("step {}, expected {next}", request.step)));
        }
        let numbers = [request.time, request.dt, request.tolerance];
        let sound = numbers.iter().all(|n| n.is_finite()) && request.dt > 0.0;
        if !sound && !self.is("request") {
            let why = format!("{request:?}");
            return Err(Trouble::Refused(Failure::new(FailureKind::NotFinite, why)));
        }
        if let Some(trouble) = refusal {
            return Err(trouble);
        }
        if self.is("defaults") && inputs.is_empty() {
            let failure = Failure::new(FailureKind::Engine, "nothing given");
            return Err(Trouble::Refused(failure));
        }
        if self.is("many-steps") && request.step == 15 {
            let failure = Failure::new(FailureKind::NotConverged, "tired");
            return Err(Trouble::Refused(failure));
        }
        let candidate = self.fall(request, &inputs);
        self.answer(request, candidate)
    }

    /// m dv/dt = m g + q − γ v, the drag implicit.
    fn fall(&mut self, request: &Advance, inputs: &[(Field, Vec<f64>)]) -> InitialGrains {
        const GRAVITY: [f64; 2] = [0.0, -9.81];
        let input = |wanted: Field, k: usize| {
            let found = inputs.iter().find(|(field, _)| *field == wanted);
            found.map_or(0.0, |(_, values)| values[k])
        };
        let (old, dt) = (&self.accepted, request.dt);
        let mut new = old.clone();
        for k in (0..old.position.len()).filter(|k| old.fixed[k / 2] == 0.0) {
            let (mass, drag) = (old.mass[k / 2], input(Field::GrainDrag, k / 2));
            let force = mass * GRAVITY[k % 2] + input(Field::GrainForce, k);
            new.velocity[k] = (mass * old.velocity[k] + dt * force) / (mass + drag * dt);
            new.position[k] += dt * new.velocity[k];
        }
        let history = &mut self.history;
        history.smallest = if history.in_step == 0 {
            dt
        } else {
            history.smallest.min(dt)
        };
        history.in_step += 1;
        history.largest = history.largest.max(dt);
        let spoilt = match self.fault.as_str() {
            "fresh-process" => true,
            "same-request" => request.step == 3 && history.last.as_ref() == Some(request),
            "same-passes" => request.pass == 2 && history.in_step > 3,
            "larger-step" => history.largest > 10.0 * dt,
            "smaller-step" => request.step == 2 && history.smallest < dt,
            _ => false,
        };
        if spoilt {
            new.velocity[1] *= 1.0 + 1e-12 * f64::from(std::process::id());
        }
        history.last = Some(request.clone());
        new
    }

    fn answer(&mut self, request: &Advance, new: InitialGrains) -> Result<ToCoupler, Trouble> {
        let count = new.radius.len();
        let moved = |k: usize| (new.position[k] - self.accepted.position[k]) / request.dt;
        let mut mean: Vec<f64> = (0..2 * count).map(moved).collect();
        if self.is("advance") {
            mean.iter_mut().for_each(|v| *v *= 0.5);
        }
        let fields: Answer = vec![
            (Field::GrainPosition, new.position.clone()),
            (Field::GrainVelocity, new.velocity.clone()),
            (Field::GrainMeanVelocity, mean),
            (Field::GrainContact, vec![0.0; count]),
        ];
        let sent = |(field, _): &&(Field, Vec<f64>)| !self.withheld.contains(field);
        let sent: Vec<Field> = fields
            .iter()
            .filter(sent)
            .map(|(field, _)| *field)
            .collect();
        self.kept = Some((request.clone(), fields));
        for field in &sent {
            match self.send_kept(*field) {
                // The refusal of a number that is not finite is the coupler's then.
                Err(error) if !self.is("death-within-advance") => return Err(error),
                _ => {}
            }
        }
        self.candidate = Some((request.step, new));
        let (step, pass) = (request.step, request.pass);
        Ok(ToCoupler::Done(Done {
            step,
            pass,
            fields: sent,
            report: Report::Particles(ParticleReport::one_step()),
            diagnostics: Vec::new(),
        }))
    }

    fn send_kept(&mut self, field: Field) -> Result<(), Trouble> {
        let (request, fields) = self.kept.as_ref().ok_or_else(|| broken("no candidate"))?;
        let time = request.time + request.dt;
        let header = self.at(field, request, Stage::Done).header();
        let own = fields.iter().find(|(kept, _)| *kept == field);
        let (_, values) = own.ok_or_else(|| broken("not of a candidate"))?;
        let header = FieldHeader { time, ..header };
        Ok(self.link.send_field(field, header, values)?)
    }

    fn tell(&mut self, fields: Vec<Field>) -> Result<ToCoupler, Trouble> {
        let accepted = self.candidate.is_none() || self.is("withheld");
        if !accepted || fields.iter().any(|field| !self.withheld.contains(field)) {
            return Err(broken(format!("Tell of {fields:?} at the wrong moment")));
        }
        for field in &fields {
            self.send_kept(*field)?;
        }
        Ok(ToCoupler::Told { fields })
    }

    fn commit(&mut self, step: u64) -> Result<(), Trouble> {
        self.state = "death-after-commit";
        let new = match self.candidate.take() {
            Some((of, new)) if of == step || self.is("commit-other-step") => new,
            None if self.is("commit-nothing") && self.committed.is_none() => return Ok(()),
            None if self.is("commit-twice") && self.committed == Some(step) => return Ok(()),
            _ => {
                return Err(broken(format!(
                    "Commit of step {step} without its candidate"
                )));
            }
        };
        if !(self.is("commit") && step == 1) {
            self.accepted = new;
        }
        if self.is("discarded-candidate") && self.history.in_step >= 3 {
            self.accepted.position[1] *= 1.0 + 1e-12;
        }
        self.committed = Some(step);
        self.history = History::default();
        Ok(())
    }

    fn restore(&mut self, path: &str) -> Result<ToCoupler, Trouble> {
        let half = self.accepted.position.len();
        let read = std::fs::read(path).map_err(broken);
        let numbers = read.and_then(|bytes| {
            if bytes.len() != 16 * half {
                return Err(broken(format!("{} bytes", bytes.len())));
            }
            let (chunks, _) = bytes.as_chunks::<8>();
            Ok(chunks
                .iter()
                .map(|&b| f64::from_le_bytes(b))
                .collect::<Vec<f64>>())
        });
        match numbers {
            Err(_) if self.is("bad-checkpoint") => {}
            Err(trouble) => return Err(trouble),
            Ok(numbers) => {
                self.accepted.position = numbers[..half].to_vec();
                self.accepted.velocity = numbers[half..].to_vec();
            }
        }
        (self.committed, self.candidate) = (None, None);
        Ok(ToCoupler::Stored)
    }
}

fn out_of_sorts() -> Error {
    Error::Transport {
        what: "finish".to_owned(),
        why: "out of sorts".to_owned(),
    }
}

fn request_at(time: f64) -> Advance {
    Advance {
        step: 0,
        pass: 0,
        time,
        dt: 0.0,
        sub_steps: 0,
        tolerance: 0.0,
        fields: Vec::new(),
    }
}

fn at(field: Field, request: &Advance, entities: usize, stage: Stage) -> Expected {
    Expected {
        field,
        epoch: 1,
        step: request.step,
        pass: request.pass,
        stage,
        dimension: 2,
        entities,
        time: request.time,
    }
}
