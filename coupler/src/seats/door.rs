//! From what crosses the boundary to what the coupler computes with, checked once.

use protocol::engine::{InitialGrains, MeshDescription};
use protocol::field::Field;
use protocol::message::Capability;
use protocol::partner::Partner;
use protocol::process;
use protocol::scene::Wall;
use space::{Vector, flat};

use crate::error::CouplerError;
use crate::state::{Contact, Grains};
use crate::transfer::mesh::Mesh;

/// Flat numbers as vectors.
pub fn vectors<const D: usize>(
    numbers: &[f64],
    what: &str,
) -> Result<Vec<Vector<D>>, CouplerError> {
    match flat::vectors(numbers) {
        Some(vectors) => Ok(vectors.to_vec()),
        None => Err(wrong_count(what, numbers.len(), D)),
    }
}

/// One vector of a scene.
pub fn vector<const D: usize>(numbers: &[f64], what: &str) -> Result<Vector<D>, CouplerError> {
    flat::vector(numbers).ok_or_else(|| wrong_count(what, numbers.len(), D))
}

/// Corners of a wall.
pub fn corners<const D: usize>(wall: &Wall) -> Result<[Vector<D>; D], CouplerError> {
    let corners = wall.corners.iter();
    let corners = corners
        .map(|corner| vector(corner, "wall"))
        .collect::<Result<Vec<_>, _>>()?;
    let count = corners.len();
    <[Vector<D>; D]>::try_from(corners).map_err(|_| wrong_count("wall", count, D))
}

/// Numbers that are no vectors of `dimension` components.
pub fn wrong_count(what: &str, count: usize, dimension: usize) -> CouplerError {
    CouplerError::Dimension {
        what: what.to_owned(),
        count,
        dimension,
    }
}

/// Contact states: 0 free, 1 touches, 2 held.
pub(super) fn contacts(numbers: &[f64], step: u64) -> Result<Vec<Contact>, CouplerError> {
    let contact = |(grain, number): (usize, &f64)| match *number {
        0.0 => Ok(Contact::Free),
        1.0 => Ok(Contact::Touches),
        2.0 => Ok(Contact::Held),
        number => Err(CouplerError::ContactState {
            step,
            grain,
            number,
        }),
    };
    numbers.iter().enumerate().map(contact).collect()
}

/// Contact states as they cross the boundary.
pub fn contact_numbers(contact: &[Contact]) -> Vec<f64> {
    let number = |state: &Contact| match state {
        Contact::Free => 0.0,
        Contact::Touches => 1.0,
        Contact::Held => 2.0,
    };
    contact.iter().map(number).collect()
}

/// The mesh of the fluid engine.
pub(super) fn mesh<const D: usize, const N: usize>(
    told: &MeshDescription,
) -> Result<Mesh<D, N>, CouplerError> {
    let corners = vectors::<D>(&told.simplex_position, "simplex_position")?;
    let nodes = &told.simplex_nodes;
    Ok(Mesh {
        node_position: vectors(&told.node_position, "node_position")?,
        simplices: nodes.as_chunks().0.to_vec(),
        corners: corners.as_chunks().0.to_vec(),
        nodal_mass: told.nodal_mass.clone(),
        period: period(&told.period)?,
    })
}

/// Period along each axis.
pub fn period<const D: usize>(told: &[Option<f64>]) -> Result<[Option<f64>; D], CouplerError> {
    <[Option<f64>; D]>::try_from(told).map_err(|_| wrong_count("period", told.len(), D))
}

/// Grains as they begin.
pub(super) fn grains<const D: usize>(told: &InitialGrains) -> Result<Grains<D>, CouplerError> {
    let count = told.mass.len();
    let velocity = vectors::<D>(&told.velocity, "grain_velocity")?;
    Ok(Grains {
        position: vectors(&told.position, "grain_position")?,
        mean_velocity: velocity.clone(),
        velocity,
        contact: vec![Contact::Free; count],
        spin: Vec::new(),
        contact_force: vec![Vector::zeros(); count],
        carried_force: vec![Vector::zeros(); count],
        mass: told.mass.clone(),
        volume: told.volume.clone(),
        radius: told.radius.clone(),
        fixed: told.fixed.iter().map(|&flag| flag != 0.0).collect(),
        id: (0..count as u64).collect(),
    })
}

/// Let an engine keep back what nobody reads with every candidate; says what it does keep back.
pub(super) fn withhold(
    partner: &mut Partner,
    unread: &[Field],
) -> Result<Vec<Field>, CouplerError> {
    let mut unread = unread.to_vec();
    let told = partner.hello().answer();
    unread.retain(|field| told.contains(field));
    if unread.is_empty() || !partner.may_withhold() || !process::may_leave_out() {
        return Ok(Vec::new());
    }
    partner.withhold(&unread)?;
    Ok(unread)
}

/// Can the engine do this?
pub fn can(partner: &Partner, capability: Capability) -> bool {
    partner.hello().capabilities.contains(&capability)
}
