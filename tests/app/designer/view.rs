//! The viewport: gestures, saved views, true scale, the cloth alone, what lies under the pointer.

use egui::{Event, MouseWheelSource, MouseWheelUnit, TouchPhase};
use glam::{DVec2, DVec3};
use renderer_core::design::CameraDesign;
use renderer_core::geometry::Camera;
use towel_designer::designer::{MakeBackend, camera_moves};

use super::compare::striped;
use super::*;

pub(super) fn camera(harness: &Harness<'_, App>) -> CameraDesign {
    harness.state().viewport().camera.clone()
}

pub(super) fn picture_rect(harness: &Harness<'_, App>) -> egui::Rect {
    harness.get_by_label("Viewport").rect()
}

pub(super) fn focus_viewport(harness: &mut Harness<'_, App>) {
    harness.get_by_label("Viewport").focus();
    harness.run_steps(2);
}

/// Where on the cloth's plane a place on the screen lies, mm.
fn on_cloth(harness: &Harness<'_, App>, at: Pos2) -> DVec3 {
    let (rect, size) = (picture_rect(harness), harness.state().viewport().size());
    let share = (at - rect.min) / rect.size();
    let pixel = DVec2::new(f64::from(share.x), f64::from(share.y))
        * DVec2::new(f64::from(size[0]), f64::from(size[1]));
    let (origin, direction) = Camera::from_design(&camera(harness)).ray(pixel, size);
    origin - direction * (origin.z / direction.z)
}

fn scroll(harness: &mut Harness<'_, App>, delta: Vec2, fingers: bool, modifiers: Modifiers) {
    let (unit, source) = if fingers {
        (MouseWheelUnit::Point, MouseWheelSource::Trackpad)
    } else {
        (MouseWheelUnit::Line, MouseWheelSource::Wheel)
    };
    harness.event(Event::ModifiersChanged(modifiers));
    harness.event(Event::MouseWheel {
        unit,
        source,
        delta,
        phase: TouchPhase::Move,
        modifiers,
    });
    // egui spreads a scroll over some frames.
    harness.run_steps(20);
    harness.event(Event::ModifiersChanged(Modifiers::NONE));
    harness.run_steps(1);
}

#[test]
fn what_was_seen_whole_stays_whole_when_the_chart_editor_opens() {
    let mut harness = designer(None);
    harness.get_by_label("Toolbar: Front").click();
    wait(&mut harness, "the picture", |h| {
        h.state().viewport().state().picture.frame.is_some()
    });
    harness.run_steps(3);
    let seen_whole = |harness: &Harness<'_, App>| {
        let size = harness.state().viewport().size();
        camera_moves::shows_all(&camera(harness), design(harness), size)
    };
    let first = camera(&harness);
    assert!(seen_whole(&harness));
    let size = harness.state().viewport().size();
    let open_and_close = |harness: &mut Harness<'_, App>| {
        click(harness, "Edit chart");
        harness.run_steps(20);
    };
    open_and_close(&mut harness);
    let narrow = harness.state().viewport().size();
    assert!(narrow[0] < size[0] / 2 + 100, "{narrow:?} of {size:?}");
    assert!(
        !camera_moves::shows_all(&first, design(&harness), narrow),
        "there is room: nothing is tested"
    );
    assert!(seen_whole(&harness) && camera(&harness).distance > first.distance);
    open_and_close(&mut harness);
    assert_eq!(harness.state().viewport().size(), size);
    assert_eq!(camera(&harness), first, "it comes back");

    // What was not seen whole stays as near as it was, and so does what was turned meanwhile.
    click(&mut harness, "Toolbar: Macro");
    let near = camera(&harness);
    open_and_close(&mut harness);
    assert_eq!(camera(&harness), near);
    open_and_close(&mut harness);
    click(&mut harness, "Toolbar: Front");
    open_and_close(&mut harness);
    focus_viewport(&mut harness);
    harness.key_press(Key::ArrowLeft);
    harness.run_steps(3);
    let turned = camera(&harness);
    open_and_close(&mut harness);
    assert_eq!(camera(&harness), turned);
}

