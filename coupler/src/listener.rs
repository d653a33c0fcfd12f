//! Who follows a run: the orchestrator over its link, or, without one, who reads standard output.

use std::io::{Write, stdout};

use protocol::field::Field;
use protocol::message::Diagnostic;
use protocol::monitor::MonitorSender;
use protocol::runspace::RunSpace;
use space::{Dim, Dimension, flat};

use crate::error::CouplerError;
use crate::seats::door::contact_numbers;
use crate::simulation::Simulation;

/// Hears of every step.
pub enum Listener {
    /// The orchestrator, and the epoch of the mesh that it knows.
    Orchestrator(Box<MonitorSender>, u64),
    /// One JSON object a step on standard output.
    Output,
}

impl Listener {
    /// Connect to the orchestrator of this run, if it has one.
    pub fn connect(runspace: &RunSpace) -> Result<Listener, CouplerError> {
        Ok(match MonitorSender::connect(runspace)? {
            Some(sender) => Listener::Orchestrator(Box::new(sender), 0),
            None => Listener::Output,
        })
    }

    /// Coupling begins, or goes on: who takes part, on what, with which grains from the start.
    pub fn started<const D: usize, const N: usize>(
        &mut self,
        simulation: &mut Simulation<D, N>,
        radius: &[f64],
    ) -> Result<(), CouplerError>
    where
        Dim<D>: Dimension<D>,
    {
        if let Listener::Orchestrator(sender, epoch) = self {
            *epoch = simulation.epoch();
            let hellos = simulation.hellos();
            let fluid = simulation.system.fluid();
            let mesh = fluid.map(|seat| &seat.description);
            sender.started(D, &hellos, mesh, radius)?;
        }
        Ok(())
    }

    /// The accepted state of this step is kept.
    pub fn checkpoint(&mut self, step: u64, time: f64) -> Result<(), CouplerError> {
        match self {
            Listener::Orchestrator(sender, _) => Ok(sender.checkpoint(step, time)?),
            Listener::Output => Ok(()),
        }
    }

    /// It cannot be kept.
    pub fn no_checkpoint(&mut self, why: &str) -> Result<(), CouplerError> {
        tracing::warn!("no checkpoint: {why}");
        match self {
            Listener::Orchestrator(sender, _) => Ok(sender.no_checkpoint(why)?),
            Listener::Output => Ok(()),
        }
    }

    /// One accepted step.
    pub fn step(&mut self, columns: Vec<Diagnostic>) -> Result<(), CouplerError> {
        match self {
            Listener::Orchestrator(sender, _) => Ok(sender.step(columns)?),
            Listener::Output => {
                let number = |column: Diagnostic| (column.name, column.value.into());
                let object = columns.into_iter().map(number).collect();
                // A reader that has seen enough is no reason to stop.
                let line = serde_json::Value::Object(object);
                if let Err(error) = writeln!(stdout().lock(), "{line}") {
                    tracing::debug!("a step could not be told: {error}");
                }
                Ok(())
            }
        }
    }

    /// The state as it is put out, with what is read only here.
    pub fn snapshot<const D: usize, const N: usize>(
        &mut self,
        simulation: &mut Simulation<D, N>,
    ) -> Result<(), CouplerError>
    where
        Dim<D>: Dimension<D>,
    {
        let Listener::Orchestrator(sender, epoch) = self else {
            return Ok(());
        };
        simulation.fetch_unread()?;
        if let Some(seat) = simulation
            .system
            .fluid()
            .filter(|seat| seat.epoch() != *epoch)
        {
            *epoch = seat.epoch();
            sender.mesh(&seat.description)?;
        }
        let leave = simulation.has_exits();
        let state = &simulation.state;
        let numbers = || state.grains.id.iter().map(|&id| id as f64).collect();
        let id: Option<Vec<f64>> = leave.then(numbers);
        let contact = contact_numbers(&state.grains.contact);
        let fixed: Vec<f64> = state
            .grains
            .fixed
            .iter()
            .map(|&fixed| fixed.into())
            .collect();
        let mut fields: Vec<(Field, &[f64])> = Vec::new();
        let (fluid, particles) = simulation.system.seats_mut();
        if let Some(seat) = fluid {
            let velocity = flat::numbers(&state.flow.velocity);
            fields.push((Field::InterstitialVelocity, velocity));
            fields.push((Field::Pressure, seat.pressure()?));
            fields.push((Field::Porosity, &state.porosity));
        }
        if particles.is_some() {
            let grains = &state.grains;
            fields.push((Field::GrainPosition, flat::numbers(&grains.position)));
            fields.push((Field::GrainVelocity, flat::numbers(&grains.velocity)));
            if !grains.spin.is_empty() {
                fields.push((Field::GrainSpin, &grains.spin));
            }
            fields.push((Field::GrainContact, &contact));
            fields.push((Field::GrainMass, &grains.mass));
            fields.push((Field::GrainFixed, &fixed));
            if let Some(id) = &id {
                fields.push((Field::GrainRadius, &grains.radius));
                fields.push((Field::GrainId, id));
            }
        }
        let moment = (state.step, state.time);
        Ok(sender.snapshot(moment, state.grains.count(), &fields)?)
    }

    /// The recording ended before the run.
    pub fn recording_ended(&mut self, why: &str) -> Result<(), CouplerError> {
        match self {
            Listener::Orchestrator(sender, _) => Ok(sender.recording_ended(why)?),
            Listener::Output => Ok(()),
        }
    }

    /// Was a stop asked for?
    pub fn stop_requested(&mut self) -> bool {
        match self {
            Listener::Orchestrator(sender, _) => sender.stop_requested(),
            Listener::Output => false,
        }
    }

    /// The run ended, early with an error; totals up to here.
    pub fn ended(
        &mut self,
        error: Option<&CouplerError>,
        totals: Vec<Diagnostic>,
    ) -> Result<(), CouplerError> {
        let Listener::Orchestrator(sender, _) = self else {
            return Ok(());
        };
        match error {
            None => Ok(sender.finished(totals)?),
            Some(error) => Ok(sender.stopped(error.exit_code(), &error.to_string(), totals)?),
        }
    }
}
