//! What is allowed in a design and probably not meant: what a designer should know.

use super::chart_yarns::ChartYarns;
use super::cost::costs;
use super::{LoopCounts, Scene, SheetGeometry};
use crate::design::{Design, Filter, Warning};

/// A filter of this radius, in waves of the turbulence, still leaves a tenth of it.
const MAX_FILTER_WAVES: f64 = 0.75;

/// What a designer should know about a design and its scene.
///
/// `yarns` remembers what was counted for the design before: of a large chart only what was painted on is counted again.
pub fn warnings(design: &Design, scene: &Scene, yarns: &mut ChartYarns) -> Vec<Warning> {
    warnings_of_loops(design, &scene.sheet, scene.loops.counts, yarns)
}

/// What is known without making anything.
pub(super) fn warnings_of_design(design: &Design, yarns: &mut ChartYarns) -> Vec<Warning> {
    let mut warnings = design.warnings();
    warnings.extend(costs(design));
    warnings.extend(yarns.warning(design));
    warnings
}

/// What is known once the loops are made.
pub(super) fn warnings_of_loops(
    design: &Design,
    sheet: &SheetGeometry,
    counts: LoopCounts,
    yarns: &mut ChartYarns,
) -> Vec<Warning> {
    let mut warnings = warnings_of_design(design, yarns);
    if counts.planted == 0 {
        let text = "no loops: the pattern, the chart and the loop length leave none";
        warnings.push(Warning::new("weave.pattern", text));
    }
    let turbulence = &design.turbulence;
    let pitch_mm = sheet.pitch_x_mm.max(sheet.pitch_y_mm);
    let waves = turbulence.filter_radius * pitch_mm * turbulence.frequency;
    if turbulence.filter != Filter::None && waves > MAX_FILTER_WAVES {
        let text = format!(
            "the turbulence's filter reaches over {waves:.1} of its waves, more than {MAX_FILTER_WAVES}: \
             little of it is left but at the cloth's edges"
        );
        warnings.push(Warning::new("turbulence.filter_radius", text));
    }
    let mut tell = |count: u64, what: &str| {
        if count > 0 {
            let text = format!("{count} of {} loops {what}", counts.planted);
            warnings.push(Warning::new("pile", text));
        }
    };
    tell(counts.dropped, "were left out: their frame is degenerate");
    tell(
        counts.repaired,
        "have another top width than asked: their frame would cross itself",
    );
    warnings
}
