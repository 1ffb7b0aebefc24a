//! Bent cloth: the same pictures by all backends, and those of level cloth where a net only turns it.

use glam::{DMat3, DVec3};
use renderer_core::cpu::CpuBackend;
use renderer_core::design::{BentAlong, Colour, Design, FormKind, HeightImage, Method, Numbers};
use renderer_core::geometry::Camera;
use renderer_core::image::{Picture, metrics};
use renderer_core::render::{Backend, RenderRequest};
use renderer_core::scene::{
    CompileError, Compiler, FormMesh, KUHN_TETRAHEDRA, Net, compile, net_through,
};

use crate::agreement::{SIZE, Wrong, assert_agree_and_tell, tracked};
use crate::support::compare::same_as_reference;
use crate::support::device::{exact_gpu, finish, gpu, on_reference};
use crate::support::scenes::{request, small_towel};

/// A way to bend the small towel.
type Bend = (&'static str, fn(&mut Design));

/// Every kind of form, along and across, bent as sharply as its pile lets it.
const BENDS: [Bend; 9] = [
    ("waves", |d| {
        d.form.kind = FormKind::Wave;
        (d.form.wavelength, d.form.steepness) = (30.0, 25.0);
    }),
    ("waves along the wefts", |d| {
        d.form.kind = FormKind::Wave;
        d.form.along = BentAlong::Weft;
        (d.form.wavelength, d.form.steepness) = (20.0, 12.0);
    }),
    ("rolled with the back inside", |d| {
        d.form.kind = FormKind::Roll;
        (d.form.radius, d.form.rolled) = (2.0, 0.7);
        d.sheet.wefts = 30;
    }),
    ("rolled with the front inside", |d| {
        d.form.kind = FormKind::Roll;
        (d.form.radius, d.form.rolled) = (2.0, 0.7);
        (d.form.front_inside, d.form.along) = (true, BentAlong::Weft);
        d.sheet.warps = 30;
    }),
    ("over a rail", |d| {
        d.form.kind = FormKind::Hanging;
        (d.form.radius, d.form.wavelength, d.form.steepness) = (3.0, 30.0, 20.0);
        d.sheet.wefts = 60;
    }),
    ("a stack", |d| {
        d.form.kind = FormKind::Stack;
        (d.form.layers, d.form.gap) = (2, 2.0);
        d.sheet.wefts = 36;
    }),
    ("a net", |d| {
        d.form.kind = FormKind::Net;
        let [x, y] = size(d);
        d.form.net = net_through([5, 4], |across, along| {
            let (across, along) = (across - 0.5, along - 0.5);
            let height = 1.5 * (3.0 * across).sin() - 2.0 * along * along;
            [x * across * 1.1, y * along, height]
        });
    }),
    ("a net that lies on its side", |d| {
        d.form.kind = FormKind::Net;
        d.form.net = turned_net(d, turn(), DVec3::new(3.0, -1.0, 2.0));
    }),
    ("a height picture", |d| {
        d.form.kind = FormKind::Height;
        (d.form.height, d.form.smooth) = (3.0, 2.5);
        // Bright in the middle of the far edge, and to the right.
        let greys = [9000, 65535, 30000, 0, 12000, 48000, 5000, 0, 26000];
        d.form.pixels = HeightImage::new(3, 3, greys.to_vec());
    }),
];

/// Size of a design's sheet, mm.
fn size(design: &Design) -> [f64; 2] {
    let sheet = &design.sheet;
    [
        f64::from(sheet.warps) * sheet.pitch_x(),
        f64::from(sheet.wefts) * sheet.pitch_y(),
    ]
}

/// A rotation about no axis in particular.
fn turn() -> DMat3 {
    DMat3::from_axis_angle(DVec3::new(1.0, 0.4, -0.3).normalize(), 1.0)
}

/// A net that turns and moves level cloth.
fn turned_net(design: &Design, turn: DMat3, shift: DVec3) -> Vec<Vec<[f64; 3]>> {
    let [x, y] = size(design);
    net_through([4, 6], |across, along| {
        let level = DVec3::new(x * (across - 0.5), y * (along - 0.5), 0.0);
        (turn * level + shift).to_array()
    })
}

/// The small towel, bent.
fn bent((_, bend): Bend) -> Design {
    let mut design = small_towel();
    design.view.cameras[0].distance = 45.0;
    bend(&mut design);
    design
}

fn mesh(design: &Design) -> FormMesh {
    let scene = compile(design).unwrap();
    scene.form.as_ref().cloned().expect("bent cloth")
}

#[test]
fn processor_and_reference_draw_the_same_samples() {
    for bend in BENDS {
        for method in [Method::Single, Method::Layered] {
            let mut design = bent(bend);
            design.quality.method = method;
            let request = request(&design, [64, 48]);
            let expected = on_reference(&request);
            let covered = expected
                .pixels
                .iter()
                .filter(|pixel| pixel[3] > 0.5)
                .count();
            assert!(covered > 150, "{}: {covered} pixels of cloth", bend.0);
            let drawn = finish(&mut CpuBackend::default(), &request);
            same_as_reference(&request, &expected, &drawn)
                .unwrap_or_else(|error| panic!("{}, {}: {error}", bend.0, method.name()));
        }
    }
}

/// How many pixels of two pictures differ by more than a hundredth of what is white.
fn differing(a: &Picture, b: &Picture) -> usize {
    let pairs = a.pixels.iter().zip(&b.pixels);
    let differs = |(a, b): &(&[f32; 4], &[f32; 4])| {
        // NaN is near nothing.
        let is_near = (0..4).all(|c| (a[c] - b[c]).abs() <= 0.01 * a[c].abs().max(1.0));
        !is_near
    };
    pairs.filter(differs).count()
}

/// Whether a picture of bent cloth by the GPU holds the reference's samples. f32 knows a place in the world to 10⁻⁵ mm
/// where it knows one of level cloth, seen from its cell, to 10⁻⁷: more samples turn on rounding, and voxels change
/// some by a few thousandths. So flips are counted: up to this share of the pixels may be.
pub fn nearly_same(expected: &Picture, drawn: &Picture, most_share: f64) -> Result<(), String> {
    let flips = differing(expected, drawn);
    let most = (most_share * expected.pixels.len() as f64) as usize;
    if flips <= most {
        Ok(())
    } else {
        Err(format!("{flips} pixels differ, at most {most} may"))
    }
}

#[test]
fn the_gpu_and_the_reference_draw_the_same_samples() {
    let mut backend = exact_gpu();
    for bend in BENDS {
        for method in [Method::Single, Method::Exact] {
            let mut design = bent(bend);
            design.quality.method = method;
            let request = request(&design, [32, 24]);
            let expected = on_reference(&request);
            let drawn = finish(&mut backend, &request);
            // Found: up to four in a thousand.
            nearly_same(&expected, &drawn, 0.01)
                .unwrap_or_else(|error| panic!("{}, {}: {error}", bend.0, method.name()));
            // Samples of another seed differ nearly everywhere.
            let mut other = request.clone();
            other.settings.seed += 1;
            assert!(
                differing(&expected, &on_reference(&other)) > 40,
                "{}",
                bend.0
            );
        }
    }
}

#[test]
fn tracked_light_has_the_same_mean_on_all_backends() {
    let wrongs: [Wrong; 2] = [
        ("level", |d| d.form.kind = FormKind::Flat),
        ("gentler", |d| {
            d.form.steepness *= 0.3;
            d.form.radius *= 2.0;
        }),
    ];
    for bend in [BENDS[0], BENDS[2]] {
        eprintln!("{}", bend.0);
        let mut design = bent(bend);
        design.view.cameras[0].distance = 16.0;
        design.light.background = Colour([0; 3]);
        let design = tracked(design, 3);
        assert_agree_and_tell(&mut CpuBackend::default(), &design, SIZE, &wrongs, 0.06);
        // What is wrong is told from what is right by the same comparison.
        assert_agree_and_tell(&mut gpu(), &design, SIZE, &[], 0.06);
    }
}

/// A request for level cloth, and one for cloth that a net turns and moves, with camera and suns turned alike.
fn turned_requests(method: Method) -> [RenderRequest; 2] {
    let mut level = small_towel();
    level.quality.method = method;
    level.light.environment.radiance = 0.0;
    level.light.sun[0].angular_diameter = 0.0;
    let (turn, shift) = (turn(), DVec3::new(3.0, -1.0, 2.0));
    let mut turned = level.clone();
    turned.form.kind = FormKind::Net;
    turned.form.net = turned_net(&level, turn, shift);
    let sun = compile(&level).unwrap().lights.suns[0].direction;
    let sun_there = turn * DVec3::from_array(sun);
    turned.light.sun[0].azimuth = sun_there.y.atan2(sun_there.x).to_degrees();
    turned.light.sun[0].elevation = sun_there.z.asin().to_degrees();
    let mut requests = [level, turned].map(|design| request(&design, [48, 40]));
    let camera = *requests[0].camera();
    requests[1].view.levels.nearest.camera = Camera {
        eye: turn * camera.eye + shift,
        right: turn * camera.right,
        up: turn * camera.up,
        forward: turn * camera.forward,
        ..camera
    };
    requests
}

#[test]
fn turned_cloth_looks_as_level_cloth_does_from_there() {
    let backends: [(&str, Box<dyn Backend>, &[Method]); 2] = [
        (
            "processor",
            Box::new(CpuBackend::default()),
            &[Method::Single, Method::Layered],
        ),
        (
            "gpu",
            Box::new(exact_gpu()),
            &[Method::Single, Method::Exact],
        ),
    ];
    for (name, mut backend, methods) in backends {
        for &method in methods {
            let [level, turned] = turned_requests(method);
            let [expected, drawn] = [&level, &turned].map(|request| finish(&mut *backend, request));
            // Found: none. Corners rounded to f32 may move what a ray grazes, one pixel in five hundred here.
            let flips = differing(&expected, &drawn);
            assert!(flips <= 4, "{name}, {}: {flips}", method.name());
            // Without turning the camera little is the same.
            let mut unturned = turned.clone();
            unturned.view.levels.nearest.camera = *level.camera();
            assert!(differing(&expected, &finish(&mut *backend, &unturned)) > 300);
        }
    }
}

#[test]
fn normals_and_depths_are_those_of_the_world() {
    let [mut level, mut turned] = turned_requests(Method::Single);
    for request in [&mut level, &mut turned] {
        request.settings.aov = true;
    }
    let mut backends: [(&str, Box<dyn Backend>); 2] = [
        ("processor", Box::new(CpuBackend::default())),
        ("gpu", Box::new(exact_gpu())),
    ];
    for (name, backend) in &mut backends {
        let [there, here] = [&level, &turned].map(|request| {
            let picture = finish(&mut **backend, request);
            picture.aov.expect("asked for")
        });
        let pairs = there.normal.iter().zip(&here.normal);
        let turned_alike = pairs.filter(|(a, b)| {
            let [a, b] = [a, b].map(|normal| DVec3::from_array(normal.map(f64::from)));
            (turn() * a - b).length() < 0.02
        });
        let count = there.normal.len();
        // As above: found is none, and four may be.
        assert!(turned_alike.count() + 4 >= count, "{name}");
        let depths = there.depth.iter().zip(&here.depth);
        let same = depths.filter(|(a, b)| a == b || (*a - *b).abs() < 0.01);
        assert!(same.count() + 4 >= count, "{name}");
    }
}

#[test]
fn the_environment_is_that_of_the_world() {
    // Light from above alone: of cloth turned upside down the camera below sees the dark side.
    let mut design = small_towel();
    design.light.sun.clear();
    design.light.environment.kind = renderer_core::design::EnvironmentKind::Gradient;
    (
        design.light.environment.zenith,
        design.light.environment.horizon,
    ) = (Colour::WHITE, Colour([128; 3]));
    design.light.environment.ground = Colour([0; 3]);
    design.light.background = Colour([0; 3]);
    let design = tracked(design, 2);
    let over = DMat3::from_rotation_x(std::f64::consts::PI);
    let brightness = |turn: DMat3, backend: &mut dyn Backend| {
        let mut design = design.clone();
        design.form.kind = FormKind::Net;
        design.form.net = turned_net(&design, turn, DVec3::ZERO);
        let mut request = request(&design, SIZE);
        let camera = *request.camera();
        request.view.levels.nearest.camera = Camera {
            eye: turn * camera.eye,
            right: turn * camera.right,
            up: turn * camera.up,
            forward: turn * camera.forward,
            ..camera
        };
        metrics::mean_luminance(&finish(backend, &request))
    };
    let mut backends: [Box<dyn Backend>; 2] =
        [Box::new(CpuBackend::default()), Box::new(exact_gpu())];
    for backend in &mut backends {
        let [above, below] = [DMat3::IDENTITY, over].map(|turn| brightness(turn, &mut **backend));
        assert!(below < 0.75 * above, "{below} {above}");
    }
}

#[test]
fn nothing_shines_through_the_seams_of_facets() {
    // A ground as tight as paper, without loops, before a bright wall and in the dark: what is seen of the wall inside
    // of the cloth's outline has come through a seam.
    let mut design = small_towel();
    design.weave.pattern = renderer_core::design::Pattern::filled(1, 1, 1);
    design.light.sun.clear();
    design.light.environment.radiance = 0.0;
    design.light.background = Colour::WHITE;
    (design.skeleton.warp_radius, design.skeleton.weft_radius) = (0.6, 0.6);
    (design.sheet.warps, design.sheet.wefts) = (60, 60);
    design.form.kind = FormKind::Wave;
    (design.form.wavelength, design.form.steepness) = (25.0, 60.0);
    design.quality.samples = 16;
    let camera = &mut design.view.cameras[0];
    (camera.elevation, camera.azimuth) = (80.0, 20.0);
    camera.orthographic_height = Some(18.0);
    let request = request(&design, [128, 96]);
    assert!(request.scene().form.as_ref().unwrap().facets[0] > 4);
    let mut backends: [(&str, Box<dyn Backend>); 2] = [
        ("processor", Box::new(CpuBackend::default())),
        ("gpu", Box::new(exact_gpu())),
    ];
    for (name, backend) in &mut backends {
        let picture = finish(&mut **backend, &request);
        let brightest = picture
            .pixels
            .iter()
            .fold(0.0, |most: f32, pixel| most.max(pixel[0]));
        assert_eq!(brightest, 0.0, "{name}");
    }
}

#[test]
fn cloth_is_bent_and_not_stretched() {
    let stretches = |bend: &&Bend| bend.0.contains("net") || bend.0.contains("picture");
    for bend in BENDS.iter().filter(|bend| !stretches(bend)) {
        let mut design = bent(*bend);
        // Long enough for several turns and folds.
        (design.sheet.warps, design.sheet.wefts) = (90, 90);
        let mesh = mesh(&design);
        let middle = -mesh.heights[0] / (mesh.heights[1] - mesh.heights[0]);
        for facet in mesh.all_facets() {
            let at = |x: f64, y: f64| {
                let coordinates = DVec3::new(x, y, middle);
                mesh.tet(facet, FormMesh::tetrahedron_of(coordinates))
                    .at(coordinates)
            };
            let lengths = [at(1.0, 0.0) - at(0.0, 0.0), at(0.0, 1.0) - at(0.0, 0.0)];
            let flat = mesh.facet_mm();
            // Chords are shorter than arcs by a twenty-fourth of their angle's square: facets are no smaller than a
            // block, here up to 0.35 of the roll's and the folds' radius. Hanging folds shear a little.
            let most = if bend.0 == "over a rail" { 0.1 } else { 0.006 };
            for (length, flat) in lengths.iter().zip([flat.x, flat.y]) {
                let stretched = length.length() / flat - 1.0;
                assert!(stretched.abs() < most, "{}: {stretched}", bend.0);
            }
        }
    }
}

#[test]
fn neighbouring_tetrahedra_share_their_faces() {
    let mesh = mesh(&bent(BENDS[6]));
    for facet in mesh.all_facets() {
        for tetrahedron in KUHN_TETRAHEDRA {
            let map = mesh.tet(facet, tetrahedron);
            // The corner after the second axis lies in all orders that begin with these two in either order.
            let mut coordinates = DVec3::ZERO;
            (coordinates[tetrahedron[0]], coordinates[tetrahedron[1]]) = (1.0, 1.0);
            let swapped = mesh.tet(facet, [tetrahedron[1], tetrahedron[0], tetrahedron[2]]);
            assert!(map.at(coordinates).distance(swapped.at(coordinates)) < 1e-9);
            // The far upper corner is the near upper one of the next facet.
            let next = [facet[0] + 1, facet[1] + 1];
            if mesh.has(next) {
                let there = mesh.tet(next, [2, 0, 1]).at(DVec3::Z);
                assert!(map.at(DVec3::ONE).distance(there) < 1e-9);
            }
        }
    }
}

#[test]
fn places_of_the_sheet_are_found_again() {
    let mesh = mesh(&bent(BENDS[0]));
    let (facet, coordinates) = ([1, 0], DVec3::new(0.3, 0.6, 0.8));
    let sheet = mesh.sheet_of(facet, coordinates);
    let (found, again) = mesh.cell_coordinates_of(sheet);
    assert_eq!(found, facet);
    assert!(again.distance(coordinates) < 1e-9);
    assert_eq!(FormMesh::tetrahedron_of(coordinates), [2, 1, 0]);
    let world = mesh.world_of(sheet);
    assert!(world.distance(mesh.tet(facet, [2, 1, 0]).at(coordinates)) < 1e-9);
    let [low, high] = mesh.bounds();
    assert!(low.cmple(world).all() && world.cmple(high).all());
}

#[test]
fn pointed_places_are_those_that_are_seen() {
    // The picture of a camera and the way back: a sheet position whose place in the world is seen straight on is the
    // one that its pixel shows.
    let design = bent(BENDS[0]);
    let mesh = mesh(&design);
    let camera = Camera::from_design(&design.view.cameras[0]);
    let size = [160, 120];
    for [x, y] in [[0.0, 0.0], [2.0, -1.5], [-3.1, 2.2]] {
        let height = 1.0;
        let world = mesh.world_of(DVec3::new(x, y, height));
        let pixel = camera.pixel_of(world, size).expect("ahead");
        let (origin, direction) = camera.ray(pixel, size);
        let way = (world - origin).normalize();
        assert!(way.distance(direction) < 1e-9);
        let ray = renderer_core::geometry::Ray { origin, direction };
        let (found, is_front) = mesh.pick(&ray, [height, -1.0]).expect("cloth");
        assert!(
            is_front && found.distance(glam::DVec2::new(x, y)) < 1e-6,
            "{found}"
        );
    }
    let back = renderer_core::geometry::Ray {
        origin: DVec3::new(0.0, 0.0, -50.0),
        direction: DVec3::Z,
    };
    assert!(matches!(mesh.pick(&back, [1.0, -1.0]), Some((_, false))));
    let beside = renderer_core::geometry::Ray {
        origin: DVec3::new(500.0, 0.0, -50.0),
        direction: DVec3::Z,
    };
    assert!(mesh.pick(&beside, [1.0, -1.0]).is_none());
}

#[test]
fn nets_pass_through_their_corners_and_lie_level_at_rest() {
    let net = net_through([6, 4], |across, along| [10.0 * across, 20.0 * along, 3.0]);
    let surface = Net::new(&net);
    for [across, along] in [[0.0, 0.0], [1.0, 0.0], [0.3, 0.7], [1.0, 1.0], [-0.2, 1.1]] {
        let expected = DVec3::new(10.0 * across, 20.0 * along, 3.0);
        let found = surface.at(across, along);
        assert!(found.distance(expected) < 1e-9, "{across} {along}: {found}");
    }
    // A corner point is where the surface ends; an inner one only pulls.
    let mut pulled = net.clone();
    pulled[0][0][2] = 9.0;
    pulled[1][2][2] = 30.0;
    let surface = Net::new(&pulled);
    assert!((surface.at(0.0, 0.0).z - 9.0).abs() < 1e-9);
    let rest = [net[1][2][0] / 10.0, net[1][2][1] / 20.0];
    let height = surface.at(rest[0], rest[1]).z;
    assert!(5.0 < height && height < 29.0, "{height}");
    // Smooth: slopes on both sides of a knot are the same.
    let slope = |x: f64| (surface.at(x + 1e-6, 0.4) - surface.at(x - 1e-6, 0.4)) / 2e-6;
    let knot = 1.0 / 3.0;
    assert!((slope(knot - 1e-5) - slope(knot + 1e-5)).length() < 0.1);
}

#[test]
fn what_cannot_be_bent_is_refused() {
    let refused = |edit: &dyn Fn(&mut Design), path: &str| {
        let mut design = small_towel();
        edit(&mut design);
        let Err(CompileError::Invalid(faults)) = compile(&design) else {
            panic!("{path} should be refused");
        };
        assert!(faults.iter().any(|fault| fault.path == path), "{faults:?}");
    };
    refused(
        &|d| {
            d.form.kind = FormKind::Wave;
            (d.form.wavelength, d.form.steepness) = (5.0, 70.0);
        },
        "form.kind",
    );
    refused(
        &|d| {
            d.form.kind = FormKind::Stack;
            d.form.layers = 40;
        },
        "form.layers",
    );
    refused(&|d| d.form.kind = FormKind::Net, "form.net");
    refused(&|d| d.form.net = vec![vec![[0.0; 3]; 4]; 3], "form.net");
    refused(
        &|d| {
            d.form.net = vec![vec![[0.0; 3]; 4]; 4];
            d.form.net[2].pop();
        },
        "form.net[2]",
    );
    refused(
        &|d| {
            d.form.net = vec![vec![[0.0; 3]; 4]; 4];
            d.form.net[1][3][2] = f64::NAN;
        },
        "form.net[1][3][2]",
    );
    for (field, value) in Design::default().form.numbers() {
        assert!((field.min..=field.max).contains(&value), "{}", field.name);
    }
}

#[test]
fn only_what_bends_the_cloth_makes_its_form_anew() {
    let mut design = bent(BENDS[0]);
    let mut compiler = Compiler::default();
    let first = compiler.compile(&design).unwrap();
    design.light.sun[0].azimuth += 10.0;
    design.chart.colour = Colour([10, 20, 30]);
    let lit = compiler.compile(&design).unwrap();
    assert!(first.form == lit.form);
    design.form.steepness += 1.0;
    let steeper = compiler.compile(&design).unwrap();
    assert!(lit.form != steeper.form && lit.loops == steeper.loops);
    design.form.kind = FormKind::Flat;
    let level = compiler.compile(&design).unwrap();
    assert!(level.form.is_none());
    // The form of level cloth stays, whatever becomes of its loops.
    design.length.value += 1.0;
    let longer = compiler.compile(&design).unwrap();
    assert!(longer.form == level.form && longer.loops != level.loops);
}

#[test]
fn sharply_bent_cloth_has_smaller_facets() {
    let facets = |steepness: f64| {
        let mut design = bent(BENDS[0]);
        (design.sheet.warps, design.sheet.wefts) = (80, 80);
        design.form.steepness = steepness;
        mesh(&design).facets
    };
    let (gentle, sharp) = (facets(2.0), facets(25.0));
    assert!(gentle[1] < sharp[1], "{gentle:?} {sharp:?}");
}
