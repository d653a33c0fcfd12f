//! Records the runs of `tests/recordings/` again, with the text beside each:
//!
//! ```text
//! cargo run --release -p tests --example renew_recordings
//! ```

use recording::RecordingError;
use tests::recorded::{cases, text_of};

fn main() -> Result<(), RecordingError> {
    for case in cases() {
        let outcome = case.record(&case.stored())?;
        assert!(outcome.complete, "{}: {:?}", case.name, outcome.why);
        let text = text_of(&case.stored())?;
        std::fs::write(case.text(), text).map_err(|source| RecordingError::File {
            action: "cannot write",
            path: case.text(),
            source,
        })?;
        println!("{}: {} bytes", case.stored().display(), outcome.bytes);
    }
    Ok(())
}
