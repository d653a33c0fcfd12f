//! The contact operator, matrix-free: bodies carry velocities, contacts carry impulses.
//!
//! ```text
//!   A = m + γδt                     inertia with implicit drag                            (D1)
//!   v_free = (m vⁿ + δt (m g + q))/A                                                      (D2)
//!   v = v_free + A⁻¹ Hᵀ R,   A (v − v_free) is each grain's sum of impulses               (D3)
//!   W_nn = 1/A_i + 1/A_j,    W_tt = W_nn + r_i²/I_i + r_j²/I_j                            (D4)
//! ```
//!
//! The drag is in A, hence in the contact operator: with the bare mass two grains pressed
//! together keep their gap but miss their momentum balance by as much as the contact force.
//! For disks the normal passes through both centres, so W_nt = 0. Fluid torque is not modelled:
//! I has no drag. Spin appears as the surface speed s = r ω, its inverse inertia r²/I = 1/(κ m).
//!
//! # The residual
//!
//! The natural map (law) is an impulse; it is compared with the impulse that the force on a
//! grain gives in a sub-step:
//!
//! ```text
//!   e_c = |natural map|_c / (δt F_c)                                                      (D5)
//!   F_i = m_i |g| + |q_i − γ_i v_i^n|                                                     (D6)
//!   F_c = min( r_c/(10 W_nn δt²), max( min(F_i, F_j), m_c max(ā/10, â/100) ) )            (D7)
//!   ā = Σ F_i / Σ m_i,    â = rms over contacts of [−U_n(v_free)]₊ /(W_nn δt m_c)
//! ```
//!
//! A free grain at rest gains the velocity δt F/(m + γδt), and W_nn e_c δt F_c is the violation
//! of the laws in velocity, so e is relative to the free velocity increment of the lighter grain:
//! without drag to |g|δt, with stiff drag to |g|m/γ, which may be 1e-5 of it. F uses the sum of
//! the magnitudes, because at terminal speed weight and drag cancel. Immobile partners do not
//! count. The floor (D7) serves grains on which nothing acts, as in an impact without gravity:
//! a tenth of the mean force per mass, or a hundredth of the rms impact. The cap keeps what a
//! violation can move grains into each other to a tenth of the smaller radius r_c, times the
//! tolerance; it acts where forces would move a grain farther than that in a sub-step.
//! m_c is the smaller mass. The root mean square is
//! over engaged contacts (R_n > 0 or U_n < 0), so it does not depend on the detection margin.

use crate::contact::Candidate;
use crate::grains::Grains;
use crate::law::{closing_speed, natural_map};
use crate::sub_step::Stage;
use crate::vector::Vector;

/// A body of the contact problem; one cache line.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
#[repr(C, align(64))]
pub struct Body {
    /// v \[m/s\].
    pub velocity: Vector,
    /// r ω \[m/s\].
    pub surface_speed: f64,
    /// 1/A \[1/kg\]; 0 when it cannot move.
    pub inverse_mass: f64,
    /// r²/I \[1/kg\].
    pub inverse_inertia: f64,
}

/// A contact of the contact problem; one cache line.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
#[repr(C, align(64))]
pub struct Contact {
    /// Body that the normal points to.
    pub first: u32,
    /// Body that the normal comes from; the last body is the ground.
    pub second: u32,
    /// Unit normal.
    pub normal: Vector,
    /// b of (L1) \[m/s\].
    pub closing_speed: f64,
    /// R_n ≥ 0 \[N s\].
    pub normal_impulse: f64,
    /// R_t \[N s\], along the normal turned to the left.
    pub tangential_impulse: f64,
    /// 1/W_nn \[kg\].
    pub normal_mass: f64,
    /// 1/W_tt \[kg\].
    pub tangential_mass: f64,
}

/// How far the impulses are from the laws, in the unit of (D5).
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Residual {
    /// Root mean square over engaged contacts.
    pub rms: f64,
    /// Largest.
    pub max: f64,
}

/// The worst contact may have this many times the tolerance.
pub const MAX_OVER_RMS: f64 = 20.0;

impl Residual {
    /// Good enough: rms below the tolerance, no contact far above it. Not finite is not good.
    pub fn within(&self, tolerance: f64) -> bool {
        self.rms <= tolerance && self.max <= MAX_OVER_RMS * tolerance
    }

    /// One number to compare iterates by.
    pub fn size(&self) -> f64 {
        self.rms.max(self.max / MAX_OVER_RMS)
    }
}

/// One contact problem.
#[derive(Debug, Clone, Default)]
pub struct System {
    /// One a grain, and the ground.
    pub bodies: Vec<Body>,
    /// Candidate contacts.
    pub contacts: Vec<Contact>,
    /// 1/(δt F_c) of each contact \[1/(N s)\].
    pub weights: Vec<f64>,
    /// Free velocity and surface speed of each body.
    pub free: Vec<(Vector, f64)>,
    /// μ between grains, and between a grain and a wall.
    pub friction: [f64; 2],
}

