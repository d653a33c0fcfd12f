//! The coupler's side of a link to one engine.

use std::path::Path;
use std::time::Duration;

use crate::language::codec;
use crate::language::engine::{InitialGrains, MeshDescription};
use crate::language::error::Error;
use crate::language::field::Field;
use crate::language::header::{FieldHeader, Stage};
use crate::language::message::{
    Advance, Capability, Configure, Done, Hello, Ready, Role, ToCoupler, ToEngine,
};
use crate::language::scene::{Convection, FluidScene, Limits, ParticleScene, Refinement};
use crate::run::limits;
use crate::run::runspace::RunSpace;
use crate::transport::channel::{Channel, Wait, seconds};
use crate::transport::exchange::{Counts, Moment, receive_grains};

use super::check::{
    check_done, count, parse, require_able, require_finite_report, same_dimension, unexpected,
};
use super::hello::hello;
use super::told;

/// One engine, seen from the coupler. Dropping it without [`Partner::finish`] still tells the
/// engine to leave, unless a process of the run was lost.
pub struct Partner {
    channel: Box<dyn Channel>,
    hello: Hello,
    limits: Limits,
    counts: Counts,
    step: u64,
    pass: u32,
    /// End of the step asked for last \[s\].
    end: f64,
    finished: bool,
}

impl std::fmt::Debug for Partner {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Partner")
            .field("hello", &self.hello)
            .field("step", &self.step)
            .finish_non_exhaustive()
    }
}

impl Partner {
    /// Wait for the engine of this seat to say hello; check its seat, its protocol version and its token.
    pub fn accept(role: Role, runspace: &RunSpace, limits: &Limits) -> Result<Partner, Error> {
        let channel = crate::transport::ipc::open(runspace, role.coupler_end())?;
        Partner::greet(role, channel, limits)
    }

    /// The same over any channel.
    pub fn greet(
        role: Role,
        mut channel: Box<dyn Channel>,
        limits: &Limits,
    ) -> Result<Partner, Error> {
        let wait = Wait::new(0, "Hello", seconds(limits.connect));
        let (header, bytes) = channel.receive_message(wait)?;
        let hello = hello(role, channel.token(), &header, &bytes)?;
        let limits = *limits;
        Ok(Partner {
            channel,
            hello,
            limits,
            counts: Counts::default(),
            step: 0,
            pass: 0,
            end: 0.0,
            finished: false,
        })
    }

    /// What the engine said about itself.
    pub fn hello(&self) -> &Hello {
        &self.hello
    }

    /// The link itself, for what a coupler does not do: traffic that breaks the rules, to see it
    /// refused (`sillage conform`).
    pub fn link(&mut self) -> &mut dyn Channel {
        &mut *self.channel
    }

    /// Epoch of the engine's mesh or grains; 0 before `Ready`.
    pub fn epoch(&self) -> u64 {
        self.counts.epoch
    }

    /// Send the fluid's part of the scene; answered by the mesh. An engine that does not know
    /// convection as needed gets it always; one that cannot steer the mean flow is refused a scene that
    /// asks for it.
    pub fn configure_fluid(&mut self, scene: &FluidScene) -> Result<MeshDescription, Error> {
        let scene_dimension = scene.dimension;
        let mut scene = scene.clone();
        let able = &self.hello().capabilities;
        if !able.contains(&Capability::ConvectionAsNeeded)
            && scene.convection == Convection::AsNeeded
        {
            scene.convection = Convection::Always;
        }
        require_able(self.hello(), &scene)?;
        self.send(&ToEngine::Configure(Configure::Fluid(Box::new(scene))))?;
        let wait = Wait::new(0, "Ready", seconds(self.limits.configure));
        match self.answer(wait)? {
            ToCoupler::Ready(ready) => self.mesh(ready, scene_dimension, wait),
            other => Err(unexpected(self.seat(), 0, &other, "Ready with a mesh")),
        }
    }

