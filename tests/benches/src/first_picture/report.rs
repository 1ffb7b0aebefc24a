//! What was found of first pictures: as CSV, Markdown and bars.

use std::fmt::Write as _;
use towel_designer::clock;

use super::{Edit, FirstPictures, PROCESSOR, WALL, middle};
use crate::coarse_preview::FirstPicture;
use crate::conditions::Conditions;
use crate::csv::{OfPresets, optional, quoted, table};
use crate::plot::{Bar, Bars};
use crate::units::seconds;

/// Share of a whole sample's time that a first picture may take.
const SHARE: f64 = 0.1;

const HEADER: &str = "preset,edit,window width [px],window height [px],picture width [px],picture height [px],round,\
    clock time [s],processor time [s],clock time : whole sample,processor time : whole sample,\
    whole sample clock time [s],whole sample processor time [s]";

/// The file: a row for each first picture; whole samples are the middle of all.
pub fn csv(all: &OfPresets<'_, Option<FirstPictures>>) -> String {
    let mut lines = Vec::new();
    for (preset, found) in all {
        let Some(found) = found else {
            continue;
        };
        let [width, height] = found.window;
        let wholes = [WALL, PROCESSOR].map(|clock| found.whole_sample(clock));
        for (edit, pictures) in &found.edits {
            for (round, picture) in pictures.iter().enumerate() {
                let times = [WALL, PROCESSOR].map(|clock| clock(&picture.spent));
                let share = |index: usize| Some(times[index]? / wholes[index]?);
                let mut fields = vec![
                    quoted(preset),
                    edit.name().into(),
                    width.to_string(),
                    height.to_string(),
                    picture.size[0].to_string(),
                    picture.size[1].to_string(),
                    (round + 1).to_string(),
                ];
                fields.extend(times.map(optional));
                fields.extend([share(0), share(1)].map(optional));
                fields.extend(wholes.map(optional));
                lines.push(fields.join(","));
            }
        }
    }
    table(HEADER, lines)
}

/// The section of the summary.
pub fn section(found: &FirstPictures) -> String {
    let [width, height] = found.window;
    let mut text = String::new();
    match found.whole_sample(WALL) {
        Some(whole) => {
            let processor = found.whole_sample(PROCESSOR);
            let _ = writeln!(
                text,
                "\nOne sample of all {width} × {height} pixels takes {} by the clock and {} of processor time; a \
                    first picture is \
                 wanted in at most {SHARE} of that.",
                seconds(whole),
                processor.map_or_else(|| "–".into(), seconds),
            );
        }
        None => {
            let _ = writeln!(
                text,
                "\nTime was up before there was one sample of all {width} × {height} pixels."
            );
        }
    }
    text += "\n| edit | first picture | pixels | processor time | share by the clock | share of processor time | \
        edits |\n\
             | --- | --- | --- | --- | --- | --- | --- |\n";
    let share =
        |value: Option<f64>| value.map_or_else(|| "–".into(), |value| format!("{value:.3}"));
    for (edit, pictures) in &found.edits {
        let times = |clock| middle(pictures.iter().map(|picture| &picture.spent), clock);
        let Some((wall, last)) = times(WALL).zip(pictures.last()) else {
            let _ = writeln!(
                text,
                "| {} | not measured: time was up | | | | | |",
                edit.name()
            );
            continue;
        };
        let _ = writeln!(
            text,
            "| {} | {} | {} × {} | {} | {} | {} | {} |",
            edit.name(),
            seconds(wall),
            last.size[0],
            last.size[1],
            times(PROCESSOR).map_or_else(|| "–".into(), seconds),
            share(found.share(pictures, WALL)),
            share(found.share(pictures, PROCESSOR)),
            pictures.len(),
        );
    }
    // By either clock: the one on the wall is disturbed by other work, that of the processor does not see waiting.
    let late = found.edits.iter().filter(|(_, pictures)| {
        let shares = [WALL, PROCESSOR].map(|clock| found.share(pictures, clock));
        shares.into_iter().flatten().any(|share| share > SHARE)
    });
    let late: Vec<&str> = late.map(|(edit, _)| edit.name()).collect();
    let says = match &late[..] {
        [] if found.is_partial || found.whole.is_empty() => {
            "Time was up before every edit could be compared.".into()
        }
        [] => "By both clocks every edit is seen within that share.".into(),
        late => format!(
            "Later than that by one clock at least: {}.",
            late.join(", ")
        ),
    };
    let _ = writeln!(text, "\n{says}");
    text
}

/// Time to the first picture of each edit, as bars.
pub fn bars(preset: &str, conditions: &Conditions, found: &FirstPictures) -> Option<Bars> {
    if found.edits.iter().all(|(_, pictures)| pictures.is_empty()) {
        return None;
    }
    let (clock, axis) = match clock::cost_is_processor_time(conditions.backend) {
        true => (PROCESSOR, "processor time of all cores [ms]"),
        false => (WALL, "time by the clock [ms]"),
    };
    let whole = found.whole_sample(clock);
    let bar = |(edit, pictures): &(Edit, Vec<FirstPicture>)| {
        let time = middle(pictures.iter().map(|picture| &picture.spent), clock);
        let text = match (time, pictures.last()) {
            (Some(time), Some(last)) => {
                format!("{} ({} × {})", seconds(time), last.size[0], last.size[1])
            }
            _ => "not measured".into(),
        };
        Bar {
            name: edit.name().into(),
            value: time.map(|time| 1e3 * time),
            text,
        }
    };
    let [width, height] = found.window;
    Some(Bars {
        title: format!("{preset}: from an edit to its first picture"),
        under: format!(
            "window of {width} × {height} pixels, {} ({}); a whole sample {}",
            conditions.backend.name(),
            conditions.device,
            whole.map_or_else(
                || "was not measured".into(),
                |whole| format!("takes {}", seconds(whole))
            ),
        ),
        axis: axis.into(),
        bars: found.edits.iter().map(bar).collect(),
        limit: whole.map(|whole| (1e3 * SHARE * whole, "a tenth of a whole sample".into())),
        cut: None,
    })
}
