//! Everything that is written in the window can be read, wherever the window stands: no text is cut off, shortened or
//! written over another, from 1280 × 720 pixels to 4K, at 100 % and 200 %; and the Tab key alone comes to all controls.
//!
//! What is looked at are the shapes that egui is about to draw, so there is nothing to tolerate but rounding to pixels.

use std::collections::{BTreeMap, BTreeSet};

use egui::epaint::{ClippedShape, Shape};
use egui::{Key, Rect, Theme, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::NodeT;
use renderer_core::design::{Fit, LengthMap};
use towel_designer::designer::{App, SMALLEST_WINDOW};

use super::states::{self, Look, STATES};
use super::*;

/// A text about to be drawn.
struct Text {
    text: String,
    rect: Rect,
    /// Nothing is drawn outside.
    clip: Rect,
    is_shortened: bool,
    /// Which shape it is: later ones are drawn over earlier ones.
    order: usize,
}

/// Texts, and opaque rectangles that hide what was drawn before.
#[derive(Default)]
struct Drawn {
    texts: Vec<Text>,
    covers: Vec<(usize, Rect)>,
    count: usize,
}

impl Drawn {
    /// What of these shapes is seen.
    fn of(shapes: &[ClippedShape]) -> Self {
        let mut drawn = Self::default();
        for ClippedShape {
            clip_rect, shape, ..
        } in shapes
        {
            drawn.add(shape, *clip_rect);
        }
        let covers = std::mem::take(&mut drawn.covers);
        drawn.texts.retain(|text| {
            let is_seen = text.rect.intersect(text.clip).is_positive();
            let is_covered = covers
                .iter()
                .any(|(order, rect)| *order > text.order && rect.intersects(text.rect));
            is_seen && !is_covered && !text.text.trim().is_empty()
        });
        drawn
    }

    fn add(&mut self, shape: &Shape, clip: Rect) {
        self.count += 1;
        match shape {
            Shape::Vec(shapes) => shapes.iter().for_each(|shape| self.add(shape, clip)),
            Shape::Rect(rect) if rect.fill.is_opaque() => {
                self.covers.push((self.count, rect.rect.intersect(clip)));
            }
            Shape::Text(text) => self.texts.push(Text {
                text: text.galley.job.text.clone(),
                rect: text.visual_bounding_rect(),
                clip,
                is_shortened: text.galley.elided,
                order: self.count,
            }),
            _ => {}
        }
    }

    /// What cannot be read, and why.
    fn faults(&self, window: Rect) -> Vec<String> {
        let mut faults = Vec::new();
        for (index, text) in self.texts.iter().enumerate() {
            let Text {
                text: name,
                rect,
                clip,
                ..
            } = text;
            if text.is_shortened {
                faults.push(format!("“{name}” is shortened"));
            }
            // Up and down, scroll areas cut off what is scrolled out; sideways nothing scrolls. Outlines of letters are
            // smoothed over a pixel.
            let clip = clip.intersect(window).expand(1.0);
            if rect.left() < clip.left() || rect.right() > clip.right() {
                faults.push(format!("“{name}” at {rect:?} is cut off by {clip:?}"));
            }
            for other in &self.texts[index + 1..] {
                let shared = rect
                    .intersect(text.clip)
                    .intersect(other.rect.intersect(other.clip));
                // A pixel of smoothing each.
                if shared.width() > 2.0 && shared.height() > 2.0 {
                    faults.push(format!(
                        "“{name}” and “{}” overlap in {shared:?}",
                        other.text
                    ));
                }
            }
        }
        faults
    }
}

fn faults(harness: &Harness<'_, App>, size: Vec2) -> Vec<String> {
    Drawn::of(&harness.output().shapes).faults(Rect::from_min_size(Pos2::ZERO, size))
}

/// Sizes in points: 1280 × 720 at 100 %, 1920 × 1080 at 200 %, 150 % and 100 %, which is 4K at 200 %, and 4K at 100 %;
/// and the smallest that a window can have.
const SIZES: [[f32; 2]; 6] = [
    SMALLEST_WINDOW,
    [1280.0, 720.0],
    [960.0, 540.0],
    [1280.0, 680.0],
    [1920.0, 1080.0],
    [3840.0, 2160.0],
];

/// States that are looked at in large windows too.
const IN_LARGE: [&str; 4] = ["started", "help", "export", "chart editor"];

#[test]
fn nothing_is_cut_off_or_overlaps_in_any_window() {
    let mut all = Vec::new();
    for [width, height] in SIZES {
        // In large windows there is room for everything; some states show that it is used well.
        let all_states = height < 600.0 || height == 720.0;
        let states = STATES
            .iter()
            .filter(|s| all_states || IN_LARGE.contains(&s.name));
        for state in states {
            let size = vec2(width, height);
            let scale = if width < 1000.0 { 2.0 } else { 1.0 };
            let look = Look {
                theme: Theme::Dark,
                scale,
                size,
            };
            let (mut harness, _home) = states::start(look);
            (state.reach)(&mut harness);
            let place = format!("{width} × {height}, {}", state.name);
            all.extend(
                faults(&harness, size)
                    .into_iter()
                    .map(|fault| format!("{place}: {fault}")),
            );
        }
    }
    assert!(all.is_empty(), "{}", all.join("\n"));
}

/// 1280 × 720 pixels at 200 %, points.
const SMALLEST: Vec2 = vec2(640.0, 360.0);

#[test]
fn menus_are_no_higher_than_the_smallest_window() {
    let look = Look {
        theme: Theme::Light,
        scale: 2.0,
        size: SMALLEST,
    };
    for menu in ["File", "Edit", "View", "Display", "Help"] {
        let (mut harness, _home) = states::start(look);
        let places = |harness: &Harness<'_, App>| -> BTreeSet<String> {
            let controls = harness.root().children_recursive();
            let controls = controls.filter(states::takes_focus);
            controls.map(|node| place_of(&node)).collect()
        };
        let before = places(&harness);
        click(&mut harness, menu);
        let window = Rect::from_min_size(Pos2::ZERO, SMALLEST);
        let mut lines = 0;
        for node in harness.root().children_recursive() {
            if states::takes_focus(&node) && !before.contains(&place_of(&node)) {
                lines += 1;
                let place = place_of(&node);
                assert!(window.contains_rect(node.rect()), "{menu}: {place}");
            }
        }
        assert!(lines > 0, "{menu} did not open");
    }
}

