//! ParaView files: one `.vtu` a state (binary, base64), and a `.pvd` that lists them with their
//! times, rewritten after every state so that a running computation can be looked at.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use protocol::field::Field;
use scene::Error;

use super::mesh::Mesh;
use crate::file;

const VTK_VERTEX: u8 = 1;
const VTK_TRIANGLE: u8 = 5;

/// Values at the points of a file.
pub struct PointData<'a> {
    /// The field.
    pub field: Field,
    /// One group of components a point.
    pub values: Vec<&'a [f64]>,
}

/// A state of the fluid: nodal fields on the mesh.
pub fn fluid(mesh: &Mesh, fields: &[(Field, &[f64])]) -> String {
    let points: Vec<f64> = mesh.points.iter().flat_map(|p| [p[0], p[1], 0.0]).collect();
    let connectivity: Vec<i64> = mesh
        .triangles
        .iter()
        .flatten()
        .map(|&p| i64::from(p))
        .collect();
    let data = fields
        .iter()
        .filter(|(field, values)| values.len() == mesh.node_count * field.components())
        .map(|(field, values)| {
            let width = field.components();
            let at = |node: &u32| &values[*node as usize * width..(*node as usize + 1) * width];
            PointData {
                field: *field,
                values: mesh.node_of.iter().map(at).collect(),
            }
        })
        .collect::<Vec<_>>();
    document(&points, &connectivity, 3, VTK_TRIANGLE, &data)
}

/// A state of the grains: points with radius, velocity and what else was sent.
pub fn grains(position: &[f64], fields: &[(Field, &[f64])]) -> String {
    let points: Vec<f64> = position
        .chunks_exact(2)
        .flat_map(|p| [p[0], p[1], 0.0])
        .collect();
    let count = points.len() / 3;
    let connectivity: Vec<i64> = (0..count as i64).collect();
    let data = fields
        .iter()
        .filter(|(field, values)| values.len() == count * field.components())
        .map(|(field, values)| PointData {
            field: *field,
            values: values.chunks_exact(field.components()).collect(),
        })
        .collect::<Vec<_>>();
    document(&points, &connectivity, 1, VTK_VERTEX, &data)
}

/// An unstructured grid of cells with `corners` points each.
fn document(
    points: &[f64],
    connectivity: &[i64],
    corners: usize,
    kind: u8,
    data: &[PointData<'_>],
) -> String {
    let cells = connectivity.len() / corners;
    let offsets: Vec<i64> = (1..=cells as i64)
        .map(|cell| cell * corners as i64)
        .collect();
    let mut xml = String::from("<?xml version=\"1.0\"?>\n");
    xml += "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n";
    // Writing to a string cannot fail.
    let _ = writeln!(
        xml,
        "<UnstructuredGrid>\n<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{cells}\">\n<PointData>",
        points.len() / 3
    );
    for column in data {
        // ParaView expects vectors with three components.
        let width = if column.field.components() == 2 {
            3
        } else {
            column.field.components()
        };
        let mut values = Vec::with_capacity(column.values.len() * width);
        for group in &column.values {
            values.extend_from_slice(group);
            values.resize(values.len() + width - group.len(), 0.0);
        }
        array(
            &mut xml,
            "Float64",
            column.field.name(),
            width,
            bytes_of(&values, f64::to_le_bytes),
        );
    }
    xml += "</PointData>\n<Points>\n";
    array(
        &mut xml,
        "Float64",
        "position",
        3,
        bytes_of(points, f64::to_le_bytes),
    );
    xml += "</Points>\n<Cells>\n";
    array(
        &mut xml,
        "Int64",
        "connectivity",
        1,
        bytes_of(connectivity, i64::to_le_bytes),
    );
    array(
        &mut xml,
        "Int64",
        "offsets",
        1,
        bytes_of(&offsets, i64::to_le_bytes),
    );
    array(&mut xml, "UInt8", "types", 1, vec![kind; cells]);
    xml += "</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n";
    xml
}

fn bytes_of<T: Copy>(values: &[T], to_bytes: impl Fn(T) -> [u8; 8]) -> Vec<u8> {
    values.iter().flat_map(|&value| to_bytes(value)).collect()
}

/// A data array: its length in bytes, then its bytes, in base64.
fn array(xml: &mut String, kind: &str, name: &str, components: usize, bytes: Vec<u8>) {
    let mut block = (bytes.len() as u64).to_le_bytes().to_vec();
    block.extend(bytes);
    let _ = writeln!(
        xml,
        "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\" format=\"binary\">"
    );
    xml.push_str(&STANDARD.encode(&block));
    xml.push_str("\n</DataArray>\n");
}

/// The list of the states of one phase.
pub struct Series {
    path: PathBuf,
    entries: Vec<(f64, String)>,
}

impl Series {
    /// A list that is written to `path`.
    pub fn new(path: PathBuf) -> Self {
        Series {
            path,
            entries: Vec::new(),
        }
    }

    /// Write a state and list it; `name` is relative to the folder of the list.
    pub fn add(&mut self, time: f64, name: &str, content: &str) -> Result<(), Error> {
        let folder = self.path.parent().unwrap_or(Path::new("."));
        file::write(&folder.join(name), content)?;
        self.entries.push((time, name.to_string()));
        let mut xml = String::from(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"LittleEndian\">\n<Collection>\n",
        );
        for (time, name) in &self.entries {
            let _ = writeln!(
                xml,
                "<DataSet timestep=\"{time:e}\" part=\"0\" file=\"{name}\"/>"
            );
        }
        xml += "</Collection>\n</VTKFile>\n";
        file::write(&self.path, &xml)
    }
}
