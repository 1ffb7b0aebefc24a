//! Tiles that end before the picture, since their error is small enough. What may end when is worked out here once
//! more, by MODEL.md §10 and from pictures that are drawn to the end: of 8, 16, 24 … samples, so that each run of 8 is
//! known by itself.

use std::collections::BTreeSet;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use renderer_core::design::Metering;
use renderer_core::image::Picture;
use renderer_core::render::{
    Backend, Counters, Optimisation, Progress, RenderRequest, background_tiles,
};

use super::{TILE, all_numbers, backends, draw, numbers, without};
use crate::support::scenes::{request, small_towel};

/// Samples that one scramble has before the next has its turn.
const RUN: u32 = 8;
const SCRAMBLES: usize = 4;
/// The device's estimates are sums of hundreds of numbers in f32, those here differences of f32 means: four digits.
const ROUNDING: f64 = 1e-3;

/// Six tiles that end at three numbers of samples.
const FEW_TILES: [u32; 2] = [40, 24];

/// A towel with its edges: tiles of pile, which are noisy, of bare ground, and of hardly any cloth.
fn uneven_towel(size: [u32; 2]) -> RenderRequest {
    let mut design = small_towel();
    design.view.cameras[0].distance = 34.0;
    // The error to reach is a share of a picture whose background is as bright as it was chosen for.
    design.view.metering = Metering::None;
    let mut request = request(&design, size);
    request.settings.samples = 1 << 10;
    request.settings.error = 0.014;
    request.settings.counters = true;
    request.settings.aov = true;
    request
}

/// The picture without an error to reach.
fn plain(request: &RenderRequest, samples: u32) -> RenderRequest {
    let mut request = request.clone();
    (request.settings.samples, request.settings.error) = (samples, 0.0);
    request
}

/// Pictures of 8, 16, 24 … samples that no tile ends in.
struct Runs(Vec<Picture>);

impl Runs {
    fn new(backend: &mut dyn Backend, request: &RenderRequest, samples: u32) -> Self {
        let counts = (1..=samples / RUN).map(|run| run * RUN);
        Self(
            counts
                .map(|count| draw(backend, &plain(request, count)).0)
                .collect(),
        )
    }

    fn of(&self, samples: u32) -> &Picture {
        &self.0[(samples / RUN) as usize - 1]
    }

    /// What so many samples tell of the error of a tile.
    fn spread(&self, samples: u32, tile: usize) -> Spread {
        let mut spread = Spread::default();
        let [width, _] = self.of(samples).size.map(|side| side as usize);
        for at in pixels_of(self.of(samples), tile) {
            let [x, y] = [at % width, at / width];
            let minus = match [x % 2, y % 2] {
                [0, 0] => 3,
                [1, 0] => 0,
                [0, _] => 1,
                _ => 2,
            };
            let signed = |picture: &Picture| -> f64 {
                let value = |c: usize| f64::from(picture.pixels[at][c]);
                (0..3)
                    .map(|c| if c == minus { -value(c) } else { value(c) })
                    .sum()
            };
            let (mut sums, mut counts) = ([0.0; SCRAMBLES], [0.0; SCRAMBLES]);
            let mut before = 0.0;
            for (run, picture) in self.0[..(samples / RUN) as usize].iter().enumerate() {
                let sum = signed(picture) * (run + 1) as f64;
                sums[run % SCRAMBLES] += sum - before;
                counts[run % SCRAMBLES] += 1.0;
                before = sum;
            }
            let runs: f64 = counts.iter().sum();
            let mean = before / runs;
            let with_samples = counts.iter().filter(|count| **count > 0.0).count();
            let off = (sums.iter().zip(counts))
                .filter(|(_, count)| *count > 0.0)
                .map(|(sum, count)| count * (sum / count - mean).powi(2));
            spread.variance += off.sum::<f64>() / ((with_samples - 1) as f64 * runs);
            let pixel = self.of(samples).pixels[at];
            spread.sum += pixel[..3]
                .iter()
                .map(|value| f64::from(*value))
                .sum::<f64>();
            spread.values += 3.0;
        }
        spread
    }
}

/// Numbers of samples up to `last` at which tiles and pictures may end.
fn decisions(last: u32) -> impl Iterator<Item = u32> {
    (0..)
        .map(|k| (2 * RUN) << k)
        .take_while(move |count| *count <= last)
}

