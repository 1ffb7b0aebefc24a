//! The panels Loop length, Pile and Turbulence: what they draw against what it should show, and their gestures.

use std::sync::Mutex;

use egui::ColorImage;
use renderer_core::design::{ChartImage, Fit, Length, Pile};
use renderer_core::scene::{LengthRule, compile, luma};
use towel_designer::designer::MakeBackend;
use towel_designer::designer::length_pictures::{BARS, Lengths, histogram};

use super::*;

/// An image without any symmetry, some of it transparent.
fn odd_image(width: usize, height: usize) -> ChartImage {
    let pixels: Vec<[u8; 4]> = (0..width * height)
        .map(|k| {
            let [r, g, b] = [37, 91, 53].map(|step| (k * step % 256) as u8);
            [r, g, b, if k % 11 == 0 { 0 } else { 255 }]
        })
        .collect();
    ChartImage::new(width, height, &pixels).expect("an image")
}

fn lengths_of(design: &Design) -> Lengths {
    Lengths {
        chart: design.chart.clone(),
        length: design.length.clone(),
        sheet: design.sheet.clone(),
        weave: design.weave.clone(),
        max_length_mm: design.pile.max_length,
    }
}

#[test]
fn the_histogram_counts_every_opaque_pixel_at_its_brightness() {
    // Over more than one of the chart's tiles.
    let image = odd_image(150, 131);
    let counted = histogram(&image);
    for (bar, count) in counted.iter().enumerate() {
        let (from, to) = (bar as f64 / BARS as f64, (bar + 1) as f64 / BARS as f64);
        let is_last = bar == BARS - 1;
        let expected = (0..150 * 131)
            .map(|k| image.pixel(k % 150, k / 150))
            .filter(|pixel| pixel[3] == 255)
            .map(|[r, g, b, _]| luma([r, g, b]))
            .filter(|brightness| *brightness >= from && (*brightness < to || is_last))
            .count();
        assert_eq!(*count, expected as u64, "bar {bar}");
    }
}

/// A design with a chart and lengths by its brightness.
fn charted(warps: u32, wefts: u32) -> Design {
    let mut design = Design::default();
    (design.sheet.warps, design.sheet.wefts) = (warps, wefts);
    design.chart.pixels = Some(odd_image(23, 17));
    design.chart.fit = Fit::Tile;
    design.length.map = LengthMap::Gray;
    design.length.curve = vec![[0.0, 0.9], [0.4, 0.1], [1.0, 1.0]];
    design.pile.max_length = 3.1;
    design
}

#[test]
fn the_height_map_shows_each_cells_length() {
    let design = charted(31, 40);
    let map = lengths_of(&design).height_map();
    assert_eq!(map.image.size, [31, 40]);
    let image = design.chart.pixels.as_ref().expect("a chart");
    let rule = LengthRule::new(&design.length);
    let length = |warp: usize, weft: usize| {
        // One pixel a loop, counted from the far left corner.
        let [r, g, b, alpha] = image.pixel(warp % 23, (39 - weft) % 17);
        let mm = rule.length_mm([r, g, b]).min(3.1);
        if alpha == 0 { 0.0 } else { mm }
    };
    let all = (0..31 * 40).map(|k| length(k % 31, k / 31));
    let longest = all.fold(0.0, f64::max);
    assert_eq!(map.scale_mm, [0.0, longest]);
    for weft in 0..40 {
        for warp in 0..31 {
            let shown = map.image.pixels[(39 - weft) * 31 + warp].r();
            let expected = 255.0 * length(warp, weft) / longest;
            // The gray is rounded to a whole number.
            assert!(
                (f64::from(shown) - expected).abs() <= 0.5 + 1e-9,
                "warp {warp}, weft {weft}: {shown}, not {expected}"
            );
        }
    }
}

