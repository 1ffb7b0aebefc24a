//! What is done to presets: saved, copied, renamed, deleted, shown in the file manager.

use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command as Process;

use egui::Context;
use renderer_core::design::ImageSlot;

use crate::designer::app::App;
use crate::designer::shell::command::{Command, Place, PresetCommand};
use crate::designer::shell::questions::Question;
use crate::designer::tasks::Task;
use crate::files::{self, BUNDLE_ENDING, KnownOutside, Outside, Reading, Shipped, stem_of};

/// Why a name cannot be a file's on some platform.
fn fault_of_name(name: &str) -> Option<&'static str> {
    if name.contains(['/', '\\', ':', '<', '>', '"', '|', '?', '*'])
        || name.contains(char::is_control)
    {
        Some("A name cannot have any of / \\ : < > \" | ? *")
    } else if name.starts_with('.') || name.ends_with('.') {
        Some("A name cannot begin or end with a dot.")
    } else if name.len() > 200 {
        Some("The name is too long.")
    } else {
        None
    }
}

impl App {
    pub(super) fn perform_preset(&mut self, ctx: &Context, command: PresetCommand) {
        let Some(folder) = self.presets.folders.as_ref().map(|f| f.presets.clone()) else {
            let what = "There is no folder for your own presets on this machine.";
            self.shell.notices.error("Not done", what);
            return;
        };
        match command {
            PresetCommand::AskToSave => {
                let text = "It is kept among your own presets, its chart included.";
                let save = Command::Presets(PresetCommand::Save(String::new()));
                self.filing.question = Some(
                    Question::new("Save as preset", text)
                        .line("Name", self.document.name())
                        .answer("Save preset", save),
                );
            }
            PresetCommand::Save(name) => {
                let design = &self.document.design;
                let has_image = ImageSlot::of(design).any(|slot| slot.has_pixels(design));
                let ending = if has_image { BUNDLE_ENDING } else { "toml" };
                let path = folder.join(format!("{name}.{ending}"));
                if let Some(fault) = fault_of_name(&name) {
                    self.shell.notices.error("Preset not saved", fault);
                } else if path.exists() {
                    let replace = PresetCommand::SaveTo(path);
                    self.filing.question = Some(
                        Question::new(
                            "Replace the preset?",
                            format!("There is a preset “{name}”."),
                        )
                        .answer("Replace preset", Command::Presets(replace)),
                    );
                } else {
                    self.save_preset(ctx, path);
                }
            }
            PresetCommand::SaveTo(path) => self.save_preset(ctx, path),
            PresetCommand::Duplicate(place) => {
                let config = self.filing.folders.as_ref().map(|f| f.config.clone());
                let known = config.as_deref().map(KnownOutside::load);
                let copied = copy(&place, &folder, &known.unwrap_or_default());
                self.tell_preset("Preset not copied", copied.map(Some));
            }
            PresetCommand::AskToRename(path) => {
                let name = stem_of(&path);
                let rename = PresetCommand::Rename(path, String::new());
                self.filing.question = Some(
                    Question::new("Rename preset", "")
                        .line("Name", name)
                        .answer("Rename", Command::Presets(rename)),
                );
            }
            PresetCommand::Rename(path, name) => {
                let renamed = rename(&path, &name);
                if let Ok(to) = &renamed {
                    self.document.file_moved(&path, to);
                    self.filing.settings.remove_recent(&path);
                }
                self.tell_preset("Preset not renamed", renamed.map(Some));
            }
            PresetCommand::AskToDelete(path) => {
                let text = format!("{} is removed for good.", path.display());
                let title = format!("Delete the preset “{}”?", stem_of(&path));
                let delete = Command::Presets(PresetCommand::Delete(path));
                self.filing.question = Some(Question::new(title, text).answer("Delete", delete));
            }
            PresetCommand::Delete(path) => {
                let deleted = fs::remove_file(&path);
                self.filing.settings.remove_recent(&path);
                let deleted = deleted.map_err(|error| format!("{}: {error}", path.display()));
                self.tell_preset("Preset not deleted", deleted.map(|()| None));
            }
            PresetCommand::Reveal(path) => {
                let shown = path.clone();
                let task = Task::start(ctx, move || reveal(&shown));
                self.presets.revealing = Some((path, task));
            }
        }
    }

