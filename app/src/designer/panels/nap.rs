//! The nap map: opened, made ready, or combed with the pointer on its picture.

use egui::{
    Button, Color32, CursorIcon, Pos2, Rect, Role, Sense, Stroke, Ui, Vec2, WidgetInfo, vec2,
};
use renderer_core::design::nap_edit::{
    LARGEST_COMB, comb, direction, footprints, pixel, smoothed, stripes, upright,
};
use renderer_core::design::{ChartImage, Design, Fit, ImageSlot, Nap, Sheet};

use super::image_preview::{Picture, reduced};
use super::surroundings::Surroundings;
use crate::designer::panels::choice_row::choice;
use crate::designer::panels::number_row::number;
use crate::designer::shell::command::Command;
use crate::designer::widgets::{NumberField, PointerWay, Thumbnail, row, subheading};

/// Picture of the map, and the comb.
pub struct State {
    thumbnail: Thumbnail<Picture>,
    /// Width of the comb, pixels of the map.
    comb: f64,
    /// Where the stroke under way was last, pixels of the map.
    stroke: Option<[f64; 2]>,
}

impl Default for State {
    fn default() -> Self {
        Self {
            thumbnail: Thumbnail::default(),
            comb: 24.0,
            stroke: None,
        }
    }
}

/// Highest picture, points.
const HEIGHT: f32 = 260.0;
/// Between the lines that show which way pile lies, points.
const LINES: f32 = 14.0;

/// Shows what there is to do with the map.
pub fn show(ui: &mut Ui, state: &mut State, design: &mut Design, around: &mut Surroundings<'_>) {
    let fields = Nap::FIELDS;
    subheading(ui, "Nap map");
    let Design { nap, sheet, .. } = design;
    let mut name = files(ui, nap, around);
    name = ready(ui, nap, sheet).or(name);
    if let Some(map) = nap.pixels.clone() {
        name = picture(ui, state, nap, sheet, &map).or(name);
        let what = "Width of the comb, in pixels of the map.";
        row(ui, "Comb", what, |ui, label| {
            let comb = NumberField::new(&mut state.comb, "px", 1.0..=LARGEST_COMB);
            let comb = comb.speed(0.5).max_decimals(0).show(ui);
            comb.labelled_by(label.id).on_hover_text(what);
            ui.weak("px");
        });
        number(ui, &fields.strength, &mut nap.strength);
        choice(
            ui,
            "Fit",
            "How the map is laid over the loops.",
            &mut nap.fit,
        );
    }
    if name.is_some() {
        *around.step_name = name.map(Into::into);
    }
}

/// Makes a map that was changed here the nap's: it is in no file.
fn put(nap: &mut Nap, map: ChartImage) {
    nap.image = None;
    nap.pixels = Some(map);
}

fn files(ui: &mut Ui, nap: &mut Nap, around: &mut Surroundings<'_>) -> Option<&'static str> {
    let mut name = None;
    ui.horizontal(|ui| {
        let open = ui.button("Open map…");
        if open
            .on_hover_text(
                "Chooses an image whose red and green say which way the pile lies, as in a normal map.",
            )
            .clicked()
        {
            around.commands.push(Command::OpenImage(ImageSlot::Nap));
        }
        let clear = ui.add_enabled(nap.pixels.is_some(), Button::new("Clear map"));
        if clear
            .on_hover_text("Removes the map; the pile lies as the panel Pile says.")
            .clicked()
        {
            nap.pixels = None;
            nap.image = None;
            name = Some("clear nap map");
        }
        let smooth = ui.add_enabled(nap.pixels.is_some(), Button::new("Smooth"));
        if smooth.on_hover_text("Blends each direction with those around it.").clicked()
            && let Some(map) = &nap.pixels
        {
            let map = smoothed(map);
            put(nap, map);
            name = Some("smoothed nap");
        }
    });
    name
}

/// Buttons that lay the pile of the whole cloth, or make marks on it.
fn ready(ui: &mut Ui, nap: &mut Nap, sheet: &Sheet) -> Option<&'static str> {
    let mut name = None;
    let map = || nap.pixels.clone().or_else(|| upright(sheet));
    let mut made = None;
    ui.horizontal_wrapped(|ui| {
        for (text, label, way) in [
            ("Left", "Brush all to the left", [-1.0, 0.0]),
            ("Right", "Brush all to the right", [1.0, 0.0]),
            ("Away", "Brush all away", [0.0, 1.0]),
            ("Near", "Brush all near", [0.0, -1.0]),
            ("Upright", "Brush all upright", [0.0, 0.0]),
        ] {
            let button = ui.button(text).accessible_name(label);
            if button.on_hover_text(format!("{label}.")).clicked() {
                made =
                    map().and_then(|map| ChartImage::filled(map.width(), map.height(), pixel(way)));
                name = Some("brushed pile");
            }
        }
    });
    ui.horizontal(|ui| {
        let vacuum = ui.button("Vacuum stripes");
        let what = "Lays the pile in the lanes of a vacuum cleaner, away and back in turns.";
        if vacuum.on_hover_text(what).clicked() {
            made = map().map(|map| stripes(&map, sheet));
            name = Some("vacuum stripes");
        }
        let feet = ui.button("Footprints");
        let what = "Adds two steps of somebody who has walked over the pile.";
        if feet.on_hover_text(what).clicked() {
            made = map().map(|map| footprints(&map, sheet));
            name = Some("footprints");
        }
    });
    if let Some(made) = made {
        put(nap, made);
    }
    name
}