/// What acts on the grains during a sub-step.
#[derive(Debug)]
pub struct Loads<'a> {
    /// Length of the sub-step \[s\].
    pub dt: f64,
    /// g \[m/s²\].
    pub gravity: Vector,
    /// γ \[kg/s\].
    pub drag: Option<&'a [f64]>,
    /// q \[N\], interleaved.
    pub force: Option<&'a [f64]>,
}

impl Loads<'_> {
    fn on(&self, grain: usize) -> (f64, Vector) {
        let drag = self.drag.map_or(0.0, |drag| drag[grain]);
        let force = self
            .force
            .map_or([0.0; 2], |q| [q[2 * grain], q[2 * grain + 1]]);
        (drag, force)
    }

    /// v_free (D2); 0 for a fixed grain.
    pub fn free_velocity(&self, grains: &Grains, velocity: &[Vector]) -> Vec<Vector> {
        let one = |grain: usize| {
            if grains.fixed[grain] {
                return [0.0; 2];
            }
            let mass = grains.mass[grain];
            let (drag, force) = self.on(grain);
            let along = |axis: usize| {
                let weight = mass * self.gravity[axis];
                (mass * velocity[grain][axis] + self.dt * (weight + force[axis]))
                    / (mass + self.dt * drag)
            };
            [along(0), along(1)]
        };
        (0..grains.count()).map(one).collect()
    }

    /// F (D6) \[N\].
    fn force_scale(&self, grains: &Grains, velocity: &[Vector], grain: usize) -> f64 {
        let (drag, force) = self.on(grain);
        let [x, y] = velocity[grain];
        let applied = (force[0] - drag * x).hypot(force[1] - drag * y);
        grains.mass[grain] * self.gravity[0].hypot(self.gravity[1]) + applied
    }
}

impl System {
    /// Assemble (D1)–(D4) at the free velocities, without impulses.
    pub fn assemble(
        stage: &Stage<'_>,
        loads: &Loads<'_>,
        free_velocity: &[Vector],
        surface_speed: &[f64],
        candidates: &[Candidate],
    ) -> System {
        let Stage {
            grains,
            inertia_factor,
            friction,
            ..
        } = *stage;
        let count = grains.count();
        let mut bodies = vec![Body::default(); count + 1];
        for (grain, body) in bodies[..count].iter_mut().enumerate() {
            body.velocity = free_velocity[grain];
            if !grains.fixed[grain] {
                body.surface_speed = surface_speed[grain];
                body.inverse_mass = 1.0 / (grains.mass[grain] + loads.dt * loads.on(grain).0);
                body.inverse_inertia = 1.0 / (inertia_factor * grains.mass[grain]);
            }
        }
        let contacts = candidates
            .iter()
            .map(|candidate| Self::contact(&bodies, candidate, loads.dt))
            .collect();
        let free = bodies
            .iter()
            .map(|body| (body.velocity, body.surface_speed))
            .collect();
        System {
            bodies,
            contacts,
            weights: Vec::new(),
            free,
            friction,
        }
    }

    fn contact(bodies: &[Body], candidate: &Candidate, dt: f64) -> Contact {
        let ground = bodies.len() as u32 - 1;
        let (first, second) = (candidate.key.first, candidate.key.second.min(ground));
        let (one, two) = (&bodies[first as usize], &bodies[second as usize]);
        let normal = one.inverse_mass + two.inverse_mass;
        Contact {
            first,
            second,
            normal: candidate.normal,
            closing_speed: closing_speed(candidate.gap, dt),
            normal_mass: 1.0 / normal,
            tangential_mass: 1.0 / (normal + one.inverse_inertia + two.inverse_inertia),
            ..Contact::default()
        }
    }

    /// Set the weights of the residual (D5)–(D7); call at the free velocity.
    pub fn weigh(&mut self, grains: &Grains, loads: &Loads<'_>, velocity: &[Vector]) {
        let scale: Vec<f64> = (0..grains.count())
            .map(|grain| loads.force_scale(grains, velocity, grain))
            .collect();
        let (mut force, mut mass) = (0.0, 0.0);
        for grain in (0..grains.count()).filter(|&grain| !grains.fixed[grain]) {
            force += scale[grain];
            mass += grains.mass[grain];
        }
        let smaller = |contact: &Contact, of: &[f64]| {
            let one = |body: u32| match self.bodies[body as usize].inverse_mass > 0.0 {
                true => of[body as usize],
                false => f64::INFINITY,
            };
            one(contact.first).min(one(contact.second))
        };
        let (mut squares, mut engaged) = (0.0, 0usize);
        for contact in &self.contacts {
            let violation = -self.speed(contact)[0];
            if violation > 0.0 {
                let mass = smaller(contact, &grains.mass);
                squares += (violation * contact.normal_mass / (loads.dt * mass)).powi(2);
                engaged += 1;
            }
        }
        let impact = (squares / engaged.max(1) as f64).sqrt();
        let floor = f64::max(0.1 * force / mass, 0.01 * impact);
        self.weights = self
            .contacts
            .iter()
            .map(|contact| {
                let floor = floor * smaller(contact, &grains.mass);
                let radius = smaller(contact, &grains.radius);
                let cap = 0.1 * radius * contact.normal_mass / (loads.dt * loads.dt);
                let scale = loads.dt * smaller(contact, &scale).max(floor).min(cap);
                if scale > 0.0 { 1.0 / scale } else { 0.0 }
            })
            .collect();
    }

