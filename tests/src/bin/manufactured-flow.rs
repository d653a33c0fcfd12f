//! Errors of the fluid engine on a manufactured flow through grains, as one JSON object: a point of
//! the study `vans-mms`.

use std::process::ExitCode;

use fluid_solver::config::{FluidConfig, Nonlinear, TimeScheme};
use fluid_solver::equations::manufactured::{Exact, suspension, suspension_in_space};
use fluid_solver::error::FluidError;
use fluid_solver::mesh::{Rectangle, Root};
use fluid_solver::refined::solver_on_cells;
use fluid_solver::step::FluidSolver;
use serde_json::{Value, json};
use space::{Dim, Dimension, Vector};
use tests::arguments::Arguments;

/// The errors are taken at this time \[s\], a third of a period of the porosity.
const END: f64 = 1.0 / 3.0;

const HELP: &str =
    "manufactured-flow dimension=2 cells=16 drag=1e3 scheme=steady|backward-euler|bdf2 steps=32
  dimension  2 or 3
  cells   cells along a side of the unit square or cube
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
    let found = match arguments.word("dimension", "2") {
        "2" => in_the_plane(drag, cells, scheme, steps),
        "3" => in_space(drag, cells, scheme, steps),
        other => return Err(format!("dimension={other}: allowed: 2, 3")),
    };
    let (velocity, pressure) = found.map_err(|error| error.to_string())?;
    Ok(json!({ "velocity_error": velocity, "pressure_error": pressure, "steps": steps }))
}

/// Errors of velocity and pressure.
type Errors = Result<(f64, f64), FluidError>;

fn in_the_plane(drag: f64, cells: usize, scheme: TimeScheme, steps: usize) -> Errors {
    let exact = suspension(drag, scheme == TimeScheme::Steady);
    let mesh = Rectangle::new([0.0; 2], [1.0; 2], [cells; 2]).mesh()?;
    advance(
        &exact,
        steps,
        FluidSolver::new(config(&exact, scheme), mesh)?,
    )
}

fn in_space(drag: f64, cells: usize, scheme: TimeScheme, steps: usize) -> Errors {
    let exact = suspension_in_space(drag, scheme == TimeScheme::Steady);
    let cube = Root {
        lower: Vector::zeros(),
        upper: Vector::repeat(1.0),
        cells: [cells; 3],
        periodic: [false; 3],
    };
    advance(
        &exact,
        steps,
        solver_on_cells(config(&exact, scheme), &cube)?,
    )
}

fn config<const D: usize, const N: usize>(exact: &Exact<D, N>, scheme: TimeScheme) -> FluidConfig<D>
where
    Dim<D>: Dimension<D>,
{
    let mut config = exact.config();
    config.time_scheme = scheme;
    config.nonlinear = Nonlinear::Newton {
        tolerance: 1e-10,
        iterations_max: 20,
    };
    config
}

fn advance<const D: usize, const N: usize>(
    exact: &Exact<D, N>,
    steps: usize,
    mut solver: FluidSolver<D, N>,
) -> Errors
where
    Dim<D>: Dimension<D>,
{
    if !exact.steady {
        solver.set_state(exact.start(solver.mesh()));
    }
    for _ in 0..steps {
        exact.step(&mut solver, END / steps as f64)?;
    }
    Ok(exact.errors(&solver, END))
}
