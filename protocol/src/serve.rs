//! The loop of an engine: message in → call → message out.
//!
//! Whatever the engine or the coupler does wrong is answered by `Failed`; the loop itself ends with
//! an error only when the coupler is gone, silent for too long, or speaks another protocol. A panic
//! of an engine is caught and answered too. A broken engine stays for a moment and answers every
//! request with its failure, so that the coupler learns why before the engine is gone.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use crate::PROTOCOL_VERSION;
use crate::channel::{Channel, Loan, Wait, seconds};
use crate::codec;
use crate::engine::{FluidEngine, ParticleEngine};
use crate::error::Error;
use crate::field::Field;
use crate::header::{FieldHeader, Stage, require_finite};
use crate::ipc::engine_link;
use crate::links::{Counts, Moment};
use crate::messages::{
    Advance, Capability, Configure, Diagnostic, Done, Failure, FailureKind, Hello, Ready, Role,
    ToCoupler, ToEngine,
};
use crate::process::{self, cpu_seconds};
use crate::seats::{FluidSeat, ParticleSeat};

/// How long a broken engine stays to tell why.
const LAST_WORDS: Duration = Duration::from_secs(5);
/// How often Hello is repeated until the coupler listens.
const KNOCK: Duration = Duration::from_millis(50);

/// An engine of either role, seen from the loop.
pub(crate) trait Seat {
    const ROLE: Role;
    /// Fields of a candidate.
    const ANSWER: &'static [Field];
    fn identity(&self) -> (&'static str, &'static str);
    fn capabilities(&self) -> Vec<Capability>;
    /// Configure; sends the fields of `Ready`.
    fn configure(&mut self, configure: Configure, session: &mut Session) -> Result<Ready, Trouble>;
    fn advance(
        &mut self,
        request: &Advance,
        inputs: &[(Field, &[f64])],
        outputs: &mut [&mut [f64]],
    ) -> Result<Vec<Diagnostic>, Failure>;
    fn commit(&mut self) -> Result<(), Failure>;
    fn save(&mut self, path: &Path) -> Result<(), Failure>;
    fn restore(&mut self, path: &Path) -> Result<(), Failure>;
}

/// Why a request could not be served.
pub(crate) enum Trouble {
    /// Tell the coupler and go on.
    Failed(Failure),
    /// Tell the coupler and leave.
    Broken(Failure),
    /// The link itself is unusable.
    Link(Error),
}

impl From<Error> for Trouble {
    fn from(error: Error) -> Trouble {
        match error {
            // The coupler sent it: it has to know.
            Error::Invalid { .. } | Error::NotFinite { .. } => {
                Trouble::Failed(Failure::new(FailureKind::NotFinite, error.to_string()))
            }
            other => Trouble::Link(other),
        }
    }
}

/// Call into an engine; a panic is a failure that it does not survive.
pub(crate) fn guarded<T>(call: impl FnOnce() -> Result<T, Failure>) -> Result<T, Trouble> {
    match catch_unwind(AssertUnwindSafe(call)) {
        Ok(result) => result.map_err(Trouble::Failed),
        Err(panic) => {
            let text = panic.downcast_ref::<&str>().map(|text| (*text).to_owned());
            let text = text
                .or_else(|| panic.downcast_ref::<String>().cloned())
                .unwrap_or_default();
            Err(Trouble::Broken(Failure::new(
                FailureKind::Engine,
                format!("panicked: {text}"),
            )))
        }
    }
}

fn fatal(trouble: Trouble) -> Trouble {
    match trouble {
        Trouble::Failed(failure) => Trouble::Broken(failure),
        other => other,
    }
}

fn out_of_order(why: String) -> Trouble {
    Trouble::Broken(Failure::new(FailureKind::Engine, why))
}

/// The engine's end of a link, with what is known about the exchange.
pub(crate) struct Session {
    pub channel: Box<dyn Channel>,
    pub counts: Counts,
    who: &'static str,
    step: u64,
    pass: u32,
    connect: Duration,
    idle: Duration,
    configured: bool,
    committed: Option<u64>,
    candidate: Option<u64>,
    withheld: Withheld,
    cost: Cost,
}

/// Fields of a candidate that are sent when they are asked for, and not with `Done`.
#[derive(Default)]
struct Withheld {
    /// Each with its numbers, those of the last candidate.
    fields: Vec<(Field, Vec<f64>)>,
    /// When that was; none before the first.
    moment: Option<Moment>,
}

