//! Whole paths: closed forms of light in a block, suns with a size, the furnace, the skeleton's Lambert.

use std::f64::consts::PI;

use glam::DVec3;
use renderer_core::design::{Design, Interpolation, Method, Phase};
use renderer_core::geometry::Camera;
use renderer_core::reference::{Scratch, Tracer};
use renderer_core::render::RenderRequest;
use renderer_core::scene::{Scene, Section, compile};

use super::cloth::{
    ALL_PHASES, block, block_extent, edit_lights, edit_pile, needle_camera, request, sun,
    wild_towel,
};

/// Mean radiance (red) of the first `samples` samples of 16 × 16 pixels, the deviation of that mean, and mean alpha.
fn mean_radiance(request: &RenderRequest, samples: u32) -> (f64, f64, f64) {
    let tracer = Tracer::new(request);
    let mut scratch = Scratch::default();
    let (mut sum, mut squares, mut alpha) = (0.0, 0.0, 0.0);
    for y in 0..16 {
        for x in 0..16 {
            let mut pixel = 0.0;
            for k in 0..samples {
                let sample = tracer.sample([x, y], k, &mut scratch);
                assert!(sample.radiance.is_finite());
                pixel += sample.radiance.x / f64::from(samples);
                alpha += f64::from(u8::from(sample.first.is_some()));
            }
            sum += pixel;
            squares += pixel * pixel;
        }
    }
    // Pixels are independent, samples of one pixel are not.
    let mean = sum / 256.0;
    let deviation = ((squares / 256.0 - mean * mean).max(0.0) / 256.0).sqrt();
    (mean, deviation, alpha / (256.0 * f64::from(samples)))
}

/// A request by another camera than the default.
fn from(camera: Camera, scene: Scene, method: Method, bounces: u32) -> RenderRequest {
    let mut request = request(scene, method, bounces);
    request.view.levels.nearest.camera = camera;
    request
}

/// A request that looks along −x at the middle of a block.
fn look_at_block(scene: Scene, method: Method, bounces: u32) -> RenderRequest {
    let (middle, _) = block_extent(&scene);
    from(needle_camera(middle, DVec3::X), scene, method, bounces)
}

#[test]
fn alpha_follows_beer_and_lambert() {
    let scene = block(5);
    let (_, half) = block_extent(&scene);
    let covered = 1.0 - (-2.0 * half.x).exp();
    for &method in Method::ALL {
        let (_, _, alpha) = mean_radiance(&look_at_block(scene.clone(), method, 1), 16);
        // A share of 4096 samples, at most ½ ± 0.0078: 4.5 of these deviations.
        assert!(
            (alpha - covered).abs() < 4.5 * 0.0078,
            "{method:?}: {alpha}, not {covered}"
        );
    }
}

#[test]
fn sunlit_block_has_its_closed_form() {
    // Seen and lit along the same line: ∫ σ e^−σs · e^−σs ds · 1/4π = (1 − e^−2σh)/8π with σ = 1/mm.
    let mut scene = block(64);
    edit_lights(&mut scene, |lights| lights.suns = vec![sun(DVec3::X, 0.0)]);
    let (_, half) = block_extent(&scene);
    let expected = (1.0 - (-4.0 * half.x).exp()) / (8.0 * PI);
    for method in [Method::Tracked, Method::Layered] {
        let request = look_at_block(scene.clone(), method, 1);
        let (mean, deviation, _) = mean_radiance(&request, 64);
        // 64 layers: a slab's own shadow on its middle is known to half a slab, 0.6 % of the thickness.
        let bias = if method == Method::Layered {
            0.006 * expected
        } else {
            0.0
        };
        assert!(
            (mean - expected).abs() < 4.5 * deviation + bias,
            "{method:?}: {mean} ± {deviation}, not {expected}"
        );
    }
    // `single` lights the whole crossing from its mean depth d: α·e^−d/4π.
    let h = 2.0 * half.x;
    let alpha = 1.0 - (-h).exp();
    let depth = 1.0 - h * (-h).exp() / alpha;
    let request = look_at_block(scene, Method::Single, 1);
    let (mean, deviation, _) = mean_radiance(&request, 64);
    let expected = alpha * (-depth).exp() / (4.0 * PI);
    // The sum over 64 slabs for the mean depth is good to their width squared.
    assert!(
        (mean - expected).abs() < 4.5 * deviation + 1e-3 * expected,
        "{mean}, not {expected}"
    );
}

