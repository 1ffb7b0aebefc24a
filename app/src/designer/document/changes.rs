//! Names what differs between two designs, for "Undo …": the history is a list of designs, the names are read off them.

use std::cmp::Ordering;

use renderer_core::design::{CameraDesign, ChartObject, Design, Numbers, WEAVE_LIBRARY};

use super::labels::label_of;

/// What a user would call the step from `before` to `after`: "pile density", "painted stitches", "open chart".
pub fn describe(before: &Design, after: &Design) -> String {
    let parts = [
        sheet(before, after),
        weave(before, after),
        chart(before, after),
        length(before, after),
        numbers("pile", &before.pile, &after.pile)
            .or_else(|| {
                other(
                    before.pile.phase != after.pile.phase,
                    "scattering of the pile",
                )
            })
            .or_else(|| other(before.pile != after.pile, "kind of pile")),
        numbers("turbulence", &before.turbulence, &after.turbulence)
            .or_else(|| other(before.turbulence != after.turbulence, "kind of turbulence")),
        numbers("finish", &before.finish, &after.finish)
            .or_else(|| other(before.finish != after.finish, "shorn faces")),
        numbers("nap", &before.nap, &after.nap)
            .or_else(|| other(before.nap.fit != after.nap.fit, "nap map layout"))
            .or_else(|| other(before.nap != after.nap, "nap map")),
        numbers("skeleton", &before.skeleton, &after.skeleton)
            .or_else(|| other(before.skeleton != after.skeleton, "look of the skeleton")),
        form(before, after),
        light(before, after),
        view(before, after),
        numbers("quality", &before.quality, &after.quality)
            .or_else(|| other(before.quality.method != after.quality.method, "method"))
            .or_else(|| other(before.quality.sampler != after.quality.sampler, "sampler"))
            .or_else(|| other(before.quality != after.quality, "shadows")),
    ];
    let mut parts = parts.into_iter().flatten();
    match (parts.next(), parts.next()) {
        (Some(only), None) => only,
        (Some(_), Some(_)) => "several changes".into(),
        (None, _) => "change".into(),
    }
}

fn other(differs: bool, name: &str) -> Option<String> {
    differs.then(|| name.into())
}

/// The first number of a section that differs.
fn numbers(section: &str, before: &impl Numbers, after: &impl Numbers) -> Option<String> {
    let (before, after) = (before.numbers(), after.numbers());
    let mut pairs = before.iter().zip(&after);
    let (_, (field, _)) = pairs.find(|((_, a), (_, b))| a != b)?;
    Some(format!("{section} {}", label_of(field.name).to_lowercase()))
}

fn sheet(before: &Design, after: &Design) -> Option<String> {
    numbers("sheet", &before.sheet, &after.sheet)
}

fn weave(before: &Design, after: &Design) -> Option<String> {
    let (a, b) = (&before.weave.pattern, &after.weave.pattern);
    if a == b {
        return other(before.weave.back != after.weave.back, "back of the cloth");
    }
    // Who paints the last cell of a ready pattern has painted.
    let one_cell = a.cols() == b.cols()
        && a.rows() == b.rows()
        && a.values()
            .iter()
            .zip(b.values())
            .filter(|(a, b)| a != b)
            .count()
            == 1;
    let ready = WEAVE_LIBRARY.iter().find(|ready| ready.pattern() == *b);
    if let (Some(ready), false) = (ready, one_cell) {
        return Some(format!("ready pattern {}", ready.name));
    }
    let is_shifted = || {
        [(1, 0), (-1, 0), (0, 1), (0, -1)]
            .iter()
            .any(|&(x, y)| a.shifted(x, y) == *b)
    };
    let name = if *b == a.mirrored_left_right() || *b == a.mirrored_near_far() {
        "mirrored pattern"
    } else if *b == a.turned() {
        "rotated pattern"
    } else if (a.cols(), a.rows()) != (b.cols(), b.rows()) {
        "pattern size"
    } else if is_shifted() {
        "shifted pattern"
    } else {
        "painted stitches"
    };
    Some(name.into())
}

fn chart(before: &Design, after: &Design) -> Option<String> {
    let (a, b) = (&before.chart, &after.chart);
    if a == b {
        return None;
    }
    if a.object != b.object {
        return Some(objects(&a.object, &b.object));
    }
    if a.yarn != b.yarn && a.pixels == b.pixels {
        return Some("yarn name".into());
    }
    if (&a.guides_x, &a.guides_y) != (&b.guides_x, &b.guides_y) {
        return Some("guide".into());
    }
    let name = match (&a.pixels, &b.pixels) {
        (None, Some(_)) => "open chart",
        (Some(_), None) => "clear chart",
        // What has a path was read from there.
        (Some(before), Some(after)) if before != after => match b.image {
            Some(_) => "open chart",
            None => "painted chart",
        },
        _ if a.colour != b.colour => "cloth colour",
        _ if (a.offset_x, a.offset_y) != (b.offset_x, b.offset_y) => "place of the chart",
        _ => "chart layout",
    };
    Some(name.into())
}

