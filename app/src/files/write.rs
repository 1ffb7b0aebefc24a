//! Writing files so that they are whole or untouched, by way of drafts (`draft`).

use std::fs::OpenOptions;
use std::io::{self, Write};
use std::path::Path;

use super::FileError;
use super::draft::{Draft, Target};

/// Writes a file so that it is either whole or untouched.
///
/// # Errors
/// When the directory or the disk refuses.
pub fn write_atomically(path: &Path, bytes: &[u8]) -> Result<(), FileError> {
    write_atomically_with(path, |file| file.write_all(bytes))
}

/// As [`write_atomically`], for files that are made piece by piece.
///
/// # Errors
/// When the directory or the disk refuses, or `write` does.
pub fn write_atomically_with(
    path: &Path,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), FileError> {
    let failed = |source| write_error(path, source);
    if let Target::Device(device) = Target::of(path).map_err(failed)? {
        let device = OpenOptions::new().write(true).open(device);
        return device
            .and_then(|mut device| write(&mut device))
            .map_err(failed);
    }
    let mut draft = Draft::new(path)?;
    write(&mut draft).map_err(failed)?;
    draft.whole()?.place().map_err(failed)
}

/// Writes several files: all of them reach the disk before the first replaces its old one, so that a full disk leaves
/// all as they were.
///
/// # Errors
/// When a directory or the disk refuses.
pub fn write_together(files: &[(&Path, &[u8])]) -> Result<(), FileError> {
    let mut written = Vec::new();
    for &(path, bytes) in files {
        let mut draft = Draft::new(path)?;
        draft
            .write_all(bytes)
            .map_err(|source| write_error(path, source))?;
        written.push(draft.whole()?);
    }
    for mut draft in written {
        draft
            .place()
            .map_err(|source| write_error(draft.path(), source))?;
    }
    Ok(())
}

/// A file that could not be written, and why.
pub fn write_error(path: &Path, source: io::Error) -> FileError {
    FileError::Write {
        path: path.to_owned(),
        source,
    }
}

/// Whether `path` could be written now, without changing it: asked before minutes of rendering.
///
/// # Errors
/// When it could not, with the reason.
pub fn check_writable(path: &Path) -> Result<(), FileError> {
    match Target::of(path) {
        Ok(Target::Device(_)) => Ok(()),
        Ok(Target::File(_)) => Draft::new(path).map(drop),
        Err(source) => Err(write_error(path, source)),
    }
}
