//! One `advance`: a candidate for the end of the step, from the accepted state, which stays.

use crate::candidate::{ActiveContact, Candidate, Forces, Label, Report, Request};
use crate::contact::{Candidate as Pair, Impulses};
use crate::correct::{correct, smaller_radius};
use crate::delassus::Loads;
use crate::error::Error;
use crate::grains::{Grains, State};
use crate::neighbours::{Neighbours, Place};
use crate::setup::{Setup, check_places};
use crate::sub_step::{Solved, Stage, impulses, solve_contacts};
use crate::sub_steps::count;
use crate::touched::Touched;
use crate::vector::{Vector, add, norm, scale, sub};
use crate::walls::Walls;

/// The engine: what never changes, the accepted state, and a candidate.
#[derive(Debug, Clone)]
pub struct ContactEngine {
    setup: Setup,
    walls: Walls,
    grains: Grains,
    accepted: State,
    candidate: Option<Candidate>,
    /// Label and first impulses of the pass before the candidate's.
    previous_pass: Option<(Label, Impulses)>,
    neighbours: Neighbours,
}

/// What moves during an advance.
struct Motion {
    state: State,
    displacement: Vec<Vector>,
    touched: Touched,
    report: Report,
    first_impulses: Option<Impulses>,
    active: Vec<ActiveContact>,
}

impl ContactEngine {
    /// Check the setup and place the grains.
    pub fn new(setup: Setup, grains: Grains, state: State) -> Result<ContactEngine, Error> {
        setup.check()?;
        grains.check()?;
        let walls = Walls::new(&setup.walls, setup.period)?;
        check_places(&setup, &grains, &state, &walls)?;
        Ok(ContactEngine {
            setup,
            walls,
            grains,
            accepted: state,
            candidate: None,
            previous_pass: None,
            neighbours: Neighbours::default(),
        })
    }

    /// Search for contacts anew each time instead of keeping what one search found; the candidates
    /// are the same.
    pub fn search_always(&mut self, always: bool) {
        self.neighbours.search_always = always;
    }

    /// Searches for contacts so far, and grains for which walls were looked at.
    pub fn searches(&self) -> [u64; 2] {
        [self.neighbours.searches, self.neighbours.wall_looks]
    }

    /// The setup.
    pub fn setup(&self) -> &Setup {
        &self.setup
    }

    /// The grains.
    pub fn grains(&self) -> &Grains {
        &self.grains
    }

    /// The accepted state.
    pub fn accepted(&self) -> &State {
        &self.accepted
    }

    /// The last candidate, until it is accepted.
    pub fn candidate(&self) -> Option<&Candidate> {
        self.candidate.as_ref()
    }

    /// Take another accepted state, as after reading a checkpoint.
    pub fn set_accepted(&mut self, state: State) -> Result<(), Error> {
        let count = self.grains.count();
        if [state.position.len(), state.velocity.len(), state.spin.len()] != [count; 3] {
            return Err(Error::Request(format!(
                "the state is not one of {count} grains"
            )));
        }
        state.check_finite()?;
        self.accepted = state;
        self.candidate = None;
        self.previous_pass = None;
        self.neighbours.forget();
        Ok(())
    }

    /// Accept the last candidate.
    pub fn commit(&mut self) -> Result<(), Error> {
        let candidate = self
            .candidate
            .take()
            .ok_or_else(|| Error::Request("there is no candidate to accept".into()))?;
        self.accepted = candidate.state;
        self.previous_pass = None;
        Ok(())
    }

    /// Compute a candidate. The same request gives the same bits, however often it is made.
    pub fn advance(&mut self, request: &Request, forces: &Forces<'_>) -> Result<&Candidate, Error> {
        self.check(request, forces)?;
        let warm = self.warm_start(request);
        self.candidate = None;
        let mut neighbours = std::mem::take(&mut self.neighbours);
        let computed = self.compute(request, forces, warm, &mut neighbours);
        self.neighbours = neighbours;
        Ok(self.candidate.insert(computed?))
    }

