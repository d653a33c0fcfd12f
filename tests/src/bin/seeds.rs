//! Writes inputs to begin fuzzing with, a folder for each kind: `seeds FOLDER`.

use std::path::PathBuf;
use std::process::ExitCode;

use tests::inputs::{TARGETS, seeds};

fn main() -> ExitCode {
    let Some(folder) = std::env::args_os().nth(1).map(PathBuf::from) else {
        eprintln!("usage: seeds FOLDER");
        return ExitCode::from(2);
    };
    for (kind, _) in TARGETS {
        let folder = folder.join(kind);
        std::fs::create_dir_all(&folder).expect("made");
        for (number, seed) in seeds::of(kind).iter().enumerate() {
            std::fs::write(folder.join(format!("{number:03}")), seed).expect("written");
        }
    }
    ExitCode::SUCCESS
}
