//! What a run chooses by itself: each part with the bound that decides, its value on this scene, the
//! reason, and what leaving it out saves.
//!
//! Values are those of t = 0. Where a part is watched the engine looks at its bound in every step and
//! the part is there in the very step that needs it; `run.json` says which (`left_out`).

use std::fmt;

use protocol::field::Field;
use protocol::message::Role;
use protocol::scene::{
    Boundary, CREEPING_REYNOLDS, ContactSolver, Convection, LUMPED_RATIO_MAX, MeanFlow, MeshSource,
    Scheme, Wall,
};
use serde::Serialize;
use space::grid::SPARE;

use super::cost::Cost;
use crate::grains::{GrainTable, Neighbours};
use crate::refinement;
use crate::scene::Scene;

/// Why nothing of the particle engine is needed.
const NO_PROCESS: &str = "every grain is fixed: there is no particle process";

/// One choice.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Choice {
    /// What it is about.
    pub part: &'static str,
    /// What was chosen.
    pub chosen: String,
    /// Why.
    pub reason: String,
    /// The number that decides.
    pub bound: Option<f64>,
    /// Its value on this scene at the start.
    pub value: Option<f64>,
    /// Share of a pass that it saves, by the cost model of the plan.
    pub saves: Option<f64>,
    /// Is the bound looked at in every step?
    pub watched: bool,
}

impl fmt::Display for Choice {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{}: {}: {}", self.part, self.chosen, self.reason)?;
        if let (Some(bound), Some(value)) = (self.bound, self.value) {
            write!(out, " [{value:.2e}, bound {bound:.1e}]")?;
        }
        match self.saves {
            Some(saves) if saves < 0.005 => write!(out, ", saves next to nothing here")?,
            Some(saves) => write!(out, ", saves about {:.0} % of a pass", 100.0 * saves)?,
            None => {}
        }
        if self.watched {
            write!(out, ", watched")?;
        }
        Ok(())
    }
}

/// A choice without numbers.
fn plain(part: &'static str, chosen: &str, reason: impl Into<String>) -> Choice {
    Choice {
        part,
        chosen: chosen.to_string(),
        reason: reason.into(),
        bound: None,
        value: None,
        saves: None,
        watched: false,
    }
}

/// All choices of a scene.
pub fn choices(scene: &Scene) -> Vec<Choice> {
    let spreading = spreading(scene);
    let spread = spreading.as_ref().is_some_and(|(_, spread)| *spread);
    let cost = Cost::of(scene, spread);
    let mut choices = Vec::new();
    choices.extend(convection(scene, &cost));
    choices.extend(contacts(scene, &cost));
    choices.extend(walls(scene));
    choices.extend(friction(scene));
    choices.extend(spreading.map(|(choice, spread)| Choice {
        saves: (!spread).then(|| {
            let with = Cost::of(scene, true);
            with.share(with.spreading)
        }),
        ..choice
    }));
    choices.extend(passes(scene));
    choices.extend(sub_steps(scene));
    choices.push(fields(scene));
    choices.push(output(scene));
    choices
}

/// Without grains that the fluid feels its matrix stays the same once convection is out of it.
fn convection(scene: &Scene, cost: &Cost) -> Option<Choice> {
    let fluid = scene.coupler.fluid.as_ref()?;
    let alone = scene.coupler.particles.is_none() || !scene.coupler.reaction;
    let kept = cost.share(cost.matrix);
    let saves = Some(if alone { kept } else { 0.0 });
    let reason = |rest: &str| match alone {
        true => format!("{rest}; without it one factorised matrix serves all steps"),
        false => format!("{rest}; the matrix follows the grains in any case"),
    };
    Some(match fluid.convection {
        Convection::Never => Choice {
            saves,
            ..plain("convection", "left out", reason("fluid.convection = false"))
        },
        Convection::Always if !scene.leave_out => {
            plain("convection", "there", "run.leave_out = false")
        }
        Convection::Always => plain("convection", "there", "fluid.convection = true"),
        Convection::AsNeeded if scene.engines.fluid.is_some() => plain(
            "convection",
            "there",
            "unless the engine of this scene says that it leaves it out as needed",
        ),
        Convection::AsNeeded => Choice {
            bound: Some(CREEPING_REYNOLDS),
            value: Some(reynolds(scene)),
            saves,
            watched: true,
            ..plain(
                "convection",
                "left out while the flow creeps",
                reason("a step whose Reynolds number is above the bound has it, and all after it"),
            )
        },
    })
}

