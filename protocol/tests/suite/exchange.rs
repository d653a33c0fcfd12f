use protocol::Error;
use protocol::field::Field;
use protocol::local::{spawn_fluid, spawn_particles};
use protocol::message::{FailureKind, Role};
use protocol::partner::Partner;

use crate::toy::{self, Fault, ToyFluid, ToyGrains, fluid_run, particle_run};

#[test]
fn a_run_over_threads_gives_the_same_bits_twice() {
    let run = || {
        let mut fluid = spawn_fluid(|| ToyFluid::new(Fault::None)).unwrap();
        assert_eq!(
            (fluid.hello().role, fluid.hello().engine.as_str()),
            (Role::Fluid, "toy-fluid")
        );
        let bits = fluid_run(&mut fluid, 8);
        fluid.finish().unwrap();
        bits
    };
    assert_eq!(run(), run());
    let run = || {
        let mut particles = spawn_particles(ToyGrains::new).unwrap();
        let bits = particle_run(&mut particles);
        particles.finish().unwrap();
        bits
    };
    assert_eq!(run(), run());
}

#[test]
fn a_second_advance_before_commit_starts_from_the_accepted_state() {
    let mut fluid = spawn_fluid(|| ToyFluid::new(Fault::None)).unwrap();
    fluid.configure_fluid(&toy::fluid_scene(3)).unwrap();
    let mut pressure_after = |step, passes: u32, commit| {
        let mut pressure = Vec::new();
        for pass in 0..passes {
            let mut outputs = [(Field::Pressure, &mut pressure)];
            fluid
                .advance(&toy::request(step, pass), &[], &mut outputs)
                .unwrap();
        }
        if commit {
            fluid.commit(step).unwrap();
        }
        pressure[0]
    };
    assert_eq!(pressure_after(1, 1, false), 0.01);
    assert_eq!(pressure_after(1, 5, false), 0.01);
    assert_eq!(pressure_after(1, 1, true), 0.01);
    assert_eq!(pressure_after(2, 3, true), 0.02);
}

#[test]
fn a_field_that_is_withheld_comes_when_it_is_asked_for_with_the_same_bits() {
    let run = |withhold: bool| -> Vec<u64> {
        let mut fluid = spawn_fluid(|| ToyFluid::new(Fault::None)).unwrap();
        fluid.configure_fluid(&toy::fluid_scene(3)).unwrap();
        assert!(fluid.may_withhold());
        if withhold {
            fluid.withhold(&[Field::Pressure]).unwrap();
        }
        let mut bits = Vec::new();
        for step in 1..=3 {
            let (mut velocity, mut pressure) = (Vec::new(), Vec::new());
            for pass in 0..2 {
                let mut outputs = vec![
                    (Field::InterstitialVelocity, &mut velocity),
                    (Field::Pressure, &mut pressure),
                ];
                outputs.truncate(if withhold { 1 } else { 2 });
                let done = fluid
                    .advance(&toy::request(step, pass), &[], &mut outputs)
                    .unwrap();
                assert_eq!(done.fields.contains(&Field::Pressure), !withhold);
            }
            fluid.commit(step).unwrap();
            // not in every step, and more than once
            for _ in 0..if withhold { step - 1 } else { 0 } {
                let mut outputs = [(Field::Pressure, &mut pressure)];
                fluid.tell(&mut outputs).unwrap();
            }
            if step > 1 {
                bits.extend(velocity.iter().chain(&pressure).map(|x| x.to_bits()));
            }
        }
        fluid.finish().unwrap();
        bits
    };
    let (always, asked) = (run(false), run(true));
    assert_eq!(always.len(), 2 * 3 * 8);
    assert_eq!(always, asked);
}

#[test]
fn a_withheld_field_that_the_engine_forgot_is_refused_in_its_step() {
    let mut fluid = spawn_fluid(|| ToyFluid::new(Fault::Forgets)).unwrap();
    fluid.configure_fluid(&toy::fluid_scene(3)).unwrap();
    fluid.withhold(&[Field::InterstitialVelocity]).unwrap();
    fluid.advance(&toy::request(1, 0), &[], &mut []).unwrap();
    fluid.commit(1).unwrap();
    let error = fluid
        .advance(&toy::request(2, 0), &[], &mut [])
        .unwrap_err();
    println!("{error}");
    assert_eq!(error.exit_code(), 7);
    assert!(error.to_string().contains("interstitial_velocity"));
}

