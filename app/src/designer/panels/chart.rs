//! Chart: the image that colours the loops, and how it lies on the cloth.

use egui::{Color32, ColorImage, Ui, vec2};
use renderer_core::design::{Chart, ChartImage, Fit};

use super::Surroundings;
use crate::designer::command::Command;
use crate::designer::widgets::{Thumbnail, check, choice, colour, show_thumbnail};

/// Picture of the chart.
#[derive(Default)]
pub struct State {
    thumbnail: Thumbnail<ChartImage>,
}

/// Largest side of the picture of the chart, points.
const SIDE: usize = 132;

/// Shows the panel.
pub fn show(ui: &mut Ui, state: &mut State, chart: &mut Chart, around: &mut Surroundings<'_>) {
    ui.horizontal(|ui| {
        let open = ui.button("Open chart…");
        if open
            .on_hover_text("Chooses an image; one can also be dropped on the window.")
            .clicked()
        {
            around.commands.push(Command::OpenChart);
        }
        let clear = ui.add_enabled(chart.pixels.is_some(), egui::Button::new("Clear chart"));
        if clear
            .on_hover_text("Removes the image; all loops have one colour again.")
            .clicked()
        {
            chart.pixels = None;
            chart.image = None;
        }
    });
    if let Some(image) = &chart.pixels {
        let (width, height) = (image.width(), image.height());
        let shrink = (SIDE as f32 / width.max(height) as f32).min(8.0);
        let size = vec2(width as f32, height as f32) * shrink;
        let texture = state.thumbnail.texture(ui, "chart", image.clone(), reduced);
        ui.add_space(2.0);
        show_thumbnail(ui, &texture, size.max(vec2(4.0, 4.0)), "Chart image");
        let path = chart.image.as_deref().unwrap_or("not yet saved");
        let name = std::path::Path::new(path)
            .file_name()
            .map_or_else(|| path.into(), |name| name.to_string_lossy());
        ui.weak(format!("{name}, {width} × {height} px"))
            .on_hover_text(path);
    } else {
        colour(
            ui,
            "Colour",
            "Colour of all loops where there is no image.",
            &mut chart.colour,
        );
    }
    let tiled = chart.fit == Fit::Tile;
    choice(
        ui,
        "Fit",
        "How the chart's pixels are laid over the loops.",
        &mut chart.fit,
    );
    ui.add_enabled_ui(tiled, |ui| {
        check(
            ui,
            "Mirror x",
            "When tiling: every second repeat along the weft is mirrored.",
            &mut chart.mirror_x,
        );
        check(
            ui,
            "Mirror y",
            "When tiling: every second repeat along the warp is mirrored.",
            &mut chart.mirror_y,
        );
        check(
            ui,
            "Half drop",
            "When tiling: every second column of repeats is shifted by half a repeat.",
            &mut chart.half_drop,
        );
    });
}

/// The chart at twice the shown size at most: of a large one every nth pixel.
fn reduced(image: &ChartImage) -> ColorImage {
    let step = image.width().max(image.height()).div_ceil(2 * SIDE);
    let size = [image.width().div_ceil(step), image.height().div_ceil(step)];
    let pixels = (0..size[0] * size[1])
        .map(|k| {
            let [r, g, b, a] = image.pixel(k % size[0] * step, k / size[0] * step);
            Color32::from_rgba_unmultiplied(r, g, b, a)
        })
        .collect();
    ColorImage::new(size, pixels)
}