#[test]
fn the_height_map_of_a_large_sheet_is_reduced_and_keeps_its_picture() {
    // Left half low, right half high; near quarter bare.
    let pixels: Vec<[u8; 4]> = (0..4 * 4)
        .map(|k| match (k % 4, k / 4) {
            (_, 3) => [0, 0, 0, 0],
            (0 | 1, _) => [0, 0, 0, 255],
            _ => [255; 4],
        })
        .collect();
    let mut design = charted(4000, 4000);
    design.chart.fit = Fit::Stretch;
    design.chart.pixels = ChartImage::new(4, 4, &pixels);
    design.length.curve = Length::default().curve;
    let map = lengths_of(&design).height_map();
    let [cols, rows] = map.image.size;
    assert!(cols <= 256 && rows <= 256, "{cols} × {rows}");
    // Means of 16 equal numbers, each rounded once.
    assert!(map.scale_mm[0] == 0.0 && (map.scale_mm[1] - 3.1).abs() < 1e-12);
    let at = |image: &ColorImage, x: f64, y: f64| {
        let [x, y] = [x * cols as f64, y * rows as f64].map(|p| p as usize);
        image.pixels[y * cols + x].r()
    };
    assert_eq!(at(&map.image, 0.75, 0.4), 255);
    let low = f64::from(at(&map.image, 0.25, 0.4));
    assert!((low - 255.0 * 1.5 / 3.1).abs() <= 0.5, "{low}");
    assert_eq!(
        at(&map.image, 0.6, 0.9),
        0,
        "the near edge is at the bottom"
    );
}

/// A window with `design`, opened from a file, with the panel of that title open.
fn opened(design: &Design, title: &str, folder: &Path) -> Harness<'static, App> {
    let path = folder.join("design.toml");
    files::save_design(design, &path, None).expect("saved");
    let mut harness = designer_of_size(Some(path), vec2(1280.0, 2400.0));
    wait(&mut harness, "the preset", |h| {
        h.state().document().path().is_some()
    });
    open_panel(&mut harness, title);
    harness
}

fn undo(harness: &mut Harness<'_, App>) {
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    harness.run_steps(3);
}

fn undo_name(harness: &Harness<'_, App>) -> String {
    let name = harness.state().document().undo_name();
    name.unwrap_or("nothing").to_owned()
}

#[test]
fn the_height_map_follows_the_sliders_and_tells_the_cell_under_the_pointer() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut design = charted(31, 40);
    design.chart.pixels = None;
    let mut harness = opened(&design, "Loop length", folder.path());
    let white = "Height map: loops from 0.00 to 3.10 mm";
    wait(&mut harness, "the height map", |h| {
        h.query_by_label(white).is_some()
    });
    type_number(&mut harness, "Longest", "2.5");
    let lower = "Height map: loops from 0.00 to 2.50 mm";
    wait(&mut harness, "the new height map", |h| {
        h.query_by_label(lower).is_some()
    });
    let map = harness.get_by_label(lower).rect();
    // The middle of warp 4 from the left and weft 2 from the near edge.
    let share = vec2(3.5 / 31.0, 1.0 - 1.5 / 40.0);
    harness.hover_at(map.min + share * map.size());
    harness.run_steps(40);
    let message = "Warp 4 of 31, weft 2 of 40: 2.50 mm";
    assert!(
        harness.query_by_label_contains(message).is_some(),
        "the tooltip does not say {message:?}"
    );
}

#[test]
fn points_of_the_curve_are_moved_added_and_removed_by_pointer_and_keys() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut design = charted(31, 40);
    design.chart.pixels = None;
    design.length.curve = vec![[0.0, 0.0], [0.5, 0.5], [1.0, 1.0]];
    let mut harness = opened(&design, "Loop length", folder.path());
    let curve = harness.get_by_label("Length curve").rect();
    harness.drag_at(curve.center());
    harness.run_steps(2);
    harness.hover_at(curve.center() + vec2(20.0, 0.0));
    harness.run_steps(2);
    harness.drop_at(curve.center() + vec2(20.0, 10.0));
    harness.run_steps(3);
    let moved = super::design(&harness).length.curve.clone();
    assert!(moved.len() == 3 && moved[1][0] > 0.52, "{moved:?}");
    assert_eq!(undo_name(&harness), "loop length curve");

    harness.key_press(Key::ArrowUp);
    harness.run_steps(2);
    let nudged = super::design(&harness).length.curve[1];
    assert!((nudged[1] - moved[1][1] - 0.01).abs() < 1e-9, "{nudged:?}");
    harness.key_press(Key::PageUp);
    harness.run_steps(1);
    harness.key_press(Key::ArrowDown);
    harness.run_steps(2);
    assert!((super::design(&harness).length.curve[2][1] - 0.99).abs() < 1e-9);
    harness.key_press(Key::PageDown);
    harness.run_steps(1);
    harness.key_press(Key::Delete);
    harness.run_steps(3);
    assert_eq!(super::design(&harness).length.curve.len(), 2);
    for _ in 0..4 {
        undo(&mut harness);
    }
    assert_eq!(super::design(&harness).length, design.length);
}

