//! `tracked` pictures of the GPU against the reference's: 256 samples a pixel on each side, as 16 pictures of 16 with
//! seeds of their own, compared pixel by pixel.

use renderer_core::design::{Colour, Design, Method, Pattern, Phase};
use renderer_core::image::Picture;
use renderer_core::render::{Backend, Optimisation, RenderRequest};

use crate::support::agreement::same_distribution;
use crate::support::closed::closed;
use crate::support::device::{gpu, reference, repeats};
use crate::support::scenes::{Case, load_design, request, small_towel};
use crate::support::unlike::unlike_preset_paths;

/// Width and height of the pictures that are compared.
pub const SIZE: [u32; 2] = [16, 12];
/// Samples of one picture: 16 pictures have 256.
const SAMPLES: u32 = 16;

/// Without what takes noise away, which the reference does not: what that is worth is another test's.
fn on_backend<'a>(
    backend: &mut dyn Backend,
    case: impl Into<Case<'a>>,
    size: [u32; 2],
) -> Vec<Picture> {
    repeats(backend, &noisy(request(case, size)), 31_000)
}

/// A picture with all its noise.
pub fn noisy(mut request: RenderRequest) -> RenderRequest {
    let optimisations = request.settings.optimisations;
    request.settings.optimisations = optimisations
        .without(Optimisation::WeighedEvents)
        .without(Optimisation::LastLooks)
        .without(Optimisation::LaterLights);
    request
}

fn on_reference<'a>(case: impl Into<Case<'a>>, size: [u32; 2]) -> Vec<Picture> {
    repeats(&mut reference(), &noisy(request(case, size)), 47_000)
}

/// A design by `tracked`, as many samples as one of the pictures that are compared.
pub fn tracked(mut design: Design, bounces: u32) -> Design {
    design.quality.method = Method::Tracked;
    (design.quality.samples, design.quality.bounces) = (SAMPLES, bounces);
    design
}

/// Loops so thin that light passes through several, lit from where they are seen: how bright they are follows their
/// density, and the share of light that the phase sends back.
pub fn thin_towel() -> Design {
    let mut design = small_towel();
    (design.pile.density, design.skeleton.visible) = (1.0, false);
    design.pile.phase = Phase::FrameLambert;
    design.pile.transmission = 0.3;
    let light = &mut design.light;
    (light.sun[0].azimuth, light.sun[0].elevation) = (-90.0, 45.0);
    (light.sun[0].irradiance, light.environment.radiance) = (4.0, 0.05);
    light.background = Colour([0; 3]);
    design.view.cameras[0].distance = 18.0;
    design
}

/// The towel before a bright wall: what is seen is what passes through.
pub fn backlit_towel() -> Design {
    let mut design = thin_towel();
    design.light.sun.clear();
    design.light.environment.radiance = 0.0;
    design.light.background = Colour::WHITE;
    design
}

/// A slightly wrong design, and what is wrong with it.
pub type Wrong = (&'static str, fn(&mut Design));

/// The backend's pictures are draws of what the reference's are draws of, and those of wrong designs are not; the test
/// can tell a relative difference of `bias` of the whole.
pub fn assert_agree_and_tell<'a>(
    backend: &mut dyn Backend,
    case: impl Into<Case<'a>>,
    size: [u32; 2],
    wrongs: &[Wrong],
    bias: f64,
) {
    let case = case.into();
    let expected = on_reference(case, size);
    let power = same_distribution(&expected, &on_backend(backend, case, size)).unwrap();
    // In one pixel of 256 samples much less can be said.
    assert!(power.whole < bias && power.pixel < 50.0 * bias, "{power:?}");
    for (what, wrong) in wrongs {
        let mut design = case.design.clone();
        wrong(&mut design);
        let wrong = closed(&design, case.traced_bounces);
        let other = on_backend(backend, wrong, size);
        assert!(
            same_distribution(&expected, &other).is_err(),
            "{what}: {power:?}"
        );
    }
}

