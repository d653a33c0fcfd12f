//! What is in the mesh file of a scene, and what is missing: for people.

use std::fmt;
use std::path::Path;

use gmsh::survey::{self, Group};
use gmsh::{File, Mesh};
use serde::Serialize;
use space::{Dim, Dimension};

use crate::document::Document;
use crate::error::Error;
use crate::keys::{Fluid, SceneFile};
use crate::mesh_file::options;
use crate::read;

/// What a group is called, by its dimension.
const KINDS: [&str; 3] = ["curve", "surface", "volume"];

/// A mesh file as it is read.
#[derive(Debug, Clone, Serialize)]
pub struct MeshSurvey {
    /// The file.
    pub file: String,
    /// Its format.
    pub format: String,
    /// Nodes in it.
    pub nodes: usize,
    /// Volumes, surfaces and curves.
    pub groups: Vec<GroupRow>,
    /// How good the simplices are; none where there is no mesh to be made.
    pub quality: Option<QualityRow>,
}

/// What is filled, or a part of its boundary.
#[derive(Debug, Clone, Serialize)]
pub struct GroupRow {
    /// "volume", "surface" or "curve".
    pub kind: &'static str,
    /// Is it what the fluid fills, and not its boundary?
    pub filled: bool,
    /// Its groups, or its number.
    pub labels: Vec<String>,
    /// Numbers of its entities.
    pub entities: Vec<i64>,
    /// Elements.
    pub elements: usize,
    /// Volume (m³), area (m²) or length (m).
    pub size: f64,
    /// Of the boundary: its condition in the scene.
    pub condition: Option<String>,
}

/// Qualities of the simplices.
#[derive(Debug, Clone, Serialize)]
pub struct QualityRow {
    /// Area over that of the equilateral one with the same mean square of sides: least, and its element.
    pub least: (f64, u64),
    /// Mean of that.
    pub mean: f64,
    /// Largest ratio of longest side and height, and its element.
    pub aspect: (f64, u64),
    /// Shortest and longest side (m).
    pub sides: [f64; 2],
}

impl MeshSurvey {
    /// Of the file that a scene names; none of a scene without one. Faults of the mesh are told by `load`.
    pub fn of(document: &Document) -> Result<Option<MeshSurvey>, Error> {
        let folder = document.folder();
        match read::dimension(document) {
            3 => MeshSurvey::of_keys::<3, 4>(&read::read(document)?, &folder),
            _ => MeshSurvey::of_keys::<2, 3>(&read::read(document)?, &folder),
        }
    }

    fn of_keys<const D: usize, const N: usize>(
        keys: &SceneFile<D>,
        folder: &Path,
    ) -> Result<Option<MeshSurvey>, Error>
    where
        Dim<D>: Dimension<D>,
    {
        let Some(fluid) = keys.fluid.as_ref() else {
            return Ok(None);
        };
        let Some(name) = &fluid.domain.mesh else {
            return Ok(None);
        };
        let file =
            File::read(&folder.join(name)).map_err(|error| Error::Usage(error.to_string()))?;
        let options = options(&fluid.domain);
        let mesh: Option<Mesh<D, N>> = Mesh::of(&file, &options).ok();
        let groups = survey::groups::<D>(&file).into_iter();
        Ok(Some(MeshSurvey {
            file: file.path.display().to_string(),
            format: file.format.clone(),
            nodes: file.nodes.len(),
            groups: groups
                .map(|group| row(group, options.scale, fluid))
                .collect(),
            quality: mesh.map(|mesh| quality(&mesh)),
        }))
    }
}

fn row<const D: usize>(group: Group, scale: f64, fluid: &Fluid<D>) -> GroupRow {
    let kind = KINDS[group.dimension.clamp(1, 3) - 1];
    let own = group
        .labels
        .iter()
        .find_map(|label| fluid.boundaries.get(label));
    let condition = own.or_else(|| fluid.boundaries.get("all"));
    let flat = condition.map(|condition| condition.map(|velocity| velocity.to_vec()));
    let text = flat.and_then(|condition| serde_json::to_string(&condition).ok());
    GroupRow {
        kind,
        entities: group.entities.into_iter().collect(),
        elements: group.elements,
        size: group.size * scale.powi(group.dimension as i32),
        condition: text.filter(|_| group.dimension < D),
        filled: group.dimension == D,
        labels: group.labels,
    }
}

fn quality<const D: usize, const N: usize>(mesh: &Mesh<D, N>) -> QualityRow
where
    Dim<D>: Dimension<D>,
{
    let quality = survey::quality(mesh);
    QualityRow {
        least: (quality.least, quality.worst),
        mean: quality.mean,
        aspect: (quality.aspect, quality.longest),
        sides: quality.edges,
    }
}

impl fmt::Display for MeshSurvey {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            out,
            "{}: Gmsh {}, {} nodes",
            self.file, self.format, self.nodes
        )?;
        for group in &self.groups {
            let unit = match group.kind {
                "volume" => "m³",
                "surface" => "m²",
                _ => "m",
            };
            let condition = match (&group.condition, group.filled) {
                (Some(condition), _) => condition,
                (None, false) => "no condition",
                (None, true) => "",
            };
            writeln!(
                out,
                "  {:7}  {:20}  {:6} elements  {:.5e} {unit:2}  number {:?}  {condition}",
                group.kind,
                format!("{:?}", group.labels.join(", ")),
                group.elements,
                group.size,
                group.entities,
            )?;
        }
        let Some(quality) = &self.quality else {
            return write!(out, "  no mesh can be made of it");
        };
        let ((least, worst), (aspect, longest)) = (quality.least, quality.aspect);
        write!(
            out,
            "  quality {least:.3} (element {worst}) to 1, mean {:.3}; up to {aspect:.1} times as long as high \
             (element {longest}); sides {:.3e} to {:.3e} m",
            quality.mean, quality.sides[0], quality.sides[1]
        )
    }
}