/// Places of a tile's pixels in a picture.
fn pixels_of(picture: &Picture, tile: usize) -> Vec<usize> {
    let [width, height] = picture.size.map(|side| side as usize);
    let columns = width.div_ceil(TILE);
    let [left, top] = [tile % columns * TILE, tile / columns * TILE];
    let rows = top..(top + TILE).min(height);
    rows.flat_map(|y| (left..(left + TILE).min(width)).map(move |x| y * width + x))
        .collect()
}

/// Variance of the mean, summed over the values of some pixels; their sum; how many they are.
#[derive(Debug, Clone, Copy, Default)]
struct Spread {
    variance: f64,
    sum: f64,
    values: f64,
}

impl Spread {
    fn and(self, other: Self) -> Self {
        Self {
            variance: self.variance + other.variance,
            sum: self.sum + other.sum,
            values: self.values + other.values,
        }
    }

    /// Root mean square error over the mean.
    fn relative(self) -> f64 {
        (self.variance / self.values).sqrt() / (self.sum / self.values)
    }
}

/// With how many samples each tile of a picture ended: those with which a plain picture has the same bits in it; `None`
/// for background.
fn ends_of(
    request: &RenderRequest,
    picture: &Picture,
    runs: &Runs,
) -> Result<Vec<Option<u32>>, String> {
    let background = background_tiles(request, TILE as u32);
    let tiles = all_numbers(picture).into_iter().zip(background).enumerate();
    tiles
        .map(|(tile, (found, is_background))| {
            if is_background {
                return Ok(None);
            }
            let columns = (picture.size[0] as usize).div_ceil(TILE);
            let place = [tile % columns, tile / columns];
            // Where nothing but ground or background is seen, several numbers of samples may give the same.
            let end = decisions(runs.0.len() as u32 * RUN)
                .find(|count| numbers(runs.of(*count), place) == found);
            end.map(Some)
                .ok_or_else(|| format!("tile {tile} is that of no number of samples"))
        })
        .collect()
}

/// Whether tiles ended when their errors allowed it, and neither sooner nor later.
fn check_ends(
    request: &RenderRequest,
    runs: &Runs,
    ends: &[Option<u32>],
    progress: Progress,
) -> Result<(), String> {
    let (target, last) = (request.settings.error, progress.samples);
    let spread = |tile: usize, samples: u32| match ends[tile] {
        Some(end) => runs.spread(samples.min(end), tile),
        None => runs.spread(samples, tile),
    };
    for samples in decisions(last) {
        let tiles = (0..ends.len()).map(|tile| spread(tile, samples));
        let whole = tiles.reduce(Spread::and).unwrap();
        let limit = target * whole.sum / whole.values;
        for (tile, end) in ends.iter().enumerate() {
            let Some(end) = end.filter(|end| *end >= samples) else {
                continue;
            };
            let found = spread(tile, samples);
            let of_limit = (found.variance / found.values).sqrt() / limit;
            if end == samples && samples < last && of_limit > 1.0 + ROUNDING {
                return Err(format!(
                    "tile {tile} ended at {samples} with {of_limit} of the error"
                ));
            }
            if end > samples && of_limit < 1.0 - ROUNDING {
                return Err(format!(
                    "tile {tile} goes on at {samples} with {of_limit} of the error"
                ));
            }
        }
        let of_target = whole.relative() / target;
        let ended = ends.iter().flatten().all(|end| *end <= samples);
        if samples < last && of_target < 1.0 - ROUNDING {
            return Err(format!(
                "the picture goes on at {samples} with {of_target} of its error"
            ));
        }
        if samples == last {
            if of_target > 1.0 + ROUNDING && !ended {
                return Err(format!(
                    "the picture ended at {samples} with {of_target} of its error"
                ));
            }
            let off = progress.error_estimate.unwrap() / whole.relative() - 1.0;
            if off.abs() > ROUNDING {
                return Err(format!("the estimate is off by {off}"));
            }
        }
    }
    Ok(())
}

