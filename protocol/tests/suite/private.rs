//! Who may look into a run, join it, or be in its way.

use std::fs::{self, DirBuilder, Permissions};
use std::os::unix::fs::{MetadataExt, PermissionsExt, chown, symlink};
use std::path::{Path, PathBuf};
use std::time::Duration;

use protocol::channel::Wait;
use protocol::codec;
use protocol::header::FieldHeader;
use protocol::ipc::{coupler_link, engine_link};
use protocol::local::LIMITS;
use protocol::message::{Hello, Role, ToCoupler};
use protocol::partner::Partner;
use protocol::runspace::{RunSpace, files_of};
use protocol::{Error, PROTOCOL_VERSION};

/// Everything at and below these paths, with modes.
fn below(paths: Vec<PathBuf>) -> Vec<(PathBuf, fs::Metadata)> {
    let mut found = Vec::new();
    let mut left = paths;
    while let Some(path) = left.pop() {
        let about = fs::symlink_metadata(&path).unwrap();
        if about.is_dir() {
            left.extend(fs::read_dir(&path).unwrap().map(|e| e.unwrap().path()));
        }
        found.push((path, about));
    }
    found
}

#[test]
fn what_a_run_has_is_its_users_alone() {
    let run = RunSpace::create().unwrap();
    let _ends = (
        coupler_link(&run, Role::Fluid).unwrap(),
        engine_link(&run, Role::Fluid).unwrap(),
    );
    let all = below(files_of(run.id()));
    let root = format!("/dev/shm/sillage-{}", run.id());
    let open = |mode: u32| mode & 0o077 != 0;
    for (path, about) in &all {
        // Folders of the transport within the private one are nobody's way.
        let inner = about.is_dir() && path.starts_with(&root) && *path != Path::new(&root);
        assert!(inner || !open(about.mode()), "{path:?} {:o}", about.mode());
    }
    println!("{} files and folders", all.len());
    assert!(all.len() > 100);
}

fn fresh(name: &str) -> (String, PathBuf) {
    let id = format!("{name}{}", std::process::id());
    let root = PathBuf::from(format!("/dev/shm/sillage-{id}"));
    (id, root)
}

fn made(path: &Path, mode: u32) {
    DirBuilder::new().create(path).unwrap();
    fs::set_permissions(path, Permissions::from_mode(mode)).unwrap();
}

/// What joining the run of this name says.
fn refusal(id: &str) -> String {
    let error = engine_link(&RunSpace::named(id).unwrap(), Role::Fluid)
        .err()
        .expect("refused");
    assert_eq!(error.exit_code(), 4);
    println!("{error}");
    error.to_string()
}

#[test]
fn a_folder_that_others_made_or_could_enter_is_refused() {
    let elsewhere = tempfile::tempdir().unwrap();
    let (id, root) = fresh("link");
    symlink(elsewhere.path(), &root).unwrap();
    assert!(refusal(&id).contains("is a symbolic link"));
    fs::remove_file(&root).unwrap();

    let (id, root) = fresh("open");
    made(&root, 0o755);
    assert!(refusal(&id).contains("is open to others (mode 755)"));
    fs::remove_dir(&root).unwrap();

    let (id, root) = fresh("other");
    made(&root, 0o700);
    if chown(&root, Some(65534), None).is_ok() {
        assert!(refusal(&id).contains("belongs to user 65534"));
    }
    fs::remove_dir(&root).unwrap();

    // Also within a folder of our own nothing is followed.
    for (name, what) in [("members", "members"), ("lock", "lock"), ("token", "token")] {
        let (id, root) = fresh(name);
        made(&root, 0o700);
        symlink(elsewhere.path().join("there"), root.join(what)).unwrap();
        assert!(refusal(&id).contains("is a symbolic link"));
        // The last one out may have done it.
        let _ = fs::remove_dir_all(&root);
    }
    assert_eq!(fs::read_dir(elsewhere.path()).unwrap().count(), 0);
}

#[test]
fn a_lock_that_somebody_keeps_is_not_waited_for_without_limit() {
    let run = RunSpace::create().unwrap();
    let lock = format!("/dev/shm/sillage-{}/lock", run.id());
    let file = fs::File::open(&lock).unwrap();
    rustix::fs::flock(&file, rustix::fs::FlockOperation::LockExclusive).unwrap();
    let mut environment = run.to_environment();
    environment.push(("SILLAGE_LOCK_LIMIT".to_owned(), "0.3".to_owned()));
    let engine = crate::processes::start("fluid", &environment, "");
    let (code, words) = crate::processes::end(engine, Duration::from_secs(5));
    assert_eq!(code, Some(4), "{words}");
    assert!(words.contains("lock is held by another process"), "{words}");
    drop(file);
}

