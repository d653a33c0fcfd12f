//! The recorder of a run: begun before the engines are greeted, ended before they leave.

use std::path::PathBuf;

use protocol::channel::Channel;
use protocol::message::{Diagnostic, Role};
use protocol::scene::CouplerScene;
use recording::{Begin, Compression, Options, Recorder, RecordingError};

use crate::error::CouplerError;
use crate::listener::Listener;

/// Environment: commit that the programs of this run were built from, as the orchestrator knows it.
const ENV_COMMIT: &str = "SILLAGE_COMMIT";

/// Where a recording that was asked for goes.
#[derive(Debug, Clone, PartialEq)]
pub struct Target {
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
    /// Make the file and write what the run is; one that is resumed keeps its first messages, and its
    /// recording has ended where `kept` has none.
    pub fn begin(
        target: Option<&Target>,
        scene: &CouplerScene,
        kept: Option<Option<u64>>,
    ) -> Result<Recording, RecordingError> {
        let Some(target) = target.filter(|_| kept != Some(None)) else {
            return Ok(Recording::default());
        };
        let program = concat!("sillage-coupler ", env!("CARGO_PKG_VERSION"));
        let commit = std::env::var(ENV_COMMIT).ok();
        let begin = Begin::of(scene, program, commit)?;
        let options = Options {
            compression: target.compression,
            ..Options::default()
        };
        let recorder = match kept.flatten() {
            Some(messages) => Recorder::resume(&target.path, options, &begin, messages)?,
            None => Recorder::create(&target.path, options, &begin)?,
        };
        Ok(Recording {
            recorder: Some(recorder),
            told: false,
        })
    }

    /// Messages recorded so far; none where nothing is recorded any more.
    pub fn passed(&self) -> Option<u64> {
        let recorder = self.recorder.as_ref()?;
        recorder.trouble().is_none().then(|| recorder.passed())
    }

    /// Leave out what passes, or record it again.
    pub fn pause(&self, paused: bool) {
        if let Some(recorder) = &self.recorder {
            recorder.pause(paused);
        }
    }

    /// Wait until all that has passed is on the disk; false where it is not.
    pub fn settle(&self) -> bool {
        self.recorder.as_ref().is_some_and(Recorder::settle)
    }

    /// The link to an engine, recorded when there is a recorder.
    pub fn tap(&self, role: Role, link: Box<dyn Channel>) -> Box<dyn Channel> {
        match &self.recorder {
            Some(recorder) => recorder.tap(role, link),
            None => link,
        }
    }

    /// Tell once when the recording ended before the run.
    pub fn look(&mut self, listener: &mut Listener) -> Result<(), CouplerError> {
        if self.told {
            return Ok(());
        }
        let trouble = self.recorder.as_ref().and_then(Recorder::trouble);
        if let Some(why) = trouble {
            self.tell(&why, listener)?;
        }
        Ok(())
    }

    fn tell(&mut self, why: &str, listener: &mut Listener) -> Result<(), CouplerError> {
        self.told = true;
        listener.recording_ended(why)
    }

    /// The run ends with this exit code: write what waits, and add what came of it to the totals.
    pub fn finish(
        &mut self,
        exit: i32,
        listener: &mut Listener,
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
            Some(why) if !self.told => self.tell(&why, listener),
            _ => Ok(()),
        }
    }
}
