//! Paths and names of files.

use std::path::{Path, PathBuf};

use super::UsedFile;
use super::apart::is_same_file;

/// Longest name of a file on most disks, bytes.
const LONGEST_NAME: usize = 255;

/// Name of a file without its ending.
pub fn stem_of(path: &Path) -> String {
    path.file_stem()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned()
}

/// A file's name of two parts, the first cut where the disk could not take the whole.
pub(super) fn name_of_parts(stem: &str, end: &str) -> String {
    let room = LONGEST_NAME.saturating_sub(end.len());
    format!("{}{end}", &stem[..stem.floor_char_boundary(room)])
}

/// The path from the root, so that it leads to the same file wherever the program goes.
pub fn absolute(path: &Path) -> PathBuf {
    std::path::absolute(path).unwrap_or_else(|_| path.to_owned())
}

/// A name for the picture of a design in `folder`, such that it is none of the files that are `used`:
/// `waves-picture.png`, `waves-picture-2.png` and so on.
pub fn picture_name(design: &str, ending: &str, folder: &Path, used: &[UsedFile]) -> String {
    let stem = design.strip_suffix("-picture").unwrap_or(design);
    let mut number = 1;
    loop {
        let name = match number {
            1 => name_of_parts(stem, &format!("-picture.{ending}")),
            _ => name_of_parts(stem, &format!("-picture-{number}.{ending}")),
        };
        let path = folder.join(&name);
        if !used.iter().any(|used| is_same_file(&used.path, &path)) {
            return name;
        }
        number += 1;
    }
}