/// What was done with what lies on the chart.
fn objects(before: &[ChartObject], after: &[ChartObject]) -> String {
    let named = |verb: &str, object: Option<&ChartObject>| {
        let kind = object.map_or("objects", |object| object.kind.label());
        format!("{verb} {kind}")
    };
    match before.len().cmp(&after.len()) {
        Ordering::Less => {
            return named("add", after.iter().find(|object| !before.contains(object)));
        }
        Ordering::Greater => {
            return named(
                "remove",
                before.iter().find(|object| !after.contains(object)),
            );
        }
        Ordering::Equal => {}
    }
    let mut pairs = before.iter().zip(after).filter(|(a, b)| a != b);
    let (Some((a, b)), None) = (pairs.next(), pairs.next()) else {
        return "order of objects".into();
    };
    let is_moved = (a.x, a.y) != (b.x, b.y);
    let is_scaled = (a.width, a.height) != (b.width, b.height);
    let verb = match (is_moved, is_scaled) {
        _ if a.text != b.text || a.font != b.font => "write",
        (_, true) => "scale",
        (true, false) => "move",
        _ if a.rotation != b.rotation => "turn",
        _ if (a.colour, a.bare) != (b.colour, b.bare) => "colour of",
        _ => "change",
    };
    named(verb, Some(b))
}

fn length(before: &Design, after: &Design) -> Option<String> {
    let (a, b) = (&before.length, &after.length);
    numbers("loop length", a, b)
        .or_else(|| other(a.map != b.map, "loop length map"))
        .or_else(|| other(a.curve != b.curve, "loop length curve"))
        .or_else(|| {
            let is_one = a.table.len().abs_diff(b.table.len()) == 1;
            list("row of lengths", a.table.len(), b.table.len()).filter(|_| is_one)
        })
        .or_else(|| other(a.table != b.table, "table of lengths"))
}

fn form(before: &Design, after: &Design) -> Option<String> {
    let (a, b) = (&before.form, &after.form);
    let is_opened = a.pixels != b.pixels && b.pixels.is_some();
    other(is_opened, "open height picture")
        .or_else(|| numbers("form", a, b))
        .or_else(|| other(a.kind != b.kind, "form of the cloth"))
        .or_else(|| other(a.net != b.net, "net of points"))
        .or_else(|| other(a != b, "way the cloth is bent"))
}

fn light(before: &Design, after: &Design) -> Option<String> {
    let (a, b) = (&before.light, &after.light);
    list("sun", a.sun.len(), b.sun.len())
        .or_else(|| {
            let mut suns = a.sun.iter().zip(&b.sun);
            suns.find_map(|(a, b)| numbers("sun", a, b))
        })
        .or_else(|| other(a.sun != b.sun, "sun colour"))
        .or_else(|| list("area light", a.area.len(), b.area.len()))
        .or_else(|| {
            let mut areas = a.area.iter().zip(&b.area);
            areas.find_map(|(a, b)| numbers("area light", a, b))
        })
        .or_else(|| other(a.area != b.area, "area light colour"))
        .or_else(|| {
            let (a, b) = (&a.environment, &b.environment);
            other(
                a.pixels != b.pixels && b.pixels.is_some(),
                "open surroundings",
            )
        })
        .or_else(|| numbers("surroundings", &a.environment, &b.environment))
        .or_else(|| other(a.environment != b.environment, "surroundings"))
        .or_else(|| other(a.background != b.background, "background"))
}

fn view(before: &Design, after: &Design) -> Option<String> {
    let (a, b) = (&before.view, &after.view);
    cameras(&a.cameras, &b.cameras)
        .or_else(|| numbers("view", a, b))
        .or_else(|| other(a.metering != b.metering, "what exposure counts from"))
        .or_else(|| other(a.tone_map != b.tone_map, "tone map"))
}

fn cameras(before: &[CameraDesign], after: &[CameraDesign]) -> Option<String> {
    let lacks = |list: &[CameraDesign], name: &str| list.iter().all(|other| other.name != name);
    let not_in = |list: &[CameraDesign], of: &[CameraDesign]| {
        let found = of.iter().find(|camera| lacks(list, &camera.name));
        found.map_or_else(String::new, |camera| format!(" “{}”", camera.name))
    };
    match before.len().cmp(&after.len()) {
        Ordering::Less => return Some(format!("save view{}", not_in(before, after))),
        Ordering::Greater => return Some(format!("remove view{}", not_in(after, before))),
        Ordering::Equal => {}
    }
    let mut pairs = before.iter().zip(after).filter(|(a, b)| a != b);
    let (a, b) = pairs.next()?;
    if pairs.next().is_some() {
        return Some("order of views".into());
    }
    if a.name != b.name {
        return Some(format!("rename view “{}”", b.name));
    }
    let (old, new) = (a.numbers(), b.numbers());
    let changed = old.iter().zip(&new).filter(|((_, a), (_, b))| a != b);
    let others = a.target != b.target || a.orthographic_height != b.orthographic_height;
    if changed.count() == 1 && !others {
        return numbers("view", a, b);
    }
    Some(format!("set view “{}”", b.name))
}

fn list(what: &str, before: usize, after: usize) -> Option<String> {
    match before.cmp(&after) {
        Ordering::Less => Some(format!("add {what}")),
        Ordering::Equal => None,
        Ordering::Greater => Some(format!("remove {what}")),
    }
}
