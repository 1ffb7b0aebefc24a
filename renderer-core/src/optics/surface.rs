//! How ground yarns scatter (MODEL.md §7): `lambert`, `phong` and `poulin_fournier`.
//!
//! As for all lobes a value is ψ/albedo with the cosine included: light of unit irradiance, on a plane that faces it,
//! that leaves towards the view. Divided by the light's cosine each is a reciprocal BRDF, and for every view the
//! integral over all lights is at most 1. The highlight has the yarn's colour, so that no yarn gives back more than its
//! albedo.
//!
//! - `phong`: (1−s)·cos θ_l/π + s·(p+2)/2π·max(0, r·l)^p·cos θ_l, r the view mirrored in the normal. The factor makes
//!   the highlight's albedo 1 where the view is along the normal and less elsewhere (Lewis 1994, "Making shaders more
//!   physically plausible").
//! - `poulin_fournier` (Poulin and Fournier 1990, "A model for anisotropic reflection"): the yarn's surface is made of
//!   parallel fibres along the yarn, half sunk into a floor: unit half-cylinders with their axes `spacing` apart on a
//!   plane. Their walls and the floor between them shine as `phong` does, and count where they are both seen and lit,
//!   past the neighbours.
//!
//! The scene's geometry knows whole yarns: their round shape, the shadows between them and those of loops come from
//! rays. What it lacks is the relief of fibres a hundredth of a millimetre thick, far below a pixel: that is what
//! `poulin_fournier` adds, averaged over one period. So no shadow is counted twice. Light that goes from fibre to fibre
//! is left out, as by the paper.
//!
//! In the plane across the fibres a direction has the angle θ from the normal and the length c. With φ a wall's angle,
//! d the spacing in radii and ℓ the share of the floor both seen and lit,
//!   ψ_diffuse = c_l/(π·d·cos θ_v) · (∫ cos(φ−θ_v)·cos(φ−θ_l) dφ + ℓ·cos θ_v·cos θ_l),
//! the integral in closed form over the walls' angles that are both seen and lit. The highlight is alike, with the
//! integrand (p+2)/2·max(0, r·l)^p times that, r·l = c_v·c_l·cos(2φ−θ_v−θ_l) − v_t·l_t for a wall at φ (t: components
//! along the fibres). It is taken at [`NODES`] points over the part of the walls within [`REACH`] deviations of its
//! peak: by definition, in all renderers.

use std::f64::consts::{FRAC_1_PI, FRAC_PI_2, TAU};

use glam::DVec3;

use crate::geometry::Interval;
use crate::sampling::directions;
use crate::scene::Skeleton;

/// Positive points of the Gauss–Legendre rule with eight points over [−1, 1].
pub(crate) const NODES: [f64; 4] = [
    0.183_434_642_495_649_8,
    0.525_532_409_916_329,
    0.796_666_477_413_626_7,
    0.960_289_856_497_536_2,
];

/// Their weights, and those of the negative points.
pub(crate) const NODE_WEIGHTS: [f64; 4] = [
    0.362_683_783_378_362,
    0.313_706_645_877_887_3,
    0.222_381_034_453_374_5,
    0.101_228_536_290_376_3,
];

/// How far the highlight's integral reaches, in standard deviations of the bell that cos^p is about its peak: what is
/// left out is below 0.1 % of the whole.
pub(crate) const REACH: f64 = 3.5;

/// Parts of [0, 1) that tell a fibre's facet from each other: the upper twelve of a random number's bits give a
/// direction, the lower twelve the facet.
pub(crate) const FACETS: f64 = 4096.0;

/// How ground yarns scatter.
#[derive(Debug, Clone, Copy)]
pub struct SurfaceOptics {
    /// s: share of light in the highlight.
    pub specular: f64,
    /// p: sharpness of the highlight.
    pub exponent: f64,
    /// d: distance of the axes of neighbouring fibres, in their radii; at least 2.
    pub spacing: f64,
}

/// A direction in the axes of a fibre.
struct InFibre {
    /// Angle from the normal in the plane across the fibre.
    angle: f64,
    /// Length in that plane.
    across: f64,
    /// Component along the fibre.
    along: f64,
}

