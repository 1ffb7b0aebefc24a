//! Run time against error as a table: a row for each setting and number of samples.

use renderer_core::render::Counters;

use crate::conditions::Conditions;
use crate::csv::{OfPresets, number, optional, quoted, table};
use crate::measure::{Findings, Row};
use crate::truth::Known;

const HEADER: &str = "preset,backend,width [px],height [px],bounces,method,sampler,shadows,setting bounces,traced \
    bounces,cached shadows,without optimisation,samples [1/px],error wanted [relRMSE],\
    clock time [s],processor time [s],error [relRMSE],error is below the truth's noise,measured error [relRMSE],\
    estimated noise [relRMSE],FLIP [0 to 1],rounds,truth's noise [relRMSE],FLIP between the truth's halves [0 to 1],\
    rays [1/sample],shadow rays [1/sample],cells [1/ray],patch tests [1/ray],volume samples [1/ray]";

/// The file.
pub fn csv(conditions: &Conditions, all: &OfPresets<'_, [Findings]>) -> String {
    let mut lines = Vec::new();
    for (preset, all) in all {
        for findings in *all {
            let rows = findings.rows.iter();
            lines.extend(rows.map(|row| line(conditions, preset, findings, row)));
        }
    }
    table(HEADER, lines)
}

fn line(conditions: &Conditions, preset: &str, findings: &Findings, row: &Row) -> String {
    let setting = &findings.target.settings[row.setting];
    let truth = &findings.truth;
    let [width, height] = conditions.size;
    let (error, below) = match row.error {
        Known::Error(error) => (number(error), "false"),
        Known::BelowNoise => (String::new(), "true"),
    };
    let mut fields = vec![
        quoted(preset),
        conditions.backend.name().into(),
        width.to_string(),
        height.to_string(),
        findings.target.bounces.to_string(),
        setting.method.name(),
        setting.sampler.name(),
        setting.shadows.to_string(),
        setting.bounces.to_string(),
        setting.traced_bounces.to_string(),
        setting.cached_shadows.to_string(),
        setting
            .without
            .map_or_else(String::new, |optimisation| optimisation.to_string()),
        row.samples.to_string(),
        optional(row.wanted),
        number(row.spent.wall.as_secs_f64()),
        optional(row.spent.processor.map(|time| time.as_secs_f64())),
        error,
        below.into(),
        number(row.measured),
        optional(row.estimate),
        number(row.flip),
        row.rounds.to_string(),
        number(truth.noise),
        number(truth.flip_between_halves),
    ];
    let counters = findings.characters[row.setting].counters;
    fields.extend(work(counters, f64::from(width * height)).map(optional));
    fields.join(",")
}

/// Rays and shadow rays a sample, then cells, patch tests and volume samples a ray of either kind.
fn work(counters: Option<Counters>, samples: f64) -> [Option<f64>; 5] {
    let Some(counters) = counters else {
        return [None; 5];
    };
    let rays = (counters.rays + counters.shadow_rays).max(1) as f64;
    [
        counters.rays as f64 / samples,
        counters.shadow_rays as f64 / samples,
        counters.cells as f64 / rays,
        counters.patch_tests as f64 / rays,
        counters.volume_samples as f64 / rays,
    ]
    .map(Some)
}
