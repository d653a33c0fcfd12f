//! Do grains and fluid have the same sides? What cannot be is refused, what only one of both sees is told.

use std::collections::{BTreeMap, BTreeSet};

use protocol::scene::{Boundary, GrainBoundary, Profile, Wall};

use crate::check::Checker;
use crate::keys::{DefaultWalls, GrainDomain, Rectangle, SceneFile};
use crate::outline::{Edge, Outline};
use crate::walls::{is_along, meets};

/// The sides of a scene with a fluid.
pub struct Sides<'a> {
    /// The scene.
    pub scene: &'a SceneFile,
    /// The fluid's rectangle; none: a mesh.
    pub rectangle: Option<&'a Rectangle>,
    /// Its conditions.
    pub boundaries: &'a BTreeMap<String, Boundary>,
    /// Its outline.
    pub outline: &'a Outline,
    /// Walls of the grains, besides those of a mesh.
    pub walls: &'a [Wall],
}

impl Sides<'_> {
    /// Refuse what cannot be.
    pub fn check(&self, checker: &mut Checker<'_>) {
        self.walls_move_along_themselves(checker);
        self.choices_are_of_open_sides(checker);
        if let Some(domain) = &self.scene.particles.domain {
            self.periods_are_the_same(domain, checker);
        }
    }

    fn walls_move_along_themselves(&self, checker: &mut Checker<'_>) {
        for (name, condition) in self.boundaries {
            let Boundary::MovingWall { velocity } = condition else {
                continue;
            };
            let velocity = [velocity[0], velocity[1]];
            let mut edges = self.outline.edges.iter().filter(|e| e.boundary == *name);
            if let Some(edge) = edges.find(|edge| !is_along(velocity, edge.inward())) {
                let [x, y] = edge.a;
                let why = format!(
                    "a wall moves along itself, and this velocity points across it at ({x:e}, {y:e}) m: \
                     turn it, or write {{ inflow = {{ velocity = … }} }}"
                );
                checker.refuse(&format!("fluid.boundaries.{name}.no-slip.velocity"), why);
            }
        }
    }

    fn choices_are_of_open_sides(&self, checker: &mut Checker<'_>) {
        let particles = &self.scene.particles;
        for name in particles.boundaries.keys() {
            let key = format!("particles.boundaries.{name}");
            let known: Vec<&str> = self.boundaries.keys().map(String::as_str).collect();
            match self.boundaries.get(name) {
                _ if self.rectangle.is_some() && particles.domain.is_some() => {
                    checker.refuse(&key, "[particles.domain] says here which sides are open");
                }
                Some(Boundary::Inflow { .. } | Boundary::Open { .. }) => {}
                Some(_) => checker.refuse(
                    &key,
                    "only inflow and open boundaries leave a choice; [particles] walls = \"none\" leaves \
                     all walls of the fluid out",
                ),
                None => {
                    let list = known.join(", ");
                    checker.refuse(&key, format!("no boundary has this name (boundaries: {list})"));
                }
            }
        }
    }

    fn periods_are_the_same(&self, domain: &GrainDomain, checker: &mut Checker<'_>) {
        for (axis, sides) in [["left", "right"], ["bottom", "top"]].iter().enumerate() {
            let fluid = self.boundaries.get(sides[0]) == Some(&Boundary::Periodic);
            let grains = domain.periodic[axis];
            if grains && !fluid {
                checker.refuse(
                    "particles.domain.periodic",
                    format!(
                        "the fluid is not periodic from {} to {}",
                        sides[0], sides[1]
                    ),
                );
            }
            let Some(rectangle) = self.rectangle.filter(|_| fluid) else {
                continue;
            };
            let period = rectangle.upper[axis] - rectangle.lower[axis];
            let own = domain.upper[axis] - domain.lower[axis];
            if grains && (own - period).abs() > 1e-9 * period {
                checker.refuse(
                    "particles.domain.upper",
                    format!(
                        "grains would have the period {own:e} m here, the fluid has {period:e} m"
                    ),
                );
            }
            let walled = match self.scene.particles.walls {
                DefaultWalls::None => !self.scene.walls.is_empty(),
                DefaultWalls::Domain => !domain.open.iter().any(|side| side.name_is(sides)),
            };
            if !grains && !walled {
                checker.refuse(
                    "particles.domain.periodic",
                    format!(
                        "the fluid is periodic from {} to {}, and grains would leave there: make them \
                         periodic too",
                        sides[0], sides[1]
                    ),
                );
            }
        }
    }

    /// Walls that only grains or only the fluid see.
    pub fn warnings(&self) -> Vec<String> {
        let mut warnings: Vec<String> = self
            .walls
            .iter()
            .filter_map(|w| self.of_grains(w))
            .collect();
        let mut names: Vec<&str> = self.of_fluid();
        names.sort_unstable();
        names.dedup();
        if !names.is_empty() && !self.scene.grains.is_empty() {
            let list = names.join(", ");
            warnings.push(format!(
                "grains meet no wall at {list}, where the fluid has one"
            ));
        }
        for (name, condition) in self.boundaries {
            if let Boundary::Inflow {
                velocity,
                profile: Profile::Parabolic,
            } = condition
                && self.rectangle.is_some()
                && self.lies_along(name, [velocity[0], velocity[1]])
            {
                warnings.push(format!(
                    "the parabolic velocity along {name} moves the fluid only; a uniform one rubs on grains"
                ));
            }
        }
        warnings
    }

    fn lies_along(&self, name: &str, velocity: [f64; 2]) -> bool {
        let mut edges = self.outline.edges.iter().filter(|e| e.boundary == *name);
        !self.scene.grains.is_empty() && edges.all(|edge| is_along(velocity, edge.inward()))
    }

    fn of_grains(&self, wall: &Wall) -> Option<String> {
        let [a, b] = [&wall.corners[0], &wall.corners[1]].map(|corner| [corner[0], corner[1]]);
        let ends = format!("({:e}, {:e}) to ({:e}, {:e}) m", a[0], a[1], b[0], b[1]);
        let Some(edge) = self.outline.along(a, b) else {
            return Some(format!(
                "only grains see the wall from {ends}: the fluid has none there"
            ));
        };
        match self.boundaries.get(&edge.boundary) {
            Some(Boundary::Periodic) => Some(format!(
                "only grains see the wall from {ends}: the fluid is periodic there"
            )),
            Some(Boundary::Open { .. })
                if !self.scene.particles.boundaries.contains_key(&edge.boundary) =>
            {
                Some(format!(
                    "only grains see the wall from {ends}: the fluid is open there"
                ))
            }
            _ => None,
        }
    }

    /// Names of the fluid's walls that are none to grains.
    fn of_fluid(&self) -> Vec<&str> {
        let theirs = self.rectangle.is_none() && self.scene.particles.walls == DefaultWalls::Domain;
        let edges = self.outline.edges.iter().filter(|edge| {
            matches!(
                self.boundaries.get(&edge.boundary),
                Some(Boundary::NoSlip | Boundary::Slip | Boundary::MovingWall { .. })
            )
        });
        let bare = edges.filter(|edge| !theirs && !self.is_met(edge));
        bare.map(|edge| edge.boundary.as_str()).collect()
    }

    /// Is a wall of the grains all along an edge?
    fn is_met(&self, edge: &Edge) -> bool {
        let reach = self.outline.tolerance();
        let met = |point: &[f64; 2]| self.walls.iter().any(|wall| wall.distance(point) <= reach);
        [edge.a, edge.middle(), edge.b].iter().all(met)
    }

    /// Names of the boundaries by which grains leave and are taken out: no wall is all along them.
    pub fn exits(&self) -> Vec<String> {
        let keys = &self.scene.particles.boundaries;
        let leads_out = |edge: &&Edge| {
            let condition = self.boundaries.get(&edge.boundary);
            let met = condition.map(|condition| meets(&edge.boundary, condition, keys));
            met == Some(GrainBoundary::Removed) && !self.is_met(edge)
        };
        let edges = self.outline.edges.iter().filter(leads_out);
        let names: BTreeSet<&String> = edges.map(|edge| &edge.boundary).collect();
        names.into_iter().cloned().collect()
    }
}
