//! Designs in exported pictures: a PNG carries the bundle of the design it shows, so that it opens again.
//!
//! The chunk is named `toWl`: ancillary (others may skip it), private, and safe to copy (a program that changes the
//! picture may keep it: the design stays the one that the picture was made from). Its data is a bundle as `bundle`
//! writes it. Images of more than 4 MB are left out, with a warning; nothing tells where on the machine they were.

use std::io::{self, BufReader, Read, Seek};
use std::path::Path;

use renderer_core::design::Design;
use renderer_core::image::png_text;

use super::bundle::{LeftOut, Packer, Unpacked, unpack};
use super::image_words::words;
use super::input::{Input, PNG, open_file};
use super::{Carried, FileError};

/// Type of the chunk.
const KIND: [u8; 4] = *b"toWl";
/// Largest image that a picture takes along, bytes.
const LARGEST_IMAGE: usize = 4 << 20;
/// Largest chunk that is read: three images, a preset and more.
const LARGEST_CHUNK: u32 = 32 << 20;

/// What an exported picture takes along.
#[derive(Debug, Clone, Default)]
pub struct Embedded {
    /// Whole PNG chunks (length, type, data, checksum), to stand anywhere between IHDR and IEND, but not between IDATs.
    pub chunks: Vec<Vec<u8>>,
    /// What the picture does not take along, as sentences.
    pub warnings: Vec<String>,
}

/// What a picture of `design` takes along; relative image paths are names of `carried` files or start at `folder`. The
/// same design makes the same bytes.
///
/// # Errors
/// When an image cannot be encoded.
pub fn embedded(design: &Design, carried: &Carried, folder: &Path) -> Result<Embedded, String> {
    let packed = Packer::default().pack(design, carried, folder, Some(LARGEST_IMAGE))?;
    let data = packed.archive()?;
    let length = u32::try_from(data.len()).map_err(|error| error.to_string())?;
    let mut chunk = Vec::with_capacity(data.len() + 12);
    chunk.extend(length.to_be_bytes());
    chunk.extend(KIND);
    chunk.extend(data);
    let checksum = crc32fast::hash(&chunk[4..]);
    chunk.extend(checksum.to_be_bytes());
    Ok(Embedded {
        chunks: vec![chunk],
        warnings: packed.left_out.iter().map(LeftOut::warning).collect(),
    })
}

impl LeftOut {
    fn warning(&self) -> String {
        let Self { slot, name, size } = self;
        let what = words(*slot).name;
        let size = *size as f64 / f64::from(1 << 20);
        let most = LARGEST_IMAGE >> 20;
        format!(
            "the {what} has {size:.1} MB, more than the {most} MB that a picture takes along: the design in the \
             picture will open without it ({name}); save a bundle to keep it"
        )
    }
}

/// Whether a file is a PNG that carries a design.
pub fn carries_design(path: &Path) -> bool {
    let file = open_file(path);
    file.and_then(|file| find_chunk(&mut BufReader::new(file)))
        .is_ok_and(|chunk| chunk.is_some())
}

/// What a picture says that it shows; `None` if it does not say, or is no picture.
pub fn picture_title(path: &Path) -> Option<String> {
    png_text(BufReader::new(open_file(path).ok()?), "Title")
}

/// Reads the design that a PNG carries.
pub(super) fn read_embedded(path: &Path, png: &mut Input) -> Result<Unpacked, FileError> {
    let failed = |what: String| FileError::Bundle {
        path: path.to_owned(),
        what,
    };
    let chunk = find_chunk(png).map_err(|source| FileError::Read {
        path: path.to_owned(),
        source,
    })?;
    let chunk = chunk.ok_or_else(|| {
        failed(
            "carries no design: it was not exported by this program, or another program has left the design out"
                .into(),
        )
    })?;
    unpack(&chunk).map_err(|what| failed(format!("the design that it carries {what}")))
}

/// The data of a PNG's chunk; a chunk whose checksum is wrong counts as none.
fn find_chunk(file: &mut (impl Read + Seek)) -> io::Result<Option<Vec<u8>>> {
    let mut signature = [0; PNG.len()];
    if file.read_exact(&mut signature).is_err() || signature != PNG {
        return Ok(None);
    }
    loop {
        let mut header = [0; 8];
        match file.read_exact(&mut header) {
            Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => return Ok(None),
            other => other?,
        }
        let [l0, l1, l2, l3, kind @ ..] = header;
        let length = u32::from_be_bytes([l0, l1, l2, l3]);
        if kind != KIND || length > LARGEST_CHUNK {
            file.seek_relative(i64::from(length) + 4)?;
            continue;
        }
        let mut data = Vec::new();
        (&mut *file)
            .take(u64::from(length) + 4)
            .read_to_end(&mut data)?;
        if data.len() < length as usize {
            return Ok(None);
        }
        let checksum = data.split_off(length as usize);
        let mut hasher = crc32fast::Hasher::new();
        hasher.update(&KIND);
        hasher.update(&data);
        let is_whole = checksum == hasher.finalize().to_be_bytes();
        return Ok(is_whole.then_some(data));
    }
}
