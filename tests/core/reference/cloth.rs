//! Scenes, tracers and random rays for the tests of the reference renderer.

use std::f64::consts::PI;
use std::sync::Arc;

use glam::{DVec2, DVec3};
use renderer_core::design::{
    Back, CameraDesign, Design, Interpolation, Method, Pattern, Phase, PileKind,
};
use renderer_core::geometry::{BilinearPatch, Camera, LoopFrame, Ray, orthonormal_basis};
use renderer_core::reference::Tracer;
use renderer_core::render::{Optimisations, RenderRequest, Settings};
use renderer_core::sampling::{self, Pcg, Sampler, Set};
use renderer_core::scene::lod::LodView;
use renderer_core::scene::{Loops, Scene, Section, SunLight, Volumes, compile};

/// A towel of fat, twisted, overlapping loops on both faces, small enough for brute force.
pub fn wild_towel(interpolation: Interpolation) -> Scene {
    let mut design = Design::default();
    (design.sheet.warps, design.sheet.wefts) = (7, 9);
    design.pile.interpolation = interpolation;
    (
        design.pile.layers,
        design.pile.resolution,
        design.pile.variants,
    ) = (4, 9, 3);
    design.pile.top_width = 1.3;
    design.pile.tilt = 100.0;
    design.pile.twist = 140.0;
    design.pile.twist_jitter = 60.0;
    design.skeleton.visible = false;
    compile(&design).expect("a valid design")
}

/// One upright loop on one cell whose volume is a uniform block: 0.8 mm thick along x, 1.9 mm wide along y, 3 mm high.
/// Its density is 1/mm; single-scatter albedo 1; isotropic; no skeleton, no light, black background.
pub fn block(layers: u32) -> Scene {
    blocks(layers, 1, 13.3)
}

/// Several of these blocks side by side along x, a cell each.
pub fn blocks(layers: u32, warps: u32, warps_per_cm: f64) -> Scene {
    let mut design = Design::default();
    (design.sheet.warps, design.sheet.wefts) = (warps, 1);
    design.sheet.warps_per_cm = warps_per_cm;
    design.weave.pattern = Pattern::filled(1, 1, 7);
    design.weave.back = Back::None;
    design.length.value = 3.0;
    let pile = &mut design.pile;
    (pile.lean_x, pile.lean_y, pile.tilt, pile.jitter) = (0.0, 0.0, 0.0, 0.0);
    (
        pile.twist,
        pile.twist_jitter,
        pile.stretch,
        pile.length_jitter,
    ) = (0.0, 0.0, 0.0, 0.0);
    (pile.thickness, pile.density, pile.layers) = (0.8, 1.0, layers);
    design.skeleton.visible = false;
    design.light.sun.clear();
    design.light.environment.radiance = 0.0;
    let mut scene = compile(&design).expect("a valid design");
    make_uniform(&mut scene, layers);
    // The top edge is in whole units of length; a root as wide to the bit makes the block a block.
    let mut loops = Loops::clone(&scene.loops);
    loops.base_width_mm = 2.0 * loops.patch(0).half_top[1];
    scene.loops = Section::new(loops);
    let mut looks = scene.looks.clone().to_vec();
    for look in &mut looks {
        look.albedo = [u16::MAX; 3];
    }
    scene.looks = Section::new(looks);
    edit_lights(&mut scene, |lights| lights.background = [0.0; 3]);
    scene
}

/// Fills all volumes evenly.
pub fn make_uniform(scene: &mut Scene, layers: u32) {
    scene.volumes = Section::new(Volumes {
        resolution: 4,
        layers,
        variants: scene.volumes.variants,
        kinds: vec![PileKind::Terry],
        interpolation: Interpolation::Nearest,
        root_blend: 0.0,
        voxels: vec![[255, 255]; (layers * 16 * scene.volumes.variants) as usize],
        tangents: Vec::new(),
        reference_size_mm: scene.volumes.reference_size_mm,
    });
}

