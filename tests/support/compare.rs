//! Comparators of pictures. Each is tried on pictures that are wrong in a known way, which it must refuse
//! (`gpu_vs_reference::the_comparators_refuse_wrong_pictures`).

use glam::{DVec2, DVec3};

use renderer_core::design::Method;
use renderer_core::geometry::Projection;
use renderer_core::image::Picture;
use renderer_core::reference::{Scratch, Tracer};
use renderer_core::render::RenderRequest;

/// Differences up to this are rounding: a path is a few hundred f32 operations of relative error 6e-8 on lengths of
/// some mm; a voxel of a dense loop (10/mm, 0.06 mm a voxel) turns 1e-5 mm into 1e-4 of a value near 1, and a mean of a
/// few loops into some times that.
pub const ROUNDING: f32 = 1e-3;

/// Largest share of pixels that may differ by more, for reasons found by [`same_samples`].
pub const MAX_FLIPS: f64 = 0.01;

/// How far rays are moved to see what rounding could have drawn, pixels: from the rounding of a ray's own direction to
/// that of points it meets far away.
const NUDGES_PX: [f64; 7] = [1e-6, 1e-5, 1e-4, 5e-4, 2e-3, 4e-3, 8e-3];
/// Directions in which they are moved.
const NUDGE_DIRECTIONS: u32 = 16;

/// Whether `picture` holds the same samples as the reference draws, the request having one sample a pixel: each pixel
/// within [`ROUNDING`] of the reference's, but for a few where a ray passes so close to an edge that rounding decides;
/// there the reference must draw the same for a ray nudged by next to nothing.
pub fn same_samples(
    request: &RenderRequest,
    expected: &Picture,
    picture: &Picture,
) -> Result<(), String> {
    assert_eq!(request.settings.samples, 1);
    if expected.size != picture.size {
        return Err(format!("sizes {:?} and {:?}", expected.size, picture.size));
    }
    let width = expected.size[0];
    let mut flips = 0_u32;
    for (index, (a, b)) in (0..).zip(expected.pixels.iter().zip(&picture.pixels)) {
        if is_near(*a, *b) {
            continue;
        }
        flips += 1;
        let pixel = [
            request.crop[0] + index % width,
            request.crop[1] + index / width,
        ];
        if !nudged(request, pixel).any(|c| is_near(c, *b)) {
            return Err(format!("pixel {pixel:?} is {b:?}, not {a:?}, nor near it"));
        }
    }
    let share = f64::from(flips) / expected.pixels.len() as f64;
    if share > MAX_FLIPS {
        return Err(format!(
            "{flips} pixels, a share of {share:.4}, turn on rounding"
        ));
    }
    Ok(())
}

/// Most pixels of `layered` that may turn on rounding, a few in a thousand.
const MOST_LAYERED_FLIPS: usize = 4;

/// Whether a picture of one sample holds the reference's samples. By `layered` a shadow ray begins on a layer's patch,
/// which it may graze: whether it meets the patch again, twice or not at all, turns on a last digit across the patch,
/// and a nudge of the camera's ray moves points along it only. So flips of `layered` are counted, those of `single`
/// traced to an edge.
pub fn same_as_reference(
    request: &RenderRequest,
    expected: &Picture,
    drawn: &Picture,
) -> Result<(), String> {
    if request.settings.method != Method::Layered {
        return same_samples(request, expected, drawn);
    }
    let near = |(a, b): &(&[f32; 4], &[f32; 4])| {
        (0..4).all(|c| (a[c] - b[c]).abs() <= ROUNDING * a[c].abs().max(1.0))
    };
    let pairs = expected.pixels.iter().zip(&drawn.pixels);
    match pairs.filter(|pair| !near(pair)).count() {
        0..=MOST_LAYERED_FLIPS => Ok(()),
        flips => Err(format!("{flips} pixels turn on rounding")),
    }
}

/// Within rounding, absolutely and for bright values relatively; never for NaN.
fn is_near(a: [f32; 4], b: [f32; 4]) -> bool {
    (0..4).all(|c| (a[c] - b[c]).abs() <= ROUNDING * a[c].abs().max(1.0))
}

/// What the reference draws for nudged rays.
fn nudged(request: &RenderRequest, pixel: [u32; 2]) -> impl Iterator<Item = [f32; 4]> {
    nudges(request).map(move |moved| {
        let sample = Tracer::new(&moved).sample(pixel, 0, &mut Scratch::default());
        let [r, g, b] = sample.radiance.as_vec3().to_array();
        [r, g, b, f32::from(u8::from(sample.first.is_some()))]
    })
}

