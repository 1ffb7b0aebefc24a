//! What a scene costs to make where that is much: known from the design alone, before anything is made.

use super::lod::{LodBudget, LodRegion};
use super::looks::Materials;
use crate::design::{Design, PileKind, Warning};

/// Time from which it is reported, seconds.
const LONG: f64 = 10.0;
/// Time of a core for a loop, from chart to grid, seconds (measured with `render --stats` on cloth of 2000 × 2000).
const SECONDS_PER_LOOP: f64 = 2e-6;
/// Memory for a loop while the grid is made, bytes.
const BYTES_PER_LOOP: f64 = 130.0;
/// Memory for a voxel while it is made: sums of density, shade and direction, bytes.
const BYTES_PER_VOXEL: f64 = 64.0;

/// Time of a core for a voxel, seconds, at the default number of fibres (measured as [`SECONDS_PER_LOOP`]).
fn seconds_per_voxel(kind: PileKind) -> f64 {
    match kind {
        PileKind::Terry => 1.3e-6,
        PileKind::Twisted => 0.85e-6,
        PileKind::Cut => 0.75e-6,
        PileKind::Fur => 6.6e-6,
        PileKind::Grass => 0.3e-6,
    }
}

/// What is allowed and takes long on this machine, with estimates of time and memory: the volumes inside loops, and the
/// loops themselves.
pub fn costs(design: &Design) -> Vec<Warning> {
    let cores = std::thread::available_parallelism().map_or(1, usize::from) as f64;
    let mut warnings = Vec::new();
    let mut tell = |path: &str, what: String, core_seconds: f64, bytes: f64| {
        let seconds = core_seconds / cores;
        if seconds > LONG {
            let time = if seconds < 100.0 {
                format!("{seconds:.0} s")
            } else {
                format!("{:.0} minutes", seconds / 60.0)
            };
            let text = format!(
                "{what} take some {time} and {:.1} GB of memory",
                bytes / 1e9
            );
            warnings.push(Warning::new(path, text));
        }
    };
    let pile = &design.pile;
    let [variants, layers, side] = [pile.variants, pile.layers, pile.resolution].map(f64::from);
    let voxels = variants * layers * side * side;
    let yarns = Materials::new(design).yarns;
    let per_voxel: f64 = yarns.iter().map(|(kind, _)| seconds_per_voxel(*kind)).sum();
    let kinds = match yarns.len() {
        1 => String::new(),
        count => format!(" for each of {count} kinds of yarn"),
    };
    tell(
        "pile.variants",
        format!("{variants} variants of {layers} layers of {side} × {side} voxels{kinds}"),
        voxels * per_voxel,
        voxels * yarns.len() as f64 * BYTES_PER_VOXEL,
    );
    let cells = f64::from(design.sheet.warps) * f64::from(design.sheet.wefts);
    let at_once = match LodRegion::is_needed(design) {
        true => cells.min(LodBudget::FINAL.cells as f64),
        false => cells,
    };
    tell(
        "sheet.wefts",
        format!("{:.1} million crossings made at once", at_once / 1e6),
        at_once * SECONDS_PER_LOOP,
        at_once * BYTES_PER_LOOP,
    );
    warnings
}