#[test]
fn wheel_and_pinch_zoom_to_the_pointer() {
    let mut harness = designer(None);
    let at = picture_rect(&harness).center() + vec2(90.0, 60.0);
    harness.hover_at(at);
    harness.run_steps(2);
    let (first, point) = (camera(&harness), on_cloth(&harness, at));
    scroll(&mut harness, vec2(0.0, 2.0), false, Modifiers::NONE);
    let wheeled = camera(&harness);
    assert!(wheeled.distance < 0.95 * first.distance);
    // f32 screen positions of some hundred points, and a hundred mm of cloth over them.
    assert!((on_cloth(&harness, at) - point).length() < 0.01);
    harness.event(Event::Zoom(1.5));
    harness.run_steps(3);
    let pinched = camera(&harness);
    assert!((wheeled.distance / pinched.distance - 1.5).abs() < 1e-6);
    assert!((on_cloth(&harness, at) - point).length() < 0.01);
    assert_eq!(pinched.azimuth, first.azimuth);
    assert!(
        !harness.state().document().is_unsaved(),
        "looking is no change"
    );
}

#[test]
fn two_fingers_move_the_cloth_and_turn_it_with_alt() {
    let mut harness = designer(None);
    let at = picture_rect(&harness).center();
    harness.hover_at(at);
    harness.run_steps(2);
    let (first, point) = (camera(&harness), on_cloth(&harness, at));
    let by = vec2(40.0, 25.0);
    scroll(&mut harness, by, true, Modifiers::NONE);
    let panned = camera(&harness);
    assert_eq!(
        (panned.distance, panned.azimuth),
        (first.distance, first.azimuth)
    );
    let moved = on_cloth(&harness, at + by);
    assert!((moved - point).length() < 0.05, "{moved} is not {point}");
    scroll(&mut harness, by, true, Modifiers::ALT);
    let orbited = camera(&harness);
    assert_eq!(orbited.target, panned.target);
    assert!(orbited.azimuth < panned.azimuth && orbited.elevation > panned.elevation);
    harness.event(Event::Rotate(0.2));
    harness.run_steps(2);
    let twisted = camera(&harness);
    assert!((twisted.azimuth - orbited.azimuth - 0.2_f64.to_degrees()).abs() < 1e-4);
}

fn views(harness: &Harness<'_, App>) -> Vec<String> {
    let cameras = &design(harness).view.cameras;
    cameras.iter().map(|camera| camera.name.clone()).collect()
}

#[track_caller]
pub(super) fn undo(harness: &mut Harness<'_, App>, name: &str) {
    assert_eq!(harness.state().document().undo_name(), Some(name));
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    harness.run_steps(3);
}

fn save_view(harness: &mut Harness<'_, App>, name: &str) {
    click(harness, "Toolbar: Views");
    harness
        .get_by_role_and_label(Role::TextInput, "Name of a new view")
        .focus();
    harness.run_steps(2);
    harness.event(Event::Text(name.into()));
    harness.run_steps(2);
    click(harness, "Save this view");
    harness.run_steps(3);
}

