//! Inputs that must not be computed with. A field that is refused spoils only its `Advance`: the
//! step can be asked again and gives the bits that it gave before. Bytes that are no message and
//! another protocol end the process.

use protocol::PROTOCOL_VERSION;
use protocol::codec;
use protocol::field::Field;
use protocol::field::GRAINS;
use protocol::header::{FieldHeader, Stage};
use protocol::message::{Advance, Configure, FailureKind, Role, ToEngine};

use crate::bench::{Bench, Candidate, LEAVE};
use crate::case::{Case, Part};
use crate::check::{ANSWERS, Check, HELLO, Trouble};

pub(super) const CHECKS: &[Check] = &[
    Check::new(
        "nan",
        "NaN in an input is refused, and the step can be repeated",
        ANSWERS,
        nan,
    ),
    Check::new(
        "infinity",
        "an infinity in an input is refused, and the step can be repeated",
        ANSWERS,
        infinity,
    ),
    Check::new(
        "count",
        "an input of another length is refused, and the step can be repeated",
        ANSWERS,
        count,
    ),
    Check::new(
        "epoch",
        "an input of another epoch is refused, and the step can be repeated",
        ANSWERS,
        epoch,
    ),
    Check::new(
        "header",
        "every other wrong value in a field's header is refused, and the step can be repeated",
        ANSWERS,
        header,
    ),
    Check::new(
        "request",
        "a step of no length and numbers that are not finite are refused in Advance",
        ANSWERS,
        request,
    ),
    Check::new(
        "grain-count",
        "grains that are fewer than announced are refused (exit 7)",
        HELLO,
        grain_count,
    )
    .only(Role::Particles),
    Check::new(
        "protocol-of-message",
        "a message of another protocol version is refused (exit 3)",
        HELLO,
        protocol_of_message,
    ),
    Check::new(
        "protocol-of-field",
        "a field of another protocol version is refused (exit 3)",
        ANSWERS,
        protocol_of_field,
    ),
    Check::new(
        "garbage",
        "bytes that are no message, or more than one, are refused (exit 7)",
        HELLO,
        garbage,
    ),
];

/// A field with its header, to be spoilt.
type Input = (Field, FieldHeader, Vec<f64>);

