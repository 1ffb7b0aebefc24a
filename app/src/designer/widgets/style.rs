//! The look of the designer: two neutral themes (so that no tint of the window colours the eye's judgement of a cloth),
//! one muted accent, small regular spacing. Everything that has a colour of its own in the window gets it here.

use egui::style::{ScrollStyle, Selection, WidgetVisuals, Widgets};
use egui::{
    Color32, Context, CornerRadius, FontFamily, FontId, Frame, Margin, Shadow, Stroke, Style,
    TextStyle, Theme, Visuals, vec2,
};

/// Height of a row of a panel, points.
pub const ROW_HEIGHT: f32 = 21.0;
/// Width of the label in front of a panel's control, points.
pub const LABEL_WIDTH: f32 = 104.0;
/// Width of the typed value behind a slider, points.
pub const VALUE_WIDTH: f32 = 62.0;
/// Width of the unit behind a typed value, points.
pub const UNIT_WIDTH: f32 = 62.0;

/// The colours of one theme.
#[derive(Debug, Clone, Copy)]
struct Palette {
    /// Panels, bars.
    panel: Color32,
    /// Windows and menus.
    raised: Color32,
    /// Text fields, slider rails, the ground of grids and curves.
    sunken: Color32,
    /// Buttons at rest, under the pointer, pressed.
    button: [Color32; 3],
    /// What is left of a slider's rail, and the handle of a scroll bar.
    rail: Color32,
    /// Lines between parts.
    line: Color32,
    /// Outline of controls.
    outline: Color32,
    /// Text, and the text of things that matter less.
    text: Color32,
    weak_text: Color32,
    strong_text: Color32,
    /// Ground of what is chosen or on.
    chosen: Color32,
    /// Text on it, and the outline of a text field that is typed in.
    on_chosen: Color32,
    /// Lines that matter: curves, focus, links.
    accent: Color32,
    warning: Color32,
    error: Color32,
}

const DARK: Palette = Palette {
    panel: Color32::from_rgb(0x27, 0x28, 0x29),
    raised: Color32::from_rgb(0x30, 0x31, 0x33),
    sunken: Color32::from_rgb(0x1a, 0x1b, 0x1c),
    button: [
        Color32::from_rgb(0x3a, 0x3c, 0x3e),
        Color32::from_rgb(0x48, 0x4a, 0x4d),
        Color32::from_rgb(0x55, 0x58, 0x5c),
    ],
    rail: Color32::from_rgb(0x4c, 0x4e, 0x51),
    line: Color32::from_rgb(0x3b, 0x3d, 0x3f),
    outline: Color32::from_rgb(0x4a, 0x4c, 0x4f),
    text: Color32::from_rgb(0xd6, 0xd7, 0xd8),
    weak_text: Color32::from_rgb(0xa2, 0xa4, 0xa7),
    strong_text: Color32::from_rgb(0xf4, 0xf4, 0xf4),
    chosen: Color32::from_rgb(0x35, 0x6d, 0x94),
    on_chosen: Color32::from_rgb(0xe2, 0xf1, 0xfc),
    accent: Color32::from_rgb(0x6f, 0xb1, 0xdc),
    warning: Color32::from_rgb(0xe6, 0xb4, 0x5c),
    error: Color32::from_rgb(0xf0, 0x8a, 0x7c),
};

const LIGHT: Palette = Palette {
    panel: Color32::from_rgb(0xf1, 0xf1, 0xf0),
    raised: Color32::from_rgb(0xfb, 0xfb, 0xfa),
    sunken: Color32::from_rgb(0xff, 0xff, 0xff),
    button: [
        Color32::from_rgb(0xe2, 0xe3, 0xe3),
        Color32::from_rgb(0xd3, 0xd5, 0xd6),
        Color32::from_rgb(0xc4, 0xc7, 0xc9),
    ],
    rail: Color32::from_rgb(0xc6, 0xc8, 0xc9),
    line: Color32::from_rgb(0xd4, 0xd5, 0xd5),
    outline: Color32::from_rgb(0xb9, 0xbb, 0xbc),
    text: Color32::from_rgb(0x2b, 0x2d, 0x2f),
    weak_text: Color32::from_rgb(0x5e, 0x61, 0x64),
    strong_text: Color32::from_rgb(0x0c, 0x0d, 0x0e),
    chosen: Color32::from_rgb(0x9f, 0xc8, 0xe6),
    on_chosen: Color32::from_rgb(0x0c, 0x43, 0x6b),
    accent: Color32::from_rgb(0x2c, 0x6d, 0x9b),
    warning: Color32::from_rgb(0x8a, 0x5a, 0x00),
    error: Color32::from_rgb(0xb3, 0x2a, 0x1c),
};

