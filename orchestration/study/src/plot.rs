//! Plots of a study, each as SVG and PNG: error against size, with slopes, and error against CPU
//! time, with the Pareto front. Both axes are logarithmic.

use std::path::Path;

use plotters::coord::Shift;
use plotters::prelude::*;

use crate::analysis;
use crate::keys::StudyFile;
use crate::results::{self, Row};
use run::file;
use scene::Error;
use show::picture::canvas::{Canvas, register_sans};

/// Names of the plots without ending, and what they are called.
pub const FILES: [(&str, &str); 2] = [
    ("convergence", "Error against size"),
    ("cost", "Error against CPU time"),
];

const SIZE: (u32, u32) = (1200, 800);
const INKS: [RGBColor; 10] = [
    RGBColor(20, 99, 156),
    RGBColor(196, 81, 15),
    RGBColor(42, 127, 79),
    RGBColor(138, 75, 176),
    RGBColor(122, 106, 18),
    RGBColor(176, 42, 91),
    RGBColor(0, 150, 136),
    RGBColor(84, 84, 84),
    RGBColor(222, 150, 0),
    RGBColor(58, 58, 160),
];

struct Line {
    label: String,
    points: Vec<(f64, f64)>,
}

struct Plot {
    across: String,
    up: String,
    lines: Vec<Line>,
    /// One for each problem that is compared.
    fronts: Vec<Vec<(f64, f64)>>,
    legend: SeriesLabelPosition,
}

/// Write the plots that have something to show; others that lie there are removed.
pub fn write(folder: &Path, study: &StudyFile, rows: &[Row]) -> Result<(), Error> {
    register_sans();
    for (index, (name, _)) in FILES.iter().enumerate() {
        let plot = plot(study, rows, index == 1);
        for ending in ["svg", "png"] {
            let path = folder.join(format!("{name}.{ending}"));
            let shown = plot
                .lines
                .iter()
                .map(|line| line.points.len())
                .sum::<usize>();
            if shown < 2 {
                let _ = std::fs::remove_file(&path);
                continue;
            }
            let failed = |why: String| Error::Picture {
                path: path.clone(),
                why,
            };
            if ending == "svg" {
                let mut text = String::new();
                draw(
                    &SVGBackend::with_string(&mut text, SIZE).into_drawing_area(),
                    &plot,
                )
                .map_err(failed)?;
                file::write(&path, text)?;
            } else {
                let mut canvas = Canvas::new(SIZE.0 as usize, SIZE.1 as usize);
                let pixels = canvas.pixels_mut();
                draw(
                    &BitMapBackend::with_buffer(pixels, SIZE).into_drawing_area(),
                    &plot,
                )
                .map_err(failed)?;
                canvas.save(&path)?;
            }
        }
    }
    Ok(())
}

fn plot(study: &StudyFile, rows: &[Row], against_cost: bool) -> Plot {
    let measure = &study.measure;
    let has_errors = rows.iter().any(|row| row.error.is_some());
    let height = |row: &Row| {
        if has_errors {
            row.error
        } else {
            Some(row.value)
        }
    };
    let place = |row: &Row| {
        let across = if against_cost {
            Some(row.cost.cpu_total)
        } else {
            row.size
        };
        let point = across.zip(height(row))?;
        (point.0 > 0.0 && point.1 > 0.0 && point.0.is_finite()).then_some(point)
    };
    let lines = rows
        .chunks(study.axis[0].points.len())
        .map(|series| {
            let points: Vec<(f64, f64)> = series.iter().filter_map(place).collect();
            let mut label = series[0].names[1..].join(", ");
            if label.is_empty() {
                label = measure.name.clone();
            }
            if let Some(slope) =
                analysis::slope(&points).filter(|_| !against_cost && study.axis[0].orders)
            {
                label += &format!(" (slope {slope:.2})");
            }
            Line { label, points }
        })
        .collect();
    let front = |group: Vec<usize>| {
        let rows = group.into_iter().map(|index| &rows[index]);
        let mut front: Vec<(f64, f64)> = rows
            .filter(|row| against_cost && row.front)
            .filter_map(place)
            .collect();
        front.sort_by(|a, b| a.0.total_cmp(&b.0));
        front
    };
    let fronts = results::comparable(study).into_iter().map(front).collect();
    Plot {
        across: if against_cost {
            "CPU time of all processes [s]".into()
        } else {
            study.axis[0].name.clone()
        },
        up: match (has_errors, measure.unit.as_str()) {
            (true, _) => format!("relative error of {}", measure.name),
            (false, "") => measure.name.clone(),
            (false, unit) => format!("{} [{unit}]", measure.name),
        },
        lines,
        fronts,
        // Where lines that rise with size, or fall with cost, leave room.
        legend: if against_cost {
            SeriesLabelPosition::UpperRight
        } else {
            SeriesLabelPosition::UpperLeft
        },
    }
}