impl Withheld {
    fn has(&self, field: Field) -> bool {
        self.fields.iter().any(|&(withheld, _)| withheld == field)
    }
}

/// What this process has spent since the last `Commit`.
struct Cost {
    /// CPU time of the process then \[s\].
    cpu_then: f64,
    /// Wall time inside the engine \[s\].
    wall: f64,
}

impl Cost {
    fn from_now() -> Cost {
        Cost {
            cpu_then: cpu_seconds(),
            wall: 0.0,
        }
    }

    /// `cpu_seconds` and `wall_seconds`, where the engine did not report them itself.
    fn add_to(&self, diagnostics: &mut Vec<Diagnostic>) {
        for (name, value) in [
            ("cpu_seconds", cpu_seconds() - self.cpu_then),
            ("wall_seconds", self.wall),
        ] {
            if !diagnostics.iter().any(|own| own.name == name) {
                let name = name.to_owned();
                diagnostics.push(Diagnostic { name, value });
            }
        }
    }
}

impl Session {
    fn new(channel: Box<dyn Channel>, who: &'static str) -> Session {
        const CONNECT: f64 = 60.0;
        const IDLE: f64 = 86_400.0;
        Session {
            channel,
            counts: Counts::default(),
            who,
            step: 0,
            pass: 0,
            connect: seconds(limit("SILLAGE_CONNECT_LIMIT", CONNECT)),
            idle: seconds(limit("SILLAGE_IDLE_LIMIT", IDLE)),
            configured: false,
            committed: None,
            candidate: None,
            withheld: Withheld::default(),
            cost: Cost::from_now(),
        }
    }

    /// For the fields that come with the message just received.
    pub(crate) fn field_wait(&self) -> Wait<'static> {
        Wait::new(self.step, "a field", self.connect)
    }

    fn send(&mut self, message: &ToCoupler) -> Result<bool, Error> {
        let bytes = codec::encode(message)
            .map_err(|e| Error::invalid(self.who, self.step, "message", e.to_string()))?;
        self.channel.send_message(
            FieldHeader::message(self.step, self.pass, bytes.len()),
            &bytes,
        )
    }

    fn receive(&mut self, limit: Duration) -> Result<ToEngine, Error> {
        let awaited = if self.configured {
            "Advance, Commit or Finish"
        } else {
            "Configure"
        };
        let (header, bytes) = self
            .channel
            .receive_message(Wait::new(self.step, awaited, limit))?;
        header.validate_message("coupler", bytes.len())?;
        codec::decode(&bytes)
            .map_err(|e| Error::invalid("coupler", self.step, "message", e.to_string()))
    }

    /// Repeat Hello until the coupler listens.
    fn say_hello(&mut self, hello: Hello) -> Result<(), Error> {
        let wait = Wait::new(0, "an ear for Hello", self.connect);
        let hello = ToCoupler::Hello(hello);
        while !self.send(&hello)? {
            self.channel.idle(wait, KNOCK)?;
        }
        Ok(())
    }

    /// Refuse what cannot be computed before the engine sees it.
    fn check_request(&mut self, request: &Advance) -> Result<(), Trouble> {
        if !self.configured {
            return Err(out_of_order("Advance before Configure".to_owned()));
        }
        (self.step, self.pass) = (request.step, request.pass);
        let next = self.committed.map_or(request.step.max(1), |step| step + 1);
        if request.step != next {
            return Err(out_of_order(format!(
                "Advance to step {}, expected {next}",
                request.step
            )));
        }
        let invalid = |what, value| {
            let why = format!("{what} of the Advance to step {} is {value}", request.step);
            Err(Trouble::Failed(Failure::new(FailureKind::NotFinite, why)))
        };
        if !request.time.is_finite() {
            return invalid("time", request.time);
        }
        if !(request.dt.is_finite() && request.dt > 0.0) {
            return invalid("dt", request.dt);
        }
        if !(request.tolerance.is_finite() && request.tolerance >= 0.0) {
            return invalid("tolerance", request.tolerance);
        }
        Ok(())
    }
}

fn limit(name: &str, default: f64) -> f64 {
    std::env::var(name)
        .ok()
        .and_then(|text| text.parse().ok())
        .unwrap_or(default)
}

/// Serve the coupler at the other end of `link` until `Finish`.
pub fn serve_fluid(engine: &mut impl FluidEngine, link: Box<dyn Channel>) -> Result<(), Error> {
    serve(&mut FluidSeat(engine), link)
}

