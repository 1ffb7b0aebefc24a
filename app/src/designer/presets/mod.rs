//! The presets: those that come with the program, and the user's own, each with a thumbnail rendered in the background.

pub mod thumbnails;

use std::collections::HashMap;
use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use egui::{
    Button, ColorImage, Context, RichText, ScrollArea, TextEdit, TextureHandle, TextureOptions, Ui,
    vec2,
};
use image::{ExtendedColorType, ImageEncoder, codecs::png::PngEncoder};

use crate::designer::document::folders::Folders;
use crate::designer::shell::command::{Command, Place, PresetCommand};
use crate::designer::shell::keyboard_focus::KeyboardFocus;
use crate::designer::tasks::{Poll, Task};
use crate::files::{self, KnownOutside, Outline, Outside, Reading, Shipped, is_bundle, stem_of};
use thumbnails::{ThumbnailJob, ThumbnailKey, ThumbnailRenderer, ThumbnailSubject};

/// A preset of the list.
#[derive(Debug, Clone)]
struct Preset {
    name: String,
    place: Place,
    outline: Outline,
}

/// What is read about all presets on another thread.
struct Listed {
    /// The presets, with the pictures that were drawn before.
    presets: Vec<(Preset, Option<ColorImage>)>,
    /// Whose images outside their folders may be opened.
    known: KnownOutside,
    /// Whether pictures can be kept. If not, every start would draw them all; then none are drawn.
    can_keep: bool,
}

/// The list.
pub struct Presets {
    /// Where the user's own presets and the pictures of all are.
    pub folders: Option<Folders>,
    list: Vec<Preset>,
    listing: Option<Task<Listed>>,
    /// By content: a picture stays right as long as that does.
    pictures: HashMap<u64, TextureHandle>,
    /// Being drawn: key and content.
    drawn: Vec<(ThumbnailKey, u64)>,
    search: String,
    is_outdated: bool,
    /// The file manager at work.
    pub revealing: Option<(PathBuf, Task<Result<(), String>>)>,
}

/// Size of a picture, points.
const PICTURE: [f32; 2] = [56.0, 42.0];
/// Size of a picture as it is drawn, pixels: sharp up to an interface scale of 225 %.
const DRAWN: [u32; 2] = [128, 96];
/// Samples a pixel of a picture: its noise is hardly seen once reduced to its size on the screen.
const SAMPLES: u32 = 12;

impl Presets {
    /// Reads the list in the background.
    pub fn new(ctx: &Context, folders: Option<Folders>) -> Self {
        let mut presets = Self {
            folders,
            list: Vec::new(),
            listing: None,
            pictures: HashMap::new(),
            drawn: Vec::new(),
            search: String::new(),
            is_outdated: false,
            revealing: None,
        };
        presets.read(ctx);
        presets
    }

    /// Has the list read anew: the user's folder may have changed.
    pub fn look_again(&mut self) {
        self.is_outdated = true;
    }

    fn read(&mut self, ctx: &Context) {
        self.is_outdated = false;
        let folders = self.folders.clone();
        self.listing = Some(Task::start(ctx, move || list(folders.as_ref())));
    }

    /// Takes what came from other threads.
    pub fn take_news(
        &mut self,
        ctx: &Context,
        thumbnails: &mut ThumbnailRenderer,
    ) -> Option<(PathBuf, String)> {
        if self.listing.is_none() && self.is_outdated {
            self.read(ctx);
        }
        if let Some(Poll::Ready(listed)) = self.listing.as_ref().map(Task::poll) {
            self.listing = None;
            self.take_list(ctx, listed, thumbnails);
        }
        let cache = self.folders.as_ref().map(|folders| folders.cache.clone());
        self.drawn.retain(|(key, content)| {
            let Some(drawn) = thumbnails.take(key) else {
                return true;
            };
            if let Ok(image) = drawn.image {
                if let (true, Some(cache)) = (drawn.is_final, &cache) {
                    let (file, image) = (picture_file(cache, *content), image.clone());
                    // A picture that cannot be kept is drawn again next time.
                    let _ = Task::start(ctx, move || write_picture(&file, &image));
                }
                let texture = ctx.load_texture("preset", image, TextureOptions::LINEAR);
                self.pictures.insert(*content, texture);
            }
            !drawn.is_final
        });
        let (path, task) = self.revealing.as_ref()?;
        let failure = match task.poll() {
            Poll::Pending => return None,
            Poll::Ready(Ok(())) => None,
            Poll::Ready(Err(error)) => Some((path.clone(), error)),
            Poll::Lost => Some((path.clone(), "the file manager cannot be started".into())),
        };
        self.revealing = None;
        failure
    }

