//! The sections of format 2.2.

use crate::cursor::{Cursor, Fault};
use crate::file::{Element, File};
use crate::kind::Kind;
use crate::sections::{element, kind_of};

pub(crate) fn nodes(file: &mut File, cursor: &mut Cursor<'_>) -> Result<(), Fault> {
    let count: u64 = cursor.text()?;
    let count = cursor.bounded(count, "nodes")?;
    cursor.begin_numbers();
    for _ in 0..count {
        let number = whole(cursor)?;
        let at = [cursor.real()?, cursor.real()?, cursor.real()?];
        file.add_node(cursor, number, at)?;
    }
    Ok(())
}

/// In ASCII each element says its type; in a binary file a head says it of those that follow.
pub(crate) fn elements(file: &mut File, cursor: &mut Cursor<'_>) -> Result<(), Fault> {
    let count: u64 = cursor.text()?;
    let count = cursor.bounded(count, "elements")?;
    cursor.begin_numbers();
    let mut read = 0;
    while read < count {
        if cursor.layout.is_none() {
            let (number, kind, tags) = (whole(cursor)?, kind_of(cursor)?, whole(cursor)?);
            let element = tagged(file, cursor, kind, number, tags)?;
            file.elements.push(element);
            read += 1;
            continue;
        }
        let (kind, following, tags) = (kind_of(cursor)?, whole(cursor)?, whole(cursor)?);
        if following == 0 {
            return Err(cursor.fault("a block of 0 elements"));
        }
        for _ in 0..cursor.bounded(following, "elements")? {
            let number = whole(cursor)?;
            let element = tagged(file, cursor, kind, number, tags)?;
            file.elements.push(element);
            read += 1;
        }
    }
    Ok(())
}

/// An element with its tags: physical group (0: none), entity, partitions.
fn tagged(
    file: &File,
    cursor: &mut Cursor<'_>,
    kind: Kind,
    number: u64,
    tags: u64,
) -> Result<Element, Fault> {
    let (mut group, mut entity) = (0, 0);
    for k in 0..cursor.bounded(tags, "tags")? {
        let tag = cursor.int()?;
        match k {
            0 => group = tag.abs(),
            1 => entity = tag,
            _ => {}
        }
    }
    Ok(Element {
        group: Some(group),
        ..element(file, cursor, kind, number, entity, whole)?
    })
}

/// An `int` that is not negative.
fn whole(cursor: &mut Cursor<'_>) -> Result<u64, Fault> {
    let number = cursor.int()?;
    let negative = |_| cursor.fault(format!("{number}: must not be negative"));
    u64::try_from(number).map_err(negative)
}
