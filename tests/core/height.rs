//! Height pictures: the surface is the spline that they tell.

use glam::DVec3;
use renderer_core::design::{Design, FormKind, HeightImage, preset};
use renderer_core::scene::{CompileError, Compiler, FormMesh, compile};

/// A picture whose grey, from 0 to 1, is given at the middles of its pixels, counted from the lower left corner.
fn picture(width: usize, height: usize, grey: impl Fn(f64, f64) -> f64) -> HeightImage {
    let at = |index: usize| {
        let (x, row) = (index % width, index / width);
        let grey = grey(x as f64 + 0.5, (height - row) as f64 - 0.5);
        (grey * 65535.0).round() as u16
    };
    HeightImage::new(width, height, (0..width * height).map(at).collect()).unwrap()
}

/// Cloth of 80 × 60 mm under a picture.
fn under(picture: HeightImage, height: f64, smooth: f64) -> Design {
    let mut design = Design::default();
    (design.sheet.warps, design.sheet.wefts) = (80, 60);
    (design.sheet.warps_per_cm, design.sheet.wefts_per_cm) = (10.0, 10.0);
    let pile = &mut design.pile;
    (pile.layers, pile.resolution, pile.variants) = (2, 6, 1);
    design.form.kind = FormKind::Height;
    (design.form.height, design.form.smooth) = (height, smooth);
    design.form.pixels = Some(picture);
    design
}

fn mesh(design: &Design) -> FormMesh {
    compile(design).unwrap().form.as_ref().cloned().unwrap()
}

/// Calls `check` with points of the surface at least so far inside of the cloth of 80 × 60 mm, and the normals there;
/// how many.
fn inside(design: &Design, margin: f64, mut check: impl FnMut(DVec3, DVec3)) -> u32 {
    let mesh = mesh(design);
    let [low, high] = mesh.heights;
    let mut count = 0;
    for [lower, upper] in &mesh.corners {
        let [lower, upper] = [lower, upper].map(|end| DVec3::from_array(end.map(f64::from)));
        let normal = (upper - lower) / (high - low);
        let point = lower - normal * low;
        if point.x.abs() < 40.0 - margin && point.y.abs() < 30.0 - margin {
            check(point, normal);
            count += 1;
        }
    }
    count
}

#[test]
fn the_surface_is_the_spline_of_the_picture() {
    // A spline through the squares of whole numbers is the square and a third; means over squares that hold several
    // pixels add a twelfth of their own side and take away that of a pixel. A plane stays a plane.
    for (pixels_per_mm, smooth) in [(1.0_f64, 0.5_f64), (1.0, 4.0), (4.0, 2.0), (0.5, 1.0)] {
        let (width, height) = (80.0 * pixels_per_mm, 60.0 * pixels_per_mm);
        let grey = |x: f64, y: f64| {
            let (x, y) = (x / pixels_per_mm - 40.0, y / pixels_per_mm - 30.0);
            0.5 + 0.2 * (x / 40.0).powi(2) + 0.1 * y / 30.0
        };
        let high = 12.0;
        let picture = picture(width as usize, height as usize, grey);
        let (pixel, square) = (1.0 / pixels_per_mm, smooth.max(1.0 / pixels_per_mm));
        let blended = square * square * (1.0 / 3.0 + 1.0 / 12.0) - pixel * pixel / 12.0;
        let design = under(picture, high, smooth);
        let count = inside(&design, 3.0 * square, |point, normal| {
            let curved = 0.2 / 1600.0 * (point.x * point.x + blended);
            let expected = high * (0.5 + curved + 0.1 * point.y / 30.0);
            // Greys are rounded to 12 mm / 65535, corners to f32.
            assert!((point.z - expected).abs() < 3e-4, "{point} {expected}");
            let slope = DVec3::new(-high * 0.4 * point.x / 1600.0, -high * 0.1 / 30.0, 1.0);
            let turned = normal.angle_between(slope.normalize());
            assert!(turned < 2e-3, "{point}: {turned}");
            assert!((normal.length() - 1.0).abs() < 1e-4);
        });
        assert!(count > 50, "{count}");
    }
}

#[test]
fn black_is_level_and_row_0_is_the_far_edge() {
    let black = under(picture(3, 2, |_, _| 0.0), 15.0, 6.0);
    // Level cloth has few facets, so that most corners lie beyond its edges.
    let beyond = -20.0;
    let count = inside(&black, beyond, |point, normal| {
        assert!(point.z.abs() < 1e-5 && normal.distance(DVec3::Z) < 1e-5);
    });
    assert!(count > 0);
    let white = under(picture(1, 1, |_, _| 1.0), -15.0, 6.0);
    let count = inside(&white, beyond, |point, _| {
        assert!((point.z + 15.0).abs() < 1e-4);
    });
    assert!(count > 0);
    // Brighter towards the far edge, and to the right; written as files are, the upper row first.
    let greys = vec![30000, 65535, 0, 30000];
    let slope = mesh(&under(HeightImage::new(2, 2, greys).unwrap(), 9.0, 6.0));
    let height = |x: f64, y: f64| slope.world_of(DVec3::new(x, y, 0.0)).z;
    assert!(height(39.0, 29.0) > height(-39.0, 29.0) + 2.0);
    assert!(height(-39.0, 29.0) > height(-39.0, -29.0) + 2.0);
}

