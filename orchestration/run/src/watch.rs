//! A run from the first message to the last process reaped.
//!
//! ```text
//!   running ──Finished, Stopped, a child's end, Ctrl-C──► ending ──all reaped──► over
//! ```
//!
//! Processes of a run watch each other: when one is lost the others leave by themselves within a
//! second. What still runs after two seconds is ended: SIGTERM, then SIGKILL.

use std::time::{Duration, Instant};

use nix::sys::signal::Signal;
use protocol::awake;
use protocol::field::Field;
use protocol::limits;
use protocol::message::{Hello, Role, ToOrchestrator};
use protocol::monitor::MonitorReceiver;
use protocol::runspace::RunSpace;
use scene::error::exit_code;

use crate::disk::{Teller, Trouble};
use crate::folder::writer::Writer;
use crate::interrupt::Interrupts;
use crate::launch::{self, Process};
use crate::progress::{self, Progress};
use crate::stopped::Stopped;
use crate::verdict::{Evidence, LastWord, Verdict};

/// How long processes may take to leave by themselves.
const PATIENCE: Duration = Duration::from_secs(2);
/// Between SIGTERM and SIGKILL.
const MERCY: Duration = Duration::from_secs(1);
/// How often children and interruptions are looked at.
const TICK: Duration = Duration::from_millis(50);

/// Watches over the processes of one run.
pub struct Watch<'a> {
    /// The run.
    pub runspace: &'a RunSpace,
    /// The coupler's messages.
    pub monitor: MonitorReceiver,
    /// The children.
    pub processes: Vec<Process>,
    /// Takes messages to the disk.
    pub writer: &'a Writer,
    /// Ctrl-C.
    pub interrupts: Interrupts,
    /// Fields of states that the scene asks for by name.
    pub asked: &'a [String],
    /// Shows how far the run is.
    pub progress: Progress,
    /// When the coupling began.
    pub began: Option<Instant>,
}

