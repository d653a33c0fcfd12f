//! The accepted state and the candidate: what a second `Advance`, a commit and a checkpoint do to
//! the bits of the answers.

use std::path::Path;

use protocol::engine::MeshDescription;
use protocol::field::Field;
use protocol::message::{Advance, Capability, Role, ToEngine};

use crate::bench::{Bench, Candidate, Model};
use crate::case::{Case, Inputs};
use crate::check::{ACCEPTS, ANSWERS, Check, REPEATABLE, Trouble};

pub(super) const CHECKS: &[Check] = &[
    Check::new(
        "fresh-process",
        "the same requests give the same bits in another process",
        ANSWERS,
        fresh_process,
    ),
    Check::new(
        "same-request",
        "a second Advance gives the same bits as the first",
        ANSWERS,
        same_request,
    ),
    Check::new(
        "same-passes",
        "passes 0, 1, 2 asked again give the same bits",
        ANSWERS,
        same_passes,
    ),
    Check::new(
        "smaller-step",
        "after an Advance with half the step the whole one gives the same bits",
        ANSWERS,
        smaller_step,
    ),
    Check::new(
        "larger-step",
        "after an Advance with a large step a small one gives the bits of a fresh process",
        REPEATABLE,
        larger_step,
    ),
    Check::new(
        "discarded-candidate",
        "a candidate that was thrown away leaves no trace after Commit",
        REPEATABLE,
        discarded_candidate,
    ),
    Check::new(
        "commit",
        "the next step starts where the accepted one ended",
        ANSWERS,
        commit,
    )
    .only(Role::Particles),
    Check::new(
        "checkpoint",
        "Save and Restore bring back the same bits, in this process and in another",
        REPEATABLE,
        checkpoint,
    ),
    Check::new(
        "withheld",
        "a field that is withheld stays away, and Tell brings the bits of the accepted state",
        REPEATABLE,
        withheld,
    ),
    Check::new(
        "remove",
        "after Remove the others are as they were, in their order, and go on",
        ACCEPTS,
        remove,
    )
    .only(Role::Particles),
    Check::new(
        "bad-checkpoint",
        "Restore of a file that is missing or is none is answered by Failed",
        ANSWERS,
        bad_checkpoint,
    ),
];

fn fresh_process(case: &Case) -> Result<(), Trouble> {
    let run = || -> Result<(Model, Vec<Candidate>), String> {
        let mut bench = Bench::greet(case)?;
        let model = bench.configure()?;
        let mut candidates = Vec::new();
        for step in 1..=3 {
            candidates.push(bench.step(step, step as u32)?);
            bench.commit(step)?;
        }
        Ok((model, candidates))
    };
    let (first, second) = (run()?, run()?);
    if let (Model::Mesh(one), Model::Mesh(two)) = (&first.0, &second.0) {
        same_mesh(one, two)?;
    }
    for (step, (one, two)) in (1..).zip(first.1.iter().zip(&second.1)) {
        one.must_equal(two, &format!("step {step} in two processes"))?;
    }
    Ok(())
}

fn same_mesh(one: &MeshDescription, two: &MeshDescription) -> Result<(), String> {
    if one == two {
        return Ok(());
    }
    Err("the meshes of two processes differ".to_owned())
}

fn same_request(case: &Case) -> Result<(), Trouble> {
    let mut bench = Bench::ready(case)?;
    for step in 1..=3 {
        let first = bench.step(step, 0)?;
        let second = bench.step(step, 0)?;
        first.must_equal(&second, &format!("step {step} asked twice"))?;
        bench.commit(step)?;
    }
    Ok(())
}

fn same_passes(case: &Case) -> Result<(), Trouble> {
    const PASSES: u32 = 3;
    let mut bench = Bench::ready(case)?;
    bench.step(1, 0)?;
    bench.commit(1)?;
    let passes = |bench: &mut Bench<'_>| -> Result<Vec<Candidate>, String> {
        let pass = |pass| bench.advance(&case.request(2, pass), &bench.inputs(pass));
        (0..PASSES).map(pass).collect()
    };
    let (first, second) = (passes(&mut bench)?, passes(&mut bench)?);
    for (pass, (one, two)) in first.iter().zip(&second).enumerate() {
        one.must_equal(
            two,
            &format!("pass {pass} of step 2, asked again from pass 0"),
        )?;
    }
    Ok(())
}

fn smaller_step(case: &Case) -> Result<(), Trouble> {
    let mut bench = Bench::ready(case)?;
    bench.step(1, 1)?;
    bench.commit(1)?;
    let whole = bench.step(2, 0)?;
    let half = Advance {
        dt: 0.5 * case.dt,
        ..case.request(2, 0)
    };
    let inputs = bench.inputs(0);
    bench.advance(&half, &inputs)?;
    let again = bench.step(2, 0)?;
    whole.must_equal(&again, "step 2 before and after an Advance with half of it")?;
    Ok(())
}

