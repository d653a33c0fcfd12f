//! Meshes: what a coupler relies on, and that they follow where an engine declares `Adapts`.

use protocol::engine::MeshDescription;
use protocol::message::{Capability, Role, ToEngine};
use protocol::scene::{Refinement, Region};

use super::exchange::{sound_facets, sound_mesh};
use crate::bench::Bench;
use crate::case::{Case, Part};
use crate::check::{Check, REPEATABLE, Trouble};

/// Checks of meshes that change.
pub(super) const CHECKS: &[Check] = &[Check::new(
    "adapt",
    "after Adapt the mesh is of the epoch asked for and depends on the sizes alone, and the next step goes on",
    REPEATABLE,
    adapt,
)
.only(Role::Fluid)];

/// Cells of half the size around a point that lies at this share of the mesh's box.
fn sizes(mesh: &MeshDescription, share: f64) -> Refinement {
    let d = mesh.dimension;
    let along = |axis: usize| mesh.node_position.iter().skip(axis).step_by(d).copied();
    let centre = (0..d).map(|axis| {
        let low = along(axis).fold(f64::INFINITY, f64::min);
        let high = along(axis).fold(f64::NEG_INFINITY, f64::max);
        low + share * (high - low)
    });
    let measure = (0..mesh.simplex_count()).map(|simplex| mesh.measure(simplex));
    let smallest = measure.fold(f64::INFINITY, f64::min);
    let region = Region::Ball {
        centre: centre.collect(),
        radius: 0.0,
        size: 0.5 * smallest.powf(1.0 / d as f64),
    };
    Refinement {
        growth: 0.5,
        largest: None,
        regions: vec![region],
    }
}

fn adapt(case: &Case) -> Result<(), Trouble> {
    let mut bench = Bench::greet(case)?;
    let able = &bench.partner.hello().capabilities;
    if !able.contains(&Capability::Adapts) {
        return Err(Trouble::Skipped("it does not declare Adapts".to_owned()));
    }
    let Part::Fluid(scene) = &case.part else {
        return Err(Trouble::Skipped("not a fluid".to_owned()));
    };
    let mut scene = scene.clone();
    scene.refinement = Some(Refinement {
        growth: 0.5,
        largest: None,
        regions: Vec::new(),
    });
    let configured = bench.partner.configure_fluid(&scene);
    let first = configured.map_err(|error| bench.explain(&error))?;
    bench.count = first.node_count();
    let (one, other) = (sizes(&first, 0.4), sizes(&first, 0.7));
    let mut meshes = Vec::new();
    for (step, asked) in (1..).zip([&one, &other, &one]) {
        bench.step(step, step as u32)?;
        bench.commit(step)?;
        let told = bench.partner.adapt((step + 1, step + 1), asked);
        let told = told.map_err(|error| format!("Adapt: {}", bench.explain(&error)))?;
        let Some(mesh) = told else {
            return Err(Trouble::Skipped("it keeps its mesh".to_owned()));
        };
        sound_mesh(&mesh).and_then(|()| sound_facets(&mesh))?;
        bench.count = mesh.node_count();
        meshes.push(mesh);
    }
    if meshes[0] != meshes[2] {
        let why = "the mesh of the same sizes is another one when the mesh before it is";
        return Err(why.to_owned().into());
    }
    bench.step(4, 1)?;
    bench.commit(4)?;
    let (epoch, sizes) = (4, one);
    bench.send(&ToEngine::Adapt { epoch, sizes })?;
    let to = "Adapt to an epoch that is over";
    let failure = bench.must_fail(to)?;
    bench.must_leave_broken(failure.kind.exit_code(), to)?;
    Ok(())
}
