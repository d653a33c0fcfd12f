//! Heat maps: the schemes of a map side by side, as SVG and PNG.
//!
//! A stable cell is pale, the paler the closer to the closed form; a failed one is dark with the letter
//! of how it failed: lightness alone tells them apart. The number in a stable cell is its mean count
//! of passes, where it is not one.

use std::path::Path;

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use crate::results::{Cell, MapResult};
use crate::schemes::DEFAULT;
use crate::verdict::Verdict;
use run::file;
use scene::Error;
use show::picture::canvas::{Canvas, register_sans};

const CELL: (i32, i32) = (44, 34);
const GAP: i32 = 26;
const TOP: i32 = 84;
const BOTTOM: i32 = 150;
const RIGHT: i32 = 24;
/// Beside the legend.
const MARGIN: i32 = 16;
const INK: RGBColor = RGBColor(33, 37, 41);
const GREY: RGBColor = RGBColor(134, 142, 150);
/// Nothing was run here.
const EMPTY: RGBColor = RGBColor(250, 250, 250);

/// Write `heat/MAP.svg` and `heat/MAP.png` of every map.
pub fn write(folder: &Path, results: &[MapResult]) -> Result<(), Error> {
    register_sans();
    let folder = folder.join("heat");
    std::fs::create_dir_all(&folder).map_err(Error::file("cannot create", &folder))?;
    for map in results {
        let size = size(map);
        let path = folder.join(map.name).with_extension("svg");
        let failed = |path: &Path, why: String| Error::Picture {
            path: path.to_path_buf(),
            why,
        };
        let mut text = String::new();
        draw(
            &SVGBackend::with_string(&mut text, size).into_drawing_area(),
            map,
        )
        .map_err(|why| failed(&path, why))?;
        file::write(&path, text)?;
        let path = path.with_extension("png");
        let mut canvas = Canvas::new(size.0 as usize, size.1 as usize);
        draw(
            &BitMapBackend::with_buffer(canvas.pixels_mut(), size).into_drawing_area(),
            map,
        )
        .map_err(|why| failed(&path, why))?;
        canvas.save(&path)?;
    }
    Ok(())
}

/// Room for the labels of the axis up.
fn left(map: &MapResult) -> i32 {
    let longest = map
        .up
        .labels
        .iter()
        .map(|label| label.chars().count())
        .max()
        .unwrap_or(0);
    64 + 8 * longest as i32
}

fn panel(map: &MapResult) -> (i32, i32) {
    let (columns, rows) = (map.across.labels.len() as i32, map.up.labels.len() as i32);
    (columns * CELL.0, rows * CELL.1)
}

fn size(map: &MapResult) -> (u32, u32) {
    let (width, height) = panel(map);
    let panels = map.schemes().len() as i32;
    let wide = (left(map) + panels * width + (panels - 1) * GAP + RIGHT).max(980);
    let rows = failures(wide).last().map_or(0, |(_, (_, row))| *row);
    let high = TOP + height + BOTTOM + rows * (CELL.1 + 4);
    (wide as u32, high as u32)
}

/// How far a text is anchored to its point.
fn style(size: i32, colour: RGBColor, horizontal: HPos) -> TextStyle<'static> {
    ("sans-serif", size)
        .into_font()
        .color(&colour)
        .pos(Pos::new(horizontal, VPos::Center))
}

/// Fill, letter or number, and its ink.
fn look(cell: &Cell) -> (RGBColor, String, RGBColor) {
    let finding = &cell.finding;
    let fill = match finding.verdict {
        Verdict::Stable => shade(finding.error.unwrap_or(0.0)),
        Verdict::Refused => RGBColor(173, 181, 189),
        Verdict::NotFinite => RGBColor(20, 20, 24),
        Verdict::Growth => RGBColor(120, 16, 42),
        Verdict::NotConverged => RGBColor(74, 40, 120),
        Verdict::BudgetBroken => RGBColor(90, 52, 10),
        Verdict::WrongLimit => RGBColor(160, 70, 10),
        Verdict::TimeLimit | Verdict::EngineFailed => RGBColor(52, 58, 64),
    };
    match finding.verdict {
        Verdict::Stable => {
            let passes = finding.passes_mean.unwrap_or(1.0);
            let text = match passes {
                _ if passes < 1.05 => String::new(),
                _ if passes < 9.95 => format!("{passes:.1}"),
                _ => format!("{passes:.0}"),
            };
            (fill, text, INK)
        }
        Verdict::Refused => (fill, finding.verdict.letter().into(), INK),
        _ => (fill, finding.verdict.letter().into(), WHITE),
    }
}

/// From a very pale green at an error of 1e-6 to a light green at 0.1.
fn shade(error: f64) -> RGBColor {
    let share = ((error.max(1e-12).log10() + 6.0) / 5.0).clamp(0.0, 1.0);
    let between = |pale: f64, deep: f64| (pale + share * (deep - pale)).round() as u8;
    RGBColor(
        between(240.0, 138.0),
        between(249.0, 205.0),
        between(242.0, 160.0),
    )
}

