//! Gestures on what lies on the chart: laid there, moved, scaled, turned by the pointer or by keys, snapping to the
//! chart's middle, its edges and guides.

use egui::{CursorIcon, Key, Pos2, Rect, Response, Ui};
use renderer_core::design::chart_objects::{ChartCanvas, Placed};
use renderer_core::design::{Chart, ChartObject, ObjectKind};

use super::objects::{new_object, object_at, rounded};
use super::pyramid::Placement;
use super::snap::{Caught, Snapper};
use super::{ChartEditor, Tool};
use crate::designer::widgets::PointerWay;

/// How near a handle or a line has to be to the pointer, points.
const NEAR: f32 = 7.0;
/// How near something snaps, points.
const SNAP: f32 = 6.0;
/// How far above an object its handle for turning is, points.
pub const TURN_ABOVE: f32 = 22.0;
/// Something that was not dragged at least so far is laid down as large as it starts, points.
const NO_DRAG: f32 = 4.0;
/// Crossings that an arrow key with Shift moves.
const LEAP: f64 = 10.0;
/// Turning with Shift goes by so many degrees.
const TURN_STEP: f64 = 15.0;

/// A gesture on objects or guides.
pub struct Drag {
    /// What is done.
    way: Way,
    /// Where the pointer went down, mm from the chart's middle.
    from: [f64; 2],
    /// Where on the screen.
    from_point: Pos2,
    /// The chart's objects and guides before it.
    before: Before,
}

#[derive(Clone)]
struct Before {
    object: Vec<ChartObject>,
    guides: [Vec<f64>; 2],
}

#[derive(Clone, Copy, PartialEq)]
enum Way {
    /// Moves an object.
    Move(usize),
    /// Pulls this handle of an object.
    Scale(usize, [i8; 2]),
    /// Turns an object.
    Turn(usize),
    /// Lays a new object on the chart.
    Create(usize),
    /// Moves a guide: upright ones (0) or level ones (1), and which of them.
    Guide(usize, usize),
}

/// Where on the screen the chart is, and how.
#[derive(Clone, Copy)]
pub struct View {
    /// What objects are laid on.
    pub canvas: ChartCanvas,
    /// Where that is.
    pub placement: Placement,
}

impl View {
    /// The place on the chart, mm from its middle, under a place on the screen.
    pub fn mm(&self, at: Pos2) -> [f64; 2] {
        let [x, y] = [0, 1].map(|k| {
            f64::from(at[k] - self.placement.corner[k]) / f64::from(self.placement.scale[k])
        });
        self.canvas.place_of([x, y])
    }

    /// The place on the screen of one on the chart.
    pub fn point(&self, place: [f64; 2]) -> Pos2 {
        let [x, y] = self.canvas.pixel_at(place);
        self.placement.at(x as f32, y as f32)
    }

    /// Millimetres of cloth in a point of the screen: the same both ways.
    pub fn mm_per_point(&self) -> f64 {
        self.canvas.pixel_mm[0] / f64::from(self.placement.scale.x)
    }
}

/// Handles of an object that can be pulled, as corners and sides of its box.
pub fn handles(kind: ObjectKind) -> &'static [[i8; 2]] {
    match kind {
        ObjectKind::StripeAcross => &[[0, -1], [0, 1]],
        ObjectKind::StripeAlong => &[[-1, 0], [1, 0]],
        ObjectKind::Line => &[[-1, 0], [1, 0]],
        _ => &[
            [-1, -1],
            [0, -1],
            [1, -1],
            [1, 0],
            [1, 1],
            [0, 1],
            [-1, 1],
            [-1, 0],
        ],
    }
}

/// Where a handle of an object is, on the screen. Those of a stripe are in the middle of what is seen of it.
pub fn handle_point(view: &View, object: &ChartObject, [x, y]: [i8; 2]) -> Pos2 {
    let placed = Placed::first(object, &view.canvas);
    view.point(placed.at([0.5 * f64::from(x), 0.5 * f64::from(y)]))
}

/// Where the handle that turns an object is, for those that can be turned.
pub fn turn_point(view: &View, object: &ChartObject) -> Option<Pos2> {
    let turns = !matches!(
        object.kind,
        ObjectKind::StripeAcross | ObjectKind::StripeAlong | ObjectKind::Line
    );
    turns.then(|| {
        // Away from the middle, whether the object is mirrored or not.
        let up = if object.mirror_y { -0.5 } else { 0.5 };
        let placed = Placed::first(object, &view.canvas);
        let [middle, top] = [[0.0, 0.0], [0.0, up]].map(|at| view.point(placed.at(at)));
        let way = (top - middle).normalized();
        top + way * TURN_ABOVE
    })
}

