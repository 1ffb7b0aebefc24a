//! The shaders' phase functions and surfaces on their own: equal to the reference's in value and in the directions
//! drawn, and none gives back more than its albedo.

use std::f64::consts::PI;

use bytemuck::{Pod, Zeroable};
use glam::DVec3;
use renderer_core::design::{Phase, SkeletonDesign, SkeletonShading, Weave};
use renderer_core::gpu::constants::{self, HIGHLIGHT_INTERVALS};
use renderer_core::gpu::layout::SceneConstants;
use renderer_core::optics::{Lobe, Optics};
use renderer_core::sampling::Pcg;
use renderer_core::scene::{Material, PileOptics, Skeleton};

use crate::support::probe::{Probe, Special, ask_special};

/// As in shaders/scene.wgsl.
const PILE: u32 = 1;
const GROUND: u32 = 2;

#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct LobeProbe {
    what: [u32; 4],
    normal: [f32; 4],
    axis: [f32; 4],
    towards_eye: [f32; 4],
    towards_light: [f32; 4],
    numbers: [f32; 4],
}

#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct LobeAnswer {
    drawn: [f32; 4],
    value: [f32; 4],
}

/// One way to scatter, with its parameters.
#[derive(Debug, Clone, Copy)]
enum Case {
    Pile {
        phase: Phase,
        transmission: f32,
        specular: f32,
        exponent: f32,
        /// Change of ρ over the thickness.
        slope: f64,
    },
    Ground {
        shading: SkeletonShading,
        specular: f32,
        exponent: f32,
        fibre_spacing: f32,
    },
}

const fn pile(phase: Phase) -> Case {
    Case::Pile {
        phase,
        transmission: 0.3,
        specular: 0.4,
        exponent: 12.0,
        slope: 1.5,
    }
}

const fn ground(shading: SkeletonShading, specular: f32, exponent: f32, spacing: f32) -> Case {
    Case::Ground {
        shading,
        specular,
        exponent,
        fibre_spacing: spacing,
    }
}

const CASES: [Case; 9] = [
    pile(Phase::Isotropic),
    pile(Phase::FrameLambert),
    pile(Phase::GradientLambert),
    pile(Phase::KajiyaKay),
    ground(SkeletonShading::Lambert, 0.0, 1.0, 1.0),
    ground(SkeletonShading::Phong, 0.4, 12.0, 1.0),
    ground(SkeletonShading::PoulinFournier, 0.0, 1.0, 1.0),
    ground(SkeletonShading::PoulinFournier, 0.4, 12.0, 1.2),
    ground(SkeletonShading::PoulinFournier, 1.0, 60.0, 3.0),
];

/// One point and what is asked of it. Vectors are those that f32 holds.
#[derive(Debug, Clone, Copy)]
struct Question {
    normal: DVec3,
    axis: DVec3,
    view: DVec3,
    light: DVec3,
    numbers: [f64; 2],
}

impl Case {
    fn optics(&self) -> Optics {
        let mut skeleton = Skeleton::new(&Weave::default(), &SkeletonDesign::default());
        let mut material = Material {
            density_per_mm: 1.0,
            kind: 0,
            phase: Phase::Isotropic,
            transmission: 0.0,
            specular: 0.0,
            exponent: 1.0,
        };
        match *self {
            Self::Pile {
                phase,
                transmission,
                specular,
                exponent,
                ..
            } => {
                material.phase = phase;
                (material.transmission, material.specular) = (transmission, specular);
                material.exponent = exponent;
            }
            Self::Ground {
                specular,
                exponent,
                fibre_spacing,
                ..
            } => {
                (skeleton.specular, skeleton.exponent) = (specular, exponent);
                skeleton.fibre_spacing = fibre_spacing;
            }
        }
        let materials = vec![material];
        Optics::new(&PileOptics { materials }, &skeleton)
    }

    fn lobe(&self, question: &Question) -> Lobe {
        let Question { normal, axis, .. } = *question;
        let material = 0;
        match *self {
            Self::Pile { phase, slope, .. } => match phase {
                Phase::Isotropic => Lobe::Isotropic,
                Phase::FrameLambert => Lobe::Frame { normal, material },
                Phase::GradientLambert => Lobe::gradient(-axis * slope, 1.0, material),
                Phase::KajiyaKay => Lobe::Fibre {
                    tangent: axis,
                    material,
                },
            },
            Self::Ground { shading, .. } => match shading {
                SkeletonShading::Lambert => Lobe::Surface(normal),
                SkeletonShading::Phong => Lobe::Phong(normal),
                SkeletonShading::PoulinFournier => Lobe::Fibres {
                    normal,
                    along: axis,
                },
            },
        }
    }

