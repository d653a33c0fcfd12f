use std::time::{Duration, Instant};

use protocol::channel::{Channel, Wait};
use protocol::codec;
use protocol::field::Field;
use protocol::header::FieldHeader;
use protocol::local::{LIMITS, spawn, spawn_fluid, spawn_with};
use protocol::message::{Hello, Ready, Role, ToCoupler};
use protocol::partner::Partner;
use protocol::scene::Limits;
use protocol::{Error, PROTOCOL_VERSION};

use crate::toy::{self, Fault, ToyFluid};

fn hello() -> Hello {
    Hello {
        role: Role::Fluid,
        engine: "odd".to_owned(),
        version: "0".to_owned(),
        protocol: PROTOCOL_VERSION,
        process: 1,
        capabilities: Vec::new(),
        token: None,
    }
}

fn send(link: &mut dyn Channel, message: &ToCoupler) {
    let bytes = codec::encode(message).unwrap();
    link.send_message(FieldHeader::message(0, 0, bytes.len()), &bytes)
        .unwrap();
}

fn linger(link: &mut dyn Channel) {
    while link
        .receive_message(Wait::new(0, "the end", Duration::from_secs(5)))
        .is_ok()
    {}
}

/// Run toy steps until something fails.
fn run_until_error(fluid: &mut Partner) -> Error {
    fluid.configure_fluid(&toy::fluid_scene(4)).unwrap();
    let mut velocity = Vec::new();
    fluid
        .advance(
            &toy::request(1, 0),
            &[],
            &mut [(Field::InterstitialVelocity, &mut velocity)],
        )
        .unwrap();
    fluid.commit(1).unwrap();
    fluid
        .advance(
            &toy::request(2, 0),
            &[],
            &mut [(Field::InterstitialVelocity, &mut velocity)],
        )
        .unwrap_err()
}

#[test]
fn another_protocol_version_ends_the_handshake_with_both_numbers() {
    let error = spawn(Role::Fluid, |mut link| {
        send(
            &mut *link,
            &ToCoupler::Hello(Hello {
                protocol: 1,
                ..hello()
            }),
        );
        linger(&mut *link);
        Ok(())
    })
    .unwrap_err();
    assert_eq!(
        error.to_string(),
        "handshake with the fluid: it speaks protocol 1, this process speaks 2"
    );
    assert_eq!(error.exit_code(), 3);
    // The same when already the header of the message says so.
    let error = spawn(Role::Fluid, |mut link| {
        let header = FieldHeader {
            protocol: 9,
            ..FieldHeader::message(0, 0, 3)
        };
        link.send_message(header, &[1, 2, 3]).unwrap();
        linger(&mut *link);
        Ok(())
    })
    .unwrap_err();
    assert!(error.to_string().contains("protocol 9"), "{error}");
}

#[test]
fn the_wrong_seat_ends_the_handshake() {
    let error = spawn(Role::Particles, |mut link| {
        send(&mut *link, &ToCoupler::Hello(hello()));
        linger(&mut *link);
        Ok(())
    })
    .unwrap_err();
    println!("{error}");
    assert!(matches!(error, Error::Handshake { .. }));
}

#[test]
fn an_infinity_from_an_engine_names_engine_field_node_and_step() {
    let mut fluid = spawn_fluid(|| ToyFluid::new(Fault::NotANumber)).unwrap();
    let error = run_until_error(&mut fluid);
    assert_eq!(
        error.to_string(),
        "pressure_gradient of the fluid is -inf at node 3 (component 1), step 2"
    );
    assert_eq!(error.exit_code(), 7);
    // The fields after that one have been received: a smaller step can be tried.
    let (mut velocity, mut gradient) = (Vec::new(), Vec::new());
    let mut outputs = [
        (Field::InterstitialVelocity, &mut velocity),
        (Field::PressureGradient, &mut gradient),
    ];
    let request = toy::request(2, 1);
    fluid.advance(&request, &[], &mut outputs).unwrap();
    assert!(
        gradient
            .iter()
            .chain(&velocity)
            .all(|value| value.is_finite())
    );
}

