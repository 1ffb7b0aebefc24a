//! First looks: a coarse picture of what is wished, from so much of the cloth as it needs, while the rest is being made.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use renderer_core::render::{Camera, LevelPlan, Levels, Progress, RenderRequest, Settings};
use renderer_core::scene::{Cancel, Excerpt, SeenScene};

use super::super::job::Job;
use super::super::{Activity, Wish, first_look};
use super::{FINISHED_ANYWAY, Failure, Worker, advance};
use crate::designer::workers;

impl Worker<'_> {
    /// Shows a coarse picture of a design whose scene will take long, from a scene with only those loops that it needs. True
    /// if there is something to see.
    pub(super) fn glimpse(&mut self, wish: &Wish) -> Result<bool, Failure> {
        let start = Instant::now();
        let cancel = &self.shared.cancel;
        let is_given_up = || cancel.load(Ordering::Relaxed) && start.elapsed() > FINISHED_ANYWAY;
        let Some(request) = self.glance(wish, &is_given_up)? else {
            return Ok(false);
        };
        // Whatever was in work is of another design.
        self.job = None;
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
        let developer = &mut self.developer;
        let image = workers::with_all(|| developer.shoot(renderer, wish.display, 0.0))?;
        self.display = Some(wish.display);
        self.publish(|shown| {
            shown.image = image;
            shown.version += 1;
            shown.progress = Progress {
                done: false,
                ..progress
            };
            shown.is_reduced = true;
            shown.is_first = true;
            shown.is_unseen = false;
            shown.error = None;
            shown.seconds = start.elapsed().as_secs_f64();
        });
        Ok(true)
    }

    /// What to draw for a first look at a wish, if its scene will take long; `None` if not, or if it is there.
    fn glance(
        &mut self,
        wish: &Wish,
        is_given_up: &(dyn Fn() -> bool + Sync),
    ) -> Result<Option<RenderRequest>, Failure> {
        let choice = wish.choice.for_method(wish.design.quality.method);
        let choice = self.fallback.effective(choice);
        let largest_side = match &mut self.renderer {
            Some((made, renderer)) if *made == choice => renderer.backend().largest_side(),
            _ => return Ok(None),
        };
        if self.loops_took < first_look::WORTH_IT || !wish.design.faults().is_empty() {
            return Ok(None);
        }
        let size = self.fallback.fitted(wish.size, largest_side);
        let settings = wish.light.settings(&wish.design);
        let camera = Camera::from_design(&wish.camera);
        if Excerpt::is_needed(&wish.design) {
            return self.glance_at_levels(wish, &camera, size, settings, is_given_up);
        }
        let is_edit =
            (self.made.as_ref()).is_some_and(|(design, _)| !Arc::ptr_eq(design, &wish.design));
        if !is_edit || self.maker.has_loops_of(&wish.design, &LevelPlan::whole()) {
            return Ok(None);
        }
        let plan = workers::with_all(|| {
            first_look::plan(&wish.design, &camera, size, &settings, self.cost)
        });
        let Some(look) = plan else {
            return Ok(None);
        };
        self.publish(|shown| shown.activity = Activity::Compiling);
        let compiler = self.maker.whole();
        let made = workers::with_all(|| {
            compiler.compile_seen(&wish.design, &look.seen, &Cancel::when(is_given_up))
        })?;
        let SeenScene::Part(scene) = made else {
            return Ok(None);
        };
        let whole = RenderRequest {
            scene,
            camera,
            levels: Levels::default(),
            size,
            crop: [0, 0, size[0], size[1]],
            settings,
        };
        Ok(Some(Job::glance(&whole, look.divisor)))
    }

    /// The same for cloth that is made in parts, after an edit or where the camera leaves what was made: levels that are fine
    /// enough for the coarse picture.
    fn glance_at_levels(
        &mut self,
        wish: &Wish,
        camera: &Camera,
        size: [u32; 2],
        settings: Settings,
        is_given_up: &(dyn Fn() -> bool + Sync),
    ) -> Result<Option<RenderRequest>, Failure> {
        let plan = self.plan(wish, camera);
        if self.has_parts(wish, &plan) || self.maker.has_loops_of(&wish.design, &plan) {
            return Ok(None);
        }
        let divisor = first_look::divisor_of_levels(size, self.cost);
        let reduced = size.map(|side| side.div_ceil(divisor));
        let plan = LevelPlan::new(&wish.design, camera, reduced, first_look::LEVELS, None);
        self.publish(|shown| shown.activity = Activity::Compiling);
        let maker = &mut self.glimpse_maker;
        let made =
            workers::with_all(|| maker.make(&wish.design, plan, &Cancel::when(is_given_up)))?;
        let sight = made.sight(&wish.design, camera, reduced);
        Ok(Some(Job::glance(&sight.request(size, settings), divisor)))
    }
}
