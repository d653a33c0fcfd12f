//! The states of a run as the page takes them: a stage that stays, and a frame a state.

use std::path::{Path, PathBuf};

use crate::cut::level;
use crate::simplices::{Point, bounds, central, grain_bounds, length};
use run::vtu::read::{self, State};
use scene::Error;
use serde::Serialize;
use serde_json::{Value, json};

use super::encode::{Shares, shares, singles, words};
use super::surface::{self, Drawn, Surface};

/// One state.
#[derive(Debug, Clone, Serialize)]
pub struct Frame {
    /// Time \[s\].
    pub time: f64,
    /// Fields at the points of the mesh, by name.
    pub fields: std::collections::BTreeMap<&'static str, Shares>,
    /// Bounds of each field without the outermost 0.2 % on either side.
    pub usual: std::collections::BTreeMap<&'static str, [f64; 2]>,
    /// Its own mesh, where the mesh follows the grains.
    pub mesh: Option<Drawn>,
    /// Centres of the grains \[m\], in single precision.
    pub position: Option<String>,
    /// Their speeds \[m/s\].
    pub grain_speed: Option<Shares>,
    /// Their places in the stage, where some have left.
    pub grain_id: Option<String>,
}

/// Reads the states of a run folder, also of one that is still being written.
pub struct Reader {
    folder: PathBuf,
    dimension: usize,
    surface: Option<Surface>,
    /// What stays: mesh, outlines, radii, window.
    pub stage: Value,
    density: f64,
    gravity: [f64; 3],
    open: bool,
    /// Does the mesh follow the grains?
    follows: bool,
}

/// Files of one state.
#[derive(Debug, Clone, PartialEq)]
pub struct Entry {
    /// Time \[s\].
    pub time: f64,
    fluid: Option<String>,
    grains: Option<String>,
}

impl Reader {
    /// Open a run folder; `scene` is its resolved scene.
    pub fn open(folder: &Path, scene: &Value) -> Reader {
        let fluid = &scene["fluid"];
        let number = |value: &Value| value.as_f64().unwrap_or(0.0);
        let open = fluid["boundaries"].as_object().is_some_and(|boundaries| {
            boundaries
                .values()
                .any(|condition| condition.get("open").is_some())
        });
        Reader {
            folder: folder.to_path_buf(),
            dimension: dimension(scene),
            surface: None,
            stage: Value::Null,
            density: number(&fluid["density"]),
            gravity: [0, 1, 2].map(|axis| number(&scene["gravity"][axis])),
            open,
            follows: !scene["near_grains"].is_null() || !scene["indicator"].is_null(),
        }
    }

    /// States that are written by now.
    pub fn entries(&self) -> Result<Vec<Entry>, Error> {
        let fluid = read::list(&self.folder.join("fluid.pvd"))?;
        let grains = read::list(&self.folder.join("grains.pvd"))?;
        // Of a state that is just being written one phase may be there alone: it is left for later.
        let count = match (fluid.len(), grains.len()) {
            (0, count) | (count, 0) => count,
            (fluid, grains) => fluid.min(grains),
        };
        let entry = |index: usize| {
            let time = fluid.get(index).or(grains.get(index)).map_or(0.0, |e| e.0);
            let file = |list: &[(f64, String)]| list.get(index).map(|entry| entry.1.clone());
            Entry {
                time,
                fluid: file(&fluid),
                grains: file(&grains),
            }
        };
        Ok((0..count).map(entry).collect())
    }

    /// The page's form of a state; the first one sets the stage.
    pub fn frame(&mut self, entry: &Entry, walls: &Value) -> Result<Frame, Error> {
        let open = |file: &Option<String>| {
            file.as_ref()
                .map(|file| State::read(&self.folder.join(file)))
                .transpose()
        };
        let (fluid, grains) = (open(&entry.fluid)?, open(&entry.grains)?);
        if self.stage.is_null() {
            self.set_stage(fluid.as_ref(), grains.as_ref(), walls)?;
        }
        let surface = match (&fluid, &self.surface) {
            (Some(state), Some(last)) if self.follows => last.again(state)?,
            _ => None,
        };
        let mut frame = Frame {
            time: entry.time,
            mesh: surface.as_ref().map(Surface::drawn),
            fields: Default::default(),
            usual: Default::default(),
            position: None,
            grain_speed: None,
            grain_id: None,
        };
        self.surface = surface.or(self.surface.take());
        if let (Some(state), Some(surface)) = (&fluid, &self.surface) {
            for (name, values) in self.fields(state, surface)? {
                if let Some(values) = surface.at(values) {
                    frame.usual.insert(name, usual(&values));
                    frame.fields.insert(name, shares(&values));
                }
            }
        }
        if let Some(state) = &grains {
            let position = state.vectors::<3>("position")?.unwrap_or_default();
            frame.position = Some(self.singles(position.iter()));
            let id = state.numbers("grain_id")?;
            frame.grain_id = id.map(|id| words(id.into_iter().map(|id| id as u32)));
            frame.grain_speed = state
                .vectors::<3>("grain_velocity")?
                .map(|v| shares(&v.iter().map(|v| length(*v)).collect::<Vec<_>>()));
        }
        Ok(frame)
    }