impl Watch<'_> {
    /// Follow the run to its end; afterwards no process of it is left.
    pub fn follow(&mut self) -> Verdict {
        let mut state = State::default();
        while self.processes.iter().any(|process| process.ended.is_none()) {
            self.listen(&mut state);
            self.look_at_children(&mut state);
            self.heed_interrupts(&mut state);
            self.heed_disk(&mut state);
            self.heed_stops(&mut state);
            self.insist(&mut state);
        }
        state.all_have_ended = true;
        // What was sent before the coupler ended is still in the queue.
        while state.connected && state.last_word.is_none() {
            let before = state.messages;
            self.listen(&mut state);
            if state.messages == before {
                break;
            }
        }
        self.progress.finish();
        self.judge(&state)
    }

    /// Seconds from then until the coupling began, and from there until nobody was left.
    pub fn phases(&self, launched: Instant) -> (f64, f64) {
        let seconds = |since: Instant| since.elapsed().as_secs_f64();
        let whole = seconds(launched);
        let steps = self.began.map_or(0.0, seconds);
        (whole - steps, steps)
    }

    /// Take one message over, or wait a tick for it.
    fn listen(&mut self, state: &mut State) {
        // What the disk cannot take the run does not compute.
        if !state.connected || !self.writer.has_room() && !state.all_have_ended {
            std::thread::sleep(TICK);
            return;
        }
        match self.monitor.next(TICK) {
            Ok(None) => {}
            Ok(Some(event)) => {
                state.messages += 1;
                match &event.message {
                    ToOrchestrator::Started { engines, .. } => {
                        state.started = true;
                        self.began = Some(Instant::now());
                        if let Some(words) = untold(self.asked, engines) {
                            self.progress.say(&words);
                        }
                    }
                    ToOrchestrator::Step(values) => self.progress.step(values),
                    ToOrchestrator::Finished(_) => state.hear(LastWord::Finished),
                    ToOrchestrator::Stopped { code, why, .. } => {
                        state.hear(LastWord::Stopped {
                            code: *code,
                            why: why.clone(),
                        });
                    }
                    ToOrchestrator::RecordingEnded(why) => self.progress.say(&format!(
                        "warning: the recording is not complete, the run goes on: {why}"
                    )),
                    ToOrchestrator::NoCheckpoint(why) => {
                        self.progress.say(&format!("no checkpoint: {why}"));
                    }
                    ToOrchestrator::Snapshot { .. }
                    | ToOrchestrator::Checkpoint { .. }
                    | ToOrchestrator::Mesh { .. } => {}
                }
                self.writer.take(event);
            }
            Err(error) => {
                tracing::debug!("no more messages: {error}");
                state.connected = false;
                state.broken = Some((error.exit_code(), error.to_string()));
                state.begin_ending();
            }
        }
    }

    fn look_at_children(&mut self, state: &mut State) {
        for process in &mut self.processes {
            let ran = process.ended.is_none();
            process.poll();
            if ran && process.ended.is_some() {
                tracing::info!("{} {}", process.seat, process.ending());
                // Without effect unless it ended before it joined the run.
                let _ = self.runspace.mark_lost(&process.seat);
                state.begin_ending();
            }
        }
    }

    /// The first interruption asks the coupler to stop after its step; the second kills.
    fn heed_interrupts(&mut self, state: &mut State) {
        let count = self.interrupts.so_far();
        if count > 0 && !state.asked_to_stop {
            state.asked_to_stop = true;
            if state.started && state.connected && self.monitor.stop().is_ok() {
                self.progress
                    .say("stopping after this step; once more to kill");
            } else {
                // Nothing was computed yet: there is no step to wait for.
                self.signal(Signal::SIGTERM);
                state.begin_ending();
            }
        }
        if count > 1 && !state.killed {
            state.killed = true;
            launch::end(&mut self.processes);
        }
    }

    /// A disk that cannot be written to is told of; when it is given up, the run stops after its step.
    fn heed_disk(&mut self, state: &mut State) {
        let trouble = self.writer.trouble();
        if let Some(words) = state.teller.look(&trouble) {
            self.progress.say(&words);
        }
        if matches!(trouble, Trouble::GivenUp(..)) && !state.gave_up {
            state.gave_up = true;
            if !state.connected || self.monitor.stop().is_err() {
                self.signal(Signal::SIGTERM);
                state.begin_ending();
            }
        }
    }

    /// A process that was stopped and does not go on is ended: the others leave then.
    fn heed_stops(&mut self, state: &mut State) {
        let Some((seat, process)) = state.stopped.look(|| self.runspace.stopped()) else {
            return;
        };
        for process in self
            .processes
            .iter_mut()
            .filter(|process| process.seat == seat)
        {
            process.signal(Signal::SIGKILL);
        }
        let why = format!(
            "the {seat} (process {process}) was stopped (SIGSTOP) and did not go on within {} s, at step {}; \
             {} steps are written",
            limits::STOPPED.duration().as_secs_f64(),
            self.progress.step + 1,
            self.progress.step
        );
        state.stopped_for_long.get_or_insert(why);
        state.begin_ending();
    }

    /// Whoever stays behind is asked to leave, then made to.
    fn insist(&mut self, state: &mut State) {
        let Some(since) = state.ending_since else {
            return;
        };
        let elapsed = awake::now() - since;
        if elapsed > PATIENCE && !state.terminated {
            state.terminated = true;
            self.signal(Signal::SIGTERM);
        }
        if elapsed > PATIENCE + MERCY {
            launch::end(&mut self.processes);
        }
    }

    fn signal(&mut self, signal: Signal) {
        for process in &mut self.processes {
            process.signal(signal);
        }
    }

    fn judge(&self, state: &State) -> Verdict {
        let (steps, time) = (self.progress.step, self.progress.time);
        if let Some(why) = &state.stopped_for_long {
            return Verdict {
                code: exit_code::TIME_LIMIT,
                why: Some(why.clone()),
            };
        }
        // A run that came to its end all the same was not interrupted.
        let finished = !state.killed && state.last_word == Some(LastWord::Finished);
        if state.asked_to_stop && !finished {
            let how = if state.killed { "killed" } else { "stopped" };
            let time = progress::digits(time);
            let why = format!("interrupted: {how} after step {steps}, t = {time} s");
            return Verdict {
                code: exit_code::INTERRUPTED,
                why: Some(why),
            };
        }
        if state.gave_up {
            // Why is known to the writer.
            return Verdict {
                code: exit_code::OK,
                why: None,
            };
        }
        let evidence = Evidence {
            processes: &self.processes,
            last_word: state.last_word.as_ref(),
            broken: state.broken.as_ref(),
            steps,
        };
        evidence.verdict()
    }
}

/// A field that the scene asks for and these engines do not have: only they know.
fn untold(asked: &[String], engines: &[Hello]) -> Option<String> {
    let particles = engines.iter().find(|hello| hello.role == Role::Particles)?;
    let optional = Field::GrainSpin;
    let lacks =
        asked.iter().any(|name| name == optional.name()) && !particles.answer().contains(&optional);
    lacks.then(|| {
        format!(
            "warning: {} does not tell {}, which output.fields names: it is not written",
            particles.engine,
            optional.name()
        )
    })
}

/// Where the watch is.
struct State {
    connected: bool,
    started: bool,
    messages: u64,
    last_word: Option<LastWord>,
    broken: Option<(i32, String)>,
    asked_to_stop: bool,
    terminated: bool,
    killed: bool,
    all_have_ended: bool,
    teller: Teller,
    stopped: Stopped,
    stopped_for_long: Option<String>,
    gave_up: bool,
    /// By the clock of `awake`.
    ending_since: Option<Duration>,
}

impl Default for State {
    fn default() -> Self {
        State {
            connected: true,
            started: false,
            messages: 0,
            last_word: None,
            broken: None,
            asked_to_stop: false,
            terminated: false,
            killed: false,
            all_have_ended: false,
            teller: Teller::default(),
            stopped: Stopped::default(),
            stopped_for_long: None,
            gave_up: false,
            ending_since: None,
        }
    }
}

impl State {
    fn begin_ending(&mut self) {
        self.ending_since.get_or_insert_with(awake::now);
    }

    fn hear(&mut self, word: LastWord) {
        self.last_word = Some(word);
        self.begin_ending();
    }
}
