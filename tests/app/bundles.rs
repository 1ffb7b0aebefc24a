//! Designs in one file: bundles and pictures that carry their design. They open as what was saved, on another machine
//! too, and whatever is broken or hostile in them gets a message.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use renderer_core::design::{Design, EnvironmentKind, ImageSlot};
use towel_designer::files::{self, Carried, Origin, Shipped};

use crate::support::png;

/// A folder with a preset that names a chart and a picture of the surroundings in other folders.
struct Workshop(tempfile::TempDir);

impl Workshop {
    fn new() -> Self {
        let shop = Self(tempfile::tempdir().expect("a folder"));
        for folder in ["design", "charts", "elsewhere"] {
            fs::create_dir(shop.at(folder)).expect("a folder");
        }
        write_noise(&shop.at("charts/Blüten muster.png"), 40, 30);
        let mut sky = Vec::new();
        image::codecs::hdr::HdrEncoder::new(&mut sky)
            .encode(&[image::Rgb([0.25, 1.0, 8.0]); 32], 8, 4)
            .expect("a picture");
        fs::write(shop.at("charts/sky.hdr"), sky).expect("written");
        let preset = "format = 1\n[sheet]\nwarps = 12\nwefts = 10\n[chart]\nimage = \"../charts/Blüten muster.png\"\n\
                      [light.environment]\nkind = \"image\"\nimage = \"../charts/sky.hdr\"\n\
                      [quality]\nmethod = \"single\"\nbounces = 1\nsamples = 1\n";
        fs::write(shop.preset(), preset).expect("written");
        shop
    }

    fn at(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn preset(&self) -> PathBuf {
        self.at("design/one.toml")
    }

    /// The preset as a bundle, and the design in it.
    fn bundle(&self) -> (PathBuf, Design) {
        let design = files::load_design(&self.preset()).expect("a preset");
        let path = self.at("one.towel");
        let none = Carried::default();
        files::save(&design, &none, &path, Some(&self.preset())).expect("saved");
        (path, design)
    }

    fn remove_sources(&self) {
        fs::remove_dir_all(self.at("charts")).expect("removed");
        fs::remove_dir_all(self.at("design")).expect("removed");
    }
}

/// A picture that does not get smaller by packing.
fn write_noise(path: &Path, width: u32, height: u32) {
    let mut state = 1_u32;
    let noise = image::RgbImage::from_fn(width, height, |_, _| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let [_, a, b, c] = state.to_le_bytes();
        image::Rgb([a, b, c])
    });
    noise.save(path).expect("a picture");
}

/// A design apart from the names of its images.
#[track_caller]
fn assert_same_cloth(design: &Design, expected: &Design) {
    let (mut design, mut expected) = (design.clone(), expected.clone());
    for slot in ImageSlot::of(&expected) {
        slot.set_path(&mut design, None);
        slot.set_path(&mut expected, None);
    }
    assert_eq!(design, expected);
}

