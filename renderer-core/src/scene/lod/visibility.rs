//! What a camera sees of a sheet: how fine it needs the loops, and which cells at which level of detail.

use glam::{DVec2, DVec3};

use super::{LodRegion, LodSelector};
use crate::design::Design;
use crate::geometry::{Camera, Interval, Projection, Ray, clip_to_box};
use crate::scene::PileReach;

/// Rays along each side of a part of a picture that tell what it shows.
const RAYS: u32 = 32;
/// Regions begin and end at whole multiples of this many cells, so that small moves of the camera give the same.
const STEP: f64 = 32.0;
/// Farthest that a shadow is thrown, in heights of the pile.
const LONGEST_SHADOW: f64 = 8.0;
/// The last LOD there is.
pub(super) const COARSEST_LOD: u32 = 20;
/// Where the eye is in the pile, it is taken to be this share of the pile's height above it.
const NEAREST_EYE: f64 = 0.25;

/// What a camera sees of a sheet.
pub(super) struct Visibility<'a> {
    reach: PileReach,
    camera: &'a Camera,
    size: [u32; 2],
    /// How far shadows are thrown, in heights of the pile.
    shadow: f64,
}

/// Cells of a cloth at some LOD that are seen, from and to along each axis.
pub(super) struct LevelCells {
    whole: [u32; 2],
    lod: u32,
    from: [f64; 2],
    to: [f64; 2],
}

/// A part of a picture: from and to which share of its height, from the top.
type Rows = [f64; 2];

const ALL_ROWS: Rows = [0.0, 1.0];

impl<'a> Visibility<'a> {
    pub(super) fn new(design: &Design, camera: &'a Camera, size: [u32; 2]) -> Self {
        let suns = design.light.sun.iter().map(|sun| sun.elevation);
        let areas = design.light.area.iter().map(|area| area.elevation);
        let slant = |elevation: f64| 1.0 / elevation.to_radians().tan().abs();
        let longest = suns.chain(areas).map(slant).fold(1.0, f64::max);
        Self {
            reach: PileReach::of(design),
            camera,
            size,
            shadow: longest.min(LONGEST_SHADOW),
        }
    }

    /// Lowest and highest corner of the cloth with its pile at some LOD, in the world, mm.
    fn cloth_box(&self, lod: u32) -> [DVec3; 2] {
        let sheet = &self.reach.sheet;
        let grown = f64::from(1_u32 << lod);
        let half = 0.5
            * DVec2::new(
                f64::from(sheet.warps) * sheet.pitch_x_mm,
                f64::from(sheet.wefts) * sheet.pitch_y_mm,
            );
        let [low, high] = [self.reach.low_mm, self.reach.high_mm].map(|mm| mm[2] * grown);
        [(-half).extend(low), half.extend(high)]
    }

    /// Where rays of some rows pass the cloth: their place from the picture's top as a share of its height, and where
    /// they enter and leave the box around the cloth.
    fn passages(&self, lod: u32, [top, bottom]: Rows) -> impl Iterator<Item = (f64, DVec3)> {
        let [low, high] = self.cloth_box(lod);
        let share = |index: u32| f64::from(index) / f64::from(RAYS);
        let size = DVec2::new(f64::from(self.size[0]), f64::from(self.size[1]));
        let points = (0..=RAYS).flat_map(move |y| (0..=RAYS).map(move |x| [x, y]));
        points.flat_map(move |[x, y]| {
            let down = top + (bottom - top) * share(y);
            let point = DVec2::new(share(x), down) * size;
            let (origin, direction) = self.camera.ray(point, self.size);
            let ray = Ray { origin, direction };
            let part = clip_to_box(&ray, Interval::new(0.0, f64::INFINITY), low, high);
            let ends = (!part.is_empty()).then(|| [part.low, part.high].map(|t| (down, ray.at(t))));
            ends.into_iter().flatten()
        })
    }

    /// How fine loops have to be that are no farther apart than so many pixels, as a multiple of those of cloth at
    /// some LOD: by the distance to the plane through the pile's top on the camera's side.
    pub(super) fn fineness(&self, loop_pixels: f64, lod: u32) -> LodSelector {
        let (eye, forward, up) = (self.camera.eye, self.camera.forward, self.camera.up);
        let pitch = self.reach.sheet.pitch_x_mm.max(self.reach.sheet.pitch_y_mm);
        let per_pixel_mm = pitch * f64::from(1_u32 << lod) / loop_pixels;
        let height_px = f64::from(self.size[1]);
        match self.camera.projection {
            Projection::Orthographic { height_mm } => LodSelector {
                at_top: per_pixel_mm * height_px / height_mm,
                down: 0.0,
            },
            Projection::Perspective { fov } => {
                let side = if eye.z < 0.0 { -1.0 } else { 1.0 };
                let top_mm = match side < 0.0 {
                    true => -self.reach.low_mm[2],
                    false => self.reach.high_mm[2],
                };
                let above_mm = (side * eye.z - top_mm).max(NEAREST_EYE * top_mm);
                // A row's rays come so much nearer to the plane for each mm ahead.
                let spread = (0.5 * fov).tan();
                let descent = |up_share: f64| -side * (forward.z + up.z * spread * up_share);
                // So many pixels a mm, for each mm that they come nearer.
                let scale = per_pixel_mm * height_px / (2.0 * spread * above_mm);
                LodSelector {
                    at_top: scale * descent(1.0),
                    down: scale * (descent(-1.0) - descent(1.0)),
                }
            }
        }
    }

