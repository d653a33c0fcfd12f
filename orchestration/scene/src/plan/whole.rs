//! What a scene needs: processes, terms, fields, sizes; what is left out, and what is chosen.

use std::fmt;
use std::path::Path;

use protocol::field::Field;
use protocol::message::Role;
use protocol::scene::{
    Boundary, Convection, CouplerScene, FluidScene, Geometry, Indicator, MeshSource, NearGrains,
    Nonlinear, Scheme,
};
use serde::Serialize;

use super::cells;
use super::choices::{self, Choice};
use super::kept;
use crate::error::Error;
use crate::record;
use crate::resolve::GRAINS_FILE;
use crate::scene::Scene;

/// The plan of a scene.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Plan {
    /// Name of the scene.
    pub scene: String,
    /// Processes that will be started, with their commands.
    pub processes: Vec<Process>,
    /// Coupling steps until the end, when the step is constant.
    pub steps: Option<u64>,
    /// States written, counting the initial one.
    pub states: u64,
    /// What is computed on, in words.
    pub sizes: Vec<String>,
    /// Terms of the equations that are solved.
    pub terms: Vec<String>,
    /// Fields that cross a process boundary in a step.
    pub fields: Vec<Exchange>,
    /// What this scene does without.
    pub left_out: Vec<String>,
    /// What the run chooses by itself, with the bounds that decide.
    pub choices: Vec<Choice>,
    /// What is kept of the run, so that it can be resumed.
    pub kept: Vec<String>,
    /// What may surprise.
    pub warnings: Vec<String>,
}

/// A process of a run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Process {
    /// fluid, particles or coupler.
    pub seat: String,
    /// Program and arguments.
    pub command: Vec<String>,
}

/// A field on its way.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Exchange {
    /// Sender and receiver.
    pub route: String,
    /// Name of the field.
    pub field: String,
    /// Its unit.
    pub unit: String,
    /// Numbers per node or grain.
    pub components: usize,
}

/// Plan a scene.
pub fn plan(scene: &Scene) -> Plan {
    let coupler = &scene.coupler;
    let adaptive = coupler.adaptive.is_some();
    let (steps, states) = steps_and_states(coupler);
    Plan {
        scene: scene.name.clone(),
        processes: processes(scene),
        steps: (!adaptive).then_some(steps),
        states,
        sizes: sizes(scene),
        terms: terms(scene),
        fields: fields(scene),
        left_out: left_out(scene),
        choices: choices::choices(scene),
        kept: kept::checkpoints(scene),
        warnings: scene.warnings.clone(),
    }
}

/// Coupling steps of equal length, cut where states are put out, and the states: at the start, at each time
/// of output, at the end.
fn steps_and_states(coupler: &CouplerScene) -> (u64, u64) {
    let steps = |time: f64| (time / coupler.coupling_step - 1e-9).ceil() as u64;
    let Some(every) = coupler.output_every else {
        return (steps(coupler.end_time), 2);
    };
    let intervals = (coupler.end_time / every - 1e-9).ceil() as u64;
    let last = coupler.end_time - every * intervals.saturating_sub(1) as f64;
    (
        intervals.saturating_sub(1) * steps(every) + steps(last),
        intervals + 1,
    )
}

/// Both phases present?
fn coupled(scene: &Scene) -> bool {
    scene.coupler.fluid.is_some() && scene.coupler.particles.is_some()
}

/// Which processes, and how they are started.
pub fn processes(scene: &Scene) -> Vec<Process> {
    let mut processes = Vec::new();
    let mut add = |seat: &str, command: Vec<String>| {
        processes.push(Process {
            seat: seat.to_string(),
            command,
        });
    };
    let command = |engine: &Option<crate::keys::EngineCommand>, built_in: &str| match engine {
        Some(engine) => engine.command.clone(),
        None => vec![built_in.to_string()],
    };
    if scene.coupler.fluid.is_some() {
        add("fluid", command(&scene.engines.fluid, "sillage-fluid"));
    }
    if scene.coupler.has_process(Role::Particles) {
        add(
            "particles",
            command(&scene.engines.particles, "sillage-particles"),
        );
    }
    let mut coupler = vec![
        "sillage-coupler".into(),
        "--scene".into(),
        "scene.json".into(),
    ];
    if let Some(record) = &scene.record {
        coupler.extend(record::arguments(record, Path::new("")));
    }
    add("coupler", coupler);
    processes
}

