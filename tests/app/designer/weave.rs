//! The weave editor: icons, tools, changes of the whole pattern, keyboard and undo.
//!
//! Longer than most files because one grid is worked: its tools share their patterns and helpers.

use std::collections::HashSet;

use egui::accesskit::Role;
use egui::{Color32, Event, Key, Modifiers, PointerButton, Pos2, Rect, pos2, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use proptest::prelude::*;
use renderer_core::design::{Anchor, Back, Keep, NewCells, Pattern, STITCHES, WEAVE_LIBRARY};
use towel_designer::designer::shapes::{self, Cell};
use towel_designer::designer::{App, Icon};

use super::cell_sets::set;
use super::{
    cell, click, design, designer, first_button, in_frames, paint_cell, requested, type_number,
};

#[test]
fn every_icon_is_drawn_inside_its_field_and_unlike_the_others() {
    let field = Rect::from_min_size(pos2(10.0, 20.0), vec2(16.0, 16.0));
    let mut drawn = HashSet::new();
    for icon in Icon::ALL {
        let ctx = egui::Context::default();
        let mut output = ctx.run_ui(egui::RawInput::default(), |ui| {
            icon.paint(ui.painter(), field, Color32::RED);
        });
        let shapes = std::mem::take(&mut output.shapes);
        output.drop_without_applying_deltas();
        assert!(!shapes.is_empty(), "{icon:?} is empty");
        for shape in &shapes {
            let around = shape.shape.visual_bounding_rect();
            assert!(
                field.expand(0.01).contains_rect(around),
                "{icon:?} reaches {around:?}"
            );
        }
        let shapes: Vec<_> = shapes.into_iter().map(|shape| shape.shape).collect();
        assert!(
            drawn.insert(format!("{shapes:?}")),
            "{icon:?} is drawn as another"
        );
    }
}

/// A designer with a flat pattern of `cols` × `rows` zeros.
fn with_zeros(cols: usize, rows: usize) -> Harness<'static, App> {
    let mut harness = designer(None);
    for (col, row) in [(0, 0), (1, 1)] {
        click(&mut harness, "Paint 0: weft over warp");
        paint_cell(&mut harness, col, row);
    }
    type_number(&mut harness, "Pattern columns", &cols.to_string());
    type_number(&mut harness, "Pattern rows", &rows.to_string());
    assert_eq!(pattern(&harness), &Pattern::filled(cols, rows, 0));
    click(&mut harness, "Paint 7: loop on the front");
    harness
}

fn pattern<'h>(harness: &'h Harness<'_, App>) -> &'h Pattern {
    &design(harness).weave.pattern
}

/// The cells that are not 0.
fn painted(harness: &Harness<'_, App>) -> HashSet<Cell> {
    let pattern = pattern(harness);
    let all = shapes::filled_rectangle(
        [0, 0],
        [pattern.cols() as i32 - 1, pattern.rows() as i32 - 1],
    );
    all.filter(|[col, row]| pattern.at((*col).into(), (*row).into()) != 0)
        .collect()
}

fn undo_name<'h>(harness: &'h Harness<'_, App>) -> Option<&'h str> {
    harness.state().document().undo_name()
}

fn undo(harness: &mut Harness<'_, App>) {
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    harness.run_steps(3);
}

/// Presses at one cell and goes to another in steps, without letting go.
fn draw_out(harness: &mut Harness<'_, App>, from: [usize; 2], to: [usize; 2]) {
    let (from, to) = (cell(harness, from[0], from[1]), cell(harness, to[0], to[1]));
    harness.drag_at(from);
    harness.run_steps(1);
    for step in 1..=3 {
        harness.hover_at(from + (to - from) * (step as f32 / 3.0));
        harness.run_steps(1);
    }
}

fn let_go(harness: &mut Harness<'_, App>, at: [usize; 2]) {
    let at = cell(harness, at[0], at[1]);
    harness.drop_at(at);
    harness.run_steps(3);
}

fn press_keys(harness: &mut Harness<'_, App>, keys: &[(Modifiers, Key)]) {
    for (modifiers, key) in keys {
        harness.key_press_modifiers(*modifiers, *key);
        harness.run_steps(2);
    }
}

fn focus_grid(harness: &mut Harness<'_, App>) {
    harness
        .get_by_role_and_label(Role::Grid, "Stitch pattern")
        .focus();
    harness.run_steps(2);
}

const PLAIN: Modifiers = Modifiers::NONE;
const SHIFT: Modifiers = Modifiers::SHIFT;

