//! The resolved scene (`scene.json`) and its grains (`grains.csv`), as the orchestrator writes them.

use std::path::Path;

use csv::StringRecord;
use protocol::engine::InitialGrains;
use protocol::scene::{CouplerScene, Geometry};

use crate::drag::laws::Shape;
use crate::error::CouplerError;

/// Columns of positions and of velocities, by axis.
const POSITION: [&str; 3] = ["x", "y", "z"];
const VELOCITY: [&str; 3] = ["vx", "vy", "vz"];

/// Read a resolved scene and the grains beside it.
pub fn read(path: &Path) -> Result<(CouplerScene, InitialGrains), CouplerError> {
    let refuse = |file: &Path, why: String| CouplerError::Scene {
        file: file.display().to_string(),
        why,
    };
    let text = std::fs::read_to_string(path).map_err(|error| refuse(path, error.to_string()))?;
    let scene: CouplerScene =
        serde_json::from_str(&text).map_err(|error| refuse(path, error.to_string()))?;
    scene.check().map_err(|why| refuse(path, why))?;
    let Some(name) = &scene.grains_file else {
        return Ok((scene, InitialGrains::default()));
    };
    let file = path.parent().unwrap_or(Path::new(".")).join(name);
    let grains = grains(&file, &scene).map_err(|why| refuse(&file, why))?;
    Ok((scene, grains))
}

/// Grains of a scene; an error names the line.
fn grains(file: &Path, scene: &CouplerScene) -> Result<InitialGrains, String> {
    let mut reader = csv::Reader::from_path(file).map_err(|error| error.to_string())?;
    let headers = reader.headers().map_err(|error| error.to_string())?;
    let columns = Columns::new(headers, scene.dimension)?;
    let mut grains = InitialGrains {
        dimension: scene.dimension,
        ..InitialGrains::default()
    };
    for (index, row) in reader.records().enumerate() {
        let row = row.map_err(|error| error.to_string())?;
        columns
            .add(&row, scene.geometry, &mut grains)
            .and_then(|()| may_move(scene, &grains))
            .map_err(|why| format!("line {}: {why}", index + 2))?;
    }
    Ok(grains)
}

fn may_move(scene: &CouplerScene, grains: &InitialGrains) -> Result<(), String> {
    match grains.fixed.last() {
        Some(&fixed) if scene.grains_stay && fixed == 0.0 => Err(
            "the grain is not fixed, but the scene says grains_stay: without a particle process all \
             must be"
                .to_owned(),
        ),
        _ => Ok(()),
    }
}

/// Where the numbers of a grain stand in a row.
struct Columns {
    position: Vec<usize>,
    velocity: Vec<usize>,
    radius: usize,
    density: usize,
    fixed: usize,
}

impl Columns {
    fn new(headers: &StringRecord, dimension: usize) -> Result<Columns, String> {
        let find = |name: &str| {
            let place = headers.iter().position(|header| header.trim() == name);
            place.ok_or_else(|| format!("column `{name}` is missing"))
        };
        let along = |names: &[&str; 3]| -> Result<Vec<usize>, String> {
            names
                .iter()
                .take(dimension)
                .map(|name| find(name))
                .collect()
        };
        Ok(Columns {
            position: along(&POSITION)?,
            velocity: along(&VELOCITY)?,
            radius: find("radius")?,
            density: find("density")?,
            fixed: find("fixed")?,
        })
    }

    fn add(
        &self,
        row: &StringRecord,
        geometry: Geometry,
        grains: &mut InitialGrains,
    ) -> Result<(), String> {
        let number = |column: usize| -> Result<f64, String> {
            let text = row.get(column).unwrap_or_default().trim();
            let number = text.parse().map_err(|_| format!("`{text}` is no number"));
            number.and_then(|number: f64| match number.is_finite() {
                true => Ok(number),
                false => Err(format!("{number} is not finite")),
            })
        };
        let (radius, density) = (number(self.radius)?, number(self.density)?);
        if radius <= 0.0 || density <= 0.0 {
            return Err("radius and density must be above 0".to_owned());
        }
        for &column in &self.position {
            grains.position.push(number(column)?);
        }
        for &column in &self.velocity {
            grains.velocity.push(number(column)?);
        }
        let volume = Shape::new(geometry, radius, 1.0).volume;
        grains.radius.push(radius);
        grains.mass.push(density * volume);
        grains.volume.push(volume);
        let fixed = number(self.fixed)? != 0.0;
        grains.fixed.push(f64::from(u8::from(fixed)));
        Ok(())
    }
}
