//! The height map: how long the loop of every cell of the sheet is, as a gray picture with a scale in mm.

use egui::{
    Align2, Color32, ColorImage, FontId, Mesh, Rect, Response, Sense, Shape, TextureHandle,
    TextureOptions, Ui, pos2, vec2,
};
use renderer_core::design::{Chart, Design};

use super::length_pictures::Lengths;
use crate::designer::tasks::Latest;
use crate::designer::widgets::{show_thumbnail, subheading};

/// The last height map and what it shows.
#[derive(Default)]
pub struct HeightMaps {
    last: Latest<Lengths, Map>,
}

struct Map {
    texture: TextureHandle,
    scale_mm: [f64; 2],
}

/// Largest height of the picture, points.
const HEIGHT: f32 = 132.0;
/// Room for the scale beside it, points.
const SCALE: f32 = 74.0;

/// Shows the lengths that the design's chart gives, as the cloth shows it.
pub fn show(ui: &mut Ui, maps: &mut HeightMaps, design: &Design, woven: &Chart) {
    subheading(ui, "Height map");
    let lengths = Lengths {
        chart: woven.clone(),
        length: design.length.clone(),
        sheet: design.sheet.clone(),
        weave: design.weave.clone(),
        max_length_mm: design.pile.max_length,
    };
    let ctx = ui.ctx().clone();
    let made = maps.last.get(ui.ctx(), &lengths, move |lengths| {
        let map = lengths.height_map();
        Map {
            texture: texture(&ctx, map.image),
            scale_mm: map.scale_mm,
        }
    });
    let sheet = &design.sheet;
    let width_mm = (f64::from(sheet.warps) * sheet.pitch_x()) as f32;
    let length_mm = (f64::from(sheet.wefts) * sheet.pitch_y()) as f32;
    let room = vec2((ui.available_width() - SCALE).max(40.0), HEIGHT);
    let points_per_mm = (room.x / width_mm).min(room.y / length_mm);
    let size = (vec2(width_mm, length_mm) * points_per_mm).max(vec2(4.0, 4.0));
    let Some((_, map)) = made else {
        ui.allocate_exact_size(size, Sense::hover());
        return;
    };
    ui.horizontal(|ui| {
        let [low, high] = map.scale_mm;
        let name = format!("Height map: loops from {low:.2} to {high:.2} mm");
        let picture = show_thumbnail(ui, &map.texture, size, &name);
        scale(ui, size.y, map.scale_mm);
        tell_cell(picture, &lengths, design);
    });
}

fn texture(ctx: &egui::Context, image: ColorImage) -> TextureHandle {
    ctx.load_texture("height map", image, TextureOptions::NEAREST)
}

/// Tells cell and length under the pointer.
fn tell_cell(picture: Response, lengths: &Lengths, design: &Design) {
    let Some(at) = picture.hover_pos() else {
        return;
    };
    let share = (at - picture.rect.min) / picture.rect.size();
    let cell = |share: f32, cells: u32| ((share * cells as f32) as u32).min(cells.max(1) - 1);
    let sheet = &lengths.sheet;
    let warp = cell(share.x, sheet.warps);
    let weft = cell(1.0 - share.y, sheet.wefts);
    let stitch = design
        .weave
        .pattern
        .stitch(i64::from(warp), i64::from(weft));
    let length = match lengths.at(warp, weft) {
        Some(mm) if mm > 0.0 => format!("{mm:.2} mm"),
        _ => "no loop: the chart leaves none here".into(),
    };
    let pattern = if stitch.front || stitch.back {
        ""
    } else {
        "\nThe stitch pattern has no loop at this crossing."
    };
    picture.on_hover_text_at_pointer(format!(
        "Warp {} of {}, weft {} of {}: {length}{pattern}",
        warp + 1,
        sheet.warps,
        weft + 1,
        sheet.wefts
    ));
}

/// A bar from white to black with lengths at its ends.
fn scale(ui: &mut Ui, height: f32, [low, high]: [f64; 2]) {
    let (rect, _) = ui.allocate_exact_size(vec2(SCALE - 8.0, height), Sense::hover());
    let bar = Rect::from_min_size(rect.min, vec2(10.0, height));
    let mut mesh = Mesh::default();
    for (corner, shade) in [
        (bar.left_top(), 255),
        (bar.right_top(), 255),
        (bar.right_bottom(), 0),
        (bar.left_bottom(), 0),
    ] {
        mesh.colored_vertex(corner, Color32::from_gray(shade));
    }
    mesh.add_triangle(0, 1, 2);
    mesh.add_triangle(0, 2, 3);
    let painter = ui.painter();
    painter.add(Shape::mesh(mesh));
    let outline = ui.visuals().widgets.noninteractive.bg_stroke;
    painter.rect_stroke(bar, 0.0, outline, egui::StrokeKind::Outside);
    let font = FontId::proportional(11.0);
    let colour = ui.visuals().weak_text_color();
    let label = |y: f32, align: Align2, mm: f64| {
        let at = pos2(bar.right() + 5.0, y);
        painter.text(at, align, format!("{mm:.2} mm"), font.clone(), colour);
    };
    label(bar.top(), Align2::LEFT_TOP, high);
    if height > 30.0 {
        label(bar.bottom(), Align2::LEFT_BOTTOM, low);
    }
}
