//! What every process of a run does first and last: join the run, log to stderr, watch the
//! partners, report a full shared memory, end with the exit code of its error.

use std::io::{IsTerminal, stderr};
use std::process::ExitCode;

use tracing_subscriber::filter::Targets;
use tracing_subscriber::fmt::MakeWriter;
use tracing_subscriber::layer::SubscriberExt;
use tracing_subscriber::util::SubscriberInitExt;

use super::open_files::require as require_open_files;
use super::signals::{self, leave_interrupts_to_orchestrator, leave_when_told};
use crate::language::error::Error;
use crate::run::liveness::OnLoss;
use crate::run::place::SMALLEST;
use crate::run::runspace::RunSpace;

pub use super::open_files::{OPEN_FILES_MIN, open_files};

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
    require_open_files()?;
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

/// A page of shared memory that does not fit kills (SIGBUS): from now on with a line that says so, the
/// remedy, and exit code 4.
pub fn report_full_memory() {
    signals::report_full_memory();
}

/// CPU time of this process so far \[s\].
pub fn cpu_seconds() -> f64 {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
}

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
    log_through(stderr, "info,iceoryx2_bb_loggers=error");
}

/// The same, where every line is written to what `writer` makes, and `default` is logged when
/// `SILLAGE_LOG` does not say: levels of targets, as in "info,coupler=debug".
pub fn log_through<W>(writer: W, default: &str)
where
    W: for<'line> MakeWriter<'line> + Send + Sync + 'static,
{
    let asked = std::env::var(ENV_LOG).ok();
    let asked = asked.and_then(|words| words.parse::<Targets>().ok());
    let targets = asked.or_else(|| default.parse().ok()).unwrap_or_default();
    let lines = tracing_subscriber::fmt::layer()
        .with_writer(writer)
        .with_ansi(stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none())
        // A reader of stderr that is gone must not take the process with it.
        .log_internal_errors(false);
    let registry = tracing_subscriber::registry().with(targets);
    let json = std::env::var(ENV_LOG_FORMAT).is_ok_and(|format| format == "json");
    let _ = if json {
        registry.with(lines.json()).try_init()
    } else {
        registry.with(lines).try_init()
    };
}

/// Environment variable that keeps an engine from leaving anything out when it is `0`.
pub const LEAVE_OUT: &str = "SILLAGE_LEAVE_OUT";

/// May this process leave out what its own bounds allow?
pub fn may_leave_out() -> bool {
    std::env::var(LEAVE_OUT).map_or(true, |value| value != "0")
}
