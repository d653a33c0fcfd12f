//! Ranges: every number of a scene is looked at once, here; inside it is trusted.

use protocol::field::{Field, Support};
use protocol::monitor::columns;
use protocol::scene::{AdaptiveStep, Geometry, MeanFlow, Nonlinear, Scheme};

use space::{Dim, Dimension, Vector, hypot};

use crate::dimensions::{Cells, Scenic, axes, is_along, sides};
use crate::document::Document;
use crate::keys::{Contact, Coupling, Domain, Fluid, GrainDomain, LimitKeys, Numbers, SceneFile};
use crate::keys::{SIDES, WallKeys};
use crate::memory;
use crate::problem::Problem;
use crate::read::nearest;
use crate::record;

/// Collects the problems of a scene.
pub struct Checker<'a> {
    document: &'a Document,
    /// What was found so far.
    pub problems: Vec<Problem>,
    /// What may surprise.
    pub warnings: Vec<String>,
}

impl<'a> Checker<'a> {
    /// A checker with nothing found.
    pub fn new(document: &'a Document) -> Self {
        Checker {
            document,
            problems: Vec::new(),
            warnings: Vec::new(),
        }
    }

    /// Note what may surprise.
    pub fn warn(&mut self, message: String) {
        self.warnings.push(message);
    }

    /// Note a problem with a key.
    pub fn refuse(&mut self, key: &str, message: impl Into<String>) {
        self.problems.push(self.document.problem(key, message));
    }

    pub(crate) fn positive(&mut self, key: &str, value: f64, unit: &str) {
        if !(value > 0.0 && value.is_finite()) {
            self.refuse(key, format!("must be a finite number greater than 0{unit}"));
        }
    }

    fn not_negative(&mut self, key: &str, value: f64, unit: &str) {
        if !(value >= 0.0 && value.is_finite()) {
            self.refuse(key, format!("must be a finite number, 0{unit} or more"));
        }
    }

    pub(crate) fn finite(&mut self, key: &str, values: &[f64]) {
        if values.iter().any(|value| !value.is_finite()) {
            self.refuse(key, "must be finite numbers");
        }
    }

    pub(crate) fn at_least_one(&mut self, key: &str, value: usize) {
        if value == 0 {
            self.refuse(key, "must be 1 or more");
        }
    }

    /// 0 < tolerance < 1.
    fn tolerance(&mut self, key: &str, value: f64) {
        if !(value > 0.0 && value < 1.0) {
            self.refuse(key, "must be between 0 and 1, both excluded");
        }
    }

    pub(crate) fn corners<const D: usize>(
        &mut self,
        key: &str,
        lower: &[f64; D],
        upper: &[f64; D],
    ) {
        self.finite(&format!("{key}.lower"), lower);
        self.finite(&format!("{key}.upper"), upper);
        self.measurable(&format!("{key}.upper"), lower, upper);
        for (axis, name) in axes::<D>() {
            if lower[axis] >= upper[axis] {
                let (low, high) = (lower[axis], upper[axis]);
                self.refuse(
                    &format!("{key}.upper"),
                    format!("{name} = {high:e} m must be greater than {name} of lower, {low:e} m"),
                );
            }
        }
    }

    /// Lengths have squares.
    fn measurable<const D: usize>(&mut self, key: &str, from: &[f64; D], to: &[f64; D]) {
        let sizes = (0..D).map(|axis| (to[axis] - from[axis]).abs());
        let longest = sizes.fold(0.0, f64::max);
        if longest > 0.0 && !(longest * longest).is_normal() {
            let why = format!("is {longest:e} m from the other end: its square is no number");
            self.refuse(key, why);
        }
    }

    /// Every range of a scene.
    pub fn scene<const D: usize>(&mut self, scene: &SceneFile<D>)
    where
        Dim<D>: Scenic<D>,
    {
        self.positive("run.end_time", scene.run.end_time, " s");
        self.positive("run.coupling_step", scene.run.coupling_step, " s");
        if let Some(step_min) = scene.run.step_min {
            let step = scene.run.coupling_step;
            self.positive("run.step_min", step_min, " s");
            if step_min > step && step > 0.0 {
                let why = format!("must not exceed run.coupling_step = {step:e} s");
                self.refuse("run.step_min", why);
            }
        }
        if scene.run.coupling_step > scene.run.end_time && scene.run.end_time > 0.0 {
            let end = scene.run.end_time;
            self.refuse(
                "run.coupling_step",
                format!("must not exceed run.end_time = {end:e} s"),
            );
        }
        self.steps_are_resolved(scene);
        self.finite("gravity.acceleration", &scene.gravity.acceleration);
        self.parts_present(scene);
        if let Some(fluid) = &scene.fluid {
            self.fluid(fluid);
        }
        for (index, grains) in scene.grains.iter().enumerate() {
            self.population(&format!("grains[{index}]"), grains);
        }
        if let Some(domain) = &scene.particles.domain {
            self.grain_domain(domain);
        }
        for (index, wall) in scene.walls.iter().enumerate() {
            self.wall(&format!("walls[{index}]"), wall);
        }
        if let Some(contact) = &scene.contact {
            self.contact(contact);
        }
        if let Some(coupling) = &scene.coupling {
            self.coupling(coupling, D);
        }
        self.output(scene);
        self.record(scene);
        self.positive("checkpoint.every_wall", scene.checkpoint.every_wall, " s");
        self.limits(&scene.limits);
        self.engines(scene);
    }