#[test]
fn views_are_saved_and_jumped_to_by_keys() {
    let mut harness = designer(None);
    let first = camera(&harness);
    click(&mut harness, "Toolbar: Back");
    let back = camera(&harness);
    save_view(&mut harness, "from below");
    assert_eq!(views(&harness), ["default", "from below"]);
    assert_eq!(design(&harness).view.cameras[1].elevation, -90.0);
    // A name that is taken gets a number: names are what --camera knows views by.
    save_view(&mut harness, "from below");
    assert_eq!(views(&harness)[2], "from below 2");
    assert!(design(&harness).faults().is_empty());
    undo(&mut harness, "save view “from below 2”");
    assert_eq!(views(&harness), ["default", "from below"]);

    harness.key_press_modifiers(Modifiers::ALT, Key::Num1);
    harness.run_steps(3);
    assert_eq!(camera(&harness), first);
    harness.key_press_modifiers(Modifiers::ALT, Key::Num2);
    harness.run_steps(3);
    let jumped = camera(&harness);
    assert_eq!(
        (jumped.elevation, jumped.distance),
        (back.elevation, back.distance)
    );
    harness.key_press_modifiers(Modifiers::ALT, Key::Num7);
    harness.run_steps(3);
    assert!(harness.query_by_label("There is no view 7").is_some());
    assert_eq!(camera(&harness), jumped);
    undo(&mut harness, "save view “from below”");
    assert_eq!(*design(&harness), Design::default());
}

#[test]
fn saved_views_are_renamed_set_ordered_and_removed() {
    let mut harness = designer_of_size(None, vec2(1280.0, 2400.0));
    open_panel(&mut harness, "View & quality");
    click(&mut harness, "Toolbar: Macro");
    click(&mut harness, "Save this view");
    let macro_view = camera(&harness);
    assert_eq!(views(&harness), ["default", "view 2"]);

    let names: Vec<_> = harness
        .get_all_by_role_and_label(Role::TextInput, "Name")
        .map(|node| node.rect().center())
        .collect();
    harness.drag_at(names[1]);
    harness.drop_at(names[1]);
    harness.run_steps(2);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::A);
    harness.run_steps(1);
    harness.event(Event::Text("loops".into()));
    harness.run_steps(1);
    harness.key_press(Key::Enter);
    harness.run_steps(3);
    assert_eq!(views(&harness), ["default", "loops"]);
    assert_eq!(
        camera(&harness).distance,
        macro_view.distance,
        "a name moves nothing"
    );

    click(&mut harness, "Move view 2 up");
    assert_eq!(views(&harness), ["loops", "default"]);
    undo(&mut harness, "order of views");
    assert_eq!(views(&harness), ["default", "loops"]);

    click(&mut harness, "Toolbar: Back");
    click(&mut harness, "Set view 2 to what is seen");
    assert_eq!(design(&harness).view.cameras[1].elevation, -90.0);
    assert_eq!(views(&harness)[1], "loops");
    undo(&mut harness, "set view “loops”");
    assert_eq!(
        design(&harness).view.cameras[1].distance,
        macro_view.distance
    );

    click(&mut harness, "Show view 2");
    assert_eq!(camera(&harness).distance, macro_view.distance);
    click(&mut harness, "Remove view 1");
    assert_eq!(views(&harness), ["loops"]);
    undo(&mut harness, "remove view “default”");
    undo(&mut harness, "rename view “loops”");
    undo(&mut harness, "save view “view 2”");
    assert_eq!(*design(&harness), Design::default());
}

fn height_mm(harness: &Harness<'_, App>) -> f64 {
    camera(harness)
        .orthographic_height
        .expect("a parallel view")
}

/// Whether the status bar, a panel or a notice says so.
pub(super) fn is_said(harness: &Harness<'_, App>, text: &str) -> bool {
    harness.query_all_by_label_contains(text).next().is_some()
}

