//! Painting with a brush: strokes and outlines, made of parts of rows. What lies outside the chart is left out.

use crate::design::ChartImage;

/// Widest brush, pixels.
pub const LARGEST_BRUSH: usize = 128;

/// Draws a line with a round brush of `size` pixels, both ends included. Ends may lie outside the chart.
pub fn draw_line(
    image: &mut ChartImage,
    from: [i64; 2],
    to: [i64; 2],
    size: usize,
    colour: [u8; 4],
) {
    let brush = brush(size);
    let [dx, dy] = [to[0] - from[0], to[1] - from[1]];
    let steps = dx.abs().max(dy.abs()).max(1);
    for step in 0..=steps {
        // The nearest pixel, halves upwards: the same line whichever way it is drawn would need more, and is not
        // needed.
        let along =
            |start: i64, delta: i64| start + (2 * delta * step + steps).div_euclid(2 * steps);
        let (x, y) = (along(from[0], dx), along(from[1], dy));
        for &(row, left, right) in &brush {
            fill_row(image, y + row, x + left, x + right, colour);
        }
    }
}

/// Draws the outline of the rectangle with these corners, with a brush of `size` pixels.
pub fn outline_rectangle(
    image: &mut ChartImage,
    [a, b]: [[i64; 2]; 2],
    size: usize,
    colour: [u8; 4],
) {
    for (from, to) in [
        (a, [b[0], a[1]]),
        ([b[0], a[1]], b),
        (b, [a[0], b[1]]),
        ([a[0], b[1]], a),
    ] {
        draw_line(image, from, to, size, colour);
    }
}

/// Rows of a round brush: where each lies and reaches, relative to the middle.
fn brush(size: usize) -> Vec<(i64, i64, i64)> {
    let size = size.clamp(1, LARGEST_BRUSH) as i64;
    let before = (size - 1) / 2;
    // Twice the distances, so that brushes of even size have their middle between pixels.
    let reach = size * size;
    let is_inside = |x: i64, y: i64| {
        let (x, y) = (2 * x - (size - 1), 2 * y - (size - 1));
        // Small brushes lose no corner: a brush of two pixels is a square.
        x * x + y * y <= reach
    };
    let row = |y: i64| {
        let first = (0..size).find(|&x| is_inside(x, y))?;
        Some((y - before, first - before, size - 1 - first - before))
    };
    (0..size).filter_map(row).collect()
}

/// Columns `left` to `right`, both included.
fn fill_row(image: &mut ChartImage, y: i64, left: i64, right: i64, colour: [u8; 4]) {
    let (Ok(y), Ok(end)) = (usize::try_from(y), usize::try_from(right + 1)) else {
        return;
    };
    image.fill_row(y, left.max(0) as usize..end, colour);
}
