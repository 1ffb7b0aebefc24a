//! The canvas of the chart editor: where the chart lies, gestures by pointer and keys, and what is drawn over it.
//!
//! Longer than most files because pointer and keys do the same to one gesture, which is drawn while it lasts.

use std::ops::Range;

use egui::{
    Color32, Context, CursorIcon, EventFilter, Key, PointerButton, Pos2, Rect, Response, Role,
    Sense, Stroke, StrokeKind, Ui, Vec2, WidgetInfo, pos2, vec2,
};
use renderer_core::design::chart_edit::{
    LARGEST_BRUSH, crop, draw_line, outline_rectangle, yarn_of,
};
use renderer_core::design::chart_objects::ChartCanvas;
use renderer_core::design::{Chart, ChartImage, Design, Fit, Sheet};

use super::object_gestures::{self, View};
use super::pyramid::{Placement, Pyramid};
use super::work::put;
use super::{ChartEditor, Tool, bars, chart_canvas, overlay, rulers};
use crate::designer::widgets::PointerWay;
use crate::designer::widgets::shapes::{connected, squared, straightened};
use crate::designer::widgets::style;

/// Nearest and farthest view, points for a pixel.
const SCALES: std::ops::RangeInclusive<f32> = 0.02..=64.0;
/// Lines of the yarn grid are at least this far apart, points.
const GRID_FROM: f32 = 5.0;
/// Zoom of a key or button.
pub const ZOOM_STEP: f32 = 1.5;
/// Pixels that an arrow key with Shift moves.
const LEAP: i32 = 10;

/// What the canvas remembers.
#[derive(Default)]
pub struct Canvas {
    pyramid: Pyramid,
    /// Points for a pixel, the mean of its width and height; `None` fits the chart in.
    pub scale: Option<f32>,
    /// The scale that is shown.
    shown: f32,
    /// What of the chart lies in the middle, pixels.
    middle: Pos2,
    /// Keyboard position.
    cursor: [i32; 2],
    gesture: Option<Gesture>,
    /// What the crop tool has marked: two opposite corners.
    pub marked: Option<[[i32; 2]; 2]>,
}

/// A gesture from press to release, or from one key to the next.
struct Gesture {
    tool: Tool,
    start: [i32; 2],
    last: [i32; 2],
    /// The chart before it.
    before: ChartImage,
    by_keys: bool,
}

impl Canvas {
    /// Forgets gesture and mark: the chart is another.
    pub fn reset(&mut self) {
        self.gesture = None;
        self.marked = None;
    }

    /// Zooms about the middle.
    pub fn zoom(&mut self, factor: f32) {
        let scale = self.scale.unwrap_or(self.shown) * factor;
        self.scale = Some(scale.clamp(*SCALES.start(), *SCALES.end()));
    }

    fn placement(&mut self, rect: Rect, canvas: &ChartCanvas) -> Placement {
        let size = vec2(canvas.size[0] as f32, canvas.size[1] as f32);
        let shape = pixel_shape(canvas);
        // Until it is zoomed, all of it is seen however large the canvas becomes.
        let scale = self.scale.unwrap_or_else(|| {
            self.middle = (size / 2.0).to_pos2();
            let fitting = (rect.size() - Vec2::splat(16.0)) / (size * shape);
            fitting.min_elem().clamp(*SCALES.start(), 32.0)
        });
        self.shown = scale;
        self.middle = self.middle.clamp(Pos2::ZERO, size.to_pos2());
        let scale = scale * shape;
        Placement {
            corner: rect.center() - self.middle.to_vec2() * scale,
            scale,
        }
    }
}

/// Width and height of a pixel on the cloth as shares of their mean, so that a circle on the canvas is one on the
/// cloth.
fn pixel_shape(canvas: &ChartCanvas) -> Vec2 {
    let [width, height] = canvas.pixel_mm;
    let mean = (width * height).sqrt();
    let shape = vec2((width / mean) as f32, (height / mean) as f32);
    if shape.is_finite() {
        shape
    } else {
        Vec2::splat(1.0)
    }
}

