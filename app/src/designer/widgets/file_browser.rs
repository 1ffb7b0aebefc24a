//! A file dialog inside the window, for machines where no system dialog can open: a path to type, and folders to walk.

use std::path::{Path, PathBuf};

use crate::designer::widgets::style;
use egui::{
    Align, Align2, Context, Id, Key, Layout, Modal, RichText, ScrollArea, TextEdit, Ui, vec2,
};

/// What kind of file is asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FileKind {
    /// Title of the dialog.
    pub title: &'static str,
    /// What the files are called.
    pub name: &'static str,
    /// Endings without the dot; the first is added to a name that has none of them when saving.
    pub endings: &'static [&'static str],
    /// Whether a file will be written.
    pub saving: bool,
}

impl FileKind {
    /// The path with the first ending behind its name, unless the name has one of them already: what stands behind
    /// another dot belongs to the name, as in "Beach 2.5".
    pub fn complete(&self, path: &Path) -> PathBuf {
        let has_one = path.extension().is_some_and(|found| {
            let mut endings = self.endings.iter();
            endings.any(|ending| found.eq_ignore_ascii_case(ending))
        });
        match self.endings.first() {
            Some(first) if !has_one => {
                let mut name = path.as_os_str().to_owned();
                name.push(".");
                name.push(first);
                name.into()
            }
            _ => path.to_owned(),
        }
    }
}

/// An open dialog.
#[derive(Debug, Clone)]
pub struct FileBrowser {
    kind: FileKind,
    folder: PathBuf,
    entries: Result<Vec<Entry>, String>,
    text: String,
    asked_to_replace: Option<PathBuf>,
    focused: bool,
}

#[derive(Debug, Clone)]
struct Entry {
    name: String,
    is_folder: bool,
}

/// What the user decided.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Browsed {
    /// This file.
    Chosen(PathBuf),
    /// None.
    Cancelled,
}

/// Height of the list of files, points, where the window has room for it;
const LIST_HEIGHT: f32 = 220.0;
/// and what the dialog has above and below it.
const AROUND_LIST: f32 = 190.0;

impl FileBrowser {
    /// A dialog that starts in `folder` with `name` in its path field.
    pub fn new(kind: FileKind, folder: &Path, name: &str) -> Self {
        let mut browser = Self {
            kind,
            folder: PathBuf::new(),
            entries: Ok(Vec::new()),
            text: name.into(),
            asked_to_replace: None,
            focused: false,
        };
        browser.enter(folder);
        browser
    }

    /// A dialog that asks whether to replace the file at `path`.
    pub fn asking_to_replace(kind: FileKind, path: PathBuf) -> Self {
        let folder = path.parent().unwrap_or(Path::new("."));
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let browser = Self::new(kind, folder, &name);
        Self {
            asked_to_replace: Some(path),
            ..browser
        }
    }

    /// Shows the dialog; `Some` when the user is done with it.
    pub fn show(&mut self, ctx: &Context) -> Option<Browsed> {
        let mut result = None;
        let list_height = (ctx.content_rect().height() - AROUND_LIST).clamp(60.0, LIST_HEIGHT);
        let modal = Modal::new(Id::unique("file browser"))
            .frame(style::dialog(ctx))
            .show(ctx, |ui| {
                ui.set_width(520.0);
                ui.heading(self.kind.title);
                ui.add_space(4.0);
                self.folder_row(ui);
                self.list(ui, list_height, &mut result);
                self.path_row(ui, &mut result);
                self.buttons(ui, &mut result);
            });
        if modal.should_close() && result.is_none() {
            result = Some(Browsed::Cancelled);
        }
        result
    }

    fn folder_row(&mut self, ui: &mut Ui) {
        let mut go_to = None;
        ui.horizontal(|ui| {
            let parent = self.folder.parent().map(Path::to_path_buf);
            let up = ui.add_enabled(parent.is_some(), egui::Button::new("Up"));
            if up.on_hover_text("Go to the folder above").clicked() {
                go_to = parent;
            }
            let text = RichText::new(self.folder.display().to_string()).weak();
            ui.add(egui::Label::new(text).truncate());
        });
        if let Some(folder) = go_to {
            self.enter(&folder);
        }
    }

