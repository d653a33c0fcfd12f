//! The handle: name, capabilities, what the engine reports and why it fails; the last error.

use std::cell::RefCell;
use std::ffi::{CStr, CString, c_char};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Mutex, MutexGuard, PoisonError};

use protocol::message::{Advance, Capability, Diagnostic, Failure, FailureKind};

use crate::constants::{
    SILLAGE_ABI_VERSION, SILLAGE_ADAPTS, SILLAGE_AFFINE_RESPONSE, SILLAGE_CHECKPOINT,
    SILLAGE_CONTACT_STATE, SILLAGE_FAILURE_ENGINE, SILLAGE_FAILURE_NOT_CONVERGED,
    SILLAGE_FAILURE_NOT_FINITE, SILLAGE_FAILURE_SCENE, SILLAGE_IMPLICIT_DRAG,
    SILLAGE_REMOVES_GRAINS, SILLAGE_SPIN,
};

/// Returned when something went wrong; why is in the last error.
pub(crate) const WRONG: i32 = -1;

/// An engine: made by sillage_engine_new(), freed by sillage_engine_free().
pub struct Engine {
    identity: (&'static str, &'static str),
    state: Mutex<State>,
}

#[derive(Default)]
struct State {
    capabilities: Vec<Capability>,
    diagnostics: Vec<Diagnostic>,
    failure: Option<Failure>,
    running: bool,
}

/// What is asked of one advance().
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct Request {
    /// Step, from 1.
    pub step: u64,
    /// Pass within the step, from 0; a new pass throws the previous candidate away.
    pub pass: u32,
    /// Particles: number of sub-steps to use; 0: the engine chooses.
    pub sub_steps: u32,
    /// Time at the start of the step (s).
    pub time: f64,
    /// Length of the step (s).
    pub dt: f64,
    /// Relative accuracy asked of an inexact solve (contact): of |g| dt.
    pub tolerance: f64,
    /// Number of nodes or grains.
    pub count: u64,
    /// Dimension of the space: a vector has as many numbers.
    pub dimension: u32,
}

impl Request {
    pub(crate) fn of(request: &Advance, count: usize, dimension: usize) -> Request {
        Request {
            count: count as u64,
            dimension: dimension as u32,
            step: request.step,
            pass: request.pass,
            sub_steps: request.sub_steps,
            time: request.time,
            dt: request.dt,
            tolerance: request.tolerance,
        }
    }
}

thread_local! {
    static LAST_ERROR: RefCell<CString> = RefCell::default();
}

pub(crate) fn set_last_error(why: &str) {
    let text = CString::new(why.replace('\0', "␀")).unwrap_or_default();
    LAST_ERROR.with(|last| last.replace(text));
}

/// Run an entry point: errors and panics become `otherwise` and the last error.
pub(crate) fn guarded<T>(otherwise: T, work: impl FnOnce() -> Result<T, String>) -> T {
    match catch_unwind(AssertUnwindSafe(work)) {
        Ok(Ok(value)) => value,
        Ok(Err(why)) => {
            set_last_error(&why);
            otherwise
        }
        Err(_) => {
            set_last_error("the library panicked; what it said is on stderr");
            otherwise
        }
    }
}

/// The text behind a pointer.
///
/// # Safety
///
/// `text` is null or ends with a zero byte.
pub(crate) unsafe fn text(text: *const c_char, what: &str) -> Result<String, String> {
    if text.is_null() {
        return Err(format!("{what} is a null pointer"));
    }
    // SAFETY: not null, and it ends with a zero byte as the caller promises.
    let text = unsafe { CStr::from_ptr(text) };
    text.to_str()
        .map(str::to_owned)
        .map_err(|_| format!("{what} is not UTF-8"))
}

/// The handle behind a pointer.
///
/// # Safety
///
/// `engine` is null or came from `sillage_engine_new` and was not freed.
pub(crate) unsafe fn handle<'a>(engine: *const Engine) -> Result<&'a Engine, String> {
    // SAFETY: as the caller promises; a handle is only ever used through shared references.
    unsafe { engine.as_ref() }.ok_or_else(|| "engine is a null pointer".to_owned())
}

impl Engine {
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(crate) fn identity(&self) -> (&'static str, &'static str) {
        self.identity
    }

    pub(crate) fn capabilities(&self) -> Vec<Capability> {
        self.state().capabilities.clone()
    }