#[test]
fn a_number_that_an_engine_forgets_to_write_is_refused() {
    let mut fluid = spawn_fluid(|| ToyFluid::new(Fault::Forgets)).unwrap();
    let error = run_until_error(&mut fluid);
    assert_eq!(
        error.to_string(),
        "interstitial_velocity of the fluid is NaN at node 2 (component 0), step 2"
    );
}

#[test]
fn a_nan_to_an_engine_is_refused_by_it_and_the_step_can_be_repeated() {
    let mut fluid = spawn_fluid(|| ToyFluid::new(Fault::None)).unwrap();
    let nodes = fluid
        .configure_fluid(&toy::fluid_scene(4))
        .unwrap()
        .nodal_mass
        .len();
    let mut porosity = vec![0.5; nodes];
    porosity[6] = f64::NAN;
    let source = vec![0.0; 2 * nodes];
    let inputs = [
        (Field::Porosity, porosity.as_slice()),
        (Field::DragSource, source.as_slice()),
    ];
    let error = fluid
        .advance(&toy::request(1, 0), &inputs, &mut [])
        .unwrap_err();
    println!("{error}");
    assert!(
        error
            .to_string()
            .contains("porosity of the coupler is NaN at node 6")
    );
    assert_eq!(error.exit_code(), 7);
    porosity[6] = 0.5;
    let inputs = [
        (Field::Porosity, porosity.as_slice()),
        (Field::DragSource, source.as_slice()),
    ];
    fluid
        .advance(&toy::request(1, 1), &inputs, &mut [])
        .unwrap();
}

#[test]
fn a_step_of_no_length_is_refused_by_the_engine() {
    let mut fluid = spawn_fluid(|| ToyFluid::new(Fault::None)).unwrap();
    fluid.configure_fluid(&toy::fluid_scene(4)).unwrap();
    for dt in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let mut request = toy::request(1, 0);
        request.dt = dt;
        let error = fluid.advance(&request, &[], &mut []).unwrap_err();
        assert!(
            error.to_string().contains("dt of the Advance to step 1 is"),
            "{error}"
        );
    }
}

#[test]
fn a_panic_of_an_engine_becomes_a_failure() {
    let mut fluid = spawn_fluid(|| ToyFluid::new(Fault::Panic)).unwrap();
    let error = run_until_error(&mut fluid);
    assert_eq!(
        error.to_string(),
        "the fluid failed at step 2: panicked: the toy breaks"
    );
    assert_eq!(error.exit_code(), 4);
    // It answers the same until it is told to leave.
    let again = fluid
        .advance(&toy::request(2, 1), &[], &mut [])
        .unwrap_err();
    assert!(again.to_string().contains("panicked"), "{again}");
    fluid.finish().unwrap();
}

#[test]
fn messages_out_of_order_are_failures() {
    let mut fluid = spawn_fluid(|| ToyFluid::new(Fault::None)).unwrap();
    let error = fluid
        .advance(&toy::request(1, 0), &[], &mut [])
        .unwrap_err();
    assert!(
        error.to_string().contains("Advance before Configure"),
        "{error}"
    );

    let mut fluid = spawn_fluid(|| ToyFluid::new(Fault::None)).unwrap();
    fluid.configure_fluid(&toy::fluid_scene(4)).unwrap();
    fluid.commit(1).unwrap();
    let error = fluid
        .advance(&toy::request(1, 0), &[], &mut [])
        .unwrap_err();
    assert!(
        error
            .to_string()
            .contains("Commit of step 1 without a candidate"),
        "{error}"
    );

    let mut fluid = spawn_fluid(|| ToyFluid::new(Fault::None)).unwrap();
    fluid.configure_fluid(&toy::fluid_scene(4)).unwrap();
    fluid.advance(&toy::request(1, 0), &[], &mut []).unwrap();
    fluid.commit(1).unwrap();
    let error = fluid
        .advance(&toy::request(3, 0), &[], &mut [])
        .unwrap_err();
    assert!(
        error.to_string().contains("Advance to step 3, expected 2"),
        "{error}"
    );
}