/// The middle of the block's volume and half its size.
pub fn block_extent(scene: &Scene) -> (DVec3, DVec3) {
    let shape = scene.loops.patch(0);
    let [_, _, length] = shape.axis.map(f64::from);
    let root = f64::from(shape.root_z0);
    (
        DVec3::new(0.0, 0.0, root + 0.5 * length),
        DVec3::new(
            0.5 * f64::from(scene.loops.thickness_mm),
            0.5 * f64::from(scene.loops.base_width_mm),
            0.5 * length,
        ),
    )
}

pub fn edit_lights(scene: &mut Scene, edit: impl FnOnce(&mut renderer_core::scene::Lights)) {
    let mut lights = renderer_core::scene::Lights::clone(&scene.lights);
    edit(&mut lights);
    scene.lights = Section::new(lights);
}

pub fn edit_pile(scene: &mut Scene, edit: impl FnOnce(&mut renderer_core::scene::PileOptics)) {
    let mut pile = renderer_core::scene::PileOptics::clone(&scene.pile);
    edit(&mut pile);
    scene.pile = Section::new(pile);
}

/// A sun of irradiance 1 in the direction of `towards`, with a disc of half-angle `radius`.
pub fn sun(towards: DVec3, radius: f64) -> SunLight {
    SunLight {
        direction: towards.normalize().to_array(),
        angular_radius: radius,
        irradiance: [1.0; 3],
    }
}

pub const ALL_PHASES: &[Phase] = Phase::ALL;

/// A request for 64 × 64 pixels by the default camera.
pub fn request(scene: Scene, method: Method, bounces: u32) -> RenderRequest {
    RenderRequest {
        view: LodView::of(
            Arc::new(scene),
            Camera::from_design(&CameraDesign::default()),
        ),
        size: [64, 64],
        crop: [0, 0, 64, 64],
        settings: Settings {
            method,
            bounces,
            traced_bounces: 0,
            step_mm: 0.05,
            samples: 1,
            error: 0.0,
            seed: 1,
            sampler: Sampler::Owen,
            shadows: true,
            aov: false,
            counters: true,
            optimisations: Optimisations::ALL,
            cached_shadows: 0,
            learns_bounces: false,
        },
    }
}

pub fn tracer(scene: Scene, method: Method) -> Tracer {
    Tracer::new(&request(scene, method, 1))
}

/// A camera far away along `towards_eye` that sees the point `target` alone: every ray is the same.
pub fn needle_camera(target: DVec3, towards_eye: DVec3) -> Camera {
    let forward = -towards_eye.normalize();
    let right = forward.any_orthonormal_vector();
    Camera {
        eye: target - forward * 50.0,
        right,
        up: right.cross(forward),
        forward,
        projection: renderer_core::geometry::Projection::Orthographic { height_mm: 1e-6 },
    }
}

/// A loop as brute force sees it: frame and cell origin in f64, density and voxels.
pub struct BruteLoop {
    pub index: usize,
    pub frame: LoopFrame,
    pub origin: DVec3,
    pub density: f64,
    first_voxel: usize,
}

