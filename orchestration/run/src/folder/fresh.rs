//! A folder for a run that names none.

use std::path::{Path, PathBuf};
use std::time::SystemTime;

use scene::Error;
use time::OffsetDateTime;

/// `runs/<scene>-<time>`, with a number when there is one already.
pub fn fresh_folder(name: &str) -> Result<PathBuf, Error> {
    let runs = Path::new("runs");
    let unusable = |error: std::io::Error| {
        Error::Usage(format!(
            "cannot write in this folder ({}: {error}): name one with --out",
            runs.display()
        ))
    };
    std::fs::create_dir_all(runs).map_err(unusable)?;
    let stamp = timestamp(SystemTime::now());
    for attempt in 1.. {
        let suffix = if attempt == 1 {
            String::new()
        } else {
            format!("-{attempt}")
        };
        let path = runs.join(format!("{name}-{stamp}{suffix}"));
        match std::fs::create_dir(&path) {
            Ok(()) => return Ok(path),
            Err(error) if error.kind() == std::io::ErrorKind::AlreadyExists => {}
            Err(error) => return Err(unusable(error)),
        }
    }
    unreachable!("the loop ends with a folder or an error")
}

/// 20261122-114500, UTC.
fn timestamp(now: SystemTime) -> String {
    let now = OffsetDateTime::from(now);
    let (year, month, day) = now.to_calendar_date();
    let (hour, minute, second) = now.to_hms();
    let month = u8::from(month);
    format!("{year:04}{month:02}{day:02}-{hour:02}{minute:02}{second:02}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn timestamps_follow_the_calendar() {
        let at =
            |seconds| timestamp(SystemTime::UNIX_EPOCH + std::time::Duration::from_secs(seconds));
        assert_eq!(at(0), "19700101-000000");
        assert_eq!(at(951_782_400), "20000229-000000");
        assert_eq!(at(1_795_348_800), "20261122-120000");
        assert_eq!(at(4_107_542_399), "21000228-235959");
    }
}
