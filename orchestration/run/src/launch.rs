//! Child processes: found, started with the run's environment, their words kept in `logs/`.

use std::fs::OpenOptions;
use std::io::ErrorKind;
use std::os::unix::fs::PermissionsExt;
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};

use nix::sys::signal::{Signal, killpg};
use nix::unistd::{Pid, SysconfVar, sysconf};
use protocol::process::LEAVE_OUT;
use protocol::runspace::RunSpace;
use scene::error::{Error, exit_code};
use scene::{Scene, plan, record};

use crate::begin::{self, From};
use crate::version;

/// A child of this run.
pub struct Process {
    /// fluid, particles or coupler.
    pub seat: String,
    /// Its process id.
    pub id: u32,
    /// What it said.
    pub log: PathBuf,
    /// How it ended; none while it runs.
    pub ended: Option<ExitStatus>,
    /// Was it asked to end by a signal of ours?
    pub signalled: bool,
    /// CPU time it has used \[s\].
    pub cpu: f64,
    /// Largest resident memory it was seen to have \[bytes\].
    pub memory_peak: u64,
    child: Child,
}

/// Start every process of a scene, from its start or from a checkpoint; on failure those that were started are
/// ended again.
pub fn launch(
    scene: &Scene,
    folder: &Path,
    from: From<'_>,
    runspace: &RunSpace,
) -> Result<Vec<Process>, Error> {
    let mut started = Vec::new();
    for planned in plan::processes(scene) {
        match start(&planned, scene, (folder, from), runspace) {
            Ok(process) => started.push(process),
            Err(error) => {
                // The others would wait for a seat that nobody takes.
                let _ = runspace.mark_lost(&planned.seat);
                end(&mut started);
                return Err(error);
            }
        }
    }
    Ok(started)
}

fn start(
    planned: &plan::Process,
    scene: &Scene,
    (folder, from): (&Path, From<'_>),
    runspace: &RunSpace,
) -> Result<Process, Error> {
    let mut command = command(planned, scene, folder)?;
    if planned.seat == "coupler" {
        command.args(begin::arguments(scene, folder, from));
    }
    if !scene.leave_out {
        command.env(LEAVE_OUT, "0");
    }
    let log = folder.join(format!("logs/{}.log", planned.seat));
    if matches!(from, From::Start) {
        // What was said before a run was resumed stays.
        std::fs::write(&log, "").map_err(Error::file("cannot write", &log))?;
    }
    spawn(
        &planned.seat,
        &planned.command.join(" "),
        command,
        log,
        runspace,
    )
}

/// Start a process that takes this seat of the run; what it says goes to `log`. `said` is the command
/// as its author wrote it, for the error.
pub fn spawn(
    seat: &str,
    said: &str,
    mut command: Command,
    log: PathBuf,
    runspace: &RunSpace,
) -> Result<Process, Error> {
    let seat = seat.to_string();
    let file = OpenOptions::new().create(true).append(true).open(&log);
    let file = file.map_err(Error::file("cannot write", &log))?;
    let errors = file
        .try_clone()
        .map_err(Error::file("cannot write", &log))?;
    command
        .envs(runspace.to_environment())
        .env("SILLAGE_COMMIT", version::commit().unwrap_or_default())
        .stdin(Stdio::null())
        .stdout(file)
        .stderr(errors)
        // Ctrl-C on the terminal is for the orchestrator, which then asks the coupler to stop.
        .process_group(0);
    let child = command.spawn().map_err(|error| Error::Run {
        code: exit_code::ENGINE,
        why: format!(
            "the {seat} could not be started ({said}): {error}{}",
            remedy(&error)
        ),
    })?;
    tracing::info!("{seat} is process {}", child.id());
    Ok(Process {
        seat,
        id: child.id(),
        log,
        ended: None,
        signalled: false,
        cpu: 0.0,
        memory_peak: 0,
        child,
    })
}

/// What to do about a program that is not there.
fn remedy(error: &std::io::Error) -> &'static str {
    match error.kind() {
        ErrorKind::NotFound => {
            "; engines that come with sillage are built by `cargo build --release --workspace`"
        }
        _ => "",
    }
}

