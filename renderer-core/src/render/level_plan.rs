//! Which levels of detail of a cloth a picture needs, and which cells of each.

use glam::{DVec2, DVec3};

use super::levels::Fineness;
use super::{Camera, Projection};
use crate::design::Design;
use crate::geometry::{Interval, Ray, clip_to_box};
use crate::scene::{Excerpt, PileReach};

/// How much of a cloth is made at most, where it is made in excerpts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extent {
    /// Most cells of all levels together.
    pub cells: u64,
    /// Cells beyond what is seen on each side, as a share of it: so far the camera moves without another excerpt.
    pub spare: f64,
}

impl Extent {
    /// For looking while designing: made in about a second.
    pub const LIVE: Self = Self {
        cells: 1 << 20,
        spare: 0.125,
    };
    /// For a picture that stays.
    pub const FINAL: Self = Self {
        cells: 1 << 22,
        spare: 0.0,
    };
}

/// The excerpts of a cloth that a picture shows.
#[derive(Debug, Clone, PartialEq)]
pub struct LevelPlan {
    /// From near to far, each halved once more than the one before; none if the whole cloth is made.
    pub excerpts: Vec<Excerpt>,
    /// How far apart the loops of a level are where it begins to give way to the next, pixels.
    loop_pixels: f64,
}

/// Rays along each side of a part of a picture that tell what it shows.
const RAYS: u32 = 32;
/// [`LevelPlan::loop_pixels`] unless that takes too many loops: 64 of them in a pixel vary so little that a zoom from level to level
/// shows no more change from frame to frame than the cloth itself (`tests/core/levels.rs`).
const LOOP_PIXELS: f64 = 0.125;
/// By how much it grows until there are few enough.
const GROWTH: f64 = std::f64::consts::SQRT_2;
/// Excerpts begin and end at whole multiples of this many cells, so that small moves of the camera give the same.
const STEP: f64 = 32.0;
/// Farthest that a shadow is thrown, in heights of the pile.
const LONGEST_SHADOW: f64 = 8.0;
const MOST_HALVINGS: u32 = 20;
/// Where the eye is in the pile, it is taken to be this share of the pile's height above it.
const NEAREST_EYE: f64 = 0.25;

impl LevelPlan {
    /// The whole cloth.
    pub fn whole() -> Self {
        Self {
            excerpts: Vec::new(),
            loop_pixels: LOOP_PIXELS,
        }
    }

    /// What a picture of `size` pixels shows of a design. Excerpts of the `last` plan are kept while they hold what is seen.
    pub fn new(
        design: &Design,
        camera: &Camera,
        size: [u32; 2],
        most: Extent,
        last: Option<&Self>,
    ) -> Self {
        if !Excerpt::is_needed(design) || !design.faults().is_empty() {
            return Self::whole();
        }
        let seen = Seen::new(design, camera, size);
        let fits =
            |excerpts: &[Excerpt]| excerpts.iter().map(Excerpt::len).sum::<u64>() <= most.cells;
        let mut loop_pixels = LOOP_PIXELS;
        loop {
            let levels = seen.levels(loop_pixels);
            let excerpts = |spare: f64| -> Vec<Excerpt> {
                levels.iter().map(|cells| cells.excerpt(spare)).collect()
            };
            let needed = excerpts(0.0);
            let is_coarsest = needed.iter().all(|one| one.halvings == MOST_HALVINGS);
            if !fits(&needed) && !is_coarsest {
                loop_pixels *= GROWTH;
                continue;
            }
            let kept = |roomy: &[Excerpt]| -> Vec<Excerpt> {
                let last = last.map_or(&[][..], |last| &last.excerpts);
                let kept = |needed: &Excerpt| last.iter().find(|last| last.holds(needed)).copied();
                (needed.iter().zip(roomy))
                    .map(|(needed, roomy)| kept(needed).unwrap_or(*roomy))
                    .collect()
            };
            let roomy = excerpts(most.spare);
            let choices = [kept(&roomy), kept(&needed), roomy];
            let excerpts = choices.into_iter().find(|choice| fits(choice));
            return Self {
                excerpts: excerpts.unwrap_or(needed),
                loop_pixels,
            };
        }
    }

    /// How fine the rows of a picture need the first level's loops.
    pub(super) fn fineness(&self, design: &Design, camera: &Camera, size: [u32; 2]) -> Fineness {
        match self.excerpts.first() {
            Some(first) => {
                Seen::new(design, camera, size).fineness(self.loop_pixels, first.halvings)
            }
            None => Fineness::default(),
        }
    }
}

/// What a camera sees of a sheet.
struct Seen<'a> {
    reach: PileReach,
    camera: &'a Camera,
    size: [u32; 2],
    /// How far shadows are thrown, in heights of the pile.
    shadow: f64,
}

/// Cells of a halved cloth that are seen, from and to along each axis.
struct SeenCells {
    whole: [u32; 2],
    halvings: u32,
    from: [f64; 2],
    to: [f64; 2],
}

/// A part of a picture: from and to which share of its height, from the top.
type Rows = [f64; 2];

const ALL_ROWS: Rows = [0.0, 1.0];

