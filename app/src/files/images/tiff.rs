//! TIFF files that their decoder knows only in part: palettes, greys of two and four bits, and inks. Their first
//! directory is changed in a copy, so that it hands over the numbers as they are.

use super::palette::{Indexed, Packing, Palette};

const IMAGE_WIDTH: u16 = 256;
const BITS_PER_SAMPLE: u16 = 258;
const PHOTOMETRIC: u16 = 262;
const SAMPLES_PER_PIXEL: u16 = 277;
const COLOR_MAP: u16 = 320;
const TILE_WIDTH: u16 = 322;
const ICC_PROFILE: u16 = 34675;

/// Values of [`PHOTOMETRIC`].
const WHITE_IS_ZERO: u32 = 0;
const BLACK_IS_ZERO: u32 = 1;
const RGB: u32 = 2;
const PALETTE: u32 = 3;
const INKS: u32 = 5;

/// The first directory of a file.
struct Directory<'a> {
    bytes: &'a [u8],
    is_big_endian: bool,
    /// Where its entries are.
    entries: usize,
    /// How many.
    count: usize,
}

/// An entry: what kind of numbers, how many, and where its field for them is, which holds them if they are few.
struct Entry {
    kind: u16,
    count: usize,
    field: usize,
}

impl<'a> Directory<'a> {
    fn read(bytes: &'a [u8]) -> Option<Self> {
        let mut directory = Self {
            bytes,
            is_big_endian: bytes.starts_with(b"MM\0*"),
            entries: 0,
            count: 0,
        };
        let at = directory.number(4, 4)? as usize;
        directory.count = directory.number(at, 2)? as usize;
        directory.entries = at.checked_add(2)?;
        Some(directory)
    }

    /// The number in `length` bytes from `at` on.
    fn number(&self, at: usize, length: usize) -> Option<u32> {
        let bytes = self.bytes.get(at..at.checked_add(length)?)?;
        let with = |sum: u32, byte: &u8| sum << 8 | u32::from(*byte);
        Some(if self.is_big_endian {
            bytes.iter().fold(0, with)
        } else {
            bytes.iter().rev().fold(0, with)
        })
    }

    fn entry(&self, tag: u16) -> Option<Entry> {
        (0..self.count).find_map(|k| {
            let at = self.entries + 12 * k;
            if self.number(at, 2)? != u32::from(tag) {
                return None;
            }
            Some(Entry {
                kind: self.number(at + 2, 2)? as u16,
                count: self.number(at + 4, 4)? as usize,
                field: at + 8,
            })
        })
    }

    /// The first number of an entry of whole numbers.
    fn value(&self, tag: u16) -> Option<u32> {
        let entry = self.entry(tag)?;
        let size = size_of_kind(entry.kind)?;
        let at = match size * entry.count {
            0..=4 => entry.field,
            _ => self.number(entry.field, 4)? as usize,
        };
        self.number(at, size)
    }

    /// Writes the one number of an entry into a copy of the file.
    fn set(&self, file: &mut [u8], tag: u16, value: u32) -> Option<()> {
        let entry = self.entry(tag)?;
        let size = size_of_kind(entry.kind)?;
        let fits = size == 4 || value < 1 << (8 * size);
        if entry.count != 1 || !fits {
            return None;
        }
        let bytes = value.to_be_bytes();
        let bytes = &bytes[4 - size..];
        let place = file.get_mut(entry.field..entry.field + size)?;
        place.copy_from_slice(bytes);
        if !self.is_big_endian {
            place.reverse();
        }
        Some(())
    }
}

/// Bytes of a whole number of an entry.
fn size_of_kind(kind: u16) -> Option<usize> {
    match kind {
        1 => Some(1),
        3 => Some(2),
        4 => Some(4),
        _ => None,
    }
}

