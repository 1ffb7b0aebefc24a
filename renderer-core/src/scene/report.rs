//! What a compilation did: which sections it kept, which frames it left out, and how long each stage took.

use std::time::Instant;

use serde::Serialize;

/// Sections of a scene, by name, in the order of [`CompileReport::kept`].
pub const SECTIONS: [&str; 8] = [
    "sheet", "loops", "looks", "volumes", "pile", "skeleton", "form", "lights",
];

/// What the last compilation did.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct CompileReport {
    /// Which of the [`SECTIONS`] were kept from the scene before.
    pub kept: [bool; SECTIONS.len()],
    /// Frames of loops that were computed.
    pub frames_made: u64,
    /// Frames of loops that were not, of two for every cell of the sheet: where pattern, chart or length leave out the
    /// loop, or it cannot be seen.
    pub frames_left_out: u64,
    /// How long it took.
    pub seconds: StageSeconds,
}

impl CompileReport {
    /// What both did; kept is what both kept.
    pub fn plus(&self, other: &Self) -> Self {
        Self {
            kept: std::array::from_fn(|section| self.kept[section] && other.kept[section]),
            frames_made: self.frames_made + other.frames_made,
            frames_left_out: self.frames_left_out + other.frames_left_out,
            seconds: self.seconds.plus(&other.seconds),
        }
    }

    /// How many sections were kept.
    pub fn sections_kept(&self) -> u64 {
        self.kept.iter().filter(|&&kept| kept).count() as u64
    }
}

/// Wall-clock seconds of each stage.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct StageSeconds {
    /// The turbulence field.
    pub turbulence: f64,
    /// From the chart to the length of every cell, and which cells have loops.
    pub lengths: f64,
    /// The frames of all loops.
    pub frames: f64,
    /// The grid that finds loops.
    pub grid: f64,
    /// Colours, variants and materials of all loops.
    pub looks: f64,
    /// The voxels inside the loops.
    pub volumes: f64,
    /// The bent cloth's corners and boxes.
    pub form: f64,
    /// Everything, what is not listed here included.
    pub total: f64,
}

impl StageSeconds {
    fn plus(&self, other: &Self) -> Self {
        Self {
            turbulence: self.turbulence + other.turbulence,
            lengths: self.lengths + other.lengths,
            frames: self.frames + other.frames,
            grid: self.grid + other.grid,
            looks: self.looks + other.looks,
            volumes: self.volumes + other.volumes,
            form: self.form + other.form,
            total: self.total + other.total,
        }
    }

    /// The stages by name, and the rest of the total.
    pub fn by_name(&self) -> [(&'static str, f64); 8] {
        let Self {
            turbulence,
            lengths,
            frames,
            grid,
            looks,
            volumes,
            form,
            total,
        } = *self;
        let staged = turbulence + lengths + frames + grid + looks + volumes + form;
        [
            ("turbulence", turbulence),
            ("lengths", lengths),
            ("frames", frames),
            ("grid", grid),
            ("looks", looks),
            ("volumes", volumes),
            ("form", form),
            ("rest of compile", (total - staged).max(0.0)),
        ]
    }
}

/// Runs `work` and adds its time to `seconds`.
pub(super) fn timed<T>(seconds: &mut f64, work: impl FnOnce() -> T) -> T {
    let start = Instant::now();
    let result = work();
    *seconds += start.elapsed().as_secs_f64();
    result
}
