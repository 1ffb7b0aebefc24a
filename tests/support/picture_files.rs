//! Picture files that no encoder at hand writes, put together byte by byte from the formats' definitions.

use std::io::Cursor;

use image::{DynamicImage, ImageFormat};

/// A file of a picture.
pub fn encoded(image: &DynamicImage, format: ImageFormat) -> Vec<u8> {
    let mut file = Cursor::new(Vec::new());
    image.write_to(&mut file, format).unwrap();
    file.into_inner()
}

/// EXIF data that says how a camera was held.
pub fn exif(orientation: u16) -> Vec<u8> {
    let mut exif = b"II*\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0".to_vec();
    exif.extend(orientation.to_le_bytes());
    exif.extend([0; 6]);
    exif
}

/// A JPEG with a segment behind its first two bytes.
pub fn with_segment(mut jpeg: Vec<u8>, marker: u8, content: &[u8]) -> Vec<u8> {
    let length = content.len() as u16 + 2;
    let segment = [&[0xff, marker][..], &length.to_be_bytes(), content].concat();
    jpeg.splice(2..2, segment);
    jpeg
}

/// A WebP with chunks beside its pixels, which `flags` announce.
pub fn webp_with(webp: &[u8], size: [u32; 2], flags: u8, chunks: &[(&[u8; 4], &[u8])]) -> Vec<u8> {
    let chunk = |kind: &[u8; 4], data: &[u8]| {
        let mut chunk = kind.to_vec();
        chunk.extend((data.len() as u32).to_le_bytes());
        chunk.extend(data);
        chunk.resize(chunk.len().next_multiple_of(2), 0);
        chunk
    };
    let mut header = vec![flags, 0, 0, 0];
    for side in size {
        header.extend(&(side - 1).to_le_bytes()[..3]);
    }
    let mut content = b"WEBP".to_vec();
    content.extend(chunk(b"VP8X", &header));
    // A profile stands before the pixels, EXIF behind them.
    for (kind, data) in chunks.iter().filter(|(kind, _)| *kind == b"ICCP") {
        content.extend(chunk(kind, data));
    }
    content.extend(&webp[12..]);
    for (kind, data) in chunks.iter().filter(|(kind, _)| *kind != b"ICCP") {
        content.extend(chunk(kind, data));
    }
    let mut file = b"RIFF".to_vec();
    file.extend((content.len() as u32).to_le_bytes());
    file.extend(content);
    file
}

