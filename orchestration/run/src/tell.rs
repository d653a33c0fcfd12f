//! Words on stderr. It may be a pipe whose reader has left or a device that is full: what is said then is
//! lost, and nothing else.

use std::fmt::Arguments;
use std::io::{Write, stderr};

/// A line on stderr.
pub fn line(text: Arguments<'_>) {
    let _ = writeln!(stderr().lock(), "{text}");
}

/// [`line()`], written as `eprintln!` is.
#[macro_export]
macro_rules! tell {
    ($($text:tt)*) => { $crate::tell::line(format_args!($($text)*)) };
}
