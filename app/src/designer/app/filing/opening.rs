//! Opening designs and the images they name: read on a thread, taken over when they are whole.

use std::path::{Path, PathBuf};

use egui::Context;
use renderer_core::design::{ChartImage, ChartObject, ImagePixels, ImageSlot};

use crate::designer::app::App;
use crate::designer::chart_editor::objects;
use crate::designer::document::Document;
use crate::designer::shell::command::{Command, OutsideChoice};
use crate::designer::shell::dialogs::Purpose;
use crate::designer::shell::questions::Question;
use crate::designer::tasks::{Poll, Task};
use crate::files::{
    self, FileError, KnownOutside, LoadedImage, Opened, Outside, OutsideImage, OwnImages, Shipped,
};

/// A file that was read on another thread.
pub(super) enum Loaded {
    Design(PathBuf, Result<Box<(Opened, OwnImages)>, FileError>),
    Image(ImageSlot, PathBuf, Result<LoadedImage, FileError>),
    Picture(PathBuf, Result<LoadedImage, FileError>),
}

impl App {
    /// Opens a design with those of its images that its file may open; asks about others.
    pub(in crate::designer::app) fn load_preset(&mut self, ctx: &Context, path: &Path) {
        self.start_loading(ctx, path, None);
    }

    /// Opens a design that names images outside its folder as the user has decided.
    pub(in crate::designer::app) fn load_preset_with(
        &mut self,
        ctx: &Context,
        path: &Path,
        choice: OutsideChoice,
    ) {
        self.start_loading(ctx, path, Some(choice));
    }

