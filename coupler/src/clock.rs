//! The coupler owns time: how long the next step is, and when a state is put out.
//!
//! ```text
//!   nominal    Δt = coupling_step, or adaptive: the fastest grain crosses `courant` cells, in bounds
//!   failed     Δt ← Δt/2 and the same step again, down to step_min (else coupling_step/64, adaptive: its own)
//!   accepted   Δt ← min(nominal, 2 Δt) after a failure, min(nominal, 1.2 Δt) when adaptive
//! ```
//!
//! Steps end where a state is put out, and where the run ends: the last two before such a time share what
//! is left, so that none is a sliver (the pressure of a step carries 1/Δt).
//!
//! What a step does depends on what was computed and on nothing else: the same scene takes the same
//! steps.

use protocol::scene::{AdaptiveStep, CouplerScene, is_over};
use serde::{Deserialize, Serialize};

/// An adaptive step may grow by this factor over the last one.
const GROWTH_MAX: f64 = 1.2;
/// A step that was halved may grow by this factor over the last one.
const RECOVERY: f64 = 2.0;
/// The last step before such a time may be longer by this part, rather than be followed by a very short one.
const LAST_STRETCH: f64 = 1e-3;
/// A time of output is met when it is missed by less than this part of it: by the round-off of sums.
const MET: f64 = 1e-9;
/// Sums of steps are off by less than this part of a step.
const ROUND_OFF: f64 = 1e-9;
/// A nominal step may be halved down to this part of it.
const SMALLEST_PART: f64 = 1.0 / 64.0;

/// What a clock remembers of the steps before.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Memory {
    coupling_step: f64,
    next_output: f64,
}

/// Chooses the coupling steps of a run.
#[derive(Debug, Clone)]
pub struct Clock {
    end_time: f64,
    nominal: f64,
    coupling_step: f64,
    step_min: Option<f64>,
    adaptive: Option<AdaptiveStep>,
    output_every: Option<f64>,
    next_output: f64,
}

/// The first multiple of `every` after a time \[s\] that has not met it.
fn output_after(time: f64, every: f64) -> f64 {
    ((time / every * (1.0 + MET)).floor() + 1.0) * every
}

impl Clock {
    /// The clock of a scene, at time 0.
    pub fn new(scene: &CouplerScene) -> Clock {
        Clock {
            end_time: scene.end_time,
            nominal: scene.coupling_step,
            coupling_step: scene.coupling_step,
            step_min: scene.step_min,
            adaptive: scene.adaptive,
            output_every: scene.output_every,
            next_output: scene.output_every.unwrap_or(f64::INFINITY),
        }
    }

    /// What is to be remembered of the steps so far.
    pub fn memory(&self) -> Memory {
        Memory {
            coupling_step: self.coupling_step,
            next_output: self.next_output,
        }
    }

    /// Go on from there.
    pub fn remember(&mut self, memory: Memory) {
        let Memory {
            coupling_step,
            next_output,
        } = memory;
        (self.coupling_step, self.next_output) = (coupling_step, next_output);
    }

    /// Is the run over at this time?
    pub fn is_over(&self, time: f64) -> bool {
        is_over(time, self.end_time)
    }

    /// Share of the run that is done.
    pub fn progress(&self, time: f64) -> f64 {
        (time / self.end_time).min(1.0)
    }

    /// Length of the next step \[s\]: the nominal one, or the one in which the fastest grain crosses
    /// `courant` cells; cut where a state is put out or the run ends.
    pub fn next_step(&mut self, time: f64, speed_max: f64, cell: f64) -> f64 {
        self.coupling_step = match self.adaptive {
            Some(adaptive) => {
                let wanted = if speed_max > 0.0 {
                    adaptive.courant * cell / speed_max
                } else {
                    f64::INFINITY
                };
                wanted
                    .min(GROWTH_MAX * self.coupling_step)
                    .clamp(adaptive.step_min, adaptive.step_max)
            }
            None => self.nominal.min(RECOVERY * self.coupling_step),
        };
        // States that are nearer to each other than steps can be are put out after every step.
        let every = self.output_every.filter(|&every| every >= self.step_min());
        let output = every.map_or(f64::INFINITY, |every| output_after(time, every));
        if output < self.end_time * (1.0 - MET) {
            self.step_towards(output - time, MET * output)
        } else {
            self.step_to_the_end(self.end_time - time)
        }
    }

    /// A step of those that must end at a time of output, `remaining` \[s\] from here; a step that misses it by
    /// less than `slack` \[s\] meets it, so that equal steps stay equal.
    fn step_towards(&self, remaining: f64, slack: f64) -> f64 {
        let step = self.coupling_step;
        if (remaining - step).abs() <= slack || remaining >= 2.0 * step - slack {
            step
        } else if remaining <= (1.0 + LAST_STRETCH) * step {
            remaining
        } else {
            0.5 * remaining
        }
    }

