//! The GPU backend around its shaders: slices, devices with less room, changed scenes, display, counters, targets.
//!
//! Longer than most files because one backend has all of it, and its tests share what devices lack.

use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use renderer_core::cpu::CpuBackend;
use renderer_core::design::{
    Colour, Design, EnvironmentImage, EnvironmentKind, EnvironmentReader, LengthMap, Method, Phase,
    SkeletonHeight, ToneMap,
};
use renderer_core::gpu::pipeline_key::PipelineKey;
use renderer_core::gpu::{DeviceWatch, GpuBackend, GpuContext, wanted_features};
use renderer_core::image::{Display, Picture};
use renderer_core::render::{Backend, Optimisation, RenderError, Settings};

use crate::support::compare::shows_something;
use crate::support::device::{
    compiling_gpu, context, exact_gpu, finish, finish_in_slices, gpu, on_reference, reference,
};
use crate::support::scenes::{request, small_towel};

const SIZE: [u32; 2] = [40, 35];

/// Bits of all pixels: same request, same bytes.
fn bits(picture: &Picture) -> Vec<[u32; 4]> {
    picture
        .pixels
        .iter()
        .map(|pixel| pixel.map(f32::to_bits))
        .collect()
}

#[test]
fn slices_do_not_change_the_picture() {
    let mut design = small_towel();
    design.quality.samples = 5;
    let request = request(&design, SIZE);
    let whole = finish(&mut gpu(), &request);
    let sliced = finish_in_slices(&mut gpu(), &request, Duration::ZERO);
    assert_eq!(bits(&whole), bits(&sliced));
}

#[test]
fn a_coarse_whole_picture_comes_first() {
    let request = request(&small_towel(), SIZE);
    let mut backend = gpu();
    backend.begin(&request).unwrap();
    let never = AtomicBool::new(false);
    let progress = backend.advance(Duration::ZERO, &never).unwrap();
    assert_eq!((progress.samples, progress.done), (0, false));
    let coarse = backend.picture().unwrap();
    let fine = finish(&mut backend, &request);
    for y in 0..SIZE[1] as usize {
        for x in 0..SIZE[0] as usize {
            let width = SIZE[0] as usize;
            let corner = y / 16 * 16 * width + x / 16 * 16;
            assert_eq!(coarse.pixels[y * width + x], fine.pixels[corner], "{x},{y}");
        }
    }
}

#[test]
fn cancelled_work_stops_and_goes_on() {
    let request = request(&small_towel(), SIZE);
    let mut backend = gpu();
    backend.begin(&request).unwrap();
    let cancelled = AtomicBool::new(true);
    let progress = backend.advance(Duration::from_secs(9), &cancelled).unwrap();
    assert_eq!((progress.samples, progress.done), (0, false));
    let picture = finish(&mut backend, &request);
    assert_eq!(bits(&picture), bits(&finish(&mut gpu(), &request)));
}

/// A device of the tests' adapter that allows less.
fn lesser_device(lower: impl FnOnce(&mut wgpu::Limits)) -> GpuContext {
    let adapter = pollster::block_on(async {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
        instance
            .enumerate_adapters(wgpu::Backends::PRIMARY)
            .await
            .into_iter()
            .find(|adapter| adapter.get_info().name == context().info.name)
            .expect("the tests' adapter")
    });
    let mut limits = adapter.limits();
    lower(&mut limits);
    let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
        required_features: wanted_features(&adapter),
        required_limits: limits,
        ..Default::default()
    }))
    .expect("less than the adapter has");
    let watch = DeviceWatch::new(&device);
    GpuContext::from_device(device, queue, adapter.get_info(), watch).unwrap()
}

#[test]
fn a_lost_device_is_an_error_wherever_it_is_used() {
    let request = request(&small_towel(), [64, 64]);
    let never = AtomicBool::new(false);
    let is_lost = |error: RenderError| {
        // Reported as lost as soon as the device itself has said so; until then as what failed.
        matches!(error, RenderError::Lost(_) | RenderError::Device(_))
    };
    let begun = || {
        let context = lesser_device(|_| {});
        let mut backend = GpuBackend::new(context.clone()).unwrap();
        backend.begin(&request).unwrap();
        backend.advance(Duration::ZERO, &never).unwrap();
        context.device.destroy();
        (context, backend)
    };
    let (context, mut backend) = begun();
    assert!(is_lost(backend.advance(Duration::MAX, &never).unwrap_err()));
    assert!(is_lost(
        backend.begin(&request).and(backend.picture()).unwrap_err()
    ));
    context.device.poll(wgpu::PollType::Poll).unwrap();
    assert!(context.watch.lost().is_some());
    assert!(matches!(
        backend.advance(Duration::MAX, &never),
        Err(RenderError::Lost(_))
    ));
    let (_, mut backend) = begun();
    assert!(is_lost(backend.picture().unwrap_err()));
    let (_, mut backend) = begun();
    let display = Display {
        exposure: 0.0,
        tone_map: ToneMap::None,
    };
    assert!(is_lost(backend.show(display).map(|_| ()).unwrap_err()));
}

