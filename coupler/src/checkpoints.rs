//! When the state of a run is kept, and how: every process writes its part into a draft, which the
//! orchestrator completes once all that was put out before is on the disk.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use protocol::checkpoints::draft;
use protocol::message::{Capability, Diagnostic};
use space::{Dim, Dimension};

use crate::checkpoint::{Kept, unusable};
use crate::clock::Memory;
use crate::error::CouplerError;
use crate::listener::Listener;
use crate::record::Recording;
use crate::seats::door::can;
use crate::simulation::Simulation;

/// Where and how often a run is kept.
#[derive(Debug, Clone, PartialEq)]
pub struct Rule {
    /// Folder of the checkpoints.
    pub folder: PathBuf,
    /// Steps between two.
    pub every_steps: Option<u64>,
    /// Wall time between two.
    pub every_wall: Duration,
}

/// What a step begins with, beside the state.
#[derive(Debug, Clone, Copy)]
pub struct Moment {
    /// The clock.
    pub clock: Memory,
    /// Messages recorded so far; none where nothing is recorded.
    pub recorded: Option<u64>,
}

/// Keeps a run.
pub struct Checkpoints {
    rule: Option<Rule>,
    since: Instant,
    /// The last step kept.
    last: Option<u64>,
}

impl Checkpoints {
    /// Of a run that begins, or goes on from the step `last`; without a rule nothing is kept.
    pub fn new(rule: Option<Rule>, last: Option<u64>) -> Checkpoints {
        Checkpoints {
            rule,
            since: Instant::now(),
            last,
        }
    }

    /// Keep nothing where an engine cannot, and tell.
    pub fn require_engines<const D: usize, const N: usize>(
        &mut self,
        simulation: &mut Simulation<D, N>,
        listener: &mut Listener,
    ) -> Result<(), CouplerError>
    where
        Dim<D>: Dimension<D>,
    {
        let mut partners = simulation.system.partners();
        let unable = partners.find(|partner| !can(partner, Capability::Checkpoint));
        let Some(partner) = unable.filter(|_| self.rule.is_some()) else {
            return Ok(());
        };
        self.rule = None;
        let engine = &partner.hello().engine;
        listener.no_checkpoint(&format!(
            "{engine} keeps no state (capability Checkpoint): this run cannot be resumed"
        ))
    }

    /// Is the state of this step to be kept?
    pub fn due(&self, step: u64) -> bool {
        self.rule.as_ref().is_some_and(|rule| {
            rule.every_steps
                .is_some_and(|every| step.is_multiple_of(every))
                || self.since.elapsed() >= rule.every_wall
        })
    }

    /// Keep the accepted state, unless that was done: was it kept now? That it cannot be is told, and the run
    /// goes on.
    pub fn keep<const D: usize, const N: usize>(
        &mut self,
        simulation: &mut Simulation<D, N>,
        moment: Moment,
        totals: &[Diagnostic],
        recording: &Recording,
        listener: &mut Listener,
    ) -> Result<bool, CouplerError>
    where
        Dim<D>: Dimension<D>,
    {
        let step = simulation.state.step;
        let Some(rule) = self.rule.as_ref().filter(|_| self.last != Some(step)) else {
            return Ok(false);
        };
        self.since = Instant::now();
        let folder = rule.folder.join(draft(step));
        recording.pause(true);
        let written = write(&folder, simulation, moment, totals, recording);
        recording.pause(false);
        match written {
            Ok(()) => {
                self.last = Some(step);
                listener.checkpoint(step, simulation.state.time)?;
                Ok(true)
            }
            Err(error) => {
                let _ = std::fs::remove_dir_all(&folder);
                listener.no_checkpoint(&format!("step {step} could not be kept: {error}"))?;
                Ok(false)
            }
        }
    }
}

/// All parts of the accepted state.
fn write<const D: usize, const N: usize>(
    folder: &Path,
    simulation: &mut Simulation<D, N>,
    moment: Moment,
    totals: &[Diagnostic],
    recording: &Recording,
) -> Result<(), CouplerError>
where
    Dim<D>: Dimension<D>,
{
    begin(folder).map_err(|error| unusable(folder, format!("cannot be written: {error}")))?;
    for partner in simulation.system.partners() {
        let seat = partner.hello().role.seat();
        partner.save(&folder.join(seat))?;
    }
    let recorded = moment.recorded.filter(|_| recording.settle());
    Kept::of(simulation, moment.clock, totals, recorded).write(folder)
}

/// An empty folder for a draft. Where the folder of the run is gone, it is not made again.
fn begin(draft: &Path) -> std::io::Result<()> {
    if draft.exists() {
        std::fs::remove_dir_all(draft)?;
    }
    match draft.parent().map(std::fs::create_dir) {
        Some(Err(error)) if error.kind() != ErrorKind::AlreadyExists => return Err(error),
        _ => {}
    }
    std::fs::create_dir(draft)
}
