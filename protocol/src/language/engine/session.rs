//! The engine's end of a link while it serves: what is known about the exchange, what is kept back, what
//! it has cost; and what the loop asks of an engine in either seat.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::time::Duration;

use crate::language::codec;
use crate::language::error::Error;
use crate::language::field::Field;
use crate::language::header::FieldHeader;
use crate::language::message::{
    Advance, Capability, Configure, Diagnostic, Failure, FailureKind, Hello, Ready, Role,
    ToCoupler, ToEngine,
};
use crate::language::report::Report;
use crate::language::scene::Refinement;
use crate::run::limits;
use crate::run::process::cpu_seconds;
use crate::transport::channel::{Channel, Wait};
use crate::transport::exchange::{Counts, Moment};

use super::fields::{Inputs, Outputs};
use super::told::without;

/// How long a broken engine stays to tell why.
pub(crate) const LAST_WORDS: Duration = Duration::from_secs(5);

/// How often Hello is repeated until the coupler listens.
const KNOCK: Duration = Duration::from_millis(50);

/// An engine of either role, seen from the loop.
pub(crate) trait Seat {
    const ROLE: Role;
    fn identity(&self) -> (&'static str, &'static str);
    fn capabilities(&self) -> Vec<Capability>;
    /// Configure; sends the fields of `Ready`.
    fn configure(&mut self, configure: Configure, session: &mut Session) -> Result<Ready, Trouble>;
    fn advance(
        &mut self,
        request: &Advance,
        inputs: &Inputs<'_>,
        outputs: Outputs<'_>,
    ) -> Result<(Report, Vec<Diagnostic>), Failure>;
    fn commit(&mut self) -> Result<(), Failure>;
    /// Change the mesh to one of this epoch, unless it stays; sends the fields of `Ready`.
    fn adapt(
        &mut self,
        epoch: u64,
        sizes: &Refinement,
        session: &mut Session,
    ) -> Result<Option<Ready>, Trouble>;
    /// Take grains out; sends the fields of `Ready`.
    fn remove(&mut self, grains: &[usize], session: &mut Session) -> Result<Ready, Trouble>;
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

/// The engine's end of a link, with what is known about the exchange.
pub(crate) struct Session {
    pub channel: Box<dyn Channel>,
    pub counts: Counts,
    /// Fields of a candidate.
    pub(crate) answer: Vec<Field>,
    pub(crate) who: &'static str,
    pub(crate) step: u64,
    pub(crate) pass: u32,
    pub(crate) connect: Duration,
    pub(crate) idle: Duration,
    pub(crate) configured: bool,
    pub(crate) committed: Option<u64>,
    pub(crate) candidate: Option<u64>,
    pub(crate) withheld: Withheld,
    pub(crate) cost: Cost,
}

/// Fields of a candidate that are sent when they are asked for, and not with `Done`.
#[derive(Default)]
pub(crate) struct Withheld {
    /// Each with its numbers, those of the last candidate.
    pub(crate) fields: Vec<(Field, Vec<f64>)>,
    /// When that was; none before the first.
    pub(crate) moment: Option<Moment>,
}

impl Withheld {
    /// Grains left: so do their numbers.
    pub(crate) fn remove(&mut self, grains: &[usize], dimension: usize) {
        for (field, values) in &mut self.fields {
            // nothing is kept before the first step
            if !values.is_empty() {
                *values = without(values, field.components(dimension), grains);
            }
        }
    }

    /// Is this field kept back?
    pub(crate) fn has(&self, field: Field) -> bool {
        self.fields.iter().any(|&(withheld, _)| withheld == field)
    }
}

/// What this process has spent since the last `Commit`.
pub(crate) struct Cost {
    /// CPU time of the process then \[s\].
    cpu_then: f64,
    /// Wall time inside the engine \[s\].
    pub(crate) wall: f64,
}

impl Cost {
    /// Nothing yet.
    pub(crate) fn from_now() -> Cost {
        Cost {
            cpu_then: cpu_seconds(),
            wall: 0.0,
        }
    }

    /// `cpu_seconds` and `wall_seconds`, where the engine did not report them itself.
    pub(crate) fn add_to(&self, diagnostics: &mut Vec<Diagnostic>) {
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
    /// Of an engine that introduces itself like this.
    pub(crate) fn new(channel: Box<dyn Channel>, hello: &Hello) -> Session {
        Session {
            channel,
            counts: Counts::default(),
            answer: hello.answer(),
            who: hello.role.seat(),
            step: 0,
            pass: 0,
            connect: limits::CONNECT.duration(),
            idle: limits::IDLE.duration(),
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

    pub(crate) fn send(&mut self, message: &ToCoupler) -> Result<bool, Error> {
        let bytes = codec::encode(message)
            .map_err(|e| Error::invalid(self.who, self.step, "message", e.to_string()))?;
        self.channel.send_message(
            FieldHeader::message(self.step, self.pass, bytes.len()),
            &bytes,
        )
    }

    pub(crate) fn receive(&mut self, limit: Duration) -> Result<ToEngine, Error> {
        let awaited = if self.configured {
            "Advance, Commit or Finish"
        } else {
            "Configure"
        };
        let (header, bytes) = self
            .channel
            .receive_message(Wait::new(self.step, awaited, limit))?;
        header.validate_message("coupler", bytes.len())?;
        let message = codec::decode(&bytes)
            .map_err(|e| Error::invalid("coupler", self.step, "message", e.to_string()))?;
        if matches!(message, ToEngine::Adapt { .. }) {
            // in a run that is resumed no step was asked for yet
            (self.step, self.pass) = (header.step, header.pass);
        }
        Ok(message)
    }

    /// Repeat Hello until the coupler listens.
    pub(crate) fn say_hello(&mut self, hello: Hello) -> Result<(), Error> {
        let wait = Wait::new(0, "an ear for Hello", self.connect);
        let hello = ToCoupler::Hello(hello);
        while !self.send(&hello)? {
            self.channel.idle(wait, KNOCK)?;
        }
        Ok(())
    }

    /// Refuse what cannot be computed before the engine sees it.
    pub(crate) fn check_request(&mut self, request: &Advance) -> Result<(), Trouble> {
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

/// A message at the wrong moment: the engine leaves.
pub(crate) fn out_of_order(why: String) -> Trouble {
    Trouble::Broken(Failure::new(FailureKind::Engine, why))
}
