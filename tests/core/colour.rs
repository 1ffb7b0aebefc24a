//! Colours of finished cloth: how much light leaves white terry after each number of scatterings, which is what the
//! albedo table is made of, and pictures of uniform charts against their colour (MODEL.md §6).
//!
//! The measurement is the reference's: its rays, its free paths, its phase functions. What is this file's own is the
//! walk without lights, which counts scatterings until a ray leaves.

use std::sync::Arc;

use glam::{DVec2, DVec3};
use palette::color_difference::Ciede2000;
use palette::white_point::D65;
use palette::{FromColor, Lab, LinSrgb};
use rayon::prelude::*;
use renderer_core::design::{CameraDesign, Colour, Design, Method, Phase, Quality};
use renderer_core::geometry::{Camera, Ray};
use renderer_core::optics::{Lobe, Optics};
use renderer_core::reference::{Scratch, Tracer};
use renderer_core::render::{RenderRequest, Settings};
use renderer_core::sampling::{Pcg, directions};
use renderer_core::scene::lod::LodView;
use renderer_core::scene::scattering_orders::{
    BIN_ENDS, BINS, Column, FRAME_LAMBERT, GRADIENT_LAMBERT, ISOTROPIC, KAJIYA_KAY,
};
use renderer_core::scene::{
    AlbedoTable, Dye, Scene, Section, Skeleton, albedo_from_reflectance, compile, wet_reflectance,
};

/// The default terry with loops and ground yarns that absorb nothing but what the grooves of their yarn do.
fn white_terry(phase: Phase, transmission: f64) -> Scene {
    let mut design = Design::default();
    (design.pile.phase, design.pile.transmission) = (phase, transmission);
    let mut scene = compile(&design).unwrap();
    let mut looks = scene.looks.clone().to_vec();
    for look in &mut looks {
        look.albedo = [u16::MAX; 3];
    }
    scene.looks = Section::new(looks);
    let mut skeleton = Skeleton::clone(&scene.skeleton);
    skeleton.albedo = [1.0; 3];
    scene.skeleton = Section::new(skeleton);
    scene
}

/// Pixels along each side of a picture.
const SIDE: u32 = 64;

/// Looks at the middle of the cloth from the default camera's place; 40 mm of a sheet of 90 mm are seen.
fn request(scene: Scene, bounces: u32) -> RenderRequest {
    let camera = CameraDesign {
        orthographic_height: Some(40.0),
        ..CameraDesign::default()
    };
    RenderRequest {
        view: LodView::of(Arc::new(scene), Camera::from_design(&camera)),
        size: [SIDE; 2],
        crop: [0, 0, SIDE, SIDE],
        settings: Settings {
            method: Method::Tracked,
            bounces,
            ..Settings::from(&Quality::default())
        },
    }
}

/// Scatterings after which a walk ends: what goes on is less than a hundredth of the light.
const LONGEST: usize = BIN_ENDS[BINS - 1] as usize;

/// What left the cloth, for each bin of scatterings in the pile.
#[derive(Debug, Clone, Copy, Default)]
struct Bin {
    /// Light that met pile alone.
    pile: f64,
    /// Light that met ground yarns as well, and its mean number of scatterings there.
    ground: f64,
    on_ground: f64,
}

/// A direction by the phase function itself, so that walks keep weight 1: uniform ones are refused where it is small.
fn onward(optics: &Optics, lobe: Lobe, view: DVec3, pcg: &mut Pcg) -> DVec3 {
    /// Above the value of any fibre that is measured here.
    const LARGEST: f64 = 0.5;
    let mut next = || f64::from(pcg.next_float());
    if !matches!(lobe, Lobe::Fibre { .. }) {
        return optics.sample(lobe, view, [next(), next()]).0;
    }
    loop {
        let direction = directions::sphere(next(), next());
        let value = optics.value(lobe, view, direction);
        assert!(value <= LARGEST, "{value}");
        if next() * LARGEST < value {
            return direction;
        }
    }
}