    fn take_list(&mut self, ctx: &Context, listed: Listed, thumbnails: &mut ThumbnailRenderer) {
        self.list.clear();
        let known = Arc::new(listed.known);
        for (preset, picture) in listed.presets {
            let content = preset.outline.content;
            if let Some(picture) = picture {
                let texture = ctx.load_texture("preset", picture, TextureOptions::LINEAR);
                self.pictures.insert(content, texture);
            }
            let key = ThumbnailKey::Preset(match &preset.place {
                Place::Program(name) => Path::new("program").join(name),
                Place::File(path) => path.clone(),
            });
            let is_known = self.pictures.contains_key(&content);
            let is_drawn = self.drawn.contains(&(key.clone(), content));
            if listed.can_keep && !is_known && !is_drawn {
                let (place, known) = (preset.place.clone(), Arc::clone(&known));
                thumbnails.draw(ThumbnailJob {
                    key: key.clone(),
                    subject: Box::new(move || subject(&place, &known)),
                    size: DRAWN,
                    samples: SAMPLES,
                    is_urgent: false,
                });
                self.drawn.push((key, content));
            }
            self.list.push(preset);
        }
    }

    /// Shows the list; `open` is the document's file.
    pub fn show(
        &mut self,
        ui: &mut Ui,
        open: Option<&Path>,
        focus: &KeyboardFocus,
        commands: &mut Vec<Command>,
    ) {
        ui.add_space(2.0);
        ui.label(RichText::new("Presets").strong().size(13.5));
        ui.add_space(2.0);
        let search = TextEdit::singleline(&mut self.search)
            .hint_text("Search")
            .align(egui::Align2::LEFT_CENTER)
            .desired_width(ui.available_width() - 6.0);
        ui.add(search)
            .accessible_name("Search presets")
            .on_hover_text("Shows the presets whose name or description has these words.");
        if self.folders.is_some() {
            let save = ui.button("Save as preset…");
            let what = "Keeps the design, its chart included, among your own presets.";
            if save.on_hover_text(what).clicked() {
                commands.push(Command::Presets(PresetCommand::AskToSave));
            }
        }
        ui.add_space(2.0);
        let words: Vec<String> = self
            .search
            .split_whitespace()
            .map(str::to_lowercase)
            .collect();
        let shown: Vec<&Preset> = self.list.iter().filter(|p| p.has(&words)).collect();
        ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
            let (own, shipped): (Vec<&Preset>, Vec<&Preset>) = shown
                .into_iter()
                .partition(|preset| matches!(preset.place, Place::File(_)));
            if own.is_empty() && shipped.is_empty() && self.listing.is_none() {
                ui.weak(format!("No preset has “{}”.", self.search.trim()));
            }
            if !own.is_empty() {
                ui.label(RichText::new("Your own").weak());
            }
            for preset in &own {
                self.row(ui, preset, open, commands);
            }
            if !own.is_empty() && !shipped.is_empty() {
                ui.add_space(6.0);
                ui.label(RichText::new("With the program").weak());
            }
            for preset in &shipped {
                self.row(ui, preset, open, commands);
            }
            ui.add_space(12.0);
            focus.reveal(ui);
        });
    }

    fn row(&self, ui: &mut Ui, preset: &Preset, open: Option<&Path>, commands: &mut Vec<Command>) {
        let chosen =
            matches!(&preset.place, Place::File(path) if open.is_some_and(|o| same_file(o, path)));
        let picture = self.pictures.get(&preset.outline.content);
        ui.push_id(&preset.place, |ui| {
            ui.horizontal(|ui| {
                ui.spacing_mut().item_spacing.x = 2.0;
                let width = ui.available_width() - 30.0;
                let size = vec2(PICTURE[0], PICTURE[1]);
                let button = match picture {
                    Some(texture) => Button::image_and_text(
                        egui::Image::new((texture.id(), size))
                            .fit_to_exact_size(size)
                            .alt_text(""),
                        preset.name.as_str(),
                    ),
                    None => Button::new(preset.name.as_str()),
                };
                let button = button
                    .selected(chosen)
                    .frame_when_inactive(chosen)
                    .min_size(vec2(width, PICTURE[1] + 6.0))
                    .right_text("")
                    .wrap();
                let button = ui
                    .allocate_ui(vec2(width, PICTURE[1] + 6.0), |ui| ui.add(button))
                    .inner
                    .accessible_name(format!("Preset {}", preset.name));
                let tooltip = preset.tooltip();
                let button = button.on_hover_text(tooltip);
                if button.clicked() {
                    commands.push(preset.open());
                }
                button.context_menu(|ui| preset.menu(ui, commands));
                ui.menu_button("…", |ui| preset.menu(ui, commands))
                    .response
                    .accessible_name(format!("More about {}", preset.name))
                    .on_hover_text("What else can be done with this preset.");
            });
        });
    }
}

impl Preset {
    fn has(&self, words: &[String]) -> bool {
        let text = format!("{} {}", self.name, self.outline.comment).to_lowercase();
        words.iter().all(|word| text.contains(word))
    }

    fn tooltip(&self) -> String {
        match (&self.place, self.outline.comment.as_str()) {
            (Place::Program(_), "") => self.name.clone(),
            (Place::Program(_), comment) => comment.into(),
            (Place::File(path), "") => path.display().to_string(),
            (Place::File(path), comment) => format!("{comment}\n\n{}", path.display()),
        }
    }

