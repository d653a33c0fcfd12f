//! What is relative or left out becomes definite: the scene that processes receive.

use std::collections::BTreeMap;
use std::path::Path;

use protocol::scene::{
    Boundary, Convection, CouplerScene, FluidScene, Geometry, Limits, MeshSource, ParticleScene,
    Scheme,
};

use space::Dim;

use crate::boundaries;
use crate::check::Checker;
use crate::dimensions::{Cells, Scenic, sides};
use crate::document::Document;
use crate::grains::{self, GrainTable};
use crate::keys::{Coupling, Fluid, RefinementKeys, SceneFile};
use crate::mean_flow;
use crate::mesh::Mesh;
use crate::mesh_file;
use crate::outline::Outline;
use crate::refinement;
use crate::scene::Scene;
use crate::sides::Sides;
use crate::walls::{self, GrainRoom};

/// Grains of a run folder, beside `scene.json`.
pub const GRAINS_FILE: &str = "grains.csv";

/// Resolve checked keys; what is found wrong goes to `checker`.
pub fn resolve<const D: usize>(
    document: &Document,
    keys: SceneFile<D>,
    threads: usize,
    checker: &mut Checker<'_>,
) -> Scene
where
    Dim<D>: Scenic<D>,
{
    let folder = document.folder();
    let (fluid, mesh) = match &keys.fluid {
        Some(fluid) => {
            let (part, mesh) = fluid_part(&keys, fluid, &folder, threads, checker);
            (Some(part), mesh)
        }
        None => (None, None),
    };
    let cells = keys
        .fluid
        .as_ref()
        .and_then(|fluid| Dim::<D>::cells(&fluid.domain));
    let cells = cells.as_ref();
    let no_boundaries = Default::default();
    let conditions = fluid
        .as_ref()
        .map_or(&no_boundaries, |fluid| &fluid.boundaries);
    let room = walls::room(&keys, cells, conditions);
    let walls = walls::walls(&keys, room.as_ref(), checker);
    let outline = outline(mesh.as_ref(), cells, conditions);
    let mut warnings = warnings(&keys);
    warnings.append(&mut checker.warnings);
    let mut exits = Vec::new();
    if let Some(outline) = &outline {
        let sides = Sides {
            scene: &keys,
            cells,
            boundaries: conditions,
            outline,
            walls: &walls,
        };
        sides.check(checker);
        warnings.extend(sides.warnings());
        exits = sides.exits();
    }
    let table = if checker.problems.is_empty() {
        let places = (room.as_ref(), outline.as_ref());
        grains::generate(&keys.grains, &folder, places, checker)
    } else {
        GrainTable::default()
    };
    refuse_thin_slab(&keys, &table, checker);
    let particles =
        (!keys.grains.is_empty()).then(|| particle_part(&keys, walls, room.as_ref(), threads));
    let grain_boundaries = walls::of_mesh(&keys, conditions);
    let mut coupler = coupler_part(&keys, fluid, particles);
    if checker.problems.is_empty() {
        refinement::check_grains(&coupler, &table, checker);
    }
    coupler.grain_boundaries = grain_boundaries;
    if !table.all_fixed() {
        coupler.grain_exits = exits;
    }
    coupler.grains_stay = keys.run.leave_out
        && coupler.fluid.is_some()
        && keys.engines.particles.is_none()
        && table.all_fixed();
    Scene {
        name: document.name(),
        folder,
        text: document.text().to_string(),
        leave_out: keys.run.leave_out,
        warnings,
        coupler,
        grains: table,
        engines: keys.engines,
        output: keys.output,
        record: keys.record,
        checkpoint: keys.checkpoint,
    }
}

