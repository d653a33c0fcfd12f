//! Feeds the recorded inputs to one engine and compares its answers with the recorded ones.

use std::path::{Path, PathBuf};

use serde::Serialize;

use protocol::Error;
use protocol::checkpoints;
use protocol::engine::{InitialGrains, MeshDescription};
use protocol::field::{BOUNDARY, Field, GRAINS, MESH};
use protocol::header::Stage;
use protocol::message::{Advance, Capability, Configure, Hello, Role, ToCoupler, ToEngine};
use protocol::partner::Partner;
use protocol::scene::MeshSource;

use crate::compare::Table;
use crate::entry::{Body, Entry, Key};
use crate::error::RecordingError;
use crate::reader::Reader;

/// What a replay found.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Report {
    /// Differences by field; the first value of each is the recorded one.
    pub fields: Table,
    /// Accepted steps.
    pub steps: u64,
    /// Candidates that were compared.
    pub answers: u64,
    /// The engine that was recorded.
    pub recorded: Option<Hello>,
    /// The engine that was asked now.
    pub replayed: Option<Hello>,
    /// Why it could not go on to the end of the recording: the answers are of another kind.
    pub stopped: Option<String>,
    /// Recorded fields that were not compared: the engine is not asked for them.
    pub left_out: Vec<&'static str>,
}

impl Report {
    /// Is every field within the tolerance (of its largest magnitude), to the end?
    pub fn within(&self, tolerance: f64) -> bool {
        self.stopped.is_none() && self.fields.values().all(|row| row.within(tolerance))
    }
}

/// Why a replay has no result.
#[derive(Debug, thiserror::Error)]
pub enum ReplayError {
    /// The recording.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// The exchange with the engine.
    #[error(transparent)]
    Exchange(#[from] Error),
}

impl ReplayError {
    /// The exit code of a process that ends with this error.
    pub fn exit_code(&self) -> i32 {
        match self {
            ReplayError::Recording(error) => error.exit_code(),
            ReplayError::Exchange(error) => error.exit_code(),
        }
    }
}

/// Play the coupler of this recording towards an engine that has said hello. A mesh file of the
/// recording is written into `folder`; `accepted` hears of every accepted step and the time it began.
pub fn replay(
    reader: &mut Reader,
    partner: &mut Partner,
    folder: &Path,
    accepted: impl FnMut(u64, f64),
) -> Result<Report, ReplayError> {
    let role = partner.hello().role;
    let mut player = Player {
        accepted,
        time: 0.0,
        partner,
        role,
        inputs: Vec::new(),
        answers: Vec::new(),
        failed: None,
        withheld: Vec::new(),
        report: Report::default(),
    };
    player.report.replayed = Some(player.partner.hello().clone());
    while let Some(entry) = reader.next_entry()? {
        if entry.seat == role && player.report.stopped.is_none() {
            player.take(reader, folder, entry)?;
        }
    }
    player.partner.finish()?;
    Ok(player.report)
}

/// The state of a replay.
struct Player<'a, F> {
    accepted: F,
    /// When the step began that was asked for last \[s\].
    time: f64,
    partner: &'a mut Partner,
    role: Role,
    /// Recorded inputs of the request that follows.
    inputs: Vec<(Field, Vec<f64>)>,
    /// What the engine answered to the last request.
    answers: Vec<(Field, Vec<f64>)>,
    /// Why it did not.
    failed: Option<String>,
    /// What it was told to keep back.
    withheld: Vec<Field>,
    report: Report,
}