    /// Of points, as many numbers as the scene has dimensions.
    fn singles<'a>(&self, points: impl Iterator<Item = &'a Point<3>>) -> String {
        singles(points.flat_map(|point| point[..self.dimension].iter().copied()))
    }

    /// Fields at the points of the mesh.
    fn fields(
        &self,
        state: &State,
        surface: &Surface,
    ) -> Result<Vec<(&'static str, Vec<f64>)>, Error> {
        let mut fields = Vec::new();
        if let Some(velocity) = state.vectors::<3>("interstitial_velocity")? {
            fields.push(("speed", velocity.iter().map(|v| length(*v)).collect()));
            fields.extend(surface.vorticity(&velocity).map(|curl| ("vorticity", curl)));
        }
        if let Some(pressure) = state.numbers("pressure")? {
            let points = state.vectors::<3>("position")?.unwrap_or_default();
            fields.push(("pressure", self.excess(&points, pressure)));
        }
        if let Some(porosity) = state.numbers("porosity")? {
            fields.push(("porosity", porosity));
        }
        Ok(fields)
    }

    /// p − ρ g·x, which is what moves the fluid; where no boundary is open, about its mean.
    fn excess(&self, points: &[Point<3>], mut pressure: Vec<f64>) -> Vec<f64> {
        let fall =
            |x: &Point<3>| self.gravity[0] * x[0] + self.gravity[1] * x[1] + self.gravity[2] * x[2];
        for (p, x) in pressure.iter_mut().zip(points) {
            *p -= self.density * fall(x);
        }
        let level = if self.open {
            // Given at the highest point.
            let top = (0..points.len().min(pressure.len()))
                .max_by(|&a, &b| (-fall(&points[a])).total_cmp(&-fall(&points[b])));
            top.map_or(0.0, |top| pressure[top])
        } else {
            pressure.iter().sum::<f64>() / pressure.len().max(1) as f64
        };
        pressure.iter_mut().for_each(|p| *p -= level);
        pressure
    }

    fn set_stage(
        &mut self,
        fluid: Option<&State>,
        grains: Option<&State>,
        walls: &Value,
    ) -> Result<(), Error> {
        let walls = walls.as_array().into_iter().flatten();
        let walls: Vec<Vec<Point<3>>> = walls.map(corners).collect();
        let positions = match grains {
            Some(state) => state.vectors::<3>("position")?.unwrap_or_default(),
            None => Vec::new(),
        };
        let radius = match grains {
            Some(state) => state.numbers("grain_radius")?.unwrap_or_default(),
            None => Vec::new(),
        };
        let nodes = match fluid {
            Some(state) => state.vectors::<3>("position")?.unwrap_or_default(),
            None => Vec::new(),
        };
        let window = match (nodes.is_empty(), walls.is_empty()) {
            (false, _) => bounds(nodes.into_iter()),
            (true, true) => grain_bounds(positions.iter().copied(), &radius),
            (true, false) => bounds(walls.iter().flatten().chain(&positions).copied()),
        };
        if let Some(state) = fluid {
            let middle = central(positions.iter().map(|position| position[2]).collect());
            let level = level(middle, (window.0[2], window.1[2]));
            self.surface = Surface::of_state(state, self.dimension, level)?;
        }
        let outline = surface::outline(self.surface.as_ref(), &walls, window, self.dimension);
        let corner = |corner: Point<3>| corner[..self.dimension].to_vec();
        self.stage = json!({
            "window": [corner(window.0), corner(window.1)],
            "outline": self.singles(outline.iter().flatten()),
            "radius": singles(radius.into_iter()),
            "mesh": self.surface.as_ref().map(Surface::drawn),
        });
        Ok(())
    }
}

/// In how many dimensions a scene is computed; of one that does not say it, the plane.
pub fn dimension(scene: &Value) -> usize {
    scene["gravity"].as_array().map_or(2, Vec::len)
}

/// Corners of a wall, with zeros for what they lack.
fn corners(wall: &Value) -> Vec<Point<3>> {
    let corner = |corner: &Value| [0, 1, 2].map(|axis| corner[axis].as_f64().unwrap_or(0.0));
    let corners = wall["corners"].as_array().into_iter().flatten();
    corners.map(corner).collect()
}

fn usual(values: &[f64]) -> [f64; 2] {
    let mut sorted: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
    sorted.sort_by(f64::total_cmp);
    let Some(last) = sorted.len().checked_sub(1) else {
        return [0.0, 0.0];
    };
    [0.002, 0.998].map(|share| sorted[(share * last as f64).round() as usize])
}
