//! The machine a run was computed on.

use serde::Serialize;

/// Processor and memory.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Machine {
    /// Model of the processor, as the system names it.
    pub cpu: String,
    /// Cores this process may use.
    pub cores: usize,
    /// Main memory \[bytes\], 0 when unknown.
    pub memory: u64,
    /// Operating system and architecture.
    pub system: String,
}

/// What can be learnt about this machine.
pub fn machine() -> Machine {
    let read = |path: &str| std::fs::read_to_string(path).unwrap_or_default();
    let cpu = read("/proc/cpuinfo");
    let memory = read("/proc/meminfo");
    let kernel = read("/proc/sys/kernel/osrelease");
    let kilobytes = value(&memory, "MemTotal")
        .and_then(|text| text.split_whitespace().next()?.parse::<u64>().ok());
    Machine {
        cpu: value(&cpu, "model name").unwrap_or("unknown").to_string(),
        cores: std::thread::available_parallelism().map_or(1, std::num::NonZeroUsize::get),
        memory: 1024 * kilobytes.unwrap_or(0),
        system: format!(
            "{} {} {}",
            std::env::consts::OS,
            kernel.trim(),
            std::env::consts::ARCH
        ),
    }
}

/// The value of `key : value` in a file of /proc.
fn value<'a>(text: &'a str, key: &str) -> Option<&'a str> {
    text.lines().find_map(|line| {
        let (name, value) = line.split_once(':')?;
        (name.trim() == key).then(|| value.trim())
    })
}
