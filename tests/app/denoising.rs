//! Denoising with the library of this machine: what it does to noise, and what `render --denoise` writes and says.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use renderer_core::cpu::CpuBackend;
use renderer_core::denoise::{Denoise, DenoiseQuality, Mix, Places, Step};
use renderer_core::image::metrics::rel_rmse;
use renderer_core::image::{Picture, png_text};
use renderer_core::render::Backend;
use tempfile::TempDir;
use towel_designer::denoiser;

use crate::support::scenes;

fn real() -> Box<dyn Denoise> {
    let how = "tests need Open Image Denoise: tests/run brings it, or set OIDN_LIBRARY to its file";
    denoiser::make().unwrap_or_else(|error| panic!("{error}; {how}"))
}

fn library() -> PathBuf {
    drop(real());
    denoiser::search().found.unwrap().path().to_owned()
}

fn rendered(backend: &mut CpuBackend, samples: u32, seed: u32) -> (Picture, Option<f64>) {
    let mut request = scenes::request(&scenes::small_towel(), [96, 96]);
    (request.settings.samples, request.settings.seed) = (samples, seed);
    backend.begin(&request).unwrap();
    let never = AtomicBool::new(false);
    loop {
        let progress = backend.advance(Duration::from_secs(1), &never).unwrap();
        if progress.done {
            return (backend.picture().unwrap(), progress.error_estimate);
        }
    }
}

#[test]
fn a_noisy_picture_comes_nearer_to_the_truth_and_a_mixture_goes_on_to_it() {
    let mut denoiser = real();
    assert!(
        denoiser.name().starts_with("Open Image Denoise 2."),
        "{}",
        denoiser.name()
    );
    let mut backend = CpuBackend::default();
    let (truth, _) = rendered(&mut backend, 512, 7);
    let never = AtomicBool::new(false);
    let mut last: Option<Step> = None;
    for samples in [1, 8, 16, 32] {
        let (plain, error) = rendered(&mut backend, samples, 0);
        let denoised = denoiser
            .denoise(&plain, DenoiseQuality::High, 1.0, &never)
            .unwrap();
        let of = |picture: &Picture| rel_rmse(picture, &truth).unwrap();
        let step = Step {
            samples,
            plain,
            error,
            denoised,
        };
        let mix = Mix::new(last.as_ref(), &step);
        let [noisy, smooth, mixed] = [of(&step.plain), of(&step.denoised), of(&mix.picture)];
        if samples == 1 {
            // The negative control is the plain picture.
            assert!(smooth < 0.5 * noisy, "{smooth} after {noisy}");
        }
        assert!(
            samples < 16 || mixed < 1.1 * noisy.min(smooth),
            "{mixed} of {noisy} and {smooth} at {samples}"
        );
        let told = mix.error.unwrap_or(mixed);
        assert!(
            (0.6..2.0).contains(&(told / mixed)),
            "{told} for {mixed} at {samples}"
        );
        let coverage = step.plain.pixels.iter().zip(&mix.picture.pixels);
        assert!(
            coverage
                .into_iter()
                .all(|(before, after)| before[3] == after[3])
        );
        last = Some(step);
    }
    // Both qualities and sizes that are no round numbers.
    let odd = Picture {
        size: [37, 21],
        pixels: vec![[0.3, 0.2, 0.1, 1.0]; 37 * 21],
        aov: None,
    };
    for quality in [DenoiseQuality::Fast, DenoiseQuality::High] {
        let even = denoiser.denoise(&odd, quality, 1.0, &never).unwrap();
        assert!(rel_rmse(&even, &odd).unwrap() < 0.05);
    }
}

/// A folder with a small preset, and the program in it.
struct Bench(TempDir);

