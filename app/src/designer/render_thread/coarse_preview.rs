//! How coarse a preview of an edited design is, so that the scene for it is made soon.

use std::time::Duration;

use renderer_core::design::{Design, FormKind};
use renderer_core::geometry::Camera;
use renderer_core::render::{CoarsePreview, RenderRequest, Settings};
use renderer_core::scene::VisibleCells;
use renderer_core::scene::lod::LodBudget;

use super::render_job::{self, first_divisor};

/// Loops that take less than this, two frames or so, are made at once.
pub const WORTH_IT: Duration = Duration::from_millis(40);
/// Most of the sheet's cells that a coarse preview may need.
const MOST_SEEN: f64 = 0.15;
/// Width and height of a coarse preview are at least those of the picture divided by this.
const COARSEST: u32 = 64;
/// How far around the rays of camera and suns the pile is whole: several times the way that light goes in dense pile
/// from one scattering to the next. On a million default loops no picture's brightness changed by more than 0.1 %.
const AROUND_MM: f64 = 0.5;

/// How much of a cloth that is made in parts is made for a coarse preview: in some twentieths of a second.
pub const LEVELS: LodBudget = LodBudget {
    cells: 1 << 15,
    margin: 0.0,
};
/// Width and height of a coarse preview of such cloth are at most those of the picture divided by this: loops as coarse
/// as its [`LEVELS`] have to be would show in a finer one.
const FINEST_OF_LEVELS: u32 = 4;

/// The size of a coarse preview of cloth that is made in parts, as a share of the picture's, at `cost` seconds for a
/// sample of a pixel.
pub fn divisor_of_levels(size: [u32; 2], cost: Option<f64>) -> u32 {
    first_divisor(cost, size).max(FINEST_OF_LEVELS)
}

/// A preview to make.
pub struct Plan {
    /// What has to be there for it.
    pub seen: VisibleCells,
    /// Its width and height are those of the picture divided by this.
    pub divisor: u32,
}

/// The coarse preview of a design, at `cost` seconds for a sample of a pixel; `None` where it would need too much of
/// the cloth.
pub fn plan(
    design: &Design,
    camera: &Camera,
    size: [u32; 2],
    settings: &Settings,
    cost: Option<f64>,
) -> Option<Plan> {
    if design.form.kind != FormKind::Flat {
        // Which cells bent cloth shows takes too long to find out.
        return None;
    }
    let cells = f64::from(design.sheet.warps) * f64::from(design.sheet.wefts);
    let mut divisor = first_divisor(cost, size);
    while divisor <= COARSEST {
        let preview = CoarsePreview {
            design,
            camera,
            size: size.map(|side| side.div_ceil(divisor)),
            stride: 1,
            settings,
            around_mm: AROUND_MM,
        };
        let seen = preview.cells();
        if seen.len() as f64 <= MOST_SEEN * cells {
            return Some(Plan { seen, divisor });
        }
        divisor *= 2;
    }
    None
}

/// The picture of a request at a fraction of its size, with one sample.
pub fn reduced(request: &RenderRequest, divisor: u32) -> RenderRequest {
    let mut preview = render_job::reduced(request, divisor);
    preview.settings.samples = 1;
    preview
}
