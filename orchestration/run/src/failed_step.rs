//! The step that ended a run, once more from the state before it, recorded: `replay` opens it.
//!
//! The same state takes the same step to the same end, so that nothing need be recorded while all goes well.

use std::path::Path;
use std::time::{Duration, Instant};

use protocol::monitor::MonitorReceiver;
use protocol::runspace::RunSpace;
use scene::keys::Record;
use scene::{Error, Scene};

use crate::begin::From;
use crate::interrupt::Interrupts;
use crate::launch;

/// The recording, in the folder of the run.
pub const FILE: &str = "failed-step.mcap";
/// How often children and interruptions are looked at.
const TICK: Duration = Duration::from_millis(50);

/// Record the step after the checkpoint in this folder; false where that was interrupted, or took longer than
/// `most`.
pub fn record(
    scene: &Scene,
    (folder, checkpoint): (&Path, &Path),
    most: Duration,
    interrupts: &Interrupts,
) -> Result<bool, Error> {
    let mut scene = scene.clone();
    scene.checkpoint.keep = 0;
    scene.record = Some(Record {
        file: FILE.to_owned(),
        ..Record::default()
    });
    let (begun, before) = (Instant::now(), interrupts.so_far());
    let runspace = RunSpace::create()?;
    let mut monitor = MonitorReceiver::create(&runspace)?;
    let from = From::CheckpointAnew(checkpoint);
    let mut processes = launch::launch(&scene, folder, from, &runspace)?;
    let mut connected = true;
    while processes.iter().any(|process| process.ended.is_none()) {
        // What it says was said before.
        match connected {
            true => connected = monitor.next(TICK).is_ok(),
            false => std::thread::sleep(TICK),
        }
        for process in &mut processes {
            process.poll();
            if process.ended.is_some() {
                let _ = runspace.mark_lost(&process.seat);
            }
        }
        if interrupts.so_far() > before || begun.elapsed() > most {
            launch::end(&mut processes);
            let _ = std::fs::remove_file(folder.join(FILE));
        }
    }
    drop(monitor);
    let _ = runspace.sweep();
    Ok(folder.join(FILE).is_file())
}
