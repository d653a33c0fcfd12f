//! The coupler owns time: how long the next step is, and when a state is put out.

use protocol::configure::{AdaptiveStep, CouplerScene};

/// A step may grow by this factor over the last one.
const GROWTH_MAX: f64 = 1.2;

/// Chooses the coupling steps of a run.
#[derive(Debug, Clone)]
pub struct Clock {
    end_time: f64,
    coupling_step: f64,
    adaptive: Option<AdaptiveStep>,
    output_every: Option<f64>,
    next_output: f64,
}

impl Clock {
    /// The clock of a scene, at time 0.
    pub fn new(scene: &CouplerScene) -> Clock {
        Clock {
            end_time: scene.end_time,
            coupling_step: scene.coupling_step,
            adaptive: scene.adaptive,
            output_every: scene.output_every,
            next_output: scene.output_every.unwrap_or(f64::INFINITY),
        }
    }

    /// Is the run over at this time?
    pub fn is_over(&self, time: f64) -> bool {
        time >= self.end_time * (1.0 - 1e-12)
    }

    /// Share of the run that is done.
    pub fn progress(&self, time: f64) -> f64 {
        (time / self.end_time).min(1.0)
    }

    /// Length of the next step \[s\]: the nominal one, or the one in which the fastest grain crosses
    /// `courant` cells. The last step is cut to end on time.
    pub fn next_step(&mut self, time: f64, speed_max: f64, cell: f64) -> f64 {
        if let Some(adaptive) = self.adaptive {
            let wanted = if speed_max > 0.0 {
                adaptive.courant * cell / speed_max
            } else {
                f64::INFINITY
            };
            self.coupling_step = wanted
                .min(GROWTH_MAX * self.coupling_step)
                .clamp(adaptive.step_min, adaptive.step_max);
        }
        let remaining = self.end_time - time;
        if remaining <= self.coupling_step * (1.0 + 1e-9) {
            remaining
        } else {
            self.coupling_step
        }
    }

    /// Take a smaller step after one that failed; `None` when that is not allowed any more.
    pub fn retry(&mut self, failed: f64) -> Option<f64> {
        let adaptive = self.adaptive?;
        let smaller = 0.5 * failed;
        self.coupling_step = smaller;
        (smaller >= adaptive.step_min).then_some(smaller)
    }

    /// Smallest step allowed \[s\].
    pub fn step_min(&self) -> f64 {
        self.adaptive
            .map_or(self.coupling_step, |adaptive| adaptive.step_min)
    }

    /// Is a state due for output at this time? The last state always is.
    pub fn output_due(&mut self, time: f64) -> bool {
        if self.is_over(time) {
            return true;
        }
        let Some(every) = self.output_every else {
            return false;
        };
        let due = time >= self.next_output * (1.0 - 1e-9);
        while time >= self.next_output * (1.0 - 1e-9) {
            self.next_output += every;
        }
        due
    }
}
