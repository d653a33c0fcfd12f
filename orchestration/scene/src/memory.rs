//! What a scene asks of the memory of this machine, counted before any of it is made.

use std::sync::OnceLock;

/// What all processes of a run hold of a grain, roughly \[bytes\].
pub const GRAIN: f64 = 1e3;
/// The same of a node of the fluid, with its share of the factors of the matrix.
pub const NODE: f64 = 1e4;

/// Why so many of these, of so many bytes each, are refused; none when this machine has room for them.
pub fn refusal(what: &str, count: f64, each: f64) -> Option<String> {
    static MEMORY: OnceLock<f64> = OnceLock::new();
    refusal_of(*MEMORY.get_or_init(memory), what, count, each)
}

fn refusal_of(memory: f64, what: &str, count: f64, each: f64) -> Option<String> {
    let gigabytes = |bytes: f64| bytes / 1e9;
    (count * each > memory).then(|| {
        format!(
            "{count:.3e} {what} need about {:.1e} GB of memory, and this machine has {:.1} GB: at most {:.1e}",
            gigabytes(count * each),
            gigabytes(memory),
            memory / each
        )
    })
}

/// Main memory of this machine, or what its container or `ulimit -v` allows \[bytes\]; unbounded where that is
/// not known.
fn memory() -> f64 {
    let read = |path: &str| std::fs::read_to_string(path).ok();
    let meminfo = read("/proc/meminfo");
    let total = meminfo.as_deref().and_then(|text| {
        let line = text
            .lines()
            .find_map(|line| line.strip_prefix("MemTotal:"))?;
        line.split_whitespace().next()?.parse::<f64>().ok()
    });
    let allowed = [
        "/sys/fs/cgroup/memory.max",
        "/sys/fs/cgroup/memory/memory.limit_in_bytes",
    ]
    .into_iter()
    .filter_map(|path| read(path)?.trim().parse::<f64>().ok());
    let total = total.map_or(f64::INFINITY, |kilobytes| 1024.0 * kilobytes);
    let limits = read("/proc/self/limits");
    let own = limits.as_deref().and_then(address_space);
    allowed.chain(own).fold(total, f64::min)
}

/// The limit on the memory of a process, unless it is "unlimited" \[bytes\].
fn address_space(limits: &str) -> Option<f64> {
    let mut lines = limits.lines();
    let line = lines.find_map(|line| line.strip_prefix("Max address space"))?;
    line.split_whitespace().next()?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_does_not_fit_is_refused_with_numbers() {
        assert_eq!(refusal_of(8e9, "grains", 7.9e6, GRAIN), None);
        let why = refusal_of(8e9, "grains", 1e10, GRAIN).expect("refused");
        println!("{why}");
        for part in ["1.000e10 grains", "1.0e4 GB", "8.0 GB", "at most 8.0e6"] {
            assert!(why.contains(part), "{why}");
        }
        assert!(refusal_of(8e9, "grains", f64::INFINITY, GRAIN).is_some());
        assert!(memory() > 1e8);
        let limits = |soft: &str| {
            format!("Max processes 7 8\nMax address space  {soft}  unlimited  bytes\n")
        };
        assert_eq!(address_space(&limits("1073741824")), Some(1073741824.0));
        assert_eq!(address_space(&limits("unlimited")), None);
    }
}
