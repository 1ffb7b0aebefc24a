//! What PNG files say beside their pixels.

use super::primaries::Primaries;

/// What a PNG begins with.
const SIGNATURE: [u8; 8] = *b"\x89PNG\r\n\x1a\n";

/// A chunk of a PNG.
#[derive(Debug, Clone, Copy)]
pub(super) struct Chunk<'a> {
    /// Its type.
    pub(super) kind: [u8; 4],
    /// Where its data begins in the file.
    pub(super) start: usize,
    /// Its data.
    pub(super) data: &'a [u8],
}

/// The chunks of a PNG, as far as they are whole.
fn chunks(bytes: &[u8]) -> impl Iterator<Item = Chunk<'_>> {
    let mut at = SIGNATURE.len();
    std::iter::from_fn(move || {
        let header = bytes.get(at..)?.first_chunk::<8>()?;
        let [l0, l1, l2, l3, kind @ ..] = *header;
        let length = u32::from_be_bytes([l0, l1, l2, l3]) as usize;
        let start = at + header.len();
        let data = bytes.get(start..start.checked_add(length)?)?;
        // Behind the data stands its checksum.
        at = start + length + 4;
        Some(Chunk { kind, start, data })
    })
}

/// The first chunk of a type.
pub(super) fn chunk(bytes: &[u8], kind: [u8; 4]) -> Option<Chunk<'_>> {
    chunks(bytes).find(|chunk| chunk.kind == kind)
}

/// The file with other data, as long as it was, in a chunk.
pub(super) fn with_data(bytes: &[u8], chunk: &Chunk<'_>, data: &[u8]) -> Vec<u8> {
    let mut file = bytes.to_vec();
    let end = chunk.start + data.len();
    file[chunk.start..end].copy_from_slice(data);
    let checksum = crc32fast::hash(&file[chunk.start - 4..end]);
    if let Some(place) = file.get_mut(end..end + 4) {
        place.copy_from_slice(&checksum.to_be_bytes());
    }
    file
}

/// What a PNG says of its colours other than by a profile, where that is to be heeded.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Described {
    /// Nothing, or that they are sRGB.
    Srgb,
    /// Code points of ITU-T H.273 for primaries, transfer characteristics, matrix, and whether the range is full.
    CodePoints([u8; 4]),
    /// A profile stands in the file.
    Profile,
    /// Chromaticities, and the exponent by which light was encoded.
    Encoded {
        primaries: Option<Primaries>,
        exponent: Option<f64>,
    },
}

/// What the chunks before the pixels say of the colours, the weightiest first as the format has it.
pub(super) fn described(bytes: &[u8]) -> Described {
    let before_pixels = || chunks(bytes).take_while(|chunk| chunk.kind != *b"IDAT");
    let find = |kind: [u8; 4]| before_pixels().find(|chunk| chunk.kind == kind);
    if let Some(points) = find(*b"cICP").and_then(|chunk| chunk.data.try_into().ok()) {
        return Described::CodePoints(points);
    }
    if find(*b"iCCP").is_some() {
        return Described::Profile;
    }
    if find(*b"sRGB").is_some() {
        return Described::Srgb;
    }
    let numbers = |kind| {
        let data = find(kind)?.data;
        let numbers = data.chunks_exact(4).map(|bytes| {
            let number = bytes
                .iter()
                .fold(0, |sum, &byte| sum << 8 | u32::from(byte));
            f64::from(number) / 100_000.0
        });
        Some(numbers.collect::<Vec<f64>>())
    };
    let exponent = match numbers(*b"gAMA").as_deref() {
        Some(&[exponent]) if !is_near_srgb(exponent) => Some(exponent),
        _ => None,
    };
    let primaries = match numbers(*b"cHRM").as_deref() {
        Some(&[wx, wy, rx, ry, gx, gy, bx, by]) => {
            Some(Primaries([[rx, ry], [gx, gy], [bx, by], [wx, wy]]))
        }
        _ => None,
    };
    if exponent.is_none() && primaries.is_none() {
        return Described::Srgb;
    }
    Described::Encoded {
        primaries,
        exponent,
    }
}

/// Whether an exponent is the one that programs write for sRGB, whose curve is no power: within a twentieth of 1/2.2,
/// as the format's reference library has it.
fn is_near_srgb(exponent: f64) -> bool {
    (exponent * 2.2 - 1.0).abs() < 0.05
}
