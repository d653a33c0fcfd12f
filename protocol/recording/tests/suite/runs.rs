//! Recordings of toy runs: all is in them, and they replay.

use std::path::Path;

use protocol::engine::{
    Computed, FluidEngine, Inputs, MeshDescription, Outputs, serve_fluid, serve_particles,
};
use protocol::field::Field;
use protocol::header::Stage;
use protocol::local::{self, LIMITS};
use protocol::message::{Advance, Capability, Failure, Role, ToCoupler, ToEngine};
use protocol::partner::Partner;
use protocol::report::FluidReport;
use protocol::scene::{CouplerScene, DragLaw, FluidScene, Geometry, Limits, Scheme};
use recording::{
    Begin, Body, Compression, Ending, Entry, Key, Options, Outcome, Reader, Recorder, Report,
    compare, diff, replay, summary,
};

use crate::toy::{self, Fault, ToyFluid, ToyGrains, fluid_run, particle_run};

pub fn begin(cells: usize) -> Begin {
    let scene = CouplerScene {
        end_time: 1.0,
        coupling_step: 0.01,
        step_min: None,
        adaptive: None,
        dimension: 2,
        gravity: vec![0.0, -9.81],
        fluid: Some(toy::fluid_scene(cells)),
        particles: Some(toy::particle_scene()),
        grains_stay: false,
        grain_boundaries: None,
        grain_exits: Vec::new(),
        near_grains: None,
        indicator: None,
        grains_file: None,
        scheme: Scheme::Staggered,
        drag: DragLaw::Dallavalle,
        geometry: Geometry::Disk,
        reaction: true,
        output_every: None,
        limits: Limits {
            connect: 1.0,
            configure: 1.0,
            step: 1.0,
        },
    };
    Begin::of(&scene, "toy-coupler 1", Some("abc".to_owned())).expect("a beginning")
}

pub fn greet(role: Role, recorder: Option<&Recorder>, fault: Fault) -> Partner {
    let link = match role {
        Role::Fluid => local::connect(role, move |link| {
            serve_fluid(&mut ToyFluid::new(fault), link)
        }),
        Role::Particles => {
            local::connect(role, |link| serve_particles(&mut ToyGrains::new(), link))
        }
    }
    .expect("a link");
    let link = match recorder {
        Some(recorder) => recorder.tap(role, link),
        None => link,
    };
    Partner::greet(role, link, &LIMITS).expect("a greeting")
}

/// Both toys, recorded or not; every bit that came back.
pub fn run(recorder: Option<&Recorder>, cells: usize) -> Vec<u64> {
    let mut fluid = greet(Role::Fluid, recorder, Fault::None);
    let mut particles = greet(Role::Particles, recorder, Fault::None);
    let mut bits = fluid_run(&mut fluid, cells);
    bits.extend(particle_run(&mut particles));
    fluid.finish().expect("left");
    particles.finish().expect("left");
    bits
}

pub fn record(path: &Path, options: Options, cells: usize) -> (Vec<u64>, Outcome) {
    let recorder = Recorder::create(path, options, &begin(cells)).expect("a recorder");
    let bits = run(Some(&recorder), cells);
    (bits, recorder.finish(0))
}

pub fn read(path: &Path) -> (Vec<Entry>, Ending) {
    let mut reader = Reader::open(path).expect("a recording");
    let mut entries = Vec::new();
    while let Some(entry) = reader.next_entry().expect("an entry") {
        entries.push(entry);
    }
    (entries, reader.ending())
}