#[test]
fn lines_and_rectangles_are_drawn_out_and_are_one_step() {
    let outline = set(shapes::rectangle([1, 1], [6, 4]));
    let filled = set(shapes::filled_rectangle([1, 1], [6, 4]));
    let line = set(shapes::line([1, 1], [6, 4]));
    for (tool, cells) in [
        ("Line", line),
        ("Rectangle", outline),
        ("Filled rectangle", filled),
    ] {
        let mut harness = with_zeros(9, 7);
        let before = design(&harness).clone();
        click(&mut harness, tool);
        draw_out(&mut harness, [1, 1], [6, 4]);
        assert_eq!(
            painted(&harness),
            HashSet::new(),
            "{tool}: painted before its end"
        );
        harness.get_by_label("6 × 4 cells");
        let_go(&mut harness, [6, 4]);
        assert_eq!(painted(&harness), cells, "{tool}");
        assert_eq!(requested(&harness).weave, design(&harness).weave);
        assert_eq!(undo_name(&harness), Some("painted stitches"));
        undo(&mut harness);
        assert_eq!(*design(&harness), before);
    }
}

#[test]
fn a_shape_that_leaves_the_grid_is_painted_as_far_as_it_is_inside() {
    let mut harness = with_zeros(5, 5);
    click(&mut harness, "Rectangle");
    let from = cell(&harness, 2, 2);
    let side = cell(&harness, 1, 0).x - cell(&harness, 0, 0).x;
    harness.drag_at(from);
    harness.run_steps(1);
    harness.hover_at(from + vec2(9.0, 1.0) * side);
    harness.run_steps(1);
    harness.drop_at(from + vec2(9.0, 1.0) * side);
    harness.run_steps(3);
    let inside = |cell: &Cell| cell.iter().all(|at| (0..5).contains(at));
    let cells: HashSet<Cell> = shapes::rectangle([2, 2], [11, 1]).filter(inside).collect();
    assert_eq!(painted(&harness), cells);
}

#[test]
fn a_stroke_within_two_frames_is_painted_where_the_pointer_went() {
    let mut harness = with_zeros(6, 6);
    let [start, corner, end, away] =
        [[1, 1], [1, 4], [4, 4], [5, 0]].map(|[col, row]| cell(&harness, col, row));
    in_frames(
        &mut harness,
        vec![
            vec![Event::PointerMoved(away), Event::PointerMoved(start)],
            vec![first_button(start, true), Event::PointerMoved(corner)],
            vec![
                Event::PointerMoved(end),
                first_button(end, false),
                Event::PointerMoved(away),
            ],
        ],
    );
    let way = shapes::line([1, 1], [1, 4]).chain(shapes::line([1, 4], [4, 4]));
    let way: HashSet<Cell> = way.collect();
    assert_eq!(painted(&harness), way);

    // All of it within one frame.
    undo(&mut harness);
    assert_eq!(painted(&harness), HashSet::new());
    let all = vec![
        Event::PointerMoved(start),
        first_button(start, true),
        Event::PointerMoved(corner),
        Event::PointerMoved(end),
        first_button(end, false),
        Event::PointerMoved(away),
    ];
    in_frames(&mut harness, vec![all]);
    assert_eq!(painted(&harness), way);
}

#[test]
fn shift_constrains_while_drawing_out() {
    let mut harness = with_zeros(9, 9);
    click(&mut harness, "Line");
    draw_out(&mut harness, [1, 1], [7, 2]);
    harness.event(Event::ModifiersChanged(SHIFT));
    harness.run_steps(1);
    harness.get_by_label("7 × 1 cells");
}

#[test]
fn escape_takes_back_what_is_under_way() {
    for tool in ["Pencil", "Line", "Filled rectangle"] {
        let mut harness = with_zeros(6, 6);
        let before = design(&harness).clone();
        let name = undo_name(&harness).map(str::to_owned);
        click(&mut harness, tool);
        draw_out(&mut harness, [0, 0], [4, 4]);
        harness.key_press(Key::Escape);
        harness.run_steps(2);
        harness.hover_at(cell(&harness, 5, 0));
        harness.run_steps(2);
        let_go(&mut harness, [5, 0]);
        assert_eq!(*design(&harness), before, "{tool}");
        assert_eq!(
            undo_name(&harness),
            name.as_deref(),
            "{tool}: a step of nothing"
        );
        // And the tool still works.
        draw_out(&mut harness, [0, 0], [4, 4]);
        let_go(&mut harness, [4, 4]);
        assert!(painted(&harness).len() >= 5, "{tool}");
    }
}

