//! Scenes drawn at random, and shipped scenes changed at random: refused with words, or run for three steps,
//! with exit code 0 only where every defect is below its bound. Nothing panics, nothing hangs.
//!
//! A few with every test run, from fixed seeds; hundreds, in an hour on two cores, with
//! `cargo test --release --workspace --test commands -- --ignored draws::hundreds --nocapture --test-threads 1`.

mod change;
mod random;
mod tally;
mod trial;
mod valid;

use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

use toml::Value;

use crate::background::{need_programs, root};
use change::{PROGRAMS, changed};
use random::Draw;
use tally::Tally;
use trial::{Ending, Trial};

/// Of every scene in the long tests.
const MANY: u64 = 300;

/// Seeds between two tables.
const ROUND: usize = 50;

/// A shipped scene.
struct Shipped {
    path: PathBuf,
    tree: Value,
}

/// Every shipped scene whose engines are built with the workspace.
fn shipped() -> Vec<Shipped> {
    let folders = ["scenes", "studies/scenes"];
    let entries = folders.map(|folder| std::fs::read_dir(root().join(folder)).expect(folder));
    let paths = entries.into_iter().flatten();
    let mut paths: Vec<PathBuf> = paths.map(|entry| entry.expect("an entry").path()).collect();
    let engines = PROGRAMS.map(|engine| root().join("engines").join(engine));
    paths.extend(engines.map(|folder| folder.join("scene.toml")));
    paths.retain(|path| path.extension().is_some_and(|end| end == "toml"));
    paths.sort();
    let read = |path: PathBuf| {
        let text = std::fs::read_to_string(&path).expect("a scene");
        let mut tree = toml::from_str(&text).expect("TOML");
        from_anywhere(&mut tree, path.parent().expect("a folder"));
        Shipped { path, tree }
    };
    paths.into_iter().map(read).collect()
}

/// Name the files beside a scene so that they are found from everywhere.
fn from_anywhere(value: &mut Value, folder: &Path) {
    match value {
        Value::Table(table) => {
            let values = table.iter_mut().map(|(_, value)| value);
            values.for_each(|value| from_anywhere(value, folder));
        }
        Value::Array(list) => {
            let values = list.iter_mut();
            values.for_each(|value| from_anywhere(value, folder));
        }
        Value::String(name) if folder.join(&*name).is_file() => {
            let path = folder.join(&*name).canonicalize().expect("a file");
            *name = path.to_string_lossy().into_owned();
        }
        _ => {}
    }
}

/// What is drawn of one kind, and how it ended.
struct Kind<'a> {
    name: String,
    draw: Box<dyn Fn(&mut Draw) -> Trial + Sync + 'a>,
    may_be_refused: bool,
    tally: Mutex<Tally>,
}

impl<'a> Kind<'a> {
    fn new(
        name: String,
        may_be_refused: bool,
        draw: impl Fn(&mut Draw) -> Trial + Sync + 'a,
    ) -> Kind<'a> {
        Kind {
            tally: Mutex::new(Tally::new(&name)),
            draw: Box::new(draw),
            name,
            may_be_refused,
        }
    }

    /// Try what is drawn from a seed; what is wrong is said at once, a refusal too where none may be.
    fn try_one(&self, seed: u64) {
        let trial = (self.draw)(&mut Draw::new(seed).of(&self.name));
        let (mut ending, seconds) = trial.run();
        if let (Ending::Refused(why), false) = (&ending, self.may_be_refused) {
            ending = Ending::Wrong(why.clone());
        }
        let name = &self.name;
        if let Ending::Early(code, why) = &ending {
            let last = why.lines().last().unwrap_or_default();
            println!("{name}, seed {seed}: exit code {code}: {last}");
        }
        if let Ending::Wrong(why) = &ending {
            println!("{name}, seed {seed}: {why}\n{}", trial.text());
        }
        self.tally.lock().expect("sound").add(ending, seconds);
    }
}

/// Try so many seeds of each kind, on two threads; the table after each round, so that one that is broken
/// off has said something. How many ran, and how many ended wrongly.
fn try_all(kinds: &[Kind<'_>], seeds: u64) -> (u32, u32) {
    need_programs();
    for round in (0..seeds).step_by(ROUND) {
        let end = seeds.min(round + ROUND as u64) * kinds.len() as u64;
        let next = AtomicU64::new(round * kinds.len() as u64);
        let work = || {
            loop {
                let number = next.fetch_add(1, Ordering::Relaxed);
                if number >= end {
                    return;
                }
                let kind = &kinds[number as usize % kinds.len()];
                kind.try_one(number / kinds.len() as u64);
            }
        };
        std::thread::scope(|scope| {
            scope.spawn(work);
            work();
        });
        println!("{}", Tally::HEADER);
        for kind in kinds {
            println!("{}", kind.tally.lock().expect("sound"));
        }
    }
    let tallies = kinds.iter().map(|kind| kind.tally.lock().expect("sound"));
    tallies.fold((0, 0), |(ran, wrong), tally| {
        (ran + tally.ran(), wrong + tally.wrong)
    })
}

fn try_valid(count: u64) {
    let draw = |draw: &mut Draw| Trial::new(valid::scene(draw));
    let (_, wrong) = try_all(&[Kind::new("drawn".to_string(), false, draw)], count);
    assert_eq!(wrong, 0, "valid scenes end as they say");
}

fn try_changed(count: u64) {
    let shipped = shipped();
    let trees: Vec<&Value> = shipped.iter().map(|scene| &scene.tree).collect();
    let trees = &trees[..];
    let kinds = shipped.iter().map(|scene| {
        let name = scene.path.strip_prefix(root()).expect("below the root");
        let draw = move |draw: &mut Draw| Trial::new(changed(&scene.tree, trees, draw));
        Kind::new(name.display().to_string(), true, draw)
    });
    let (ran, wrong) = try_all(&kinds.collect::<Vec<_>>(), count);
    assert_eq!(wrong, 0, "changed scenes end as they say");
    assert!(ran > 0, "some of them run");
}

#[test]
fn a_dozen_valid_scenes_end_as_they_say() {
    try_valid(12);
}

#[test]
fn every_shipped_scene_changed_twice_is_refused_or_runs() {
    try_changed(2);
}

#[test]
#[ignore = "takes minutes: cargo test --release -p sillage --test commands -- --ignored draws::hundreds --nocapture"]
fn hundreds_of_valid_scenes_end_as_they_say() {
    try_valid(MANY);
}

#[test]
#[ignore = "takes an hour: cargo test --release -p sillage --test commands -- --ignored draws::hundreds --nocapture"]
fn hundreds_of_changes_of_every_shipped_scene_are_refused_or_run() {
    try_changed(MANY);
}
