//! What is known of a picture while it is drawn: the last picture, moved to where the camera sees its cloth now, joined
//! with what is drawn of the new one.

use std::sync::Arc;

use renderer_core::geometry::Camera;
use renderer_core::image::Picture;
use renderer_core::render::RenderError;

use super::super::known::{Drawn, Joining, ShownPicture, Surface, enlarged};
use super::super::{ViewRequest, workers};
use super::Worker;

/// Of so many samples on a picture is shown as it is: what was known before has hardly any weight by then.
const JOINED_UP_TO: u32 = 64;

/// What the thread knows of the picture it draws.
#[derive(Default)]
pub(super) struct Knowledge {
    /// What is expected of it, of full size: what was known before the first sample of its present size.
    expected: Option<Arc<Picture>>,
    /// The request that this is of.
    request: Option<Box<ViewRequest>>,
    /// What the picture that is shown shows: the camera, and the cloth if it is made.
    shows: Option<(Camera, Option<Surface>)>,
    /// The last picture that was drawn, whatever has been moved since.
    seen: Option<ShownPicture>,
    /// The picture of the present size when it had half as many samples or fewer,
    earlier: Option<(u32, Picture)>,
    /// and a later one that will take its place: successive samples even each other out, and tell less of their noise.
    next_earlier: Option<(u32, Picture)>,
    joining: Joining,
}

impl Knowledge {
    /// Notes that a picture is drawn at another size, or anew.
    pub fn start_size(&mut self) {
        (self.earlier, self.next_earlier) = (None, None);
        self.joining.start();
    }

    /// Whether the picture in work is of another design than the last that was drawn, from the same place.
    pub fn is_of_edit(&self) -> bool {
        let (Some(seen), Some(request)) = (&self.seen, &self.request) else {
            return false;
        };
        seen.camera == Camera::from_design(&request.camera)
    }

    /// Notes what the picture now shown shows.
    fn note_shown(&mut self, view: &ViewRequest, surface: Option<Surface>) {
        self.shows = Some((Camera::from_design(&view.camera), surface));
    }

    /// What is drawn joined with what is expected; `None` where nothing is.
    fn joined(&mut self, picture: &Picture, samples: u32, error: Option<f64>) -> Option<Picture> {
        let expected = self.expected.as_ref()?;
        let is_earlier =
            |(fewer, it): &&(u32, Picture)| 2 * fewer <= samples && it.size == picture.size;
        let earlier = self.earlier.as_ref().filter(is_earlier);
        let drawn = Drawn {
            picture,
            samples,
            earlier: earlier
                .filter(|_| error.is_none())
                .map(|(fewer, it)| (*fewer, it)),
            error,
        };
        Some(self.joining.join(expected, &drawn))
    }

    /// Keeps a picture to tell the noise of those by that will have twice as many samples.
    fn keep_earlier(&mut self, picture: Picture, samples: u32) {
        let has_half = |kept: &Option<(u32, Picture)>| {
            kept.as_ref().is_some_and(|(fewer, _)| 2 * fewer <= samples)
        };
        if self.earlier.is_none() {
            self.earlier = Some((samples.max(1), picture));
        } else if self.next_earlier.is_none() {
            self.next_earlier = has_half(&self.earlier).then_some((samples, picture));
        } else if has_half(&self.next_earlier) {
            self.earlier = self.next_earlier.replace((samples, picture));
        }
    }
}