/// ρ V L/(π μ) with the fastest flow that the scene's numbers lead to: what is prescribed, or what
/// the weight of all grains drives, F/(4πμ); on the large side.
fn reynolds(scene: &Scene) -> f64 {
    let Some(fluid) = &scene.coupler.fluid else {
        return 0.0;
    };
    let size = |vector: &[f64]| vector.iter().copied().fold(0.0, f64::hypot);
    let inflow = fluid.boundaries.values().map(|boundary| match boundary {
        Boundary::Inflow { velocity, .. } | Boundary::MovingWall { velocity } => size(velocity),
        Boundary::NoSlip | Boundary::Slip | Boundary::Periodic | Boundary::Open { .. } => 0.0,
    });
    let mean = match &fluid.mean_flow {
        MeanFlow::Velocity(velocity) => size(velocity),
        MeanFlow::Free | MeanFlow::Zero => 0.0,
    };
    let prescribed = inflow.fold(size(&fluid.initial_velocity).max(mean), f64::max);
    let grains = &scene.grains;
    let excess: f64 = (0..grains.len())
        .filter(|&grain| !grains.fixed[grain] && scene.coupler.reaction)
        .map(|grain| grains.content_of(grain) * (grains.density[grain] - fluid.density).abs())
        .sum();
    let weight = excess * size(&fluid.gravity);
    let driven = weight / (4.0 * std::f64::consts::PI * fluid.dynamic_viscosity * depth(grains));
    let extent = refinement::cells_of(&fluid.mesh).map_or(
        // Its extent is in the file.
        1.0,
        |(lower, upper, _)| {
            let sides = lower.iter().zip(upper).map(|(low, high)| high - low);
            sides.fold(f64::INFINITY, f64::min)
        },
    );
    let speed = prescribed.max(driven);
    fluid.density * speed * extent / (std::f64::consts::PI * fluid.dynamic_viscosity)
}

/// How far grains reach across their fall, on the small side: of disks, which are told per metre, one metre.
fn depth(grains: &GrainTable) -> f64 {
    let cubes = grains
        .radius
        .iter()
        .map(|radius| radius.powi(3))
        .sum::<f64>();
    match grains.dimension {
        3 => cubes.cbrt(),
        _ => 1.0,
    }
}

fn contacts(scene: &Scene, cost: &Cost) -> Option<Choice> {
    scene.coupler.particles.as_ref()?;
    if scene.coupler.grains_stay {
        return Some(plain("contacts", "left out", NO_PROCESS));
    }
    if scene.engines.particles.is_some() {
        let reason = "the engine of this scene searches as it likes";
        return Some(plain("contacts", "up to the engine", reason));
    }
    if !scene.leave_out {
        let reason = "run.leave_out = false";
        return Some(plain("contacts", "searched for in every sub-step", reason));
    }
    if scene.grains.len() == 1 {
        return Some(plain(
            "contacts between grains",
            "left out",
            "there is one grain",
        ));
    }
    if scene.grains.all_fixed() {
        let reason = "no grain moves";
        return Some(Choice {
            saves: Some(cost.share(cost.search)),
            ..plain("contacts", "left out", reason)
        });
    }
    Some(Choice {
        bound: Some(SPARE),
        value: smallest_gap(scene),
        saves: Some(cost.share(0.9 * cost.search)),
        watched: true,
        ..plain(
            "contacts",
            "searched for when a grain has used up the spare reach of the last search",
            "until then its pairs are all that can meet, to the bit; the smallest gap, of the radius",
        )
    })
}

/// Smallest gap between two grains of which one moves, of the smaller radius.
fn smallest_gap(scene: &Scene) -> Option<f64> {
    match scene.dimension() {
        3 => smallest_gap_in::<3>(&scene.grains),
        _ => smallest_gap_in::<2>(&scene.grains),
    }
}

fn smallest_gap_in<const D: usize>(grains: &GrainTable) -> Option<f64> {
    let largest = grains.radius.iter().copied().fold(0.0, f64::max);
    let mut placed = Neighbours::<D>::new(2.0 * largest, [None; D]);
    let mut smallest = None;
    for grain in 0..grains.len() {
        let radius = grains.radius[grain];
        let place = &std::array::from_fn(|axis| grains.place(grain)[axis]);
        let within = smallest.unwrap_or(f64::INFINITY);
        let gap = placed.gap(place, radius, grains.fixed[grain], within);
        smallest = gap.or(smallest);
        placed.insert(place, radius, grains.fixed[grain]);
    }
    smallest
}

fn walls(scene: &Scene) -> Option<Choice> {
    let part = scene.coupler.particles.as_ref()?;
    if scene.coupler.grains_stay {
        return Some(plain("walls", "left out", NO_PROCESS));
    }
    if part.walls.is_empty() {
        return Some(plain(
            "walls",
            "left out",
            "the scene has no wall for grains",
        ));
    }
    if scene.engines.particles.is_some() || !scene.leave_out {
        return None;
    }
    let grains = &scene.grains;
    let far = (0..grains.len()).filter(|&grain| {
        let reach = std::f64::consts::SQRT_2 * (1.0 + SPARE) * grains.radius[grain];
        let near = |wall: &Wall| wall.distance(grains.place(grain)) <= reach;
        grains.fixed[grain] || !part.walls.iter().any(near)
    });
    let share = far.count() as f64 / grains.len().max(1) as f64;
    Some(Choice {
        value: Some(share),
        watched: true,
        ..plain(
            "walls",
            "looked at by grains that may have come near one",
            format!(
                "{:.0} % of the grains are far from every wall at the start",
                100.0 * share
            ),
        )
    })
}

