//! Turbulence: the smooth disorder of the loops, with its four channels as thumbnails (the paper's figure 11), how
//! strongly each moves the loops, and what each loop does on its own.

use egui::{Button, Color32, ColorImage, RichText, Sense, TextureHandle, TextureOptions, Ui, vec2};
use renderer_core::design::{Design, Filter, Pile, Turbulence};
use renderer_core::scene::{CHANNELS, SheetGeometry, TurbulenceField};

use super::surroundings::Surroundings;
use crate::designer::panels::choice_row::choice;
use crate::designer::panels::number_row::number;
use crate::designer::tasks::Latest;
use crate::designer::widgets::{more, show_thumbnail, subheading};

/// What the thumbnails show: the turbulence of the first cells of a sheet.
type Key = (SheetGeometry, Turbulence);

/// Pictures of the four channels.
#[derive(Default)]
pub struct State {
    channels: Latest<Key, [TextureHandle; 4]>,
}

/// Most cells along a side of a thumbnail; larger sheets show their near left corner.
const MOST_CELLS: u32 = 96;

/// Shows the panel.
pub fn show(ui: &mut Ui, state: &mut State, design: &mut Design, around: &mut Surroundings<'_>) {
    thumbnails(ui, state, design);
    let pile = &mut design.pile;
    let of_pile = Pile::FIELDS;
    subheading(ui, "How far clumps of loops move");
    number(ui, &of_pile.tilt, &mut pile.tilt);
    number(ui, &of_pile.twist, &mut pile.twist);
    number(ui, &of_pile.stretch, &mut pile.stretch);
    subheading(ui, "Clumps");
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
    number(ui, &fields.seed, &mut turbulence.seed);
    subheading(ui, "What each loop does on its own");
    number(ui, &of_pile.jitter, &mut pile.jitter);
    number(ui, &of_pile.twist_jitter, &mut pile.twist_jitter);
    number(ui, &of_pile.length_jitter, &mut pile.length_jitter);
    more(ui, "More about clumps", |ui| {
        number(ui, &fields.lacunarity, &mut turbulence.lacunarity);
        number(ui, &fields.gain, &mut turbulence.gain);
        choice(
            ui,
            "Filter",
            "Smoothing of the turbulence over neighbouring cells.",
            &mut turbulence.filter,
        );
        ui.add_enabled_ui(turbulence.filter != Filter::None, |ui| {
            number(ui, &fields.filter_radius, &mut turbulence.filter_radius);
        });
    });
    if reset(ui, design) {
        *around.step_name = Some("reset turbulence".into());
    }
}

/// A button that gives everything in this panel the value that a new design has; true when it was pressed.
fn reset(ui: &mut Ui, design: &mut Design) -> bool {
    ui.add_space(3.0);
    let usual = Design::default();
    let pile = Pile {
        tilt: usual.pile.tilt,
        twist: usual.pile.twist,
        stretch: usual.pile.stretch,
        jitter: usual.pile.jitter,
        twist_jitter: usual.pile.twist_jitter,
        length_jitter: usual.pile.length_jitter,
        ..design.pile.clone()
    };
    let differs = design.turbulence != usual.turbulence || design.pile != pile;
    let button = ui.add_enabled(differs, Button::new("Reset turbulence"));
    let what = "Everything in this panel becomes what a new towel has.";
    let is_pressed = button.on_hover_text(what).clicked();
    if is_pressed {
        (design.turbulence, design.pile) = (usual.turbulence, pile);
    }
    is_pressed
}

/// What a channel is called, what it does, and how far at most with this pile.
fn texts(channel: usize, pile: &Pile) -> [String; 3] {
    let degrees = |angle: f64| format!("± {angle:.0}°");
    let percent = format!("± {:.0} %", 100.0 * pile.stretch);
    let (name, what, reach) = match channel {
        0 => (
            "tilt sideways",
            "how far loops lean along the weft",
            degrees(pile.tilt),
        ),
        1 => (
            "tilt lengthwise",
            "how far loops lean along the warp",
            degrees(pile.tilt),
        ),
        2 => ("stretch", "how much longer or shorter loops are", percent),
        _ => (
            "twist",
            "how far loops are turned about themselves",
            degrees(pile.twist),
        ),
    };
    [name.into(), what.into(), reach]
}

fn thumbnails(ui: &mut Ui, state: &mut State, design: &Design) {
    let sheet = &design.sheet;
    let geometry = SheetGeometry {
        warps: sheet.warps.min(MOST_CELLS),
        wefts: sheet.wefts.min(MOST_CELLS),
        pitch_x_mm: sheet.pitch_x(),
        pitch_y_mm: sheet.pitch_y(),
        region: None,
    };
    let key = (geometry, design.turbulence.clone());
    let ctx = ui.ctx().clone();
    let made = state
        .channels
        .get(ui.ctx(), &key, move |(geometry, turbulence)| {
            let field = TurbulenceField::new(geometry, turbulence);
            std::array::from_fn(|channel| {
                let image = picture(&field, geometry, channel);
                ctx.load_texture(CHANNELS[channel], image, TextureOptions::NEAREST)
            })
        });
    let gap = ui.spacing().item_spacing.x;
    let side = ((ui.available_width() - 3.0 * gap) / 4.0).floor();
    ui.add_space(2.0);
    ui.horizontal(|ui| {
        for channel in 0..4 {
            let [name, what, reach] = texts(channel, &design.pile);
            ui.vertical(|ui| {
                ui.spacing_mut().item_spacing.y = 1.0;
                let size = vec2(side, side);
                match made {
                    Some((_, textures)) => {
                        let title = format!("Turbulence of {name}");
                        show_thumbnail(ui, &textures[channel], size, &title).on_hover_text(format!(
                            "Turbulence of {name}: {what}. Gray leaves a loop as it is, black and white move it by \
                            {reach}."
                        ));
                    }
                    None => {
                        ui.allocate_exact_size(size, Sense::hover());
                    }
                }
                ui.label(RichText::new(name).small());
                ui.label(RichText::new(reach).small().weak());
            });
        }
    });
    if sheet.warps > MOST_CELLS || sheet.wefts > MOST_CELLS {
        let [x, y] = [
            f64::from(geometry.warps) * geometry.pitch_x_mm,
            f64::from(geometry.wefts) * geometry.pitch_y_mm,
        ];
        let text = format!("The near left corner of the cloth, {x:.0} × {y:.0} mm.");
        ui.label(RichText::new(text).small().weak());
    }
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
