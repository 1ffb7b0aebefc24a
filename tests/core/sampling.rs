//! The random numbers: Sobol points, their scrambles, sets, and directions made from them.

use std::f64::consts::PI;

use glam::DVec3;
use renderer_core::sampling::Sampler;
use renderer_core::sampling::{
    Pcg, RUN, SCRAMBLES, Set, directions, hash, owen_bits, pixel_seed, sample, samples_of,
    scramble_of, sobol, unit_float,
};

/// Sobol's direction numbers from Joe and Kuo's table, by the recurrence of their paper.
fn direction_numbers(degree: usize, polynomial: u32, initial: &[u32]) -> [u32; 32] {
    let mut m = initial.to_vec();
    for k in degree..32 {
        let mut next = m[k - degree] ^ (m[k - degree] << degree);
        for i in 1..degree {
            if polynomial >> (degree - 1 - i) & 1 == 1 {
                next ^= m[k - i] << i;
            }
        }
        m.push(next);
    }
    std::array::from_fn(|k| m[k] << (31 - k))
}

#[test]
fn sobol_points_are_joe_and_kuos() {
    // The first eight points in plain binary order, in eighths.
    let eighths: Vec<_> = (0..8).map(|index| sobol(index).map(|x| x >> 29)).collect();
    let known = [
        [0, 0, 0, 0],
        [4, 4, 4, 4],
        [2, 6, 6, 6],
        [6, 2, 2, 2],
        [1, 5, 3, 1],
        [5, 1, 7, 5],
        [3, 3, 5, 7],
        [7, 7, 1, 3],
    ];
    assert_eq!(eighths, known);

    let dimensions: [[u32; 32]; 4] = [
        std::array::from_fn(|k| 1 << (31 - k)),
        direction_numbers(1, 0, &[1]),
        direction_numbers(2, 1, &[1, 3]),
        direction_numbers(3, 1, &[1, 3, 1]),
    ];
    for index in [8, 9, 1_000, 65_535, 1 << 20, 0x1234_5678, u32::MAX] {
        let expected = dimensions.map(|numbers| {
            (0..32)
                .filter(|bit| index >> bit & 1 == 1)
                .fold(0, |sum, bit| sum ^ numbers[bit])
        });
        assert_eq!(sobol(index), expected, "point {index}");
    }
}

/// Points first..first + count of one scramble.
fn scramble_points(seed: u32, scramble: u32, set: Set, first: u32, count: u32) -> Vec<[u32; 4]> {
    (first..first + count)
        .map(|point| owen_bits(seed, sample_number(scramble, point), set))
        .collect()
}

/// Which sample point `point` of a scramble is.
fn sample_number(scramble: u32, point: u32) -> u32 {
    point / RUN * (RUN * SCRAMBLES) + scramble * RUN + point % RUN
}

#[test]
fn scrambles_take_turns_by_runs() {
    for point in 0..5 * RUN {
        for scramble in 0..SCRAMBLES {
            assert_eq!(scramble_of(sample_number(scramble, point)), scramble);
        }
    }
    let mut counts = [0; SCRAMBLES as usize];
    for samples in 0..200 {
        for (scramble, count) in (0..).zip(counts) {
            assert_eq!(samples_of(scramble, samples), count);
        }
        counts[scramble_of(samples) as usize] += 1;
    }
}

#[test]
fn blocks_of_every_scramble_are_stratified() {
    // How many bits of a pair are not stratified (its t value): degree − 1 of the polynomials, for the dimensions 2 and
    // 3.
    let quality = |a: usize, b: usize| [0, 0, 1, 2][a] + [0, 0, 1, 2][b];
    let sets = [
        Set::Film,
        Set::Sun { bounce: 3, sun: 2 },
        Set::Onward { bounce: 64 },
    ];
    for (set, seed) in sets.into_iter().zip([1, 77, 0xdead_beef]) {
        for scramble in 0..SCRAMBLES {
            for bits in 0..=8_u32 {
                let count = 1 << bits;
                let points = scramble_points(seed, scramble, set, 5 * count, count);
                for dimension in 0..4 {
                    let mut strata: Vec<_> = points
                        .iter()
                        .map(|p| u64::from(p[dimension]) >> (32 - bits))
                        .collect();
                    strata.sort_unstable();
                    assert!(strata.iter().copied().eq(0..u64::from(count)));
                }
                for (a, b) in [(0, 1), (0, 2), (1, 2), (0, 3), (1, 3), (2, 3)] {
                    let t = quality(a, b);
                    let Some(split) = bits.checked_sub(t) else {
                        continue;
                    };
                    for bits_of_a in 0..=split {
                        let bits_of_b = split - bits_of_a;
                        let mut boxes = vec![0; 1 << split];
                        for p in &points {
                            let index = (u64::from(p[a]) >> (32 - bits_of_a) << bits_of_b)
                                + (u64::from(p[b]) >> (32 - bits_of_b));
                            boxes[index as usize] += 1;
                        }
                        assert!(
                            boxes.iter().all(|&inside| inside == 1 << t),
                            "{set:?} {scramble}: dimensions {a}, {b} in 2^{bits_of_a} by 2^{bits_of_b}: {boxes:?}"
                        );
                    }
                }
            }
        }
    }
}

