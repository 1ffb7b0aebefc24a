//! The processor in place of a GPU whose pipeline for a picture is still in the making.
//!
//! It draws the same picture at once. When the pipeline is there the GPU begins that picture unseen, and what the
//! processor has stays in the window until the GPU's is no noisier: nobody sees a step back. A picture that the
//! processor has ended before stays for good, since the GPU could only draw the same again; the next edit is the GPU's.
//! If more samples are asked for than it ended with, the GPU begins it as above.

use super::DeviceInUse;
use super::renderer::Renderer;

/// What the processor does for the renderer.
#[derive(Default)]
pub enum StandIn {
    /// Nothing: the renderer draws, and its picture is shown.
    #[default]
    None,
    /// It draws while the renderer is not ready.
    Draws(Renderer),
    /// Its picture is shown, while the renderer draws the same and is behind.
    IsShown(Renderer),
}

impl StandIn {
    /// Whether the picture shown is the processor's.
    pub fn is_some(&self) -> bool {
        !matches!(self, Self::None)
    }

    /// Who draws.
    pub fn drawing<'a>(&'a mut self, renderer: &'a mut Renderer) -> &'a mut Renderer {
        match self {
            Self::Draws(stand_in) => stand_in,
            Self::None | Self::IsShown(_) => renderer,
        }
    }

    /// Whose picture is shown.
    pub fn shown<'a>(&'a mut self, renderer: &'a mut Renderer) -> &'a mut Renderer {
        match self {
            Self::Draws(stand_in) | Self::IsShown(stand_in) => stand_in,
            Self::None => renderer,
        }
    }

    /// What there is to say about whose picture is shown.
    pub fn device(&mut self, renderer: &mut Renderer) -> DeviceInUse {
        let stands_in = self.is_some();
        let shown = self.shown(renderer).backend();
        DeviceInUse {
            kind: shown.kind(),
            name: shown.device_name(),
            bytes: shown.device_bytes(),
            stands_in,
        }
    }

    /// Leaves drawing to the renderer, which is ready now; showing as well if nothing `is_unseen` so far.
    pub fn step_back(&mut self, is_unseen: bool) {
        if let Self::Draws(stand_in) = std::mem::take(self)
            && !is_unseen
        {
            *self = Self::IsShown(stand_in);
        }
    }

    /// Leaves showing to the renderer if that draws.
    pub fn give_way(&mut self) {
        if let Self::IsShown(_) = self {
            *self = Self::None;
        }
    }
}