    fn wall<const D: usize>(&mut self, key: &str, wall: &WallKeys<D>)
    where
        Dim<D>: Scenic<D>,
    {
        let ends = [("from", &wall.from), ("to", &wall.to)];
        for (name, end) in ends {
            self.finite(
                &format!("{key}.{name}"),
                end.as_ref().map_or(&[], |end| &end.0),
            );
        }
        for (number, corner) in wall.corners.iter().enumerate() {
            self.finite(&format!("{key}.corners[{number}]"), &corner.0);
        }
        if let (Some(from), Some(to)) = (&wall.from, &wall.to) {
            self.measurable(&format!("{key}.to"), &from.0, &to.0);
        }
        let facets = match Dim::<D>::wall(wall) {
            Ok(facets) => facets,
            Err((name, why)) => return self.refuse(&format!("{key}.{name}"), why),
        };
        let Some(Numbers(velocity)) = &wall.velocity else {
            return;
        };
        let key = format!("{key}.velocity");
        self.finite(&key, velocity);
        let leads_across = |corners: &[[f64; D]; D]| {
            let normal = Dim::<D>::inward_normal(&corners.map(Vector::from));
            !is_along(velocity, &(normal / hypot(&normal)))
        };
        if facets.iter().any(leads_across) {
            self.refuse(&key, "must lead along the wall, which stays where it is");
        }
    }

    /// What must be there for what is there.
    fn parts_present<const D: usize>(&mut self, scene: &SceneFile<D>) {
        if scene.fluid.is_none() && scene.grains.is_empty() {
            self.refuse("", "nothing to compute: write [fluid], [[grains]] or both");
        }
        if !scene.grains.is_empty() && scene.contact.is_none() {
            self.refuse(
                "contact",
                "missing, and a scene with grains needs it: write [contact] tolerance = 1e-3 (of |g| Δt)",
            );
        }
        let scheme = scene.coupling.as_ref().and_then(|coupling| coupling.scheme);
        if scene.fluid.is_some() && !scene.grains.is_empty() && scheme.is_none() {
            self.refuse(
                "coupling.scheme",
                "missing, and grains in a fluid need it: \"staggered\" (one pass), or \
                 { iterated = { tolerance = 1e-3, passes_max = 30 } }",
            );
        }
    }

    fn fluid<const D: usize>(&mut self, fluid: &Fluid<D>)
    where
        Dim<D>: Scenic<D>,
    {
        self.positive("fluid.density", fluid.density, " kg/m³");
        self.positive("fluid.dynamic_viscosity", fluid.dynamic_viscosity, " Pa s");
        self.finite("fluid.initial_velocity", &fluid.initial_velocity.0);
        if let Some(MeanFlow::Velocity(Numbers(velocity))) = &fluid.mean_flow {
            self.finite("fluid.mean_flow.velocity", velocity);
        }
        if let Some(factor) = fluid.grad_div {
            self.not_negative("fluid.grad_div", factor, "");
        }
        if let Nonlinear::Newton {
            tolerance,
            iterations_max,
        } = fluid.nonlinear
        {
            self.tolerance("fluid.nonlinear.newton.tolerance", tolerance);
            self.at_least_one("fluid.nonlinear.newton.iterations_max", iterations_max);
        }
        self.domain::<D>(&fluid.domain);
        for (name, boundary) in &fluid.boundaries {
            if let Some((place, numbers)) = boundary.numbers() {
                self.finite(&format!("fluid.boundaries.{name}.{place}"), numbers);
            }
        }
    }

    fn domain<const D: usize>(&mut self, domain: &Domain)
    where
        Dim<D>: Scenic<D>,
    {
        let given = [
            domain.rectangle.is_some(),
            domain.cells.is_some(),
            domain.mesh.is_some(),
        ];
        if given.iter().filter(|&&given| given).count() != 1 {
            return self.refuse(
                "fluid.domain",
                "write exactly one of rectangle, box and mesh",
            );
        }
        if let Some(scale) = domain.scale.filter(|_| domain.mesh.is_some()) {
            self.positive(
                "fluid.domain.scale",
                scale,
                " (metres of a unit of the file)",
            );
        }
        if domain.mesh.is_none() && (domain.scale.is_some() || !domain.surfaces.is_empty()) {
            self.refuse(
                "fluid.domain",
                "scale and surfaces are for a mesh: leave them out",
            );
        }
        if let Some(cells) = Dim::<D>::cells(domain) {
            self.cells(&cells);
        }
    }