#[test]
fn nothing_is_cut_off_or_overlaps_in_any_panel() {
    let mut all = Vec::new();
    for scale in [1.0, 2.0] {
        let size = states::tall(900.0);
        let (mut harness, _home) = states::start(Look {
            theme: Theme::Light,
            scale,
            size,
        });
        states::open_everything(&mut harness);
        let mut look = |harness: &Harness<'_, App>, place: &str| {
            let faults = faults(harness, size).into_iter();
            all.extend(faults.map(|fault| format!("{scale}, {place}: {fault}")));
        };
        look(&harness, "as opened");
        click(&mut harness, "Rows by colour");
        harness.run_steps(20);
        click(&mut harness, "More of row 1");
        click(&mut harness, "Reduce to yarns…");
        choose(&mut harness, "Fit", Fit::Place.label());
        harness.run_steps(20);
        look(&harness, "more rows");
        states::choose_length_map(&mut harness, LengthMap::Gray);
        choose(&mut harness, "Fit", Fit::Tile.label());
        harness.run_steps(20);
        look(&harness, "length curve");
        states::choose_length_map(&mut harness, LengthMap::Constant);
        click(&mut harness, "Clear chart");
        harness.run_steps(20);
        look(&harness, "without a chart");
    }
    assert!(all.is_empty(), "{}", all.join("\n"));
}

#[test]
fn what_is_cut_off_or_overlaps_is_seen() {
    let size = vec2(300.0, 100.0);
    let mut harness = Harness::builder().with_size(size).build_ui(|ui| {
        let at = ui.max_rect().left_top();
        let painter = ui.painter().clone();
        let write = |at, text: &str| {
            let font = egui::FontId::proportional(14.0);
            let colour = egui::Color32::WHITE;
            painter.text(at, egui::Align2::LEFT_TOP, text, font, colour);
        };
        write(at, "first");
        write(at + vec2(4.0, 3.0), "second");
        write(at + vec2(270.0, 60.0), "beyond the edge");
        let long = egui::Label::new("a text that does not fit into forty points").truncate();
        ui.place(
            Rect::from_min_size(at + vec2(0.0, 60.0), vec2(40.0, 20.0)),
            long,
        );
        // Covered: not seen, so no fault.
        write(at + vec2(120.0, 0.0), "under");
        write(at + vec2(122.0, 3.0), "neath");
        let cover = Rect::from_min_size(at + vec2(110.0, -2.0), vec2(100.0, 30.0));
        painter.rect_filled(cover, 0.0, egui::Color32::BLACK);
    });
    harness.run_steps(2);
    let window = Rect::from_min_size(Pos2::ZERO, size);
    let faults = Drawn::of(&harness.output().shapes).faults(window);
    let count_of = |part: &str| faults.iter().filter(|fault| fault.contains(part)).count();
    assert_eq!(count_of("“first” and “second” overlap"), 1, "{faults:?}");
    assert_eq!(count_of("“beyond the edge” at"), 1, "{faults:?}");
    assert_eq!(count_of("is shortened"), 1, "{faults:?}");
    assert_eq!(faults.len(), 3, "{faults:?}");
}