#[test]
fn the_table_takes_the_charts_colours_and_keeps_rows_it_has() {
    let folder = tempfile::tempdir().expect("a folder");
    let chart = folder.path().join("chart.png");
    write_chart(&chart);
    let mut design = Design::default();
    design.length.map = LengthMap::Lut;
    let red = LengthEntry {
        colour: renderer_core::design::Colour([200, 30, 30]),
        length: 4.5,
        ..LengthEntry::default()
    };
    design.length.table = vec![LengthEntry::default(), red.clone()];
    let mut harness = opened(&design, "Loop length", folder.path());
    let dropped = Arc::new(Dropped(chart));
    harness.input_mut().dropped_files.push(dropped);
    wait(&mut harness, "the chart", |h| {
        super::design(h).chart.pixels.is_some()
    });
    harness.run_steps(3);
    click(&mut harness, "Rows by colour");
    harness.run_steps(20);
    click(&mut harness, "Colours from chart");
    let table = super::design(&harness).length.table.clone();
    assert_eq!(table.len(), 2, "{table:?}");
    assert!(table.contains(&red), "{table:?}");
    assert!(table.iter().any(|row| row.colour.0 == [250, 250, 240]));
    assert_eq!(undo_name(&harness), "lengths by the chart's colours");

    type_number(&mut harness, "Length of row 1", "1.25");
    assert_eq!(requested(&harness).length.table[0].length, 1.25);
    choose(&mut harness, "Kind of row 2", "cut tuft");
    assert!(requested(&harness).length.table[1].kind.is_some());
    click(&mut harness, "More of row 2");
    let as_pile = "as the pile: 10 /mm";
    assert!(harness.query_by_label(as_pile).is_some());
    for _ in 0..3 {
        undo(&mut harness);
    }
    assert_eq!(super::design(&harness).length, design.length);
}

/// Designs and sizes of the thumbnails that were begun, by a window whose viewport draws nothing.
type Begun = Arc<Mutex<Vec<[u32; 2]>>>;

struct Counting(FlatBackend, Begun);

impl Backend for Counting {
    fn kind(&self) -> BackendKind {
        self.0.kind()
    }

    fn device_name(&self) -> String {
        self.0.device_name()
    }

    fn begin(&mut self, request: &RenderRequest) -> Result<(), RenderError> {
        self.1.lock().expect("whole").push(request.size);
        self.0.begin(request)
    }

    fn advance(&mut self, slice: Duration, cancel: &AtomicBool) -> Result<Progress, RenderError> {
        self.0.advance(slice, cancel)
    }

    fn picture(&mut self) -> Result<Picture, RenderError> {
        self.0.picture()
    }

    fn counters(&mut self) -> Result<Counters, RenderError> {
        self.0.counters()
    }

    fn device_bytes(&self) -> u64 {
        0
    }
}

/// A window whose thumbnails are counted. The viewport's backend is asked for as `Reference`, theirs as `Cpu`.
fn counting() -> (Harness<'static, App>, Begun) {
    let begun = Begun::default();
    let counter = Arc::clone(&begun);
    let make: MakeBackend = Arc::new(move |choice| {
        let flat = FlatBackend::default();
        Ok(match choice {
            BackendChoice::Cpu => Box::new(Counting(flat, Arc::clone(&counter))),
            _ => Box::new(flat),
        })
    });
    (tall_with_reference(make), begun)
}

