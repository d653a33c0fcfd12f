//! `sillage run`: from a scene to a run folder.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, SystemTime};

use protocol::monitor::MonitorReceiver;
use protocol::runspace::RunSpace;
use scene::Scene;
use scene::error::{Error, exit_code};
use serde_json::{Value, json};
use time::OffsetDateTime;

use crate::disk::{Disk, PATIENCE, Teller, Trouble};
use crate::folder::claim;
use crate::folder::document::{self, Ending};
use crate::folder::draw::Pictures;
use crate::folder::lock::Lock;
use crate::folder::previous::{NOT_STARTED, Previous};
use crate::folder::reserve::Reserve;
use crate::folder::run_folder::RunFolder;
use crate::folder::writer::Writer;
use crate::interrupt::Interrupts;
use crate::launch::{self, Process};
use crate::limits::require_open_files;
use crate::progress::Progress;
use crate::tell;
use crate::verdict::Verdict;
use crate::watch::Watch;

/// What `run.json` may grow by until the end: engines, costs, extremes, totals, and why it ended \[bytes\].
const LAST_WORD: usize = 1 << 16;

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
    phases: BTreeMap<&'static str, f64>,
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
    /// How long a disk that is full is waited for.
    pub patience: Duration,
}

impl Runner {
    /// A runner that counts interruptions from now on.
    pub fn new(voice: Voice, pictures: Pictures) -> Result<Runner, Error> {
        protocol::process::report_full_memory();
        Ok(Runner {
            interrupts: Interrupts::count()?,
            voice,
            pictures,
            patience: PATIENCE,
        })
    }

    /// Run a scene into this folder. Several may run at the same time, each in its own.
    pub fn run(&self, scene: &Scene, path: &Path) -> Result<Outcome, Error> {
        let begun = Instant::now();
        claim::RUN.check(path)?;
        claim::is_not_of_scene(path, &scene.folder)?;
        require_open_files()?;
        // A folder that cannot be used is a wrong --out, found before anything is computed.
        let unusable = |error: Error| Error::Usage(error.to_string());
        let _lock = Lock::take(path).map_err(unusable)?;
        let (folder, reserve) = prepare(path, scene).map_err(unusable)?;
        self.say(&format!("{} → {}", scene.name, path.display()));

        let disk = Disk::new(self.patience);
        let writer = Writer::start(folder, (self.pictures)(scene, path), disk.clone());
        let mut used = Used::default();
        let mut verdict = self.follow(scene, path, &writer, &mut used);
        let ended = Instant::now();
        let (mut folder, written) = self.finish(writer)?;
        used.phases.insert("end", ended.elapsed().as_secs_f64());
        if let (Ok(verdict), Err(error)) = (&mut verdict, &written) {
            incomplete(verdict, error, &folder);
        }
        // Could not be started: run.json says so as well.
        let Verdict { code, why } = verdict.unwrap_or_else(|error| Verdict {
            code: error.exit_code(),
            why: Some(error.to_string()),
        });
        let ending = Ending {
            code,
            why,
            wall: begun.elapsed().as_secs_f64(),
            cpu: used.cpu,
            memory_peak: used.memory_peak,
            phases: used.phases,
        };
        let document = document::document(scene, &folder, Some(&ending));
        let told = last_word(path, reserve, &disk, &document);
        match (told, ending.code) {
            (Err(error), exit_code::OK) => return Err(error),
            (Err(error), _) => tell!("sillage: {error}"),
            (Ok(()), _) => {}
        }
        self.keep_previous(&mut folder)?;
        Ok(Outcome {
            folder: path.to_path_buf(),
            document,
            ending,
        })
    }

    /// An earlier run that this one has not replaced comes back.
    fn keep_previous(&self, folder: &mut RunFolder) -> Result<(), Error> {
        let Some(previous) = folder.not_replaced() else {
            return Ok(());
        };
        previous.restore()?;
        self.say(&format!(
            "the earlier run in {} is kept; what this one left is in {NOT_STARTED}/",
            folder.path().display()
        ));
        Ok(())
    }