    fn list(&mut self, ui: &mut Ui, height: f32, result: &mut Option<Browsed>) {
        let mut go_to = None;
        egui::Frame::new()
            .fill(ui.visuals().extreme_bg_color)
            .corner_radius(4)
            .inner_margin(4)
            .show(ui, |ui| {
                ui.set_min_size(vec2(ui.available_width(), height));
                ScrollArea::vertical()
                    .max_height(height)
                    .auto_shrink(false)
                    .show(ui, |ui| match &self.entries {
                        Err(error) => {
                            ui.colored_label(ui.visuals().error_fg_color, error);
                        }
                        Ok(entries) if entries.is_empty() => {
                            ui.weak(format!("No {} here.", self.kind.name));
                        }
                        Ok(entries) => {
                            for entry in entries {
                                let text = if entry.is_folder {
                                    format!("{}/", entry.name)
                                } else {
                                    entry.name.clone()
                                };
                                let chosen = !entry.is_folder && entry.name == self.text;
                                let row = ui.add_sized(
                                    [ui.available_width(), 20.0],
                                    egui::Button::selectable(chosen, text)
                                        .right_text("")
                                        .truncate(),
                                );
                                if row.clicked() && entry.is_folder {
                                    go_to = Some(self.folder.join(&entry.name));
                                } else if row.clicked() {
                                    self.text.clone_from(&entry.name);
                                    self.asked_to_replace = None;
                                }
                                if row.double_clicked() && !entry.is_folder && !self.kind.saving {
                                    *result = Some(Browsed::Chosen(self.folder.join(&entry.name)));
                                }
                            }
                        }
                    });
            });
        if let Some(folder) = go_to {
            self.enter(&folder);
        }
    }

    fn path_row(&mut self, ui: &mut Ui, result: &mut Option<Browsed>) {
        ui.horizontal(|ui| {
            let label = ui.label("Path");
            let field = TextEdit::singleline(&mut self.text)
                .desired_width(ui.available_width())
                .align(Align2::LEFT_CENTER)
                .hint_text("name, or a whole path");
            let field = ui.add(field).labelled_by(label.id);
            if field.changed() {
                self.asked_to_replace = None;
            }
            if !self.focused {
                self.focused = true;
                field.request_focus();
            }
            if field.lost_focus() && ui.input(|i| i.key_pressed(Key::Enter)) {
                self.confirm(result);
            }
        });
        if let Some(path) = &self.asked_to_replace {
            let name = path.file_name().unwrap_or(path.as_os_str());
            let text = format!("{} exists. Replace it?", name.to_string_lossy());
            ui.colored_label(ui.visuals().warn_fg_color, text);
        }
    }

    fn buttons(&mut self, ui: &mut Ui, result: &mut Option<Browsed>) {
        ui.add_space(4.0);
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            let verb = match (self.kind.saving, &self.asked_to_replace) {
                (false, _) => "Open file",
                (true, None) => "Save file",
                (true, Some(_)) => "Replace file",
            };
            let possible = !self.text.trim().is_empty();
            if ui.add_enabled(possible, egui::Button::new(verb)).clicked() {
                self.confirm(result);
            }
            if ui.button("Cancel").clicked() {
                *result = Some(Browsed::Cancelled);
            }
        });
    }

    /// Takes the path field: a folder is entered, a file chosen, an existing file asked about before it is replaced.
    fn confirm(&mut self, result: &mut Option<Browsed>) {
        let text = self.text.trim();
        if text.is_empty() {
            return;
        }
        // `join` of an absolute path is that path.
        let mut path = self.folder.join(text);
        if path.is_dir() {
            self.text.clear();
            self.focused = false;
            self.enter(&path);
            return;
        }
        if self.kind.saving {
            path = self.kind.complete(&path);
        }
        if self.kind.saving && path.exists() && self.asked_to_replace.as_ref() != Some(&path) {
            self.asked_to_replace = Some(path);
            self.focused = false;
            return;
        }
        *result = Some(Browsed::Chosen(path));
    }

    fn enter(&mut self, folder: &Path) {
        self.folder = std::path::absolute(folder).unwrap_or_else(|_| folder.into());
        self.entries = read_folder(&self.folder, self.kind.endings);
    }
}

/// Folders, then files with one of the endings, each by name; hidden ones left out.
fn read_folder(folder: &Path, endings: &[&str]) -> Result<Vec<Entry>, String> {
    let failed = |error: std::io::Error| format!("{} cannot be read: {error}", folder.display());
    let mut entries = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        let Some(name) = path
            .file_name()
            .map(|name| name.to_string_lossy().into_owned())
        else {
            continue;
        };
        let is_folder = path.is_dir();
        let ending = path.extension().map(|e| e.to_string_lossy().to_lowercase());
        let fits = is_folder || ending.is_some_and(|ending| endings.contains(&ending.as_str()));
        if fits && !name.starts_with('.') {
            entries.push(Entry { name, is_folder });
        }
    }
    entries.sort_by_key(|entry| (!entry.is_folder, entry.name.to_lowercase()));
    Ok(entries)
}