fn friction(scene: &Scene) -> Option<Choice> {
    let part = scene.coupler.particles.as_ref()?;
    if scene.coupler.grains_stay {
        return None;
    }
    Some(if part.friction == 0.0 && part.wall_friction == 0.0 {
        plain(
            "friction",
            "left out, with the spin of the grains",
            "its coefficients are 0",
        )
    } else {
        plain("friction", "there", "a coefficient is above 0")
    })
}

/// The choice, and whether grains are spread over more than one point.
fn spreading(scene: &Scene) -> Option<(Choice, bool)> {
    let coupler = &scene.coupler;
    let (fluid, _) = (coupler.fluid.as_ref()?, coupler.particles.as_ref()?);
    const PART: &str = "spreading of grains";
    let Some(size) = refinement::near_grains(coupler) else {
        let reason = "there for grains whose diameter is above 0.25 of the cells around them";
        return Some((
            plain(PART, "decided by the mesh of the file", reason),
            false,
        ));
    };
    let grading = match &fluid.mesh {
        MeshSource::Rectangle { grading, .. } => grading.iter().product::<f64>().sqrt(),
        _ => 1.0,
    };
    let cell = size / grading;
    let diameter = 2.0 * scene.grains.radius.iter().copied().fold(0.0, f64::max);
    let ratio = diameter / cell;
    let spread = ratio > LUMPED_RATIO_MAX;
    let (chosen, reason) = match spread {
        true => (
            "there, each grain over 2.75 of its radii or two cells",
            "grains are not small beside the cells",
        ),
        false => ("left out", "grains are small beside the cells"),
    };
    let choice = Choice {
        bound: Some(LUMPED_RATIO_MAX),
        value: Some(ratio),
        ..plain(PART, chosen, format!("{reason}: diameter over cell"))
    };
    Some((choice, spread))
}

fn passes(scene: &Scene) -> Option<Choice> {
    let coupler = &scene.coupler;
    (coupler.fluid.is_some() && coupler.particles.is_some()).then(|| match coupler.scheme {
        _ if !coupler.reaction => {
            plain("passes", "one a step", "the fluid does not feel the grains")
        }
        Scheme::Iterated { tolerance, .. } => Choice {
            bound: Some(tolerance),
            watched: true,
            ..plain(
                "passes",
                "as few as reach the interaction defect",
                format!("one where no contact interferes; bound {tolerance:e}"),
            )
        },
        _ => plain("passes", "one a step", "coupling.scheme"),
    })
}

fn sub_steps(scene: &Scene) -> Option<Choice> {
    let part = scene.coupler.particles.as_ref()?;
    if scene.coupler.grains_stay {
        return None;
    }
    let (chosen, reason) = match part.solver {
        Some(ContactSolver::Converged) => (
            "one, and more where grains pass each other",
            "contact.solver; from relative motion and gaps",
        ),
        Some(ContactSolver::SmallSteps) => (
            "small steps: eight, and more by load and motion",
            "contact.solver",
        ),
        None => (
            "one, and more where grains pass each other; dry, small steps while they press on each other",
            "a cloud that moves as one needs one, dry heaps are cheaper in small steps",
        ),
    };
    let most = part.sub_steps_max;
    Some(Choice {
        watched: true,
        ..plain("sub-steps", chosen, format!("{reason}; at most {most}"))
    })
}

/// Fields of engines that do not come with every candidate.
pub fn withheld(scene: &Scene) -> Vec<Field> {
    if !scene.leave_out {
        return Vec::new();
    }
    [Role::Fluid, Role::Particles]
        .map(|role| scene.coupler.unread(role))
        .concat()
}

fn fields(scene: &Scene) -> Choice {
    const PART: &str = "fields";
    if !scene.leave_out {
        return plain(PART, "all, with every pass", "run.leave_out = false");
    }
    let names = |fields: &[Field]| {
        fields
            .iter()
            .map(|field| field.name())
            .collect::<Vec<_>>()
            .join(", ")
    };
    let is_never_read = |field: &Field| *field == Field::PressureGradient;
    let (unread, put_out): (Vec<Field>, _) = withheld(scene).into_iter().partition(is_never_read);
    let mut reason = format!("{} with a state that is put out", names(&put_out));
    if !unread.is_empty() {
        reason += &format!("; {} never: no grain reads it", names(&unread));
    }
    if scene.coupler.fluid.is_some() && scene.coupler.particles.is_some() && scene.coupler.reaction
    {
        reason +=
            "; solid flux, entrained fraction and mobility not while they are zero everywhere";
    }
    plain(PART, "sent when they are read", reason)
}

fn output(scene: &Scene) -> Choice {
    let pictures = if scene.output.frames {
        ", a picture each"
    } else {
        ", no pictures"
    };
    match scene.coupler.output_every {
        None => plain(
            "output",
            "first and last state",
            format!("output.every is not set{pictures}"),
        ),
        Some(every) => plain("output", "states", format!("every {every:e} s{pictures}")),
    }
}
