//! ParaView files: one `.vtu` a state (binary, base64), and a `.pvd` that lists them with their
//! times, rewritten after every state so that a running computation can be looked at.

use std::fmt::Write as _;
use std::path::PathBuf;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use protocol::field::{Field, Rank};
use scene::Error;

use super::mesh::Mesh;
use crate::disk::Disk;
use crate::file::{self, sync};

/// Kind of a cell, by VTK's numbers.
const VERTEX: u8 = 1;
const TRIANGLE: u8 = 5;
const TETRAHEDRON: u8 = 10;

/// Numbers of a point and of a vector in a file, where the plane lies at z = 0.
const SPACE: usize = 3;

/// A time and a file name for each state of a list.
pub type Entries = Vec<(f64, String)>;

/// How a file is to be written.
#[derive(Debug, Clone, Copy)]
pub struct Style {
    /// Numbers of a point.
    pub dimension: usize,
    /// Are grains disks, per metre of depth?
    pub disks: bool,
    /// Time of the state \[s\].
    pub time: f64,
}

impl Style {
    /// `name [unit]`; a number without a unit has its name alone.
    fn label(&self, field: Field) -> String {
        match field.unit_among(self.dimension, self.disks) {
            "–" => field.name().to_string(),
            unit => format!("{} [{unit}]", field.name()),
        }
    }
}

/// Values at the points of a file.
struct PointData {
    name: String,
    width: usize,
    values: Vec<f64>,
}

impl PointData {
    /// ParaView expects vectors with three components.
    fn new(field: Field, style: &Style, values: Vec<f64>) -> PointData {
        let rank = field.spec().rank;
        let width = rank.components(style.dimension);
        let (width, values) = match rank {
            Rank::Vector => (SPACE, in_space(&values, width)),
            _ => (width, values),
        };
        PointData {
            name: style.label(field),
            width,
            values,
        }
    }
}

/// Points or vectors with zeros for the components that they lack.
fn in_space(values: &[f64], dimension: usize) -> Vec<f64> {
    let zeros = [0.0; SPACE];
    let padded = |v: &[f64]| -> [f64; SPACE] {
        let mut space = zeros;
        space[..dimension].copy_from_slice(v);
        space
    };
    values.chunks_exact(dimension).flat_map(padded).collect()
}

/// A state of the fluid: nodal fields on the mesh.
pub fn fluid(mesh: &Mesh, style: &Style, fields: &[(Field, &[f64])]) -> String {
    let width = |field: &Field| field.spec().rank.components(mesh.dimension);
    let data: Vec<PointData> = fields
        .iter()
        .filter(|(field, values)| values.len() == mesh.node_count * width(field))
        .map(|(field, values)| {
            let values = mesh.at_points(values, width(field));
            PointData::new(*field, style, values)
        })
        .collect();
    let cells = Cells {
        kind: match mesh.dimension {
            2 => TRIANGLE,
            _ => TETRAHEDRON,
        },
        corners: mesh.dimension + 1,
        connectivity: mesh.corners.iter().map(|&point| point.into()).collect(),
    };
    document(
        &in_space(&mesh.points, mesh.dimension),
        &cells,
        &data,
        style,
    )
}

/// A state of the grains: points with radius, velocity and what else was sent.
pub fn grains(style: &Style, position: &[f64], fields: &[(Field, &[f64])]) -> String {
    let dimension = style.dimension;
    let count = position.len() / dimension;
    let data: Vec<PointData> = fields
        .iter()
        .filter(|(field, values)| values.len() == count * field.spec().rank.components(dimension))
        .map(|(field, values)| PointData::new(*field, style, values.to_vec()))
        .collect();
    let cells = Cells {
        kind: VERTEX,
        corners: 1,
        connectivity: (0..count as i64).collect(),
    };
    document(&in_space(position, dimension), &cells, &data, style)
}

/// Cells of one kind, with as many points each.
struct Cells {
    kind: u8,
    corners: usize,
    connectivity: Vec<i64>,
}

impl Cells {
    fn count(&self) -> usize {
        self.connectivity.len() / self.corners
    }

    fn write(&self, xml: &mut String) {
        let ends: Vec<i64> = (1..=self.count())
            .map(|cell| (cell * self.corners) as i64)
            .collect();
        *xml += "<Cells>\n";
        array(xml, "Int64", "connectivity", 1, whole(&self.connectivity));
        array(xml, "Int64", "offsets", 1, whole(&ends));
        array(xml, "UInt8", "types", 1, vec![self.kind; self.count()]);
        *xml += "</Cells>\n";
    }
}

/// An unstructured grid of cells, with its time where ParaView looks for it.
fn document(points: &[f64], cells: &Cells, data: &[PointData], style: &Style) -> String {
    let mut xml = String::from("<?xml version=\"1.0\"?>\n");
    xml += "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n";
    xml += "<UnstructuredGrid>\n<FieldData>\n";
    array(&mut xml, "Float64", "TimeValue", 1, reals(&[style.time]));
    xml += "</FieldData>\n";
    // Writing to a string cannot fail.
    let _ = writeln!(
        xml,
        "<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n<PointData>",
        points.len() / SPACE,
        cells.count()
    );
    for column in data {
        let bytes = reals(&column.values);
        array(&mut xml, "Float64", &column.name, column.width, bytes);
    }
    xml += "</PointData>\n<Points>\n";
    array(&mut xml, "Float64", "position", SPACE, reals(points));
    xml += "</Points>\n";
    cells.write(&mut xml);
    xml += "</Piece>\n</UnstructuredGrid>\n</VTKFile>\n";
    xml
}