#[test]
fn tell_and_withhold_at_the_wrong_moment_are_out_of_order() {
    type Wrong = fn(&mut Partner) -> Result<(), Error>;
    let tell: Wrong = |fluid| fluid.tell(&mut [(Field::Pressure, &mut Vec::new())]);
    let advance: Wrong = |fluid| fluid.advance(&toy::request(2, 0), &[], &mut []).map(drop);
    let cases: [(&str, Wrong); 4] = [
        ("Tell of pressure, which is not withheld", tell),
        ("Tell without an accepted step", |fluid| {
            fluid.withhold(&[Field::Pressure])?;
            fluid.tell(&mut [(Field::Pressure, &mut Vec::new())])
        }),
        ("Tell without an accepted step", |fluid| {
            fluid.advance(&toy::request(2, 0), &[], &mut [])?;
            fluid.tell(&mut [(Field::Pressure, &mut Vec::new())])
        }),
        (
            "Withhold of grain_contact, which is named twice or is not of a candidate",
            |fluid| {
                fluid.withhold(&[Field::GrainContact])?;
                fluid.tell(&mut [])
            },
        ),
    ];
    for (expected, wrong) in cases {
        let mut fluid = spawn_fluid(|| ToyFluid::new(Fault::None)).unwrap();
        fluid.configure_fluid(&toy::fluid_scene(3)).unwrap();
        fluid.advance(&toy::request(1, 0), &[], &mut []).unwrap();
        fluid.commit(1).unwrap();
        let error = wrong(&mut fluid).unwrap_err();
        println!("{error}");
        assert!(error.to_string().contains(expected));
        // It stays broken, with the same words.
        assert!(
            advance(&mut fluid)
                .unwrap_err()
                .to_string()
                .contains(expected)
        );
    }
}

#[test]
fn a_refused_step_may_be_asked_again() {
    let mut fluid = spawn_fluid(|| ToyFluid::new(Fault::Refuses)).unwrap();
    fluid.configure_fluid(&toy::fluid_scene(3)).unwrap();
    fluid.advance(&toy::request(1, 0), &[], &mut []).unwrap();
    fluid.commit(1).unwrap();
    for pass in 0..3 {
        let error = fluid
            .advance(&toy::request(2, pass), &[], &mut [])
            .unwrap_err();
        assert_eq!(
            error.to_string(),
            "the fluid failed at step 2: residual 1 above 1e-3"
        );
        assert_eq!(error.exit_code(), 8);
    }
    fluid.finish().unwrap();
}

#[test]
fn save_and_restore_bring_back_the_same_bits() {
    let path = std::env::temp_dir().join(format!("sillage-protocol-{}", std::process::id()));
    let mut fluid = spawn_fluid(|| ToyFluid::new(Fault::None)).unwrap();
    fluid.configure_fluid(&toy::fluid_scene(2)).unwrap();
    let step = |fluid: &mut Partner, step| {
        let mut pressure = Vec::new();
        fluid
            .advance(
                &toy::request(step, 0),
                &[],
                &mut [(Field::Pressure, &mut pressure)],
            )
            .unwrap();
        fluid.commit(step).unwrap();
        pressure
    };
    step(&mut fluid, 1);
    fluid.save(&path).unwrap();
    let straight = step(&mut fluid, 2);
    fluid.restore(&path).unwrap();
    assert_eq!(step(&mut fluid, 2), straight);
    std::fs::remove_file(&path).unwrap();
    // A failure of anything but Advance ends the engine.
    let error = fluid.restore(&path).unwrap_err();
    println!("{error}");
    assert!(matches!(error, Error::Engine { failure, .. } if failure.kind == FailureKind::Engine));
}

#[test]
fn sizes_from_none_to_many_cross_the_link() {
    for count in [0, 1, 1000, 30_000] {
        let mut particles = spawn_particles(ToyGrains::new).unwrap();
        let grains = toy::grains(count);
        assert_eq!(
            particles
                .configure_particles(&toy::particle_scene(), &grains)
                .unwrap(),
            grains
        );
        let force = vec![1.0; 2 * count];
        let mut velocity = Vec::new();
        let mut outputs = [(Field::GrainVelocity, &mut velocity)];
        particles
            .advance(
                &toy::request(1, 0),
                &[(Field::GrainForce, &force)],
                &mut outputs,
            )
            .unwrap();
        assert_eq!(velocity.len(), 2 * count);
        particles.finish().unwrap();
    }
}

#[test]
fn an_input_of_another_length_is_refused_by_the_sender() {
    let mut fluid = spawn_fluid(|| ToyFluid::new(Fault::None)).unwrap();
    let nodes = fluid
        .configure_fluid(&toy::fluid_scene(3))
        .unwrap()
        .nodal_mass
        .len();
    let short = vec![1.0; nodes - 1];
    let error = fluid
        .advance(&toy::request(1, 0), &[(Field::Porosity, &short)], &mut [])
        .unwrap_err();
    println!("{error}");
    assert!(error.to_string().contains("7 numbers given, 8 expected"));
}
