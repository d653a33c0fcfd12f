//! Gmsh 4.1 ASCII files with named physical curves.
//!
//! Parsed here rather than with a crate so that every complaint carries the line it is about.
//! Read are `$MeshFormat`, `$PhysicalNames`, `$Entities`, `$Nodes` and `$Elements`; other sections
//! are skipped. A boundary's name is the physical name of the curve its edges lie on.

use std::collections::BTreeMap;
use std::path::Path;

use space::Vector;

use super::simplices::Mesh;
use crate::error::FluidError;

const LINE: i64 = 1;
const TRIANGLE: i64 = 2;
const POINT: i64 = 15;

/// Read a mesh.
pub fn read(path: &Path) -> Result<Mesh<2, 3>, FluidError> {
    let bytes = std::fs::read(path).map_err(|source| FluidError::MeshFile {
        path: path.to_path_buf(),
        source,
    })?;
    let text = String::from_utf8_lossy(&bytes);
    parse(path, &text)
}

/// Read a mesh from the text of a file; `path` is for messages.
pub fn parse(path: &Path, text: &str) -> Result<Mesh<2, 3>, FluidError> {
    let mut reader = Reader {
        path,
        lines: text.lines(),
        number: 0,
    };
    let mut parts = Parts::default();
    while let Some(section) = reader.next_section() {
        match section {
            "$MeshFormat" => reader.format()?,
            "$PhysicalNames" => parts.physical_names(&mut reader)?,
            "$Entities" => parts.entities(&mut reader)?,
            "$Nodes" => parts.nodes(&mut reader)?,
            "$Elements" => parts.elements(&mut reader)?,
            _ => {}
        }
        reader.skip_to_end(section)?;
    }
    parts.mesh(&reader)
}

/// The lines of the file with their numbers.
struct Reader<'a> {
    path: &'a Path,
    lines: std::str::Lines<'a>,
    number: usize,
}

impl<'a> Reader<'a> {
    fn error(&self, why: impl Into<String>) -> FluidError {
        FluidError::GmshSyntax {
            path: self.path.to_path_buf(),
            line: self.number,
            why: why.into(),
        }
    }

    fn line(&mut self) -> Result<&'a str, FluidError> {
        self.number += 1;
        self.lines
            .next()
            .map(str::trim)
            .ok_or_else(|| self.error("the file ends here, inside a section"))
    }

    fn next_section(&mut self) -> Option<&'a str> {
        for line in self.lines.by_ref() {
            self.number += 1;
            let line = line.trim();
            if line.starts_with('$') && !line.starts_with("$End") {
                return Some(line);
            }
        }
        None
    }

    fn skip_to_end(&mut self, section: &str) -> Result<(), FluidError> {
        let end = format!("$End{}", &section[1..]);
        loop {
            let line = self.line()?;
            if line == end {
                return Ok(());
            }
            if line.starts_with('$') {
                return Err(self.error(format!("{line} before {end}")));
            }
        }
    }

    /// The numbers of one line, `count` at least.
    fn numbers<T: std::str::FromStr>(&mut self, count: usize) -> Result<Vec<T>, FluidError> {
        let line = self.line()?;
        let parsed: Result<Vec<T>, _> = line.split_whitespace().map(str::parse).collect();
        match parsed {
            Ok(values) if values.len() >= count => Ok(values),
            _ => Err(self.error(format!("{line:?}: {count} numbers expected"))),
        }
    }

    fn format(&mut self) -> Result<(), FluidError> {
        let line = self.line()?;
        let mut words = line.split_whitespace();
        match (words.next(), words.next()) {
            (Some("4.1"), Some("0")) => Ok(()),
            (Some("4.1"), Some("1")) => {
                Err(self.error("binary file; save it as ASCII (Mesh.Binary = 0)"))
            }
            (Some(version), _) => Err(self.error(format!(
                "format {version}; only 4.1 is read (gmsh: Mesh.MshFileVersion = 4.1)"
            ))),
            _ => Err(self.error("no format version; \"4.1 0 8\" expected")),
        }
    }
}

/// What has been read so far.
#[derive(Default)]
struct Parts {
    /// Physical tag of curves → name.
    names: BTreeMap<i64, String>,
    /// Curve tag → physical tags.
    curves: BTreeMap<i64, Vec<i64>>,
    /// Node tag → position.
    nodes: BTreeMap<i64, Vector<2>>,
    /// (element tag, node tags).
    triangles: Vec<(usize, [i64; 3])>,
    /// (node tags, curve tag).
    edges: Vec<([i64; 2], i64)>,
}

impl Parts {
    fn physical_names(&mut self, reader: &mut Reader<'_>) -> Result<(), FluidError> {
        let count = reader.numbers::<usize>(1)?[0];
        for _ in 0..count {
            let line = reader.line()?;
            let mut words = line.splitn(3, ' ');
            let dimension = words.next().and_then(|w| w.parse::<i64>().ok());
            let tag = words.next().and_then(|w| w.parse::<i64>().ok());
            let name = words.next().map(|w| w.trim().trim_matches('"'));
            let (Some(dimension), Some(tag), Some(name)) = (dimension, tag, name) else {
                return Err(reader.error(format!("{line:?}: 'dimension tag \"name\"' expected")));
            };
            if dimension == 1 {
                self.names.insert(tag, name.to_string());
            }
        }
        Ok(())
    }