impl Bench {
    fn new() -> Self {
        let folder = TempDir::new().unwrap();
        let preset = "format = 1\n\n[sheet]\nwarps = 12\nwefts = 10\n\n[pile]\nvariants = 2\nresolution = 16\n\n\
            [quality]\nmethod = \"single\"\nbounces = 1\nsamples = 4\n";
        fs::write(folder.path().join("small.toml"), preset).unwrap();
        Self(folder)
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Runs `render` with this library, or none.
    fn render(&self, library: &Path, output: &str, more: &[&str]) -> Output {
        Command::new(env!("CARGO_BIN_EXE_towel-designer"))
            .current_dir(self.0.path())
            .env(Places::LIBRARY, library)
            .args([
                "render",
                "small.toml",
                "--backend",
                "cpu",
                "--quiet",
                "-o",
                output,
            ])
            .args(more)
            .output()
            .unwrap()
    }

    fn ok(&self, library: &Path, output: &str, more: &[&str]) {
        let done = self.render(library, output, more);
        assert!(
            done.status.success(),
            "{}",
            String::from_utf8_lossy(&done.stderr)
        );
    }

    fn json(&self, name: &str) -> serde_json::Value {
        serde_json::from_slice(&fs::read(self.path(name)).unwrap()).unwrap()
    }
}

fn channels(path: &Path) -> (Option<String>, BTreeMap<String, Vec<f32>>) {
    use exr::prelude::{ReadChannels, ReadLayers};
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_file(path)
        .unwrap();
    let comments = image
        .layer_data
        .attributes
        .comments
        .map(|text| text.to_string());
    let list = image.layer_data.channel_data.list.iter();
    let channels = list.map(|channel| {
        (
            channel.name.to_string(),
            channel.sample_data.values_as_f32().collect(),
        )
    });
    (comments, channels.collect())
}

/// The channels of one layer, as a picture.
fn layer(channels: &BTreeMap<String, Vec<f32>>, layer: &str) -> Picture {
    let of = |channel: &str| &channels[&format!("{layer}{channel}")];
    let pixels = (0..64 * 48).map(|k| [of("R")[k], of("G")[k], of("B")[k], 1.0]);
    Picture {
        size: [64, 48],
        pixels: pixels.collect(),
        aov: None,
    }
}

#[test]
fn files_and_stats_say_that_a_picture_is_denoised_and_an_exr_keeps_the_noisy_one() {
    let (bench, library) = (Bench::new(), library());
    // Of one sample all of the picture is denoised.
    let one = ["--size", "64x48", "--samples", "1"];
    let asked = [&one[..], &["--denoise"]].concat();
    bench.ok(&library, "plain.exr", &one);
    let more = ["--aov", "albedo", "--stats", "stats.json"];
    bench.ok(&library, "denoised.exr", &[&asked[..], &more].concat());
    let (comment, plain) = channels(&bench.path("plain.exr"));
    assert_eq!(comment, None);
    let (comment, denoised) = channels(&bench.path("denoised.exr"));
    let names: Vec<&str> = denoised.keys().map(String::as_str).collect();
    assert_eq!(
        names,
        [
            "B", "G", "R", "albedo.B", "albedo.G", "albedo.R", "noisy.B", "noisy.G", "noisy.R"
        ]
    );
    for channel in ["R", "G", "B"] {
        assert_eq!(plain[channel], denoised[&format!("noisy.{channel}")]);
        assert_ne!(plain[channel], denoised[channel]);
    }
    // The distance is that of the two pictures in the file.
    let stats = bench.json("stats.json");
    let told = stats["denoised"]["distance"].as_f64().unwrap();
    let distance = rel_rmse(&layer(&denoised, ""), &layer(&denoised, "noisy.")).unwrap();
    assert!(
        distance > 0.01 && (told / distance - 1.0).abs() < 1e-3,
        "{told}, {distance}"
    );
    assert_eq!(stats["denoised"]["share"], 1.0);
    let by = stats["denoised"]["by"].as_str().unwrap();
    assert!(by.starts_with("Open Image Denoise 2."), "{by}");
    let comment = comment.unwrap();
    let expected = format!("relRMSE to the plain picture {distance:.3}");
    assert!(
        comment.starts_with(&format!("Denoised by {by}")) && comment.contains(&expected),
        "{comment}"
    );

    bench.ok(&library, "plain.png", &[&one[..], &more[2..]].concat());
    assert_eq!(
        bench.json("stats.json")["denoised"],
        serde_json::Value::Null
    );
    bench.ok(&library, "denoised.png", &asked);
    let text = |name: &str| {
        let file = std::io::Cursor::new(fs::read(bench.path(name)).unwrap());
        png_text(file, "Comment")
    };
    assert_eq!(text("plain.png"), None);
    assert_eq!(text("denoised.png").as_deref(), Some(&*comment));
}

#[test]
fn bands_are_denoised_as_if_they_were_one_but_for_what_is_far_away() {
    let (bench, library) = (Bench::new(), library());
    // Of one sample all of the picture is denoised, whatever is known of it.
    let one = ["--denoise", "--samples", "1", "--size", "256x800"];
    bench.ok(&library, "whole.exr", &one);
    bench.ok(
        &library,
        "bands.exr",
        &[&one[..], &["--memory", "12", "--stats", "stats.json"]].concat(),
    );
    assert!(bench.json("stats.json")["bands"].as_u64().unwrap() > 2);
    let [whole, bands] = ["whole.exr", "bands.exr"].map(|name| channels(&bench.path(name)).1);
    assert_eq!(whole["noisy.G"], bands["noisy.G"]);
    let difference = |of: &dyn Fn(usize) -> f32, reference: &dyn Fn(usize) -> f32| {
        let squares: f32 = (0..256 * 800).map(|k| (of(k) - reference(k)).powi(2)).sum();
        squares.sqrt()
    };
    let between = difference(&|k| bands["G"][k], &|k| whole["G"][k]);
    let noise = difference(&|k| whole["noisy.G"][k], &|k| whole["G"][k]);
    assert!(between < 0.02 * noise, "{between} of {noise}");
}

#[test]
fn without_a_library_it_says_how_to_get_one_before_anything_is_rendered() {
    let bench = Bench::new();
    let text = bench.path("text.so");
    fs::write(&text, "no library").unwrap();
    for (library, says) in [
        (Path::new(""), "OIDN_LIBRARY is empty"),
        (&text, "text.so cannot be loaded"),
        (Path::new("/lib/x86_64-linux-gnu/libc.so.6"), "libc.so.6"),
    ] {
        let done = bench.render(library, "out.png", &["--denoise"]);
        let errors = String::from_utf8_lossy(&done.stderr);
        assert_eq!(done.status.code(), Some(1), "{errors}");
        assert!(
            errors.contains(says) && errors.contains("or leave out --denoise"),
            "{errors}"
        );
        assert!(!bench.path("out.png").exists());
        // Without being asked to, it needs none.
        bench.ok(library, "plain.png", &["--size", "64x48"]);
    }
}