#[test]
fn true_scale_is_a_millimetre_for_a_millimetre_and_stays_so() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut harness = designer_with_folders(folder.path());
    focus_viewport(&mut harness);
    harness.key_press(Key::T);
    harness.run_steps(3);
    let pixels = |h: &Harness<'_, App>| f64::from(picture_rect(h).height());
    // 96 pixels an inch at a scale of 1, which is the tests'.
    assert!((height_mm(&harness) - pixels(&harness) / 96.0 * 25.4).abs() < 1e-6);
    assert!(is_said(&harness, "·   1:1"));
    assert!(is_said(&harness, "hold a ruler to the screen"));

    harness.set_size(vec2(1280.0, 600.0));
    harness.run_steps(3);
    assert!((height_mm(&harness) - pixels(&harness) / 96.0 * 25.4).abs() < 1e-6);

    // Measured: half a pixel less for every pixel, by typing and by the arrow keys.
    click(&mut harness, "Display");
    click(&mut harness, "Size of the screen…");
    type_number(&mut harness, "Dots per inch", "120");
    assert!((height_mm(&harness) - pixels(&harness) / 120.0 * 25.4).abs() < 1e-6);
    harness
        .get_by_role_and_label(Role::Slider, "Right end of the bar")
        .focus();
    harness.run_steps(2);
    harness.key_press(Key::ArrowRight);
    harness.run_steps(3);
    // The bar of 100 mm is a pixel longer: f32 arithmetic of some hundred points.
    let dpi = (100.0 / 25.4 * 120.0 + 1.0) / 100.0 * 25.4;
    let measured = pixels(&harness) / height_mm(&harness) * 25.4;
    assert!((measured - dpi).abs() < 0.01, "{measured} is not {dpi}");
    click(&mut harness, "Done");
    let again = designer_with_folders(folder.path());
    assert!(again.state().viewport().screen_is_measured());

    focus_viewport(&mut harness);
    harness.key_press(Key::Plus);
    harness.run_steps(3);
    assert!(is_said(&harness, "·   1.2:1"), "zooming leaves true scale");
    harness.set_size(vec2(1280.0, 700.0));
    harness.run_steps(3);
    assert!(
        !is_said(&harness, "·   1.2:1"),
        "a zoomed view keeps its cloth"
    );
    let flat = height_mm(&harness);
    harness.key_press(Key::O);
    harness.run_steps(3);
    let lens = camera(&harness);
    assert_eq!(lens.orthographic_height, None);
    let shown = 2.0 * lens.distance * (lens.fov.to_radians() / 2.0).tan();
    assert!(
        (shown - flat).abs() < 1e-6,
        "what is looked at keeps its size"
    );
    assert!(!harness.state().document().is_unsaved());
}

fn designer_with_folders(folder: &Path) -> Harness<'static, App> {
    let setup = Setup {
        folders: Some(folders_in(folder)),
        ..on_processor(striped())
    };
    let mut harness = window(vec2(1280.0, 720.0), setup);
    wait(&mut harness, "the picture", |h| {
        h.state().viewport().state().picture.progress.done
    });
    harness.run_steps(3);
    harness
}

/// As [`setup`], drawn by the processor's backend.
pub(super) fn on_processor(make: MakeBackend) -> Setup {
    Setup {
        choice: BackendChoice::Cpu,
        ..setup(make)
    }
}

#[test]
fn the_scale_bar_tells_round_millimetres_of_the_right_length() {
    let mut harness = designer(None);
    focus_viewport(&mut harness);
    harness.key_press(Key::T);
    harness.run_steps(2);
    harness.key_press(Key::B);
    harness.run_steps(3);
    let value = |h: &Harness<'_, App>| h.get_by_label("Viewport").value().unwrap_or_default();
    // At 96 pixels an inch 20 mm are 76 points, 50 mm would be 189: more than 160.
    assert!(
        value(&harness).ends_with("scale bar 20 mm"),
        "{}",
        value(&harness)
    );
    for _ in 0..6 {
        harness.key_press(Key::Plus);
        harness.run_steps(2);
    }
    // 1.2⁶ = 3 times as large.
    assert!(
        value(&harness).ends_with("scale bar 10 mm"),
        "{}",
        value(&harness)
    );
    harness.key_press(Key::B);
    harness.run_steps(3);
    assert!(!value(&harness).contains("scale bar"));
}

