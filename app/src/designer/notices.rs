//! Messages over the viewport: errors and news, each until it is dismissed or settled.

use egui::{Align, Color32, Frame, Layout, Margin, RichText, ScrollArea, Stroke, Ui};

/// How grave a notice is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Gravity {
    /// Something failed.
    Error,
    /// Something is done.
    News,
}

/// A message.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Notice {
    /// How grave it is.
    pub gravity: Gravity,
    /// What happened, in a few words.
    pub title: String,
    /// The whole story: file, place, what to do.
    pub text: String,
}

/// All messages not yet dismissed.
#[derive(Debug, Default)]
pub struct Notices {
    list: Vec<Notice>,
}

/// Messages kept at most; older ones go first.
const MOST: usize = 4;

impl Notices {
    /// Tells of a failure.
    pub fn error(&mut self, title: impl Into<String>, text: impl Into<String>) {
        self.add(Gravity::Error, title.into(), text.into());
    }

    /// Tells that something is done. Takes the place of earlier such news.
    pub fn news(&mut self, title: impl Into<String>, text: impl Into<String>) {
        self.list.retain(|notice| notice.gravity != Gravity::News);
        self.add(Gravity::News, title.into(), text.into());
    }

    fn add(&mut self, gravity: Gravity, title: String, text: String) {
        let notice = Notice {
            gravity,
            title,
            text,
        };
        self.list.retain(|other| *other != notice);
        self.list.push(notice);
        let excess = self.list.len().saturating_sub(MOST);
        self.list.drain(..excess);
    }

    /// Shows all messages, the newest first.
    pub fn show(&mut self, ui: &mut Ui) {
        let mut dismissed = None;
        for (index, notice) in self.list.iter().enumerate().rev() {
            if show_one(ui, notice) {
                dismissed = Some(index);
            }
        }
        if let Some(index) = dismissed {
            self.list.remove(index);
        }
    }
}

/// Shows a message that stays for as long as its cause: no button.
pub fn show_standing(ui: &mut Ui, title: &str, text: &str) {
    banner(ui, ui.visuals().error_fg_color, title, text, false);
}

fn show_one(ui: &mut Ui, notice: &Notice) -> bool {
    let colour = match notice.gravity {
        Gravity::Error => ui.visuals().error_fg_color,
        Gravity::News => ui.visuals().hyperlink_color,
    };
    banner(ui, colour, &notice.title, &notice.text, true)
}

fn banner(ui: &mut Ui, colour: Color32, title: &str, text: &str, dismissible: bool) -> bool {
    let mut dismissed = false;
    Frame::new()
        .fill(ui.visuals().window_fill)
        .stroke(Stroke::new(1.0, colour))
        .corner_radius(5)
        .inner_margin(Margin::symmetric(10, 6))
        .outer_margin(Margin::symmetric(0, 2))
        .show(ui, |ui| {
            ui.set_width(ui.available_width());
            ui.horizontal(|ui| {
                ui.label(RichText::new(title).strong().color(colour));
                if dismissible {
                    ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                        let button = ui.small_button("Dismiss");
                        dismissed = button
                            .accessible_name(format!("Dismiss: {title}"))
                            .clicked();
                    });
                }
            });
            if !text.is_empty() {
                ScrollArea::vertical()
                    .id_salt((title, text))
                    .max_height(120.0)
                    .auto_shrink([false, true])
                    .show(ui, |ui| ui.label(text));
            }
        });
    dismissed
}
