//! Pixels, and text on them.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Once;

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{FontTransform, register_font};

use super::colour::{INK, PAPER, Rgb};
use run::file;
use scene::Error;

/// A picture in the making.
pub struct Canvas {
    /// Width \[pixels\].
    pub width: usize,
    /// Height \[pixels\].
    pub height: usize,
    pixels: Vec<u8>,
}

/// How text sits at its point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Anchor {
    /// Starts there; the point is at mid height.
    Left,
    /// Ends there; the point is at mid height.
    Right,
    /// Centred; the point is at the upper edge.
    Below,
    /// Centred; the point is at the lower edge.
    Above,
    /// Reads upwards; the point is in the middle.
    Upright,
}

impl Canvas {
    /// White paper.
    pub fn new(width: usize, height: usize) -> Self {
        register_sans();
        Canvas {
            width,
            height,
            pixels: PAPER.repeat(width * height),
        }
    }

    /// Its pixels, three bytes each, row by row.
    pub fn pixels_mut(&mut self) -> &mut [u8] {
        &mut self.pixels
    }

    /// Mix a colour into a pixel; outside the paper nothing happens.
    pub fn blend(&mut self, x: i64, y: i64, colour: Rgb, opacity: f64) {
        if x < 0 || y < 0 || x >= self.width as i64 || y >= self.height as i64 {
            return;
        }
        let start = 3 * (y as usize * self.width + x as usize);
        for (pixel, ink) in self.pixels[start..start + 3].iter_mut().zip(colour) {
            let mixed = f64::from(*pixel) * (1.0 - opacity) + f64::from(ink) * opacity;
            *pixel = mixed.round() as u8;
        }
    }

    /// A filled rectangle; `right` and `bottom` are outside it.
    pub fn fill(&mut self, left: i64, top: i64, right: i64, bottom: i64, colour: Rgb) {
        for y in top.max(0)..bottom.min(self.height as i64) {
            for x in left.max(0)..right.min(self.width as i64) {
                self.blend(x, y, colour, 1.0);
            }
        }
    }

    /// A straight line, its edges smoothed.
    pub fn line(&mut self, from: [f64; 2], to: [f64; 2], width: f64, colour: Rgb) {
        self.lines(&[(from, to)], width, colour);
    }

    /// Lines that may meet: where they overlap the ink is not doubled, so a boundary drawn edge by
    /// edge looks as if drawn in one.
    pub fn lines(&mut self, segments: &[([f64; 2], [f64; 2])], width: f64, colour: Rgb) {
        let mut covered: BTreeMap<(i64, i64), f64> = BTreeMap::new();
        for (from, to) in segments {
            self.each_covered(*from, *to, 0.5 * width, |x, y, cover| {
                let most = covered.entry((y, x)).or_default();
                *most = most.max(cover);
            });
        }
        for ((y, x), cover) in covered {
            self.blend(x, y, colour, cover);
        }
    }

    /// The pixels that a line of this half width covers, and how much of them.
    fn each_covered(
        &self,
        from: [f64; 2],
        to: [f64; 2],
        half: f64,
        mut visit: impl FnMut(i64, i64, f64),
    ) {
        let low = |axis: usize| (from[axis].min(to[axis]) - half - 1.0).floor() as i64;
        let high = |axis: usize| (from[axis].max(to[axis]) + half + 1.0).ceil() as i64;
        let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
        let square = (dx * dx + dy * dy).max(f64::MIN_POSITIVE);
        for y in low(1).max(0)..=high(1).min(self.height as i64 - 1) {
            for x in low(0).max(0)..=high(0).min(self.width as i64 - 1) {
                let (px, py) = (x as f64 + 0.5 - from[0], y as f64 + 0.5 - from[1]);
                let along = ((px * dx + py * dy) / square).clamp(0.0, 1.0);
                let distance = (px - along * dx).hypot(py - along * dy);
                let cover = (half + 0.5 - distance).clamp(0.0, 1.0);
                if cover > 0.0 {
                    visit(x, y, cover);
                }
            }
        }
    }