    fn open(&self) -> Command {
        match &self.place {
            Place::Program(name) => Command::OpenShipped(name.clone()),
            Place::File(path) => Command::OpenPreset(path.clone()),
        }
    }

    fn menu(&self, ui: &mut Ui, commands: &mut Vec<Command>) {
        let mut item = |ui: &mut Ui, text: &str, command: Command| {
            if ui.button(text).clicked() {
                commands.push(command);
                ui.close();
            }
        };
        let duplicate = PresetCommand::Duplicate(self.place.clone());
        match &self.place {
            Place::Program(_) => {
                item(ui, "Open a copy", self.open());
                item(ui, "Copy to my presets", Command::Presets(duplicate));
            }
            Place::File(path) => {
                let command =
                    |command: fn(PathBuf) -> PresetCommand| Command::Presets(command(path.clone()));
                item(ui, "Open", self.open());
                item(ui, "Duplicate", Command::Presets(duplicate));
                item(ui, "Rename…", command(PresetCommand::AskToRename));
                item(ui, "Show in folder", command(PresetCommand::Reveal));
                ui.separator();
                item(ui, "Delete…", command(PresetCommand::AskToDelete));
            }
        }
    }
}

/// All presets, the user's own first, with the pictures that were drawn before.
fn list(folders: Option<&Folders>) -> Listed {
    let mut listed: Vec<Preset> = Vec::new();
    let known = folders.map(|folders| KnownOutside::load(&folders.config));
    let known = known.unwrap_or_default();
    if let Some(folders) = folders {
        let entries = fs::read_dir(&folders.presets)
            .into_iter()
            .flatten()
            .flatten();
        let mut files: Vec<PathBuf> = entries.map(|entry| entry.path()).collect();
        files.retain(|path| {
            let is_hidden = path
                .file_name()
                .is_none_or(|name| name.as_encoded_bytes().first() == Some(&b'.'));
            let is_preset = path.extension() == Some(OsStr::new("toml")) || is_bundle(path);
            is_preset && !is_hidden
        });
        files.sort();
        listed.extend(files.into_iter().map(|path| Preset {
            name: stem_of(&path),
            outline: Outline::of_file(&path, &known),
            place: Place::File(path),
        }));
    }
    listed.extend(Shipped::all().map(|shipped| Preset {
        name: shipped.name.into(),
        outline: Outline::of_shipped(&shipped),
        place: Place::Program(shipped.name.into()),
    }));
    let with_picture = |preset: Preset| {
        let cache = folders.map(|folders| &folders.cache);
        let file = cache.map(|cache| picture_file(cache, preset.outline.content));
        let picture = file.and_then(|file| read_picture(&file));
        (preset, picture)
    };
    Listed {
        known,
        presets: listed.into_iter().map(with_picture).collect(),
        can_keep: folders
            .is_some_and(|folders| fs::create_dir_all(pictures_folder(&folders.cache)).is_ok()),
    }
}

/// Where the picture of a content is kept; another version of the program may draw it otherwise.
fn picture_file(cache: &Path, content: u64) -> PathBuf {
    let [width, height] = DRAWN;
    let version = env!("CARGO_PKG_VERSION");
    let name = format!("{content:016x}-{width}x{height}-{SAMPLES}-{version}.png");
    pictures_folder(cache).join(name)
}

fn pictures_folder(cache: &Path) -> PathBuf {
    cache.join("presets")
}

fn read_picture(path: &Path) -> Option<ColorImage> {
    let bytes = fs::read(path).ok()?;
    let picture = image::load_from_memory(&bytes).ok()?.into_rgb8();
    let size = [picture.width() as usize, picture.height() as usize];
    (size == DRAWN.map(|side| side as usize)).then(|| ColorImage::from_rgb(size, picture.as_raw()))
}

fn write_picture(path: &Path, picture: &ColorImage) -> Option<()> {
    let rgb: Vec<[u8; 3]> = picture
        .pixels
        .iter()
        .map(|pixel| [pixel.r(), pixel.g(), pixel.b()])
        .collect();
    let [width, height] = picture.size.map(|side| side as u32);
    let mut png = Vec::new();
    PngEncoder::new(&mut png)
        .write_image(rgb.as_flattened(), width, height, ExtendedColorType::Rgb8)
        .ok()?;
    files::write_atomically(path, &png).ok()
}

/// A preset in the view that it opens with.
fn subject(place: &Place, known: &KnownOutside) -> Result<ThumbnailSubject, String> {
    let reading = Reading {
        outside: Outside::Known(known),
        ..Reading::default()
    };
    let opened = match place {
        Place::Program(name) => Shipped::named(name).ok_or("is gone")?.open(),
        Place::File(path) => files::read_design(path, reading),
    };
    let design = opened.map_err(|error| error.to_string())?.design;
    let camera = design.view.opening().cloned().unwrap_or_default();
    Ok(ThumbnailSubject { design, camera })
}

fn same_file(a: &Path, b: &Path) -> bool {
    a == b || matches!((a.canonicalize(), b.canonicalize()), (Ok(a), Ok(b)) if a == b)
}