    fn save_preset(&mut self, ctx: &Context, path: PathBuf) {
        self.document.settle(false);
        if let Some(fault) = self.document.design.faults().first() {
            self.shell
                .notices
                .error("Preset not saved", fault.to_string());
            return;
        }
        let made = path.parent().map_or(Ok(()), fs::create_dir_all);
        let made = made.map_err(|error| format!("{}: {error}", path.display()));
        match made {
            Ok(()) => self.save_copy(ctx, path),
            Err(error) => self.shell.notices.error("Preset not saved", error),
        }
    }

    fn tell_preset(&mut self, title: &str, result: Result<Option<PathBuf>, String>) {
        self.presets.look_again();
        match result {
            Ok(Some(path)) => self
                .shell
                .notices
                .news("Preset kept", path.display().to_string()),
            Ok(None) => {}
            Err(error) => self.shell.notices.error(title, error),
        }
    }
}

/// Copies a preset into the user's folder, under a name that is free there.
fn copy(place: &Place, folder: &Path, known: &KnownOutside) -> Result<PathBuf, String> {
    let reading = Reading {
        outside: Outside::Known(known),
        ..Reading::default()
    };
    let opened = match place {
        Place::Program(name) => Shipped::named(name).ok_or("is gone")?.open(),
        Place::File(path) => files::read_design(path, reading),
    };
    let opened = opened.map_err(|error| error.to_string())?;
    let (name, from, ending) = match place {
        Place::Program(name) => {
            let has_image = opened.carried.iter().next().is_some();
            let ending = if has_image { BUNDLE_ENDING } else { "toml" };
            (name.clone(), None, ending.to_owned())
        }
        Place::File(path) => {
            let ending = path.extension().unwrap_or_default().to_string_lossy();
            let name = format!("{} copy", stem_of(path));
            (name, Some(path.as_path()), ending.into_owned())
        }
    };
    fs::create_dir_all(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let mut to = folder.join(format!("{name}.{ending}"));
    let mut number = 2;
    while to.exists() {
        to = folder.join(format!("{name} {number}.{ending}"));
        number += 1;
    }
    match (place, ending.as_str()) {
        // With its comments.
        (Place::Program(name), "toml") => {
            let text = Shipped::named(name).map_or("", |shipped| shipped.text);
            files::write_atomically(&to, text.as_bytes())
        }
        (Place::File(path), _) if path.parent() == Some(folder) => {
            let bytes = fs::read(path).map_err(|error| format!("{}: {error}", path.display()))?;
            files::write_atomically(&to, &bytes)
        }
        _ => files::save(&opened.design, &opened.carried, &to, from),
    }
    .map_err(|error| error.to_string())?;
    Ok(to)
}

fn rename(path: &Path, name: &str) -> Result<PathBuf, String> {
    if let Some(fault) = fault_of_name(name) {
        return Err(fault.into());
    }
    let ending = path.extension().unwrap_or_default().to_string_lossy();
    let to = path.with_file_name(format!("{name}.{ending}"));
    if to.exists() {
        return Err(format!("There is a preset “{name}” already."));
    }
    fs::rename(path, &to).map_err(|error| format!("{}: {error}", path.display()))?;
    Ok(to)
}

/// Shows a file in the platform's file manager.
fn reveal(path: &Path) -> Result<(), String> {
    let folder = path.parent().unwrap_or(Path::new("."));
    let (program, arguments): (_, Vec<&OsStr>) = if cfg!(windows) {
        ("explorer", vec![folder.as_os_str()])
    } else if cfg!(target_os = "macos") {
        ("open", vec![OsStr::new("-R"), path.as_os_str()])
    } else {
        ("xdg-open", vec![folder.as_os_str()])
    };
    let failed = |why: String| format!("{program}: {why}");
    let status = Process::new(program).args(arguments).status();
    let status = status.map_err(|error| failed(error.to_string()))?;
    // Explorer ends with 1 whatever it has done.
    if status.success() || cfg!(windows) {
        Ok(())
    } else {
        Err(failed(status.to_string()))
    }
}
