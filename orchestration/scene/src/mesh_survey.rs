//! What is in the mesh file of a scene, and what is missing: for people.

use std::fmt;
use std::path::Path;

use gmsh::survey::{self, Group};
use gmsh::{File, Mesh};
use serde::Serialize;

use crate::error::Error;
use crate::keys::{Fluid, SceneFile};
use crate::mesh_file::options;

/// A mesh file as it is read.
#[derive(Debug, Clone, Serialize)]
pub struct MeshSurvey {
    /// The file.
    pub file: String,
    /// Its format.
    pub format: String,
    /// Nodes in it.
    pub nodes: usize,
    /// Surfaces and curves.
    pub groups: Vec<GroupRow>,
    /// How good the triangles are; none where there is no mesh to be made.
    pub quality: Option<QualityRow>,
}

/// A surface or a curve.
#[derive(Debug, Clone, Serialize)]
pub struct GroupRow {
    /// "surface" or "curve".
    pub kind: &'static str,
    /// Its groups, or its number.
    pub labels: Vec<String>,
    /// Numbers of its entities.
    pub entities: Vec<i64>,
    /// Elements.
    pub elements: usize,
    /// Area (m²) or length (m).
    pub size: f64,
    /// Of a curve: its condition in the scene.
    pub condition: Option<String>,
}

/// Qualities of the triangles.
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
    pub fn of(keys: &SceneFile, folder: &Path) -> Result<Option<MeshSurvey>, Error> {
        let Some(fluid) = keys.fluid.as_ref() else {
            return Ok(None);
        };
        let Some(name) = &fluid.domain.mesh else {
            return Ok(None);
        };
        let file =
            File::read(&folder.join(name)).map_err(|error| Error::Usage(error.to_string()))?;
        let options = options(&fluid.domain);
        let mesh: Option<Mesh<2, 3>> = Mesh::of(&file, &options).ok();
        let groups = survey::groups::<2>(&file).into_iter();
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

fn row(group: Group, scale: f64, fluid: &Fluid) -> GroupRow {
    let kind = if group.dimension == 2 {
        "surface"
    } else {
        "curve"
    };
    let own = group
        .labels
        .iter()
        .find_map(|label| fluid.boundaries.get(label));
    let condition = own.or_else(|| fluid.boundaries.get("all"));
    let text = condition.and_then(|condition| serde_json::to_string(condition).ok());
    GroupRow {
        kind,
        entities: group.entities.into_iter().collect(),
        elements: group.elements,
        size: group.size * scale.powi(group.dimension as i32),
        condition: text.filter(|_| kind == "curve"),
        labels: group.labels,
    }
}

fn quality(mesh: &Mesh<2, 3>) -> QualityRow {
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
            let unit = if group.kind == "surface" { "m²" } else { "m" };
            let condition = match (&group.condition, group.kind) {
                (Some(condition), _) => condition,
                (None, "curve") => "no condition",
                (None, _) => "",
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
