//! Same sample, same ray: sample k of a pixel is the same in the reference and on the GPU, for the presets that are
//! unlike each other and every method without free paths, to the digits that f32 has (bounces = 1). `cpu` holds the
//! processor to the same.

use std::path::PathBuf;

use renderer_core::design::{CameraDesign, Design, FormKind, Method};
use renderer_core::image::{Picture, metrics};
use renderer_core::render::{Backend, BackendKind};

use crate::form::nearly_same;
use crate::support::device::{exact_gpu, finish, gpu, on_reference};
use crate::support::same_sample::{SAME_SHARE, same_picture};
use crate::support::scenes::{load_design, preset_path, request, small_towel};
use crate::support::unlike::unlike_preset_paths;

/// The methods whose samples are the same in the reference and on the GPU.
const METHODS: [Method; 3] = [Method::Single, Method::Layered, Method::Exact];

/// Presets with their names, with one scattering.
fn named(paths: Vec<PathBuf>) -> impl Iterator<Item = (String, Design)> {
    paths.into_iter().map(|path| {
        let mut design = load_design(&path);
        design.quality.bounces = 1;
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        (name, design)
    })
}

/// Most flips in a picture of 128 × 128 pixels.
pub const MOST_FLIPS: usize = ((1.0 - SAME_SHARE) * 128.0 * 128.0) as usize;
/// A part of that picture, and most flips in it: a thousandth would be one pixel; by chance it is now and then four.
pub const PART: ([u32; 4], usize) = ([40, 50, 40, 24], 4);

/// Draws presets, or a part of each, by every method and compares with the reference.
pub fn compare_presets(
    paths: Vec<PathBuf>,
    backend: &mut dyn Backend,
    methods: &[Method],
    samples: &[u32],
    crop: Option<[u32; 4]>,
    most_flips: usize,
) {
    for (name, mut design) in named(paths) {
        let is_bent = design.form.kind != FormKind::Flat;
        for &method in methods {
            for &count in samples {
                (design.quality.method, design.quality.samples) = (method, count);
                let mut request = request(&design, [128, 128]);
                request.crop = crop.unwrap_or(request.crop);
                let expected = on_reference(&request);
                let drawn = finish(backend, &request);
                let what = format!("{name}, {}, {count} samples", method.name());
                // Flips of `layered`, one in several ten thousand pixels, are not all at edges that a nudge of the
                // camera's ray finds: one that was looked into is at an edge of the shadow ray.
                let traced = method != Method::Layered;
                let agreement = if is_bent && backend.kind() == BackendKind::Gpu {
                    nearly_same(&expected, &drawn, 0.01)
                } else {
                    same_picture(&request, &expected, &drawn, most_flips, traced)
                        .map(|found| eprintln!("{what}: {found:?}"))
                };
                agreement.unwrap_or_else(|error| panic!("{what}: {error}"));
            }
        }
    }
}

#[test]
#[ignore = "long: minutes on software Vulkan"]
fn unlike_presets_are_the_same_picture_on_both_sides() {
    let (_, paths) = in_part_and_whole();
    compare_presets(paths, &mut exact_gpu(), &METHODS, &[1, 4], None, MOST_FLIPS);
}

/// Presets whose whole pictures take software Vulkan minutes each, and those that are drawn whole in the long test.
fn in_part_and_whole() -> (Vec<PathBuf>, Vec<PathBuf>) {
    let in_part = ["fur", "hanging-towel", "velour-bath", "velvet"].map(preset_path);
    let is_in_part = |path: &PathBuf| in_part.contains(path);
    unlike_preset_paths().into_iter().partition(is_in_part)
}

#[test]
fn a_part_of_unlike_presets_is_the_same_on_both_sides() {
    // `single` draws all presets in `gpu_vs_reference`. The other two take turns where the long test draws both.
    let (in_part, whole) = in_part_and_whole();
    let mut gpu = exact_gpu();
    let mut compare = |paths: Vec<PathBuf>, methods: &[Method]| {
        let (crop, flips) = PART;
        compare_presets(paths, &mut gpu, methods, &[1], Some(crop), flips);
    };
    compare(in_part, &METHODS[1..]);
    for (k, path) in whole.into_iter().enumerate() {
        compare(vec![path], &METHODS[1 + k % 2..][..1]);
    }
}

