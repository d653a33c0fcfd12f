use std::mem::{align_of, offset_of, size_of};

use protocol::Error;
use protocol::field::Field;
use protocol::header::{Expected, FieldHeader, Stage, check_sum, require_finite};

const EXPECTED: Expected = Expected {
    field: Field::DragSource,
    epoch: 3,
    step: 12,
    pass: 1,
    stage: Stage::Advance,
    dimension: 2,
    entities: 5,
    time: 0.25,
};

fn payload() -> Vec<f64> {
    (0..10).map(|k| f64::from(k) - 4.0).collect()
}

#[test]
fn the_header_is_64_bytes_without_padding() {
    assert_eq!(
        (size_of::<FieldHeader>(), align_of::<FieldHeader>()),
        (64, 8)
    );
    let places = [
        offset_of!(FieldHeader, protocol),
        offset_of!(FieldHeader, field),
        offset_of!(FieldHeader, epoch),
        offset_of!(FieldHeader, step),
        offset_of!(FieldHeader, pass),
        offset_of!(FieldHeader, stage),
        offset_of!(FieldHeader, components),
        offset_of!(FieldHeader, reserved),
        offset_of!(FieldHeader, count),
        offset_of!(FieldHeader, time),
        offset_of!(FieldHeader, check),
    ];
    assert_eq!(places, [0, 4, 8, 16, 24, 28, 32, 36, 40, 48, 56]);
}

#[test]
fn each_wrong_header_value_is_refused_by_name() {
    let payload = payload();
    let good = EXPECTED.header();
    good.validate("fluid", &EXPECTED, &payload).unwrap();
    type Spoil = fn(&mut FieldHeader);
    let wrong: [(&str, Spoil); 12] = [
        ("protocol", |h| h.protocol = 1),
        ("field", |h| h.field = Field::SolidFlux.id()),
        ("field", |h| h.field = 999),
        ("epoch", |h| h.epoch = 2),
        ("step", |h| h.step = 11),
        ("pass", |h| h.pass = 0),
        ("stage", |h| h.stage = Stage::Done as u32),
        ("components", |h| h.components = 1),
        ("reserved", |h| h.reserved = 1),
        ("count", |h| h.count = 8),
        ("time", |h| h.time = f64::NAN),
        ("check", |h| h.check = 1),
    ];
    for (name, spoil) in wrong {
        let mut header = good;
        spoil(&mut header);
        let error = header.validate("fluid", &EXPECTED, &payload).unwrap_err();
        println!("{name:10} {error}");
        assert!(error.to_string().contains(name) && error.to_string().contains("fluid"));
        assert_eq!(error.exit_code(), if name == "protocol" { 3 } else { 7 });
    }
}

#[test]
fn a_payload_of_another_length_is_refused() {
    let error = EXPECTED
        .header()
        .validate("fluid", &EXPECTED, &payload()[..9])
        .unwrap_err();
    println!("{error}");
    assert!(
        error
            .to_string()
            .contains("count against the payload is 10, expected 9")
    );
}

#[test]
fn a_value_that_is_not_finite_is_named_with_its_place() {
    for (place, value) in [(0, f64::NAN), (7, f64::INFINITY), (9, f64::NEG_INFINITY)] {
        let mut values = payload();
        values[place] = value;
        let error = EXPECTED
            .header()
            .validate("coupler", &EXPECTED, &values)
            .unwrap_err();
        println!("{error}");
        let Error::NotFinite {
            field,
            index,
            component,
            step,
            support,
            ..
        } = &error
        else {
            panic!("{error}")
        };
        assert_eq!(
            (*field, *index, *component, *step, *support),
            (Field::DragSource, place / 2, place % 2, 12, "node")
        );
        assert_eq!(error.exit_code(), 7);
    }
    let mut long = vec![1.0; 1000];
    long[777] = f64::NAN;
    let error = require_finite("particles", 3, (Field::GrainRadius, 2), &long).unwrap_err();
    assert_eq!(
        error.to_string(),
        "grain_radius of the particles is NaN at grain 777 (component 0), step 3"
    );
}

#[test]
fn the_check_sum_sees_every_bit_and_the_order() {
    let payload = payload();
    let mut header = EXPECTED.header();
    header.check = check_sum(&payload);
    header.validate("fluid", &EXPECTED, &payload).unwrap();
    for place in 0..payload.len() {
        for bit in [0, 31, 51, 63] {
            let mut values = payload.clone();
            values[place] = f64::from_bits(values[place].to_bits() ^ (1 << bit));
            assert_ne!(
                check_sum(&values),
                header.check,
                "number {place}, bit {bit}"
            );
        }
    }
    let mut swapped = payload.clone();
    swapped.swap(2, 6);
    assert_ne!(check_sum(&swapped), header.check);
    assert_ne!(check_sum(&[]), 0);
}

#[test]
fn ids_and_names_of_fields_are_unique() {
    for (place, field) in Field::ALL.into_iter().enumerate() {
        assert_eq!(Field::from_id(field.id()), Some(field));
        assert!(
            Field::ALL[..place]
                .iter()
                .all(|other| other.id() != field.id() && other.name() != field.name())
        );
    }
    assert_eq!(Field::from_id(0), None);
}
