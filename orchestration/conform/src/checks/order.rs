//! Messages at a moment when they make no sense: refused, and the engine leaves with exit code 4.

use protocol::message::{Configure, FailureKind, Role, ToEngine};
use protocol::scene::{Convection, FluidScene, ParticleScene};

use crate::bench::Bench;
use crate::case::{Case, Part};
use crate::check::{ANSWERS, Check, HELLO, READY, Trouble};

pub(super) const CHECKS: &[Check] = &[
    Check::new(
        "advance-first",
        "Advance before Configure is refused (exit 4)",
        HELLO,
        advance_first,
    ),
    Check::new(
        "other-seat",
        "Configure for the other seat is refused (exit 4)",
        HELLO,
        other_seat,
    ),
    Check::new(
        "configure-twice",
        "a second Configure is refused (exit 4)",
        READY,
        configure_twice,
    ),
    Check::new(
        "step-left-out",
        "Advance to a step that does not follow the accepted one is refused (exit 4)",
        ANSWERS,
        step_left_out,
    ),
    Check::new(
        "commit-nothing",
        "Commit without a candidate is refused (exit 4)",
        ANSWERS,
        commit_nothing,
    ),
    Check::new(
        "commit-other-step",
        "Commit of another step than the candidate's is refused (exit 4)",
        ANSWERS,
        commit_other_step,
    ),
    Check::new(
        "commit-twice",
        "a second Commit of a step is refused (exit 4)",
        ANSWERS,
        commit_twice,
    ),
];

/// The next answer must be `Failed { Engine }`; it then leaves with the code of that.
fn must_break(bench: &mut Bench<'_>, what: &str) -> Result<(), Trouble> {
    bench.must_fail_as(FailureKind::Engine, what)?;
    Ok(bench.must_leave_broken(FailureKind::Engine.exit_code(), what)?)
}

fn advance_first(case: &Case) -> Result<(), Trouble> {
    let mut bench = Bench::greet(case)?;
    bench.send(&ToEngine::Advance(case.request(1, 0)))?;
    must_break(&mut bench, "Advance before Configure")
}

fn other_seat(case: &Case) -> Result<(), Trouble> {
    let mut bench = Bench::greet(case)?;
    let grain_count = 0;
    let configure = match case.role {
        Role::Fluid => {
            let scene = Box::new(some_particles(case));
            Configure::Particles { scene, grain_count }
        }
        Role::Particles => Configure::Fluid(Box::new(some_fluid(case))),
    };
    bench.send(&ToEngine::Configure(configure))?;
    must_break(&mut bench, "Configure for the other seat")
}

/// The built-in scene has both parts.
fn both(case: &Case) -> (Option<FluidScene>, Option<ParticleScene>) {
    let part = |role| Case::new(role, case.command.clone(), None, Vec::new(), case.limit);
    let (mut fluid, mut particles) = (None, None);
    for role in [Role::Fluid, Role::Particles] {
        match part(role).map(|case| case.part) {
            Ok(Part::Fluid(scene)) => fluid = Some(*scene),
            Ok(Part::Particles(scene, _)) => particles = Some(*scene),
            Err(_) => {}
        }
    }
    (fluid, particles)
}

fn some_fluid(case: &Case) -> FluidScene {
    readable(both(case).0.expect("the built-in scene has a fluid"))
}

/// What an engine of any capabilities can read, where it is not its partner that sends it.
fn readable(scene: FluidScene) -> FluidScene {
    FluidScene {
        convection: Convection::Always,
        ..scene
    }
}

fn some_particles(case: &Case) -> ParticleScene {
    both(case).1.expect("the built-in scene has grains")
}

fn configure_twice(case: &Case) -> Result<(), Trouble> {
    let mut bench = Bench::ready(case)?;
    let configure = match &case.part {
        Part::Fluid(scene) => Configure::Fluid(Box::new(readable(*scene.clone()))),
        Part::Particles(scene, grains) => Configure::Particles {
            scene: scene.clone(),
            grain_count: grains.radius.len() as u64,
        },
    };
    bench.send(&ToEngine::Configure(configure))?;
    must_break(&mut bench, "a second Configure")
}

fn step_left_out(case: &Case) -> Result<(), Trouble> {
    for wrong in [1, 3] {
        let mut bench = Bench::ready(case)?;
        bench.step(1, 0)?;
        bench.commit(1)?;
        bench.send(&ToEngine::Advance(case.request(wrong, 0)))?;
        must_break(
            &mut bench,
            &format!("Advance to step {wrong} after Commit of step 1"),
        )?;
    }
    Ok(())
}

/// `Commit` is not answered: what comes next is.
fn commit_and_ask(bench: &mut Bench<'_>, step: u64, what: &str) -> Result<(), Trouble> {
    bench.send(&ToEngine::Commit { step })?;
    // An engine may say it at once, and again to this.
    let _ = bench.send(&ToEngine::Advance(bench.case.request(step + 1, 0)));
    must_break(bench, what)
}

fn commit_nothing(case: &Case) -> Result<(), Trouble> {
    let mut bench = Bench::ready(case)?;
    commit_and_ask(&mut bench, 1, "Commit without a candidate")
}

fn commit_other_step(case: &Case) -> Result<(), Trouble> {
    let mut bench = Bench::ready(case)?;
    bench.step(1, 0)?;
    commit_and_ask(&mut bench, 2, "Commit of step 2 with a candidate of step 1")
}

fn commit_twice(case: &Case) -> Result<(), Trouble> {
    let mut bench = Bench::ready(case)?;
    bench.step(1, 0)?;
    bench.commit(1)?;
    commit_and_ask(&mut bench, 1, "a second Commit of step 1")
}