/// Takes what the pointer does with a tool for objects.
pub fn pointer(
    ui: &Ui,
    editor: &mut ChartEditor,
    response: &Response,
    chart: &mut Chart,
    view: &View,
) {
    let way = PointerWay::new(ui, response, editor.objects.drag.is_some());
    if let (true, Some(&at)) = (way.begins, way.places.first()) {
        response.request_focus();
        begin(editor, chart, view, at);
    }
    if let Some(&at) = way.places.last() {
        let modifiers = ui.input(|i| i.modifiers);
        go_on(editor, chart, view, at, modifiers, response.rect);
    }
    if way.ends {
        end(editor, chart, view);
    }
    if let Some(at) = response.hover_pos()
        && editor.objects.drag.is_none()
        && editor.tool == Tool::Select
    {
        show_cursor(ui, editor, chart, view, at);
    }
}

fn show_cursor(ui: &Ui, editor: &ChartEditor, chart: &Chart, view: &View, at: Pos2) {
    let icon = match grip_at(editor, chart, view, at) {
        Some(Way::Turn(_)) => CursorIcon::Grab,
        Some(Way::Scale(_, handle)) => match handle {
            [_, 0] => CursorIcon::ResizeHorizontal,
            [0, _] => CursorIcon::ResizeVertical,
            [x, y] if x == y => CursorIcon::ResizeNeSw,
            _ => CursorIcon::ResizeNwSe,
        },
        Some(Way::Guide(0, _)) => CursorIcon::ResizeHorizontal,
        Some(Way::Guide(..)) => CursorIcon::ResizeVertical,
        Some(Way::Move(_) | Way::Create(_)) => CursorIcon::Move,
        None => CursorIcon::Default,
    };
    ui.set_cursor_icon(icon);
}

/// What a press of the Select tool takes hold of.
fn grip_at(editor: &ChartEditor, chart: &Chart, view: &View, at: Pos2) -> Option<Way> {
    let is_near = |point: Pos2| point.distance(at) <= NEAR;
    if let Some(index) = editor.objects.selected
        && let Some(object) = chart.object.get(index)
    {
        if turn_point(view, object).is_some_and(is_near) {
            return Some(Way::Turn(index));
        }
        let mut handles = handles(object.kind).iter();
        if let Some(handle) = handles.find(|handle| is_near(handle_point(view, object, **handle))) {
            return Some(Way::Scale(index, *handle));
        }
    }
    let margin = 3.0 * view.mm_per_point();
    if let Some(index) = object_at(chart, &view.canvas, view.mm(at), margin) {
        return Some(Way::Move(index));
    }
    guide_at(chart, view, at).map(|(axis, index)| Way::Guide(axis, index))
}

fn guide_at(chart: &Chart, view: &View, at: Pos2) -> Option<(usize, usize)> {
    let guides = [&chart.guides_x, &chart.guides_y];
    (0..2).find_map(|axis| {
        let is_near = |guide: &f64| {
            let mut place = [0.0; 2];
            place[axis] = *guide;
            (view.point(place)[axis] - at[axis]).abs() <= NEAR
        };
        guides[axis]
            .iter()
            .position(is_near)
            .map(|index| (axis, index))
    })
}

fn begin(editor: &mut ChartEditor, chart: &mut Chart, view: &View, at: Pos2) {
    let before = Before {
        object: chart.object.clone(),
        guides: [chart.guides_x.clone(), chart.guides_y.clone()],
    };
    let snapper = snapper(editor, chart, view, false);
    let mut from = view.mm(at);
    let way = match editor.tool {
        Tool::Add(kind) => {
            if chart.object.len() >= ChartObject::MAX {
                return;
            }
            from = snapper.place(from).0;
            let mut object = new_object(kind, editor.colour, &view.canvas);
            (object.x, object.y) = (from[0], from[1]);
            chart.object.push(object);
            let index = chart.object.len() - 1;
            editor.objects.selected = Some(index);
            Way::Create(index)
        }
        _ => {
            let Some(way) = grip_at(editor, chart, view, at) else {
                editor.objects.selected = None;
                return;
            };
            match way {
                Way::Move(index) => editor.objects.selected = Some(index),
                Way::Guide(..) => editor.objects.selected = None,
                _ => {}
            }
            way
        }
    };
    editor.objects.drag = Some(Drag {
        way,
        from,
        from_point: at,
        before,
    });
}

