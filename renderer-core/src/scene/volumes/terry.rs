//! Terry: an uncut loop. Two legs and an arch of twisted plies, with a round cross-section over u, v and w.
//!
//! The centre line lies near the patch's plane, a little bent so that no two variants are alike; plies wind about it
//! as helices. The arch is half an ellipse, a circle where the loop is long enough.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};
use noise::{NoiseFn, Perlin};

use super::{Field, GROOVE_SHADE, LoopSize, MARGIN, Yarn, falloff, signed, variant_random};
use crate::design::Pile;
use crate::sampling::Pcg;

/// Straight pieces of the centre line. An arch of 24 pieces departs from a circle by less than 0.3 % of its radius.
const PIECES: usize = 48;

pub(super) struct Terry {
    /// Points of the centre line, mm, from one root to the other.
    line: Vec<DVec3>,
    /// Length of the line up to each point, mm.
    arc: Vec<f64>,
    /// Middle of each piece, mm, and the square of how far from it a point of the yarn beside the piece can be.
    around: Vec<(DVec3, f64)>,
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

impl Terry {
    pub(super) fn new(pile: &Pile, size: LoopSize, variant: u32) -> Self {
        let mut random = variant_random(variant, 1);
        let line = centre_line(pile.yarn_diameter, size, &mut random);
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
        Self {
            around: line.windows(2).map(around).collect(),
            line,
            arc,
            yarn_radius,
            plies,
            fibres,
        }
    }

    /// Nearest point of the centre line: the point, the line's direction, and the length up to it; `None` outside the yarn,
    /// though not everywhere there.
    fn nearest(&self, point: DVec3) -> Option<(DVec3, DVec3, f64)> {
        let mut best = (f64::INFINITY, 0, 0.0);
        for (k, (ends, &(middle, reach_squared))) in
            self.line.windows(2).zip(&self.around).enumerate()
        {
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

impl Field for Terry {
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
        Yarn {
            density: falloff(ply_radius) * (1.0 - 0.35 * streak),
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
        let unwound = DVec2::from_angle(-turn).rotate(across) * self.around;
        (0.5 + 0.9 * self.noise.get([unwound.x, unwound.y, arc * 1.3])).clamp(0.0, 1.0)
    }
}

/// Legs and arch of one variant: bent sideways, out of plane and in leg spacing.
fn centre_line(diameter: f64, size: LoopSize, random: &mut Pcg) -> Vec<DVec3> {
    let margin = diameter * (0.5 + MARGIN);
    let spacing =
        (size.width - 2.0 * margin).max(0.0) * (1.0 - 0.12 * f64::from(random.next_float()));
    let top = (size.length - margin).max(0.3 * size.length);
    let rise = (spacing / 2.0).min(top);
    let room = (size.thickness / 2.0 - 0.5 * diameter).max(0.0);
    let (bend, sway, slack) = (signed(random) * room, signed(random) * room, signed(random));
    let asymmetry = 0.25 * slack * (size.width / 2.0 - margin - spacing / 2.0).max(0.0);
    let leg = top - rise;
    let half_girth = std::f64::consts::PI * rise / 2.0;
    let total = 2.0 * (leg + half_girth);
    (0..=PIECES)
        .map(|k| {
            let s = total * k as f64 / PIECES as f64;
            let (side, from_root) = if s < total / 2.0 {
                (-1.0, s)
            } else {
                (1.0, total - s)
            };
            let (x, y) = if from_root <= leg {
                (spacing / 2.0, from_root)
            } else {
                let angle = (from_root - leg) / half_girth * std::f64::consts::FRAC_PI_2;
                (spacing / 2.0 * angle.cos(), leg + rise * angle.sin())
            };
            let height = y / top;
            DVec3::new(
                side * x + asymmetry * height,
                y,
                (bend * side + sway) * 0.5 * height,
            )
        })
        .collect()
}