#[test]
fn steps_between_greys_are_no_stairs() {
    // A slope of 24 greys only, each 3.3 mm long: as stairs, half of the cloth were level and the other half steep.
    let grey = |x: f64, _: f64| (x / 320.0 * 24.0).floor() / 24.0;
    let steepest = |smooth: f64| {
        let design = under(picture(320, 240, grey), 20.0, smooth);
        let mut most = 0.0_f64;
        let plane = DVec3::new(-20.0 / 80.0, 0.0, 1.0).normalize();
        inside(&design, 16.0, |_, normal| {
            most = most.max(normal.angle_between(plane).to_degrees());
        });
        most
    };
    let [rough, default] = [steepest(1.5), steepest(Design::default().form.smooth)];
    assert!(default < 1.0 && rough > 4.0, "{default} {rough}");
}

fn refused(design: &Design) -> String {
    match compile(design) {
        Err(CompileError::Invalid(faults)) => faults[0].to_string(),
        other => panic!("{:?} should be refused", other.map(|_| ())),
    }
}

#[test]
fn what_cannot_be_raised_is_refused() {
    let cliff = under(picture(80, 60, |x, _| f64::from(x > 40.0)), 30.0, 2.0);
    let message = refused(&cliff);
    for part in [
        "form.height is 30, bent so sharply",
        "passes through itself, allowed is less height, more of form.smooth, another form.image",
    ] {
        assert!(message.contains(part), "{message}");
    }
    // Each of what it advises helps.
    let mut lower = cliff.clone();
    lower.form.height = 1.0;
    assert!(compile(&lower).is_ok());
    let mut smoother = cliff.clone();
    smoother.form.smooth = 30.0;
    assert!(compile(&smoother).is_ok());

    let mut without = cliff;
    without.form.pixels = None;
    assert_eq!(
        refused(&without),
        "form.image is left out, allowed is the path of a picture when form.kind is \"height\""
    );
}

#[test]
fn a_single_steep_place_is_found_wherever_it_is() {
    // Also between the lines that would do for forms that bend alike beside them.
    let facets = |[at_x, at_y]: [f64; 2]| {
        let spot = move |x: f64, y: f64| f64::from((x - at_x).hypot(y - at_y) < 3.0);
        let mut design = under(picture(320, 240, spot), 2.5, 1.0);
        (design.sheet.warps, design.sheet.wefts) = (320, 240);
        design.length.value = 0.5;
        mesh(&design).facets
    };
    let level = facets([-50.0; 2]);
    for k in 0..6 {
        let at = [60.0 + 33.0 * f64::from(k), 50.0 + 23.0 * f64::from(k)];
        let steep = facets(at);
        assert!(steep[0] > level[0], "{at:?}: {steep:?} {level:?}");
    }
}

#[test]
fn only_the_form_follows_from_the_picture() {
    let hill = |x: f64, y: f64| 0.5 - 0.25 * ((x / 4.0).cos() + (y / 4.0).cos());
    let mut design = under(picture(40, 30, hill), 3.0, 6.0);
    let mut compiler = Compiler::default();
    let mut last = compiler.compile(&design).unwrap();
    for edit in [
        &|d: &mut Design| d.form.height = 4.0,
        &|d: &mut Design| d.form.smooth = 8.0,
        &|d: &mut Design| d.form.pixels = HeightImage::new(2, 1, vec![0, 30000]),
    ] as [&dyn Fn(&mut Design); 3]
    {
        edit(&mut design);
        let next = compiler.compile(&design).unwrap();
        let same = next.same_sections(&last);
        assert_eq!(same, [true, true, true, true, true, true, false, true]);
        last = next;
    }
    // The same pixels in another place of memory are the same picture.
    design.form.pixels = HeightImage::new(2, 1, vec![0, 30000]);
    assert!(std::sync::Arc::ptr_eq(
        &compiler.compile(&design).unwrap(),
        &last
    ));
}

#[test]
fn pictures_have_pixels_for_their_size() {
    assert!(HeightImage::new(2, 2, vec![0; 3]).is_none());
    assert!(HeightImage::new(0, 2, Vec::new()).is_none());
    let side = HeightImage::MAX_SIDE + 1;
    assert!(HeightImage::new(side, 1, vec![0; side]).is_none());
    assert_eq!(
        format!("{:?}", picture(3, 2, |_, _| 0.0)),
        "HeightImage(3 x 2)"
    );
}

#[test]
fn setting_another_field_keeps_the_picture() {
    let mut design = under(picture(2, 2, |_, _| 0.5), 1.0, 6.0);
    design.form.image = Some("a.png".into());
    let higher = preset::set(&design, "form.height", "2").unwrap();
    assert_eq!(higher.form.pixels, design.form.pixels);
    let other = preset::set(&design, "form.image", "b.png").unwrap();
    assert_eq!(other.form.pixels, None);
}
