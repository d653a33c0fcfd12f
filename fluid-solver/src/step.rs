//! One step: the accepted state and the solid in, a candidate out; `commit` accepts it.

use std::sync::Arc;

use space::{Dim, Dimension};

use crate::boundary::constraints::Constraints;
use crate::candidate::{Candidate, Request};
use crate::config::FluidConfig;
use crate::cost::cpu_seconds;
use crate::diagnostics::content::MeshChange;
use crate::error::FluidError;
use crate::mesh::nested::Coarser;
use crate::mesh::simplices::Mesh;
use crate::problem::{Problem, Step};
use crate::solid::{Solid, SolidFields};
use crate::state::State;

/// The fluid engine in `D` dimensions, with `N = D + 1` unknowns a node.
pub struct FluidSolver<const D: usize, const N: usize> {
    problem: Problem<D, N>,
    pool: Arc<rayon::ThreadPool>,
    accepted: State<D>,
    candidate: Option<Candidate<D>>,
}

impl<const D: usize, const N: usize> FluidSolver<D, N>
where
    Dim<D>: Dimension<D>,
{
    /// A solver at its initial state.
    pub fn new(config: FluidConfig<D>, mesh: Mesh<D, N>) -> Result<Self, FluidError> {
        Self::with_coarser(config, mesh, &[])
    }

    /// The same with coarser meshes under the mesh, by which large ones are solved.
    pub fn with_coarser(
        config: FluidConfig<D>,
        mesh: Mesh<D, N>,
        coarser: &[Coarser<D, N>],
    ) -> Result<Self, FluidError> {
        config.validate()?;
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(config.threads.max(1))
            .build();
        Ok(FluidSolver {
            accepted: State::uniform(mesh.node_count(), config.initial_velocity),
            problem: Problem::new(config, mesh, coarser)?,
            pool: Arc::new(pool.map_err(|error| FluidError::Threads(error.to_string()))?),
            candidate: None,
        })
    }

    /// The mesh.
    pub fn mesh(&self) -> &Mesh<D, N> {
        &self.problem.mesh
    }

    /// What holds at its boundary.
    pub fn constraints(&self) -> &Constraints<D> {
        self.problem.constraints()
    }

    /// The accepted state.
    pub fn state(&self) -> &State<D> {
        &self.accepted
    }

    /// Replace the accepted state, e.g. by a checkpoint of the same mesh.
    pub fn set_state(&mut self, state: State<D>) {
        self.accepted = state;
        self.candidate = None;
    }

    /// The mesh may become another one: from the first step on candidates tell what that costs and changes.
    pub(crate) fn tell_of_meshes(&mut self) {
        self.problem.add_cost_of_mesh(0.0);
    }

    /// Go on on another mesh with coarser ones under it, whose nodes are at these nodes and shape functions of the one
    /// before; it was begun at this CPU time \[s\].
    pub(crate) fn change_mesh(
        &mut self,
        mesh: Mesh<D, N>,
        coarser: &[Coarser<D, N>],
        spots: &[([u32; N], [f64; N])],
        begin: f64,
    ) -> Result<(), FluidError> {
        let config = self.problem.config();
        let mut problem = Problem::new(config.clone(), mesh, coarser)?;
        let mut state = self.accepted.carried(spots);
        let before = || self.accepted.content(&self.problem.mesh, config.density);
        let changed = self.accepted.mesh_change;
        state.mesh_change = Some(MeshChange {
            from: changed.map_or_else(before, |change| change.from),
            to: state.content(&problem.mesh, config.density),
        });
        problem.add_cost_of_mesh(cpu_seconds() - begin);
        self.problem = problem;
        self.set_state(state);
        Ok(())
    }

    /// Compute a candidate from the accepted state, which stays as it is. Fails on a `dt` that is not
    /// positive, on fields of the wrong shape, and where the equations cannot be solved.
    pub fn advance(
        &mut self,
        request: &Request,
        fields: &SolidFields<'_>,
    ) -> Result<&Candidate<D>, FluidError> {
        let last = self.candidate.take();
        let further = last.filter(|last| request.follows(&last.request));
        let convected = further.map_or(self.accepted.convected, |last| last.state.convected);
        let solid = Solid::new(fields, &self.problem.mesh)?;
        let step = Step::new(&self.accepted, request, solid)?;
        let problem = &mut self.problem;
        let mut candidate = self.pool.install(|| problem.solve(&step, convected))?;
        if problem.mesh_may_change() {
            let change = self.accepted.mesh_change.unwrap_or_else(MeshChange::none);
            candidate.diagnostics.extend(change.numbers());
        }
        Ok(self.candidate.insert(candidate))
    }

    /// Accept the last candidate.
    pub fn commit(&mut self) -> Result<(), FluidError> {
        let candidate = self.candidate.take().ok_or(FluidError::NoCandidate)?;
        if candidate.state.convected && !self.accepted.convected {
            let (time, reynolds) = (candidate.state.time, candidate.reynolds);
            tracing::info!(time, reynolds, "convection is there from now on");
        }
        self.accepted = candidate.state;
        self.problem.forget_cost();
        Ok(())
    }
}
