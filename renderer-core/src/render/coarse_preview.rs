//! Which cells of the cloth a coarse first picture depends on, so that a scene can be made for it before all loops are.
//!
//! Space: world, mm. A camera's ray is followed through the heights that loops can reach, and the light of every sun
//! and area light to each of its points. Both lie over a convex polygon on the sheet: the ray's ends there, and the
//! second end's shadow on the plane where the loops end, for the outermost directions of the sun. The sky's light and
//! further bounces come from all sides; so far as their way is short, they see the same, too.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::Settings;
use crate::design::Design;
use crate::geometry::{Camera, Interval, Ray, clip_to_box};
use crate::sampling::{self, Set};
use crate::scene::{AreaLight, Lights, PileReach, SunLight, VisibleCells};

/// Allowance for rounding, and for rays that start a little off a surface, mm.
const SLACK_MM: f64 = 0.01;

/// A coarse picture of level cloth: the first sample of some pixels. Which cells bent cloth shows is not found so
/// quickly.
#[derive(Debug, Clone, Copy)]
pub struct CoarsePreview<'a> {
    /// The cloth.
    pub design: &'a Design,
    /// From where.
    pub camera: &'a Camera,
    /// Width and height of the whole picture, pixels.
    pub size: [u32; 2],
    /// Every so manieth pixel of every so manieth row is drawn.
    pub stride: u32,
    /// How.
    pub settings: &'a Settings,
    /// How far around the rays of camera and suns the cloth is whole, for light that comes another way, mm.
    pub around_mm: f64,
}

impl CoarsePreview<'_> {
    /// The cells that it depends on.
    pub fn cells(&self) -> VisibleCells {
        let reach = PileReach::of(self.design);
        let none = VisibleCells::none(&reach);
        let lights = Lights::new(&self.design.light);
        let suns = lights.suns.iter().map(Shadow::of_sun);
        let areas = lights.areas.iter().map(Shadow::of_area);
        let shadows: Vec<Shadow> = if self.settings.shadows {
            suns.chain(areas).collect()
        } else {
            Vec::new()
        };
        let rows = (0..self.size[1])
            .into_par_iter()
            .step_by(self.stride as usize);
        let mut seen = rows
            // Each piece of work has a set of its own, of a bit a cell.
            .with_min_len(16)
            .fold(
                || none.clone(),
                |mut seen, row| {
                    self.see_row(row, &shadows, &mut seen);
                    seen
                },
            )
            .reduce(|| none.clone(), |a, b| a.or(&b));
        let pitches = [reach.sheet.pitch_x_mm, reach.sheet.pitch_y_mm];
        seen.grow(pitches.map(|pitch| (self.around_mm / pitch).ceil() as i64));
        seen
    }

    fn see_row(&self, row: u32, shadows: &[Shadow], seen: &mut VisibleCells) {
        let [low, high] = seen.bounds_mm().map(DVec3::from_array);
        let mut corners = Vec::new();
        for column in (0..self.size[0]).step_by(self.stride as usize) {
            let ray = self.ray([column, row]);
            let part = clip_to_box(&ray, Interval::new(0.0, f64::INFINITY), low, high);
            if part.is_empty() {
                continue;
            }
            let ends = [part.low, part.high].map(|t| ray.at(t));
            let track = ends.map(DVec3::truncate);
            insert(seen, &track);
            for shadow in shadows {
                corners.clear();
                corners.extend(track);
                shadow.add(ends, [low, high], &mut corners);
                insert(seen, &corners);
            }
        }
    }

    /// The ray of the first sample of a pixel.
    fn ray(&self, pixel: [u32; 2]) -> Ray {
        let seed = sampling::pixel_seed(self.settings.seed, pixel);
        let [x, y, ..] = sampling::sample(self.settings.sampler, seed, 0, Set::Film);
        let point = DVec2::new(
            f64::from(pixel[0]) + f64::from(x),
            f64::from(pixel[1]) + f64::from(y),
        );
        let (origin, direction) = self.camera.ray(point, self.size);
        Ray { origin, direction }
    }
}

