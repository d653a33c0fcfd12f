//! The header is what the code says, engines in C compile against it without a warning, conform, and
//! take part in a run.

mod conform;
mod programs;
mod runs;

use protocol::field::{Exchange, FIELDS, Rank};

use crate::programs::kit;

const HEADER: &str = "include/sillage_engine.h";

/// The numbers of the fields that an engine meets in `advance`, from the table of the protocol.
fn numbers_of_fields() -> String {
    let exchanged = [
        Exchange::ToFluid,
        Exchange::FromFluid,
        Exchange::ToParticles,
        Exchange::FromParticles,
        Exchange::MaybeFromParticles,
    ];
    let mut text = String::new();
    for spec in FIELDS {
        if spec
            .sent
            .iter()
            .any(|exchange| exchanged.contains(exchange))
        {
            let name = spec.name.to_uppercase();
            let rank = match spec.rank {
                Rank::Scalar => "scalar",
                Rank::Spin => "spin",
                _ => "vector",
            };
            text += &format!(
                "\n/*\n {} ({}; {rank})\n */\n#define SILLAGE_FIELD_{name} {}\n",
                spec.meaning.trim(),
                spec.field.unit(2),
                spec.id
            );
        }
    }
    text
}

#[test]
fn the_header_is_what_cbindgen_writes() {
    let config = cbindgen::Config::from_file(kit().join("cbindgen.toml"));
    let config = cbindgen::Config {
        after_includes: Some(numbers_of_fields()),
        ..config.expect("cbindgen.toml")
    };
    let mut written = Vec::new();
    cbindgen::generate_with_config(kit(), config)
        .expect("bindings")
        .write(&mut written);
    let written = String::from_utf8(written).expect("UTF-8");
    let path = kit().join(HEADER);
    if std::env::var_os("SILLAGE_WRITE_HEADER").is_some() {
        std::fs::write(&path, &written).expect("written");
    }
    let found = std::fs::read_to_string(&path).unwrap_or_default();
    let differs = found.lines().zip(written.lines()).position(|(a, b)| a != b);
    assert!(
        found == written,
        "{HEADER} differs from line {differs:?} on; see cbindgen.toml for how to write it"
    );
}