#[test]
fn several_suns_add_and_colours_multiply() {
    let mut scene = block(4);
    let request_with = |scene: &Scene| look_at_block(scene.clone(), Method::Single, 1);
    edit_lights(&mut scene, |lights| lights.suns = vec![sun(DVec3::X, 0.0)]);
    let (one, ..) = mean_radiance(&request_with(&scene), 4);
    edit_lights(&mut scene, |lights| {
        lights.suns = vec![sun(DVec3::X, 0.0); 3];
    });
    let (three, ..) = mean_radiance(&request_with(&scene), 4);
    assert!((three / one - 3.0).abs() < 1e-12);

    let mut looks = scene.looks.clone().to_vec();
    for look in &mut looks {
        look.albedo = [65535 / 3, 65535 / 5, 0];
    }
    scene.looks = Section::new(looks);
    let tracer = Tracer::new(&request_with(&scene));
    let sample = (0..64)
        .map(|k| tracer.sample([0, 0], k, &mut Scratch::default()))
        .find(|sample| sample.first.is_some())
        .expect("the block is hit");
    assert!((sample.radiance.y / sample.radiance.x - 3.0 / 5.0).abs() < 1e-12);
    assert_eq!(sample.radiance.z, 0.0);
}

#[test]
fn a_wide_sun_lights_by_the_mean_over_its_disc() {
    // Lambert facing up under a sun of half-angle r at the zenith: E · albedo/π · mean cos = E·albedo/π · (1 + cos
    // r)/2. A flat yarn has no crimp; in the middle of its top the normal is straight up.
    let mut design = Design::default();
    (design.sheet.warps, design.sheet.wefts) = (1, 1);
    design.weave.pattern = renderer_core::design::Pattern::filled(1, 1, 1);
    design.skeleton.crimp = 0.0;
    let mut scene = compile(&design).expect("a valid design");
    let radius = 0.8;
    edit_lights(&mut scene, |lights| {
        lights.suns = vec![sun(DVec3::Z, radius)];
        lights.environment = [0.0; 3];
    });
    let albedo = f64::from(scene.skeleton.albedo[0]);
    let expected = albedo / PI * 0.5 * (1.0 + radius.cos());
    for &method in Method::ALL {
        let request = from(
            needle_camera(DVec3::ZERO, DVec3::Z),
            scene.clone(),
            method,
            1,
        );
        let (mean, deviation, alpha) = mean_radiance(&request, 64);
        assert_eq!(alpha, 1.0);
        assert!(
            (mean - expected).abs() < 4.5 * deviation + 1e-12,
            "{mean} ± {deviation}, not {expected}"
        );
        assert!(deviation < 1e-4, "stratified over the disc: {deviation}");
    }
    // And a constant sky: albedo · 1 wherever nothing is in the way.
    edit_lights(&mut scene, |lights| {
        lights.suns.clear();
        lights.environment = [1.0; 3];
    });
    for &method in Method::ALL {
        let request = from(
            needle_camera(DVec3::ZERO, DVec3::Z),
            scene.clone(),
            method,
            1,
        );
        let (mean, ..) = mean_radiance(&request, 4);
        assert!(
            (mean - albedo).abs() < 1e-9,
            "{method:?}: {mean}, not {albedo}"
        );
    }
}

/// The towel with white yarns everywhere under a white sky of radiance 1.
pub fn furnace(phase: Phase) -> Scene {
    let mut scene = wild_towel(Interpolation::Linear);
    let mut design = Design::default();
    design.pile.phase = phase;
    (design.sheet.warps, design.sheet.wefts) = (7, 9);
    (
        design.pile.layers,
        design.pile.resolution,
        design.pile.variants,
    ) = (4, 9, 3);
    if phase == Phase::KajiyaKay {
        // Tangents are only there where the design asks for them.
        scene = compile(&design).expect("a valid design");
    }
    edit_pile(&mut scene, |pile| pile.materials[0].phase = phase);
    let mut looks = scene.looks.clone().to_vec();
    for look in &mut looks {
        look.albedo = [u16::MAX; 3];
    }
    scene.looks = Section::new(looks);
    let mut volumes = renderer_core::scene::Volumes::clone(&scene.volumes);
    for voxel in &mut volumes.voxels {
        voxel[1] = voxel[0];
    }
    scene.volumes = Section::new(volumes);
    let mut skeleton = renderer_core::scene::Skeleton::clone(&scene.skeleton);
    (skeleton.visible, skeleton.albedo) = (true, [1.0; 3]);
    scene.skeleton = Section::new(skeleton);
    edit_lights(&mut scene, |lights| {
        lights.suns.clear();
        lights.environment = [1.0; 3];
        lights.background = [1.0; 3];
    });
    scene
}

