//! Paths of images as designs write them, which may have been written on another system: with backslashes, with `./`,
//! and with accents composed otherwise than the file's name has them.

use std::fs;
use std::path::{Path, PathBuf};

use unicode_normalization::{UnicodeNormalization, is_nfc};

/// A name in the one form that names are compared in: accents composed (Unicode's form NFC), forward slashes, no `./`.
pub(super) fn same_form(name: &str) -> String {
    let composed: String = if is_nfc(name) {
        name.into()
    } else {
        name.nfc().collect()
    };
    let parts = composed.split(['/', '\\']).filter(|part| *part != ".");
    parts.collect::<Vec<_>>().join("/")
}

/// The path to the file that a design in `folder` calls `name`, as this system has it: `name` itself where there is
/// such a file, else one that differs in form only, else none.
pub(super) fn found_as(folder: &Path, name: &str) -> Option<String> {
    if folder.join(name).exists() {
        return Some(name.into());
    }
    if is_of_windows(name) {
        return None;
    }
    let mut place = PathBuf::from(folder);
    let mut found: Vec<String> = Vec::new();
    for part in same_form(name).split('/') {
        let actual = match part {
            // The root, of an absolute path.
            "" if found.is_empty() => {
                place = PathBuf::from("/");
                found.push(String::new());
                continue;
            }
            part if place.join(part).exists() => part.to_owned(),
            part => name_like(&place, part)?,
        };
        place.push(&actual);
        found.push(actual);
    }
    Some(found.join("/"))
}

/// A file of a folder whose name differs in form only.
fn name_like(folder: &Path, name: &str) -> Option<String> {
    let folder = if folder == Path::new("") {
        Path::new(".")
    } else {
        folder
    };
    let names = fs::read_dir(folder).ok()?.flatten();
    let mut names = names.filter_map(|entry| entry.file_name().into_string().ok());
    names.find(|other| same_form(other) == name)
}

/// Whether a path begins at a drive or a share, as only those of Windows do.
fn is_of_windows(name: &str) -> bool {
    let bytes = name.as_bytes();
    let has_drive = bytes.len() > 1 && bytes[0].is_ascii_alphabetic() && bytes[1] == b':';
    has_drive || name.starts_with("\\\\")
}

/// What explains that there is no file of a name, if its form does.
pub(super) fn explanation(name: &str) -> Option<&'static str> {
    if name.contains(char::is_control) {
        return Some(
            "the path has characters that no name has: in double quotes a backslash \\ begins an escape; write / or \
             use single quotes",
        );
    }
    if cfg!(windows) {
        return None;
    }
    if is_of_windows(name) {
        return Some(
            "this is a path of Windows, with a drive or a share before backslashes \\; put the image beside the \
             preset and name it relative to that, with /",
        );
    }
    name.contains('\\').then_some(
        "the backslash \\ was taken for /, which separates folders on every system, and there is no such file either",
    )
}
