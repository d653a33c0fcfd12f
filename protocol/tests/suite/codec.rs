use protocol::codec::{CodecError, LIMIT, decode, decode_file, encode, encode_file};
use protocol::field::Field;
use protocol::message::{
    Advance, Configure, Diagnostic, Done, Failure, FailureKind, ToCoupler, ToEngine,
};
use protocol::report::{ParticleReport, Report};
use protocol::scene::{Refinement, Region, Wall};

use crate::toy;

fn messages() -> Vec<ToEngine> {
    let request = Advance {
        fields: vec![Field::Porosity, Field::SolidMobility],
        ..toy::request(7, 2)
    };
    vec![
        ToEngine::Configure(Configure::Fluid(Box::new(toy::fluid_scene(4)))),
        ToEngine::Configure(Configure::Particles {
            scene: Box::new(toy::particle_scene()),
            grain_count: 3,
        }),
        ToEngine::Advance(request),
        ToEngine::Commit { step: 1 << 60 },
        ToEngine::Save {
            path: "state.bin".to_owned(),
        },
        ToEngine::Finish,
        ToEngine::Withhold {
            fields: vec![Field::Pressure],
        },
        ToEngine::Tell {
            fields: vec![Field::Pressure],
        },
        ToEngine::Adapt {
            epoch: 2,
            sizes: Refinement {
                growth: 0.2,
                largest: Some(0.1),
                regions: vec![Region::Ball {
                    centre: vec![0.5, 0.5],
                    radius: 0.0,
                    size: 0.01,
                }],
            },
        },
        ToEngine::Remove {
            grains: vec![0, 3, 1 << 40],
        },
    ]
}

#[test]
fn every_message_comes_back_the_same() {
    for message in messages() {
        let bytes = encode(&message).unwrap();
        println!("{:5} bytes  {message:.60?}", bytes.len());
        assert_eq!(decode::<ToEngine>(&bytes).unwrap(), message);
    }
    let done = ToCoupler::Done(Done {
        step: 1,
        pass: 0,
        fields: Field::ALL.to_vec(),
        report: Report::Particles(ParticleReport::one_step()),
        diagnostics: vec![Diagnostic {
            name: "kinetic_energy".to_owned(),
            value: -0.0,
        }],
    });
    assert_eq!(decode::<ToCoupler>(&encode(&done).unwrap()).unwrap(), done);
}

#[test]
fn every_truncation_is_an_error() {
    for message in messages() {
        let bytes = encode(&message).unwrap();
        for length in 0..bytes.len() {
            let cut = decode::<ToEngine>(&bytes[..length]);
            assert!(
                matches!(cut, Err(CodecError::Malformed(_))),
                "{length} of {}: {cut:?}",
                bytes.len()
            );
        }
    }
}

#[test]
fn trailing_bytes_are_refused() {
    let mut bytes = encode(&ToEngine::Finish).unwrap();
    bytes.extend([0, 0]);
    assert_eq!(
        decode::<ToEngine>(&bytes),
        Err(CodecError::Trailing {
            length: 1,
            extra: 2
        })
    );
}

#[test]
fn hostile_lengths_are_refused_without_allocating() {
    // Failed{Engine, why}: tag 4, kind 1, then a string length of 2^60 and of 8 GiB, marker 253: u64.
    let good = encode(&ToCoupler::Failed(Failure::new(FailureKind::Engine, "x"))).unwrap();
    assert_eq!(good, [4, 1, 1, b'x']);
    for length in [1_u64 << 60, 8 << 30, u64::MAX, 70_000] {
        let mut bytes = vec![4, 1, 253];
        bytes.extend(length.to_le_bytes());
        bytes.extend([b'x'; 64]);
        let began = std::time::Instant::now();
        let result = decode::<ToCoupler>(&bytes);
        println!("length {length}: {result:?} in {:?}", began.elapsed());
        assert!(matches!(result, Err(CodecError::Malformed(_))));
        assert!(began.elapsed().as_millis() < 100);
    }
}

#[test]
fn a_file_is_read_at_any_length_and_its_lengths_are_not_believed() {
    for count in [0, 1, 1000, 100_000, 1_000_000] {
        // The most that a byte of a file can become: small numbers take one.
        let content: (Vec<u64>, Vec<f64>) = (vec![1; count], vec![0.5; count / 10]);
        let bytes = encode_file(&content).unwrap();
        assert_eq!(decode_file::<(Vec<u64>, Vec<f64>)>(&bytes), Ok(content));
    }
    for length in [1_u64 << 60, 8 << 30, u64::MAX, 70_000] {
        let mut bytes = vec![253];
        bytes.extend(length.to_le_bytes());
        bytes.extend([b'x'; 64]);
        for result in [
            decode_file::<String>(&bytes).map(drop),
            decode_file::<Vec<f64>>(&bytes).map(drop),
            decode_file::<Vec<u8>>(&bytes).map(drop),
        ] {
            assert!(
                matches!(result, Err(CodecError::Malformed(_))),
                "{result:?}"
            );
        }
    }
}

#[test]
fn unknown_tags_and_arbitrary_bytes_are_refused_without_panic() {
    assert!(decode::<ToEngine>(&[8]).is_err());
    assert!(decode::<ToCoupler>(&[250]).is_err());
    let mut state = 1_u64;
    for _ in 0..20_000 {
        let mut bytes = [0_u8; 24];
        for byte in &mut bytes {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            *byte = (state >> 56) as u8;
        }
        let _ = decode::<ToEngine>(&bytes[..1 + (state >> 33) as usize % 24]);
        let _ = decode::<ToCoupler>(&bytes);
    }
}

#[test]
fn messages_above_the_limit_are_refused_both_ways() {
    let mut scene = toy::particle_scene();
    scene.walls = vec![Wall::segment([0.0, 0.0], [1.0, 0.0]); 3000];
    let message = ToEngine::Configure(Configure::Particles {
        scene: Box::new(scene),
        grain_count: 0,
    });
    let error = encode(&message).unwrap_err();
    println!("{error}");
    assert!(matches!(error, CodecError::TooLong { length } if length > LIMIT));
    assert!(matches!(
        decode::<ToEngine>(&vec![0; LIMIT + 1]),
        Err(CodecError::TooLong { .. })
    ));
}
