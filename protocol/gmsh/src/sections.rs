//! The sections of format 4.1, the same in ASCII and binary.

use crate::cursor::{Cursor, Fault};
use crate::file::{Element, Entity, File};
use crate::kind::{Kind, kind};

/// Points, curves, surfaces and volumes with their physical groups; of a partitioned mesh with their
/// parents.
pub(crate) fn entities(
    file: &mut File,
    cursor: &mut Cursor<'_>,
    partitioned: bool,
) -> Result<(), Fault> {
    if partitioned {
        cursor.size()?;
        for _ in 0..cursor.count("ghost entities")? {
            cursor.int()?;
            cursor.int()?;
        }
    }
    let mut counts = [0; 4];
    for count in &mut counts {
        *count = cursor.count("entities")?;
    }
    for (dimension, count) in counts.into_iter().enumerate() {
        for _ in 0..count {
            let (number, entity) = entity(cursor, dimension, partitioned)?;
            file.entities.insert((dimension, number), entity);
        }
    }
    Ok(())
}

fn entity(
    cursor: &mut Cursor<'_>,
    dimension: usize,
    partitioned: bool,
) -> Result<(i64, Entity), Fault> {
    let number = cursor.int()?;
    let parent = match partitioned {
        true => Some((cursor.int()? as usize, cursor.int()?)),
        false => None,
    };
    if partitioned {
        numbers(cursor, "partitions")?;
    }
    for _ in 0..if dimension == 0 { 3 } else { 6 } {
        cursor.real()?;
    }
    let groups = numbers(cursor, "physical groups")?;
    if dimension > 0 {
        numbers(cursor, "bounding entities")?;
    }
    // The sign tells a direction.
    let groups = groups.iter().map(|group| group.abs()).collect();
    Ok((number, Entity { groups, parent }))
}

/// A count and as many numbers.
fn numbers(cursor: &mut Cursor<'_>, what: &str) -> Result<Vec<i64>, Fault> {
    let count = cursor.count(what)?;
    (0..count).map(|_| cursor.int()).collect()
}

pub(crate) fn nodes(file: &mut File, cursor: &mut Cursor<'_>) -> Result<(), Fault> {
    let blocks = blocks(cursor)?;
    for _ in 0..blocks {
        let dimension = cursor.int()?;
        cursor.int()?;
        let parameters = if cursor.int()? == 0 { 0 } else { dimension };
        let count = cursor.count("nodes")?;
        let mut tags = Vec::new();
        for _ in 0..count {
            tags.push(cursor.size()?);
        }
        for tag in tags {
            let at = [cursor.real()?, cursor.real()?, cursor.real()?];
            file.add_node(cursor, tag, at)?;
            for _ in 0..parameters {
                cursor.real()?;
            }
        }
    }
    Ok(())
}

/// How many blocks follow.
fn blocks(cursor: &mut Cursor<'_>) -> Result<usize, Fault> {
    let blocks = cursor.count("blocks")?;
    for _ in 0..3 {
        cursor.size()?;
    }
    Ok(blocks)
}

pub(crate) fn elements(file: &mut File, cursor: &mut Cursor<'_>) -> Result<(), Fault> {
    for _ in 0..blocks(cursor)? {
        cursor.int()?;
        let entity = cursor.int()?;
        let kind = kind_of(cursor)?;
        for _ in 0..cursor.count("elements")? {
            let number = cursor.size()?;
            let element = element(file, cursor, kind, number, entity, |c| c.size())?;
            file.elements.push(element);
        }
    }
    Ok(())
}

/// The kind of the elements that follow.
pub(crate) fn kind_of(cursor: &mut Cursor<'_>) -> Result<Kind, Fault> {
    let number = cursor.int()?;
    let unknown = || cursor.fault(format!("element type {number} is not known"));
    kind(number).ok_or_else(unknown)
}

/// The element whose nodes follow; without a group.
pub(crate) fn element(
    file: &File,
    cursor: &mut Cursor<'_>,
    kind: Kind,
    number: u64,
    entity: i64,
    node: fn(&mut Cursor<'_>) -> Result<u64, Fault>,
) -> Result<Element, Fault> {
    let mut nodes = [0; 8];
    for k in 0..kind.nodes {
        let tag = node(cursor)?;
        if !file.nodes.contains_key(&tag) {
            return Err(cursor.fault(format!("element {number}: node {tag} does not exist")));
        }
        if k < kind.corners {
            nodes[k] = tag;
        }
    }
    Ok(Element {
        number,
        dimension: kind.dimension,
        corners: kind.corners,
        nodes,
        curved: kind.nodes > kind.corners,
        entity,
        group: None,
    })
}