    fn compute(
        &self,
        request: &Request,
        forces: &Forces<'_>,
        warm: Impulses,
        neighbours: &mut Neighbours,
    ) -> Result<Candidate, Error> {
        let sub_steps = match request.sub_steps {
            0 => self.sub_steps(request.dt, forces, neighbours)?,
            given => given,
        };
        let grain_count = self.grains.count();
        let mut motion = Motion {
            state: State {
                impulses: warm,
                ..self.accepted.clone()
            },
            displacement: vec![[0.0; 2]; grain_count],
            touched: Touched::new(grain_count),
            report: Report {
                sub_steps,
                ..Report::default()
            },
            first_impulses: None,
            active: Vec::new(),
        };
        let stage = self.stage(request.tolerance);
        let loads = self.loads(request.dt / f64::from(sub_steps), forces);
        for sub_step in 1..=sub_steps {
            self.sub_step(&mut motion, neighbours, &stage, &loads, sub_step)?;
        }
        motion.state.check_finite()?;
        let inertia_factor = self.setup.inertia_factor;
        motion.report.kinetic_energy = motion.state.kinetic_energy(&self.grains, inertia_factor);
        let mean = |moved: &Vector| scale(1.0 / request.dt, *moved);
        Ok(Candidate {
            label: request.label(),
            mean_velocity: motion.displacement.iter().map(mean).collect(),
            contact: motion.touched.answer(&self.grains.fixed),
            report: motion.report,
            active: motion.active,
            first_impulses: motion.first_impulses.unwrap_or_default(),
            state: motion.state,
        })
    }

    /// Sub-steps that the relative motion of this step asks for.
    fn sub_steps(
        &self,
        dt: f64,
        forces: &Forces<'_>,
        neighbours: &mut Neighbours,
    ) -> Result<u32, Error> {
        let free = self
            .loads(dt, forces)
            .free_velocity(&self.grains, &self.accepted.velocity);
        let place = Place {
            grains: &self.grains,
            position: &self.accepted.position,
            walls: &self.walls,
            period: self.setup.period,
        };
        count(neighbours, &place, &free, dt, self.setup.sub_steps_max)
    }

    /// Impulses to start from: accepted ones in pass 0, afterwards those of the pass before of the
    /// same step and length, so that a repeated request starts from the same.
    fn warm_start(&mut self, request: &Request) -> Impulses {
        if let Some(before) = request.label_before() {
            if let Some(candidate) = self.candidate.take_if(|c| c.label == before) {
                self.previous_pass = Some((before, candidate.first_impulses));
            }
            if let Some((label, impulses)) = &self.previous_pass
                && *label == before
            {
                return impulses.clone();
            }
        }
        self.accepted.impulses.clone()
    }