/// Built-in programs lie beside this one; engines of the scene start in the scene's folder, and a
/// bare name is looked for beside this program before `PATH`.
fn command(planned: &plan::Process, scene: &Scene, folder: &Path) -> Result<Command, Error> {
    let foreign = match planned.seat.as_str() {
        "fluid" => scene.engines.fluid.is_some(),
        "particles" => scene.engines.particles.is_some(),
        _ => false,
    };
    // Checked with the scene: a command is never empty.
    let (program, arguments) = planned
        .command
        .split_first()
        .ok_or_else(|| Error::Usage(format!("engines.{}.command is empty", planned.seat)))?;
    if foreign {
        let mut command = Command::new(program_of_scene(program, &scene.folder));
        command.args(arguments).current_dir(&scene.folder);
        return Ok(command);
    }
    let mut command = Command::new(sibling(program)?);
    if planned.seat == "coupler" {
        let scene_file = folder.join("scene.json");
        let scene_file = std::path::absolute(&scene_file).unwrap_or(scene_file);
        command.arg("--scene").arg(scene_file);
        if let Some(record) = &scene.record {
            let folder = std::path::absolute(folder).unwrap_or(folder.to_path_buf());
            command.args(record::arguments(record, &folder));
        }
    } else {
        command.args(arguments);
    }
    Ok(command)
}

/// The program that a command names: a bare name is looked for beside this program, then in `PATH`;
/// one with a folder in it from `folder`.
pub fn program_of_scene(program: &str, folder: &Path) -> PathBuf {
    if !program.contains('/') {
        return sibling(program).unwrap_or_else(|_| program.into());
    }
    let path = folder.join(program);
    std::path::absolute(&path).unwrap_or(path)
}

/// Seats whose engine names a program that is nowhere, with what was looked for.
pub fn missing_programs(scene: &Scene) -> Vec<(&'static str, String)> {
    let engines = [
        ("fluid", &scene.engines.fluid, scene.coupler.fluid.is_some()),
        (
            "particles",
            &scene.engines.particles,
            scene.coupler.particles.is_some(),
        ),
    ];
    let named = engines.into_iter().filter_map(|(seat, engine, starts)| {
        let program = engine.as_ref()?.command.first()?;
        (starts && !is_program(program, &scene.folder)).then(|| (seat, nowhere(program)))
    });
    named.collect()
}

/// Refuse a scene whose engines are not there.
pub fn require_programs(scene: &Scene) -> Result<(), Error> {
    match missing_programs(scene).first() {
        None => Ok(()),
        Some((seat, why)) => Err(Error::Usage(format!("engines.{seat}.command: {why}"))),
    }
}

fn nowhere(program: &str) -> String {
    match program.contains('/') {
        true => format!("{program} is no program in the folder of the scene"),
        false => format!(
            "{program} is no program beside sillage, nor in PATH{}",
            remedy(&ErrorKind::NotFound.into())
        ),
    }
}

/// Is there such a program, for an engine of a scene in this folder?
fn is_program(program: &str, folder: &Path) -> bool {
    let path = program_of_scene(program, folder);
    if path.components().count() > 1 {
        return is_executable(&path);
    }
    let paths = std::env::var_os("PATH").unwrap_or_default();
    std::env::split_paths(&paths).any(|folder| is_executable(&folder.join(program)))
}

fn is_executable(path: &Path) -> bool {
    let mode = std::fs::metadata(path).map(|about| (about.is_file(), about.permissions().mode()));
    mode.is_ok_and(|(is_file, mode)| is_file && mode & 0o111 != 0)
}

/// A program beside this one.
pub fn sibling(name: &str) -> Result<PathBuf, Error> {
    let here = std::env::current_exe().map_err(Error::file("cannot find", "this program"))?;
    let path = here.parent().unwrap_or(Path::new(".")).join(name);
    if path.is_file() {
        return Ok(path);
    }
    Err(Error::Run {
        code: exit_code::ENGINE,
        why: format!(
            "{} does not exist: build the programs of a run with `cargo build --release`, or run \
             ./sillage, which does; all programs with `cargo build --release --workspace`",
            path.display()
        ),
    })
}

impl Process {
    /// Look whether it has ended, and reap it.
    pub fn poll(&mut self) {
        if self.ended.is_none() {
            // Also of a process that has ended, until it is reaped below.
            self.cpu = cpu_seconds(self.id).unwrap_or(self.cpu);
            // Gone from a process that has ended: the last look before counts.
            self.memory_peak = memory_peak(self.id).unwrap_or(self.memory_peak);
            // An error here means that somebody else reaped it: it has ended all the same.
            self.ended = match self.child.try_wait() {
                Ok(status) => status,
                Err(_) => Some(ExitStatus::from_raw(0)),
            };
        }
    }

