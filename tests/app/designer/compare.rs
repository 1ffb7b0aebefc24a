//! What is seen of the picture itself: the loupe, and a snapshot beside it.

use super::view::{camera, focus_viewport, is_said, on_processor, picture_rect, undo};
use super::*;

/// A backend that draws black and white columns of one pixel, and tints the cloth by its number of warps.
struct Stripes(FlatBackend, u32);

impl Backend for Stripes {
    fn kind(&self) -> BackendKind {
        BackendKind::Cpu
    }

    fn device_name(&self) -> String {
        "stripes".into()
    }

    fn begin(&mut self, request: &RenderRequest) -> Result<(), RenderError> {
        self.1 = request.scene().sheet.warps;
        self.0.begin(request)
    }

    fn advance(&mut self, slice: Duration, stop: &AtomicBool) -> Result<Progress, RenderError> {
        self.0.advance(slice, stop)
    }

    fn picture(&mut self) -> Result<Picture, RenderError> {
        let mut picture = self.0.picture()?;
        let width = picture.size[0] as usize;
        let blue = if self.1 == 120 { 0.0 } else { 1.0 };
        for (index, pixel) in picture.pixels.iter_mut().enumerate() {
            let white = if (index % width).is_multiple_of(2) {
                1.0
            } else {
                0.0
            };
            *pixel = [white, white, blue, 1.0];
        }
        Ok(picture)
    }

    fn counters(&mut self) -> Result<Counters, RenderError> {
        self.0.counters()
    }

    fn device_bytes(&self) -> u64 {
        0
    }
}

pub(super) fn striped() -> towel_designer::designer::MakeBackend {
    Arc::new(|_| Ok(Box::new(Stripes(FlatBackend::default(), 0))))
}

/// A designer whose window can be photographed.
fn photographed() -> Harness<'static, App> {
    let mut harness = Harness::builder()
        .with_size(vec2(1000.0, 560.0))
        .with_step_dt(1.0 / 60.0)
        .wgpu()
        .build_eframe(|cc| App::new(cc, on_processor(striped())));
    harness.run_steps(3);
    wait_for_whole_picture(&mut harness, 0);
    // A gesture, so that the hint is gone.
    let at = picture_rect(&harness).center();
    harness.drag_at(at);
    harness.run_steps(1);
    harness.hover_at(at + vec2(5.0, 0.0));
    harness.run_steps(1);
    harness.drop_at(at + vec2(5.0, 0.0));
    harness.run_steps(3);
    let version = harness.state().viewport().state().picture.version;
    wait_for_whole_picture(&mut harness, version);
    harness
}

fn wait_for_whole_picture(harness: &mut Harness<'_, App>, after: u64) {
    wait(harness, "the picture", |h| {
        let state = h.state().viewport().state();
        state.picture.version >= after && state.picture.progress.done && !state.picture.is_reduced
    });
    harness.run_steps(3);
}

/// Whether a pixel is of the blue picture; both have black or white in the other channels.
fn is_blue(pixel: &image::Rgba<u8>) -> bool {
    pixel[2] > 200 && pixel[0] < 60
}

/// Changes of brightness along 120 pixels.
fn changes(picture: &image::RgbaImage, at: Pos2) -> usize {
    let (x, y) = (at.x as u32, at.y as u32);
    let row: Vec<bool> = (x - 60..x + 60)
        .map(|x| picture.get_pixel(x, y)[0] > 128)
        .collect();
    row.windows(2).filter(|pair| pair[0] != pair[1]).count()
}