    fn ask(&self, questions: &[Question]) -> Vec<LobeAnswer> {
        let mut scene = SceneConstants::zeroed();
        let (mut phase, mut shading) = (constants::PHASE_ISOTROPIC, constants::SHADING_LAMBERT);
        let (mut what, mut surfaceness, mut sharpness) = (GROUND, 0.0, 1.0);
        match *self {
            Self::Pile {
                phase: own,
                transmission,
                specular,
                exponent,
                slope,
            } => {
                phase = match own {
                    Phase::Isotropic => constants::PHASE_ISOTROPIC,
                    Phase::FrameLambert => constants::PHASE_FRAME_LAMBERT,
                    Phase::GradientLambert => constants::PHASE_GRADIENT_LAMBERT,
                    Phase::KajiyaKay => constants::PHASE_KAJIYA_KAY,
                };
                let material = &mut scene.materials[0];
                (material.transmission, material.specular) = (transmission, specular);
                material.exponent = exponent;
                (what, surfaceness) = (PILE, slope * slope / (1.0 + slope * slope));
                sharpness = f64::from(exponent);
            }
            Self::Ground {
                shading: own,
                specular,
                exponent,
                fibre_spacing,
            } => {
                shading = match own {
                    SkeletonShading::Lambert => constants::SHADING_LAMBERT,
                    SkeletonShading::Phong => constants::SHADING_PHONG,
                    SkeletonShading::PoulinFournier => constants::SHADING_POULIN_FOURNIER,
                };
                (scene.skeleton_specular, scene.skeleton_exponent) = (specular, exponent);
                scene.fibre_spacing = 2.0 * fibre_spacing;
            }
        }
        let table: Vec<f32> = (0..=HIGHLIGHT_INTERVALS)
            .map(|k| {
                let view = 0.5 * PI * f64::from(k) / f64::from(HIGHLIGHT_INTERVALS);
                highlight_norm(sharpness, view) as f32
            })
            .collect();
        let probe = Probe {
            entry: "probe_lobes",
            bindings: [0, 1],
            answer_size: size_of::<LobeAnswer>() as u64,
            scene: Some(bytemuck::bytes_of(&scene).to_vec()),
        };
        let constants = [("PHASE", f64::from(phase)), ("SHADING", f64::from(shading))];
        let special = Special {
            part: (
                "probe_lobes.wgsl",
                include_str!("../support/probe_lobes.wgsl"),
            ),
            constants: &constants,
            highlight: (HIGHLIGHT_INTERVALS + 1, &table),
        };
        let four = |v: DVec3, w: f64| {
            let [x, y, z] = v.as_vec3().to_array();
            [x, y, z, w as f32]
        };
        let probes: Vec<LobeProbe> = questions
            .iter()
            .map(|question| LobeProbe {
                what: [what, 0, 0, 0],
                normal: four(question.normal, surfaceness),
                axis: four(question.axis, 0.0),
                towards_eye: four(question.view, 0.0),
                towards_light: four(question.light, 0.0),
                numbers: [
                    question.numbers[0] as f32,
                    question.numbers[1] as f32,
                    0.0,
                    0.0,
                ],
            })
            .collect();
        ask_special(&probe, Some(&special), &probes)
    }
}

/// N_p(θ_v) by midpoints.
fn highlight_norm(exponent: f64, view: f64) -> f64 {
    const STEPS: u32 = 4096;
    let width = PI / f64::from(STEPS);
    let term = |step: u32| {
        let theta = (f64::from(step) + 0.5) * width;
        (theta + view - PI).cos().max(0.0).powf(exponent) * theta.sin()
    };
    2.0 * PI * width * (0..STEPS).map(term).sum::<f64>()
}

struct Random(Pcg);

impl Random {
    fn number(&mut self) -> f64 {
        f64::from(self.0.next_float())
    }

    /// A unit vector that f32 holds.
    fn direction(&mut self) -> DVec3 {
        loop {
            let v = DVec3::from_array([(); 3].map(|()| 2.0 * self.number() - 1.0));
            if (0.01..1.0).contains(&v.length_squared()) {
                return v.normalize().as_vec3().as_dvec3();
            }
        }
    }

