//! What commands say on stdout, which may be a pipe whose reader has seen enough.

use std::fmt::Arguments;
use std::io::{ErrorKind, Write, stdout};

use scene::Error;

/// Text on stdout, ending in a newline. A reader that is gone (`sillage plan … | head`) is no error;
/// any other failure ends the command, since its result is lost.
pub fn line(text: Arguments<'_>) -> Result<(), Error> {
    // What was said before it, on stderr, comes first.
    run::tell::finish();
    let mut out = stdout().lock();
    let text = text.to_string();
    let text = text.strip_suffix('\n').unwrap_or(&text);
    match writeln!(out, "{text}").and_then(|()| out.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(Error::Usage(format!("cannot write to stdout: {error}")))
        }
        _ => Ok(()),
    }
}

/// [`line()`], written as `println!` is.
#[macro_export]
macro_rules! say {
    ($($text:tt)*) => { $crate::say::line(format_args!($($text)*)) };
}
