//! That no command writes over what it reads, nor two files into one: found before anything is made.

use std::fs;
use std::path::{Path, PathBuf};

use unicode_normalization::UnicodeNormalization;

use super::FileError;
use super::draft::{folder_of, follow};

/// A file that a command reads or writes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct UsedFile {
    /// Where it is.
    pub path: PathBuf,
    /// What it is, as in "… is WHAT": "the chart image of the design".
    pub what: String,
}

impl UsedFile {
    /// A file, and what it is.
    pub fn new(path: impl Into<PathBuf>, what: impl Into<String>) -> Self {
        Self {
            path: path.into(),
            what: what.into(),
        }
    }
}

/// Makes sure that none of `outputs` is one of `inputs` or another output, under whatever names.
///
/// # Errors
/// When one is, with what it is.
pub fn check_apart(inputs: &[UsedFile], outputs: &[UsedFile]) -> Result<(), FileError> {
    for (k, output) in outputs.iter().enumerate() {
        let others = inputs.iter().chain(&outputs[..k]);
        let taken = others
            .filter(|other| is_same_file(&other.path, &output.path))
            .map(|other| FileError::NotApart {
                path: output.path.clone(),
                what: other.what.clone(),
            });
        taken.map(Err).next().unwrap_or(Ok(()))?;
    }
    Ok(())
}

/// Whether two paths lead to one file. Of two that are not there yet, those count as one whose names differ in case or
/// in the form of their characters alone: on many disks they would be.
pub fn is_same_file(a: &Path, b: &Path) -> bool {
    let (Ok(a), Ok(b)) = (follow(a), follow(b)) else {
        return false;
    };
    match (fs::metadata(&a), fs::metadata(&b)) {
        (Ok(of_a), Ok(of_b)) => {
            // Into a device two may write.
            of_a.is_file()
                && of_b.is_file()
                && (is_one(&of_a, &of_b) || canonical(&a) == canonical(&b))
        }
        (Err(_), Err(_)) => {
            canonical(folder_of(&a)) == canonical(folder_of(&b)) && name_key(&a) == name_key(&b)
        }
        _ => false,
    }
}

/// Two names of one file (hard links) have these in common.
#[cfg(unix)]
fn is_one(a: &fs::Metadata, b: &fs::Metadata) -> bool {
    use std::os::unix::fs::MetadataExt;
    (a.dev(), a.ino()) == (b.dev(), b.ino())
}

#[cfg(not(unix))]
fn is_one(_a: &fs::Metadata, _b: &fs::Metadata) -> bool {
    false
}

fn canonical(path: &Path) -> PathBuf {
    path.canonicalize()
        .or_else(|_| std::path::absolute(path))
        .unwrap_or_else(|_| path.to_owned())
}

fn name_key(path: &Path) -> String {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    name.to_lowercase().nfc().collect()
}