/// A slab is at least as deep as its largest sphere is wide: in a thinner one a sphere takes more volume
/// than there is.
fn refuse_thin_slab<const D: usize>(
    keys: &SceneFile<D>,
    grains: &GrainTable,
    checker: &mut Checker<'_>,
) {
    let Some(Geometry::Sphere { depth }) = keys.coupling.as_ref().and_then(|c| c.geometry) else {
        return;
    };
    let diameter = 2.0 * grains.radius.iter().copied().fold(0.0, f64::max);
    if depth < diameter * (1.0 - 1e-9) {
        checker.refuse(
            "coupling.geometry.sphere.depth",
            format!("must be at least the diameter of the largest grain, {diameter:e} m"),
        );
    }
}

fn fluid_part<const D: usize>(
    keys: &SceneFile<D>,
    fluid: &Fluid<D>,
    folder: &Path,
    threads: usize,
    checker: &mut Checker<'_>,
) -> (FluidScene, Option<Mesh<D>>)
where
    Dim<D>: Scenic<D>,
{
    let (source, read, boundaries) = mesh_part(fluid, folder, checker);
    if checker.problems.is_empty() {
        match Dim::<D>::cells(&fluid.domain) {
            Some(cells) => boundaries::check_box(&boundaries, &cells, checker),
            None => boundaries::check_mesh(&boundaries, checker),
        }
        mean_flow::check(keys, fluid, &boundaries, checker);
        refinement::check(keys, fluid, read.as_ref(), checker);
    }
    // Suspensions need the full grad-div term for local mass balance; around bodies in clear flow
    // it is too dissipative.
    let grad_div = if keys.grains.is_empty() { 0.1 } else { 1.0 };
    let part = FluidScene {
        dimension: D,
        density: fluid.density,
        dynamic_viscosity: fluid.dynamic_viscosity,
        gravity: keys.gravity.acceleration.to_vec(),
        mesh: source,
        boundaries,
        convection: match fluid.convection {
            Convection::AsNeeded if !keys.run.leave_out => Convection::Always,
            given => given,
        },
        time_scheme: fluid.time_scheme,
        nonlinear: fluid.nonlinear,
        viscous_form: fluid.viscous_form,
        grad_div: fluid.grad_div.unwrap_or(grad_div),
        initial_velocity: fluid.initial_velocity.0.to_vec(),
        threads,
        mean_flow: fluid.mean_flow.unwrap_or_default().map(|v| v.0.to_vec()),
        refinement: fluid.refinement.as_ref().map(RefinementKeys::sizes),
    };
    (part, read)
}

/// The mesh with an absolute path, and a condition for each of its boundaries.
fn mesh_part<const D: usize>(
    fluid: &Fluid<D>,
    folder: &Path,
    checker: &mut Checker<'_>,
) -> (MeshSource, Option<Mesh<D>>, BTreeMap<String, Boundary>)
where
    Dim<D>: Scenic<D>,
{
    let Some(cells) = Dim::<D>::cells(&fluid.domain) else {
        let mesh = mesh_file::read(&fluid.domain, folder, checker);
        let boundaries = mesh.as_ref().map_or_else(BTreeMap::new, |mesh| {
            mesh_file::warn(mesh, checker);
            mesh_file::boundaries(fluid, mesh, checker)
        });
        return (mesh_file::source(&fluid.domain, folder), mesh, boundaries);
    };
    boundaries::warn_of_cells(&cells, checker);
    let names: Vec<String> = sides::<D>().iter().map(|name| (*name).to_owned()).collect();
    let boundaries = boundaries::by_name(&fluid.boundaries, &names, checker);
    (Dim::<D>::mesh(&cells), None, boundaries)
}

/// The outline of the fluid; none without one, or where its mesh cannot be used.
fn outline<const D: usize>(
    mesh: Option<&Mesh<D>>,
    cells: Option<&Cells<D>>,
    conditions: &BTreeMap<String, Boundary>,
) -> Option<Outline<D>>
where
    Dim<D>: Scenic<D>,
{
    if let Some(Cells { lower, upper, .. }) = cells {
        return Some(Outline::of_box(lower, upper, walls::joined(conditions)));
    }
    let facets = mesh_file::facets(mesh?, |name| conditions.contains_key(name));
    Some(Outline::new(facets, [false; D]))
}