#[test]
fn the_next_run_removes_what_a_dead_one_left_and_no_living_one() {
    let living = RunSpace::create().unwrap();
    let (id, root) = fresh("swept");
    made(&root, 0o700);
    made(&root.join("members"), 0o700);
    // Process 1 lives, and holds no lock here: a number says nothing.
    fs::write(root.join("members/orchestrator"), "1 1\n").unwrap();
    fs::write(format!("/dev/shm/sillage{id}_segment"), [0; 5000]).unwrap();
    fs::create_dir(format!("/dev/shm/.sillage-{id}.half")).unwrap();
    let next = RunSpace::create().unwrap();
    assert_eq!(files_of(&id), Vec::<PathBuf>::new());
    assert!(!files_of(living.id()).is_empty());
    drop(next);
}

#[test]
fn a_start_that_has_nothing_to_remove_costs_some_milliseconds() {
    let mut times: Vec<Duration> = Vec::new();
    for _ in 0..30 {
        let begun = std::time::Instant::now();
        let run = RunSpace::create().unwrap();
        times.push(begun.elapsed());
        drop(run);
    }
    times.sort();
    println!("median {:?}, longest {:?}", times[15], times[29]);
    assert!(times[15] < Duration::from_millis(20), "{:?}", times[15]);
}

/// What the coupler says to this first message of an engine over shared memory.
fn greeted(run: &RunSpace, bytes: impl FnOnce(&RunSpace) -> Vec<u8>) -> Result<Hello, Error> {
    let bytes = bytes(run);
    std::thread::scope(|scope| {
        scope.spawn(|| {
            let mut link = engine_link(run, Role::Fluid).unwrap();
            let header = FieldHeader::message(0, 0, bytes.len());
            let wait = Wait::new(0, "an ear", Duration::from_secs(5));
            while !link.send_message(header, &bytes).unwrap() {
                link.idle(wait, Duration::from_millis(20)).unwrap();
            }
            let _ = link.receive_message(Wait::new(0, "the end", Duration::from_millis(300)));
        });
        Partner::accept(Role::Fluid, run, &LIMITS).map(|partner| partner.hello().clone())
    })
}

fn hello(token: Option<String>) -> Hello {
    Hello {
        role: Role::Fluid,
        engine: "odd".to_owned(),
        version: "0".to_owned(),
        protocol: PROTOCOL_VERSION,
        process: 1,
        capabilities: Vec::new(),
        token,
    }
}

#[test]
fn an_engine_that_does_not_know_the_token_is_refused_by_the_name_of_its_seat() {
    let token = |run: &RunSpace| run.to_environment()[2].1.clone();
    let bytes = |hello| codec::encode(&ToCoupler::Hello(hello)).unwrap();
    let run = || RunSpace::create().unwrap();
    let known = greeted(&run(), |run| bytes(hello(Some(token(run))))).unwrap();
    assert_eq!(known.token, None, "it is not passed on");
    let refused = |error: Error, words: &str| {
        println!("{error}");
        assert_eq!(error.exit_code(), 3);
        let words = format!("handshake with the fluid: `odd` shows {words}");
        assert!(error.to_string().starts_with(&words), "{error}");
    };
    let wrong = hello(Some("guessed".to_owned()));
    let error = greeted(&run(), |_| bytes(wrong)).unwrap_err();
    refused(error, "another token than the run's");
    refused(
        greeted(&run(), |_| bytes(hello(None))).unwrap_err(),
        "no token",
    );
    // As engines said it before there were tokens.
    let older = |_: &RunSpace| {
        let mut bytes = bytes(hello(None));
        assert_eq!(bytes.pop(), Some(0));
        bytes
    };
    refused(greeted(&run(), older).unwrap_err(), "no token");
}

#[test]
fn an_engine_that_was_handed_no_token_reads_it_in_the_runs_folder() {
    let run = RunSpace::create().unwrap();
    let mut environment = run.to_environment();
    environment.retain(|(name, _)| name != "SILLAGE_TOKEN");
    let engine = crate::processes::start("fluid", &environment, "");
    let mut fluid = Partner::accept(Role::Fluid, &run, &LIMITS).unwrap();
    fluid.finish().unwrap();
    assert_eq!(
        crate::processes::end(engine, Duration::from_secs(2)).0,
        Some(0)
    );
}
