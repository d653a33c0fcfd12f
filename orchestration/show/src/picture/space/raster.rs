//! Samples of a picture with their depths: of what lies behind one another the nearest is seen.

use crate::picture::canvas::Canvas;
use crate::picture::colour::{PAPER, Rgb};
use crate::simplices::Point;

/// Samples of a pixel along either side: edges are as smooth.
const SAMPLES: usize = 3;
/// Where the light comes from: left, above, behind the camera.
const LIGHT: Point<3> = [-0.43, 0.62, 0.656];
/// What of a thing is seen through the plane before it.
const SEEN_THROUGH: f64 = 0.3;
/// Depth of a line over that of where it lies, so that it stays on the surfaces that it bounds.
const NEARER: f64 = 0.999;

/// A part of the paper. Points come as the camera has them: right, up, depth \[m\].
pub struct Raster {
    columns: usize,
    rows: usize,
    /// Slopes of the left and the upper edge: right and up over depth.
    corner: [f64; 2],
    /// Samples a unit of slope.
    scale: f64,
    colour: Vec<Rgb>,
    depth: Vec<f32>,
}

impl Raster {
    /// Paper of so many pixels, whose upper left corner shows these slopes, `scale` pixels a unit.
    pub fn new(width: usize, height: usize, corner: [f64; 2], scale: f64) -> Raster {
        let (columns, rows) = (width * SAMPLES, height * SAMPLES);
        Raster {
            columns,
            rows,
            corner,
            scale: scale * SAMPLES as f64,
            colour: vec![PAPER; columns * rows],
            depth: vec![f32::INFINITY; columns * rows],
        }
    }

    /// Samples of a range of slopes along one axis, as far as they lie on the paper.
    fn span(&self, axis: usize, low: f64, high: f64) -> std::ops::Range<usize> {
        let (low, high, count) = match axis {
            0 => (low - self.corner[0], high - self.corner[0], self.columns),
            _ => (self.corner[1] - high, self.corner[1] - low, self.rows),
        };
        // `as` takes what lies outside to the nearest end.
        let start = (low * self.scale).floor() as usize;
        let end = (high * self.scale).ceil() as usize;
        start.min(count)..end.min(count)
    }

    /// Slopes of the middle of a sample.
    fn slopes(&self, column: usize, row: usize) -> [f64; 2] {
        [
            self.corner[0] + (column as f64 + 0.5) / self.scale,
            self.corner[1] - (row as f64 + 0.5) / self.scale,
        ]
    }

    /// A sphere in the light; smaller than a pixel it stays visible.
    ///
    /// A sample looks along d = (right, up, 1), and sees the sphere about c at the smaller root of |t d − c| = r.
    pub fn sphere(&mut self, c: Point<3>, radius: f64, colour: Rgb) {
        let r = radius.max(0.6 * SAMPLES as f64 * c[2] / self.scale);
        let room = c[2] * c[2] - r * r;
        if c[2] <= r {
            return;
        }
        // Slopes of the tangents.
        let range = |x: f64| {
            let root = r * (x * x + room).sqrt();
            ((x * c[2] - root) / room, (x * c[2] + root) / room)
        };
        let ((left, right), (low, high)) = (range(c[0]), range(c[1]));
        let (columns, rows) = (self.span(0, left, right), self.span(1, low, high));
        let free = c[0] * c[0] + c[1] * c[1] + room;
        for row in rows {
            for column in columns.clone() {
                let [x, y] = self.slopes(column, row);
                let (square, along) = (x * x + y * y + 1.0, x * c[0] + y * c[1] + c[2]);
                let root = along * along - square * free;
                if root < 0.0 {
                    continue;
                }
                let t = (along - root.sqrt()) / square;
                let place = row * self.columns + column;
                if t < f64::from(self.depth[place]) {
                    let normal = [(t * x - c[0]) / r, (t * y - c[1]) / r, (c[2] - t) / r];
                    self.depth[place] = t as f32;
                    self.colour[place] = lit(colour, normal);
                }
            }
        }
    }