/// All loops of a scene, from its records by MODEL.md §4, without the grid's lists, in the order of their shapes.
pub fn all_loops(scene: &Scene) -> Vec<BruteLoop> {
    let loops = &scene.loops;
    let mut found = Vec::new();
    for j in 0..scene.sheet.wefts {
        for planted in loops.planted_in_row(&scene.sheet, j) {
            let shape = loops.patch(planted.index as usize);
            let w0 = f64::from(loops.base_width_mm);
            let p0 = DVec3::new(0.0, -0.5 * w0, f64::from(shape.root_z0));
            let p1 = DVec3::new(0.0, 0.5 * w0, f64::from(shape.root_z1));
            let top = 0.5 * (p0 + p1) + DVec3::from_array(shape.axis.map(f64::from));
            let e = DVec3::from_array(shape.half_top.map(f64::from));
            let patch = BilinearPatch::from_corners([p0, p1, top + e, top - e]);
            let [i, j] = planted.cell.map(f64::from);
            let origin = DVec3::new(
                (i + 0.5 - f64::from(scene.sheet.warps) / 2.0) * scene.sheet.pitch_x_mm,
                (j + 0.5 - f64::from(scene.sheet.wefts) / 2.0) * scene.sheet.pitch_y_mm,
                0.0,
            );
            let look = scene.looks[planted.index as usize];
            let material = scene.pile.materials[usize::from(look.material)];
            let volumes = &scene.volumes;
            let volume = material.kind * volumes.variants + u32::from(look.variant);
            found.push(BruteLoop {
                index: planted.index as usize,
                frame: LoopFrame::new(patch, f64::from(loops.thickness_mm)),
                origin,
                density: f64::from(material.density_per_mm),
                first_voxel: (volume * volumes.layers * volumes.resolution.pow(2)) as usize,
            });
        }
    }
    assert_eq!(found.len(), loops.shapes.len());
    found.sort_by_key(|found| found.index);
    found
}

impl BruteLoop {
    /// ρ at (u, v, w) by MODEL.md §5, as a sum over all voxels with tent weights, the border's reaching to infinity.
    pub fn rho(&self, volumes: &Volumes, [u, v, w]: [f64; 3]) -> f64 {
        let tents = |x: f64, count: u32| -> Vec<f64> {
            let place = (x * f64::from(count) - 0.5).clamp(0.0, f64::from(count - 1));
            (0..count)
                .map(|k| (1.0 - (place - f64::from(k)).abs()).max(0.0))
                .collect()
        };
        let (along_u, along_v) = (tents(u, volumes.resolution), tents(v, volumes.resolution));
        let across = match volumes.interpolation {
            Interpolation::Linear => tents(w + 0.5, volumes.layers),
            Interpolation::Nearest => {
                let layer = ((w + 0.5) * f64::from(volumes.layers)).floor();
                let layer = layer.clamp(0.0, f64::from(volumes.layers - 1));
                (0..volumes.layers)
                    .map(|l| f64::from(u8::from(f64::from(l) == layer)))
                    .collect()
            }
        };
        let mut sum = 0.0;
        let mut voxel = self.first_voxel;
        for layer in &across {
            for row in &along_v {
                for column in &along_u {
                    let weight = layer * row * column;
                    if weight > 0.0 {
                        sum += weight * f64::from(volumes.voxels[voxel][0]) / 255.0;
                    }
                    voxel += 1;
                }
            }
        }
        let blend = f64::from(volumes.root_blend);
        let x = if blend > 0.0 {
            (v / blend).min(1.0)
        } else {
            1.0
        };
        sum * (3.0 * x * x - 2.0 * x * x * x)
    }
}

/// Random numbers and rays for one test.
pub struct Random(pub Pcg);

impl Random {
    pub fn new(seed: u32) -> Self {
        Self(Pcg::new(seed, 1))
    }

    pub fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * f64::from(self.0.next_float())
    }

    pub fn direction(&mut self) -> DVec3 {
        loop {
            let v = DVec3::from_array([(); 3].map(|()| self.within(-1.0, 1.0)));
            if (0.01..1.0).contains(&v.length_squared()) {
                return v.normalize();
            }
        }
    }

    /// A ray from outside towards a point of the cloth of `scene`; some are level, some run along a row or column.
    pub fn ray_at(&mut self, scene: &Scene) -> Ray {
        let sheet = &scene.sheet;
        let half = 0.5
            * DVec2::new(
                f64::from(sheet.warps) * sheet.pitch_x_mm,
                f64::from(sheet.wefts) * sheet.pitch_y_mm,
            );
        let [low, high] = scene.loops.z_range_mm.map(f64::from);
        let target = DVec3::new(
            self.within(-1.2, 1.2) * half.x,
            self.within(-1.2, 1.2) * half.y,
            self.within(low, high),
        );
        let mut direction = self.direction();
        match (self.within(0.0, 8.0)) as u32 {
            0 => direction.z = 0.0,
            1 => direction.x = 0.0,
            2 => direction.y = 0.0,
            3 => direction = DVec3::Z,
            _ => {}
        }
        let direction = direction.normalize();
        Ray {
            origin: target - direction * 40.0,
            direction,
        }
    }
}