    /// Points: tag x y z n physical…; curves: tag box(6) n physical… ; surfaces are not needed.
    fn entities(&mut self, reader: &mut Reader<'_>) -> Result<(), FluidError> {
        let counts = reader.numbers::<usize>(4)?;
        for _ in 0..counts[0] {
            reader.line()?;
        }
        for _ in 0..counts[1] {
            let values = reader.numbers::<f64>(8)?;
            let count = values[7] as usize;
            let Some(tags) = values.get(8..8 + count) else {
                return Err(reader.error(format!("{count} physical tags expected after the count")));
            };
            let tags = tags.iter().map(|&tag| (tag as i64).abs()).collect();
            self.curves.insert(values[0] as i64, tags);
        }
        Ok(())
    }

    fn nodes(&mut self, reader: &mut Reader<'_>) -> Result<(), FluidError> {
        let blocks = reader.numbers::<usize>(4)?[0];
        let mut height: Option<f64> = None;
        for _ in 0..blocks {
            let count = reader.numbers::<i64>(4)?[3] as usize;
            let mut tags = Vec::new();
            for _ in 0..count {
                tags.push(reader.numbers::<i64>(1)?[0]);
            }
            for tag in tags {
                let x = reader.numbers::<f64>(3)?;
                if !x[..3].iter().all(|value| value.is_finite()) {
                    return Err(reader.error(format!("node {tag}: coordinates are not finite")));
                }
                if *height.get_or_insert(x[2]) != x[2] {
                    return Err(reader.error(format!(
                        "node {tag}: z = {} differs; the mesh must be plane",
                        x[2]
                    )));
                }
                if self.nodes.insert(tag, Vector::from([x[0], x[1]])).is_some() {
                    return Err(reader.error(format!("node {tag} appears twice")));
                }
            }
        }
        Ok(())
    }

    fn elements(&mut self, reader: &mut Reader<'_>) -> Result<(), FluidError> {
        let blocks = reader.numbers::<usize>(4)?[0];
        for _ in 0..blocks {
            let head = reader.numbers::<i64>(4)?;
            let (entity, kind, count) = (head[1], head[2], head[3]);
            if ![LINE, TRIANGLE, POINT].contains(&kind) {
                return Err(reader.error(format!(
                    "element type {kind} of entity {entity}; only lines (1), triangles (2) and points (15)"
                )));
            }
            for _ in 0..count {
                self.element(reader, entity, kind)?;
            }
        }
        Ok(())
    }

    fn element(
        &mut self,
        reader: &mut Reader<'_>,
        curve: i64,
        kind: i64,
    ) -> Result<(), FluidError> {
        let corners = match kind {
            LINE => 2,
            TRIANGLE => 3,
            _ => 1,
        };
        let values = reader.numbers::<i64>(1 + corners)?;
        if let Some(unknown) = values[1..=corners]
            .iter()
            .find(|tag| !self.nodes.contains_key(tag))
        {
            return Err(reader.error(format!(
                "element {}: node {unknown} does not exist",
                values[0]
            )));
        }
        match kind {
            LINE => self.edges.push(([values[1], values[2]], curve)),
            TRIANGLE => self
                .triangles
                .push((values[0] as usize, [values[1], values[2], values[3]])),
            _ => {}
        }
        Ok(())
    }

    /// Nodes of triangles, numbered in the order of their tags; edges by physical name.
    fn mesh(self, reader: &Reader<'_>) -> Result<Mesh<2, 3>, FluidError> {
        if self.triangles.is_empty() {
            return Err(reader.error("no triangles; does a physical surface cover the domain?"));
        }
        let mut index: BTreeMap<i64, usize> = BTreeMap::new();
        for (_, nodes) in &self.triangles {
            index.extend(nodes.iter().map(|&tag| (tag, 0)));
        }
        index
            .values_mut()
            .enumerate()
            .for_each(|(k, slot)| *slot = k);
        let position = index.keys().map(|tag| self.nodes[tag]).collect();
        let triangles = self
            .triangles
            .iter()
            .map(|(_, t)| t.map(|tag| index[&tag]))
            .collect();
        let mut names: Vec<String> = self.names.values().cloned().collect();
        names.sort();
        names.dedup();
        let mut named = Vec::new();
        for &([a, b], curve) in &self.edges {
            let physical = self.curves.get(&curve).map_or(&[][..], |tags| tags);
            let mut found: Vec<&String> = physical
                .iter()
                .filter_map(|tag| self.names.get(tag))
                .collect();
            found.sort();
            found.dedup();
            for name in found {
                let (Some(&a), Some(&b)) = (index.get(&a), index.get(&b)) else {
                    return Err(reader.error(format!(
                        "an edge of curve {curve} ({name:?}) touches no triangle"
                    )));
                };
                named.push(([a, b], names.partition_point(|known| known < name)));
            }
        }
        let tags: Vec<usize> = self.triangles.iter().map(|(tag, _)| *tag).collect();
        Mesh::new(position, triangles, names, &named, |t| tags[t])
    }
}