    fn start_loading(&mut self, ctx: &Context, path: &Path, choice: Option<OutsideChoice>) {
        let path = files::absolute(path);
        let config = self.filing.folders.as_ref().map(|f| f.config.clone());
        self.filing.replaces = Some(self.document.revision());
        self.filing.loading = Some(Task::start(ctx, move || {
            let opened = open(&path, choice, config.as_deref());
            Loaded::Design(path, opened.map(Box::new))
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

    pub(in crate::designer::app) fn load_image(
        &mut self,
        ctx: &Context,
        slot: ImageSlot,
        path: PathBuf,
    ) {
        let folder_key = Purpose::OpenImage(slot).key();
        self.filing.remember_folder(folder_key, &path);
        self.filing.loading = Some(Task::start(ctx, move || {
            let path = files::absolute(&path);
            let image = files::load_image(slot, &path);
            Loaded::Image(slot, path, image)
        }));
    }

    /// Reads a picture that is to lie on the chart.
    pub(in crate::designer::app) fn load_picture(&mut self, ctx: &Context, path: PathBuf) {
        self.filing.loading = Some(Task::start(ctx, move || {
            let path = files::absolute(&path);
            let image = files::load_image(ImageSlot::Object(0), &path);
            Loaded::Picture(path, image)
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
            Some(Loaded::Design(path, Err(FileError::Outside { images, .. }))) => {
                self.ask_about_outside(&path, &images);
            }
            Some(Loaded::Design(path, Err(error))) => self.tell_not_opened(&path, &error),
            Some(Loaded::Image(slot, path, Ok(image))) => self.take_image(slot, &path, image),
            Some(Loaded::Picture(path, Ok(image))) => {
                self.warn_of_images(&image.warnings);
                if let ImagePixels::Colours(pixels) = image.pixels {
                    let path = path.to_string_lossy().into_owned();
                    self.add_picture(pixels, Some(path));
                }
            }
            Some(Loaded::Picture(_, Err(error))) => {
                let heading = files::words(ImageSlot::Object(0)).not_opened;
                self.shell.notices.error(heading, error.to_string());
            }
            Some(Loaded::Image(slot, _, Err(error))) => {
                let heading = files::words(slot).not_opened;
                self.shell.notices.error(heading, error.to_string());
            }
        }
    }

    /// Lays a picture on the chart, chosen in the chart editor.
    pub(in crate::designer::app) fn add_picture(
        &mut self,
        pixels: ChartImage,
        path: Option<String>,
    ) {
        let design = &mut self.document.design;
        if objects::add_picture(design, pixels, path) {
            self.panels.choose_last_object(&design.chart);
            self.document.name_step("picture on the chart".into());
        } else {
            let most = ChartObject::MAX;
            let text =
                format!("There are {most} objects on the chart already. Flatten some of them.");
            self.shell.notices.error("Not laid on the chart", text);
        }
    }

    fn take_image(&mut self, slot: ImageSlot, path: &Path, image: LoadedImage) {
        self.warn_of_images(&image.warnings);
        let design = &mut self.document.design;
        slot.set_path(design, Some(path.to_string_lossy().into_owned()));
        slot.set_pixels(design, Some(image.pixels));
        slot.show(design);
        if slot == ImageSlot::Height {
            // Another form is seldom where the last one was.
            self.viewport.fit(&self.document.design);
        }
    }

    /// Tells what of images could not be understood or is damaged, until it is dismissed.
    fn warn_of_images(&mut self, warnings: &[String]) {
        if !warnings.is_empty() {
            let text = warnings.join("\n");
            self.shell.notices.error("Opened with a warning", text);
        }
    }

    fn take_opened(&mut self, path: PathBuf, mut opened: Opened, own_images: OwnImages) {
        self.document.settle(false);
        if self.document.is_unsaved() && self.filing.replaces != Some(self.document.revision()) {
            // Edited while the file was read.
            self.filing.asked = Some(match opened.origin {
                files::Origin::Program => Command::OpenShipped(path.to_string_lossy().into_owned()),
                _ => Command::OpenPreset(path),
            });
            return;
        }
        let left_out = opened.left_out.iter();
        let left_out = left_out.map(|image| format!("Opened without {}.", image.sentence()));
        opened.warnings.extend(left_out);
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
        // The window has it from here on: looking around is no change of the design.
        let view = opened.design.view.current.take();
        self.set_document(Document::opened(opened, path), view);
        self.document.own_images = own_images;
    }

    /// Asks whether a design may open images outside its folder.
    fn ask_about_outside(&mut self, path: &Path, images: &[OutsideImage]) {
        let name = path.file_name().unwrap_or(path.as_os_str());
        let list: Vec<String> = images.iter().map(OutsideImage::sentence).collect();
        let text = format!(
            "{} names images outside its own folder:\n{}\nOpen them if the file is yours, or from somebody you trust.",
            name.to_string_lossy(),
            list.join("\n")
        );
        let answer = |choice| Command::OpenPresetWith(path.to_owned(), choice);
        let question = Question::new("Open images from elsewhere?", text)
            .answer("Open them", answer(OutsideChoice::Open))
            .answer("Open without them", answer(OutsideChoice::LeaveOut));
        self.filing.question = Some(question);
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

    /// Whether there is a chart that a picture can lie on.
    pub(in crate::designer::app) fn has_chart(&self) -> bool {
        let chart = &self.document.design.chart;
        chart.pixels.is_some() || !chart.object.is_empty()
    }

    /// A file was dropped on the window.
    pub(in crate::designer::app) fn take_dropped(&mut self, path: PathBuf) {
        if self.filing.is_asking() {
            let text = "Answer the question first, then drop the file again.";
            return self.shell.notices.error("Not opened", text);
        }
        let ending = path.extension().map(|e| e.to_string_lossy().to_lowercase());
        match ending.as_deref() {
            // Browsers and mail programs rename bundles to what they are.
            Some("toml" | files::BUNDLE_ENDING | "zip") => {
                self.shell.commands.push(Command::OpenPreset(path));
            }
            Some("png") if files::carries_design(&path) => {
                let name = path.file_name().unwrap_or(path.as_os_str());
                let text = format!(
                    "{} is a picture of a design, and carries that design.",
                    name.to_string_lossy()
                );
                self.filing.question = Some(
                    Question::new("Open its design?", text)
                        .answer("Open its design", Command::OpenPreset(path.clone()))
                        .answer("Use as chart", Command::UseImage(ImageSlot::Chart, path)),
                );
            }
            ending => match ending.and_then(files::dropped) {
                Some(ImageSlot::Chart) if self.has_chart() => {
                    self.shell.commands.push(Command::AddPicture(path));
                }
                Some(slot) => self.shell.commands.push(Command::UseImage(slot, path)),
                None => {
                    let text = format!(
                        "{}: drop a design (.toml, .towel, or a .png exported here), a chart image (.png, .jpg, .webp, \
                         .gif, .bmp, .tif, .tga, .ppm) or an image of the surroundings (.hdr, .exr).",
                        path.display()
                    );
                    self.shell.notices.error("Not opened", text);
                }
            },
        }
    }
}

/// Reads a design. What the user has allowed is known from then on.
fn open(
    path: &Path,
    choice: Option<OutsideChoice>,
    config: Option<&Path>,
) -> Result<(Opened, OwnImages), FileError> {
    let known = config.map(KnownOutside::load).unwrap_or_default();
    let outside = match choice {
        None => Outside::Known(&known),
        Some(OutsideChoice::Open) => Outside::Open,
        Some(OutsideChoice::LeaveOut) => Outside::LeaveOut,
    };
    let opened = files::open_to_edit(path, outside)?;
    if let (Some(OutsideChoice::Open), Some(config)) = (choice, config) {
        // What cannot be noted is asked about again.
        let _ = KnownOutside::note(config, path, &opened.0.outside);
    }
    Ok(opened)
}