/// Unit normal of the yarn, the direction across its fibres and that along them.
#[derive(Clone, Copy)]
struct Axes {
    normal: DVec3,
    across: DVec3,
    along: DVec3,
}

impl Axes {
    fn new(normal: DVec3, along: DVec3) -> Self {
        let across = normal.cross(along);
        Self {
            normal,
            across,
            along,
        }
    }

    fn place(&self, direction: DVec3) -> InFibre {
        let (x, z) = (direction.dot(self.across), direction.dot(self.normal));
        InFibre {
            angle: x.atan2(z),
            across: x.hypot(z),
            along: direction.dot(self.along),
        }
    }
}

impl SurfaceOptics {
    /// Those of a scene's skeleton.
    pub fn new(skeleton: &Skeleton) -> Self {
        Self {
            specular: f64::from(skeleton.specular),
            exponent: f64::from(skeleton.exponent),
            spacing: 2.0 * f64::from(skeleton.fibre_spacing),
        }
    }

    /// `phong`.
    pub fn phong(&self, normal: DVec3, view: DVec3, light: DVec3) -> f64 {
        let cosine = normal.dot(light);
        if cosine <= 0.0 {
            return 0.0;
        }
        let mirrored = mirrored(normal, view).dot(light).max(0.0);
        let highlight = (self.exponent + 2.0) / TAU * mirrored.powf(self.exponent);
        cosine * ((1.0 - self.specular) * FRAC_1_PI + self.specular * highlight)
    }

    /// A direction for `phong`, by the diffuse part or by the highlight, and its value over the density of both
    /// together.
    pub fn sample_phong(&self, normal: DVec3, view: DVec3, [u, v]: [f64; 2]) -> (DVec3, f64) {
        let diffuse = 1.0 - self.specular;
        let peak = mirrored(normal, view);
        let direction = if u < diffuse {
            directions::cosine_hemisphere(normal, u / diffuse, v)
        } else {
            let u = (u - diffuse) / self.specular;
            directions::power_lobe(peak, self.exponent, u, v)
        };
        let density = self.phong_density(normal, view, direction);
        let value = self.phong(normal, view, direction);
        (direction, if value > 0.0 { value / density } else { 0.0 })
    }

    /// The density of [`Self::sample_phong`], per sr.
    pub fn phong_density(&self, normal: DVec3, view: DVec3, direction: DVec3) -> f64 {
        let diffuse = 1.0 - self.specular;
        let cosine = normal.dot(direction).max(0.0);
        let peak = mirrored(normal, view);
        let lobe = peak.dot(direction).max(0.0).powf(self.exponent);
        diffuse * cosine * FRAC_1_PI + self.specular * (self.exponent + 1.0) / TAU * lobe
    }

    /// `poulin_fournier` with fibres along the unit vector `along`.
    pub fn fibres(&self, normal: DVec3, along: DVec3, view: DVec3, light: DVec3) -> f64 {
        if normal.dot(view) <= 0.0 || normal.dot(light) <= 0.0 {
            return 0.0;
        }
        let axes = Axes::new(normal, along);
        let (view, light) = (axes.place(view), axes.place(light));
        let walls = self.walls(view.angle).intersect(self.walls(light.angle));
        let floor = self.floor(view.angle).intersect(self.floor(light.angle));
        let (difference, sum) = (view.angle - light.angle, view.angle + light.angle);
        // On the floor φ is 0.
        let on_floor = floor.length() * view.angle.cos() * light.angle.cos();
        let diffuse = on_floor
            + if walls.is_empty() {
                0.0
            } else {
                // ∫ cos(φ−θ_v)·cos(φ−θ_l) dφ = ½∫ cos(θ_v−θ_l) + cos(2φ−θ_v−θ_l) dφ
                let ends = walls.high + walls.low - sum;
                0.5 * (walls.length() * difference.cos() + ends.cos() * walls.length().sin())
            };
        let mirrored = |phi: f64| {
            let cosine = view.across * light.across * (2.0 * phi - sum).cos();
            (cosine - view.along * light.along).max(0.0)
        };
        let peak = mirrored(0.5 * sum);
        let mut highlight = on_floor * mirrored(0.0).powf(self.exponent);
        // About its peak (a·cos 2x + b)^p falls off as exp(−2a·p·x²/(a+b)).
        let deviation = (peak / (4.0 * view.across * light.across * self.exponent)).sqrt();
        let reach = REACH * deviation;
        let part = walls.intersect(Interval::new(0.5 * sum - reach, 0.5 * sum + reach));
        if !part.is_empty() {
            for (node, weight) in NODES.into_iter().zip(NODE_WEIGHTS) {
                for side in [-1.0, 1.0] {
                    let phi = part.middle() + 0.5 * part.length() * side * node;
                    highlight += 0.5
                        * part.length()
                        * weight
                        * mirrored(phi).powf(self.exponent)
                        * (phi - view.angle).cos()
                        * (phi - light.angle).cos();
                }
            }
        }
        let per_area = light.across / (self.spacing * view.angle.cos());
        let highlight = 0.5 * (self.exponent + 2.0) * highlight;
        per_area * FRAC_1_PI * ((1.0 - self.specular) * diffuse + self.specular * highlight)
    }