#[test]
fn values_are_picked_by_tool_by_right_click_and_with_alt() {
    let chosen = |harness: &Harness<'_, App>| {
        let names = [
            "weft over warp",
            "warp over weft",
            "loop on the front",
            "loop on the back",
        ];
        let shown = |name: &&str| harness.query_by_role_and_label(Role::Label, name).is_some();
        names.into_iter().find(shown)
    };
    let mut harness = designer(None);
    assert_eq!(chosen(&harness), Some("loop on the front"));
    let before = design(&harness).clone();

    click(&mut harness, "Pick");
    paint_cell(&mut harness, 1, 0);
    assert_eq!(chosen(&harness), Some("weft over warp"));

    click(&mut harness, "Pencil");
    let button = |harness: &mut Harness<'_, App>, at: Pos2, button, modifiers| {
        for pressed in [true, false] {
            harness.event_modifiers(
                Event::PointerButton {
                    pos: at,
                    button,
                    pressed,
                    modifiers,
                },
                modifiers,
            );
            harness.run_steps(2);
        }
        harness.run_steps(2);
    };
    let at = cell(&harness, 0, 0);
    harness.hover_at(at);
    harness.run_steps(1);
    button(&mut harness, at, PointerButton::Secondary, PLAIN);
    assert_eq!(chosen(&harness), Some("loop on the front"));

    let at = cell(&harness, 1, 0);
    harness.hover_at(at);
    harness.run_steps(1);
    button(&mut harness, at, PointerButton::Primary, Modifiers::ALT);
    assert_eq!(chosen(&harness), Some("weft over warp"));
    assert_eq!(*design(&harness), before, "picking painted");
}

#[test]
fn keys_draw_out_shapes() {
    let mut harness = with_zeros(6, 6);
    focus_grid(&mut harness);
    // The cursor is where the last cell was painted.
    press_keys(
        &mut harness,
        &[
            (PLAIN, Key::ArrowLeft),
            (PLAIN, Key::ArrowDown),
            (PLAIN, Key::L),
            (PLAIN, Key::Space),
        ],
    );
    press_keys(&mut harness, &[(PLAIN, Key::ArrowRight); 3]);
    press_keys(&mut harness, &[(PLAIN, Key::ArrowUp); 3]);
    assert_eq!(painted(&harness), HashSet::new());
    press_keys(&mut harness, &[(PLAIN, Key::Space)]);
    assert_eq!(painted(&harness), set(shapes::line([0, 0], [3, 3])));
    assert_eq!(undo_name(&harness), Some("painted stitches"));
    undo(&mut harness);
    assert_eq!(painted(&harness), HashSet::new(), "one shape is one step");

    // From (3, 3), where the cursor stayed.
    press_keys(
        &mut harness,
        &[
            (PLAIN, Key::R),
            (SHIFT, Key::ArrowDown),
            (SHIFT, Key::ArrowDown),
            (SHIFT, Key::ArrowRight),
            (SHIFT, Key::ArrowRight),
        ],
    );
    press_keys(&mut harness, &[(PLAIN, Key::Enter)]);
    assert_eq!(painted(&harness), set(shapes::rectangle([3, 3], [5, 1])));
    undo(&mut harness);

    press_keys(
        &mut harness,
        &[
            (SHIFT, Key::R),
            (PLAIN, Key::Space),
            (PLAIN, Key::ArrowUp),
            (PLAIN, Key::Escape),
        ],
    );
    let grid = harness.get_by_role_and_label(Role::Grid, "Stitch pattern");
    assert!(grid.is_focused(), "Escape took the focus with the shape");
    press_keys(&mut harness, &[(PLAIN, Key::ArrowUp), (PLAIN, Key::P)]);
    assert_eq!(painted(&harness), HashSet::new());
    press_keys(
        &mut harness,
        &[(SHIFT, Key::ArrowLeft), (SHIFT, Key::ArrowLeft)],
    );
    assert_eq!(painted(&harness), set(shapes::line([5, 3], [3, 3])));
}