    /// Ask for cells of these sizes, before this step: after `Ready` or a commit, before the next `advance`; answered by the mesh of
    /// this epoch, or none where the mesh stays. Only an engine with `Capability::Adapts` understands it.
    pub fn adapt(
        &mut self,
        (step, epoch): (u64, u64),
        sizes: &Refinement,
    ) -> Result<Option<MeshDescription>, Error> {
        // also in a run that is resumed, whose engine has been asked for no step yet
        (self.step, self.pass) = (step, 0);
        let sizes = sizes.clone();
        self.send(&ToEngine::Adapt { epoch, sizes })?;
        let awaited = "Ready after Adapt";
        let wait = Wait::new(self.step, awaited, seconds(self.limits.configure));
        match self.answer(wait)? {
            ToCoupler::Kept => Ok(None),
            ToCoupler::Ready(ready) => {
                let mesh = self.mesh(ready, self.counts.dimension, wait)?;
                if self.counts.epoch != epoch {
                    let why = format!("epoch {}, asked for was {epoch}", self.counts.epoch);
                    return Err(Error::invalid(self.seat(), self.step, "Ready", why));
                }
                Ok(Some(mesh))
            }
            other => Err(unexpected(self.seat(), self.step, &other, awaited)),
        }
    }

    /// The mesh that was told.
    fn mesh(
        &mut self,
        ready: Ready,
        dimension: usize,
        wait: Wait<'_>,
    ) -> Result<MeshDescription, Error> {
        let (counts, mesh) = told::ready(ready, dimension, &mut *self.channel, wait)?;
        self.counts = counts;
        Ok(mesh)
    }

    /// Send the particles' part of the scene and the initial grains; answered by the grains that
    /// will be run.
    pub fn configure_particles(
        &mut self,
        scene: &ParticleScene,
        grains: &InitialGrains,
    ) -> Result<InitialGrains, Error> {
        self.counts = Counts {
            dimension: scene.dimension,
            grains: grains.count(),
            ..Counts::default()
        };
        for (field, values) in grains.slices() {
            self.counts.send(
                &mut *self.channel,
                field,
                Moment::at(Stage::Configure),
                values,
            )?;
        }
        let grain_count = grains.count() as u64;
        self.send(&ToEngine::Configure(Configure::Particles {
            scene: Box::new(scene.clone()),
            grain_count,
        }))?;
        let wait = Wait::new(0, "Ready", seconds(self.limits.configure));
        let (epoch, dimension, grain_count) = match self.answer(wait)? {
            ToCoupler::Ready(Ready::Grains {
                epoch,
                dimension,
                grains,
            }) => (epoch, dimension, grains),
            other => return Err(unexpected(self.seat(), 0, &other, "Ready with grains")),
        };
        same_dimension(self.seat(), scene.dimension, dimension)?;
        self.counts = Counts {
            epoch,
            dimension: scene.dimension,
            grains: count(self.seat(), "grains", grain_count)?,
            ..Counts::default()
        };
        receive_grains(&self.counts, &mut *self.channel, Stage::Ready, wait)
    }

    /// Compute a candidate. `request.fields` is filled here from `inputs`, which are copied into
    /// loaned buffers; the fields of `Done` are copied into `outputs` (resized). An output that
    /// the engine does not send is an error, one that nobody asked for is dropped.
    pub fn advance(
        &mut self,
        request: &Advance,
        inputs: &[(Field, &[f64])],
        outputs: &mut [(Field, &mut Vec<f64>)],
    ) -> Result<Done, Error> {
        (self.step, self.pass) = (request.step, request.pass);
        let given = Moment {
            step: request.step,
            pass: request.pass,
            stage: Stage::Advance,
            time: request.time,
        };
        for &(field, values) in inputs {
            if let Err(error) = self.counts.send(&mut *self.channel, field, given, values) {
                return Err(self.last_words(error));
            }
        }
        let fields = inputs.iter().map(|&(field, _)| field).collect();
        self.send(&ToEngine::Advance(Advance {
            fields,
            ..request.clone()
        }))?;
        let wait = Wait::new(request.step, "Done", seconds(self.limits.step));
        let done = match self.answer(wait)? {
            ToCoupler::Done(done) => done,
            other => return Err(unexpected(self.seat(), self.step, &other, "Done")),
        };
        check_done(self.hello.role, (self.step, self.pass), &done, outputs)?;
        self.end = request.time + request.dt;
        self.take(&done.fields, outputs, wait)?;
        require_finite_report(self.seat(), self.step, &done)?;
        Ok(done)
    }