#[test]
fn every_message_of_a_run_is_in_its_recording_and_the_run_has_the_same_bits() {
    let folder = tempfile::tempdir().expect("a folder");
    let without = run(None, 8);
    let mut contents = Vec::new();
    println!("| compression | messages | bytes |");
    for compression in [Compression::Zstd, Compression::None] {
        let path = folder.path().join(format!("{compression:?}.mcap"));
        let options = Options {
            compression,
            ..Options::default()
        };
        let (bits, outcome) = record(&path, options, 8);
        println!(
            "| {compression:?} | {} | {} |",
            outcome.messages, outcome.bytes
        );
        assert_eq!(bits, without);
        assert!(outcome.complete, "{outcome:?}");
        assert_eq!(outcome.bytes, path.metadata().expect("a file").len());
        let (entries, ending) = read(&path);
        assert_eq!(ending, Ending::Complete { exit: Some(0) });
        // and run/begin
        assert_eq!(entries.len() as u64 + 1, outcome.messages);
        assert!(entries.is_sorted_by(|a, b| a.sequence < b.sequence));
        contents.push(entries);
    }
    let of = |entries: &[Entry], seat: Role, wanted: fn(&Body) -> bool| {
        let found = entries.iter().filter(|e| e.seat == seat && wanted(&e.body));
        found.count()
    };
    let entries = &contents[0];
    let requests: fn(&Body) -> bool = |body| matches!(body, Body::Request(_));
    let answers: fn(&Body) -> bool = |body| matches!(body, Body::Answer(_));
    let fields: fn(&Body) -> bool = |body| matches!(body, Body::Field(..));
    // Configure, 4 steps of 2 passes and a Commit, Finish; Hello, Ready, Done; mesh, 2 in, 3 out
    assert_eq!(of(entries, Role::Fluid, requests), 1 + 4 * 3 + 1);
    assert_eq!(of(entries, Role::Fluid, answers), 2 + 4 * 2);
    assert_eq!(of(entries, Role::Fluid, fields), 4 + 4 * 2 * 5);
    assert_eq!(of(entries, Role::Particles, requests), 1 + 3 * 2 + 1);
    assert_eq!(of(entries, Role::Particles, answers), 2 + 3);
    assert_eq!(of(entries, Role::Particles, fields), 12 + 3 * 6);
    let content = |entries: &[Entry]| -> Vec<(Key, String)> {
        let essence = |entry: &Entry| match &entry.body {
            Body::Answer(ToCoupler::Done(done)) => format!("{} {:?}", done.step, done.fields),
            body => format!("{body:?}"),
        };
        entries
            .iter()
            .map(|entry| (entry.key, essence(entry)))
            .collect()
    };
    assert_eq!(content(&contents[0]), content(&contents[1]));
}

#[test]
fn keys_headers_and_numbers_say_where_and_what() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("toy.mcap");
    record(&path, Options::default(), 8);
    let (entries, _) = read(&path);
    let porosity = entries
        .iter()
        .filter(|entry| entry.key.step == 3 && entry.key.pass == 1)
        .find_map(|entry| match &entry.body {
            Body::Field(Field::Porosity, values) => Some((entry.header, values)),
            _ => None,
        });
    let (header, values) = porosity.expect("the porosity of step 3, pass 1");
    assert_eq!((header.step, header.pass), (3, 1));
    assert_eq!(header.stage, Stage::Advance as u32);
    assert_eq!(header.time, 0.02);
    assert_eq!(header.count, 18);
    let expected: Vec<f64> = (0..18).map(|n| 1.0 / (1.1 + f64::from(n) + 1.0)).collect();
    assert_eq!(*values, expected);
    let commit = entries.iter().find_map(|entry| match entry.body {
        Body::Request(ToEngine::Commit { step: 3 }) => Some(entry.key),
        _ => None,
    });
    let commit = commit.expect("the commit of step 3");
    assert_eq!((commit.step, commit.pass), (3, 1));
    let begin = Reader::open(&path).expect("a recording").begin().clone();
    assert_eq!(begin, self::begin(8));
}

/// Another engine: the pressure at node 5 is a little higher in step 3.
struct Shifted(ToyFluid, f64);