/// Shows the canvas and its rulers in all of `ui`, and edits the chart.
pub fn show(ui: &mut Ui, editor: &mut ChartEditor, design: &mut Design) -> Response {
    let whole = ui.available_rect_before_wrap();
    let breadth = Vec2::splat(rulers::BREADTH).min(whole.size());
    let rect = Rect::from_min_max(whole.min + breadth, whole.max);
    let response = ui.allocate_rect(rect, Sense::click_and_drag());
    let canvas = chart_canvas(design);
    let mut view = View {
        canvas,
        placement: editor.canvas.placement(rect, &canvas),
    };
    if move_view(ui, editor, &response, &view) {
        view.placement = editor.canvas.placement(rect, &canvas);
    }
    let placement = view.placement;
    let at = |at: Pos2| {
        let place = (at - placement.corner) / placement.scale;
        [place.x.floor() as i32, place.y.floor() as i32]
    };
    let top = Rect::from_min_max(pos2(rect.left(), whole.top()), rect.right_top());
    let left = Rect::from_min_max(pos2(whole.left(), rect.top()), rect.left_bottom());
    rulers::show(ui, editor, design, &view, top, rect, 0);
    rulers::show(ui, editor, design, &view, left, rect, 1);
    if !editor.work.is_busy() {
        let is_for_objects = editor.tool.is_for_objects();
        if is_for_objects {
            object_gestures::pointer(ui, editor, &response, &mut design.chart, &view);
        } else {
            pointer(ui, editor, &response, design, at);
        }
        keyboard(ui, editor, &response, design, rect);
    }
    let hovered = response.hover_pos().map(at);
    paint(ui, editor, &response, design, &view, hovered);
    let chart = &design.chart;
    editor.under = hovered
        .or_else(|| response.has_focus().then_some(editor.canvas.cursor))
        .filter(|&place| inside(&canvas, place).is_some());
    let cursor = editor.canvas.cursor;
    response.widget_info(|| WidgetInfo {
        current_text_value: Some(format!(
            "pixel {}, {}: {}",
            cursor[0],
            cursor[1],
            colour_at(chart, cursor).unwrap_or_default()
        )),
        ..WidgetInfo::labeled(Role::Canvas, ui.is_enabled(), "Chart canvas")
    });
    if editor.tool.is_for_objects() {
        return response;
    }
    response.on_hover_cursor(CursorIcon::Crosshair)
}

/// A place as a pixel of the chart, if it is one.
fn inside(canvas: &ChartCanvas, [x, y]: [i32; 2]) -> Option<[usize; 2]> {
    let (x, y) = (usize::try_from(x).ok()?, usize::try_from(y).ok()?);
    (x < canvas.size[0] && y < canvas.size[1]).then_some([x, y])
}

/// The pixel of an image at a column and row, if it has that one.
fn inside_image(image: &ChartImage, [x, y]: [i32; 2]) -> Option<[usize; 2]> {
    let (x, y) = (usize::try_from(x).ok()?, usize::try_from(y).ok()?);
    (x < image.width() && y < image.height()).then_some([x, y])
}

/// What the chart has at a place, as text.
pub fn colour_at(chart: &Chart, place: [i32; 2]) -> Option<String> {
    let image = chart.pixels.as_ref()?;
    let [x, y] = inside_image(image, place)?;
    Some(match yarn_of(image.pixel(x, y)) {
        [r, g, b, 255] => format!("#{r:02x}{g:02x}{b:02x}"),
        _ => "bare".into(),
    })
}

/// Columns and rows between two corners, as far as there are some.
pub fn marked_part([a, b]: [[i32; 2]; 2], image: &ChartImage) -> [Range<usize>; 2] {
    let span = |k: usize, side: usize| {
        let (low, high) = (a[k].min(b[k]), a[k].max(b[k]) + 1);
        (low.max(0) as usize).min(side)..(high.max(0) as usize).min(side)
    };
    [span(0, image.width()), span(1, image.height())]
}

/// Cuts off what is not marked.
pub fn crop_marked(ctx: &Context, editor: &mut ChartEditor, image: &ChartImage) {
    let Some(marked) = editor.canvas.marked.take() else {
        return;
    };
    editor.canvas.reset();
    let [xs, ys] = marked_part(marked, image);
    let work = move |image: &ChartImage| crop(image, xs, ys);
    editor.work.start(ctx, "crop chart", image, work);
}

