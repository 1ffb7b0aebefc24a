//! The yarns that a design's chart asks for, counted in loops of its cloth, and what of the chart no loop shows.

use std::sync::Arc;

use super::{ChartComposer, ChartOnSheet};
use crate::design::chart_edit::{BARE, LoopsPerPixel, YarnCount, YarnCounts};
use crate::design::{Chart, ChartImage, Colour, Design, Fit, Warning, Weave};

/// Counts the yarns of a design's chart, and again what changed of them.
#[derive(Default)]
pub struct ChartYarns {
    composer: ChartComposer,
    counts: YarnCounts,
    loops: Option<(Laid, Arc<LoopsPerPixel>)>,
}

/// What the loops on each pixel follow from.
struct Laid {
    /// Without its pixels.
    chart: Chart,
    size: [usize; 2],
    weave: Weave,
    cells: [u32; 2],
}

/// A yarn whose share of the loops is less than this part of its share of the pixels is shown wrongly.
const LOST_BELOW: f64 = 0.5;
/// Yarns with a smaller share of the pixels may be shown as it comes; those without any loop never.
const SMALL_SHARE: f64 = 0.002;
/// A photograph of whose pixels a larger share has no loop loses its fine detail.
const MUCH_WITHOUT: f64 = 0.6;
/// Most yarns that a warning names.
const MOST_NAMED: usize = 4;

impl ChartYarns {
    /// The yarns of a chart's image, laid on the design's cloth as its own is: those with most loops first; `None`
    /// where there are more than [`YarnCounts::MOST`].
    pub fn of(&mut self, design: &Design, image: &ChartImage) -> Option<&[YarnCount]> {
        let loops = self.loops_per_pixel(design, image);
        self.counts.of(image, &loops)
    }

    fn loops_per_pixel(&mut self, design: &Design, image: &ChartImage) -> Arc<LoopsPerPixel> {
        // Asked in every frame: a large pattern is compared, not copied.
        let chart = Chart {
            pixels: None,
            ..design.chart.clone()
        };
        let size = [image.width(), image.height()];
        let cells = [design.sheet.warps, design.sheet.wefts];
        if let Some((of, loops)) = &self.loops
            && (of.size, of.cells) == (size, cells)
            && of.chart == chart
            && of.weave == design.weave
        {
            return loops.clone();
        }
        let on_sheet = ChartOnSheet::new(&design.chart, &design.weave, cells);
        let loops = Arc::new(on_sheet.loops_per_pixel(&design.weave, image));
        let laid = Laid {
            chart,
            size,
            weave: design.weave.clone(),
            cells,
        };
        self.loops = Some((laid, loops.clone()));
        loops
    }

    /// The yarns of a design's chart with its objects, as [`Self::of`]; none where the cloth has but one colour.
    pub fn of_design(&mut self, design: &Design) -> Option<Vec<YarnCount>> {
        let design = &*self.composer.design(design);
        let Some(image) = &design.chart.pixels else {
            return Some(Vec::new());
        };
        self.of(design, image).map(<[YarnCount]>::to_vec)
    }

    /// What of a design's chart no loop shows, or too few; `None` where all is well.
    pub fn warning(&mut self, design: &Design) -> Option<Warning> {
        let design = &*self.composer.design(design);
        let image = design.chart.pixels.as_ref()?;
        let text = match self.of(design, image) {
            Some(yarns) => lost_yarns(yarns)?,
            None if design.chart.fit == Fit::Stretch => {
                let without = self.loops_per_pixel(design, image).share_without();
                (without > MUCH_WITHOUT).then(|| {
                    let percent = 100.0 * without;
                    format!(
                        "{percent:.0} % of the chart's pixels lie on no loop: fine detail is lost"
                    )
                })?
            }
            None => return None,
        };
        Some(Warning::new("chart.image", text))
    }
}

/// The yarns that have no loops or far fewer than their pixels ask for.
fn lost_yarns(yarns: &[YarnCount]) -> Option<String> {
    let total = |of: fn(&YarnCount) -> u64| yarns.iter().map(of).sum::<u64>() as f64;
    let (pixels, loops) = (total(|yarn| yarn.pixels), total(|yarn| yarn.loops));
    if loops == 0.0 {
        return None;
    }
    let percent = |share: f64| match 100.0 * share {
        percent if percent >= 10.0 => format!("{percent:.0} %"),
        percent => format!("{percent:.1} %"),
    };
    let lost = yarns
        .iter()
        .filter(|yarn| yarn.colour != BARE)
        .filter_map(|yarn| {
            let of_pixels = yarn.pixels as f64 / pixels;
            let of_loops = yarn.loops as f64 / loops;
            let [r, g, b, _] = yarn.colour;
            let colour = String::from(Colour([r, g, b]));
            if yarn.loops == 0 {
                Some(format!(
                    "{colour} has {} of the pixels and no loop",
                    percent(of_pixels)
                ))
            } else if of_pixels > SMALL_SHARE && of_loops < LOST_BELOW * of_pixels {
                let (pixels, loops) = (percent(of_pixels), percent(of_loops));
                Some(format!(
                    "{colour} has {pixels} of the pixels and {loops} of the loops"
                ))
            } else {
                None
            }
        });
    let lost: Vec<String> = lost.collect();
    let more = match lost.len().saturating_sub(MOST_NAMED) {
        0 => String::new(),
        more => format!(", and {more} more"),
    };
    let named = lost[..lost.len().min(MOST_NAMED)].join(", ");
    (!lost.is_empty())
        .then(|| format!("loops do not show the chart's yarns as its pixels do: {named}{more}"))
}