impl<'a> Seen<'a> {
    fn new(design: &Design, camera: &'a Camera, size: [u32; 2]) -> Self {
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

    /// Lowest and highest corner of the cloth when its pile is halved some times, in the world, mm.
    fn cloth_box(&self, halvings: u32) -> [DVec3; 2] {
        let sheet = &self.reach.sheet;
        let grown = f64::from(1_u32 << halvings);
        let half = 0.5
            * DVec2::new(
                f64::from(sheet.warps) * sheet.pitch_x_mm,
                f64::from(sheet.wefts) * sheet.pitch_y_mm,
            );
        let [low, high] = [self.reach.low_mm, self.reach.high_mm].map(|mm| mm[2] * grown);
        [(-half).extend(low), half.extend(high)]
    }

    /// Where rays of some rows pass the cloth: their place from the picture's top as a share of its height, and where they
    /// enter and leave the box around the cloth.
    fn passages(&self, halvings: u32, [top, bottom]: Rows) -> impl Iterator<Item = (f64, DVec3)> {
        let [low, high] = self.cloth_box(halvings);
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

    /// How fine loops have to be that are no farther apart than so many pixels, as a multiple of those of cloth that is halved
    /// some times: by the distance to the plane through the pile's top on the camera's side.
    fn fineness(&self, loop_pixels: f64, halvings: u32) -> Fineness {
        let (eye, forward, up) = (self.camera.eye, self.camera.forward, self.camera.up);
        let pitch = self.reach.sheet.pitch_x_mm.max(self.reach.sheet.pitch_y_mm);
        let per_pixel_mm = pitch * f64::from(1_u32 << halvings) / loop_pixels;
        let height_px = f64::from(self.size[1]);
        match self.camera.projection {
            Projection::Orthographic { height_mm } => Fineness {
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
                Fineness {
                    at_top: scale * descent(1.0),
                    down: scale * (descent(-1.0) - descent(1.0)),
                }
            }
        }
    }

    /// The cells of each level, the first as fine as the picture needs it anywhere.
    fn levels(&self, loop_pixels: f64) -> Vec<SeenCells> {
        let rows = self.passages(0, ALL_ROWS).map(|(down, _)| down);
        let rows = rows.fold(None, |rows: Option<Rows>, down| {
            let [top, bottom] = rows.unwrap_or([down; 2]);
            Some([top.min(down), bottom.max(down)])
        });
        let Some([top, bottom]) = rows else {
            return vec![self.cells(MOST_HALVINGS, ALL_ROWS)];
        };
        let of_cloth = self.fineness(loop_pixels, 0);
        let halvings = |down: f64| {
            let fineness = of_cloth.at(down);
            let halvings = if fineness > 0.0 {
                -fineness.log2()
            } else {
                f64::INFINITY
            };
            halvings.clamp(0.0, f64::from(MOST_HALVINGS))
        };
        // Between the rays there may be some that see it nearer; what is farther is left to the last level.
        let between = 1.0 / f64::from(RAYS);
        let [above, below] = [top - between, bottom + between].map(|down| down.clamp(0.0, 1.0));
        let first = halvings(above).min(halvings(below)).floor() as u32;
        let last = halvings(top).max(halvings(bottom)).ceil() as u32;
        let of_first = self.fineness(loop_pixels, first);
        let levels = first..=last.max(first);
        levels
            .map(|halvings| {
                let level = f64::from(halvings - first);
                // Each begins where the one before gives way, and ends where the next has taken over.
                let finest = if halvings == first {
                    f64::INFINITY
                } else {
                    0.5_f64.powf(level - 1.0)
                };
                let coarsest = if halvings >= last {
                    f64::NEG_INFINITY
                } else {
                    0.5_f64.powf(level + 1.0)
                };
                self.cells(halvings, of_first.rows(coarsest, finest))
            })
            .collect()
    }

    /// The cells that are seen in some rows or throw shadows on what is.
    fn cells(&self, halvings: u32, rows: Rows) -> SeenCells {
        let sheet = &self.reach.sheet;
        let whole = [sheet.warps, sheet.wefts];
        let scale = 0.5_f64.powi(halvings as i32);
        let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        let mut coarsest = 0.0_f64;
        for (_, point) in self.passages(halvings, rows) {
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
        let margin = self.reach.margin();
        let cell = |axis: usize, mm: f64, outwards: f64| {
            let pitch = [sheet.pitch_x_mm, sheet.pitch_y_mm][axis];
            let from_low = mm + outwards * between + 0.5 * f64::from(whole[axis]) * pitch;
            let beyond = margin[axis] as f64 + 1.0 + height * self.shadow / pitch;
            from_low * scale / pitch + outwards * beyond
        };
        SeenCells {
            whole,
            halvings,
            from: [cell(0, low.x, -1.0), cell(1, low.y, -1.0)],
            to: [cell(0, high.x, 1.0), cell(1, high.y, 1.0)],
        }
    }
}

impl Fineness {
    fn at(&self, down: f64) -> f64 {
        self.at_top + self.down * down
    }

    /// The rows between two finenesses.
    fn rows(&self, coarsest: f64, finest: f64) -> Rows {
        if self.down == 0.0 {
            return ALL_ROWS;
        }
        let [a, b] = [coarsest, finest]
            .map(|fineness| ((fineness - self.at_top) / self.down).clamp(0.0, 1.0));
        [a.min(b), a.max(b)]
    }
}

impl SeenCells {
    /// The excerpt that has these, and a share of them more on each side.
    fn excerpt(&self, spare: f64) -> Excerpt {
        let halved = Excerpt::halved(self.whole, self.halvings);
        let ends = [0, 1].map(|axis| {
            let more = spare * (self.to[axis] - self.from[axis]);
            let [from, to] = [self.from[axis] - more, self.to[axis] + more];
            let within = |cells: f64| cells.clamp(0.0, f64::from(halved[axis])) as u32;
            let from = within((from / STEP).floor() * STEP);
            let from = from.min(halved[axis] - 1);
            [from, within((to / STEP).ceil() * STEP).max(from + 1)]
        });
        Excerpt {
            whole: self.whole,
            halvings: self.halvings,
            first: ends.map(|[from, _]| from),
            cells: ends.map(|[from, to]| to - from),
        }
    }
}