impl FluidEngine for Shifted {
    fn identity(&self) -> (&'static str, &'static str) {
        ("shifted", "2")
    }
    fn capabilities(&self) -> Vec<Capability> {
        self.0.capabilities()
    }
    fn configure(&mut self, scene: &FluidScene) -> Result<MeshDescription, Failure> {
        self.0.configure(scene)
    }
    fn advance(
        &mut self,
        request: &Advance,
        inputs: &Inputs<'_>,
        mut outputs: Outputs<'_>,
    ) -> Result<Computed<FluidReport>, Failure> {
        let computed = self.0.advance(request, inputs, outputs.reborrow())?;
        if request.step == 3 {
            outputs.take(Field::Pressure)[5] += self.1;
        }
        Ok(computed)
    }
    fn commit(&mut self) -> Result<(), Failure> {
        self.0.commit()
    }
    fn save(&mut self, path: &Path) -> Result<(), Failure> {
        self.0.save(path)
    }
    fn restore(&mut self, path: &Path) -> Result<(), Failure> {
        self.0.restore(path)
    }
}

pub fn replayed(path: &Path, partner: &mut Partner) -> Report {
    let folder = tempfile::tempdir().expect("a folder");
    let mut reader = Reader::open(path).expect("a recording");
    let report = replay(&mut reader, partner, folder.path(), |_, _| ()).expect("a replay");
    println!("{}", compare::text(&report.fields, 0.0));
    report
}

#[test]
fn a_replay_of_the_same_engine_differs_by_nothing_and_of_another_by_what_it_changed() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("toy.mcap");
    record(&path, Options::default(), 8);
    for role in [Role::Fluid, Role::Particles] {
        let report = replayed(&path, &mut greet(role, None, Fault::None));
        assert!(report.within(0.0), "{report:?}");
        assert!(report.fields.values().all(|row| row.unequal == 0));
        let (steps, answers, fields) = match role {
            Role::Fluid => (4, 8, 7),
            Role::Particles => (3, 3, 8),
        };
        assert_eq!((report.steps, report.answers), (steps, answers));
        assert_eq!(report.fields.len(), fields);
        assert_eq!(report.left_out, Vec::<&str>::new());
    }
    let link = local::connect(Role::Fluid, |link| {
        serve_fluid(&mut Shifted(ToyFluid::new(Fault::None), 0.125), link)
    });
    let mut shifted = Partner::greet(Role::Fluid, link.expect("a link"), &LIMITS).expect("hello");
    let report = replayed(&path, &mut shifted);
    assert!(!report.within(0.0));
    let row = &report.fields["pressure"];
    let place = row.place.expect("a place");
    assert_eq!((place.step, place.index, row.unequal), (3, 5, 2));
    assert!((row.max - 0.125).abs() < 1e-15);
    let share = row.relative();
    assert!(report.within(share) && !report.within(0.99 * share));
    assert_eq!(report.fields["interstitial_velocity"].unequal, 0);
    assert_eq!(report.replayed.expect("hello").engine, "shifted");
    assert_eq!(report.recorded.expect("hello").engine, "toy-fluid");
}

/// Two steps; the second is refused once and asked again with half its length.
fn with_a_refused_step(partner: &mut Partner) {
    partner
        .configure_fluid(&toy::fluid_scene(3))
        .expect("a mesh");
    partner
        .advance(&toy::request(1, 1), &[], &mut [])
        .expect("step 1");
    partner.commit(1).expect("commit");
    for dt in [0.01, 0.005] {
        let request = Advance {
            dt,
            ..toy::request(2, 1)
        };
        partner
            .advance(&request, &[], &mut [])
            .expect_err("refused");
    }
}

