//! What panels may see and ask for beside the design that they edit.

use renderer_core::design::{CameraDesign, Chart, Fault, Warning};

use crate::designer::presets::thumbnails::ThumbnailRenderer;
use crate::designer::shell::command::Command;
use crate::designer::shell::keyboard_focus::KeyboardFocus;

/// What panels may see beside the design.
pub struct Surroundings<'a> {
    /// Values of the design that are not allowed.
    pub faults: &'a [Fault],
    /// Things that are allowed but probably not meant.
    pub warnings: &'a [Warning],
    /// The design's chart as the cloth shows it: with the objects on it, and without any left.
    pub woven: &'a Chart,
    /// The camera of the viewport.
    pub camera: &'a CameraDesign,
    /// What the history is to call what a panel changes, where the designs before and after do not say it.
    pub step_name: &'a mut Option<String>,
    /// Where panels put what they ask for.
    pub commands: &'a mut Vec<Command>,
    /// What has the keyboard.
    pub focus: &'a KeyboardFocus,
    /// Draws thumbnails.
    pub thumbnails: &'a mut ThumbnailRenderer,
}
