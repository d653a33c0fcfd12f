//! From bytes to what a file says.

use std::path::Path;

use crate::cursor::{Cursor, Fault};
use crate::error::Error;
use crate::file::File;
use crate::{legacy, sections};

impl File {
    /// Read a file.
    pub fn read(path: &Path) -> Result<File, Error> {
        let bytes = std::fs::read(path).map_err(|source| Error::File {
            path: path.to_path_buf(),
            source,
        })?;
        File::parse(path, &bytes)
    }

    /// The same from the bytes of a file; `path` is for messages.
    pub fn parse(path: &Path, bytes: &[u8]) -> Result<File, Error> {
        let mut file = File {
            path: path.to_path_buf(),
            ..File::default()
        };
        file.fill(bytes).map_err(|fault| Error::Syntax {
            path: path.to_path_buf(),
            place: fault.place,
            why: fault.why,
        })?;
        Ok(file)
    }

    fn fill(&mut self, bytes: &[u8]) -> Result<(), Fault> {
        let mut cursor = Cursor::new(bytes);
        let mut old = None;
        while let Some(section) = cursor.next_section() {
            let read = match (section.as_str(), old) {
                ("MeshFormat", _) => self.format(&mut cursor).map(|is_old| old = Some(is_old)),
                ("PhysicalNames" | "Entities" | "Nodes" | "Elements", None) => {
                    Err(cursor.fault("no $MeshFormat before this section"))
                }
                ("PhysicalNames", _) => self.physical_names(&mut cursor),
                ("Nodes", Some(true)) => legacy::nodes(self, &mut cursor),
                ("Elements", Some(true)) => legacy::elements(self, &mut cursor),
                ("Entities", Some(false)) => sections::entities(self, &mut cursor, false),
                ("PartitionedEntities", Some(false)) => sections::entities(self, &mut cursor, true),
                ("Nodes", Some(false)) => sections::nodes(self, &mut cursor),
                ("Elements", Some(false)) => sections::elements(self, &mut cursor),
                _ => {
                    cursor.skip(&section)?;
                    continue;
                }
            };
            read?;
            cursor.end(&section)?;
        }
        match old {
            Some(_) => Ok(()),
            None => Err(cursor.fault("no $MeshFormat: this is not a Gmsh file")),
        }
    }

    /// Version, binary or not, size of `size_t`; true: the format before 4.
    fn format(&mut self, cursor: &mut Cursor<'_>) -> Result<bool, Fault> {
        let version: String = cursor.text()?;
        let old = match version.as_str() {
            "2" | "2.0" | "2.1" | "2.2" => true,
            "4.1" => false,
            _ => {
                return Err(cursor.fault(format!(
                    "format {version}; 2.2 and 4.1 are read (gmsh: Mesh.MshFileVersion = 4.1)"
                )));
            }
        };
        let (binary, size): (u8, usize) = (cursor.text()?, cursor.text()?);
        if binary == 1 {
            if ![4, 8].contains(&size) {
                return Err(cursor.fault(format!("numbers of {size} bytes; 4 or 8 are read")));
            }
            cursor.byte_order(size)?;
        }
        self.format = format!(
            "{version}, {}",
            ["ASCII", "binary"][usize::from(binary == 1)]
        );
        Ok(old)
    }

    fn physical_names(&mut self, cursor: &mut Cursor<'_>) -> Result<(), Fault> {
        let count: u64 = cursor.text()?;
        for _ in 0..cursor.bounded(count, "names")? {
            let key = (cursor.text()?, cursor.text()?);
            self.names.insert(key, cursor.name());
        }
        Ok(())
    }
}
