//! Editing charts: tiles that are shared, cutting and turning, painting, yarns, and charts as PNG files.

use std::collections::{HashMap, HashSet};

use palette::{FromColor, Oklab, Srgb};
use std::sync::Arc;

use renderer_core::design::chart_edit::{
    BARE, Dither, LoopsPerPixel, Resampling, YarnCounts, choose_yarns, crop, draw_line, flip_x,
    flip_y, linear_from_oklab, nearest_srgb, oklab, oklab_from_linear, outline_rectangle,
    precise_oklab, reduce_to, replace_yarn, resize, rotate_left, rotate_right,
};
use renderer_core::design::{ChartImage, TILE};
use renderer_core::image::{encode_chart_png, png_text};
use renderer_core::sampling::hash;

/// An image of more colours than a tile can list, no two neighbours alike.
fn noise(width: usize, height: usize) -> ChartImage {
    ChartImage::from_fn(width, height, |x, y| {
        let [r, g, b, _] = hash((y * width + x) as u32).to_le_bytes();
        [r, g, b, 255]
    })
    .unwrap()
}

/// An image of few colours in patches.
fn patches(width: usize, height: usize, yarns: &[[u8; 4]]) -> ChartImage {
    ChartImage::from_fn(width, height, |x, y| {
        yarns[(hash((y / 9 * 1000 + x / 7) as u32) as usize) % yarns.len()]
    })
    .unwrap()
}

fn pixels(image: &ChartImage) -> Vec<[u8; 4]> {
    let (width, height) = (image.width(), image.height());
    (0..width * height)
        .map(|k| image.pixel(k % width, k / width))
        .collect()
}

const RED: [u8; 4] = [200, 30, 30, 255];
const NAVY: [u8; 4] = [20, 30, 90, 255];
const WHITE: [u8; 4] = [255; 4];

#[test]
fn an_image_gives_back_its_pixels_whatever_its_tiles_hold() {
    // One colour, a few, 256, 257 and thousands; sides that fill tiles and sides that don't.
    for (width, height) in [(1, 1), (TILE, TILE), (TILE + 1, 3), (300, 200)] {
        for colours in [1, 3, 256, 257, 5000] {
            let pixels: Vec<[u8; 4]> = (0..width * height)
                .map(|k| {
                    let [a, b, ..] = ((k * 7) as u32 % colours).to_le_bytes();
                    [a, b, 9, 255 - b]
                })
                .collect();
            let image = ChartImage::new(width, height, &pixels).unwrap();
            assert_eq!(
                self::pixels(&image),
                pixels,
                "{width} x {height}, {colours}"
            );
            assert_eq!(image, ChartImage::new(width, height, &pixels).unwrap());
        }
    }
    assert!(ChartImage::new(2, 2, &[WHITE; 3]).is_none());
    assert!(ChartImage::filled(0, 5, WHITE).is_none());
    assert!(ChartImage::filled(5, ChartImage::MAX_SIDE + 1, WHITE).is_none());
}

#[test]
fn images_of_equal_pixels_are_equal_however_they_came_about() {
    let painted = |image: &ChartImage| {
        let mut image = image.clone();
        image.fill_rectangle(3..9, 2..5, NAVY);
        image.fill_rectangle(3..9, 2..5, RED);
        image
    };
    let plain = ChartImage::filled(150, 140, RED).unwrap();
    // Navy is still listed, and what lies beyond the image is red or not.
    assert_eq!(painted(&plain), plain);
    assert_eq!(
        replace_yarn(&painted(&plain), RED, NAVY),
        replace_yarn(&plain, RED, NAVY)
    );
    let mut other = plain.clone();
    other.fill_row(139, 149..150, NAVY);
    assert_ne!(other, plain);
    assert_ne!(plain, ChartImage::filled(150, 141, RED).unwrap());
}

#[test]
fn painting_copies_the_touched_tiles_alone() {
    for image in [noise(1000, 1000), patches(1000, 1000, &[RED, NAVY, WHITE])] {
        let mut painted = image.clone();
        assert_eq!(painted.bytes_beside(Some(&image)), 0);
        draw_line(&mut painted, [10, 10], [20, 12], 3, NAVY);
        let one_tile = TILE * TILE * 4;
        let own = painted.bytes_beside(Some(&image));
        assert!(own > 0 && own <= one_tile + 1024, "{own}");
        // Back again: the pixels are those of the image, and then its tiles too.
        for y in 0..30 {
            for x in 0..30 {
                painted.fill_row(y, x..x + 1, image.pixel(x, y));
            }
        }
        assert_eq!(painted, image);
        painted.share_with(&image);
        assert!(painted.is(&image));
    }
}

