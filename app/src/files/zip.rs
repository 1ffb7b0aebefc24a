//! Zip archives in memory, for bundles. What is written is the same bytes for the same members. What is read may come
//! from anywhere: nothing larger than asked for is unpacked, and nothing is written anywhere, so that names that lead
//! out of the archive lead nowhere.

use std::collections::BTreeMap;
use std::io::{Cursor, Read, Write};

use zip::result::ZipResult;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipArchive, ZipWriter};

use super::image_paths::same_form;

/// Most members of an archive that is read.
const MOST_MEMBERS: usize = 1000;

/// An archive of these members, in this order.
///
/// # Errors
/// When it would be larger than 4 GiB.
pub fn write<'a>(members: impl IntoIterator<Item = (&'a str, &'a [u8])>) -> ZipResult<Vec<u8>> {
    // Without a time of day, which would differ from one writing to the next.
    let options = SimpleFileOptions::default().compression_method(CompressionMethod::Deflated);
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, bytes) in members {
        archive.start_file(name, options)?;
        archive.write_all(bytes)?;
    }
    Ok(archive.finish()?.into_inner())
}

/// An archive in memory, its directory read. Members are called by their names in one form: with forward slashes,
/// without `./`, their accents composed. What a system's own tools add (`__MACOSX`, `.DS_Store`) is left out.
pub struct Archive<'a> {
    archive: ZipArchive<Cursor<&'a [u8]>>,
    /// Which member has which name; of several of a name the first.
    members: BTreeMap<String, usize>,
}

impl<'a> Archive<'a> {
    /// Reads the directory.
    ///
    /// # Errors
    /// What is wrong, as the end of a sentence about the file.
    pub fn open(bytes: &'a [u8]) -> Result<Self, String> {
        let archive = ZipArchive::new(Cursor::new(bytes))
            .map_err(|error| format!("is no bundle, or one that was cut off: {error}"))?;
        let count = archive.len();
        if count > MOST_MEMBERS {
            return Err(format!(
                "has {count} members, a bundle has at most {MOST_MEMBERS}"
            ));
        }
        let mut members = BTreeMap::new();
        for (index, raw) in archive.file_names_raw().enumerate() {
            // Some tools write UTF-8 without saying so; as UTF-8 nothing else can be read by chance but plain ASCII.
            let name = match std::str::from_utf8(raw) {
                Ok(name) => Some(same_form(name)),
                Err(_) => match archive.name_for_index(index) {
                    Some(Ok(name)) => Some(same_form(&name)),
                    _ => None,
                },
            };
            if let Some(name) = name.filter(|name| !is_of_a_tool(name)) {
                members.entry(name).or_insert(index);
            }
        }
        Ok(Self { archive, members })
    }

    /// The names of all members.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.members.keys().map(String::as_str)
    }

    /// Unpacks a member of at most `most` bytes; `None` if there is no member of that name.
    ///
    /// # Errors
    /// What is wrong, as the end of a sentence about the file.
    pub fn read(&mut self, name: &str, most: usize) -> Result<Option<Vec<u8>>, String> {
        let broken = |error: &dyn std::fmt::Display| format!("is broken: its {name}: {error}");
        let Some(&index) = self.members.get(name) else {
            return Ok(None);
        };
        let mut member = self
            .archive
            .by_index(index)
            .map_err(|error| broken(&error))?;
        let size = member.size();
        if size > most as u64 {
            return Err(format!(
                "is not opened: its {name} has {size} bytes, allowed are at most {most}"
            ));
        }
        let mut unpacked = Vec::new();
        // Ends with an error where there is more than it says.
        member
            .read_to_end(&mut unpacked)
            .map_err(|error| broken(&error))?;
        Ok(Some(unpacked))
    }
}

/// Whether a member is none of the user's: what macOS notes of files beside them.
fn is_of_a_tool(name: &str) -> bool {
    let mut parts = name.split('/');
    parts.any(|part| part == "__MACOSX" || part == ".DS_Store" || part.starts_with("._"))
}
