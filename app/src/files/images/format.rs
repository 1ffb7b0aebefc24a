//! Which format the bytes of a picture are, by their content, whatever the file is called.

use image::ImageFormat;

/// Formats of pictures of colours, for messages.
pub(super) const FLAT_NAMES: &str = "PNG, JPEG, WebP, GIF, BMP, TIFF, TGA and PPM";

/// A format that is read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Format {
    /// Colours as displayed.
    Flat(ImageFormat),
    /// Radiance HDR: light.
    Hdr,
    /// OpenEXR: light.
    Exr,
}

/// Formats that others write and that are not read: what each begins with, from which byte on, and its name.
const FOREIGN: [(usize, &[u8], &str); 12] = [
    (4, b"ftyphei", "an HEIC picture"),
    (4, b"ftypmif1", "an HEIF picture"),
    (4, b"ftypavi", "an AVIF picture"),
    (0, b"\xff\x0a", "a JPEG XL picture"),
    (0, b"\0\0\0\x0cJXL ", "a JPEG XL picture"),
    (0, b"\0\0\0\x0cjP  ", "a JPEG 2000 picture"),
    (0, b"8BPS", "a Photoshop file"),
    (0, b"gimp xcf", "a GIMP file"),
    (0, b"\0\0\x01\0", "an icon"),
    (0, b"%PDF", "a PDF file"),
    (0, b"<svg", "an SVG drawing"),
    (0, b"PK\x03\x04", "a zip archive"),
];

/// The format of a picture; else what it is, if that is known.
pub(super) fn of(bytes: &[u8]) -> Result<Format, Option<&'static str>> {
    // Any program may write its name behind these two, and RGBE is what many call themselves.
    if bytes.starts_with(b"#?") {
        return Ok(Format::Hdr);
    }
    match image::guess_format(bytes).ok() {
        Some(ImageFormat::OpenExr) => Ok(Format::Exr),
        Some(
            format @ (ImageFormat::Png
            | ImageFormat::Jpeg
            | ImageFormat::WebP
            | ImageFormat::Gif
            | ImageFormat::Bmp
            | ImageFormat::Tiff
            | ImageFormat::Pnm),
        ) => Ok(Format::Flat(format)),
        _ if is_tga(bytes) => Ok(Format::Flat(ImageFormat::Tga)),
        _ => Err(FOREIGN
            .iter()
            .find(|(from, start, _)| bytes.get(*from..).is_some_and(|b| b.starts_with(start)))
            .map(|(_, _, name)| *name)),
    }
}

/// Whether the bytes begin with a header as TGA has it, the one format here without a signature: kinds of pictures and
/// of pixels that exist, and no palette where none belongs.
fn is_tga(bytes: &[u8]) -> bool {
    let Some(
        &[
            _,
            map,
            kind,
            m0,
            m1,
            m2,
            m3,
            map_bits,
            _,
            _,
            _,
            _,
            w0,
            w1,
            h0,
            h1,
            bits,
            flags,
        ],
    ) = bytes.first_chunk::<18>()
    else {
        return false;
    };
    let has_map = match map {
        0 => [m0, m1, m2, m3, map_bits] == [0; 5],
        1 => [m2, m3] != [0; 2] && [15, 16, 24, 32].contains(&map_bits),
        _ => false,
    };
    let fits = match kind {
        1 | 9 => map == 1 && [8, 16].contains(&bits),
        2 | 10 => [15, 16, 24, 32].contains(&bits),
        3 | 11 => [8, 16].contains(&bits),
        _ => false,
    };
    has_map && fits && [w0, w1] != [0; 2] && [h0, h1] != [0; 2] && flags & 0xc0 == 0
}
