//! Picture files written while the picture is made: rows go in from top to bottom, and no more of them are in memory
//! than were made at once.

use std::borrow::Borrow;
use std::io::{Seek, Write};

use exr::block::writer::ChunksWriter;
use exr::block::{BlockIndex, UncompressedBlock};
use exr::meta::BlockDescription;
use exr::meta::attribute::{ChannelDescription, LineOrder, SampleType};
use exr::meta::header::Header;
use exr::prelude::{Compression, Vec2};
use png::chunk::ChunkType;

use super::files::exr_channels;
use super::{About, Aov, Background, Depth, Display, ExrLayer, ImageError, Picture};

/// How a PNG shows a picture.
#[derive(Debug, Clone, Copy)]
pub struct PngLook<'a> {
    /// From linear light to what is shown.
    pub display: Display,
    /// Bits a channel.
    pub depth: Depth,
    /// Leaves this background out; then there is an alpha channel.
    pub transparent: Option<Background>,
    /// What the file says of the picture.
    pub about: &'a About,
    /// Whole chunks (length, type, data, checksum) to stand behind the header: what the file carries beside the
    /// picture.
    pub chunks: &'a [Vec<u8>],
}

/// Writes a PNG from the pictures that `next` gives: rows from the top, all `size[0]` wide, together `size[1]` high.
///
/// # Errors
/// What `next` says, or when the file refuses.
pub fn write_png_rows<P: Borrow<Picture>, E: From<ImageError>>(
    file: impl Write,
    size: [u32; 2],
    look: &PngLook<'_>,
    mut next: impl FnMut() -> Result<P, E>,
) -> Result<(), E> {
    let refused = |error: png::EncodingError| E::from(ImageError::from(error));
    let mut encoder = png::Encoder::new(file, size[0], size[1]);
    encoder.set_color(match look.transparent {
        Some(_) => png::ColorType::Rgba,
        None => png::ColorType::Rgb,
    });
    encoder.set_depth(match look.depth {
        Depth::Eight => png::BitDepth::Eight,
        Depth::Sixteen => png::BitDepth::Sixteen,
    });
    look.about.describe_png(&mut encoder)?;
    // What more would take off a large noisy picture costs minutes.
    encoder.set_compression(png::Compression::Fast);
    let mut writer = encoder.write_header().map_err(refused)?;
    for chunk in look.chunks {
        let (Some(kind), true) = (chunk.get(4..8), chunk.len() >= 12) else {
            return Err(ImageError::Rows("a chunk of the picture is too short").into());
        };
        let kind = ChunkType([kind[0], kind[1], kind[2], kind[3]]);
        let written = writer.write_chunk(kind, &chunk[8..chunk.len() - 4]);
        written.map_err(refused)?;
    }
    let mut stream = writer.stream_writer().map_err(refused)?;
    let mut top = 0;
    while top < size[1] {
        let rows = next()?;
        let rows = rows.borrow();
        if rows.size[0] != size[0] || rows.size[1] == 0 {
            return Err(OTHER_PICTURE.into());
        }
        for row in rows.pixels.chunks(size[0] as usize) {
            let written = stream.write_all(&look.bytes(row));
            written.map_err(|error| refused(error.into()))?;
        }
        top += rows.size[1];
    }
    stream.finish().map_err(refused)?;
    writer.finish().map_err(refused)
}

/// Rows that do not fit their header.
const OTHER_PICTURE: ImageError = ImageError::Rows("the rows belong to a picture of another size");

impl PngLook<'_> {
    fn bytes(&self, pixels: &[[f32; 4]]) -> Vec<u8> {
        let mut values: Vec<f64> = Vec::with_capacity(4 * pixels.len());
        for &[r, g, b, alpha] in pixels {
            match self.transparent {
                None => values.extend(self.display.encode([r, g, b])),
                Some(background) => {
                    let cloth = background.removed([r, g, b], alpha);
                    let straight = cloth.map(|c| if alpha > 0.0 { c / alpha } else { 0.0 });
                    values.extend(self.display.encode(straight));
                    values.push(f64::from(alpha).clamp(0.0, 1.0));
                }
            }
        }
        // Values are in [0, 1], or NaN, which `as` makes 0.
        match self.depth {
            Depth::Eight => values.iter().map(|v| (v * 255.0).round() as u8).collect(),
            Depth::Sixteen => values
                .iter()
                .flat_map(|v| ((v * 65535.0).round() as u16).to_be_bytes())
                .collect(),
        }
    }
}

