//! Pictures of the surroundings as they are kept: reduced by area, mended where light is impossible.

use renderer_core::design::{
    Design, EnvironmentFault, EnvironmentImage, EnvironmentKind, EnvironmentReader, preset,
};

/// All pixels of a picture through a reader.
fn read(width: usize, colour: impl Fn(usize, usize) -> [f32; 3]) -> EnvironmentImage {
    let mut reader = EnvironmentReader::new(width, width / 2).unwrap();
    for y in 0..width / 2 {
        for x in 0..width {
            reader.add(x, y, colour(x, y));
        }
    }
    reader.finish().unwrap()
}

#[test]
fn large_pictures_are_reduced_by_area() {
    // 1.5 pixels to one: of a ramp each kept pixel holds the mean over its own stretch.
    let image = read(1536, |x, y| [x as f32, y as f32, 1.0]);
    assert_eq!((image.width(), image.height()), (1024, 512));
    assert_eq!(image.file_size(), [1536, 768]);
    for k in 0..512 {
        // Kept pixel k covers 1.5k to 1.5k + 1.5 of steps that are a pixel wide.
        let steps = |k: usize| {
            if k.is_multiple_of(2) {
                1.0 / 3.0
            } else {
                2.0 / 3.0
            }
        };
        let expected = (1.5 * k as f64).floor() + steps(k);
        let [across, down, one] = image.pixel(k, k).map(f64::from);
        for value in [across, down] {
            // f32 of a few hundred.
            assert!(
                (value - expected).abs() < 1e-4,
                "{k}: {value}, not {expected}"
            );
        }
        assert!((one - 1.0).abs() < 1e-6, "{k}: {one}");
    }
    // Nothing gets lost: one bright pixel keeps its light.
    let spot = read(2050, |x, y| [f32::from(u8::from((x, y) == (1001, 17))); 3]);
    assert_eq!(spot.width(), 1024);
    let light: f64 = spot.pixels().iter().map(|p| f64::from(p[0])).sum();
    let expected = (1024.0 / 2050.0_f64).powi(2);
    assert!((light - expected).abs() < 1e-6, "{light}, not {expected}");
    // What is small enough is kept as it is.
    let small = read(6, |x, y| [x as f32, y as f32, 0.1]);
    for (k, &pixel) in small.pixels().iter().enumerate() {
        assert_eq!(pixel, [(k % 6) as f32, (k / 6) as f32, 0.1]);
    }
}

#[test]
fn light_below_zero_and_beyond_all_suns_is_mended_and_reported() {
    let image = read(4, |x, y| match (x, y) {
        (0, 0) => [-0.5, 2.0, 0.0],
        (1, 0) => [f32::INFINITY, 1.0, 1.0],
        (2, 1) => [1.0, 1.0, 3e7],
        _ => [1.0; 3],
    });
    assert_eq!(image.mended(), 3);
    assert_eq!(image.pixel(0, 0), [0.0, 2.0, 0.0]);
    assert_eq!(image.pixel(1, 0), [1e6, 1.0, 1.0]);
    assert_eq!(image.pixel(2, 1), [1.0, 1.0, 1e6]);
    let mut design = Design::default();
    assert_eq!(design.warnings(), []);
    design.light.environment.pixels = Some(image);
    let warnings = design.warnings();
    assert_eq!(warnings[0].path, "light.environment.image");
    assert!(
        warnings[0]
            .text
            .starts_with("3 pixels of the environment's image")
    );
    assert_eq!(
        EnvironmentReader::new(3, 2).unwrap_err(),
        EnvironmentFault::Proportion {
            width: 3,
            height: 2
        }
    );
    assert!(EnvironmentReader::new(0, 0).is_err());
}

#[test]
fn an_image_is_asked_for_where_the_kind_needs_one() {
    let text = "format = 1\n[light.environment]\nkind = 'image'";
    let faults = preset::parse(text).unwrap_err();
    assert_eq!(
        faults[0].to_string(),
        "2:1: light.environment.image is left out, allowed is the path of an image when light.environment.kind is \
         \"image\""
    );
    let mut design = Design::default();
    design.light.environment.kind = EnvironmentKind::Gradient;
    assert_eq!(design.faults(), []);
}