    /// A step of those that must end with the run, `remaining` \[s\] from here.
    fn step_to_the_end(&self, remaining: f64) -> f64 {
        let steps_left = remaining / self.coupling_step;
        if steps_left <= 1.0 + LAST_STRETCH {
            remaining
        } else if steps_left < 2.0 - ROUND_OFF {
            0.5 * remaining
        } else {
            self.coupling_step
        }
    }

    /// Take a smaller step after one that failed; `None` when that is not allowed any more.
    pub fn retry(&mut self, failed: f64) -> Option<f64> {
        let smaller = 0.5 * failed;
        if smaller < self.step_min() * (1.0 - 1e-9) {
            return None;
        }
        self.coupling_step = smaller;
        Some(smaller)
    }

    /// Smallest step that a failed one may be cut to \[s\].
    pub fn step_min(&self) -> f64 {
        let adaptive = self.adaptive.map(|adaptive| adaptive.step_min);
        let own = adaptive.unwrap_or(SMALLEST_PART * self.nominal);
        self.step_min.unwrap_or(own)
    }

    /// Is a state due for output at this time? The last state always is.
    pub fn output_due(&mut self, time: f64) -> bool {
        if self.is_over(time) {
            return true;
        }
        let Some(every) = self.output_every else {
            return false;
        };
        let due = time >= self.next_output * (1.0 - MET);
        if due {
            self.next_output = output_after(time, every);
        }
        due
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use protocol::scene::{DragLaw, Geometry, Limits, Scheme};

    fn clock(end_time: f64, coupling_step: f64, adaptive: Option<AdaptiveStep>) -> Clock {
        Clock::new(&CouplerScene {
            dimension: 2,
            end_time,
            coupling_step,
            step_min: None,
            adaptive,
            gravity: vec![0.0, -9.81],
            fluid: None,
            particles: None,
            grains_stay: false,
            grain_boundaries: None,
            grain_exits: Vec::new(),
            near_grains: None,
            indicator: None,
            grains_file: None,
            scheme: Scheme::Staggered,
            drag: DragLaw::Dallavalle,
            geometry: Geometry::Disk,
            reaction: true,
            output_every: None,
            limits: Limits {
                connect: 1.0,
                configure: 1.0,
                step: 1.0,
            },
        })
    }

    /// Steps of a run in which every step that starts in `stiff` fails unless it is below `bound`.
    fn steps(clock: &mut Clock, stiff: std::ops::Range<f64>, bound: f64) -> Vec<f64> {
        let (mut time, mut taken) = (0.0, Vec::new());
        while !clock.is_over(time) {
            let mut dt = clock.next_step(time, 0.0, f64::INFINITY);
            while stiff.contains(&time) && dt > bound {
                dt = clock.retry(dt).expect("above the smallest step");
            }
            time += dt;
            taken.push(dt);
        }
        taken
    }

    #[test]
    fn a_failed_step_is_halved_and_grows_back_by_two_to_the_nominal_step() {
        let taken = steps(&mut clock(1.0, 0.125, None), 0.125..0.25, 0.02);
        println!("{taken:?}");
        let nominal = 0.125;
        assert_eq!(taken[0], nominal);
        assert_eq!(taken[1], nominal / 8.0);
        assert!(taken.windows(2).all(|pair| pair[1] <= 2.0 * pair[0]));
        // the last two share what is left
        assert_eq!(taken.iter().filter(|&&dt| dt == nominal).count(), 5);
        assert_eq!(taken[taken.len() - 2..], [0.078125; 2]);
        assert_eq!(taken.iter().sum::<f64>(), 1.0);
        let again = steps(&mut clock(1.0, 0.125, None), 0.125..0.25, 0.02);
        assert_eq!(taken, again);
    }

    #[test]
    fn a_step_is_halved_six_times_and_no_further() {
        let mut clock = clock(1.0, 0.125, None);
        let mut dt = clock.next_step(0.0, 0.0, 1.0);
        let mut halvings = 0;
        while let Some(smaller) = clock.retry(dt) {
            assert_eq!(smaller, 0.5 * dt);
            dt = smaller;
            halvings += 1;
        }
        assert_eq!((halvings, dt), (6, 0.125 / 64.0));
        assert_eq!(clock.step_min(), dt);
    }

    #[test]
    fn an_adaptive_step_follows_the_courant_number_within_its_bounds() {
        let adaptive = AdaptiveStep {
            step_min: 0.01,
            step_max: 0.2,
            courant: 0.5,
        };
        let mut clock = clock(10.0, 0.1, Some(adaptive));
        // courant h / v = 0.05 s
        assert_eq!(clock.next_step(0.0, 10.0, 1.0), 0.05);
        // grows by 1.2 at most
        assert!((clock.next_step(0.05, 0.0, 1.0) - 0.06).abs() < 1e-15);
        assert_eq!(clock.next_step(0.11, 1e9, 1.0), 0.01);
        assert_eq!(clock.retry(0.01), None);
        assert_eq!(clock.retry(0.04), Some(0.02));
        assert!((clock.next_step(0.12, 0.0, 1.0) - 0.024).abs() < 1e-15);
    }

    #[test]
    fn no_step_is_a_sliver_when_the_end_is_not_a_multiple_of_the_step() {
        println!("| end time | steps | shortest | longest |");
        let nominal = 0.1;
        for end in [1.0, 1.0 + 1e-13, 1.0 + 1e-7, 1.001, 1.05, 1.0999, 0.03] {
            let taken = steps(&mut clock(end, nominal, None), 0.0..0.0, nominal);
            let shortest = taken.iter().copied().fold(f64::INFINITY, f64::min);
            let longest = taken.iter().copied().fold(0.0, f64::max);
            println!("| {end} | {} | {shortest} | {longest} |", taken.len());
            assert!(shortest >= 0.5 * nominal.min(end) && longest <= 1.002 * nominal);
            assert!((taken.iter().sum::<f64>() - end).abs() <= 1e-12);
        }
    }

    #[test]
    fn the_last_step_ends_on_time_and_states_are_due_once() {
        let mut clock = with_output(1.0, 0.3, None, 0.25);
        let (mut time, mut due) = (0.0, Vec::new());
        while !clock.is_over(time) {
            time += clock.next_step(time, 0.0, 1.0);
            due.push(clock.output_due(time));
        }
        assert_eq!(time, 1.0);
        assert_eq!(due, [true, true, true, true]);
        assert!(!clock.clone().output_due(0.1));
    }

    fn with_output(end: f64, step: f64, adaptive: Option<AdaptiveStep>, every: f64) -> Clock {
        Clock {
            output_every: Some(every),
            next_output: every,
            ..clock(end, step, adaptive)
        }
    }

    #[test]
    fn every_time_of_output_is_met_also_by_adaptive_steps_and_after_halvings() {
        let adaptive = AdaptiveStep {
            step_min: 1e-3,
            step_max: 0.2,
            courant: 0.5,
        };
        // steps, time step by time step, the times at which a state is due
        let run = |mut clock: Clock, speed: fn(f64) -> f64, fails: fn(f64) -> bool| {
            let (mut time, mut taken, mut due) = (0.0, Vec::new(), Vec::new());
            while !clock.is_over(time) {
                let mut dt = clock.next_step(time, speed(time), 1e-3);
                while fails(time) && dt > 2e-3 {
                    dt = clock.retry(dt).expect("above the smallest step");
                }
                time += dt;
                taken.push(dt);
                if clock.output_due(time) {
                    due.push(time);
                }
            }
            (taken, due)
        };
        let rising = |time: f64| 0.02 + time;
        let still = |_: f64| 0.0;
        let never = |_: f64| false;
        let some = |time: f64| (0.11..0.13).contains(&time);
        for (name, (taken, due)) in [
            (
                "adaptive",
                run(
                    with_output(0.5, 0.0149, Some(adaptive), 0.05),
                    rising,
                    never,
                ),
            ),
            (
                "fixed",
                run(with_output(0.5, 0.0149, None, 0.05), still, never),
            ),
            (
                "halved",
                run(with_output(0.5, 0.01, None, 0.05), still, some),
            ),
        ] {
            println!("{name}: {due:?}");
            assert_eq!(due.len(), 10);
            for (index, time) in due.iter().enumerate() {
                assert!((time - 0.05 * (index + 1) as f64).abs() < 1e-12);
            }
            let shortest = taken.iter().copied().fold(f64::INFINITY, f64::min);
            // half of the smallest, where two share what is left
            assert!(shortest >= 0.5e-3, "{shortest}");
        }
    }

    #[test]
    fn equal_steps_that_meet_the_times_of_output_stay_equal() {
        let (step, steps) = (5.5e-3, 4000);
        let mut clock = with_output(step * f64::from(steps), step, None, 10.0 * step);
        let (mut time, mut due) = (0.0, 0);
        for number in 0..steps {
            let dt = clock.next_step(time, 0.0, 1.0);
            assert!(dt == step || number + 2 >= steps, "step {number}: {dt}");
            time += dt;
            due += usize::from(clock.output_due(time));
        }
        assert!(clock.is_over(time));
        assert_eq!(due, 400);
    }

    #[test]
    fn an_interval_of_output_that_no_time_resolves_is_looked_at_once() {
        let mut clock = with_output(1.0, 0.1, None, 1e-300);
        assert!(clock.output_due(0.1));
        assert!(clock.output_due(0.2));
    }
}