#[test]
fn a_refused_step_is_another_attempt_in_the_recording_and_is_refused_again() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("toy.mcap");
    let recorder = Recorder::create(&path, Options::default(), &begin(3)).expect("a recorder");
    let mut fluid = greet(Role::Fluid, Some(&recorder), Fault::Refuses);
    with_a_refused_step(&mut fluid);
    fluid.finish().expect("left");
    assert!(recorder.finish(8).complete);
    let (entries, ending) = read(&path);
    assert_eq!(ending, Ending::Complete { exit: Some(8) });
    let attempts: Vec<(u64, u32)> = entries
        .iter()
        .filter(|entry| matches!(entry.body, Body::Request(ToEngine::Advance(_))))
        .map(|entry| (entry.key.step, entry.key.attempt))
        .collect();
    assert_eq!(attempts, [(1, 0), (2, 0), (2, 1)]);
    let same = replayed(&path, &mut greet(Role::Fluid, None, Fault::Refuses));
    assert!(same.within(0.0), "{same:?}");
    assert_eq!(same.answers, 3);
    let other = replayed(&path, &mut greet(Role::Fluid, None, Fault::None));
    let stopped = other.stopped.clone().expect("a reason");
    println!("{stopped}");
    assert!(!other.within(1e300));
    assert!(stopped.contains("step 2") && stopped.contains("recorded one failed: residual 1"));
    record(&path, Options::default(), 3);
    let failing = replayed(&path, &mut greet(Role::Fluid, None, Fault::Refuses));
    let stopped = failing.stopped.expect("a reason");
    println!("{stopped}");
    assert!(stopped.contains("failed where the recorded one did not"));
}

#[test]
fn an_answer_that_is_not_finite_stops_a_replay_with_its_place() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("toy.mcap");
    record(&path, Options::default(), 8);
    let report = replayed(&path, &mut greet(Role::Fluid, None, Fault::NotANumber));
    let stopped = report.stopped.expect("a reason");
    println!("{stopped}");
    assert!(stopped.contains("step 2") && stopped.contains("-inf at node 3 (component 1)"));
}

#[test]
fn two_recordings_of_one_run_do_not_differ_and_of_two_runs_by_what_they_do() {
    let folder = tempfile::tempdir().expect("a folder");
    let [one, same, other] = ["one", "same", "other"].map(|name| folder.path().join(name));
    record(&one, Options::default(), 8);
    let options = Options {
        compression: Compression::None,
        ..Options::default()
    };
    record(&same, options, 8);
    let compared = |a: &Path, b: &Path| {
        let mut readers = [a, b].map(|path| Reader::open(path).expect("a recording"));
        let [a, b] = &mut readers;
        let differences = diff::diff(a, b).expect("differences");
        println!("{}", diff::text(&differences, 0.0));
        differences
    };
    let none = compared(&one, &same);
    assert!(none.within(0.0) && none.messages_unequal.is_empty());
    assert!(none.about.is_empty() && !none.scenes_differ);
    let recorder = Recorder::create(&other, Options::default(), &begin(8)).expect("a recorder");
    let mut fluid = greet(Role::Fluid, Some(&recorder), Fault::None);
    let mut particles = greet(Role::Particles, Some(&recorder), Fault::None);
    fluid_run(&mut fluid, 8);
    let grains = toy::grains(5);
    particles
        .configure_particles(&toy::particle_scene(), &grains)
        .expect("grains");
    fluid.finish().expect("left");
    particles.finish().expect("left");
    recorder.finish(0);
    let some = compared(&one, &other);
    assert!(!some.within(1e300));
    assert_eq!(some.only_first["particles/grain_drag"].count, 3);
    assert_eq!(some.only_first["particles/grain_drag"].first, [1, 0, 0]);
    // Finish, told in another step
    assert!(
        some.only_second
            .keys()
            .all(|topic| topic.ends_with("request"))
    );
    assert!(some.fields.values().all(|row| row.unequal == 0));
}

#[test]
fn a_summary_tells_what_is_there() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("toy.mcap");
    record(&path, Options::default(), 8);
    let text = summary(&mut Reader::open(&path).expect("a recording")).expect("a summary");
    println!("{text}");
    assert!(text.starts_with("protocol 2, format 1, toy-coupler 1\nfluid: toy-fluid 1\n"));
    assert!(text.contains("4 steps, 11 candidates, 0 failed\ncomplete, exit code 0\n"));
    let row = text.lines().find(|line| line.starts_with("fluid/porosity"));
    let words: Vec<&str> = row.expect("a row").split_whitespace().collect();
    assert_eq!(words[1..3], ["8", "144"]);
}