/// Walks from the default camera's elevation into white terry until they leave; rays through its holes are left out.
fn measure(scene: &Scene, walks: u32) -> Vec<Bin> {
    let optics = Optics::new(&scene.pile, &scene.skeleton);
    let tracer = Tracer::new(&request(scene.clone(), 1));
    const STREAMS: u32 = 64;
    let parts: Vec<(Vec<Bin>, f64)> = (0..STREAMS)
        .into_par_iter()
        .map(|stream| {
            let (mut scratch, mut pcg) = (Scratch::default(), Pcg::new(77, stream));
            let mut bins = vec![Bin::default(); BINS];
            let mut met = 0.0;
            for _ in 0..walks / STREAMS {
                let [x, y] = [(); 2].map(|()| f64::from(pcg.next_float()) * f64::from(SIDE));
                let mut ray: Ray = tracer.camera_ray(DVec2::new(x, y));
                let (mut pile, mut ground, mut weight) = (0, 0, 1.0);
                while pile <= LONGEST && ground <= LONGEST {
                    let Some(vertex) = tracer.collision(&ray, &mut pcg, &mut scratch) else {
                        if pile + ground > 0 {
                            let bin = &mut bins[bin_of(pile)];
                            if ground == 0 {
                                bin.pile += weight;
                            } else {
                                bin.ground += weight;
                                bin.on_ground += weight * f64::from(ground as u32);
                            }
                        }
                        break;
                    };
                    met += f64::from(u8::from(pile + ground == 0));
                    match vertex.lobe {
                        Lobe::Surface(_) => ground += 1,
                        _ => pile += 1,
                    }
                    weight *= vertex.albedo.x;
                    let view = -ray.direction;
                    ray = vertex.leave(onward(&optics, vertex.lobe, view, &mut pcg), 1e-6);
                }
            }
            (bins, met)
        })
        .collect();
    let met: f64 = parts.iter().map(|(_, met)| met).sum();
    (0..BINS)
        .map(|bin| {
            let mut sum = Bin::default();
            for (bins, _) in &parts {
                sum.pile += bins[bin].pile / met;
                sum.ground += bins[bin].ground / met;
                sum.on_ground += bins[bin].on_ground / met;
            }
            sum.on_ground /= sum.ground.max(1e-12);
            sum
        })
        .collect()
}

/// The bin of paths with `n` scatterings in the pile.
fn bin_of(n: usize) -> usize {
    BIN_ENDS
        .partition_point(|&end| (end as usize) < n)
        .min(BINS - 1)
}

/// White terry for each column of the table: name, phase, transmission.
const COLUMNS: [(&str, Phase, f64); 8] = [
    ("ISOTROPIC", Phase::Isotropic, 0.0),
    ("FRAME_LAMBERT[0]", Phase::FrameLambert, 0.0),
    ("FRAME_LAMBERT[1]", Phase::FrameLambert, 0.5),
    ("FRAME_LAMBERT[2]", Phase::FrameLambert, 1.0),
    ("GRADIENT_LAMBERT[0]", Phase::GradientLambert, 0.0),
    ("GRADIENT_LAMBERT[1]", Phase::GradientLambert, 0.5),
    ("GRADIENT_LAMBERT[2]", Phase::GradientLambert, 1.0),
    ("KAJIYA_KAY", Phase::KajiyaKay, 0.0),
];

/// What the renderer holds for a column.
fn tabulated(phase: Phase, transmission: f64) -> Column {
    let step = (2.0 * transmission) as usize;
    match phase {
        Phase::Isotropic => ISOTROPIC,
        Phase::FrameLambert => FRAME_LAMBERT[step],
        Phase::GradientLambert => GRADIENT_LAMBERT[step],
        Phase::KajiyaKay => KAJIYA_KAY,
    }
}

/// Measures a column anew and compares it with the table; says all that was measured if it differs.
fn column_is_as_measured(name: &str, phase: Phase, transmission: f64, walks: u32) {
    // What the table itself was measured with.
    const TABLE_WALKS: f64 = 64_000.0;
    let bins = measure(&white_terry(phase, transmission), walks);
    let table = tabulated(phase, transmission);
    let mut wrong = String::new();
    for (bin, found) in bins.iter().enumerate() {
        // Counts, most of weight nearly 1, on both sides.
        let shares = [
            (found.pile, table.pile[bin]),
            (found.ground, table.ground[bin]),
        ];
        for (found, expected) in shares {
            let deviation = (expected * (1.0 / f64::from(walks) + 1.0 / TABLE_WALKS)).sqrt();
            // 4.5 deviations: one in 3·10⁵ right bins is refused; 10⁻⁴ is for few counts.
            if (found - expected).abs() > 4.5 * deviation + 1e-4 {
                wrong += &format!("bin {bin}: {found} ± {deviation}, not {expected}\n");
            }
        }
    }
    // The mean of a geometric distribution of some thousand counts, most of them in the last bins.
    let times = |share: &[f64], mean: &[f64]| -> f64 {
        let sum: f64 = share.iter().zip(mean).map(|(s, m)| s * m).sum();
        sum / share.iter().sum::<f64>()
    };
    let [share, mean] = [|bin: &Bin| bin.ground, |bin: &Bin| bin.on_ground]
        .map(|part| bins.iter().map(part).collect::<Vec<f64>>());
    let (found, expected) = (times(&share, &mean), times(&table.ground, &table.on_ground));
    if (found / expected - 1.0).abs() > 0.15 {
        wrong += &format!("{found} times on the ground, not {expected}\n");
    }
    let list = |part: fn(&Bin) -> f64| {
        let numbers: Vec<String> = bins.iter().map(|bin| format!("{:.5}", part(bin))).collect();
        numbers.join(", ")
    };
    assert!(
        wrong.is_empty(),
        "{wrong}measured for {name}:\npile: [{}]\nground: [{}]\non_ground: [{}]",
        list(|bin| bin.pile),
        list(|bin| bin.ground),
        list(|bin| bin.on_ground)
    );
}