/// A little beyond the extremes, at least half a decade.
fn range(values: impl Iterator<Item = f64>) -> std::ops::Range<f64> {
    let (low, high) = values.fold((f64::MAX, f64::MIN), |(low, high), v| {
        (low.min(v), high.max(v))
    });
    let room = (high / low).powf(0.08).max(1.35);
    low / room..high * room
}

fn draw<B: DrawingBackend>(root: &DrawingArea<B, Shift>, plot: &Plot) -> Result<(), String> {
    let text = |error: DrawingAreaErrorKind<B::ErrorType>| error.to_string();
    let all = || {
        plot.lines
            .iter()
            .flat_map(|line| line.points.iter().copied())
    };
    root.fill(&WHITE).map_err(text)?;
    let mut chart = ChartBuilder::on(root)
        .margin(24)
        .x_label_area_size(70)
        .y_label_area_size(110)
        .build_cartesian_2d(
            range(all().map(|p| p.0)).log_scale(),
            range(all().map(|p| p.1)).log_scale(),
        )
        .map_err(text)?;
    chart
        .configure_mesh()
        .x_desc(plot.across.as_str())
        .y_desc(plot.up.as_str())
        .label_style(("sans-serif", 24))
        .axis_desc_style(("sans-serif", 26))
        .x_label_formatter(&|v| number(*v))
        .y_label_formatter(&|v| number(*v))
        .bold_line_style(RGBColor(214, 219, 223))
        .light_line_style(RGBColor(238, 241, 243))
        .draw()
        .map_err(text)?;
    let broad = RGBColor(150, 158, 166).stroke_width(8);
    let fronts = plot.fronts.iter().filter(|front| front.len() > 1);
    for (index, front) in fronts.enumerate() {
        let line = chart
            .draw_series(LineSeries::new(front.iter().copied(), broad))
            .map_err(text)?;
        if index == 0 {
            line.label("Pareto front")
                .legend(move |(x, y)| PathElement::new(vec![(x, y), (x + 26, y)], broad));
        }
    }
    for (index, line) in plot
        .lines
        .iter()
        .filter(|line| !line.points.is_empty())
        .enumerate()
    {
        let ink = INKS[index % INKS.len()];
        chart
            .draw_series(LineSeries::new(
                line.points.iter().copied(),
                ink.stroke_width(3),
            ))
            .map_err(text)?
            .label(line.label.as_str())
            .legend(move |(x, y)| PathElement::new(vec![(x, y), (x + 26, y)], ink.stroke_width(4)));
        let dots = line
            .points
            .iter()
            .map(|point| Circle::new(*point, 6, ink.filled()));
        chart.draw_series(dots).map_err(text)?;
    }
    chart
        .configure_series_labels()
        .background_style(WHITE.mix(0.85))
        .border_style(RGBColor(214, 219, 223))
        .label_font(("sans-serif", 24))
        .legend_area_size(40)
        .position(plot.legend.clone())
        .draw()
        .map_err(text)?;
    root.present().map_err(text)
}

fn number(value: f64) -> String {
    if (1e-2..1e4).contains(&value) {
        let text = format!("{value:.6}");
        text.trim_end_matches('0').trim_end_matches('.').to_string()
    } else {
        format!("{value:.0e}")
    }
}