    fn loads<'a>(&self, dt: f64, forces: &Forces<'a>) -> Loads<'a> {
        Loads {
            dt,
            gravity: self.setup.gravity,
            drag: forces.drag,
            force: forces.force,
        }
    }

    fn stage(&self, tolerance: f64) -> Stage<'_> {
        Stage {
            grains: &self.grains,
            walls: &self.walls,
            period: self.setup.period,
            friction: [self.setup.friction, self.setup.wall_friction],
            inertia_factor: self.setup.inertia_factor,
            tolerance: if tolerance > 0.0 {
                tolerance
            } else {
                self.setup.tolerance
            },
            required: self.setup.tolerance,
            sweeps_max: self.setup.sweeps_max,
        }
    }

    /// Free velocities, contacts, motion.
    fn sub_step(
        &self,
        motion: &mut Motion,
        neighbours: &mut Neighbours,
        stage: &Stage<'_>,
        loads: &Loads<'_>,
        sub_step: u32,
    ) -> Result<(), Error> {
        let solved = solve_contacts(stage, neighbours, &motion.state, loads)?;
        if !solved.outcome.converged {
            return Err(not_converged(
                &solved,
                stage,
                sub_step,
                motion.report.sub_steps,
            ));
        }
        let grain_count = self.grains.count();
        let mut displacement = Vec::with_capacity(grain_count);
        for (grain, body) in solved.system.bodies[..grain_count].iter().enumerate() {
            motion.state.velocity[grain] = body.velocity;
            if solved.system.has_friction() {
                motion.state.spin[grain] = body.surface_speed / self.grains.radius[grain];
            }
            displacement.push(scale(loads.dt, body.velocity));
        }
        correct(&self.grains, &solved.pairs, &mut displacement);
        for (grain, &moved) in displacement.iter().enumerate() {
            motion.state.position[grain] = add(motion.state.position[grain], moved);
            motion.displacement[grain] = add(motion.displacement[grain], moved);
        }
        self.remember(motion, stage, &solved, &displacement, loads.dt);
        Ok(())
    }

    /// Keep impulses, contact states and numbers of a solved sub-step.
    fn remember(
        &self,
        motion: &mut Motion,
        stage: &Stage<'_>,
        solved: &Solved,
        displacement: &[Vector],
        dt: f64,
    ) {
        let Solved {
            system,
            pairs,
            outcome,
            attempts,
        } = solved;
        motion.state.impulses = impulses(system, pairs, dt);
        if motion.first_impulses.is_none() {
            motion.first_impulses = Some(motion.state.impulses.clone());
        }
        motion.active.clear();
        let mut penetration_max = 0.0f64;
        for ((pair, contact), weight) in pairs.iter().zip(&system.contacts).zip(&system.weights) {
            let overlap = -gap_after(&self.grains, pair, displacement);
            penetration_max = penetration_max.max(overlap / smaller_radius(&self.grains, pair));
            // Below the tolerance an impulse is noise and holds nothing.
            if contact.normal_impulse * weight > stage.tolerance {
                let (first, second) = (pair.key.first as usize, pair.key.second as usize);
                motion.touched.join(first, second, &self.grains.fixed);
                let force = [contact.normal_impulse / dt, contact.tangential_impulse / dt];
                motion.active.push(ActiveContact { pair: *pair, force });
            }
        }
        let report = &mut motion.report;
        report.contacts = motion.active.len();
        report.candidates = report.candidates.max(pairs.len());
        report.sweeps += outcome.sweeps;
        report.residual.rms = report.residual.rms.max(outcome.residual.rms);
        report.residual.max = report.residual.max.max(outcome.residual.max);
        report.penetration_max = penetration_max;
        report.attempts += attempts;
    }

    fn check(&self, request: &Request, forces: &Forces<'_>) -> Result<(), Error> {
        if !(request.dt.is_finite() && request.dt > 0.0) {
            return Err(Error::Request(format!(
                "step of {} s, must be positive",
                request.dt
            )));
        }
        let count = self.grains.count();
        let (drag, force) = (
            forces.drag.unwrap_or_default(),
            forces.force.unwrap_or_default(),
        );
        if forces.drag.is_some() && drag.len() != count {
            return Err(Error::Request(format!(
                "{} drags for {count} grains",
                drag.len()
            )));
        }
        if forces.force.is_some() && force.len() != 2 * count {
            return Err(Error::Request(format!(
                "{} forces for {count} grains",
                force.len() / 2
            )));
        }
        if let Some(grain) = drag
            .iter()
            .position(|drag| !(drag.is_finite() && *drag >= 0.0))
        {
            return Err(Error::NotFinite {
                what: "drag",
                grain,
                value: drag[grain],
            });
        }
        if let Some(place) = force.iter().position(|force| !force.is_finite()) {
            let value = force[place];
            return Err(Error::NotFinite {
                what: "force",
                grain: place / 2,
                value,
            });
        }
        Ok(())
    }
}

fn not_converged(solved: &Solved, stage: &Stage<'_>, sub_step: u32, sub_steps: u32) -> Error {
    Error::NotConverged {
        residual: solved.outcome.residual.rms,
        residual_max: solved.outcome.residual.max,
        tolerance: stage.tolerance.max(stage.required),
        sweeps: solved.outcome.sweeps,
        sweeps_max: stage.sweeps_max,
        contacts: solved.pairs.len(),
        sub_step,
        sub_steps,
    }
}

/// Gap of a pair after these displacements \[m\]; exact for two grains and for faces.
fn gap_after(grains: &Grains, pair: &Pair, displacement: &[Vector]) -> f64 {
    let (first, second) = (pair.key.first as usize, pair.key.second as usize);
    let other = displacement.get(second).copied().unwrap_or_default();
    let moved = sub(displacement[first], other);
    match grains.radius.get(second) {
        Some(radius) => {
            let size = grains.radius[first] + radius;
            norm(add(scale(size + pair.gap, pair.normal), moved)) - size
        }
        None => pair.gap + moved[0] * pair.normal[0] + moved[1] * pair.normal[1],
    }
}
