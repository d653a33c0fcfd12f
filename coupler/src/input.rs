//! The resolved scene (`scene.json`) and its grains (`grains.csv`), as the orchestrator writes them.

use std::path::Path;

use protocol::configure::{CouplerScene, Geometry};
use protocol::engine::InitialGrains;
use serde::Deserialize;

use crate::drag::Shape;
use crate::error::CouplerError;

#[derive(Deserialize)]
struct Row {
    x: f64,
    y: f64,
    radius: f64,
    density: f64,
    vx: f64,
    vy: f64,
    fixed: u8,
}

/// Read a resolved scene and the grains beside it.
pub fn read(path: &Path) -> Result<(CouplerScene, InitialGrains), CouplerError> {
    let refuse = |file: &Path, why: String| CouplerError::Scene {
        file: file.display().to_string(),
        why,
    };
    let text = std::fs::read_to_string(path).map_err(|error| refuse(path, error.to_string()))?;
    let scene: CouplerScene =
        serde_json::from_str(&text).map_err(|error| refuse(path, error.to_string()))?;
    let Some(name) = &scene.grains_file else {
        return Ok((scene, InitialGrains::default()));
    };
    let file = path.parent().unwrap_or(Path::new(".")).join(name);
    let mut reader =
        csv::Reader::from_path(&file).map_err(|error| refuse(&file, error.to_string()))?;
    let rows: Vec<Row> = reader
        .deserialize()
        .collect::<Result<_, _>>()
        .map_err(|error| refuse(&file, error.to_string()))?;
    let grains = grains(&rows, scene.geometry).map_err(|why| refuse(&file, why))?;
    if let Some(row) = rows
        .iter()
        .position(|row| scene.grains_stay && row.fixed == 0)
    {
        let why =
            "is not fixed, but the scene says grains_stay: without a particle process all must be";
        return Err(refuse(&file, format!("line {}: the grain {why}", row + 2)));
    }
    Ok((scene, grains))
}

fn grains(rows: &[Row], geometry: Geometry) -> Result<InitialGrains, String> {
    let mut grains = InitialGrains::default();
    for (index, row) in rows.iter().enumerate() {
        let finite = [row.x, row.y, row.radius, row.density, row.vx, row.vy]
            .iter()
            .all(|value| value.is_finite());
        if !finite || row.radius <= 0.0 || row.density <= 0.0 {
            return Err(format!(
                "line {}: radius and density must be above 0 and all values finite",
                index + 2
            ));
        }
        let volume = Shape::new(geometry, row.radius, 1.0).volume;
        grains.position.extend([row.x, row.y]);
        grains.velocity.extend([row.vx, row.vy]);
        grains.radius.push(row.radius);
        grains.mass.push(row.density * volume);
        grains.volume.push(volume);
        grains.fixed.push(f64::from(row.fixed != 0));
    }
    Ok(grains)
}
