//! Folders and files that only this user can reach, made by this user; random names and secrets.
//!
//! `/dev/shm` belongs to everybody. What is found there under a name of ours was not necessarily made by
//! us: a folder of another user, one that is open to others, or a symbolic link is refused.

use std::fs::{self, DirBuilder, File, OpenOptions};
use std::io::{self, ErrorKind, Read, Write};
use std::os::unix::fs::{DirBuilderExt, MetadataExt, OpenOptionsExt};
use std::path::Path;

/// Make a folder that only this user can enter, or find that it is there as one.
pub(crate) fn folder(path: &Path) -> io::Result<()> {
    match DirBuilder::new().mode(0o700).create(path) {
        Err(error) if error.kind() == ErrorKind::AlreadyExists => ours(path),
        made => made,
    }
}

/// Refuse a folder that another user made, could enter, or that is elsewhere.
pub(crate) fn ours(path: &Path) -> io::Result<()> {
    let about = fs::symlink_metadata(path)?;
    let why = if about.is_symlink() {
        "is a symbolic link".to_owned()
    } else if !about.is_dir() {
        "is no folder".to_owned()
    } else if !is_ours(&about) {
        format!("belongs to user {}", about.uid())
    } else if about.mode() & 0o077 != 0 {
        format!("is open to others (mode {:o})", about.mode() & 0o777)
    } else {
        return Ok(());
    };
    let why = format!(
        "{} {why}, and a run goes only where its own user alone can: remove it, or run under another name",
        path.display()
    );
    Err(io::Error::new(ErrorKind::PermissionDenied, why))
}

/// Was this made by the user of this process?
pub(crate) fn is_ours(about: &fs::Metadata) -> bool {
    about.uid() == rustix::process::geteuid().as_raw()
}

/// How files are opened here: never through a symbolic link, and for this user alone when they are made.
pub(crate) fn options() -> OpenOptions {
    let mut options = File::options();
    options.mode(0o600).custom_flags(libc::O_NOFOLLOW);
    options
}

/// Open it so, and say of a symbolic link that it is one.
pub(crate) fn open(options: &OpenOptions, path: &Path) -> io::Result<File> {
    options.open(path).map_err(|error| {
        let why = match error.raw_os_error() {
            Some(libc::ELOOP) => "is a symbolic link, and a run follows none".to_owned(),
            _ => error.to_string(),
        };
        io::Error::new(error.kind(), format!("{} {why}", path.display()))
    })
}

/// The text of a small file, never through a symbolic link.
pub(crate) fn read(path: &Path) -> io::Result<String> {
    let mut text = String::new();
    let file = open(options().read(true), path)?;
    file.take(4096).read_to_string(&mut text)?;
    Ok(text)
}

/// Take from others what they may do with a file of ours; one of another user is refused.
pub(crate) fn close_to_others(path: &Path) -> io::Result<()> {
    use std::os::unix::fs::PermissionsExt;
    let file = open(options().read(true).write(true), path)?;
    let about = file.metadata()?;
    if !is_ours(&about) {
        let why = format!("{} belongs to user {}", path.display(), about.uid());
        return Err(io::Error::new(ErrorKind::PermissionDenied, why));
    }
    if about.mode() & 0o077 != 0 {
        file.set_permissions(fs::Permissions::from_mode(0o600))?;
    }
    Ok(())
}

/// Letters and digits of 128 random bits from the system.
pub(crate) const RANDOM_LENGTH: usize = 25;

/// 128 random bits from the system, as 25 characters of a-z and 0-9.
pub(crate) fn random() -> io::Result<String> {
    let mut bytes = [0; 16];
    File::open("/dev/urandom")?.read_exact(&mut bytes)?;
    let mut left = u128::from_ne_bytes(bytes);
    let digits = std::iter::repeat_with(|| {
        let digit = (left % 36) as u32;
        left /= 36;
        char::from_digit(digit, 36).unwrap_or('0')
    });
    Ok(digits.take(RANDOM_LENGTH).collect())
}

/// Make a file with random bits, unless it is there; called by one process at a time.
pub(crate) fn secret(path: &Path) -> io::Result<()> {
    match open(options().write(true).create_new(true), path) {
        Ok(mut file) => file.write_all(random()?.as_bytes()),
        Err(error) if error.kind() == ErrorKind::AlreadyExists => Ok(()),
        Err(error) => Err(error),
    }
}