/// Values of an entry of a TIFF's directory.
pub enum Values<'a> {
    Bytes(&'a [u8]),
    Shorts(&'a [u16]),
    Long(u32),
}

/// A TIFF of one strip, not compressed, of one byte order or the other; what it needs beside the tags of its size.
pub fn tiff(
    is_big_endian: bool,
    [width, height]: [u16; 2],
    tags: &[(u16, Values<'_>)],
    pixels: &[u8],
) -> Vec<u8> {
    let short = |v: u16| {
        if is_big_endian {
            v.to_be_bytes()
        } else {
            v.to_le_bytes()
        }
    };
    let long = |v: u32| {
        if is_big_endian {
            v.to_be_bytes()
        } else {
            v.to_le_bytes()
        }
    };
    let mut file = if is_big_endian {
        b"MM\0*".to_vec()
    } else {
        b"II*\0".to_vec()
    };
    let count = tags.len() + 6;
    let mut beyond = 8 + 2 + 12 * count as u32 + 4;
    let strip = beyond;
    beyond += pixels.len().next_multiple_of(2) as u32;
    let fixed = [
        (256, Values::Shorts(&[width])),
        (257, Values::Shorts(&[height])),
        (259, Values::Shorts(&[1])),
        (273, Values::Long(strip)),
        (278, Values::Shorts(&[height])),
        (279, Values::Long(pixels.len() as u32)),
    ];
    let mut all: Vec<&(u16, Values<'_>)> = fixed.iter().chain(tags).collect();
    all.sort_by_key(|(tag, _)| *tag);
    file.extend(long(8));
    file.extend(short(count as u16));
    let mut data = Vec::new();
    for (tag, values) in all {
        let (kind, number, bytes) = match values {
            Values::Bytes(bytes) => (7, bytes.len(), bytes.to_vec()),
            Values::Shorts(values) => {
                let bytes: Vec<u8> = values.iter().flat_map(|v| short(*v)).collect();
                (3, values.len(), bytes)
            }
            Values::Long(value) => (4, 1, long(*value).to_vec()),
        };
        file.extend(short(*tag));
        file.extend(short(kind));
        file.extend(long(number as u32));
        if bytes.len() <= 4 {
            let mut field = bytes;
            field.resize(4, 0);
            file.extend(field);
        } else {
            file.extend(long(beyond + data.len() as u32));
            data.extend(bytes);
            data.resize(data.len().next_multiple_of(2), 0);
        }
    }
    file.extend([0; 4]);
    file.extend(pixels);
    file.resize(file.len().next_multiple_of(2), 0);
    file.extend(data);
    file
}

/// A palette as TIFF has it: all reds, greens and blues, of 16 bits, of so many entries.
pub fn color_map(palette: &[[u8; 3]], entries: usize) -> Vec<u16> {
    let value = |k: usize, c: usize| palette.get(k).map_or(0, |entry| u16::from(entry[c]) * 257);
    (0..3)
        .flat_map(|c| (0..entries).map(move |k| value(k, c)))
        .collect()
}

/// Rows of a BMP or TIFF of so many bits a pixel, each filled up to a multiple of `unit` bytes.
pub fn packed_rows(numbers: &[u8], width: usize, bits: usize, unit: usize) -> Vec<Vec<u8>> {
    let pack = |row: &[u8]| {
        let mut bytes = vec![0_u8; (width * bits).div_ceil(8).next_multiple_of(unit)];
        for (x, number) in row.iter().enumerate() {
            bytes[x * bits / 8] |= number << (8 - bits - x * bits % 8);
        }
        bytes
    };
    numbers.chunks(width).map(pack).collect()
}

/// A BMP with a palette, of 1, 4 or 8 bits a pixel; bottom row first, as most are.
pub fn bmp(width: usize, bits: usize, palette: &[[u8; 3]], numbers: &[u8]) -> Vec<u8> {
    let rows = packed_rows(numbers, width, bits, 4);
    let start = 14 + 40 + 4 * palette.len() as u32;
    let pixels: Vec<u8> = rows.into_iter().rev().flatten().collect();
    let mut file = b"BM".to_vec();
    file.extend((start + pixels.len() as u32).to_le_bytes());
    file.extend([0; 4]);
    file.extend(start.to_le_bytes());
    for number in [
        40,
        width as u32,
        (numbers.len() / width) as u32,
        1 | (bits as u32) << 16,
    ] {
        file.extend(number.to_le_bytes());
    }
    for number in [0, 0, 0, 0, palette.len() as u32, 0] {
        file.extend(number.to_le_bytes());
    }
    file.extend(palette.iter().flat_map(|&[r, g, b]| [b, g, r, 0]));
    file.extend(pixels);
    file
}

/// A GIF of two frames, the first with these numbers, of up to 128 palette entries, local to the frame or for all.
pub fn gif(
    width: u16,
    palette: &[[u8; 3]],
    transparent: Option<u8>,
    is_local: bool,
    numbers: &[u8],
) -> Vec<u8> {
    let height = numbers.len() as u16 / width;
    let mut table = palette.as_flattened().to_vec();
    table.resize(3 * 128, 0);
    let size = [width.to_le_bytes(), height.to_le_bytes()].concat();
    let mut file = b"GIF89a".to_vec();
    file.extend(&size);
    file.extend([0xf6, 0, 0]);
    match is_local {
        false => file.extend(&table),
        true => file.extend([9; 3 * 128]),
    }
    let zeros = vec![0; numbers.len()];
    for (frame, numbers) in [numbers, &zeros].into_iter().enumerate() {
        let has = u8::from(transparent.is_some());
        file.extend([0x21, 0xf9, 4, has, 10, 0, transparent.unwrap_or(0), 0]);
        file.extend([0x2c, 0, 0, 0, 0]);
        file.extend(&size);
        let is_own = is_local && frame == 0;
        file.push(if is_own { 0x86 } else { 0 });
        if is_own {
            file.extend(&table);
        }
        file.push(7);
        for block in codes_of(numbers).chunks(255) {
            file.push(block.len() as u8);
            file.extend(block);
        }
        file.push(0);
    }
    file.push(0x3b);
    file
}

/// Numbers below 128 as LZW codes of 8 bits, begun anew before they would grow to 9.
fn codes_of(numbers: &[u8]) -> Vec<u8> {
    const CLEAR: u8 = 0x80;
    let mut codes = Vec::new();
    for run in numbers.chunks(100) {
        codes.push(CLEAR);
        codes.extend(run);
    }
    codes.push(CLEAR + 1);
    codes
}

/// A TGA with a palette of entries of so many bits; bottom row first, as most are. `before` entries are left out.
pub fn tga(
    width: u16,
    entry_bits: u8,
    before: u16,
    palette: &[[u8; 3]],
    numbers: &[u8],
) -> Vec<u8> {
    let mut file = vec![3, 1, 1];
    file.extend(before.to_le_bytes());
    file.extend((palette.len() as u16).to_le_bytes());
    file.push(entry_bits);
    file.extend([0; 4]);
    file.extend(width.to_le_bytes());
    file.extend((numbers.len() as u16 / width).to_le_bytes());
    file.extend([8, 0]);
    file.extend(b"id.");
    for &[r, g, b] in palette {
        match entry_bits {
            15 | 16 => {
                let [r, g, b] = [r, g, b].map(|v| u16::from(v >> 3));
                file.extend((r << 10 | g << 5 | b).to_le_bytes());
            }
            24 => file.extend([b, g, r]),
            _ => file.extend([b, g, r, 255]),
        }
    }
    file.extend(numbers.chunks(usize::from(width)).rev().flatten());
    file
}

/// A JPEG of blocks of 8 × 8 pixels, each of one value a channel, in one row.
pub fn jpeg_of_blocks(blocks: &[&[u8]]) -> Vec<u8> {
    let channels = blocks[0].len();
    let mut file = vec![0xff, 0xd8];
    let mut segment = |marker: u8, content: &[u8]| {
        file.extend([0xff, marker]);
        file.extend((content.len() as u16 + 2).to_be_bytes());
        file.extend(content);
    };
    // The mean of a block, which its transform has eightfold, divided by eight.
    let mut table = [1; 65];
    (table[0], table[1]) = (0, 8);
    segment(0xdb, &table);
    let mut frame = vec![8, 0, 8];
    frame.extend((8 * blocks.len() as u16).to_be_bytes());
    frame.push(channels as u8);
    frame.extend((1..=channels as u8).flat_map(|id| [id, 0x11, 0]));
    segment(0xc0, &frame);
    // Means: twelve codes of four bits, one a number of bits. Others: one code of one bit, the end of the block.
    let mut means = vec![0];
    means.extend([0, 0, 0, 12, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]);
    means.extend(0..12);
    segment(0xc4, &means);
    let mut others = vec![0x10, 1];
    others.extend([0; 15]);
    others.push(0);
    segment(0xc4, &others);
    let mut scan = vec![channels as u8];
    scan.extend((1..=channels as u8).flat_map(|id| [id, 0]));
    scan.extend([0, 63, 0]);
    segment(0xda, &scan);
    file.extend(entropy_coded(blocks, channels));
    file.extend([0xff, 0xd9]);
    file
}

fn entropy_coded(blocks: &[&[u8]], channels: usize) -> Vec<u8> {
    let mut bits: Vec<bool> = Vec::new();
    let mut push = |value: i32, count: u32| {
        bits.extend((0..count).rev().map(|k| value >> k & 1 == 1));
    };
    let mut last = vec![0; channels];
    for block in blocks {
        for (last, value) in last.iter_mut().zip(*block) {
            let mean = i32::from(*value) - 128;
            let step = mean - *last;
            *last = mean;
            let size = 32 - step.unsigned_abs().leading_zeros();
            push(size as i32, 4);
            // Of what is below zero, one less.
            push(if step < 0 { step - 1 } else { step }, size);
            push(0, 1);
        }
    }
    bits.resize(bits.len().next_multiple_of(8), true);
    let bytes = bits
        .chunks(8)
        .map(|byte| byte.iter().fold(0, |sum, &bit| sum << 1 | u8::from(bit)));
    bytes
        .flat_map(|byte| {
            if byte == 0xff {
                vec![0xff, 0]
            } else {
                vec![byte]
            }
        })
        .collect()
}

/// An ICC profile of four inks: a table of two steps an ink, cyan slowest, of Lab as 8 bits have it.
pub fn profile_of_inks(lab: impl Fn([bool; 4]) -> [u8; 3]) -> Vec<u8> {
    let mut table = b"mft1\0\0\0\0\x04\x03\x02\0".to_vec();
    for k in 0..9 {
        let one = if k % 4 == 0 { 0x1_0000_u32 } else { 0 };
        table.extend(one.to_be_bytes());
    }
    table.extend((0..4).flat_map(|_| 0..=255));
    for k in 0..16 {
        table.extend(lab([8, 4, 2, 1].map(|ink| k & ink != 0)));
    }
    table.extend((0..3).flat_map(|_| 0..=255));
    let mut profile = vec![0; 128];
    let length = 128 + 4 + 12 + table.len() as u32;
    profile[..4].copy_from_slice(&length.to_be_bytes());
    profile[8..12].copy_from_slice(&[2, 0x40, 0, 0]);
    profile[12..24].copy_from_slice(b"prtrCMYKLab ");
    profile[36..40].copy_from_slice(b"acsp");
    for (k, value) in [0xf6d6_u32, 0x1_0000, 0xd32d].into_iter().enumerate() {
        profile[68 + 4 * k..72 + 4 * k].copy_from_slice(&value.to_be_bytes());
    }
    profile.extend(1_u32.to_be_bytes());
    profile.extend(b"A2B0");
    profile.extend(144_u32.to_be_bytes());
    profile.extend((table.len() as u32).to_be_bytes());
    profile.extend(table);
    profile
}
