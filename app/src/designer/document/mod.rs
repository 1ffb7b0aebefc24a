//! The document: the design being edited, its history, its file and whether it differs from that file.
//!
//! Panels edit [`Document::design`] freely. After every frame [`Document::settle`] looks whether it differs from the
//! state after the last finished gesture; when no gesture is under way, the difference becomes one step of the history,
//! named after what changed. So a drag of any length is one step, and no panel has to know that undo exists.

pub mod autosave;
mod changes;
pub mod folders;
pub mod labels;
pub mod settings;

use std::path::{Path, PathBuf};

use renderer_core::design::{ChartImage, Design, ImagePixels, ImageSlot};

use crate::files::{
    Carried, Opened, Origin, OwnImages, Stamp, Unsaved, UsedFile, is_bundle, stem_of, words,
};

/// Most steps that can be undone. Designs share their charts' tiles, so a step costs little,
const MAX_STEPS: usize = 1000;
/// unless each of them changes all of a large chart: then as many as fit into this many bytes, and always the last.
const MOST_BYTES: usize = 1 << 30;

/// A state to go back (or forward) to, and the name of the gesture that lies between.
#[derive(Debug, Clone)]
struct Step {
    name: String,
    design: Design,
    /// What the images before and after do not share.
    bytes: usize,
}

/// A design with its history and its file.
#[derive(Debug)]
pub struct Document {
    /// What panels show and edit.
    pub design: Design,
    settled: Design,
    /// What the file holds; nothing for a design that was recovered.
    saved: Option<Design>,
    path: Option<PathBuf>,
    /// The files of the images that were painted here, as they were last read or written.
    pub own_images: OwnImages,
    /// Name of a design without a file that was made from something with a name.
    name: Option<String>,
    /// The picture that a design without a file was read from.
    source: Option<PathBuf>,
    /// Images that lie in no folder.
    carried: Carried,
    /// The file's state when it was read or written.
    stamp: Option<Stamp>,
    /// Counts the steps, in whichever direction.
    revision: u64,
    undo: Vec<Step>,
    redo: Vec<Step>,
    /// What the step that is under way is to be called.
    step_name: Option<String>,
}

impl Default for Document {
    fn default() -> Self {
        Self::new(Design::default(), None)
    }
}

impl Document {
    /// A document of a design just read from `path`, or of a new design.
    ///
    /// In memory the paths of images are absolute, so that no state of the history depends on where the preset lies;
    /// files name them relative to themselves.
    pub fn new(mut design: Design, path: Option<PathBuf>) -> Self {
        if let Some(folder) = path.as_deref().and_then(Path::parent) {
            for slot in ImageSlot::of(&design) {
                if let Some(image) = slot.path(&design) {
                    let file = folder.join(image);
                    let file = std::path::absolute(&file).unwrap_or(file);
                    slot.set_path(&mut design, Some(file.to_string_lossy().into_owned()));
                }
            }
        }
        Self::with_images_found(design, path)
    }

    fn with_images_found(design: Design, path: Option<PathBuf>) -> Self {
        Self {
            settled: design.clone(),
            saved: Some(design.clone()),
            design,
            stamp: path.as_deref().and_then(Stamp::of),
            path,
            own_images: OwnImages::default(),
            name: None,
            source: None,
            carried: Carried::default(),
            revision: 0,
            undo: Vec::new(),
            redo: Vec::new(),
            step_name: None,
        }
    }