#[test]
fn letters_choose_tools_and_fill_and_pick_work_by_keys() {
    let mut harness = with_zeros(4, 3);
    focus_grid(&mut harness);
    for (modifiers, key, name) in [
        (PLAIN, Key::L, "Line"),
        (PLAIN, Key::R, "Rectangle"),
        (SHIFT, Key::R, "Filled rectangle"),
        (PLAIN, Key::I, "Pick"),
        (PLAIN, Key::P, "Pencil"),
        (PLAIN, Key::F, "Fill"),
    ] {
        press_keys(&mut harness, &[(modifiers, key)]);
        let button = harness.get_by_role_and_label(Role::Button, name);
        assert_eq!(
            button.accesskit_node().toggled(),
            Some(egui::accesskit::Toggled::True),
            "{name}"
        );
    }
    press_keys(&mut harness, &[(PLAIN, Key::Space)]);
    assert_eq!(painted(&harness).len(), 12);
    press_keys(&mut harness, &[(PLAIN, Key::P)]);
    harness.event(Event::Text("1".into()));
    harness.run_steps(3);
    press_keys(
        &mut harness,
        &[
            (PLAIN, Key::ArrowLeft),
            (PLAIN, Key::I),
            (PLAIN, Key::Space),
        ],
    );
    harness.get_by_role_and_label(Role::Label, "loop on the front");
}

#[test]
fn a_screen_reader_hears_the_cell_and_the_shape() {
    let mut harness = designer(None);
    focus_grid(&mut harness);
    let value = |harness: &Harness<'_, App>| {
        let grid = harness.get_by_role_and_label(Role::Grid, "Stitch pattern");
        grid.value().unwrap_or_default()
    };
    assert_eq!(
        value(&harness),
        "column 1 of 2, row 1 of 2: 7, loop on the front"
    );
    press_keys(&mut harness, &[(PLAIN, Key::ArrowRight)]);
    assert_eq!(
        value(&harness),
        "column 2 of 2, row 1 of 2: 0, weft over warp"
    );
    press_keys(&mut harness, &[(PLAIN, Key::R), (SHIFT, Key::ArrowUp)]);
    assert_eq!(
        value(&harness),
        "column 2 of 2, row 2 of 2: 7, loop on the front; drawing 1 by 2"
    );
}

fn patterns() -> impl Strategy<Value = Pattern> {
    let value = prop::sample::select(STITCHES.to_vec());
    (1_usize..7, 1_usize..7).prop_flat_map(move |(cols, rows)| {
        let values = prop::collection::vec(value.clone(), cols * rows);
        values.prop_map(move |values| {
            Pattern::from_fn(cols, rows, |col, row| values[row * cols + col])
        })
    })
}

proptest! {
    #[test]
    fn mirrors_turns_and_shifts_obey_their_laws(pattern in patterns(), x in -9_i64..9, y in -9_i64..9) {
        let (cols, rows) = (pattern.cols() as i64, pattern.rows() as i64);
        prop_assert_eq!(&pattern.mirrored_left_right().mirrored_left_right(), &pattern);
        prop_assert_eq!(&pattern.mirrored_near_far().mirrored_near_far(), &pattern);
        let half = pattern.turned().turned();
        prop_assert_eq!(&half, &pattern.mirrored_left_right().mirrored_near_far());
        prop_assert_eq!(&half.turned().turned(), &pattern);
        prop_assert_eq!(&pattern.shifted(x, y).shifted(-x, -y), &pattern);
        prop_assert_eq!(&pattern.shifted(cols, -rows), &pattern);
        prop_assert_eq!(pattern.shifted(x, y).at(x, y), pattern.at(0, 0));
        // Clockwise: what was at the near left comes to the far left.
        prop_assert_eq!(pattern.turned().at(0, cols - 1), pattern.at(0, 0));
        prop_assert_eq!(pattern.mirrored_left_right().at(0, 0), pattern.at(cols - 1, 0));
        prop_assert_eq!(pattern.mirrored_near_far().at(0, 0), pattern.at(0, rows - 1));
    }

    #[test]
    fn resizing_keeps_content_where_the_anchor_says(
        pattern in patterns(),
        cols in 1_usize..9,
        rows in 1_usize..9,
        x in prop::sample::select(vec![Keep::First, Keep::Middle, Keep::Last]),
        y in prop::sample::select(vec![Keep::First, Keep::Middle, Keep::Last]),
    ) {
        let anchor = Anchor { x, y };
        let room = [cols as i64 - pattern.cols() as i64, rows as i64 - pattern.rows() as i64];
        let offset = |keep, room: i64| match keep {
            Keep::First => 0,
            Keep::Middle => room.div_euclid(2),
            Keep::Last => room,
        };
        let [dx, dy] = [offset(x, room[0]), offset(y, room[1])];
        let flat = pattern.resized(cols, rows, anchor, NewCells::Weft);
        let repeated = pattern.resized(cols, rows, anchor, NewCells::Repeat);
        prop_assert_eq!((flat.cols(), flat.rows()), (cols, rows));
        for row in 0..rows as i64 {
            for col in 0..cols as i64 {
                let old = pattern.at(col - dx, row - dy);
                let was_inside = (0..pattern.cols() as i64).contains(&(col - dx))
                    && (0..pattern.rows() as i64).contains(&(row - dy));
                prop_assert_eq!(flat.at(col, row), if was_inside { old } else { 0 });
                prop_assert_eq!(repeated.at(col, row), old);
            }
        }
        if room.iter().all(|room| *room >= 0) {
            let back = flat.resized(pattern.cols(), pattern.rows(), anchor, NewCells::Weft);
            // An odd rest in the middle is rounded the other way on the way back.
            if anchor.x != Keep::Middle && anchor.y != Keep::Middle {
                prop_assert_eq!(&back, &pattern);
            }
        }
    }
}