#[test]
fn pipelines_are_made_beside_the_work() {
    let never = AtomicBool::new(false);
    let first = request(&small_towel(), SIZE);
    let mut design = small_towel();
    design.pile.phase = Phase::KajiyaKay;
    design.light.sun.clear();
    let second = request(&design, SIZE);
    let [first_picture, second_picture] = [&first, &second].map(|r| finish(&mut gpu(), r));

    let mut backend = compiling_gpu();
    backend.begin_soon(&first).unwrap();
    let ready = backend.is_ready().unwrap();
    // A cancelled advance does not wait for it either.
    let progress = backend
        .advance(Duration::MAX, &AtomicBool::new(true))
        .unwrap();
    assert!(!ready && progress.samples == 0 && !progress.done);
    // Another scene before the first is ready: its own pipeline is made, and nothing is drawn with another's.
    backend.begin_soon(&second).unwrap();
    assert_eq!(backend.advance(Duration::ZERO, &never).unwrap().samples, 0);
    assert_eq!(bits(&finish(&mut backend, &second)), bits(&second_picture));
    // Back again; and both are there from now on.
    backend.begin_soon(&first).unwrap();
    while !backend
        .advance(Duration::from_secs(1), &never)
        .unwrap()
        .done
    {}
    assert_eq!(bits(&backend.picture().unwrap()), bits(&first_picture));
    for request in [&second, &first] {
        backend.begin_soon(request).unwrap();
        assert!(backend.is_ready().unwrap());
    }
    // Dropped at work.
    let mut dropped = compiling_gpu();
    dropped.begin_soon(&first).unwrap();
}

#[test]
fn a_device_lost_while_it_compiles_is_an_error() {
    let context = lesser_device(|_| {});
    let mut backend = GpuBackend::new(context.clone()).unwrap();
    backend.begin_soon(&request(&small_towel(), SIZE)).unwrap();
    context.device.destroy();
    let never = AtomicBool::new(false);
    let error = backend
        .advance(Duration::from_secs(120), &never)
        .unwrap_err();
    assert!(
        matches!(error, RenderError::Lost(_) | RenderError::Device(_)),
        "{error}"
    );
}

#[test]
fn a_pipeline_with_everything_in_it_draws_the_same() {
    let mut design = small_towel();
    design.light.environment.radiance = 0.0;
    let mut gpu = gpu();
    for method in [Method::Single, Method::Tracked] {
        design.quality.method = method;
        let mut request = request(&design, SIZE);
        let special = finish(&mut gpu, &request);
        request.settings.optimisations = request
            .settings
            .optimisations
            .without(Optimisation::UnusedShading);
        let needs = [&request.settings, &Settings::from(&design.quality)]
            .map(|settings| PipelineKey::new(request.scene(), settings, false));
        assert_ne!(needs[0], needs[1]);
        assert_eq!(bits(&finish(&mut gpu, &request)), bits(&special));
    }
}

#[test]
fn a_baseline_sample_costs_little_and_leaves_nothing_behind() {
    let request = request(&small_towel(), [150, 130]);
    let mut backend = gpu();
    let picture = finish(&mut backend, &request);
    backend.begin(&request).unwrap();
    let start = Instant::now();
    let bare = backend.baseline_sample().unwrap().expect("on a GPU");
    // It is the least of five means over 16 samples that were drawn meanwhile: at most an eightieth on the same clock,
    // however busy the machine.
    assert!(
        bare > Duration::ZERO && bare <= start.elapsed() / 80,
        "{bare:?}"
    );
    assert_eq!(bits(&finish(&mut backend, &request)), bits(&picture));
    assert_eq!(CpuBackend::default().baseline_sample().unwrap(), None);
}

