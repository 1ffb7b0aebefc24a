//! Pictures without what their files say beside the pixels: where and when a photograph was taken, by whom, from which
//! file on whose machine, and the design that a picture of ours carries. Colour profiles stay, for they are needed, and
//! so does which way is up.

use image::metadata::Orientation;

use super::input::PNG;

/// The file without that, of a PNG or a JPEG; others, and what is broken, as they are.
pub(super) fn stripped(file: &[u8]) -> Vec<u8> {
    let stripped = if file.starts_with(&PNG) {
        strip_png(file)
    } else if file.starts_with(b"\xff\xd8") {
        strip_jpeg(file)
    } else {
        None
    };
    stripped.unwrap_or_else(|| file.to_vec())
}

/// Whether a chunk of a PNG says nothing of its pixels.
fn is_beside_pixels(kind: &[u8]) -> bool {
    matches!(kind, b"tEXt" | b"zTXt" | b"iTXt" | b"tIME" | b"toWl")
}

fn strip_png(file: &[u8]) -> Option<Vec<u8>> {
    let mut kept = PNG.to_vec();
    let mut rest = &file[PNG.len()..];
    loop {
        let length = u32::from_be_bytes(rest.get(..4)?.try_into().ok()?);
        let (kind, end) = (rest.get(4..8)?, (length as usize).checked_add(12)?);
        let chunk = rest.get(..end)?;
        if kind == b"eXIf" {
            if let Some(exif) = upright(&chunk[8..end - 4]) {
                let start = kept.len() + 4;
                kept.extend((exif.len() as u32).to_be_bytes());
                kept.extend(b"eXIf");
                kept.extend(exif);
                let checksum = crc32fast::hash(&kept[start..]);
                kept.extend(checksum.to_be_bytes());
            }
        } else if !is_beside_pixels(kind) {
            kept.extend(chunk);
        }
        if kind == b"IEND" {
            return Some(kept);
        }
        rest = &rest[end..];
    }
}

/// What an EXIF segment of a JPEG begins with.
const EXIF: &[u8] = b"Exif\0\0";

/// EXIF that says no more than which way is up; `None` where that is as the pixels are.
fn upright(exif: &[u8]) -> Option<Vec<u8>> {
    let orientation = Orientation::from_exif_chunk(exif)?;
    if orientation == Orientation::NoTransforms {
        return None;
    }
    // A little-endian TIFF header, one directory at 8 with one entry: 0x0112, one short, its value; no directory more.
    let mut tiff = b"II*\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0".to_vec();
    tiff.extend([orientation.to_exif(), 0, 0, 0, 0, 0, 0, 0]);
    Some(tiff)
}

/// Of the segments of applications only those are kept that say how the pixels are meant: JFIF, ICC, Adobe.
fn strip_jpeg(file: &[u8]) -> Option<Vec<u8>> {
    let mut kept = file[..2].to_vec();
    let mut rest = &file[2..];
    loop {
        let marker = *rest.get(1).filter(|_| rest[0] == 0xff)?;
        if marker == 0xda {
            // The pixels, up to the end of the picture; cameras write more behind it.
            let end = rest.windows(2).position(|pair| pair == b"\xff\xd9")?;
            kept.extend(&rest[..end + 2]);
            return Some(kept);
        }
        let length = u16::from_be_bytes(rest.get(2..4)?.try_into().ok()?);
        let segment = rest.get(..2 + usize::from(length))?;
        let exif = segment.get(4..).and_then(|data| data.strip_prefix(EXIF));
        if let (0xe1, Some(exif)) = (marker, exif.and_then(upright)) {
            kept.extend([0xff, 0xe1]);
            kept.extend(((2 + EXIF.len() + exif.len()) as u16).to_be_bytes());
            kept.extend(EXIF);
            kept.extend(exif);
        } else if !matches!(marker, 0xe1 | 0xe3..=0xed | 0xef | 0xfe) {
            kept.extend(segment);
        }
        rest = &rest[segment.len()..];
    }
}