#[test]
fn tiles_end_when_their_error_allows_it_with_the_bits_of_a_plain_picture() {
    let request = uneven_towel(FEW_TILES);
    let (mut gpu, mut cpu) = backends();
    for backend in [&mut gpu as &mut dyn Backend, &mut cpu] {
        let name = backend.kind().name();
        let (picture, counters, progress) = draw(backend, &request);
        let last = progress.samples;
        assert!(last > 32 && last.is_power_of_two(), "{name}: {progress:?}");
        let runs = Runs::new(backend, &request, last);
        let ends = ends_of(&request, &picture, &runs).unwrap();
        check_ends(&request, &runs, &ends, progress).unwrap();
        let kinds: BTreeSet<u32> = ends.iter().flatten().copied().collect();
        assert!(kinds.len() >= 3, "{name}: {kinds:?}");
        let left_out = ends.iter().flatten().map(|end| u64::from(last - end));
        assert_eq!(counters.converged_tiles, left_out.sum::<u64>(), "{name}");
        let background = ends.iter().filter(|end| end.is_none()).count();
        assert_eq!(
            counters.skipped_tiles,
            background as u64 * u64::from(last),
            "{name}"
        );

        // Negative controls: a tile that ended at another time, a value one bit off, and another target.
        let some = (ends.iter())
            .position(|end| end.is_some_and(|end| end < last))
            .unwrap();
        for other in [ends[some].unwrap() / 2, 2 * ends[some].unwrap()] {
            let mut wrong = ends.clone();
            wrong[some] = Some(other);
            let is_refused = check_ends(&request, &runs, &wrong, progress).is_err();
            assert!(is_refused || other < 2 * RUN, "{name}: {other}");
        }
        let mut wrong = picture.clone();
        let value = &mut wrong.pixels[pixels_of(&picture, some)[5]][1];
        *value = value.next_up();
        assert!(ends_of(&request, &wrong, &runs).is_err());
        let mut wrong = request.clone();
        wrong.settings.error *= 0.8;
        assert!(
            check_ends(&wrong, &runs, &ends, progress).is_err(),
            "{name}"
        );

        // Without the skip all tiles go on until the picture ends.
        let (all, counted, progress) =
            draw(backend, &without(&request, Optimisation::ConvergedTiles));
        assert_eq!(counted.converged_tiles, 0);
        assert!(progress.samples <= last && counted.rays > 0);
        assert_eq!(
            all_numbers(&all),
            all_numbers(runs.of(progress.samples)),
            "{name}"
        );
    }
}

/// Sums over the tiles that ended early: of squared differences from another picture, of the variance that both tell of
/// themselves, of differences, and the number of values.
#[derive(Debug, Clone, Copy, Default)]
struct Apart {
    squares: f64,
    variance: f64,
    difference: f64,
    values: f64,
}

impl Apart {
    /// Adds what lies between a picture and one of `last` samples of another seed.
    fn add(&mut self, picture: &Picture, ends: &[Option<u32>], runs: &Runs, last: u32) {
        for (tile, end) in ends.iter().enumerate() {
            let Some(end) = end.filter(|end| *end < last) else {
                continue;
            };
            self.variance += runs.spread(end, tile).variance + runs.spread(last, tile).variance;
            for at in pixels_of(picture, tile) {
                for c in 0..3 {
                    let [a, b] = [picture, runs.of(last)].map(|picture| picture.pixels[at][c]);
                    let off = f64::from(a) - f64::from(b);
                    self.squares += off * off;
                    self.difference += off;
                    self.values += 1.0;
                }
            }
        }
    }

    /// Whether it is noise. A bright pixel that only one of two pictures has seen can double the squares of a whole
    /// picture. Channels go together, so that the variance of their sum is at most three times the sum of theirs; four
    /// deviations are one chance in 16,000.
    fn is_noise(&self) -> Result<(), String> {
        let ratio = self.squares / self.variance;
        let deviations = self.difference / (3.0 * self.variance).sqrt();
        if (0.5..2.5).contains(&ratio) && deviations.abs() < 4.0 {
            Ok(())
        } else {
            Err(format!(
                "{ratio} of the variance, {deviations} deviations: {self:?}"
            ))
        }
    }
}

