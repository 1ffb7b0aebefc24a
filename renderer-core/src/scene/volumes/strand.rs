//! A yarn of twisted plies along a centre line, with a round cross-section over u, v and w: what terry loops and
//! twisted strands are made of. Plies wind about the line as helices.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};
use noise::{NoiseFn, Perlin};

use super::{Field, GROOVE_SHADE, Yarn, falloff};
use crate::design::Pile;
use crate::sampling::Pcg;

/// Straight pieces of a centre line. An arch of 24 pieces departs from a circle by less than 0.3 % of its radius.
pub(super) const PIECES: usize = 48;

/// Slabs in which pieces are looked for: about as many as there are rows of points.
const SLABS: usize = 64;

/// How far fibres end before and behind the cut, in radii of the yarn.
const RAGGED: f64 = 0.5;

/// What the end of a centre line is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum End {
    /// In the ground weave, like its beginning.
    Rooted,
    /// Cut: fibres end at different lengths.
    Cut,
}

pub(super) struct Strand {
    /// Points of the centre line, mm, from one root to the other.
    line: Vec<DVec3>,
    /// Length of the line up to each point, mm.
    arc: Vec<f64>,
    /// Middle of each piece, mm, and the square of how far from it a point of the yarn beside the piece can be.
    around: Vec<(DVec3, f64)>,
    /// For each of the slabs across the line's height: a bit for each piece whose yarn reaches into it.
    slabs: [u64; SLABS],
    /// Where the first slab begins, mm, and how many there are in a millimetre.
    first_slab: f64,
    slabs_per_mm: f64,
    end: End,
    yarn_radius: f64,
    plies: Plies,
    fibres: Fibres,
}

/// Cross-section of a plied yarn in units of its radius.
struct Plies {
    count: u32,
    /// Distance of the plies' axes from the yarn's.
    offset: f64,
    /// Radius of a ply; plies press into each other, so they overlap.
    radius: f64,
    /// Radians of twist for each mm of yarn.
    twist_per_mm: f64,
    phase: f64,
}

/// Fine streaks along the fibres.
struct Fibres {
    noise: Perlin,
    /// Streaks around the yarn's girth.
    around: f64,
}

impl Strand {
    /// The yarn of `pile` along the [`PIECES`] of `line`, mm.
    pub(super) fn new(
        pile: &Pile,
        line: Vec<DVec3>,
        end: End,
        variant: u32,
        random: &mut Pcg,
    ) -> Self {
        let mut arc = vec![0.0; line.len()];
        for k in 1..line.len() {
            arc[k] = arc[k - 1] + line[k].distance(line[k - 1]);
        }
        let radius = match pile.plies {
            1 => 1.0,
            2 => 0.62,
            3 => 0.56,
            _ => 0.5,
        };
        let plies = Plies {
            count: pile.plies,
            offset: 1.0 - radius,
            radius,
            twist_per_mm: TAU * pile.twist_per_cm / 10.0,
            phase: TAU * f64::from(random.next_float()),
        };
        let fibres = Fibres {
            noise: Perlin::new(variant),
            around: f64::from(pile.fibres).sqrt(),
        };
        let yarn_radius = pile.yarn_diameter / 2.0;
        let around = |ends: &[DVec3]| {
            // A little more, for rounding.
            let reach = (yarn_radius + 0.5 * ends[0].distance(ends[1])) * (1.0 + 1e-9);
            (0.5 * (ends[0] + ends[1]), reach * reach)
        };
        let around: Vec<_> = line.windows(2).map(around).collect();
        let reach = |&(middle, squared): &(DVec3, f64)| {
            let reach = squared.sqrt();
            [middle.y - reach, middle.y + reach]
        };
        let heights = around.iter().map(reach);
        let [low, high] = heights.clone().fold(
            [f64::INFINITY, f64::NEG_INFINITY],
            |[low, high], [from, to]| [low.min(from), high.max(to)],
        );
        let slabs_per_mm = SLABS as f64 / (high - low);
        let mut slabs = [0; SLABS];
        for (piece, [from, to]) in heights.enumerate() {
            let [from, to] = [from, to].map(|y| slab_of((y - low) * slabs_per_mm));
            for pieces in &mut slabs[from..=to] {
                *pieces |= 1 << piece;
            }
        }
        Self {
            around,
            slabs,
            first_slab: low,
            slabs_per_mm,
            line,
            arc,
            end,
            yarn_radius,
            plies,
            fibres,
        }
    }

