//! Radiance pictures (`.hdr`, `.pic`, `.xyze`): lines of text, then pixels of four bytes with a shared exponent.
//!
//! As Radiance's manual and its program `ra_xyze` have them: EXPOSURE and COLORCORR say what values were multiplied by,
//! each line once more; XYZE holds X, Y, Z whose white is that of equal energy; the line before the pixels names the
//! axes, the slower first.

use glam::{DMat3, DVec3};
use renderer_core::design::{EnvironmentFault, EnvironmentImage, EnvironmentReader};

use super::primaries::{Primaries, srgb_of_xyz};

/// Widths of rows that may be coded by channel; others are not, whatever they begin with.
const CODED_WIDTHS: std::ops::Range<usize> = 8..0x8000;

/// Reads the surroundings from a file.
///
/// # Errors
/// When it is broken or of another size, as the end of a sentence.
pub(super) fn read(bytes: &[u8], notes: &mut Vec<String>) -> Result<EnvironmentImage, String> {
    let why = |fault: EnvironmentFault| fault.to_string();
    let mut bytes = Bytes(bytes);
    let header = Header::read(&mut bytes, notes)?;
    let axes = Axes::read(&bytes.line().ok_or_else(cut_header)?)?;
    let mut environment = EnvironmentReader::new(axes.width, axes.height).map_err(why)?;
    let (lines, length) = axes.lines();
    let mut line = vec![[0; 4]; length];
    for k in 0..lines {
        let what = |what| format!("is broken: line {} of its pixels {what}", k + 1);
        read_line(&mut bytes, &mut line).map_err(what)?;
        for (along, pixel) in line.iter().enumerate() {
            let [x, y] = axes.place(k, along);
            environment.add(x, y, header.colour(value_of(*pixel)));
        }
    }
    environment.finish().map_err(why)
}

fn cut_header() -> String {
    "is broken: it ends in its header".into()
}

/// Red, green and blue (or X, Y, Z) of a pixel.
fn value_of([r, g, b, exponent]: [u8; 4]) -> [f32; 3] {
    if exponent == 0 {
        return [0.0; 3];
    }
    // The exponent is off by 128, and the others are 256ths.
    let unit = f64::from(i32::from(exponent) - 136).exp2() as f32;
    [r, g, b].map(|value| f32::from(value) * unit)
}

/// What the lines of text say.
struct Header {
    /// From the file's values to linear sRGB, where they are not the same.
    matrix: Option<DMat3>,
}

impl Header {
    fn read(bytes: &mut Bytes<'_>, notes: &mut Vec<String>) -> Result<Self, String> {
        let mut multiplied = DVec3::ONE;
        let mut primaries = None;
        let mut is_xyz = false;
        let mut is_first = true;
        loop {
            let line = bytes.line().ok_or_else(cut_header)?;
            if line.is_empty() {
                break;
            }
            let Some((name, value)) = line.split_once('=').filter(|_| !is_first) else {
                is_first = false;
                continue;
            };
            let value = value.trim();
            match name.trim() {
                "FORMAT" => is_xyz = is_xyze(value)?,
                "EXPOSURE" => multiplied *= factors::<1>(name, value)?[0],
                "COLORCORR" => multiplied *= DVec3::from(factors::<3>(name, value)?),
                "PRIMARIES" => primaries = Some(value.to_owned()),
                _ => {}
            }
        }
        let colours = match primaries {
            _ if is_xyz => srgb_of_xyz(),
            None => None,
            Some(text) => {
                let primaries = numbers::<8>(&text).map(|[rx, ry, gx, gy, bx, by, wx, wy]| {
                    Primaries([[rx, ry], [gx, gy], [bx, by], [wx, wy]])
                });
                let matrix = primaries.and_then(Primaries::to_srgb);
                if matrix.is_none() {
                    notes.push(format!(
                        "has PRIMARIES={text}, which are those of no colours: they are taken as those of sRGB"
                    ));
                }
                matrix.filter(|_| !primaries.is_some_and(|primaries| primaries.is_srgb()))
            }
        };
        let is_plain = colours.is_none() && multiplied == DVec3::ONE;
        let divided = DMat3::from_diagonal(multiplied.recip());
        Ok(Self {
            matrix: (!is_plain).then(|| colours.unwrap_or(DMat3::IDENTITY) * divided),
        })
    }

    fn colour(&self, value: [f32; 3]) -> [f32; 3] {
        match self.matrix {
            None => value,
            Some(matrix) => (matrix * DVec3::from(value.map(f64::from)))
                .to_array()
                .map(|c| c as f32),
        }
    }
}

/// Whether a format is XYZ.
fn is_xyze(format: &str) -> Result<bool, String> {
    match format {
        "32-bit_rle_rgbe" => Ok(false),
        "32-bit_rle_xyze" => Ok(true),
        other => Err(format!(
            "has FORMAT={other}, allowed are 32-bit_rle_rgbe and 32-bit_rle_xyze"
        )),
    }
}

/// Numbers with spaces between.
fn numbers<const N: usize>(text: &str) -> Option<[f64; N]> {
    let numbers = text.split_whitespace().map(str::parse);
    let numbers: Vec<f64> = numbers.collect::<Result<_, _>>().ok()?;
    numbers.try_into().ok()
}

/// Factors above zero.
fn factors<const N: usize>(name: &str, text: &str) -> Result<[f64; N], String> {
    // Beyond these no picture is seen, and dividing by them leaves the numbers there are.
    let is_factor = |factor: &f64| (1e-30..=1e30).contains(factor);
    numbers(text)
        .filter(|factors: &[f64; N]| factors.iter().all(is_factor))
        .ok_or_else(|| {
            let allowed = match N {
                1 => "a number above 0".to_owned(),
                n => format!("{n} numbers above 0"),
            };
            format!("is broken: its header has {name}={text}, allowed is {allowed}")
        })
}

