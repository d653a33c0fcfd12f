//! Sub-steps with the same candidates, one after the other.

use space::{Dim, Dimension, Vector};

use crate::contact::impulses::{Impulses, Pair};
use crate::contact::law::Local;
use crate::contact::loads::Loads;
use crate::grains::State;
use crate::small::near::{Found, Near};
use crate::small::pass::{Frame, Path, apply, begin, end, geometry, visit_all};
use crate::small::records::{Body, Contact, Free, Given, Sum, bodies, contacts};
use crate::step::candidate::ActiveContact;
use crate::step::correct::RECOVERY_MAX;
use crate::step::sub_step::Stage;

/// Sub-steps with the same candidates.
#[derive(Debug)]
pub struct Stretch<'a, const D: usize>
where
    Dim<D>: Dimension<D>,
{
    frame: Frame<'a, D>,
    near: &'a [Near],
    bodies: Vec<Body<D>>,
    free: Vec<Free<D>>,
    given: Vec<Given<D>>,
    contacts: Vec<Contact<D>>,
    /// What each contact gave.
    sums: Vec<Sum<D>>,
    paths: Vec<Path<D>>,
}

impl<'a, const D: usize> Stretch<'a, D>
where
    Dim<D>: Dimension<D>,
{
    /// From this state with sub-steps of length `loads.dt` and the candidates found in it.
    pub fn new(
        stage: &'a Stage<'_, D>,
        state: &State<D>,
        loads: &Loads<'_, D>,
        found: &'a Found<D>,
    ) -> Stretch<'a, D> {
        let place = (stage.grains, stage.walls);
        let (bodies, free) = bodies(place, &stage.material, state, loads);
        let contacts = contacts(&found.near, place, &bodies);
        let starts = state.position.iter().zip(&found.velocity);
        let given = Given {
            velocity: Vector::zeros(),
            surface: Default::default(),
        };
        let sum = Sum {
            normal: 0.0,
            impulse: Vector::zeros(),
        };
        let mut stretch = Stretch {
            frame: Frame {
                walls: stage.walls,
                shifts: &found.shifts,
                friction: stage.material.friction,
                ground: stage.grains.count() as u32,
                dt: loads.dt,
            },
            near: &found.near,
            given: vec![given; free.len()],
            sums: vec![sum; contacts.len()],
            paths: starts
                .map(|(&from, &velocity)| Path { from, velocity })
                .collect(),
            bodies,
            free,
            contacts,
        };
        stretch.recall(&state.impulses);
        stretch
    }

    /// Let the contacts start from these impulses, as if they had just given them.
    fn recall(&mut self, impulses: &Impulses<D>) {
        let keys = self.near.iter().map(|near| near.key);
        let recalled = impulses.recall(keys, self.frame.dt);
        for (given, body) in self.given.iter_mut().zip(&self.bodies) {
            (given.velocity, given.surface) = (body.velocity, body.surface);
        }
        for (contact, impulse) in self.contacts.iter_mut().zip(recalled) {
            if impulse.normal == 0.0 {
                continue;
            }
            let (one, two) = (contact.first as usize, contact.second as usize);
            let (one, two) = (&self.bodies[one], &self.bodies[two]);
            if let Some((_, normal)) = geometry(&self.frame, contact, one, two) {
                apply(&mut self.bodies, contact, impulse, &normal);
            }
        }
        for (given, body) in self.given.iter_mut().zip(&mut self.bodies) {
            let before = *given;
            given.velocity = body.velocity - before.velocity;
            given.surface = body.surface - before.surface;
            (body.velocity, body.surface) = (before.velocity, before.surface);
        }
    }

    /// Up to so many sub-steps, fewer when a grain strays from its path: how many, and does one stray?
    pub fn run(&mut self, most: u32) -> (u32, bool) {
        let dt = self.frame.dt;
        let (mut made, mut strays) = (0, false);
        while made < most && !strays {
            begin(&mut self.bodies, &self.free, &mut self.given);
            visit_all(
                &self.frame,
                &mut self.bodies,
                &mut self.contacts,
                &mut self.sums,
            );
            made += 1;
            let time = dt * f64::from(made);
            strays = end(&mut self.bodies, &mut self.given, &self.paths, (dt, time));
        }
        (made, strays)
    }

    /// Write what has changed into the state, and into the displacement since the start of the step \[m\].
    pub fn store(&self, state: &mut State<D>, displacement: &mut [Vector<D>]) {
        let count = self.free.len();
        for (grain, body) in self.bodies[..count].iter().enumerate() {
            displacement[grain] += body.position - state.position[grain];
            state.position[grain] = body.position;
            state.velocity[grain] = body.velocity;
            if self.frame.friction.acts() {
                state.spin[grain] = body.surface / body.radius;
            }
        }
        let contacts = self.near.iter().zip(&self.contacts);
        let acting = contacts.filter(|(_, contact)| contact.normal > 0.0);
        let entries = acting.map(|(near, contact)| (near.key, self.impulse(contact)));
        state.impulses = Impulses {
            dt: self.frame.dt,
            entries: entries.collect(),
        };
    }

    /// (R_n, R_t) of the last sub-step.
    fn impulse(&self, contact: &Contact<D>) -> Local<D> {
        let tangential = match self.geometry(contact) {
            Some((_, normal)) => Dim::<D>::surface(contact.torque, &normal),
            None => Default::default(),
        };
        Local {
            normal: contact.normal,
            tangential,
        }
    }

    fn geometry(&self, contact: &Contact<D>) -> Option<(f64, Vector<D>)> {
        let (one, two) = (contact.first as usize, contact.second as usize);
        geometry(&self.frame, contact, &self.bodies[one], &self.bodies[two])
    }

    /// How many candidates there are.
    pub fn candidates(&self) -> usize {
        self.near.len()
    }

    /// The candidates that a position pass may bring together, where the grains are now; those beyond the end of a
    /// wall are none.
    pub fn pairs(&self) -> Vec<Pair<D>> {
        let contacts = self.near.iter().zip(&self.contacts);
        let pair = |(near, contact): (&Near, &Contact<D>)| {
            let (gap, normal) = self.geometry(contact)?;
            let (one, two) = (contact.first as usize, contact.second as usize);
            let smaller = self.bodies[one].radius.min(self.bodies[two].radius);
            let key = near.key;
            (gap < 2.0 * RECOVERY_MAX * smaller).then_some(Pair { key, normal, gap })
        };
        contacts.filter_map(pair).collect()
    }

    /// Contacts that acted, as if what they gave had been given in the time `dt` \[s\].
    pub fn acted(&self, dt: f64) -> Vec<ActiveContact<D>> {
        let contacts = self.near.iter().zip(&self.contacts).zip(&self.sums);
        let acted = contacts.filter(|(_, sum)| sum.normal > 0.0);
        let active = acted.map(|((near, contact), sum)| {
            let (gap, normal) = self.geometry(contact).unwrap_or((0.0, Vector::zeros()));
            let key = near.key;
            let push = sum.impulse * (1.0 / dt);
            let force = Local {
                normal: sum.normal / dt,
                tangential: Dim::<D>::tangential(&push, &normal),
            };
            let pair = Pair { key, normal, gap };
            ActiveContact { pair, force, push }
        });
        active.collect()
    }
}
