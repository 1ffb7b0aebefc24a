//! The window that asks how large the screen's pixels are: a bar that the user makes as long as a real ruler says.

use egui::{
    Align2, Button, Color32, Context, CursorIcon, EventFilter, FontId, Id, Key, Sense, Stroke, Ui,
    WidgetInfo, Window, pos2, vec2,
};

use super::screen::{DPI_RANGE, MM_PER_INCH, Screen};
use crate::designer::widgets::{NumberField, style};

/// Width of the window's inside, points.
const WIDTH: f32 = 600.0;
/// Lengths of the bar, mm: the first that fits.
const LENGTHS_MM: [f32; 3] = [100.0, 50.0, 20.0];

/// Shows the window if it is open.
pub fn show(ctx: &Context, screen: &mut Screen) {
    let mut is_open = *screen.is_calibrating();
    let mut is_done = false;
    Window::new("Size of the screen")
        .open(&mut is_open)
        .collapsible(false)
        .resizable(false)
        .pivot(Align2::CENTER_CENTER)
        .default_pos(ctx.content_rect().center())
        .show(ctx, |ui| {
            ui.set_width(WIDTH);
            is_done = contents(ui, screen);
        });
    *screen.is_calibrating() = is_open && !is_done;
}

fn contents(ui: &mut Ui, screen: &mut Screen) -> bool {
    let mut dpi = screen.dots_per_inch(ui.ctx());
    let before = dpi;
    let bar_mm = ruler(ui, &mut dpi);
    ui.label(format!(
        "Hold a ruler to the screen and drag the bar's right end until the bar is {bar_mm} mm long. Then 1:1 shows \
        the cloth in its real size."
    ));
    ui.add_space(6.0);
    ui.horizontal(|ui| {
        let label = ui.label("Dots per inch");
        NumberField::new(&mut dpi, "dpi", DPI_RANGE)
            .speed(0.1)
            .max_decimals(1)
            .show(ui)
            .labelled_by(label.id)
            .on_hover_text(
                "Pixels of the screen in an inch, if you know them: 25.4 × its width in pixels ÷ its width in mm.",
            );
        ui.weak(if screen.is_calibrated() {
            "measured"
        } else {
            "assumed from the system's scale, not measured"
        });
    });
    if dpi != before {
        screen.set_dots_per_inch(Some(dpi));
    }
    ui.add_space(6.0);
    ui.horizontal(|ui| {
        let is_done = ui.button("Done").clicked();
        let forget = ui.add_enabled(screen.is_calibrated(), Button::new("Forget the measure"));
        let forget =
            forget.on_hover_text("Assumes again 96 dots per inch times the system's scale.");
        if forget.clicked() {
            screen.set_dots_per_inch(None);
        }
        is_done
    })
    .inner
}

/// A bar whose right end can be dragged, or moved by the arrow keys; returns the length it should have, mm.
fn ruler(ui: &mut Ui, dpi: &mut f64) -> f32 {
    let pixels_per_point = f64::from(ui.pixels_per_point());
    let points_per_mm = |dpi: f64| (dpi / MM_PER_INCH / pixels_per_point) as f32;
    let fits = |mm: &f32| mm * points_per_mm(*dpi) <= WIDTH - 10.0;
    let bar_mm = LENGTHS_MM.into_iter().find(fits).unwrap_or(10.0);
    let (rect, _) = ui.allocate_exact_size(vec2(WIDTH, 44.0), Sense::hover());
    let length = bar_mm * points_per_mm(*dpi);
    let end = rect.left() + length;
    let grip = egui::Rect::from_center_size(pos2(end, rect.top() + 15.0), vec2(14.0, 34.0));
    let id = Id::unique("ruler of the screen");
    let grip = ui.interact(grip, id, Sense::click_and_drag());
    grip.widget_info(|| WidgetInfo::slider(true, *dpi, "Right end of the bar"));
    let mut moved = grip.drag_delta().x;
    if grip.clicked() || grip.drag_started() {
        grip.request_focus();
    }
    if grip.has_focus() {
        let keep = EventFilter {
            horizontal_arrows: true,
            ..EventFilter::default()
        };
        ui.memory_mut(|memory| memory.set_focus_lock_filter(id, keep));
        let presses = |key| ui.input(|i| i.num_presses(key) as f32);
        // A pixel a press.
        moved += (presses(Key::ArrowRight) - presses(Key::ArrowLeft)) / pixels_per_point as f32;
    }
    if moved != 0.0 {
        let wanted = (length + moved).clamp(40.0, WIDTH - 10.0);
        *dpi = f64::from(wanted / bar_mm) * pixels_per_point * MM_PER_INCH;
    }
    let visuals = ui.visuals();
    let (ground, line) = (style::accent(visuals), Color32::WHITE);
    let bar = egui::Rect::from_min_max(rect.left_top(), pos2(end, rect.top() + 30.0));
    let painter = ui.painter();
    painter.rect_filled(bar, 0.0, ground);
    for mm in (0..=bar_mm as u32).step_by(5) {
        let x = rect.left() + mm as f32 * points_per_mm(*dpi);
        let height = if mm % 10 == 0 { 12.0 } else { 6.0 };
        painter.line_segment(
            [pos2(x, bar.bottom() - height), pos2(x, bar.bottom())],
            Stroke::new(1.0, line),
        );
    }
    let text = visuals.text_color();
    for mm in [0.0, bar_mm / 2.0, bar_mm] {
        let x = rect.left() + mm * points_per_mm(*dpi);
        let (anchor, place) = match mm {
            0.0 => (Align2::LEFT_TOP, pos2(x, bar.bottom() + 2.0)),
            _ => (Align2::CENTER_TOP, pos2(x, bar.bottom() + 2.0)),
        };
        painter.text(place, anchor, mm, FontId::proportional(10.0), text);
    }
    let thick = if grip.hovered() || grip.has_focus() {
        3.0
    } else {
        1.5
    };
    painter.line_segment(
        [pos2(end, rect.top()), pos2(end, bar.bottom() + 2.0)],
        Stroke::new(thick, visuals.strong_text_color()),
    );
    grip.on_hover_cursor(CursorIcon::ResizeHorizontal)
        .on_hover_text(
            "Drag, or move with the arrow keys, until the bar has its length on a real ruler.",
        );
    bar_mm
}