/// The request with its rays nudged in all directions, by little and by more.
pub fn nudges(request: &RenderRequest) -> impl Iterator<Item = RenderRequest> {
    NUDGES_PX.into_iter().flat_map(move |by| {
        (0..NUDGE_DIRECTIONS).map(move |k| {
            let angle = f64::from(k) * std::f64::consts::TAU / f64::from(NUDGE_DIRECTIONS);
            let mut moved = request.clone();
            moved.view.levels.nearest.camera = nudge(request, DVec2::from_angle(angle) * by);
            moved
        })
    })
}

/// The camera whose rays are those of `offset` pixels away.
fn nudge(request: &RenderRequest, offset: DVec2) -> renderer_core::geometry::Camera {
    let mut camera = *request.camera();
    let height = f64::from(request.size[1]);
    match camera.projection {
        Projection::Orthographic { height_mm } => {
            let shift = offset * (height_mm / height);
            camera.eye += camera.right * shift.x - camera.up * shift.y;
        }
        Projection::Perspective { fov } => {
            // Turned about the eye by the small angle of so many pixels in the middle of the picture.
            let turn = offset * (2.0 * (fov / 2.0).tan() / height);
            let forward: DVec3 = camera.forward + camera.right * turn.x - camera.up * turn.y;
            camera.forward = forward.normalize();
            camera.right =
                (camera.right - camera.forward * camera.right.dot(camera.forward)).normalize();
            camera.up = camera.right.cross(camera.forward);
        }
    }
    camera
}

/// Blocks of a picture along each side in [`same_means`].
const BLOCKS: usize = 4;

/// Largest |t| allowed, for 2 × 16 pictures: at most one in a thousand right pictures is refused. Šidák's correction
/// for the 17 tests (16 blocks and the whole) leaves 5.9e-5 a test, which Student's t with 30 degrees of freedom
/// exceeds at 4.67.
const MAX_T: f64 = 4.67;
/// Pictures on each side that [`MAX_T`] is for.
pub const REPEATS: usize = 16;

/// Whether two sets of independent pictures have the same expectation: Welch's test on the mean luminance of each of
/// 4 × 4 blocks and of the whole, over [`REPEATS`] pictures with different seeds on each side.
pub fn same_means(a: &[Picture], b: &[Picture]) -> Result<(), String> {
    assert_eq!((a.len(), b.len()), (REPEATS, REPEATS));
    for block in 0..=BLOCKS * BLOCKS {
        let means = |pictures: &[Picture]| -> Vec<f64> {
            pictures
                .iter()
                .map(|picture| block_mean(picture, block))
                .collect()
        };
        let ((mean_a, variance_a), (mean_b, variance_b)) = (moments(&means(a)), moments(&means(b)));
        let spread = ((variance_a + variance_b) / REPEATS as f64).sqrt();
        let t = (mean_a - mean_b) / spread;
        // Equal to the bit is right as well (a block that shows only background); NaN is not.
        let equal = mean_a == mean_b;
        if !(equal || t.abs() <= MAX_T) {
            return Err(format!(
                "block {block}: means {mean_a} and {mean_b}, t = {t:.2}"
            ));
        }
    }
    Ok(())
}

/// Mean luminance of one block, or of the whole picture for the number after the last.
fn block_mean(picture: &Picture, block: usize) -> f64 {
    let [width, height] = picture.size.map(|side| side as usize);
    let (mut sum, mut count) = (0.0, 0.0);
    for (index, pixel) in picture.pixels.iter().enumerate() {
        let column = index % width * BLOCKS / width;
        let row = index / width * BLOCKS / height;
        if block == BLOCKS * BLOCKS || block == row * BLOCKS + column {
            let [r, g, b, _] = pixel.map(f64::from);
            sum += 0.2126 * r + 0.7152 * g + 0.0722 * b;
            count += 1.0;
        }
    }
    sum / count
}

/// Mean and sample variance.
fn moments(values: &[f64]) -> (f64, f64) {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    (mean, squares / (count - 1.0))
}

/// Whether a picture is of numbers, and shows something: luminance varies by more than a tenth of its mean.
pub fn shows_something(picture: &Picture) -> Result<(), String> {
    if let Some(index) = picture
        .pixels
        .iter()
        .position(|pixel| !pixel.iter().all(|value| value.is_finite()))
    {
        return Err(format!("pixel {index} is {:?}", picture.pixels[index]));
    }
    let luminance: Vec<f64> = picture
        .pixels
        .iter()
        .map(|&[r, g, b, _]| f64::from(0.2126 * r + 0.7152 * g + 0.0722 * b))
        .collect();
    let (mean, variance) = moments(&luminance);
    if mean > 0.0 && variance.sqrt() > 0.1 * mean {
        Ok(())
    } else {
        Err(format!(
            "uniform: mean {mean}, deviation {}",
            variance.sqrt()
        ))
    }
}
