//! A closed column of a uniform suspension: one-dimensional, with a closed form at every step.

use protocol::engine::InitialGrains;
use protocol::scene::{Boundary, DragLaw, Scheme};
use space::flat::numbers;
use tests::grains::lattice;
use tests::{couple, fluid, particles, scene, with_boundaries, with_uniform_diagonals};

const PER_CELL: usize = 4;
const ROWS: usize = 64;
/// Stokes drag of a disk without hindrance is 12 μ for every radius and porosity.
const VISCOSITY: f64 = 0.1;
const DENSITY: f64 = 1000.0;

/// Grains whose contact radius is a tenth of the radius of their volume: no contact at any porosity.
fn suspension(porosity: f64, ratio: f64) -> (InitialGrains, f64) {
    let radius = 1e-4_f64;
    let volume = std::f64::consts::PI * radius * radius;
    let spacing = (volume / (1.0 - porosity)).sqrt();
    let centres = lattice([0.0, 0.0], spacing, [PER_CELL, PER_CELL * ROWS]);
    let count = centres.len();
    let grains = InitialGrains {
        dimension: 2,
        position: centres.into_iter().flatten().collect(),
        velocity: vec![0.0; 2 * count],
        radius: vec![0.1 * radius; count],
        mass: vec![ratio * DENSITY * volume; count],
        volume: vec![volume; count],
        fixed: vec![0.0; count],
    };
    (grains, PER_CELL as f64 * spacing)
}

#[test]
fn a_closed_uniform_column_settles_monotonically_as_its_closed_form_at_every_stiffness() {
    println!("| porosity | a = γΔt/m | ρ_p/ρ | worst error / slip | last |");
    let mut worst_of_all = 0.0_f64;
    for porosity in [0.1, 0.3, 0.6, 0.95] {
        for stiffness in [1e-3, 1.0, 1e3, 1e8] {
            for ratio in [1e-3, 0.5, 2.0, 1e3] {
                let (worst, last, monotone) = settle(Scheme::Staggered, porosity, stiffness, ratio);
                println!("| {porosity} | {stiffness:e} | {ratio:e} | {worst:.1e} | {last:.6} |");
                worst_of_all = worst_of_all.max(worst);
                assert!(
                    monotone,
                    "not monotone: φ {porosity} a {stiffness} ratio {ratio}"
                );
                assert!(
                    worst < 1e-6,
                    "φ {porosity} a {stiffness} ratio {ratio}: {worst}"
                );
            }
        }
    }
    println!("worst of all {worst_of_all:.1e}");
}

/// Worst distance from the closed form over 20 steps, relative to the final velocity; last velocity
/// relative to it; and whether every step came closer to it.
///
/// With no net flux the slip obeys [φρ_p + (1−φ)ρ] w' = (ρ_p−ρ) g − γ w/(φ V) (1−φ)…: backward Euler
/// of it is w ← (w + Δt/τ w∞)/(1 + Δt/τ), τ = φ τ_p [φ + (1−φ) ρ/ρ_p], and grains move with φ w.
fn settle(scheme: Scheme, porosity: f64, stiffness: f64, ratio: f64) -> (f64, f64, bool) {
    const STEPS: usize = 20;
    let (grains, width) = suspension(porosity, ratio);
    let drag = 12.0 * VISCOSITY;
    let (mass, volume) = (grains.mass[0], grains.volume[0]);
    let relaxation = mass / drag;
    let dt = stiffness * relaxation;
    // so weak that no grain moves by more than 1e-10 of a cell in the test
    let slip_target = 1e-10 * width / dt / STEPS as f64;
    let gravity = slip_target * drag / (porosity * volume * DENSITY * (ratio - 1.0_f64).abs());
    let slip = slip_target * (ratio - 1.0).signum();
    let fluid = with_uniform_diagonals(with_boundaries(
        fluid(
            DENSITY,
            VISCOSITY,
            [0.0, -gravity],
            [0.0, 0.0],
            [width, ROWS as f64 * width],
            [1, ROWS],
        ),
        &[
            ("left", Boundary::Periodic),
            ("right", Boundary::Periodic),
            ("bottom", Boundary::Slip),
            ("top", Boundary::Slip),
        ],
    ));
    let mut engine = particles([0.0, -gravity]);
    engine.period = vec![Some(width), None];
    let mut setup = scene(Some(fluid), Some(engine), dt, STEPS);
    setup.drag = DragLaw::Stokes;
    setup.scheme = scheme;
    let mut coupling = couple(setup, &grains);
    let tau = porosity * relaxation * (porosity + (1.0 - porosity) / ratio);
    let (mut exact, mut worst, mut monotone, mut before) = (0.0, 0.0_f64, true, 0.0);
    for _ in 0..STEPS {
        if let Err(error) = coupling.advance(dt) {
            println!("{scheme:?} φ {porosity} a {stiffness} ratio {ratio}: {error}");
            return (f64::INFINITY, f64::INFINITY, false);
        }
        exact = (exact + dt / tau * slip) / (1.0 + dt / tau);
        let count = coupling.state.grains.count();
        let middle = 2 * (count / 2) + 1;
        let found = -numbers(&coupling.state.grains.velocity)[middle] / porosity;
        worst = worst.max(((found - exact) / slip).abs());
        // to the 1e-7 that round-off of the stiffest columns leaves
        monotone &= found / slip >= before - 1e-7 && found / slip <= 1.0 + 1e-6;
        before = found / slip;
    }
    (worst, before, monotone)
}

#[test]
fn schemes_for_comparison_settle_where_soft_and_diverge_where_stiff() {
    println!("| scheme | porosity | a = γΔt/m | worst error / slip | last |");
    let rows = [
        (Scheme::Explicit, 0.9, 1e-2, true),
        (Scheme::Explicit, 0.9, 1e2, false),
        (Scheme::SemiImplicit, 0.9, 1e-2, true),
        (Scheme::SemiImplicit, 0.9, 1e3, true),
        (Scheme::SemiImplicit, 0.6, 1e-2, true),
        (Scheme::SemiImplicit, 0.6, 1e3, false),
    ];
    for (scheme, porosity, stiffness, stable) in rows {
        let (worst, last, _) = settle(scheme, porosity, stiffness, 2.0);
        println!("| {scheme:?} | {porosity} | {stiffness:e} | {worst:.1e} | {last:.3e} |");
        // of first order where they are stable; the start of a stiff lagged run overshoots
        assert_eq!(
            worst < 0.3,
            stable,
            "{scheme:?} φ {porosity} a {stiffness}: {worst:e}"
        );
        assert!(
            stable || worst > 1e3,
            "{scheme:?} φ {porosity} a {stiffness}: {worst:e}"
        );
    }
}
