//! Units, ticks, labels and the colour bar.

use super::canvas::{Anchor, Canvas};
use super::colour::{self, INK, Rgb};

/// Size of numbers and labels \[pixels\].
pub const TEXT: f64 = 22.0;

/// A unit for numbers of this size: its name and what it is in the base unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unit {
    /// "mm", "mm/s", …
    pub name: &'static str,
    /// 1e-3 for mm.
    pub size: f64,
}

/// Unit of lengths for a window of this extent \[m\].
pub fn length_unit(extent: f64) -> Unit {
    match extent {
        e if e < 5e-4 => Unit {
            name: "µm",
            size: 1e-6,
        },
        e if e < 0.5 => Unit {
            name: "mm",
            size: 1e-3,
        },
        _ => Unit {
            name: "m",
            size: 1.0,
        },
    }
}

/// Unit of speeds up to this one \[m/s\].
pub fn speed_unit(largest: f64) -> Unit {
    match largest {
        s if s > 0.0 && s < 5e-4 => Unit {
            name: "µm/s",
            size: 1e-6,
        },
        s if s < 0.5 => Unit {
            name: "mm/s",
            size: 1e-3,
        },
        _ => Unit {
            name: "m/s",
            size: 1.0,
        },
    }
}

/// The smallest round number that is not below `value`.
pub fn round_up(value: f64) -> f64 {
    if !(value > 0.0 && value.is_finite()) {
        return 0.0;
    }
    let decade = 10f64.powf(value.log10().floor());
    [1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 10.0]
        .into_iter()
        .map(|step| step * decade)
        .find(|round| *round >= value * (1.0 - 1e-9))
        .unwrap_or(10.0 * decade)
}

/// Round numbers between two bounds, about `count` of them.
pub fn ticks(low: f64, high: f64, count: f64) -> Vec<f64> {
    let rough = (high - low) / count.max(1.0);
    if !(rough > 0.0 && rough.is_finite()) {
        return Vec::new();
    }
    let decade = 10f64.powf(rough.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0]
        .into_iter()
        .map(|step| step * decade)
        .find(|step| *step >= rough * (1.0 - 1e-9))
        .unwrap_or(10.0 * decade);
    let first = (low / step - 1e-9).ceil() as i64;
    let last = (high / step + 1e-9).floor() as i64;
    (first..=last).map(|index| index as f64 * step).collect()
}

/// A tick's number, without needless digits.
pub fn number(value: f64) -> String {
    let text = format!("{value:.6}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" {
        "0".into()
    } else {
        text.replace('-', "−")
    }
}

/// "t = 0.055 s", or in ms when the time is short.
pub fn time_label(time: f64) -> String {
    if time > 0.0 && time < 0.01 {
        return format!("t = {:.3} ms", 1e3 * time);
    }
    format!("t = {time:.3} s")
}

/// A round length for a scale bar beside a window of this extent \[m\], and its label.
pub fn scale_length(extent: f64) -> (f64, String) {
    let unit = length_unit(extent);
    let decade = 10f64.powf((extent / unit.size).log10().floor());
    let length = [5.0, 2.0, 1.0, 0.5, 0.2, 0.1]
        .into_iter()
        .map(|step| step * decade)
        .find(|length| *length * unit.size <= 0.3 * extent)
        .unwrap_or(0.1 * decade);
    let label = format!("{} {}", number(length), unit.name);
    (length * unit.size, label)
}

/// What colours mean: a map, its largest speed, its name.
pub struct ColourBar<'a> {
    /// "fluid speed" or "grain speed".
    pub label: &'a str,
    /// Largest speed \[m/s\].
    pub speed_max: f64,
    /// Colour of a share between 0 and 1.
    pub map: fn(f64) -> Rgb,
}

impl<'a> ColourBar<'a> {
    /// The bar of a scene with a fluid, or of dry grains.
    pub fn of(has_fluid: bool, speed_max: f64) -> ColourBar<'a> {
        match has_fluid {
            true => ColourBar {
                label: "fluid speed",
                speed_max,
                map: colour::fluid,
            },
            false => ColourBar {
                label: "grain speed",
                speed_max,
                map: colour::dry,
            },
        }
    }

    /// Draw it upright.
    pub fn draw(&self, canvas: &mut Canvas, left: f64, top: f64, height: f64) {
        let (x, y) = (left as i64, top as i64);
        for row in 0..height as i64 {
            let share = 1.0 - row as f64 / height;
            canvas.fill(x, y + row, x + 24, y + row + 1, (self.map)(share));
        }
        let (right, bottom) = (left + 24.0, top + height);
        for (from, to) in [
            ([left, top], [right, top]),
            ([right, top], [right, bottom]),
            ([right, bottom], [left, bottom]),
            ([left, bottom], [left, top]),
        ] {
            canvas.line(from, to, 1.2, INK);
        }
        let unit = speed_unit(self.speed_max);
        let largest = self.speed_max / unit.size;
        let marks = if largest > 0.0 {
            ticks(0.0, largest, (height / 80.0).max(2.0))
        } else {
            vec![0.0]
        };
        for mark in marks {
            let share = if largest > 0.0 { mark / largest } else { 0.0 };
            let level = bottom - share * height;
            canvas.line([right, level], [right + 6.0, level], 1.5, INK);
            canvas.text(&number(mark), [right + 11.0, level], TEXT, Anchor::Left);
        }
        let label = format!("{} [{}]", self.label, unit.name);
        canvas.text(
            &label,
            [right + 88.0, top + 0.5 * height],
            TEXT,
            Anchor::Upright,
        );
    }
}
