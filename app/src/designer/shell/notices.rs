//! Messages over the viewport: errors and news, each until it is dismissed or settled.

use std::path::PathBuf;

use egui::{Align, Color32, Frame, Layout, Margin, RichText, ScrollArea, Stroke, Ui};

use crate::designer::shell::command::{Command, PresetCommand};

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
    /// A file that can be shown in its folder.
    pub file: Option<PathBuf>,
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
        self.add(Gravity::Error, title.into(), text.into(), None);
    }

    /// Tells that something is done. Takes the place of earlier such news.
    pub fn news(&mut self, title: impl Into<String>, text: impl Into<String>) {
        self.list.retain(|notice| notice.gravity != Gravity::News);
        self.add(Gravity::News, title.into(), text.into(), None);
    }

    /// As [`Self::news`], of a file that was written, with a button that shows it in its folder.
    pub fn news_of_file(
        &mut self,
        title: impl Into<String>,
        text: impl Into<String>,
        file: PathBuf,
    ) {
        self.list.retain(|notice| notice.gravity != Gravity::News);
        self.add(Gravity::News, title.into(), text.into(), Some(file));
    }

    fn add(&mut self, gravity: Gravity, title: String, text: String, file: Option<PathBuf>) {
        let notice = Notice {
            gravity,
            title,
            text,
            file,
        };
        self.list.retain(|other| *other != notice);
        self.list.push(notice);
        let excess = self.list.len().saturating_sub(MOST);
        self.list.drain(..excess);
    }

    /// Shows all messages, the newest first. What a button of theirs asks for.
    pub fn show(&mut self, ui: &mut Ui) -> Option<Command> {
        let mut clicked = None;
        for (index, notice) in self.list.iter().enumerate().rev() {
            if let Some(click) = show_one(ui, notice) {
                clicked = Some((index, click));
            }
        }
        match clicked? {
            (index, Click::Dismiss) => {
                self.list.remove(index);
                None
            }
            (index, Click::ShowFile) => self.list[index]
                .file
                .clone()
                .map(|file| Command::Presets(PresetCommand::Reveal(file))),
        }
    }
}

/// What was clicked on a message.
enum Click {
    Dismiss,
    ShowFile,
}

/// Shows a message that stays for as long as its cause: no button.
pub fn show_standing(ui: &mut Ui, title: &str, text: &str) {
    banner(ui, ui.visuals().error_fg_color, title, text, |_| {});
}

fn show_one(ui: &mut Ui, notice: &Notice) -> Option<Click> {
    let colour = match notice.gravity {
        Gravity::Error => ui.visuals().error_fg_color,
        Gravity::News => ui.visuals().hyperlink_color,
    };
    let mut clicked = None;
    banner(ui, colour, &notice.title, &notice.text, |ui| {
        let dismiss = ui
            .small_button("Dismiss")
            .accessible_name(format!("Dismiss: {}", notice.title));
        if dismiss.clicked() {
            clicked = Some(Click::Dismiss);
        }
        if notice.file.is_some() {
            let show = ui
                .small_button("Show in folder")
                .on_hover_text("Opens the file manager where the file is.");
            if show.clicked() {
                clicked = Some(Click::ShowFile);
            }
        }
    });
    clicked
}

/// A message with buttons at its right, the first of them outermost.
fn banner(ui: &mut Ui, colour: Color32, title: &str, text: &str, buttons: impl FnOnce(&mut Ui)) {
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
                ui.with_layout(Layout::right_to_left(Align::Center), buttons);
            });
            if !text.is_empty() {
                ScrollArea::vertical()
                    .id_salt((title, text))
                    .max_height(120.0)
                    .auto_shrink([false, true])
                    .show(ui, |ui| ui.label(text));
            }
        });
}
