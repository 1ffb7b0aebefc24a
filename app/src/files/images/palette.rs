//! Pictures whose pixels are numbers of palette entries. Decoders hand over only the colours; so the palette is read
//! here, and the decoder gets a copy of the file in which every entry has its own number as its colour.

use std::collections::HashSet;

use image::{DynamicImage, GrayAlphaImage, ImageFormat, LumaA, Rgba, RgbaImage};

use super::profile::Profile;
use super::{png, tiff};

/// Colours by number, with alpha; black beyond the last.
#[derive(Debug, Clone)]
pub(super) struct Palette(Box<[[u8; 4]; 256]>);

/// A file with a palette.
pub(super) struct Indexed {
    /// What the decoder is to be given.
    pub(super) file: Vec<u8>,
    /// The palette.
    pub(super) palette: Palette,
    /// How numbers stand in what comes out.
    pub(super) packing: Packing,
}

/// How the numbers of pixels stand in a decoded picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Packing {
    /// As grey values.
    Bytes,
    /// As so many pixels each, the first the highest bit, white or black.
    Bits(usize),
}

impl Packing {
    /// Pixels of the decoded picture for one number.
    pub(super) fn pixels_per_number(self) -> usize {
        match self {
            Self::Bytes => 1,
            Self::Bits(bits) => bits,
        }
    }

    /// The numbers and the alpha of a decoded picture.
    pub(super) fn numbers(self, image: DynamicImage) -> GrayAlphaImage {
        let image = image.into_luma_alpha8();
        let Self::Bits(bits) = self else {
            return image;
        };
        GrayAlphaImage::from_fn(image.width() / bits as u32, image.height(), |x, y| {
            let bit = |k: u32| u8::from(image.get_pixel(x * bits as u32 + k, y).0[0] >= 128);
            let number = (0..bits as u32).fold(0, |number, k| number << 1 | bit(k));
            LumaA([number, 255])
        })
    }
}

impl Palette {
    /// Of at most 256 entries.
    pub(super) fn new(entries: impl IntoIterator<Item = [u8; 4]>) -> Self {
        let mut palette = Box::new([[0, 0, 0, 255]; 256]);
        for (place, entry) in palette.iter_mut().zip(entries) {
            *place = entry;
        }
        Self(palette)
    }

    /// The colour of a pixel: of its entry, as opaque as both are.
    pub(super) fn colour(&self, [number, alpha]: [u8; 2]) -> [u8; 4] {
        let [r, g, b, own] = self.0[usize::from(number)];
        [r, g, b, own.min(alpha)]
    }

    /// The picture in its colours.
    pub(super) fn colours_of(&self, numbers: &GrayAlphaImage) -> RgbaImage {
        RgbaImage::from_fn(numbers.width(), numbers.height(), |x, y| {
            Rgba(self.colour(numbers.get_pixel(x, y).0))
        })
    }

    /// Converts the entries to sRGB.
    pub(super) fn convert(&mut self, profile: &Profile, notes: &mut Vec<String>) {
        let entries = RgbaImage::from_fn(256, 1, |x, _| Rgba(self.0[x as usize]));
        let entries = profile.to_srgb(entries.into(), notes).into_rgba8();
        for (place, entry) in self.0.iter_mut().zip(entries.pixels()) {
            *place = entry.0;
        }
    }

    /// Gives entries that are used and have the colour of an earlier one the nearest colour that none has. A chart
    /// knows a yarn by its colour, and two entries are two yarns, in whatever colours they are shown.
    pub(super) fn tell_apart(&mut self, used: &[bool; 256]) {
        let mut taken: HashSet<[u8; 3]> = HashSet::new();
        let colour = |[r, g, b, _]: [u8; 4]| [r, g, b];
        let of_all: HashSet<[u8; 3]> = (self.0.iter().zip(used))
            .filter(|(_, used)| **used)
            .map(|(entry, _)| colour(*entry))
            .collect();
        for (entry, _) in self.0.iter_mut().zip(used).filter(|(_, used)| **used) {
            if !taken.insert(colour(*entry)) {
                let free = neighbours(colour(*entry))
                    .find(|near| !taken.contains(near) && !of_all.contains(near));
                if let Some(near) = free {
                    entry[..3].copy_from_slice(&near);
                    taken.insert(near);
                }
            }
        }
    }
}

/// Colours that differ in one channel, the nearest first, blue before red before green: least seen first.
fn neighbours(colour: [u8; 3]) -> impl Iterator<Item = [u8; 3]> {
    let step = move |channel: usize, step: i16| {
        let value = u8::try_from(i16::from(colour[channel]) + step).ok()?;
        let mut near = colour;
        near[channel] = value;
        Some(near)
    };
    (1..=255_i16).flat_map(move |distance| {
        let both = [distance, -distance];
        [2, 0, 1]
            .into_iter()
            .flat_map(move |channel| both.into_iter().filter_map(move |by| step(channel, by)))
    })
}

/// The palette of a file, if it has one.
pub(super) fn find(format: ImageFormat, bytes: &[u8]) -> Option<Indexed> {
    match format {
        ImageFormat::Png => of_png(bytes),
        ImageFormat::Bmp => of_bmp(bytes),
        ImageFormat::Gif => of_gif(bytes),
        ImageFormat::Tga => of_tga(bytes),
        ImageFormat::Tiff => tiff::indexed(bytes),
        _ => None,
    }
}

fn indexed(file: Vec<u8>, entries: impl IntoIterator<Item = [u8; 4]>) -> Indexed {
    Indexed {
        file,
        palette: Palette::new(entries),
        packing: Packing::Bytes,
    }
}

