//! Opening designs and the images they name: read on a thread, taken over when they are whole.

use std::path::{Path, PathBuf};

use egui::Context;
use renderer_core::design::{ChartImage, EnvironmentImage, EnvironmentKind, FormKind, HeightImage};

use crate::designer::app::App;
use crate::designer::document::Document;
use crate::designer::shell::command::Command;
use crate::designer::shell::dialogs::Purpose;
use crate::designer::shell::questions::Question;
use crate::designer::tasks::{Poll, Task};
use crate::files::{self, FileError, Opened, OwnImages, Shipped};

/// A file that was read on another thread.
pub(super) enum Loaded {
    Design(PathBuf, Result<Box<(Opened, OwnImages)>, FileError>),
    Chart(PathBuf, Result<ChartImage, FileError>),
    Nap(PathBuf, Result<ChartImage, FileError>),
    Environment(PathBuf, Result<EnvironmentImage, FileError>),
    Height(PathBuf, Result<HeightImage, FileError>),
}

impl App {
    pub(in crate::designer::app) fn load_preset(&mut self, ctx: &Context, path: PathBuf) {
        self.filing.replaces = Some(self.document.revision());
        self.filing.loading = Some(Task::start(ctx, move || {
            let opened = files::open_to_edit(&path).map(Box::new);
            Loaded::Design(path, opened)
        }));
    }

    pub(super) fn load_shipped(&mut self, ctx: &Context, name: String) {
        let Some(shipped) = Shipped::named(&name) else {
            return;
        };
        self.filing.replaces = Some(self.document.revision());
        self.filing.loading = Some(Task::start(ctx, move || {
            let opened = shipped.open();
            let opened = opened.map(|opened| Box::new((opened, OwnImages::default())));
            Loaded::Design(name.into(), opened)
        }));
    }

    pub(in crate::designer::app) fn load_chart(&mut self, ctx: &Context, path: PathBuf) {
        self.filing.remember_folder(Purpose::OpenChart.key(), &path);
        self.filing.loading = Some(Task::start(ctx, move || {
            let path = std::path::absolute(&path).unwrap_or(path);
            let chart = files::load_chart(&path);
            Loaded::Chart(path, chart)
        }));
    }

    pub(in crate::designer::app) fn load_nap(&mut self, ctx: &Context, path: PathBuf) {
        self.filing.remember_folder(Purpose::OpenNap.key(), &path);
        self.filing.loading = Some(Task::start(ctx, move || {
            let path = std::path::absolute(&path).unwrap_or(path);
            let map = files::load_nap(&path);
            Loaded::Nap(path, map)
        }));
    }

    pub(in crate::designer::app) fn load_environment(&mut self, ctx: &Context, path: PathBuf) {
        let purpose = Purpose::OpenEnvironment.key();
        self.filing.remember_folder(purpose, &path);
        self.filing.loading = Some(Task::start(ctx, move || {
            let path = std::path::absolute(&path).unwrap_or(path);
            let image = files::load_environment(&path);
            Loaded::Environment(path, image)
        }));
    }

    pub(in crate::designer::app) fn load_height(&mut self, ctx: &Context, path: PathBuf) {
        self.filing
            .remember_folder(Purpose::OpenHeight.key(), &path);
        self.filing.loading = Some(Task::start(ctx, move || {
            let path = std::path::absolute(&path).unwrap_or(path);
            let picture = files::load_height(&path);
            Loaded::Height(path, picture)
        }));
    }