#[test]
fn buttons_and_keys_change_the_whole_pattern_under_their_own_names() {
    let mut harness = designer(None);
    type_number(&mut harness, "Pattern columns", "4");
    type_number(&mut harness, "Pattern rows", "3");
    let before = pattern(&harness).clone();
    let ctrl = Modifiers::COMMAND;
    let cases: [(&str, (Modifiers, Key), Pattern, &str); 7] = [
        (
            "Mirror left and right",
            (PLAIN, Key::M),
            before.mirrored_left_right(),
            "mirrored pattern",
        ),
        (
            "Mirror near and far",
            (SHIFT, Key::M),
            before.mirrored_near_far(),
            "mirrored pattern",
        ),
        (
            "Rotate",
            (PLAIN, Key::T),
            before.turned(),
            "rotated pattern",
        ),
        (
            "Shift left",
            (ctrl, Key::ArrowLeft),
            before.shifted(-1, 0),
            "shifted pattern",
        ),
        (
            "Shift right",
            (ctrl, Key::ArrowRight),
            before.shifted(1, 0),
            "shifted pattern",
        ),
        (
            "Shift up",
            (ctrl, Key::ArrowUp),
            before.shifted(0, 1),
            "shifted pattern",
        ),
        (
            "Shift down",
            (ctrl, Key::ArrowDown),
            before.shifted(0, -1),
            "shifted pattern",
        ),
    ];
    for (button, key, after, name) in cases {
        assert_ne!(after, before, "{button}: would show nothing");
        click(&mut harness, button);
        assert_eq!(*pattern(&harness), after, "{button}");
        assert_eq!(undo_name(&harness), Some(name), "{button}");
        undo(&mut harness);
        assert_eq!(*pattern(&harness), before, "{button}");

        focus_grid(&mut harness);
        press_keys(&mut harness, &[key]);
        assert_eq!(*pattern(&harness), after, "key of {button}");
        undo(&mut harness);
        assert_eq!(*pattern(&harness), before, "{button}");
    }
}

#[test]
fn a_size_dragged_down_and_up_again_loses_nothing() {
    let mut harness = designer(None);
    type_number(&mut harness, "Pattern columns", "12");
    click(&mut harness, "Paint 9: loops on both faces");
    paint_cell(&mut harness, 11, 1);
    let before = pattern(&harness).clone();
    let field = harness
        .get_by_role_and_label(Role::SpinButton, "Pattern columns")
        .rect()
        .center();
    harness.drag_at(field);
    harness.run_steps(2);
    let mut fewest = 12;
    for step in (0..=8).chain((0..8).rev()) {
        harness.hover_at(field - vec2(10.0 * step as f32, 0.0));
        harness.run_steps(2);
        fewest = fewest.min(pattern(&harness).cols());
    }
    harness.drop_at(field);
    harness.run_steps(3);
    assert!(
        fewest < 9,
        "{fewest} columns: the drag did not change the size"
    );
    assert_eq!(*pattern(&harness), before);
}

#[test]
fn the_side_that_stays_can_be_chosen() {
    let mut harness = designer(None);
    let before = pattern(&harness).clone();
    click(&mut harness, "How the size changes");
    click(&mut harness, "Keep far right");
    click(&mut harness, "repeat the pattern");
    harness.key_press(Key::Escape);
    harness.run_steps(3);
    type_number(&mut harness, "Pattern columns", "5");
    assert_eq!(undo_name(&harness), Some("pattern size"));
    let anchor = Anchor {
        x: Keep::Last,
        y: Keep::Last,
    };
    assert_eq!(
        *pattern(&harness),
        before.resized(5, 2, anchor, NewCells::Repeat)
    );
    undo(&mut harness);
    assert_eq!(*pattern(&harness), before);
}