fn sizes(scene: &Scene) -> Vec<String> {
    let mut sizes = Vec::new();
    match scene.coupler.fluid.as_ref().map(|fluid| &fluid.mesh) {
        Some(MeshSource::File { path, .. }) => sizes.push(format!("fluid: mesh {path}")),
        Some(mesh) => sizes.extend(cells::in_words(scene, mesh)),
        None => {}
    }
    if let Some(NearGrains { size, margin }) = scene.coupler.near_grains {
        sizes.push(format!(
            "fluid: cells of {size:.3e} m or less near grains; the mesh follows when one has gone about \
             {margin:.3e} m, or the zone of small cells is a fifth too large (`nodes` and `epoch` of steps.csv)"
        ));
    }
    if let Some(Indicator { jump, smallest }) = scene.coupler.indicator {
        sizes.push(format!(
            "fluid: cells down to {smallest:.3e} m where ∇v changes from one to the next by more than {jump} of the \
             largest speed over a cell; the mesh follows the flow (`nodes` and `epoch` of steps.csv)"
        ));
    }
    if !scene.grains.is_empty() {
        let grains = &scene.grains;
        let smallest = grains.radius.iter().copied().fold(f64::MAX, f64::min);
        let largest = grains.radius.iter().copied().fold(0.0, f64::max);
        let fixed = grains.fixed.iter().filter(|&&fixed| fixed).count();
        sizes.push(format!(
            "grains: {} ({fixed} fixed), radius {smallest:.4e} to {largest:.4e} m, {} {:.5e} {}",
            grains.len(),
            ["area", "volume"][grains.dimension - 2],
            grains.content(),
            ["m²", "m³"][grains.dimension - 2],
        ));
    }
    sizes
}

fn terms(scene: &Scene) -> Vec<String> {
    let mut terms = Vec::new();
    let mut add = |term: &str| terms.push(term.to_string());
    if let Some(fluid) = &scene.coupler.fluid {
        add(if coupled(scene) {
            "fluid: volume-averaged Navier–Stokes in the superficial velocity and the pressure"
        } else {
            "fluid: Navier–Stokes in the velocity and the pressure"
        });
        match fluid.convection {
            Convection::Always => add("fluid: convection ρφ v·∇v"),
            Convection::AsNeeded => {
                add("fluid: convection ρφ v·∇v, from the first step that needs it")
            }
            Convection::Never => {}
        }
        add(&format!(
            "fluid: time scheme {:?}, {}",
            fluid.time_scheme,
            nonlinear(fluid)
        ));
        if coupled(scene) && scene.coupler.reaction {
            add("fluid: response of the grains (porosity, drag, entrainment, flux, mobility)");
        }
    }
    if scene.coupler.particles.is_some() {
        add("grains: non-smooth contacts, full weight");
        if scene
            .coupler
            .particles
            .as_ref()
            .is_some_and(|p| p.friction > 0.0 || p.wall_friction > 0.0)
        {
            add("grains: Coulomb friction");
        }
    }
    if coupled(scene) {
        add(&format!(
            "coupling: drag {:?}, pressure gradient",
            scene.coupler.drag
        ));
        match scene.coupler.scheme {
            Scheme::Staggered => add("coupling: one pass a step"),
            Scheme::SemiImplicit => add(
                "coupling: for comparison, one pass with the solid's flux of the start of the step; \
                 unstable where dense and stiff",
            ),
            Scheme::Explicit => add(
                "coupling: for comparison, one pass with the drag of the start of the step; \
                 unstable where the step is longer than the relaxation times",
            ),
            Scheme::Iterated {
                tolerance,
                passes_max,
            } => add(&format!(
                "coupling: passes until the interaction defect is below {tolerance:e}, at most {passes_max}"
            )),
        }
        match scene.coupler.geometry {
            Geometry::Disk => add("coupling: grains are disks, per metre of depth"),
            Geometry::Sphere { .. } if scene.dimension() == 3 => {
                add("coupling: grains are spheres")
            }
            Geometry::Sphere { depth } => {
                add(&format!(
                    "coupling: grains are spheres in a slab of {depth:e} m"
                ));
            }
        }
    }
    terms
}

fn nonlinear(fluid: &FluidScene) -> String {
    match fluid.nonlinear {
        Nonlinear::Picard => "one linear solve a step".into(),
        Nonlinear::Newton { tolerance, .. } => format!("Newton to {tolerance:e}"),
    }
}

