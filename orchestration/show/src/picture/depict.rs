//! What pictures of the plane and of space have in common: their names.

use super::canvas::Canvas;
use super::state::{Stage, State};
use super::{plane, space};
use crate::outline;
use crate::simplices::{Point, Simplices};

/// What is drawn of a stage and its states.
pub trait Depict<const D: usize, const N: usize> {
    /// Segments that show where the mesh and the walls end.
    fn outlines(mesh: Option<&Simplices<D, N>>, walls: &[[Point<D>; D]]) -> Vec<[Point<D>; 2]>;

    /// One picture of one state; `speed_max` is the speed of the deepest colour \[m/s\].
    fn frame(&self, state: &State<D, N>, speed_max: f64) -> Canvas;

    /// A contact sheet of states; none when there is nothing to show.
    fn overview(&self, states: &[&State<D, N>]) -> Option<Canvas>;
}

impl Depict<2, 3> for Stage<2, 3> {
    fn outlines(mesh: Option<&Simplices<2, 3>>, walls: &[[Point<2>; 2]]) -> Vec<[Point<2>; 2]> {
        let sides = mesh.into_iter().flat_map(|mesh| {
            let at = |point: u32| mesh.points[point as usize];
            mesh.boundary().into_iter().map(move |side| side.map(at))
        });
        walls.iter().copied().chain(sides).collect()
    }

    fn frame(&self, state: &State<2, 3>, speed_max: f64) -> Canvas {
        plane::frame::frame(self, state, speed_max)
    }

    fn overview(&self, states: &[&State<2, 3>]) -> Option<Canvas> {
        plane::overview::overview(self, states)
    }
}

impl Depict<3, 4> for Stage<3, 4> {
    fn outlines(mesh: Option<&Simplices<3, 4>>, walls: &[[Point<3>; 3]]) -> Vec<[Point<3>; 2]> {
        let mut outlines = outline::of_facets(walls);
        if let Some(mesh) = mesh {
            outlines.extend(outline::creases(&mesh.points, &mesh.boundary()));
        }
        outlines
    }

    fn frame(&self, state: &State<3, 4>, speed_max: f64) -> Canvas {
        space::frame::frame(self, state, speed_max)
    }

    fn overview(&self, states: &[&State<3, 4>]) -> Option<Canvas> {
        space::overview::overview(self, states)
    }
}
