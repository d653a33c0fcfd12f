//! A box of space on a rectangle of the paper, and what is drawn in it.

use super::camera::Camera;
use super::raster::Raster;
use super::{Stage, State};
use crate::cut::{Cut, level};
use crate::outline::{corners, edges};
use crate::picture::canvas::Canvas;
use crate::picture::colour::{FluidColours, GREY, INK};
use crate::simplices::{Corners, Point, clip};

/// A box as its camera sees it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sight {
    /// What is shown \[m\].
    pub shown: Corners<3>,
    camera: Camera,
    /// Slopes of the left and lower edge, and of the right and upper one.
    slopes: Corners<2>,
}

impl Sight {
    /// A box, filled by it.
    pub fn of(shown: Corners<3>) -> Sight {
        let camera = Camera::of(shown);
        let slopes = corners(shown).map(|corner| slope(&camera, corner));
        Sight {
            shown,
            camera,
            slopes: crate::simplices::bounds(slopes.into_iter()),
        }
    }

    /// Width and height, in units of slope.
    pub fn size(&self) -> [f64; 2] {
        let (low, high) = self.slopes;
        [high[0] - low[0], high[1] - low[1]]
    }
}

fn slope(camera: &Camera, point: Point<3>) -> Point<2> {
    let [right, up, depth] = camera.see(point);
    [right / depth, up / depth]
}

/// Where a box lies on the paper.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    /// What is seen.
    pub sight: Sight,
    /// Left edge on the paper \[pixels\].
    pub left: f64,
    /// Upper edge on the paper \[pixels\].
    pub top: f64,
    /// Pixels a unit of slope.
    pub scale: f64,
}

impl View {
    /// Right edge \[pixels\].
    pub fn right(&self) -> f64 {
        self.left + self.sight.size()[0] * self.scale
    }

    /// Lower edge \[pixels\].
    pub fn bottom(&self) -> f64 {
        self.top + self.sight.size()[1] * self.scale
    }

    /// A point of space on the paper.
    pub fn place(&self, point: Point<3>) -> Point<2> {
        let ([left, _], [_, top]) = self.sight.slopes;
        let [right, up] = slope(&self.sight.camera, point);
        [
            self.left + (right - left) * self.scale,
            self.top + (top - up) * self.scale,
        ]
    }

    /// Draw a state: grains, boundaries, speed of the fluid on the plane; `speed_max` is the deepest colour,
    /// `marked` a box within.
    pub fn draw(
        &self,
        canvas: &mut Canvas,
        stage: &Stage,
        state: &State,
        speed_max: f64,
        marked: Option<Corners<3>>,
    ) {
        // A pixel of margin for lines along the edge.
        const MARGIN: f64 = 2.0;
        let [width, height] = self
            .sight
            .size()
            .map(|size| size * self.scale + 2.0 * MARGIN);
        let ([left, _], [_, top]) = self.sight.slopes;
        let (paper_left, paper_top) = (self.left.round() - MARGIN, self.top.round() - MARGIN);
        let corner = [
            left - (self.left - paper_left) / self.scale,
            top + (self.top - paper_top) / self.scale,
        ];
        let mut raster = Raster::new(
            width.ceil() as usize,
            height.ceil() as usize,
            corner,
            self.scale,
        );
        self.draw_grains(&mut raster, stage, state, speed_max);
        let (low, high) = self.sight.shown;
        for [a, b] in &stage.outlines {
            if let Some((a, b)) = clip(*a, *b, low, high) {
                raster.line(self.see([a, b]), 1.8, INK);
            }
        }
        let is_boundary = (low, high) == stage.window && !stage.outlines.is_empty();
        for [a, b] in edges(self.sight.shown).into_iter().filter(|_| !is_boundary) {
            raster.line(self.see([a, b]), 1.3, GREY);
        }
        for [a, b] in marked.map(edges).unwrap_or_default() {
            raster.line(self.see([a, b]), 1.3, INK);
        }
        self.draw_speed(&mut raster, stage, state, speed_max);
        raster.lay_on(canvas, paper_left as usize, paper_top as usize);
    }

    fn see(&self, ends: [Point<3>; 2]) -> [Point<3>; 2] {
        ends.map(|end| self.sight.camera.see(end))
    }