/// A window in which a loop's picture and panels below it are seen, and the viewport's backend is `Reference`.
fn tall_with_reference(make: MakeBackend) -> Harness<'static, App> {
    let setup = Setup {
        choice: BackendChoice::Reference,
        ..setup(make)
    };
    window(vec2(1280.0, 2000.0), setup)
}

/// Shows frames until more thumbnails than `after` have been begun (where some are to come) and none for a while.
/// Tells how many there were.
#[track_caller]
fn settled(harness: &mut Harness<'_, App>, begun: &Begun, after: Option<usize>) -> usize {
    let count = || begun.lock().expect("whole").len();
    if let Some(after) = after {
        wait(harness, "a thumbnail", |_| count() > after);
    }
    rest(harness);
    count()
}

#[test]
fn the_loop_is_drawn_anew_when_the_yarn_changes_and_stands_still_otherwise() {
    let (mut harness, begun) = counting();
    assert_eq!(
        settled(&mut harness, &begun, None),
        0,
        "drawn though nobody sees it"
    );
    open_panel(&mut harness, "Pile");
    let first = settled(&mut harness, &begun, Some(0));
    // Coarse, then whole.
    assert_eq!(first, 2, "{begun:?}");
    let sizes = begun.lock().expect("whole").clone();
    assert_eq!(sizes[0].map(|side| 4 * side), sizes[1]);

    type_number(&mut harness, "Twist per cm", "9");
    let twisted = settled(&mut harness, &begun, Some(first));
    // How loops lie does not show on one.
    type_number(&mut harness, "Lean sideways", "30");
    assert_eq!(settled(&mut harness, &begun, None), twisted);

    undo(&mut harness);
    undo(&mut harness);
    settled(&mut harness, &begun, Some(twisted));
    assert_eq!(*design(&harness), Design::default());
}

#[test]
fn the_loop_turns_under_the_pointer_when_dragged_and_by_keys_and_edits_nothing() {
    let (mut harness, begun) = counting();
    open_panel(&mut harness, "Pile");
    let first = settled(&mut harness, &begun, Some(0));
    let turned = |h: &Harness<'_, App>| {
        let node = h.get_by_role_and_label(Role::Image, "One loop");
        node.value().expect("a value")
    };
    let at_first = turned(&harness);
    harness
        .get_by_role_and_label(Role::Image, "One loop")
        .focus();
    harness.run_steps(2);
    harness.key_press(Key::ArrowRight);
    harness.run_steps(2);
    let by_key = turned(&harness);
    assert_ne!(by_key, at_first);
    settled(&mut harness, &begun, Some(first));
    harness.key_press(Key::ArrowLeft);
    harness.run_steps(2);
    assert_eq!(turned(&harness), at_first);
    let known = settled(&mut harness, &begun, None);

    let centre = harness
        .get_by_role_and_label(Role::Image, "One loop")
        .rect()
        .center();
    harness.drag_at(centre);
    harness.run_steps(1);
    harness.hover_at(centre - vec2(40.0, 0.0));
    harness.run_steps(1);
    assert_ne!(turned(&harness), at_first);
    harness.drop_at(centre - vec2(40.0, 0.0));
    harness.run_steps(1);

    // Under the pointer it goes on, as pictures come.
    harness.hover_at(centre);
    wait(&mut harness, "a turn", |_| {
        begun.lock().expect("whole").len() > known + 10
    });
    harness.hover_at(Pos2::new(900.0, 400.0));
    harness.run_steps(2);
    settled(&mut harness, &begun, None);
    let at_rest = turned(&harness);
    harness.run_steps(30);
    assert_eq!(turned(&harness), at_rest);
    assert_eq!(undo_name(&harness), "nothing");
}

#[test]
fn a_loop_that_cannot_be_drawn_is_reported_and_tried_once() {
    let tried = Arc::new(Mutex::new(0));
    let counter = Arc::clone(&tried);
    let mut harness = tall_with_reference(Arc::new(move |choice| match choice {
        BackendChoice::Cpu => {
            *counter.lock().expect("whole") += 1;
            Err(RenderError::Device("out of order".into()))
        }
        _ => Ok(Box::new(FlatBackend::default())),
    }));
    open_panel(&mut harness, "Pile");
    wait(&mut harness, "the reason", |h| {
        let node = h.get_by_role_and_label(Role::Image, "One loop");
        node.value()
            .is_some_and(|message| message.contains("out of order"))
    });
    // Another try would come as soon as the scene of one loop is made.
    rest(&mut harness);
    assert_eq!(*tried.lock().expect("whole"), 1);
}

