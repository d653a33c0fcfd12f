//! A cloud whose mesh follows it: the first step on a new mesh goes as others do, and what meshes change is small
//! beside what moves the cloud.

use coupler::seats::request::value;
use coupler::simulation::Simulation;
use protocol::scene::{CouplerScene, NearGrains, Refinement, Scheme};
use tests::grains::{Noise, disks, sunflower};
use tests::{box_walls, couple, fluid, particles, scene};

const DENSITY: f64 = 1200.0;
const VISCOSITY: f64 = 0.12;
const RADIUS: f64 = 1.25e-3;
const GRAVITY: f64 = 9.81;
const SOLID_FRACTION: f64 = 0.2;
const COUNT: usize = 400;

/// A disk of grains of twice the fluid's density, in a box of 10 R × 20 R with cells of 2 R and of R/4 near grains;
/// steps of 0.2 μ/(f R).
fn cloud(scheme: Scheme) -> Simulation<2, 3> {
    let (lower, upper) = ([-5.0 * RADIUS, 0.0], [5.0 * RADIUS, 20.0 * RADIUS]);
    let gravity = [0.0, -GRAVITY];
    let mut fluid = fluid(DENSITY, VISCOSITY, gravity, lower, upper, [5, 10]);
    fluid.convection = true.into();
    fluid.refinement = Some(Refinement {
        growth: 0.2,
        largest: None,
        regions: Vec::new(),
    });
    let mut engine = particles(gravity);
    engine.walls = box_walls(lower, upper);
    engine.tolerance = 1e-3;
    let time_unit = VISCOSITY / (SOLID_FRACTION * DENSITY * GRAVITY * RADIUS);
    let scene = CouplerScene {
        near_grains: Some(NearGrains {
            size: 0.25 * RADIUS,
            margin: 0.25 * RADIUS,
        }),
        scheme,
        ..scene(Some(fluid), Some(engine), 0.2 * time_unit, 1)
    };
    let radius = RADIUS * (SOLID_FRACTION / COUNT as f64).sqrt();
    let mut centres = sunflower([0.0, 16.0 * RADIUS], RADIUS, COUNT);
    let mut noise = Noise::new(7);
    for x in centres.iter_mut().flatten() {
        *x += noise.around(0.1 * radius);
    }
    couple(scene, &disks(&centres, &vec![radius; COUNT], 2.0 * DENSITY))
}

/// Sums over steps.
#[derive(Debug, Default)]
struct Sums {
    steps: f64,
    passes: f64,
    defect: f64,
}

impl Sums {
    fn of_a_step(&self, sum: f64) -> f64 {
        sum / self.steps
    }
}

#[test]
fn the_first_pass_on_a_new_mesh_is_as_good_as_others_and_as_many_follow_it() {
    println!(
        "tolerance  steps: new mesh, old  first defect: new, old  passes: new, old  most: new, old"
    );
    let iterated = |tolerance: f64| Scheme::Iterated {
        tolerance,
        passes_max: 60,
    };
    for tolerance in [1e-3, 1e-6] {
        // of a staggered step the defect is that of its first pass
        let [once, many] = [Scheme::Staggered, iterated(tolerance)].map(|scheme| {
            let mut cloud = cloud(scheme);
            let dt = cloud.scene.coupling_step;
            let (mut sums, mut most) = ([Sums::default(), Sums::default()], [0; 2]);
            for step in 0..60 {
                let old = usize::from(!cloud.follow().unwrap());
                let report = cloud
                    .advance(dt)
                    .unwrap_or_else(|error| panic!("step {step}: {error}"));
                // the first steps begin at rest
                if step >= 3 {
                    sums[old].steps += 1.0;
                    sums[old].passes += f64::from(report.passes);
                    sums[old].defect += report.interaction_defect;
                    most[old] = report.passes.max(most[old]);
                }
            }
            (sums, most)
        });
        let [first_new, first_old] = once.0.map(|sums| sums.of_a_step(sums.defect));
        let counts = [0, 1].map(|k| many.0[k].steps);
        let passes = many.0.map(|sums| sums.of_a_step(sums.passes));
        println!(
            "{tolerance:.0e}       {:2}, {:2}                {first_new:.1e}, {first_old:.1e}        {:.2}, {:.2}        {}, {}",
            counts[0], counts[1], passes[0], passes[1], many.1[0], many.1[1]
        );
        assert!(counts[0] >= 5.0 && counts[1] >= 5.0, "{counts:?}");
        assert!(first_new < 2.0 * first_old + 1e-9);
        assert!(passes[0] <= passes[1] + 1.0);
    }
}

#[test]
fn what_meshes_change_of_a_falling_cloud_is_small_beside_its_weight_and_its_work() {
    let mut cloud = cloud(Scheme::Iterated {
        tolerance: 1e-3,
        passes_max: 30,
    });
    let dt = cloud.scene.coupling_step;
    let (mut momentum, mut energy, mut work, mut epochs) = (0.0, 0.0, 0.0, 0);
    let mut worst = [0.0_f64; 3];
    for step in 0..60 {
        let followed = cloud.follow().unwrap();
        let report = cloud
            .advance(dt)
            .unwrap_or_else(|error| panic!("step {step}: {error}"));
        let told = &cloud.system.fluid().unwrap().diagnostics;
        let number = |name: &str| value(told, name).unwrap();
        epochs += usize::from(followed);
        momentum += number("mesh_momentum_y");
        energy += number("mesh_energy");
        work += report.budget.gravity_power * dt;
        if step > 3 {
            let shares = [
                "mesh_volume_share",
                "mesh_momentum_share",
                "mesh_energy_share",
            ];
            for (worst, name) in worst.iter_mut().zip(shares) {
                *worst = worst.max(number(name));
            }
        }
        assert!(followed || number("mesh_energy") == 0.0);
    }
    let volume: f64 = cloud.state.grains.volume.iter().sum();
    let impulse = volume * DENSITY * GRAVITY * dt * 60.0;
    println!(
        "{epochs} meshes in 60 steps: ΔM of all over weight × time {:.1e}, ΔT of all over the work of gravity {:.1e}",
        momentum / impulse,
        energy / work
    );
    println!(
        "largest of one: ΔV {:.1e} of the grains, ΔM {:.1e} of ρ∫|u|, ΔT {:.1e} of T",
        worst[0], worst[1], worst[2]
    );
    assert!((momentum / impulse).abs() < 1e-3 && (energy / work).abs() < 1e-3);
}
