//! The table of fields, and what is derived from it.

use std::fmt::Write as _;

use protocol::field::{Exchange, FIELDS, Field, FieldSpec, Rank, Support, Unit};

fn numbers(spec: &FieldSpec) -> String {
    let each = match spec.support {
        Support::Node => "n",
        Support::Simplex => "s",
        Support::Grain => "g",
        Support::Facet => "f",
    };
    match spec.rank {
        Rank::Scalar => each.to_owned(),
        Rank::Vector => format!("d {each}"),
        Rank::Corners => format!("(d + 1) {each}"),
        Rank::CornerVectors => format!("d (d + 1) {each}"),
        Rank::FacetVectors => format!("d d {each}"),
        Rank::Spin => format!("d (d − 1)/2 {each}"),
    }
}

fn unit(spec: &FieldSpec) -> String {
    match spec.unit {
        Unit::Of(unit) => unit.to_owned(),
        Unit::Measure => "m² (space: m³)".to_owned(),
        Unit::Grain { ball, disk } => format!("{ball} (disk: {disk})"),
    }
}

fn sent(spec: &FieldSpec) -> String {
    let words = spec.sent.iter().map(|exchange| match exchange {
        Exchange::Mesh => "fluid, `Ready`",
        Exchange::ToFluid => "coupler → fluid, `Advance`",
        Exchange::FromFluid => "fluid, `Done`",
        Exchange::Grains => "`Configure`, `Ready`",
        Exchange::ToParticles => "coupler → particles, `Advance`",
        Exchange::FromParticles => "particles, `Done`",
        Exchange::MaybeFromParticles => "particles, `Done` (optional)",
        Exchange::Boundary => "fluid, `Ready` (optional)",
        Exchange::Shown => "coupler → orchestrator, `Snapshot`",
    });
    words.collect::<Vec<_>>().join("; ")
}

/// The table of the README.
fn table() -> String {
    let mut text = "| variant | id | name | numbers | unit | default | sent by, with | what |\n\
                    | --- | --- | --- | --- | --- | --- | --- | --- |\n"
        .to_owned();
    for spec in FIELDS {
        let default = spec
            .default
            .map_or(String::new(), |value| value.to_string());
        let _ = writeln!(
            text,
            "| {} | {} | `{}` | {} | {} | {default} | {} |{} |",
            variant(spec.field),
            spec.id,
            spec.name,
            numbers(&spec),
            unit(&spec),
            sent(&spec),
            spec.meaning
        );
    }
    text
}

/// Its number within messages.
fn variant(field: Field) -> u8 {
    protocol::codec::encode(&field).expect("a field")[0]
}

#[test]
fn the_table_of_the_readme_is_that_of_the_code() {
    let readme = include_str!("../../README.md");
    let table = table();
    assert!(
        readme.contains(&table),
        "the table of protocol/README.md is not that of src/language/field.rs; it must be\n\n{table}"
    );
}

#[test]
fn ids_and_names_are_unique_and_rows_are_found_by_both() {
    for (place, spec) in FIELDS.iter().enumerate() {
        println!("{place} {} {} {}", spec.id, spec.name, spec.field.unit(2));
        assert_eq!(usize::from(variant(spec.field)), place);
        assert_eq!(spec.field.spec(), spec);
        assert_eq!(Field::from_id(spec.id), Some(spec.field));
        assert_eq!(Field::from_name(spec.name), Some(spec.field));
        assert!(!spec.sent.is_empty() && !spec.meaning.is_empty());
    }
    let different = |a: &FieldSpec, b: &FieldSpec| a.id != b.id && a.name != b.name;
    for (place, spec) in FIELDS.iter().enumerate() {
        assert!(FIELDS[..place].iter().all(|other| different(spec, other)));
    }
    assert_eq!(Field::from_id(0), None);
    assert_eq!(Field::from_name(""), None);
}