impl<F: FnMut(u64, f64)> Player<'_, F> {
    fn take(&mut self, reader: &Reader, folder: &Path, entry: Entry) -> Result<(), ReplayError> {
        let key = entry.key;
        match entry.body {
            Body::Field(field, values) if is_input(entry.header.stage) => {
                self.inputs.push((field, values));
            }
            Body::Field(field, values) => {
                self.compare(key, field, entry.header.components, &values);
            }
            Body::Request(request) => self.request(reader, folder, key, request)?,
            Body::Answer(answer) => self.answer(key, answer),
            Body::Unreadable(_) => self.stop(key, "the recorded message is none".to_owned()),
        }
        Ok(())
    }

    fn stop(&mut self, key: Key, why: String) {
        self.report.stopped = Some(format!("step {} pass {}: {why}", key.step, key.pass));
    }

    fn request(
        &mut self,
        reader: &Reader,
        folder: &Path,
        key: Key,
        request: ToEngine,
    ) -> Result<(), ReplayError> {
        let inputs = std::mem::take(&mut self.inputs);
        match request {
            ToEngine::Configure(Configure::Fluid(mut scene)) => {
                if let (MeshSource::File { path, .. }, Some(content)) =
                    (&mut scene.mesh, &reader.begin().mesh_file)
                {
                    let file = folder.join("mesh.msh");
                    let bytes: Vec<u8> = content.chars().map(|byte| byte as u8).collect();
                    std::fs::write(&file, bytes).map_err(|error| {
                        RecordingError::file("cannot write the mesh", &file, error)
                    })?;
                    *path = file.to_string_lossy().into_owned();
                }
                let mesh = self.partner.configure_fluid(&scene)?;
                self.answers = mesh_fields(&mesh);
            }
            ToEngine::Configure(Configure::Particles { scene, .. }) => {
                let grains = self
                    .partner
                    .configure_particles(&scene, &grains_of(scene.dimension, &inputs))?;
                self.answers = grain_fields(&grains);
            }
            ToEngine::Advance(request) => self.advance(key, &request, &inputs)?,
            ToEngine::Commit { step } => {
                self.partner.commit(step)?;
                self.report.steps += 1;
                (self.accepted)(step, self.time);
            }
            ToEngine::Restore { path } => {
                let file = beside(reader.path(), &path, self.role).ok_or_else(|| {
                    RecordingError::NotReplayable {
                        path: reader.path().to_path_buf(),
                        why: format!(
                            "the {} was restored from a checkpoint, {path}, which is not beside the recording",
                            self.role.seat()
                        ),
                    }
                })?;
                self.partner.restore(&file)?;
            }
            // One that keeps nothing back has sent it all with its candidate.
            ToEngine::Withhold { fields } if self.partner.may_withhold() => {
                self.withheld = self.told_by_it(fields);
                self.partner.withhold(&self.withheld)?;
            }
            ToEngine::Tell { fields } if self.partner.may_withhold() => {
                let fields = self.told_by_it(fields).into_iter();
                self.answers = fields.map(|field| (field, Vec::new())).collect();
                self.partner.tell(&mut outputs(&mut self.answers))?;
            }
            ToEngine::Withhold { .. } | ToEngine::Tell { .. } => {}
            ToEngine::Remove { grains } if self.can(Capability::RemovesGrains) => {
                let gone: Vec<usize> = grains.iter().map(|&grain| grain as usize).collect();
                self.answers = grain_fields(&self.partner.remove(&gone)?);
            }
            ToEngine::Remove { .. } => {
                let why = "grains leave there, and this engine cannot take grains out (capability RemovesGrains)";
                self.stop(key, why.to_owned());
            }
            ToEngine::Adapt { epoch, sizes } if self.can(Capability::Adapts) => {
                let mesh = self.partner.adapt((key.step, epoch), &sizes)?;
                self.answers = mesh.as_ref().map_or_else(Vec::new, mesh_fields);
            }
            ToEngine::Adapt { .. } => {
                let why =
                    "the mesh changes there, and this engine keeps its own (capability Adapts)";
                self.stop(key, why.to_owned());
            }
            ToEngine::Save { .. } | ToEngine::Finish => {}
        }
        Ok(())
    }

    /// Of these fields those that the engine has: another one than was recorded may lack some.
    fn told_by_it(&self, mut fields: Vec<Field>) -> Vec<Field> {
        let answer = self.partner.hello().answer();
        fields.retain(|field| answer.contains(field));
        fields
    }

    fn can(&self, capability: Capability) -> bool {
        self.partner.hello().capabilities.contains(&capability)
    }

    /// A failure of the engine is an answer, to be compared with the recorded one; a lost or silent
    /// engine is not.
    fn advance(
        &mut self,
        key: Key,
        request: &Advance,
        inputs: &[(Field, Vec<f64>)],
    ) -> Result<(), ReplayError> {
        self.time = request.time;
        let mut sent = self.partner.hello().answer();
        sent.retain(|field| !self.withheld.contains(field));
        self.answers = sent.into_iter().map(|field| (field, Vec::new())).collect();
        let inputs: Vec<(Field, &[f64])> = inputs
            .iter()
            .map(|(field, values)| (*field, values.as_slice()))
            .collect();
        match self
            .partner
            .advance(request, &inputs, &mut outputs(&mut self.answers))
        {
            Ok(_) => self.failed = None,
            Err(Error::Engine { failure, .. }) => self.failed = Some(failure.why),
            Err(error @ (Error::NotFinite { .. } | Error::Invalid { .. })) => {
                self.stop(key, format!("its answer is refused: {error}"));
            }
            Err(error) => return Err(error.into()),
        }
        Ok(())
    }

    fn answer(&mut self, key: Key, answer: ToCoupler) {
        match (answer, self.failed.take()) {
            (ToCoupler::Hello(hello), _) => self.report.recorded = Some(hello),
            (ToCoupler::Done(_), None) => self.report.answers += 1,
            (ToCoupler::Done(_), Some(why)) => {
                self.stop(
                    key,
                    format!("it failed where the recorded one did not: {why}"),
                );
            }
            (ToCoupler::Failed(failure), None) if key.step > 0 => {
                let why = format!("it answered where the recorded one failed: {}", failure.why);
                self.stop(key, why);
            }
            (ToCoupler::Failed(_), _) => self.report.answers += 1,
            (
                ToCoupler::Ready(_) | ToCoupler::Stored | ToCoupler::Told { .. } | ToCoupler::Kept,
                _,
            ) => {}
        }
    }

    fn compare(&mut self, key: Key, field: Field, components: u32, recorded: &[f64]) {
        let Some((_, found)) = self.answers.iter().find(|(answer, _)| *answer == field) else {
            if !self.report.left_out.contains(&field.name()) {
                self.report.left_out.push(field.name());
            }
            return;
        };
        let row = self
            .report
            .fields
            .entry(field.name().to_owned())
            .or_default();
        if let Err(why) = row.add(key, components.max(1) as usize, recorded, found) {
            let why = format!(
                "{} has {why} (recorded, now): nothing to compare",
                field.name()
            );
            self.stop(key, why);
        }
    }
}

