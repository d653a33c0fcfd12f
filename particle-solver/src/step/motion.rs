//! From an accepted state to a candidate: sub-step after sub-step.

use space::{Dim, Dimension, Vector};

use crate::contact::impulses::Impulses;
use crate::contact::loads::Loads;
use crate::error::Error;
use crate::grains::State;
use crate::search::neighbours::Neighbours;
use crate::step::candidate::{ActiveContact, Candidate, Report};
use crate::step::correct::{SWEEPS, correct, gap_after, smaller_radius};
use crate::step::request::Request;
use crate::step::sub_step::{Solved, Stage, impulses, solve_contacts};
use crate::step::touched::Touched;

/// What moves during an advance.
#[derive(Debug)]
pub struct Motion<'a, const D: usize>
where
    Dim<D>: Dimension<D>,
{
    stage: &'a Stage<'a, D>,
    /// Where the grains are now.
    pub state: State<D>,
    /// Since the start of the step \[m\].
    pub displacement: Vec<Vector<D>>,
    /// Who has touched.
    pub touched: Touched,
    /// Numbers so far.
    pub report: Report,
    first_impulses: Option<Impulses<D>>,
    /// Contacts that act.
    pub active: Vec<ActiveContact<D>>,
}

impl<'a, const D: usize> Motion<'a, D>
where
    Dim<D>: Dimension<D>,
{
    /// At the start of a step.
    pub fn new(stage: &'a Stage<'a, D>, state: State<D>) -> Motion<'a, D> {
        let grain_count = stage.grains.count();
        Motion {
            stage,
            state,
            displacement: vec![Vector::zeros(); grain_count],
            touched: Touched::new(grain_count),
            report: Report::default(),
            first_impulses: None,
            active: Vec::new(),
        }
    }

    /// All sub-steps, each under these loads.
    pub fn run(
        mut self,
        neighbours: &mut Neighbours<D>,
        request: &Request,
        loads: &Loads<'_, D>,
        sub_steps: u32,
    ) -> Result<Candidate<D>, Error> {
        self.report.sub_steps = sub_steps;
        for sub_step in 1..=sub_steps {
            let solved = solve_contacts(self.stage, neighbours, &self.state, loads)?;
            if !solved.outcome.converged {
                return Err(not_converged(&solved, self.stage, sub_step, sub_steps));
            }
            self.accept(&solved, loads.dt);
        }
        self.state.check_finite()?;
        Ok(self.finish(request))
    }

    /// Velocities and positions at the end of a solved sub-step.
    fn accept(&mut self, solved: &Solved<D>, dt: f64) {
        let grains = self.stage.grains;
        let grain_count = grains.count();
        let mut displacement = Vec::with_capacity(grain_count);
        for (grain, body) in solved.system.bodies[..grain_count].iter().enumerate() {
            self.state.velocity[grain] = body.velocity;
            if solved.system.has_friction() {
                self.state.spin[grain] = body.surface / grains.radius[grain];
            }
            displacement.push(body.velocity * dt);
        }
        correct(grains, &solved.pairs, &mut displacement, SWEEPS);
        for (grain, moved) in displacement.iter().enumerate() {
            self.state.position[grain] += moved;
            self.displacement[grain] += moved;
        }
        self.state.impulses = impulses(&solved.system, &solved.pairs, dt);
        if self.first_impulses.is_none() {
            self.first_impulses = Some(self.state.impulses.clone());
        }
        let penetration_max = self.note_contacts(solved, &displacement, dt);
        self.note_numbers(solved, penetration_max);
    }

    /// Who touches and with what force; the largest overlap, of the smaller radius.
    fn note_contacts(&mut self, solved: &Solved<D>, displacement: &[Vector<D>], dt: f64) -> f64 {
        let (grains, system) = (self.stage.grains, &solved.system);
        self.active.clear();
        let mut penetration_max = 0.0f64;
        let contacts = solved.pairs.iter().zip(&system.contacts);
        for ((pair, contact), weight) in contacts.zip(&system.weights) {
            let overlap = -gap_after(grains, pair, displacement);
            penetration_max = penetration_max.max(overlap / smaller_radius(grains, pair));
            // Below the tolerance an impulse is noise and holds nothing.
            if contact.impulse.normal * weight > self.stage.goal.wished {
                let (first, second) = (pair.key.first as usize, pair.key.second as usize);
                self.touched.join(first, second, &grains.fixed);
                let force = contact.impulse.over(dt);
                let push = Dim::<D>::combined(force.normal, force.tangential, &pair.normal);
                let pair = *pair;
                self.active.push(ActiveContact { pair, force, push });
            }
        }
        penetration_max
    }

    fn note_numbers(&mut self, solved: &Solved<D>, penetration_max: f64) {
        let (report, outcome) = (&mut self.report, &solved.outcome);
        report.contacts = self.active.len();
        report.candidates = report.candidates.max(solved.pairs.len());
        report.sweeps += outcome.sweeps;
        report.residual.rms = report.residual.rms.max(outcome.residual.rms);
        report.residual.max = report.residual.max.max(outcome.residual.max);
        report.penetration_max = penetration_max;
        report.attempts += solved.attempts;
    }

    /// The candidate.
    pub fn finish(mut self, request: &Request) -> Candidate<D> {
        let grains = self.stage.grains;
        let inertia_factor = self.stage.material.inertia_factor;
        self.report.kinetic_energy = self.state.kinetic_energy(grains, inertia_factor);
        let mean = |moved: &Vector<D>| moved * (1.0 / request.dt);
        Candidate {
            label: request.label(),
            mean_velocity: self.displacement.iter().map(mean).collect(),
            contact: self.touched.answer(&grains.fixed),
            report: self.report,
            active: self.active,
            first_impulses: self.first_impulses.unwrap_or_default(),
            state: self.state,
        }
    }
}

fn not_converged<const D: usize>(
    solved: &Solved<D>,
    stage: &Stage<'_, D>,
    sub_step: u32,
    sub_steps: u32,
) -> Error
where
    Dim<D>: Dimension<D>,
{
    Error::NotConverged {
        residual: solved.outcome.residual.rms,
        residual_max: solved.outcome.residual.max,
        tolerance: stage.goal.wished.max(stage.goal.required),
        sweeps: solved.outcome.sweeps,
        sweeps_max: stage.sweeps_max,
        contacts: solved.pairs.len(),
        sub_step,
        sub_steps,
    }
}