#[test]
fn a_tile_takes_more_colours_than_it_can_list() {
    let mut image = ChartImage::filled(TILE, TILE, WHITE).unwrap();
    let colour = |k: usize| [(k % 256) as u8, (k / 256) as u8, 77, 255];
    // Twice over: the first 300 colours are gone when the second 300 come.
    for round in 0..2 {
        for k in 0..300 {
            image.fill_row(k / TILE, k % TILE..k % TILE + 1, colour(k + 300 * round));
        }
    }
    for k in 0..TILE * TILE {
        let expected = if k < 300 { colour(k + 300) } else { WHITE };
        assert_eq!(image.pixel(k % TILE, k / TILE), expected, "{k}");
    }
}

#[test]
fn a_hundred_strokes_on_a_large_chart_take_little_memory() {
    let whole = 4096 * 4096 * 4;
    let mut history = vec![noise(4096, 4096)];
    for k in 0..100 {
        let mut image = history.last().unwrap().clone();
        let at = |k: usize| (hash(k as u32) % 4000) as i64;
        let [x, y] = [at(2 * k), at(2 * k + 1)];
        draw_line(&mut image, [x, y], [x + 90, y + 40], 5, RED);
        history.push(image);
    }
    let own: usize = history
        .windows(2)
        .map(|pair| pair[0].bytes_beside(Some(&pair[1])))
        .sum();
    // A stroke of 90 × 40 pixels and 5 more touches four tiles of 64 kB at most.
    assert!(own <= 100 * 4 * (TILE * TILE * 4), "{own}");
    assert!(own < whole / 2, "{own} of {whole}");

    // A chart of yarns: another colour for a yarn is another list of colours, not other pixels.
    let mut history = vec![patches(4096, 4096, &[RED, NAVY, WHITE])];
    for k in 0..100_u8 {
        let last = history.last().unwrap();
        let red = if k == 0 { RED } else { [k, 1, 2, 255] };
        history.push(replace_yarn(last, red, [k + 1, 1, 2, 255]));
    }
    let own: usize = history
        .windows(2)
        .map(|pair| pair[0].bytes_beside(Some(&pair[1])))
        .sum();
    assert!(own < 4 << 20, "{own}");
}

#[test]
fn cropping_and_turning_obey_their_laws() {
    for image in [noise(300, 170), patches(170, 300, &[RED, NAVY, BARE])] {
        let (width, height) = (image.width(), image.height());
        let four = (0..4).fold(image.clone(), |image, _| rotate_right(&image));
        assert_eq!(four, image);
        let right = rotate_right(&image);
        assert_eq!((right.width(), right.height()), (height, width));
        // The top left corner goes to the top right.
        assert_eq!(right.pixel(height - 1, 0), image.pixel(0, 0));
        assert_eq!(rotate_left(&right), image);
        assert_eq!(flip_x(&flip_x(&image)), image);
        assert_eq!(flip_x(&image).pixel(0, 5), image.pixel(width - 1, 5));
        assert_eq!(flip_y(&image).pixel(5, 0), image.pixel(5, height - 1));
        // Half a turn is both mirrors.
        assert_eq!(flip_x(&flip_y(&image)), rotate_right(&right));

        assert_eq!(crop(&image, 0..width, 0..height), Some(image.clone()));
        let part = crop(&image, 20..150, 30..160).unwrap();
        assert_eq!((part.width(), part.height()), (130, 130));
        assert_eq!(part.pixel(0, 0), image.pixel(20, 30));
        // A crop of a crop is a crop.
        assert_eq!(crop(&part, 10..40, 5..130), crop(&image, 30..60, 35..160));
        // Beyond the edge there is nothing.
        let corner = crop(&image, width - 3..width + 50, 0..2).unwrap();
        assert_eq!((corner.width(), corner.height()), (3, 2));
        assert_eq!(crop(&image, width..width + 5, 0..2), None);
    }
}

