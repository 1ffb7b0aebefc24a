//! The turbulence field (MODEL.md §3).

use noise::core::{perlin::perlin_2d, simplex::simplex_2d, worley};
use noise::permutationtable::PermutationTable;
use renderer_core::design::{Filter, NoiseKind, Turbulence};
use renderer_core::sampling::{hash_with, unit_float};
use renderer_core::scene::{SheetGeometry, TurbulenceField};

fn sheet(cells: u32, pitch_mm: f64) -> SheetGeometry {
    SheetGeometry {
        warps: cells,
        wefts: cells,
        pitch_x_mm: pitch_mm,
        pitch_y_mm: pitch_mm,
        region: None,
    }
}

fn turbulence(kind: NoiseKind) -> Turbulence {
    Turbulence {
        kind,
        ..Turbulence::default()
    }
}

/// The field itself, and after each filter.
fn filtered(turbulence: &Turbulence) -> [Turbulence; 5] {
    let with = |filter, filter_radius| Turbulence {
        filter,
        filter_radius,
        ..turbulence.clone()
    };
    [
        turbulence.clone(),
        with(Filter::Box, 1.0),
        with(Filter::Box, 4.5),
        with(Filter::Gaussian, 2.0),
        with(Filter::Gaussian, 12.0),
    ]
}

/// Largest difference of a channel between neighbours.
fn largest_step(field: &TurbulenceField) -> f64 {
    let warps = field.warps();
    let step = |a: [f32; 4], b: [f32; 4]| {
        let differences = a.iter().zip(b).map(|(a, b)| f64::from((a - b).abs()));
        differences.fold(0.0, f64::max)
    };
    let mut largest = 0.0_f64;
    for (k, &value) in field.values().iter().enumerate() {
        if k % warps > 0 {
            largest = largest.max(step(value, field.values()[k - 1]));
        }
        if k >= warps {
            largest = largest.max(step(value, field.values()[k - warps]));
        }
    }
    largest
}

/// T_c of MODEL.md §3 straight from the crate, for a cell of a sheet with square cells.
fn by_the_crate(turbulence: &Turbulence, channel: u32, cell: [usize; 2], pitch_mm: f64) -> f64 {
    let seed = hash_with(turbulence.seed, channel);
    let table = PermutationTable::new(seed);
    let octave = |frequency: f64| {
        let point = [0, 1].map(|axis| {
            let offset = 0.1 + 0.8 * f64::from(unit_float(hash_with(seed, 1 + axis as u32)));
            frequency * ((cell[axis] as f64 + 0.5) * pitch_mm) + offset
        });
        let value = match turbulence.kind {
            NoiseKind::Fbm => perlin_2d(point.into(), &table),
            NoiseKind::Turbulence => 2.0 * perlin_2d(point.into(), &table).abs() - 1.0 + 0.315,
            NoiseKind::Simplex => simplex_2d(point.into(), &table).0,
            NoiseKind::Worley => worley::worley_2d(
                &table,
                worley::distance_functions::euclidean,
                worley::ReturnType::Distance,
                point.into(),
            ),
        };
        value.clamp(-1.0, 1.0)
    };
    let (mut sum, mut amplitudes) = (0.0, 0.0);
    let (mut frequency, mut amplitude) = (turbulence.frequency, 1.0);
    for _ in 0..turbulence.octaves {
        sum += amplitude * octave(frequency);
        amplitudes += amplitude;
        frequency *= turbulence.lacunarity;
        amplitude *= turbulence.gain;
    }
    (sum / amplitudes).clamp(-1.0, 1.0)
}

#[test]
fn the_field_is_the_crates_noise_to_the_bit() {
    for kind in [
        NoiseKind::Fbm,
        NoiseKind::Turbulence,
        NoiseKind::Simplex,
        NoiseKind::Worley,
    ] {
        // From many cells in a cell of the lattice to many of its cells between neighbours, past the 256 that repeat.
        for (frequency, octaves, pitch) in [(0.01, 3, 0.5), (0.31, 2, 0.75), (1.7, 2, 2.9)] {
            let turbulence = Turbulence {
                frequency,
                octaves,
                seed: 7,
                ..turbulence(kind)
            };
            let field = TurbulenceField::new(&sheet(120, pitch), &turbulence);
            for (j, i) in (0..120)
                .step_by(7)
                .flat_map(|j| (0..120).map(move |i| (j, i)))
            {
                for (c, value) in field.at(i, j).into_iter().enumerate() {
                    let wanted = by_the_crate(&turbulence, c as u32, [i, j], pitch) as f32;
                    assert_eq!(
                        value.to_bits(),
                        wanted.to_bits(),
                        "{kind:?}, {frequency}/mm, channel {c} of cell ({i}, {j})"
                    );
                }
            }
        }
    }
}

