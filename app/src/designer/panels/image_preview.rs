//! A thumbnail of an image of the design (chart, nap map), made anew when that is another.

use std::path::Path;

use egui::{Color32, ColorImage, Label, RichText, Ui};
use renderer_core::design::{ChartImage, OPAQUE_FROM};

/// An image by its place in memory: comparing pixels every frame would take longer than making the picture.
pub struct Picture(pub ChartImage);

impl PartialEq for Picture {
    fn eq(&self, other: &Self) -> bool {
        self.0.is(&other.0)
    }
}

/// An image at twice the side it is shown at, points, at most: of a large one every nth pixel. What is bare is grey.
pub fn reduced(image: &ChartImage, side: usize) -> ColorImage {
    let step = image.width().max(image.height()).div_ceil(2 * side);
    let size = [image.width().div_ceil(step), image.height().div_ceil(step)];
    let pixels = (0..size[0] * size[1])
        .map(|k| {
            let [r, g, b, alpha] = image.pixel(k % size[0] * step, k / size[0] * step);
            if alpha < OPAQUE_FROM {
                Color32::from_gray(0x98)
            } else {
                Color32::from_rgb(r, g, b)
            }
        })
        .collect();
    ColorImage::new(size, pixels)
}

/// The file that an image was read from, `otherwise` where it has none, and the image's size in pixels; the whole path
/// for who points at it.
pub fn file_label(ui: &mut Ui, path: Option<&str>, otherwise: &str, [width, height]: [usize; 2]) {
    let path = path.unwrap_or(otherwise);
    let name = Path::new(path).file_name();
    let name = name.map_or_else(|| path.into(), |name| name.to_string_lossy());
    let text = RichText::new(format!("{name}, {width} × {height} px")).weak();
    ui.add(Label::new(text).wrap()).on_hover_text(path);
}
