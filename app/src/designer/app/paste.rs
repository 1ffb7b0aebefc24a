//! Images from the clipboard: pasted, they become the chart, or lie on the one that there is.
//!
//! Ctrl+V comes as an event, with the image or with text; where the clipboard has neither there is no event. The button
//! asks for the same event and, when none comes, says so.

use egui::{ColorImage, Context, Event, ViewportCommand};
use renderer_core::design::ChartImage;

use crate::designer::app::App;
use crate::designer::chart_editor::work::put;

/// Frames to wait for an answer of the clipboard.
const PATIENCE: u32 = 3;

impl App {
    /// Asks for what the clipboard has.
    pub(super) fn ask_to_paste(&mut self, ctx: &Context) {
        self.shell.pasting = Some(PATIENCE);
        ctx.send_viewport_cmd(ViewportCommand::RequestPaste);
        ctx.request_repaint();
    }

    /// Takes what was pasted in this frame.
    pub(super) fn take_pasted(&mut self, ctx: &Context) {
        let image = ctx.input(|i| {
            i.events.iter().find_map(|event| match event {
                Event::PasteImage(image) => Some(image.clone()),
                _ => None,
            })
        });
        if let Some(image) = image {
            self.shell.pasting = None;
            match chart_of(&image) {
                Ok(pixels) if self.has_chart() => self.add_picture(pixels, None),
                Ok(pixels) => {
                    put(&mut self.document.design.chart, pixels);
                    self.document.name_step("paste chart".into());
                }
                Err(why) => self.shell.notices.error("Not pasted", why),
            }
            return;
        }
        let has_text = ctx.input(|i| i.events.iter().any(|e| matches!(e, Event::Paste(_))));
        if has_text && !ctx.text_edit_focused() {
            self.shell.pasting = None;
            self.shell.notices.error(
                "Not pasted",
                "The clipboard holds text, not an image. Copy the image itself, or open its file.",
            );
            return;
        }
        match self.shell.pasting {
            None => {}
            Some(0) => {
                self.shell.pasting = None;
                self.shell.notices.error(
                    "Not pasted",
                    "The clipboard holds no image, or there is no clipboard. Copy an image, or open its file.",
                );
            }
            Some(left) => {
                self.shell.pasting = Some(left - 1);
                ctx.request_repaint();
            }
        }
    }
}

/// A pasted image as a chart.
fn chart_of(image: &ColorImage) -> Result<ChartImage, String> {
    let [width, height] = image.size;
    let chart = ChartImage::from_fn(width, height, |x, y| {
        image.pixels[y * width + x].to_srgba_unmultiplied()
    });
    let most = ChartImage::MAX_SIDE;
    chart.ok_or_else(|| {
        format!("The image in the clipboard has {width} × {height} pixels, allowed are 1 × 1 to {most} × {most}.")
    })
}
