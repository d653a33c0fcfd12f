//! Where a mesh comes from: a rectangle or a box of cells, a file; alone, or as what is refined.

use std::path::PathBuf;

use gmsh::Options;
use space::{Dim, Dimension, Vector};

use crate::boundary::condition::periodic_directions;
use crate::config::FluidConfig;
use crate::error::FluidError;
use crate::mesh::Root;
use crate::mesh::file;
use crate::mesh::rectangle::Rectangle;
use crate::mesh::simplices::Mesh;
use crate::refined::{self, Refined, Refinement};
use crate::step::FluidSolver;

/// What a mesh is made of.
pub trait Source<const D: usize, const N: usize>
where
    Dim<D>: Dimension<D>,
{
    /// A solver on its mesh, whose sides are joined where the conditions say so.
    fn solver(&self, config: FluidConfig<D>) -> Result<FluidSolver<D, N>, FluidError>;

    /// A solver whose mesh is refined from it.
    fn refined(
        &self,
        config: FluidConfig<D>,
        sizes: &Refinement<D>,
    ) -> Result<(FluidSolver<D, N>, Refined<D, N>), FluidError>;
}

/// A Gmsh file.
pub struct MeshFile {
    /// Where it is.
    pub path: PathBuf,
    /// How it is read.
    pub options: Options,
}

impl MeshFile {
    fn mesh<const D: usize, const N: usize>(
        &self,
        config: &FluidConfig<D>,
    ) -> Result<Mesh<D, N>, FluidError>
    where
        Dim<D>: Dimension<D>,
    {
        file::read(&self.path, &self.options, |name| {
            config.boundaries.contains_key(name)
        })
    }
}

impl<const D: usize, const N: usize> Source<D, N> for MeshFile
where
    Dim<D>: Dimension<D>,
{
    fn solver(&self, config: FluidConfig<D>) -> Result<FluidSolver<D, N>, FluidError> {
        let mesh = self.mesh(&config)?;
        FluidSolver::new(config, mesh)
    }

    fn refined(
        &self,
        config: FluidConfig<D>,
        sizes: &Refinement<D>,
    ) -> Result<(FluidSolver<D, N>, Refined<D, N>), FluidError> {
        let mesh = self.mesh(&config)?;
        refined::solver_on_mesh(config, &mesh, sizes)
    }
}

impl Source<2, 3> for Rectangle {
    fn solver(&self, config: FluidConfig<2>) -> Result<FluidSolver<2, 3>, FluidError> {
        let joined = Rectangle {
            periodic: periodic_directions(&config.boundaries)?,
            ..self.clone()
        };
        FluidSolver::new(config, joined.mesh()?)
    }

    fn refined(
        &self,
        config: FluidConfig<2>,
        sizes: &Refinement<2>,
    ) -> Result<(FluidSolver<2, 3>, Refined<2, 3>), FluidError> {
        if self.grading != Vector::from([1.0; 2]) {
            return Err(FluidError::Mesh(
                "a rectangle is refined from cells of one size: leave its grading out".to_owned(),
            ));
        }
        let cells = Root {
            lower: self.lower,
            upper: self.upper,
            cells: self.cells,
            periodic: [false; 2],
        };
        cells.refined(config, sizes)
    }
}

impl<const D: usize, const N: usize> Source<D, N> for Root<D>
where
    Dim<D>: Dimension<D>,
{
    fn solver(&self, config: FluidConfig<D>) -> Result<FluidSolver<D, N>, FluidError> {
        let cells = joined(self, &config)?;
        refined::solver_on_cells(config, &cells)
    }

    fn refined(
        &self,
        config: FluidConfig<D>,
        sizes: &Refinement<D>,
    ) -> Result<(FluidSolver<D, N>, Refined<D, N>), FluidError> {
        let root = joined(self, &config)?;
        refined::solver(config, &root, sizes)
    }
}

/// These cells with their sides joined where the conditions say so.
fn joined<const D: usize>(cells: &Root<D>, config: &FluidConfig<D>) -> Result<Root<D>, FluidError> {
    Ok(Root {
        periodic: periodic_directions(&config.boundaries)?,
        ..cells.clone()
    })
}