/// Begins to drag a new guide from a ruler: an upright one (0) or a level one (1).
pub fn begin_guide(
    editor: &mut ChartEditor,
    chart: &mut Chart,
    view: &View,
    axis: usize,
    at: Pos2,
) {
    let before = Before {
        object: chart.object.clone(),
        guides: [chart.guides_x.clone(), chart.guides_y.clone()],
    };
    let from = view.mm(at);
    let guides = guides_mut(chart, axis);
    guides.push(from[axis]);
    editor.objects.drag = Some(Drag {
        way: Way::Guide(axis, guides.len() - 1),
        from,
        from_point: at,
        before,
    });
}

/// Goes on with dragging a guide that began on a ruler.
pub fn drag_guide(
    editor: &mut ChartEditor,
    chart: &mut Chart,
    view: &View,
    at: Pos2,
    canvas: Rect,
    ends: bool,
) {
    go_on(editor, chart, view, at, egui::Modifiers::NONE, canvas);
    if ends {
        end(editor, chart, view);
    }
}

fn guides_mut(chart: &mut Chart, axis: usize) -> &mut Vec<f64> {
    match axis {
        0 => &mut chart.guides_x,
        _ => &mut chart.guides_y,
    }
}

fn snapper(editor: &ChartEditor, chart: &Chart, view: &View, is_off: bool) -> Snapper {
    let reach = f64::from(SNAP) * view.mm_per_point();
    Snapper::new(chart, &view.canvas, reach, editor.objects.snaps && !is_off)
}

fn go_on(
    editor: &mut ChartEditor,
    chart: &mut Chart,
    view: &View,
    at: Pos2,
    modifiers: egui::Modifiers,
    canvas: Rect,
) {
    let snapper = snapper(editor, chart, view, modifiers.alt);
    let Some(drag) = &editor.objects.drag else {
        return;
    };
    let (to, shift) = (view.mm(at), modifiers.shift);
    let mut caught = Caught::default();
    match drag.way {
        Way::Guide(axis, index) => {
            // To the middle and the edges, or to a crossing; taken off the canvas, it is given up.
            let place = to[axis] + snapper.without_guides().shift(axis, &[to[axis]]).0;
            let guides = guides_mut(chart, axis);
            guides.clone_from(&drag.before.guides[axis]);
            match (canvas.expand(1.0).contains(at), guides.get_mut(index)) {
                (true, Some(guide)) => *guide = place,
                (true, None) => guides.push(place),
                (false, Some(_)) => drop(guides.remove(index)),
                (false, None) => {}
            }
        }
        Way::Move(index) => {
            let Some(object) = drag.before.object.get(index) else {
                return;
            };
            let mut moved = object.clone();
            let mut by = [0, 1].map(|k| to[k] - drag.from[k]);
            if shift {
                // Along one axis.
                let still = usize::from(by[0].abs() > by[1].abs());
                by[still] = 0.0;
            }
            (moved.x, moved.y) = (object.x + by[0], object.y + by[1]);
            let [low, high] = Placed::first(&moved, &view.canvas).bounds();
            for axis in 0..2 {
                if by[axis] == 0.0 || is_through(object.kind, axis) {
                    continue;
                }
                let middle = 0.5 * (low[axis] + high[axis]);
                let (shift, line) = snapper.shift(axis, &[low[axis], middle, high[axis]]);
                match axis {
                    0 => moved.x = tidy(moved.x + shift),
                    _ => moved.y = tidy(moved.y + shift),
                }
                caught.0[axis] = line;
            }
            chart.object[index] = moved;
        }
        Way::Turn(index) => {
            let Some(object) = drag.before.object.get(index) else {
                return;
            };
            let angle = |place: [f64; 2]| {
                (place[1] - object.y)
                    .atan2(place[0] - object.x)
                    .to_degrees()
            };
            let turned = object.rotation + angle(to) - angle(drag.from);
            let step = if shift { TURN_STEP } else { 0.5 };
            let turned = (turned / step).round() * step;
            chart.object[index].rotation = (turned + 180.0).rem_euclid(360.0) - 180.0;
        }
        Way::Scale(index, handle) => {
            let Some(object) = drag.before.object.get(index) else {
                return;
            };
            let (to, lines) = snapper.place(to);
            caught = lines;
            chart.object[index] = match object.kind {
                ObjectKind::Line => pulled_line(object, handle, to, shift, &view.canvas),
                _ => pulled(object, handle, to, shift, &view.canvas),
            };
        }
        Way::Create(index) => {
            if drag.from_point.distance(at) < NO_DRAG {
                return;
            }
            let (to, lines) = snapper.place(to);
            caught = lines;
            let object = chart.object[index].clone();
            chart.object[index] = spanned(object, drag.from, to, shift);
        }
    }
    editor.objects.caught = caught;
}