/// Once through thin loops, and once scattered by them, with what each tells best.
pub fn one_scattering(
    backend: &mut dyn Backend,
    size: [u32; 2],
    through: &[Wrong],
    scattered: &[Wrong],
    biases: [f64; 2],
) {
    let [by_background, by_sun] = [backlit_towel(), thin_towel()].map(|towel| tracked(towel, 1));
    assert_agree_and_tell(backend, &by_background, size, through, biases[0]);
    assert_agree_and_tell(backend, &by_sun, size, scattered, biases[1]);
}

#[test]
fn one_scattering_agrees_at_256_samples() {
    one_scattering(
        &mut gpu(),
        SIZE,
        &[("density", |d| d.pile.density *= 1.15)],
        &[("phase", |d| d.pile.transmission = 0.45)],
        [0.05, 0.1],
    );
}

#[test]
#[ignore = "long: about 30 s"]
fn one_scattering_agrees_at_256_samples_to_a_few_percent() {
    one_scattering(
        &mut gpu(),
        [64, 48],
        &[
            ("density + 3 %", |d| d.pile.density *= 1.03),
            ("a missing loop", |d| {
                d.weave.pattern = without_a_loop(&d.weave.pattern);
            }),
        ],
        &[("phase", |d| d.pile.transmission = 0.33)],
        [0.01, 0.026],
    );
}

#[test]
fn several_scatterings_agree_at_256_samples() {
    assert_agree_and_tell(
        &mut gpu(),
        &tracked(small_towel(), 5),
        SIZE,
        &[("one bounce less", |d| d.quality.bounces = 4)],
        0.03,
    );
}

/// The pattern over the whole of a small towel, less one loop in its middle.
fn without_a_loop(pattern: &Pattern) -> Pattern {
    let mut whole = Pattern::filled(12, 10, 0);
    for row in 0..10 {
        for column in 0..12 {
            whole.set(column, row, pattern.at(column as i64, row as i64));
        }
    }
    let (column, row) = (4..8)
        .flat_map(|column| (3..7).map(move |row| (column, row)))
        .find(|&(column, row)| whole.at(column as i64, row as i64) == 7)
        .unwrap();
    // The warp stays over.
    whole.set(column, row, 1);
    whole
}

#[test]
fn wrong_noise_and_wrong_pixels_are_refused() {
    let design = tracked(thin_towel(), 1);
    let expected = on_reference(&design, SIZE);
    let same = repeats(&mut reference(), &request(&design, SIZE), 90_000);
    same_distribution(&expected, &same).unwrap();

    // The same mean from half as many samples: twice the variance.
    let mut noisier = design.clone();
    noisier.quality.samples = SAMPLES / 2;
    let message = same_distribution(&expected, &on_reference(&noisier, SIZE)).unwrap_err();
    assert!(message.starts_with("noise"), "{message}");

    // One pixel of all is twice as bright; pictures are upside down; not a number.
    let changed = |change: fn(&mut Picture)| {
        let mut pictures = same.clone();
        pictures.iter_mut().for_each(change);
        same_distribution(&expected, &pictures)
    };
    assert!(changed(|picture| picture.pixels[100] = picture.pixels[100].map(|x| x * 2.0)).is_err());
    assert!(changed(|picture| picture.pixels.reverse()).is_err());
    assert!(changed(|picture| picture.pixels[7][1] = f32::NAN).is_err());
}

#[test]
#[ignore = "long: about 120 s"]
fn unlike_presets_agree_at_256_samples() {
    unlike_presets_agree(&mut gpu());
}

/// Presets with one and with several scatterings.
pub fn unlike_presets_agree(backend: &mut dyn Backend) {
    for path in unlike_preset_paths() {
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        for bounces in [1, 4] {
            let design = load_design(&path);
            let design = tracked(design, bounces);
            let expected = on_reference(&design, SIZE);
            let power = same_distribution(&expected, &on_backend(backend, &design, SIZE))
                .unwrap_or_else(|error| panic!("{name}, {bounces} bounces: {error}"));
            eprintln!("{name}, {bounces} bounces: {power:?}");
            // What a picture of so few pixels can tell: the paper's presets are almost black where the sun does not
            // reach.
            assert!(power.whole < 0.15, "{name}, {bounces} bounces: {power:?}");
        }
    }
}