    /// Does the engine keep fields back until they are asked for?
    pub fn may_withhold(&self) -> bool {
        let able = &self.hello.capabilities;
        able.contains(&Capability::FieldsOnRequest)
    }

    /// Let the engine leave these fields out of its candidates; only one that
    /// [may](Partner::may_withhold) understands it.
    pub fn withhold(&mut self, fields: &[Field]) -> Result<(), Error> {
        let fields = fields.to_vec();
        self.send(&ToEngine::Withhold { fields })
    }

    /// Ask for withheld fields of the accepted state: after a commit, before the next `advance`.
    pub fn tell(&mut self, outputs: &mut [(Field, &mut Vec<f64>)]) -> Result<(), Error> {
        let wanted: Vec<Field> = outputs.iter().map(|(field, _)| *field).collect();
        self.send(&ToEngine::Tell {
            fields: wanted.clone(),
        })?;
        let wait = Wait::new(self.step, "Told", seconds(self.limits.step));
        match self.answer(wait)? {
            ToCoupler::Told { fields } if fields == wanted => self.take(&fields, outputs, wait),
            ToCoupler::Told { fields } => {
                let why = format!("{fields:?}, asked for were {wanted:?}");
                Err(Error::invalid(self.seat(), self.step, "Told", why))
            }
            other => Err(unexpected(self.seat(), self.step, &other, "Told")),
        }
    }

    /// Receive the fields of a candidate; those that nobody asked for are dropped. Where one is not finite the
    /// others are received all the same: the engine may be asked for another candidate.
    fn take(
        &mut self,
        fields: &[Field],
        outputs: &mut [(Field, &mut Vec<f64>)],
        wait: Wait<'_>,
    ) -> Result<(), Error> {
        let answered = Moment {
            step: self.step,
            pass: self.pass,
            stage: Stage::Done,
            time: self.end,
        };
        let mut trouble = Ok(());
        for &field in fields {
            let received = self
                .counts
                .receive(&mut *self.channel, field, answered, wait);
            let received = match received {
                Err(error @ Error::NotFinite { .. }) => {
                    trouble = trouble.and(Err(error));
                    continue;
                }
                other => other?,
            };
            if let Some((_, output)) = outputs.iter_mut().find(|(wanted, _)| *wanted == field) {
                output.clear();
                output.extend_from_slice(received.values());
            }
        }
        trouble
    }

    /// Take grains out of the accepted state, by their ascending numbers: after a commit, before the next
    /// `advance`; answered by the grains that are left. Only an engine with `Capability::RemovesGrains`
    /// understands it.
    pub fn remove(&mut self, grains: &[usize]) -> Result<InitialGrains, Error> {
        let asked = grains.iter().map(|&grain| grain as u64).collect();
        self.send(&ToEngine::Remove { grains: asked })?;
        let wait = Wait::new(self.step, "Ready after Remove", seconds(self.limits.step));
        let told = match self.answer(wait)? {
            ToCoupler::Ready(Ready::Grains {
                epoch,
                dimension,
                grains,
            }) => [epoch, dimension.into(), grains],
            other => {
                return Err(unexpected(
                    self.seat(),
                    self.step,
                    &other,
                    "Ready with grains",
                ));
            }
        };
        let left = Counts {
            epoch: self.counts.epoch + 1,
            grains: self.counts.grains - grains.len(),
            ..self.counts
        };
        let expected = [left.epoch, left.dimension as u64, left.grains as u64];
        if told != expected {
            let why = format!(
                "epoch, dimension and number of grains are {told:?}, expected {expected:?}"
            );
            return Err(Error::invalid(self.seat(), self.step, "Ready", why));
        }
        self.counts = left;
        receive_grains(&self.counts, &mut *self.channel, Stage::Ready, wait)
    }

