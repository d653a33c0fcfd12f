//! Signals: leave when told to, report a shared memory that is full, leave Ctrl-C to the orchestrator.

use std::os::fd::{BorrowedFd, IntoRawFd};
use std::sync::atomic::{AtomicI32, Ordering};

use rustix::event::{EventfdFlags, eventfd};

use crate::language::error::Error;

/// Descriptor that becomes readable when this process is told to end, and the signal that did it.
static TOLD: AtomicI32 = AtomicI32::new(-1);

static SIGNAL: AtomicI32 = AtomicI32::new(0);

/// A process that is told to end (SIGTERM, SIGHUP, SIGINT) leaves its seat first: the watching
/// thread does it, a handler may not.
pub(crate) fn leave_when_told() -> Result<(), Error> {
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
pub(crate) fn report_full_memory() {
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

/// End this process without running anything more.
pub(crate) fn exit_at_once(code: i32) -> ! {
    // SAFETY: _exit runs no code of this process, and may be called on any thread at any time.
    unsafe { libc::_exit(code) }
}

/// Ctrl-C reaches every process of a terminal; the orchestrator decides what it means.
pub(crate) fn leave_interrupts_to_orchestrator() {
    // SAFETY: sets a disposition, runs no code of ours.
    unsafe {
        libc::signal(libc::SIGINT, libc::SIG_IGN);
    }
}
