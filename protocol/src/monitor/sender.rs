//! The coupler's end.

use std::time::Duration;

use crate::language::codec;
use crate::language::engine::MeshDescription;
use crate::language::error::Error;
use crate::language::field::{Field, MESH};
use crate::language::header::{FieldHeader, Stage};
use crate::language::message::{Diagnostic, FromOrchestrator, Hello, ToOrchestrator};
use crate::run::limits;
use crate::run::runspace::RunSpace;
use crate::transport::channel::{Channel, Wait};
use crate::transport::ends::monitor_sender_end;
use crate::transport::exchange::{Counts, Moment};

/// The coupler's end.
pub struct MonitorSender {
    channel: Box<dyn Channel>,
    counts: Counts,
    step: u64,
    unanswered: bool,
    heard: bool,
    stop: bool,
}

impl MonitorSender {
    /// Connect to the orchestrator; `None` when this run has none.
    pub fn connect(runspace: &RunSpace) -> Result<Option<MonitorSender>, Error> {
        if runspace.orchestrator().is_none() {
            return Ok(None);
        }
        let channel = crate::transport::ipc::open(runspace, monitor_sender_end())?;
        Ok(Some(MonitorSender {
            channel,
            counts: Counts::default(),
            step: 0,
            unanswered: false,
            heard: false,
            stop: false,
        }))
    }

    /// Coupling begins in a space of this dimension: who takes part, the mesh and the grains' radii
    /// (empty: no grains).
    pub fn started(
        &mut self,
        dimension: usize,
        engines: &[Hello],
        mesh: Option<&MeshDescription>,
        grain_radius: &[f64],
    ) -> Result<(), Error> {
        let (nodes, simplices) =
            mesh.map_or((0, 0), |mesh| (mesh.node_count(), mesh.simplex_count()));
        self.counts = Counts {
            epoch: 0,
            dimension,
            nodes,
            simplices,
            grains: grain_radius.len(),
            facets: 0,
        };
        self.wait_for_reader()?;
        let moment = Moment::at(Stage::Started);
        if let Some(mesh) = mesh {
            self.send_mesh(mesh)?;
        }
        if !grain_radius.is_empty() {
            self.counts
                .send(&mut *self.channel, Field::GrainRadius, moment, grain_radius)?;
        }
        self.send(&ToOrchestrator::Started {
            dimension: dimension as u32,
            nodes: nodes as u64,
            simplices: simplices as u64,
            grains: grain_radius.len() as u64,
            engines: engines.to_vec(),
        })?;
        (self.unanswered, self.heard) = (true, false);
        Ok(())
    }

    fn send_mesh(&mut self, mesh: &MeshDescription) -> Result<(), Error> {
        let corners = mesh.corner_numbers();
        let values: [&[f64]; 4] = [
            &mesh.node_position,
            &corners,
            &mesh.simplex_position,
            &mesh.nodal_mass,
        ];
        let moment = Moment::at(Stage::Started);
        for (field, values) in MESH.into_iter().zip(values) {
            self.counts
                .send(&mut *self.channel, field, moment, values)?;
        }
        Ok(())
    }

    /// The mesh of the states from here on; waits until the previous snapshot was taken over.
    pub fn mesh(&mut self, mesh: &MeshDescription) -> Result<(), Error> {
        self.wait_for_answer("the previous snapshot to be taken over")?;
        (self.counts.nodes, self.counts.simplices) = (mesh.node_count(), mesh.simplex_count());
        self.send_mesh(mesh)?;
        self.send(&ToOrchestrator::Mesh {
            nodes: self.counts.nodes as u64,
            simplices: self.counts.simplices as u64,
        })?;
        self.unanswered = true;
        Ok(())
    }

    /// One accepted step.
    pub fn step(&mut self, values: Vec<Diagnostic>) -> Result<(), Error> {
        if !self.heard {
            self.wait_for_answer("Started to be read")?;
        }
        self.send(&ToOrchestrator::Step(values))
    }

    /// The recording ended before the run.
    pub fn recording_ended(&mut self, why: &str) -> Result<(), Error> {
        self.send(&ToOrchestrator::RecordingEnded(why.to_owned()))
    }