/// Pans and zooms. Returns whether the view has moved.
fn move_view(ui: &Ui, editor: &mut ChartEditor, response: &Response, view: &View) -> bool {
    let (canvas, placement) = (&mut editor.canvas, view.placement);
    let before = (canvas.scale, canvas.middle);
    if response.dragged_by(PointerButton::Middle) || response.dragged_by(PointerButton::Secondary) {
        canvas.middle -= response.drag_delta() / placement.scale;
        canvas.scale = Some(canvas.shown);
        ui.set_cursor_icon(CursorIcon::Move);
    }
    if let Some(at) = response.hover_pos() {
        let (scroll, pinch) = ui.input(|i| (i.smooth_scroll_delta().y, i.zoom_delta()));
        let factor = pinch * (scroll / 200.0).exp();
        if factor != 1.0 {
            let shape = pixel_shape(&view.canvas);
            let scale = placement.scale.x / shape.x * factor;
            let scale = scale.clamp(*SCALES.start(), *SCALES.end());
            // What lies under the pointer stays there.
            let under = (at - placement.corner) / placement.scale;
            let from_middle = (at - response.rect.center()) / (scale * shape);
            canvas.middle = (under - from_middle).to_pos2();
            canvas.scale = Some(scale);
        }
    }
    (canvas.scale, canvas.middle) != before
}

fn pointer(
    ui: &Ui,
    editor: &mut ChartEditor,
    response: &Response,
    design: &mut Design,
    at: impl Fn(Pos2) -> [i32; 2],
) {
    if let (true, Some(now)) = (
        response.clicked_by(PointerButton::Secondary),
        response.interact_pointer_pos(),
    ) {
        pick(editor, design, at(now));
        return;
    }
    let is_under_way = (editor.canvas.gesture.as_ref()).is_some_and(|gesture| !gesture.by_keys);
    let way = PointerWay::new(ui, response, is_under_way);
    let ends = way.ends;
    let places: Vec<[i32; 2]> = way.places.into_iter().map(at).collect();
    let (Some(&first), Some(&last)) = (places.first(), places.last()) else {
        if ends {
            end(editor, false);
        }
        return;
    };
    if !is_under_way {
        response.request_focus();
        if ui.input(|i| i.modifiers.alt) {
            pick(editor, design, first);
            return;
        }
        editor.canvas.cursor = first;
        begin(editor, design, first, false);
    }
    let shift = ui.input(|i| i.modifiers.shift);
    // Of a shape only its ends count, and it may cover a large chart.
    let is_stroke = editor.tool == Tool::Pencil;
    for place in if is_stroke { places } else { vec![last] } {
        go_on(editor, design, place, shift);
    }
    if ends {
        end(editor, false);
    }
}

