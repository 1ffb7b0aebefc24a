//! The window that starts a new design: what cloth it is, how large, heavy or high, how closely woven.

mod kinds;

use egui::{Align2, Button, ComboBox, Context, Grid, RichText, Ui, Window};
use renderer_core::design::{Back, Design};

pub use kinds::{Cloth, ClothKind};

use crate::designer::widgets::{NumberField, shown_unit};

/// The window.
pub struct NewDesign {
    /// Whether it is open.
    pub is_open: bool,
    cloth: Cloth,
}

impl Default for NewDesign {
    fn default() -> Self {
        Self {
            is_open: false,
            cloth: ClothKind::Towel.usual(),
        }
    }
}

/// Smallest and largest side of a new cloth, mm.
const SIDES_MM: [f64; 2] = [10.0, 20_000.0];
/// Lightest and heaviest terry, g/m².
const WEIGHTS: [f64; 2] = [150.0, 2000.0];
/// Lowest and highest pile, mm.
const PILES_MM: [f64; 2] = [0.5, 60.0];

impl NewDesign {
    /// Shows the window, if it is open. Returns the design that is to be started.
    pub fn show(&mut self, ctx: &Context) -> Option<Design> {
        if !self.is_open {
            return None;
        }
        let (mut is_open, mut made) = (true, None);
        let room = ctx.content_rect();
        Window::new("New design")
            .open(&mut is_open)
            .collapsible(false)
            .resizable(false)
            .pivot(Align2::CENTER_CENTER)
            .default_pos(room.center())
            .show(ctx, |ui| {
                ui.horizontal_top(|ui| {
                    ui.vertical(|ui| self.kinds(ui));
                    ui.separator();
                    ui.vertical(|ui| made = self.form(ui));
                });
            });
        self.is_open = is_open && made.is_none();
        made
    }

    fn kinds(&mut self, ui: &mut Ui) {
        ui.set_width(108.0);
        for kind in ClothKind::ALL {
            let is_chosen = self.cloth.kind == kind;
            let button = Button::selectable(is_chosen, kind.label()).min_size([104.0, 22.0].into());
            if ui.add(button).on_hover_text(kind.what()).clicked() {
                self.cloth = kind.usual();
            }
        }
    }

    /// The fields, and the buttons below them.
    fn form(&mut self, ui: &mut Ui) -> Option<Design> {
        ui.set_width(300.0);
        let kind = self.cloth.kind;
        ui.label(RichText::new(kind.what()).weak());
        ui.add_space(4.0);
        Grid::new("new design")
            .num_columns(2)
            .spacing([10.0, 6.0])
            .show(ui, |ui| {
                self.size(ui);
                self.pile(ui);
                self.density(ui);
                self.back(ui);
            });
        ui.add_space(4.0);
        let design = self.cloth.design();
        let sheet = &design.sheet;
        let loops = match kind {
            ClothKind::Blank => String::new(),
            _ => format!(", loops of {} mm", design.length.value),
        };
        ui.weak(format!(
            "{} ends × {} picks{loops}",
            sheet.warps, sheet.wefts
        ));
        let faults = design.faults();
        if let Some(fault) = faults.first() {
            ui.colored_label(ui.visuals().error_fg_color, fault.to_string());
        }
        ui.add_space(6.0);
        let mut is_made = false;
        ui.horizontal(|ui| {
            let create = Button::new(RichText::new("Create").strong());
            let create = ui.add_enabled(faults.is_empty(), create);
            let what =
                "Starts this design; what is unsaved of the one that is open is asked about first.";
            is_made = create.on_hover_text(what).clicked();
            if ui
                .button("Cancel")
                .on_hover_text("Leaves everything as it is.")
                .clicked()
            {
                self.is_open = false;
                ui.close();
            }
        });
        is_made.then_some(design)
    }

    fn size(&mut self, ui: &mut Ui) {
        ui.label("Size");
        ui.horizontal(|ui| {
            let [least, most] = SIDES_MM.map(|mm| mm / 10.0);
            for (axis, name) in [
                (0, "Width of the new cloth"),
                (1, "Length of the new cloth"),
            ] {
                let mut cm = self.cloth.size_mm[axis] / 10.0;
                let field = NumberField::new(&mut cm, "cm", least..=most)
                    .speed(0.5)
                    .max_decimals(1);
                if field.show(ui).accessible_name(name).changed() {
                    self.cloth.size_mm[axis] = 10.0 * cm;
                }
                if axis == 0 {
                    ui.label("×");
                }
            }
            ui.weak(shown_unit(ui.ctx(), "cm"));
        });
        ui.end_row();
    }

    /// Weight of terry, pile height of other cloth.
    fn pile(&mut self, ui: &mut Ui) {
        let cloth = &mut self.cloth;
        if cloth.kind == ClothKind::Blank {
            return;
        }
        if cloth.kind.is_terry() {
            ui.label("Weight");
            ui.horizontal(|ui| {
                let field = NumberField::new(&mut cloth.weight, "g/m²", WEIGHTS[0]..=WEIGHTS[1]);
                field.max_decimals(0).show(ui).accessible_name("Weight").on_hover_text(
                    "300 to 400 is light, 400 to 600 medium, 600 to 900 heavy: decides how long the loops are.",
                );
                ui.weak("g/m²");
            });
        } else {
            let most = PILES_MM[1].min(cloth.highest_mm());
            ui.label("Pile height");
            ui.horizontal(|ui| {
                let field = NumberField::new(&mut cloth.pile_mm, "mm", PILES_MM[0]..=most);
                field
                    .speed(0.1)
                    .max_decimals(1)
                    .show(ui)
                    .accessible_name("Pile height");
                ui.weak(shown_unit(ui.ctx(), "mm"));
            });
        }
        ui.end_row();
    }

    fn density(&mut self, ui: &mut Ui) {
        let [least, most] = self.cloth.kind.densities();
        for (axis, name) in [(0, "Ends"), (1, "Picks")] {
            ui.label(name);
            ui.horizontal(|ui| {
                let value = &mut self.cloth.per_cm[axis];
                let field = NumberField::new(value, "/cm", least..=most).speed(0.05).max_decimals(1);
                field.show(ui).accessible_name(name).on_hover_text(
                    "How closely they stand: columns and rows of the weave. Yarn and irregularity follow.",
                );
                ui.weak(shown_unit(ui.ctx(), "/cm"));
            });
            ui.end_row();
        }
    }

    fn back(&mut self, ui: &mut Ui) {
        let choices = [
            (Back::Mirror, "same as face"),
            (Back::Pattern, "from weave"),
            (Back::None, "no pile"),
        ];
        let text = |back| {
            choices
                .iter()
                .find(|(choice, _)| *choice == back)
                .map_or("", |(_, text)| *text)
        };
        ui.label("Reverse side");
        let combo = ComboBox::from_id_salt("reverse side")
            .selected_text(text(self.cloth.back))
            .show_ui(ui, |ui| {
                for (choice, text) in choices {
                    ui.selectable_value(&mut self.cloth.back, choice, text);
                }
            });
        combo.response.accessible_name("Reverse side");
        ui.end_row();
    }
}
