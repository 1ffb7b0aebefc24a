//! Denoising: which libraries are taken, what is handed to them, and how much of what comes back is shown. With libraries
//! built here; what the real one does is tested with the program.

use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

use renderer_core::denoise::{
    self, Denoise, DenoiseError, DenoiseQuality, Denoiser, FILE_NAMES, Library, Mix, Places, Step,
};
use renderer_core::image::Picture;
use renderer_core::image::metrics::rel_rmse;
use renderer_core::sampling::{hash_with, unit_float};
use tempfile::TempDir;

use crate::support::denoisers::build;
use crate::support::pictures::uniform;

fn denoiser(library: &Path) -> Result<Denoiser, DenoiseError> {
    Denoiser::new(&Library::open(library)?)
}

fn halved(denoiser: &mut Denoiser, picture: &Picture) -> Result<Picture, DenoiseError> {
    denoiser.denoise(picture, DenoiseQuality::High, 1.0, &AtomicBool::new(false))
}

#[test]
fn what_is_not_the_library_is_refused_by_file_and_reason() {
    let folder = TempDir::new().unwrap();
    let text = folder.path().join("text.so");
    std::fs::write(&text, "no library at all").unwrap();
    let refused = Library::open(&text).unwrap_err();
    assert!(
        matches!(&refused, DenoiseError::Load { path, .. } if *path == text),
        "{refused}"
    );
    assert!(
        refused.to_string().contains("text.so cannot be loaded: "),
        "{refused}"
    );

    let lacking = build(folder.path(), "lacking.so", &["LACKS_FILTERS"]);
    let refused = Library::open(&lacking).unwrap_err().to_string();
    assert!(
        refused.ends_with("lacking.so is not Open Image Denoise 2: it lacks oidnNewFilter"),
        "{refused}"
    );

    for (number, version) in [(10403, "1.4.3"), (30000, "3.0.0")] {
        let name = format!("{version}.so");
        let other = build(folder.path(), &name, &[&format!("VERSION={number}")]);
        let refused = denoiser(&other).err().unwrap();
        let expected = DenoiseError::Version {
            path: other,
            version: version.into(),
        };
        assert_eq!(refused, expected);
    }
}

#[test]
fn colours_go_through_the_library_and_coverage_and_bare_background_do_not() {
    let folder = TempDir::new().unwrap();
    let mut denoiser = denoiser(&build(folder.path(), "good.so", &[])).unwrap();
    assert_eq!(denoiser.name(), "Open Image Denoise 2.5.1 on CPU: A test");
    // Cloth in the right half; the column left of it is near it.
    let mut picture = uniform([8, 3], [0.4, 0.2, 0.6, 0.0]);
    for (index, pixel) in picture.pixels.iter_mut().enumerate() {
        pixel[3] = if index % 8 >= 4 { 0.75 } else { 0.0 };
    }
    let denoised = halved(&mut denoiser, &picture).unwrap();
    for (index, pixel) in denoised.pixels.iter().enumerate() {
        let (factor, alpha) = match index % 8 {
            0..3 => (1.0, 0.0),
            3 => (0.5, 0.0),
            _ => (0.5, 0.75),
        };
        assert_eq!(
            *pixel,
            [0.4 * factor, 0.2 * factor, 0.6 * factor, alpha],
            "{index}"
        );
    }
    // Another size, then the first again.
    let small = uniform([2, 2], [1.0, 1.0, 1.0, 1.0]);
    assert_eq!(
        halved(&mut denoiser, &small).unwrap().pixels,
        [[0.5, 0.5, 0.5, 1.0]; 4]
    );
    assert_eq!(halved(&mut denoiser, &picture), Ok(denoised));
}

#[test]
fn failures_say_what_the_library_says_and_a_cancelled_picture_is_no_failure() {
    let folder = TempDir::new().unwrap();
    let picture = uniform([2, 2], [1.0; 4]);
    let mut failing = denoiser(&build(folder.path(), "failing.so", &["FAILS"])).unwrap();
    let failure = halved(&mut failing, &picture).unwrap_err();
    assert_eq!(
        failure.to_string(),
        "Open Image Denoise: not enough memory for the network"
    );

    let mut good = denoiser(&build(folder.path(), "good.so", &[])).unwrap();
    let cancelled = good.denoise(&picture, DenoiseQuality::Fast, 1.0, &AtomicBool::new(true));
    assert_eq!(cancelled, Err(DenoiseError::Cancelled));
    assert!(
        halved(&mut good, &picture).is_ok(),
        "it goes on with the next"
    );

    // Where the default device cannot be made the processor is taken; where that cannot be made either, it says so.
    let no_gpu = build(folder.path(), "no-gpu.so", &["NO_DEVICE=0"]);
    assert!(denoiser(&no_gpu).is_ok());
    let no_processor = build(folder.path(), "none.so", &["NO_DEVICE=type"]);
    let failure = denoiser(&no_processor).err().unwrap();
    assert_eq!(
        failure.to_string(),
        "Open Image Denoise: no such device here"
    );
}

/// Folders with libraries of the usual name, made with these macros.
fn folders(folder: &Path, libraries: &[&[&str]]) -> Vec<PathBuf> {
    let make = |(number, macros): (usize, &&[&str])| {
        let place = folder.join(number.to_string());
        std::fs::create_dir(&place).unwrap();
        build(&place, FILE_NAMES[0], macros);
        place
    };
    libraries.iter().enumerate().map(make).collect()
}

