//! What the measurements say, as Markdown: the largest cost, which setting to take for an error, which are never worth
//! it, and what each method costs and lacks.

use std::fmt::Write as _;

use renderer_core::design::{Method, Sampler};
use renderer_core::render::{Counters, Optimisation};
use towel_designer::clock;

use crate::conditions::Conditions;
use crate::measure::{Character, Findings, Row, points};
use crate::measured::Measured;
use crate::pareto::{self, Point};
use crate::plan::TRUTH;
use crate::truth::Known;
use crate::units::seconds;
use crate::{backends, costs, distances, first_picture, growth, optimisations, variants};

/// Errors for which the best setting is named, relRMSE.
const WANTED: [f64; 4] = [0.5, 0.2, 0.1, 0.05];

/// The file.
pub fn write(conditions: &Conditions, all: &[Measured]) -> String {
    let time = if clock::cost_is_processor_time(conditions.backend) {
        "processor time, of all cores together"
    } else {
        "time by the clock"
    };
    let mut text = format!(
        "# What it costs\n\n{conditions}, {} s a preset. Times are {time}, unless said otherwise.\n",
        conditions.budget.as_secs_f64(),
    );
    for measured in all {
        text += &largest_cost(conditions, measured);
    }
    if all.iter().any(|measured| !measured.findings.is_empty()) {
        text += "\nErrors are relRMSE against a converged truth, that one's own noise taken out; an error below that \
            noise is not \
                 known any better.\n";
    }
    for measured in all {
        for findings in &measured.findings {
            text += &section(conditions, &measured.name, findings);
        }
        text += &parts(conditions, measured);
    }
    text
}

/// Which stage between an edit and a whole picture is the dearest.
fn largest_cost(conditions: &Conditions, measured: &Measured) -> String {
    let Some(largest) = costs::largest(&measured.costs) else {
        return String::new();
    };
    let [width, height] = conditions.window;
    format!(
        "\n{}: the largest remaining cost is **{}**: {:.0} % of the time from an edit of all loops to one sample of a \
            picture of \
         {width} × {height} pixels.\n",
        measured.name,
        largest.stage,
        100.0 * largest.share,
    )
}

/// The sections of everything but run time against error.
fn parts(conditions: &Conditions, measured: &Measured) -> String {
    let mut text = String::new();
    let mut add = |title: &str, section: String| {
        let _ = write!(text, "\n## {}: {title}\n{section}", measured.name);
    };
    if !measured.optimisations.is_empty() {
        add(
            "with and without each optimisation",
            optimisations::section(&measured.optimisations),
        );
    }
    if !measured.backends.is_empty() {
        add("each backend", backends::section(&measured.backends));
    }
    if let Some(growth) = &measured.growth {
        add("growth", growth::section(growth, conditions));
    }
    if !measured.lights.is_empty() {
        let section = variants::section("light", &measured.lights, conditions);
        add("each kind of light", section);
    }
    if !measured.piles.is_empty() {
        let section = variants::section("pile", &measured.piles, conditions);
        add("each kind of pile, and each finish", section);
    }
    if !measured.forms.is_empty() {
        let section = variants::section("form", &measured.forms, conditions);
        add("each form", section);
    }
    if !measured.distances.is_empty() {
        let section = distances::section(&measured.distances);
        add("a large cloth from farther and farther", section);
    }
    if let Some(found) = &measured.first_pictures {
        let section = first_picture::section(found);
        add("from an edit to its first picture", section);
    }
    if !measured.costs.is_empty() {
        let section = costs::section(&measured.costs);
        add("from an edit of all loops to a whole picture", section);
    }
    text
}

