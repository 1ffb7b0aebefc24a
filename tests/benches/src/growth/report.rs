//! What was found of growth: as CSV, Markdown and curves.

use std::fmt::Write as _;
use towel_designer::clock::{self, Spent};

use super::{Growth, Picture, Sheet};
use crate::conditions::Conditions;
use crate::csv::{OfPresets, number, optional, quoted, table};
use crate::drawing::patch_tests_per_ray;
use crate::plot::{Curve, Curves, Limit};
use crate::units::seconds;

/// Bytes that a loop may take.
const BYTES_PER_LOOP: f64 = 64.0;

const HEADER: &str = "preset,grows,loops,warps,wefts,width [px],height [px],compile clock time [s],compile processor \
    time [s],\
    compile [µs/loop],upload [s],sample clock time [s],sample processor time [s],sample cost [ns/px],patch tests \
    [1/ray],\
    scene [bytes],shapes looks lists and bounds [bytes/loop],held by the backend [bytes],turns";

/// The file.
pub fn csv(all: &OfPresets<'_, Option<Growth>>, conditions: &Conditions) -> String {
    let mut lines = Vec::new();
    for (preset, growth) in all {
        let preset = quoted(preset);
        let Some(growth) = growth else {
            continue;
        };
        let sheets = growth.loops.iter();
        lines.extend(sheets.map(|sheet| format!("{preset},loops,{}", of_sheet(sheet, conditions))));
        let pictures = growth.pixels.iter();
        lines.extend(
            pictures.map(|picture| format!("{preset},pixels,{}", of_picture(picture, conditions))),
        );
    }
    table(HEADER, lines)
}

/// Cost of a sample of a pixel, ns.
fn pixel_ns(sample: &Spent, size: [u32; 2], conditions: &Conditions) -> f64 {
    1e9 * sample.cost(conditions.backend) / (f64::from(size[0]) * f64::from(size[1]))
}

/// Time of a scene for each loop, µs: on all cores together where that is known.
fn loop_us(sheet: &Sheet) -> f64 {
    let time = sheet.compile.processor.unwrap_or(sheet.compile.wall);
    1e6 * time.as_secs_f64() / sheet.loops.max(1) as f64
}

fn of_sheet(sheet: &Sheet, conditions: &Conditions) -> String {
    let [warps, wefts] = sheet.yarns;
    let [width, height] = conditions.size;
    let fields = [
        sheet.loops.to_string(),
        warps.to_string(),
        wefts.to_string(),
        width.to_string(),
        height.to_string(),
        number(sheet.compile.wall.as_secs_f64()),
        optional(sheet.compile.processor.map(|time| time.as_secs_f64())),
        number(loop_us(sheet)),
        number(sheet.upload.as_secs_f64()),
        number(sheet.sample.wall.as_secs_f64()),
        optional(sheet.sample.processor.map(|time| time.as_secs_f64())),
        number(pixel_ns(&sheet.sample, conditions.size, conditions)),
        number(patch_tests_per_ray(&sheet.counters)),
        sheet.scene_bytes.to_string(),
        number(sheet.bytes_per_loop),
        sheet.backend_bytes.to_string(),
        sheet.turns.to_string(),
    ];
    fields.join(",")
}

fn of_picture(picture: &Picture, conditions: &Conditions) -> String {
    let [width, height] = picture.size;
    let sample = &picture.sample;
    format!(
        ",,,{width},{height},,,,,{},{},{},,,,,{}",
        number(sample.wall.as_secs_f64()),
        optional(sample.processor.map(|time| time.as_secs_f64())),
        number(pixel_ns(sample, picture.size, conditions)),
        picture.turns,
    )
}

/// How much dearer the last is than the one before for each that there are more of, as for 4 times as many.
fn for_four_times(before: [f64; 2], last: [f64; 2]) -> f64 {
    let exponent = (last[1] / before[1]).ln() / (last[0] / before[0]).ln();
    4.0_f64.powf(exponent)
}

