//! The loop of an engine: message in → call → message out.
//!
//! Whatever the engine or the coupler does wrong is answered by `Failed`; the loop itself ends with
//! an error only when the coupler is gone, silent for too long, or speaks another protocol. A panic
//! of an engine is caught and answered too. A broken engine stays for a moment and answers every
//! request with its failure, so that the coupler learns why before the engine is gone.

use std::path::Path;
use std::time::Instant;

use crate::language::error::Error;
use crate::language::field::Field;
use crate::language::header::PROTOCOL_VERSION;
use crate::language::header::{Stage, require_finite};
use crate::language::message::{Advance, Capability, Done, Failure, Hello, ToCoupler, ToEngine};
use crate::transport::channel::{Channel, Loan, Received, Wait};
use crate::transport::exchange::Moment;

use super::fields::{Inputs, Outputs};
use super::session::{Cost, LAST_WORDS, Seat, Session, Trouble, Withheld, guarded, out_of_order};

fn fatal(trouble: Trouble) -> Trouble {
    match trouble {
        Trouble::Failed(failure) => Trouble::Broken(failure),
        other => other,
    }
}

pub(crate) fn serve<S: Seat>(seat: &mut S, link: Box<dyn Channel>) -> Result<(), Error> {
    let (engine, version) = seat.identity();
    let hello = Hello {
        role: S::ROLE,
        engine: engine.to_owned(),
        version: version.to_owned(),
        protocol: PROTOCOL_VERSION,
        process: std::process::id(),
        capabilities: [seat.capabilities(), vec![Capability::FieldsOnRequest]].concat(),
        token: link.token().map(str::to_owned),
    };
    let mut session = Session::new(link, &hello);
    session.say_hello(hello)?;
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

/// One request; the engine's failure after anything but `Advance` and `Save` is fatal.
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
            guarded(|| seat.save(Path::new(&path)))?;
            session.send(&ToCoupler::Stored)?;
        }
        ToEngine::Restore { path } => {
            guarded(|| seat.restore(Path::new(&path))).map_err(fatal)?;
            (session.committed, session.candidate) = (None, None);
            session.withheld.moment = None;
            session.send(&ToCoupler::Stored)?;
        }
        ToEngine::Withhold { fields } => withhold(session, &fields)?,
        ToEngine::Tell { fields } => tell(session, fields)?,
        ToEngine::Remove { grains } => {
            let grains = leaving(session, &grains)?;
            let ready = seat.remove(&grains, session).map_err(fatal)?;
            session.send(&ToCoupler::Ready(ready))?;
        }
        ToEngine::Adapt { epoch, sizes } => {
            if !session.configured || session.candidate.is_some() || epoch <= session.counts.epoch {
                return Err(out_of_order(format!(
                    "Adapt to epoch {epoch} in epoch {}, before Configure or while a candidate waits for its commit",
                    session.counts.epoch
                )));
            }
            let ready = seat.adapt(epoch, &sizes, session).map_err(fatal)?;
            session.send(&ready.map_or(ToCoupler::Kept, ToCoupler::Ready))?;
        }
        ToEngine::Finish => {}
    }
    Ok(())
}