fn reals(values: &[f64]) -> Vec<u8> {
    values
        .iter()
        .flat_map(|value| value.to_le_bytes())
        .collect()
}

fn whole(values: &[i64]) -> Vec<u8> {
    values
        .iter()
        .flat_map(|value| value.to_le_bytes())
        .collect()
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
    entries: Entries,
}

impl Series {
    /// A list that is written to `path`.
    pub fn new(path: PathBuf) -> Self {
        Series {
            path,
            entries: Vec::new(),
        }
    }

    /// A list that goes on after these states.
    pub fn resume(path: PathBuf, entries: Entries) -> Result<Self, Error> {
        let series = Series { path, entries };
        if !series.entries.is_empty() {
            file::write(&series.path, series.text())?;
        }
        Ok(series)
    }

    /// Time and name of each state.
    pub fn entries(&self) -> &Entries {
        &self.entries
    }

    /// The list and its states are on the disk after this, from the state `first` on.
    pub fn sync(&self, first: usize) -> Result<(), Error> {
        let states = self.entries.iter().skip(first);
        for (_, name) in states {
            sync(&self.path.with_file_name(name))?;
        }
        match self.entries.is_empty() {
            true => Ok(()),
            false => sync(&self.path),
        }
    }

    /// Write a state and list it; `name` is relative to the folder of the list. A state that cannot be listed
    /// does not stay.
    pub fn add(&mut self, time: f64, name: &str, content: &str, disk: &Disk) -> Result<(), Error> {
        let state = self.path.with_file_name(name);
        disk.write(&state, content)?;
        self.entries.push((time, name.to_string()));
        disk.write(&self.path, self.text()).inspect_err(|_| {
            let _ = std::fs::remove_file(&state);
        })
    }

    fn text(&self) -> String {
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
        xml
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vtu::read::State;

    /// One simplex from the origin along the axes, with a velocity, and one grain in it.
    fn written(dimension: usize) -> [String; 2] {
        let mut points = vec![0.0; dimension * (dimension + 1)];
        for axis in 0..dimension {
            points[(axis + 1) * dimension + axis] = 1.0;
        }
        let mesh = Mesh {
            dimension,
            points,
            node_of: (0..=dimension as u32).collect(),
            corners: (0..=dimension as u32).collect(),
            node_count: dimension + 1,
        };
        let velocity: Vec<f64> = (0..dimension * (dimension + 1)).map(|k| k as f64).collect();
        let pressure = vec![7.0; dimension + 1];
        let grain = vec![0.25; dimension];
        let style = Style {
            dimension,
            disks: dimension == 2,
            time: 0.5,
        };
        [
            fluid(
                &mesh,
                &style,
                &[
                    (Field::InterstitialVelocity, &velocity),
                    (Field::Pressure, &pressure),
                ],
            ),
            grains(
                &style,
                &grain,
                &[
                    (Field::GrainVelocity, &grain),
                    (Field::GrainMass, &[2.0]),
                    (Field::GrainFixed, &[1.0]),
                ],
            ),
        ]
    }

    #[test]
    fn names_have_units_and_files_their_time() {
        for (dimension, mass) in [(2, "grain_mass [kg/m]"), (3, "grain_mass [kg]")] {
            let [fluid, grains] = written(dimension);
            assert!(fluid.contains("\"pressure [Pa]\""), "{fluid}");
            for name in ["grain_velocity [m/s]", mass, "grain_fixed"] {
                assert!(grains.contains(&format!("\"{name}\"")), "{grains}");
            }
            for state in [fluid, grains].map(State::from_text) {
                assert_eq!(state.numbers("TimeValue").expect("read"), Some(vec![0.5]));
            }
        }
    }

    #[test]
    fn triangles_and_tetrahedra_are_written_with_vectors_of_three_components() {
        for (dimension, kind) in [(2, TRIANGLE), (3, TETRAHEDRON)] {
            let [fluid, grains] = written(dimension).map(State::from_text);
            let numbers = |state: &State, name| state.numbers(name).expect("read").expect(name);
            let mut corner = vec![0.0; 3 * (dimension + 1)];
            (0..dimension).for_each(|axis| corner[3 * (axis + 1) + axis] = 1.0);
            assert_eq!(numbers(&fluid, "position"), corner);
            let velocity = numbers(&fluid, "interstitial_velocity");
            println!("{dimension}: {velocity:?}");
            assert_eq!(velocity.len(), 3 * (dimension + 1));
            assert_eq!(velocity[3], dimension as f64);
            assert_eq!(numbers(&fluid, "pressure"), vec![7.0; dimension + 1]);
            let ends = fluid.indices("offsets").expect("read").expect("offsets");
            assert_eq!(ends, [dimension as i64 + 1]);
            assert_eq!(fluid.bytes("types").expect("read"), Some(vec![kind]));
            let mut grain = vec![0.25; dimension];
            grain.resize(3, 0.0);
            assert_eq!(numbers(&grains, "position"), grain);
            assert_eq!(numbers(&grains, "grain_velocity"), grain);
        }
    }
}
