//! Ways in which small cloths differ that matter to a renderer: loops, yarns, looks, lights, cameras.

use renderer_core::design::{
    AreaLight, Back, ChartImage, Colour, Design, EnvironmentImage, EnvironmentKind,
    EnvironmentReader, Fit, Interpolation, LengthEntry, LengthMap, Pattern, Phase, PileKind,
    SkeletonHeight, SkeletonShading, Sun,
};

/// What is different, and how.
pub type Edit = (&'static str, fn(&mut Design));

/// Scatterings of a cloth after which its light is estimated: where it has several, the first.
pub fn traced_bounces(design: &Design) -> u32 {
    u32::from(design.quality.bounces > 1)
}

/// Nothing.
const AS_IT_IS: Edit = ("as it is", |_| {});

/// Shapes of loops, and blocks of 1, 2 and 4 cells to find them.
pub const LOOPS: [Edit; 13] = [
    AS_IT_IS,
    ("wild", |d| {
        let pile = &mut d.pile;
        (pile.layers, pile.resolution, pile.variants) = (4, 9, 3);
        (pile.top_width, pile.tilt) = (1.3, 100.0);
        (pile.twist, pile.twist_jitter) = (140.0, 60.0);
    }),
    ("far apart", |d| {
        d.weave.pattern = Pattern::filled(1, 1, 9);
        (d.sheet.warps_per_cm, d.sheet.wefts_per_cm) = (4.0, 4.0);
        let pile = &mut d.pile;
        (pile.base_width, pile.top_width, pile.thickness) = (3.2, 3.2, 0.6);
        (pile.yarn_diameter, pile.tilt, pile.twist) = (0.5, 8.0, 20.0);
        (pile.lean_x, pile.lean_y, pile.jitter) = (0.0, 0.0, 2.0);
        d.view.cameras[0].distance = 60.0;
    }),
    ("long and lying", |d| {
        (d.length.value, d.pile.max_length) = (20.0, 30.0);
        (d.pile.lean_x, d.pile.tilt) = (60.0, 30.0);
        d.view.cameras[0].distance = 60.0;
    }),
    ("pointed", |d| {
        (d.pile.base_width, d.pile.top_width) = (3.0, 0.3);
        (d.pile.tilt, d.pile.twist) = (120.0, 143.0);
    }),
    ("wide and short", |d| {
        (d.pile.base_width, d.pile.top_width) = (4.0, 4.0);
        d.length.value = 0.4;
    }),
    ("cut", |d| {
        (d.pile.kind, d.pile.density, d.pile.layers) = (PileKind::Cut, 60.0, 1);
    }),
    ("nearest of few layers", |d| {
        d.pile.interpolation = Interpolation::Nearest;
        (d.pile.layers, d.pile.resolution) = (3, 5);
    }),
    ("nearest of many layers", |d| {
        d.pile.interpolation = Interpolation::Nearest;
        (d.pile.layers, d.pile.root_blend) = (24, 0.0);
    }),
    ("twisted", |d| {
        (d.pile.kind, d.length.value) = (PileKind::Twisted, 5.0);
    }),
    ("fur", |d| sparse(d, PileKind::Fur)),
    ("grass", |d| sparse(d, PileKind::Grass)),
    ("crowded and thin", |d| {
        d.weave.pattern = Pattern::filled(1, 1, 9);
        let pile = &mut d.pile;
        (pile.base_width, pile.top_width, pile.thickness) = (2.6, 2.6, 1.9);
        (pile.yarn_diameter, pile.tilt, pile.density) = (1.5, 20.0, 0.25);
        pile.root_blend = 1.0;
    }),
];

/// Exact parallelograms, A = 0. By `layered` every shadow ray that begins on a layer runs along others, and turns on
/// rounding: not among [`LOOPS`].
pub const UNBENT: Edit = ("unbent", |d| {
    let pile = &mut d.pile;
    pile.top_width = pile.base_width;
    (pile.lean_x, pile.lean_y, pile.tilt) = (0.0, 0.0, 0.0);
    (pile.twist, pile.twist_jitter) = (0.0, 0.0);
    (pile.stretch, pile.length_jitter) = (0.0, 0.0);
});

/// Long ways through frames that hold little yarn, skewed and bent.
fn sparse(d: &mut Design, kind: PileKind) {
    (d.pile.kind, d.length.value) = (kind, 8.0);
    let pile = &mut d.pile;
    (pile.base_width, pile.top_width, pile.thickness) = (4.0, 5.0, 4.0);
    (pile.yarn_diameter, pile.fibres, pile.plies) = (0.8, 12, 2);
    (pile.density, pile.hairiness) = (20.0, 0.0);
    d.view.cameras[0].distance = 60.0;
}

/// Patterns and what stands on the back.
pub const BACKS: [Edit; 4] = [
    AS_IT_IS,
    ("bare back", |d| d.weave.back = Back::None),
    ("mirrored back", |d| d.weave.back = Back::Mirror),
    ("few loops", |d| {
        d.weave.pattern =
            Pattern::try_from(vec![vec![1, 0, 1, 0], vec![0, 1, 0, 7], vec![0, 0, 1, 1]]).unwrap();
    }),
];

/// Ground yarns.
pub const GROUNDS: [Edit; 9] = [
    AS_IT_IS,
    ("no ground", |d| d.skeleton.visible = false),
    ("thick warps", |d| {
        (d.skeleton.warp_radius, d.skeleton.weft_radius) = (0.5, 0.2);
    }),
    ("thin yarns that wind", |d| {
        (d.skeleton.warp_radius, d.skeleton.weft_radius) = (0.06, 0.05);
        d.skeleton.crimp = 0.6;
    }),
    ("straight yarns", |d| d.skeleton.crimp = 0.0),
    ("phong", |d| {
        d.skeleton.shading = SkeletonShading::Phong;
        (d.skeleton.specular, d.skeleton.exponent) = (0.5, 8.0);
    }),
    ("fibres", |d| {
        d.skeleton.shading = SkeletonShading::PoulinFournier;
        (d.skeleton.specular, d.skeleton.fibre_spacing) = (0.5, 1.3);
    }),
    ("the paper's heights", |d| {
        d.skeleton.height = SkeletonHeight::Paper;
    }),
    ("the paper's heights, fibres", |d| {
        d.skeleton.height = SkeletonHeight::Paper;
        d.skeleton.shading = SkeletonShading::PoulinFournier;
        (d.skeleton.specular, d.skeleton.fibre_spacing) = (1.0, 2.5);
        (d.skeleton.warp_radius, d.skeleton.weft_radius) = (0.35, 0.2);
    }),
];

/// Phases and materials.
pub const LOOKS: [Edit; 6] = [
    AS_IT_IS,
    ("frame", |d| {
        (d.pile.phase, d.pile.transmission) = (Phase::FrameLambert, 0.3);
    }),
    ("gradient", |d| {
        (d.pile.phase, d.pile.transmission) = (Phase::GradientLambert, 0.3);
    }),
    ("fibre", |d| {
        d.pile.phase = Phase::KajiyaKay;
        (d.pile.specular, d.pile.exponent) = (0.5, 20.0);
    }),
    ("several materials", |d| {
        d.pile.phase = Phase::FrameLambert;
        several_materials(d);
    }),
    ("several materials of fibres", |d| {
        d.pile.phase = Phase::KajiyaKay;
        several_materials(d);
    }),
];

/// Three colours of loop, of which each has its own everything.
fn several_materials(design: &mut Design) {
    let colours = [[255, 255, 255], [200, 30, 30], [30, 30, 200]];
    let pixels = colours.map(|[r, g, b]| [r, g, b, 255]);
    design.chart.pixels = ChartImage::new(3, 1, &pixels);
    design.chart.fit = Fit::Tile;
    design.length.map = LengthMap::Lut;
    design.length.table = (0..3)
        .map(|k| LengthEntry {
            colour: Colour(colours[k]),
            length: [2.8, 2.0, 3.1][k],
            density: Some([10.0, 2.5, 25.0][k]),
            kind: (k == 1).then_some(PileKind::Cut),
            transmission: Some([0.1, 0.5, 1.0][k]),
            specular: Some([0.9, 0.5, 0.1][k]),
            exponent: Some([3.0, 30.0, 300.0][k]),
            ..LengthEntry::default()
        })
        .collect();
}

/// Suns, area lights and skies.
pub const LIGHTS: [Edit; 8] = [
    AS_IT_IS,
    ("a grazing sun", |d| {
        let sun = &mut d.light.sun[0];
        (sun.elevation, sun.azimuth) = (1.0, 17.0);
        (sun.angular_diameter, sun.irradiance) = (0.5, 4.0);
    }),
    ("level along a warp", |d| {
        (d.light.sun[0].elevation, d.light.sun[0].azimuth) = (0.0, 90.0);
        d.light.sun[0].angular_diameter = 0.0;
    }),
    ("suns from above and below", |d| {
        d.light.sun = [(-20.0, 200.0, 0.0), (80.0, 0.0, 60.0), (25.0, -60.0, 3.0)]
            .map(|(elevation, azimuth, angular_diameter)| Sun {
                elevation,
                azimuth,
                angular_diameter,
                ..Sun::default()
            })
            .to_vec();
    }),
    ("gradient sky", |d| {
        d.light.environment.kind = EnvironmentKind::Gradient;
        d.light.environment.radiance = 1.5;
    }),
    ("picture of a sky", |d| {
        d.light.sun.clear();
        let environment = &mut d.light.environment;
        (environment.kind, environment.image) = (EnvironmentKind::Image, Some("sky".into()));
        (environment.radiance, environment.rotation) = (2.0, 70.0);
        environment.pixels = Some(sky());
    }),
    ("closed at the first scattering", |d| {
        d.quality.bounces = 16;
    }),
    ("area lights", |d| {
        d.light.area = [(15.0, 180.0, 90.0), (80.0, 30.0, 60.0), (-50.0, 0.0, 200.0)]
            .map(|(elevation, azimuth, distance)| AreaLight {
                elevation,
                azimuth,
                distance,
                width: 40.0,
                height: 25.0,
                ..AreaLight::default()
            })
            .to_vec();
    }),
];

/// Surroundings with smooth patches of light of different colours.
fn sky() -> EnvironmentImage {
    let mut reader = EnvironmentReader::new(64, 32).unwrap();
    for y in 0..32 {
        for x in 0..64 {
            let wave = |k: usize| (1.0 + (0.3 * (x * k + y) as f32).sin()) / 2.0;
            reader.add(x, y, [wave(1), wave(2), wave(3)]);
        }
    }
    reader.finish().unwrap()
}

/// From where the cloth is seen.
pub const CAMERAS: [Edit; 9] = [
    AS_IT_IS,
    ("from behind", |d| d.view.cameras[0].elevation = -35.0),
    ("grazing", |d| d.view.cameras[0].elevation = 2.0),
    ("in the sheet's plane", |d| {
        d.view.cameras[0].elevation = 0.0;
    }),
    ("straight down", |d| d.view.cameras[0].elevation = 90.0),
    ("parallel", |d| {
        d.view.cameras[0].orthographic_height = Some(9.0);
    }),
    ("inside the pile", |d| {
        let camera = &mut d.view.cameras[0];
        (camera.target, camera.distance, camera.fov) = ([0.2, 0.1, 1.2], 0.7, 90.0);
    }),
    ("very near", |d| {
        let camera = &mut d.view.cameras[0];
        (camera.target, camera.distance) = ([0.0, 0.0, 2.5], 1.0);
    }),
    ("very far", |d| {
        let camera = &mut d.view.cameras[0];
        (camera.distance, camera.orthographic_height) = (100_000.0, Some(11.0));
    }),
];

/// Every way, group by group.
pub const GROUPS: [&[Edit]; 6] = [&LOOPS, &BACKS, &GROUNDS, &LOOKS, &LIGHTS, &CAMERAS];
