//! The states of a run as the page takes them: a stage that stays, and a frame a state.

use std::path::{Path, PathBuf};

use crate::simplices::{Triangles, bounds, grain_bounds};
use run::vtu::read::{self, State};
use scene::Error;
use serde::Serialize;
use serde_json::{Value, json};

use super::encode::{Shares, shares, singles, words};

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

/// A mesh as the page takes it.
#[derive(Debug, Clone, Serialize)]
pub struct Drawn {
    /// Places \[m\], in single precision.
    points: String,
    /// Corners of the triangles.
    triangles: String,
}

impl Drawn {
    fn of(mesh: &Triangles) -> Drawn {
        Drawn {
            points: singles(mesh.points.iter().flatten().copied()),
            triangles: words(mesh.simplices.iter().flatten().copied()),
        }
    }
}

/// Reads the states of a run folder, also of one that is still being written.
pub struct Reader {
    folder: PathBuf,
    mesh: Option<Triangles>,
    /// What stays: mesh, outlines, radii, window.
    pub stage: Value,
    density: f64,
    gravity: [f64; 2],
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
            mesh: None,
            stage: Value::Null,
            density: number(&fluid["density"]),
            gravity: [0, 1].map(|axis| number(&scene["gravity"][axis])),
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
        let mesh = match &fluid {
            Some(state) if self.follows => Triangles::of_state(state)?,
            _ => None,
        };
        let mut frame = Frame {
            time: entry.time,
            mesh: mesh.as_ref().map(Drawn::of),
            fields: Default::default(),
            usual: Default::default(),
            position: None,
            grain_speed: None,
            grain_id: None,
        };
        self.mesh = mesh.or(self.mesh.take());
        if let (Some(state), Some(mesh)) = (&fluid, &self.mesh) {
            for (name, values) in self.fields(state, mesh)? {
                if values.len() == mesh.points.len() {
                    frame.usual.insert(name, usual(&values));
                    frame.fields.insert(name, shares(&values));
                }
            }
        }
        if let Some(state) = &grains {
            let position = state.vectors::<2>("position")?.unwrap_or_default();
            frame.position = Some(singles(position.into_iter().flatten()));
            let id = state.numbers("grain_id")?;
            frame.grain_id = id.map(|id| words(id.into_iter().map(|id| id as u32)));
            frame.grain_speed = state
                .vectors::<2>("grain_velocity")?
                .map(|v| shares(&v.iter().map(|v| v[0].hypot(v[1])).collect::<Vec<_>>()));
        }
        Ok(frame)
    }

    fn fields(
        &self,
        state: &State,
        mesh: &Triangles,
    ) -> Result<Vec<(&'static str, Vec<f64>)>, Error> {
        let mut fields = Vec::new();
        if let Some(velocity) = state.vectors::<2>("interstitial_velocity")? {
            fields.push(("speed", velocity.iter().map(|v| v[0].hypot(v[1])).collect()));
            if velocity.len() == mesh.points.len() {
                fields.push(("vorticity", vorticity(mesh, &velocity)));
            }
        }
        if let Some(pressure) = state.numbers("pressure")? {
            fields.push(("pressure", self.excess(mesh, pressure)));
        }
        if let Some(porosity) = state.numbers("porosity")? {
            fields.push(("porosity", porosity));
        }
        Ok(fields)
    }

    /// p − ρ g·x, which is what moves the fluid; where no boundary is open, about its mean.
    fn excess(&self, mesh: &Triangles, mut pressure: Vec<f64>) -> Vec<f64> {
        for (p, x) in pressure.iter_mut().zip(&mesh.points) {
            *p -= self.density * (self.gravity[0] * x[0] + self.gravity[1] * x[1]);
        }
        let level = if self.open {
            // Given at the highest point.
            let up = |x: &[f64; 2]| -(self.gravity[0] * x[0] + self.gravity[1] * x[1]);
            let top = (0..mesh.points.len().min(pressure.len()))
                .max_by(|&a, &b| up(&mesh.points[a]).total_cmp(&up(&mesh.points[b])));
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
        if let Some(state) = fluid {
            self.mesh = Triangles::of_state(state)?;
        }
        let mut outline: Vec<[[f64; 2]; 2]> = Vec::new();
        for wall in walls.as_array().into_iter().flatten() {
            let end = |name: &str| [0, 1].map(|axis| wall[name][axis].as_f64().unwrap_or(0.0));
            outline.push([end("a"), end("b")]);
        }
        let positions = match grains {
            Some(state) => state.vectors::<2>("position")?.unwrap_or_default(),
            None => Vec::new(),
        };
        let radius = match grains {
            Some(state) => state.numbers("grain_radius")?.unwrap_or_default(),
            None => Vec::new(),
        };
        let window = match &self.mesh {
            Some(mesh) => mesh.bounds(),
            None if outline.is_empty() => grain_bounds(positions.iter().copied(), &radius),
            None => bounds(outline.iter().flatten().chain(&positions).copied()),
        };
        if let Some(mesh) = &self.mesh {
            let at = |point: u32| mesh.points[point as usize];
            outline.extend(mesh.boundary().iter().map(|[a, b]| [at(*a), at(*b)]));
        }
        self.stage = json!({
            "window": [window.0, window.1],
            "outline": singles(outline.into_iter().flatten().flatten()),
            "radius": singles(radius.into_iter()),
            "mesh": self.mesh.as_ref().map(Drawn::of),
        });
        Ok(())
    }
}