    /// A document of what was read from the file at `path`. Pictures, the program's own presets, archives of other names
    /// than bundles have, and pipes are no files to save to: what is made from them is new, and keeps their name.
    pub fn opened(opened: Opened, path: PathBuf) -> Self {
        let Opened {
            design,
            carried,
            origin,
            left_out,
            ..
        } = opened;
        let name = path.file_stem().map(|stem| stem.to_string_lossy().into());
        let document = match origin {
            Origin::Preset if path.is_file() => Self::new(design, Some(path)),
            Origin::Bundle if is_bundle(&path) => Self::with_images_found(design, Some(path)),
            Origin::Preset | Origin::Bundle | Origin::Picture => Self {
                name,
                source: Some(path),
                ..Self::with_images_found(design, None)
            },
            Origin::Program => Self {
                name,
                ..Self::with_images_found(design, None)
            },
        };
        let document = Self {
            carried,
            ..document
        };
        match left_out.is_empty() {
            true => document,
            false => document.without_file(),
        }
    }

    /// Is a new design that keeps its name: the file has more than was opened, and is not to be saved over.
    fn without_file(self) -> Self {
        Self {
            name: Some(self.name()),
            path: None,
            stamp: None,
            source: self.path.clone().or(self.source),
            ..self
        }
    }

    /// A document that a program which ended without saving it has left behind.
    pub fn recovered(unsaved: Unsaved) -> Self {
        // A path that starts where another program was started leads nowhere now.
        let (path, lost) = match unsaved.path {
            Some(path) if path.is_relative() => (None, Some(stem_of(&path))),
            path => (path, None),
        };
        Self {
            saved: None,
            name: unsaved.name.or(lost),
            carried: unsaved.carried,
            stamp: unsaved.stamp,
            ..Self::with_images_found(unsaved.design, path)
        }
    }

    /// What is kept of this document until it is saved.
    pub fn unsaved(&self) -> Unsaved {
        Unsaved {
            design: self.settled.clone(),
            carried: self.carried.clone(),
            path: self.path.clone(),
            name: self.name.clone(),
            stamp: self.stamp,
        }
    }

    /// The files that the design is made of: its own, the picture it was read from, and its images.
    pub fn files(&self) -> Vec<UsedFile> {
        let own = self.path.iter().chain(&self.source);
        let own = own.map(|path| UsedFile::new(path, "the file of the design"));
        own.chain(self.image_files()).collect()
    }

    /// The files of the design's images.
    pub fn image_files(&self) -> Vec<UsedFile> {
        let mut files = self.own_images.files();
        let preset = self.path.as_deref().filter(|path| !is_bundle(path));
        for slot in ImageSlot::of(&self.design) {
            let Some(path) = slot.path(&self.design) else {
                continue;
            };
            let file = match self.carried.get(path) {
                // In memory what is not carried has its whole path.
                None => Some(PathBuf::from(path)),
                // What was carried lies beside the preset that it was saved with.
                Some(_) => preset.map(|preset| preset.with_file_name(path)),
            };
            let what = format!("the {} of the design", words(slot).name);
            files.extend(file.map(|file| UsedFile::new(file, what)));
        }
        files
    }

    /// The images that lie in no folder.
    pub fn carried(&self) -> &Carried {
        &self.carried
    }

    /// Counts the steps, undone ones too: as long as it stays the same, so does the settled design.
    pub fn revision(&self) -> u64 {
        self.revision
    }

    /// Whether another program has written the file since it was read or saved. A file that is gone loses nothing.
    pub fn is_changed_outside(&self) -> bool {
        let now = self.path.as_deref().and_then(Stamp::of);
        now.is_some() && now != self.stamp
    }

    /// The file this document was read from or last saved to.
    pub fn path(&self) -> Option<&Path> {
        self.path.as_deref()
    }

    /// Name for the window's title: that of the file without its ending.
    pub fn name(&self) -> String {
        let of_file = self.path.as_deref().and_then(Path::file_stem);
        of_file
            .map(|name| name.to_string_lossy().into_owned())
            .or_else(|| self.name.clone())
            .unwrap_or_else(|| "untitled".into())
    }

    /// Whether there is something that no file holds.
    pub fn is_unsaved(&self) -> bool {
        self.saved.as_ref() != Some(&self.design)
    }

    /// Notes that the file at `path` now holds `design`.
    pub fn mark_saved(&mut self, path: PathBuf, design: Design) {
        self.saved = Some(design);
        self.stamp = Stamp::of(&path);
        self.path = Some(path);
    }

