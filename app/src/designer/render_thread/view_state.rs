//! What the render thread publishes: how far the requested picture is, and what there is to show of it.

use std::sync::Arc;

use renderer_core::design::Warning;
use renderer_core::render::{BackendKind, Progress};
use renderer_core::scene::LoopCounts;
use renderer_core::scene::lod::LodCloth;

use super::denoising::Denoising;
use super::renderer::DisplayFrame;

/// What the thread has to show.
#[derive(Debug, Clone, Default)]
pub struct ViewState {
    /// How far the requested picture is.
    pub stage: Stage,
    /// The newest picture.
    pub picture: LatestPicture,
    /// The newest scene.
    pub scene: SceneSummary,
    /// Whether pictures can be denoised.
    pub denoising: Denoising,
    /// What renders, once something does.
    pub device: Option<DeviceInUse>,
    /// Width and height of the picture in work at its full size, pixels; less than requested where the backend or its
    /// memory cannot do more.
    pub size: [u32; 2],
    /// What went wrong, until something goes right.
    pub error: Option<String>,
    /// Why something else renders than was chosen, as long as it does.
    pub instead: Option<String>,
    /// Something that happened, and how many such things did.
    pub news: (u64, News),
}

/// Something that happened.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct News {
    /// What, in short.
    pub title: &'static str,
    /// All of it.
    pub text: String,
}

/// How far the requested picture is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Stage {
    /// The picture is done, or cannot be had; or nothing was requested.
    #[default]
    Idle,
    /// The scene is being made.
    Compiling,
    /// Samples are being added.
    Rendering(Seen),
}

/// How much can be seen of what is requested.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Seen {
    /// No picture of the size that is in work; at most a smaller one, or a coarse preview drawn while the scene was
    /// being made.
    Nothing,
    /// A picture smaller than requested, drawn for speed.
    Reduced,
    /// A picture of full size, which only gets clearer.
    Whole,
}

/// The newest picture.
#[derive(Debug, Clone, Default)]
pub struct LatestPicture {
    /// The picture, if there is one.
    pub frame: Option<DisplayFrame>,
    /// Counts pictures, so that the viewport notices a new one.
    pub version: u64,
    /// How far it is; its samples are those of a smaller picture if it `is_reduced`.
    pub progress: Progress,
    /// Whether it is a small one, drawn for speed.
    pub is_reduced: bool,
    /// What of it is denoised, if anything is (see [`renderer_core::denoise::Mix`]).
    pub denoised: Option<DenoisedPart>,
    /// Time spent rendering since the last request that changed the picture.
    pub seconds: f64,
}

/// What of a picture is denoised.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DenoisedPart {
    /// Samples of a pixel that it was denoised from.
    pub samples: u32,
    /// The share of it that is denoised, 0 to 1; the rest is plain.
    pub share: f64,
    /// Estimated relRMSE of the mixture, bias included.
    pub error: Option<f64>,
}

/// What there is to say about the newest scene.
#[derive(Debug, Clone, Default)]
pub struct SceneSummary {
    /// Its loops.
    pub counts: LoopCounts,
    /// Things about it and its design that are allowed but probably not meant.
    pub warnings: Vec<Warning>,
    /// The cloth, to look up what lies under the pointer.
    pub cloth: Option<Arc<LodCloth>>,
}

/// The backend whose picture is shown.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DeviceInUse {
    /// Which backend.
    pub kind: BackendKind,
    /// Its adapter or processor.
    pub name: String,
    /// Bytes taken on it.
    pub bytes: u64,
    /// Whether it stands in for a GPU that was not ready for the picture.
    pub stands_in: bool,
}

/// How urgently the viewport needs the machine.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Priority {
    /// What is requested can be seen in full size; it only gets clearer.
    #[default]
    Low,
    /// What is requested can be seen, but smaller than it should be.
    Medium,
    /// Nothing of what is requested can be seen.
    High,
}

impl ViewState {
    /// Notes something that happened, to be shown once.
    pub fn report(&mut self, title: &'static str, text: String) {
        self.news = (self.news.0 + 1, News { title, text });
    }

    /// Takes `frame` as a new version of the newest picture.
    pub fn show(&mut self, frame: Option<DisplayFrame>) {
        self.picture.frame = frame;
        self.picture.version += 1;
    }

    /// Whether the thread works towards the first picture of what is requested: somebody waits for it.
    pub fn is_busy(&self) -> bool {
        self.priority() != Priority::Low
    }

    /// How much somebody waits for it.
    pub fn priority(&self) -> Priority {
        match self.stage {
            Stage::Compiling | Stage::Rendering(Seen::Nothing) => Priority::High,
            Stage::Rendering(Seen::Reduced) => Priority::Medium,
            Stage::Rendering(Seen::Whole) | Stage::Idle => Priority::Low,
        }
    }
}