fn draw<B: DrawingBackend>(root: &DrawingArea<B, Shift>, map: &MapResult) -> Result<(), String> {
    let text = |error: DrawingAreaErrorKind<B::ErrorType>| error.to_string();
    root.fill(&WHITE).map_err(text)?;
    let title = format!("{} × {}", map.across.name, map.up.name);
    let write = |words: &str, at: (i32, i32), style: TextStyle<'_>| {
        root.draw_text(words, &style, at).map_err(text)
    };
    write(&title, (16, 22), style(22, INK, HPos::Left))?;
    write(map.title, (16, 48), style(16, GREY, HPos::Left))?;
    let (width, height) = panel(map);
    for (row, label) in map.up.labels.iter().enumerate() {
        let y = TOP + height - row as i32 * CELL.1 - CELL.1 / 2;
        write(label, (left(map) - 8, y), style(15, INK, HPos::Right))?;
    }
    let upright = ("sans-serif", 16)
        .into_font()
        .transform(FontTransform::Rotate270)
        .color(&INK)
        .pos(Pos::new(HPos::Center, VPos::Center));
    write(map.up.name, (18, TOP + height / 2), upright)?;
    for (number, scheme) in map.schemes().into_iter().enumerate() {
        let x = left(map) + number as i32 * (width + GAP);
        let stable = map
            .of(scheme)
            .filter(|cell| cell.finding.verdict == Verdict::Stable)
            .count();
        let name = if scheme == DEFAULT {
            format!("{scheme} (default)")
        } else {
            scheme.into()
        };
        let head = format!("{name}: {stable}/{} stable", map.of(scheme).count());
        write(
            &head,
            (x + width / 2, TOP - 14),
            style(15, INK, HPos::Center),
        )?;
        draw_panel(root, map, scheme, x)?;
        for (column, label) in map.across.labels.iter().enumerate() {
            let at = (x + column as i32 * CELL.0 + CELL.0 / 2, TOP + height + 14);
            write(label, at, style(13, INK, HPos::Center))?;
        }
        let at = (x + width / 2, TOP + height + 38);
        write(map.across.name, at, style(16, INK, HPos::Center))?;
    }
    legend(root, size(map).0 as i32, TOP + height + 70)?;
    root.present().map_err(text)
}

fn draw_panel<B: DrawingBackend>(
    root: &DrawingArea<B, Shift>,
    map: &MapResult,
    scheme: &str,
    x: i32,
) -> Result<(), String> {
    let text = |error: DrawingAreaErrorKind<B::ErrorType>| error.to_string();
    let (width, height) = panel(map);
    let frame = [(x, TOP), (x + width, TOP + height)];
    root.draw(&Rectangle::new(frame, EMPTY.filled()))
        .map_err(text)?;
    for cell in map.of(scheme) {
        let corner = (
            x + cell.across as i32 * CELL.0,
            TOP + height - (cell.up as i32 + 1) * CELL.1,
        );
        let (fill, words, ink) = look(cell);
        draw_cell(root, corner, fill, &words, ink)?;
    }
    root.draw(&Rectangle::new(frame, GREY)).map_err(text)
}

fn draw_cell<B: DrawingBackend>(
    root: &DrawingArea<B, Shift>,
    (x, y): (i32, i32),
    fill: RGBColor,
    words: &str,
    ink: RGBColor,
) -> Result<(), String> {
    let text = |error: DrawingAreaErrorKind<B::ErrorType>| error.to_string();
    let corners = [(x + 1, y + 1), (x + CELL.0 - 1, y + CELL.1 - 1)];
    root.draw(&Rectangle::new(corners, fill.filled()))
        .map_err(text)?;
    let centre = (x + CELL.0 / 2, y + CELL.1 / 2);
    root.draw_text(words, &style(15, ink, HPos::Center), centre)
        .map_err(text)
}

/// Two rows: shades of the error and the number, then the letters.
fn legend<B: DrawingBackend>(
    root: &DrawingArea<B, Shift>,
    width: i32,
    y: i32,
) -> Result<(), String> {
    let text = |error: DrawingAreaErrorKind<B::ErrorType>| error.to_string();
    let words = |words: &str, x: i32, y: i32| {
        let at = (x, y + CELL.1 / 2);
        root.draw_text(words, &style(14, INK, HPos::Left), at)
            .map_err(text)
    };
    let shades = [
        ("≤1e-6", 1e-6),
        ("1e-4", 1e-4),
        ("1e-2", 1e-2),
        ("0.1", 0.1),
    ];
    words("stable, error", 16, y)?;
    let mut x = 120;
    for (label, error) in shades {
        draw_cell(root, (x, y), shade(error), label, INK)?;
        x += CELL.0;
    }
    words("number: passes a step, if not 1", x + 12, y)?;
    for (verdict, (x, row)) in failures(width) {
        let (fill, letter, ink) = look(&Cell::of(verdict));
        let y = y + (row + 1) * (CELL.1 + 4);
        draw_cell(root, (x, y), fill, &letter, ink)?;
        words(verdict.name(), x + CELL.0 + 4, y)?;
    }
    Ok(())
}

/// Ways to fail, with the place of each in a legend of this width: x, and the row from 0.
fn failures(width: i32) -> Vec<(Verdict, (i32, i32))> {
    let (mut x, mut row) = (MARGIN, 0);
    let ways = Verdict::ALL
        .into_iter()
        .filter(|way| *way != Verdict::Stable);
    ways.map(|way| {
        let own = CELL.0 + 4 + 8 * way.name().chars().count() as i32;
        if x + own > width - MARGIN {
            (x, row) = (MARGIN, row + 1);
        }
        let place = (x, row);
        x += own + 12;
        (way, place)
    })
    .collect()
}

impl Cell {
    /// An example for the legend.
    fn of(verdict: Verdict) -> Cell {
        let mut finding = crate::verdict::Finding::refused(String::new());
        finding.verdict = verdict;
        Cell {
            across: 0,
            up: 0,
            scheme: DEFAULT,
            limit: 0.0,
            steps_asked: 0,
            finding,
        }
    }
}
