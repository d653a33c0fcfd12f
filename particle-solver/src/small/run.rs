//! From an accepted state to a candidate in small steps.

use space::{Dim, Dimension, Vector};

use crate::contact::impulses::Pair;
use crate::contact::loads::Loads;
use crate::contact::residual::force_scale;
use crate::error::Error;
use crate::grains::State;
use crate::search::neighbours::Neighbours;
use crate::small::count::{LEAST, SINKING, load};
use crate::small::near::{Found, find, relative_speed};
use crate::small::stretch::Stretch;
use crate::step::candidate::{ActiveContact, Candidate};
use crate::step::correct::{correct, gap_after, smaller_radius};
use crate::step::motion::Motion;
use crate::step::request::Request;
use crate::step::sub_step::Stage;

/// Overlap with which a step is not accepted, of the smaller radius.
const OVERLAP_MAX: f64 = 0.05;
/// Sweeps of the one position pass of a step.
const SWEEPS: usize = 4;

/// A step in small steps from `start`; `loads.dt` is the whole of it.
///
/// An overlap above its limit at the end of the step has it made again in twice as many sub-steps; more of them than
/// `sub_steps_max` are an error.
pub fn advance<const D: usize>(
    stage: &Stage<'_, D>,
    start: &State<D>,
    neighbours: &mut Neighbours<D>,
    (request, loads): (&Request, &Loads<'_, D>),
    sub_steps_max: u32,
) -> Result<Candidate<D>, Error>
where
    Dim<D>: Dimension<D>,
{
    let mut asked = (request.sub_steps > 0).then_some(request.sub_steps);
    loop {
        let mut step = SmallSteps::new(stage, loads, start, sub_steps_max);
        step.run(neighbours, asked)?;
        if step.overlap <= step.overlap_max {
            step.motion.state.check_finite()?;
            return Ok(step.finish(request));
        }
        let made = step.motion.report.sub_steps;
        if 2 * made > sub_steps_max || step.overlap.is_nan() {
            return Err(Error::Overlap {
                overlap: step.overlap,
                limit: step.overlap_max,
                sub_steps: made,
                sub_steps_max,
            });
        }
        asked = Some(2 * made);
    }
}

/// A step that is being made.
struct SmallSteps<'a, const D: usize>
where
    Dim<D>: Dimension<D>,
{
    stage: &'a Stage<'a, D>,
    /// Of the whole step.
    loads: &'a Loads<'a, D>,
    motion: Motion<'a, D>,
    /// Contacts that acted, sorted by key, with their mean forces.
    acted: Vec<ActiveContact<D>>,
    /// Largest at the end, of the smaller radius.
    overlap: f64,
    /// Largest allowed: no more than at the start where there were larger ones.
    overlap_max: f64,
    sub_steps_max: u32,
}

impl<'a, const D: usize> SmallSteps<'a, D>
where
    Dim<D>: Dimension<D>,
{
    fn new(
        stage: &'a Stage<'a, D>,
        loads: &'a Loads<'a, D>,
        start: &State<D>,
        sub_steps_max: u32,
    ) -> SmallSteps<'a, D> {
        SmallSteps {
            stage,
            loads,
            motion: Motion::new(stage, start.clone()),
            acted: Vec::new(),
            overlap: 0.0,
            overlap_max: OVERLAP_MAX,
            sub_steps_max,
        }
    }

    /// All sub-steps, as many as asked or as load and motion need.
    fn run(&mut self, neighbours: &mut Neighbours<D>, asked: Option<u32>) -> Result<(), Error> {
        let dt = self.loads.dt;
        let parts = self.parts();
        let mut found = self.find(neighbours, dt / f64::from(parts))?;
        self.overlap_max = self.overlap_max.max(1.2 * found.overlap);
        let count = self.count(found.needed * f64::from(parts), asked)?;
        let sub_step = Loads {
            dt: dt / f64::from(count),
            ..*self.loads
        };
        let mut left = count;
        loop {
            let most = left.min((count / parts).max(1));
            let mut stretch = self.stretch(&sub_step, &found);
            let (made, strays) = stretch.run(most);
            left -= made;
            self.take(&stretch);
            if left == 0 && !strays {
                self.move_apart(&stretch);
                return Ok(());
            }
            let next = left.min((count / parts).max(1));
            found = self.find(neighbours, sub_step.dt * f64::from(next))?;
            if left == 0 {
                let end = self.stretch(&sub_step, &found);
                self.move_apart(&end);
                return Ok(());
            }
        }
    }

    /// Parts of the step in which grains move by no more than a radius; candidates are looked for in each.
    fn parts(&self) -> u32 {
        let grains = self.stage.grains;
        let expected = self.expected(self.loads.dt);
        let path = relative_speed(grains, &expected) * self.loads.dt;
        let mean = grains.radius.iter().sum::<f64>() / grains.count().max(1) as f64;
        (path / mean)
            .ceil()
            .clamp(1.0, f64::from(self.sub_steps_max)) as u32
    }

    /// Velocities after this time without contacts \[m/s\].
    fn expected(&self, time: f64) -> Vec<Vector<D>> {
        let loads = Loads {
            dt: time,
            ..*self.loads
        };
        loads.free_velocity(self.stage.grains, &self.motion.state.velocity)
    }

    fn find(&self, neighbours: &mut Neighbours<D>, time: f64) -> Result<Found<D>, Error> {
        let place = self.stage.place(&self.motion.state.position);
        find(neighbours, &place, self.expected(time), time)
    }

    fn stretch<'b>(&self, loads: &Loads<'_, D>, found: &'b Found<D>) -> Stretch<'b, D>
    where
        'a: 'b,
    {
        Stretch::new(self.stage, &self.motion.state, loads, found)
    }

    /// How many sub-steps; an error above the limit.
    fn count(&mut self, by_motion: f64, asked: Option<u32>) -> Result<u32, Error> {
        let dt = self.loads.dt;
        let load = load(
            &self.motion.state.impulses,
            self.stage.grains,
            self.loads.drag,
        );
        let by_load = dt * (load / SINKING).sqrt();
        let needed = by_load.max(by_motion).max(f64::from(LEAST)).ceil();
        let count = asked.unwrap_or(needed as u32);
        if count > self.sub_steps_max {
            return Err(Error::SmallSteps {
                by_load,
                by_motion,
                dt,
                sub_steps_max: self.sub_steps_max,
            });
        }
        self.motion.report.sub_steps = count;
        self.motion.report.sweeps += count as usize;
        self.motion.report.sinking = Some(load * (dt / f64::from(count)).powi(2));
        Ok(count)
    }

    /// Take over what a stretch made of the state.
    fn take(&mut self, stretch: &Stretch<'_, D>) {
        let motion = &mut self.motion;
        motion.report.candidates = motion.report.candidates.max(stretch.candidates());
        motion.report.attempts += 1;
        stretch.store(&mut motion.state, &mut motion.displacement);
        self.acted = merged(
            std::mem::take(&mut self.acted),
            stretch.acted(self.loads.dt),
        );
    }

    /// The one position pass of the step; notes the overlaps before and after it.
    fn move_apart(&mut self, stretch: &Stretch<'_, D>) {
        let (grains, motion) = (self.stage.grains, &mut self.motion);
        let pairs = stretch.pairs();
        let largest = |gap: &dyn Fn(&Pair<D>) -> f64| {
            let overlaps = pairs.iter();
            let overlaps = overlaps.map(|pair| -gap(pair) / smaller_radius(grains, pair));
            overlaps.fold(0.0, f64::max)
        };
        self.overlap = largest(&|pair| pair.gap);
        let mut moved = vec![Vector::zeros(); grains.count()];
        correct(grains, &pairs, &mut moved, SWEEPS);
        motion.report.penetration_max = largest(&|pair| gap_after(grains, pair, &moved));
        for (grain, moved) in moved.iter().enumerate() {
            motion.state.position[grain] += moved;
            motion.displacement[grain] += moved;
        }
    }

    /// Who touches and with what force, and the candidate.
    fn finish(mut self, request: &Request) -> Candidate<D> {
        let (grains, loads) = (self.stage.grains, self.loads);
        let velocity = &self.motion.state.velocity;
        let force = |grain: usize| force_scale(grains, loads, velocity, grain);
        let forces: Vec<f64> = (0..grains.count()).map(force).collect();
        let scale = |grain: usize| match grains.fixed.get(grain) {
            Some(false) => forces[grain],
            _ => f64::INFINITY,
        };
        for active in &self.acted {
            let key = active.pair.key;
            let (first, second) = (key.first as usize, key.second as usize);
            // below the tolerance a force is noise and holds nothing
            if active.force.normal > self.stage.goal.wished * scale(first).min(scale(second)) {
                self.motion.touched.join(first, second, &grains.fixed);
                self.motion.report.contacts += 1;
            }
        }
        self.motion.active = self.acted;
        self.motion.finish(request)
    }
}

/// Both of two lists sorted by key; forces of the same contact are added, the later geometry holds.
fn merged<const D: usize>(
    earlier: Vec<ActiveContact<D>>,
    later: Vec<ActiveContact<D>>,
) -> Vec<ActiveContact<D>>
where
    Dim<D>: Dimension<D>,
{
    let mut earlier = earlier.into_iter().peekable();
    let mut merged = Vec::with_capacity(later.len());
    for mut own in later {
        while let Some(before) = earlier.next_if(|before| before.pair.key < own.pair.key) {
            merged.push(before);
        }
        if let Some(before) = earlier.next_if(|before| before.pair.key == own.pair.key) {
            own.force = own.force.plus(&before.force);
            own.push += before.push;
        }
        merged.push(own);
    }
    merged.extend(earlier);
    merged
}