/// Serve the coupler at the other end of `link` until `Finish`.
pub fn serve_particles(
    engine: &mut impl ParticleEngine,
    link: Box<dyn Channel>,
) -> Result<(), Error> {
    serve(&mut ParticleSeat(engine), link)
}

/// `main` of a fluid engine's process: enters the run named by the environment, serves the coupler
/// until `Finish`, returns the exit code.
pub fn run_fluid(mut engine: impl FluidEngine) -> ExitCode {
    process::run(Role::Fluid.seat(), |runspace| {
        let link = engine_link(runspace, Role::Fluid)?;
        serve_fluid(&mut engine, link)
    })
}

/// `main` of a particle engine's process; see [`run_fluid`].
pub fn run_particles(mut engine: impl ParticleEngine) -> ExitCode {
    process::run(Role::Particles.seat(), |runspace| {
        let link = engine_link(runspace, Role::Particles)?;
        serve_particles(&mut engine, link)
    })
}

fn serve<S: Seat>(seat: &mut S, link: Box<dyn Channel>) -> Result<(), Error> {
    let mut session = Session::new(link, S::ROLE.seat());
    let (engine, version) = seat.identity();
    session.say_hello(Hello {
        role: S::ROLE,
        engine: engine.to_owned(),
        version: version.to_owned(),
        protocol: PROTOCOL_VERSION,
        process: std::process::id(),
        capabilities: [seat.capabilities(), vec![Capability::FieldsOnRequest]].concat(),
    })?;
    loop {
        let message = session.receive(session.idle)?;
        let result = match message {
            ToEngine::Finish => return Ok(()),
            other => handle(seat, &mut session, other),
        };
        match result {
            Ok(()) => {}
            Err(Trouble::Link(error)) => return Err(error),
            Err(Trouble::Failed(failure)) => {
                tracing::warn!("step {}: {}", session.step, failure.why);
                session.send(&ToCoupler::Failed(failure))?;
            }
            Err(Trouble::Broken(failure)) => return Err(last_words(&mut session, failure)),
        }
    }
}

/// One request; the engine's failure after anything but `Advance` is fatal.
fn handle<S: Seat>(seat: &mut S, session: &mut Session, message: ToEngine) -> Result<(), Trouble> {
    match message {
        ToEngine::Configure(configure) => {
            if session.configured {
                return Err(out_of_order("Configure for the second time".to_owned()));
            }
            let ready = seat.configure(configure, session).map_err(fatal)?;
            session.configured = true;
            session.cost = Cost::from_now();
            session.send(&ToCoupler::Ready(ready))?;
        }
        ToEngine::Advance(request) => advance(seat, session, &request)?,
        ToEngine::Commit { step } => {
            if session.candidate != Some(step) {
                return Err(out_of_order(format!(
                    "Commit of step {step} without a candidate for it"
                )));
            }
            session.cost = Cost::from_now();
            guarded(|| seat.commit()).map_err(fatal)?;
            (session.committed, session.candidate) = (Some(step), None);
        }
        ToEngine::Save { path } => {
            guarded(|| seat.save(Path::new(&path))).map_err(fatal)?;
            session.send(&ToCoupler::Stored)?;
        }
        ToEngine::Restore { path } => {
            guarded(|| seat.restore(Path::new(&path))).map_err(fatal)?;
            (session.committed, session.candidate) = (None, None);
            session.withheld.moment = None;
            session.send(&ToCoupler::Stored)?;
        }
        ToEngine::Withhold { fields } => withhold::<S>(session, &fields)?,
        ToEngine::Tell { fields } => tell(session, fields)?,
        ToEngine::Finish => {}
    }
    Ok(())
}

fn withhold<S: Seat>(session: &mut Session, fields: &[Field]) -> Result<(), Trouble> {
    for (place, field) in fields.iter().enumerate() {
        if !S::ANSWER.contains(field) || fields[..place].contains(field) {
            return Err(out_of_order(format!(
                "Withhold of {}, which is named twice or is not of a candidate",
                field.name()
            )));
        }
    }
    session.withheld = Withheld {
        fields: fields.iter().map(|&field| (field, Vec::new())).collect(),
        moment: None,
    };
    Ok(())
}