/// To a nanometre: what sums leave of rounding is no place.
fn tidy(mm: f64) -> f64 {
    (mm * 1e6).round() / 1e6
}

/// Whether an object reaches through the chart along an axis.
fn is_through(kind: ObjectKind, axis: usize) -> bool {
    matches!(
        (kind, axis),
        (ObjectKind::StripeAcross, 0) | (ObjectKind::StripeAlong, 1)
    )
}

/// A new object from one place to another.
fn spanned(mut object: ChartObject, from: [f64; 2], to: [f64; 2], shift: bool) -> ChartObject {
    let mut by = [0, 1].map(|k| to[k] - from[k]);
    if object.kind == ObjectKind::Line {
        return line_between(&object, from, [from[0] + by[0], from[1] + by[1]], shift);
    }
    if object.kind == ObjectKind::Text {
        // As high as it was dragged, whichever way.
        let proportion = object.width / object.height;
        object.height = rounded(by[1].abs());
        object.width = rounded(object.height * proportion);
        object.x = from[0] + 0.5 * object.width * by[0].signum();
        object.y = from[1] + 0.5 * object.height * by[1].signum();
        return object;
    }
    if shift {
        let side = by[0].abs().max(by[1].abs());
        by = by.map(|by| side.copysign(by));
    }
    (object.x, object.y) = (from[0] + 0.5 * by[0], from[1] + 0.5 * by[1]);
    if object.kind != ObjectKind::StripeAcross {
        object.width = rounded(by[0].abs());
    }
    if object.kind != ObjectKind::StripeAlong {
        object.height = rounded(by[1].abs());
    }
    match object.kind {
        ObjectKind::StripeAcross => object.x = 0.0,
        ObjectKind::StripeAlong => object.y = 0.0,
        _ => {}
    }
    object.step_x = rounded(2.0 * object.width);
    object.step_y = rounded(2.0 * object.height);
    object
}

/// A line between two places; level, upright or diagonal with `shift`.
fn line_between(line: &ChartObject, from: [f64; 2], to: [f64; 2], shift: bool) -> ChartObject {
    let by = [0, 1].map(|k| to[k] - from[k]);
    let mut angle = by[1].atan2(by[0]).to_degrees();
    let mut length = by[0].hypot(by[1]);
    if shift {
        let straight = (angle / 45.0).round() * 45.0;
        length *= (angle - straight).to_radians().cos();
        angle = straight;
    }
    let (sine, cosine) = angle.to_radians().sin_cos();
    ChartObject {
        x: from[0] + 0.5 * length * cosine,
        y: from[1] + 0.5 * length * sine,
        width: rounded(length),
        rotation: angle,
        ..line.clone()
    }
}

fn pulled_line(
    line: &ChartObject,
    [side, _]: [i8; 2],
    to: [f64; 2],
    shift: bool,
    canvas: &ChartCanvas,
) -> ChartObject {
    let placed = Placed::first(line, canvas);
    let still = placed.at([-0.5 * f64::from(side), 0.0]);
    let mut pulled = line_between(line, still, to, shift);
    if side < 0 {
        // From the other end it points the other way.
        pulled.rotation = (pulled.rotation + 360.0).rem_euclid(360.0) - 180.0;
    }
    pulled
}