/// What an OpenEXR file holds.
#[derive(Debug, Clone)]
pub struct ExrLook {
    /// Extra channels.
    pub layers: Vec<ExrLayer>,
    /// Leaves this background out; then there is an alpha channel.
    pub transparent: Option<Background>,
    /// What the file says of the picture.
    pub about: About,
}

/// Rows that an OpenEXR file holds together: pictures that are added must have a multiple of it, but for the last.
pub const EXR_BLOCK_ROWS: u32 = 16;

/// Writes an OpenEXR file of linear radiance, with the channels of [`super::encode_exr`], from the pictures that `next` gives:
/// rows from the top, all `size[0]` wide, together `size[1]` high.
///
/// # Errors
/// What `next` says, or when the file refuses.
pub fn write_exr_rows<E: From<ImageError>>(
    file: impl Write + Seek,
    size: [u32; 2],
    look: &ExrLook,
    mut next: impl FnMut() -> Result<Picture, E>,
) -> Result<(), E> {
    let [width, height] = size.map(|side| side as usize);
    // The names are those of a picture that has everything.
    let everything = Picture {
        aov: Some(Aov::default()),
        ..Picture::default()
    };
    let mut names: Vec<&str> = exr_channels(&everything, &look.layers, look.transparent)
        .into_iter()
        .map(|(name, _)| name)
        .collect();
    names.sort_unstable();
    let channels = names
        .iter()
        .map(|name| ChannelDescription::named(*name, SampleType::F32))
        .collect();
    let mut header = Header::new("".into(), (width, height), channels).with_encoding(
        Compression::ZIP16,
        BlockDescription::ScanLines,
        LineOrder::Increasing,
    );
    look.about.describe_exr(&mut header);
    let mut failed = None;
    let written = exr::block::write(
        file,
        [header].into_iter().collect(),
        true,
        |meta, chunks| {
            let mut compressor = chunks.sequential_blocks_compressor(&meta);
            let (mut top, mut block) = (0, 0);
            while top < height {
                let rows = match next() {
                    Ok(rows) => rows,
                    Err(error) => {
                        failed = Some(error);
                        return Err(exr::error::Error::Aborted);
                    }
                };
                let mut values = exr_channels(&rows, &look.layers, look.transparent);
                values.sort_unstable_by_key(|(name, _)| *name);
                let count = rows.size[1] as usize;
                if rows.size[0] as usize != width || count == 0 || values.len() != names.len() {
                    failed = Some(OTHER_PICTURE.into());
                    return Err(exr::error::Error::Aborted);
                }
                for first in (0..count).step_by(EXR_BLOCK_ROWS as usize) {
                    let end = (first + EXR_BLOCK_ROWS as usize).min(count);
                    let mut data = Vec::with_capacity((end - first) * width * names.len() * 4);
                    for row in first..end {
                        for (_, values) in &values {
                            for value in &values[row * width..(row + 1) * width] {
                                data.extend(value.to_ne_bytes());
                            }
                        }
                    }
                    let index = BlockIndex {
                        layer: 0,
                        pixel_position: Vec2(0, top + first),
                        pixel_size: Vec2(width, end - first),
                        level: Vec2(0, 0),
                    };
                    compressor.compress_block(block, UncompressedBlock { index, data })?;
                    block += 1;
                }
                top += count;
            }
            Ok(())
        },
    );
    match (failed, written) {
        (Some(error), _) => Err(error),
        (None, written) => written.map_err(|error| ImageError::from(error).into()),
    }
}