    /// Names the step that the change just made belongs to, where the designs before and after do not say it.
    pub fn name_step(&mut self, name: String) {
        self.step_name = Some(name);
    }

    /// Notes that the file at `from` is at `to` now.
    pub fn file_moved(&mut self, from: &Path, to: &Path) {
        if self.path.as_deref() == Some(from) {
            self.path = Some(to.to_owned());
        }
    }

    /// Makes a finished gesture a step of the history. To be called after every frame; while a gesture goes on
    /// (a pointer or key is down, text is being typed) nothing happens.
    pub fn settle(&mut self, gesture_goes_on: bool) {
        if gesture_goes_on {
            return;
        }
        self.share_tiles();
        let name = self.step_name.take();
        if self.design == self.settled {
            return;
        }
        self.revision += 1;
        let before = std::mem::replace(&mut self.settled, self.design.clone());
        let bytes = ImageSlot::of(&before).map(|slot| {
            let now = colours(slot, &self.design);
            colours(slot, &before).map_or(0, |pixels| pixels.bytes_beside(now.as_ref()))
        });
        let bytes = bytes.sum();
        self.undo.push(Step {
            name: name.unwrap_or_else(|| changes::describe(&before, &self.design)),
            design: before,
            bytes,
        });
        let mut total: usize = self.undo.iter().map(|step| step.bytes).sum();
        let mut too_many = self.undo.len().saturating_sub(MAX_STEPS);
        while total > MOST_BYTES && too_many + 1 < self.undo.len() {
            total -= self.undo[too_many].bytes;
            too_many += 1;
        }
        self.undo.drain(..too_many);
        self.redo.clear();
    }

    /// Keeps equal parts of images in memory once: the comparisons of every frame then compare pointers.
    fn share_tiles(&mut self) {
        for slot in ImageSlot::of(&self.design) {
            let Some(mut pixels) = colours(slot, &self.design) else {
                continue;
            };
            let settled = colours(slot, &self.settled);
            // Once a gesture, not every frame: images that differ all over take a while to compare.
            if settled.as_ref().is_some_and(|settled| settled.is(&pixels)) {
                continue;
            }
            let saved = self.saved.as_ref().and_then(|saved| colours(slot, saved));
            for other in [saved, settled].into_iter().flatten() {
                pixels.share_with(&other);
            }
            slot.set_pixels(&mut self.design, Some(ImagePixels::Colours(pixels)));
        }
    }

    /// Name of the gesture that [`Self::undo`] would take back.
    pub fn undo_name(&self) -> Option<&str> {
        self.undo.last().map(|step| step.name.as_str())
    }

    /// Name of the gesture that [`Self::redo`] would repeat.
    pub fn redo_name(&self) -> Option<&str> {
        self.redo.last().map(|step| step.name.as_str())
    }

    /// Takes back the last gesture.
    pub fn undo(&mut self) {
        self.settle(false);
        if let Some(step) = self.undo.pop() {
            let after = self.replace(step.design.clone());
            self.redo.push(Step {
                design: after,
                ..step
            });
        }
    }

    /// Repeats the gesture last taken back.
    pub fn redo(&mut self) {
        self.settle(false);
        if let Some(step) = self.redo.pop() {
            let before = self.replace(step.design.clone());
            self.undo.push(Step {
                design: before,
                ..step
            });
        }
    }

    fn replace(&mut self, design: Design) -> Design {
        self.revision += 1;
        self.settled = design.clone();
        std::mem::replace(&mut self.design, design)
    }
}

/// An image of a design, if it is one of colours: of those parts can be shared, others are copied whole or not at all.
fn colours(slot: ImageSlot, design: &Design) -> Option<ChartImage> {
    match slot.pixels(design) {
        Some(ImagePixels::Colours(image)) => Some(image),
        _ => None,
    }
}