    pub(crate) fn declares(&self, capability: Capability) -> bool {
        self.state().capabilities.contains(&capability)
    }

    /// One run at a time; `false` when there is one.
    pub(crate) fn begin_run(&self) -> bool {
        !std::mem::replace(&mut self.state().running, true)
    }

    pub(crate) fn end_run(&self) {
        self.state().running = false;
    }

    /// Call a function of the engine; what it reports and why it fails.
    pub(crate) fn call(
        &self,
        name: &str,
        function: impl FnOnce() -> i32,
    ) -> Result<Vec<Diagnostic>, Failure> {
        {
            let mut state = self.state();
            state.diagnostics.clear();
            state.failure = None;
        }
        let returned = function();
        let mut state = self.state();
        match (returned, state.failure.take()) {
            (0, None) => Ok(std::mem::take(&mut state.diagnostics)),
            (_, Some(failure)) => Err(failure),
            (code, None) => {
                let why = format!("{name} returned {code} and did not say why");
                Err(Failure::new(FailureKind::Engine, why))
            }
        }
    }
}

/// Version of the interface that the library has; an engine was built for SILLAGE_ABI_VERSION.
#[unsafe(no_mangle)]
pub extern "C" fn sillage_abi_version() -> u32 {
    SILLAGE_ABI_VERSION
}

/// Make an engine's handle. `name` and `version` are for the handshake: UTF-8, not empty, copied.
/// Returns NULL when they are not usable. Free it with sillage_engine_free().
///
/// # Safety
///
/// `name` and `version` are NULL or end with a zero byte.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sillage_engine_new(
    name: *const c_char,
    version: *const c_char,
) -> *mut Engine {
    guarded(std::ptr::null_mut(), || {
        // SAFETY: as the caller promises.
        let (name, version) = unsafe { (text(name, "name")?, text(version, "version")?) };
        if name.trim().is_empty() || version.trim().is_empty() {
            return Err("name and version must not be empty".to_owned());
        }
        // The loop keeps them for as long as the process: a few bytes for each handle are not
        // given back.
        let identity: (&'static str, &'static str) = (name.leak(), version.leak());
        Ok(Box::into_raw(Box::new(Engine {
            identity,
            state: Mutex::default(),
        })))
    })
}

/// Free a handle; NULL is allowed. Not while it runs.
///
/// # Safety
///
/// `engine` is NULL or came from sillage_engine_new(), is not freed yet, and does not run.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sillage_engine_free(engine: *mut Engine) {
    guarded((), || {
        if !engine.is_null() {
            // SAFETY: it came from `Box::into_raw` and is given back once.
            drop(unsafe { Box::from_raw(engine) });
        }
        Ok(())
    });
}

/// Declare what the engine can do, before it runs: one of SILLAGE_AFFINE_RESPONSE,
/// SILLAGE_IMPLICIT_DRAG, SILLAGE_CONTACT_STATE, SILLAGE_CHECKPOINT, SILLAGE_SPIN,
/// SILLAGE_REMOVES_GRAINS, SILLAGE_ADAPTS. Returns 0 or -1.
///
/// # Safety
///
/// `engine` is NULL or came from sillage_engine_new() and is not freed yet.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sillage_engine_declare(engine: *mut Engine, capability: u32) -> i32 {
    guarded(WRONG, || {
        // SAFETY: as the caller promises.
        let engine = unsafe { handle(engine)? };
        let capability = match capability {
            SILLAGE_AFFINE_RESPONSE => Capability::AffineResponse,
            SILLAGE_IMPLICIT_DRAG => Capability::ImplicitDrag,
            SILLAGE_CONTACT_STATE => Capability::ContactState,
            SILLAGE_CHECKPOINT => Capability::Checkpoint,
            SILLAGE_SPIN => Capability::Spin,
            SILLAGE_REMOVES_GRAINS => Capability::RemovesGrains,
            SILLAGE_ADAPTS => Capability::Adapts,
            other => return Err(format!("capability {other} is not known, 0 to 6 are")),
        };
        let mut state = engine.state();
        if !state.capabilities.contains(&capability) {
            state.capabilities.push(capability);
        }
        Ok(0)
    })
}

