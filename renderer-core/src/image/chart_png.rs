//! A chart as the bytes of a PNG file: of up to 256 colours with a palette, as small and quick as charts of yarns are.

use std::collections::HashMap;
use std::io::{BufRead, Seek};

use png::{BitDepth, ColorType, Compression, Decoder, DeflateCompression, Encoder, Filter};

use super::ImageError;
use crate::design::{ChartImage, TILE};

/// A PNG of a chart, pixel for pixel, with texts (keyword, in Latin letters, and value) for [`png_text`].
///
/// # Errors
/// When the encoder refuses.
pub fn encode_chart_png(chart: &ChartImage, texts: &[(&str, &str)]) -> Result<Vec<u8>, ImageError> {
    let mut file = Vec::new();
    let mut encoder = Encoder::new(&mut file, chart.width() as u32, chart.height() as u32);
    for (keyword, value) in texts {
        encoder.add_itxt_chunk((*keyword).into(), (*value).into())?;
    }
    let palette = palette(chart);
    let bytes = if let Some(palette) = &palette {
        let depth = match palette.colours.len() {
            0..=2 => BitDepth::One,
            3..=4 => BitDepth::Two,
            5..=16 => BitDepth::Four,
            _ => BitDepth::Eight,
        };
        encoder.set_color(ColorType::Indexed);
        encoder.set_depth(depth);
        let rgb = palette.colours.iter().flat_map(|&[r, g, b, _]| [r, g, b]);
        encoder.set_palette(rgb.collect::<Vec<u8>>());
        if palette.colours.iter().any(|colour| colour[3] < 255) {
            let alphas = palette.colours.iter().map(|colour| colour[3]);
            encoder.set_trns(alphas.collect::<Vec<u8>>());
        }
        // Quick, and dithered yarns hardly get smaller with more effort.
        encoder.set_deflate_compression(DeflateCompression::Level(1));
        encoder.set_filter(Filter::NoFilter);
        palette.numbers(chart, depth as usize)
    } else {
        encoder.set_compression(Compression::Fast);
        encoder.set_filter(Filter::Up);
        let mut rgba = Vec::with_capacity(chart.width() * chart.height() * 4);
        for_each_run(chart, |tile, y, width| {
            for x in 0..width {
                rgba.extend(tile.pixel(x, y));
            }
        });
        if rgba.chunks_exact(4).all(|pixel| pixel[3] == 255) {
            encoder.set_color(ColorType::Rgb);
            let mut to = 0;
            for from in (0..rgba.len()).step_by(4) {
                rgba.copy_within(from..from + 3, to);
                to += 3;
            }
            rgba.truncate(to);
        } else {
            encoder.set_color(ColorType::Rgba);
        }
        rgba
    };
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&bytes)?;
    writer.finish()?;
    Ok(file)
}

/// The text with this keyword that stands before the pixels of a PNG; `None` if there is none, or no PNG.
pub fn png_text(file: impl BufRead + Seek, keyword: &str) -> Option<String> {
    let reader = Decoder::new(file).read_info().ok()?;
    let info = reader.info();
    let mut texts = info.utf8_text.iter();
    let text = texts.find(|text| text.keyword == keyword);
    let latin = info.uncompressed_latin1_text.iter();
    let mut latin = latin.filter(|text| text.keyword == keyword);
    match text {
        Some(text) => text.get_text().ok(),
        None => latin.next().map(|text| text.text.clone()),
    }
}

/// Row by row, what of each row lies in each tile: the tile, the row in it, and how many of its pixels lie in the
/// image.
fn for_each_run(chart: &ChartImage, mut run: impl FnMut(&crate::design::Tile, usize, usize)) {
    let [across, _] = chart.tiles();
    for y in 0..chart.height() {
        for tx in 0..across {
            let [width, _] = chart.tile_size(tx, y / TILE);
            run(chart.tile(tx, y / TILE), y % TILE, width);
        }
    }
}

struct Palette {
    colours: Vec<[u8; 4]>,
    number_of: HashMap<[u8; 4], u8>,
}

/// The colours of a chart in the order of its tiles; `None` if they are too many for a palette.
fn palette(chart: &ChartImage) -> Option<Palette> {
    let mut palette = Palette {
        colours: Vec::new(),
        number_of: HashMap::new(),
    };
    let [across, down] = chart.tiles();
    for k in 0..across * down {
        let (colours, _) = chart.tile(k % across, k / across).numbered()?;
        for &colour in colours {
            if palette.number_of.contains_key(&colour) {
                continue;
            }
            let number = u8::try_from(palette.colours.len()).ok()?;
            palette.colours.push(colour);
            palette.number_of.insert(colour, number);
        }
    }
    Some(palette)
}

impl Palette {
    /// The numbers of all pixels, packed into `bits` bits each, rows filled up to whole bytes.
    fn numbers(&self, chart: &ChartImage, bits: usize) -> Vec<u8> {
        let [across, down] = chart.tiles();
        // From a tile's numbers to the file's.
        let translations: Vec<Vec<u8>> = (0..across * down)
            .map(|k| {
                let listed = chart.tile(k % across, k / across).numbered();
                let colours = listed.map_or(&[][..], |(colours, _)| colours);
                colours
                    .iter()
                    .map(|colour| self.number_of[colour])
                    .collect()
            })
            .collect();
        let per_byte = 8 / bits;
        let mut bytes = Vec::with_capacity(chart.width().div_ceil(per_byte) * chart.height());
        let mut row = Vec::with_capacity(chart.width());
        for y in 0..chart.height() {
            row.clear();
            for tx in 0..across {
                let [width, _] = chart.tile_size(tx, y / TILE);
                let translation = &translations[y / TILE * across + tx];
                if let Some((_, numbers)) = chart.tile(tx, y / TILE).numbered() {
                    let part = &numbers[y % TILE * TILE..][..width];
                    row.extend(part.iter().map(|&number| translation[usize::from(number)]));
                }
            }
            bytes.extend(row.chunks(per_byte).map(|pixels| {
                let shifted = pixels.iter().enumerate();
                shifted.fold(0, |byte, (k, &number)| {
                    byte | number << (8 - bits * (k + 1))
                })
            }));
        }
        bytes
    }
}
