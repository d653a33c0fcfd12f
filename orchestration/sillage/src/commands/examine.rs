//! `sillage doctor`: what this machine offers, what is built, what dead runs left behind.

use std::fmt;

use nix::sys::statvfs::statvfs;
use protocol::runspace::RunSpace;
use run::folder::machine::{Machine, machine};
use run::limits::{OPEN_FILES_MIN, open_files};
use run::{launch, version};
use scene::Error;
use serde::Serialize;

/// Shared memory below which even small runs fail \[bytes\].
const SHARED_MEMORY_MIN: u64 = 64 << 20;

/// What was found.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Findings {
    /// The machine.
    pub machine: Machine,
    /// Size of /dev/shm \[bytes\].
    pub shared_memory: u64,
    /// Free bytes in /dev/shm.
    pub shared_memory_free: u64,
    /// Files a process may have open.
    pub open_files: u64,
    /// Version of this program.
    pub sillage: String,
    /// Version of the protocol.
    pub protocol: u32,
    /// Version of the transport.
    pub iceoryx2: String,
    /// Commit it was built from, when known.
    pub commit: Option<String>,
    /// Programs of a run, and where they are.
    pub programs: Vec<Program>,
    /// What dead runs left in shared memory.
    pub leftovers: Vec<Left>,
    /// Runs of other users, alive or not: only they can tell, and remove them.
    pub others: Vec<Other>,
    /// What should be mended, and how.
    pub problems: Vec<String>,
}

/// A program of a run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Program {
    /// Its name.
    pub name: String,
    /// Where it is, if it is there.
    pub path: Option<String>,
}

/// Files of a dead run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Left {
    /// The run.
    pub run: String,
    /// How many files.
    pub files: usize,
    /// Their size \[bytes\].
    pub bytes: u64,
    /// Were they removed just now?
    pub removed: bool,
    /// Why they could not be.
    pub trouble: Option<String>,
}

/// A run of another user.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Other {
    /// The run.
    pub run: String,
    /// The user's number.
    pub user: u32,
}

/// Look around; `clean` removes what dead runs left.
pub fn examine(clean: bool) -> Result<Findings, Error> {
    let os = |error: nix::errno::Errno| std::io::Error::from(error);
    let memory = statvfs("/dev/shm")
        .map_err(os)
        .map_err(Error::file("cannot examine", "/dev/shm"))?;
    let open_files = open_files();
    let mut findings = Findings {
        machine: machine(),
        shared_memory: memory.blocks() as u64 * memory.fragment_size() as u64,
        shared_memory_free: memory.blocks_available() as u64 * memory.fragment_size() as u64,
        open_files,
        sillage: version::SILLAGE.into(),
        protocol: protocol::PROTOCOL_VERSION,
        iceoryx2: version::ICEORYX2.into(),
        commit: version::commit().map(String::from),
        programs: programs(),
        leftovers: leftovers(clean)?,
        others: others()?,
        problems: Vec::new(),
    };
    findings.problems = problems(&findings);
    Ok(findings)
}

fn programs() -> Vec<Program> {
    ["sillage-fluid", "sillage-particles", "sillage-coupler"]
        .map(|name| Program {
            name: name.into(),
            path: launch::sibling(name)
                .ok()
                .map(|path| path.to_string_lossy().into_owned()),
        })
        .to_vec()
}

fn leftovers(clean: bool) -> Result<Vec<Left>, Error> {
    let mut found = Vec::new();
    for leftover in RunSpace::leftovers()? {
        let swept = clean.then(|| leftover.sweep());
        let removed = matches!(swept, Some(Ok(_)));
        let trouble = swept.and_then(Result::err).map(|error| error.to_string());
        found.push(Left {
            run: leftover.id.clone(),
            files: leftover.files,
            bytes: leftover.bytes,
            removed,
            trouble,
        });
    }
    Ok(found)
}

fn others() -> Result<Vec<Other>, Error> {
    let others = RunSpace::of_others()?.into_iter();
    let others = others.map(|other| Other {
        run: other.id,
        user: other.user,
    });
    Ok(others.collect())
}

fn problems(findings: &Findings) -> Vec<String> {
    let mut problems = Vec::new();
    if findings.shared_memory_free < SHARED_MEMORY_MIN {
        problems.push(format!(
            "/dev/shm has {} free, and runs want at least {}: enlarge it \
             (container: --shm-size=1g; else: mount -o remount,size=1g /dev/shm)",
            bytes(findings.shared_memory_free),
            bytes(SHARED_MEMORY_MIN)
        ));
    }
    if findings.open_files < OPEN_FILES_MIN {
        problems.push(format!(
            "a process may open {} files, and runs want at least {OPEN_FILES_MIN}: ulimit -n 1024",
            findings.open_files
        ));
    }
    for program in findings
        .programs
        .iter()
        .filter(|program| program.path.is_none())
    {
        let name = &program.name;
        problems.push(format!(
            "{name} is not beside sillage: cargo build --release"
        ));
    }
    let left = findings
        .leftovers
        .iter()
        .filter(|left| !left.removed && left.trouble.is_none())
        .count();
    let stuck = findings.leftovers.iter();
    problems.extend(stuck.filter_map(|left| left.trouble.clone()));
    if left > 0 {
        problems.push(format!(
            "{left} dead runs left files in shared memory: sillage doctor --clean"
        ));
    }
    problems
}

fn bytes(count: u64) -> String {
    match count {
        c if c >= 1 << 30 => format!("{:.1} GiB", c as f64 / (1u64 << 30) as f64),
        c if c >= 1 << 20 => format!("{:.1} MiB", c as f64 / (1u64 << 20) as f64),
        c => format!("{:.1} KiB", c as f64 / 1024.0),
    }
}

impl fmt::Display for Findings {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Machine {
            cpu,
            cores,
            memory,
            system,
        } = &self.machine;
        writeln!(
            out,
            "machine        {cpu}, {cores} cores, {}, {system}",
            bytes(*memory)
        )?;
        writeln!(
            out,
            "shared memory  {} free of {}",
            bytes(self.shared_memory_free),
            bytes(self.shared_memory)
        )?;
        writeln!(out, "open files     {} allowed", self.open_files)?;
        let commit = self.commit.as_deref().unwrap_or("unknown");
        writeln!(
            out,
            "versions       sillage {} (commit {commit}), protocol {}, iceoryx2 {}",
            self.sillage, self.protocol, self.iceoryx2
        )?;
        for Program { name, path } in &self.programs {
            writeln!(
                out,
                "program        {name}: {}",
                path.as_deref().unwrap_or("missing")
            )?;
        }
        for Left {
            run,
            files,
            bytes: size,
            removed,
            ..
        } in &self.leftovers
        {
            let what = if *removed { "removed" } else { "left over" };
            writeln!(
                out,
                "dead run       {run}: {files} files, {}, {what}",
                bytes(*size)
            )?;
        }
        for Other { run, user } in &self.others {
            writeln!(
                out,
                "run            {run} of user {user}: alive or not, only that user can look into it"
            )?;
        }
        if self.problems.is_empty() {
            return writeln!(out, "nothing to mend");
        }
        self.problems
            .iter()
            .try_for_each(|problem| writeln!(out, "problem        {problem}"))
    }
}