/// Entries of three bytes, red, green, blue.
fn of_triples(data: &[u8]) -> impl Iterator<Item = [u8; 4]> + '_ {
    let (triples, _) = data.as_chunks();
    triples.iter().map(|&[r, g, b]| [r, g, b, 255])
}

/// As many bytes as the entries of a palette of three or four bytes take, each with its number.
fn numbered(entry: usize, length: usize) -> Vec<u8> {
    (0..length).map(|k| (k / entry) as u8).collect()
}

fn of_png(bytes: &[u8]) -> Option<Indexed> {
    /// The kind of pixels in the header, the tenth byte of it.
    const INDEXED: u8 = 3;
    let is_indexed = png::chunk(bytes, *b"IHDR")?.data.get(9) == Some(&INDEXED);
    let palette = is_indexed.then(|| png::chunk(bytes, *b"PLTE"))??;
    let file = png::with_data(bytes, &palette, &numbered(3, palette.data.len()));
    // Alpha comes from the decoder.
    Some(indexed(file, of_triples(palette.data)))
}

fn of_bmp(bytes: &[u8]) -> Option<Indexed> {
    /// Bytes before the header that tells of the picture, and of that header where it is the oldest.
    const FILE_HEADER: usize = 14;
    const CORE_HEADER: usize = 12;
    let number = |at: usize, length: usize| {
        let bytes = bytes.get(at..at + length)?;
        Some(
            bytes
                .iter()
                .rev()
                .fold(0, |sum, &byte| sum << 8 | usize::from(byte)),
        )
    };
    let header = number(FILE_HEADER, 4)?;
    let (bits, entry, used) = match header {
        CORE_HEADER => (number(FILE_HEADER + 10, 2)?, 3, 0),
        _ => (
            number(FILE_HEADER + 14, 2)?,
            4,
            number(FILE_HEADER + 32, 4)?,
        ),
    };
    if !(1..=8).contains(&bits) {
        return None;
    }
    let entries = match used {
        1..=256 => used,
        _ => 1 << bits,
    };
    let start = FILE_HEADER.checked_add(header)?;
    let place = start..start.checked_add(entry * entries)?;
    let palette = bytes.get(place.clone())?;
    let colours: Vec<[u8; 4]> = palette
        .chunks_exact(entry)
        .map(|entry| [entry[2], entry[1], entry[0], 255])
        .collect();
    let mut file = bytes.to_vec();
    file[place].copy_from_slice(&numbered(entry, palette.len()));
    Some(indexed(file, colours))
}

fn of_gif(bytes: &[u8]) -> Option<Indexed> {
    // Flags tell whether a palette follows, and the exponent of its size less one.
    let table = |flags: u8| (flags & 0x80 != 0).then(|| 3_usize << ((flags & 7) + 1));
    let mut file = bytes.to_vec();
    let mut palette = None;
    let mut at = 13;
    let mut take = |at: &mut usize, length: usize| {
        let place = *at..*at + length;
        let colours: Vec<[u8; 4]> = of_triples(bytes.get(place.clone())?).collect();
        file[place].copy_from_slice(&numbered(3, length));
        palette = Some(colours);
        *at += length;
        Some(())
    };
    if let Some(length) = table(*bytes.get(10)?) {
        take(&mut at, length)?;
    }
    loop {
        match *bytes.get(at)? {
            // An extension: its kind, and blocks until an empty one.
            0x21 => {
                at += 2;
                loop {
                    let length = usize::from(*bytes.get(at)?);
                    at += 1 + length;
                    if length == 0 {
                        break;
                    }
                }
            }
            // The first picture.
            0x2c => {
                let flags = *bytes.get(at + 9)?;
                at += 10;
                if let Some(length) = table(flags) {
                    take(&mut at, length)?;
                }
                break;
            }
            _ => return None,
        }
    }
    // Alpha comes from the decoder.
    palette.map(|palette| indexed(file, palette))
}

/// A TGA with its palette taken out, its numbers declared to be greys.
fn of_tga(bytes: &[u8]) -> Option<Indexed> {
    let header = bytes.first_chunk::<18>()?;
    let [id, 1, kind @ (1 | 9), o0, o1, c0, c1, bits, ..] = *header else {
        return None;
    };
    if header[16] != 8 {
        return None;
    }
    let origin = usize::from(u16::from_le_bytes([o0, o1]));
    let count = usize::from(u16::from_le_bytes([c0, c1]));
    let entry = usize::from(bits).div_ceil(8);
    let start = header.len() + usize::from(id);
    let palette = bytes.get(start..start + entry * count)?;
    let wide = |value: u16| (((value & 31) * 255 + 15) / 31) as u8;
    let colours = palette.chunks_exact(entry).map(|entry| match *entry {
        [low, high] => {
            let value = u16::from_le_bytes([low, high]);
            [wide(value >> 10), wide(value >> 5), wide(value), 255]
        }
        [b, g, r] => [r, g, b, 255],
        [b, g, r, alpha] => [r, g, b, alpha],
        _ => [0, 0, 0, 255],
    });
    let before = std::iter::repeat_n([0, 0, 0, 255], origin);
    let colours: Vec<[u8; 4]> = before.chain(colours).collect();
    let mut file = header.to_vec();
    file[..8].copy_from_slice(&[0, 0, kind + 2, 0, 0, 0, 0, 0]);
    // No bits of alpha any more; which corner comes first stays.
    file[17] &= 0xf0;
    file.extend(&bytes[start + entry * count..]);
    Some(indexed(file, colours))
}