#[test]
fn the_cloth_alone_fills_the_window_until_escape() {
    let mut harness = designer(None);
    let before = picture_rect(&harness);
    harness.key_press(Key::F11);
    harness.run_steps(4);
    assert!(harness.query_by_label("Toolbar: Save").is_none());
    let alone = picture_rect(&harness);
    assert_eq!(alone.size(), vec2(1280.0, 720.0));
    let requested = harness.state().viewport().requested().expect("a request");
    assert_eq!(requested.size, [1280, 720]);
    harness.key_press(Key::Escape);
    harness.run_steps(4);
    assert!(harness.query_by_label("Toolbar: Save").is_some());
    assert_eq!(picture_rect(&harness), before);
    harness.key_press(Key::F11);
    harness.run_steps(4);
    harness.key_press(Key::F11);
    harness.run_steps(4);
    assert_eq!(picture_rect(&harness), before);
}

#[test]
fn what_lies_under_the_pointer_is_read_out() {
    let mut harness = designer(None);
    wait(&mut harness, "the picture", |h| {
        h.state().viewport().state().picture.progress.done
    });
    click(&mut harness, "Toolbar: Front");
    let rect = picture_rect(&harness);
    // From straight above the middle of the picture is the middle of the cloth; a little right and up, the cell beyond.
    let pitch = design(&harness).sheet.pitch_x();
    let point = harness.state().viewport().camera.distance * (15_f64.to_radians()).tan() * 2.0
        / f64::from(rect.height());
    let cell = (pitch / point) as f32;
    harness.hover_at(rect.center() + vec2(0.5 * cell, -0.5 * cell));
    harness.run_steps(4);
    let readout = *harness.state().viewport().readout().expect("a readout");
    assert_eq!(readout.cell, [60, 70]);
    assert!(is_said(&harness, "warp 61, weft 71"));
    let stands = design(&harness).weave.pattern.stitch(60, 70).front;
    assert_eq!(readout.loop_mm.is_some(), stands);
    assert_eq!(is_said(&harness, "#ffffff"), stands, "its yarn's colour");
    harness.hover_at(rect.center() + vec2(1.5 * cell, -0.5 * cell));
    harness.run_steps(4);
    let next = *harness.state().viewport().readout().expect("a readout");
    assert_eq!(next.cell, [61, 70]);
    // The default pattern has a loop on every second cell, of about the usual length.
    let loop_mm = readout.loop_mm.or(next.loop_mm).expect("a loop");
    let usual = design(&harness).length.value;
    assert!((loop_mm / usual - 1.0).abs() < 0.35, "{loop_mm} of {usual}");
    harness.hover_at(Pos2::new(20.0, 400.0));
    harness.run_steps(4);
    assert_eq!(harness.state().viewport().readout(), None);
}

#[test]
fn cloth_without_end_is_made_where_one_looks() {
    let preset = crate::support::scenes::preset_path("endless-carpet");
    let mut harness = designer(Some(preset));
    let region = |h: &Harness<'_, App>| {
        let cloth = h.state().viewport().state().scene.cloth.as_ref();
        cloth.and_then(|cloth| cloth.scenes.nearest.sheet.region)
    };
    wait(&mut harness, "the picture", |h| {
        h.state().viewport().state().picture.progress.done
    });
    let here = region(&harness).expect("a region");
    assert!(here.lod == 0 && here.len() < 200_000, "{here:?}");
    let middle = picture_rect(&harness).center();
    harness.hover_at(middle);
    harness.run_steps(4);
    let readout = *harness.state().viewport().readout().expect("a readout");
    // The camera looks at the middle of the cloth's plane, and its ray goes through that of the pile a little before
    // it.
    assert!((4980..5020).contains(&readout.cell[0]) && (4980..5020).contains(&readout.cell[1]));
    assert!(readout.loop_mm.is_some());

    // A little beside it is the same scene; farther away another.
    let by = |harness: &mut Harness<'_, App>, by: Vec2| {
        scroll(harness, by, true, Modifiers::NONE);
        harness.run_steps(4);
    };
    by(&mut harness, vec2(4.0, 0.0));
    assert_eq!(region(&harness), Some(here));
    for _ in 0..4 {
        by(&mut harness, vec2(-400.0, 0.0));
    }
    wait(&mut harness, "cloth farther right", |h| {
        region(h).is_some_and(|there| there.first[0] > here.first[0])
    });
    harness.hover_at(middle);
    harness.run_steps(4);
    let there = *harness.state().viewport().readout().expect("a readout");
    assert!(there.cell[0] > readout.cell[0] + 100 && there.cell[1] < readout.cell[1] + 20);

    // From afar it is coarser, and no larger than a picture needs.
    for _ in 0..6 {
        harness.event(Event::Zoom(0.5));
        harness.run_steps(3);
    }
    wait(&mut harness, "the carpet from afar", |h| {
        region(h).is_some_and(|region| region.lod > 0)
    });
    let far = region(&harness).expect("a region");
    assert!(far.len() <= 1 << 20);

    // Where the camera leaves what is there, a coarse picture of the rest is shown before all of it is made.
    wait(&mut harness, "the whole picture", |h| {
        h.state().viewport().state().picture.progress.done
    });
    for _ in 0..3 {
        by(&mut harness, vec2(-300.0, 0.0));
    }
    let was_previewed = std::cell::Cell::new(false);
    wait(&mut harness, "the cloth there", |h| {
        let state = h.state().viewport().state();
        if state.picture.is_reduced && region(h) == Some(far) {
            was_previewed.set(true);
        }
        region(h) != Some(far)
    });
    assert!(was_previewed.get());
}

