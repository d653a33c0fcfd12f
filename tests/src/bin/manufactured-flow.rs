//! Errors of the fluid engine on a manufactured flow through grains, as one JSON object: a point of
//! the study `vans-mms`.

use std::process::ExitCode;

use fluid_solver::config::{Nonlinear, TimeScheme};
use fluid_solver::equations::manufactured::suspension;
use fluid_solver::error::FluidError;
use fluid_solver::mesh::Rectangle;
use fluid_solver::step::FluidSolver;
use serde_json::{Value, json};
use tests::arguments::Arguments;

/// The errors are taken at this time \[s\], a third of a period of the porosity.
const END: f64 = 1.0 / 3.0;

const HELP: &str = "manufactured-flow cells=16 drag=1e3 scheme=steady|backward-euler|bdf2 steps=32
  cells   cells along a side of the unit square
  drag    mean β [kg/(m³ s)]
  scheme  time scheme
  steps   steps to t = 1/3 s (steady: one)
Prints the L2 errors of the interstitial velocity and of the pressure as JSON.";

fn main() -> ExitCode {
    tests::arguments::answer(HELP, errors)
}

fn errors(arguments: &Arguments) -> Result<Value, String> {
    let cells = arguments.number("cells", 16.0)? as usize;
    let drag = arguments.number("drag", 1e3)?;
    let scheme = match arguments.word("scheme", "steady") {
        "steady" => TimeScheme::Steady,
        "backward-euler" => TimeScheme::BackwardEuler,
        "bdf2" => TimeScheme::Bdf2,
        other => {
            return Err(format!(
                "scheme={other}: allowed: steady, backward-euler, bdf2"
            ));
        }
    };
    let steady = scheme == TimeScheme::Steady;
    let steps = if steady {
        1
    } else {
        arguments.number("steps", 32.0)? as usize
    };
    let run = || -> Result<(f64, f64), FluidError> {
        let exact = suspension(drag, steady);
        let mesh = Rectangle::new([0.0; 2], [1.0; 2], [cells; 2]).mesh()?;
        let mut config = exact.config();
        config.time_scheme = scheme;
        config.nonlinear = Nonlinear::Newton {
            tolerance: 1e-10,
            iterations_max: 20,
        };
        let start = exact.start(&mesh);
        let mut solver = FluidSolver::new(config, mesh)?;
        if !steady {
            solver.set_state(start);
        }
        for _ in 0..steps {
            exact.step(&mut solver, END / steps as f64)?;
        }
        Ok(exact.errors(&solver, END))
    };
    let (velocity, pressure) = run().map_err(|error| error.to_string())?;
    Ok(json!({ "velocity_error": velocity, "pressure_error": pressure, "steps": steps }))
}