/// ∂v/∂x − ∂u/∂y at the points: the gradient of each triangle, averaged by area.
fn vorticity(mesh: &Triangles, velocity: &[[f64; 2]]) -> Vec<f64> {
    let mut sum = vec![0.0; mesh.points.len()];
    let mut area = vec![0.0; mesh.points.len()];
    for corners in &mesh.simplices {
        let [a, b, c] = corners.map(|corner| corner as usize);
        let [pa, pb, pc] = [a, b, c].map(|point| mesh.points[point]);
        let (ux, uy) = (pb[0] - pa[0], pb[1] - pa[1]);
        let (vx, vy) = (pc[0] - pa[0], pc[1] - pa[1]);
        let twice = ux * vy - uy * vx;
        let [va, vb, vc] = [a, b, c].map(|point| velocity[point]);
        let (d1, d2) = (
            [vb[0] - va[0], vb[1] - va[1]],
            [vc[0] - va[0], vc[1] - va[1]],
        );
        // Twice the area times ∂v/∂x − ∂u/∂y.
        let curl = (d1[1] * vy - d2[1] * uy) - (ux * d2[0] - vx * d1[0]);
        for point in [a, b, c] {
            sum[point] += curl;
            area[point] += twice;
        }
    }
    let mean = |(sum, area): (f64, f64)| if area == 0.0 { 0.0 } else { sum / area };
    sum.into_iter().zip(area).map(mean).collect()
}

fn usual(values: &[f64]) -> [f64; 2] {
    let mut sorted: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
    sorted.sort_by(f64::total_cmp);
    let Some(last) = sorted.len().checked_sub(1) else {
        return [0.0, 0.0];
    };
    [0.002, 0.998].map(|share| sorted[(share * last as f64).round() as usize])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_vorticity_of_a_rotation_is_twice_its_rate() {
        let points = vec![[0.0, 0.0], [1.0, 0.0], [1.0, 2.0], [0.0, 1.0]];
        let velocity: Vec<[f64; 2]> = points
            .iter()
            .map(|x: &[f64; 2]| [-3.0 * x[1], 3.0 * x[0]])
            .collect();
        let mesh = Triangles {
            node_of: vec![0, 1, 2, 3],
            node_count: 4,
            simplices: vec![[0, 1, 2], [0, 2, 3]],
            points,
        };
        let found = vorticity(&mesh, &velocity);
        println!("{found:?}");
        assert!(found.iter().all(|curl| (curl - 6.0).abs() < 1e-12));
    }
}