    /// Nearest point of the centre line: the point, the line's direction, and the length up to it; `None` outside the
    /// yarn, though not everywhere there.
    fn nearest(&self, point: DVec3) -> Option<(DVec3, DVec3, f64)> {
        let mut best = (f64::INFINITY, 0, 0.0);
        let mut pieces = self.slabs[slab_of((point.y - self.first_slab) * self.slabs_per_mm)];
        while pieces != 0 {
            let k = pieces.trailing_zeros() as usize;
            pieces &= pieces - 1;
            let (middle, reach_squared) = self.around[k];
            let ends = [self.line[k], self.line[k + 1]];
            if point.distance_squared(middle) > reach_squared {
                continue;
            }
            let along = ends[1] - ends[0];
            let t =
                ((point - ends[0]).dot(along) / along.length_squared().max(1e-12)).clamp(0.0, 1.0);
            let distance = (point - ends[0] - along * t).length_squared();
            if distance < best.0 {
                best = (distance, k, t);
            }
        }
        let (distance, k, t) = best;
        let along = self.line[k + 1] - self.line[k];
        distance.is_finite().then(|| {
            (
                self.line[k] + along * t,
                along.normalize_or(DVec3::Y),
                self.arc[k] + along.length() * t,
            )
        })
    }
}

/// The slab at `place` slabs from the first; the nearest where there is none.
fn slab_of(place: f64) -> usize {
    (place as usize).min(SLABS - 1)
}

impl Field for Strand {
    fn yarn(&self, point: DVec3) -> Yarn {
        let Some((axis_point, axis, arc)) = self.nearest(point) else {
            return Yarn::default();
        };
        let offset = (point - axis_point) / self.yarn_radius;
        if offset.length_squared() > 1.0 {
            return Yarn::default();
        }
        // Across the yarn: one direction in the plane of the arch, one along the thickness.
        let inward = axis.cross(DVec3::Z).normalize_or(DVec3::X);
        let across = DVec2::new(offset.dot(inward), offset.dot(DVec3::Z));
        let turn = self.plies.phase + self.plies.twist_per_mm * arc;
        let ply_radius = self.plies.nearest(across, turn);
        let streak = self.fibres.streak(across, turn, arc);
        // Fibres wind with the ply: their slope against the axis grows with the distance from it.
        let around = DVec3::Z * across.x - inward * across.y;
        let tangent =
            (axis + around * (self.plies.twist_per_mm * self.yarn_radius)).normalize_or(axis);
        let brush = match self.end {
            End::Rooted => 1.0,
            End::Cut => self.brush(across, turn, arc + offset.dot(axis) * self.yarn_radius),
        };
        Yarn {
            density: falloff(ply_radius) * (1.0 - 0.35 * streak) * brush,
            shade: 1.0 - GROOVE_SHADE * streak,
            tangent,
        }
    }

    fn surface(&self, random: &mut Pcg) -> (DVec3, DVec3, DVec3) {
        let k = (f64::from(random.next_float()) * PIECES as f64) as usize;
        let axis = (self.line[k + 1] - self.line[k]).normalize_or(DVec3::Y);
        let inward = axis.cross(DVec3::Z).normalize_or(DVec3::X);
        let angle = TAU * f64::from(random.next_float());
        let out = inward * angle.cos() + DVec3::Z * angle.sin();
        (self.line[k] + out * (0.85 * self.yarn_radius), out, axis)
    }
}

impl Strand {
    /// 1 where a fibre goes on at a length from the root, 0 behind its end.
    fn brush(&self, across: DVec2, turn: f64, length: f64) -> f64 {
        let total = self.arc[PIECES];
        let ragged = RAGGED * self.yarn_radius;
        // Noise of fibres far beyond all lengths: their ends have nothing to do with their streaks.
        let end = total - ragged * (0.5 + 0.5 * self.fibres.noise_at(across, turn, 1e3));
        ((end - length) / (0.3 * ragged) + 0.5).clamp(0.0, 1.0)
    }
}

impl Plies {
    /// Distance to the nearest ply's axis in units of its radius.
    fn nearest(&self, across: DVec2, turn: f64) -> f64 {
        let distance = |ply: u32| {
            let angle = turn + TAU * f64::from(ply) / f64::from(self.count);
            across.distance(DVec2::from_angle(angle) * self.offset) / self.radius
        };
        (0..self.count).map(distance).fold(f64::INFINITY, f64::min)
    }
}

impl Fibres {
    /// 0 on a fibre, towards 1 between fibres; streaks follow the twist.
    fn streak(&self, across: DVec2, turn: f64, arc: f64) -> f64 {
        (0.5 + 0.9 * self.noise_at(across, turn, arc)).clamp(0.0, 1.0)
    }

    /// In [−1, 1], the same along the way of a fibre for some millimetres.
    fn noise_at(&self, across: DVec2, turn: f64, arc: f64) -> f64 {
        let unwound = DVec2::from_angle(-turn).rotate(across) * self.around;
        self.noise.get([unwound.x, unwound.y, arc * 1.3])
    }
}
