//! Drag of the fluid on one grain: one function a law, all written without dividing by the slip.
//!
//! ```text
//!   force on the grain = γ (v_f − v_p),   γ(|w|) ≥ 0,   w = v_p − v_f  interstitial slip
//! ```
//!
//! All laws are for equations in which the grain also feels −V ∇p ("model A").
//!
//! | symbol | code             | unit              |
//! | ------ | ---------------- | ----------------- |
//! | \|w\|  | `slip_speed`     | m/s, interstitial |
//! | φ      | `porosity`       | –                 |
//! | A      | `frontal_area`   | m² (disk: m)      |
//! | d      | `diameter`       | m                 |
//! | V      | `volume`         | m³ (disk: m²)     |

use protocol::scene::{DragLaw, Geometry};

/// Porosity is bounded to this range inside the drag laws, and nowhere else.
pub const POROSITY_RANGE: [f64; 2] = [0.1, 1.0];

/// The fluid around a grain.
#[derive(Debug, Clone, Copy)]
pub struct Fluid {
    /// ρ \[kg/m³\]
    pub density: f64,
    /// μ \[Pa s\]
    pub dynamic_viscosity: f64,
}

/// The shape of a grain.
#[derive(Debug, Clone, Copy)]
pub struct Shape {
    /// d \[m\]
    pub diameter: f64,
    /// A \[m²\]; disk: d, per metre of depth
    pub frontal_area: f64,
    /// V \[m³\]; disk: πr², per metre of depth
    pub volume: f64,
    /// d_i over the Sauter mean diameter of all grains; 1 when all are equal
    pub relative_diameter: f64,
}

impl Shape {
    /// Shape of a grain of this radius.
    pub fn new(geometry: Geometry, radius: f64, relative_diameter: f64) -> Shape {
        let disk = std::f64::consts::PI * radius * radius;
        let (frontal_area, volume) = match geometry {
            Geometry::Disk => (2.0 * radius, disk),
            Geometry::Sphere { .. } => (disk, 4.0 / 3.0 * disk * radius),
        };
        Shape {
            diameter: 2.0 * radius,
            frontal_area,
            volume,
            relative_diameter,
        }
    }

    /// γ of Stokes' law without hindrance in the limit of small Re, the scale of all laws:
    /// a sphere has 3πμd; a disk the same multiple of its frontal area, 12 μ A/d.
    fn creeping(&self, fluid: &Fluid) -> f64 {
        12.0 * fluid.dynamic_viscosity * self.frontal_area / self.diameter
    }
}

/// γ \[kg/s\] of the law chosen, at the porosity and slip speed around the grain.
pub fn coefficient(
    law: DragLaw,
    fluid: &Fluid,
    porosity: f64,
    slip_speed: f64,
    grain: &Shape,
) -> f64 {
    let porosity = porosity.clamp(POROSITY_RANGE[0], POROSITY_RANGE[1]);
    match law {
        DragLaw::Dallavalle => dallavalle(fluid, porosity, slip_speed, grain),
        DragLaw::DiFelice => di_felice(fluid, porosity, slip_speed, grain),
        DragLaw::WenYu => wen_yu(fluid, porosity, slip_speed, grain),
        DragLaw::Gidaspow => gidaspow(fluid, porosity, slip_speed, grain),
        DragLaw::Beetstra => beetstra(fluid, porosity, slip_speed, grain),
        DragLaw::Stokes => grain.creeping(fluid),
        DragLaw::Migflow => migflow(fluid, porosity, slip_speed, grain),
    }
}

/// γ of Dallavalle's sphere with the hindrance of the paper.
///
/// ```text
///   γ = ½ ρ A φ^−1.8 (0.63 √|w| + 4.8 √(μ/(ρ φ d)))²      (D1)  Dallavalle 1943; paper eq. (5)
/// ```
pub fn dallavalle(fluid: &Fluid, porosity: f64, slip_speed: f64, grain: &Shape) -> f64 {
    porosity.powf(-1.8) * dallavalle_bare(fluid, porosity, slip_speed, grain) // (D1)
}

/// (D1) without hindrance: Re = ρ φ d |w|/μ.
fn dallavalle_bare(fluid: &Fluid, porosity: f64, slip_speed: f64, grain: &Shape) -> f64 {
    let inertial = 0.63 * slip_speed.sqrt();
    let viscous =
        4.8 * (fluid.dynamic_viscosity / (fluid.density * porosity * grain.diameter)).sqrt();
    0.5 * fluid.density * grain.frontal_area * (inertial + viscous).powi(2)
}

/// γ of Di Felice: Dallavalle with an exponent that depends on Re.
///
/// ```text
///   γ = ½ ρ A φ^(2−χ) (…)²,   χ = 3.7 − 0.65 exp(−(1.5 − log₁₀ Re)²/2)      (D2)  Di Felice 1994
/// ```
pub fn di_felice(fluid: &Fluid, porosity: f64, slip_speed: f64, grain: &Shape) -> f64 {
    let distance = 1.5 - reynolds(fluid, porosity, slip_speed, grain).log10(); // +∞ at rest
    let exponent = 3.7 - 0.65 * (-0.5 * distance * distance).exp();
    porosity.powf(2.0 - exponent) * dallavalle_bare(fluid, porosity, slip_speed, grain) // (D2)
}

