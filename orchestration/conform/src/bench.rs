//! An engine on the bench: a process of the command in a run of its own, and the coupler's end of
//! its link. Whatever goes wrong is a sentence for the report.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use protocol::channel::Wait;
use protocol::codec;
use protocol::engine::{InitialGrains, MeshDescription};
use protocol::field::Field;
use protocol::header::{Expected, FieldHeader, Stage};
use protocol::message::{Advance, Failure, FailureKind, ToCoupler, ToEngine};
use protocol::partner::Partner;
use protocol::runspace::RunSpace;

use crate::case::{Case, Inputs, Part};
use crate::subject::Subject;

/// How long an engine may take to leave when it has to.
pub const LEAVE: Duration = Duration::from_secs(2);

/// What an engine answered to `Ready`.
pub enum Model {
    /// A fluid's mesh.
    Mesh(MeshDescription),
    /// The grains that will be run.
    Grains(InitialGrains),
}

/// A candidate: the fields that the coupler reads.
#[derive(Debug, Clone)]
pub struct Candidate(pub Vec<(Field, Vec<f64>)>);

/// An engine on the bench.
pub struct Bench<'a> {
    /// What it is tested with.
    pub case: &'a Case,
    /// The coupler's end.
    pub partner: Partner,
    /// Its process.
    pub subject: Subject,
    /// Nodes or grains; 0 before `Ready`.
    pub count: usize,
    // Last: the run is removed when its links are closed.
    _runspace: RunSpace,
}

impl<'a> Bench<'a> {
    /// Start the command and hear its hello.
    pub fn greet(case: &'a Case) -> Result<Bench<'a>, String> {
        let runspace = RunSpace::create().map_err(|e| e.to_string())?;
        Bench::greet_with(case, &runspace, &[])
    }

    /// The same in a run that is there already, with further variables.
    pub fn greet_with(
        case: &'a Case,
        runspace: &RunSpace,
        further: &[(&str, &str)],
    ) -> Result<Bench<'a>, String> {
        let mut variables = runspace.to_environment();
        variables.extend(
            further
                .iter()
                .map(|(name, value)| (name.to_string(), value.to_string())),
        );
        let started = Subject::start(&case.command, &variables);
        let mut subject = started.map_err(|e| e.to_string())?;
        let partner = hear_hello(case, runspace, &mut subject)?;
        Ok(Bench {
            case,
            partner,
            subject,
            count: 0,
            _runspace: runspace.clone(),
        })
    }