#[test]
fn tiles_that_ended_are_within_noise_of_other_samples() {
    let (mut gpu, mut cpu) = backends();
    for (backend, repeats) in [(&mut gpu as &mut dyn Backend, 1), (&mut cpu, 4)] {
        let name = backend.kind().name();
        // As drawn; a hundredth brighter; a pixel further; with 8 samples everywhere.
        let mut found = [Apart::default(); 4];
        for repeat in 0..repeats {
            let mut request = uneven_towel([56, 40]);
            request.settings.seed = 10 + 2 * repeat;
            let (picture, _, progress) = draw(backend, &request);
            let last = progress.samples;
            let runs = Runs::new(backend, &request, last);
            let ends = ends_of(&request, &picture, &runs).unwrap();
            request.settings.seed += 1;
            let others = Runs::new(backend, &request, last);
            let mut bright = picture.clone();
            for pixel in &mut bright.pixels {
                *pixel = pixel.map(|value| 1.01 * value);
            }
            let mut moved = picture.clone();
            moved.pixels.rotate_right(1);
            let few = runs.of(RUN).clone();
            for (apart, picture) in found.iter_mut().zip([picture, bright, moved, few]) {
                apart.add(&picture, &ends, &others, last);
            }
        }
        let ratios = found.map(|apart| apart.squares / apart.variance);
        eprintln!("{name}: squares over variance {ratios:.2?}");
        found[0].is_noise().unwrap();
        for wrong in &found[1..] {
            assert!(wrong.is_noise().is_err(), "{name}: {wrong:?}");
        }
    }
}

/// Draws to the end in slices of time, with one that is cancelled before it begins between every two.
fn draw_in_slices(
    backend: &mut dyn Backend,
    request: &RenderRequest,
    slice: Duration,
) -> (Picture, Counters, Progress) {
    backend.begin(request).unwrap();
    let [go_on, stop] = [false, true].map(AtomicBool::new);
    loop {
        backend.advance(slice, &stop).unwrap();
        let progress = backend.advance(slice, &go_on).unwrap();
        if progress.done {
            let picture = backend.picture().unwrap();
            return (picture, backend.counters().unwrap(), progress);
        }
    }
}

#[test]
fn how_work_is_cut_into_slices_changes_nothing() {
    let request = uneven_towel(FEW_TILES);
    let (mut gpu, mut cpu) = backends();
    for backend in [&mut gpu as &mut dyn Backend, &mut cpu] {
        let name = backend.kind().name();
        let (picture, counters, progress) = draw(backend, &request);
        assert!(
            progress.samples > 32 && counters.converged_tiles > 0,
            "{name}: {progress:?}"
        );
        let mut other = request.clone();
        (other.settings.seed, other.settings.samples) = (request.settings.seed + 1, 1);
        for micros in [0, 3000] {
            draw(backend, &other);
            let found = draw_in_slices(backend, &request, Duration::from_micros(micros));
            assert_eq!(
                (&counters, &progress),
                (&found.1, &found.2),
                "{name}: {micros}"
            );
            assert_eq!(
                all_numbers(&picture),
                all_numbers(&found.0),
                "{name}: {micros}"
            );
        }
        // Nor does it matter that fewer samples were wanted at first, or how often was looked.
        draw(backend, &other);
        for samples in [3, 20, 40] {
            let mut few = request.clone();
            few.settings.samples = samples;
            assert_eq!(draw(backend, &few).2.samples, samples);
        }
        let found = draw(backend, &request);
        assert_eq!((&counters, &progress), (&found.1, &found.2), "{name}");
        assert_eq!(all_numbers(&picture), all_numbers(&found.0), "{name}");
    }
}

#[test]
fn an_error_that_would_have_ended_something_before_starts_again() {
    let request = uneven_towel(FEW_TILES);
    let (mut gpu, mut cpu) = backends();
    for backend in [&mut gpu as &mut dyn Backend, &mut cpu] {
        let name = backend.kind().name();
        let (fresh, ..) = draw(backend, &request);
        // Before, no error was asked for, or one that only tiles without any noise reach.
        for error in [0.0, 1e-6] {
            let mut before = plain(&request, 40);
            before.settings.error = error;
            draw(backend, &before);
            let (found, ..) = draw(backend, &request);
            assert_eq!(
                all_numbers(&found),
                all_numbers(&fresh),
                "{name}: after {error}"
            );
        }
    }
}

#[test]
fn another_error_starts_again_once_tiles_have_ended() {
    let mut request = uneven_towel(FEW_TILES);
    let (mut gpu, mut cpu) = backends();
    for backend in [&mut gpu as &mut dyn Backend, &mut cpu] {
        request.settings.error = 0.02;
        let (_, counters, _) = draw(backend, &request);
        assert!(counters.converged_tiles > 0);
        request.settings.error = 0.014;
        let (tightened, ..) = draw(backend, &request);
        request.settings.seed += 1;
        draw(backend, &request);
        request.settings.seed -= 1;
        let (fresh, ..) = draw(backend, &request);
        assert_eq!(all_numbers(&tightened), all_numbers(&fresh));
    }
}