    /// The cells of each level, the first as fine as the picture needs it anywhere.
    pub(super) fn levels(&self, loop_pixels: f64) -> Vec<LevelCells> {
        let rows = self.passages(0, ALL_ROWS).map(|(down, _)| down);
        let rows = rows.fold(None, |rows: Option<Rows>, down| {
            let [top, bottom] = rows.unwrap_or([down; 2]);
            Some([top.min(down), bottom.max(down)])
        });
        let Some([top, bottom]) = rows else {
            return vec![self.cells(COARSEST_LOD, ALL_ROWS)];
        };
        let of_cloth = self.fineness(loop_pixels, 0);
        let lod = |down: f64| {
            let fineness = of_cloth.at(down);
            let lod = if fineness > 0.0 {
                -fineness.log2()
            } else {
                f64::INFINITY
            };
            lod.clamp(0.0, f64::from(COARSEST_LOD))
        };
        // Between the rays there may be some that see it nearer; what is farther is left to the last level.
        let between = 1.0 / f64::from(RAYS);
        let [above, below] = [top - between, bottom + between].map(|down| down.clamp(0.0, 1.0));
        let first = lod(above).min(lod(below)).floor() as u32;
        let last = lod(top).max(lod(bottom)).ceil() as u32;
        let of_first = self.fineness(loop_pixels, first);
        let levels = first..=last.max(first);
        levels
            .map(|lod| {
                let level = f64::from(lod - first);
                // Each begins where the one before gives way, and ends where the next has taken over.
                let finest = if lod == first {
                    f64::INFINITY
                } else {
                    0.5_f64.powf(level - 1.0)
                };
                let coarsest = if lod >= last {
                    f64::NEG_INFINITY
                } else {
                    0.5_f64.powf(level + 1.0)
                };
                self.cells(lod, of_first.rows_between(coarsest, finest))
            })
            .collect()
    }

    /// The cells that are seen in some rows or throw shadows on what is.
    fn cells(&self, lod: u32, rows: Rows) -> LevelCells {
        let sheet = &self.reach.sheet;
        let whole = [sheet.warps, sheet.wefts];
        let scale = 0.5_f64.powi(lod as i32);
        let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        let mut coarsest = 0.0_f64;
        for (_, point) in self.passages(lod, rows) {
            low = low.min(point.truncate());
            high = high.max(point.truncate());
            coarsest = coarsest.max(self.camera.pixel_mm_at(point, self.size[1]));
        }
        if !low.is_finite() || !high.is_finite() {
            // Between the rays, if anywhere.
            (low, high) = (DVec2::ZERO, DVec2::ZERO);
        }
        let [width, height] = self.size.map(f64::from);
        let between = coarsest * width.max(height * (rows[1] - rows[0])) / f64::from(RAYS);
        let height = self.reach.high_mm[2].max(-self.reach.low_mm[2]);
        let reach = self.reach.margin();
        let cell = |axis: usize, mm: f64, outwards: f64| {
            let pitch = [sheet.pitch_x_mm, sheet.pitch_y_mm][axis];
            let from_low = mm + outwards * between + 0.5 * f64::from(whole[axis]) * pitch;
            let beyond = reach[axis] as f64 + 1.0 + height * self.shadow / pitch;
            from_low * scale / pitch + outwards * beyond
        };
        LevelCells {
            whole,
            lod,
            from: [cell(0, low.x, -1.0), cell(1, low.y, -1.0)],
            to: [cell(0, high.x, 1.0), cell(1, high.y, 1.0)],
        }
    }
}

impl LodSelector {
    fn at(&self, down: f64) -> f64 {
        self.at_top + self.down * down
    }

    /// The rows between two finenesses.
    fn rows_between(&self, coarsest: f64, finest: f64) -> Rows {
        if self.down == 0.0 {
            return ALL_ROWS;
        }
        let [a, b] = [coarsest, finest]
            .map(|fineness| ((fineness - self.at_top) / self.down).clamp(0.0, 1.0));
        [a.min(b), a.max(b)]
    }
}

impl LevelCells {
    /// The region that has these, and a share of them more on each side.
    pub(super) fn region(&self, margin: f64) -> LodRegion {
        let cells = LodRegion::cells_at(self.whole, self.lod);
        let ends = [0, 1].map(|axis| {
            let more = margin * (self.to[axis] - self.from[axis]);
            let [from, to] = [self.from[axis] - more, self.to[axis] + more];
            let within = |place: f64| place.clamp(0.0, f64::from(cells[axis])) as u32;
            let from = within((from / STEP).floor() * STEP);
            let from = from.min(cells[axis] - 1);
            [from, within((to / STEP).ceil() * STEP).max(from + 1)]
        });
        LodRegion {
            whole: self.whole,
            lod: self.lod,
            first: ends.map(|[from, _]| from),
            cells: ends.map(|[from, to]| to - from),
        }
    }
}
