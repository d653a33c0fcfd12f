//! Exact flows in space.

use std::f64::consts::PI;

use space::Vector;

use super::exact::{Exact, Fields};
use super::jet::Jet;

type Space = Jet<4>;

/// sin πx and cos πx along each axis.
fn waves(place: [Space; 3]) -> ([Space; 3], [Space; 3]) {
    (place.map(|x| (x * PI).sin()), place.map(|x| (x * PI).cos()))
}

/// Solenoidal, and along surfaces on which sin πx sin πy sin πz is constant:
///
/// ```text
///   v = (sin²πx cy sy cz sz, cx sx sin²πy cz sz, −2 cx sx cy sy sin²πz),   sx = sin πx, cx = cos πx, …
/// ```
fn swirl([sx, sy, sz]: [Space; 3], [cx, cy, cz]: [Space; 3]) -> [Space; 3] {
    [
        sx * sx * cy * sy * cz * sz,
        cx * sx * sy * sy * cz * sz,
        cx * sx * cy * sy * sz * sz * -2.0,
    ]
}

/// lethe's case of clear fluid in space (0), and its three cases of volume-averaged flow, which are of the plane,
/// with the solenoidal field of the former and a wave more along z (1 to 3); ν = ρ = 1.
pub fn lethe_in_space(case: usize) -> Exact<3, 4> {
    fn bump([sx, sy, sz]: [Space; 3]) -> Space {
        sx * sy * sz
    }
    let fields = [
        |place: [Space; 4], _: f64| {
            let (sine, cosine) = waves([place[0], place[1], place[2]]);
            flow(Jet::constant(1.0), swirl(sine, cosine), Jet::constant(0.0))
        },
        |place: [Space; 4], _: f64| {
            let (sine, cosine) = waves([place[0], place[1], place[2]]);
            let pressure = bump(sine) * 0.5 + 0.5;
            flow(Jet::constant(0.5), swirl(sine, cosine), pressure)
        },
        |place: [Space; 4], _: f64| {
            let (sine, cosine) = waves([place[0], place[1], place[2]]);
            let velocity = swirl(sine, cosine).map(|v| v * -2.0);
            flow(bump(sine) * 0.25 + 0.5, velocity, bump(sine))
        },
        |place: [Space; 4], _: f64| {
            let (sine, _) = waves([place[0], place[1], place[2]]);
            let bump = bump(sine);
            let velocity = [(bump + -1.0).exp(); 3];
            flow((bump * -1.0 + -1.0).exp(), velocity, bump * 0.5 + 0.5)
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

/// Without grains that drag or move.
fn flow(porosity: Space, velocity: [Space; 3], pressure: Space) -> Fields<3, 4> {
    Fields {
        porosity,
        velocity,
        pressure,
        drag: Jet::constant(0.0),
        solid_flux: Vector::zeros(),
    }
}

/// Flow through grains whose porosity changes in time, with β = b (1 + ½ sin πx cos πy cos πz).
///
/// φ = 0.6 + 0.2 cos πx cos πy cos πz cos ωt;  φ v = ψ + ∇χ with ∇·ψ = 0 and χ = ∂_tφ/(3π²), so that
/// ∇·(φv) = −∂_tφ, which the solid flux j⁰ = −∇χ carries.
pub fn suspension_in_space(drag: f64, steady: bool) -> Exact<3, 4> {
    fn fields([x, y, z, t]: [Space; 4], drag: f64) -> Fields<3, 4> {
        let w = 2.0 * PI;
        let (sine, cosine) = waves([x, y, z]);
        let ([sx, sy, sz], [cx, cy, cz]) = (sine, cosine);
        let (rise, beat) = ((t * w).sin(), (t * w).cos());
        let porosity = cx * cy * cz * beat * 0.2 + 0.6;
        let pulse = (rise * 0.5 + 1.0) * (2.0 * PI);
        // χ = −a cos πx cos πy cos πz sin ωt
        let a = 0.2 * w / (3.0 * PI * PI) * PI;
        let chi = [sx * cy * cz, cx * sy * cz, cx * cy * sz].map(|slope| slope * rise * a);
        let psi = swirl(sine, cosine);
        let flux: [Space; 3] = std::array::from_fn(|d| psi[d] * pulse + chi[d]);
        Fields {
            porosity,
            velocity: flux.map(|u| u * porosity.recip()),
            pressure: cx * sy * cz * (beat * 0.5 + 1.0),
            drag: (sx * cy * cz * 0.5 + 1.0) * drag,
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

/// Uniform strain and spin that beat in time, φ v = (1 + ½ sin ωt) S x with tr S = 0, through grains of porosity 0.6 and
/// β = 1 kg/(m³ s): linear in space, so that simplices have it exactly and what is left is the error in time.
pub fn straining_in_space() -> Exact<3, 4> {
    fn fields([x, y, z, t]: [Space; 4], drag: f64) -> Fields<3, 4> {
        let pulse = (t * (2.0 * PI)).sin() * 0.5 + 1.0;
        let strain = [x + y * 0.5, z * 2.0 - y * 0.5, x + z * -0.5];
        Fields {
            porosity: Jet::constant(0.6),
            velocity: strain.map(|slope| slope * pulse * (1.0 / 0.6)),
            pressure: x * pulse,
            drag: Jet::constant(drag),
            solid_flux: Vector::zeros(),
        }
    }
    Exact {
        density: 1.0,
        viscosity: 0.1,
        fields,
        amplitude: 1.0,
        steady: false,
    }
}
