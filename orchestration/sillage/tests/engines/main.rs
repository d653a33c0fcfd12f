//! Tests of engines by `sillage conform` and by runs: hundreds of processes, so in a binary of their
//! own, that the tests of time limits are not disturbed.

// Of what a run in the background offers, only starting and finishing is needed here.
#[allow(dead_code)]
#[path = "../background.rs"]
mod background;
mod conform;
mod conform_toy;
#[path = "../schema.rs"]
mod schema;
mod shipped;
