//! The link between coupler and orchestrator.

use std::time::Duration;

use crate::engine::MeshDescription;
use crate::error::Error;
use crate::field::Field;
use crate::messages::{Diagnostic, Hello, ToOrchestrator};
use crate::runspace::RunSpace;

fn not_yet<T>() -> Result<T, Error> {
    Err(Error::transport("protocol", "not connected in this build"))
}

/// The coupler's end.
pub struct MonitorSender;

impl MonitorSender {
    /// Connect to the orchestrator; `None` when this run has none.
    pub fn connect(_runspace: &RunSpace) -> Result<Option<MonitorSender>, Error> {
        not_yet()
    }
    /// Coupling begins: who takes part, the mesh and the grains' radii (empty: no grains).
    pub fn started(
        &mut self,
        _engines: &[Hello],
        _mesh: Option<&MeshDescription>,
        _grain_radius: &[f64],
    ) -> Result<(), Error> {
        not_yet()
    }
    /// One accepted step.
    pub fn step(&mut self, _values: Vec<Diagnostic>) -> Result<(), Error> {
        not_yet()
    }
    /// Fields of the accepted state; waits until the previous snapshot was taken over.
    pub fn snapshot(
        &mut self,
        _step: u64,
        _time: f64,
        _fields: &[(Field, &[f64])],
    ) -> Result<(), Error> {
        not_yet()
    }
    /// The run ended as asked.
    pub fn finished(&mut self, _totals: Vec<Diagnostic>) -> Result<(), Error> {
        not_yet()
    }
    /// The run ended early.
    pub fn stopped(&mut self, _code: i32, _why: &str) -> Result<(), Error> {
        not_yet()
    }
    /// Was a stop asked for?
    pub fn stop_requested(&mut self) -> bool {
        false
    }
}

/// A message of the coupler with its fields.
#[derive(Debug, Clone, PartialEq)]
pub struct Event {
    /// The message.
    pub message: ToOrchestrator,
    /// The fields that came with it.
    pub fields: Vec<(Field, Vec<f64>)>,
}

/// The orchestrator's end.
pub struct MonitorReceiver;

impl MonitorReceiver {
    /// Open the link; before the coupler is started.
    pub fn create(_runspace: &RunSpace) -> Result<MonitorReceiver, Error> {
        not_yet()
    }
    /// The next message, or `None` when there was none within `timeout`. Snapshots are
    /// acknowledged here, after their fields were copied.
    pub fn next(&mut self, _timeout: Duration) -> Result<Option<Event>, Error> {
        not_yet()
    }
    /// Ask the coupler to stop after the current step.
    pub fn stop(&mut self) -> Result<(), Error> {
        not_yet()
    }
}