fn section(conditions: &Conditions, preset: &str, findings: &Findings) -> String {
    let (target, truth) = (&findings.target, &findings.truth);
    let is_choice = |row: &&Row| target.settings[row.setting].is_choice();
    let rows: Vec<&Row> = findings.rows.iter().filter(is_choice).collect();
    let points = points(conditions, &rows, truth.noise);
    let mut text = format!(
        "\n## {preset}: {}\n\nTruth: `{}`, 2 halves of {} and {} samples; its own noise is {:.4}, FLIP between its \
            halves {:.3}.\n\n",
        target.name(),
        TRUTH.name(),
        truth.samples[0],
        truth.samples[1],
        truth.noise,
        truth.flip_between_halves,
    );
    text += &best(findings, &rows, &points);
    text += &dominated(findings, &rows, &points);
    text += &costs(conditions, findings);
    text += &to_errors(conditions, findings);
    text
}

fn setting_name(findings: &Findings, index: usize) -> String {
    findings.target.settings[index].name(&findings.target)
}

/// The Pareto-best setting for each wanted error.
fn best(findings: &Findings, rows: &[&Row], points: &[Point]) -> String {
    let noise = findings.truth.noise;
    let mut text = String::from(
        "| error wanted | cheapest setting | samples | time | its error | its FLIP |\n| --- | --- | --- | --- | --- | \
            --- |\n",
    );
    for wanted in WANTED {
        let line = match pareto::cheapest(points, wanted) {
            Some(index) => {
                let row = rows[index];
                format!(
                    "{} | {} | {} | {} | {:.3}",
                    setting_name(findings, row.setting),
                    row.samples,
                    seconds(points[index].cost),
                    error(row.error, noise),
                    row.flip,
                )
            }
            None if wanted < noise => "not known: below the truth's noise | | | |".into(),
            None => "none in this time | | | |".into(),
        };
        let _ = writeln!(text, "| {wanted} | {line} |");
    }
    text
}

/// Settings without a place on the Pareto front.
fn dominated(findings: &Findings, rows: &[&Row], points: &[Point]) -> String {
    let mut text = String::new();
    let mut missing = Vec::new();
    for (index, setting) in findings.target.settings.iter().enumerate() {
        if !setting.is_choice() {
            continue;
        }
        let group: Vec<usize> = (0..points.len())
            .filter(|&row| rows[row].setting == index)
            .collect();
        if group.is_empty() {
            missing.push(setting_name(findings, index));
        } else if let Some(factor) = pareto::domination(points, &group) {
            let name = setting_name(findings, index);
            let _ = writeln!(
                text,
                "- {name}: another gives the same error in 1/{factor:.1} of the time, or less"
            );
        }
    }
    if text.is_empty() {
        text = "- none\n".into();
    }
    text.insert_str(
        0,
        "\nDominated (another setting is cheaper and no worse, at any number of samples):\n\n",
    );
    if !missing.is_empty() {
        let _ = writeln!(
            text,
            "\nNot measured, since time was up: {}.",
            missing.join("; ")
        );
    }
    text
}

/// Pictures drawn up to error targets, with tiles that end before the picture and without.
fn to_errors(conditions: &Conditions, findings: &Findings) -> String {
    let settings = &findings.target.settings;
    let rows = |is_with: bool| -> Vec<&Row> {
        let is_side = |row: &&Row| {
            let setting = &settings[row.setting];
            setting.to_error && setting.without.is_none() == is_with
        };
        findings.rows.iter().filter(is_side).collect()
    };
    let [with, without] = [true, false].map(rows);
    let pairs: Vec<[&Row; 2]> = with
        .iter()
        .filter_map(|row| {
            let other = without.iter().find(|other| other.wanted == row.wanted)?;
            Some([*row, *other])
        })
        .collect();
    if pairs.is_empty() {
        return String::new();
    }
    let optimisation = Optimisation::ConvergedTiles;
    let mut text = format!(
        "\n| error target | time with `{optimisation}` | without | without : with | its error with | without | most \
         samples \
            with | without |\n\
         | --- | --- | --- | --- | --- | --- | --- | --- |\n",
    );
    for pair in pairs {
        let costs = pair.map(|row| row.spent.cost(conditions.backend));
        let errors = pair.map(|row| error(row.error, findings.truth.noise));
        let _ = writeln!(
            text,
            "| {:.4} | {} | {} | {:.2} | {} | {} | {} | {} |",
            pair[0].wanted.unwrap_or_default(),
            seconds(costs[0]),
            seconds(costs[1]),
            costs[1] / costs[0].max(1e-9),
            errors[0],
            errors[1],
            pair[0].samples,
            pair[1].samples,
        );
    }
    text
}