#[test]
fn resizing_keeps_what_it_can() {
    let image = noise(60, 40);
    for resampling in [Resampling::Nearest, Resampling::Average] {
        assert_eq!(resize(&image, 60, 40, resampling), Some(image.clone()));
        let twice = resize(&image, 120, 80, resampling).unwrap();
        assert_eq!(twice.pixel(119, 79), image.pixel(59, 39));
        assert_eq!(resize(&twice, 60, 40, resampling), Some(image.clone()));
        assert_eq!(resize(&image, 0, 4, resampling), None);
        let plain = ChartImage::filled(37, 53, RED).unwrap();
        assert_eq!(
            resize(&plain, 11, 101, resampling),
            ChartImage::filled(11, 101, RED)
        );
    }
    // Half black, half white is half the light: sRGB 188.
    let halves = ChartImage::new(2, 1, &[[0, 0, 0, 255], WHITE]).unwrap();
    assert_eq!(
        resize(&halves, 1, 1, Resampling::Average)
            .unwrap()
            .pixel(0, 0),
        [188, 188, 188, 255]
    );
    // Three pixels in two: the middle one belongs to both by halves, so a third of each is its light.
    let three = ChartImage::new(3, 1, &[WHITE, [0, 0, 0, 255], WHITE]).unwrap();
    let two = resize(&three, 2, 1, Resampling::Average).unwrap();
    assert_eq!(pixels(&two), [[213, 213, 213, 255]; 2]);
    // What is transparent has no colour to give.
    let half_bare = ChartImage::new(2, 1, &[[0, 255, 0, 0], RED]).unwrap();
    assert_eq!(
        resize(&half_bare, 1, 1, Resampling::Average)
            .unwrap()
            .pixel(0, 0),
        [200, 30, 30, 128]
    );
}

#[test]
fn brushes_lines_and_rectangles_have_the_pixels_they_should() {
    let painted = |draw: &dyn Fn(&mut ChartImage)| -> HashSet<(usize, usize)> {
        let mut image = ChartImage::filled(200, 200, WHITE).unwrap();
        draw(&mut image);
        let all = (0..200).flat_map(|y| (0..200).map(move |x| (x, y)));
        all.filter(|&(x, y)| image.pixel(x, y) == RED).collect()
    };
    let dot = |size| painted(&|image| draw_line(image, [100, 100], [100, 100], size, RED));
    assert_eq!(dot(1), HashSet::from([(100, 100)]));
    assert_eq!(dot(2).len(), 4);
    for size in [3, 8, 21, 64] {
        let dot = dot(size);
        let xs = dot.iter().map(|(x, _)| x);
        assert_eq!(xs.clone().max().unwrap() - xs.min().unwrap() + 1, size);
        // Its area is that of a circle, but for the steps of its edge.
        let circle = std::f64::consts::PI / 4.0 * (size * size) as f64;
        assert!(
            (dot.len() as f64 - circle).abs() <= 2.0 * size as f64,
            "{size}: {}",
            dot.len()
        );
    }
    // No gaps, whatever the slope: every pixel has a neighbour nearer to the start.
    for to in [[190, 120], [60, 3], [100, 190], [0, 100]] {
        let line = painted(&|image| draw_line(image, [100, 100], to, 1, RED));
        let steps = (to[0] - 100_i64).abs().max((to[1] - 100_i64).abs()) as usize;
        assert_eq!(line.len(), steps + 1);
        assert!(line.contains(&(to[0] as usize, to[1] as usize)));
    }
    let outline = painted(&|image| outline_rectangle(image, [[20, 30], [9, 14]], 1, RED));
    assert_eq!(outline.len(), 2 * (11 + 16));
    assert!(outline.contains(&(9, 30)) && !outline.contains(&(10, 29)));
    // What leaves the image is left out, also far away.
    let clipped = painted(&|image| draw_line(image, [-50, 5], [3, 5], 3, RED));
    assert_eq!(clipped.len(), 3 * 5);
}