/// Size, and which way the pixels go.
struct Axes {
    width: usize,
    height: usize,
    /// Whether lines are columns.
    by_columns: bool,
    /// Whether x falls from pixel to pixel, or y rises.
    is_mirrored: bool,
    is_upside_down: bool,
}

impl Axes {
    /// From `-Y 512 +X 1024` and its kin.
    fn read(line: &str) -> Result<Self, String> {
        let unknown = || {
            format!(
                "is broken: its size is given as \"{line}\", allowed are such as \"-Y 512 +X 1024\""
            )
        };
        let words: Vec<&str> = line.split_whitespace().collect();
        let &[first, a, second, b] = words.as_slice() else {
            return Err(unknown());
        };
        let a: usize = a.parse().map_err(|_| unknown())?;
        let b: usize = b.parse().map_err(|_| unknown())?;
        let by_columns = first.ends_with('X');
        let (y, x, height, width) = match by_columns {
            false => (first, second, a, b),
            true => (second, first, b, a),
        };
        let sign = |axis: &str, positive: &str, negative: &str| match axis {
            axis if axis == positive => Ok(true),
            axis if axis == negative => Ok(false),
            _ => Err(unknown()),
        };
        Ok(Self {
            width,
            height,
            by_columns,
            is_mirrored: !sign(x, "+X", "-X")?,
            is_upside_down: sign(y, "+Y", "-Y")?,
        })
    }

    /// How many lines there are, and their length.
    fn lines(&self) -> (usize, usize) {
        match self.by_columns {
            false => (self.height, self.width),
            true => (self.width, self.height),
        }
    }

    /// Column and row, from the upper left, of the pixel so far along a line.
    fn place(&self, line: usize, along: usize) -> [usize; 2] {
        let [x, y] = match self.by_columns {
            false => [along, line],
            true => [line, along],
        };
        let turned = |is_turned: bool, at: usize, size: usize| match is_turned {
            true => size - 1 - at,
            false => at,
        };
        [
            turned(self.is_mirrored, x, self.width),
            turned(self.is_upside_down, y, self.height),
        ]
    }
}

/// What is left of a file.
struct Bytes<'a>(&'a [u8]);

impl<'a> Bytes<'a> {
    /// The next line of text, without its end.
    fn line(&mut self) -> Option<String> {
        let end = self.0.iter().position(|&byte| byte == b'\n')?;
        let line = self.take(end + 1)?;
        Some(String::from_utf8_lossy(line).trim_end().to_owned())
    }

    fn take(&mut self, length: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.0.split_at_checked(length)?;
        self.0 = rest;
        Some(taken)
    }

    fn byte(&mut self) -> Option<u8> {
        self.take(1).map(|bytes| bytes[0])
    }

    fn pixel(&mut self) -> Option<[u8; 4]> {
        self.take(4)?.try_into().ok()
    }
}

const CUT: &str = "is cut off";
const TOO_LONG: &str = "is longer than the picture is wide";

/// Reads a line of pixels.
fn read_line(bytes: &mut Bytes<'_>, line: &mut [[u8; 4]]) -> Result<(), &'static str> {
    if CODED_WIDTHS.contains(&line.len())
        && let Some(&[2, 2, high @ ..0x80, low]) = bytes.0.first_chunk()
    {
        if usize::from(u16::from_be_bytes([high, low])) != line.len() {
            return Err("has another length");
        }
        bytes.0 = &bytes.0[4..];
        return (0..4).try_for_each(|channel| read_channel(bytes, line, channel));
    }
    read_plain(bytes, line)
}

/// One channel of a line: runs, of a byte more than 128 less than they are long, and bytes as they are.
fn read_channel(
    bytes: &mut Bytes<'_>,
    line: &mut [[u8; 4]],
    channel: usize,
) -> Result<(), &'static str> {
    let mut at = 0;
    while at < line.len() {
        let code = usize::from(bytes.byte().ok_or(CUT)?);
        let length = if code > 128 { code - 128 } else { code };
        let pixels = line.get_mut(at..at + length).ok_or(TOO_LONG)?;
        if length == 0 {
            return Err("has a run of no pixels");
        }
        if code > 128 {
            let value = bytes.byte().ok_or(CUT)?;
            pixels.iter_mut().for_each(|pixel| pixel[channel] = value);
        } else {
            let values = bytes.take(length).ok_or(CUT)?;
            for (pixel, value) in pixels.iter_mut().zip(values) {
                pixel[channel] = *value;
            }
        }
        at += length;
    }
    Ok(())
}

/// A line of pixels one after the other, in which 1, 1, 1, n repeats the last one n times; a second such n counts 256
/// times as much, and so on.
fn read_plain(bytes: &mut Bytes<'_>, line: &mut [[u8; 4]]) -> Result<(), &'static str> {
    let (mut at, mut shift) = (0, 0);
    while at < line.len() {
        let pixel = bytes.pixel().ok_or(CUT)?;
        let [1, 1, 1, count] = pixel else {
            line[at] = pixel;
            (at, shift) = (at + 1, 0);
            continue;
        };
        let last = at.checked_sub(1).ok_or("begins with a repetition")?;
        let count = usize::from(count).checked_shl(shift).ok_or(TOO_LONG)?;
        let last = line[last];
        line.get_mut(at..at.saturating_add(count))
            .ok_or(TOO_LONG)?
            .fill(last);
        at += count;
        shift = (shift + 8).min(32);
    }
    Ok(())
}