#[test]
fn the_albedo_table_is_what_walks_measure() {
    column_is_as_measured("ISOTROPIC", Phase::Isotropic, 0.0, 25_600);
}

#[test]
#[ignore = "long: about 30 s"]
fn every_column_of_the_albedo_table_is_what_walks_measure() {
    for (name, phase, transmission) in COLUMNS {
        column_is_as_measured(name, phase, transmission, 32_000);
    }
}

/// CIEDE2000 between linear colours.
fn difference(a: [f64; 3], b: [f64; 3]) -> f64 {
    let [a, b] = [a, b].map(|[r, g, b]| Lab::<D65, f64>::from_color(LinSrgb::new(r, g, b)));
    a.difference(b)
}

/// Mean radiance of the cloth in a picture of a uniform chart.
fn mean_of_chart(phase: Phase, transmission: f64, colour: Colour, bounces: u32) -> [f64; 3] {
    let mut design = Design::default();
    design.chart.colour = colour;
    (design.pile.phase, design.pile.transmission) = (phase, transmission);
    design.quality.bounces = bounces;
    mean_of(design)
}

/// Mean radiance of the cloth in a picture of a design under a white sky of radiance 1.
fn mean_of(mut design: Design) -> [f64; 3] {
    design.light.sun.clear();
    design.light.environment.radiance = 1.0;
    let tracer = Tracer::new(&request(compile(&design).unwrap(), design.quality.bounces));
    let rows: Vec<(DVec3, f64)> = (0..SIDE)
        .into_par_iter()
        .map(|y| {
            let mut scratch = Scratch::default();
            let (mut sum, mut met) = (DVec3::ZERO, 0.0);
            for x in 0..SIDE {
                let sample = tracer.sample([x, y], 0, &mut scratch);
                if sample.first.is_some() {
                    sum += sample.radiance;
                    met += 1.0;
                }
            }
            (sum, met)
        })
        .collect();
    let (sum, met) = rows
        .into_iter()
        .fold((DVec3::ZERO, 0.0), |(s, m), (sum, met)| (s + sum, m + met));
    (sum / met).to_array()
}

/// Near black, a dark, a saturated, a middle, a light colour, and white, which is the brightest that cotton can be.
const CHART: [[u8; 3]; 6] = [
    [18, 18, 20],
    [30, 45, 90],
    [140, 35, 40],
    [120, 120, 120],
    [180, 160, 130],
    [255, 255, 255],
];

fn renders_as_itself(phase: Phase, transmission: f64, bounces: u32, colours: &[[u8; 3]]) {
    let defaults = Design::default();
    let table = AlbedoTable::new(&Dye {
        phase,
        transmission,
        ground: defaults.skeleton.colour.linear(),
        bounces,
        max_albedo: defaults.pile.max_albedo,
    });
    for &colour in colours {
        let texel = Colour(colour).linear();
        // Only white is beyond cotton; where light goes deep before it comes back, 16 bounces show less of every
        // colour.
        let expected = table.reached(texel);
        assert!(phase != Phase::Isotropic || colour == [255; 3] || expected == texel);
        let found = mean_of_chart(phase, transmission, Colour(colour), bounces);
        let far = difference(found, expected);
        // 4096 paths of mean r deviate by √(r(1−r)/4096): 0.8 % at a half, ΔE 0.5; near black less.
        assert!(
            far < 3.0,
            "{phase:?} {transmission}, {bounces} bounces, {colour:?}: ΔE {far:.2}, {found:.4?} not {expected:.4?}"
        );
    }
}

