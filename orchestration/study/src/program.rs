//! Points that are not runs of a scene: a program that prints one JSON object of numbers.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use nix::sys::resource::{UsageWho, getrusage};
use nix::sys::time::TimeValLike;
use serde_json::{Value, json};

use run::batch::{self, Done};
use run::file;
use run::interrupt::Interrupts;
use run::launch;
use scene::error::{Error, exit_code};

/// How often a program is looked at.
const TICK: Duration = Duration::from_millis(5);

/// A program with the arguments of a point.
#[derive(Debug, Clone)]
pub struct Program {
    path: PathBuf,
    arguments: Vec<String>,
}

impl Program {
    /// `name` is looked for beside `sillage`.
    pub fn new(name: &str, arguments: &[String]) -> Result<Program, Error> {
        Ok(Program {
            path: launch::sibling(name)?,
            arguments: arguments.to_vec(),
        })
    }

    /// What makes a point the same: the program and its arguments.
    pub fn mark(&self) -> Value {
        json!({ "program": self.path.file_name().map(|name| name.to_string_lossy()), "arguments": self.arguments })
    }

    /// Run it; what it prints becomes `run.json`, with its cost beside it. None when it was interrupted.
    pub fn run(&self, place: &Path, interrupts: &Interrupts) -> Result<Option<Done>, Error> {
        std::fs::create_dir_all(place).map_err(Error::file("cannot create", place))?;
        let log = place.join("program.log");
        let errors = std::fs::File::create(&log).map_err(Error::file("cannot create", &log))?;
        let (begun, cpu_before) = (Instant::now(), cpu_of_children());
        let mut child = Command::new(&self.path)
            .args(&self.arguments)
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(errors)
            .spawn()
            .map_err(Error::file("cannot start", &self.path))?;
        // What it prints fits a pipe: reading can wait for its end.
        let mut memory = 0;
        let waiting = |error| Error::file("cannot wait for", &self.path)(error);
        while child.try_wait().map_err(waiting)?.is_none() {
            memory = launch::memory_peak(child.id()).unwrap_or(memory);
            if interrupts.so_far() > 0 {
                child.kill().map_err(waiting)?;
            }
            std::thread::sleep(TICK);
        }
        let output = child.wait_with_output().map_err(waiting)?;
        let wall = begun.elapsed().as_secs_f64();
        if output.status.code().is_none() && interrupts.so_far() > 0 {
            return Ok(None);
        }
        let words = std::fs::read_to_string(&log).unwrap_or_default();
        let printed = serde_json::from_slice::<Value>(&output.stdout);
        let (code, why, mut document) = match (output.status.code(), printed) {
            (Some(0), Ok(document)) if document.is_object() => (exit_code::OK, None, document),
            (Some(0), _) => (
                exit_code::ENGINE,
                Some(format!(
                    "{} did not print a JSON object",
                    self.path.display()
                )),
                json!({}),
            ),
            (Some(code), _) => (code, words.lines().next_back().map(String::from), json!({})),
            // Ended by a signal of its own.
            (None, _) => (
                exit_code::ENGINE,
                Some(output.status.to_string()),
                json!({}),
            ),
        };
        document["cost"] = json!({
            "cpu_process": { "program": cpu_of_children() - cpu_before },
            "memory_peak": { "program": memory },
            "wall_total": wall,
        });
        file::write(&place.join("run.json"), format!("{document:#}\n"))?;
        let point = batch::write_point(place, &self.mark(), code, why.as_deref())?;
        Ok(Some(Done { point, document }))
    }
}

/// User and system time of all children that have ended \[s\].
fn cpu_of_children() -> f64 {
    getrusage(UsageWho::RUSAGE_CHILDREN).map_or(f64::NAN, |usage| {
        let microseconds =
            usage.user_time().num_microseconds() + usage.system_time().num_microseconds();
        1e-6 * microseconds as f64
    })
}
