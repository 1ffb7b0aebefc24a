//! Curves in a plane that a cloth is bent along: given by the angle at every place, so that no length changes.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::DVec2;

/// Distance of the places at which a curve is known, mm; in between it is a cubic.
const STEP_MM: f64 = 0.2;
/// Most of them.
const MOST_STEPS: usize = 1 << 16;

/// How the angle of a curve, counted from level and upwards, changes along it. Places are mm from the cloth's middle.
#[derive(Debug, Clone, Copy)]
pub(super) enum Bend {
    /// Waves of a length, as steep as an angle.
    Wave { length: f64, steepest: f64 },
    /// A spiral of turns `gap` apart from `start` on; `outermost` is its first radius. Upwards, or with `turn` −1
    /// downwards.
    Roll {
        start: f64,
        outermost: f64,
        gap: f64,
        turn: f64,
    },
    /// Half a turn downwards about the middle.
    Rail { radius: f64 },
    /// Layers of a length, and half turns between them: upwards with the first radius, then downwards with the second,
    /// and so on.
    Stack {
        start: f64,
        layer: f64,
        radii: [f64; 2],
    },
}

impl Bend {
    /// The angle at `place`.
    fn angle(&self, place: f64) -> f64 {
        match *self {
            Self::Wave { length, steepest } => steepest * (TAU * place / length).sin(),
            Self::Roll {
                start,
                outermost,
                gap,
                turn,
            } => {
                // r² falls by gap/π for each mm, and dθ = ds/r.
                let way = (place - start).max(0.0);
                let radius = (outermost * outermost - gap * way / PI).max(0.0).sqrt();
                turn * TAU / gap * (outermost - radius)
            }
            Self::Rail { radius } => (-place / radius).clamp(-FRAC_PI_2, FRAC_PI_2),
            Self::Stack {
                start,
                layer,
                radii: [up, down],
            } => {
                let period = 2.0 * layer + PI * (up + down);
                let way = (place - start).rem_euclid(period);
                let up_end = layer + PI * up;
                if way < up_end {
                    ((way - layer) / up).max(0.0)
                } else {
                    PI - ((way - up_end - layer) / down).max(0.0)
                }
            }
        }
    }
}

/// A bent curve.
#[derive(Debug, Clone)]
pub(super) struct Profile {
    bend: Bend,
    /// The place of the first point.
    first: f64,
    step: f64,
    points: Vec<DVec2>,
}

impl Profile {
    /// The curve between two places; the middle of the box around its part between `inner` is at (0, 0).
    pub fn new(bend: Bend, [first, last]: [f64; 2], inner: [f64; 2]) -> Self {
        let count = (((last - first) / STEP_MM).ceil() as usize).clamp(16, MOST_STEPS);
        let step = (last - first) / count as f64;
        let direction = |place: f64| DVec2::from_angle(bend.angle(place));
        let mut points = Vec::with_capacity(count + 1);
        let mut point = DVec2::ZERO;
        points.push(point);
        for index in 0..count {
            let place = first + index as f64 * step;
            // Simpson's rule.
            let sum =
                direction(place) + 4.0 * direction(place + 0.5 * step) + direction(place + step);
            point += sum * (step / 6.0);
            points.push(point);
        }
        let mut profile = Self {
            bend,
            first,
            step,
            points,
        };
        let places = (0..=count).map(|index| first + index as f64 * step);
        let inside = places.filter(|place| inner[0] <= *place && *place <= inner[1]);
        let none = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        let (low, high) = inside.fold(none, |(low, high), place| {
            let point = profile.at(place);
            (low.min(point), high.max(point))
        });
        let middle = 0.5 * (low + high);
        profile.points.iter_mut().for_each(|point| *point -= middle);
        profile
    }

    /// The point at `place`: level and upwards.
    pub fn at(&self, place: f64) -> DVec2 {
        let x = (place - self.first) / self.step;
        let index = (x.max(0.0) as usize).min(self.points.len() - 2);
        let (share, start) = (x - index as f64, self.first + index as f64 * self.step);
        let (a, b) = (self.points[index], self.points[index + 1]);
        let slope = |place: f64| DVec2::from_angle(self.bend.angle(place)) * self.step;
        let (from, to) = (slope(start), slope(start + self.step));
        // Hermite's cubic.
        let (c2, c3) = (3.0 * (b - a) - 2.0 * from - to, 2.0 * (a - b) + from + to);
        a + share * (from + share * (c2 + share * c3))
    }

    /// Unit vector along the curve at `place`.
    pub fn direction(&self, place: f64) -> DVec2 {
        DVec2::from_angle(self.bend.angle(place))
    }
}