#[test]
fn the_loupe_shows_every_pixel_as_four_by_four() {
    let mut harness = photographed();
    let rect = picture_rect(&harness);
    let at = rect.center().round();
    harness.hover_at(at);
    focus_viewport(&mut harness);
    let without = harness.render().expect("a picture of the window");
    harness.key_press(Key::L);
    harness.run_steps(4);
    let with = harness.render().expect("a picture of the window");
    // One change a pixel outside, one every fourth inside: give or take one at the ends.
    let line = at + vec2(0.0, 20.0);
    assert!(
        changes(&without, line) >= 110,
        "{}",
        changes(&without, line)
    );
    assert!(
        (28..=32).contains(&changes(&with, line)),
        "{}",
        changes(&with, line)
    );
    harness.key_press(Key::L);
    harness.run_steps(4);
    let again = harness.render().expect("a picture of the window");
    assert!(changes(&again, line) >= 110);
}

/// Where the blue picture begins on a line across the viewport, as a share of its width; 1 where it does not.
fn border(harness: &mut Harness<'_, App>) -> f32 {
    let rect = picture_rect(harness);
    let picture = harness.render().expect("a picture of the window");
    let y = (rect.top() + 0.3 * rect.height()) as u32;
    let (left, right) = (rect.left() as u32 + 3, rect.right() as u32 - 3);
    let mut row = left..right;
    let first = row.find(|&x| is_blue(picture.get_pixel(x, y)));
    (first.unwrap_or(right) as f32 - rect.left()) / rect.width()
}

#[test]
fn a_snapshot_is_compared_with_and_restored() {
    let mut harness = photographed();
    focus_viewport(&mut harness);
    harness.key_press(Key::C);
    harness.run_steps(3);
    assert!(is_said(&harness, "Nothing to compare with"));
    click(&mut harness, "Dismiss: Nothing to compare with");
    focus_viewport(&mut harness);
    harness.key_press(Key::S);
    harness.run_steps(3);
    assert!(harness.state().viewport().is_comparing());
    let (before, seen) = (design(&harness).clone(), camera(&harness));

    let version = harness.state().viewport().state().picture.version;
    type_number(&mut harness, "Warps", "100");
    wait_for_whole_picture(&mut harness, version + 1);
    let edited = design(&harness).clone();
    assert!(
        (border(&mut harness) - 0.5).abs() < 0.02,
        "{}",
        border(&mut harness)
    );

    // The divider, by the pointer and by keys.
    let rect = picture_rect(&harness);
    // Smaller cloth is seen from nearer.
    let nearer = camera(&harness);
    let from = pos(rect, 0.5);
    harness.drag_at(from);
    harness.run_steps(1);
    harness.hover_at(pos(rect, 0.75));
    harness.run_steps(1);
    harness.drop_at(pos(rect, 0.75));
    harness.run_steps(3);
    assert!(
        (border(&mut harness) - 0.75).abs() < 0.02,
        "{}",
        border(&mut harness)
    );
    assert_eq!(
        camera(&harness),
        nearer,
        "dragging the divider turns nothing"
    );
    harness
        .get_by_role_and_label(Role::Slider, "Divider between snapshot and picture")
        .focus();
    harness.run_steps(2);
    for _ in 0..5 {
        harness.key_press(Key::ArrowLeft);
        harness.run_steps(2);
    }
    assert!(
        (border(&mut harness) - 0.65).abs() < 0.02,
        "{}",
        border(&mut harness)
    );
    focus_viewport(&mut harness);
    harness.key_press(Key::C);
    harness.run_steps(3);
    assert!(border(&mut harness) < 0.02, "the snapshot is hidden");

    click(&mut harness, "Toolbar: Front");
    click(&mut harness, "Toolbar: Compare");
    click(&mut harness, "Restore snapshot");
    assert_eq!(*design(&harness), before);
    assert_eq!(camera(&harness), seen);
    undo(&mut harness, "restore snapshot");
    assert_eq!(*design(&harness), edited);
}

/// A place on the screen at a share of the picture's width.
fn pos(rect: egui::Rect, share: f32) -> Pos2 {
    Pos2::new(
        rect.left() + share * rect.width(),
        rect.top() + 0.6 * rect.height(),
    )
}
