//! A run in the background, what belongs to it, and what it leaves.

use std::collections::BTreeMap;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::Once;
use std::time::{Duration, Instant};

use crate::schema;

/// Longest time between a death and the end of everybody else.
pub const LEAVING_MAX: Duration = Duration::from_secs(6);
/// A machine that is busy with other tests may take long to get a run going.
const STARTING_MAX: Duration = Duration::from_secs(60);

pub fn programs() -> PathBuf {
    PathBuf::from(env!("CARGO_BIN_EXE_sillage"))
        .parent()
        .expect("a folder")
        .to_path_buf()
}

pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// The program with these arguments: exit code, stdout, stderr.
pub fn sillage(arguments: &[&str]) -> (Option<i32>, String, String) {
    schema::of_command(Path::new("."), arguments);
    let output = Command::new(programs().join("sillage"))
        .args(arguments)
        .output()
        .expect("started");
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (
        output.status.code(),
        text(&output.stdout),
        text(&output.stderr),
    )
}

/// The engines and the coupler, built when they are not there yet.
pub fn need_programs() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let names = [
            "sillage-fluid",
            "sillage-particles",
            "sillage-coupler",
            "prescribed-fluid",
            "frozen-particles",
            "rapier-particles",
        ];
        if names.iter().all(|name| programs().join(name).exists()) {
            return;
        }
        let mut cargo = Command::new(env!("CARGO"));
        cargo
            .args(["build", "--workspace", "--bins"])
            .current_dir(root());
        if programs().ends_with("release") {
            cargo.arg("--release");
        }
        assert!(
            cargo.status().expect("cargo").success(),
            "the programs cannot be built"
        );
    });
}

/// This test as a program that can run scenes itself: the programs of a run are looked for beside the one that
/// starts it.
pub fn beside_programs(place: &Path) -> PathBuf {
    need_programs();
    let program = place.join("test");
    std::fs::copy(std::env::current_exe().expect("a test"), &program).expect("copied");
    for name in ["sillage-fluid", "sillage-particles", "sillage-coupler"] {
        std::os::unix::fs::symlink(programs().join(name), place.join(name)).expect("linked");
    }
    program
}

/// A small cloud, as many steps as a test needs: about 10 ms each.
pub fn small_cloud(end_time: f64) -> Vec<String> {
    let mut arguments = vec![
        root()
            .join("scenes/cloud-uniform.toml")
            .to_string_lossy()
            .into_owned(),
    ];
    for setting in [
        "fluid.domain.rectangle.cells=[10, 30]".to_string(),
        "grains[0].radius=1.5e-4".to_string(),
        format!("run.end_time={end_time}"),
        "output.every=0.055".to_string(),
    ] {
        arguments.extend(["--set".to_string(), setting]);
    }
    arguments
}

/// Numbers that look random and are the same each time (splitmix64).
pub struct Schedule(pub u64);

impl Schedule {
    pub fn below(&mut self, bound: u64) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut mixed = self.0;
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (mixed ^ (mixed >> 31)) % bound
    }
}

/// A run in the background.
pub struct Run {
    pub child: Child,
    pub folder: tempfile::TempDir,
}

impl Run {
    pub fn start(arguments: &[String]) -> Run {
        Run::start_with(arguments, &[])
    }

    /// The same with further variables.
    pub fn start_with(arguments: &[String], variables: &[(&str, &str)]) -> Run {
        need_programs();
        schema::of_command(Path::new("."), &[&["run".to_string()], arguments].concat());
        let folder = tempfile::tempdir().expect("a folder");
        let child = Command::new(env!("CARGO_BIN_EXE_sillage"))
            .arg("run")
            .args(arguments)
            .args(["--threads", "1", "--out"])
            .env("SILLAGE_LOG", "info")
            .envs(variables.iter().copied())
            .arg(folder.path())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("started");
        Run { child, folder }
    }

    pub fn rows(&self) -> usize {
        let text =
            std::fs::read_to_string(self.folder.path().join("steps.csv")).unwrap_or_default();
        text.lines().count().saturating_sub(1)
    }

    /// Wait until some steps are computed; then all processes are there.
    pub fn wait_for_steps(&mut self, count: usize) {
        let begun = Instant::now();
        while self.rows() < count {
            let ended = self.child.try_wait().expect("status");
            assert!(
                ended.is_none() && begun.elapsed() < STARTING_MAX,
                "no steps: {}",
                self.words()
            );
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    /// Children by program name (cut by the system to 15 characters), and the run's identity.
    pub fn children(&self) -> (BTreeMap<String, i32>, String) {
        let mut found = BTreeMap::new();
        let mut run = String::new();
        for entry in std::fs::read_dir("/proc").expect("/proc").flatten() {
            let Ok(pid) = entry.file_name().to_string_lossy().parse::<i32>() else {
                continue;
            };
            let stat = std::fs::read_to_string(entry.path().join("stat")).unwrap_or_default();
            let Some((start, rest)) = stat.rsplit_once(") ") else {
                continue;
            };
            if rest.split_whitespace().nth(1) != Some(&self.child.id().to_string()) {
                continue;
            }
            let name = start
                .split_once('(')
                .map_or("", |(_, name)| name)
                .to_string();
            let environment = std::fs::read(entry.path().join("environ")).unwrap_or_default();
            for variable in environment.split(|&byte| byte == 0) {
                if let Some(id) = String::from_utf8_lossy(variable).strip_prefix("SILLAGE_RUN=") {
                    run = id.to_string();
                }
            }
            found.insert(name, pid);
        }
        (found, run)
    }

    fn words(&mut self) -> String {
        let mut text = String::new();
        if let Some(stderr) = &mut self.child.stderr {
            let _ = stderr.read_to_string(&mut text);
        }
        text
    }

    /// Wait for the end; exit code, stderr, and how long it took.
    pub fn finish(mut self) -> (Option<i32>, String, Duration, tempfile::TempDir) {
        let begun = Instant::now();
        let words = self.words();
        let status = self.child.wait().expect("reaped");
        (status.code(), words, begun.elapsed(), self.folder)
    }
}

/// Files of a run in shared memory; while all that is left is what another start of a run is removing just now, that
/// is waited for.
pub fn shared_memory_of(run: &str) -> Vec<String> {
    let begun = Instant::now();
    loop {
        let files = protocol::runspace::files_of(run).into_iter();
        let files: Vec<String> = files
            .map(|path| path.to_string_lossy().into_owned())
            .collect();
        let aside = files
            .iter()
            .all(|file| file.starts_with("/dev/shm/.sillage-"));
        if files.is_empty() || !aside || begun.elapsed() > Duration::from_secs(2) {
            return files;
        }
        std::thread::sleep(Duration::from_millis(5));
    }
}

pub fn is_alive(pid: i32) -> bool {
    let stat = std::fs::read_to_string(format!("/proc/{pid}/stat")).unwrap_or_default();
    stat.rsplit_once(") ")
        .is_some_and(|(_, rest)| !rest.starts_with('Z'))
}

pub fn report(folder: &Path) -> serde_json::Value {
    let text = std::fs::read_to_string(folder.join("run.json")).expect("run.json");
    serde_json::from_str(&text).expect("JSON")
}