fn keyboard(
    ui: &Ui,
    editor: &mut ChartEditor,
    response: &Response,
    design: &mut Design,
    rect: Rect,
) {
    let modifiers = ui.input(|i| i.modifiers);
    // With Ctrl, + and − are the size of the interface.
    if !response.has_focus() || modifiers.command {
        return;
    }
    let keep = EventFilter {
        horizontal_arrows: true,
        vertical_arrows: true,
        escape: true,
        ..EventFilter::default()
    };
    ui.memory_mut(|memory| memory.set_focus_lock_filter(response.id, keep));
    let presses = |key| ui.input(|i| i.num_presses(key) as i32);
    let canvas = chart_canvas(design);
    if object_gestures::keyboard(ui, editor, &mut design.chart, &canvas) {
        return;
    }
    let step = if modifiers.shift { LEAP } else { 1 };
    let [dx, dy] = [
        presses(Key::ArrowRight) - presses(Key::ArrowLeft),
        presses(Key::ArrowDown) - presses(Key::ArrowUp),
    ];
    let ends = canvas.size.map(|side| side as i32 - 1);
    let cursor = &mut editor.canvas.cursor;
    *cursor = [0, 1].map(|k| (cursor[k] + [dx, dy][k] * step).clamp(0, ends[k]));
    let place = *cursor;
    if [dx, dy] != [0, 0] {
        show_place(&mut editor.canvas, pixel_shape(&canvas), place, rect);
    }
    let zoom = presses(Key::Plus) + presses(Key::Equals) - presses(Key::Minus);
    if zoom != 0 {
        editor.canvas.middle = pos2(place[0] as f32 + 0.5, place[1] as f32 + 0.5);
        editor.canvas.zoom(ZOOM_STEP.powi(zoom));
    }
    if presses(Key::Home) > 0 {
        editor.canvas.scale = None;
    }
    for (shift, key, tool) in Tool::KEYS {
        if presses(key) > 0 && modifiers.shift == shift && !modifiers.alt {
            editor.tool = tool;
            end(editor, false);
        }
    }
    let brush = presses(Key::CloseBracket) - presses(Key::OpenBracket);
    editor.brush = (editor.brush as i32 + brush).clamp(1, LARGEST_BRUSH as i32) as usize;
    if presses(Key::Escape) > 0 {
        if let Some(gesture) = editor.canvas.gesture.take() {
            put_back(&mut design.chart, &gesture);
        }
        editor.canvas.marked = None;
    }
    if presses(Key::Enter) > 0 && editor.canvas.marked.is_some() {
        if let Some(image) = design.chart.pixels.clone() {
            crop_marked(ui.ctx(), editor, &image);
        }
        return;
    }
    if editor.tool.is_for_objects() {
        return;
    }
    if presses(Key::Space) + presses(Key::Enter) > 0 {
        let spans = matches!(
            editor.tool,
            Tool::Line | Tool::Rectangle | Tool::FilledRectangle | Tool::Crop
        );
        if editor.canvas.gesture.is_some() {
            go_on(editor, design, place, false);
            end(editor, true);
        } else {
            begin(editor, design, place, true);
            go_on(editor, design, place, false);
            if !spans {
                end(editor, true);
            }
        }
    } else if editor.canvas.gesture.as_ref().is_some_and(|g| g.by_keys) {
        go_on(editor, design, place, false);
    }
}

/// Moves the view so that a place is seen.
fn show_place(canvas: &mut Canvas, shape: Vec2, place: [i32; 2], rect: Rect) {
    let half = rect.size() / 2.0 / (canvas.shown * shape) - Vec2::splat(2.0);
    let place = pos2(place[0] as f32, place[1] as f32);
    let half = half.max(Vec2::ZERO);
    canvas.middle = canvas.middle.clamp(place - half, place + half);
}

/// Takes the colour that is seen there, be it of the chart or of something on it.
fn pick(editor: &mut ChartEditor, design: &Design, place: [i32; 2]) {
    let canvas = chart_canvas(design);
    let Some([x, y]) = inside(&canvas, place) else {
        return;
    };
    if let Some(seen) = editor.composer.chart(design).pixels {
        let at = |at: usize, side: usize, of: usize| (2 * at + 1) * side / (2 * of);
        let (x, y) = (
            at(x, seen.width(), canvas.size[0]),
            at(y, seen.height(), canvas.size[1]),
        );
        editor.colour = yarn_of(seen.pixel(x, y));
    }
}

fn begin(editor: &mut ChartEditor, design: &mut Design, place: [i32; 2], by_keys: bool) {
    let Design { chart, sheet, .. } = design;
    if chart.pixels.is_none() {
        // Objects alone lie on cloth of one colour.
        let [r, g, b] = chart.colour.0;
        bars::start_blank(chart, sheet, [r, g, b, 255]);
    }
    let Some(before) = chart.pixels.clone() else {
        return;
    };
    if editor.tool != Tool::Crop {
        editor.canvas.marked = None;
    }
    if editor.tool == Tool::Fill
        && let Some([x, y]) = inside_image(&before, place)
        && before.pixel(x, y) != editor.colour
    {
        let mut image = before.clone();
        let size = [image.width() as i32, image.height() as i32];
        let value = |[x, y]: [i32; 2]| before.pixel(x as usize, y as usize);
        for run in connected(size, place, value) {
            let cols = run.cols.start as usize..run.cols.end as usize;
            image.fill_row(run.row as usize, cols, editor.colour);
        }
        put(chart, image);
    }
    editor.canvas.gesture = Some(Gesture {
        tool: editor.tool,
        start: place,
        last: place,
        before,
        by_keys,
    });
}

