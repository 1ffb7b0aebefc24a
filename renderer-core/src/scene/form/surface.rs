//! Where the middle of the ground weave lies in space: a surface over the sheet.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::{DVec2, DVec3};

use super::height::HeightMap;
use super::net::Net;
use super::profile::{Bend, Profile};
use crate::design::{BentAlong, Fault, Form, FormKind};

/// Share of the hanging length over which folds grow, and of a fold's length where that is more.
const FOLDS_GROW: f64 = 0.7;
/// Step by which directions of the surface are found, mm.
const STEP_MM: f64 = 1e-3;

/// A surface.
#[derive(Debug, Clone)]
pub(super) struct Surface {
    shape: Shape,
    along: BentAlong,
    /// Size of the sheet, mm.
    size: DVec2,
}

#[derive(Debug, Clone)]
enum Shape {
    /// Bent along one direction.
    Bent(Profile),
    /// Bent over a rail, with folds of a length as steep as an angle below it.
    Hanging {
        profile: Profile,
        /// Half the way over the rail, and from there to where folds are fully grown, mm.
        over: f64,
        growth: f64,
        fold: f64,
        steepest: f64,
    },
    Net(Net),
    /// Raised as a picture is bright.
    Height(HeightMap),
}

impl Surface {
    /// The surface of a form over a sheet of a size and some `margin` mm around it, whose pile stands between two
    /// heights; `None` for a level one, as that of a height picture that nobody has read.
    ///
    /// # Errors
    /// When the form has no room for the pile.
    pub fn new(
        form: &Form,
        size: DVec2,
        margin: f64,
        [low, high]: [f64; 2],
    ) -> Result<Option<Self>, Fault> {
        let along = form.along;
        let length = match along {
            BentAlong::Warp => size.y,
            BentAlong::Weft => size.x,
        };
        let half = 0.5 * length;
        let steepest = form.steepness.to_radians();
        let profile = |bend| Profile::new(bend, [-half - margin, half + margin], [-half, half]);
        let shape = match form.kind {
            FormKind::Flat => return Ok(None),
            FormKind::Wave => Shape::Bent(profile(Bend::Wave {
                length: form.wavelength,
                steepest,
            })),
            FormKind::Roll => {
                let gap = high - low + form.gap;
                let rolled = form.rolled * length;
                let inner = if form.front_inside { high } else { -low };
                // Hollow within the pile, and large enough for what goes on beyond the cloth's end.
                let core = form.radius + inner;
                let outermost = (core * core + gap * rolled / PI).sqrt();
                Shape::Bent(profile(Bend::Roll {
                    start: half - rolled,
                    outermost,
                    gap,
                    turn: if form.front_inside { 1.0 } else { -1.0 },
                }))
            }
            FormKind::Stack => {
                let count = f64::from(form.layers);
                let radii = [high, -low].map(|inner| inner.max(0.0) + 0.5 * form.gap);
                let turns = [(count / 2.0).floor(), ((count - 1.0) / 2.0).floor()];
                let turned = PI * (radii[0] * turns[0] + radii[1] * turns[1]);
                let layer = (length - turned) / count;
                if layer <= 0.0 {
                    return Err(Fault {
                        path: "form.layers".into(),
                        value: form.layers.to_string(),
                        allowed: format!(
                            "so few layers that the {turned:.0} mm in the folds between them are less than the \
                             {length:.0} mm of cloth"
                        ),
                    });
                }
                Shape::Bent(profile(Bend::Stack {
                    start: -half,
                    layer,
                    radii,
                }))
            }
            FormKind::Hanging => {
                let radius = form.radius + (-low).max(0.0);
                let over = FRAC_PI_2 * radius;
                Shape::Hanging {
                    profile: profile(Bend::Rail { radius }),
                    over,
                    growth: FOLDS_GROW * (half - over).max(form.wavelength),
                    fold: form.wavelength,
                    steepest,
                }
            }
            FormKind::Net => Shape::Net(Net::new(&form.net)),
            FormKind::Height => match &form.pixels {
                None => return Ok(None),
                Some(image) => Shape::Height(HeightMap::new(image, form.height, form.smooth, size)),
            },
        };
        Ok(Some(Self { shape, along, size }))
    }

    /// The point of the ground weave's middle that lies at (x, y) of the flat sheet, mm.
    pub fn point(&self, sheet: DVec2) -> DVec3 {
        let (place, across) = match self.along {
            BentAlong::Warp => (sheet.y, sheet.x),
            BentAlong::Weft => (sheet.x, sheet.y),
        };
        let (way, across, up) = match &self.shape {
            Shape::Bent(profile) => {
                let point = profile.at(place);
                (point.x, across, point.y)
            }
            Shape::Hanging {
                profile,
                over,
                growth,
                fold,
                steepest,
            } => {
                let below = (place.abs() - over).max(0.0);
                let share = (below / growth).min(1.0);
                let angle = steepest * share * share * (3.0 - 2.0 * share);
                let folded = fold_at(across, *fold, angle);
                let direction = profile.direction(place);
                // Both halves fold to the same side of the world, so that they never meet.
                let outwards = DVec2::new(-direction.y, direction.x) * place.signum();
                let point = profile.at(place) + outwards * folded.y;
                (point.x, folded.x, point.y)
            }
            Shape::Net(net) => {
                let share = sheet / self.size + 0.5;
                return net.at(share.x, share.y);
            }
            Shape::Height(map) => return sheet.extend(map.height(sheet)),
        };
        match self.along {
            BentAlong::Warp => DVec3::new(across, way, up),
            BentAlong::Weft => DVec3::new(way, across, up),
        }
    }

    /// Whether some rows and columns tell how sharply it is bent anywhere.
    pub fn bends_alike(&self) -> bool {
        !matches!(self.shape, Shape::Height(_))
    }

    /// Unit normal of the front at (x, y) of the flat sheet.
    pub fn normal(&self, sheet: DVec2) -> DVec3 {
        if let Shape::Height(map) = &self.shape {
            return (-map.slope(sheet)).extend(1.0).normalize_or(DVec3::Z);
        }
        let slope = |step: DVec2| self.point(sheet + step) - self.point(sheet - step);
        let along_x = slope(DVec2::new(STEP_MM, 0.0));
        let along_y = slope(DVec2::new(0.0, STEP_MM));
        along_x.cross(along_y).normalize_or(DVec3::Z)
    }
}

/// Where a place `across` cloth comes to in folds of a length whose angle is `angle`·sin(2π·across/fold): along, and
/// out of the plane. By the series of Jacobi and Anger of cos(a·sin t) and sin(a·sin t), integrated.
fn fold_at(across: f64, fold: f64, angle: f64) -> DVec2 {
    let t = TAU * across / fold;
    let unit = fold / TAU;
    let mut along = across * bessel(0, angle);
    let mut out = 0.0;
    for k in 1..=4_u32 {
        let (even, odd) = (2 * k, 2 * k - 1);
        along += unit * 2.0 * bessel(even, angle) / f64::from(even) * (f64::from(even) * t).sin();
        out -= unit * 2.0 * bessel(odd, angle) / f64::from(odd) * (f64::from(odd) * t).cos();
    }
    DVec2::new(along, out)
}

/// Bessel's function J of an order, for arguments up to some 3: its power series.
fn bessel(order: u32, x: f64) -> f64 {
    let half = 0.5 * x;
    let mut term = (1..=order).fold(1.0, |term, k| term * half / f64::from(k));
    let mut sum = term;
    for k in 1..=12_u32 {
        term *= -half * half / f64::from(k * (k + order));
        sum += term;
    }
    sum
}