    /// The accepted state of this step is kept.
    pub fn checkpoint(&mut self, step: u64, time: f64) -> Result<(), Error> {
        self.send(&ToOrchestrator::Checkpoint { step, time })
    }

    /// It cannot be kept.
    pub fn no_checkpoint(&mut self, why: &str) -> Result<(), Error> {
        self.send(&ToOrchestrator::NoCheckpoint(why.to_owned()))
    }

    /// Fields of the accepted state with this many grains; waits until the previous snapshot was taken
    /// over.
    pub fn snapshot(
        &mut self,
        (step, time): (u64, f64),
        grains: usize,
        fields: &[(Field, &[f64])],
    ) -> Result<(), Error> {
        (self.step, self.counts.grains) = (step, grains);
        self.wait_for_answer("the previous snapshot to be taken over")?;
        let moment = Moment {
            step,
            pass: 0,
            stage: Stage::Snapshot,
            time,
        };
        for &(field, values) in fields {
            self.counts
                .send(&mut *self.channel, field, moment, values)?;
        }
        let fields = fields.iter().map(|&(field, _)| field).collect();
        self.send(&ToOrchestrator::Snapshot {
            step,
            time,
            fields,
            grains: grains as u64,
        })?;
        self.unanswered = true;
        Ok(())
    }

    /// The run ended as asked.
    pub fn finished(&mut self, totals: Vec<Diagnostic>) -> Result<(), Error> {
        self.goodbye(&ToOrchestrator::Finished(totals))
    }

    /// The run ended early; totals up to here.
    pub fn stopped(&mut self, code: i32, why: &str, totals: Vec<Diagnostic>) -> Result<(), Error> {
        self.goodbye(&ToOrchestrator::Stopped {
            code,
            why: why.to_owned(),
            totals,
        })
    }

    /// Was a stop asked for?
    pub fn stop_requested(&mut self) -> bool {
        while let Ok(Some((header, bytes))) = self.channel.poll_message() {
            if let Err(error) = self.take(&header, &bytes) {
                tracing::warn!("{error}");
            }
        }
        self.stop
    }

    fn goodbye(&mut self, message: &ToOrchestrator) -> Result<(), Error> {
        self.wait_for_answer("the last snapshot to be taken over")?;
        self.send(message)?;
        self.unanswered = true;
        self.wait_for_answer("the last message to be read")
    }

    fn wait_for_answer(&mut self, awaited: &str) -> Result<(), Error> {
        while self.unanswered {
            // The orchestrator may itself wait for a disk that is full.
            let wait = Wait::new(self.step, awaited, limits::TAKE_OVER.duration());
            let (header, bytes) = self.channel.receive_message(wait)?;
            self.take(&header, &bytes)?;
        }
        Ok(())
    }

    fn take(&mut self, header: &FieldHeader, bytes: &[u8]) -> Result<(), Error> {
        let who = self.channel.peer();
        header.validate_message(who, bytes.len())?;
        match codec::decode(bytes)
            .map_err(|e| Error::invalid(who, self.step, "message", e.to_string()))?
        {
            FromOrchestrator::SnapshotTaken => (self.unanswered, self.heard) = (false, true),
            FromOrchestrator::Stop => self.stop = true,
        }
        Ok(())
    }

    /// The orchestrator opens its end before it starts the coupler; by hand it may come later.
    fn wait_for_reader(&mut self) -> Result<(), Error> {
        let wait = Wait::new(0, "its end of the monitor link", limits::MONITOR.duration());
        while !self.channel.has_reader()? {
            self.channel.idle(wait, Duration::from_millis(50))?;
        }
        Ok(())
    }

    fn send(&mut self, message: &ToOrchestrator) -> Result<(), Error> {
        let bytes = codec::encode(message)
            .map_err(|e| Error::invalid("coupler", self.step, "message", e.to_string()))?;
        let header = FieldHeader::message(self.step, 0, bytes.len());
        if self.channel.send_message(header, &bytes)? {
            return Ok(());
        }
        Err(Wait::new(self.step, "a reader of messages", Duration::ZERO).lost(self.channel.peer()))
    }
}
