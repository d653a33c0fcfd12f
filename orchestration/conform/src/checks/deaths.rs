//! The end of a run as an engine sees it: the coupler and the orchestrator die in each of its
//! states, are silent, or tell it to end. It must be gone within two seconds, and as the last one of
//! the run it must have removed the run from shared memory.
//!
//! What dies is a process of this same program, [`play_coupler`]; it has both other seats.

use std::io::{BufRead, BufReader, Read, Write};
use std::path::PathBuf;
use std::process::{Child, ChildStdout, Command, Stdio};
use std::time::{Duration, Instant};

use nix::sys::signal::Signal;
use protocol::field::Field;
use protocol::header::FieldHeader;
use protocol::partner::Partner;
use protocol::runspace::{RunSpace, files_of};

use crate::bench::{Bench, LEAVE, header, send_advance};
use crate::case::{Case, Part};
use crate::check::{ANSWERS, Check, HELLO, READY, Trouble};
use crate::subject::Subject;
use scene::error::{Error, exit_code};

pub(super) const CHECKS: &[Check] = &[
    Check::new(
        "told-to-end",
        "SIGTERM makes it leave its seat with exit code 143",
        HELLO,
        told_to_end,
    ),
    Check::new(
        "silent-coupler",
        "a silent coupler makes it leave with exit code 6 after SILLAGE_IDLE_LIMIT",
        HELLO,
        silent_coupler,
    ),
    Check::new(
        "death-before-hello",
        "the run dies while it knocks: exit code 5 within 2 s, nothing left",
        HELLO,
        |case| death(case, State::Knocking),
    ),
    Check::new(
        "death-after-hello",
        "the run dies before Configure: exit code 5 within 2 s, nothing left",
        HELLO,
        |case| death(case, State::Greeted),
    ),
    Check::new(
        "death-configured",
        "the run dies after Ready: exit code 5 within 2 s, nothing left",
        READY,
        |case| death(case, State::Configured),
    ),
    Check::new(
        "death-within-advance",
        "the run dies with an Advance open: exit code 5 within 2 s, nothing left",
        ANSWERS,
        |case| death(case, State::Advancing),
    ),
    Check::new(
        "death-after-commit",
        "the run dies after Commit: exit code 5 within 2 s, nothing left",
        ANSWERS,
        |case| death(case, State::Committed),
    ),
];

/// What the engine is doing when the run dies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum State {
    /// It has its seat; nobody hears its hello.
    Knocking,
    /// Its hello was heard.
    Greeted,
    /// It is ready.
    Configured,
    /// It was asked for a candidate.
    Advancing,
    /// Its first step was accepted.
    Committed,
}

impl State {
    /// All of them, in the order in which an engine passes through.
    pub const ALL: [State; 5] = [
        State::Knocking,
        State::Greeted,
        State::Configured,
        State::Advancing,
        State::Committed,
    ];

    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            State::Knocking => "knocking",
            State::Greeted => "greeted",
            State::Configured => "configured",
            State::Advancing => "advancing",
            State::Committed => "committed",
        }
    }
}

/// Between the variables of the run and the word that the state is reached.
const END_OF_VARIABLES: &str = "--";
const THERE: &str = "there";

/// The process that dies: makes a run, says its variables on stdout, brings the engine into the
/// state, says so, and waits to be killed.
pub fn play_coupler(case: &Case, state: State) -> Result<(), Error> {
    let runspace = RunSpace::create()?;
    for (name, value) in runspace.to_environment() {
        say(&format!("{name}={value}"))?;
    }
    say(END_OF_VARIABLES)?;
    let _partner = match state {
        State::Knocking => {
            wait_for_seat(case, &runspace)?;
            None
        }
        _ => Some(bring(case, state, &runspace)?),
    };
    say(THERE)?;
    std::thread::sleep(case.patience());
    Err(Error::Run {
        code: exit_code::TIME_LIMIT,
        why: "nobody killed this process".to_owned(),
    })
}

fn say(line: &str) -> Result<(), Error> {
    let mut out = std::io::stdout().lock();
    let said = writeln!(out, "{line}").and_then(|()| out.flush());
    said.map_err(Error::file("cannot write to", "stdout"))
}