    fn say(&self, words: &str) {
        if self.voice == Voice::Aloud {
            tell!("{words}");
        }
    }

    /// Wait until the folder is written; another interruption ends the wait, and where a second one came
    /// before, a disk that is full is not waited for.
    fn finish(&self, writer: Writer) -> Result<(RunFolder, Result<(), Error>), Error> {
        let (mut teller, before) = (Teller::default(), self.interrupts.so_far());
        writer.finish(|disk| {
            let trouble = disk.trouble();
            if let Some(words) = teller.look(&trouble) {
                self.say(&words);
            }
            let count = self.interrupts.so_far();
            if count > before || count > 1 && matches!(trouble, Trouble::Waiting(_)) {
                let why = "interrupted while the folder was written";
                disk.abandon(exit_code::INTERRUPTED, why);
            }
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
        let launched = Instant::now();
        let mut watch = Watch {
            runspace: &runspace,
            monitor,
            processes,
            writer,
            interrupts: self.interrupts.clone(),
            asked: scene.output.fields.as_deref().unwrap_or_default(),
            progress: match self.voice {
                Voice::Aloud => Progress::new(scene.coupler.end_time),
                Voice::Quiet => Progress::silent(scene.coupler.end_time),
            },
            began: None,
        };
        let verdict = watch.follow();
        let (start, steps) = watch.phases(launched);
        used.phases.insert("start", start);
        used.phases.insert("steps", steps);
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
        tell!(
            "--- {} {}; {}",
            process.seat,
            process.ending(),
            process.log.display()
        );
        for line in process.last_words(5) {
            tell!("    {line}");
        }
    }
}

/// `runs/<scene>-<time>`, with a number when there is one already.
pub fn fresh_folder(name: &str) -> Result<PathBuf, Error> {
    let runs = Path::new("runs");
    let unusable = |error: std::io::Error| {
        Error::Usage(format!(
            "cannot write in this folder ({}: {error}): name one with --out",
            runs.display()
        ))
    };
    std::fs::create_dir_all(runs).map_err(unusable)?;
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
            Err(error) => return Err(unusable(error)),
        }
    }
    unreachable!("the loop ends with a folder or an error")
}

/// Set an earlier run aside and write what is known before the run, and keep room for what will be known
/// after it; when that fails the earlier one is back.
fn prepare(path: &Path, scene: &Scene) -> Result<(RunFolder, Reserve), Error> {
    let previous = Previous::set_aside(path)?;
    // First of all, so that a folder that is left half made is known as one of ours.
    let mark = json!({ "versions": document::versions() });
    let written = document::write(path, &mark).and_then(|()| {
        let folder = RunFolder::create(path, scene)?;
        let document = document::document(scene, &folder, None);
        document::write(path, &document)?;
        let reserve = Reserve::take(path, document::text(&document).len() + LAST_WORD)?;
        Ok((folder, reserve))
    });
    match (written, previous) {
        (Ok((mut folder, reserve)), previous) => {
            folder.replaces(previous);
            Ok((folder, reserve))
        }
        (Err(error), previous) => {
            previous.map_or(Ok(()), Previous::restore)?;
            Err(error)
        }
    }
}

/// The last `run.json`; room for it was kept.
fn last_word(path: &Path, reserve: Reserve, disk: &Disk, document: &Value) -> Result<(), Error> {
    let told = reserve.spend(&document::place(path), &document::text(document));
    match (told, disk.trouble()) {
        (Err(error), Trouble::GivenUp(..)) => Err(error),
        (Err(_), _) => disk.attempt(|| document::write(path, document)),
        (Ok(()), _) => Ok(()),
    }
}

/// What the folder lacks goes before how the run itself ended, unless that was worse.
fn incomplete(verdict: &mut Verdict, error: &Error, folder: &RunFolder) {
    let reached = folder.reached();
    let why = format!("{error}; what is written is complete to {reached}");
    match verdict.code {
        exit_code::OK => {
            *verdict = Verdict {
                code: error.exit_code(),
                why: Some(why),
            }
        }
        _ => tell!("sillage: {why}"),
    }
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
