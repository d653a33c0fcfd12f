//! A contact sheet of several states of a run, with one scale of colours.

use super::view::View;
use super::{Stage, State, axes};
use crate::picture::axes::{ColourBar, TEXT, round_up, time_label};
use crate::picture::canvas::{Anchor, Canvas};
use crate::picture::colour::INK;
use crate::picture::sheet::{BAR, EDGE, GAP, LABEL, PANELS, SCALE, arrange, shown, spread};

/// Draw the states side by side; none when there is nothing to show.
pub fn overview(stage: &Stage, states: &[&State]) -> Option<Canvas> {
    let chosen = spread(states, PANELS);
    let (lower, upper) = shown(stage, &chosen)?;
    let size = [upper[0] - lower[0], upper[1] - lower[1]];
    let (columns, scale) = arrange(chosen.len(), size);
    let rows = chosen.len().div_ceil(columns);
    let (width, height) = (size[0] * scale, size[1] * scale);
    let sheet_width = 2.0 * EDGE + columns as f64 * (width + GAP) + BAR;
    let sheet_height =
        2.0 * EDGE + SCALE + rows as f64 * (height + LABEL) + (rows - 1) as f64 * GAP;
    let mut canvas = Canvas::new(sheet_width.ceil() as usize, sheet_height.ceil() as usize);
    let speed_max = round_up(
        chosen
            .iter()
            .map(|state| state.speed_max())
            .fold(0.0, f64::max),
    );
    for (index, state) in chosen.iter().enumerate() {
        let left = EDGE + (index % columns) as f64 * (width + GAP);
        let top = EDGE + LABEL + (index / columns) as f64 * (height + LABEL + GAP);
        let view = View {
            lower,
            upper,
            left,
            top,
            scale,
        };
        view.draw(&mut canvas, stage, state, speed_max);
        view.outline(&mut canvas, 1.5, INK);
        let middle = left + 0.5 * width;
        canvas.text(
            &time_label(state.time),
            [middle, top - 10.0],
            TEXT,
            Anchor::Above,
        );
        if index + 1 == chosen.len() {
            axes::scale_bar(&mut canvas, &view);
        }
    }
    let bar_left = EDGE + columns as f64 * (width + GAP) + 10.0;
    let bar_height = (sheet_height - 2.0 * EDGE - LABEL - SCALE).min(700.0);
    ColourBar::of(stage.mesh.is_some(), speed_max).draw(
        &mut canvas,
        bar_left,
        EDGE + LABEL,
        bar_height,
    );
    Some(canvas)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::colour::GRAIN;

    #[test]
    fn one_grain_at_rest_lies_whole_within_each_panel() {
        let mut stage = Stage::new("rest", None, &[], vec![1e-3], vec![false]);
        stage.mesh = crate::simplices::Triangles::of(run::vtu::mesh::Mesh {
            dimension: 2,
            points: vec![0.0, 0.0, 1.0, 0.0, 0.0, 1.0],
            node_of: vec![0, 1, 2],
            corners: vec![0, 1, 2],
            node_count: 3,
        });
        stage.window = ([0.0; 2], [1.0; 2]);
        let state = |time: f64| State {
            time,
            grain_position: vec![[0.3, 0.3]],
            grain_speed: vec![0.0],
            grain_id: Vec::new(),
            ..State::default()
        };
        let states = [state(0.0), state(1.0)];
        let (low, high) = shown(&stage, &[&states[0], &states[1]]).expect("something");
        println!("{low:?} {high:?}");
        assert!(low[0] <= 0.3 - 2.9e-3 && high[0] >= 0.3 + 2.9e-3);
        let begun = std::time::Instant::now();
        let mut sheet = overview(&stage, &[&states[0], &states[1]]).expect("a sheet");
        assert!(begun.elapsed() < std::time::Duration::from_secs(5));
        let width = sheet.width;
        let inked = |pixel: &[u8]| pixel == GRAIN;
        let rows = sheet.pixels_mut().chunks_exact(3 * width);
        // seen from left to right: paper, grain, paper, grain, paper
        let changes = rows.map(|row| {
            let row: Vec<bool> = row.chunks_exact(3).map(inked).collect();
            row.windows(2).filter(|pair| pair[0] != pair[1]).count()
        });
        assert_eq!(changes.max(), Some(4));
    }
}
