//! What an engine said, looked at before it is used.

use crate::language::codec;
use crate::language::engine::MeshDescription;
use crate::language::error::Error;
use crate::language::field::Field;
use crate::language::header::FieldHeader;
use crate::language::message::{Capability, Done, Failure, FailureKind, Hello, ToCoupler};
use crate::language::report::Report;
use crate::language::role::Role;
use crate::language::scene::FluidScene;
use crate::transport::exchange::Counts;

/// The message in these bytes, its header checked.
pub(crate) fn parse(
    who: &str,
    step: u64,
    header: &FieldHeader,
    bytes: &[u8],
) -> Result<ToCoupler, Error> {
    header.validate_message(who, bytes.len())?;
    codec::decode(bytes).map_err(|e| Error::invalid(who, step, "message", e.to_string()))
}

/// The error of a message at the wrong moment.
pub(crate) fn unexpected(who: &str, step: u64, message: &ToCoupler, expected: &str) -> Error {
    let kind = match message {
        ToCoupler::Hello(_) => "Hello",
        ToCoupler::Ready(_) => "Ready",
        ToCoupler::Done(_) => "Done",
        ToCoupler::Stored => "Stored",
        ToCoupler::Failed(_) => "Failed",
        ToCoupler::Told { .. } => "Told",
        ToCoupler::Kept => "Kept",
    };
    Error::invalid(
        who,
        step,
        "message",
        format!("{kind} where {expected} was expected"),
    )
}

/// A number of nodes, triangles or grains that memory can hold.
pub(crate) fn count(who: &str, what: &str, value: u64) -> Result<usize, Error> {
    const MOST: u64 = 1 << 28;
    if value > MOST {
        return Err(Error::invalid(
            who,
            0,
            "Ready",
            format!("{value} {what}, at most {MOST} are possible"),
        ));
    }
    Ok(value as usize)
}

/// Is it the candidate asked for, with every field that is wanted?
pub(crate) fn check_done(
    role: Role,
    (step, pass): (u64, u32),
    done: &Done,
    outputs: &[(Field, &mut Vec<f64>)],
) -> Result<(), Error> {
    let invalid = |why| Err(Error::invalid(role.seat(), step, "Done", why));
    if (role == Role::Fluid) != matches!(done.report, Report::Fluid(_)) {
        return invalid("its report is that of another seat".to_owned());
    }
    if (done.step, done.pass) != (step, pass) {
        return invalid(format!(
            "step {} pass {}, expected {} and {}",
            done.step, done.pass, step, pass
        ));
    }
    if let Some((missing, _)) = outputs
        .iter()
        .find(|(wanted, _)| !done.fields.contains(wanted))
    {
        return invalid(format!("it does not send {}", missing.name()));
    }
    for (place, field) in done.fields.iter().enumerate() {
        if done.fields[..place].contains(field) {
            return invalid(format!("it lists {} twice", field.name()));
        }
    }
    Ok(())
}

/// What it reports must be finite; otherwise the candidate failed, as if the engine had said so.
pub(crate) fn require_finite_report(who: &str, step: u64, done: &Done) -> Result<(), Error> {
    let told = done.diagnostics.iter().find(|d| !d.value.is_finite());
    let told = told.map(|d| (d.name.as_str(), d.value));
    match done.report.not_finite().or(told) {
        None => Ok(()),
        Some((name, value)) => Err(Error::Engine {
            who: who.to_owned(),
            step,
            failure: Failure::new(FailureKind::NotFinite, format!("its {name} is {value}")),
        }),
    }
}

/// The scene asks for a mean flow, or for cells, that this engine does not go by.
pub(crate) fn require_able(hello: &Hello, scene: &FluidScene) -> Result<(), Error> {
    let (able, engine) = (&hello.capabilities, &hello.engine);
    let why = if scene.mean_flow.is_steered() && !able.contains(&Capability::SteersMeanFlow) {
        format!(
            "the scene steers the mean flow (fluid.mean_flow), which {engine} cannot do (capability \
             SteersMeanFlow): write mean_flow = \"free\", or leave [engines] fluid out"
        )
    } else if scene.refinement.is_some() && !able.contains(&Capability::Adapts) {
        format!(
            "the scene says how large cells are (fluid.refinement), which {engine} does not go by (capability \
             Adapts): leave that table out, or [engines] fluid"
        )
    } else {
        return Ok(());
    };
    Err(Error::Engine {
        who: hello.role.seat().to_owned(),
        step: 0,
        failure: Failure::new(FailureKind::Scene, why),
    })
}

/// Does an engine answer in the dimension that it was asked for?
pub(crate) fn same_dimension(who: &str, asked: usize, told: u32) -> Result<(), Error> {
    if told as usize == asked {
        return Ok(());
    }
    let why = format!("{told} dimensions, expected {asked}");
    Err(Error::invalid(who, 0, "Ready", why))
}

/// Node numbers of the corners, whole and within the mesh.
pub(crate) fn corners(who: &str, counts: &Counts, numbers: &[f64]) -> Result<Vec<u32>, Error> {
    let nodes = counts.nodes;
    let corner = |(place, &number): (usize, &f64)| {
        if number.fract() == 0.0 && (0.0..nodes as f64).contains(&number) {
            return Ok(number as u32);
        }
        let why = format!(
            "corner {number} of simplex {}, must be a whole number from 0 to {}",
            place / (counts.dimension + 1),
            nodes as i64 - 1
        );
        Err(Error::invalid(who, 0, "simplex_nodes", why))
    };
    numbers.iter().enumerate().map(corner).collect()
}

/// Boundaries of the facets, whole numbers of those that there are.
pub(crate) fn facet_boundaries(
    who: &str,
    count: usize,
    numbers: &[f64],
) -> Result<Vec<u32>, Error> {
    let boundary = |(facet, &number): (usize, &f64)| {
        if number.fract() == 0.0 && (0.0..count as f64).contains(&number) {
            return Ok(number as u32);
        }
        let why = format!("boundary {number} of facet {facet}, there are {count} boundaries");
        Err(Error::invalid(who, 0, "facet_boundary", why))
    };
    numbers.iter().enumerate().map(boundary).collect()
}

/// Can shape functions be made on it?
pub(crate) fn check_mesh(who: &str, mesh: &MeshDescription) -> Result<(), Error> {
    let invalid = |what: &str, why| Err(Error::invalid(who, 0, what, why));
    if mesh.simplex_nodes.is_empty() {
        return invalid("mesh", "it has no simplex".to_owned());
    }
    if mesh.period.len() != mesh.dimension {
        let why = format!("{} periods, must be {}", mesh.period.len(), mesh.dimension);
        return invalid("Ready", why);
    }
    let mut periods = mesh.period.iter().flatten();
    if let Some(period) = periods.find(|p| !(p.is_finite() && **p > 0.0)) {
        return invalid("Ready", format!("a period of {period} m, must be positive"));
    }
    if let Some(node) = mesh.nodal_mass.iter().position(|&mass| mass <= 0.0) {
        return invalid(
            "nodal_mass",
            format!("{} at node {node}, must be positive", mesh.nodal_mass[node]),
        );
    }
    for simplex in 0..mesh.simplex_count() {
        let measure = mesh.measure(simplex);
        if measure <= 0.0 {
            let why = format!(
                "simplex {simplex} has measure {measure}, its corners must be positively oriented \
                 (in the plane counter-clockwise)"
            );
            return invalid("simplex_position", why);
        }
    }
    Ok(())
}