/// What is wrong, and how a field is spoilt that way.
type Spoil = (&'static str, fn(&mut Input));

/// Spoil each input in each way; the engine must refuse it and answer the right ones as before.
fn refused(case: &Case, ways: &[Spoil]) -> Result<(), Trouble> {
    let mut bench = Bench::ready(case)?;
    let request = case.request(1, 0);
    let before = bench.step(1, 0)?;
    let right = bench.right(&request, 0);
    for (what, spoil) in ways {
        for place in 0..right.len() {
            let mut inputs = right.clone();
            spoil(&mut inputs[place]);
            let to = format!("{} with {what}", inputs[place].0.name());
            bench.send_advance(&request, &inputs)?;
            bench.must_fail_as(FailureKind::NotFinite, &to)?;
            must_go_on(&mut bench, &before, &to)?;
        }
    }
    Ok(())
}

/// The step is asked again, rightly.
fn must_go_on(bench: &mut Bench<'_>, before: &Candidate, after: &str) -> Result<(), String> {
    let again = bench
        .step(1, 0)
        .map_err(|why| format!("after {after}: {why}"))?;
    before.must_equal(&again, &format!("step 1 before and after {after}"))
}

fn nan(case: &Case) -> Result<(), Trouble> {
    let last = |(_, _, values): &mut Input| {
        if let Some(last) = values.last_mut() {
            *last = f64::NAN;
        }
    };
    refused(case, &[("NaN as its last number", last)])
}

fn infinity(case: &Case) -> Result<(), Trouble> {
    let first = |(_, _, values): &mut Input| {
        if let Some(first) = values.first_mut() {
            *first = f64::NEG_INFINITY;
        }
    };
    refused(case, &[("-inf as its first number", first)])
}

fn count(case: &Case) -> Result<(), Trouble> {
    let ways: [Spoil; 3] = [
        ("one node or grain too many", |(_, header, values)| {
            values.extend(vec![0.1; header.components as usize]);
            header.count = values.len() as u64;
        }),
        ("one node or grain too few", |(_, header, values)| {
            values.truncate(values.len() - header.components as usize);
            header.count = values.len() as u64;
        }),
        ("a count that is not its length", |(_, header, values)| {
            values.pop();
            header.count = values.len() as u64 + 1;
        }),
    ];
    refused(case, &ways)
}

fn epoch(case: &Case) -> Result<(), Trouble> {
    let ways: [Spoil; 2] = [
        ("the next epoch", |(_, header, _)| header.epoch += 1),
        ("epoch 0", |(_, header, _)| header.epoch = 0),
    ];
    refused(case, &ways)
}

fn header(case: &Case) -> Result<(), Trouble> {
    let ways: [Spoil; 8] = [
        ("the id of no field", |(_, header, _)| header.field = 9999),
        ("another step", |(_, header, _)| header.step += 1),
        ("another pass", |(_, header, _)| header.pass += 1),
        ("the stage of Done", |(_, header, _)| {
            header.stage = Stage::Done as u32
        }),
        ("one component too many", |(_, header, _)| {
            header.components += 1
        }),
        ("reserved that is not 0", |(_, header, _)| {
            header.reserved = 1
        }),
        ("another time", |(_, header, _)| header.time += 1e-9),
        ("a wrong check sum", |(_, header, _)| header.check = 1),
    ];
    refused(case, &ways)
}

fn request(case: &Case) -> Result<(), Trouble> {
    let mut bench = Bench::ready(case)?;
    let right = case.request(1, 0);
    let before = bench.step(1, 0)?;
    let wrong = [
        (
            "dt 0",
            Advance {
                dt: 0.0,
                ..right.clone()
            },
        ),
        (
            "a negative dt",
            Advance {
                dt: -case.dt,
                ..right.clone()
            },
        ),
        (
            "dt NaN",
            Advance {
                dt: f64::NAN,
                ..right.clone()
            },
        ),
        (
            "an infinite dt",
            Advance {
                dt: f64::INFINITY,
                ..right.clone()
            },
        ),
        (
            "tolerance NaN",
            Advance {
                tolerance: f64::NAN,
                ..right.clone()
            },
        ),
        (
            "time NaN",
            Advance {
                time: f64::NAN,
                ..right.clone()
            },
        ),
    ];
    for (what, request) in wrong {
        let to = format!("Advance with {what}");
        let inputs = bench.right(&request, 0);
        bench.send_advance(&request, &inputs)?;
        bench.must_fail_as(FailureKind::NotFinite, &to)?;
        must_go_on(&mut bench, &before, &to)?;
    }
    Ok(())
}

fn grain_count(case: &Case) -> Result<(), Trouble> {
    let Part::Particles(scene, grains) = &case.part else {
        return Ok(());
    };
    let to = "Configure with a grain too few in its fields";
    let mut bench = Bench::greet(case)?;
    let announced = grains.radius.len();
    for field in GRAINS {
        let values = vec![1.0; (announced - 1) * field.components(scene.dimension)];
        let header = FieldHeader {
            stage: Stage::Configure as u32,
            count: values.len() as u64,
            ..bench.header(&case.request(1, 0), field)
        };
        let header = FieldHeader { step: 0, ..header };
        let sent = bench.partner.link().send_field(field, header, &values);
        sent.map_err(|e| bench.explain(&e))?;
    }
    let (scene, grain_count) = (scene.clone(), announced as u64);
    bench.send(&ToEngine::Configure(Configure::Particles {
        scene,
        grain_count,
    }))?;
    bench.must_fail_as(FailureKind::NotFinite, to)?;
    Ok(bench.must_leave_broken(FailureKind::NotFinite.exit_code(), to)?)
}

fn protocol_of_message(case: &Case) -> Result<(), Trouble> {
    let mut bench = Bench::greet(case)?;
    let bytes = codec::encode(&ToEngine::Finish).map_err(|e| e.to_string())?;
    let header = FieldHeader {
        protocol: PROTOCOL_VERSION + 1,
        ..FieldHeader::message(0, 0, bytes.len())
    };
    bench.send_bytes(header, &bytes)?;
    let left = bench.subject.must_leave(3, LEAVE);
    Ok(left.map_err(|why| format!("after a message of protocol 2 {why}"))?)
}

fn protocol_of_field(case: &Case) -> Result<(), Trouble> {
    let mut bench = Bench::ready(case)?;
    let request = case.request(1, 0);
    let mut inputs = bench.right(&request, 0);
    inputs[0].1.protocol = PROTOCOL_VERSION + 1;
    bench.send_advance(&request, &inputs)?;
    let left = bench.subject.must_leave(3, LEAVE);
    Ok(left.map_err(|why| format!("after a field of protocol 2 {why}"))?)
}

fn garbage(case: &Case) -> Result<(), Trouble> {
    let finish = codec::encode(&ToEngine::Finish).map_err(|e| e.to_string())?;
    let trailing = [finish.as_slice(), &[0]].concat();
    for (what, bytes) in [
        ("bytes that are no message", vec![0, 255, 255, 255, 255]),
        ("a message with a byte after it", trailing),
    ] {
        let mut bench = Bench::greet(case)?;
        bench.send_bytes(FieldHeader::message(0, 0, bytes.len()), &bytes)?;
        let left = bench.subject.must_leave(7, LEAVE);
        left.map_err(|why| format!("after {what} {why}"))?;
    }
    let mut bench = Bench::greet(case)?;
    bench.send_bytes(FieldHeader::message(0, 0, finish.len() + 3), &finish)?;
    let left = bench.subject.must_leave(7, LEAVE);
    Ok(left.map_err(|why| format!("after a message whose header counts 3 bytes too many {why}"))?)
}
