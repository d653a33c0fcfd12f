//! What commands say on stdout, which may be a pipe whose reader has seen enough.

use std::fmt::Arguments;
use std::io::{ErrorKind, Write, stdout};

use crate::error::exit_code;

/// Text on stdout, ending in a newline. A reader that is gone (`sillage plan … | head`) is no error;
/// any other failure ends the command, since its result is lost.
pub fn line(text: Arguments<'_>) {
    let mut out = stdout().lock();
    let text = text.to_string();
    let text = text.strip_suffix('\n').unwrap_or(&text);
    if let Err(error) = writeln!(out, "{text}").and_then(|()| out.flush())
        && error.kind() != ErrorKind::BrokenPipe
    {
        eprintln!("sillage: cannot write to stdout: {error}");
        std::process::exit(exit_code::SCENE);
    }
}

/// [`line()`], written as `println!` is.
#[macro_export]
macro_rules! say {
    ($($text:tt)*) => { $crate::stdout::line(format_args!($($text)*)) };
}