/// Over what parts of the sheet light comes to a point.
enum Shadow {
    /// From all directions of a sun.
    Sun {
        /// How far over the sheet it comes for every mm of height: least and most along x and y.
        slopes: [[f64; 2]; 2],
        /// It comes from below.
        from_below: bool,
    },
    /// From all points of a rectangle with these corners, mm.
    Area([DVec3; 4]),
}

impl Shadow {
    fn of_sun(sun: &SunLight) -> Self {
        let [x, y, z] = sun.direction;
        let sin = sun.angular_radius.sin();
        // The plane x = m·z touches the cone of the sun's directions where (x − m·z)² = (1 + m²)·sin².
        let along = |x: f64| {
            let (a, b, c) = (z * z - sin * sin, x * z, x * x - sin * sin);
            if a <= 0.0 {
                // Part of the sun is at the horizon.
                return [f64::NEG_INFINITY, f64::INFINITY];
            }
            let root = (b * b - a * c).max(0.0).sqrt();
            [(b - root) / a, (b + root) / a]
        };
        Self::Sun {
            slopes: [along(x), along(y)],
            from_below: z < 0.0,
        }
    }

    fn of_area(area: &AreaLight) -> Self {
        let centre = DVec3::from_array(area.centre);
        let [x, y] = area.half_sides.map(DVec3::from_array);
        Self::Area([
            centre - x - y,
            centre + x - y,
            centre - x + y,
            centre + x + y,
        ])
    }

    /// Adds to the ends of a ray within a box the corners of what lies under the ways of this light to all its points.
    fn add(&self, ends: [DVec3; 2], [low, high]: [DVec3; 2], corners: &mut Vec<DVec2>) {
        for end in ends {
            match self {
                Self::Sun { slopes, from_below } => {
                    let height = if *from_below {
                        low.z - end.z
                    } else {
                        high.z - end.z
                    };
                    if height == 0.0 {
                        // Even for a sun at the horizon.
                        continue;
                    }
                    let shift = |axis: usize, side: usize| {
                        // No way is longer than the box.
                        let most = high[axis] - low[axis];
                        (slopes[axis][side] * height).clamp(-most, most)
                    };
                    let sides = [[0, 0], [0, 1], [1, 0], [1, 1]];
                    corners.extend(
                        sides.map(|[x, y]| end.truncate() + DVec2::new(shift(0, x), shift(1, y))),
                    );
                }
                Self::Area(places) => {
                    let above = places.iter().all(|place| place.z > high.z);
                    let below = places.iter().all(|place| place.z < low.z);
                    for place in places {
                        // Where the way leaves the heights of the cloth; from a light that reaches down to them, the
                        // whole way.
                        let share = if above || below {
                            let level = if above { high.z } else { low.z };
                            (level - end.z) / (place.z - end.z)
                        } else {
                            1.0
                        };
                        corners.push(end.truncate().lerp(place.truncate(), share));
                    }
                }
            }
        }
    }
}

/// Adds the cells under the smallest convex polygon that holds all `corners`.
fn insert(seen: &mut VisibleCells, corners: &[DVec2]) {
    let lowest = corners.iter().fold(f64::INFINITY, |y, c| y.min(c.y)) - SLACK_MM;
    let highest = corners.iter().fold(f64::NEG_INFINITY, |y, c| y.max(c.y)) + SLACK_MM;
    for j in seen.wefts_between(lowest, highest) {
        let [low, high] = seen.weft_mm(j);
        let rows = Interval::new(low - SLACK_MM, high + SLACK_MM);
        let (mut left, mut right) = (f64::INFINITY, f64::NEG_INFINITY);
        // The polygon's sides are among the lines between any two corners.
        for (k, a) in corners.iter().enumerate() {
            for b in &corners[k..] {
                let along = *b - *a;
                let part = Interval::new(0.0, 1.0).clip_linear(a.y, along.y, rows);
                if !part.is_empty() {
                    let x = [part.low, part.high].map(|share| a.x + share * along.x);
                    left = left.min(x[0]).min(x[1]);
                    right = right.max(x[0]).max(x[1]);
                }
            }
        }
        if left <= right {
            seen.insert(j, seen.warps_between(left - SLACK_MM, right + SLACK_MM));
        }
    }
}