fn go_on(editor: &mut ChartEditor, design: &mut Design, place: [i32; 2], shift: bool) {
    let chart = &mut design.chart;
    let Some(gesture) = &mut editor.canvas.gesture else {
        return;
    };
    let wide = |[x, y]: [i32; 2]| [i64::from(x), i64::from(y)];
    let (size, colour) = (editor.brush, editor.colour);
    let start = gesture.start;
    let is_new = gesture.last != place || gesture.start == place;
    match gesture.tool {
        Tool::Pencil if is_new => {
            if let Some(image) = &chart.pixels {
                let mut image = image.clone();
                draw_line(&mut image, wide(gesture.last), wide(place), size, colour);
                put_if_painted(chart, image);
            }
        }
        Tool::Line if is_new => {
            let end = if shift {
                straightened(start, place)
            } else {
                place
            };
            let mut image = gesture.before.clone();
            draw_line(&mut image, wide(start), wide(end), size, colour);
            put_if_painted(chart, image);
        }
        Tool::Rectangle | Tool::FilledRectangle if is_new => {
            let end = if shift { squared(start, place) } else { place };
            let mut image = gesture.before.clone();
            if gesture.tool == Tool::Rectangle {
                outline_rectangle(&mut image, [wide(start), wide(end)], size, colour);
            } else {
                let sides = [0, 1].map(|k| {
                    let (low, high) = (start[k].min(end[k]), start[k].max(end[k]) + 1);
                    low.max(0) as usize..high.max(0) as usize
                });
                let [xs, ys] = sides;
                image.fill_rectangle(xs, ys, colour);
            }
            put_if_painted(chart, image);
        }
        Tool::Crop => {
            let end = if shift { squared(start, place) } else { place };
            // A click without a drag marks nothing.
            editor.canvas.marked = (start != end).then_some([start, end]);
        }
        Tool::Pick => {
            gesture.last = place;
            pick(editor, design, place);
            return;
        }
        _ => {}
    }
    gesture.last = place;
}

/// Makes painted pixels the chart's, unless none of them is another than before: a chart that is painted with the
/// colours it has is still the imported one.
fn put_if_painted(chart: &mut Chart, mut image: ChartImage) {
    if let Some(now) = &chart.pixels {
        image.share_with(now);
        if image.is(now) {
            return;
        }
    }
    put(chart, image);
}

fn put_back(chart: &mut Chart, gesture: &Gesture) {
    put_if_painted(chart, gesture.before.clone());
}

/// Ends the gesture that is under way, if it is one by keys or one by pointer.
fn end(editor: &mut ChartEditor, by_keys: bool) {
    if editor
        .canvas
        .gesture
        .as_ref()
        .is_some_and(|g| g.by_keys == by_keys)
    {
        editor.canvas.gesture = None;
    }
}