    /// Grains whose centres are in the box.
    fn draw_grains(&self, raster: &mut Raster, stage: &Stage, state: &State, speed_max: f64) {
        let (low, high) = self.sight.shown;
        let mut seen = Vec::new();
        for (grain, position) in state.grain_position.iter().enumerate() {
            let centre = position.map(f64::from);
            if (0..3).all(|axis| centre[axis] >= low[axis] && centre[axis] <= high[axis]) {
                seen.push((self.sight.camera.see(centre), grain));
            }
        }
        // What is hidden later need not be lit.
        seen.sort_by(|a, b| a.0[2].total_cmp(&b.0[2]));
        for (centre, grain) in seen {
            let radius = stage.radius(state.id(grain));
            raster.sphere(centre, radius, stage.grain_colour(state, grain, speed_max));
        }
        raster.darken_gaps(stage.widest().max(f64::MIN_POSITIVE));
    }

    /// Speed of the velocity interpolated in the triangles of the cut, as far as they lie in the box.
    fn draw_speed(&self, raster: &mut Raster, stage: &Stage, state: &State, speed_max: f64) {
        let Some((mesh, nodal)) = state.flow(stage) else {
            return;
        };
        let colours = FluidColours::new(speed_max);
        let (low, high) = self.sight.shown;
        let height = cut_level(stage, state);
        let cut = Cut::of(mesh, 2, height);
        let velocity = cut.at(|node| nodal[node as usize].map(f64::from));
        for corners in &cut.triangles {
            let points = corners.map(|corner| cut.points[corner as usize]);
            let velocity = corners.map(|corner| velocity[corner as usize]);
            for (points, velocity) in within(points, velocity, low, high) {
                raster.triangle(
                    points.map(|point| self.sight.camera.see(point)),
                    velocity,
                    |speed| colours.of(speed),
                );
            }
        }
        let frame = [
            [low[0], low[1]],
            [high[0], low[1]],
            [high[0], high[1]],
            [low[0], high[1]],
        ];
        let frame = frame.map(|[x, y]| [x, y, height]);
        for side in 0..4 {
            raster.line(self.see([frame[side], frame[(side + 1) % 4]]), 1.0, GREY);
        }
    }
}

/// Where the plane z = … lies \[m\].
pub fn cut_level(stage: &Stage, state: &State) -> f64 {
    let (lower, upper) = stage.window;
    let grains = state.central_bounds().map(|(low, high)| (low[2], high[2]));
    level(grains, (lower[2], upper[2]))
}

/// A corner of a triangle and the velocity there.
type Corner = (Point<3>, Point<3>);

/// The part of a triangle inside a box's sides along x and y, as triangles (Sutherland and Hodgman).
fn within(
    points: [Point<3>; 3],
    velocity: [Point<3>; 3],
    low: Point<3>,
    high: Point<3>,
) -> Vec<([Point<3>; 3], [Point<3>; 3])> {
    let mut polygon: Vec<Corner> = points.into_iter().zip(velocity).collect();
    for axis in 0..2 {
        for (sign, bound) in [(1.0, low[axis]), (-1.0, -high[axis])] {
            let height = |corner: &Corner| sign * corner.0[axis] - bound;
            if polygon.iter().all(|corner| height(corner) >= 0.0) {
                continue;
            }
            let mut rest = Vec::with_capacity(polygon.len() + 1);
            for (index, to) in polygon.iter().enumerate() {
                let from = &polygon[(index + polygon.len() - 1) % polygon.len()];
                let (a, b) = (height(from), height(to));
                if (a < 0.0) != (b < 0.0) {
                    let share = a / (a - b);
                    let between = |from: Point<3>, to: Point<3>| {
                        std::array::from_fn(|k| from[k] + share * (to[k] - from[k]))
                    };
                    rest.push((between(from.0, to.0), between(from.1, to.1)));
                }
                if b >= 0.0 {
                    rest.push(*to);
                }
            }
            polygon = rest;
        }
    }
    let fan = (2..polygon.len()).map(|last| [0, last - 1, last].map(|corner| polygon[corner]));
    fan.map(|corners| (corners.map(|c| c.0), corners.map(|c| c.1)))
        .collect()
}