/// Gives `ctx` the designer's look in both themes.
pub fn apply(ctx: &Context) {
    ctx.set_style_of(Theme::Dark, style(&DARK, Visuals::dark()));
    ctx.set_style_of(Theme::Light, style(&LIGHT, Visuals::light()));
}

/// Frame of a dialog that stands before everything else.
pub fn dialog(ctx: &Context) -> Frame {
    Frame::window(&ctx.global_style()).inner_margin(Margin::same(14))
}

/// Ground of the area that shows the picture, where no picture is.
pub fn viewport_ground(visuals: &Visuals) -> Color32 {
    if visuals.dark_mode {
        Color32::from_gray(0x50)
    } else {
        Color32::from_gray(0xb4)
    }
}

/// Colour of lines that matter: curves, the outline of what has the keyboard's focus.
pub fn accent(visuals: &Visuals) -> Color32 {
    visuals.hyperlink_color
}

/// Outline of a box or circle that can be switched on: three times as light or dark as what is around it, in panels and
/// in windows.
pub fn mark_outline(visuals: &Visuals) -> Color32 {
    if visuals.dark_mode {
        Color32::from_gray(0x88)
    } else {
        Color32::from_gray(0x80)
    }
}

fn style(palette: &Palette, base: Visuals) -> Style {
    let mut style = Style {
        visuals: visuals(palette, base),
        animation_time: 0.08,
        explanation_tooltips: false,
        ..Style::default()
    };
    style.text_styles = [
        (TextStyle::Heading, 15.0, FontFamily::Proportional),
        (TextStyle::Body, 12.5, FontFamily::Proportional),
        (TextStyle::Button, 12.5, FontFamily::Proportional),
        (TextStyle::Small, 11.0, FontFamily::Proportional),
        (TextStyle::Monospace, 12.0, FontFamily::Monospace),
    ]
    .map(|(name, size, family)| (name, FontId::new(size, family)))
    .into();
    style.drag_value_text_style = TextStyle::Body;
    let spacing = &mut style.spacing;
    spacing.item_spacing = vec2(6.0, 4.0);
    spacing.button_padding = vec2(7.0, 2.0);
    spacing.interact_size = vec2(36.0, ROW_HEIGHT);
    spacing.indent = 12.0;
    spacing.icon_width = 14.0;
    spacing.icon_width_inner = 8.0;
    spacing.slider_rail_height = 4.0;
    spacing.combo_width = 60.0;
    spacing.menu_margin = Margin::same(5);
    spacing.window_margin = Margin::same(12);
    spacing.tooltip_width = 320.0;
    spacing.scroll = ScrollStyle {
        bar_width: 8.0,
        floating_allocated_width: 8.0,
        ..ScrollStyle::thin()
    };
    style
}

fn visuals(palette: &Palette, base: Visuals) -> Visuals {
    let radius = CornerRadius::same(4);
    let widget = |fill: Color32, outline: Color32, text: Color32| WidgetVisuals {
        bg_fill: fill,
        weak_bg_fill: fill,
        bg_stroke: Stroke::new(1.0, outline),
        corner_radius: radius,
        fg_stroke: Stroke::new(1.2, text),
        expansion: 0.0,
    };
    let [rest, over, pressed] = palette.button;
    let mut text_cursor = base.text_cursor;
    // A blinking cursor would draw the whole window twice a second for ever.
    text_cursor.blink = false;
    let shadow = Shadow {
        offset: [0, 4],
        blur: 14,
        spread: 0,
        color: Color32::from_black_alpha(if base.dark_mode { 110 } else { 50 }),
    };
    Visuals {
        weak_text_color: Some(palette.weak_text),
        widgets: Widgets {
            noninteractive: widget(palette.panel, palette.line, palette.text),
            inactive: WidgetVisuals {
                bg_fill: palette.rail,
                ..widget(rest, palette.line, palette.text)
            },
            hovered: widget(over, palette.outline, palette.strong_text),
            active: widget(pressed, palette.accent, palette.strong_text),
            open: widget(over, palette.outline, palette.strong_text),
        },
        selection: Selection {
            bg_fill: palette.chosen,
            stroke: Stroke::new(1.2, palette.on_chosen),
        },
        hyperlink_color: palette.accent,
        faint_bg_color: palette.raised,
        extreme_bg_color: palette.sunken,
        text_edit_bg_color: Some(palette.sunken),
        code_bg_color: palette.sunken,
        warn_fg_color: palette.warning,
        error_fg_color: palette.error,
        window_corner_radius: CornerRadius::same(6),
        menu_corner_radius: CornerRadius::same(5),
        window_shadow: shadow,
        popup_shadow: shadow,
        window_fill: palette.raised,
        window_stroke: Stroke::new(1.0, palette.outline),
        panel_fill: palette.panel,
        slider_trailing_fill: true,
        indent_has_left_vline: false,
        text_cursor,
        ..base
    }
}
