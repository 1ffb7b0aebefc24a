//! The document's panels, one file each, in the order one designs. A panel edits its part of the design and nothing
//! else; what it cannot do itself (open a file, move the camera) it asks for with a command.

mod cameras;
mod chart;
mod choice_row;
mod finish;
mod form;
mod height_map;
mod image_preview;
pub mod length_pictures;
mod length_table;
mod light;
mod light_presets;
mod light_sphere;
mod loop_length;
mod loop_picture;
mod nap;
mod number_row;
mod pile;
mod sheet_weave;
mod skeleton;
mod surroundings;
mod turbulence;
mod view_quality;

use std::collections::BTreeMap;

use egui::{CollapsingHeader, RichText, ScrollArea, Ui};
use renderer_core::design::{Chart, ChartImage, Design};

pub use cameras::free_name;
pub use light_presets::LightPreset;
pub use surroundings::Surroundings;

/// What panels remember that is no part of the design.
#[derive(Default)]
pub struct Panels {
    sheet_weave: sheet_weave::State,
    chart: chart::State,
    loop_length: loop_length::State,
    pile: pile::State,
    turbulence: turbulence::State,
    form: form::State,
    nap: nap::State,
    light: light::State,
    /// Whether panels are open, by title, where that is not as they start.
    pub open: BTreeMap<String, bool>,
}

/// Title of a panel, the parts of the design whose faults belong to it, and whether it starts open.
struct Title(&'static str, &'static [&'static str], bool);

const TITLES: [Title; 10] = [
    Title("Sheet & weave", &["sheet", "weave"], true),
    Title("Chart", &["chart"], true),
    Title("Loop length", &["length"], false),
    Title("Pile", &["pile"], false),
    Title("Turbulence", &["turbulence"], false),
    Title("Finish", &["finish", "nap"], false),
    Title("Skeleton", &["skeleton"], false),
    Title("Form", &["form"], false),
    Title("Light", &["light"], false),
    Title("View & quality", &["view", "quality"], false),
];

impl Panels {
    /// Panels of which these are open or closed, by title, and the others as they start.
    pub fn with_open(open: BTreeMap<String, bool>) -> Self {
        Self {
            open,
            ..Self::default()
        }
    }

    /// Titles of all panels, from top to bottom.
    pub fn titles() -> impl Iterator<Item = &'static str> {
        TITLES.iter().map(|Title(title, ..)| *title)
    }

    /// Whether the panel of the cloth's form is open.
    pub fn form_is_open(&self) -> bool {
        self.open.get("Form").copied().unwrap_or(false)
    }

    /// Whether the chart editor is open.
    pub fn chart_editor_is_open(&self) -> bool {
        self.chart.editor.is_open
    }

    /// Opens or closes the chart editor.
    pub fn toggle_chart_editor(&mut self) {
        self.chart.editor.is_open ^= true;
    }

    /// Shows the chart editor. Returns what the history is to call a change made there.
    pub fn show_chart_editor(&mut self, ui: &mut Ui, design: &mut Design) -> Option<String> {
        let (editor, yarns) = self.chart.editor_and_yarns();
        editor.show(ui, design, yarns)
    }

    /// Opens the chart editor with what was last laid on the chart chosen.
    pub fn choose_last_object(&mut self, chart: &Chart) {
        self.chart.editor.is_open = true;
        self.chart.editor.choose_last(chart);
    }

    /// The chart that the cloth shows instead of the design's, while it is tried out.
    pub fn chart_preview(&self, chart: &Chart) -> Option<&ChartImage> {
        self.chart.preview(chart)
    }

    /// Shows all panels.
    pub fn show(&mut self, ui: &mut Ui, design: &mut Design, around: &mut Surroundings<'_>) {
        self.chart.begin_frame();
        ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
            for (index, title) in TITLES.iter().enumerate() {
                let Title(name, _, starts_open) = title;
                let was_open = self.open.get(*name).copied().unwrap_or(*starts_open);
                let is_open = section(ui, title, was_open, around, |ui, around| match index {
                    0 => sheet_weave::show(ui, &mut self.sheet_weave, design),
                    1 => chart::show(ui, &mut self.chart, design, around),
                    2 => {
                        let has_yarn_table = self.chart.has_yarn_table();
                        loop_length::show(
                            ui,
                            &mut self.loop_length,
                            design,
                            has_yarn_table,
                            around,
                        );
                    }
                    3 => pile::show(ui, &mut self.pile, design, around),
                    4 => turbulence::show(ui, &mut self.turbulence, design, around),
                    5 => finish::show(ui, &mut self.nap, design, around),
                    6 => skeleton::show(ui, &mut design.skeleton),
                    7 => form::show(ui, &mut self.form, design, around.commands),
                    8 => light::show(ui, &mut self.light, design, around),
                    _ => view_quality::show(ui, design, around),
                });
                if is_open != was_open {
                    self.open.insert((*name).into(), is_open);
                }
            }
            ui.add_space(24.0);
            around.focus.reveal(ui);
        });
        sheet_weave::show_window(ui.ctx(), &mut self.sheet_weave, design);
    }
}

/// A collapsible panel, marked where its part of the design has faults, which are listed at its top, or warnings, which
/// are listed at its end: they come and go while a slider is dragged, which must not move away under the pointer.
/// Returns whether the user has it open.
fn section(
    ui: &mut Ui,
    Title(title, parts, _): &Title,
    was_open: bool,
    around: &mut Surroundings<'_>,
    body: impl FnOnce(&mut Ui, &mut Surroundings<'_>),
) -> bool {
    let concerns = |path: &str| {
        let part = path.split(['.', '[']).next().unwrap_or_default();
        parts.contains(&part)
    };
    let faults = around.faults.iter().filter(|f| concerns(&f.path));
    let faults: Vec<String> = faults.map(ToString::to_string).collect();
    let warnings = around.warnings.iter().filter(|w| concerns(&w.path));
    let warnings: Vec<String> = warnings.map(ToString::to_string).collect();
    let mut heading = RichText::new(*title).strong().size(13.5);
    if !faults.is_empty() {
        heading = heading.color(ui.visuals().error_fg_color);
    } else if !warnings.is_empty() {
        heading = heading.color(ui.visuals().warn_fg_color);
    }
    let has_fault = !faults.is_empty();
    let header = CollapsingHeader::new(heading)
        .id_salt(title)
        .default_open(was_open)
        // A fault nobody sees cannot be mended.
        .open(has_fault.then_some(true))
        .show_unindented(ui, |ui| {
            ui.spacing_mut().item_spacing.y = 3.0;
            for fault in faults {
                ui.colored_label(ui.visuals().error_fg_color, fault);
            }
            // Panels have rows of the same names, which else would be the same to egui: the menu of one would open that
            // of the other, and Tab would go round between them.
            ui.push_id(title, |ui| body(ui, around));
            for warning in warnings {
                let text = RichText::new(warning).small();
                ui.label(text.color(ui.visuals().warn_fg_color));
            }
            ui.add_space(6.0);
        });
    ui.separator();
    if has_fault {
        was_open
    } else if was_open {
        !header.fully_closed()
    } else {
        header.fully_open()
    }
}