/// A checkerboard of 16 × 16 squares on dyadic borders: mean ½.
fn checker([x, y]: [f32; 2]) -> f64 {
    f64::from(((x * 16.0) as u32 + (y * 16.0) as u32) & 1)
}

/// Root mean square error of the mean of `count` numbers, over 2000 pixels.
fn rms_error(count: u32, mean: impl Fn(u32, u32) -> f64) -> f64 {
    let pixels = 2_000;
    let sum: f64 = (0..pixels)
        .map(|pixel| (mean(pixel_seed(3, [pixel, 9]), count) - 0.5).powi(2))
        .sum();
    (sum / f64::from(pixels)).sqrt()
}

#[test]
fn owen_points_are_never_much_worse_than_random_on_dyadic_squares() {
    let owen = |seed, count| {
        let value = |k| {
            let [x, y, ..] = sample(Sampler::Owen, seed, sample_number(0, k), Set::Film);
            checker([x, y])
        };
        (0..count).map(value).sum::<f64>() / f64::from(count)
    };
    let xor = |seed, count| {
        let flip = [hash(seed), hash(seed ^ 1)];
        let value = |k| {
            let [x, y, ..] = sobol(k);
            checker([x ^ flip[0], y ^ flip[1]].map(unit_float))
        };
        (0..count).map(value).sum::<f64>() / f64::from(count)
    };
    let random = |seed, count| {
        let mut pcg = Pcg::new(seed, 5);
        let mut value = || checker([pcg.next_float(), pcg.next_float()]);
        (0..count).map(|_| value()).sum::<f64>() / f64::from(count)
    };
    let mut worst_xor: f64 = 0.0;
    for count in [4, 16, 32, 64, 128] {
        let (owen, random) = (rms_error(count, owen), rms_error(count, random));
        // Owen's bound for a (0, m, 2)-net in base 2: twice the variance of random points. 2000 pixels know an rms to
        // 1.6 %; 7 % is three deviations of the quotient of two.
        assert!(
            owen < 2.0_f64.sqrt() * 1.07 * random,
            "{count} points: {owen} against {random}"
        );
        worst_xor = worst_xor.max(rms_error(count, xor) / random);
    }
    // What the scramble saves us from.
    assert!(worst_xor > 2.0, "{worst_xor}");
    // From 256 points on every square has its share, whatever the scramble.
    for count in [256, 512, 1024] {
        assert_eq!(rms_error(count, owen), 0.0);
    }
    assert!(rms_error(256, random) > 0.02);
}

/// Samples of each pixel in [`columns_of`].
const SAMPLES: usize = 16;

/// Each dimension of each set less ½, for 4096 pixels with [`SAMPLES`] samples each.
fn columns_of(sampler: Sampler, sets: &[Set]) -> Vec<Vec<f64>> {
    let mut columns: Vec<Vec<f64>> = vec![Vec::new(); 4 * sets.len()];
    for pixel in 0..4096 {
        let seed = pixel_seed(11, [pixel % 64, pixel / 64]);
        for number in 0..SAMPLES as u32 {
            for (set_index, &set) in sets.iter().enumerate() {
                let numbers = sample(sampler, seed, number, set);
                for (dimension, x) in numbers.into_iter().enumerate() {
                    columns[4 * set_index + dimension].push(f64::from(x) - 0.5);
                }
            }
        }
    }
    columns
}

/// The correlation of independent uniform numbers has a deviation of 1/√count; five of them for some hundred pairs.
fn assert_uncorrelated(a: &[f64], b: &[f64], what: &str) {
    let (product, count) = (a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>(), a.len());
    let correlation = 12.0 * product / count as f64;
    let most = 5.0 / (count as f64).sqrt();
    assert!(correlation.abs() < most, "{what}: {correlation}");
}

#[test]
fn random_numbers_are_independent_in_every_way() {
    let sets = [
        Set::Film,
        Set::Sun { bounce: 1, sun: 0 },
        Set::Onward { bounce: 2 },
    ];
    let columns = columns_of(Sampler::Random, &sets);
    for a in 0..columns.len() {
        for b in 0..a {
            assert_uncorrelated(&columns[a], &columns[b], &format!("{a} and {b}"));
        }
        // The next sample, the one that Owen points stratify it with (four on), and the next pixel.
        for lag in [1, 4, SAMPLES] {
            let later = &columns[a][lag..];
            assert_uncorrelated(
                &columns[a][..later.len()],
                later,
                &format!("{a}, lag {lag}"),
            );
        }
        // Uniform: each of 64 bins holds its share, within five deviations of a binomial count.
        let mut bins = [0.0; 64];
        for x in &columns[a] {
            bins[((x + 0.5) * 64.0) as usize] += 1.0;
        }
        let share = columns[a].len() as f64 / 64.0;
        for count in bins {
            assert!((count - share).abs() < 5.0 * share.sqrt(), "{a}: {bins:?}");
        }
    }
    // Not stratified: of 16 numbers in 16 strata some stratum stays empty, but for 16!/16¹⁶ = 1e-6 of the pixels.
    let full = columns[0].chunks(SAMPLES).filter(|numbers| {
        let mut strata: Vec<_> = numbers.iter().map(|x| ((x + 0.5) * 16.0) as u32).collect();
        strata.sort_unstable();
        strata.dedup();
        strata.len() == SAMPLES
    });
    assert!(full.count() <= 1);
}