impl Worker<'_> {
    /// Prepares for another picture than the one in work: what is seen of its cloth already is shown at once where the
    /// new camera sees it.
    pub(super) fn expect(&mut self, view: &ViewRequest) -> Result<(), RenderError> {
        let last = self.known.request.as_ref();
        if last.is_some_and(|last| view.has_samples_of(last)) {
            return Ok(());
        }
        self.keep_seen()?;
        self.known.request = Some(Box::new(view.clone()));
        self.known.start_size();
        let Some(seen) = &self.known.seen else {
            return Ok(());
        };
        let seen = seen.metered(view.design.metered_stops());
        let camera = Camera::from_design(&view.camera);
        if seen.camera == camera && seen.picture.size == view.size {
            self.known.expected = Some(Arc::clone(&seen.picture));
            return Ok(());
        }
        let background = view.design.background_radiance().map(|c| c as f32);
        let moved = workers::with_all(|| seen.from(&camera, view.size, background));
        let moved = Arc::new(moved);
        self.known.expected = Some(Arc::clone(&moved));
        let transform = &mut self.transform;
        let frame = workers::with_all(|| transform.frame_of(moved, view.display));
        (self.display, self.shows_denoised) = (Some(view.display), false);
        self.publish(|state| {
            state.show(frame);
            state.picture.denoised = None;
            state.picture.is_reduced = true;
        });
        Ok(())
    }

    /// Takes the picture that is shown for what is seen, if it was drawn since the last time.
    fn keep_seen(&mut self) -> Result<(), RenderError> {
        let (Some((camera, surface)), Some(request)) =
            (self.known.shows.take(), &self.known.request)
        else {
            return Ok(());
        };
        let last = self.known.seen.take();
        let Some(surface) = surface.or(last.map(|last| last.surface)) else {
            return Ok(());
        };
        let picture = match (self.transform.picture(), &mut self.renderer) {
            (Some(picture), _) => Arc::clone(picture),
            // It is a texture, of the picture that the renderer still has.
            (None, Some((_, renderer))) => {
                let shown = self.stand_in.shown(renderer).backend();
                Arc::new(workers::with_all(|| shown.picture())?)
            }
            (None, None) => return Ok(()),
        };
        let picture = match picture.size == request.size {
            true => picture,
            false => Arc::new(workers::with_all(|| enlarged(&picture, request.size))),
        };
        self.known.seen = Some(ShownPicture {
            picture,
            camera,
            metered_stops: request.design.metered_stops(),
            surface,
        });
        Ok(())
    }

    /// What to show of a picture that is being drawn, and was drawn so far: joined with what is expected of it, or as it
    /// is (`None`) where nothing is expected or that counts no more.
    pub(super) fn joined(
        &mut self,
        is_whole: bool,
        samples: u32,
        is_done: bool,
    ) -> Result<Option<Picture>, RenderError> {
        if is_whole && (is_done || samples >= JOINED_UP_TO) {
            self.known.expected = None;
        }
        let (Some(_), Some((_, renderer))) = (&self.known.expected, &mut self.renderer) else {
            return Ok(None);
        };
        let shown = self.stand_in.shown(renderer).backend();
        let known = &mut self.known;
        workers::with_all(|| {
            let picture = shown.picture()?;
            let joined = known.joined(&picture, samples, None);
            known.keep_earlier(picture, samples);
            Ok(joined)
        })
    }

    /// A denoised picture with this relRMSE, as far as is known, joined with what is expected.
    pub(super) fn joined_with(
        &mut self,
        picture: &Picture,
        samples: u32,
        error: Option<f64>,
    ) -> Option<Picture> {
        let is_last = self.progress.done && samples == self.progress.samples;
        if is_last || samples >= JOINED_UP_TO {
            return None;
        }
        let known = &mut self.known;
        let error = error.unwrap_or_else(|| known.joining.error_denoised(samples));
        workers::with_all(|| known.joined(picture, samples, Some(error)))
    }

    /// Notes that the picture shown is one of the request in work.
    pub(super) fn note_shown(&mut self) {
        if let Some(view) = &self.view {
            let cloth = self
                .made
                .as_ref()
                .filter(|(design, _)| Arc::ptr_eq(design, &view.design));
            let surface = cloth.map(|(design, cloth)| Surface::new(design, cloth));
            self.known.note_shown(view, surface);
        }
    }

    /// Goes on from what is shown: what is drawn at the next size has samples of its own.
    pub(super) fn expect_what_is_shown(&mut self) {
        let size = self.job.as_ref().map(|job| job.request.size);
        self.known.start_size();
        if let (Some(picture), Some(size)) = (self.transform.picture(), size) {
            self.known.expected = Some(match picture.size == size {
                true => Arc::clone(picture),
                false => Arc::new(workers::with_all(|| enlarged(picture, size))),
            });
        }
    }
}