/// Rings from pole to pole and steps around in integrals over the sphere.
const RINGS: u32 = 540;
const STEPS: u32 = 360;

/// Calls `f` with the middle and the solid angle of each of many patches of the sphere; the poles at ±`axis`.
fn over_sphere(axis: DVec3, mut f: impl FnMut(DVec3, f64)) {
    let (x, y) = orthonormal_basis(axis);
    let (height, width) = (PI / f64::from(RINGS), 2.0 * PI / f64::from(STEPS));
    for ring in 0..RINGS {
        let (sine, cosine) = (height * (f64::from(ring) + 0.5)).sin_cos();
        for step in 0..STEPS {
            let (s, c) = (width * (f64::from(step) + 0.5)).sin_cos();
            let direction = x * (sine * c) + y * (sine * s) + axis * cosine;
            f(direction, sine * height * width);
        }
    }
}

/// ∫ f over the sphere by midpoints.
pub fn integral(axis: DVec3, f: impl Fn(DVec3) -> f64) -> f64 {
    let mut sum = 0.0;
    over_sphere(axis, |direction, area| sum += area * f(direction));
    sum
}

/// Bins of directions: in height over the plane across the axis, and around.
const BINS: [usize; 2] = [8, 12];

fn bin_of(axis: DVec3, direction: DVec3) -> usize {
    let (x, y) = orthonormal_basis(axis);
    let [heights, turns] = BINS.map(|count| count as f64);
    let height = (0.5 * (1.0 + direction.dot(axis)) * heights).clamp(0.0, heights - 1.0);
    let turn = direction.dot(y).atan2(direction.dot(x)) / (2.0 * PI) + 0.5;
    height as usize * BINS[1] + (turn * turns).clamp(0.0, turns - 1.0) as usize
}

/// ∫ f over each bin of directions.
pub fn direction_bins(axis: DVec3, f: impl Fn(DVec3) -> f64) -> Vec<f64> {
    let mut bins = vec![0.0; BINS[0] * BINS[1]];
    over_sphere(axis, |direction, area| {
        bins[bin_of(axis, direction)] += area * f(direction);
    });
    bins
}

/// Mean weight of samples in each bin of directions, and the deviation of that mean.
pub fn shares_of_samples(
    axis: DVec3,
    sample: impl Fn([f64; 2]) -> (DVec3, f64),
) -> (Vec<f64>, Vec<f64>) {
    const SAMPLES: u32 = 1 << 15;
    let mut bins = vec![(0.0, 0.0); BINS[0] * BINS[1]];
    for number in 0..SAMPLES {
        let [u, v, ..] =
            sampling::sample(Sampler::Owen, 9, number, Set::Onward { bounce: 1 }).map(f64::from);
        let (direction, weight) = sample([u, v]);
        assert!((direction.length() - 1.0).abs() < 1e-12);
        assert!(weight >= 0.0);
        let (sum, squares) = &mut bins[bin_of(axis, direction)];
        *sum += weight;
        *squares += weight * weight;
    }
    let n = f64::from(SAMPLES);
    let deviation =
        |&(sum, squares): &(f64, f64)| ((squares / n - (sum / n) * (sum / n)).max(0.0) / n).sqrt();
    (
        bins.iter().map(|(sum, _)| sum / n).collect(),
        bins.iter().map(deviation).collect(),
    )
}