#[test]
fn oklab_is_the_published_one() {
    // Linear light of the XYZ of Ottosson's table that lie in or near sRGB, from palette, another implementation.
    for colour in [
        [255, 255, 255],
        [255, 0, 0],
        [0, 255, 0],
        [0, 0, 255],
        [12, 200, 97],
        [1, 2, 3],
    ] {
        let expected: Oklab<f64> =
            Oklab::from_color(Srgb::from(colour).into_format::<f64>().into_linear());
        let found = oklab(colour);
        for (found, expected) in found.into_iter().zip([expected.l, expected.a, expected.b]) {
            // f32 with numbers of the order of 1, a few roundings.
            assert!(
                (f64::from(found) - expected).abs() < 2e-6,
                "{colour:?}: {found} {expected}"
            );
        }
        let precise = precise_oklab(colour);
        for (found, expected) in precise
            .into_iter()
            .zip([expected.l, expected.a, expected.b])
        {
            // The published matrices have ten digits.
            assert!(
                (found - expected).abs() < 1e-6,
                "{colour:?}: {found} {expected}"
            );
        }
    }
    // As published: white is 1, red is (0.628, 0.225, 0.126), blue (0.452, -0.032, -0.312).
    for (colour, lab) in [
        ([255, 255, 255], [1.0, 0.0, 0.0]),
        ([255, 0, 0], [0.628, 0.225, 0.126]),
        ([0, 0, 255], [0.452, -0.032, -0.312]),
    ] {
        for (found, published) in oklab(colour).into_iter().zip(lab) {
            assert!((found - published).abs() < 5e-4, "{colour:?}");
        }
    }
    for k in 0..2000 {
        let [r, g, b, _] = hash(k).to_le_bytes();
        assert_eq!(nearest_srgb(linear_from_oklab(oklab([r, g, b]))), [r, g, b]);
    }
    let gray = oklab_from_linear([0.25; 3]);
    assert!((gray[0] - 0.25_f32.cbrt()).abs() < 1e-6 && gray[1].abs() < 1e-6);
}

/// Mean squared distance in Oklab of the pixels of two images.
fn error(a: &ChartImage, b: &ChartImage) -> f64 {
    let pairs = pixels(a).into_iter().zip(pixels(b));
    let sum: f64 = pairs
        .map(|([r, g, b, _], [s, t, u, _])| {
            let (p, q) = (oklab([r, g, b]), oklab([s, t, u]));
            (0..3).map(|c| f64::from(p[c] - q[c]).powi(2)).sum::<f64>()
        })
        .sum();
    sum / (a.width() * a.height()) as f64
}

/// Something like a photo: a sky, a field, a few shapes, some grain.
fn photo(width: usize, height: usize) -> ChartImage {
    ChartImage::from_fn(width, height, |x, y| {
        let (u, v) = (x as f64 / width as f64, y as f64 / height as f64);
        let grain = f64::from(hash((y * width + x) as u32) % 17) - 8.0;
        let colour = if (u - 0.3).hypot(v - 0.4) < 0.15 {
            [210.0, 60.0 + 80.0 * u, 40.0]
        } else if v > 0.6 {
            [60.0 + 60.0 * v, 120.0 - 40.0 * u, 50.0]
        } else {
            [120.0 + 80.0 * v, 160.0 + 60.0 * v, 230.0]
        };
        let [r, g, b] = colour.map(|c| (c + grain).clamp(0.0, 255.0) as u8);
        [r, g, b, 255]
    })
    .unwrap()
}

#[test]
fn well_separated_colours_are_found_exactly() {
    let yarns = [RED, NAVY, WHITE, [240, 200, 30, 255], [10, 120, 60, 255]];
    let flat = patches(500, 400, &yarns);
    let found: HashSet<[u8; 3]> = choose_yarns(&flat, 5).into_iter().collect();
    let expected: HashSet<[u8; 3]> = yarns.iter().map(|&[r, g, b, _]| [r, g, b]).collect();
    assert_eq!(found, expected);
    assert_eq!(
        reduce_to(&flat, &choose_yarns(&flat, 5), Dither::None),
        flat
    );
    // More than there are are not made up.
    assert_eq!(choose_yarns(&flat, 64).len(), 5);

    // With the smooth edges of a drawn logo: seven in a hundred pixels are mixtures.
    let large = ChartImage::from_fn(1500, 1200, |x, y| flat.pixel(x / 3, y / 3)).unwrap();
    let smooth = resize(&large, 700, 560, Resampling::Average).unwrap();
    assert!(
        YarnCounts::default().of(&smooth, &alike()).is_none(),
        "no smooth edges"
    );
    let found: HashSet<[u8; 3]> = choose_yarns(&smooth, 5).into_iter().collect();
    assert_eq!(found, expected);

    // Grain around each: the centres are means, a value or two away.
    let grainy = ChartImage::from_fn(500, 400, |x, y| {
        let grain = hash((y * 500 + x) as u32).to_le_bytes();
        let [r, g, b, _] = flat.pixel(x, y);
        let mut k = 0;
        let [r, g, b] = [r, g, b].map(|value| {
            k += 1;
            (i16::from(value) + i16::from(grain[k] % 13) - 6).clamp(0, 255) as u8
        });
        [r, g, b, 255]
    })
    .unwrap();
    for [r, g, b] in choose_yarns(&grainy, 5) {
        let near = |yarn: &&[u8; 3]| {
            let pairs = yarn.iter().zip([r, g, b]);
            pairs.into_iter().all(|(a, b)| a.abs_diff(b) <= 4)
        };
        assert!(expected.iter().any(|yarn| near(&yarn)), "{r} {g} {b}");
    }
}