    /// Darken what lies deeper than its neighbours, by depths of about `size` \[m\]: gaps between spheres, and those below.
    pub fn darken_gaps(&mut self, size: f64) {
        const REACH: usize = SAMPLES + 2;
        let per_depth = (1.0 / (4.0 * size)) as f32;
        let columns = self.columns;
        let shade = |place: usize| {
            let own = self.depth[place];
            let around = [
                place - REACH,
                place + REACH,
                place - REACH * columns,
                place + REACH * columns,
                place - REACH * columns - REACH,
                place - REACH * columns + REACH,
                place + REACH * columns - REACH,
                place + REACH * columns + REACH,
            ];
            let hidden =
                around.map(|other| ((own - self.depth[other]) * per_depth).clamp(0.0, 1.0));
            1.0 - 0.55 * hidden.iter().sum::<f32>() / 8.0
        };
        let mut shaded = self.colour.clone();
        for row in REACH..self.rows.saturating_sub(REACH) {
            for place in row * columns + REACH..(row + 1) * columns - REACH.min(columns) {
                if self.depth[place].is_finite() {
                    let shade = shade(place);
                    shaded[place] = shaded[place].map(|channel| (f32::from(channel) * shade) as u8);
                }
            }
        }
        self.colour = shaded;
    }

    /// A triangle of a plane with a velocity at each corner; `paint` is the colour of a speed. It lies on paper as
    /// it is, and lets what is behind it shine through.
    pub fn triangle(
        &mut self,
        corners: [Point<3>; 3],
        velocity: [Point<3>; 3],
        paint: impl Fn(f64) -> Rgb,
    ) {
        let seen = corners.map(|c| [c[0] / c[2], c[1] / c[2]]);
        let [a, b, c] = seen;
        let twice = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
        if twice == 0.0 {
            return;
        }
        let low = |axis: usize| a[axis].min(b[axis]).min(c[axis]);
        let high = |axis: usize| a[axis].max(b[axis]).max(c[axis]);
        let columns = self.span(0, low(0), high(0));
        // Shares of the first two corners, linear along a row.
        let step = [(b[1] - c[1]) / twice, (c[1] - a[1]) / twice];
        for row in self.span(1, low(1), high(1)) {
            let [x, y] = self.slopes(0, row);
            let start = [
                ((b[0] - x) * (c[1] - y) - (c[0] - x) * (b[1] - y)) / twice,
                ((c[0] - x) * (a[1] - y) - (a[0] - x) * (c[1] - y)) / twice,
            ];
            for column in columns.clone() {
                let way = column as f64 / self.scale;
                let (first, second) = (start[0] + way * step[0], start[1] + way * step[1]);
                let third = 1.0 - first - second;
                // A hair of overlap closes the seams between triangles.
                if first < -1e-7 || second < -1e-7 || third < -1e-7 {
                    continue;
                }
                // Linear in space is linear over the depth on paper.
                let weights = [
                    first / corners[0][2],
                    second / corners[1][2],
                    third / corners[2][2],
                ];
                let depth = 1.0 / (weights[0] + weights[1] + weights[2]);
                let place = row * self.columns + column;
                let behind = f64::from(self.depth[place]);
                // A neighbour was here already where the seams overlap.
                if depth >= behind * (1.0 - 1e-5) {
                    continue;
                }
                let along =
                    |k: usize| (0..3).map(|c| weights[c] * velocity[c][k]).sum::<f64>() * depth;
                let speed = (along(0).powi(2) + along(1).powi(2) + along(2).powi(2)).sqrt();
                let colour = paint(speed);
                self.colour[place] = match behind.is_finite() {
                    true => mix(colour, self.colour[place], SEEN_THROUGH),
                    false => colour,
                };
                self.depth[place] = depth as f32;
            }
        }
    }