    fn cells<const D: usize>(&mut self, cells: &Cells<D>) {
        let key = cells.key;
        self.corners(key, &cells.lower, &cells.upper);
        if cells.cells.contains(&0) {
            let names = ["x and y", "x, y, z"][D - 2];
            let why = format!("must be 1 or more in {names}");
            self.refuse(&format!("{key}.cells"), why);
        }
        let nodes = cells.cells.iter().map(|&count| count as f64 + 1.0);
        if let Some(why) = memory::refusal("nodes", nodes.product(), memory::NODE) {
            self.refuse(&format!("{key}.cells"), why);
        }
        if cells
            .grading
            .iter()
            .any(|&ratio| !(ratio >= 1.0 && ratio.is_finite()))
        {
            self.refuse(
                &format!("{key}.grading"),
                "must be 1 (all cells equal) or more",
            );
        }
    }

    fn grain_domain<const D: usize>(&mut self, domain: &GrainDomain<D>) {
        self.corners("particles.domain", &domain.lower, &domain.upper);
        for (index, side) in domain.open.iter().enumerate() {
            if !SIDES[..2 * D].contains(side) {
                let known = sides::<D>().join(", ");
                let why = format!("is no side here (allowed: {known})");
                self.refuse(&format!("particles.domain.open[{index}]"), why);
            }
        }
    }

    fn contact(&mut self, contact: &Contact) {
        self.not_negative("contact.friction", contact.friction, "");
        if let Some(friction) = contact.wall_friction {
            self.not_negative("contact.wall_friction", friction, "");
        }
        self.tolerance("contact.tolerance", contact.tolerance);
        self.at_least_one("contact.sweeps_max", contact.sweeps_max);
        self.at_least_one("contact.sub_steps_max", contact.sub_steps_max as usize);
    }

    fn coupling(&mut self, coupling: &Coupling, dimension: usize) {
        if let Some(Scheme::Iterated {
            tolerance,
            passes_max,
        }) = coupling.scheme
        {
            self.tolerance("coupling.scheme.iterated.tolerance", tolerance);
            self.at_least_one("coupling.scheme.iterated.passes_max", passes_max as usize);
        }
        if coupling.geometry.is_some() && dimension > 2 {
            self.refuse(
                "coupling.geometry",
                "is of the plane: in space grains are spheres, leave it out",
            );
        } else if let Some(Geometry::Sphere { depth }) = coupling.geometry {
            self.positive("coupling.geometry.sphere.depth", depth, " m");
        }
        if let Some(AdaptiveStep {
            step_min,
            step_max,
            courant,
        }) = coupling.adaptive
        {
            self.positive("coupling.adaptive.step_min", step_min, " s");
            if !(step_max >= step_min && step_max.is_finite()) {
                let message = format!("must be step_min = {step_min:e} s or more");
                self.refuse("coupling.adaptive.step_max", message);
            }
            self.positive(
                "coupling.adaptive.courant",
                courant,
                " (cells a grain may cross in a step)",
            );
        }
    }

    fn output<const D: usize>(&mut self, scene: &SceneFile<D>) {
        if let Some(every) = scene.output.every {
            self.positive("output.every", every, " s");
            self.output_is_resolved(scene, every);
        }
        let (nodes, grains) = (scene.fluid.is_some(), !scene.grains.is_empty());
        let written = |field: &&Field| match field.support() {
            Support::Grain => grains,
            _ => nodes,
        };
        let known = columns::WRITTEN.iter().filter(written);
        let known: Vec<&str> = known.map(|field| field.name()).collect();
        for (index, name) in scene.output.fields.iter().flatten().enumerate() {
            if !known.contains(&name.as_str()) {
                let meant = nearest(name, &known)
                    .map_or(String::new(), |name| format!("; did you mean {name}?"));
                let list = known.join(", ");
                self.refuse(
                    &format!("output.fields[{index}]"),
                    format!("no field of this name is written{meant} (written: {list})"),
                );
            }
        }
    }

    fn record<const D: usize>(&mut self, scene: &SceneFile<D>) {
        let file = scene.record.as_ref().map(|record| record.file.as_str());
        if let Some(Err(why)) = file.map(record::check_file) {
            self.refuse("record.file", why);
        }
    }

    fn limits(&mut self, limits: &LimitKeys) {
        self.positive("limits.connect", limits.connect, " s");
        self.positive("limits.configure", limits.configure, " s");
        self.positive("limits.step", limits.step, " s");
    }

    fn engines<const D: usize>(&mut self, scene: &SceneFile<D>) {
        let seats = [
            ("fluid", &scene.engines.fluid),
            ("particles", &scene.engines.particles),
        ];
        for (seat, engine) in seats {
            if engine
                .as_ref()
                .is_some_and(|engine| engine.command.is_empty())
            {
                self.refuse(
                    &format!("engines.{seat}.command"),
                    "must name a program, e.g. [\"python3\", \"my_engine.py\"]",
                );
            }
        }
    }
}