    /// Is any tangential work to be done?
    pub fn has_friction(&self) -> bool {
        self.friction.iter().any(|&friction| friction > 0.0)
    }

    /// μ of a contact.
    #[inline]
    pub fn friction_of(&self, contact: &Contact) -> f64 {
        self.friction[usize::from(contact.second as usize + 1 == self.bodies.len())]
    }

    /// (U_n, u_t) of a contact \[m/s\].
    #[inline]
    pub fn speed(&self, contact: &Contact) -> [f64; 2] {
        relative_speed(
            &self.bodies[contact.first as usize],
            &self.bodies[contact.second as usize],
            contact,
        )
    }

    /// v = v_free + A⁻¹HᵀR (D3), from scratch: momentum is then exact to round-off per grain.
    pub fn apply_impulses(&mut self) {
        for (body, free) in self.bodies.iter_mut().zip(&self.free) {
            (body.velocity, body.surface_speed) = *free;
        }
        for place in 0..self.contacts.len() {
            let contact = self.contacts[place];
            if contact.normal_impulse != 0.0 || contact.tangential_impulse != 0.0 {
                let change = [contact.normal_impulse, contact.tangential_impulse];
                push(&mut self.bodies, &contact, change);
            }
        }
    }

    /// The impulses, to come back to.
    pub fn impulses(&self) -> Vec<[f64; 2]> {
        self.contacts
            .iter()
            .map(|c| [c.normal_impulse, c.tangential_impulse])
            .collect()
    }

    /// Set the impulses, brought into the cone, and the velocities that follow from them.
    pub fn set_impulses(&mut self, impulses: &[[f64; 2]]) {
        let (friction, ground) = (self.friction, self.bodies.len() - 1);
        for (contact, impulse) in self.contacts.iter_mut().zip(impulses) {
            let limit = friction[usize::from(contact.second as usize == ground)] * impulse[0];
            contact.normal_impulse = impulse[0];
            contact.tangential_impulse = impulse[1].min(limit).max(-limit);
        }
        self.apply_impulses();
    }

    /// The residual at the present impulses and velocities.
    pub fn residual(&self) -> Residual {
        let rough = self.has_friction();
        let (mut squares, mut max, mut engaged) = (0.0, 0.0, 0usize);
        for (contact, weight) in self.contacts.iter().zip(&self.weights) {
            let speed = self.speed(contact);
            if contact.normal_impulse == 0.0 && speed[0] >= 0.0 {
                continue;
            }
            let impulse = [contact.normal_impulse, contact.tangential_impulse];
            let k = [contact.normal_mass, contact.tangential_mass];
            let mut map = natural_map(impulse, speed, k, self.friction_of(contact));
            if !rough {
                map[1] = 0.0;
            }
            let square = (map[0] * map[0] + map[1] * map[1]) * weight * weight;
            squares += square;
            max = if square > max { square } else { max };
            engaged += 1;
        }
        Residual {
            rms: (squares / engaged.max(1) as f64).sqrt(),
            max: max.sqrt(),
        }
    }
}

/// (U_n, u_t) between two bodies; the tangent is the normal turned to the left.
#[inline(always)]
pub fn relative_speed(one: &Body, two: &Body, contact: &Contact) -> [f64; 2] {
    let [nx, ny] = contact.normal;
    let x = one.velocity[0] - two.velocity[0];
    let y = one.velocity[1] - two.velocity[1];
    let tangential = y * nx - x * ny - one.surface_speed - two.surface_speed;
    [x * nx + y * ny + contact.closing_speed, tangential]
}

/// Add a change of impulse (normal, tangential) to the velocities of both bodies.
#[inline(always)]
pub fn push(bodies: &mut [Body], contact: &Contact, change: [f64; 2]) {
    let [nx, ny] = contact.normal;
    let impulse = [
        change[0] * nx - change[1] * ny,
        change[0] * ny + change[1] * nx,
    ];
    let one = &mut bodies[contact.first as usize];
    one.velocity[0] += one.inverse_mass * impulse[0];
    one.velocity[1] += one.inverse_mass * impulse[1];
    one.surface_speed -= one.inverse_inertia * change[1];
    let two = &mut bodies[contact.second as usize];
    two.velocity[0] -= two.inverse_mass * impulse[0];
    two.velocity[1] -= two.inverse_mass * impulse[1];
    two.surface_speed -= two.inverse_inertia * change[1];
}
