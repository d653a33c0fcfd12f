//! `sillage run`: from a scene to a run folder.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::{Instant, SystemTime};

use protocol::monitor::MonitorReceiver;
use protocol::runspace::RunSpace;
use scene::Scene;
use scene::error::{Error, exit_code};
use serde_json::Value;
use time::OffsetDateTime;

use crate::folder::document::{self, Ending};
use crate::folder::draw::Pictures;
use crate::folder::lock::Lock;
use crate::folder::recorded;
use crate::folder::run_folder::RunFolder;
use crate::folder::writer::Writer;
use crate::interrupt::Interrupts;
use crate::launch::{self, Process};
use crate::progress::Progress;
use crate::verdict::Verdict;
use crate::watch::Watch;

/// A run that was started and is over.
pub struct Outcome {
    /// The run folder.
    pub folder: PathBuf,
    /// `run.json`.
    pub document: Value,
    /// How it ended.
    pub ending: Ending,
}

/// What each process used.
#[derive(Default)]
struct Used {
    cpu: BTreeMap<String, f64>,
    memory_peak: BTreeMap<String, u64>,
}

/// What a run says on stderr.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Voice {
    /// Where it goes, how far it is, and the last words of what failed.
    Aloud,
    /// Nothing: its outcome says it all.
    Quiet,
}

/// How scenes are run: who may interrupt them, what is said, who draws.
pub struct Runner {
    /// Ctrl-C.
    pub interrupts: Interrupts,
    /// What is said.
    pub voice: Voice,
    /// What draws.
    pub pictures: Pictures,
}

impl Runner {
    /// A runner that counts interruptions from now on.
    pub fn new(voice: Voice, pictures: Pictures) -> Result<Runner, Error> {
        Ok(Runner {
            interrupts: Interrupts::count()?,
            voice,
            pictures,
        })
    }

    /// Run a scene into this folder. Several may run at the same time, each in its own.
    pub fn run(&self, scene: &Scene, path: &Path) -> Result<Outcome, Error> {
        let begun = Instant::now();
        // A folder that cannot be used is a wrong --out, found before anything is computed.
        let unusable = |error: Error| Error::Usage(error.to_string());
        require_folder(path)?;
        let _lock = Lock::take(path).map_err(unusable)?;
        clear_previous(path).map_err(unusable)?;
        let folder = RunFolder::create(path, scene).map_err(unusable)?;
        document::write(path, &document::document(scene, &folder, None))?;
        if self.voice == Voice::Aloud {
            eprintln!("{} → {}", scene.name, path.display());
        }

        let writer = Writer::start(folder, (self.pictures)(scene, path));
        let mut used = Used::default();
        let verdict = self.follow(scene, path, &writer, &mut used);
        let (folder, written) = writer.finish()?;
        let verdict = match (verdict, written) {
            (Ok(verdict), Ok(())) => verdict,
            (
                Ok(Verdict {
                    code: exit_code::OK,
                    ..
                }),
                Err(error),
            ) => Verdict {
                code: error.exit_code(),
                why: Some(format!(
                    "the run finished, but its folder is not complete: {error}"
                )),
            },
            (Ok(verdict), Err(error)) => {
                eprintln!("sillage: {error}");
                verdict
            }
            // Could not be started: run.json says so as well.
            (Err(error), _) => Verdict {
                code: error.exit_code(),
                why: Some(error.to_string()),
            },
        };
        let Verdict { code, why } = verdict;
        let ending = Ending {
            code,
            why,
            wall: begun.elapsed().as_secs_f64(),
            cpu: used.cpu,
            memory_peak: used.memory_peak,
        };
        let document = document::document(scene, &folder, Some(&ending));
        document::write(path, &document)?;
        Ok(Outcome {
            folder: path.to_path_buf(),
            document,
            ending,
        })
    }