#[test]
fn a_picture_larger_than_a_buffer_is_the_same() {
    let mut request = request(&small_towel(), [110, 75]);
    request.settings.samples = 16;
    // Room for the sums of 16 tiles of 35, and for the scene and the bases of rays.
    let small = lesser_device(|limits| limits.max_storage_buffer_binding_size = 16 * 256 * 32);
    let mut backend = GpuBackend::new(small).unwrap();
    let picture = finish(&mut backend, &request);
    let mut whole = gpu();
    assert_eq!(bits(&picture), bits(&finish(&mut whole, &request)));
    // So is the estimate of its error.
    let never = AtomicBool::new(false);
    let error_of = |backend: &mut GpuBackend| {
        backend.begin(&request).unwrap();
        let progress = backend.advance(Duration::ZERO, &never).unwrap();
        progress.error_estimate.expect("enough samples")
    };
    assert_eq!(error_of(&mut backend), error_of(&mut whole));
    // The display is put together from the same buffers.
    let shown = shown(&mut backend, ToneMap::None);
    assert_displays(&picture, &shown, ToneMap::None);
}

#[test]
fn what_is_beyond_the_adapter_is_reported_with_numbers() {
    let small = lesser_device(|limits| {
        limits.max_storage_buffer_binding_size = 16_384;
        limits.max_texture_dimension_3d = 256;
    });
    let mut backend = GpuBackend::new(small).unwrap();
    let mut design = small_towel();
    let mut refusal = |design: &Design| match backend.begin(&request(design, [8, 8])) {
        Err(RenderError::BeyondAdapter {
            what,
            value,
            limit,
            adapter,
        }) => {
            assert_eq!(adapter, context().info.name);
            (what, value, limit)
        }
        other => panic!("{other:?}"),
    };
    design.pile.layers = 64;
    design.pile.variants = 5;
    assert_eq!(
        refusal(&design),
        (
            "pile.layers times pile.variants times the kinds of pile in use",
            320,
            256
        )
    );
    design.sheet.warps = 4000;
    let (what, value, limit) = refusal(&design);
    assert!(
        what.contains("loop shapes") && value > 16_384 && limit == 16_384,
        "{what} {value}"
    );
}

#[test]
fn sizes_are_checked() {
    let mut request = request(&small_towel(), SIZE);
    for (size, crop, says) in [
        ([0, 4], [0, 0, 1, 1], "0x4"),
        ([4, 20_000], [0, 0, 1, 1], "4x20000"),
        ([4, 4], [1, 1, 4, 1], "1,1,4,1"),
        ([4, 4], [0, 0, 0, 1], "0,0,0,1"),
        ([4, 4], [0, u32::MAX, 1, 2], "inside 4x4"),
    ] {
        (request.size, request.crop) = (size, crop);
        match gpu().begin(&request) {
            Err(RenderError::Size(message)) => assert!(message.contains(says), "{message}"),
            other => panic!("{size:?} {crop:?}: {other:?}"),
        }
    }
}

/// Surroundings of 8 × 4 pixels, the first `bright` columns white.
fn sky(bright: usize) -> EnvironmentImage {
    let mut reader = EnvironmentReader::new(8, 4).unwrap();
    for k in 0..32 {
        reader.add(k % 8, k / 8, [f32::from(u8::from(k % 8 < bright)); 3]);
    }
    reader.finish().unwrap()
}