fn particle_part<const D: usize>(
    keys: &SceneFile<D>,
    walls: Vec<protocol::scene::Wall>,
    room: Option<&GrainRoom<D>>,
    threads: usize,
) -> ParticleScene
where
    Dim<D>: Scenic<D>,
{
    let geometry = Dim::<D>::geometry(keys.coupling.as_ref());
    let contact = keys.contact.as_ref();
    let friction = contact.map_or(0.0, |contact| contact.friction);
    ParticleScene {
        dimension: D,
        gravity: keys.gravity.acceleration.to_vec(),
        walls,
        period: room.map_or([None; D], |room| room.period).to_vec(),
        friction,
        wall_friction: contact
            .and_then(|contact| contact.wall_friction)
            .unwrap_or(friction),
        inertia_factor: if geometry == Geometry::Disk { 0.5 } else { 0.4 },
        // Checked before: a scene with grains has [contact].
        tolerance: contact.map_or(f64::NAN, |contact| contact.tolerance),
        solver: contact.and_then(|contact| contact.solver),
        sweeps_max: contact.map_or(0, |contact| contact.sweeps_max),
        sub_steps_max: contact.map_or(0, |contact| contact.sub_steps_max),
        threads,
    }
}

fn coupler_part<const D: usize>(
    keys: &SceneFile<D>,
    fluid: Option<FluidScene>,
    particles: Option<ParticleScene>,
) -> CouplerScene
where
    Dim<D>: Scenic<D>,
{
    // Without both phases there is nothing to couple, and the scheme has no meaning: one pass.
    let uncoupled = Coupling {
        scheme: Some(Scheme::Staggered),
        drag: protocol::scene::DragLaw::Dallavalle,
        reaction: true,
        geometry: None,
        adaptive: None,
    };
    let coupling = keys.coupling.as_ref().unwrap_or(&uncoupled);
    CouplerScene {
        dimension: D,
        end_time: keys.run.end_time,
        coupling_step: keys.run.coupling_step,
        step_min: keys.run.step_min,
        adaptive: coupling.adaptive,
        gravity: keys.gravity.acceleration.to_vec(),
        grains_stay: false,
        grain_boundaries: None,
        grain_exits: Vec::new(),
        near_grains: keys
            .fluid
            .as_ref()
            .and_then(|fluid| fluid.refinement.as_ref()?.near()),
        indicator: keys
            .fluid
            .as_ref()
            .and_then(|fluid| fluid.refinement.as_ref()?.indicator),
        grains_file: particles.is_some().then(|| GRAINS_FILE.to_string()),
        fluid,
        particles,
        scheme: coupling.scheme.unwrap_or(Scheme::Staggered),
        drag: coupling.drag,
        geometry: Dim::<D>::geometry(Some(coupling)),
        reaction: coupling.reaction,
        output_every: keys.output.every,
        limits: Limits {
            connect: keys.limits.connect,
            configure: keys.limits.configure,
            step: keys.limits.step,
        },
    }
}

/// What was asked for and has no effect.
fn warnings<const D: usize>(keys: &SceneFile<D>) -> Vec<String> {
    let mut warnings = Vec::new();
    if keys.engines.fluid.is_some() && keys.fluid.is_none() {
        warnings.push("engines.fluid is not started: the scene has no [fluid]".to_string());
    }
    if keys.engines.particles.is_some() && keys.grains.is_empty() {
        warnings.push("engines.particles is not started: the scene has no [[grains]]".to_string());
    }
    if keys.coupling.is_some() && (keys.fluid.is_none() || keys.grains.is_empty()) {
        warnings.push("[coupling] couples nothing: the scene has one phase only".to_string());
    }
    warnings
}
