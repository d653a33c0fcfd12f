//! Hello, `Ready`, a candidate, `Finish`: shapes, names, numbers.

use protocol::engine::{InitialGrains, MeshDescription};
use protocol::field::Field;
use protocol::message::{Capability, Role};
use protocol::runspace::RunSpace;

use crate::bench::{Bench, Candidate, Model};
use crate::case::{Case, Part};
use crate::check::{ANSWERS, Check, HELLO, NOTHING, READY, Trouble};
use crate::subject::Subject;

pub(super) const CHECKS: &[Check] = &[
    Check::new(
        "no-run",
        "without SILLAGE_RUN it leaves with exit code 3",
        NOTHING,
        no_run,
    ),
    Check::new(
        "hello",
        "it says hello: its seat, protocol 2, a name, a version, its process",
        NOTHING,
        hello,
    ),
    Check::new(
        "no-coupler",
        "without a coupler it leaves with exit code 6 after SILLAGE_CONNECT_LIMIT",
        HELLO,
        no_coupler,
    ),
    Check::new(
        "seat-taken",
        "a second process in its seat leaves with exit code 3, the first goes on",
        HELLO,
        seat_taken,
    ),
    Check::new(
        "ready",
        "Configure is answered by Ready with a sound mesh or grains",
        HELLO,
        ready,
    ),
    Check::new(
        "advance",
        "Advance is answered by every field, of its shape, finite and sound",
        READY,
        advance,
    ),
    Check::new(
        "defaults",
        "inputs that are not listed have their defaults",
        ANSWERS,
        defaults,
    ),
    Check::new(
        "many-steps",
        "twenty steps of several passes go through",
        ANSWERS,
        many_steps,
    ),
    Check::new(
        "finish",
        "after Finish it leaves its seat with exit code 0",
        HELLO,
        finish,
    ),
];

fn no_run(case: &Case) -> Result<(), Trouble> {
    let mut subject = Subject::start(&case.command, &[]).map_err(|e| e.to_string())?;
    Ok(subject.must_leave(3, case.patience())?)
}

fn hello(case: &Case) -> Result<(), Trouble> {
    let bench = Bench::greet(case)?;
    let hello = bench.partner.hello();
    if hello.engine.trim().is_empty() || hello.version.trim().is_empty() {
        let why = format!(
            "name {:?} and version {:?} must not be empty",
            hello.engine, hello.version
        );
        return Err(why.into());
    }
    let alive = std::path::Path::new(&format!("/proc/{}", hello.process)).exists();
    if !alive {
        return Err(format!(
            "its hello names process {}, which is not there",
            hello.process
        )
        .into());
    }
    for (place, capability) in hello.capabilities.iter().enumerate() {
        let foreign = match capability {
            Capability::AffineResponse
            | Capability::ConvectionAsNeeded
            | Capability::SteersMeanFlow
            | Capability::Adapts => case.role != Role::Fluid,
            Capability::ImplicitDrag
            | Capability::ContactState
            | Capability::MovingWalls
            | Capability::Spin
            | Capability::RemovesGrains => case.role != Role::Particles,
            Capability::Checkpoint | Capability::FieldsOnRequest => false,
        };
        if foreign || hello.capabilities[..place].contains(capability) {
            let why = format!("it declares {capability:?} twice or in the wrong seat");
            return Err(why.into());
        }
    }
    Ok(())
}

fn no_coupler(case: &Case) -> Result<(), Trouble> {
    const LIMIT: &str = "0.3";
    let runspace = RunSpace::create().map_err(|e| e.to_string())?;
    let mut variables = runspace.to_environment();
    variables.push(("SILLAGE_CONNECT_LIMIT".to_owned(), LIMIT.to_owned()));
    let mut subject = Subject::start(&case.command, &variables).map_err(|e| e.to_string())?;
    // It may take long to start; the limit counts from when it knocks.
    Ok(subject.must_leave(6, case.patience())?)
}

fn seat_taken(case: &Case) -> Result<(), Trouble> {
    let runspace = RunSpace::create().map_err(|e| e.to_string())?;
    let mut first = Bench::greet_with(case, &runspace, &[])?;
    let second = Subject::start(&case.command, &runspace.to_environment());
    second
        .map_err(|e| e.to_string())?
        .must_leave(3, case.patience())?;
    let configured = first.configure();
    configured.map_err(|why| format!("the first, after the second was refused: {why}"))?;
    Ok(())
}

fn ready(case: &Case) -> Result<(), Trouble> {
    let mut bench = Bench::greet(case)?;
    let model = bench.configure()?;
    if bench.partner.epoch() == 0 {
        return Err("its epoch is 0, epochs count from 1".to_owned().into());
    }
    match model {
        Model::Mesh(mesh) => Ok(sound_mesh(&mesh).and_then(|()| sound_facets(&mesh))?),
        Model::Grains(grains) => Ok(sound_grains(case, &grains)?),
    }
}

/// What the coupler relies on, beyond what it checks itself (orientation, positive mass, corners).
pub(super) fn sound_mesh(mesh: &MeshDescription) -> Result<(), String> {
    const ROUND_OFF: f64 = 1e-9;
    let d = mesh.dimension;
    let mut measure = 0.0;
    for (simplex, p) in mesh.simplex_position.chunks_exact(d * (d + 1)).enumerate() {
        measure += mesh.measure(simplex);
        for corner in 0..=d {
            let node = mesh.simplex_nodes[simplex * (d + 1) + corner] as usize;
            for axis in 0..d {
                let apart = p[d * corner + axis] - mesh.node_position[d * node + axis];
                let along = (1..=d).map(|other| (p[d * other + axis] - p[axis]).abs());
                let size = along.fold(0.0, f64::max);
                let periods =
                    mesh.period[axis].map_or(0.0, |period| (apart / period).round() * period);
                if (apart - periods).abs() > ROUND_OFF * size {
                    return Err(format!(
                        "corner {corner} of simplex {simplex} lies {apart:e} m from its node {node}"
                    ));
                }
            }
        }
    }
    let mass: f64 = mesh.nodal_mass.iter().sum();
    if (mass - measure).abs() > ROUND_OFF * measure {
        return Err(format!(
            "nodal_mass sums to {mass:e} m^{d}, the simplices cover {measure:e}; it must be ∫N of each node"
        ));
    }
    Ok(())
}

