//! The plane or space, of which every map is made.

use std::fmt::Display;

/// Where a scene is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dimension {
    /// Triangles and disks.
    Plane,
    /// Tetrahedra and spheres.
    Space,
}

impl Dimension {
    /// Of so many axes.
    pub fn of(axes: u8) -> Option<Dimension> {
        match axes {
            2 => Some(Dimension::Plane),
            3 => Some(Dimension::Space),
            _ => None,
        }
    }

    /// Number of axes.
    pub fn axes(self) -> usize {
        match self {
            Dimension::Plane => 2,
            Dimension::Space => 3,
        }
    }

    /// A vector of a scene: this along each axis across gravity, this upward.
    pub(crate) fn vector(self, across: impl Display, up: impl Display) -> String {
        match self {
            Dimension::Plane => format!("[{across}, {up}]"),
            Dimension::Space => format!("[{across}, {up}, {across}]"),
        }
    }

    /// The same in metres, or another unit.
    pub(crate) fn place(self, across: f64, up: f64) -> String {
        self.vector(format!("{across:e}"), format!("{up:e}"))
    }

    /// Edge of a square or cube of this content.
    pub(crate) fn edge(self, content: f64) -> f64 {
        match self {
            Dimension::Plane => content.sqrt(),
            Dimension::Space => content.cbrt(),
        }
    }
}
