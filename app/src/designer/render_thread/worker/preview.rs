//! The coarse preview: a small picture of what is requested, from so much of the cloth as it needs, while the rest is
//! being made.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use renderer_core::geometry::Camera;
use renderer_core::render::{Progress, RenderRequest, Settings};
use renderer_core::scene::lod::{LodPlan, LodRegion, LodView};
use renderer_core::scene::{Cancel, PreviewScene};

use super::super::stand_in::StandIn;
use super::super::{Stage, ViewRequest, coarse_preview, workers};
use super::{FINISHED_ANYWAY, Failure, Worker, advance};

impl Worker<'_> {
    /// Shows a coarse preview of a design whose scene will take long, from a scene with only those loops that it needs.
    /// True if there is something to see.
    pub(super) fn preview(&mut self, view: &ViewRequest) -> Result<bool, Failure> {
        let start = Instant::now();
        let cancel = &self.shared.cancel;
        let is_given_up = || cancel.load(Ordering::Relaxed) && start.elapsed() > FINISHED_ANYWAY;
        let Some(request) = self.preview_request(view, &is_given_up)? else {
            return Ok(false);
        };
        // Whatever was in work is of another design.
        self.job = None;
        self.stand_in = StandIn::None;
        self.forget_denoised();
        self.known.start_size();
        let Some((_, renderer)) = &mut self.renderer else {
            return Ok(false);
        };
        let backend = renderer.backend();
        workers::with_all(|| backend.begin_soon(&request))?;
        if !backend.is_ready()? {
            return Ok(false);
        }
        let never = AtomicBool::new(false);
        let mut progress = Progress::default();
        while !progress.done {
            if is_given_up() {
                return Ok(false);
            }
            progress = advance(renderer, &never)?;
        }
        let joined = self.joined(false, progress.samples, false)?;
        let (transform, Some((_, renderer))) = (&mut self.transform, &mut self.renderer) else {
            return Ok(false);
        };
        let frame = workers::with_all(|| match joined {
            Some(joined) => Ok(transform.frame_of(Arc::new(joined), view.display)),
            None => transform.frame(renderer, view.display, 0.0),
        })?;
        (self.display, self.shows_denoised) = (Some(view.display), false);
        self.note_shown();
        self.publish(|state| {
            state.show(frame);
            state.picture.denoised = None;
            state.picture.progress = Progress {
                done: false,
                ..progress
            };
            state.picture.is_reduced = true;
            state.picture.seconds = start.elapsed().as_secs_f64();
            state.error = None;
        });
        Ok(true)
    }

    /// What to draw as a preview of a request, if its scene will take long; `None` if not, or if it is there.
    fn preview_request(
        &mut self,
        view: &ViewRequest,
        is_given_up: &(dyn Fn() -> bool + Sync),
    ) -> Result<Option<RenderRequest>, Failure> {
        let choice = view.choice.for_method(view.design.quality.method);
        let choice = self.fallback.effective(choice);
        let largest_side = match &mut self.renderer {
            Some((made, renderer)) if *made == choice => renderer.backend().largest_side(),
            _ => return Ok(None),
        };
        if self.loops_took < coarse_preview::WORTH_IT || !view.design.faults().is_empty() {
            return Ok(None);
        }
        let size = self.fallback.fitted(view.size, largest_side);
        let settings = view.light.settings(&view.design);
        let camera = Camera::from_design(&view.camera);
        if LodRegion::is_needed(&view.design) {
            return self.preview_of_levels(view, &camera, size, settings, is_given_up);
        }
        let is_edit =
            (self.made.as_ref()).is_some_and(|(design, _)| !Arc::ptr_eq(design, &view.design));
        if !is_edit || self.maker.has_loops_of(&view.design, &LodPlan::whole()) {
            return Ok(None);
        }
        let plan = workers::with_all(|| {
            coarse_preview::plan(&view.design, &camera, size, &settings, self.cost)
        });
        let Some(preview) = plan else {
            return Ok(None);
        };
        self.publish(|state| state.stage = Stage::Compiling);
        let compiler = self.maker.whole();
        let made = workers::with_all(|| {
            compiler.compile_visible(&view.design, &preview.seen, &Cancel::when(is_given_up))
        })?;
        let PreviewScene::Part(scene) = made else {
            return Ok(None);
        };
        let whole = RenderRequest::new(LodView::of(scene, camera), size, settings);
        Ok(Some(coarse_preview::reduced(&whole, preview.divisor)))
    }

    /// What to draw as a preview of cloth that is made in parts, after an edit or where the camera leaves what was
    /// made: levels that are just fine enough for it.
    fn preview_of_levels(
        &mut self,
        view: &ViewRequest,
        camera: &Camera,
        size: [u32; 2],
        settings: Settings,
        is_given_up: &(dyn Fn() -> bool + Sync),
    ) -> Result<Option<RenderRequest>, Failure> {
        let plan = self.plan(view, camera);
        if self.has_parts(view, &plan) || self.maker.has_loops_of(&view.design, &plan) {
            return Ok(None);
        }
        let divisor = coarse_preview::divisor_of_levels(size, self.cost);
        let reduced = size.map(|side| side.div_ceil(divisor));
        let plan = LodPlan::new(&view.design, camera, reduced, coarse_preview::LEVELS, None);
        self.publish(|state| state.stage = Stage::Compiling);
        let maker = &mut self.preview_maker;
        let made =
            workers::with_all(|| maker.make(&view.design, plan, &Cancel::when(is_given_up)))?;
        let seen = made.view(&view.design, camera, reduced);
        let whole = RenderRequest::new(seen, size, settings);
        Ok(Some(coarse_preview::reduced(&whole, divisor)))
    }
}