    fn question(&mut self) -> Question {
        let normal = self.direction();
        let axis = normal.cross(self.direction()).normalize().as_vec3();
        let [mut view, light] = [self.direction(), self.direction()];
        // Normals of ground yarns are turned towards the eye.
        if view.dot(normal) < 0.0 {
            view = -view;
        }
        Question {
            normal,
            axis: axis.as_dvec3(),
            view,
            light,
            numbers: [self.number(), self.number()],
        }
    }
}

#[test]
fn values_and_directions_are_those_of_the_reference() {
    let mut random = Random(Pcg::new(21, 1));
    for case in CASES {
        let questions: Vec<Question> = (0..4000).map(|_| random.question()).collect();
        let optics = case.optics();
        let (mut bright, mut flips) = (0, Vec::new());
        for (question, answer) in questions.iter().zip(case.ask(&questions)) {
            let lobe = case.lobe(question);
            let value = optics.value(lobe, question.view, question.light);
            let [red, green, blue] = [0, 1, 2].map(|c| f64::from(answer.value[c]));
            assert!((green - 0.5 * red).abs() < 1e-6 && (blue - 0.25 * red).abs() < 1e-6);
            bright += u32::from(value > 0.02);
            // Tens of operations of 6e-8 each; powers multiply that by their exponent. The edge of a fibre's shadow is
            // an angle whose cosine is known to 6e-8, itself to the root of that, 2.5e-4; the view's cosine divides it.
            let grazing = question.view.dot(question.normal).abs().max(0.01);
            let allowed = match lobe {
                Lobe::Fibres { .. } => 2e-4 + 1e-3 * value + 5e-5 / grazing,
                _ => 1e-4 + 1e-3 * value,
            };
            assert!(
                (red - value).abs() < allowed,
                "{case:?}: {red}, not {value}"
            );
            let (direction, weight) = optics.sample(lobe, question.view, question.numbers);
            let [x, y, z, drawn_weight] = answer.drawn.map(f64::from);
            let far = (DVec3::new(x, y, z) - direction).length();
            // Sines near 0 are roots of small numbers: 1e-4 off where a highlight is sharp.
            if far > 2e-4 || (drawn_weight - weight).abs() > 2e-3 * weight.max(1.0) {
                flips.push((answer.drawn, direction, weight, question));
            }
        }
        assert!(bright > 200, "{case:?}: {bright}");
        // Numbers so near to a choice between two parts that rounding decides it.
        assert!(
            flips.len() <= 8,
            "{case:?}: {} such as {:?}",
            flips.len(),
            &flips[..4]
        );
    }
}

#[test]
fn no_lobe_of_the_shaders_gains_energy() {
    const RINGS: u32 = 96;
    let mut random = Random(Pcg::new(22, 1));
    for case in CASES {
        for view in 0..3 {
            let mut first = random.question();
            if view == 0 {
                first.view = first.normal;
            }
            let (x, y) = first.axis.any_orthonormal_pair();
            let mut questions = Vec::new();
            let mut areas = Vec::new();
            let (height, width) = (PI / f64::from(RINGS), 2.0 * PI / f64::from(2 * RINGS));
            for ring in 0..RINGS {
                let (sine, cosine) = (height * (f64::from(ring) + 0.5)).sin_cos();
                for step in 0..2 * RINGS {
                    let (s, c) = (width * (f64::from(step) + 0.5)).sin_cos();
                    questions.push(Question {
                        light: x * (sine * c) + y * (sine * s) + first.axis * cosine,
                        ..first
                    });
                    areas.push(sine * height * width);
                }
            }
            let answers = case.ask(&questions);
            let terms = answers.iter().zip(&areas);
            let sum: f64 = terms.map(|(a, area)| f64::from(a.value[0]) * area).sum();
            // Rings of π/96 integrate edges at a hemisphere's rim and the sharpest highlight (0.13 rad) to 0.5 %.
            assert!(sum < 1.005, "{case:?}: {sum}");
            let loses =
                matches!(case, Case::Ground { shading, .. } if shading != SkeletonShading::Lambert);
            assert!(sum > 0.995 || (loses && sum > 0.3), "{case:?}: {sum}");
        }
    }
}
