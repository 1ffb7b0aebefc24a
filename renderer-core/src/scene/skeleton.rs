//! The ground weave as a surface (MODEL.md §7, the paper's §4.1, equations 1 and 2), mm, f64.
//!
//! Positions along the sheet are in cells from its low corner: crossing (i, j) is at (i + ½, j + ½). Beyond the border
//! the pattern goes on; renderers end the yarns there, but a loop's root may stand a little outside.

use rayon::prelude::*;

use super::{SheetGeometry, Skeleton};
use crate::design::{SkeletonDesign, SkeletonHeight, Weave};

/// Side of the cloth.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Face {
    /// Towards +z.
    Front,
    /// Towards −z.
    Back,
}

impl Face {
    /// z of the face's normal.
    pub fn sign(self) -> f64 {
        match self {
            Self::Front => 1.0,
            Self::Back => -1.0,
        }
    }
}

impl Skeleton {
    /// The ground weave of a design.
    pub fn new(weave: &Weave, design: &SkeletonDesign) -> Self {
        let SkeletonDesign {
            warp_radius,
            weft_radius,
            crimp,
            height,
            specular,
            exponent,
            fibre_spacing,
            shading,
            colour,
            visible,
        } = *design;
        let pattern = &weave.pattern;
        let (cols, rows) = (pattern.cols(), pattern.rows());
        let over = |cell: usize| {
            let stitch = pattern.stitch((cell % cols) as i64, (cell / cols) as i64);
            stitch.warp_over
        };
        Self {
            warp_radius_mm: warp_radius as f32,
            weft_radius_mm: weft_radius as f32,
            crimp_mm: crimp as f32,
            height,
            shading,
            albedo: colour.linear().map(|c| c as f32),
            specular: specular as f32,
            exponent: exponent as f32,
            fibre_spacing: fibre_spacing as f32,
            visible,
            repeat: [cols as u32, rows as u32],
            warp_over: (0..cols * rows).map(over).collect(),
        }
    }

    /// Share of the sheet between the yarns, where rays go through to the other side (MODEL.md §7); 1 if it is not
    /// drawn.
    pub fn open_share(&self, sheet: &SheetGeometry) -> f64 {
        if !self.visible {
            return 1.0;
        }
        let open =
            |radius_mm: f32, pitch_mm: f64| (1.0 - 2.0 * f64::from(radius_mm) / pitch_mm).max(0.0);
        open(self.warp_radius_mm, sheet.pitch_x_mm) * open(self.weft_radius_mm, sheet.pitch_y_mm)
    }

    /// In which share points of the pile look for light on the other side of the ground, half of all directions. With V
    /// the light's visibility on their own side and g·V on the other, g the open share, the variance of what they
    /// gather is least where sides are looked to in proportion to √V. f32, so that all renderers have the same number.
    pub fn worth_looking_down(&self, sheet: &SheetGeometry) -> f32 {
        /// Light comes round the cloth's border, too.
        const LEAST: f64 = 1.0 / 16.0;
        let root = self.open_share(sheet).sqrt();
        (root / (1.0 + root)).max(LEAST) as f32
    }

    /// +1 where the warp lies over the weft at crossing (i, j), else −1; the pattern repeats to all sides.
    pub fn warp_sign(&self, i: i64, j: i64) -> f64 {
        let [cols, rows] = self.repeat.map(i64::from);
        let cell = j.rem_euclid(rows) * cols + i.rem_euclid(cols);
        if self.warp_over[cell as usize] {
            1.0
        } else {
            -1.0
        }
    }

    /// s along warp `i` at `y` cells from the near border: +1 on top of a weft, −1 below one.
    pub fn warp_profile(&self, i: i64, y: f64) -> f64 {
        profile(y, |j| self.warp_sign(i, j))
    }

    /// s along weft `j` at `x` cells from the left border: +1 on top of a warp, −1 below one.
    pub fn weft_profile(&self, j: i64, x: f64) -> f64 {
        profile(x, |i| -self.warp_sign(i, j))
    }

