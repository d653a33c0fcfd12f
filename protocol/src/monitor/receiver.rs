//! The orchestrator's end.

use std::time::{Duration, Instant};

use crate::language::codec;
use crate::language::error::Error;
use crate::language::field::{Field, MESH};
use crate::language::header::{FieldHeader, Stage};
use crate::language::message::{FromOrchestrator, ToOrchestrator};
use crate::run::limits;
use crate::run::runspace::RunSpace;
use crate::transport::channel::{Channel, Wait};
use crate::transport::ends::monitor_receiver_end;
use crate::transport::exchange::{Counts, Moment};

/// A message of the coupler with its fields.
#[derive(Debug, Clone, PartialEq)]
pub struct Event {
    /// The message.
    pub message: ToOrchestrator,
    /// The fields that came with it.
    pub fields: Vec<(Field, Vec<f64>)>,
}

/// The orchestrator's end.
pub struct MonitorReceiver {
    channel: Box<dyn Channel>,
    counts: Counts,
}

impl MonitorReceiver {
    /// Open the link; before the coupler is started.
    pub fn create(runspace: &RunSpace) -> Result<MonitorReceiver, Error> {
        let channel = crate::transport::ipc::open(runspace, monitor_receiver_end())?;
        Ok(MonitorReceiver {
            channel,
            counts: Counts::default(),
        })
    }

    /// The next message, or `None` when there was none within `timeout`. Snapshots are
    /// acknowledged here, after their fields were copied. An error says that the coupler is gone
    /// and has nothing more to say.
    pub fn next(&mut self, timeout: Duration) -> Result<Option<Event>, Error> {
        let begun = Instant::now();
        let (header, bytes) = match self
            .channel
            .receive_message(Wait::new(0, "a message", timeout))
        {
            Err(Error::TimeLimit { .. }) => return Ok(None),
            other => other?,
        };
        tracing::trace!("message after {:?}", begun.elapsed());
        let who = self.channel.peer();
        header.validate_message(who, bytes.len())?;
        let message: ToOrchestrator = codec::decode(&bytes)
            .map_err(|e| Error::invalid(who, header.step, "message", e.to_string()))?;
        let fields = self.fields_of(&message)?;
        let unanswered = matches!(
            message,
            ToOrchestrator::Step(_)
                | ToOrchestrator::RecordingEnded(_)
                | ToOrchestrator::Checkpoint { .. }
                | ToOrchestrator::NoCheckpoint(_)
        );
        if !unanswered {
            self.send(FromOrchestrator::SnapshotTaken)?;
        }
        Ok(Some(Event { message, fields }))
    }

    /// Ask the coupler to stop after the current step.
    pub fn stop(&mut self) -> Result<(), Error> {
        self.send(FromOrchestrator::Stop)
    }

    fn fields_of(&mut self, message: &ToOrchestrator) -> Result<Vec<(Field, Vec<f64>)>, Error> {
        let (moment, names) = match message {
            ToOrchestrator::Started {
                dimension,
                nodes,
                simplices,
                grains,
                ..
            } => {
                self.counts = Counts {
                    epoch: 0,
                    dimension: *dimension as usize,
                    nodes: *nodes as usize,
                    simplices: *simplices as usize,
                    grains: *grains as usize,
                    facets: 0,
                };
                let mut names = if *nodes > 0 {
                    MESH.to_vec()
                } else {
                    Vec::new()
                };
                names.extend((*grains > 0).then_some(Field::GrainRadius));
                (Moment::at(Stage::Started), names)
            }
            ToOrchestrator::Mesh { nodes, simplices } => {
                (self.counts.nodes, self.counts.simplices) = (*nodes as usize, *simplices as usize);
                (Moment::at(Stage::Started), MESH.to_vec())
            }
            ToOrchestrator::Snapshot {
                step,
                time,
                fields,
                grains,
            } => {
                self.counts.grains = *grains as usize;
                let moment = Moment {
                    step: *step,
                    pass: 0,
                    stage: Stage::Snapshot,
                    time: *time,
                };
                (moment, fields.clone())
            }
            _ => return Ok(Vec::new()),
        };
        let wait = Wait::new(moment.step, "a field", limits::MONITOR.duration());
        let mut fields = Vec::with_capacity(names.len());
        for field in names {
            fields.push((
                field,
                self.counts
                    .receive_copy(&mut *self.channel, field, moment, wait)?,
            ));
        }
        Ok(fields)
    }

    fn send(&mut self, message: FromOrchestrator) -> Result<(), Error> {
        let bytes = codec::encode(&message)
            .map_err(|e| Error::invalid("orchestrator", 0, "message", e.to_string()))?;
        self.channel
            .send_message(FieldHeader::message(0, 0, bytes.len()), &bytes)?;
        Ok(())
    }
}