fn program(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_towel-designer"))
        .args(arguments)
        .output()
        .expect("the program runs")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

#[test]
fn a_bundle_opens_without_the_files_it_was_made_of() {
    let shop = Workshop::new();
    let (path, design) = shop.bundle();
    let sky = fs::read(shop.at("charts/sky.hdr")).unwrap();
    shop.remove_sources();
    let opened = files::open_design(&path).unwrap();
    assert_eq!(opened.origin, Origin::Bundle);
    assert_eq!(opened.warnings, [""; 0]);
    assert_same_cloth(&opened.design, &design);
    assert!(design.chart.pixels.is_some() && design.light.environment.pixels.is_some());
    let names: Vec<_> = opened.carried.iter().map(|(name, _)| name).collect();
    assert_eq!(names, ["Blüten muster.png", "sky.hdr"]);
    assert_eq!(**opened.carried.get("sky.hdr").unwrap(), *sky, "as it was");

    // Saved from there, again as a bundle and as a preset with its images beside it.
    let again = shop.at("elsewhere/two.towel");
    files::save(&opened.design, &opened.carried, &again, Some(&path)).unwrap();
    assert_eq!(
        fs::read(&again).unwrap(),
        fs::read(&path).unwrap(),
        "the same design makes the same bytes"
    );
    let preset = shop.at("elsewhere/three.toml");
    for _ in 0..2 {
        files::save(&opened.design, &opened.carried, &preset, Some(&path)).unwrap();
        let loose = files::load_design(&preset).unwrap();
        assert_eq!(loose.chart.image.as_deref(), Some("Blüten muster.png"));
        assert_same_cloth(&loose, &design);
    }
    assert_eq!(
        fs::read_dir(shop.at("elsewhere")).unwrap().count(),
        4,
        "images are written once"
    );
}

#[test]
fn what_is_only_in_memory_is_saved_too() {
    let shop = Workshop::new();
    let (_, mut design) = shop.bundle();
    shop.remove_sources();
    // Another file has the name already, and stays.
    fs::write(shop.at("elsewhere/sky.exr"), "mine").unwrap();
    design.chart.image = None;
    for place in ["elsewhere/memory.toml", "elsewhere/memory.towel"] {
        let none = Carried::default();
        files::save(&design, &none, &shop.at(place), None).unwrap();
        let opened = files::load_design(&shop.at(place)).unwrap();
        let environment = &opened.light.environment;
        assert_eq!(environment.pixels, design.light.environment.pixels);
        if place.ends_with("towel") {
            assert_eq!(opened.chart.pixels, design.chart.pixels);
        } else {
            assert_eq!(environment.image.as_deref(), Some("sky-2.exr"));
        }
    }
    assert_eq!(fs::read(shop.at("elsewhere/sky.exr")).unwrap(), b"mine");
}

#[test]
fn the_command_line_takes_bundles() {
    let shop = Workshop::new();
    let (path, _) = shop.bundle();
    let bundle = path.to_str().unwrap();
    let checked = program(&["check", bundle]);
    assert_eq!(checked.status.code(), Some(0), "{checked:?}");
    assert!(text(&checked.stdout).contains("one.towel: ok"));
    let render = |from: &str, to: &str| {
        let out = shop.at(to);
        let done = program(&[
            "render",
            from,
            "-o",
            out.to_str().unwrap(),
            "--size",
            "24x16",
            "--backend",
            "reference",
            "--quiet",
            // The preset's images are in other folders.
            "--allow-outside-images",
        ]);
        assert_eq!(done.status.code(), Some(0), "{done:?}");
        assert_eq!(text(&done.stderr), "");
        fs::read(out).unwrap()
    };
    let from_bundle = render(bundle, "a.png");
    let from_preset = render(shop.preset().to_str().unwrap(), "b.png");
    assert!(
        from_bundle == from_preset,
        "the same design makes the same picture, wherever it lies"
    );
    // A picture renders as the design that it carries.
    assert!(render(shop.at("a.png").to_str().unwrap(), "c.png") == from_bundle);
}

#[test]
fn a_picture_carries_its_design() {
    let shop = Workshop::new();
    let design = files::load_design(&shop.preset()).unwrap();
    let folder = shop.at("design");
    let embedded = files::embedded(&design, &Carried::default(), &folder).unwrap();
    assert_eq!(embedded.warnings, [""; 0]);
    write_noise(&shop.at("plain.png"), 9, 7);
    assert!(!files::carries_design(&shop.at("plain.png")));
    let plain = fs::read(shop.at("plain.png")).unwrap();
    let picture = shop.at("picture.png");
    fs::write(&picture, png::with_chunks(plain, &embedded.chunks)).unwrap();
    shop.remove_sources();
    assert!(files::carries_design(&picture));
    let opened = files::open_design(&picture).unwrap();
    assert_eq!(opened.origin, Origin::Picture);
    assert_same_cloth(&opened.design, &design);
    // Still the same picture for everybody else.
    let pixels = |name: &str| image::open(shop.at(name)).unwrap().into_rgb8();
    assert_eq!(pixels("picture.png"), pixels("plain.png"));

    let error = files::load_design(&shop.at("plain.png")).unwrap_err();
    let message = error.to_string();
    assert!(
        message.contains("plain.png: carries no design"),
        "{message}"
    );
    // A single wrong bit, and it is not believed.
    let mut damaged = fs::read(&picture).unwrap();
    damaged[100] ^= 4;
    fs::write(&picture, damaged).unwrap();
    assert!(!files::carries_design(&picture));
}

#[test]
fn large_images_are_left_out_and_that_is_reported() {
    let shop = Workshop::new();
    // Three bytes a pixel that cannot be packed: 4.4 MB, just too large.
    write_noise(&shop.at("charts/Blüten muster.png"), 1400, 1100);
    let design = files::load_design(&shop.preset()).unwrap();
    let embedded = files::embedded(&design, &Carried::default(), &shop.at("design")).unwrap();
    let [warning] = embedded.warnings.as_slice() else {
        panic!("{:?}", embedded.warnings);
    };
    assert!(
        warning.contains("the chart image has 4.4 MB") && warning.contains("Blüten muster.png"),
        "{warning}"
    );
    assert!(embedded.chunks[0].len() < 100_000);
    write_noise(&shop.at("plain.png"), 9, 7);
    let plain = fs::read(shop.at("plain.png")).unwrap();
    let picture = shop.at("picture.png");
    fs::write(&picture, png::with_chunks(plain, &embedded.chunks)).unwrap();
    let opened = files::open_design(&picture).unwrap();
    assert_eq!(opened.design.chart.pixels, None);
    assert_eq!(opened.design.light.environment.kind, EnvironmentKind::Image);
    assert!(
        opened.warnings[0].contains("opened without its chart image"),
        "{:?}",
        opened.warnings
    );
}

/// What is wrong with a bundle of these bytes.
#[track_caller]
fn refused(shop: &Workshop, bytes: &[u8], expected: &str) {
    let path = shop.at("broken.towel");
    fs::write(&path, bytes).unwrap();
    let message = files::load_design(&path).expect_err(expected).to_string();
    assert!(
        message.contains(expected) && message.contains("broken.towel"),
        "{message:?} does not tell {expected:?}"
    );
    let checked = program(&["check", path.to_str().unwrap()]);
    assert_eq!(checked.status.code(), Some(2), "{checked:?}");
}

/// Where `needle` is in `bytes`, the last time.
fn find(bytes: &[u8], needle: &[u8]) -> usize {
    let mut places = bytes.windows(needle.len());
    places.rposition(|window| window == needle).expect("there")
}

#[test]
fn broken_bundles_are_refused_with_what_is_wrong() {
    let shop = Workshop::new();
    let (path, _) = shop.bundle();
    let good = fs::read(&path).unwrap();
    refused(&shop, b"", "is no bundle");
    refused(&shop, b"format = 1\n", "is no bundle");
    refused(
        &shop,
        &good[..good.len() - 30],
        "is no bundle, or one that was cut off",
    );
    refused(&shop, &good[good.len() / 2..], "is no bundle");
    // A bit of the packed preset.
    let mut flipped = good.clone();
    flipped[30 + 11 + 40] ^= 1;
    refused(&shop, &flipped, "preset.toml");
    // The directory's first entry: of the preset.
    let entry = find(&good, b"preset.toml") - 46;
    assert_eq!(good[entry..entry + 4], *b"PK\x01\x02");
    let changed = |offset: usize, bytes: &[u8]| {
        let mut changed = good.clone();
        changed[entry + offset..][..bytes.len()].copy_from_slice(bytes);
        changed
    };
    refused(&shop, &changed(8, &[1, 8]), "Password required");
    refused(&shop, &changed(10, &[12, 0]), "is broken: its preset.toml");
    refused(&shop, &changed(24, &[0xff; 4]), "has 4294967295 bytes");
    refused(
        &shop,
        &changed(42, &[0xfe; 4]),
        "is broken: its preset.toml",
    );
    refused(&shop, &changed(46, b"another.tom"), "it has no preset.toml");
    // Cut anywhere, changed anywhere: a message or the same design, never a panic.
    for at in (0..good.len()).step_by(5) {
        let mut changed = good.clone();
        changed[at] ^= 0x55;
        fs::write(&path, changed).unwrap();
        let _ = files::load_design(&path);
        fs::write(&path, &good[..at]).unwrap();
        assert!(files::load_design(&path).is_err(), "cut off at {at}");
    }
}

/// A zip archive of stored members, made by nobody we trust.
pub(crate) fn archive(members: &[(&str, &[u8])]) -> Vec<u8> {
    let (mut file, mut directory) = (Vec::new(), Vec::new());
    for (name, bytes) in members {
        let offset = file.len() as u32;
        let mut shared = vec![20, 0, 0, 8, 0, 0, 0, 0, 0x21, 0];
        shared.extend(checksum(bytes).to_le_bytes());
        shared.extend((bytes.len() as u32).to_le_bytes());
        shared.extend((bytes.len() as u32).to_le_bytes());
        shared.extend((name.len() as u16).to_le_bytes());
        shared.extend([0; 2]);
        file.extend(b"PK\x03\x04");
        file.extend(&shared);
        file.extend(name.as_bytes());
        file.extend(*bytes);
        directory.extend(b"PK\x01\x02\x14\x00");
        directory.extend(&shared);
        directory.extend([0; 10]);
        directory.extend(offset.to_le_bytes());
        directory.extend(name.as_bytes());
    }
    let start = file.len() as u32;
    let count = (members.len() as u16).to_le_bytes();
    file.extend(&directory);
    file.extend(b"PK\x05\x06\0\0\0\0");
    file.extend(count);
    file.extend(count);
    file.extend((directory.len() as u32).to_le_bytes());
    file.extend(start.to_le_bytes());
    file.extend([0; 2]);
    file
}

/// CRC-32 bit by bit.
fn checksum(bytes: &[u8]) -> u32 {
    let mut rest = u32::MAX;
    for byte in bytes {
        rest ^= u32::from(*byte);
        for _ in 0..8 {
            rest = (rest >> 1) ^ (0xedb8_8320 * (rest & 1));
        }
    }
    !rest
}

#[test]
fn hostile_bundles_reach_nothing_outside() {
    let shop = Workshop::new();
    let secret = shop.at("charts/Blüten muster.png");
    let image = fs::read(&secret).unwrap();
    let secret = secret.to_str().unwrap();
    for (name, expected) in [
        ("../charts/Blüten muster.png", "the bundle does not hold it"),
        (secret, "the bundle does not hold it"),
        ("missing.png", "the bundle does not hold it"),
    ] {
        let preset = format!("format = 1\nchart.image = {name:?}\n");
        let bundle = archive(&[("preset.toml", preset.as_bytes())]);
        refused(&shop, &bundle, expected);
    }
    // A member with a name that leads out is an image like others: nothing is unpacked into folders.
    let preset = b"format = 1\nchart.image = \"../../evil.png\"\n";
    let bundle = archive(&[("preset.toml", preset), ("../../evil.png", &image)]);
    fs::write(shop.at("evil.towel"), bundle).unwrap();
    let opened = files::open_design(&shop.at("evil.towel")).unwrap();
    let to = shop.at("elsewhere/deep.toml");
    files::save(&opened.design, &opened.carried, &to, None).unwrap();
    assert!(shop.at("elsewhere/evil.png").is_file());
    assert!(!shop.at("evil.png").exists() && !shop.at("../evil.png").exists());

    let preset: &[u8] = b"format = 1\n";
    let names: Vec<String> = (0..1001).map(|n| n.to_string()).collect();
    let many: Vec<(&str, &[u8])> = names.iter().map(|n| (n.as_str(), preset)).collect();
    refused(&shop, &archive(&many), "has 1001 members");
    // A preset that would be a bomb: small when packed, 17 MB unpacked.
    let spaces = vec![b' '; 17 << 20];
    refused(
        &shop,
        &archive(&[("preset.toml", &spaces)]),
        "has 17825792 bytes, allowed are at most 16777216",
    );
    // Faults are reported with the place in the bundle's preset.
    let faulty = archive(&[("preset.toml", b"format = 1\n[sheet]\nwarps = -1\n")]);
    refused(&shop, &faulty, "broken.towel/preset.toml:3:");
    let newer = archive(&[("preset.toml", b"format = 2\n")]);
    refused(&shop, &newer, "format");
}

#[test]
fn a_bomb_is_not_unpacked_beyond_what_it_says() {
    let shop = Workshop::new();
    // 64 MiB of zeros in 64 kB, whose size is given as 100 bytes.
    let zeros = vec![0; 64 << 20];
    let mut chart = flate2_of(&zeros);
    let preset: &[u8] = b"format = 1\nchart.image = \"c.png\"\n";
    let mut bundle = archive(&[("preset.toml", preset), ("c.png", &chart)]);
    let entry = find(&bundle, b"PK\x01\x02");
    bundle[entry + 10] = 8;
    bundle[entry + 24..entry + 28].copy_from_slice(&100_u32.to_le_bytes());
    refused(
        &shop,
        &bundle,
        "is broken: its c.png: File is larger than its declared",
    );
    chart.truncate(1000);
    let mut bundle = archive(&[("preset.toml", preset), ("c.png", &chart)]);
    let entry = find(&bundle, b"PK\x01\x02");
    bundle[entry + 10] = 8;
    bundle[entry + 24..entry + 28].copy_from_slice(&(64_u32 << 20).to_le_bytes());
    refused(&shop, &bundle, "is broken: its c.png");
}

/// Deflated, without zlib's header and checksum.
fn flate2_of(bytes: &[u8]) -> Vec<u8> {
    let mut deflater =
        flate2::write::DeflateEncoder::new(Vec::new(), flate2::Compression::default());
    std::io::Write::write_all(&mut deflater, bytes).expect("deflated");
    deflater.finish().expect("deflated")
}

#[test]
fn bundles_are_archives_that_others_open() {
    let shop = Workshop::new();
    let (path, _) = shop.bundle();
    let listed = Command::new("python3")
        .args(["-c", "import sys, zipfile; z = zipfile.ZipFile(sys.argv[1]); print(z.testzip(), z.namelist())"])
        .arg(&path)
        .output();
    // Python is no part of what tests install; where it is, it must agree.
    if let Ok(listed) = listed {
        assert_eq!(
            text(&listed.stdout).trim(),
            "None ['preset.toml', 'Blüten muster.png', 'sky.hdr']",
            "{}",
            text(&listed.stderr)
        );
    }
}

#[test]
fn shipped_presets_are_part_of_the_program() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../presets");
    let mut names = Vec::new();
    for entry in fs::read_dir(&folder).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|ending| ending == "toml") {
            let name = path.file_stem().unwrap().to_str().unwrap().to_owned();
            let shipped = Shipped::named(&name).expect("shipped").open().unwrap();
            assert_eq!(shipped.design, files::load_design(&path).unwrap());
            assert_eq!(shipped.origin, Origin::Program);
            names.push(name);
        }
    }
    names.sort();
    let shipped: Vec<_> = Shipped::all().map(|shipped| shipped.name).collect();
    assert_eq!(shipped, names);
}
