//! What a picture of a design is made from: a scene, whole or an excerpt, and the camera in its space.

use std::sync::Arc;

use glam::{DVec2, DVec3};

use super::Camera;
use crate::design::Design;
use crate::geometry::{Interval, Ray, clip_to_box};
use crate::scene::{Cancel, CompileError, Compiler, Excerpt, PileReach, Scene};

/// A scene for a picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Sight {
    /// The cloth, or the part of it that the picture shows.
    pub scene: Arc<Scene>,
    /// The camera in the scene's space.
    pub camera: Camera,
}

/// How much of a cloth is made at most, where it is made in excerpts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extent {
    /// Most cells.
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

impl Sight {
    /// Makes what a picture of `size` pixels shows.
    ///
    /// # Errors
    /// As [`Compiler::compile_unless_cancelled`].
    pub fn new(
        compiler: &mut Compiler,
        design: &Design,
        camera: &Camera,
        size: [u32; 2],
        most: Extent,
        cancel: &Cancel<'_>,
    ) -> Result<Self, CompileError> {
        let excerpt = excerpt_for(design, camera, size, most, None);
        let scene = compiler.compile_excerpt(design, excerpt, cancel)?;
        Ok(Self::of(scene, design, camera))
    }

    /// A scene of a design, be it an excerpt, and the camera that sees it as `camera` sees the whole.
    pub fn of(scene: Arc<Scene>, design: &Design, camera: &Camera) -> Self {
        let camera = match &scene.sheet.excerpt {
            Some(excerpt) => excerpt.camera(design, camera),
            None => *camera,
        };
        Self { scene, camera }
    }

    /// The part of the cloth that the scene is; `None` for all of it.
    pub fn excerpt(&self) -> Option<&Excerpt> {
        self.scene.sheet.excerpt.as_ref()
    }
}

/// Rays along each side of a picture that tell what it shows.
const RAYS: u32 = 32;
/// Loops of a halved cloth are no wider apart than this many pixels where it is nearest, if there may be so many.
const LOOP_PIXELS: f64 = 0.25;
/// Excerpts begin and end at whole multiples of this many cells, so that small moves of the camera give the same.
const STEP: f64 = 32.0;
/// Farthest that a shadow is thrown, in heights of the pile.
const LONGEST_SHADOW: f64 = 8.0;
const MOST_HALVINGS: u32 = 20;

/// The excerpt of a design that a picture shows; `None` where the whole cloth is made. The `last` one is kept while it holds what
/// is seen.
pub fn excerpt_for(
    design: &Design,
    camera: &Camera,
    size: [u32; 2],
    most: Extent,
    last: Option<&Excerpt>,
) -> Option<Excerpt> {
    if !Excerpt::is_needed(design) || !design.faults().is_empty() {
        return None;
    }
    let seen = Seen::new(design, camera, size);
    let fits = |excerpt: &Excerpt| excerpt.len() <= most.cells;
    let mut halvings = seen.halvings_of_pixels();
    let mut cells = seen.cells(halvings);
    while !fits(&cells.excerpt(0.0)) && halvings < MOST_HALVINGS {
        halvings += 1;
        cells = seen.cells(halvings);
    }
    let seen_alone = cells.excerpt(0.0);
    let kept = last
        .copied()
        .filter(|last| last.holds(&seen_alone) && fits(last));
    let roomy = || Some(cells.excerpt(most.spare)).filter(fits);
    kept.or_else(roomy).or(Some(seen_alone))
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

    /// Where rays of the picture pass the cloth: where they enter and leave the box around it.
    fn passages(&self, halvings: u32) -> impl Iterator<Item = DVec3> {
        let [low, high] = self.cloth_box(halvings);
        let size = self.size;
        let share = move |index: u32, axis: usize| f64::from(index * size[axis]) / f64::from(RAYS);
        let points = (0..=RAYS).flat_map(move |y| (0..=RAYS).map(move |x| [x, y]));
        points.flat_map(move |[x, y]| {
            let point = DVec2::new(share(x, 0), share(y, 1));
            let (origin, direction) = self.camera.ray(point, size);
            let ray = Ray { origin, direction };
            let part = clip_to_box(&ray, Interval::new(0.0, f64::INFINITY), low, high);
            let ends = (!part.is_empty()).then(|| [part.low, part.high].map(|t| ray.at(t)));
            ends.into_iter().flatten()
        })
    }

    /// How often the cloth can be halved until its loops are as far apart as the nearest pixels allow.
    fn halvings_of_pixels(&self) -> u32 {
        let pitch = self.reach.sheet.pitch_x_mm.max(self.reach.sheet.pitch_y_mm);
        let finest = self.passages(0).fold(f64::INFINITY, |finest, point| {
            finest.min(self.camera.pixel_mm_at(point, self.size[1]))
        });
        let cells = LOOP_PIXELS * finest / pitch;
        if !cells.is_finite() {
            return MOST_HALVINGS;
        }
        cells.log2().floor().clamp(0.0, f64::from(MOST_HALVINGS)) as u32
    }

    /// The cells that are seen or throw shadows on what is.
    fn cells(&self, halvings: u32) -> SeenCells {
        let sheet = &self.reach.sheet;
        let whole = [sheet.warps, sheet.wefts];
        let scale = 0.5_f64.powi(halvings as i32);
        let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        let mut coarsest = 0.0_f64;
        for point in self.passages(halvings) {
            low = low.min(point.truncate());
            high = high.max(point.truncate());
            coarsest = coarsest.max(self.camera.pixel_mm_at(point, self.size[1]));
        }
        if !low.is_finite() || !high.is_finite() {
            // Between the rays, if anywhere.
            (low, high) = (DVec2::ZERO, DVec2::ZERO);
        }
        let between = coarsest * f64::from(self.size[0].max(self.size[1]).div_ceil(RAYS));
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