#[test]
fn the_hardware_filter_adds_little() {
    // Sampler weights have 8 bits: a density is off by up to 1/512 of a step from voxel to voxel, in u and in v. The
    // picture with f32 weights draws the same samples, so that nothing else differs; but where one event is taken for
    // the next, a pixel of one sample changes altogether: fur, with the finest pile, has 0.15 by `exact`, all others
    // less. Such errors have no preferred sign: the mean stays (0.005 at most). It is the pile that counts: all lie flat
    // in one light, so that few pipelines draw them.
    let (mut hardware, mut f32_filter) = (gpu(), exact_gpu());
    let (mut worst, mut worst_shift) = (0.0_f64, 0.0_f64);
    for (name, mut design) in named(unlike_preset_paths()) {
        design.quality.samples = 1;
        design.light = small_towel().light;
        design.skeleton.visible = false;
        if design.form.kind != FormKind::Flat {
            design.form.kind = FormKind::Flat;
            design.view.cameras = vec![CameraDesign::default()];
        }
        for method in [Method::Single, Method::Exact] {
            design.quality.method = method;
            let mut request = request(&design, [128, 128]);
            request.crop = [36, 36, 36, 36];
            let [a, b] = [&mut f32_filter, &mut hardware].map(|gpu| finish(gpu, &request));
            let error = metrics::rel_rmse(&b, &a).unwrap();
            let shift = metrics::mean_luminance(&b) / metrics::mean_luminance(&a) - 1.0;
            eprintln!(
                "{name}, {}: relRMSE {error:.4}, mean {shift:+.5}",
                method.name()
            );
            worst = worst.max(error);
            worst_shift = worst_shift.max(shift.abs());
        }
    }
    eprintln!("hardware filter: relRMSE at most {worst:.4}, mean within {worst_shift:.5}");
    assert!(
        worst > 0.0,
        "the hardware's filter is not the one with f32 weights"
    );
    assert!(worst < 0.3 && worst_shift < 0.01, "{worst} {worst_shift}");
}

#[test]
fn the_comparator_refuses_wrong_pictures() {
    let mut design = small_towel();
    design.quality.samples = 4;
    let request = request(&design, [48, 40]);
    let right = on_reference(&request);
    let refused = |wrong: &Picture| same_picture(&request, &right, wrong, 2, true).is_err();
    assert!(!refused(&right));

    let changed = |change: &dyn Fn(&mut Picture)| {
        let mut picture = right.clone();
        change(&mut picture);
        picture
    };
    assert!(
        refused(&changed(&|picture| picture.pixels.reverse())),
        "turned"
    );
    assert!(
        refused(&changed(&|picture| picture.pixels.rotate_right(1))),
        "shifted"
    );
    assert!(
        refused(&changed(&|picture| picture.size = [40, 48])),
        "of another size"
    );
    let brighter = |by: f32| {
        changed(&|picture| {
            for pixel in &mut picture.pixels {
                *pixel = pixel.map(|value| value * by);
            }
        })
    };
    assert!(!refused(&brighter(1.0002)));
    assert!(refused(&brighter(1.002)), "a little brighter");
    // One pixel that no nudge explains; the brightest, which no nudge makes brighter.
    let luminance = |pixel: &[f32; 4]| pixel[0] + pixel[1] + pixel[2];
    let brightest = |picture: &Picture| {
        let pixels = picture.pixels.iter().enumerate();
        let (index, _) = pixels
            .max_by(|a, b| luminance(a.1).total_cmp(&luminance(b.1)))
            .unwrap();
        index
    };
    for by in [1.005, 2.0, f32::NAN] {
        let wrong = changed(&|picture| {
            let index = brightest(picture);
            picture.pixels[index][1] *= by;
        });
        assert!(refused(&wrong), "one pixel times {by}");
    }
    let samples_of_another = on_reference(&{
        let mut other = request.clone();
        other.settings.seed += 1;
        other
    });
    assert!(refused(&samples_of_another), "other samples");
}
