//! Where the pointer went within a frame.

use egui::{Event, PointerButton, Pos2, Response, Ui};

/// The places that the pointer came through in this frame while it held its primary button down on what `response` is of,
/// the press and the release included; the last of them is where the gesture stands now. Empty when there is no such
/// gesture.
///
/// A frame of a busy machine holds many moves: whoever took only the last would begin strokes late, cut their corners and
/// end them early.
pub fn pointer_way(ui: &Ui, response: &Response) -> Vec<Pos2> {
    let Some(now) = response.interact_pointer_pos() else {
        return Vec::new();
    };
    let mut way = Vec::new();
    ui.input(|i| {
        for event in &i.events {
            match *event {
                Event::PointerButton {
                    pos,
                    button: PointerButton::Primary,
                    pressed,
                    ..
                } => {
                    if pressed {
                        way.clear();
                    }
                    way.push(pos);
                    if !pressed {
                        // What comes after it belongs to no gesture.
                        break;
                    }
                }
                Event::PointerMoved(pos) => way.push(pos),
                _ => {}
            }
        }
    });
    if way.is_empty() {
        way.push(now);
    }
    way
}