fn withhold(session: &mut Session, fields: &[Field]) -> Result<(), Trouble> {
    for (place, field) in fields.iter().enumerate() {
        if !session.answer.contains(field) || fields[..place].contains(field) {
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

/// The numbers of a `Remove`, in their order and of grains that there are.
fn leaving(session: &Session, grains: &[u64]) -> Result<Vec<usize>, Trouble> {
    if session.candidate.is_some() {
        return Err(out_of_order(
            "Remove while a candidate waits for its commit".to_owned(),
        ));
    }
    let count = session.counts.grains as u64;
    let ascending = grains.is_sorted_by(|a, b| a < b);
    if !ascending || grains.last().is_some_and(|&last| last >= count) || grains.is_empty() {
        let why = format!(
            "Remove of {} grains whose numbers are not ascending and below {count}",
            grains.len()
        );
        return Err(out_of_order(why));
    }
    Ok(grains.iter().map(|&grain| grain as usize).collect())
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
    let received = receive(session, request)?;
    session.check_request(request)?;
    session.candidate = None;
    let given = Moment {
        step: request.step,
        pass: request.pass,
        stage: Stage::Advance,
        time: request.time,
    };
    let inputs = checked(session, given, &request.fields, &received)?;
    let answered = Moment {
        stage: Stage::Done,
        time: request.time + request.dt,
        ..given
    };
    session.withheld.moment = None;
    let (fields, mut loans) = loan(session, answered)?;
    let begin = Instant::now();
    let result = guarded(|| {
        let outputs = room(&fields, &mut loans, &mut session.withheld.fields);
        seat.advance(request, &Inputs::new(&inputs), outputs)
    });
    session.cost.wall += begin.elapsed().as_secs_f64();
    let (report, mut diagnostics) = result?;
    session.cost.add_to(&mut diagnostics);
    // What is not sent is not looked at by its receiver.
    for (field, values) in &session.withheld.fields {
        let field = (*field, session.counts.dimension);
        require_finite(session.who, request.step, field, values)?;
    }
    for loan in loans {
        loan.send()?;
    }
    session.withheld.moment = Some(answered);
    session.candidate = Some(request.step);
    session.send(&ToCoupler::Done(Done {
        step: request.step,
        pass: request.pass,
        fields,
        report,
        diagnostics,
    }))?;
    Ok(())
}

/// All inputs are taken from their queues before anything is refused: nothing stays behind.
fn receive(session: &mut Session, request: &Advance) -> Result<Vec<Box<dyn Received>>, Error> {
    let mut received = Vec::with_capacity(request.fields.len());
    for &field in &request.fields {
        let wait = Wait::new(request.step, field.name(), session.connect);
        received.push(session.channel.receive_field(field, wait)?);
    }
    Ok(received)
}

/// The inputs' numbers, after a look at each.
fn checked<'a>(
    session: &Session,
    given: Moment,
    fields: &[Field],
    received: &'a [Box<dyn Received>],
) -> Result<Vec<(Field, &'a [f64])>, Error> {
    let mut inputs = Vec::with_capacity(received.len());
    for (&field, input) in fields.iter().zip(received) {
        let expected = session.counts.expect(field, given);
        let values = input.values();
        input.header().validate("coupler", &expected, values)?;
        inputs.push((field, values));
    }
    Ok(inputs)
}

/// Fields that will be sent, each with its buffer of the transport.
type Loans = (Vec<Field>, Vec<Box<dyn Loan>>);

/// Buffers for the candidate; those of withheld fields are made ready too.
fn loan(session: &mut Session, answered: Moment) -> Result<Loans, Error> {
    let (mut fields, mut loans) = (Vec::new(), Vec::new());
    for &field in &session.answer {
        if !session.withheld.has(field) {
            let header = session.counts.expect(field, answered).header();
            loans.push(session.channel.loan_field(field, header)?);
            fields.push(field);
        }
    }
    for (field, values) in &mut session.withheld.fields {
        values.clear();
        values.resize(session.counts.expect(*field, answered).count(), f64::NAN);
    }
    Ok((fields, loans))
}

/// Where the engine writes each field of a candidate: into the transport, or into what is kept.
fn room<'a>(
    sent: &[Field],
    loans: &'a mut [Box<dyn Loan>],
    kept: &'a mut [(Field, Vec<f64>)],
) -> Outputs<'a> {
    let loans = loans.iter_mut().map(|loan| loan.values());
    let kept = kept
        .iter_mut()
        .map(|(field, values)| (*field, values.as_mut_slice()));
    Outputs::new(sent.iter().copied().zip(loans).chain(kept).collect())
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
