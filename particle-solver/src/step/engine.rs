//! The engine: an accepted state, and a candidate that replaces it when it is committed.

use std::path::Path;
use std::sync::Arc;

use space::{Dim, Dimension};

use crate::checkpoint;
use crate::contact::impulses::Impulses;
use crate::contact::loads::Loads;
use crate::error::Error;
use crate::grains::{Grains, State};
use crate::search::neighbours::{Found, Neighbours};
use crate::search::place::Place;
use crate::setup::{Setup, check_places};
use crate::small::choice::{Solver, choose};
use crate::small::run as small;
use crate::solve::schedule::Goal;
use crate::step::candidate::Candidate;
use crate::step::motion::Motion;
use crate::step::request::{Forces, Label, Request};
use crate::step::sub_step::Stage;
use crate::step::sub_steps::count;
use crate::walls::near::Walls;

/// The engine: what never changes, the accepted state, and a candidate.
#[derive(Debug, Clone)]
pub struct ContactEngine<const D: usize>
where
    Dim<D>: Dimension<D>,
{
    setup: Setup<D>,
    walls: Walls<D>,
    grains: Grains,
    accepted: State<D>,
    candidate: Option<Candidate<D>>,
    /// Label and first impulses of the pass before the candidate's.
    previous_pass: Option<(Label, Impulses<D>)>,
    neighbours: Neighbours<D>,
    /// What was known of neighbours when the state was accepted.
    accepted_search: Arc<Found<D>>,
}

