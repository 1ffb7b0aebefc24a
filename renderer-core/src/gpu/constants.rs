//! Constants that host and shaders share, declared once: WGSL gets them from [`prelude`], which begins every program.
//! Numbers that have a meaning on the host come from where that meaning is.

use std::fmt::Write;

use crate::design::{Light, Phase};
use crate::geometry::tolerances;
use crate::image::display;
use crate::optics::{limits, multiple_scattering, surface};
use crate::render::{accumulation, bounced_light, shadow_cache};
use crate::sampling::{self, Set};
use crate::scene::Sky;

/// A value that WGSL can be given as a constant.
pub trait WgslValue {
    /// Its type and the value itself, to the last bit.
    fn typed(&self) -> (String, String);
}

impl WgslValue for u32 {
    fn typed(&self) -> (String, String) {
        ("u32".into(), format!("{self}u"))
    }
}

impl WgslValue for f32 {
    fn typed(&self) -> (String, String) {
        // The shortest digits that are this number and no other; without `f` they would be read as an f64 first.
        ("f32".into(), format!("{self:?}f"))
    }
}

impl<const N: usize> WgslValue for [f32; N] {
    fn typed(&self) -> (String, String) {
        let ty = format!("vec{N}<f32>");
        let values: Vec<String> = self.iter().map(|value| value.typed().1).collect();
        (ty.clone(), format!("{ty}({})", values.join(", ")))
    }
}

/// Appends the WGSL declaration of a constant, a line.
pub fn declare(text: &mut String, name: &str, value: &impl WgslValue) {
    let (ty, value) = value.typed();
    // Strings take everything.
    let _ = writeln!(text, "const {name}: {ty} = {value};");
}

