//! Exact flows in the plane.

use std::f64::consts::PI;

use space::Vector;

use super::exact::{Exact, Fields};
use super::jet::Jet;

type Plane = Jet<3>;

/// The solenoidal field and the three cases of lethe's 2D VANS verification (ν = ρ = 1).
pub fn lethe(case: usize) -> Exact<2, 3> {
    fn swirl(x: Plane, y: Plane, amplitude: f64) -> [Plane; 2] {
        let (sx, sy, cx, cy) = (
            (x * PI).sin(),
            (y * PI).sin(),
            (x * PI).cos(),
            (y * PI).cos(),
        );
        [
            sx * sx * cy * sy * amplitude,
            cx * sx * sy * sy * -amplitude,
        ]
    }
    fn bump(x: Plane, y: Plane) -> Plane {
        (x * PI).sin() * (y * PI).sin()
    }
    let fields = [
        |[x, y, _]: [Plane; 3], _: f64| Fields {
            porosity: Jet::constant(0.5),
            velocity: swirl(x, y, 1.0),
            pressure: bump(x, y) * 0.5 + 0.5,
            drag: Jet::constant(0.0),
            solid_flux: Vector::zeros(),
        },
        |[x, y, _]: [Plane; 3], _: f64| Fields {
            porosity: bump(x, y) * 0.25 + 0.5,
            velocity: swirl(x, y, -2.0),
            pressure: bump(x, y),
            drag: Jet::constant(0.0),
            solid_flux: Vector::zeros(),
        },
        |[x, y, _]: [Plane; 3], _: f64| Fields {
            porosity: (bump(x, y) * -1.0 + -1.0).exp(),
            velocity: [(bump(x, y) + -1.0).exp(); 2],
            pressure: bump(x, y) * 0.5 + 0.5,
            drag: Jet::constant(0.0),
            solid_flux: Vector::zeros(),
        },
    ][case];
    Exact {
        density: 1.0,
        viscosity: 1.0,
        fields,
        amplitude: 0.0,
        steady: true,
    }
}

/// Flow through grains whose porosity changes in time, with β = b (1 + ½ sin πx cos πy).
///
/// φ = 0.6 + 0.2 cos πx cos πy cos ωt;  φ v = curl ψ + ∇χ with χ = ∂_tφ/(2π²), so that
/// ∇·(φv) = −∂_tφ, which the solid flux j⁰ = −∇χ carries.
pub fn suspension(drag: f64, steady: bool) -> Exact<2, 3> {
    fn fields([x, y, t]: [Plane; 3], drag: f64) -> Fields<2, 3> {
        let w = 2.0 * PI;
        let ((sx, cx), (sy, cy)) = (
            ((x * PI).sin(), (x * PI).cos()),
            ((y * PI).sin(), (y * PI).cos()),
        );
        let (sine, cosine) = ((t * w).sin(), (t * w).cos());
        let porosity = cx * cy * cosine * 0.2 + 0.6;
        let pulse = sine * 0.5 + 1.0;
        // χ = −a cos πx cos πy sin ωt
        let a = 0.2 * w / (2.0 * PI * PI);
        let chi = [sx * cy * sine * (a * PI), cx * sy * sine * (a * PI)];
        let psi = [
            sx * cx * sy * sy * pulse * 2.0,
            sx * sx * sy * cy * pulse * 2.0,
        ];
        let flux = [psi[1] + chi[0], chi[1] - psi[0]];
        Fields {
            porosity,
            velocity: flux.map(|u| u * porosity.recip()),
            pressure: cx * sy * (cosine * 0.5 + 1.0),
            drag: (sx * cy * 0.5 + 1.0) * drag,
            solid_flux: chi.map(|u| -u.value).into(),
        }
    }
    Exact {
        density: 1.0,
        viscosity: 0.1,
        fields,
        amplitude: drag,
        steady,
    }
}
