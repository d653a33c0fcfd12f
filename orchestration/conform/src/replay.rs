//! Plays the coupler of a recording towards one engine, in a run of its own.

use std::path::Path;
use std::process::Command;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use nix::sys::signal::Signal;
use protocol::message::{Diagnostic, Role};
use protocol::partner::Partner;
use protocol::runspace::RunSpace;
use recording::{Reader, ReplayError, Report, compare};
use run::interrupt::Interrupts;
use run::launch::{self, Process};
use run::progress::Progress;
use scene::error::{Error, exit_code};

/// How often the engine's process is looked at.
const TICK: Duration = Duration::from_millis(20);
/// How long it may take to leave after the replay.
const PATIENCE: Duration = Duration::from_secs(2);

/// What was compared, as text.
pub fn text(report: &Report, tolerance: f64) -> String {
    let mut text = String::new();
    for (what, hello) in [
        ("recorded", &report.recorded),
        ("replayed", &report.replayed),
    ] {
        if let Some(hello) = hello {
            text += &format!("{what}: {} {}\n", hello.engine, hello.version);
        }
    }
    text += &compare::text(&report.fields, tolerance);
    if !report.left_out.is_empty() {
        text += &format!("not compared: {}\n", report.left_out.join(", "));
    }
    if let Some(why) = &report.stopped {
        text += &format!("stopped: {why}\n");
    }
    let verdict = if report.within(tolerance) {
        "within"
    } else {
        "OUTSIDE"
    };
    text += &format!(
        "{} steps, {} answers, {verdict} the tolerance {tolerance:e}\n",
        report.steps, report.answers
    );
    text
}

/// Replay a recording to one engine: the built-in one, or that of a command.
pub fn replay(reader: &mut Reader, role: Role, engine: Option<&str>) -> Result<Report, Error> {
    let scene = &reader.begin().scene;
    if !scene.has_process(role) {
        return Err(Error::Usage(format!(
            "{} has no {}: the scene does without",
            reader.path().display(),
            role.seat()
        )));
    }
    let (limits, mut progress) = (scene.limits, Progress::new(scene.end_time));
    let runspace = RunSpace::create()?;
    let folder = runspace.folder("replay")?;
    let interrupts = Interrupts::count()?;
    let engine = Engine::start(role, engine, &folder, &runspace, &interrupts)?;
    // A link that was opened before the engine could be is closed before the engine is reaped.
    let played = Partner::accept(role, &runspace, &limits)
        .map_err(ReplayError::from)
        .and_then(|mut partner| {
            let accepted = |step: u64, time: f64| {
                let values = [("step", step as f64), ("time", time)];
                progress.step(&values.map(|(name, value)| Diagnostic {
                    name: name.to_string(),
                    value,
                }));
            };
            recording::replay(reader, &mut partner, &folder, accepted)
        });
    progress.finish();
    let process = engine.end();
    let report = judged(played, process.as_ref(), &interrupts);
    // With it goes the folder, and what the engine said.
    if let Err(error) = runspace.sweep() {
        tracing::warn!("{error}");
    }
    report
}

fn judged(
    played: Result<Report, ReplayError>,
    process: Option<&Process>,
    interrupts: &Interrupts,
) -> Result<Report, Error> {
    if interrupts.so_far() > 0 {
        return Err(Error::Run {
            code: exit_code::INTERRUPTED,
            why: "interrupted".to_string(),
        });
    }
    played.map_err(|error| match error {
        ReplayError::Recording(error) => error.into(),
        ReplayError::Exchange(error) => {
            if let Some(process) = process {
                run::tell!("    {} {}", process.seat, process.ending());
                for line in process.last_words(5) {
                    run::tell!("    {line}");
                }
            }
            error.into()
        }
    })
}

/// The engine's process, and the thread that notices its end.
struct Engine {
    over: Arc<AtomicBool>,
    watch: JoinHandle<Process>,
}

impl Engine {
    fn start(
        role: Role,
        engine: Option<&str>,
        folder: &Path,
        runspace: &RunSpace,
        interrupts: &Interrupts,
    ) -> Result<Engine, Error> {
        let seat = role.seat();
        let command = match engine {
            None => Command::new(launch::sibling(&format!("sillage-{seat}"))?),
            Some(words) if words.trim().is_empty() => {
                return Err(Error::Usage("--engine names no program".to_string()));
            }
            Some(words) => {
                // The shell knows how words are quoted; it becomes the engine.
                let mut command = Command::new("sh");
                command.arg("-c").arg(format!("exec {words}"));
                command
            }
        };
        let log = folder.join(format!("{seat}.log"));
        let built_in = format!("sillage-{seat}");
        let process = launch::spawn(seat, engine.unwrap_or(&built_in), command, log, runspace)?;
        let over = Arc::new(AtomicBool::new(false));
        let (told, runspace) = (Arc::clone(&over), runspace.clone());
        let interrupts = interrupts.clone();
        let watch = std::thread::spawn(move || watch(process, &told, &runspace, &interrupts));
        Ok(Engine { over, watch })
    }

    /// The replay is over: the process has ended when this returns.
    fn end(self) -> Option<Process> {
        self.over.store(true, Ordering::Release);
        self.watch.join().ok()
    }
}

/// Until the process has ended; who waits for it hears of it. When it is not needed any more it may
/// leave by itself for a while; an interruption ends it, and with it the replay.
fn watch(
    mut process: Process,
    over: &AtomicBool,
    runspace: &RunSpace,
    interrupts: &Interrupts,
) -> Process {
    let mut patience = PATIENCE;
    loop {
        process.poll();
        if process.ended.is_some() {
            // Without effect unless it ended before it joined the run.
            let _ = runspace.mark_lost(&process.seat);
            return process;
        }
        std::thread::sleep(TICK);
        if interrupts.so_far() > 0 && !process.signalled {
            process.signal(Signal::SIGTERM);
        }
        if over.load(Ordering::Acquire) {
            if patience.is_zero() {
                process.signal(Signal::SIGKILL);
            }
            patience = patience.saturating_sub(TICK);
        }
    }
}