/// Facets, where the engine tells them, are sides of simplices.
pub(super) fn sound_facets(mesh: &MeshDescription) -> Result<(), String> {
    const ROUND_OFF: f64 = 1e-9;
    let d = mesh.dimension;
    let simplices = || mesh.simplex_position.chunks_exact(d * (d + 1));
    for (facet, corners) in mesh.facets.position.chunks_exact(d * d).enumerate() {
        let far = |a: &[f64], b: &[f64]| {
            a.iter()
                .zip(b)
                .map(|(a, b)| (a - b).abs())
                .fold(0.0, f64::max)
        };
        let size = far(&corners[..d], &corners[d..2 * d]);
        let has = |simplex: &[f64], corner: &[f64]| {
            let mut own = simplex.chunks_exact(d);
            own.any(|place| far(place, corner) <= ROUND_OFF * size)
        };
        let side = |simplex: &[f64]| corners.chunks_exact(d).all(|corner| has(simplex, corner));
        if !simplices().any(side) {
            return Err(format!(
                "facet {facet} at {corners:?} is no side of a simplex"
            ));
        }
    }
    Ok(())
}

fn sound_grains(case: &Case, grains: &InitialGrains) -> Result<(), String> {
    let Part::Particles(_, given) = &case.part else {
        return Ok(());
    };
    if grains.radius.is_empty() {
        return Err(format!("{} grains given, it runs none", given.radius.len()));
    }
    match grains
        .fixed
        .iter()
        .position(|&fixed| fixed != 0.0 && fixed != 1.0)
    {
        Some(grain) => Err(format!(
            "grain_fixed of grain {grain} is {}, must be 0 or 1",
            grains.fixed[grain]
        )),
        None => Ok(()),
    }
}

fn advance(case: &Case) -> Result<(), Trouble> {
    let mut bench = Bench::greet(case)?;
    let model = bench.configure()?;
    let candidate = bench.step(1, 0)?;
    if let Model::Grains(grains) = model {
        let contact_state = bench
            .partner
            .hello()
            .capabilities
            .contains(&Capability::ContactState);
        sound_motion(case, &grains, &candidate, contact_state)?;
    }
    Ok(())
}

/// Fixed grains stay, displacements are the mean velocity, contact states are known ones.
fn sound_motion(
    case: &Case,
    grains: &InitialGrains,
    candidate: &Candidate,
    contact_state: bool,
) -> Result<(), String> {
    const ROUND_OFF: f64 = 1e-9;
    let position = candidate.field(Field::GrainPosition);
    let mean = candidate.field(Field::GrainMeanVelocity);
    let period = match &case.part {
        Part::Particles(scene, _) => scene.period.clone(),
        Part::Fluid(_) => vec![None; case.dimension()],
    };
    let d = case.dimension();
    for k in 0..position.len() {
        let (grain, moved) = (k / d, position[k] - grains.position[k]);
        if grains.fixed[grain] != 0.0 && (moved != 0.0 || mean[k] != 0.0) {
            return Err(format!("fixed grain {grain} moved by {moved:e} m"));
        }
        let told = case.dt * mean[k];
        let size = grains.position[k].abs() + grains.radius[grain] + told.abs();
        if period[k % d].is_none() && (moved - told).abs() > ROUND_OFF * size {
            return Err(format!(
                "grain {grain} moved by {moved:e} m, its grain_mean_velocity times dt is {told:e}"
            ));
        }
    }
    let most = if contact_state { 2.0 } else { 1.0 };
    let contact = candidate.field(Field::GrainContact);
    match contact
        .iter()
        .position(|&state| state.fract() != 0.0 || !(0.0..=most).contains(&state))
    {
        Some(grain) => Err(format!(
            "grain_contact of grain {grain} is {}, must be a whole number from 0 to {most}{}",
            contact[grain],
            if contact_state {
                ""
            } else {
                " (ContactState is not declared)"
            }
        )),
        None => Ok(()),
    }
}

fn defaults(case: &Case) -> Result<(), Trouble> {
    let mut bench = Bench::ready(case)?;
    bench.advance(&case.request(1, 0), &Vec::new())?;
    Ok(())
}

fn many_steps(case: &Case) -> Result<(), Trouble> {
    const STEPS: u64 = 20;
    let mut bench = Bench::ready(case)?;
    for step in 1..=STEPS {
        for pass in 0..=(step % 3) as u32 {
            let inputs = bench.inputs(pass);
            bench.advance(&case.request(step, pass), &inputs)?;
        }
        bench.commit(step)?;
    }
    bench.finish()?;
    Ok(())
}

fn finish(case: &Case) -> Result<(), Trouble> {
    let runspace = RunSpace::create().map_err(|e| e.to_string())?;
    let mut bench = Bench::greet_with(case, &runspace, &[])?;
    bench.configure()?;
    bench.finish()?;
    let seat = format!(
        "/dev/shm/sillage-{}/members/{}",
        runspace.id(),
        case.role.seat()
    );
    if std::path::Path::new(&seat).exists() {
        return Err(format!("it left and {seat} is still there").into());
    }
    Ok(())
}
