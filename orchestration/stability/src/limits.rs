//! Closed forms that the small scenes are held against: a uniform suspension is one ordinary
//! differential equation for its slip w, interstitial, grain against fluid.
//!
//! ```text
//!   closed column     M w' = φ V (ρ_p − ρ) g − γ(w) w,   M = φ m [φ + (1−φ) ρ/ρ_p],   v_p = φ w      (L1)
//!   periodic, g = 0   M w' = −γ(w) w,   M = m m_f/(m + m_f),   m_f = ρφV/(1−φ)                    (L2)
//!                     v_p = (m v_p⁰ + m_f v_f⁰)/(m + m_f) + w m_f/(m + m_f)
//!   bed at rest       Δp/L = ρ g + (1−φ)/V γ(U/φ) U/φ²                                            (L3)
//!   lift              γ(w) w = φ V (ρ_p − ρ) g,   U_mf = φ w                                       (L4)
//! ```
//!
//! In (L1) the mixture's volume flux is zero; M holds the inertia of both phases. Laws of γ: Stokes,
//! 12 μ A/d (6πμr of a sphere), and Dallavalle with φ^−1.8, of which γ w has a closed inverse. They are written here
//! again and not taken from the coupler, which is what they judge.

use std::f64::consts::PI;

/// Law of γ.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Law {
    /// Without hindrance.
    Stokes,
    /// With φ^−1.8.
    Dallavalle,
}

/// What a grain is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Shape {
    /// A disk, per metre of depth.
    Disk,
    /// A sphere in a slab of this depth \[m\]: of any solid fraction without a contact.
    SphereInSlab {
        /// Depth of the slab \[m\].
        depth: f64,
    },
    /// A sphere in space.
    Sphere,
}

/// A uniform suspension, SI units.
#[derive(Debug, Clone, Copy)]
pub struct Suspension {
    /// Law of γ.
    pub law: Law,
    /// Disk or sphere.
    pub shape: Shape,
    /// Radius of a grain.
    pub radius: f64,
    /// ρ_p.
    pub grain_density: f64,
    /// ρ.
    pub density: f64,
    /// μ.
    pub viscosity: f64,
    /// φ.
    pub porosity: f64,
}

impl Suspension {
    /// Volume of a grain.
    pub fn volume(&self) -> f64 {
        let disk = PI * self.radius.powi(2);
        match self.shape {
            Shape::Disk => disk,
            Shape::SphereInSlab { .. } | Shape::Sphere => 4.0 / 3.0 * disk * self.radius,
        }
    }

    /// Depth of a slab that is thinner than a grain is wide \[m\].
    pub fn thin_slab(&self) -> Option<f64> {
        match self.shape {
            Shape::SphereInSlab { depth } if depth < 2.0 * self.radius => Some(depth),
            _ => None,
        }
    }

    fn frontal_area(&self) -> f64 {
        match self.shape {
            Shape::Disk => 2.0 * self.radius,
            Shape::SphereInSlab { .. } | Shape::Sphere => PI * self.radius.powi(2),
        }
    }

    /// m.
    pub fn mass(&self) -> f64 {
        self.grain_density * self.volume()
    }

    /// Mass of the fluid of a grain.
    fn fluid_mass(&self) -> f64 {
        self.density * self.porosity * self.volume() / (1.0 - self.porosity)
    }

    /// k and b of γ w = k (0.63 w + b √w)².
    fn dallavalle(&self) -> (f64, f64) {
        let diameter = 2.0 * self.radius;
        let scale = 0.5 * self.density * self.frontal_area() * self.porosity.powf(-1.8);
        let viscous = 4.8 * (self.viscosity / (self.density * self.porosity * diameter)).sqrt();
        (scale, viscous)
    }

    /// γ at this slip speed.
    pub fn drag(&self, slip: f64) -> f64 {
        match self.law {
            Law::Stokes => 6.0 * self.viscosity * self.frontal_area() / self.radius,
            Law::Dallavalle => {
                let (scale, viscous) = self.dallavalle();
                scale * (0.63 * slip.abs().sqrt() + viscous).powi(2)
            }
        }
    }

    /// w with γ(w) w = drive, of the sign of the drive.
    pub fn slip_carrying(&self, drive: f64) -> f64 {
        let speed = match self.law {
            Law::Stokes => drive.abs() / self.drag(0.0),
            Law::Dallavalle => {
                let (scale, viscous) = self.dallavalle();
                let root = (drive.abs() / scale).sqrt();
                // 0.63 s² + b s = root with s = √w, without cancellation
                let s = 2.0 * root / (viscous + (viscous * viscous + 4.0 * 0.63 * root).sqrt());
                s * s
            }
        };
        speed.copysign(drive)
    }

    /// φ V (ρ_p − ρ) g: what the drag carries at zero volume flux.
    fn drive(&self, gravity: f64) -> f64 {
        self.porosity * self.volume() * (self.grain_density - self.density) * gravity
    }

