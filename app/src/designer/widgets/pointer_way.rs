//! Where the pointer went within a frame.
//!
//! A frame of a busy machine holds many events: a press with moves after it, moves before a release, or all of them.
//! egui's responses say where the pointer is at its end; who painted by these alone would begin strokes late, cut their
//! corners, end them early, and miss short ones.

use egui::{Event, PointerButton, Pos2, Response, Ui};

/// What the pointer did in a frame with its primary button down.
#[derive(Debug, Default)]
pub struct PointerWay {
    /// Where it was, the places of press and release included. Empty if it did not hold what was asked about.
    pub places: Vec<Pos2>,
    /// Whether the button went down.
    pub begins: bool,
    /// Whether the button was let go.
    pub ends: bool,
}

impl PointerWay {
    /// The way of this frame over what `response` is of, from the press there on, or from the beginning where the
    /// button `is_down_already` since an earlier frame.
    pub fn new(ui: &Ui, response: &Response, is_down_already: bool) -> Self {
        let is_here = |at: Pos2| {
            let is_seen = ui.clip_rect().contains(at) && response.interact_rect.contains(at);
            ui.is_enabled() && is_seen && ui.ctx().layer_id_at(at) == Some(response.layer_id)
        };
        let events = ui.input(|i| i.events.clone());
        let mut way = Self::default();
        let mut is_down = is_down_already;
        for event in events {
            match event {
                Event::PointerButton {
                    pos,
                    button: PointerButton::Primary,
                    pressed,
                    ..
                } => {
                    if pressed && !is_down && is_here(pos) {
                        is_down = true;
                        way.begins = true;
                        way.places.push(pos);
                    } else if !pressed && is_down {
                        way.ends = true;
                        way.places.push(pos);
                        // What comes after it belongs to no gesture.
                        break;
                    }
                }
                Event::PointerMoved(pos) if is_down => way.places.push(pos),
                _ => {}
            }
        }
        if is_down_already && way.places.is_empty() {
            way.places.extend(ui.input(|i| i.pointer.interact_pos()));
        }
        // The window may have lost the pointer without a report of the release.
        way.ends |= is_down_already && !ui.input(|i| i.pointer.primary_down());
        way
    }
}