fn wait_for_seat(case: &Case, runspace: &RunSpace) -> Result<(), Error> {
    let seat = format!(
        "/dev/shm/sillage-{}/members/{}",
        runspace.id(),
        case.role.seat()
    );
    let begin = Instant::now();
    while !std::path::Path::new(&seat).exists() {
        if begin.elapsed() > case.patience() {
            return Err(Error::Run {
                code: exit_code::TIME_LIMIT,
                why: format!("nobody took {seat} within {} s", case.limit),
            });
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    Ok(())
}

fn bring(case: &Case, state: State, runspace: &RunSpace) -> Result<Partner, protocol::Error> {
    let mut partner = Partner::accept(case.role, runspace, &case.limits())?;
    if state == State::Greeted {
        return Ok(partner);
    }
    let count = match &case.part {
        Part::Fluid(scene) => partner.configure_fluid(scene)?.nodal_mass.len(),
        Part::Particles(scene, grains) => partner.configure_particles(scene, grains)?.radius.len(),
    };
    let (request, inputs) = (
        case.request(1, 0),
        case.inputs(count, 0, &partner.hello().capabilities),
    );
    match state {
        State::Advancing => {
            let inputs: Vec<(Field, FieldHeader, Vec<f64>)> = inputs
                .into_iter()
                .map(|(field, values)| {
                    (
                        field,
                        header(&partner, (count, case.dimension()), &request, field),
                        values,
                    )
                })
                .collect();
            send_advance(&mut partner, &request, &inputs)?;
        }
        State::Committed => {
            let given: Vec<(Field, &[f64])> = inputs
                .iter()
                .map(|(field, values)| (*field, values.as_slice()))
                .collect();
            partner.advance(&request, &given, &mut [])?;
            partner.commit(1)?;
        }
        _ => {}
    }
    Ok(partner)
}

/// A process of [`play_coupler`], killed when dropped.
struct Victim {
    child: Child,
    words: BufReader<ChildStdout>,
}

impl Victim {
    fn start(case: &Case, state: State) -> Result<Victim, String> {
        let program = std::env::current_exe().map_err(|e| e.to_string())?;
        let (state, seat) = (state.name(), case.role.seat());
        let mut command = Command::new(program);
        command.args(["conform-coupler", "--as", seat, "--state", state]);
        command.args(["--limit", &case.limit.to_string()]);
        for setting in &case.settings {
            command.args(["--set", setting]);
        }
        if let Some(scene) = &case.scene {
            command.arg("--scene").arg(scene);
        }
        let started = command.stdin(Stdio::null()).stdout(Stdio::piped()).spawn();
        let mut child = started.map_err(|e| format!("the coupler cannot be started: {e}"))?;
        let words = child.stdout.take().map(BufReader::new);
        let words = words.ok_or("the coupler has no stdout")?;
        Ok(Victim { child, words })
    }

    /// Its lines until this one, which it says within its own limits or ends.
    fn until(&mut self, last: &str) -> Result<Vec<String>, String> {
        let mut lines = Vec::new();
        for line in self.words.by_ref().lines() {
            let line = line.map_err(|e| e.to_string())?;
            if line == last {
                return Ok(lines);
            }
            lines.push(line);
        }
        Err("the coupler could not bring it there".to_owned())
    }
}

impl Drop for Victim {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn death(case: &Case, state: State) -> Result<(), Trouble> {
    let mut victim = Victim::start(case, state)?;
    let variables: Vec<(String, String)> = victim
        .until(END_OF_VARIABLES)?
        .iter()
        .filter_map(|line| line.split_once('='))
        .map(|(name, value)| (name.to_owned(), value.to_owned()))
        .collect();
    let run = variables
        .iter()
        .find(|(name, _)| name == protocol::runspace::ENV_RUN);
    let run = run
        .map(|(_, id)| id.clone())
        .ok_or("the coupler did not name its run".to_owned())?;
    let mut subject = Subject::start(&case.command, &variables).map_err(|e| e.to_string())?;
    if let Err(why) = victim.until(THERE) {
        return Err(format!("{why}{}", subject.postscript()).into());
    }
    drop(victim);
    let left = subject.must_leave(exit_code::PARTNER_LOST, LEAVE);
    drop(subject);
    let behind = left_behind(&run);
    if !behind.is_empty() {
        // Not its to remove when it was killed here.
        let left = RunSpace::leftovers().into_iter().flatten();
        left.filter(|left| left.id == run).for_each(|left| {
            let _ = left.sweep();
        });
    }
    left.map_err(|why| format!("after the death {why}"))?;
    match behind.first() {
        None => Ok(()),
        Some(file) => Err(format!(
            "it left {} files in shared memory, e.g. {}",
            behind.len(),
            file.display()
        )
        .into()),
    }
}

/// What the run left, once no start of another run is at its removal, which puts it aside first.
fn left_behind(run: &str) -> Vec<PathBuf> {
    let begin = Instant::now();
    loop {
        let files = files_of(run);
        let is_aside = |path: &PathBuf| {
            let name = path.file_name().unwrap_or_default();
            name.to_string_lossy().starts_with('.')
        };
        if files.is_empty() || !files.iter().all(is_aside) || begin.elapsed() > LEAVE {
            return files;
        }
        std::thread::sleep(Duration::from_millis(5));
    }
}

fn told_to_end(case: &Case) -> Result<(), Trouble> {
    let runspace = RunSpace::create().map_err(|e| e.to_string())?;
    let mut bench = Bench::greet_with(case, &runspace, &[])?;
    bench.configure()?;
    bench.subject.signal(Signal::SIGTERM);
    bench.subject.must_leave(143, LEAVE)?;
    let seat = format!(
        "/dev/shm/sillage-{}/members/{}",
        runspace.id(),
        case.role.seat()
    );
    if std::path::Path::new(&seat).exists() {
        return Err(format!("it was told to end and {seat} is still there").into());
    }
    Ok(())
}

fn silent_coupler(case: &Case) -> Result<(), Trouble> {
    let runspace = RunSpace::create().map_err(|e| e.to_string())?;
    let mut bench = Bench::greet_with(case, &runspace, &[("SILLAGE_IDLE_LIMIT", "0.3")])?;
    Ok(bench.subject.must_leave(exit_code::TIME_LIMIT, LEAVE)?)
}