#[test]
fn neighbours_differ_little_before_and_after_filters() {
    // Largest slope of one octave: 3.9 for the crate's Perlin noise (MODEL.md §3), twice that when folded; for its
    // simplex noise 4.11, the maximum over a triangle of the slopes of its three surflets, each with its worst
    // gradient. Worley noise jumps at cell borders and is exempt.
    for (kind, slope) in [
        (NoiseKind::Fbm, 3.9),
        (NoiseKind::Turbulence, 7.8),
        (NoiseKind::Simplex, 4.11),
    ] {
        for (frequency, octaves, lacunarity, gain) in
            [(0.05, 1, 2.0, 0.5), (0.2, 3, 2.0, 0.5), (0.1, 4, 1.7, 0.8)]
        {
            let base = Turbulence {
                frequency,
                octaves,
                lacunarity,
                gain,
                ..turbulence(kind)
            };
            let pitch = 0.7;
            let sum = |ratio: f64| (0..octaves as i32).map(|k| ratio.powi(k)).sum::<f64>();
            let bound = slope * frequency * pitch * sum(gain * lacunarity) / sum(gain);
            for turbulence in filtered(&base) {
                let field = TurbulenceField::new(&sheet(150, pitch), &turbulence);
                let step = largest_step(&field);
                assert!(
                    step <= bound,
                    "{turbulence:?}: a step of {step}, allowed {bound}"
                );
                assert!(step > 0.02 * bound, "{turbulence:?} hardly varies: {step}");
            }
        }
    }
}

#[test]
fn filters_smooth_but_keep_the_deviation() {
    for kind in NoiseKind::ALL {
        let base = Turbulence {
            // Waves longer than the widest filter, which would leave nothing but edges of shorter ones.
            frequency: 0.08,
            ..turbulence(*kind)
        };
        let sheet = sheet(200, 0.7);
        let [plain, smoothed @ ..] =
            filtered(&base).map(|turbulence| TurbulenceField::new(&sheet, &turbulence));
        // Bends along the first channel's rows.
        let roughness = |field: &TurbulenceField| {
            let rows = field.values().chunks(200);
            let bends = rows.flat_map(|row| row.windows(3));
            bends
                .map(|cells| f64::from(cells[0][0] - 2.0 * cells[1][0] + cells[2][0]).powi(2))
                .sum::<f64>()
        };
        for field in &smoothed {
            assert!(roughness(field) < 0.9 * roughness(&plain), "{kind:?}");
            let pairs = plain
                .mean_and_deviation()
                .into_iter()
                .zip(field.mean_and_deviation());
            for ([mean, deviation], [new_mean, new_deviation]) in pairs {
                // The clamp at ±1 cuts what a filter made Gaussian: at most 3 % for the widest field here (Worley
                // noise, deviation 0.5). The mean moves by what edges weigh more than the middle: a radius in 200
                // cells.
                assert!(
                    (new_deviation / deviation - 1.0).abs() < 0.04,
                    "{kind:?}: {new_deviation} for {deviation}"
                );
                assert!(
                    (new_mean - mean).abs() < 0.05,
                    "{kind:?}: {new_mean} for {mean}"
                );
            }
        }
    }
}

