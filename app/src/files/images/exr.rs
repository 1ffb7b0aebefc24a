//! OpenEXR pictures of the surroundings: which channels are their colours, and where the pixels of the data window lie
//! in the display window, which is what the picture shows.

use std::io::{self, BufRead, Seek};

use exr::error::Error;
use exr::meta::header::Header;
use exr::prelude::{self, MetaData, ReadChannels, ReadLayers, ReadSpecificChannel, Text, Vec2};
use glam::{DMat3, DVec3};
use renderer_core::design::{EnvironmentFault, EnvironmentImage, EnvironmentReader};

use super::primaries::Primaries;

/// Most columns of a data window, half as many rows: overscan of the largest picture by half on every side.
const MOST_COLUMNS: usize = 2 * EnvironmentImage::MAX_WIDTH;

/// Most channels that a message lists.
const MOST_LISTED: usize = 12;

/// Reads the surroundings from a file: red, green and blue of its first layer that has them, else its luminance. Alpha
/// is left out. Blender's passes count as layers, and of them its finished picture, `Combined`, as the first.
///
/// # Errors
/// When it is broken, of another size or has no such channels, as the end of a sentence.
pub(super) fn read<R: BufRead + Seek + Send>(
    open: impl Fn() -> io::Result<R>,
) -> Result<EnvironmentImage, String> {
    let open = || open().map_err(|error| format!("cannot be read: {error}"));
    // Asked first: decoding what is too large would take its time.
    let headers = MetaData::read_from_buffered(open()?, false)
        .map_err(|error| why(&error))?
        .headers;
    let [header, ..] = headers.as_slice() else {
        return Err("is broken: it has no layers".into());
    };
    let Vec2(width, height) = header.shared_attributes.display_window.size;
    EnvironmentImage::check_size(width, height).map_err(|fault| fault.to_string())?;
    let (layer, colours) = Colours::find(&headers)?;
    let window = Window::new(layer)?;
    let new = move || EnvironmentReader::new(width, height);
    let channels = prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .specific_channels();
    let picture = match colours {
        Colours::Rgb([r, g, b]) => channels
            .required(r)
            .required(g)
            .required(b)
            .collect_pixels(
                move |_, _| new(),
                move |picture, at, (r, g, b): (f32, f32, f32)| window.add(picture, at, [r, g, b]),
            )
            .first_valid_layer()
            .all_attributes()
            .from_buffered(open()?)
            .map(|image| image.layer_data.channel_data.pixels),
        Colours::Luminance(y) => channels
            .required(y)
            .collect_pixels(
                move |_, _| new(),
                move |picture, at, (y,): (f32,)| window.add(picture, at, [y; 3]),
            )
            .first_valid_layer()
            .all_attributes()
            .from_buffered(open()?)
            .map(|image| image.layer_data.channel_data.pixels),
    };
    picture
        .map_err(|error| why(&error))?
        .and_then(EnvironmentReader::finish)
        .map_err(|fault| fault.to_string())
}

/// Why a file cannot be read, as the end of a sentence.
fn why(error: &Error) -> String {
    match error {
        Error::NotSupported(what) if what.contains("subsampling") => {
            "has channels that are coarser than the picture (luminance and chroma: Y, RY, BY), allowed are R, G and B, \
             or Y, all as fine as it"
                .into()
        }
        Error::NotSupported(what) => format!("is of a kind that is not read: {what}"),
        error => format!("is broken: {error}"),
    }
}

/// Full names of the channels that are read.
enum Colours {
    Rgb([Text; 3]),
    Luminance(Text),
}

impl Colours {
    /// The layer whose colours are read, and their names in it.
    fn find(layers: &[Header]) -> Result<(&Header, Self), String> {
        if let Some((layer, names)) = find_channels(layers, ["R", "G", "B"]) {
            return Ok((layer, Self::Rgb(names)));
        }
        if let Some((layer, [luminance])) = find_channels(layers, ["Y"]) {
            return Ok((layer, Self::Luminance(luminance)));
        }
        Err(format!(
            "has no channels R, G and B of one layer, nor a Y; it has {}",
            listed(layers)
        ))
    }
}