/// The map, to comb with the pointer. Returns how the history calls a stroke.
fn picture(
    ui: &mut Ui,
    state: &mut State,
    nap: &mut Nap,
    sheet: &Sheet,
    map: &ChartImage,
) -> Option<&'static str> {
    let pixels = vec2(map.width() as f32, map.height() as f32);
    let shape = match nap.fit {
        Fit::Stretch => vec2(
            (f64::from(sheet.warps) * sheet.pitch_x()) as f32,
            (f64::from(sheet.wefts) * sheet.pitch_y()) as f32,
        ),
        Fit::Tile | Fit::Place => vec2(
            (f64::from(map.width() as u32) * sheet.pitch_x()) as f32,
            (f64::from(map.height() as u32) * sheet.pitch_y()) as f32,
        ),
    };
    let room = vec2(ui.available_width().max(40.0), HEIGHT);
    let size = (shape * (room / shape).min_elem()).max(Vec2::splat(4.0));
    let texture = state
        .thumbnail
        .texture(ui, "nap", Picture(map.clone()), |Picture(map)| {
            reduced(map, HEIGHT as usize)
        });
    let (rect, response) = ui.allocate_exact_size(size, Sense::click_and_drag());
    if ui.is_rect_visible(rect) {
        let whole = Rect::from_min_max(Pos2::ZERO, Pos2::new(1.0, 1.0));
        ui.painter()
            .image(texture.id(), rect, whole, Color32::WHITE);
        lines(ui, rect, map);
    }
    let at = |place: Pos2| {
        let share = (place - rect.min) / rect.size() * pixels;
        [f64::from(share.x), f64::from(share.y)]
    };
    let way = PointerWay::new(ui, &response, state.stroke.is_some());
    let mut combed: Option<ChartImage> = None;
    for place in way.places.into_iter().map(at) {
        let Some(last) = state.stroke else {
            state.stroke = Some(place);
            continue;
        };
        // Over a shorter way the hand's trembling would be a direction.
        if (place[0] - last[0]).hypot(place[1] - last[1]) >= (0.1 * state.comb).max(1.0) {
            let map = combed.get_or_insert_with(|| map.clone());
            comb(map, last, place, state.comb);
            state.stroke = Some(place);
        }
    }
    if way.ends {
        state.stroke = None;
    }
    response.widget_info(|| WidgetInfo::labeled(Role::Canvas, ui.is_enabled(), "Nap map canvas"));
    response
        .on_hover_cursor(CursorIcon::Crosshair)
        .on_hover_text_at_pointer("Drag to comb the pile.");
    let combed = combed?;
    put(nap, combed);
    Some("combed pile")
}

/// Which way the pile lies, as lines that begin thick.
fn lines(ui: &Ui, rect: Rect, map: &ChartImage) {
    let [columns, rows] = [rect.width(), rect.height()].map(|side| (side / LINES) as usize);
    let painter = ui.painter().with_clip_rect(rect);
    for (column, row) in (0..rows).flat_map(|row| (0..columns).map(move |column| (column, row))) {
        let share = vec2(
            (column as f32 + 0.5) / columns as f32,
            (row as f32 + 0.5) / rows as f32,
        );
        let [x, y] = [
            (share.x * map.width() as f32) as usize,
            (share.y * map.height() as f32) as usize,
        ];
        let [right, up] = direction(map.pixel(x, y)).map(|part| part as f32);
        let way = vec2(right, -up) * 0.48 * LINES;
        let middle = rect.min + share * rect.size();
        let stroke = Stroke::new(1.0, Color32::from_black_alpha(200));
        painter.line_segment([middle - way, middle + way], stroke);
        painter.circle_filled(middle - way, 1.8, Color32::from_black_alpha(200));
    }
}
