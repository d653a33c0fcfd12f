//! What a file says: names, entities, nodes, elements.

use std::collections::BTreeMap;
use std::path::PathBuf;

use crate::cursor::{Cursor, Fault};

/// Dimension and number of an entity or a physical group.
pub type Key = (usize, i64);

/// A point, curve, surface or volume of the geometry.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Entity {
    /// Physical groups that it belongs to, of its own dimension.
    pub groups: Vec<i64>,
    /// The entity that a partition cut it from.
    pub parent: Option<Key>,
}

/// A file, as it is written.
#[derive(Debug, Clone, Default)]
pub struct File {
    /// Where it was read.
    pub path: PathBuf,
    /// E.g. "4.1, binary".
    pub format: String,
    /// Names of physical groups.
    pub names: BTreeMap<Key, String>,
    /// Entities, where the format has them.
    pub entities: BTreeMap<Key, Entity>,
    /// Coordinates of each node, by its number.
    pub nodes: BTreeMap<u64, [f64; 3]>,
    /// All elements, in their order.
    pub elements: Vec<Element>,
}

/// An element.
#[derive(Debug, Clone, PartialEq)]
pub struct Element {
    /// Its number.
    pub number: u64,
    /// Its dimension.
    pub dimension: usize,
    /// How many corners it has.
    pub corners: usize,
    /// Nodes of its corners, and 0.
    pub nodes: [u64; 8],
    /// Has it nodes beside its corners?
    pub curved: bool,
    /// The entity it lies on.
    pub entity: i64,
    /// Its physical group, where an element says so; else they are those of its entity.
    pub group: Option<i64>,
}

impl File {
    /// Take a node; a number that is there already, and coordinates that are not finite, are faults.
    pub(crate) fn add_node(
        &mut self,
        cursor: &Cursor<'_>,
        number: u64,
        at: [f64; 3],
    ) -> Result<(), Fault> {
        if !at.iter().all(|value| value.is_finite()) {
            return Err(cursor.fault(format!("node {number}: coordinates are not finite")));
        }
        match self.nodes.insert(number, at) {
            None => Ok(()),
            Some(_) => Err(cursor.fault(format!("node {number} appears twice"))),
        }
    }

    /// What an element says that it lies on: names of its physical groups, the number of one without a
    /// name, or without a group the number of its entity. Nothing on what only a partition made.
    pub fn labels(&self, element: &Element) -> Vec<String> {
        let dimension = element.dimension;
        let entity = self.entities.get(&(dimension, element.entity));
        let groups: &[i64] = match (&element.group, entity) {
            (Some(0), _) => &[],
            (Some(group), _) => std::slice::from_ref(group),
            (None, entity) => entity.map_or(&[], |entity| &entity.groups),
        };
        let name = |group: &i64| {
            let name = self.names.get(&(dimension, *group));
            name.cloned().unwrap_or_else(|| group.to_string())
        };
        if !groups.is_empty() {
            return groups.iter().map(name).collect();
        }
        match entity.and_then(|entity| entity.parent) {
            Some((of, number)) if of == dimension => vec![number.to_string()],
            Some(_) => Vec::new(),
            None => vec![element.entity.to_string()],
        }
    }

    /// Does an element belong to a physical group?
    pub fn is_grouped(&self, element: &Element) -> bool {
        match element.group {
            Some(group) => group != 0,
            None => {
                let entity = self.entities.get(&(element.dimension, element.entity));
                entity.is_some_and(|entity| !entity.groups.is_empty())
            }
        }
    }
}
