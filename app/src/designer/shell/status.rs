//! The status bar: how far the picture is, what it is made of, what lies under the pointer, what renders.

use egui::{Color32, RichText, Sense, Sides, Stroke, StrokeKind, TextStyle, Ui, vec2};
use renderer_core::design::Design;
use renderer_core::render::BackendKind;

use crate::designer::export::UnderWay;
use crate::designer::render_thread::draft_lighting::LiveLight;
use crate::designer::render_thread::{Denoising, ViewState};
use crate::designer::shell::command::Command;
use crate::designer::shell::view_bar::{DENOISE, backend_name, backends, live_lights};
use crate::designer::viewport::command::ViewCommand;
use crate::designer::viewport::{Viewport, progress_text};
use crate::designer::widgets::shortened;

/// Shows the status bar.
pub fn show(
    ui: &mut Ui,
    design: &Design,
    viewport: &Viewport,
    export: Option<UnderWay>,
    commands: &mut Vec<Command>,
) {
    Sides::new().shrink_left().truncate().show(
        ui,
        |ui| left(ui, viewport),
        |ui| {
            device(ui, viewport, commands);
            light(ui, design, viewport, commands);
            denoising(ui, viewport, commands);
            if let Some(export) = export {
                exporting(ui, &export, commands);
            }
            readout(ui, viewport);
        },
    );
}

/// How far an export is; a click opens its window.
fn exporting(ui: &mut Ui, export: &UnderWay, commands: &mut Vec<Command>) {
    let UnderWay { name, share, left } = export;
    let text = format!("Exporting {:.0} % · {left}", 100.0 * share);
    let what =
        format!("{name} is being rendered beside editing. Click to see more, or to cancel it.");
    if ui.button(text).on_hover_text(what).clicked() {
        commands.push(Command::Export);
    }
}

/// One thing that the status bar says, and what it means.
struct Part(String, String);

fn parts(viewport: &Viewport, state: &ViewState, magnification: Option<f64>) -> Vec<Part> {
    let mut parts = vec![Part(
        progress_text(state),
        "samples of every pixel, and the time they took".into(),
    )];
    let mut say = |text: String, what: &str| parts.push(Part(text, what.into()));
    let denoised = state.picture.denoised;
    if let Some(denoised) = denoised {
        let what = format!(
            "what is shown is denoised, of so many samples: {:.0} % of it, the rest is as it is. The bar at the right \
            shows the picture without",
            100.0 * denoised.share
        );
        say(format!("denoised of {}", denoised.samples), &what);
    }
    let error = match denoised {
        Some(denoised) => denoised.error,
        None => state.picture.progress.error_estimate,
    };
    if let (false, Some(error)) = (state.picture.is_reduced, error) {
        let text = format!("error {:.1} %", 100.0 * error);
        say(
            text,
            "how far the picture may still be from its final state",
        );
    }
    let counts = state.scene.counts;
    say(format!("{} loops", counts.planted), "loops on both faces");
    if counts.dropped > 0 {
        let text = format!("{} dropped", counts.dropped);
        say(text, "loops left out because their shape was impossible");
    }
    let [width, height] = viewport.size();
    let longest = state.size[0].max(state.size[1]);
    let is_smaller = longest > 0 && longest < width.max(height);
    if is_smaller {
        let [width, height] = state.size;
        let text = format!("{width} × {height} px, enlarged");
        say(
            text,
            "the picture is drawn smaller and enlarged: more is beyond this GPU or its memory",
        );
    } else {
        say(format!("{width} × {height} px"), "size of the picture");
    }
    let device = state.device.as_ref();
    let memory = match device.map(|device| device.kind) {
        Some(BackendKind::Gpu) => "memory taken on the GPU",
        _ => "memory that rendering takes beside the design",
    };
    let bytes = device.map_or(0, |device| device.bytes);
    say(format!("{:.1} MB", bytes as f64 / 1e6), memory);
    if let Some(magnification) = magnification {
        let measure = if viewport.screen_is_measured() {
            "size on the screen : size of the cloth"
        } else {
            "size on the screen : size of the cloth, if the screen's pixels are as large as the system says; Display, \
            Size of the screen tells better"
        };
        say(scale_text(magnification), measure);
    }
    parts.retain(|Part(text, _)| !text.is_empty());
    parts
}

/// `1:1`, `2.5:1`, `1:8`.
fn scale_text(magnification: f64) -> String {
    let short = |ratio: f64| {
        let text = if ratio < 9.95 {
            format!("{ratio:.1}")
        } else {
            format!("{ratio:.0}")
        };
        text.trim_end_matches(".0").to_owned()
    };
    if magnification >= 1.0 {
        format!("{}:1", short(magnification))
    } else {
        format!("1:{}", short(1.0 / magnification))
    }
}

