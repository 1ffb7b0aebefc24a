//! Comparator of pictures that should hold the same samples, whatever their number: pixel by pixel, to rounding.

use renderer_core::image::Picture;
use renderer_core::reference::{Scratch, Tracer};
use renderer_core::render::RenderRequest;
use renderer_core::scene::Scene;

use super::compare::nudges;

/// Largest difference of a pixel that counts as the same: of its value, or of 1 where that is larger.
pub const SAME: f64 = 1e-3;
/// Smallest share of the pixels of a large picture that are the same.
pub const SAME_SHARE: f64 = 0.999;
/// Largest relRMSE over the pixels that are the same.
pub const SAME_REL_RMSE: f64 = 2e-3;
/// Smallest share of pixels that are also within [`SAME`] of their own value, down to values of 10⁻³. Dark pixels are
/// those whose light has come through a depth of 5 or more; f32 knows a point to some 10⁻⁷ mm and a ray's way through a
/// loop that it grazes to 10⁻⁶ mm, and at the border of a yarn the depth changes by hundreds in a millimetre.
pub const CLOSE_SHARE: f64 = 0.99;
const CLOSE_FLOOR: f64 = 1e-3;

/// How far two pictures agree.
#[derive(Debug, Clone, PartialEq)]
pub struct Agreement {
    /// Pixels that are not the same, each traced to an edge.
    pub flips: usize,
    /// relRMSE over the others.
    pub rel_rmse: f64,
    /// Share of all that are within [`SAME`] of their own value.
    pub close: f64,
}

/// Whether `picture` holds the same samples as the reference draws for `request`: all numbers finite, all pixels but
/// `most_flips` within [`SAME`], those at most [`SAME_REL_RMSE`] apart altogether, and, if they are to be `traced`,
/// each of the rest such that rays nudged by next to nothing, and so on one side of an edge or the other, draw what
/// `picture` holds.
pub fn same_picture(
    request: &RenderRequest,
    expected: &Picture,
    picture: &Picture,
    most_flips: usize,
    traced: bool,
) -> Result<Agreement, String> {
    if expected.size != picture.size {
        return Err(format!("sizes {:?} and {:?}", expected.size, picture.size));
    }
    let width = expected.size[0];
    let same_in_the_dark = SAME * rounding_of(request.scene()).max(1.0);
    let (mut squares, mut sum, mut close, mut flips) = (0.0, 0.0, 0, Vec::new());
    for (index, (a, b)) in (0_u32..).zip(expected.pixels.iter().zip(&picture.pixels)) {
        if !b.iter().all(|value| value.is_finite()) {
            return Err(format!("pixel {index} is {b:?}"));
        }
        close += usize::from(difference(*a, *b, CLOSE_FLOOR) <= same_in_the_dark);
        if difference(*a, *b, 1.0) > SAME {
            flips.push((index, *a, *b));
            continue;
        }
        for c in 0..3 {
            squares += (f64::from(a[c]) - f64::from(b[c])).powi(2);
            sum += f64::from(a[c]);
        }
    }
    let count = expected.pixels.len();
    let values = 3.0 * (count - flips.len()) as f64;
    let agreement = Agreement {
        flips: flips.len(),
        rel_rmse: f64::sqrt(squares / values) / (sum / values),
        close: close as f64 / count as f64,
    };
    if agreement.flips > most_flips
        || agreement.rel_rmse > SAME_REL_RMSE
        || agreement.close < CLOSE_SHARE
    {
        return Err(format!("{agreement:?} of {count} pixels"));
    }
    if !traced {
        return Ok(agreement);
    }
    let tracer = Tracer::new(request);
    for (index, a, b) in flips {
        let pixel = [
            request.crop[0] + index % width,
            request.crop[1] + index / width,
        ];
        if !is_at_an_edge(&tracer, request, pixel, [a, b]) {
            return Err(format!(
                "pixel {pixel:?} is {b:?}, not {a:?}, and not at an edge"
            ));
        }
    }
    Ok(agreement)
}

/// How much more than in terry rounding does: places in longer loops have fewer digits behind the point, and in denser
/// yarn each of them counts for more. 10/mm and 3 mm have 0.3, the densest terry among the presets 1.3, fur and grass 3
/// to 5.
fn rounding_of(scene: &Scene) -> f64 {
    let densities = scene
        .pile
        .materials
        .iter()
        .map(|material| material.density_per_mm);
    let [_, length_mm, _] = scene.volumes.reference_size_mm;
    f64::from(densities.fold(0.0, f32::max) * length_mm) / 100.0
}

/// Largest difference of the channels, relative to their values or to `floor` if that is larger.
fn difference(a: [f32; 4], b: [f32; 4], floor: f64) -> f64 {
    (0..4)
        .map(|c| {
            let (a, b) = (f64::from(a[c]), f64::from(b[c]));
            (a - b).abs() / a.abs().max(floor)
        })
        .fold(0.0, f64::max)
}

/// Share of a pixel's difference that nudged rays may leave unexplained: a ray that is nudged far enough to come to the
/// other side of an edge also sees a little more or less of everything else.
const UNEXPLAINED: f64 = 0.1;

/// Whether the reference draws `drawn` with one or two of the pixel's rays nudged.
fn is_at_an_edge(
    tracer: &Tracer,
    request: &RenderRequest,
    pixel: [u32; 2],
    [expected, drawn]: [[f32; 4]; 2],
) -> bool {
    let count = request.settings.samples;
    let value = |tracer: &Tracer, number| {
        let sample = tracer.sample(pixel, number, &mut Scratch::default());
        let [r, g, b] = sample.radiance.as_vec3().to_array();
        [r, g, b, f32::from(u8::from(sample.first.is_some()))]
    };
    // What nudging each of the rays changes in the pixel's mean; nothing, first.
    let mut changes: Vec<Vec<[f32; 4]>> = (0..count).map(|_| vec![[0.0; 4]]).collect();
    let straight: Vec<[f32; 4]> = (0..count).map(|number| value(tracer, number)).collect();
    for nudged in nudges(request) {
        let nudged = tracer.again(&nudged);
        for (number, changes) in (0..).zip(&mut changes) {
            let from = straight[number as usize];
            let to = value(&nudged, number);
            changes.push([0, 1, 2, 3].map(|c| (to[c] - from[c]) / count as f32));
        }
    }
    let allowed = SAME.max(UNEXPLAINED * difference(expected, drawn, 1.0));
    let explains = |a: &[f32; 4], b: &[f32; 4]| {
        let sum = [0, 1, 2, 3].map(|c| expected[c] + a[c] + b[c]);
        difference(sum, drawn, 1.0) <= allowed
    };
    changes.iter().enumerate().any(|(number, first)| {
        first.iter().any(|a| {
            explains(a, &[0.0; 4])
                || changes[number + 1..]
                    .iter()
                    .any(|second| second.iter().any(|b| explains(a, b)))
        })
    })
}