    /// Fall of the grains of a closed column after `time`, from rest (L1): velocity and way.
    pub fn settling(&self, gravity: f64, time: f64) -> (f64, f64) {
        let inertia = self.porosity
            * self.mass()
            * (self.porosity + (1.0 - self.porosity) * self.density / self.grain_density);
        let (slip, way) = self.slip_after(0.0, self.drive(gravity), inertia, time);
        (self.porosity * slip, self.porosity * way)
    }

    /// Their velocity after a long time.
    pub fn settled(&self, gravity: f64) -> f64 {
        self.porosity * self.slip_carrying(self.drive(gravity))
    }

    /// Velocity of grains after `time` in a periodic box without gravity, where they began with `speed`
    /// and the fluid at rest (L2).
    pub fn drifting(&self, speed: f64, time: f64) -> f64 {
        let (solid, fluid) = (self.mass(), self.fluid_mass());
        let inertia = solid * fluid / (solid + fluid);
        let (slip, _) = self.slip_after(speed, 0.0, inertia, time);
        (solid * speed + fluid * slip) / (solid + fluid)
    }

    /// Pressure gradient below a bed that rests, at superficial velocity U (L3), and U_mf (L4).
    pub fn bed(&self, share: f64, gravity: f64) -> (f64, f64) {
        let lifting = self.porosity * self.slip_carrying(self.drive(gravity));
        let (speed, porosity) = (share * lifting, self.porosity);
        let drag = self.drag(speed / porosity) * speed / (porosity * porosity);
        let gradient = self.density * gravity + (1.0 - porosity) / self.volume() * drag;
        (gradient, speed)
    }

    /// M w' = F − γ(w) w over `time`: slip and its integral, by steps that each cross a small part of
    /// the relaxation time.
    fn slip_after(&self, start: f64, drive: f64, inertia: f64, time: f64) -> (f64, f64) {
        let rate = |w: f64| (drive - self.drag(w) * w) / inertia;
        let (mut slip, mut way, mut left) = (start, 0.0, time);
        let end = if drive == 0.0 {
            0.0
        } else {
            self.slip_carrying(drive)
        };
        while left > 0.0 {
            if (slip - end).abs() <= 1e-12 * start.abs().max(end.abs()) {
                return (end, way + end * left);
            }
            let step = (0.02 * inertia / self.drag(slip))
                .min(0.01 * time)
                .min(left);
            // classical Runge–Kutta
            let a = rate(slip);
            let b = rate(slip + 0.5 * step * a);
            let c = rate(slip + 0.5 * step * b);
            let d = rate(slip + step * c);
            let next = slip + step / 6.0 * (a + 2.0 * b + 2.0 * c + d);
            way += 0.5 * step * (slip + next);
            slip = next;
            left -= step;
        }
        (slip, way)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn water(law: Law) -> Suspension {
        Suspension {
            law,
            shape: Shape::Disk,
            radius: 5e-5,
            grain_density: 2500.0,
            density: 1000.0,
            viscosity: 1e-3,
            porosity: 0.99,
        }
    }

    #[test]
    fn the_settled_velocity_is_the_row_of_the_reference_table() {
        // stiffness.csv: glass/water 100um, c = 0.01: u_p = 7.6883e-3 × 0.99 is the slip's share
        let glass = water(Law::Dallavalle);
        let slip = glass.slip_carrying(glass.drive(9.81));
        let reynolds = slip * 1000.0 * 1e-4 / 1e-3;
        println!("slip {slip:.5e} m/s, Re {reynolds:.4e}");
        assert!((glass.drag(slip) * slip / glass.drive(9.81) - 1.0).abs() < 1e-12);
        assert!((slip / 7.6883e-3 - 1.0).abs() < 0.02, "{slip:e}");
    }

    #[test]
    fn the_start_from_rest_is_the_exponential_of_the_linear_law() {
        let glass = water(Law::Stokes);
        let settled = glass.settled(9.81);
        let inertia = 0.99 * glass.mass() * (0.99 + 0.01 / 2.5);
        let relaxation = inertia / glass.drag(0.0);
        for share in [1e-3, 0.5, 3.0, 1e7] {
            let (speed, _) = glass.settling(9.81, share * relaxation);
            let exact = -settled * (-share).exp_m1();
            println!("t/τ {share:e}: {speed:e}, exact {exact:e}");
            assert!((speed / exact - 1.0).abs() < 1e-6);
        }
    }

    #[test]
    fn what_drifts_ends_with_the_momentum_it_began_with() {
        let glass = water(Law::Dallavalle);
        let end = glass.drifting(0.1, 1e3);
        let (solid, fluid) = (glass.mass(), glass.fluid_mass());
        assert!((end / (0.1 * solid / (solid + fluid)) - 1.0).abs() < 1e-9);
    }
}