macro_rules! constants {
    ($( $(#[$meta:meta])* $name:ident: $type:ty = $value:expr; )+) => {
        $( $(#[$meta])* pub const $name: $type = $value; )+

        /// WGSL that declares every shared constant, a line each.
        pub fn prelude() -> String {
            let mut text = String::new();
            $( declare(&mut text, stringify!($name), &$name); )+
            text
        }
    };
}

const fn as_f32<const N: usize>(values: [f64; N]) -> [f32; N] {
    let mut narrow = [0.0; N];
    let mut k = 0;
    while k < N {
        narrow[k] = values[k] as f32;
        k += 1;
    }
    narrow
}

constants! {
    /// METHOD for `single`.
    METHOD_SINGLE: u32 = 0;
    /// METHOD for `layered`.
    METHOD_LAYERED: u32 = 1;
    /// METHOD for `tracked`.
    METHOD_TRACKED: u32 = 2;
    /// METHOD for `exact`.
    METHOD_EXACT: u32 = 3;
    /// PHASE for `isotropic`.
    PHASE_ISOTROPIC: u32 = 0;
    /// PHASE for `frame_lambert`.
    PHASE_FRAME_LAMBERT: u32 = 1;
    /// PHASE for `kajiya_kay`.
    PHASE_KAJIYA_KAY: u32 = 2;
    /// PHASE for `gradient_lambert`.
    PHASE_GRADIENT_LAMBERT: u32 = 3;
    /// PHASE where not all materials scatter alike.
    PHASE_OF_MATERIAL: u32 = 4;
    /// SKELETON for none.
    SKELETON_NONE: u32 = 0;
    /// SKELETON for tubes.
    SKELETON_WINDING: u32 = 1;
    /// SKELETON for the paper's product.
    SKELETON_PAPER: u32 = 2;
    /// SKY for one colour.
    SKY_UNIFORM: u32 = 0;
    /// SKY for a gradient.
    SKY_GRADIENT: u32 = 1;
    /// SKY for a picture.
    SKY_IMAGE: u32 = 2;
    /// Columns of sums of light beside the picture of SKY_IMAGE.
    SKY_SUMS: u32 = 2;
    /// Share of the directions to an environment sampled by importance that follow the phase.
    PHASE_SHARE: f32 = Sky::PHASE_SHARE;
    /// SHADING for `lambert`.
    SHADING_LAMBERT: u32 = 0;
    /// SHADING for `phong`.
    SHADING_PHONG: u32 = 1;
    /// SHADING for `poulin_fournier`.
    SHADING_POULIN_FOURNIER: u32 = 2;
    /// Points of the rule that SHADING_POULIN_FOURNIER integrates with, the positive ones.
    NODES: [f32; 4] = as_f32(surface::NODES);
    /// Their weights.
    NODE_WEIGHTS: [f32; 4] = as_f32(surface::NODE_WEIGHTS);
    /// How far its highlight's integral reaches, in standard deviations.
    REACH: f32 = surface::REACH as f32;
    /// Parts of [0, 1) that tell its facets from each other.
    FACETS: f32 = surface::FACETS as f32;
    /// π.
    PI: f32 = std::f32::consts::PI;
    /// Side of the tiles that work is handed out in, pixels.
    TILE: u32 = accumulation::TILE_SIDE;
    /// Pixels of a tile.
    TILE_PIXELS: u32 = TILE * TILE;
    /// Threads of a workgroup, in every entry point.
    WORKGROUP: u32 = 64;
    /// Most suns.
    MAX_SUNS: u32 = Light::MAX_SUNS as u32;
    /// Most area lights.
    MAX_AREAS: u32 = Light::MAX_AREAS as u32;
    /// Most materials.
    MAX_MATERIALS: u32 = 130;
    /// Intervals of the table of N_p over [0, π/2].
    HIGHLIGHT_INTERVALS: u32 = 256;
    /// Independent scrambles of the random sequence (MODEL.md §10).
    SCRAMBLES: u32 = sampling::SCRAMBLES;
    /// Samples of one scramble before the next one's turn.
    RUN: u32 = sampling::RUN;
    /// The set of numbers that places a ray in its pixel.
    SET_FILM: u32 = Set::Film.number();
    /// The set that chooses a sample's level of detail.
    SET_LEVEL: u32 = Set::Level.number();
    /// From the sets of one scattering to those of the next.
    SETS_PER_BOUNCE: u32 = sampling::SETS_PER_BOUNCE;
    /// The set of a scattering's direction towards the environment, among those of the scattering; so are the next.
    SET_ENVIRONMENT: u32 = Set::Environment { bounce: 0 }.number();
    /// The set of the way on.
    SET_ONWARD: u32 = Set::Onward { bounce: 0 }.number();
    /// The set of the first area light; those of suns begin with 0.
    SET_FIRST_AREA: u32 = Set::Area { bounce: 0, area: 0 }.number();
    /// g, r and β of the first mode of light that has scattered many times.
    SCATTERING_MODE_FIRST: [f32; 3] = as_f32(multiple_scattering::MODES[0]);
    /// Those of the middle mode.
    SCATTERING_MODE_MIDDLE: [f32; 3] = as_f32(multiple_scattering::MODES[1]);
    /// Those of the last mode.
    SCATTERING_MODE_LAST: [f32; 3] = as_f32(multiple_scattering::MODES[2]);
    /// ℓ: the share of that light that depth does not matter to.
    SCATTERING_LEVEL: f32 = multiple_scattering::LEVEL as f32;
    /// Least visibility that it is estimated with.
    SCATTERING_FLOOR: f32 = multiple_scattering::FLOOR as f32;
    /// Index of the counter of rays.
    COUNT_RAYS: u32 = 0;
    /// Index of the counter of shadow rays.
    COUNT_SHADOW_RAYS: u32 = 1;
    /// Index of the counter of cells.
    COUNT_CELLS: u32 = 2;
    /// Index of the counter of patch tests.
    COUNT_PATCH_TESTS: u32 = 3;
    /// Index of the counter of volume samples.
    COUNT_VOLUME_SAMPLES: u32 = 4;
    /// Index of the counter of contributing hits.
    COUNT_CONTRIBUTING_HITS: u32 = 5;
    /// Index of the counter of shadow rays that ended in the dark.
    COUNT_ENDED_RAYS: u32 = 6;
    /// Index of the counter of rays for which no ground yarn was looked for.
    COUNT_HIDDEN_RAYS: u32 = 7;
    /// Index of the counter of shadow rays that the cache saved.
    COUNT_CACHED_RAYS: u32 = 8;
    /// Word of the counters' buffer with the rooms that pages of the shadow cache have taken.
    LEARNED_ROOMS: u32 = 20;
    /// Word with the rooms there are.
    LEARNED_MOST_ROOMS: u32 = 21;
    /// Word with the entries of a page.
    LEARNED_PAGE_ENTRIES: u32 = 22;
    /// Word with the first word of the means of shadows.
    LEARNED_MEANS: u32 = 23;
    /// Word with the first word of their sums.
    LEARNED_SUMS: u32 = 24;
    /// Word with the steps of those sums in a radiance of 1, as bits.
    LEARNED_SHADOW_SCALE: u32 = 25;
    /// Word with the first word of the ratios of light that goes on.
    LEARNED_RATIOS: u32 = 26;
    /// Word with the number of their texels.
    LEARNED_BOUNCED: u32 = 27;
    /// Word with the number of them along x.
    LEARNED_BOUNCED_X: u32 = 28;
    /// Word with the number of them along y.
    LEARNED_BOUNCED_Y: u32 = 29;
    /// Word with the binary logarithm of their cells along each side.
    LEARNED_BOUNCED_SHIFT: u32 = 30;
    /// Word with the steps of their sums in a radiance of 1, as bits.
    LEARNED_BOUNCED_SCALE: u32 = 31;
    /// Width and height of a page of the shadow cache, texels.
    PAGE_SIDE: u32 = shadow_cache::PAGE_SIDE;
    /// Words of the sums of one of its entries.
    SHADOW_SUMS: u32 = 5;
    /// Most steps of light that a shadow ray counts for.
    SHADOW_MOST_STEPS: f32 = (shadow_cache::MOST_LIGHT * shadow_cache::SUM_STEPS) as f32;
    /// Word of the counters' buffer at which shadows begin.
    SHADOWS_FROM: u32 = 32;
    /// Steps of a mean from 0 to 1.
    SHADOW_MEAN_STEPS: f32 = shadow_cache::MEAN_STEPS as f32;
    /// Marks a mean that is final.
    SHADOW_FINAL: u32 = shadow_cache::FINAL;
    /// Rays that make a mean.
    ENOUGH_RAYS: u32 = shadow_cache::ENOUGH_RAYS;
    /// Rays that make a final one.
    ALL_RAYS: u32 = shadow_cache::ALL_RAYS;
    /// Share of rays that are traced until then.
    TRACED_SHARE: f32 = shadow_cache::TRACED_SHARE;
    /// Words of the sums of a texel of light that goes on.
    BOUNCED_SUMS: u32 = 7;
    /// Width and height of the blocks of pixels that learn of it together are 2 to this, pixels.
    BOUNCED_BLOCK_SHIFT: u32 = bounced_light::BLOCK_SHIFT;
    /// Blocks learn whose hash is below this.
    BOUNCED_CHANCE: u32 = bounced_light::CHANCE;
    /// Paths from which a texel learns no more.
    BOUNCED_ALL_PATHS: u32 = bounced_light::ALL_PATHS;
    /// Most steps that a path counts.
    BOUNCED_MOST_STEPS: f32 = (bounced_light::MOST * bounced_light::STEPS) as f32;
    /// Paths that a ratio begins with, each as estimated.
    BOUNCED_PRIOR_PATHS: f32 = bounced_light::PRIOR_PATHS;
    /// Least ratio of light that goes on to its estimate.
    BOUNCED_LEAST: f32 = bounced_light::BOUNDS[0];
    /// Most.
    BOUNCED_MOST: f32 = bounced_light::BOUNDS[1];
    /// Transmittance of a shadow ray below which it counts as dark.
    DARK: f32 = limits::DARK as f32;
    /// Sum of ρ that overlapping yarns are held to.
    MOST_OVERLAP: f32 = limits::MOST_OVERLAP as f32;
    /// Scattering from which on a path may end by Russian roulette.
    ROULETTE_FROM: u32 = limits::ROULETTE_FROM;
    /// Share of the lights that are looked for at later scatterings than a path's first.
    LATER_LIGHTS_SHARE: f32 = limits::LATER_LIGHTS_SHARE as f32;
    /// Steps over a strip of the ground yarns of SKELETON_PAPER.
    PAPER_STEPS: u32 = tolerances::PAPER_STEPS;
    /// Smallest step towards a tube of SKELETON_WINDING, in its radii.
    SMALLEST_STEP: f32 = tolerances::SMALLEST_STEP as f32;
    /// By how much bounds of ground yarns are too wide.
    ROOMY: f32 = tolerances::ROOMY as f32;
    /// Smallest |w′|, 1/mm.
    FLATTEST: f32 = tolerances::FLATTEST as f32;
    /// Where a line of a patch is so much shorter than the patch (squared) that its root is refined.
    SHORT: f32 = tolerances::SHORT;
    /// Projected areas of loops are above this, mm².
    SMALLEST_AREA: f32 = tolerances::SMALLEST_AREA;
    /// By how much loops are taken to be thicker where the part of a ray in one is looked for.
    WIDENED: f32 = tolerances::WIDENED;
    /// Bit of a stitch word: warp over at the crossing itself.
    STITCH_HERE: u32 = 0;
    /// Bit of a stitch word: warp over at the next crossing along x.
    STITCH_RIGHT: u32 = 1;
    /// Bit of a stitch word: warp over at the crossing before along x.
    STITCH_LEFT: u32 = 2;
    /// Bit of a stitch word: warp over at the next crossing along y.
    STITCH_FAR: u32 = 3;
    /// Bit of a stitch word: warp over at the crossing before along y.
    STITCH_NEAR: u32 = 4;
    /// Texels of a row of a bent cloth's mesh.
    FORM_ROW: u32 = 1024;
    /// Vectors of a pixel in the accumulation.
    SUMS: u32 = 2;
    /// Vectors of a pixel with AOV.
    SUMS_WITH_AOV: u32 = 4;
    /// End of a tile that shows background alone.
    ALL_BACKGROUND: u32 = u32::MAX;
    /// Coarsest lattice of the first sample, pixels: one pixel a tile.
    COARSEST: u32 = TILE;
    /// Tone map: hard clip.
    TONE_NONE: u32 = 0;
    /// Tone map: filmic.
    TONE_FILMIC: u32 = 1;
    /// Linear value above which TONE_FILMIC departs from the identity.
    SHOULDER: f32 = display::SHOULDER as f32;
}

/// Number of counters, of two words each. WGSL sees an array without a length.
pub const COUNTERS_IN_ALL: u32 = 9;
const _: () = assert!(2 * COUNTERS_IN_ALL <= LEARNED_ROOMS);

/// How shaders number phase functions.
pub(super) fn phase(phase: Phase) -> u32 {
    match phase {
        Phase::Isotropic => PHASE_ISOTROPIC,
        Phase::FrameLambert => PHASE_FRAME_LAMBERT,
        Phase::KajiyaKay => PHASE_KAJIYA_KAY,
        Phase::GradientLambert => PHASE_GRADIENT_LAMBERT,
    }
}
