//! The presets that come with the program, to open with a click.

use std::path::{Path, PathBuf};

use egui::{Button, ColorImage, RichText, ScrollArea, TextureHandle, TextureOptions, Ui, vec2};

use super::command::Command;
use super::tasks::{Poll, Task};

/// A preset file.
#[derive(Debug, Clone)]
struct Preset {
    name: String,
    path: PathBuf,
    what: String,
}

/// The list and its little pictures.
pub struct PresetList {
    folder: Option<PathBuf>,
    presets: Vec<Preset>,
    pictures: Task<Vec<Option<ColorImage>>>,
    textures: Vec<Option<TextureHandle>>,
}

/// Size of a picture, points.
const PICTURE: [f32; 2] = [46.0, 34.0];

impl PresetList {
    /// Lists the presets of the first presets folder there is.
    pub fn new(ctx: &egui::Context) -> Self {
        let folder = candidates().into_iter().find(|folder| folder.is_dir());
        let presets = folder.as_deref().map(presets_in).unwrap_or_default();
        let paths: Vec<PathBuf> = presets.iter().map(|p| picture_of(&p.path)).collect();
        Self {
            folder,
            textures: vec![None; presets.len()],
            presets,
            pictures: Task::start(ctx, move || paths.iter().map(|p| read_picture(p)).collect()),
        }
    }

    /// The folder of the presets.
    pub fn folder(&self) -> Option<&Path> {
        self.folder.as_deref()
    }

    /// Shows the list; `open` is the document's file.
    pub fn show(&mut self, ui: &mut Ui, open: Option<&Path>, commands: &mut Vec<Command>) {
        if let Poll::Ready(pictures) = self.pictures.poll() {
            let texture = |(image, preset): (Option<ColorImage>, &Preset)| {
                let name = &preset.name;
                Some(ui.ctx().load_texture(name, image?, TextureOptions::LINEAR))
            };
            self.textures = pictures
                .into_iter()
                .zip(&self.presets)
                .map(texture)
                .collect();
        }
        ui.add_space(2.0);
        ui.label(RichText::new("Presets").strong().size(13.5));
        ui.add_space(2.0);
        if self.presets.is_empty() {
            let place = self.folder.as_deref().map_or_else(
                || "No folder \"presets\" lies beside the program.".into(),
                |folder| format!("There are no presets in {}.", folder.display()),
            );
            ui.weak(place);
            return;
        }
        ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
            for (preset, texture) in self.presets.iter().zip(&self.textures) {
                let chosen = open.is_some_and(|open| same_file(open, &preset.path));
                let button = match texture {
                    Some(texture) => Button::image_and_text(
                        egui::Image::new((texture.id(), PICTURE.into()))
                            .fit_to_exact_size(PICTURE.into())
                            .alt_text(""),
                        preset.name.as_str(),
                    ),
                    None => Button::new(preset.name.as_str()),
                };
                let button = button
                    .selected(chosen)
                    .frame_when_inactive(chosen)
                    .min_size(vec2(ui.available_width(), 24.0))
                    .right_text("")
                    .truncate();
                let name = format!("Preset {}", preset.name);
                let button = ui.add(button).accessible_name(name);
                let button = if preset.what.is_empty() {
                    button
                } else {
                    button.on_hover_text(&preset.what)
                };
                if button.clicked() {
                    commands.push(Command::OpenPreset(preset.path.clone()));
                }
            }
        });
    }
}

/// Where the presets may be: beside the program, above cargo's target folder, or in the source tree it was built from.
fn candidates() -> Vec<PathBuf> {
    let exe = std::env::current_exe().unwrap_or_default();
    let above = exe.ancestors().skip(1).take(4);
    let mut folders: Vec<PathBuf> = above.map(|folder| folder.join("presets")).collect();
    folders.push(PathBuf::from(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../presets"
    )));
    folders
}

fn presets_in(folder: &Path) -> Vec<Preset> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut presets: Vec<Preset> = entries
        .map(|entry| entry.path())
        .filter(|path| path.extension().is_some_and(|ending| ending == "toml"))
        .filter_map(|path| {
            let name = path.file_stem()?.to_string_lossy().into_owned();
            let what = first_comment(&path);
            Some(Preset { name, path, what })
        })
        .collect();
    presets.sort_by(|a, b| a.name.cmp(&b.name));
    presets
}

/// The comment that a preset begins with, as one paragraph.
fn first_comment(path: &Path) -> String {
    let text = std::fs::read_to_string(path).unwrap_or_default();
    let lines = text.lines().map_while(|line| line.strip_prefix('#'));
    let words: Vec<&str> = lines.map(str::trim).collect();
    words.join(" ").trim().into()
}

/// The README's picture of a preset.
fn picture_of(preset: &Path) -> PathBuf {
    let folder = preset.parent().unwrap_or(Path::new(""));
    let name = preset.file_stem().unwrap_or_default();
    folder.join("pictures").join(name).with_extension("png")
}

/// A picture reduced to twice the shown size, its middle part where the shape differs.
fn read_picture(path: &Path) -> Option<ColorImage> {
    let picture = image::open(path).ok()?;
    let [width, height] = PICTURE.map(|side| 2 * side as u32);
    let small = picture
        .resize_to_fill(width, height, image::imageops::FilterType::Triangle)
        .into_rgba8();
    let size = [width as usize, height as usize];
    Some(ColorImage::from_rgba_unmultiplied(size, small.as_raw()))
}

fn same_file(a: &Path, b: &Path) -> bool {
    a == b || matches!((a.canonicalize(), b.canonicalize()), (Ok(a), Ok(b)) if a == b)
}
