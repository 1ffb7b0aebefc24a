//! Filling outlines row by row: a pixel is filled where the outline winds around its middle.

use std::ops::Range;

use super::place::{Contour, Placed};
use super::{ChartCanvas, ChartObject};
use crate::design::chart_edit::BARE;
use crate::design::chart_edit::mixed;
use crate::design::{ChartImage, Colour};

/// Fills an object's outline where it is placed.
pub(super) fn draw(
    image: &mut ChartImage,
    object: &ChartObject,
    outline: &[Contour],
    placed: &Placed,
    canvas: &ChartCanvas,
) {
    let Colour([r, g, b]) = object.colour;
    let colour = if object.bare { BARE } else { [r, g, b, 255] };
    let in_pixels = |place: &[f64; 2]| canvas.pixel_at(placed.at(*place));
    let outline: Vec<Contour> = outline
        .iter()
        .map(|contour| contour.iter().map(in_pixels).collect())
        .collect();
    for (row, columns) in spans(&outline, canvas.size) {
        if object.opacity >= 1.0 {
            image.fill_row(row, columns, colour);
        } else {
            mix_row(image, row, columns, |_| colour, object.opacity);
        }
    }
}

/// Gives each pixel of a part of a row a colour over the one it has, as far as `opacity` says.
pub(super) fn mix_row(
    image: &mut ChartImage,
    row: usize,
    columns: Range<usize>,
    colour: impl Fn(usize) -> [u8; 4],
    opacity: f64,
) {
    let mut start = columns.start;
    let mixed_at = |image: &ChartImage, x: usize| mixed(image.pixel(x, row), colour(x), opacity);
    while start < columns.end {
        let new = mixed_at(image, start);
        let mut end = start + 1;
        while end < columns.end && mixed_at(image, end) == new {
            end += 1;
        }
        image.fill_row(row, start..end, new);
        start = end;
    }
}

/// The rows of pixels, and of each the columns, whose middles an outline in pixels winds around.
fn spans(outline: &[Contour], [width, height]: [usize; 2]) -> Vec<(usize, Range<usize>)> {
    /// Where an edge crosses a row's middle, and which way it goes.
    type Crossing = (f64, i32);
    let mut crossings: Vec<Vec<Crossing>> = vec![Vec::new(); height];
    // The first pixel whose middle is not before a place.
    let first_from = |at: f64, side: usize| (at - 0.5).ceil().clamp(0.0, side as f64) as usize;
    for contour in outline {
        for (k, &[x0, y0]) in contour.iter().enumerate() {
            let [x1, y1] = contour[(k + 1) % contour.len()];
            let (low, high, way) = if y0 < y1 { (y0, y1, 1) } else { (y1, y0, -1) };
            let rows = first_from(low, height)..first_from(high, height);
            for (row, crossed) in crossings[rows.clone()]
                .iter_mut()
                .zip(rows)
                .map(|(c, r)| (r, c))
            {
                let along = (row as f64 + 0.5 - y0) / (y1 - y0);
                crossed.push((x0 + along * (x1 - x0), way));
            }
        }
    }
    let mut spans = Vec::new();
    for (row, mut crossed) in crossings.into_iter().enumerate() {
        crossed.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (mut winding, mut start) = (0, 0.0);
        for (x, way) in crossed {
            if winding == 0 {
                start = x;
            }
            winding += way;
            let columns = first_from(start, width)..first_from(x, width);
            if winding == 0 && !columns.is_empty() {
                spans.push((row, columns));
            }
        }
    }
    spans
}
