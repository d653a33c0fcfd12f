//! A window of the plane on a rectangle of the paper, and what is drawn through it.

use super::{Stage, State};
use crate::picture::canvas::Canvas;
use crate::picture::colour::{FluidColours, INK, Rgb};
use crate::simplices::clip;

/// Where a window of the plane lies on the paper.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    /// Lower left corner of the window \[m\].
    pub lower: [f64; 2],
    /// Upper right corner of the window \[m\].
    pub upper: [f64; 2],
    /// Left edge on the paper \[pixels\].
    pub left: f64,
    /// Upper edge on the paper \[pixels\].
    pub top: f64,
    /// Pixels a metre, in x and y alike.
    pub scale: f64,
}

impl View {
    /// Width on the paper \[pixels\].
    pub fn width(&self) -> f64 {
        (self.upper[0] - self.lower[0]) * self.scale
    }

    /// Height on the paper \[pixels\].
    pub fn height(&self) -> f64 {
        (self.upper[1] - self.lower[1]) * self.scale
    }

    /// Right edge \[pixels\].
    pub fn right(&self) -> f64 {
        self.left + self.width()
    }

    /// Lower edge \[pixels\].
    pub fn bottom(&self) -> f64 {
        self.top + self.height()
    }

    /// A point of the plane on the paper.
    pub fn place(&self, point: [f64; 2]) -> [f64; 2] {
        [
            self.left + (point[0] - self.lower[0]) * self.scale,
            self.top + (self.upper[1] - point[1]) * self.scale,
        ]
    }

    /// Draw a state: speed of the fluid, boundaries, grains; `speed_max` is the deepest colour.
    pub fn draw(&self, canvas: &mut Canvas, stage: &Stage, state: &State, speed_max: f64) {
        if stage.mesh.is_some() {
            self.draw_speed(canvas, stage, state, speed_max);
        }
        self.draw_grains(canvas, stage, state, speed_max);
        let visible: Vec<_> = stage
            .outlines
            .iter()
            .filter_map(|[a, b]| clip(*a, *b, self.lower, self.upper))
            .map(|(a, b)| (self.place(a), self.place(b)))
            .collect();
        canvas.lines(&visible, 2.0, INK);
    }

    /// The window's edge.
    pub fn outline(&self, canvas: &mut Canvas, width: f64, colour: Rgb) {
        let (l, r, t, b) = (self.left, self.right(), self.top, self.bottom());
        for (from, to) in [
            ([l, t], [r, t]),
            ([r, t], [r, b]),
            ([r, b], [l, b]),
            ([l, b], [l, t]),
        ] {
            canvas.line(from, to, width, colour);
        }
    }

    fn contains_pixel(&self, x: f64, y: f64) -> bool {
        x >= self.left && x <= self.right() && y >= self.top && y <= self.bottom()
    }

    /// Every pixel inside a triangle gets the speed of the velocity interpolated to its centre.
    fn draw_speed(&self, canvas: &mut Canvas, stage: &Stage, state: &State, speed_max: f64) {
        let Some((mesh, nodal)) = state.flow(stage) else {
            return;
        };
        let colours = FluidColours::new(speed_max);
        for triangle in &mesh.simplices {
            let corners = triangle.map(|point| self.place(mesh.points[point as usize]));
            let velocity = triangle.map(|point| {
                let node = mesh.node_of[point as usize] as usize;
                nodal[node].map(f64::from)
            });
            self.each_pixel(corners, |x, y, weights| {
                let along =
                    |axis: usize| (0..3).map(|c| weights[c] * velocity[c][axis]).sum::<f64>();
                let speed = along(0).hypot(along(1));
                canvas.blend(x, y, colours.of(speed), 1.0);
            });
        }
    }

    /// Call `paint` for each pixel of the window whose centre lies in the triangle, with the
    /// barycentric coordinates of that centre.
    fn each_pixel(&self, corners: [[f64; 2]; 3], mut paint: impl FnMut(i64, i64, [f64; 3])) {
        let [a, b, c] = corners;
        let twice_area = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
        if twice_area == 0.0 {
            return;
        }
        let low = |axis: usize| a[axis].min(b[axis]).min(c[axis]);
        let high = |axis: usize| a[axis].max(b[axis]).max(c[axis]);
        let columns =
            low(0).max(self.left).floor() as i64..=high(0).min(self.right()).ceil() as i64;
        for y in low(1).max(self.top).floor() as i64..=high(1).min(self.bottom()).ceil() as i64 {
            for x in columns.clone() {
                let (px, py) = (x as f64 + 0.5, y as f64 + 0.5);
                let first = ((b[0] - px) * (c[1] - py) - (c[0] - px) * (b[1] - py)) / twice_area;
                let second = ((c[0] - px) * (a[1] - py) - (a[0] - px) * (c[1] - py)) / twice_area;
                let third = 1.0 - first - second;
                // A hair of overlap closes the seams between triangles.
                let inside = first >= -1e-9 && second >= -1e-9 && third >= -1e-9;
                if inside && self.contains_pixel(px, py) {
                    paint(x, y, [first, second, third]);
                }
            }
        }
    }

    fn draw_grains(&self, canvas: &mut Canvas, stage: &Stage, state: &State, speed_max: f64) {
        let window = [[self.left, self.top], [self.right(), self.bottom()]];
        for (index, position) in state.grain_position.iter().enumerate() {
            let centre = self.place(position.map(f64::from));
            let colour = stage.grain_colour(state, index, speed_max);
            // Touching grains stay apart to the eye.
            let pixels = stage.radius(state.id(index)) * self.scale;
            canvas.disk(
                centre,
                if pixels > 3.0 { pixels - 0.4 } else { pixels },
                colour,
                window,
            );
        }
    }
}