/// An object of which one handle is pulled to a place while what lies opposite stays. Pictures and letters keep their
/// proportion at corners, other objects do so with `shift`.
fn pulled(
    object: &ChartObject,
    handle: [i8; 2],
    to: [f64; 2],
    shift: bool,
    canvas: &ChartCanvas,
) -> ChartObject {
    let placed = Placed::first(object, canvas);
    let sides = handle.map(f64::from);
    let still = placed.at(sides.map(|side| -0.5 * side));
    let (sine, cosine) = object.rotation.to_radians().sin_cos();
    let by = [0, 1].map(|k| to[k] - still[k]);
    // Along the object's own axes.
    let along = match object.kind {
        ObjectKind::StripeAcross | ObjectKind::StripeAlong => by,
        _ => [by[0] * cosine + by[1] * sine, by[1] * cosine - by[0] * sine],
    };
    let before = [object.width, object.height];
    let mut size = [0, 1].map(|k| {
        if handle[k] == 0 {
            before[k]
        } else {
            along[k].abs()
        }
    });
    let keeps = matches!(object.kind, ObjectKind::Image | ObjectKind::Text) != shift;
    if keeps && handle[0] != 0 && handle[1] != 0 {
        let factor = (size[0] / before[0]).max(size[1] / before[1]);
        size = before.map(|side| side * factor);
    }
    let size = size.map(rounded);
    let from_still = [0, 1].map(|k| {
        let way = if handle[k] == 0 {
            0.0
        } else {
            along[k].signum()
        };
        0.5 * way * size[k]
    });
    let mut pulled = ChartObject {
        width: size[0],
        height: size[1],
        ..object.clone()
    };
    match object.kind {
        ObjectKind::StripeAcross => pulled.y = still[1] + from_still[1],
        ObjectKind::StripeAlong => pulled.x = still[0] + from_still[0],
        _ => {
            pulled.x = still[0] + from_still[0] * cosine - from_still[1] * sine;
            pulled.y = still[1] + from_still[0] * sine + from_still[1] * cosine;
        }
    }
    pulled
}

fn end(editor: &mut ChartEditor, chart: &mut Chart, view: &View) {
    let Some(drag) = editor.objects.drag.take() else {
        return;
    };
    editor.objects.caught = Caught::default();
    if let Way::Create(index) = drag.way {
        editor.tool = Tool::Select;
        if let Some(object) = chart.object.get_mut(index) {
            // Laid down by a click, it is as large as it starts, between whole crossings.
            keep_reachable(object, view);
        }
    }
}

/// An object that lies beside the chart could not be seen any more.
fn keep_reachable(object: &mut ChartObject, view: &View) {
    let half = view.canvas.size_mm().map(|side| 0.5 * side);
    object.x = object.x.clamp(-half[0], half[0]);
    object.y = object.y.clamp(-half[1], half[1]);
}

/// Gives up the gesture that is under way: all is as before.
pub fn give_up(editor: &mut ChartEditor, chart: &mut Chart) {
    if let Some(drag) = editor.objects.drag.take() {
        chart.object = drag.before.object;
        [chart.guides_x, chart.guides_y] = drag.before.guides;
        editor.objects.caught = Caught::default();
        editor.objects.keep_within(chart);
    }
}

/// Takes keys for the object that is chosen: arrows move it, Delete removes it, Escape lets go of it. Returns whether
/// they were for it.
pub fn keyboard(
    ui: &Ui,
    editor: &mut ChartEditor,
    chart: &mut Chart,
    canvas: &ChartCanvas,
) -> bool {
    let pressed = |key| ui.input(|i| i.num_presses(key) as i32);
    if editor.objects.drag.is_some() && pressed(Key::Escape) > 0 {
        give_up(editor, chart);
        return true;
    }
    let (Tool::Select, Some(index)) = (editor.tool, editor.objects.selected) else {
        return false;
    };
    let Some(object) = chart.object.get_mut(index) else {
        return false;
    };
    if pressed(Key::Delete) + pressed(Key::Backspace) > 0 {
        chart.object.remove(index);
        editor.objects.selected = None;
        return true;
    }
    if pressed(Key::Escape) > 0 {
        editor.objects.selected = None;
        return true;
    }
    let by = [
        pressed(Key::ArrowRight) - pressed(Key::ArrowLeft),
        pressed(Key::ArrowUp) - pressed(Key::ArrowDown),
    ];
    if by == [0, 0] {
        return false;
    }
    let leap = if ui.input(|i| i.modifiers.shift) {
        LEAP
    } else {
        1.0
    };
    object.x += f64::from(by[0]) * leap * canvas.pixel_mm[0];
    object.y += f64::from(by[1]) * leap * canvas.pixel_mm[1];
    true
}

/// The object that a gesture is about, with its size to be shown beside it.
pub fn under_way<'c>(editor: &ChartEditor, chart: &'c Chart) -> Option<&'c ChartObject> {
    match editor.objects.drag.as_ref()?.way {
        Way::Move(index) | Way::Scale(index, _) | Way::Turn(index) | Way::Create(index) => {
            chart.object.get(index)
        }
        Way::Guide(..) => None,
    }
}