    /// Send a signal to it and to what it started.
    pub fn signal(&mut self, signal: Signal) {
        if self.ended.is_none() {
            self.signalled = true;
            // It may end at this very moment.
            let _ = killpg(Pid::from_raw(self.id as i32), signal);
        }
    }

    /// The end in words: "exit code 5", "killed by SIGKILL".
    pub fn ending(&self) -> String {
        match self.ended {
            None => "still runs".into(),
            Some(status) => match (status.code(), status.signal()) {
                (Some(code), _) => match self.told() {
                    Some(signal) => format!("ended on {}, as it was told", signal.as_str()),
                    None => format!("ended with exit code {code}"),
                },
                (_, Some(7)) => {
                    "was killed by SIGBUS: shared memory is full, see `sillage doctor`".into()
                }
                (_, Some(number)) => {
                    let name = Signal::try_from(number).map_or("a signal", Signal::as_str);
                    format!("was killed by {name}")
                }
                _ => "ended".into(),
            },
        }
    }

    /// Did it end by a signal that did not come from here, at once or as it was told?
    pub fn was_killed(&self) -> bool {
        let by_signal = |status: ExitStatus| status.signal().is_some();
        !self.signalled && (self.ended.is_some_and(by_signal) || self.told().is_some())
    }

    /// The signal that it ended on by itself: by custom the exit code is 128 and the number of the signal.
    fn told(&self) -> Option<Signal> {
        let signal = Signal::try_from(self.code()? - 128).ok()?;
        let heeded = [Signal::SIGTERM, Signal::SIGHUP, Signal::SIGINT];
        heeded.contains(&signal).then_some(signal)
    }

    /// Its exit code, when it ended with one.
    pub fn code(&self) -> Option<i32> {
        self.ended.and_then(|status| status.code())
    }

    /// What it said last, most often the reason and the remedy; of its last lines one that calls itself an
    /// error goes before hints on usage.
    pub fn reason(&self) -> String {
        let mut words = self.last_words(5);
        let error = words.iter().rposition(|line| line.starts_with("error"));
        let place = error.unwrap_or(words.len().saturating_sub(1));
        words.drain(place..).next().unwrap_or_default()
    }

    /// The last lines it wrote.
    pub fn last_words(&self, lines: usize) -> Vec<String> {
        let text = std::fs::read(&self.log).unwrap_or_default();
        let text = String::from_utf8_lossy(&text);
        let all: Vec<&str> = text
            .lines()
            .filter(|line| !line.trim().is_empty())
            .collect();
        all[all.len().saturating_sub(lines)..]
            .iter()
            .map(|line| line.to_string())
            .collect()
    }
}

/// User and system time of a process \[s\], from fields 14 and 15 of /proc/PID/stat.
fn cpu_seconds(id: u32) -> Option<f64> {
    let stat = std::fs::read_to_string(format!("/proc/{id}/stat")).ok()?;
    let mut fields = stat.rsplit_once(')')?.1.split_whitespace().skip(11);
    let ticks = fields.next()?.parse::<f64>().ok()? + fields.next()?.parse::<f64>().ok()?;
    let per_second = sysconf(SysconfVar::CLK_TCK).ok()??;
    Some(ticks / per_second as f64)
}

/// Largest resident memory of a living process \[bytes\], VmHWM in /proc/PID/status.
pub fn memory_peak(id: u32) -> Option<u64> {
    let status = std::fs::read_to_string(format!("/proc/{id}/status")).ok()?;
    let line = status
        .lines()
        .find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kilobytes: u64 = line.split_whitespace().next()?.parse().ok()?;
    Some(1024 * kilobytes)
}

/// End processes at once and reap them.
pub fn end(processes: &mut [Process]) {
    for process in processes.iter_mut() {
        process.signal(Signal::SIGKILL);
    }
    for process in processes
        .iter_mut()
        .filter(|process| process.ended.is_none())
    {
        process.ended = process.child.wait().ok().or(Some(ExitStatus::from_raw(9)));
    }
}
