//! Rows of the length table that bring their own yarn: a loop of such a row looks like one of a pile that is made so.

use renderer_core::cpu::CpuBackend;
use renderer_core::design::{
    ChartImage, Colour, Design, Fit, LengthEntry, LengthMap, Method, Phase, PileKind,
};
use renderer_core::gpu::GpuBackend;
use renderer_core::image::Picture;
use renderer_core::scene::compile;

use crate::support::compare::{same_samples, shows_something};
use crate::support::device::{exact_gpu, finish, on_reference};
use crate::support::scenes::{request, small_towel};

const SIZE: [u32; 2] = [40, 32];

/// A towel whose loops are all of one length.
fn towel(phase: Phase) -> Design {
    let mut design = small_towel();
    design.pile.phase = phase;
    (design.pile.layers, design.pile.resolution) = (3, 8);
    design.length.value = 2.8;
    design
}

/// What a row may have of its own, and the same for a pile.
type Own = (fn(&mut LengthEntry), fn(&mut Design));

const KINDS: [(&str, Phase, Own); 13] = [
    (
        "density",
        Phase::Isotropic,
        (|row| row.density = Some(2.5), |d| d.pile.density = 2.5),
    ),
    (
        "transmission",
        Phase::FrameLambert,
        (
            |row| row.transmission = Some(0.9),
            |d| d.pile.transmission = 0.9,
        ),
    ),
    (
        "specular",
        Phase::KajiyaKay,
        (|row| row.specular = Some(0.8), |d| d.pile.specular = 0.8),
    ),
    (
        "exponent",
        Phase::KajiyaKay,
        (
            |row| (row.specular, row.exponent) = (Some(0.8), Some(60.0)),
            |d| (d.pile.specular, d.pile.exponent) = (0.8, 60.0),
        ),
    ),
    (
        "lean along the weft",
        Phase::Isotropic,
        (|row| row.lean_x = Some(-30.0), |d| d.pile.lean_x = -30.0),
    ),
    (
        "lean along the warp",
        Phase::Isotropic,
        (|row| row.lean_y = Some(50.0), |d| d.pile.lean_y = 50.0),
    ),
    (
        "tilt",
        Phase::Isotropic,
        (|row| row.tilt = Some(5.0), |d| d.pile.tilt = 5.0),
    ),
    (
        "top width",
        Phase::Isotropic,
        (|row| row.top_width = Some(1.1), |d| d.pile.top_width = 1.1),
    ),
    (
        "diameter of the yarn",
        Phase::Isotropic,
        (
            |row| row.yarn_diameter = Some(0.4),
            |d| d.pile.yarn_diameter = 0.4,
        ),
    ),
    (
        "scattering as surfaces",
        Phase::Isotropic,
        (
            |row| row.phase = Some(Phase::FrameLambert),
            |d| d.pile.phase = Phase::FrameLambert,
        ),
    ),
    (
        "scattering as yarn",
        Phase::FrameLambert,
        (
            |row| row.phase = Some(Phase::GradientLambert),
            |d| d.pile.phase = Phase::GradientLambert,
        ),
    ),
    (
        "scattering as fibres",
        Phase::Isotropic,
        (
            |row| row.phase = Some(Phase::KajiyaKay),
            |d| d.pile.phase = Phase::KajiyaKay,
        ),
    ),
    (
        "kind",
        Phase::Isotropic,
        (
            |row| row.kind = Some(PileKind::Cut),
            |d| d.pile.kind = PileKind::Cut,
        ),
    ),
];

/// The pictures of all backends, the reference's first.
fn pictures(gpu: &mut GpuBackend, design: &Design) -> [Picture; 3] {
    let request = request(design, SIZE);
    [
        on_reference(&request),
        finish(&mut CpuBackend::default(), &request),
        finish(gpu, &request),
    ]
}

/// Their names.
const BACKENDS: [&str; 3] = ["reference", "processor", "GPU"];

#[test]
fn a_row_of_its_own_looks_like_a_pile_of_its_own() {
    let mut gpu = exact_gpu();
    for (what, phase, (row, pile)) in KINDS {
        let plain = towel(phase);
        let mut of_pile = plain.clone();
        pile(&mut of_pile);
        let mut of_row = plain.clone();
        of_row.length.map = LengthMap::Lut;
        let mut entry = LengthEntry {
            length: plain.length.value,
            ..LengthEntry::default()
        };
        row(&mut entry);
        // A row far from white comes first, so that a loop that took the wrong one would show.
        let other = LengthEntry {
            colour: Colour([0; 3]),
            length: 1.0,
            density: Some(0.5),
            ..LengthEntry::default()
        };
        of_row.length.table = vec![other, entry];
        let [plain, of_pile, of_row] =
            [plain, of_pile, of_row].map(|design| pictures(&mut gpu, &design));
        for (k, backend) in BACKENDS.into_iter().enumerate() {
            let what = format!("{what} on the {backend}");
            shows_something(&of_row[k]).unwrap_or_else(|error| panic!("{what}: {error}"));
            // The same numbers lead to the same samples, to the last bit.
            assert!(of_row[k].pixels == of_pile[k].pixels, "{what}");
            assert!(of_row[k].pixels != plain[k].pixels, "{what} shows");
        }
    }
}

#[test]
fn rows_side_by_side_are_the_same_on_all_backends() {
    let mut gpu = exact_gpu();
    for phase in [Phase::FrameLambert, Phase::KajiyaKay] {
        let mut design = towel(phase);
        design.quality.method = Method::Layered;
        let colours = [[255, 255, 255], [200, 30, 30], [30, 30, 200]];
        let pixels = colours.map(|[r, g, b]| [r, g, b, 255]);
        design.chart.pixels = ChartImage::new(3, 1, &pixels);
        design.chart.fit = Fit::Stretch;
        design.length.map = LengthMap::Lut;
        design.length.table = (0..3)
            .map(|k| LengthEntry {
                colour: Colour(colours[k]),
                length: 2.8,
                transmission: Some([0.1, 0.5, 1.0][k]),
                specular: Some([0.9, 0.5, 0.1][k]),
                exponent: Some([3.0, 30.0, 300.0][k]),
                // The last row scatters in another way than the others.
                phase: (k == 2).then_some(Phase::GradientLambert),
                ..LengthEntry::default()
            })
            .collect();
        let materials = &compile(&design).unwrap().pile.materials;
        assert_eq!(materials.len(), 4, "the pile's own and the rows'");
        let request = request(&design, SIZE);
        let [expected, drawn @ ..] = pictures(&mut gpu, &design);
        shows_something(&expected).unwrap();
        for (drawn, backend) in drawn.iter().zip(&BACKENDS[1..]) {
            same_samples(&request, &expected, drawn)
                .unwrap_or_else(|error| panic!("{backend}, {phase:?}: {error}"));
        }
    }
}
