//! Steps and times of output must go together.

use crate::check::Checker;
use crate::keys::SceneFile;

/// States written, each with its line in a list that is renewed with each.
const STATES_MAX: f64 = 1e5;
/// Smallest step, of the whole time: round-off of sums of a 64th of it stays small.
const RESOLVED: f64 = 1e-12;

impl Checker<'_> {
    /// States lie on steps, so none can be nearer to another than the smallest step.
    pub(crate) fn output_is_resolved<const D: usize>(&mut self, scene: &SceneFile<D>, every: f64) {
        let adaptive = scene.coupling.as_ref().and_then(|c| c.adaptive);
        let (key, step) = match adaptive {
            Some(adaptive) => ("coupling.adaptive.step_min", adaptive.step_min),
            None => ("run.coupling_step", scene.run.coupling_step),
        };
        if every > 0.0 && every < step * (1.0 - 1e-9) {
            self.refuse(
                "output.every",
                format!(
                    "must be at least {key} = {step:e} s, the smallest step: write states less often, \
                     or take smaller steps"
                ),
            );
        }
        let states = scene.run.end_time / every;
        if every > 0.0 && states > STATES_MAX {
            self.refuse(
                "output.every",
                format!("would write {states:.1e} states, at most {STATES_MAX:e}"),
            );
        }
    }

    /// Sums of steps must tell the end of a step from its start.
    pub(crate) fn steps_are_resolved<const D: usize>(&mut self, scene: &SceneFile<D>) {
        let end = scene.run.end_time;
        let adaptive = scene.coupling.as_ref().and_then(|c| c.adaptive);
        let steps = [
            ("run.coupling_step", Some(scene.run.coupling_step)),
            ("run.step_min", scene.run.step_min),
            ("coupling.adaptive.step_min", adaptive.map(|a| a.step_min)),
        ];
        for (key, step) in steps {
            if step.is_some_and(|step| step > 0.0 && step < RESOLVED * end) {
                self.refuse(
                    key,
                    format!("must be at least {RESOLVED:e} of run.end_time = {end:e} s: times are known no better"),
                );
            }
        }
    }
}