/// Cost ratios of the methods, dearest first, and what each lacks.
fn costs(conditions: &Conditions, findings: &Findings) -> String {
    let of = |method| {
        let mut settings = findings.target.settings.iter();
        let index = settings.position(|setting| {
            (setting.method, setting.sampler, setting.shadows) == (method, Sampler::Owen, true)
                && setting.is_whole(&findings.target)
                && setting.is_choice()
        })?;
        let character = &findings.characters[index];
        Cost::new(method, character, conditions)
    };
    let mut costs: Vec<Cost> = Method::ALL.iter().copied().filter_map(of).collect();
    costs.sort_by(|a, b| b.seconds.total_cmp(&a.seconds));
    let single = costs
        .iter()
        .find(|cost| cost.method == Method::Single)
        .cloned();
    let Some(single) = single else {
        return String::new();
    };
    let mut text = String::from(
        "\n| method | time a sample | times single | patch tests a ray | volume samples a ray | own bias |\n\
         | --- | --- | --- | --- | --- | --- |\n",
    );
    for cost in &costs {
        let _ = writeln!(
            text,
            "| {} | {} | {:.2} | {:.1} | {:.1} | {} |",
            cost.method.name(),
            seconds(cost.seconds),
            cost.seconds / single.seconds,
            cost.patch_tests,
            cost.volume_samples,
            cost.bias,
        );
    }
    let names: Vec<String> = costs.iter().map(|cost| cost.method.name()).collect();
    let ratio = |value: fn(&Cost) -> f64| {
        let ratios = costs
            .iter()
            .map(|cost| format!("{:.2}", value(cost) / value(&single)));
        ratios.collect::<Vec<_>>().join(" : ")
    };
    let _ = writeln!(
        text,
        "\n{} = {} in time, {} in patch tests and {} in volume samples a ray.",
        names.join(" : "),
        ratio(|cost| cost.seconds),
        ratio(|cost| cost.patch_tests),
        ratio(|cost| cost.volume_samples),
    );
    if let Some(bare) = findings.bare {
        let times: Vec<String> = costs
            .iter()
            .map(|cost| {
                let times = cost.seconds / bare.as_secs_f64().max(1e-9);
                format!("{} {times:.0}", cost.method.name())
            })
            .collect();
        let _ = writeln!(
            text,
            "\nA dispatch of the same size that makes rays and writes sums, and traces nothing, takes {:.3} ms a \
                sample. A sample \
             takes so many times that: {}.",
            bare.as_secs_f64() * 1e3,
            times.join(", "),
        );
    }
    text
}

/// What a method costs.
#[derive(Debug, Clone)]
struct Cost {
    method: Method,
    seconds: f64,
    patch_tests: f64,
    volume_samples: f64,
    bias: String,
}

impl Cost {
    fn new(method: Method, character: &Character, conditions: &Conditions) -> Option<Self> {
        let Counters {
            rays,
            shadow_rays,
            patch_tests,
            volume_samples,
            ..
        } = character.counters?;
        let rays = (rays + shadow_rays).max(1) as f64;
        Some(Self {
            method,
            seconds: character.per_sample?.cost(conditions.backend),
            patch_tests: patch_tests as f64 / rays,
            volume_samples: volume_samples as f64 / rays,
            bias: character
                .bias
                .map_or_else(|| "not measured".into(), |bias| bias.to_string()),
        })
    }
}

fn error(error: Known, noise: f64) -> String {
    match error {
        Known::Error(error) => format!("{error:.3}"),
        Known::BelowNoise => format!("below {noise:.3}"),
    }
}