    /// Height of the ground weave over the sheet's plane as seen from `face`, along that face's normal, mm, at a place
    /// in cells; `None` in a gap. Of all yarns there the outermost counts.
    pub fn height_mm(&self, sheet: &SheetGeometry, place: [f64; 2], face: Face) -> Option<f64> {
        let radii = [self.warp_radius_mm, self.weft_radius_mm].map(f64::from);
        let pitches = [sheet.pitch_x_mm, sheet.pitch_y_mm];
        let mut highest: Option<f64> = None;
        for (set, (radius, pitch)) in radii.into_iter().zip(pitches).enumerate() {
            let (across, along) = (place[set], place[1 - set]);
            let reach = radius / pitch;
            let first = (across - 0.5 - reach).ceil() as i64;
            let last = (across - 0.5 + reach).floor() as i64;
            for yarn in first..=last {
                let off = (across - 0.5 - yarn as f64) * pitch;
                let bulge = (radius * radius - off * off).max(0.0).sqrt();
                let s = match set {
                    0 => self.warp_profile(yarn, along),
                    _ => self.weft_profile(yarn, along),
                };
                let height = match self.height {
                    SkeletonHeight::Winding => face.sign() * s * f64::from(self.crimp_mm) + bulge,
                    SkeletonHeight::Paper => face.sign() * s * bulge,
                };
                highest = Some(highest.map_or(height, |other| other.max(height)));
            }
        }
        highest
    }

    /// Share of the sheet's area where neither set of yarns is.
    pub fn gap_share(&self, sheet: &SheetGeometry) -> f64 {
        let gap = |radius: f32, pitch: f64| (1.0 - 2.0 * f64::from(radius) / pitch).max(0.0);
        gap(self.warp_radius_mm, sheet.pitch_x_mm) * gap(self.weft_radius_mm, sheet.pitch_y_mm)
    }
}

/// s at `t` cells along a yarn: half a cosine from each crossing's sign to the next.
fn profile(t: f64, sign: impl Fn(i64) -> f64) -> f64 {
    let crossing = (t - 0.5).floor();
    let (s0, s1) = (sign(crossing as i64), sign(crossing as i64 + 1));
    let phase = std::f64::consts::PI * (t - 0.5 - crossing);
    0.5 * (s0 + s1) + 0.5 * (s0 - s1) * phase.cos()
}

/// Heights of a loop's two roots along its face's normal, mm, for each cell of the pattern's repeat.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct RootHeights {
    repeat: [usize; 2],
    front: Vec<[f64; 2]>,
    back: Vec<[f64; 2]>,
}

impl RootHeights {
    pub(super) fn new(skeleton: &Skeleton, sheet: &SheetGeometry, base_width_mm: f64) -> Self {
        let [cols, rows] = skeleton.repeat.map(|n| n as usize);
        let half = 0.5 * base_width_mm / sheet.pitch_y_mm;
        let of_face = |face: Face| {
            let heights = (0..cols * rows).into_par_iter().map(|cell| {
                let (x, y) = ((cell % cols) as f64 + 0.5, (cell / cols) as f64 + 0.5);
                // The loop's own warp passes under both roots, so there is always a height.
                [y - half, y + half]
                    .map(|y| skeleton.height_mm(sheet, [x, y], face).unwrap_or_default())
            });
            heights.collect()
        };
        Self {
            repeat: [cols, rows],
            front: of_face(Face::Front),
            back: of_face(Face::Back),
        }
    }

    fn of_face(&self, face: Face) -> &[[f64; 2]] {
        match face {
            Face::Front => &self.front,
            Face::Back => &self.back,
        }
    }

    /// Lowest and highest, zero among them, and by how much those of one loop differ at most.
    pub(super) fn range(&self) -> ([f64; 2], f64) {
        let heights = || self.front.iter().chain(&self.back);
        let low = heights().flatten().fold(0.0, |low: f64, h| low.min(*h));
        let high = heights().flatten().fold(0.0, |high: f64, h| high.max(*h));
        let steps = heights().map(|[h0, h1]| (h1 - h0).abs());
        ([low, high], steps.fold(0.0, f64::max))
    }

    pub(super) fn at(&self, i: usize, j: usize, face: Face) -> [f64; 2] {
        let cell = j % self.repeat[1] * self.repeat[0] + i % self.repeat[0];
        self.of_face(face)[cell]
    }
}
