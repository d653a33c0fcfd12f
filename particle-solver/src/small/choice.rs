//! Whether a step is made in small steps, or with converged sweeps.

use space::{Dim, Dimension};

use crate::grains::{Grains, State};

/// How the contacts of a step are solved.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Solver {
    /// Many sub-steps with one relaxed sweep each.
    SmallSteps,
    /// Few sub-steps, sweeps until the laws hold to a tolerance.
    Converged,
}

/// Fewer contacts that act are solved to the end at no cost worth saving.
const CONTACTS: usize = 100;

/// Which of them serves a step from this state, where the scene does not say; `immersed`: drag or forces of a fluid act.
///
/// Small steps pay where grains press on each other for long: at least every second one that moves acts on another or
/// on a wall. They start from impulses that hold the load; a state that has none, at the start of a run, is solved to
/// the end first. In a fluid sweeps mostly are few, as drag is stiff, and beds were held against closed forms with
/// converged contacts: there the scene has to ask for small steps.
pub fn choose<const D: usize>(
    wished: Option<Solver>,
    grains: &Grains,
    state: &State<D>,
    immersed: bool,
) -> Solver
where
    Dim<D>: Dimension<D>,
{
    let acting = state.impulses.entries.len();
    let cold = state.impulses.dt == 0.0;
    if cold || wished == Some(Solver::Converged) {
        return Solver::Converged;
    }
    let moving = grains.fixed.iter().filter(|fixed| !**fixed).count();
    let pressed = acting >= CONTACTS && 2 * acting >= moving && !immersed;
    match wished {
        None if !pressed => Solver::Converged,
        _ => Solver::SmallSteps,
    }
}