#[test]
fn the_first_that_can_be_used_is_taken_unless_one_is_named() {
    let folder = TempDir::new().unwrap();
    let (old, good, better): (&[&str], &[&str], &[&str]) =
        (&["VERSION=10403"], &[], &["VERSION=20600"]);
    let folders = folders(folder.path(), &[old, good, better]);
    let file = |number: usize| folders[number].join(FILE_NAMES[0]);
    let places = Places {
        folders: [vec![folder.path().join("nowhere")], folders.clone()].concat(),
        ..Places::default()
    };
    let searched = denoise::find(&places);
    assert_eq!(searched.found.unwrap().path(), file(1));
    assert!(
        matches!(&searched.refused[..], [DenoiseError::Version { path, .. }] if *path == file(0)),
        "{:?}",
        searched.refused
    );

    // A folder or a file that is named is the only place; the file is asked first.
    let mut named = places.clone();
    named.folder = Some(folders[2].clone());
    assert_eq!(denoise::find(&named).found.unwrap().path(), file(2));
    named.library = Some(file(0).into());
    let error = denoise::find(&named).found.unwrap_err();
    assert!(matches!(error, DenoiseError::Version { .. }), "{error}");
    named.library = None;
    named.folder = Some(folder.path().join("nowhere"));
    let error = denoise::find(&named).found.unwrap_err();
    assert!(matches!(error, DenoiseError::Load { .. }), "{error}");

    let off = Places {
        library: Some("".into()),
        ..places
    };
    assert_eq!(
        denoise::find(&off).found.unwrap_err(),
        DenoiseError::SwitchedOff
    );
    assert_eq!(
        denoise::find(&Places::default()).found.unwrap_err(),
        DenoiseError::NotFound
    );
}

/// Values of a picture without noise, of its noise in a sample, and of what denoising leaves wrong.
const SIDE: u32 = 192;
const NOISE: f64 = 2.0;
const BIAS: f64 = 0.2;

fn noise(seed: u32, index: usize, channel: usize) -> f64 {
    let uniform = f64::from(unit_float(hash_with(seed, (3 * index + channel) as u32)));
    (2.0 * uniform - 1.0) * 3.0_f64.sqrt()
}

fn made(value: impl Fn(usize, usize) -> f64) -> Picture {
    let mut picture = uniform([SIDE, SIDE], [0.0, 0.0, 0.0, 1.0]);
    for (index, pixel) in picture.pixels.iter_mut().enumerate() {
        for (channel, to) in pixel[..3].iter_mut().enumerate() {
            *to = value(index, channel) as f32;
        }
    }
    picture
}

fn truth() -> Picture {
    made(|index, channel| 1.0 + 0.5 * ((index + channel) as f64 * 0.1).sin())
}

/// The mean of the first samples, and a denoised picture that is off by [`BIAS`].
fn step(samples: u32) -> Step {
    let truth = truth();
    let value = |index: usize, channel: usize| f64::from(truth.pixels[index][channel]);
    let mean = |index: usize, channel: usize| {
        let sum: f64 = (0..samples)
            .map(|sample| noise(sample, index, channel))
            .sum();
        NOISE * sum / f64::from(samples)
    };
    Step {
        samples,
        plain: made(|index, channel| value(index, channel) + mean(index, channel)),
        // As a backend estimates it: the mean of what is there is 1.
        error: Some(NOISE / f64::from(samples).sqrt()),
        denoised: made(|index, channel| value(index, channel) + BIAS * noise(9999, index, channel)),
    }
}

#[test]
fn a_mixture_has_the_least_error_and_knows_it() {
    let steps = [1, 4, 16, 64].map(step);
    let truth = truth();
    // For the first what is known of the noise has to do; it is too much to tell the rest.
    for (number, now) in steps.iter().enumerate() {
        let earlier = number.checked_sub(1).map(|number| &steps[number]);
        let mix = Mix::new(earlier, now);
        let variance = NOISE.powi(2) / f64::from(now.samples);
        let best = variance / (variance + BIAS.powi(2));
        assert!((mix.share - best).abs() < 0.02, "{} for {best}", mix.share);
        let error = rel_rmse(&mix.picture, &truth).unwrap();
        let told = mix.error.unwrap();
        assert!(
            number == 0 || (told / error - 1.0).abs() < 0.15,
            "{told} for {error}"
        );
        // Negative controls: neither part alone is as near.
        assert!(error < rel_rmse(&now.plain, &truth).unwrap());
        assert!(error < rel_rmse(&now.denoised, &truth).unwrap());
    }
}

#[test]
fn all_is_denoised_where_the_noise_is_not_known_and_nothing_where_there_is_none() {
    let (early, late) = (step(2), step(4));
    let mut unknown = late.clone();
    unknown.error = None;
    let mix = Mix::new(Some(&early), &unknown);
    assert_eq!((mix.share, mix.error), (1.0, None));
    assert_eq!(mix.picture, late.denoised);
    let mut clear = late.clone();
    clear.error = Some(0.0);
    let mix = Mix::new(Some(&early), &clear);
    assert_eq!((mix.share, mix.picture), (0.0, clear.plain));

    // A step of another size, or with more samples, tells nothing.
    let mut small = early.clone();
    small.plain = uniform([2, 2], [1.0; 4]);
    let alone = Mix::new(None, &early);
    assert_eq!(Mix::new(Some(&late), &early).share, alone.share);
    assert_eq!(
        Mix::new(Some(&small), &late).share,
        Mix::new(None, &late).share
    );
    assert!(Mix::new(Some(&early), &late).share != Mix::new(None, &late).share);
}