fn left(ui: &mut Ui, viewport: &Viewport) {
    let state = viewport.state();
    let parts = parts(viewport, state, viewport.magnification(ui.ctx()));
    let lines = parts
        .iter()
        .map(|Part(text, what)| format!("{text}: {what}"));
    let tooltip = lines.collect::<Vec<_>>().join("\n");
    ui.label(RichText::new(fitting(ui, &parts)).weak())
        .on_hover_text(tooltip);
    if !state.scene.warnings.is_empty() {
        let lines: Vec<String> = state
            .scene
            .warnings
            .iter()
            .map(ToString::to_string)
            .collect();
        let count = lines.len();
        let plural = if count == 1 { "" } else { "s" };
        let text = format!("{count} warning{plural}");
        ui.colored_label(ui.visuals().warn_fg_color, text)
            .on_hover_text(lines.join("\n"));
    }
}

/// As many of the parts as there is room for, the first always.
fn fitting(ui: &Ui, parts: &[Part]) -> String {
    let font = TextStyle::Body.resolve(ui.style());
    let mut fitting = String::new();
    for Part(text, _) in parts {
        let longer = match fitting.as_str() {
            "" => text.clone(),
            shorter => format!("{shorter}   ·   {text}"),
        };
        let galley = ui
            .painter()
            .layout_no_wrap(longer.clone(), font.clone(), Color32::WHITE);
        if !fitting.is_empty() && galley.size().x > ui.available_width() {
            break;
        }
        fitting = longer;
    }
    fitting
}

/// What lies under the pointer.
fn readout(ui: &mut Ui, viewport: &Viewport) {
    let Some(readout) = viewport.readout() else {
        return;
    };
    // From the right: the bar's right side is laid out that way.
    if let (Some(yarn), Some([r, g, b])) = (readout.yarn(), readout.colour) {
        ui.label(RichText::new(format!("#{r:02x}{g:02x}{b:02x}")).weak());
        let (rect, _) = ui.allocate_exact_size(vec2(12.0, 12.0), Sense::hover());
        let outline = Stroke::new(1.0, ui.visuals().weak_text_color());
        ui.painter()
            .rect(rect, 2.0, yarn, outline, StrokeKind::Inside);
    }
    let what = "The cell under the pointer, counted from the left of the near edge; the loop's length from its root, \
        after turbulence; its yarn's colour in the chart.";
    ui.label(readout.text()).on_hover_text(what);
}

fn device(ui: &mut Ui, viewport: &Viewport, commands: &mut Vec<Command>) {
    let state = viewport.state();
    let chosen = backend_name(viewport.choice());
    let name = state.device.as_ref().map_or_else(
        || chosen.into(),
        |device| format!("{}: {}", device.kind.name(), shortened(&device.name, 36)),
    );
    let button = ui.menu_button(name, |ui| backends(ui, viewport.choice(), commands));
    let stands_in = state.device.as_ref().is_some_and(|device| device.stands_in);
    let why = match (stands_in, state.picture.progress.done) {
        (false, _) => "",
        (true, false) => {
            "\nThe GPU was not ready for this picture: the processor draws the same meanwhile."
        }
        (true, true) => {
            "\nThe processor had this picture done before the GPU was ready; the next is the GPU's."
        }
    };
    let device = state.device.as_ref().map_or("", |device| &device.name);
    let tooltip = format!("{device}{why}\nChosen: {chosen}. Click to render with another backend.");
    button
        .response
        .accessible_name("Backend")
        .on_hover_text(tooltip.trim_start());
}

/// Shows the picture denoised or as it is, a click each; says so where it cannot be denoised.
fn denoising(ui: &mut Ui, viewport: &Viewport, commands: &mut Vec<Command>) {
    match &viewport.state().denoising {
        Denoising::Looking => {}
        Denoising::Missing(why) => {
            ui.label(RichText::new("no denoiser").weak())
                .on_hover_text(why);
        }
        Denoising::Ready(by) => {
            let is_on = viewport.denoises();
            let button = ui.selectable_label(is_on, "denoise");
            let what = format!(
                "{DENOISE}\nBy {by}. Click to show the picture {}.",
                match is_on {
                    true => "as it is",
                    false => "denoised",
                }
            );
            if button.on_hover_text(what).clicked() {
                commands.push(Command::View(ViewCommand::Denoise));
            }
        }
    }
}

fn light(ui: &mut Ui, design: &Design, viewport: &Viewport, commands: &mut Vec<Command>) {
    // Where both are the same there is nothing to choose.
    if !LiveLight::matters(design) {
        return;
    }
    let light = viewport.light;
    let button = ui.menu_button(light.name(), |ui| live_lights(ui, light, commands));
    button
        .response
        .accessible_name("Light in the viewport")
        .on_hover_text(light.what());
}