/// The section of the summary.
pub fn section(growth: &Growth, conditions: &Conditions) -> String {
    let mut text = String::new();
    if !growth.loops.is_empty() {
        text += "\n| loops | yarns | compile, by the clock | µs a loop, all cores | upload | a sample | patch tests a \
            ray | bytes a loop | scene | held by the backend |\n\
                 | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n";
    }
    for sheet in &growth.loops {
        let _ = writeln!(
            text,
            "| {} | {} × {} | {} | {:.2} | {} | {} | {:.2} | {:.1} | {:.1} MB | {:.1} MB |",
            sheet.loops,
            sheet.yarns[0],
            sheet.yarns[1],
            seconds(sheet.compile.wall.as_secs_f64()),
            loop_us(sheet),
            seconds(sheet.upload.as_secs_f64()),
            seconds(sheet.sample.cost(conditions.backend)),
            patch_tests_per_ray(&sheet.counters),
            sheet.bytes_per_loop,
            sheet.scene_bytes as f64 / 1e6,
            sheet.backend_bytes as f64 / 1e6,
        );
    }
    let costs = growth
        .loops
        .iter()
        .map(|sheet| [sheet.loops as f64, sheet.sample.cost(conditions.backend)]);
    let costs: Vec<[f64; 2]> = costs.collect();
    for pair in costs.windows(2) {
        let _ = writeln!(
            text,
            "\nFrom {} to {} loops, a sample with 4 times the loops takes {:.2} times as long.",
            pair[0][0],
            pair[1][0],
            for_four_times(pair[0], pair[1])
        );
    }
    if !growth.pixels.is_empty() {
        text += "\n| pixels | a sample | ns a pixel |\n| --- | --- | --- |\n";
    }
    for picture in &growth.pixels {
        let [width, height] = picture.size;
        let _ = writeln!(
            text,
            "| {width} × {height} | {} | {:.0} |",
            seconds(picture.sample.cost(conditions.backend)),
            pixel_ns(&picture.sample, picture.size, conditions),
        );
    }
    text
}

/// The plots, each with the end of its file's name.
pub fn plots(
    preset: &str,
    conditions: &Conditions,
    growth: &Growth,
) -> Vec<(&'static str, Curves)> {
    let curve = |name: &str, points: Vec<[f64; 2]>| Curve {
        name: name.into(),
        points,
    };
    let by_loops = |name: &str, value: &dyn Fn(&Sheet) -> f64| {
        let point = |sheet: &Sheet| [sheet.loops as f64, value(sheet)];
        curve(name, growth.loops.iter().map(point).collect())
    };
    let cost = |spent: &Spent| spent.cost(conditions.backend);
    let time = if clock::cost_is_processor_time(conditions.backend) {
        "processor time of all cores [s]"
    } else {
        "time [s]"
    };
    let mut plots = Vec::new();
    if !growth.loops.is_empty() {
        plots.push((
            "growth",
            Curves {
                title: format!("{preset}: time as the sheet grows"),
                under: conditions.to_string(),
                axes: ["loops".into(), time.into()],
                curves: vec![
                    by_loops("one sample", &|sheet| cost(&sheet.sample)),
                    by_loops("compile", &|sheet| {
                        let compile = &sheet.compile;
                        compile.processor.unwrap_or(compile.wall).as_secs_f64()
                    }),
                    by_loops("upload (clock)", &|sheet| sheet.upload.as_secs_f64()),
                ],
                limit: None,
                notes: vec![
                    "The camera moves away".into(),
                    "as the sheet grows: the".into(),
                    "same share of the picture".into(),
                    "is cloth.".into(),
                ],
            },
        ));
        plots.push((
            "memory",
            Curves {
                title: format!("{preset}: memory as the sheet grows"),
                under: conditions.to_string(),
                axes: ["loops".into(), "bytes a loop".into()],
                curves: vec![
                    by_loops("shapes, looks, lists", &|sheet| sheet.bytes_per_loop),
                    by_loops("scene with volumes", &|sheet| {
                        sheet.scene_bytes as f64 / sheet.loops as f64
                    }),
                ],
                limit: Some(Limit {
                    name: format!("{BYTES_PER_LOOP} bytes a loop"),
                    value: BYTES_PER_LOOP,
                }),
                notes: vec![
                    "Volumes are as large for".into(),
                    "few loops as for many.".into(),
                ],
            },
        ));
    }
    if !growth.pixels.is_empty() {
        let point = |picture: &Picture| {
            let [width, height] = picture.size.map(f64::from);
            [width * height, cost(&picture.sample)]
        };
        plots.push((
            "pixels",
            Curves {
                title: format!("{preset}: time as the picture grows"),
                under: conditions.to_string(),
                axes: ["pixels".into(), time.into()],
                curves: vec![curve(
                    "one sample",
                    growth.pixels.iter().map(point).collect(),
                )],
                limit: None,
                notes: Vec::new(),
            },
        ));
    }
    plots
}
