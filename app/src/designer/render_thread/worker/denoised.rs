//! Denoised pictures in place of plain ones: when one is made, and when it is shown.

use std::sync::Arc;

use renderer_core::image::Display;
use renderer_core::render::Progress;

use super::super::denoising::Outcome;
use super::super::{DenoisedPart, workers};
use super::{Failure, Worker};

impl Worker<'_> {
    /// Another picture is begun.
    pub(super) fn forget_denoised(&mut self) {
        self.denoising.restart();
        self.denoised = None;
        self.progress = Progress::default();
    }

    /// Gives the picture as it is to the denoiser, if that should have it.
    pub(super) fn denoise_if_due(&mut self) -> Result<(), Failure> {
        let (Some(job), Some((_, renderer)), Some(view)) =
            (&self.job, &mut self.renderer, &self.view)
        else {
            return Ok(());
        };
        let progress = self.progress;
        let is_whole = progress.samples > 0 && !job.is_reduced() && !job.is_behind();
        if !(view.denoises && is_whole && self.denoising.wants(progress.samples, progress.done)) {
            return Ok(());
        }
        let shown = self.stand_in.shown(renderer).backend();
        let picture = workers::with_all(|| shown.picture())?;
        let scale = view.display.exposure.exp2() as f32;
        self.denoising.denoise(progress, picture, scale);
        Ok(())
    }

    /// Takes what the denoiser has to say, shows it, and gives it more where there is more.
    pub(super) fn take_denoised(&mut self, outcome: Outcome) -> Result<(), Failure> {
        let (denoised, failure) = self.denoising.take(outcome);
        let state_now = self.denoising.state.clone();
        self.publish(|state| {
            state.denoising = state_now;
            if let Some(failure) = failure {
                state.report("No longer denoised", failure);
            }
        });
        if let (Some(denoised), Some(view)) = (denoised, &self.view) {
            let (display, denoises) = (view.display, view.denoises);
            self.denoised = Some(denoised);
            if denoises {
                self.shows_denoised = false;
                self.show_denoised(display);
            }
        }
        self.denoise_if_due()
    }

    /// Publishes the last denoised picture, unless it is shown like that.
    pub(super) fn show_denoised(&mut self, display: Display) {
        if self.shows_denoised && self.display == Some(display) {
            return;
        }
        let Some(denoised) = self.denoised.take() else {
            return;
        };
        let (samples, mix) = (denoised.samples, &denoised.mix);
        let joined = self.joined_with(&mix.picture, samples, mix.error);
        let picture = joined.unwrap_or_else(|| mix.picture.clone());
        let transform = &mut self.transform;
        let frame = workers::with_all(|| transform.frame_of(Arc::new(picture), display));
        let part = DenoisedPart {
            samples,
            share: mix.share,
            error: mix.error,
        };
        self.denoised = Some(denoised);
        (self.display, self.shows_denoised) = (Some(display), true);
        self.note_shown();
        self.publish(|state| {
            state.show(frame);
            state.picture.denoised = Some(part);
            state.picture.is_reduced = false;
        });
    }
}