/// What changes, and how.
type Edit = (&'static str, fn(&mut Design));

#[test]
fn a_changed_scene_is_drawn_as_by_a_new_backend() {
    assert_changes_are_drawn_as_by_a_new_backend(&|| Box::new(gpu()));
}

/// A backend that has drawn other scenes draws the next one as if it were its first.
pub fn assert_changes_are_drawn_as_by_a_new_backend(new: &dyn Fn() -> Box<dyn Backend>) {
    let edits: [Edit; 13] = [
        ("looks", |d| d.chart.colour = Colour([90, 30, 200])),
        ("loops", |d| d.turbulence.seed += 1),
        ("length", |d| {
            (d.length.map, d.length.value) = (LengthMap::Constant, 2.0);
        }),
        ("volumes", |d| d.pile.layers = 3),
        ("tangents", |d| d.pile.phase = Phase::KajiyaKay),
        ("exponent", |d| d.pile.exponent = 40.0),
        ("skeleton", |d| d.skeleton.height = SkeletonHeight::Paper),
        ("lights", |d| d.light.sun[0].elevation = 20.0),
        ("gradient", |d| {
            d.light.environment.kind = EnvironmentKind::Gradient;
        }),
        ("picture", |d| {
            let environment = &mut d.light.environment;
            (environment.kind, environment.image) = (EnvironmentKind::Image, Some("sky".into()));
            environment.pixels = Some(sky(2));
        }),
        ("another picture", |d| {
            d.light.environment.pixels = Some(sky(7));
        }),
        ("a turned picture", |d| d.light.environment.rotation = 60.0),
        ("sheet", |d| d.sheet.warps_per_cm = 11.0),
    ];
    let mut design = small_towel();
    let mut compiler = renderer_core::scene::Compiler::default();
    let mut kept = new();
    let mut made = |design: &Design| {
        let mut request = request(design, SIZE);
        request.view.levels.nearest.scene = compiler.compile(design).unwrap();
        request
    };
    let mut before = finish(kept.as_mut(), &made(&design));
    for (what, edit) in edits {
        edit(&mut design);
        let request = made(&design);
        let picture = finish(kept.as_mut(), &request);
        shows_something(&picture).unwrap_or_else(|error| panic!("{what}: {error}"));
        assert_ne!(bits(&picture), bits(&before), "{what} shows");
        assert_eq!(
            bits(&picture),
            bits(&finish(new().as_mut(), &request)),
            "{what}"
        );
        before = picture;
    }
}

#[test]
fn targets_may_grow_and_other_changes_start_again() {
    let mut request = request(&small_towel(), SIZE);
    let mut backend = gpu();
    request.settings.samples = 2;
    finish(&mut backend, &request);
    request.settings.samples = 7;
    backend.begin(&request).unwrap();
    let never = AtomicBool::new(false);
    assert!(backend.advance(Duration::ZERO, &never).unwrap().samples >= 2);
    let grown = finish(&mut backend, &request);
    assert_eq!(bits(&grown), bits(&finish(&mut gpu(), &request)));
    request.settings.seed += 1;
    backend.begin(&request).unwrap();
    assert_eq!(backend.advance(Duration::ZERO, &never).unwrap().samples, 0);
}

#[test]
fn the_error_estimate_is_the_references_and_ends_the_picture() {
    let mut design = small_towel();
    design.quality.samples = 4096;
    design.quality.error = 0.15;
    let request = request(&design, SIZE);
    let never = AtomicBool::new(false);
    let mut ends = Vec::new();
    for backend in [
        &mut reference() as &mut dyn Backend,
        &mut exact_gpu(),
        &mut CpuBackend::default(),
    ] {
        backend.begin(&request).unwrap();
        let mut progress = backend.advance(Duration::ZERO, &never).unwrap();
        while !progress.done {
            progress = backend.advance(Duration::from_secs(1), &never).unwrap();
        }
        ends.push((
            progress.samples,
            progress.error_estimate.expect("enough samples"),
        ));
    }
    let (samples, expected) = ends[0];
    assert!(
        (16..4096).contains(&samples) && expected <= 0.15,
        "{samples} {expected}"
    );
    for &(other, error) in &ends[1..] {
        assert_eq!(samples, other);
        // The same samples but for a few that turn on rounding.
        assert!((error - expected).abs() < 0.01 * expected, "{ends:?}");
    }
}

#[test]
fn counters_are_the_references_but_for_what_is_skipped() {
    for (method, bounces) in [(Method::Single, 1), (Method::Layered, 1)] {
        let mut design = small_towel();
        (design.quality.method, design.quality.bounces) = (method, bounces);
        let mut request = request(&design, SIZE);
        let mut backend = exact_gpu();
        finish(&mut backend, &request);
        assert_eq!(backend.counters().unwrap(), Default::default());
        request.settings.counters = true;
        finish(&mut backend, &request);
        let gpu = backend.counters().unwrap();
        let mut plain = reference();
        finish(&mut plain, &request);
        let all = plain.counters().unwrap();
        assert_eq!(gpu.rays, all.rays);
        assert_eq!(gpu.rays, u64::from(SIZE[0] * SIZE[1]));
        // A ray near an edge may turn on rounding.
        assert!(gpu.shadow_rays.abs_diff(all.shadow_rays) <= 2);
        // What lies behind ground yarns, or behind the event that ends a ray, is not looked at. The device tells apart
        // what a ray passes in a block as a whole, the reference piece by piece: a few tests more.
        for (name, gpu, all) in [
            ("cells", gpu.cells, all.cells),
            ("patch tests", gpu.patch_tests, all.patch_tests),
            ("volume samples", gpu.volume_samples, all.volume_samples),
            ("hits", gpu.contributing_hits, all.contributing_hits),
        ] {
            assert!(
                gpu > all / 3 && gpu <= all + all / 20,
                "{name}: {gpu} of {all}"
            );
        }
    }
}

#[test]
fn extra_channels_are_the_references() {
    let mut request = request(&small_towel(), SIZE);
    request.settings.aov = true;
    let expected = on_reference(&request).aov.expect("asked for");
    for backend in [
        &mut exact_gpu() as &mut dyn Backend,
        &mut CpuBackend::default(),
    ] {
        let drawn = finish(backend, &request).aov.expect("asked for");
        let mut covered = 0;
        for index in 0..drawn.depth.len() {
            covered += u32::from(expected.depth[index] > 0.0);
            let near = |a: f32, b: f32| (a - b).abs() <= 1e-3;
            let same = near(drawn.depth[index], expected.depth[index])
                && (0..3).all(|c| {
                    near(drawn.normal[index][c], expected.normal[index][c])
                        && near(drawn.albedo[index][c], expected.albedo[index][c])
                });
            assert!(
                same,
                "{}, pixel {index}: {} {}",
                backend.kind().name(),
                drawn.depth[index],
                expected.depth[index]
            );
        }
        assert!(covered > 300, "{covered}");
    }
}

/// The display texture's bytes.
fn shown(backend: &mut GpuBackend, tone_map: ToneMap) -> Vec<[u8; 4]> {
    let context = backend.context().clone();
    let display = Display {
        exposure: 0.4,
        tone_map,
    };
    let texture = backend.show(display).unwrap().expect("a picture").clone();
    let (width, height) = (texture.width(), texture.height());
    let row = (4 * width).next_multiple_of(256);
    let buffer = context.device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: u64::from(row * height),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = context
        .device
        .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    encoder.copy_texture_to_buffer(
        texture.as_image_copy(),
        wgpu::TexelCopyBufferInfo {
            buffer: &buffer,
            layout: wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(row),
                rows_per_image: None,
            },
        },
        texture.size(),
    );
    context.queue.submit([encoder.finish()]);
    buffer
        .slice(..)
        .map_async(wgpu::MapMode::Read, |result| result.unwrap());
    context
        .device
        .poll(wgpu::PollType::wait_indefinitely())
        .unwrap();
    let bytes = buffer.slice(..).get_mapped_range().unwrap().to_vec();
    bytes
        .chunks_exact(row as usize)
        .flat_map(|row| row[..4 * width as usize].chunks_exact(4))
        .map(|texel| [texel[0], texel[1], texel[2], texel[3]])
        .collect()
}