#[test]
fn the_hint_goes_with_the_first_gesture_and_does_not_come_back() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut harness = designer_with_folders(folder.path());
    let hint = "Drag to turn the cloth";
    assert!(is_said(&harness, hint));
    let at = picture_rect(&harness).center();
    harness.drag_at(at);
    harness.run_steps(1);
    harness.hover_at(at + vec2(30.0, 10.0));
    harness.run_steps(1);
    harness.drop_at(at + vec2(30.0, 10.0));
    harness.run_steps(3);
    assert!(!is_said(&harness, hint));
    drop(harness);
    let again = designer_with_folders(folder.path());
    assert!(!is_said(&again, hint));
}

#[test]
fn fast_light_is_offered_only_where_it_means_something() {
    let mut harness = designer_of_size(None, vec2(1280.0, 2400.0));
    let label = "Light in the viewport";
    assert!(harness.query_by_label(label).is_some());
    open_panel(&mut harness, "View & quality");
    type_number(&mut harness, "Bounces", "1");
    assert!(harness.query_by_label(label).is_some(), "soft shadows");
    click(&mut harness, "Shadows");
    assert!(
        harness.query_by_label(label).is_none(),
        "one bounce, no shadows"
    );
    type_number(&mut harness, "Bounces", "8");
    assert!(harness.query_by_label(label).is_some(), "estimated bounces");
}

#[test]
fn a_lost_window_leaves_its_document_to_the_next() {
    let device = Arc::new(std::sync::OnceLock::new());
    let of_window = Arc::clone(&device);
    let mut harness = Harness::builder()
        .with_size(vec2(1000.0, 560.0))
        .wgpu()
        .build_eframe(move |cc| {
            let state = cc.wgpu_render_state.as_ref().expect("a device");
            let _ = of_window.set(state.device.clone());
            App::new(cc, on_processor(striped()))
        });
    harness.run_steps(3);
    type_number(&mut harness, "Warps", "60");
    assert!(!harness.state().handoff().is_filled());
    let device: &wgpu::Device = device.get().expect("a device");
    device.destroy();
    device.poll(wgpu::PollType::Poll).expect("polled");
    harness.step();
    assert!(harness.state().handoff().is_filled());
    let closes = harness
        .output()
        .viewport_output
        .values()
        .any(|viewport| viewport.commands.contains(&egui::ViewportCommand::Close));
    assert!(closes, "the window is to be closed");
    // Nothing is drawn: what draws has no device.
    assert!(harness.query_by_label("Viewport").is_none());
}