#[test]
fn filter_weights_are_those_asked_for() {
    // On a sheet of one row, a box of radius 1 is the mean of three cells, edges continued; rescaling is linear, so the
    // filtered channel and the mean of three differ by a stretch about the mean.
    let plain = turbulence(NoiseKind::Fbm);
    let boxed = Turbulence {
        filter: Filter::Box,
        filter_radius: 1.0,
        ..plain.clone()
    };
    let row = SheetGeometry {
        wefts: 1,
        ..sheet(60, 0.7)
    };
    let (plain, boxed) = (
        TurbulenceField::new(&row, &plain),
        TurbulenceField::new(&row, &boxed),
    );
    let x = |i: usize| f64::from(plain.at(i, 0)[0]);
    let mean_of_three: Vec<f64> = (0..60)
        .map(|i: usize| (x(i.saturating_sub(1)) + x(i) + x((i + 1).min(59))) / 3.0)
        .collect();
    let mean = mean_of_three.iter().sum::<f64>() / 60.0;
    let deviation = (mean_of_three
        .iter()
        .map(|m| (m - mean).powi(2))
        .sum::<f64>()
        / 60.0)
        .sqrt();
    let stretch = plain.mean_and_deviation()[0][1] / deviation;
    for (i, m) in mean_of_three.iter().enumerate() {
        let expected = mean + stretch * (m - mean);
        // f32 rounding of values up to 1.
        assert!(
            (f64::from(boxed.at(i, 0)[0]) - expected).abs() < 1e-5,
            "{i}"
        );
    }
}

#[test]
fn channels_and_seeds_are_unrelated() {
    let sheet = sheet(300, 0.7);
    let first = TurbulenceField::new(&sheet, &turbulence(NoiseKind::Fbm));
    let second = TurbulenceField::new(
        &sheet,
        &Turbulence {
            seed: 2,
            ..turbulence(NoiseKind::Fbm)
        },
    );
    let channel = |field: &TurbulenceField, c: usize| -> Vec<f64> {
        field.values().iter().map(|v| f64::from(v[c])).collect()
    };
    let correlation = |a: &[f64], b: &[f64]| {
        let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        product(a, b) / (product(a, a) * product(b, b)).sqrt()
    };
    let mut channels: Vec<Vec<f64>> = (0..4).map(|c| channel(&first, c)).collect();
    channels.extend((0..4).map(|c| channel(&second, c)));
    for a in 0..8 {
        for b in 0..a {
            let correlation = correlation(&channels[a], &channels[b]);
            // The sheet is 210 mm = 52 lattice cells wide: some 2700 independent values, so a standard error of 0.02.
            assert!(correlation.abs() < 0.1, "{a}, {b}: {correlation}");
        }
    }
}

#[test]
fn no_kind_has_a_hidden_lean_or_leaves_its_range() {
    for &kind in NoiseKind::ALL {
        let field = TurbulenceField::new(&sheet(300, 0.7), &turbulence(kind));
        let inside = |value: &[f32; 4]| value.iter().all(|c| (-1.0..=1.0).contains(c));
        assert!(field.values().iter().all(inside), "{kind:?}");
        if kind != NoiseKind::Worley {
            for [mean, deviation] in field.mean_and_deviation() {
                // Deviations are 0.25 to 0.4; some 2700 independent values give a standard error below 0.01.
                assert!(mean.abs() < 0.04, "{kind:?} has the mean {mean}");
                assert!(deviation > 0.15, "{kind:?} has the deviation {deviation}");
            }
        }
    }
}

#[test]
fn values_are_not_all_zero_where_cells_meet_the_lattice() {
    // (i + ½)·pitch·frequency is an integer for all cells: Perlin noise without an offset would be zero everywhere.
    let on_lattice = Turbulence {
        frequency: 2.0 / 0.5,
        octaves: 1,
        ..turbulence(NoiseKind::Fbm)
    };
    let field = TurbulenceField::new(&sheet(20, 0.5), &on_lattice);
    for [_, deviation] in field.mean_and_deviation() {
        assert!(deviation > 0.01, "{deviation}");
    }
}

#[test]
fn a_filter_wider_than_a_sheet_leaves_finite_values() {
    for cells in [1, 2, 5] {
        for filter in [Filter::Box, Filter::Gaussian] {
            let wide = Turbulence {
                filter,
                filter_radius: 64.0,
                ..Turbulence::default()
            };
            let field = TurbulenceField::new(&sheet(cells, 0.7), &wide);
            let sound = |value: &[f32; 4]| value.iter().all(|c| c.abs() <= 1.0);
            assert!(field.values().iter().all(sound));
        }
    }
}
