//! PNG files that tests put together.

use std::io::Write;

/// A PNG's bytes with chunks inserted behind its header: the signature has 8 bytes, IHDR 12 and 13 of content.
pub fn with_chunks(mut png: Vec<u8>, chunks: &[Vec<u8>]) -> Vec<u8> {
    png.splice(33..33, chunks.concat());
    png
}

/// A chunk: length, type, data, checksum.
pub fn chunk(kind: &[u8; 4], data: &[u8]) -> Vec<u8> {
    let mut chunk = (data.len() as u32).to_be_bytes().to_vec();
    chunk.extend(kind);
    chunk.extend(data);
    chunk.extend(crc32fast::hash(&chunk[4..]).to_be_bytes());
    chunk
}

/// Data as zlib has it.
pub fn deflated(data: &[u8]) -> Vec<u8> {
    let level = flate2::Compression::fast();
    let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), level);
    encoder.write_all(data).unwrap();
    encoder.finish().unwrap()
}

/// A PNG with a palette and pixels of 8 bits, row by row.
pub fn indexed(width: u32, palette: &[[u8; 3]], alphas: &[u8], numbers: &[u8]) -> Vec<u8> {
    let height = numbers.len() as u32 / width;
    let mut header = [width.to_be_bytes(), height.to_be_bytes()].concat();
    header.extend([8, 3, 0, 0, 0]);
    let rows = numbers.chunks(width as usize);
    let data: Vec<u8> = rows.flat_map(|row| [&[0][..], row].concat()).collect();
    let mut png = b"\x89PNG\r\n\x1a\n".to_vec();
    png.extend(chunk(b"IHDR", &header));
    png.extend(chunk(b"PLTE", palette.as_flattened()));
    if !alphas.is_empty() {
        png.extend(chunk(b"tRNS", alphas));
    }
    png.extend(chunk(b"IDAT", &deflated(&data)));
    png.extend(chunk(b"IEND", &[]));
    png
}

/// Gives every chunk the checksum that its data has, as far as chunks can be told.
pub fn with_right_checksums(mut png: Vec<u8>) -> Vec<u8> {
    let mut at = 8;
    while let Some(header) = png.get(at..).and_then(|rest| rest.first_chunk::<4>()) {
        let end = at + 8 + u32::from_be_bytes(*header) as usize;
        let Some(checked) = png.get(at + 4..end) else {
            break;
        };
        let checksum = crc32fast::hash(checked).to_be_bytes();
        match png.get_mut(end..end + 4) {
            Some(place) => place.copy_from_slice(&checksum),
            None => break,
        }
        at = end + 4;
    }
    png
}