#[test]
fn the_furnace_shows_no_cloth() {
    for &phase in ALL_PHASES {
        let mut request = request(furnace(phase), Method::Tracked, 64);
        request.size = [16, 16];
        request.view.levels.nearest.camera.eye *= 0.07;
        let tracer = Tracer::new(&request);
        let mut scratch = Scratch::default();
        let (mut sum, mut squares, mut covered) = (0.0, 0.0, 0.0);
        let samples = 16;
        for pixel in 0..256 {
            for k in 0..samples {
                let sample = tracer.sample([pixel % 16, pixel / 16], k, &mut scratch);
                let radiance = sample.radiance.x;
                if phase != Phase::KajiyaKay {
                    // Every path carries exactly 1 until it leaves.
                    assert!(
                        radiance == 0.0 || (radiance - 1.0).abs() < 1e-12,
                        "{radiance}"
                    );
                }
                sum += radiance;
                squares += radiance * radiance;
                covered += f64::from(u8::from(sample.first.is_some()));
            }
        }
        let n = 256.0 * f64::from(samples);
        let mean = sum / n;
        let deviation = ((squares / n - mean * mean) / n).sqrt();
        assert!(covered > 0.5 * n, "{covered} of {n}");
        // Never above 1; below by paths that have not left after 64 scatterings.
        assert!(
            mean < 1.0 + 4.5 * deviation,
            "{phase:?}: {mean} ± {deviation}"
        );
        assert!(mean > 0.9, "{phase:?}: {mean}");
    }
}

#[test]
fn fewer_bounces_are_darker_and_never_brighter_than_the_sky() {
    let scene = furnace(Phase::Isotropic);
    for &method in Method::ALL {
        let mut last = 0.0;
        for bounces in [1, 2, 6] {
            let mut request = request(scene.clone(), method, bounces);
            request.size = [16, 16];
            request.view.levels.nearest.camera.eye *= 0.07;
            let (mean, deviation, _) = mean_radiance(&request, 8);
            assert!(
                mean > last + deviation,
                "{method:?}, {bounces} bounces: {mean} after {last}"
            );
            last = mean;
        }
        assert!(last < 1.02, "{method:?}: {last}");
    }
}

#[test]
fn roulette_does_not_change_the_mean() {
    // A gray block in a white sky: with albedo a, the light of exactly n scatterings is aⁿ times that of a white one.
    // So the gray picture follows from the white ones of 1, 2, … bounces, which roulette leaves alone (their throughput
    // is 1).
    let gray = 0.8;
    let mut scene = block(1);
    edit_pile(&mut scene, |pile| pile.materials[0].density_per_mm = 8.0);
    edit_lights(&mut scene, |lights| lights.environment = [1.0; 3]);
    let bounces = 9;
    let samples = 256;
    let of = |scene: &Scene, bounces| {
        mean_radiance(
            &look_at_block(scene.clone(), Method::Tracked, bounces),
            samples,
        )
    };
    let (mut expected, mut last, mut variance) = (0.0, 0.0, 0.0);
    for n in 1..=bounces {
        let (mean, deviation, _) = of(&scene, n);
        expected += (mean - last) * f64::powi(gray, n as i32);
        variance += (deviation * f64::powi(gray, n as i32)).powi(2);
        last = mean;
    }
    let mut looks = scene.looks.clone().to_vec();
    for look in &mut looks {
        look.albedo = [(gray * 65535.0) as u16; 3];
    }
    scene.looks = Section::new(looks);
    let (mean, deviation, _) = of(&scene, bounces);
    let allowed = 4.5 * (variance + deviation.powi(2)).sqrt();
    assert!(
        (mean - expected).abs() < allowed,
        "{mean}, not {expected} ± {allowed}"
    );
    assert!(
        allowed < 0.04 * expected,
        "{allowed} tells nothing about {expected}"
    );
}
