//! How many threads, as the command line gives them.

use std::num::NonZeroUsize;

use run::limits::threads_max;

/// A number of threads that this machine can be asked for.
pub fn parse(text: &str) -> Result<NonZeroUsize, String> {
    let most = threads_max();
    match text.parse::<NonZeroUsize>() {
        Ok(threads) if threads.get() <= most => Ok(threads),
        _ => Err(format!("must be a whole number from 1 to {most}")),
    }
}