fn fields(scene: &Scene) -> Vec<Exchange> {
    let mut exchanges = Vec::new();
    let withheld = choices::withheld(scene);
    let mut add = |route: &str, fields: &[Field]| {
        let crosses = |field: &&Field| !withheld.contains(field);
        exchanges.extend(fields.iter().filter(crosses).map(|field| Exchange {
            route: route.to_string(),
            field: field.name().to_string(),
            unit: field.unit(scene.coupler.dimension).to_string(),
            components: field.components(scene.coupler.dimension),
        }));
    };
    if scene.coupler.fluid.is_some() {
        if coupled(scene) && scene.coupler.reaction {
            add(
                "coupler → fluid",
                &[
                    Field::Porosity,
                    Field::Drag,
                    Field::DragSource,
                    Field::EntrainedFraction,
                    Field::SolidFlux,
                    Field::SolidMobility,
                    Field::FixedDrag,
                ],
            );
        }
        add(
            "fluid → coupler",
            &[
                Field::InterstitialVelocity,
                Field::PressureGradient,
                Field::Pressure,
            ],
        );
    }
    if scene.coupler.has_process(Role::Particles) {
        if coupled(scene) {
            add(
                "coupler → particles",
                &[Field::GrainDrag, Field::GrainForce],
            );
        }
        add(
            "particles → coupler",
            &[
                Field::GrainPosition,
                Field::GrainVelocity,
                Field::GrainMeanVelocity,
                Field::GrainContact,
            ],
        );
    }
    exchanges
}

fn left_out(scene: &Scene) -> Vec<String> {
    let coupler = &scene.coupler;
    let mut left_out = Vec::new();
    let mut add = |what: &str| left_out.push(what.to_string());
    match &coupler.fluid {
        None => add("fluid process, mesh, drag, transfer: the scene has no [fluid]"),
        Some(fluid) => {
            if fluid.convection == Convection::Never {
                add("convection of the fluid: convection = false");
            }
            let pressure_given = fluid
                .boundaries
                .values()
                .any(|side| matches!(side, Boundary::Open { .. }));
            if !pressure_given {
                add(
                    "a level of the pressure: no boundary is open, only differences have a meaning",
                );
            }
        }
    }
    if coupler.particles.is_none() {
        add("particle process, contacts, porosity, drag: the scene has no [[grains]]");
    }
    if coupler.grains_stay {
        add("particle process, contacts: every grain is fixed");
    }
    if coupled(scene) && !coupler.reaction {
        add("response of the grains in the fluid: reaction = false, one-way");
    }
    if let Some(particles) = &coupler.particles
        && particles.friction == 0.0
        && particles.wall_friction == 0.0
    {
        add("friction and spin of the grains: friction = 0");
    }
    if coupler.adaptive.is_none() {
        add("adaptive coupling step");
    }
    if !scene.output.frames {
        add("pictures: frames = false");
    }
    left_out
}

/// `scene.json`: what the coupler takes.
pub fn scene_json(scene: &Scene) -> Result<String, Error> {
    let json = serde_json::to_string_pretty(&scene.coupler)
        .map_err(|error| Error::Usage(format!("the scene cannot be written as JSON: {error}")))?;
    Ok(json + "\n")
}

/// Write what the coupler takes: `scene.json` and, with grains, `grains.csv`.
pub fn write_inputs(scene: &Scene, folder: &Path) -> Result<(), Error> {
    std::fs::create_dir_all(folder).map_err(Error::file("cannot create", folder))?;
    let path = folder.join("scene.json");
    std::fs::write(&path, scene_json(scene)?).map_err(Error::file("cannot write", &path))?;
    if !scene.grains.is_empty() {
        let path = folder.join(GRAINS_FILE);
        std::fs::write(&path, scene.grains.to_csv()).map_err(Error::file("cannot write", &path))?;
    }
    Ok(())
}

impl fmt::Display for Plan {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(out, "{}", self.scene)?;
        match self.steps {
            Some(steps) => writeln!(
                out,
                "  {steps} coupling steps, {} states written",
                self.states
            )?,
            None => writeln!(
                out,
                "  adaptive coupling steps, {} states written",
                self.states
            )?,
        }
        let section = |out: &mut fmt::Formatter<'_>, title: &str, lines: &[String]| {
            if lines.is_empty() {
                return Ok(());
            }
            writeln!(out, "{title}")?;
            lines.iter().try_for_each(|line| writeln!(out, "  {line}"))
        };
        let processes: Vec<String> = self
            .processes
            .iter()
            .map(|process| format!("{:<10} {}", process.seat, process.command.join(" ")))
            .collect();
        section(out, "processes", &processes)?;
        section(out, "sizes", &self.sizes)?;
        section(out, "terms", &self.terms)?;
        let fields: Vec<String> = self
            .fields
            .iter()
            .map(|exchange| {
                let Exchange {
                    route,
                    field,
                    unit,
                    components,
                } = exchange;
                format!("{route:<20} {field:<22} {components} × {unit}")
            })
            .collect();
        section(out, "fields exchanged in a pass", &fields)?;
        section(out, "left out", &self.left_out)?;
        let choices: Vec<String> = self.choices.iter().map(Choice::to_string).collect();
        section(out, "chosen", &choices)?;
        section(out, "kept", &self.kept)?;
        section(out, "warnings", &self.warnings)
    }
}