/// The colour profile that a file carries; an error where it lies beyond the file's end.
pub(super) fn profile(bytes: &[u8]) -> Result<Option<&[u8]>, String> {
    let place = Directory::read(bytes).and_then(|directory| {
        let entry = directory.entry(ICC_PROFILE)?;
        let start = directory.number(entry.field, 4)? as usize;
        Some((start, start.checked_add(entry.count)?))
    });
    match place {
        None => Ok(None),
        Some((start, end)) => match bytes.get(start..end) {
            Some(profile) => Ok(Some(profile)),
            None => Err("it is cut off".into()),
        },
    }
}

/// A file whose pixels are inks, changed so that they pass for colours; `None` for others.
pub(super) fn with_inks_as_colours(bytes: &[u8]) -> Option<Vec<u8>> {
    let directory = Directory::read(bytes)?;
    let is_inks = directory.value(PHOTOMETRIC)? == INKS && directory.value(SAMPLES_PER_PIXEL)? == 4;
    let mut file = is_inks.then(|| bytes.to_vec())?;
    directory.set(&mut file, PHOTOMETRIC, RGB)?;
    Some(file)
}

/// A file with a palette of up to 256 entries, or greys of two or four bits; `None` for others.
pub(super) fn indexed(bytes: &[u8]) -> Option<Indexed> {
    let directory = Directory::read(bytes)?;
    let bits = directory.value(BITS_PER_SAMPLE).unwrap_or(1);
    let samples = directory.value(SAMPLES_PER_PIXEL).unwrap_or(1);
    let entries = 1_usize << [1, 2, 4, 8].into_iter().find(|allowed| *allowed == bits)?;
    let palette = match (directory.value(PHOTOMETRIC)?, bits) {
        (PALETTE, _) => directory.color_map(entries)?,
        (BLACK_IS_ZERO, 2 | 4) => greys(entries).collect(),
        (WHITE_IS_ZERO, 2 | 4) => greys(entries).rev().collect(),
        _ => return None,
    };
    if samples != 1 {
        return None;
    }
    let mut file = bytes.to_vec();
    directory.set(&mut file, PHOTOMETRIC, BLACK_IS_ZERO)?;
    let packing = match bits {
        8 => Packing::Bytes,
        bits => Packing::Bits(bits as usize),
    };
    if bits == 2 || bits == 4 {
        // As a picture of single bits, each pixel one of as many.
        directory.set(&mut file, BITS_PER_SAMPLE, 1)?;
        for tag in [IMAGE_WIDTH, TILE_WIDTH] {
            if let Some(width) = directory.value(tag) {
                directory.set(&mut file, tag, width.checked_mul(bits)?)?;
            }
        }
    }
    Some(Indexed {
        file,
        palette: Palette::new(palette),
        packing,
    })
}

/// Even steps from black to white.
fn greys(entries: usize) -> impl DoubleEndedIterator<Item = [u8; 4]> {
    (0..entries).map(move |k| {
        let grey = (255 * k / (entries - 1)) as u8;
        [grey, grey, grey, 255]
    })
}

impl Directory<'_> {
    /// The entries of the palette: all reds, all greens and all blues, of 16 bits.
    fn color_map(&self, entries: usize) -> Option<Vec<[u8; 4]>> {
        let entry = self.entry(COLOR_MAP)?;
        if entry.kind != 3 || entry.count < 3 * entries {
            return None;
        }
        let start = self.number(entry.field, 4)? as usize;
        let value = |k: usize| self.number(start.checked_add(2 * k)?, 2);
        let values: Vec<u32> = (0..3 * entries).map(value).collect::<Option<_>>()?;
        // Some programs write values of 8 bits.
        let is_narrow = values.iter().all(|value| *value < 256);
        let byte = |value: u32| match is_narrow {
            true => value as u8,
            false => ((value * 255 + 32767) / 65535) as u8,
        };
        let colour = |k: usize| {
            let [r, g, b] = [0, 1, 2].map(|c| byte(values[c * entries + k]));
            [r, g, b, 255]
        };
        Some((0..entries).map(colour).collect())
    }
}