fn paint(
    ui: &Ui,
    editor: &mut ChartEditor,
    response: &Response,
    design: &Design,
    view: &View,
    hovered: Option<[i32; 2]>,
) {
    let (chart, sheet, placement) = (&design.chart, &design.sheet, view.placement);
    let Some(seen) = editor.composer.chart(design).pixels else {
        return;
    };
    let rect = response.rect;
    let painter = ui.painter_at(rect);
    painter.rect_filled(rect, 0.0, style::viewport_ground(ui.visuals()));
    let size = view.canvas.size.map(|side| side as f32);
    let shown = Placement {
        corner: placement.corner,
        scale: placement.scale
            * vec2(
                size[0] / seen.width() as f32,
                size[1] / seen.height() as f32,
            ),
    };
    editor.canvas.pyramid.paint(&painter, &seen, shown);
    let whole = Rect::from_min_max(placement.at(0.0, 0.0), placement.at(size[0], size[1]));
    if editor.shows_grid {
        yarn_grid(&painter, chart, sheet, view, whole);
    }
    painter.rect_stroke(
        whole,
        0.0,
        ui.visuals().widgets.noninteractive.bg_stroke,
        StrokeKind::Outside,
    );
    let dark = Stroke::new(1.0, Color32::BLACK);
    let light = Stroke::new(1.0, Color32::WHITE);
    // In black and white, so that it is seen on every yarn.
    let outline = |rect: Rect| {
        painter.rect_stroke(rect, 0.0, light, StrokeKind::Outside);
        painter.rect_stroke(rect.expand(1.0), 0.0, dark, StrokeKind::Outside);
    };
    let span = |[a, b]: [[i32; 2]; 2]| {
        let low = [0, 1].map(|k| a[k].min(b[k]) as f32);
        let high = [0, 1].map(|k| a[k].max(b[k]) as f32 + 1.0);
        Rect::from_min_max(placement.at(low[0], low[1]), placement.at(high[0], high[1]))
    };
    if let Some(marked) = editor.canvas.marked {
        let shade = Color32::from_black_alpha(110);
        let kept = span(marked).intersect(whole);
        for part in [
            Rect::from_min_max(whole.min, pos2(whole.right(), kept.top())),
            Rect::from_min_max(pos2(whole.left(), kept.bottom()), whole.max),
            Rect::from_min_max(
                pos2(whole.left(), kept.top()),
                pos2(kept.left(), kept.bottom()),
            ),
            Rect::from_min_max(
                pos2(kept.right(), kept.top()),
                pos2(whole.right(), kept.bottom()),
            ),
        ] {
            painter.rect_filled(part, 0.0, shade);
        }
        outline(kept);
    }
    let brush = |[x, y]: [i32; 2]| {
        let size = match editor.tool {
            Tool::Pencil | Tool::Line | Tool::Rectangle => editor.brush as i32,
            _ => 1,
        };
        let before = (size - 1) / 2;
        span([
            [x - before, y - before],
            [x - before + size - 1, y - before + size - 1],
        ])
    };
    overlay::paint(ui, &painter, editor, chart, sheet, view);
    if response.has_focus() {
        painter.rect_stroke(
            rect,
            0.0,
            Stroke::new(1.0, style::accent(ui.visuals())),
            StrokeKind::Inside,
        );
    }
    if editor.tool.is_for_objects() {
        return;
    }
    match hovered {
        Some(place) => outline(brush(place)),
        None if response.has_focus() => outline(brush(editor.canvas.cursor)),
        None => {}
    }
}

/// Lines between the crossings of the cloth: of every one, or of every 10th or 100th where they would be too dense.
fn yarn_grid(painter: &egui::Painter, chart: &Chart, sheet: &Sheet, view: &View, whole: Rect) {
    let (size, placement) = (view.canvas.size.map(|side| side as f64), view.placement);
    let cells = match chart.fit {
        Fit::Stretch => [f64::from(sheet.warps), f64::from(sheet.wefts)],
        Fit::Tile | Fit::Place => size,
    };
    let shown = painter.clip_rect().intersect(whole);
    for axis in [0, 1] {
        let distance = size[axis] / cells[axis] * f64::from(placement.scale[axis]);
        let Some(every) = [1.0, 10.0, 100.0, 1000.0]
            .into_iter()
            .find(|every| distance * every >= f64::from(GRID_FROM))
        else {
            continue;
        };
        let distance = distance * every;
        let stroke = |alpha| Stroke::new(1.0, Color32::from_black_alpha(alpha));
        let light = Stroke::new(1.0, Color32::from_white_alpha(60));
        let (low, high, corner) = match axis {
            0 => (shown.left(), shown.right(), placement.corner.x),
            _ => (shown.top(), shown.bottom(), placement.corner.y),
        };
        let first = (f64::from(low - corner) / distance).floor().max(0.0) as u32;
        let last = (f64::from(high - corner) / distance).ceil().max(0.0) as u32;
        for k in first..=last {
            let at = corner + (f64::from(k) * distance) as f32;
            if at > high || at < low {
                continue;
            }
            // Every tenth stronger, for counting. Dark with a light line beside it is seen on every yarn.
            let dark = stroke(if k % 10 == 0 { 170 } else { 80 });
            if axis == 0 {
                painter.vline(at, shown.y_range(), dark);
                painter.vline(at + 1.0, shown.y_range(), light);
            } else {
                painter.hline(shown.x_range(), at, dark);
                painter.hline(shown.x_range(), at + 1.0, light);
            }
        }
    }
}