/// The first layer that has all of these channels, and their full names. A layer may be a part of the file, or channels
/// whose names begin with its name and a dot; those without such a name come first.
fn find_channels<'a, const N: usize>(
    layers: &'a [Header],
    names: [&str; N],
) -> Option<(&'a Header, [Text; N])> {
    let flat = layers.iter().filter(|layer| !layer.deep);
    let found = flat.flat_map(|layer| {
        layer.channels.list.iter().filter_map(move |channel| {
            let first = channel.name.to_string();
            let prefix = first.strip_suffix(names[0])?;
            if !prefix.is_empty() && !prefix.ends_with('.') {
                return None;
            }
            let full = names.map(|name| {
                let name = format!("{prefix}{name}");
                let mut list = layer.channels.list.iter();
                list.find(|channel| channel.name == *name)
                    .map(|channel| channel.name.clone())
            });
            let full: Vec<Text> = full.into_iter().collect::<Option<_>>()?;
            Some((rank(prefix), layer, full.try_into().ok()?))
        })
    });
    // The first of equals.
    let best = found.min_by_key(|(rank, ..)| *rank);
    best.map(|(_, layer, names)| (layer, names))
}

/// How far behind others a layer stands, by what its channels' names begin with.
fn rank(prefix: &str) -> u32 {
    match prefix {
        "" => 0,
        // Blender's finished picture, among its passes.
        prefix if prefix.ends_with(".Combined.") || prefix == "Combined." => 1,
        _ => 2,
    }
}

/// The names of channels, for a message.
fn listed(layers: &[Header]) -> String {
    let channels = layers.iter().flat_map(|layer| &layer.channels.list);
    let names: Vec<String> = channels.map(|channel| channel.name.to_string()).collect();
    match names.len() {
        0..=MOST_LISTED => names.join(", "),
        count => format!(
            "{} and {} more",
            names[..MOST_LISTED].join(", "),
            count - MOST_LISTED
        ),
    }
}

/// How the data window of a layer lies in the display window.
#[derive(Clone, Copy)]
struct Window {
    /// From columns and rows of the one to those of the other.
    shift: [i64; 2],
    /// Size of the display window.
    size: [usize; 2],
    /// From the file's primaries to those of sRGB.
    matrix: Option<DMat3>,
}

impl Window {
    fn new(layer: &Header) -> Result<Self, String> {
        let Vec2(width, height) = layer.layer_size;
        if width > MOST_COLUMNS || height > MOST_COLUMNS / 2 {
            return Err(format!(
                "has a data window of {width} x {height} pixels, allowed are at most {MOST_COLUMNS} x {}",
                MOST_COLUMNS / 2
            ));
        }
        let display = &layer.shared_attributes.display_window;
        let (from, to) = (layer.own_attributes.layer_position, display.position);
        let primaries = layer.shared_attributes.chromaticities.as_ref();
        let primaries = primaries.map(|c| {
            let places = [c.red, c.green, c.blue, c.white];
            Primaries(places.map(|Vec2(x, y)| [f64::from(x), f64::from(y)]))
        });
        Ok(Self {
            shift: [
                i64::from(from.0) - i64::from(to.0),
                i64::from(from.1) - i64::from(to.1),
            ],
            size: [display.size.0, display.size.1],
            matrix: primaries
                .filter(|p| !p.is_srgb())
                .and_then(Primaries::to_srgb),
        })
    }

    /// Adds a pixel of the data window, unless it lies beside the display window.
    fn add(
        &self,
        picture: &mut Result<EnvironmentReader, EnvironmentFault>,
        Vec2(x, y): Vec2<usize>,
        colour: [f32; 3],
    ) {
        let place = |axis: usize, at: usize| {
            let place = usize::try_from(at as i64 + self.shift[axis]).ok()?;
            (place < self.size[axis]).then_some(place)
        };
        if let (Ok(picture), Some(x), Some(y)) = (picture, place(0, x), place(1, y)) {
            let colour = match self.matrix {
                None => colour,
                Some(matrix) => (matrix * DVec3::from(colour.map(f64::from)))
                    .to_array()
                    .map(|c| c as f32),
            };
            picture.add(x, y, colour);
        }
    }
}