/// A gentle step that is accepted, then a large step in a strong flow in one process of two, then a
/// small gentle one in both.
fn larger_step(case: &Case) -> Result<(), Trouble> {
    const LARGE: f64 = 10.0;
    let request = |step: u64, share: f64| Advance {
        time: 0.1 * (step - 1) as f64 * case.dt,
        dt: share * case.dt,
        ..case.request(step, 0)
    };
    let run = |disturbed: bool| -> Result<Candidate, String> {
        let mut bench = Bench::ready(case)?;
        let gentle = gentle(bench.inputs(0));
        bench.advance(&request(1, 0.1), &gentle)?;
        bench.commit(1)?;
        if disturbed {
            let strong = bench.inputs(1);
            bench.advance_or_fail(&request(2, LARGE), &strong)?;
        }
        bench.advance(&request(2, 0.1), &gentle)
    };
    let which = format!("step 2, alone and after an Advance with {LARGE} times the usual step");
    run(false)?.must_equal(&run(true)?, &which)?;
    Ok(())
}

/// The same grains, but forces and flow so small that what they do is linear.
fn gentle(mut inputs: Inputs) -> Inputs {
    const SMALL: f64 = 1e-6;
    for (field, values) in &mut inputs {
        if matches!(
            field,
            Field::DragSource | Field::SolidFlux | Field::GrainForce
        ) {
            values.iter_mut().for_each(|value| *value *= SMALL);
        }
    }
    inputs
}

fn discarded_candidate(case: &Case) -> Result<(), Trouble> {
    let run = |discarded: &[(u32, f64)]| -> Result<[Candidate; 2], String> {
        let mut bench = Bench::ready(case)?;
        for &(variant, share) in discarded {
            let request = Advance {
                dt: share * case.dt,
                ..case.request(1, 0)
            };
            let inputs = bench.inputs(variant);
            bench.advance(&request, &inputs)?;
        }
        let first = bench.step(1, 0)?;
        bench.commit(1)?;
        Ok([first, bench.step(2, 3)?])
    };
    let (directly, after) = (run(&[])?, run(&[(1, 1.0), (2, 0.5)])?);
    for step in 0..2 {
        let which = format!(
            "step {} of a run without and of one with candidates of step 1 thrown away",
            step + 1
        );
        directly[step].must_equal(&after[step], &which)?;
    }
    Ok(())
}

fn commit(case: &Case) -> Result<(), Trouble> {
    const ROUND_OFF: f64 = 1e-9;
    let mut bench = Bench::ready(case)?;
    let first = bench.step(1, 0)?;
    bench.commit(1)?;
    let second = bench.step(2, 0)?;
    let (before, after) = (
        first.field(Field::GrainPosition),
        second.field(Field::GrainPosition),
    );
    let mean = second.field(Field::GrainMeanVelocity);
    let wrapped = |k: usize, apart: f64| match &case.part {
        crate::case::Part::Particles(scene, _) => scene.period[k % scene.dimension]
            .map_or(apart, |period| apart - (apart / period).round() * period),
        crate::case::Part::Fluid(_) => apart,
    };
    for k in 0..before.len() {
        let told = case.dt * mean[k];
        let apart = wrapped(k, after[k] - before[k] - told);
        if apart.abs() > ROUND_OFF * (before[k].abs() + told.abs()) + f64::MIN_POSITIVE {
            return Err(format!(
                "grain {} ends step 1 at {:e} m and step 2 at {:e}, but its grain_mean_velocity \
                 times dt is {told:e}",
                k / 2,
                before[k],
                after[k]
            )
            .into());
        }
    }
    Ok(())
}

fn checkpoint(case: &Case) -> Result<(), Trouble> {
    let folder = tempfile::tempdir().map_err(|e| e.to_string())?;
    let file = folder.path().join("state");
    let mut bench = Bench::ready(case)?;
    if !bench
        .partner
        .hello()
        .capabilities
        .contains(&Capability::Checkpoint)
    {
        return Err(Trouble::Skipped(
            "it does not declare Checkpoint".to_owned(),
        ));
    }
    for step in 1..=3 {
        bench.step(step, step as u32)?;
        bench.commit(step)?;
    }
    bench.partner.save(&file).map_err(|e| bench.explain(&e))?;
    let expected = on(&mut bench)?;
    restore(&mut bench, &file)?;
    compare(&expected, &on(&mut bench)?, "restored in the same process")?;
    drop(bench);
    let mut other = Bench::ready(case)?;
    restore(&mut other, &file)?;
    compare(&expected, &on(&mut other)?, "restored in another process")?;
    Ok(())
}

