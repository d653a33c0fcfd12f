//! What every process of a run does first and last: join the run, log to stderr, watch the
//! partners, report a full shared memory, end with the exit code of its error.

use std::io::{IsTerminal, stderr};
use std::os::fd::{BorrowedFd, IntoRawFd};
use std::process::ExitCode;
use std::sync::atomic::{AtomicI32, Ordering};

use rustix::event::{EventfdFlags, eventfd};
use tracing_subscriber::EnvFilter;

use crate::error::Error;
use crate::liveness::OnLoss;
use crate::runspace::RunSpace;

/// Environment: log filter (`info`, `debug`, `fluid_solver=trace`, …).
pub const ENV_LOG: &str = "SILLAGE_LOG";
/// Environment: `json` for a JSON document a line.
pub const ENV_LOG_FORMAT: &str = "SILLAGE_LOG_FORMAT";

/// Enter the run named by the environment and take `seat` ("coupler", "fluid", "particles"): log
/// to stderr, report a full shared memory, watch the partners. When a partner is lost and this
/// process does not notice within half a second, it is ended with exit code 5.
pub fn enter(seat: &str) -> Result<RunSpace, Error> {
    log_to_stderr();
    report_full_memory();
    let runspace = RunSpace::from_environment()?;
    runspace.preflight(SMALLEST)?;
    if let Some(pid) = runspace.orchestrator() {
        if !runspace.has_orchestrator() {
            let awaited = format!("process {pid} in its seat");
            return Err(Error::PartnerLost {
                who: "orchestrator".to_owned(),
                step: 0,
                awaited,
            });
        }
        leave_interrupts_to_orchestrator();
    }
    leave_when_told()?;
    runspace.take_seat(seat)?;
    runspace.watch(OnLoss::Exit)?;
    Ok(runspace)
}

/// CPU time of this process so far \[s\].
pub fn cpu_seconds() -> f64 {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
}

/// Shared memory that every process needs at least, for its messages \[bytes\].
const SMALLEST: u64 = 4 << 20;

/// `main` of a process of a run: enter, do `work`, log its error, leave, return the exit code.
pub fn run(seat: &str, work: impl FnOnce(&RunSpace) -> Result<(), Error>) -> ExitCode {
    ExitCode::from(u8::try_from(exit_code(seat, work)).unwrap_or(1))
}

/// The same, with the exit code as a number.
pub fn exit_code(seat: &str, work: impl FnOnce(&RunSpace) -> Result<(), Error>) -> i32 {
    match enter(seat).and_then(|runspace| work(&runspace)) {
        Ok(()) => 0,
        Err(error) => {
            tracing::error!("{seat}: {error}");
            error.exit_code()
        }
    }
}

/// Log to stderr as `SILLAGE_LOG` and `SILLAGE_LOG_FORMAT` ask; without effect when called again.
pub fn log_to_stderr() {
    // The transport's own records are about its files, not about the run.
    let default = "info,iceoryx2_bb_loggers=error";
    let filter = EnvFilter::try_from_env(ENV_LOG).unwrap_or_else(|_| EnvFilter::new(default));
    let builder = tracing_subscriber::fmt()
        .with_env_filter(filter)
        .with_writer(stderr)
        .with_ansi(stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none())
        // A reader of stderr that is gone must not take the process with it.
        .log_internal_errors(false);
    let json = std::env::var(ENV_LOG_FORMAT).is_ok_and(|format| format == "json");
    let _ = if json {
        builder.json().try_init()
    } else {
        builder.try_init()
    };
}

/// Ctrl-C reaches every process of a terminal; the orchestrator decides what it means.
fn leave_interrupts_to_orchestrator() {
    // SAFETY: sets a disposition, runs no code of ours.
    unsafe {
        libc::signal(libc::SIGINT, libc::SIG_IGN);
    }
}

/// Descriptor that becomes readable when this process is told to end, and the signal that did it.
static TOLD: AtomicI32 = AtomicI32::new(-1);
static SIGNAL: AtomicI32 = AtomicI32::new(0);

/// A process that is told to end (SIGTERM, SIGHUP, SIGINT) leaves its seat first: the watching
/// thread does it, a handler may not.
fn leave_when_told() -> Result<(), Error> {
    if TOLD.load(Ordering::Acquire) >= 0 {
        return Ok(());
    }
    let flags = EventfdFlags::NONBLOCK | EventfdFlags::CLOEXEC;
    let told = eventfd(0, flags).map_err(|e| Error::memory("event of signals", e))?;
    TOLD.store(told.into_raw_fd(), Ordering::Release);
    for signal in [libc::SIGTERM, libc::SIGHUP, libc::SIGINT] {
        // SAFETY: the handler only stores and writes eight bytes; an ignored signal stays ignored.
        unsafe {
            if libc::signal(signal, note as *const () as usize) == libc::SIG_IGN {
                libc::signal(signal, libc::SIG_IGN);
            }
        }
    }
    Ok(())
}

extern "C" fn note(signal: libc::c_int) {
    SIGNAL.store(signal, Ordering::Release);
    let one = 1_u64;
    // SAFETY: write is async-signal-safe; the descriptor is never closed.
    unsafe {
        libc::write(
            TOLD.load(Ordering::Acquire),
            (&raw const one).cast(),
            size_of::<u64>(),
        );
    }
}

/// Becomes readable when this process is told to end; `None` in a process that did not `enter`.
pub(crate) fn told() -> Option<BorrowedFd<'static>> {
    let told = TOLD.load(Ordering::Acquire);
    // SAFETY: the descriptor is never closed.
    (told >= 0).then(|| unsafe { BorrowedFd::borrow_raw(told) })
}

/// The exit code of the signal that told this process to end.
pub(crate) fn told_code() -> i32 {
    128 + SIGNAL.load(Ordering::Acquire)
}

/// A page of shared memory that does not fit kills with SIGBUS: say so, with the remedy.
fn report_full_memory() {
    extern "C" fn report(_signal: libc::c_int) {
        const TEXT: &[u8] = b"error: shared memory is full (/dev/shm); enlarge it (container: --shm-size=1g) or free it (sillage doctor)\n";
        // SAFETY: write and _exit are async-signal-safe.
        unsafe {
            libc::write(libc::STDERR_FILENO, TEXT.as_ptr().cast(), TEXT.len());
            libc::_exit(4);
        }
    }
    // SAFETY: the handler only calls async-signal-safe functions and does not return.
    unsafe {
        let mut action: libc::sigaction = std::mem::zeroed();
        action.sa_sigaction = report as extern "C" fn(libc::c_int) as usize;
        libc::sigemptyset(&mut action.sa_mask);
        libc::sigaction(libc::SIGBUS, &action, std::ptr::null_mut());
    }
}

/// Environment variable that keeps an engine from leaving anything out when it is `0`.
pub const LEAVE_OUT: &str = "SILLAGE_LEAVE_OUT";

/// May this process leave out what its own bounds allow?
pub fn may_leave_out() -> bool {
    std::env::var(LEAVE_OUT).map_or(true, |value| value != "0")
}
