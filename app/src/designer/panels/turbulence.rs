//! Turbulence: the smooth disorder of the loops, with its four channels as thumbnails (the paper's figure 11).

use egui::{Color32, ColorImage, RichText, Ui, vec2};
use renderer_core::design::{Design, Filter, Turbulence};
use renderer_core::scene::{CHANNELS, SheetGeometry, TurbulenceField};

use super::Surroundings;
use crate::designer::widgets::{Thumbnail, choice, number, show_thumbnail, subheading};

/// What the thumbnails show: the turbulence of the first cells of a sheet.
type Key = (SheetGeometry, Turbulence);

/// Pictures of the four channels, side by side in one texture.
#[derive(Default)]
pub struct State {
    channels: [Thumbnail<Key>; 4],
}

/// Most cells along a side of a thumbnail; larger sheets show their near left corner.
const MOST_CELLS: u32 = 96;

/// Shows the panel.
pub fn show(ui: &mut Ui, state: &mut State, design: &mut Design, around: &mut Surroundings<'_>) {
    thumbnails(ui, state, design);
    for warning in around.warnings.iter().filter(|w| w.contains("turbulence")) {
        let text = RichText::new(warning).small();
        ui.label(text.color(ui.visuals().warn_fg_color));
    }
    let fields = Turbulence::FIELDS;
    let turbulence = &mut design.turbulence;
    choice(
        ui,
        "Kind",
        "The noise behind the turbulence.",
        &mut turbulence.kind,
    );
    number(ui, &fields.frequency, &mut turbulence.frequency);
    number(ui, &fields.octaves, &mut turbulence.octaves);
    number(ui, &fields.lacunarity, &mut turbulence.lacunarity);
    number(ui, &fields.gain, &mut turbulence.gain);
    number(ui, &fields.seed, &mut turbulence.seed);
    choice(
        ui,
        "Filter",
        "Smoothing of the turbulence over neighbouring cells.",
        &mut turbulence.filter,
    );
    ui.add_enabled_ui(turbulence.filter != Filter::None, |ui| {
        number(ui, &fields.filter_radius, &mut turbulence.filter_radius);
    });
    subheading(ui, "Strengths");
    let pile = &mut design.pile;
    let fields = renderer_core::design::Pile::FIELDS;
    number(ui, &fields.tilt, &mut pile.tilt);
    number(ui, &fields.twist, &mut pile.twist);
    number(ui, &fields.stretch, &mut pile.stretch);
}

fn thumbnails(ui: &mut Ui, state: &mut State, design: &Design) {
    let sheet = &design.sheet;
    let geometry = SheetGeometry {
        warps: sheet.warps.min(MOST_CELLS),
        wefts: sheet.wefts.min(MOST_CELLS),
        pitch_x_mm: sheet.pitch_x(),
        pitch_y_mm: sheet.pitch_y(),
    };
    let key = (geometry, design.turbulence.clone());
    // Made when the first channel finds its key changed, then shared by the other three.
    let mut field = None;
    let gap = ui.spacing().item_spacing.x;
    let side = ((ui.available_width() - 3.0 * gap) / 4.0).floor();
    ui.horizontal(|ui| {
        for (channel, thumbnail) in state.channels.iter_mut().enumerate() {
            let texture = thumbnail.texture(ui, CHANNELS[channel], key.clone(), |key| {
                let field = field.get_or_insert_with(|| TurbulenceField::new(&key.0, &key.1));
                picture(field, &key.0, channel)
            });
            ui.vertical(|ui| {
                ui.spacing_mut().item_spacing.y = 1.0;
                let name = format!("Turbulence of {}", CHANNELS[channel]);
                show_thumbnail(ui, &texture, vec2(side, side), &name).on_hover_text(name);
                ui.label(RichText::new(CHANNELS[channel]).small().weak());
            });
        }
    });
}

/// One channel as gray, −1 black and 1 white, the near edge at the bottom.
fn picture(field: &TurbulenceField, geometry: &SheetGeometry, channel: usize) -> ColorImage {
    let (cols, rows) = (geometry.warps as usize, geometry.wefts as usize);
    let pixels = (0..rows * cols)
        .map(|k| {
            let value = field.at(k % cols, rows - 1 - k / cols)[channel];
            Color32::from_gray((127.5 * (value + 1.0)).round() as u8)
        })
        .collect();
    ColorImage::new([cols, rows], pixels)
}