fn outputs(answers: &mut [(Field, Vec<f64>)]) -> Vec<(Field, &mut Vec<f64>)> {
    let fields = answers.iter_mut();
    fields.map(|(field, values)| (*field, values)).collect()
}

/// The part of this seat in a checkpoint that lies beside a recording, as it does in a run folder.
fn beside(recording: &Path, told: &str, role: Role) -> Option<PathBuf> {
    let told = Path::new(told);
    let step = told.parent()?.file_name()?.to_str()?;
    checkpoints::step_of(step)?;
    let folder = recording.parent()?.join(checkpoints::FOLDER).join(step);
    let file = folder.join(role.seat());
    (told.file_name()? == role.seat() && file.is_file()).then_some(file)
}

fn is_input(stage: u32) -> bool {
    stage == Stage::Configure as u32 || stage == Stage::Advance as u32
}

fn grain_fields(grains: &InitialGrains) -> Vec<(Field, Vec<f64>)> {
    let fields = grains.slices();
    fields
        .map(|(field, values)| (field, values.to_vec()))
        .into()
}

fn mesh_fields(mesh: &MeshDescription) -> Vec<(Field, Vec<f64>)> {
    let values = [
        mesh.node_position.clone(),
        mesh.corner_numbers(),
        mesh.simplex_position.clone(),
        mesh.nodal_mass.clone(),
    ];
    let facets = [
        mesh.facets.position.clone(),
        mesh.facets.boundary_numbers(),
        mesh.facets.velocity.clone(),
    ];
    let boundary = BOUNDARY.into_iter().zip(facets);
    MESH.into_iter().zip(values).chain(boundary).collect()
}

/// A grain field that is missing is empty, and refused by the partner.
fn grains_of(dimension: usize, fields: &[(Field, Vec<f64>)]) -> InitialGrains {
    let of = |wanted: Field| {
        fields
            .iter()
            .find(|(field, _)| *field == wanted)
            .map(|(_, values)| values.clone())
            .unwrap_or_default()
    };
    InitialGrains::from_arrays(dimension, GRAINS.map(of))
}