/// γ with the hindrance that MigFlow 1.4 applies, for comparison runs.
///
/// ```text
///   γ = ½ ρ A φ·φ^−(2.8 − 0.65 exp(−(1.5 − ln(max(φ, 0.01) Re))²/2)) (…)²      (D3)
/// ```
///
/// with Re = ρ|w|d/μ; the natural logarithm is theirs. Its bare coefficient carries φ inside the
/// square, hence one power of φ less than (D1).
pub fn migflow(fluid: &Fluid, porosity: f64, slip_speed: f64, grain: &Shape) -> f64 {
    let distance = 1.5 - reynolds(fluid, porosity, slip_speed, grain).ln();
    let exponent = 2.8 - 0.65 * (-0.5 * distance * distance).exp();
    porosity * porosity.powf(-exponent) * dallavalle_bare(fluid, porosity, slip_speed, grain) // (D3)
}

/// γ of Wen and Yu.
///
/// ```text
///   γ = ½ ρ A C_d |w| φ^−1.65,   C_d = 24/Re (1 + 0.15 Re^0.687), 0.44 above Re = 1000   (D4)
/// ```
pub fn wen_yu(fluid: &Fluid, porosity: f64, slip_speed: f64, grain: &Shape) -> f64 {
    let reynolds = reynolds(fluid, porosity, slip_speed, grain);
    let speed_times_coefficient = if reynolds < 1000.0 {
        24.0 * fluid.dynamic_viscosity / (fluid.density * porosity * grain.diameter)
            * (1.0 + 0.15 * reynolds.powf(0.687))
    } else {
        0.44 * slip_speed
    };
    0.5 * fluid.density * grain.frontal_area * speed_times_coefficient * porosity.powf(-1.65) // (D4)
}

/// γ of Gidaspow: Ergun below φ = 0.8, Wen–Yu above, blended over 0.78…0.82 so that it is continuous.
///
/// ```text
///   γ_Ergun = V [150 (1−φ) μ/(φ d²) + 1.75 ρ |w|/d]      (D5)  Gidaspow 1994
/// ```
pub fn gidaspow(fluid: &Fluid, porosity: f64, slip_speed: f64, grain: &Shape) -> f64 {
    let diameter = grain.diameter;
    let viscous =
        150.0 * (1.0 - porosity) * fluid.dynamic_viscosity / (porosity * diameter * diameter);
    let ergun = grain.volume * (viscous + 1.75 * fluid.density * slip_speed / diameter); // (D5)
    let dilute = ((porosity - 0.78) / 0.04).clamp(0.0, 1.0);
    dilute * wen_yu(fluid, porosity, slip_speed, grain) + (1.0 - dilute) * ergun
}

/// γ of Beetstra, van der Hoef and Kuipers with their polydisperse factor.
///
/// ```text
///   γ = 3πμd φ F(φ, Re) (φ y + c y²),   y = d_i/⟨d⟩, c = 1 − φ, Re with ⟨d⟩                   (D6)
///   F = 10c/φ² + φ²(1 + 1.5√c) + 0.413 Re/(24φ²) [1/φ + 3φc + 8.4 Re^−0.343]/[1 + 10^(3c) Re^−(0.5+2c)]
/// ```
///
/// Beetstra 2007; the cubic term of the polydisperse factor is left out, as is consistent with the
/// pressure-gradient force acting on the grain, so the factor is exactly 1 for equal grains.
pub fn beetstra(fluid: &Fluid, porosity: f64, slip_speed: f64, grain: &Shape) -> f64 {
    let solid = 1.0 - porosity;
    let mean = Shape {
        diameter: grain.diameter / grain.relative_diameter,
        ..*grain
    };
    let reynolds = reynolds(fluid, porosity, slip_speed, &mean).max(1e-12);
    let creeping = 10.0 * solid / porosity.powi(2) + porosity.powi(2) * (1.0 + 1.5 * solid.sqrt());
    let inertial = 0.413 * reynolds / (24.0 * porosity.powi(2))
        * (1.0 / porosity + 3.0 * porosity * solid + 8.4 * reynolds.powf(-0.343))
        / (1.0 + 10_f64.powf(3.0 * solid) * reynolds.powf(-(0.5 + 2.0 * solid)));
    let ratio = grain.relative_diameter;
    let polydisperse = porosity * ratio + solid * ratio * ratio;
    grain.creeping(fluid) * porosity * (creeping + inertial) * polydisperse // (D6)
}

/// Re = ρ φ d |w| / μ
fn reynolds(fluid: &Fluid, porosity: f64, slip_speed: f64, grain: &Shape) -> f64 {
    fluid.density * porosity * grain.diameter * slip_speed / fluid.dynamic_viscosity
}