#[test]
fn charts_render_in_their_colours() {
    let own = Design::default().quality.bounces;
    renders_as_itself(Phase::Isotropic, 0.0, own, &CHART);
    renders_as_itself(Phase::Isotropic, 0.0, 64, &CHART[3..]);
    for (phase, transmission) in [
        (Phase::FrameLambert, 0.5),
        (Phase::GradientLambert, 0.5),
        (Phase::KajiyaKay, 0.0),
    ] {
        renders_as_itself(phase, transmission, own, &CHART[2..4]);
    }
}

#[test]
#[ignore = "long: about 60 s"]
fn charts_render_in_their_colours_with_every_phase() {
    for (_, phase, transmission) in COLUMNS {
        for bounces in [16, 64] {
            renders_as_itself(phase, transmission, bounces, &CHART);
        }
    }
    // Between what was measured.
    renders_as_itself(Phase::GradientLambert, 0.25, 32, &CHART);
    renders_as_itself(Phase::FrameLambert, 0.8, 32, &CHART);
}

#[test]
fn wet_charts_render_as_much_darker_as_water_makes_them() {
    for colour in [[30, 45, 90], [120, 120, 120], [180, 160, 130]] {
        for wetness in [0.5, 1.0] {
            let mut design = Design::default();
            design.chart.colour = Colour(colour);
            // Between clumps the ground shows: it is dyed as the pile is.
            design.skeleton.colour = Colour(colour);
            design.finish.wetness = wetness;
            let expected = Colour(colour)
                .linear()
                .map(|dry| wet_reflectance(dry, wetness));
            let found = mean_of(design);
            let far = difference(found, expected);
            // The noise of ΔE 0.5 as above; and that loops in clumps let light go deeper between them.
            assert!(
                far < 5.0,
                "{colour:?}, wet {wetness}: ΔE {far:.2}, {found:.4?} not {expected:.4?}"
            );
        }
    }
}

#[test]
fn white_is_what_cotton_can_reach() {
    let reach = |bounces, max_albedo| {
        let table = AlbedoTable::new(&Dye {
            phase: Phase::Isotropic,
            transmission: 0.0,
            ground: Design::default().skeleton.colour.linear(),
            bounces,
            max_albedo,
        });
        let reached = table.reached([1.0; 3]);
        // Ground yarns are less blue, so that white is as bright as loops can be in blue; between the table's entries.
        let albedo = albedo_from_reflectance([1.0; 3], &table);
        assert!((albedo[2] - max_albedo).abs() < 1e-3 && albedo[0] < albedo[2]);
        reached[0]
    };
    // As stated in the documentation of `pile.max_albedo`.
    assert!((reach(64, 0.985) - 0.6).abs() < 0.005);
    assert!((reach(16, 0.985) - 0.48).abs() < 0.005);
    // More bounces and whiter cotton are brighter.
    assert!(reach(64, 0.985) > reach(32, 0.985));
    assert!(reach(64, 0.99) > reach(64, 0.985));
}

#[test]
fn darkened_colours_keep_their_hue_and_order() {
    for bounces in [1, 2, 4, 8, 16, 64] {
        let table = AlbedoTable::new(&Dye {
            phase: Phase::Isotropic,
            transmission: 0.0,
            ground: [0.8, 0.7, 0.6],
            bounces,
            max_albedo: 0.985,
        });
        let mut last = 0.0;
        for k in 1..=20 {
            let bright = f64::from(k) / 20.0;
            let reached = table.reached([bright, 0.5 * bright, 0.1 * bright]);
            assert!((reached[1] / reached[0] - 0.5).abs() < 1e-12);
            assert!((reached[2] / reached[0] - 0.1).abs() < 1e-12);
            // Rounding aside.
            assert!(reached[0] > last - 1e-12 && reached[0] < bright + 1e-12);
            last = reached[0];
            let albedo = albedo_from_reflectance([bright, 0.5 * bright, 0.1 * bright], &table);
            assert!(
                albedo.iter().all(|a| (0.0..=0.985).contains(a)),
                "{albedo:?}"
            );
            assert!(albedo[0] > albedo[1] && albedo[1] >= albedo[2]);
        }
        // One bounce shows the chart's proportions among all colours that cotton can have.
        if bounces == 1 {
            let [dark, bright] = [0.3, 0.6].map(|r| table.reached([r; 3])[0]);
            assert!((dark / bright - 0.5).abs() < 1e-12, "{dark} and {bright}");
        }
    }
}