    /// A direction for `poulin_fournier` and its value over its density: a facet is drawn as the view sees them, and
    /// from it a direction as from a surface of its own.
    pub fn sample_fibres(
        &self,
        normal: DVec3,
        along: DVec3,
        view: DVec3,
        [u, v]: [f64; 2],
    ) -> (DVec3, f64) {
        let mut axes = Axes::new(normal, along);
        if view.dot(axes.across) < 0.0 {
            axes.across = -axes.across;
        }
        let theta = axes.place(view).angle;
        // The place across the view, from the edge of a fibre to that of the next one.
        let place = (v * FACETS).fract() * self.spacing * theta.cos() - 1.0;
        let on_wall = place <= theta.cos();
        let phi = if on_wall {
            theta + place.clamp(-1.0, 1.0).asin()
        } else {
            0.0
        };
        let facet = axes.normal * phi.cos() + axes.across * phi.sin();
        let diffuse = 1.0 - self.specular;
        let (direction, weight) = if u < diffuse {
            let direction = directions::cosine_hemisphere(facet, u / diffuse, v);
            (direction, 1.0)
        } else {
            let u = (u - diffuse) / self.specular;
            let direction = directions::power_lobe(mirrored(facet, view), self.exponent, u, v);
            let factor = (self.exponent + 2.0) / (self.exponent + 1.0);
            (direction, factor * facet.dot(direction).max(0.0))
        };
        let light = axes.place(direction).angle;
        let is_lit = light.abs() < FRAC_PI_2
            && if on_wall {
                self.walls(light).holds(phi)
            } else {
                self.floor(light).holds(place / theta.cos())
            };
        (direction, if is_lit { weight } else { 0.0 })
    }

    /// The angles φ of a fibre's wall that a direction at `theta` reaches: turned towards it, above the floor and not
    /// behind the neighbour, whose edge is d·cos θ − 1 from this fibre's axis.
    fn walls(&self, theta: f64) -> Interval {
        let angle = theta.abs();
        let neighbour = (self.spacing * angle.cos() - 1.0).clamp(-1.0, 1.0).asin();
        let (low, high) = (angle - FRAC_PI_2, (angle + neighbour).min(FRAC_PI_2));
        if theta < 0.0 {
            Interval::new(-high, -low)
        } else {
            Interval::new(low, high)
        }
    }

    /// The part of the floor between the axes of a fibre, at 0, and the next one, at d, that a direction at `theta`
    /// reaches.
    fn floor(&self, theta: f64) -> Interval {
        let shadow = 1.0 / theta.cos();
        if theta < 0.0 {
            Interval::new(shadow, self.spacing - 1.0)
        } else {
            Interval::new(1.0, self.spacing - shadow)
        }
    }
}

/// `view` mirrored in `normal`.
fn mirrored(normal: DVec3, view: DVec3) -> DVec3 {
    normal * (2.0 * normal.dot(view)) - view
}