#[test]
fn a_loops_picture_differs_with_plies_hair_and_kind() {
    // The volumes themselves: what the picture is made of.
    let voxels = |change: fn(&mut Pile)| {
        let mut design = Design::default();
        (design.sheet.warps, design.sheet.wefts) = (2, 2);
        design.pile.variants = 1;
        change(&mut design.pile);
        compile(&design).expect("a scene").volumes.voxels.clone()
    };
    let usual = voxels(|_| {});
    let changes: [fn(&mut Pile); 4] = [
        |pile| pile.plies = 4,
        |pile| pile.hairiness = 0.9,
        |pile| pile.thickness = 1.4,
        |pile| pile.kind = renderer_core::design::PileKind::Cut,
    ];
    for (index, change) in changes.into_iter().enumerate() {
        assert_ne!(voxels(change), usual, "change {index}");
    }
}

#[test]
fn turbulence_follows_is_rolled_and_reset_in_one_step_each() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut design = Design::default();
    (design.sheet.warps, design.sheet.wefts) = (600, 400);
    design.pile.tilt = 30.0;
    design.turbulence.octaves = 5;
    let mut harness = opened(&design, "Turbulence", folder.path());
    wait(&mut harness, "the thumbnails", |h| {
        h.query_by_label("Turbulence of stretch").is_some()
    });
    assert!(
        harness
            .query_by_label_contains("near left corner")
            .is_some(),
        "nothing tells that a large sheet is not shown whole"
    );
    click(&mut harness, "Roll seed");
    assert_ne!(requested(&harness).turbulence.seed, design.turbulence.seed);
    assert_eq!(undo_name(&harness), "turbulence seed");
    click(&mut harness, "Reset turbulence");
    let reset = super::design(&harness);
    let usual = Design::default();
    assert_eq!(reset.turbulence, usual.turbulence);
    assert_eq!(reset.pile, usual.pile);
    assert_eq!(undo_name(&harness), "reset turbulence");
    undo(&mut harness);
    undo(&mut harness);
    assert_eq!(super::design(&harness).turbulence, design.turbulence);
    assert_eq!(super::design(&harness).pile, design.pile);
}

#[test]
fn a_warning_stands_at_its_panel_by_path() {
    let mut harness = designer_of_size(None, vec2(1280.0, 2400.0));
    open_panel(&mut harness, "Turbulence");
    open_panel(&mut harness, "Pile");
    let message = "the highest turbulence octave has";
    assert_eq!(harness.query_all_by_label_contains(message).count(), 0);
    type_number(&mut harness, "Clumps per mm", "4");
    wait(&mut harness, "the warning", |h| {
        h.query_all_by_label_contains(message).count() > 0
    });
    let panel = harness.get_by_role_and_label(Role::DisclosureTriangle, "Turbulence");
    let next = harness.get_by_role_and_label(Role::DisclosureTriangle, "Skeleton");
    let warning = harness.get_by_label_contains(message).rect();
    assert!(
        warning.top() > panel.rect().bottom() && warning.bottom() < next.rect().top(),
        "it stands elsewhere: {warning:?}"
    );
}

#[test]
fn a_change_of_the_display_alone_does_not_say_that_loops_are_planted() {
    let mut harness = designer_of_size(None, vec2(1280.0, 2400.0));
    open_panel(&mut harness, "View & quality");
    let done = |h: &Harness<'_, App>| {
        let state = h.state().viewport().state();
        state.picture.progress.done && !state.picture.is_reduced && !state.is_busy()
    };
    wait(&mut harness, "the picture", done);
    let version = harness.state().viewport().state().picture.version;
    type_number(&mut harness, "Exposure", "1");
    wait(&mut harness, "the brighter picture", |h| {
        h.state().viewport().state().picture.version > version
    });
    wait(&mut harness, "rest", done);
}