/// What a control is called and where it is.
fn place_of(node: &egui_kittest::Node<'_>) -> String {
    let (name, role) = (node.accesskit_node().label(), node.accesskit_node().role());
    format!(
        "{role:?} “{}” at {:?}",
        name.unwrap_or_default(),
        node.rect()
    )
}

/// What each control that takes the keyboard is called, and whether it has it. Where nothing scrolls, so that all of them
/// are there, those of one name are counted; places are none, since what is reported beside a control may move it.
fn controls(harness: &Harness<'static, App>, scrolls: bool) -> Vec<(String, bool)> {
    let mut counts = BTreeMap::new();
    let root = harness.root();
    let takers = root.children_recursive().filter(states::takes_focus);
    takers
        .map(|node| {
            let node = node.accesskit_node();
            let (role, name) = (node.role(), node.label().unwrap_or_default());
            let name = format!("{role:?} “{name}”");
            let count: &mut u32 = counts.entry(name.clone()).or_default();
            *count += 1;
            let called = match scrolls {
                true => name,
                false => format!("{name}, number {count}"),
            };
            (called, node.is_focused())
        })
        .collect()
}

/// So many presses without anything new, and the focus has come round or is caught somewhere.
const ROUND: u32 = 30;

/// Presses Tab until the focus comes round again, and tells which controls it never came to.
fn never_reached(harness: &mut Harness<'static, App>, scrolls: bool) -> Vec<String> {
    let all: BTreeSet<String> = controls(harness, scrolls)
        .into_iter()
        .map(|(called, _)| called)
        .collect();
    assert!(all.len() > 20, "few controls: {all:?}");
    let mut reached = BTreeSet::new();
    let mut without_news = 0;
    while without_news < ROUND {
        harness.key_press(Key::Tab);
        harness.run_steps(2);
        let focused = controls(harness, scrolls)
            .into_iter()
            .find_map(|(called, has_focus)| has_focus.then_some(called));
        let is_new = focused.is_some_and(|place| reached.insert(place));
        without_news = if is_new { 0 } else { without_news + 1 };
    }
    all.difference(&reached).cloned().collect()
}

#[test]
fn tab_alone_comes_to_every_control() {
    let size = states::tall(900.0);
    let look = Look {
        theme: Theme::Dark,
        scale: 1.0,
        size,
    };
    let (mut harness, _home) = states::start(look);
    states::open_everything(&mut harness);
    let missing = never_reached(&mut harness, false);
    assert!(missing.is_empty(), "never reached:\n{}", missing.join("\n"));

    let look = Look {
        size: vec2(1280.0, 720.0),
        ..look
    };
    for name in ["chart editor", "export", "weave editor"] {
        let (mut harness, _home) = states::start(look);
        states::reach(&mut harness, name);
        let missing = never_reached(&mut harness, true);
        assert!(
            missing.is_empty(),
            "{name}, never reached:\n{}",
            missing.join("\n")
        );
    }

    // Where a question stands before everything else, to it alone.
    for (name, controls) in [
        (
            "question",
            &["Save changes", "Discard changes", "Cancel"] as &[&str],
        ),
        ("file browser", &["Up", "Path", "Cancel"]),
    ] {
        let (mut harness, _home) = states::start(look);
        states::reach(&mut harness, name);
        let missing = never_reached(&mut harness, true);
        let is_missing =
            |control: &&&str| missing.iter().any(|m| m.contains(&format!("“{control}”")));
        let caught: Vec<_> = controls.iter().filter(is_missing).collect();
        assert!(caught.is_empty(), "{name}, never reached: {caught:?}");
        let beside = missing.iter().any(|m| m.contains("“Toolbar: New”"));
        assert!(beside, "{name}: what is behind it takes the keyboard");
    }
}
