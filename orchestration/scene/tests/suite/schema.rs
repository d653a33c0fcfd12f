//! The schema that `sillage check --schema` prints, held against the program that reads scenes: it takes what
//! the program takes, and refuses what a schema can.

use scene::document::Document;

use crate::validator::complaint;

/// The schema takes a scene: the program takes it as well, or refuses what no schema can.
pub fn takes(document: &Document) {
    if let Some(complaint) = complaint(document) {
        panic!("refused by the schema: {complaint}\n{:#?}", document.tree);
    }
}

/// The schema refuses a scene, as the program does.
pub fn refuses(document: &Document) {
    match complaint(document) {
        Some(complaint) => println!("{complaint}"),
        None => panic!("taken by the schema: {:#?}", document.tree),
    }
}