#[test]
fn chosen_yarns_are_better_than_naive_ones_and_always_the_same() {
    let photo = photo(640, 480);
    let mut last = f64::INFINITY;
    for count in [2, 5, 8, 16, 40] {
        let yarns = choose_yarns(&photo, count);
        assert_eq!(yarns.len(), count);
        let reduced = reduce_to(&photo, &yarns, Dither::None);
        let own = error(&photo, &reduced);
        assert!(own < last, "{count}: {own} after {last}");
        last = own;
        // The commonest colours; and those of an even selection of pixels.
        let mut counts: HashMap<[u8; 3], usize> = HashMap::new();
        for [r, g, b, _] in pixels(&photo) {
            *counts.entry([r, g, b]).or_default() += 1;
        }
        let mut common: Vec<_> = counts.into_iter().collect();
        common.sort_by_key(|&(colour, count)| (std::cmp::Reverse(count), colour));
        let common: Vec<[u8; 3]> = common.into_iter().take(count).map(|(c, _)| c).collect();
        let even: Vec<[u8; 3]> = (0..count)
            .map(|k| photo.pixel((k * 97) % 640, k * 480 / count))
            .map(|[r, g, b, _]| [r, g, b])
            .collect();
        for naive in [common, even] {
            let theirs = error(&photo, &reduce_to(&photo, &naive, Dither::None));
            assert!(own <= theirs, "{count}: {own} against {theirs}");
        }
        assert_eq!(choose_yarns(&photo, count), yarns);
    }
    // With one processor too.
    let alone = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build()
        .unwrap();
    assert_eq!(
        alone.install(|| choose_yarns(&photo, 16)),
        choose_yarns(&photo, 16)
    );
}

#[test]
fn every_pixel_takes_the_nearest_yarn_and_bare_ones_stay_bare() {
    let mut image = noise(200, 150);
    image.fill_rectangle(10..30, 10..30, [9, 9, 9, 100]);
    let yarns = [[200, 30, 30], [20, 30, 90], [250, 250, 250], [0, 120, 60]];
    let reduced = reduce_to(&image, &yarns, Dither::None);
    for (was, is) in pixels(&image).into_iter().zip(pixels(&reduced)) {
        let [r, g, b, alpha] = was;
        if alpha < 128 {
            assert_eq!(is, BARE);
            continue;
        }
        let distance = |yarn: &[u8; 3]| {
            let (p, q) = (oklab([r, g, b]), oklab(*yarn));
            (0..3).map(|c| (p[c] - q[c]).powi(2)).sum::<f32>()
        };
        let nearest = yarns
            .iter()
            .min_by(|a, b| distance(a).total_cmp(&distance(b)));
        assert_eq!(is[..3], nearest.unwrap()[..]);
    }
    assert_eq!(reduce_to(&image, &[], Dither::None), image);
    let bare = ChartImage::filled(9, 9, BARE).unwrap();
    assert_eq!(choose_yarns(&bare, 5), Vec::<[u8; 3]>::new());
}

