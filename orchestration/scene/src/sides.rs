//! Do grains and fluid have the same sides? What cannot be is refused, what only one of both sees is told.

use std::collections::{BTreeMap, BTreeSet};

use protocol::scene::{Boundary, GrainBoundary, Profile, Wall, fixed};
use space::Dim;

use crate::check::Checker;
use crate::dimensions::{Cells, Corners, Scenic, is_along, sides, words};
use crate::keys::{DefaultWalls, GrainDomain, SIDES, SceneFile};
use crate::outline::{Facet, Outline};
use crate::walls::meets;

/// The sides of a scene with a fluid.
pub struct Sides<'a, const D: usize> {
    /// The scene.
    pub scene: &'a SceneFile<D>,
    /// The fluid's rectangle or box; none: a mesh.
    pub cells: Option<&'a Cells<D>>,
    /// Its conditions.
    pub boundaries: &'a BTreeMap<String, Boundary>,
    /// Its outline.
    pub outline: &'a Outline<D>,
    /// Walls of the grains, besides those of a mesh.
    pub walls: &'a [Wall],
}

impl<const D: usize> Sides<'_, D>
where
    Dim<D>: Scenic<D>,
{
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
            let Ok(velocity) = fixed::<D, f64>(velocity) else {
                continue;
            };
            let mut facets = self.outline.facets.iter().filter(|f| f.boundary == *name);
            if let Some(facet) = facets.find(|facet| !is_along(&velocity, &facet.inward())) {
                let place = words(&facet.corners[0]);
                let why = format!(
                    "a wall moves along itself, and this velocity points across it at {place} m: \
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
                _ if self.cells.is_some() && particles.domain.is_some() => {
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

    fn periods_are_the_same(&self, domain: &GrainDomain<D>, checker: &mut Checker<'_>) {
        for (axis, sides) in sides::<D>().chunks_exact(2).enumerate() {
            let fluid = self.boundaries.get(sides[0]) == Some(&Boundary::Periodic);
            let grains = domain.periodic.0[axis];
            if grains && !fluid {
                checker.refuse(
                    "particles.domain.periodic",
                    format!(
                        "the fluid is not periodic from {} to {}",
                        sides[0], sides[1]
                    ),
                );
            }
            let Some(cells) = self.cells.filter(|_| fluid) else {
                continue;
            };
            let period = cells.upper[axis] - cells.lower[axis];
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
                DefaultWalls::Domain => {
                    let own = &SIDES[2 * axis..2 * axis + 2];
                    !domain.open.iter().any(|side| own.contains(side))
                }
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
                && self.cells.is_some()
                && fixed(velocity).is_ok_and(|velocity| self.lies_along(name, &velocity))
            {
                warnings.push(format!(
                    "the parabolic velocity along {name} moves the fluid only; a uniform one rubs on grains"
                ));
            }
        }
        warnings
    }

    fn lies_along(&self, name: &str, velocity: &[f64; D]) -> bool {
        let mut facets = self.outline.facets.iter().filter(|f| f.boundary == *name);
        !self.scene.grains.is_empty() && facets.all(|facet| is_along(velocity, &facet.inward()))
    }

    fn of_grains(&self, wall: &Wall) -> Option<String> {
        let corners: Result<Vec<[f64; D]>, _> = wall.corners.iter().map(|c| fixed(c)).collect();
        let corners: Corners<D> = fixed(&corners.ok()?).ok()?;
        let ends = format!("{} m", corners.map(|corner| words(&corner)).join(" to "));
        let Some(facet) = self.outline.along(&corners) else {
            return Some(format!(
                "only grains see the wall from {ends}: the fluid has none there"
            ));
        };
        match self.boundaries.get(&facet.boundary) {
            Some(Boundary::Periodic) => Some(format!(
                "only grains see the wall from {ends}: the fluid is periodic there"
            )),
            Some(Boundary::Open { .. })
                if !self
                    .scene
                    .particles
                    .boundaries
                    .contains_key(&facet.boundary) =>
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
        let theirs = self.cells.is_none() && self.scene.particles.walls == DefaultWalls::Domain;
        let facets = self.outline.facets.iter().filter(|facet| {
            matches!(
                self.boundaries.get(&facet.boundary),
                Some(Boundary::NoSlip | Boundary::Slip | Boundary::MovingWall { .. })
            )
        });
        let bare = facets.filter(|facet| !theirs && !self.is_met(facet));
        bare.map(|facet| facet.boundary.as_str()).collect()
    }

    /// Is a wall of the grains all along a facet?
    fn is_met(&self, facet: &Facet<D>) -> bool {
        let reach = self.outline.tolerance();
        let met = |point: &[f64; D]| self.walls.iter().any(|wall| wall.distance(point) <= reach);
        met(&facet.middle()) && facet.corners.iter().all(met)
    }

    /// Names of the boundaries by which grains leave and are taken out: no wall is all along them.
    pub fn exits(&self) -> Vec<String> {
        let keys = &self.scene.particles.boundaries;
        let leads_out = |facet: &&Facet<D>| {
            let condition = self.boundaries.get(&facet.boundary);
            let met = condition.map(|condition| meets(&facet.boundary, condition, keys));
            met == Some(GrainBoundary::Removed) && !self.is_met(facet)
        };
        let facets = self.outline.facets.iter().filter(leads_out);
        let names: BTreeSet<&String> = facets.map(|facet| &facet.boundary).collect();
        names.into_iter().cloned().collect()
    }
}
