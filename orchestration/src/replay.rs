//! `sillage replay`: plays the coupler of a recording towards one engine, in a run of its own.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use nix::sys::signal::Signal;
use protocol::messages::{Diagnostic, Role};
use protocol::partner::Partner;
use protocol::runspace::RunSpace;
use recording::{Reader, ReplayError, Report, compare};
use serde_json::json;
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
use signal_hook::iterator::Signals;

use crate::cli::ReplayArgs;
use crate::error::{Error, exit_code};
use crate::launch::{self, Process};
use crate::progress::Progress;
use crate::record;
use crate::say;

/// How often the engine's process is looked at.
const TICK: Duration = Duration::from_millis(20);
/// How long it may take to leave after the replay.
const PATIENCE: Duration = Duration::from_secs(2);

/// The command: the table, or with `--json` a document, on standard output.
pub fn command(args: &ReplayArgs) -> Result<(), Error> {
    let path = record::find(&args.recording)?;
    let mut reader = Reader::open(&path)?;
    let Some(seat) = args.seat else {
        return tell(&mut reader, args.json);
    };
    let report = replay(&mut reader, seat.role(), args.engine.as_deref())?;
    let within = report.within(args.tolerance);
    let warning = reader.ending().warning();
    if args.json {
        let fields: serde_json::Map<String, serde_json::Value> = report
            .fields
            .iter()
            .map(|(name, row)| (name.clone(), row.to_json(args.tolerance)))
            .collect();
        let document = json!({
            "ok": within,
            "tolerance": args.tolerance,
            "seat": seat.role().seat(),
            "steps": report.steps,
            "answers": report.answers,
            "recorded": report.recorded,
            "replayed": report.replayed,
            "stopped": report.stopped,
            "not_compared": report.left_out,
            "complete": warning.is_none(),
            "fields": fields,
        });
        say!("{document:#}");
    } else {
        if let Some(commit) = &reader.begin().commit {
            say!("recorded by the programs of commit {commit}");
        }
        say!("{}", text(&report, args.tolerance));
    }
    if let Some(warning) = warning {
        eprintln!("sillage: warning: {}: {warning}", path.display());
    }
    if within {
        Ok(())
    } else {
        Err(Error::Different)
    }
}

/// What is recorded.
fn tell(reader: &mut Reader, as_json: bool) -> Result<(), Error> {
    let summary = recording::summary(reader)?;
    if as_json {
        let document = json!({
            "ok": true,
            "begin": reader.begin(),
            "complete": reader.ending().warning().is_none(),
            "summary": summary.lines().collect::<Vec<_>>(),
        });
        say!("{document:#}");
    } else {
        say!("{summary}");
    }
    Ok(())
}

fn text(report: &Report, tolerance: f64) -> String {
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
    let runspace = RunSpace::create().map_err(failed)?;
    let folder = Folder::create(&runspace)?;
    leave_when_interrupted(&folder.0)?;
    let engine = Engine::start(role, engine, &folder, &runspace)?;
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
            recording::replay(reader, &mut partner, &folder.0, accepted)
        });
    progress.finish();
    let process = engine.end();
    if let Err(error) = runspace.sweep() {
        tracing::warn!("{error}");
    }
    played.map_err(|error| match error {
        ReplayError::Recording(error) => error.into(),
        ReplayError::Exchange(error) => {
            if let Some(process) = &process {
                eprintln!("    {} {}", process.seat, process.ending());
                for line in process.last_words(5) {
                    eprintln!("    {line}");
                }
            }
            failed(error)
        }
    })
}

/// Ctrl-C: remove the folder and leave; the engine notices, leaves too and clears shared memory.
fn leave_when_interrupted(folder: &Path) -> Result<(), Error> {
    let mut signals = Signals::new([SIGINT, SIGTERM, SIGHUP])
        .map_err(Error::file("cannot handle signals of", "this process"))?;
    let folder = folder.to_path_buf();
    std::thread::spawn(move || {
        if signals.forever().next().is_some() {
            let _ = std::fs::remove_dir_all(&folder);
            eprintln!("sillage: interrupted");
            std::process::exit(exit_code::INTERRUPTED);
        }
    });
    Ok(())
}

fn failed(error: protocol::Error) -> Error {
    Error::Run {
        code: error.exit_code(),
        why: error.to_string(),
    }
}

/// A folder for the log and the mesh, removed at the end.
struct Folder(PathBuf);

impl Folder {
    fn create(runspace: &RunSpace) -> Result<Folder, Error> {
        let path = std::env::temp_dir().join(format!("sillage-replay-{}", runspace.id()));
        std::fs::create_dir_all(&path).map_err(Error::file("cannot create", &path))?;
        Ok(Folder(path))
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
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
        folder: &Folder,
        runspace: &RunSpace,
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
        let log = folder.0.join(format!("{seat}.log"));
        let built_in = format!("sillage-{seat}");
        let process = launch::spawn(seat, engine.unwrap_or(&built_in), command, log, runspace)?;
        let over = Arc::new(AtomicBool::new(false));
        let (told, runspace) = (Arc::clone(&over), runspace.clone());
        let watch = std::thread::spawn(move || watch(process, &told, &runspace));
        Ok(Engine { over, watch })
    }

    /// The replay is over: the process has ended when this returns.
    fn end(self) -> Option<Process> {
        self.over.store(true, Ordering::Release);
        self.watch.join().ok()
    }
}

/// Until the process has ended; who waits for it hears of it. When it is not needed any more it may
/// leave by itself for a while.
fn watch(mut process: Process, over: &AtomicBool, runspace: &RunSpace) -> Process {
    let mut patience = PATIENCE;
    loop {
        process.poll();
        if process.ended.is_some() {
            // Without effect unless it ended before it joined the run.
            let _ = runspace.mark_lost(&process.seat);
            return process;
        }
        std::thread::sleep(TICK);
        if over.load(Ordering::Acquire) {
            if patience.is_zero() {
                process.signal(Signal::SIGKILL);
            }
            patience = patience.saturating_sub(TICK);
        }
    }
}