/// Two steps from the saved state.
fn on(bench: &mut Bench<'_>) -> Result<[Candidate; 2], String> {
    let first = bench.step(4, 0)?;
    bench.commit(4)?;
    Ok([first, bench.step(5, 1)?])
}

fn restore(bench: &mut Bench<'_>, file: &Path) -> Result<(), String> {
    let restored = bench.partner.restore(file);
    restored.map_err(|error| format!("Restore of what Save wrote: {}", bench.explain(&error)))
}

fn compare(one: &[Candidate; 2], two: &[Candidate; 2], where_from: &str) -> Result<(), String> {
    for (place, (one, two)) in one.iter().zip(two).enumerate() {
        one.must_equal(two, &format!("step {} saved and {where_from}", place + 4))?;
    }
    Ok(())
}

fn withheld(case: &Case) -> Result<(), Trouble> {
    let mut bench = Bench::ready(case)?;
    if !bench.partner.may_withhold() {
        let why = "it does not declare FieldsOnRequest";
        return Err(Trouble::Skipped(why.to_owned()));
    }
    let mut always = Vec::new();
    for step in 1..=2 {
        always.push(bench.step(step, 1)?);
        bench.commit(step)?;
    }
    let mut bench = Bench::ready(case)?;
    let fields: Vec<Field> = bench.partner.hello().answer().pop().into_iter().collect();
    let withheld = bench.partner.withhold(&fields);
    withheld.map_err(|error| bench.explain(&error))?;
    for (step, always) in (1..).zip(&always) {
        let rest = bench.step_without(step, 1, &fields)?;
        bench.commit(step)?;
        let told = bench.tell(&fields)?;
        always.must_equal(&rest, &format!("step {step} with a field withheld"))?;
        always.must_equal(&told, &format!("Tell after step {step}"))?;
    }
    bench.step_without(3, 1, &fields)?;
    bench.send(&ToEngine::Tell { fields })?;
    let to = "Tell of a candidate that is not accepted";
    let failure = bench.must_fail(to)?;
    bench.must_leave_broken(failure.kind.exit_code(), to)?;
    Ok(())
}

/// A grain in the middle leaves after a step, the first one after the next.
fn remove(case: &Case) -> Result<(), Trouble> {
    let mut bench = Bench::greet(case)?;
    let able = &bench.partner.hello().capabilities;
    if !able.contains(&Capability::RemovesGrains) {
        let why = "it does not declare RemovesGrains";
        return Err(Trouble::Skipped(why.to_owned()));
    }
    let Model::Grains(mut grains) = bench.configure()? else {
        return Err("it answers with a mesh".to_owned().into());
    };
    if grains.count() < 3 {
        return Err(Trouble::Skipped("fewer than three grains".to_owned()));
    }
    for (step, gone) in [(1, grains.count() / 2), (2, 0)] {
        let candidate = bench.step(step, 0)?;
        bench.commit(step)?;
        grains.position = candidate.field(Field::GrainPosition).to_vec();
        grains.velocity = candidate.field(Field::GrainVelocity).to_vec();
        grains = grains.without(&[gone]);
        let left = bench.remove(&[gone])?;
        let fields = grains.slices().into_iter().zip(left.slices());
        for ((field, expected), (_, found)) in fields {
            if expected != found {
                let pairs = expected.iter().zip(found);
                let first =
                    pairs.take_while(|(a, b)| a == b).count() / field.components(grains.dimension);
                let why = format!(
                    "when grain {gone} has left after step {step}, {} of grain {first} is not what it was",
                    field.name()
                );
                return Err(why.into());
            }
        }
    }
    bench.step(3, 1)?;
    bench.commit(3)?;
    let grains = vec![grains.count() as u64];
    bench.send(&ToEngine::Remove { grains })?;
    let to = "Remove of a grain that is not there";
    let failure = bench.must_fail(to)?;
    bench.must_leave_broken(failure.kind.exit_code(), to)?;
    Ok(())
}

fn bad_checkpoint(case: &Case) -> Result<(), Trouble> {
    let folder = tempfile::tempdir().map_err(|e| e.to_string())?;
    let garbage = folder.path().join("garbage");
    std::fs::write(&garbage, [7; 100]).map_err(|e| e.to_string())?;
    for (path, what) in [
        (folder.path().join("missing"), "missing"),
        (garbage, "garbage"),
    ] {
        let to = format!("Restore of a {what} file");
        let mut bench = Bench::ready(case)?;
        let path = path.to_string_lossy().into_owned();
        bench.send(&ToEngine::Restore { path })?;
        let failure = bench.must_fail(&to)?;
        bench.must_leave_broken(failure.kind.exit_code(), &to)?;
    }
    Ok(())
}