    /// A filled disk, as far as it lies between two corners of the paper. Below a pixel it stays visible and
    /// pales with its area instead.
    pub fn disk(&mut self, centre: [f64; 2], radius: f64, colour: Rgb, within: [[f64; 2]; 2]) {
        let drawn = radius.max(0.55);
        let opacity = if radius < drawn {
            (radius / drawn).powi(2).max(0.65)
        } else {
            1.0
        };
        let size = [self.width, self.height];
        let range = |axis: usize| {
            let low = (centre[axis] - drawn - 1.0).max(within[0][axis]).max(0.0);
            let high = (centre[axis] + drawn + 1.0).min(within[1][axis]);
            low.floor() as i64..(high.ceil() as i64).clamp(0, size[axis] as i64)
        };
        for y in range(1) {
            for x in range(0) {
                let distance = (x as f64 + 0.5 - centre[0]).hypot(y as f64 + 0.5 - centre[1]);
                let cover = (drawn + 0.5 - distance).clamp(0.0, 1.0);
                if cover > 0.0 {
                    self.blend(x, y, colour, cover * opacity);
                }
            }
        }
    }

    /// A line of text in `INK`.
    pub fn text(&mut self, text: &str, at: [f64; 2], size: f64, anchor: Anchor) {
        let (horizontal, vertical) = match anchor {
            Anchor::Left => (HPos::Left, VPos::Center),
            Anchor::Right => (HPos::Right, VPos::Center),
            Anchor::Below => (HPos::Center, VPos::Top),
            Anchor::Above => (HPos::Center, VPos::Bottom),
            Anchor::Upright => (HPos::Center, VPos::Center),
        };
        let font = ("sans-serif", size).into_font();
        let font = match anchor {
            Anchor::Upright => font.transform(FontTransform::Rotate270),
            _ => font,
        };
        let style = TextStyle::from(font)
            .color(&RGBColor(INK[0], INK[1], INK[2]))
            .pos(Pos::new(horizontal, vertical));
        let size = (self.width as u32, self.height as u32);
        let area = BitMapBackend::with_buffer(&mut self.pixels, size).into_drawing_area();
        // Text outside the paper, or a glyph the font lacks, must not end a run.
        let _ = area.draw_text(text, &style, (at[0].round() as i32, at[1].round() as i32));
    }

    /// Write the picture as PNG.
    pub fn save(&self, path: &Path) -> Result<(), Error> {
        file::write(path, self.png(path)?)
    }

    /// The picture as PNG, as it goes to this path.
    pub fn png(&self, path: &Path) -> Result<Vec<u8>, Error> {
        let draw = |why: png::EncodingError| Error::Picture {
            path: path.into(),
            why: why.to_string(),
        };
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, self.width as u32, self.height as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        let mut writer = encoder.write_header().map_err(draw)?;
        writer.write_image_data(&self.pixels).map_err(draw)?;
        writer.finish().map_err(draw)?;
        Ok(bytes)
    }
}

/// The embedded font: pictures are the same on every machine.
/// Make the embedded font known to plotters.
pub fn register_sans() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        // The bytes are a constant of the program, so they are a font.
        let _ = register_font("sans-serif", FontStyle::Normal, dejavu::sans::regular());
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_disk_of_any_size_takes_the_time_of_its_window_and_stays_in_it() {
        let mut canvas = Canvas::new(100, 50);
        let begun = std::time::Instant::now();
        canvas.disk([20.0, 20.0], 1e12, INK, [[10.0, 10.0], [30.0, 40.0]]);
        canvas.disk([1e300, -1e300], 1e200, INK, [[0.0; 2], [100.0, 50.0]]);
        canvas.fill(i64::MIN, i64::MAX - 1, i64::MAX, i64::MAX, INK);
        assert!(begun.elapsed() < std::time::Duration::from_secs(1));
        let inked = canvas.pixels.chunks_exact(3).filter(|pixel| *pixel == INK);
        assert_eq!(inked.count(), 20 * 30);
    }
}