    /// Start the processes, follow them, leave nothing behind.
    fn follow(
        &self,
        scene: &Scene,
        path: &Path,
        writer: &Writer,
        used: &mut Used,
    ) -> Result<Verdict, Error> {
        let runspace = RunSpace::create().map_err(transport)?;
        let monitor = MonitorReceiver::create(&runspace).map_err(transport)?;
        let processes = launch::launch(scene, path, &runspace)?;
        let mut watch = Watch {
            runspace: &runspace,
            monitor,
            processes,
            writer,
            interrupts: self.interrupts.clone(),
            progress: match self.voice {
                Voice::Aloud => Progress::new(scene.coupler.end_time),
                Voice::Quiet => Progress::silent(scene.coupler.end_time),
            },
        };
        let verdict = watch.follow();
        for Process {
            seat,
            cpu,
            memory_peak,
            ..
        } in &watch.processes
        {
            used.cpu.insert(seat.clone(), *cpu);
            used.memory_peak.insert(seat.clone(), *memory_peak);
        }
        let failed = verdict.code != exit_code::OK && verdict.code != exit_code::INTERRUPTED;
        if failed && self.voice == Voice::Aloud {
            show_last_words(&watch.processes);
        }
        drop(watch);
        // Everything is reaped and our own end is closed: what is still there nobody uses.
        if let Err(error) = runspace.sweep() {
            tracing::warn!("{error}");
        }
        Ok(verdict)
    }
}

fn transport(error: protocol::error::Error) -> Error {
    Error::Run {
        code: error.exit_code(),
        why: error.to_string(),
    }
}

/// What failed processes said last; those that only lost a partner have nothing to add.
fn show_last_words(processes: &[Process]) {
    let failed = |process: &&Process| {
        !process.signalled && !matches!(process.code(), Some(0 | exit_code::PARTNER_LOST))
    };
    for process in processes.iter().filter(failed) {
        eprintln!(
            "--- {} {}; {}",
            process.seat,
            process.ending(),
            process.log.display()
        );
        for line in process.last_words(5) {
            eprintln!("    {line}");
        }
    }
}

/// `runs/<scene>-<time>`, with a number when there is one already.
pub fn fresh_folder(name: &str) -> Result<PathBuf, Error> {
    let runs = Path::new("runs");
    std::fs::create_dir_all(runs).map_err(Error::file("cannot create", runs))?;
    let stamp = timestamp(SystemTime::now());
    for attempt in 1.. {
        let suffix = if attempt == 1 {
            String::new()
        } else {
            format!("-{attempt}")
        };
        let path = runs.join(format!("{name}-{stamp}{suffix}"));
        match std::fs::create_dir(&path) {
            Ok(()) => return Ok(path),
            Err(error) if error.kind() == std::io::ErrorKind::AlreadyExists => {}
            Err(error) => return Err(Error::file("cannot create", &path)(error)),
        }
    }
    unreachable!("the loop ends with a folder or an error")
}

fn require_folder(path: &Path) -> Result<(), Error> {
    if path.exists() && !path.is_dir() {
        return Err(Error::Usage(format!(
            "--out {}: is not a folder",
            path.display()
        )));
    }
    Ok(())
}

/// Remove what an earlier run left in this folder, and nothing else.
fn clear_previous(path: &Path) -> Result<(), Error> {
    if !path.join("run.json").exists() {
        return Ok(());
    }
    let recording = recorded::in_folder(path).filter(|file| file.starts_with(path));
    if let Some(file) = recording.filter(|file| file.exists()) {
        std::fs::remove_file(&file).map_err(Error::file("cannot remove", &file))?;
    }
    for name in [
        "run.json",
        "steps.csv",
        "fluid.pvd",
        "grains.pvd",
        "overview.png",
        "report.html",
        "grains.csv",
    ] {
        let file = path.join(name);
        if file.exists() {
            std::fs::remove_file(&file).map_err(Error::file("cannot remove", &file))?;
        }
    }
    for name in ["vtu", "frames", "logs"] {
        let folder = path.join(name);
        if folder.exists() {
            std::fs::remove_dir_all(&folder).map_err(Error::file("cannot remove", &folder))?;
        }
    }
    Ok(())
}

/// 20261122-114500, UTC.
fn timestamp(now: SystemTime) -> String {
    let now = OffsetDateTime::from(now);
    let (year, month, day) = now.to_calendar_date();
    let (hour, minute, second) = now.to_hms();
    let month = u8::from(month);
    format!("{year:04}{month:02}{day:02}-{hour:02}{minute:02}{second:02}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn timestamps_follow_the_calendar() {
        let at =
            |seconds| timestamp(SystemTime::UNIX_EPOCH + std::time::Duration::from_secs(seconds));
        assert_eq!(at(0), "19700101-000000");
        assert_eq!(at(951_782_400), "20000229-000000");
        assert_eq!(at(1_795_348_800), "20261122-120000");
        assert_eq!(at(4_107_542_399), "21000228-235959");
    }
}
