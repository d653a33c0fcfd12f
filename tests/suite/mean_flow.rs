//! Grains that settle where all sides are periodic.

use protocol::scene::{Boundary, MeanFlow};
use space::dot;
use tests::grains::{disks, lattice};
use tests::{couple, fluid, particles, scene, with_boundaries};

const GRAVITY: [f64; 2] = [0.0, -9.81];
const SIDE: f64 = 0.01;

/// Flux of the mixture through unit area \[m/s\] and fall speed after some steps of a suspension.
fn settle(mean_flow: MeanFlow) -> (f64, f64) {
    let sides = ["left", "right", "bottom", "top"].map(|side| (side, Boundary::Periodic));
    let mut fluid = fluid(1200.0, 0.12, GRAVITY, [0.0; 2], [SIDE; 2], [10, 10]);
    fluid = with_boundaries(fluid, &sides);
    fluid.mean_flow = mean_flow;
    let mut engine = particles(GRAVITY);
    engine.period = vec![Some(SIDE); 2];
    let centres = lattice([0.0; 2], SIDE / 6.0, [6, 6]);
    let grains = disks(&centres, &[2.5e-4; 36], 2400.0);
    let steps = 40;
    let mut coupling = couple(scene(Some(fluid), Some(engine), 5e-3, steps), &grains);
    let (mut flux, mut fall) = (0.0, 0.0);
    for _ in 0..steps {
        coupling.advance(5e-3).unwrap();
        let state = &coupling.state;
        let seat = coupling.system.fluid().expect("a fluid");
        let mass = &seat.description.nodal_mass;
        let nodes = 0..mass.len();
        let of_fluid: f64 = nodes
            .map(|a| mass[a] * state.porosity[a] * state.flow.velocity[a][1])
            .sum();
        let grains = &state.grains;
        let up = [0.0, 1.0].into();
        let of_grains: f64 = (0..grains.count())
            .map(|i| grains.volume[i] * dot(&grains.mean_velocity[i], &up))
            .sum();
        flux = (of_fluid + of_grains) / (SIDE * SIDE);
        fall = -grains.velocity.iter().map(|v| v[1]).sum::<f64>() / grains.count() as f64;
    }
    (flux, fall)
}

#[test]
fn grains_settle_in_a_periodic_box_at_the_flux_that_is_asked_for() {
    println!("mean flow                   flux of the mixture   fall speed [m/s]");
    let tell = |mean_flow: MeanFlow| {
        let (flux, fall) = settle(mean_flow.clone());
        println!("{mean_flow:?}  {flux:+.6e}  {fall:.6e}");
        (flux, fall)
    };
    let (_, free) = tell(MeanFlow::Free);
    assert!(free > 0.9 * 9.81 * 0.2);
    let (still, settling) = tell(MeanFlow::Zero);
    assert!(still.abs() < 1e-3 * settling && settling > 0.0 && settling < 0.02);
    let upward = 2e-3;
    let (flux, slower) = tell(MeanFlow::Velocity(vec![0.0, upward]));
    assert!((flux / upward - 1.0).abs() < 1e-2);
    assert!((settling - slower - upward).abs() < 0.05 * upward);
}