/// Say why a function of the engine fails, and return the result of this call from it. `kind` is one
/// of SILLAGE_FAILURE_...; `why` names the number, the bound and the place (UTF-8, copied). From any
/// thread; the first reason counts. Never returns 0.
///
/// # Safety
///
/// `engine` came from sillage_engine_new() and is not freed yet; `why` is NULL or ends with a zero
/// byte.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sillage_fail(engine: *mut Engine, kind: u32, why: *const c_char) -> i32 {
    guarded(WRONG, || {
        // SAFETY: as the caller promises.
        let (engine, why) = unsafe { (handle(engine)?, text(why, "why")) };
        let known = match kind {
            SILLAGE_FAILURE_SCENE => Some(FailureKind::Scene),
            SILLAGE_FAILURE_ENGINE => Some(FailureKind::Engine),
            SILLAGE_FAILURE_NOT_FINITE => Some(FailureKind::NotFinite),
            SILLAGE_FAILURE_NOT_CONVERGED => Some(FailureKind::NotConverged),
            _ => None,
        };
        let mut why = why.unwrap_or_else(|trouble| format!("(sillage_fail: {trouble})"));
        if known.is_none() {
            why += &format!(" (sillage_fail: kind {kind} is not 2, 4, 7 or 8)");
        }
        let failure = Failure::new(known.unwrap_or(FailureKind::Engine), why);
        engine.state().failure.get_or_insert(failure);
        Ok(i32::try_from(kind).unwrap_or(WRONG).max(1))
    })
}

/// Tell a number of this candidate, e.g. ("kinetic_energy", 1.2e-6), within advance(): finite, SI
/// units, for people. From any thread. Returns 0 or -1.
///
/// # Safety
///
/// `engine` came from sillage_engine_new() and is not freed yet; `name` is NULL or ends with a zero
/// byte.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sillage_diagnostic(
    engine: *mut Engine,
    name: *const c_char,
    value: f64,
) -> i32 {
    guarded(WRONG, || {
        // SAFETY: as the caller promises.
        let (engine, name) = unsafe { (handle(engine)?, text(name, "name")?) };
        if !value.is_finite() {
            return Err(format!("{name} is {value}, must be finite"));
        }
        engine.state().diagnostics.push(Diagnostic { name, value });
        Ok(0)
    })
}

/// Why the last call of this thread went wrong; "" when none did. Valid until the next call of this
/// thread that goes wrong; not to be freed.
#[unsafe(no_mangle)]
pub extern "C" fn sillage_last_error() -> *const c_char {
    LAST_ERROR.with(|last| last.borrow().as_ptr())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn last_error() -> String {
        // SAFETY: the pointer is this thread's last error, which ends with a zero byte.
        unsafe { text(sillage_last_error(), "last error") }.expect("UTF-8")
    }

    #[test]
    fn a_panic_becomes_an_error_of_this_thread() {
        assert_eq!(
            guarded(WRONG, || -> Result<i32, String> { panic!("on purpose") }),
            WRONG
        );
        assert!(last_error().contains("panicked"), "{}", last_error());
        std::thread::spawn(|| assert_eq!(last_error(), ""))
            .join()
            .expect("no error there");
        assert_eq!(guarded(WRONG, || Err("a \0 in it".to_owned())), WRONG);
        assert_eq!(last_error(), "a ␀ in it");
    }

    #[test]
    fn the_first_reason_of_a_failure_counts_and_silence_is_one() {
        // SAFETY: literals that end with a zero byte, a handle that is freed once.
        unsafe {
            let engine = sillage_engine_new(c"test".as_ptr(), c"1".as_ptr());
            let this = handle(engine).expect("a handle");
            let failure = this.call("advance", || {
                sillage_fail(engine, SILLAGE_FAILURE_NOT_CONVERGED, c"first".as_ptr());
                sillage_fail(engine, SILLAGE_FAILURE_ENGINE, c"second".as_ptr())
            });
            let expected = Failure::new(FailureKind::NotConverged, "first");
            assert_eq!(failure, Err(expected));
            // Said, and then returned 0 all the same.
            let failure = this.call("advance", || {
                sillage_fail(engine, SILLAGE_FAILURE_SCENE, c"said".as_ptr());
                0
            });
            assert_eq!(failure.expect_err("failed").why, "said");
            let silent = this.call("commit", || 3).expect_err("failed").why;
            assert_eq!(silent, "commit returned 3 and did not say why");
            assert_eq!(
                this.call("advance", || sillage_diagnostic(engine, c"x".as_ptr(), 2.0))
                    .map(|d| d.len()),
                Ok(1)
            );
            sillage_engine_free(engine);
        }
    }
}