    /// A straight line of this width \[pixels\].
    pub fn line(&mut self, [from, to]: [Point<3>; 2], width: f64, colour: Rgb) {
        let place = |p: Point<3>| {
            let (x, y) = (p[0] / p[2] - self.corner[0], self.corner[1] - p[1] / p[2]);
            [x * self.scale, y * self.scale]
        };
        let ([a, b], sizes) = ([place(from), place(to)], [self.columns, self.rows]);
        let way = [b[0] - a[0], b[1] - a[1]];
        // Step along the axis that it is longer in, and be as wide across the other.
        let long = usize::from(way[1].abs() > way[0].abs());
        if way[long] == 0.0 {
            return;
        }
        let tilt = way[1 - long] / way[long];
        let half = 0.5 * width * SAMPLES as f64 * (1.0 + tilt * tilt).sqrt();
        let (start, end) = (a[long].min(b[long]), a[long].max(b[long]));
        for step in start.floor().max(0.0) as usize..(end.ceil().max(0.0) as usize).min(sizes[long])
        {
            let share = ((step as f64 + 0.5 - a[long]) / way[long]).clamp(0.0, 1.0);
            let depth = NEARER / ((1.0 - share) / from[2] + share / to[2]);
            let middle = a[1 - long] + share * way[1 - long];
            let first = (middle - half).round().max(0.0) as usize;
            let last = ((middle + half).round().max(0.0) as usize).min(sizes[1 - long]);
            for across in first..last {
                let place = match long {
                    0 => across * self.columns + step,
                    _ => step * self.columns + across,
                };
                if depth < f64::from(self.depth[place]) {
                    self.depth[place] = depth as f32;
                    self.colour[place] = colour;
                }
            }
        }
    }

    /// Put it on a canvas, each pixel the mean of its samples; its upper left corner at this pixel.
    pub fn lay_on(&self, canvas: &mut Canvas, left: usize, top: usize) {
        let (width, height) = (canvas.width, canvas.height);
        let pixels = canvas.pixels_mut();
        for y in 0..(self.rows / SAMPLES).min(height.saturating_sub(top)) {
            for x in 0..(self.columns / SAMPLES).min(width.saturating_sub(left)) {
                let mut sum = [0_usize; 3];
                for row in y * SAMPLES..(y + 1) * SAMPLES {
                    let start = row * self.columns + x * SAMPLES;
                    for sample in &self.colour[start..start + SAMPLES] {
                        (0..3).for_each(|k| sum[k] += usize::from(sample[k]));
                    }
                }
                let start = 3 * ((top + y) * width + left + x);
                let count = SAMPLES * SAMPLES;
                let mean = sum.map(|sum| ((sum + count / 2) / count) as u8);
                pixels[start..start + 3].copy_from_slice(&mean);
            }
        }
    }
}

/// A colour in the light; the normal points at the camera where its third component is 1.
fn lit(colour: Rgb, normal: Point<3>) -> Rgb {
    let light = (0..3).map(|k| normal[k] * LIGHT[k]).sum::<f64>();
    // Half-way between the light and the eye the surface shines.
    let half = [LIGHT[0], LIGHT[1], LIGHT[2] + 1.0];
    let size = (half[0] * half[0] + half[1] * half[1] + half[2] * half[2]).sqrt();
    let toward = (0..3).map(|k| normal[k] * half[k]).sum::<f64>() / size;
    let shine = 0.28 * toward.max(0.0).powi(24);
    let diffuse = 0.46 + 0.66 * light.max(0.0);
    colour.map(|channel| {
        let shaded = (f64::from(channel) * diffuse).min(255.0);
        (shaded + shine * (255.0 - shaded)) as u8
    })
}

fn mix(front: Rgb, back: Rgb, share: f64) -> Rgb {
    std::array::from_fn(|k| {
        let (front, back) = (f64::from(front[k]), f64::from(back[k]));
        (front + share * (back - front)).round() as u8
    })
}
