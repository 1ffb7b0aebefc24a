//! Plots as SVG and PNG.
//!
//! Colours are Okabe and Ito's, which the colour-blind tell apart, and every curve has its own marker besides. All is
//! laid out in units of which the SVG has one a pixel and the PNG two, drawn at twice that and averaged.

mod axis;
mod bars;
mod canvas;
mod curves;
mod errors;
mod field;

use image::RgbImage;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use plotters::prelude::{BitMapBackend, DrawingBackend, IntoDrawingArea, RGBColor, SVGBackend};

use self::canvas::{Canvas, draw, register};

pub use bars::{Bar, Bars};
pub use canvas::Marker;
pub use curves::{Curve, Curves, Limit};
pub use errors::Plot;

/// Width and height, units.
const SIZE: [f64; 2] = [960.0, 600.0];
/// Pixels a unit of the PNG.
const PNG_SCALE: u32 = 2;
/// Times as large that the PNG is drawn.
const OVERSAMPLING: u32 = 2;

const INK: RGBColor = RGBColor(34, 34, 34);
const GREY: RGBColor = RGBColor(120, 120, 120);
const GRID: RGBColor = RGBColor(226, 226, 226);
const FINE_GRID: RGBColor = RGBColor(243, 243, 243);

/// Colours that curves and bars have in turn.
pub const COLOURS: [RGBColor; 6] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
];

/// Markers that curves have in turn.
pub const MARKERS: [Marker; 5] = [
    Marker::Circle,
    Marker::Down,
    Marker::Up,
    Marker::Diamond,
    Marker::Square,
];

/// A plot.
pub trait Figure {
    /// Draws it on white.
    ///
    /// # Errors
    /// When the surface refuses.
    fn draw<B: DrawingBackend>(&self, canvas: &Canvas<'_, B>) -> anyhow::Result<()>;

    /// The figure as SVG.
    ///
    /// # Errors
    /// When it cannot be drawn.
    fn svg(&self) -> anyhow::Result<String> {
        register()?;
        let mut text = String::new();
        let [width, height] = SIZE.map(|side| side as u32);
        {
            let area = SVGBackend::with_string(&mut text, (width, height)).into_drawing_area();
            self.draw(&Canvas {
                area: &area,
                scale: 1.0,
                text_rise: 0.0,
            })?;
            draw(area.present())?;
        }
        Ok(text)
    }

    /// The figure as PNG.
    ///
    /// # Errors
    /// When it cannot be drawn.
    fn png(&self) -> anyhow::Result<Vec<u8>> {
        register()?;
        let [width, height] = SIZE.map(|side| side as u32 * PNG_SCALE);
        let [drawn_width, drawn_height] = [width, height].map(|side| side * OVERSAMPLING);
        let mut pixels = vec![0; (drawn_width * drawn_height * 3) as usize];
        {
            let area = BitMapBackend::with_buffer(&mut pixels, (drawn_width, drawn_height))
                .into_drawing_area();
            self.draw(&Canvas {
                area: &area,
                scale: f64::from(PNG_SCALE * OVERSAMPLING),
                text_rise: 0.16,
            })?;
            draw(area.present())?;
        }
        let image = RgbImage::from_fn(width, height, |x, y| {
            image::Rgb([0, 1, 2].map(|c| {
                let inside = (0..OVERSAMPLING * OVERSAMPLING).map(|k| {
                    let (x, y) = (
                        x * OVERSAMPLING + k % OVERSAMPLING,
                        y * OVERSAMPLING + k / OVERSAMPLING,
                    );
                    u32::from(pixels[((y * drawn_width + x) * 3 + c) as usize])
                });
                (inside.sum::<u32>() / (OVERSAMPLING * OVERSAMPLING)) as u8
            }))
        });
        let mut file = Vec::new();
        image.write_with_encoder(PngEncoder::new_with_quality(
            &mut file,
            CompressionType::Best,
            FilterType::Adaptive,
        ))?;
        Ok(file)
    }
}
