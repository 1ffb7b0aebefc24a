//! Pictures drawn in the background: in which order, what is given up for what, and that nothing of it reaches the
//! window but pictures and reasons.

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex};

use renderer_core::design::{CameraDesign, Colour, Design, Method};
use towel_designer::backend::{self, BackendChoice};
use towel_designer::designer::thumbnails::{
    DrawnThumbnail, ThumbnailJob, ThumbnailKey, ThumbnailRenderer, ThumbnailSubject,
};
use towel_designer::designer::{MakeBackend, Priority};

use super::{FlatBackend, PATIENCE};

fn flat() -> MakeBackend {
    Arc::new(|choice| {
        assert_eq!(choice, BackendChoice::Cpu);
        Ok(Box::new(FlatBackend {
            size: [1, 1],
            samples: 0,
        }))
    })
}

fn key(name: &str) -> ThumbnailKey {
    ThumbnailKey::Preset(PathBuf::from(name))
}

fn few_loops() -> ThumbnailSubject {
    let mut design = Design::default();
    (design.sheet.warps, design.sheet.wefts) = (4, 4);
    ThumbnailSubject {
        design,
        camera: CameraDesign::default(),
    }
}

fn job(
    key: ThumbnailKey,
    is_urgent: bool,
    subject: impl FnOnce() -> Result<ThumbnailSubject, String> + Send + 'static,
) -> ThumbnailJob {
    ThumbnailJob {
        key,
        subject: Box::new(subject),
        size: [40, 24],
        samples: 8,
        is_urgent,
    }
}

/// A job that waits at its beginning until it is let go.
fn held(key: ThumbnailKey) -> (ThumbnailJob, Sender<()>, Receiver<()>) {
    let (go, wait) = channel();
    let (here, is_here) = channel();
    let job = job(key, false, move || {
        here.send(()).expect("the test listens");
        wait.recv().expect("the test lets go");
        Ok(few_loops())
    });
    (job, go, is_here)
}

/// All news of a job until the last.
#[track_caller]
fn news(pictures: &ThumbnailRenderer, key: &ThumbnailKey) -> Vec<DrawnThumbnail> {
    let mut all = Vec::new();
    let is_last = |drawn: &DrawnThumbnail| drawn.is_final;
    while !all.last().is_some_and(is_last) {
        let drawn = pictures.take_within(key, PATIENCE);
        all.push(drawn.unwrap_or_else(|| panic!("no picture of {key:?}, but {all:?}")));
    }
    all
}

/// Frames that a window is asked for.
fn counted() -> (egui::Context, Arc<AtomicUsize>) {
    let (ctx, count) = (egui::Context::default(), Arc::new(AtomicUsize::new(0)));
    let counter = Arc::clone(&count);
    ctx.set_request_repaint_callback(move |_| {
        counter.fetch_add(1, Ordering::Relaxed);
    });
    (ctx, count)
}

#[test]
fn a_picture_is_what_the_design_is_and_one_frame_is_asked_for() {
    let (ctx, frames) = counted();
    let mut pictures = ThumbnailRenderer::new(Arc::new(backend::make), ctx);
    let red = || {
        let mut red = few_loops();
        red.design.light.background = Colour([200, 20, 20]);
        red.design.quality.method = Method::Single;
        red.camera.elevation = 0.0;
        red.camera.target = [0.0, 0.0, 1000.0];
        Ok(red)
    };
    pictures.draw(job(key("red"), false, red));
    let [drawn] = &news(&pictures, &key("red"))[..] else {
        panic!("a picture in the background comes once, whole");
    };
    let image = drawn.image.as_ref().expect("a picture");
    assert_eq!(image.size, [40, 24]);
    // Nothing but background: its colour goes through light and back, which rounds by half a step at most.
    let near = |pixel: &egui::Color32| {
        let differs = |a: u8, b: u8| a.abs_diff(b) > 1;
        !(differs(pixel.r(), 200) || differs(pixel.g(), 20) || differs(pixel.b(), 20))
    };
    assert!(image.pixels.iter().all(near), "{:?}", image.pixels[0]);
    assert!(pictures.wait_for_rest(PATIENCE));
    assert_eq!(frames.load(Ordering::Relaxed), 1);
    assert!(pictures.take(&key("red")).is_none(), "news come once");
}

#[test]
fn urgent_pictures_come_first_the_newest_before_others_and_coarse() {
    let mut pictures = ThumbnailRenderer::new(flat(), egui::Context::default());
    let (first, go, is_here) = held(key("first"));
    pictures.draw(first);
    is_here.recv().expect("the thread is at work");
    let order = Arc::new(Mutex::new(Vec::new()));
    for (name, is_urgent) in [("b", false), ("c", false), ("x", true), ("y", true)] {
        let order = Arc::clone(&order);
        pictures.draw(job(key(name), is_urgent, move || {
            order.lock().expect("whole").push(name);
            Ok(few_loops())
        }));
    }
    go.send(()).expect("the thread waits");
    for name in ["first", "b", "c"] {
        assert_eq!(news(&pictures, &key(name)).len(), 1);
    }
    assert_eq!(*order.lock().expect("whole"), ["y", "x", "b", "c"]);
}