/// Send what was kept of the accepted state.
fn tell(session: &mut Session, fields: Vec<Field>) -> Result<(), Trouble> {
    let accepted = session
        .withheld
        .moment
        .filter(|_| session.candidate.is_none());
    let Some(moment) = accepted else {
        return Err(out_of_order("Tell without an accepted step".to_owned()));
    };
    let kept = &session.withheld.fields;
    for &field in &fields {
        let Some((_, values)) = kept.iter().find(|&&(withheld, _)| withheld == field) else {
            let why = format!("Tell of {}, which is not withheld", field.name());
            return Err(out_of_order(why));
        };
        session
            .counts
            .send(&mut *session.channel, field, moment, values)?;
    }
    session.send(&ToCoupler::Told { fields })?;
    Ok(())
}

/// Read the inputs and write the candidate in the transport's own buffers.
fn advance<S: Seat>(seat: &mut S, session: &mut Session, request: &Advance) -> Result<(), Trouble> {
    // All inputs are taken from their queues before anything is refused: nothing stays behind.
    let mut received = Vec::with_capacity(request.fields.len());
    for &field in &request.fields {
        let wait = Wait::new(request.step, field.name(), session.connect);
        received.push(session.channel.receive_field(field, wait)?);
    }
    session.check_request(request)?;
    session.candidate = None;
    let given = Moment {
        step: request.step,
        pass: request.pass,
        stage: Stage::Advance,
        time: request.time,
    };
    let mut inputs = Vec::with_capacity(received.len());
    for (&field, input) in request.fields.iter().zip(&received) {
        input.header().validate(
            "coupler",
            &session.counts.expect(field, given),
            input.values(),
        )?;
        inputs.push((field, input.values()));
    }
    let answered = Moment {
        stage: Stage::Done,
        time: request.time + request.dt,
        ..given
    };
    let (withheld, channel) = (&mut session.withheld, &mut *session.channel);
    withheld.moment = None;
    let mut fields = Vec::with_capacity(S::ANSWER.len());
    let mut loans = Vec::with_capacity(S::ANSWER.len());
    for &field in S::ANSWER {
        if !withheld.has(field) {
            let header = session.counts.expect(field, answered).header();
            loans.push(channel.loan_field(field, header)?);
            fields.push(field);
        }
    }
    for (field, values) in &mut withheld.fields {
        values.clear();
        values.resize(session.counts.expect(*field, answered).count(), f64::NAN);
    }
    let begin = Instant::now();
    let result = guarded(|| {
        let mut outputs = in_order(S::ANSWER, &fields, &mut loans, &mut withheld.fields);
        seat.advance(request, &inputs, &mut outputs)
    });
    session.cost.wall += begin.elapsed().as_secs_f64();
    let mut diagnostics = result?;
    session.cost.add_to(&mut diagnostics);
    // What is not sent is not looked at by its receiver.
    for (field, values) in &withheld.fields {
        require_finite(session.who, request.step, *field, values)?;
    }
    for loan in loans {
        loan.send()?;
    }
    withheld.moment = Some(answered);
    session.candidate = Some(request.step);
    let (step, pass) = (request.step, request.pass);
    session.send(&ToCoupler::Done(Done {
        step,
        pass,
        fields,
        diagnostics,
    }))?;
    Ok(())
}

/// Where the engine writes each field of a candidate: into the transport, or into what is kept.
fn in_order<'a>(
    answer: &[Field],
    sent: &[Field],
    loans: &'a mut [Box<dyn Loan>],
    kept: &'a mut [(Field, Vec<f64>)],
) -> Vec<&'a mut [f64]> {
    let loans = loans.iter_mut().map(|loan| loan.values());
    let kept = kept
        .iter_mut()
        .map(|(field, values)| (*field, values.as_mut_slice()));
    let mut outputs: Vec<(Field, &mut [f64])> =
        sent.iter().copied().zip(loans).chain(kept).collect();
    outputs.sort_by_key(|(field, _)| answer.iter().position(|own| own == field));
    outputs.into_iter().map(|(_, values)| values).collect()
}

/// Answer everything with the failure until the coupler says Finish, leaves, or time is up.
fn last_words(session: &mut Session, failure: Failure) -> Error {
    let error = Error::Engine {
        who: session.who.to_owned(),
        step: session.step,
        failure: failure.clone(),
    };
    let wait = Wait::new(session.step, "Finish", LAST_WORDS);
    let answer = ToCoupler::Failed(failure);
    while session.send(&answer).is_ok() {
        loop {
            match session.receive(wait.left()) {
                Ok(ToEngine::Commit { .. } | ToEngine::Withhold { .. }) => {}
                Ok(ToEngine::Finish) | Err(_) => return error,
                Ok(_) => break,
            }
        }
    }
    error
}