impl<const D: usize> ContactEngine<D>
where
    Dim<D>: Dimension<D>,
{
    /// Check the setup and place the grains.
    pub fn new(
        setup: Setup<D>,
        grains: Grains,
        state: State<D>,
    ) -> Result<ContactEngine<D>, Error> {
        setup.check()?;
        grains.check()?;
        let walls = Walls::new(&setup.walls, &setup.period)?;
        check_places(&setup, &grains, &state, &walls)?;
        Ok(ContactEngine {
            setup,
            walls,
            grains,
            accepted: state,
            candidate: None,
            previous_pass: None,
            neighbours: Neighbours::default(),
            accepted_search: Arc::default(),
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
    pub fn setup(&self) -> &Setup<D> {
        &self.setup
    }

    /// The grains.
    pub fn grains(&self) -> &Grains {
        &self.grains
    }

    /// The accepted state.
    pub fn accepted(&self) -> &State<D> {
        &self.accepted
    }

    /// The last candidate, until it is accepted.
    pub fn candidate(&self) -> Option<&Candidate<D>> {
        self.candidate.as_ref()
    }

    /// Write the accepted state to a file, with the search before it.
    pub fn save(&self, path: &Path) -> Result<(), Error> {
        let search = (
            &self.accepted_search.reference[..],
            &self.accepted_search.spare[..],
        );
        checkpoint::save(path, &self.grains, (&self.accepted, search))
    }

    /// Read the accepted state from a file.
    pub fn restore(&mut self, path: &Path) -> Result<(), Error> {
        let (state, (reference, spare)) = checkpoint::restore(path, &self.grains)?;
        self.set_accepted(state)?;
        if !reference.is_empty() && !self.neighbours.search_always {
            let place = Place {
                grains: &self.grains,
                position: &reference,
                walls: &self.walls,
                period: self.setup.period,
            };
            self.accepted_search = Arc::new(Found::search(&place, spare)?);
            self.neighbours.found = Arc::clone(&self.accepted_search);
        }
        Ok(())
    }

    /// Take another accepted state.
    pub fn set_accepted(&mut self, state: State<D>) -> Result<(), Error> {
        let count = self.grains.count();
        if [state.position.len(), state.velocity.len(), state.spin.len()] != [count; 3] {
            return Err(Error::Request(format!(
                "the state is not one of {count} grains"
            )));
        }
        state.check_finite()?;
        self.accepted = state;
        self.begin_anew();
        Ok(())
    }

    /// Nothing is known of the accepted state.
    fn begin_anew(&mut self) {
        self.candidate = None;
        self.previous_pass = None;
        self.neighbours.forget();
        self.accepted_search = Arc::default();
    }

    /// Take grains out of the accepted state, by ascending numbers; the others keep their order.
    pub fn remove(&mut self, gone: &[usize]) -> Result<(), Error> {
        let count = self.grains.count();
        let known = gone.is_sorted_by(|a, b| a < b) && gone.last().is_none_or(|&g| g < count);
        if !known {
            return Err(Error::Request(format!(
                "grains {gone:?} are to leave: numbers must ascend and be below {count}"
            )));
        }
        self.accepted = self.accepted.without(gone);
        self.grains = self.grains.without(gone);
        self.begin_anew();
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
        self.accepted_search = Arc::clone(&self.neighbours.found);
        Ok(())
    }

    /// Compute a candidate. The same request gives the same bits, however often it is made.
    pub fn advance(
        &mut self,
        request: &Request,
        forces: &Forces<'_, D>,
    ) -> Result<&Candidate<D>, Error> {
        request.check()?;
        forces.check(self.grains.count())?;
        let warm = match self.solver(forces) {
            Solver::Converged => Some(self.warm_start(request)),
            Solver::SmallSteps => None,
        };
        self.candidate = None;
        let mut neighbours = std::mem::take(&mut self.neighbours);
        let computed = self.compute(request, forces, warm, &mut neighbours);
        self.neighbours = neighbours;
        Ok(self.candidate.insert(computed?))
    }

    /// In small steps, or with converged contacts from `warm` impulses.
    fn compute(
        &self,
        request: &Request,
        forces: &Forces<'_, D>,
        warm: Option<Impulses<D>>,
        neighbours: &mut Neighbours<D>,
    ) -> Result<Candidate<D>, Error> {
        let stage = self.stage(request.tolerance);
        let Some(warm) = warm else {
            let loads = self.loads(request.dt, forces);
            let most = self.setup.sub_steps_max;
            return small::advance(&stage, &self.accepted, neighbours, (request, &loads), most);
        };
        let sub_steps = match request.sub_steps {
            0 => self.sub_steps(request.dt, forces, neighbours)?,
            given => given,
        };
        let start = State {
            impulses: warm,
            ..self.accepted.clone()
        };
        let loads = self.loads(request.dt / f64::from(sub_steps), forces);
        Motion::new(&stage, start).run(neighbours, request, &loads, sub_steps)
    }

    /// Sub-steps that the relative motion of this step asks for.
    fn sub_steps(
        &self,
        dt: f64,
        forces: &Forces<'_, D>,
        neighbours: &mut Neighbours<D>,
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

    /// How this step is solved; its passes agree, as they start from the same state.
    fn solver(&self, forces: &Forces<'_, D>) -> Solver {
        let immersed = forces.drag.is_some() || forces.force.is_some();
        choose(self.setup.solver, &self.grains, &self.accepted, immersed)
    }

    /// Impulses to start from: accepted ones in pass 0, afterwards those of the pass before of the
    /// same step and length, so that a repeated request starts from the same.
    fn warm_start(&mut self, request: &Request) -> Impulses<D> {
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

    fn loads<'a>(&self, dt: f64, forces: &Forces<'a, D>) -> Loads<'a, D> {
        Loads {
            dt,
            gravity: self.setup.gravity,
            drag: forces.drag,
            force: forces.force,
        }
    }

    fn stage(&self, tolerance: f64) -> Stage<'_, D> {
        let required = self.setup.tolerance;
        let wished = if tolerance > 0.0 { tolerance } else { required };
        Stage {
            grains: &self.grains,
            walls: &self.walls,
            period: self.setup.period,
            material: self.setup.material(),
            goal: Goal { wished, required },
            sweeps_max: self.setup.sweeps_max,
        }
    }
}