    pub(in crate::designer::app) fn take_loaded(&mut self) {
        let Some(task) = &self.filing.loading else {
            return;
        };
        let loaded = match task.poll() {
            Poll::Pending => return,
            Poll::Lost => None,
            Poll::Ready(loaded) => Some(loaded),
        };
        self.filing.loading = None;
        match loaded {
            None => self
                .shell
                .notices
                .error("Not opened", "The file could not be read to its end."),
            Some(Loaded::Design(path, Ok(opened))) => {
                let (opened, own_images) = *opened;
                self.take_opened(path, opened, own_images);
            }
            Some(Loaded::Design(path, Err(error))) => self.tell_not_opened(&path, &error),
            Some(Loaded::Chart(path, Ok(image))) => {
                let chart = &mut self.document.design.chart;
                chart.image = Some(path.to_string_lossy().into_owned());
                chart.pixels = Some(image);
            }
            Some(Loaded::Chart(_, Err(error))) => {
                self.shell
                    .notices
                    .error("Chart not opened", error.to_string());
            }
            Some(Loaded::Nap(path, Ok(image))) => {
                let nap = &mut self.document.design.nap;
                nap.image = Some(path.to_string_lossy().into_owned());
                nap.pixels = Some(image);
            }
            Some(Loaded::Nap(_, Err(error))) => {
                self.shell
                    .notices
                    .error("Nap map not opened", error.to_string());
            }
            Some(Loaded::Environment(path, Ok(image))) => {
                let environment = &mut self.document.design.light.environment;
                environment.kind = EnvironmentKind::Image;
                environment.image = Some(path.to_string_lossy().into_owned());
                environment.pixels = Some(image);
            }
            Some(Loaded::Environment(_, Err(error))) => {
                self.shell
                    .notices
                    .error("Surroundings not opened", error.to_string());
            }
            Some(Loaded::Height(path, Ok(picture))) => {
                let form = &mut self.document.design.form;
                form.kind = FormKind::Height;
                form.image = Some(path.to_string_lossy().into_owned());
                form.pixels = Some(picture);
                self.viewport.fit(&self.document.design);
            }
            Some(Loaded::Height(_, Err(error))) => {
                self.shell
                    .notices
                    .error("Height picture not opened", error.to_string());
            }
        }
    }

    fn take_opened(&mut self, path: PathBuf, opened: Opened, own_images: OwnImages) {
        self.document.settle(false);
        if self.document.is_unsaved() && self.filing.replaces != Some(self.document.revision()) {
            // Edited while the file was read.
            self.filing.asked = Some(match opened.origin {
                files::Origin::Program => Command::OpenShipped(path.to_string_lossy().into_owned()),
                _ => Command::OpenPreset(path),
            });
            return;
        }
        if !opened.warnings.is_empty() {
            self.shell
                .notices
                .error("Not everything was opened", opened.warnings.join("\n"));
        }
        if opened.origin != files::Origin::Program {
            self.filing.settings.add_recent(&path);
            self.filing
                .remember_folder(Purpose::OpenPreset.key(), &path);
        }
        self.set_document(Document::opened(opened, path));
        self.document.own_images = own_images;
    }

    fn tell_not_opened(&mut self, path: &Path, error: &FileError) {
        let recent = &mut self.filing.settings;
        let is_gone = matches!(error, FileError::Read { .. }) && !path.exists();
        if is_gone && recent.recent.iter().any(|recent| recent == path) {
            recent.remove_recent(path);
            let text = format!("{error}\nIt was taken off the list of recent files.");
            self.shell.notices.error("Not opened", text);
        } else {
            self.shell
                .notices
                .error("Preset not opened", error.to_string());
        }
    }

    /// A file was dropped on the window.
    pub(in crate::designer::app) fn take_dropped(&mut self, path: PathBuf) {
        if self.filing.is_asking() {
            let text = "Answer the question first, then drop the file again.";
            return self.shell.notices.error("Not opened", text);
        }
        let ending = path.extension().map(|e| e.to_string_lossy().to_lowercase());
        match ending.as_deref() {
            Some("toml" | files::BUNDLE_ENDING) => self.shell.commands.push(Command::OpenPreset(path)),
            Some("png") if files::carries_design(&path) => {
                let name = path.file_name().unwrap_or(path.as_os_str());
                let text = format!(
                    "{} is a picture of a design, and carries that design.",
                    name.to_string_lossy()
                );
                self.filing.question = Some(
                    Question::new("Open its design?", text)
                        .answer("Open its design", Command::OpenPreset(path.clone()))
                        .answer("Use as chart", Command::UseChart(path)),
                );
            }
            Some("png" | "jpg" | "jpeg") => self.shell.commands.push(Command::UseChart(path)),
            Some("hdr" | "exr") => self.shell.commands.push(Command::UseEnvironment(path)),
            _ => self.shell.notices.error(
                "Not opened",
                format!(
                    "{}: drop a design (.toml, .towel, or a .png exported here), a chart image (.png, .jpg) or an \
                    image of the surroundings (.hdr, .exr).",
                    path.display()
                ),
            ),
        }
    }
}