    /// The same, and configured.
    pub fn ready(case: &'a Case) -> Result<Bench<'a>, String> {
        let mut bench = Bench::greet(case)?;
        bench.configure()?;
        Ok(bench)
    }

    /// Configure the engine.
    pub fn configure(&mut self) -> Result<Model, String> {
        let model = match &self.case.part {
            Part::Fluid(scene) => self.partner.configure_fluid(scene).map(Model::Mesh),
            Part::Particles(scene, grains) => {
                let answered = self.partner.configure_particles(scene, grains);
                answered.map(Model::Grains)
            }
        };
        let model = model.map_err(|error| self.explain(&error))?;
        self.count = match &model {
            Model::Mesh(mesh) => mesh.nodal_mass.len(),
            Model::Grains(grains) => grains.radius.len(),
        };
        Ok(model)
    }

    /// Inputs of this variant for this engine.
    pub fn inputs(&self, variant: u32) -> Inputs {
        let able = &self.partner.hello().capabilities;
        self.case.inputs(self.count, variant, able)
    }

    /// One `Advance`, which must be answered by a candidate.
    pub fn advance(&mut self, request: &Advance, inputs: &Inputs) -> Result<Candidate, String> {
        self.advance_without(request, inputs, &[])
    }

    /// One `Advance` that may be too much for the engine: a failure is an answer too.
    pub fn advance_or_fail(&mut self, request: &Advance, inputs: &Inputs) -> Result<(), String> {
        match self.partner.advance(request, &borrowed(inputs), &mut []) {
            Ok(_) | Err(protocol::Error::Engine { .. }) => Ok(()),
            Err(error) => Err(self.explain(&error)),
        }
    }

    /// The usual `Advance` to `step`, whose answer must not have these fields.
    pub fn step_without(
        &mut self,
        step: u64,
        variant: u32,
        withheld: &[Field],
    ) -> Result<Candidate, String> {
        let inputs = self.inputs(variant);
        self.advance_without(&self.case.request(step, 0), &inputs, withheld)
    }

    /// `Tell`, which must bring these fields.
    pub fn tell(&mut self, fields: &[Field]) -> Result<Candidate, String> {
        let mut answer: Vec<(Field, Vec<f64>)> =
            fields.iter().map(|&field| (field, Vec::new())).collect();
        let mut outputs: Vec<(Field, &mut Vec<f64>)> = answer
            .iter_mut()
            .map(|(field, values)| (*field, values))
            .collect();
        let told = self.partner.tell(&mut outputs);
        told.map_err(|error| format!("Tell: {}", self.explain(&error)))?;
        Ok(Candidate(answer))
    }

    fn advance_without(
        &mut self,
        request: &Advance,
        inputs: &Inputs,
        withheld: &[Field],
    ) -> Result<Candidate, String> {
        let mut answer: Vec<(Field, Vec<f64>)> = self
            .partner
            .hello()
            .answer()
            .into_iter()
            .filter(|field| !withheld.contains(field))
            .map(|field| (field, Vec::new()))
            .collect();
        let mut outputs: Vec<(Field, &mut Vec<f64>)> = answer
            .iter_mut()
            .map(|(field, values)| (*field, values))
            .collect();
        let done = self
            .partner
            .advance(request, &borrowed(inputs), &mut outputs);
        let done = done.map_err(|error| {
            let place = format!("Advance to step {}, pass {}", request.step, request.pass);
            format!("{place}: {}", self.explain(&error))
        })?;
        if let Some(field) = withheld.iter().find(|field| done.fields.contains(field)) {
            return Err(format!(
                "{} is withheld and comes all the same",
                field.name()
            ));
        }
        Ok(Candidate(answer))
    }

    /// The usual `Advance` to `step` with inputs of `variant`.
    pub fn step(&mut self, step: u64, variant: u32) -> Result<Candidate, String> {
        self.advance(&self.case.request(step, 0), &self.inputs(variant))
    }

    /// Accept the candidate of this step.
    pub fn commit(&mut self, step: u64) -> Result<(), String> {
        let sent = self.partner.commit(step);
        sent.map_err(|error| self.explain(&error))
    }

    /// `Remove`, which must be answered by the grains that are left.
    pub fn remove(&mut self, grains: &[usize]) -> Result<InitialGrains, String> {
        let left = self.partner.remove(grains);
        let left = left.map_err(|error| format!("Remove: {}", self.explain(&error)))?;
        self.count = left.count();
        Ok(left)
    }

    /// `Finish`, after which it must leave with exit code 0.
    pub fn finish(&mut self) -> Result<(), String> {
        let told = self.partner.finish();
        told.map_err(|error| format!("after Finish: {}", self.explain(&error)))?;
        let left = self.subject.must_leave(0, LEAVE);
        left.map_err(|why| format!("after Finish {why}"))
    }

    /// An error of the protocol, and what the process said when it has ended.
    pub fn explain(&mut self, error: &protocol::Error) -> String {
        format!("{error}{}", self.subject.postscript())
    }

    /// The header that this input must have.
    pub fn header(&self, request: &Advance, field: Field) -> FieldHeader {
        header(
            &self.partner,
            (self.count, self.case.dimension()),
            request,
            field,
        )
    }

    /// `Advance` with inputs and headers as given, right or wrong; not waiting for the answer.
    pub fn send_advance(
        &mut self,
        request: &Advance,
        inputs: &[(Field, FieldHeader, Vec<f64>)],
    ) -> Result<(), String> {
        send_advance(&mut self.partner, request, inputs).map_err(|error| self.explain(&error))
    }

    /// Right headers and values, to be spoilt.
    pub fn right(&self, request: &Advance, variant: u32) -> Vec<(Field, FieldHeader, Vec<f64>)> {
        let inputs = self.inputs(variant).into_iter();
        inputs
            .map(|(field, values)| (field, self.header(request, field), values))
            .collect()
    }

    /// A message, at whatever moment.
    pub fn send(&mut self, message: &ToEngine) -> Result<(), String> {
        send(&mut self.partner, message).map_err(|error| self.explain(&error))
    }

    /// Bytes that may be no message.
    pub fn send_bytes(&mut self, header: FieldHeader, bytes: &[u8]) -> Result<(), String> {
        send_bytes(&mut self.partner, header, bytes).map_err(|error| self.explain(&error))
    }

    /// The next answer must be `Failed`.
    pub fn must_fail(&mut self, to: &str) -> Result<Failure, String> {
        let wait = Wait::new(0, "Failed", self.case.patience());
        let received = self.partner.link().receive_message(wait);
        let (_, bytes) = received.map_err(|error| {
            format!("{to} must be answered by Failed: {}", self.explain(&error))
        })?;
        match codec::decode(&bytes) {
            Ok(ToCoupler::Failed(failure)) => Ok(failure),
            Ok(other) => Err(format!(
                "{to} must be answered by Failed, it answers {}",
                name(&other)
            )),
            Err(error) => Err(format!("{to} must be answered by Failed: {error}")),
        }
    }

    /// The same, of this kind.
    pub fn must_fail_as(&mut self, kind: FailureKind, to: &str) -> Result<(), String> {
        let failure = self.must_fail(to)?;
        if failure.kind == kind {
            return Ok(());
        }
        Err(format!(
            "{to} must be answered by Failed of kind {kind:?}, it is {:?}: {}",
            failure.kind, failure.why
        ))
    }

    /// After a failure that an engine does not survive: `Finish`, then this exit code.
    pub fn must_leave_broken(&mut self, code: i32, after: &str) -> Result<(), String> {
        // It may be gone already.
        let _ = self.send(&ToEngine::Finish);
        let left = self.subject.must_leave(code, LEAVE);
        left.map_err(|why| format!("after {after} and Finish {why}"))
    }
}

fn borrowed(inputs: &Inputs) -> Vec<(Field, &[f64])> {
    let inputs = inputs.iter();
    inputs
        .map(|(field, values)| (*field, values.as_slice()))
        .collect()
}

/// Wait for hello, but not longer than the process lives.
fn hear_hello(case: &Case, runspace: &RunSpace, subject: &mut Subject) -> Result<Partner, String> {
    let over = AtomicBool::new(false);
    let (watched, over_here) = (&mut *subject, &over);
    let heard = std::thread::scope(|scope| {
        scope.spawn(move || {
            while !over_here.load(Ordering::Acquire) {
                if watched.wait(Duration::from_millis(20)).is_some() {
                    // Ends the wait; without effect when the engine had taken its seat.
                    let _ = runspace.mark_lost(case.role.seat());
                    return;
                }
            }
        });
        let heard = Partner::accept(case.role, runspace, &case.limits());
        over.store(true, Ordering::Release);
        heard
    });
    heard.map_err(|error| format!("{error}{}", subject.postscript()))
}

/// The header that an input must have.
pub fn header(
    partner: &Partner,
    (count, dimension): (usize, usize),
    request: &Advance,
    field: Field,
) -> FieldHeader {
    let expected = Expected {
        field,
        epoch: partner.epoch(),
        step: request.step,
        pass: request.pass,
        stage: Stage::Advance,
        dimension,
        entities: count,
        time: request.time,
    };
    expected.header()
}

/// `Advance` with its inputs, not waiting for the answer.
pub fn send_advance(
    partner: &mut Partner,
    request: &Advance,
    inputs: &[(Field, FieldHeader, Vec<f64>)],
) -> Result<(), protocol::Error> {
    for (field, header, values) in inputs {
        partner.link().send_field(*field, *header, values)?;
    }
    let fields = inputs.iter().map(|(field, _, _)| *field).collect();
    let request = Advance {
        fields,
        ..request.clone()
    };
    send(partner, &ToEngine::Advance(request))
}

fn send(partner: &mut Partner, message: &ToEngine) -> Result<(), protocol::Error> {
    let bytes = codec::encode(message).map_err(|error| protocol::Error::Invalid {
        who: "coupler".to_owned(),
        step: 0,
        what: "message".to_owned(),
        why: error.to_string(),
    })?;
    send_bytes(partner, FieldHeader::message(0, 0, bytes.len()), &bytes)
}

fn send_bytes(
    partner: &mut Partner,
    header: FieldHeader,
    bytes: &[u8],
) -> Result<(), protocol::Error> {
    if partner.link().send_message(header, bytes)? {
        return Ok(());
    }
    let wait = Wait::new(0, "a receiver of messages", Duration::ZERO);
    let who = partner.link().culprit();
    Err(wait.lost(&who))
}

fn name(message: &ToCoupler) -> &'static str {
    match message {
        ToCoupler::Hello(_) => "Hello",
        ToCoupler::Ready(_) => "Ready",
        ToCoupler::Done(_) => "Done",
        ToCoupler::Stored => "Stored",
        ToCoupler::Failed(_) => "Failed",
        ToCoupler::Told { .. } => "Told",
        ToCoupler::Kept => "Kept",
    }
}

impl Candidate {
    /// A field of it.
    pub fn field(&self, wanted: Field) -> &[f64] {
        let found = self.0.iter().find(|(field, _)| *field == wanted);
        found.map_or(&[], |(_, values)| values.as_slice())
    }

    /// Require the same bits in all fields of the other.
    pub fn must_equal(&self, other: &Candidate, which: &str) -> Result<(), String> {
        for (field, theirs) in &other.0 {
            let ours = self.field(*field);
            if ours.len() != theirs.len() {
                let (name, one, two) = (field.name(), ours.len(), theirs.len());
                return Err(format!("{which}: {name} has {one} numbers, then {two}"));
            }
            let mut pairs = ours.iter().zip(theirs);
            if let Some(place) = pairs.position(|(a, b)| a.to_bits() != b.to_bits()) {
                let (name, first, second) = (field.name(), ours[place], theirs[place]);
                return Err(format!(
                    "{which}: {name} differs at number {place}: {first:e}, then {second:e}"
                ));
            }
        }
        Ok(())
    }
}
