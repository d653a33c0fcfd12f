//! `sillage run`: from a scene to a run folder.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use protocol::monitor::MonitorReceiver;
use protocol::runspace::RunSpace;
use protocol::scene::is_over;
use scene::error::{Error, exit_code};
use scene::{Scene, plan};
use serde_json::{Value, json};

use crate::begin::From;
use crate::disk::{Disk, PATIENCE, Teller, Trouble};
use crate::failed_step;
use crate::file;
use crate::folder::checkpoint::{self, Checkpoint};
use crate::folder::claim;
use crate::folder::document::{self, Ending};
use crate::folder::draw::{Draw, Pictures};
use crate::folder::lock::Lock;
use crate::folder::previous::{NOT_STARTED, Previous};
use crate::folder::reserve::Reserve;
use crate::folder::run_folder::RunFolder;
use crate::folder::writer::Writer;
use crate::interrupt::Interrupts;
use crate::launch::{self, Process};
use crate::limits::require_open_files;
use crate::progress::{self, Progress};
use crate::tell;
use crate::verdict::Verdict;
use crate::version;
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
    /// How to go on with a run that has not reached its end, where that is possible.
    pub way_on: Option<String>,
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
        claim::RUN.check(path)?;
        claim::is_not_of_scene(path, &scene.folder)?;
        require_open_files()?;
        // A folder that cannot be used is a wrong --out, found before anything is computed.
        let unusable = |error: Error| Error::Usage(error.to_string());
        let _lock = Lock::take(path).map_err(unusable)?;
        let (folder, reserve) = prepare(path, scene).map_err(unusable)?;
        self.say(&format!("{} → {}", scene.name, path.display()));
        let pictures = (self.pictures)(scene, path);
        self.go(scene, folder, reserve, pictures, None)
    }

    /// Go on with the run in this folder, whose scene this is, from its newest checkpoint or that of the step
    /// `from`; without any from its start. None: it has reached its end.
    pub fn resume(
        &self,
        scene: &Scene,
        path: &Path,
        from: Option<u64>,
    ) -> Result<Option<Outcome>, Error> {
        require_open_files()?;
        let lock = Lock::take(path)?;
        let found = checkpoint::newest(path, from, |words| self.say(&format!("warning: {words}")))?;
        let Some(checkpoint) = found else {
            drop(lock);
            self.say("there is no checkpoint: the run begins again");
            return self.run(scene, path).map(Some);
        };
        let Checkpoint { step, time, .. } = checkpoint;
        if is_over(time, scene.coupler.end_time) {
            return Ok(None);
        }
        let mut pictures = (self.pictures)(scene, path);
        let folder = RunFolder::resume(path, scene, &checkpoint)?;
        pictures.resume(&checkpoint.outputs.pictures)?;
        file::write(&path.join("scene.json"), plan::scene_json(scene)?)?;
        let reserve = begin_document(path, scene, &folder)?;
        let at = progress::digits(time);
        self.say(&format!(
            "{} → {}, from step {step}, t = {at} s",
            scene.name,
            path.display()
        ));
        let outcome = self.go(scene, folder, reserve, pictures, Some(&checkpoint));
        drop(lock);
        outcome.map(Some)
    }

    /// Start the processes, follow them, and write what they say, to the end.
    fn go(
        &self,
        scene: &Scene,
        folder: RunFolder,
        reserve: Reserve,
        pictures: Box<dyn Draw>,
        resumed: Option<&Checkpoint>,
    ) -> Result<Outcome, Error> {
        let path = &folder.path().to_path_buf();
        let disk = Disk::new(self.patience);
        let writer = Writer::start(folder, pictures, disk.clone());
        let mut used = Used::default();
        let mut verdict = self.follow(scene, (path, resumed), &writer, &mut used);
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
        if matches!(code, exit_code::NOT_FINITE | exit_code::NOT_CONVERGED) {
            self.record_failed_step(scene, &folder);
        }
        let ending = Ending {
            code,
            why,
            wall: folder.wall(),
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
            way_on: way_on(&folder, &ending),
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

    /// Record the step that ended the run, where the state before it is kept.
    fn record_failed_step(&self, scene: &Scene, folder: &RunFolder) {
        let (place, steps) = (folder.path(), folder.summary().steps);
        let Some(step) = folder.kept().0.filter(|step| *step == steps) else {
            return;
        };
        let name = failed_step::FILE;
        self.say(&format!("the step that failed is recorded in {name}"));
        let checkpoint = checkpoint::folder(place, step);
        let places = (place, checkpoint.as_path());
        let most = Duration::from_secs_f64(60.0 + folder.wall());
        match failed_step::record(scene, places, most, &self.interrupts) {
            Ok(true) => {}
            Ok(false) => self.say("it was not: it took too long, or was interrupted"),
            Err(error) => self.say(&format!("it was not: {error}")),
        }
    }

    /// Start the processes, follow them, leave nothing behind.
    fn follow(
        &self,
        scene: &Scene,
        (path, resumed): (&Path, Option<&Checkpoint>),
        writer: &Writer,
        used: &mut Used,
    ) -> Result<Verdict, Error> {
        let runspace = RunSpace::create()?;
        let monitor = MonitorReceiver::create(&runspace)?;
        let from = resumed.map_or(From::Start, |checkpoint| {
            From::Checkpoint(&checkpoint.folder)
        });
        let processes = launch::launch(scene, path, from, &runspace)?;
        let launched = Instant::now();
        let mut progress = match self.voice {
            Voice::Aloud => Progress::new(scene.coupler.end_time),
            Voice::Quiet => Progress::silent(scene.coupler.end_time),
        };
        if let Some(Checkpoint { step, time, .. }) = resumed {
            (progress.step, progress.time) = (*step, *time);
        }
        let mut watch = Watch {
            runspace: &runspace,
            monitor,
            processes,
            writer,
            interrupts: self.interrupts.clone(),
            asked: scene.output.fields.as_deref().unwrap_or_default(),
            progress,
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

/// The step from which the run in this folder can be resumed, where it has not reached its end.
pub fn unfinished(path: &Path) -> Option<u64> {
    let document = document::read(path).ok()?;
    let reached = document["exit"]["code"].as_i64() == Some(exit_code::OK.into());
    checkpoint::steps(path).pop().filter(|_| !reached)
}

/// Set an earlier run aside and write what is known before the run, and keep room for what will be known
/// after it; when that fails the earlier one is back.
fn prepare(path: &Path, scene: &Scene) -> Result<(RunFolder, Reserve), Error> {
    let previous = Previous::set_aside(path)?;
    // First of all, so that a folder that is left half made is known as one of ours.
    let mark = json!({ "versions": version::all() });
    let written = document::write(path, &mark).and_then(|()| {
        let folder = RunFolder::create(path, scene)?;
        let reserve = begin_document(path, scene, &folder)?;
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

/// `run.json` of a run that begins, and room for that of its end.
fn begin_document(path: &Path, scene: &Scene, folder: &RunFolder) -> Result<Reserve, Error> {
    let document = document::document(scene, folder, None);
    document::write(path, &document)?;
    Reserve::take(path, document::text(&document).len() + LAST_WORD)
}

/// How to go on with a run that ended early.
fn way_on(folder: &RunFolder, ending: &Ending) -> Option<String> {
    let (kept, _) = folder.kept();
    let step = kept.filter(|_| ending.code != exit_code::OK)?;
    let place = folder.path().display();
    let lost = folder.summary().steps.saturating_sub(step);
    let again = match lost {
        0 => String::new(),
        1 => "; 1 step after it is computed again".to_owned(),
        lost => format!("; {lost} steps after it are computed again"),
    };
    Some(format!(
        "to go on from step {step}: sillage resume {place}{again}"
    ))
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