    /// Accept the last candidate of this step.
    pub fn commit(&mut self, step: u64) -> Result<(), Error> {
        self.send(&ToEngine::Commit { step })
    }

    /// Let the engine write its accepted state.
    pub fn save(&mut self, path: &Path) -> Result<(), Error> {
        let path = self.text(path)?;
        self.send(&ToEngine::Save { path })?;
        self.stored("Stored after Save")
    }

    /// Let the engine read its accepted state.
    pub fn restore(&mut self, path: &Path) -> Result<(), Error> {
        let path = self.text(path)?;
        self.send(&ToEngine::Restore { path })?;
        self.stored("Stored after Restore")
    }

    /// The run is over; returns when the engine has left.
    pub fn finish(&mut self) -> Result<(), Error> {
        self.finished = true;
        if self.channel.peer_is_gone() {
            return Ok(());
        }
        self.send(&ToEngine::Finish)?;
        let limit = limits::LEAVE.duration();
        if self.channel.wait_for_leave(limit) {
            return Ok(());
        }
        Err(Wait::new(self.step, "its leave after Finish", limit).passed(self.seat()))
    }

    fn seat(&self) -> &'static str {
        self.hello.role.seat()
    }

    fn send(&mut self, message: &ToEngine) -> Result<(), Error> {
        let bytes = codec::encode(message)
            .map_err(|e| Error::invalid("coupler", self.step, "message", e.to_string()))?;
        let header = FieldHeader::message(self.step, self.pass, bytes.len());
        match self.channel.send_message(header, &bytes) {
            Ok(true) => Ok(()),
            Ok(false) => {
                let who = self.channel.culprit();
                let awaited = "a receiver of messages";
                let lost = Wait::new(self.step, awaited, Duration::ZERO).lost(&who);
                Err(self.last_words(lost))
            }
            Err(error) => Err(self.last_words(error)),
        }
    }

    /// An engine that could not be reached may have said why before it left.
    fn last_words(&mut self, error: Error) -> Error {
        while let Ok(Some((header, bytes))) = self.channel.poll_message() {
            if let Ok(ToCoupler::Failed(failure)) = parse(self.seat(), self.step, &header, &bytes) {
                return Error::Engine {
                    who: self.seat().to_owned(),
                    step: self.step,
                    failure,
                };
            }
        }
        error
    }

    fn answer(&mut self, wait: Wait<'_>) -> Result<ToCoupler, Error> {
        let (header, bytes) = self.channel.receive_message(wait)?;
        match parse(self.seat(), self.step, &header, &bytes)? {
            ToCoupler::Failed(failure) => Err(Error::Engine {
                who: self.seat().to_owned(),
                step: self.step,
                failure,
            }),
            other => Ok(other),
        }
    }

    fn stored(&mut self, awaited: &str) -> Result<(), Error> {
        match self.answer(Wait::new(
            self.step,
            awaited,
            seconds(self.limits.configure),
        ))? {
            ToCoupler::Stored => Ok(()),
            other => Err(unexpected(self.seat(), self.step, &other, awaited)),
        }
    }

    fn text(&self, path: &Path) -> Result<String, Error> {
        let text = path.to_str().map(str::to_owned);
        text.ok_or_else(|| {
            Error::invalid(
                "coupler",
                self.step,
                "path",
                format!("{} is not UTF-8", path.display()),
            )
        })
    }
}

impl Drop for Partner {
    fn drop(&mut self) {
        // After a loss everybody ends by itself, with the exit code that says so.
        let over = self.finished || self.channel.peer_is_gone() || self.channel.anyone_is_lost();
        if !over && self.send(&ToEngine::Finish).is_ok() {
            // The buffers must outlive the engine's look at them.
            self.channel.wait_for_leave(Duration::from_secs(1));
        }
    }
}