#[test]
fn a_newer_request_replaces_an_older_one_and_a_forgotten_one_never_comes() {
    let mut pictures = ThumbnailRenderer::new(flat(), egui::Context::default());
    let (old, go, is_here) = held(key("it"));
    pictures.draw(old);
    is_here.recv().expect("the thread is at work");
    pictures.draw(job(key("gone"), false, || {
        panic!("forgotten before it began")
    }));
    pictures.forget(&key("gone"));
    let mut newer = job(key("it"), false, || Ok(few_loops()));
    newer.size = [8, 8];
    pictures.draw(newer);
    go.send(()).expect("the thread waits");
    let drawn = news(&pictures, &key("it"));
    let [
        DrawnThumbnail {
            image: Ok(image), ..
        },
    ] = &drawn[..]
    else {
        panic!("{drawn:?}");
    };
    assert_eq!(image.size, [8, 8], "the older picture came");
    assert!(pictures.take(&key("gone")).is_none());
}

#[test]
fn failures_are_reported_and_the_next_picture_comes() {
    let broken: MakeBackend = Arc::new(|_| panic!("no backend"));
    let mut without = ThumbnailRenderer::new(broken, egui::Context::default());
    without.draw(job(key("it"), false, || Ok(few_loops())));
    let drawn = news(&without, &key("it"));
    assert!(drawn[0].image.is_err(), "{drawn:?}");

    let mut pictures = ThumbnailRenderer::new(flat(), egui::Context::default());
    pictures.draw(job(key("file"), false, || Err("no such file".into())));
    let drawn = news(&pictures, &key("file"));
    assert_eq!(drawn[0].image.as_ref().err().unwrap(), "no such file");
    pictures.draw(job(key("fault"), true, || {
        let mut subject = few_loops();
        subject.design.pile.layers = 0;
        Ok(subject)
    }));
    let drawn = news(&pictures, &key("fault"));
    assert!(
        drawn[0]
            .image
            .as_ref()
            .err()
            .unwrap()
            .contains("pile.layers is 0")
    );
    pictures.draw(job(key("good"), false, || Ok(few_loops())));
    assert!(news(&pictures, &key("good"))[0].image.is_ok());
}

#[test]
fn the_viewports_first_picture_comes_before_all_but_a_coarse_one() {
    let mut pictures = ThumbnailRenderer::new(flat(), egui::Context::default());
    pictures.give_way(Priority::High);
    let is_begun = Arc::new(AtomicBool::new(false));
    let begins = Arc::clone(&is_begun);
    pictures.draw(job(key("preset"), false, move || {
        begins.store(true, Ordering::Relaxed);
        Ok(few_loops())
    }));
    pictures.draw(job(ThumbnailKey::Loop, true, || Ok(few_loops())));
    let coarse = pictures.take_within(&ThumbnailKey::Loop, PATIENCE);
    let coarse = coarse.expect("a coarse picture");
    assert!(!coarse.is_final);
    assert_eq!(coarse.image.expect("a picture").size, [10, 6]);
    assert!(pictures.wait_for_rest(PATIENCE), "it did not give way");
    assert!(
        pictures.take(&ThumbnailKey::Loop).is_none(),
        "it did not give way"
    );
    pictures.give_way(Priority::Medium);
    let whole = news(&pictures, &ThumbnailKey::Loop);
    assert_eq!(whole[0].image.as_ref().expect("a picture").size, [40, 24]);
    assert!(pictures.wait_for_rest(PATIENCE), "it did not give way");
    assert!(!is_begun.load(Ordering::Relaxed), "it did not give way");
    pictures.give_way(Priority::Low);
    news(&pictures, &key("preset"));
}

#[test]
fn the_thread_ends_with_the_window_even_in_the_midst_of_a_picture() {
    let (alive, gone) = channel::<()>();
    let flat = flat();
    let make: MakeBackend = Arc::new(move |choice| {
        // It lives as long as what backends are made with.
        let _ = &alive;
        flat(choice)
    });
    let mut pictures = ThumbnailRenderer::new(make, egui::Context::default());
    let (first, go, is_here) = held(key("first"));
    pictures.draw(first);
    pictures.draw(job(key("second"), false, || {
        panic!("nobody looks any more")
    }));
    is_here.recv().expect("the thread is at work");
    drop(pictures);
    go.send(()).expect("the thread waits");
    let ended = gone.recv_timeout(PATIENCE);
    assert_eq!(ended, Err(RecvTimeoutError::Disconnected), "it still runs");
}
