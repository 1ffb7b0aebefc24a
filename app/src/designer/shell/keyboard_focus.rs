//! What has the keyboard, for those who work without a pointer: a ring around it, and a panel scrolls to it when Tab
//! comes to something that is scrolled out. A press of the pointer hides the ring until Tab is pressed again.

use egui::{Context, Event, Id, Key, Response, Stroke, StrokeKind, Ui};

use crate::designer::widgets::style;

/// Distance of the ring from what it is around, and its thickness, points.
const RING: [f32; 2] = [1.0, 1.5];

/// Follows the focus from frame to frame.
#[derive(Debug, Default)]
pub struct KeyboardFocus {
    is_shown: bool,
    /// What has the keyboard.
    last: Option<Id>,
    /// Whether something had it when that frame began.
    had_focus: bool,
    /// Whether something else has it now.
    has_moved: bool,
}

impl KeyboardFocus {
    /// To be called before anything of a frame is shown.
    pub fn follow(&mut self, ctx: &Context) {
        ctx.input(|i| {
            for event in &i.events {
                match event {
                    Event::Key {
                        key: Key::Tab,
                        pressed: true,
                        ..
                    } => self.is_shown = true,
                    Event::PointerButton { pressed: true, .. } => self.is_shown = false,
                    _ => {}
                }
            }
        });
        self.had_focus = self.last.is_some();
        let focused = ctx.memory(egui::Memory::focused);
        self.has_moved = self.is_shown && focused != self.last;
        self.last = focused;
    }

    /// Whether something had the keyboard in the last frame: Escape takes it away before this one begins.
    pub fn had_focus(&self) -> bool {
        self.had_focus
    }

    /// Scrolls to what has just got the keyboard, if it is in this scroll area: to be called in it, behind its content.
    pub fn reveal(&self, ui: &Ui) {
        let focused = self.last.filter(|_| self.has_moved);
        let Some(response) = focused.and_then(|id| ui.ctx().read_response(id)) else {
            return;
        };
        // What is seen elsewhere may lie where this area's content would be if it were not scrolled out.
        let seen = response.interact_rect;
        let is_elsewhere = seen.is_positive() && !ui.clip_rect().contains(seen.center());
        let is_here =
            response.layer_id == ui.layer_id() && ui.min_rect().contains_rect(response.rect);
        if is_here && !is_elsewhere {
            ui.scroll_to_rect(response.rect.expand(8.0), None);
        }
    }

    /// Draws the ring. To be called when everything has been shown.
    pub fn ring(&self, ctx: &Context) {
        let focused = ctx.memory(egui::Memory::focused);
        if self.is_shown && focused != self.last {
            // It is scrolled to in the next frame.
            ctx.request_repaint();
        }
        let focused = focused.filter(|_| self.is_shown);
        if let Some(response) = focused.and_then(|id| ctx.read_response(id)) {
            draw(ctx, &response);
        }
    }
}

fn draw(ctx: &Context, response: &Response) {
    let [distance, thickness] = RING;
    let seen = response.interact_rect;
    if !seen.is_positive() {
        return;
    }
    let stroke = Stroke::new(thickness, style::accent(&ctx.global_style().visuals));
    let ring = seen.expand(distance).intersect(ctx.content_rect());
    ctx.layer_painter(response.layer_id)
        .rect_stroke(ring, 4.0, stroke, StrokeKind::Middle);
}