#[test]
fn an_answer_of_the_wrong_kind_is_refused() {
    let mut fluid = spawn(Role::Fluid, |mut link| {
        send(&mut *link, &ToCoupler::Hello(hello()));
        link.receive_message(Wait::new(0, "Configure", Duration::from_secs(5)))?;
        send(&mut *link, &ToCoupler::Stored);
        linger(&mut *link);
        Ok(())
    })
    .unwrap();
    let error = fluid.configure_fluid(&toy::fluid_scene(4)).unwrap_err();
    assert_eq!(
        error.to_string(),
        "invalid message from the fluid at step 0: Stored where Ready with a mesh was expected"
    );
}

#[test]
fn absurd_counts_are_refused_before_anything_is_allocated() {
    let mut fluid = spawn(Role::Fluid, |mut link| {
        send(&mut *link, &ToCoupler::Hello(hello()));
        link.receive_message(Wait::new(0, "Configure", Duration::from_secs(5)))?;
        let ready = Ready::Mesh {
            epoch: 1,
            dimension: 2,
            nodes: u64::MAX,
            simplices: 1,
            facets: 0,
            boundaries: Vec::new(),
            period: vec![None, None],
        };
        send(&mut *link, &ToCoupler::Ready(ready));
        linger(&mut *link);
        Ok(())
    })
    .unwrap();
    let error = fluid.configure_fluid(&toy::fluid_scene(4)).unwrap_err();
    println!("{error}");
    assert!(error.to_string().contains("18446744073709551615 nodes"));
}

#[test]
fn garbage_instead_of_a_message_is_refused() {
    let error = spawn(Role::Fluid, |mut link| {
        link.send_message(FieldHeader::message(0, 0, 5), &[0, 255, 255, 255, 255])
            .unwrap();
        linger(&mut *link);
        Ok(())
    })
    .unwrap_err();
    println!("{error}");
    assert!(matches!(error, Error::Invalid { .. }));
    let error = spawn(Role::Fluid, |mut link| {
        link.send_message(FieldHeader::message(0, 0, 5), &[0, 1])
            .unwrap();
        linger(&mut *link);
        Ok(())
    })
    .unwrap_err();
    assert!(
        error.to_string().contains("count is 5, expected 2"),
        "{error}"
    );
}

#[test]
fn a_silent_engine_ends_at_the_time_limit_with_what_was_awaited() {
    let limits = Limits {
        connect: 0.3,
        step: 0.3,
        ..LIMITS
    };
    let silent = |mut link: Box<dyn Channel>| {
        linger(&mut *link);
        Ok(())
    };
    let began = Instant::now();
    let error = spawn_with(Role::Fluid, &limits, silent).unwrap_err();
    println!("{error} ({:?})", began.elapsed());
    assert_eq!(
        error.to_string(),
        "the fluid did not send Hello within 0.3 s at step 0"
    );
    assert_eq!(error.exit_code(), 6);
    assert!(began.elapsed() < Duration::from_secs(3));
}

#[test]
fn an_engine_that_leaves_ends_the_wait_at_once() {
    let began = Instant::now();
    let error = spawn(Role::Fluid, |_| Ok(())).unwrap_err();
    println!("{error} ({:?})", began.elapsed());
    assert_eq!(
        error.to_string(),
        "the fluid is gone at step 0, while waiting for Hello"
    );
    assert_eq!(error.exit_code(), 5);
    assert!(began.elapsed() < Duration::from_secs(1));
}
