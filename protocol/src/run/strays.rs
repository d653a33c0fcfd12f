//! What the processes of a run started and left behind: found by the name of the run in their
//! environment, and ended with it.
//!
//! Only runs with an orchestrator do so: they alone have a name that nobody else's environment has.

use std::fs;
use std::os::fd::OwnedFd;
use std::time::Duration;

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::process::{Pid, PidfdFlags, Signal, pidfd_open, pidfd_send_signal};

use super::names::{ENV_ORCHESTRATOR, ENV_RUN};

/// A process may have started another one while it was ended.
const ROUNDS: usize = 4;
/// How long the kernel may take to end them.
const AT_MOST: Duration = Duration::from_millis(500);

/// End all processes of this run that are none of `members`; how many there were.
pub(crate) fn end(run: &str, members: &[u32]) -> usize {
    let mut ended = 0;
    for _ in 0..ROUNDS {
        let strays = find(run, members);
        if strays.is_empty() {
            break;
        }
        for stray in &strays {
            ended += usize::from(pidfd_send_signal(stray, Signal::KILL).is_ok());
        }
        strays.iter().for_each(wait);
    }
    ended
}

/// Is this process stopped by a signal? State T of /proc/PID/stat.
pub(crate) fn is_stopped(process: u32) -> bool {
    let stat = fs::read_to_string(format!("/proc/{process}/stat")).unwrap_or_default();
    stat.rsplit_once(") ")
        .is_some_and(|(_, rest)| rest.starts_with('T'))
}

fn find(run: &str, members: &[u32]) -> Vec<OwnedFd> {
    let entries = fs::read_dir("/proc").into_iter().flatten().flatten();
    let pids = entries.filter_map(|entry| entry.file_name().to_str()?.parse::<u32>().ok());
    let own = std::process::id();
    let others = pids.filter(|pid| *pid != own && !members.contains(pid));
    others.filter_map(|pid| of_run(pid, run)).collect()
}

/// A handle of this process if it belongs to the run: held before the look, so that it is the one seen.
fn of_run(pid: u32, run: &str) -> Option<OwnedFd> {
    belongs(pid, run)?;
    let handle = Pid::from_raw(i32::try_from(pid).ok()?)?;
    let handle = pidfd_open(handle, PidfdFlags::empty()).ok()?;
    belongs(pid, run)?;
    Some(handle)
}

/// Does its environment name the run, and an orchestrator?
fn belongs(pid: u32, run: &str) -> Option<()> {
    let environment = fs::read(format!("/proc/{pid}/environ")).ok()?;
    let mut variables = environment.split(|&byte| byte == 0);
    let of_run = format!("{ENV_RUN}={run}");
    let named = variables.clone().any(|this| this == of_run.as_bytes());
    let orchestrated = format!("{ENV_ORCHESTRATOR}=");
    let child = variables.any(|this| this.starts_with(orchestrated.as_bytes()));
    (named && child).then_some(())
}

fn wait(stray: &OwnedFd) {
    let timeout = Timespec::try_from(AT_MOST).ok();
    let _ = poll(&mut [PollFd::new(stray, PollFlags::IN)], timeout.as_ref());
}