#[test]
fn sets_pixels_and_scrambles_are_independent() {
    let sets = [
        Set::Film,
        Set::Sun { bounce: 1, sun: 0 },
        Set::Sun { bounce: 1, sun: 1 },
        Set::Area { bounce: 1, area: 0 },
        Set::Environment { bounce: 1 },
        Set::Onward { bounce: 1 },
        Set::Sun { bounce: 2, sun: 0 },
    ];
    // All purposes have different numbers.
    let mut numbers: Vec<_> = (1..=64)
        .flat_map(|bounce| {
            (0..8)
                .map(move |sun| Set::Sun { bounce, sun })
                .chain((0..4).map(move |area| Set::Area { bounce, area }))
                .chain([Set::Environment { bounce }, Set::Onward { bounce }])
        })
        .chain([Set::Film])
        .map(Set::number)
        .collect();
    numbers.sort_unstable();
    let all = numbers.len();
    numbers.dedup();
    assert_eq!(numbers.len(), all);

    // Any two dimensions of different sets: each is stratified in a pixel, but they are paired at random.
    let columns = columns_of(Sampler::Owen, &sets);
    for a in 0..columns.len() {
        for b in (0..a).filter(|b| a / 4 != b / 4) {
            assert_uncorrelated(&columns[a], &columns[b], &format!("{a} and {b}"));
        }
    }
    // Neighbouring pixels, the four scrambles of one, and another seed all differ.
    let first = |seed: u32, pixel, number| owen_bits(pixel_seed(seed, pixel), number, Set::Film);
    let mut starts = vec![
        first(1, [0, 0], 0),
        first(1, [1, 0], 0),
        first(1, [0, 1], 0),
    ];
    starts.extend([
        first(2, [0, 0], 0),
        first(1, [0, 0], RUN),
        first(1, [0, 0], 2 * RUN),
    ]);
    starts.extend([
        first(1, [0, 0], 3 * RUN),
        first(1, [5, 7], 0),
        first(1, [7, 5], 0),
    ]);
    for a in 0..starts.len() {
        for b in 0..a {
            assert_ne!(starts[a], starts[b]);
        }
    }
}

#[test]
fn floats_are_exact_and_below_one() {
    assert_eq!(unit_float(u32::MAX), 1.0 - 1.0 / 16_777_216.0);
    assert_eq!(unit_float(0xff), 0.0);
    assert_eq!(unit_float(0x8000_0000), 0.5);
    assert_ne!(hash(1), hash(2));
}

/// Mean of `f` over 4096 stratified pairs of numbers.
fn mean_over_square(f: impl Fn(f64, f64) -> DVec3) -> DVec3 {
    let side = 64;
    let mut sum = DVec3::ZERO;
    for i in 0..side {
        for j in 0..side {
            let at = |k: i32| (f64::from(k) + 0.5) / f64::from(side);
            sum += f(at(i), at(j));
        }
    }
    sum / f64::from(side * side)
}

#[test]
fn directions_have_their_densities() {
    let axis = DVec3::new(0.3, -0.5, -0.8).normalize();
    // Midpoint sums over 64² strata are good to 10⁻³ for these integrands; sharper where they are linear in u.
    assert!(mean_over_square(directions::sphere).length() < 1e-12);
    let squares = mean_over_square(|u, v| directions::sphere(u, v).powf(2.0));
    assert!((squares - DVec3::splat(1.0 / 3.0)).length() < 1e-3);

    // ∫ cos·cos/π = 2/3, and nothing below the surface.
    let mean = mean_over_square(|u, v| directions::cosine_hemisphere(axis, u, v));
    assert!((mean - axis * (2.0 / 3.0)).length() < 1e-3, "{mean}");

    for angle in [1e-4, 0.1, 1.0] {
        let cone = |u, v| directions::cone(axis, angle, u, v);
        let mean = mean_over_square(cone);
        assert!((mean - axis * (0.5 * (1.0 + angle.cos()))).length() < 1e-9);
        // The rim is reached, at every azimuth, and not passed.
        for k in 0..16 {
            let direction = cone(1.0 - 1e-12, f64::from(k) / 16.0);
            assert!((direction.cross(axis).length() - angle.sin()).abs() < 1e-9 * angle);
            assert!((direction.length() - 1.0).abs() < 1e-14);
        }
    }
    assert!((directions::sphere(0.5, 0.25) - DVec3::Y).length() < 1e-15);
    assert!((directions::cone(DVec3::Z, PI / 2.0, 1.0, 0.0) - DVec3::X).length() < 1e-15);
}
