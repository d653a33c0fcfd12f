//! The recorder of a run: begun before the engines are greeted, ended before they leave.

use std::path::PathBuf;

use protocol::channel::Channel;
use protocol::configure::CouplerScene;
use protocol::messages::{Diagnostic, Role};
use protocol::monitor::MonitorSender;
use recording::{Begin, Compression, Options, Recorder, RecordingError};

use crate::error::CouplerError;

/// Environment: commit that the programs of this run were built from, as the orchestrator knows it.
const ENV_COMMIT: &str = "SILLAGE_COMMIT";

/// A recording that was asked for.
#[derive(Debug, Clone, PartialEq)]
pub struct Request {
    /// The file.
    pub path: PathBuf,
    /// Of its chunks.
    pub compression: Compression,
}

/// Records a run, or does nothing when no recording was asked for.
#[derive(Default)]
pub struct Recording {
    recorder: Option<Recorder>,
    told: bool,
}

impl Recording {
    /// Make the file and write what the run is.
    pub fn begin(
        request: Option<&Request>,
        scene: &CouplerScene,
    ) -> Result<Recording, RecordingError> {
        let Some(request) = request else {
            return Ok(Recording::default());
        };
        let program = concat!("sillage-coupler ", env!("CARGO_PKG_VERSION"));
        let commit = std::env::var(ENV_COMMIT).ok();
        let begin = Begin::of(scene, program, commit)?;
        let options = Options {
            compression: request.compression,
            ..Options::default()
        };
        Ok(Recording {
            recorder: Some(Recorder::create(&request.path, options, &begin)?),
            told: false,
        })
    }

    /// The link to an engine, recorded when there is a recorder.
    pub fn tap(&self, role: Role, link: Box<dyn Channel>) -> Box<dyn Channel> {
        match &self.recorder {
            Some(recorder) => recorder.tap(role, link),
            None => link,
        }
    }

    /// Tell once when the recording ended before the run.
    pub fn look(&mut self, monitor: &mut Option<MonitorSender>) -> Result<(), CouplerError> {
        if self.told {
            return Ok(());
        }
        let trouble = self.recorder.as_ref().and_then(Recorder::trouble);
        if let Some(why) = trouble {
            self.tell(&why, monitor)?;
        }
        Ok(())
    }

    fn tell(&mut self, why: &str, monitor: &mut Option<MonitorSender>) -> Result<(), CouplerError> {
        self.told = true;
        match monitor {
            Some(monitor) => Ok(monitor.recording_ended(why)?),
            None => Ok(()),
        }
    }

    /// The run ends with this exit code: write what waits, and add what came of it to the totals.
    pub fn finish(
        &mut self,
        exit: i32,
        monitor: &mut Option<MonitorSender>,
        totals: &mut Vec<Diagnostic>,
    ) -> Result<(), CouplerError> {
        let Some(recorder) = self.recorder.take() else {
            return Ok(());
        };
        let path = recorder.path().to_path_buf();
        let outcome = recorder.finish(exit);
        tracing::info!(
            complete = outcome.complete,
            messages = outcome.messages,
            bytes = outcome.bytes,
            "recorded {}",
            path.display()
        );
        for (name, value) in [
            ("recording_complete", f64::from(u8::from(outcome.complete))),
            ("recording_messages", outcome.messages as f64),
            ("recording_bytes", outcome.bytes as f64),
            ("cpu_recorder", outcome.cpu_seconds),
        ] {
            let name = name.to_owned();
            totals.push(Diagnostic { name, value });
        }
        match outcome.why {
            Some(why) if !self.told => self.tell(&why, monitor),
            _ => Ok(()),
        }
    }
}