#[test]
fn choosing_a_ready_pattern_is_one_step_with_its_name() {
    for ready in WEAVE_LIBRARY {
        let mut harness = designer(None);
        let before = design(&harness).clone();
        click(&mut harness, "Ready patterns…");
        click(&mut harness, ready.name);
        assert_eq!(*pattern(&harness), ready.pattern());
        assert_eq!(requested(&harness).weave.pattern, ready.pattern());
        let back = ready.back.unwrap_or(Back::Mirror);
        assert_eq!(design(&harness).weave.back, back, "{}", ready.name);
        let name = format!("ready pattern {}", ready.name);
        assert_eq!(undo_name(&harness), Some(name.as_str()));
        assert!(
            harness.query_by_label("Velvet").is_none(),
            "the menu stays open"
        );
        undo(&mut harness);
        assert_eq!(*design(&harness), before, "{}", ready.name);
    }
}

#[test]
fn the_large_window_edits_the_same_pattern() {
    let mut harness = designer(None);
    let small = harness
        .get_by_role_and_label(Role::Grid, "Stitch pattern")
        .rect();
    click(&mut harness, "Enlarge the weave editor");
    harness.run_steps(5);
    let large = harness
        .get_by_role_and_label(Role::Grid, "Stitch pattern")
        .rect();
    assert!(
        large.width() > 2.0 * small.width(),
        "{large:?} after {small:?}"
    );
    // Three by three repeats of 2 × 2 cells: the middle one is the pattern itself.
    let side = (large.width() - 1.0) / 6.0;
    let lower_left = pos2(large.left() + 2.5 * side, large.bottom() - 1.0 - 2.5 * side);
    harness.drag_at(lower_left + vec2(side, 0.0));
    harness.run_steps(1);
    harness.drop_at(lower_left + vec2(side, 0.0));
    harness.run_steps(3);
    assert_eq!(pattern(&harness).at(1, 0), 7);
    assert_eq!(undo_name(&harness), Some("painted stitches"));
    // The repeats around are to be looked at only.
    harness.drag_at(lower_left - vec2(side, 0.0));
    harness.run_steps(1);
    harness.drop_at(lower_left - vec2(side, 0.0));
    harness.run_steps(3);
    undo(&mut harness);
    assert_eq!(pattern(&harness).at(1, 0), 0);
    click(&mut harness, "Edit here");
    harness.run_steps(5);
    let again = harness
        .get_by_role_and_label(Role::Grid, "Stitch pattern")
        .rect();
    assert_eq!(again.size(), small.size());
}

#[test]
fn cells_can_be_made_larger_and_fitted_again() {
    let mut harness = designer(None);
    let width = |harness: &Harness<'_, App>| {
        harness
            .get_by_role_and_label(Role::Grid, "Stitch pattern")
            .rect()
            .width()
    };
    let fitting = width(&harness);
    click(&mut harness, "Larger cells");
    assert!(width(&harness) > 1.1 * fitting);
    click(&mut harness, "Fit the pattern");
    assert_eq!(width(&harness), fitting);
    focus_grid(&mut harness);
    press_keys(&mut harness, &[(PLAIN, Key::Minus)]);
    assert!(width(&harness) < 0.9 * fitting);
}

/// Vertices of a frame.
fn vertices(harness: &mut Harness<'_, App>) -> usize {
    harness.run_steps(2);
    let shapes = harness.output().shapes.clone();
    let primitives = harness.ctx.tessellate(shapes, 1.0);
    let of = |primitive: &egui::ClippedPrimitive| match &primitive.primitive {
        egui::epaint::Primitive::Mesh(mesh) => mesh.vertices.len(),
        egui::epaint::Primitive::Callback(_) => 0,
    };
    primitives.iter().map(of).sum()
}

#[test]
fn a_large_pattern_costs_little_more_to_draw_than_a_small_one() {
    let mut harness = designer(None);
    let small = vertices(&mut harness);
    type_number(&mut harness, "Pattern columns", "64");
    type_number(&mut harness, "Pattern rows", "64");
    let large = vertices(&mut harness);
    // One texture instead of 4096 cells: what is left are the digits of the size, and lines and glyphs get fewer.
    assert!(large < small + 200, "{large} vertices after {small}");
}