#[test]
fn dithering_gives_the_light_that_no_yarn_has() {
    // A ramp of grays in black and white, and a brown between red and green.
    let yarns = [[0, 0, 0], [255, 255, 255], [200, 30, 30], [10, 120, 60]];
    let light = |image: &ChartImage, xs: std::ops::Range<usize>| -> [f64; 3] {
        let mut sum = [0.0; 3];
        for y in 0..64 {
            for x in xs.clone() {
                let [r, g, b, _] = image.pixel(x, y);
                let linear = renderer_core::design::Colour([r, g, b]).linear();
                for c in 0..3 {
                    sum[c] += linear[c] / (64.0 * xs.len() as f64);
                }
            }
        }
        sum
    };
    let ramp = ChartImage::from_fn(512, 64, |x, _| {
        let value = (x / 64 * 32) as u8 + 16;
        [value, value, value, 255]
    })
    .unwrap();
    for dither in [Dither::Ordered, Dither::Diffusion] {
        let dithered = reduce_to(&ramp, &yarns[..2], dither);
        for k in 0..8 {
            let (is, was) = (
                light(&dithered, k * 64..k * 64 + 64),
                light(&ramp, k * 64..k * 64 + 64),
            );
            // Ordered: the pattern has 64 steps. Diffusion: errors that crossed the patch's edges, one pixel in 64.
            assert!(
                (is[0] - was[0]).abs() < 1.0 / 64.0 + 0.005,
                "{dither:?} {k}: {is:?} {was:?}"
            );
        }
        let plain = reduce_to(&ramp, &yarns[..2], Dither::None);
        assert_ne!(dithered, plain);
        // What is a yarn's own colour stays as it is.
        let own = patches(100, 100, &[RED, [10, 120, 60, 255]]);
        assert_eq!(reduce_to(&own, &yarns, dither), own);
    }
}

/// A loop on every pixel.
fn alike() -> Arc<LoopsPerPixel> {
    Arc::new(LoopsPerPixel::Alike)
}

#[test]
fn yarns_are_counted_and_counted_again_after_painting() {
    let mut counts = YarnCounts::default();
    let mut image = ChartImage::filled(300, 200, RED).unwrap();
    let shares = |counts: &mut YarnCounts, image: &ChartImage| -> Vec<([u8; 4], u64)> {
        let yarns = counts.of(image, &alike()).expect("few yarns").iter();
        yarns.map(|yarn| (yarn.colour, yarn.pixels)).collect()
    };
    assert_eq!(shares(&mut counts, &image), [(RED, 60_000)]);
    image.fill_rectangle(250..290, 150..160, NAVY);
    image.fill_rectangle(0..10, 0..10, [1, 2, 3, 20]);
    assert_eq!(
        shares(&mut counts, &image),
        [(RED, 59_500), (NAVY, 400), (BARE, 100)]
    );
    let merged = replace_yarn(&image, NAVY, RED);
    assert_eq!(shares(&mut counts, &merged), [(RED, 59_900), (BARE, 100)]);
    assert_eq!(shares(&mut counts, &image).len(), 3);
    assert!(counts.of(&noise(300, 200), &alike()).is_none());
    assert_eq!(shares(&mut counts, &image).len(), 3);
    let cropped = crop(&image, 0..20, 0..20).unwrap();
    assert_eq!(shares(&mut counts, &cropped), [(RED, 300), (BARE, 100)]);
}

#[test]
fn a_chart_comes_back_from_its_png() {
    let many: Vec<[u8; 4]> = (0..300)
        .map(|k| [k as u8, (k / 256) as u8, 5, 255])
        .collect();
    let mut half_bare = noise(257, 130);
    half_bare.fill_rectangle(0..200, 0..9, [1, 2, 3, 77]);
    for (image, colours) in [
        (ChartImage::filled(3, 2, RED).unwrap(), 1),
        (patches(301, 140, &[RED, NAVY]), 2),
        (patches(301, 140, &[RED, NAVY, BARE]), 3),
        (patches(301, 140, &many[..16]), 16),
        (patches(301, 140, &many[..17]), 17),
        (patches(301, 140, &many[..256]), 256),
        (patches(301, 140, &many), 300),
        (noise(300, 129), 1000),
        (half_bare, 1000),
    ] {
        let png = encode_chart_png(&image, &[("Title", "Häkeln"), ("Software", "here")]).unwrap();
        let decoded = image::load_from_memory(&png).unwrap().into_rgba8();
        assert_eq!(
            (decoded.width() as usize, decoded.height() as usize),
            (image.width(), image.height())
        );
        assert!(
            decoded.pixels().map(|p| p.0).eq(pixels(&image)),
            "{colours} colours"
        );
        let text = |keyword| png_text(std::io::Cursor::new(&png), keyword);
        assert_eq!(text("Title").as_deref(), Some("Häkeln"));
        assert_eq!(text("Author"), None);
    }
}
