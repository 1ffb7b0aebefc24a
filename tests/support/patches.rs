//! Rays against patches on the device: `probe_patches` and `probe_points` of probe.wgsl, with the same case in f64.

use bytemuck::{Pod, Zeroable};
use glam::{DVec2, DVec3, Vec3};
use renderer_core::geometry::{BilinearPatch, Ray, Root};
use renderer_core::gpu::layout::SceneConstants;
use renderer_core::sampling::Pcg;

use super::probe::{Probe, ask};

/// Thickness of every loop, mm.
pub const THICKNESS: f32 = 0.9;
/// Distances between cells, mm: no numbers that f32 holds exactly.
pub const PITCH: DVec2 = DVec2::new(10.0 / 13.3, 10.0 / 14.8);
/// Cases asked at once: their answers stay below the smallest limit of a binding, 128 MiB.
const AT_ONCE: usize = 250_000;

#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct PatchProbe {
    half_base: [f32; 4],
    axis: [f32; 4],
    half_top: [f32; 4],
    middle: [f32; 4],
    origin: [f32; 4],
    direction: [f32; 4],
}

/// What the shader finds.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct PatchAnswer {
    /// (u, v, t) of the nearer root, and how many there are.
    pub first: [f32; 4],
    /// (u, v, t) of the farther root.
    pub second: [f32; 4],
    /// (u′, v′, w′, (A·n̂)u′v′) at the first root.
    pub slopes: [f32; 4],
    /// (u, v, w) of the point at the first root.
    pub inverted: [f32; 4],
}

/// A patch as the shader takes it, in f32, and a ray.
#[derive(Debug, Clone, Copy)]
pub struct Case {
    /// From the middle of the base edge to P1.
    pub half_base: Vec3,
    /// From the middle of the base edge to the middle of the top edge.
    pub axis: Vec3,
    /// From the middle of the top edge to P2.
    pub half_top: Vec3,
    /// Middle of the base edge.
    pub middle: Vec3,
    /// Of the ray, relative to its cell.
    pub origin: Vec3,
    /// Of the ray.
    pub direction: Vec3,
    /// The patch's cell, counted from the ray's.
    pub cell: [i32; 2],
}

impl Case {
    fn probe(&self) -> PatchProbe {
        let four = |v: Vec3, w: f32| [v.x, v.y, v.z, w];
        PatchProbe {
            half_base: four(self.half_base, 0.0),
            axis: four(self.axis, 0.0),
            half_top: four(self.half_top, 0.0),
            middle: four(self.middle, 0.0),
            // Whole numbers below 2²⁴ are exact.
            origin: four(self.origin, self.cell[0] as f32),
            direction: four(self.direction, self.cell[1] as f32),
        }
    }

    /// The patch in f64.
    pub fn patch(&self) -> BilinearPatch {
        let [g, c, e, m] =
            [self.half_base, self.axis, self.half_top, self.middle].map(Vec3::as_dvec3);
        BilinearPatch::from_corners([m - g, m + g, m + c + e, m + c - e])
    }

    /// The ray in f64, relative to the patch's cell. Its direction has unit length in f64 too, which moves points
    /// on it by no more than a rounding of t.
    pub fn ray(&self) -> Ray {
        let cell = DVec2::new(f64::from(self.cell[0]), f64::from(self.cell[1]));
        Ray {
            origin: self.origin.as_dvec3() - (cell * PITCH).extend(0.0),
            direction: self.direction.as_dvec3().normalize(),
        }
    }
}

/// Random numbers for cases.
pub struct Random(pub Pcg);

impl Random {
    /// Uniform between two values.
    pub fn within(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.0.next_float()
    }

    /// Uniform in a cube of this half side.
    pub fn vector(&mut self, size: f32) -> Vec3 {
        Vec3::from_array([(); 3].map(|()| self.within(-size, size)))
    }

    /// A unit vector.
    pub fn direction(&mut self) -> Vec3 {
        loop {
            let v = self.vector(1.0);
            if (0.01..1.0).contains(&v.length_squared()) {
                return v.normalize();
            }
        }
    }
}

fn probe(entry: &'static str, bindings: [u32; 2], answer_size: usize) -> Probe {
    let mut scene = SceneConstants::zeroed();
    scene.thickness = THICKNESS;
    scene.pitch = PITCH.as_vec2().to_array();
    Probe {
        entry,
        bindings,
        answer_size: answer_size as u64,
        scene: Some(bytemuck::bytes_of(&scene).to_vec()),
    }
}

/// What the shader finds for each case; everything is finite, or this fails.
pub fn asked(cases: &[Case]) -> Vec<PatchAnswer> {
    let probe = probe("probe_patches", [0, 1], size_of::<PatchAnswer>());
    let mut answers = Vec::with_capacity(cases.len());
    for cases in cases.chunks(AT_ONCE) {
        let probes: Vec<PatchProbe> = cases.iter().map(Case::probe).collect();
        answers.extend(ask::<_, PatchAnswer>(&probe, &probes));
    }
    for (case, answer) in cases.iter().zip(&answers) {
        let all = [answer.first, answer.second, answer.slopes, answer.inverted];
        assert!(
            all.as_flattened().iter().all(|value| value.is_finite()),
            "{case:?} {answer:?}"
        );
    }
    answers
}

/// (u, v, w) that the shader finds for the point that is each case's `origin`.
pub fn inverted(cases: &[Case]) -> Vec<[f32; 4]> {
    let probe = probe("probe_points", [0, 4], size_of::<[f32; 4]>());
    let probes: Vec<PatchProbe> = cases.iter().map(Case::probe).collect();
    ask(&probe, &probes)
}

/// The roots of an answer.
pub fn answered(answer: &PatchAnswer) -> Vec<Root> {
    let root = |[u, v, t, _]: [f32; 4]| Root {
        u: f64::from(u),
        v: f64::from(v),
        t: f64::from(t),
    };
    [root(answer.first), root(answer.second)][..answer.first[3] as usize].to_vec()
}

/// Roots of a case's ray moved by `shift`, found in f64.
pub fn truth(case: &Case, shift: DVec3) -> Vec<Root> {
    let mut ray = case.ray();
    ray.origin += shift;
    case.patch().roots(&ray).as_slice().to_vec()
}