fn assert_displays(picture: &Picture, shown: &[[u8; 4]], tone_map: ToneMap) {
    let display = Display {
        exposure: 0.4,
        tone_map,
    };
    assert_eq!(shown.len(), picture.pixels.len());
    for (pixel, texel) in picture.pixels.iter().zip(shown) {
        let expected = display.encode([pixel[0], pixel[1], pixel[2]]);
        for (channel, value) in expected.into_iter().enumerate() {
            // Half a step of rounding, and f32 powers.
            let off = (value * 255.0 - f64::from(texel[channel])).abs();
            assert!(off < 0.51, "{pixel:?} {texel:?} {expected:?}");
        }
        assert_eq!(texel[3], 255);
    }
}

#[test]
fn the_display_texture_shows_what_files_show() {
    let mut design = small_towel();
    design.quality.samples = 3;
    let mut backend = gpu();
    assert!(
        backend
            .show(Display {
                exposure: 0.0,
                tone_map: ToneMap::None
            })
            .unwrap()
            .is_none()
    );
    let picture = finish(&mut backend, &request(&design, SIZE));
    let plain = shown(&mut backend, ToneMap::None);
    assert_displays(&picture, &plain, ToneMap::None);
    let filmic = shown(&mut backend, ToneMap::Filmic);
    assert_displays(&picture, &filmic, ToneMap::Filmic);
    assert_ne!(plain, filmic);
    // Another size, another texture.
    let picture = finish(&mut backend, &request(&design, [70, 9]));
    assert_displays(&picture, &shown(&mut backend, ToneMap::None), ToneMap::None);
}

#[test]
fn six_faces_are_left_to_the_processor() {
    let mut design = small_towel();
    design.quality.method = Method::SixFace;
    let error = gpu().begin(&request(&design, SIZE)).unwrap_err();
    let said = error.to_string();
    assert!(said.ends_with("does not draw by method six-face"), "{said}");
}
