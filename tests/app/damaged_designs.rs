//! Presets, bundles and pictures that carry a design, changed at random: whatever they say, they are opened or refused
//! with a message that names the file, and what was opened is saved and comes back as it was.
//!
//! `FUZZ_INPUTS=100000` tries as many instead of some hundred.

use std::fs;
use std::io::{Cursor, Write};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};

use image::{ImageFormat, Rgb, RgbImage};
use towel_designer::files;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

use crate::support::mutate::Mutator;
use crate::support::png::{chunk, with_chunks};

/// Inputs that the suite tries.
const INPUTS: usize = 900;

/// A folder with a preset and its images.
struct Workshop(tempfile::TempDir);

impl Workshop {
    fn new() -> Self {
        let shop = Self(tempfile::tempdir().expect("a folder"));
        fs::write(shop.at("chart.png"), chart()).expect("written");
        fs::write(shop.at("sky.png"), chart()).expect("written");
        shop
    }

    fn at(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }
}

fn chart() -> Vec<u8> {
    let image = RgbImage::from_fn(16, 8, |x, y| Rgb([x as u8 * 16, y as u8 * 30, 99]));
    let mut file = Cursor::new(Vec::new());
    image
        .write_to(&mut file, ImageFormat::Png)
        .expect("a picture");
    file.into_inner()
}

/// The shipped presets, as if their images lay beside them, and one that names an image of each kind.
fn presets() -> Vec<String> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../presets");
    let files = fs::read_dir(folder)
        .expect("presets")
        .map(|entry| entry.expect("a file").path());
    let mut files: Vec<PathBuf> = files
        .filter(|file| file.extension().is_some_and(|e| e == "toml"))
        .collect();
    files.sort();
    let with_own_images = |text: String| {
        let line = |line: &str| match line.starts_with("image = ") {
            true => "image = \"chart.png\"".to_owned(),
            false => line.to_owned(),
        };
        text.lines().map(line).collect::<Vec<_>>().join("\n")
    };
    let mut presets: Vec<String> = files
        .iter()
        .map(|file| with_own_images(fs::read_to_string(file).expect("a preset")))
        .collect();
    presets.push(
        "format = 1\n[chart]\nimage = \"chart.png\"\n[nap]\nimage = \"chart.png\"\n[form]\nkind = \"height\"\n\
         image = \"chart.png\"\n[light.environment]\nkind = \"image\"\nimage = \"sky.png\"\n"
            .into(),
    );
    presets
}

/// A zip of these entries.
fn archive(entries: &[(&str, &[u8])]) -> Vec<u8> {
    let mut writer = ZipWriter::new(Cursor::new(Vec::new()));
    let options = SimpleFileOptions::default().compression_method(CompressionMethod::Stored);
    for (name, bytes) in entries {
        writer.start_file(*name, options).expect("an entry");
        writer.write_all(bytes).expect("written");
    }
    writer.finish().expect("an archive").into_inner()
}

/// What a changed design comes in.
#[derive(Debug, Clone, Copy)]
enum Container {
    Preset,
    Bundle,
    Picture,
}

impl Container {
    fn name(self) -> &'static str {
        match self {
            Self::Preset => "changed.toml",
            Self::Bundle => "changed.towel",
            Self::Picture => "changed.png",
        }
    }

    /// A file of a preset's text with its images beside it or within.
    fn file(self, text: &[u8]) -> Vec<u8> {
        let chart = chart();
        let entries = [
            ("preset.toml", text),
            ("chart.png", &*chart),
            ("sky.png", &*chart),
        ];
        match self {
            Self::Preset => text.to_vec(),
            Self::Bundle => archive(&entries),
            Self::Picture => with_chunks(chart.clone(), &[chunk(b"toWl", &archive(&entries))]),
        }
    }
}

/// Opens a file; what was opened is saved, and opened again.
fn open_and_keep(shop: &Workshop, file: &Path) -> Result<(), String> {
    let opened = files::open_design(file).map_err(|error| error.to_string())?;
    let kept = shop.at("kept.toml");
    files::save(&opened.design, &opened.carried, &kept, Some(file)).expect("saved");
    let again = files::open_design(&kept)
        .expect("what was saved opens")
        .design;
    let without_paths = |mut design: renderer_core::design::Design| {
        for slot in renderer_core::design::ImageSlot::of(&design) {
            slot.set_path(&mut design, None);
        }
        design
    };
    assert_eq!(
        without_paths(again),
        without_paths(opened.design),
        "what was saved"
    );
    Ok(())
}

#[test]
fn designs_changed_at_random_are_opened_and_kept_or_refused() {
    let count = std::env::var("FUZZ_INPUTS")
        .ok()
        .and_then(|count| count.parse().ok());
    let inputs = count.unwrap_or(INPUTS);
    let (shop, presets) = (Workshop::new(), presets());
    let texts: Vec<&[u8]> = presets.iter().map(String::as_bytes).collect();
    for container in [Container::Preset, Container::Bundle, Container::Picture] {
        let file = shop.at(container.name());
        fs::write(&file, container.file(texts[texts.len() - 1])).expect("written");
        open_and_keep(&shop, &file).expect("the unchanged design opens");
    }
    let mut mutator = Mutator::new(20_261_130);
    let (mut opened, mut faults) = (0, Vec::new());
    for input in 0..inputs {
        let text = texts[mutator.below(texts.len())];
        let container =
            [Container::Preset, Container::Bundle, Container::Picture][mutator.below(3)];
        // The text as another program or a hand changes it, or the bytes as a disk does.
        let bytes = match mutator.below(3) {
            0 => mutator.mutated(&container.file(text), &texts),
            1 => container.file(&mutator.mutated(text, &texts)),
            _ => container.file(&mutator.mutated_text(text)),
        };
        let file = shop.at(container.name());
        fs::write(&file, &bytes).expect("written");
        match catch_unwind(AssertUnwindSafe(|| open_and_keep(&shop, &file))) {
            Ok(Ok(())) => opened += 1,
            Ok(Err(message)) if message.contains(container.name()) => {}
            Ok(Err(message)) => faults.push(format!("{input} {container:?}: {message}")),
            Err(_) => faults.push(format!("{input} {container:?}: panic")),
        }
    }
    if count.is_some() {
        eprintln!("{opened} of {inputs} opened");
    }
    assert!(faults.is_empty(), "{faults:#?}");
    // Neither all nor none come through, or nothing was tried.
    assert!(
        opened > inputs / 20 && opened < inputs,
        "{opened} of {inputs}"
    );
}
