//! A process of the command under test: started, watched, ended.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use nix::sys::signal::{Signal, killpg};
use nix::unistd::Pid;

use run::launch;
use scene::error::{Error, exit_code};

/// How often an end is looked for.
const TICK: Duration = Duration::from_millis(5);

/// One process of the command under test; killed with all it started when dropped.
pub struct Subject {
    child: Child,
    words: File,
    ended: Option<ExitStatus>,
}

impl Subject {
    /// Start the command with these variables; nothing of a run around this one is passed on.
    pub fn start(command: &[String], variables: &[(String, String)]) -> Result<Subject, Error> {
        let unusable = Error::file("cannot create a file in", std::env::temp_dir());
        // Appending: reading from the start does not move where the process writes.
        let words = tempfile::Builder::new().append(true).tempfile();
        let words = words.map_err(unusable)?.into_file();
        let copy = || {
            words
                .try_clone()
                .map_err(Error::file("cannot write", "log"))
        };
        let (program, arguments) = command
            .split_first()
            .ok_or_else(|| Error::Usage("no command after `--`".to_owned()))?;
        let child = Command::new(launch::program_of_scene(program, Path::new("")))
            .args(arguments)
            .env_remove("SILLAGE_RUN")
            .env_remove("SILLAGE_ORCHESTRATOR")
            .env_remove("SILLAGE_TOKEN")
            .envs(variables.iter().cloned())
            .stdin(Stdio::null())
            .stdout(copy()?)
            .stderr(copy()?)
            .process_group(0)
            .spawn()
            .map_err(|error| Error::Run {
                code: exit_code::ENGINE,
                why: format!("{} cannot be started: {error}", command.join(" ")),
            })?;
        Ok(Subject {
            child,
            words,
            ended: None,
        })
    }

    /// How it ended, if it has.
    pub fn ended(&mut self) -> Option<ExitStatus> {
        if self.ended.is_none() {
            self.ended = self.child.try_wait().ok().flatten();
        }
        self.ended
    }

    /// How it ended, if it does within `limit`.
    pub fn wait(&mut self, limit: Duration) -> Option<ExitStatus> {
        let begin = Instant::now();
        while self.ended().is_none() && begin.elapsed() < limit {
            std::thread::sleep(TICK);
        }
        self.ended()
    }

    /// Require that it ends within `limit` with this exit code.
    pub fn must_leave(&mut self, code: i32, limit: Duration) -> Result<(), String> {
        let begin = Instant::now();
        let Some(status) = self.wait(limit) else {
            let seconds = limit.as_secs_f64();
            return Err(format!(
                "it still runs {seconds} s later, exit code {code} expected{}",
                self.last_words()
            ));
        };
        if status.code() == Some(code) {
            return Ok(());
        }
        let how = describe(status);
        Err(format!(
            "it {how} after {:.1} s, exit code {code} expected{}",
            begin.elapsed().as_secs_f64(),
            self.last_words()
        ))
    }

    /// Send a signal to it and to what it started.
    pub fn signal(&self, signal: Signal) {
        // It may end at this very moment.
        let _ = killpg(Pid::from_raw(self.child.id() as i32), signal);
    }

    /// "; it said: …" with the last line it wrote, or nothing.
    pub fn last_words(&mut self) -> String {
        let mut bytes = Vec::new();
        let read = self
            .words
            .seek(SeekFrom::Start(0))
            .and_then(|_| self.words.read_to_end(&mut bytes));
        let text = String::from_utf8_lossy(&bytes);
        let line = text.lines().rev().find(|line| !line.trim().is_empty());
        match (read, line) {
            (Ok(_), Some(line)) => format!("; it said: {}", plain(line)),
            _ => String::new(),
        }
    }

    /// "; it ended with exit code 1; it said: …" when it has ended, or nothing.
    pub fn postscript(&mut self) -> String {
        match self.wait(Duration::from_millis(200)) {
            Some(status) => format!("; it {}{}", describe(status), self.last_words()),
            None => String::new(),
        }
    }
}

impl Drop for Subject {
    fn drop(&mut self) {
        self.signal(Signal::SIGKILL);
        if self.ended.is_none() {
            let _ = self.child.wait();
        }
    }
}

/// A log line without colours.
fn plain(line: &str) -> String {
    let mut text = String::new();
    let mut characters = line.trim().chars();
    while let Some(character) = characters.next() {
        if character == '\u{1b}' {
            let _ = characters.by_ref().find(char::is_ascii_alphabetic);
        } else {
            text.push(character);
        }
    }
    text
}

fn describe(status: ExitStatus) -> String {
    match (status.code(), status.signal()) {
        (Some(code), _) => format!("ended with exit code {code}"),
        (_, Some(signal)) => {
            let name = Signal::try_from(signal).map_or("a signal", Signal::as_str);
            format!("was killed by {name}")
        }
        _ => "ended".to_owned(),
    }
}
