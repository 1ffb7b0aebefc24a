//! What comes from strangers and what goes to them: images outside the folder of the file that names them are opened
//! only where that is allowed, and no file that is handed on tells of the machine it was made on.

use std::fs;
use std::path::PathBuf;
use std::process::{Command, Output};

use renderer_core::design::ImageSlot;
use tempfile::TempDir;
use towel_designer::files::{self, Carried, FileError, KnownOutside, Outside, Reading};

use crate::support::png;

const HEAD: &str = "format = 1\nsheet = { warps = 12, wefts = 10 }\n\
                    quality = { method = 'single', bounces = 1, samples = 1 }\n";

/// A folder `in` with presets, a folder `out` that is none of theirs, and a user.
struct Bench(TempDir);

impl Bench {
    fn new() -> Self {
        let bench = Self(TempDir::new().unwrap());
        for folder in ["in", "in/deep", "out", "config"] {
            fs::create_dir(bench.at(folder)).unwrap();
        }
        for (name, red) in [
            ("in/near.png", 10),
            ("in/deep/near.png", 20),
            ("out/far.png", 30),
        ] {
            image::RgbImage::from_pixel(4, 4, image::Rgb([red, 99, 200]))
                .save(bench.at(name))
                .unwrap();
        }
        bench
    }

    fn at(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn preset(&self, name: &str, more: &str) -> PathBuf {
        let path = self.at(name);
        fs::write(&path, format!("{HEAD}{more}\n")).unwrap();
        path
    }

    fn run(&self, arguments: &[&str]) -> Output {
        Command::new(env!("CARGO_BIN_EXE_towel-designer"))
            .current_dir(self.0.path())
            .env("XDG_CONFIG_HOME", self.at("config"))
            .env("HOME", self.0.path())
            .args(arguments)
            .output()
            .unwrap()
    }

    fn far(&self) -> String {
        self.at("out/far.png").to_str().unwrap().to_owned()
    }
}

fn errors(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[test]
fn images_of_the_own_folder_open_and_others_do_not() {
    let bench = Bench::new();
    let known = KnownOutside::default();
    let open = |image: &str| {
        let path = bench.preset("in/a.toml", &format!("chart.image = {image:?}"));
        let outside = Outside::Known(&known);
        let reading = Reading {
            outside,
            ..Reading::default()
        };
        files::read_design(&path, reading)
    };
    let near = bench.at("in/near.png");
    for image in [
        "near.png",
        "./near.png",
        "deep/near.png",
        near.to_str().unwrap(),
    ] {
        let opened = open(image).unwrap_or_else(|error| panic!("{image}: {error}"));
        assert!(opened.design.chart.pixels.is_some());
        assert_eq!(opened.outside, []);
    }
    // Not even looked for: who asks a host whether it has a file has said who they are.
    let whole = "/nowhere/at/all.png";
    let around = format!("{}/../out/far.png", bench.at("in").display());
    for image in [
        "../out/far.png",
        "deep/../../out/far.png",
        "..\\out\\far.png",
        "\\\\host\\share\\far.png",
        &bench.far(),
        whole,
        &around,
    ] {
        let Err(FileError::Outside { path, images }) = open(image) else {
            panic!("{image} was opened");
        };
        assert_eq!(path, bench.at("in/a.toml"));
        assert_eq!(
            (images[0].slot, images[0].name.as_str()),
            (ImageSlot::Chart, image)
        );
    }
}

#[test]
fn every_image_is_asked_about_and_can_be_left_out() {
    let bench = Bench::new();
    let far = bench.far();
    let path = bench.preset(
        "in/a.toml",
        &format!(
            "chart.image = 'near.png'\nnap.image = {far:?}\n\
             form = {{ kind = 'height', image = {far:?} }}\n\
             light.environment = {{ kind = 'image', image = '../out/sky.hdr' }}"
        ),
    );
    let known = KnownOutside::default();
    let read = |outside| {
        files::read_design(
            &path,
            Reading {
                outside,
                ..Reading::default()
            },
        )
    };
    let Err(FileError::Outside { images, .. }) = read(Outside::Known(&known)) else {
        panic!("opened");
    };
    let slots: Vec<_> = images.iter().map(|image| image.slot).collect();
    assert_eq!(
        slots,
        [ImageSlot::Nap, ImageSlot::Environment, ImageSlot::Height]
    );
    let opened = read(Outside::LeaveOut).unwrap();
    assert_eq!(opened.left_out, images);
    for slot in ImageSlot::ALL {
        assert_eq!(slot.has_pixels(&opened.design), slot == ImageSlot::Chart);
    }
    assert!(opened.design.faults().is_empty());
}

#[test]
fn the_command_line_wants_a_flag() {
    let bench = Bench::new();
    bench.preset("in/a.toml", "chart.image = '../out/far.png'");
    let commands = [
        "render in/a.toml -o a.png --size 8x8 --backend cpu",
        "check in/a.toml",
        "export loops in/a.toml -o a.json",
        "export volume in/a.toml -o volume",
        "export turbulence in/a.toml -o a.exr",
    ];
    for command in commands {
        let mut arguments: Vec<&str> = command.split(' ').collect();
        let refused = bench.run(&arguments);
        assert_eq!(refused.status.code(), Some(2), "{command}");
        let message = errors(&refused);
        for part in [
            "in/a.toml: ",
            "chart.image = \"../out/far.png\"",
            "--allow-outside-images",
        ] {
            assert!(message.contains(part), "{command}: {message}");
        }
        arguments.push("--allow-outside-images");
        let done = bench.run(&arguments);
        assert!(done.status.success(), "{command}: {}", errors(&done));
    }
    // What is asked for at the command line itself is allowed.
    bench.preset("in/b.toml", "");
    let far = format!("chart.image={}", bench.far());
    let set = "render in/b.toml -o b.png --size 8x8 --backend cpu --set";
    let mut arguments: Vec<&str> = set.split(' ').collect();
    arguments.push(&far);
    let done = bench.run(&arguments);
    assert!(done.status.success(), "{}", errors(&done));
}

#[test]
fn what_the_user_saved_or_allowed_is_known() {
    let bench = Bench::new();
    let path = bench.preset("in/a.toml", "chart.image = '../out/far.png'");
    let config = bench.at("config/towel-designer");
    let opens = || bench.run(&["check", "in/a.toml"]).status.success();
    assert!(!opens());
    let opened = files::open_design(&path).unwrap();
    KnownOutside::note(&config, &path, &opened.outside).unwrap();
    assert!(opens());
    // The same file with another image is another matter; and so is another file.
    fs::write(bench.at("out/other.png"), fs::read(bench.far()).unwrap()).unwrap();
    bench.preset("in/a.toml", "chart.image = '../out/other.png'");
    assert!(!opens());
    bench.preset("in/b.toml", "chart.image = '../out/far.png'");
    assert!(!bench.run(&["check", "in/b.toml"]).status.success());
    // Saved by the user.
    let design = files::load_design(&bench.at("in/b.toml")).unwrap();
    let to = bench.at("in/c.toml");
    files::save(
        &design,
        &Carried::default(),
        &to,
        Some(&bench.at("in/b.toml")),
    )
    .unwrap();
    KnownOutside::note_saved(&config, &to);
    assert!(bench.run(&["check", "in/c.toml"]).status.success());
    // A list that is no list is no list of anything.
    fs::write(config.join(KnownOutside::FILE), "file = 3").unwrap();
    assert!(!bench.run(&["check", "in/c.toml"]).status.success());
}

/// Every file in which `needle` stands, packed or not, is one too many.
fn tells(bytes: &[u8], needle: &str) -> bool {
    bytes
        .windows(needle.len())
        .any(|part| part == needle.as_bytes())
}

#[test]
fn nothing_that_is_handed_on_tells_of_the_machine() {
    let bench = Bench::new();
    // Images of every kind, one of them too large for a picture.
    let mut state = 1_u32;
    let noise = image::RgbImage::from_fn(1400, 1100, |_, _| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let [_, a, b, c] = state.to_le_bytes();
        image::Rgb([a, b, c])
    });
    noise.save(bench.at("out/large.png")).unwrap();
    let (far, large) = (bench.far(), bench.at("out/large.png"));
    let large = large.to_str().unwrap();
    let path = bench.preset(
        "in/a.toml",
        &format!("chart.image = {large:?}\nnap.image = {far:?}\nform = {{ kind = 'height', image = {large:?} }}"),
    );
    let design = files::load_design(&path).unwrap();
    let embedded = files::embedded(&design, &Carried::default(), &bench.at("in")).unwrap();
    assert_eq!(embedded.warnings.len(), 2);
    let place = bench.0.path().to_str().unwrap();
    for warning in &embedded.warnings {
        assert!(
            warning.contains("save a bundle to keep it") && !warning.contains(place),
            "{warning}"
        );
    }
    let picture = bench.at("picture.png");
    let plain = fs::read(bench.at("in/near.png")).unwrap();
    fs::write(&picture, png::with_chunks(plain, &embedded.chunks)).unwrap();
    let bundle = bench.at("bundle.towel");
    files::save(&design, &Carried::default(), &bundle, Some(&path)).unwrap();
    for file in [&picture, &bundle] {
        assert!(
            !tells(&fs::read(file).unwrap(), place),
            "{}",
            file.display()
        );
    }
    // The text is packed: what it says is seen once it is opened.
    let opened = files::open_design(&picture).unwrap();
    assert_eq!(opened.warnings.len(), 2, "{:?}", opened.warnings);
    assert!(opened.design.nap.pixels.is_some() && opened.design.chart.pixels.is_none());
    for warning in &opened.warnings {
        assert!(!warning.contains("/out/"), "{warning}");
    }
    let opened = files::open_design(&bundle).unwrap();
    for slot in ImageSlot::ALL {
        assert!(
            slot.path(&opened.design)
                .is_none_or(|name| !name.contains('/'))
        );
    }
}

/// A JPEG of a photograph: turned, with a place, an edit, a comment, and more behind its end.
fn photograph() -> Vec<u8> {
    let mut pixels = Vec::new();
    let noise = image::RgbImage::from_fn(24, 16, |x, y| {
        image::Rgb([(9 * x) as u8, (15 * y) as u8, 40])
    });
    image::codecs::jpeg::JpegEncoder::new_with_quality(&mut pixels, 95)
        .encode_image(&noise)
        .unwrap();
    // Orientation 6 (turned right) and a text that is its maker's name, SECRET.
    let tiff = b"MM\0*\0\0\0\x08\0\x02\x01\x0f\0\x02\0\0\0\x07\0\0\0\x26\x01\x12\0\x03\0\0\0\x01\0\x06\0\0\0\0\0\0SECRET\0";
    let mut file = pixels[..2].to_vec();
    let mut segment = |marker: u8, data: &[u8]| {
        file.extend([0xff, marker]);
        file.extend((data.len() as u16 + 2).to_be_bytes());
        file.extend(data);
    };
    segment(0xe1, &[b"Exif\0\0", &tiff[..]].concat());
    segment(0xe1, b"http://ns.adobe.com/xap/1.0/\0<x:SECRET/>");
    segment(0xed, b"Photoshop 3.0\0SECRET");
    segment(0xfe, b"SECRET");
    file.extend(&pixels[2..]);
    file.extend(b"SECRET");
    file
}

#[test]
fn images_that_are_handed_on_say_nothing_beside_their_pixels() {
    let bench = Bench::new();
    fs::write(bench.at("in/photo.jpg"), photograph()).unwrap();
    // A chart that is a picture of ours, with a design of its own and a title.
    bench.preset("in/SECRET.toml", "");
    let render = "render in/SECRET.toml -o in/ours.png --size 24x16 --backend cpu";
    assert!(
        bench
            .run(&render.split(' ').collect::<Vec<_>>())
            .status
            .success()
    );
    assert!(tells(&fs::read(bench.at("in/ours.png")).unwrap(), "SECRET"));
    for (name, turned) in [("photo.jpg", true), ("ours.png", false)] {
        let path = bench.preset("in/a.toml", &format!("chart.image = '{name}'"));
        let design = files::load_design(&path).unwrap();
        let chart = design.chart.pixels.as_ref().unwrap();
        assert_eq!(chart.width() < chart.height(), turned, "{name}");
        let bundle = bench.at("bundle.towel");
        files::save(&design, &Carried::default(), &bundle, Some(&path)).unwrap();
        let opened = files::open_design(&bundle).unwrap();
        assert_eq!(opened.design.chart.pixels, design.chart.pixels, "{name}");
        let handed_on = opened.carried.get(name).expect("the same kind of file");
        assert!(
            !tells(handed_on, "SECRET") && !tells(handed_on, "toWl"),
            "{name}"
        );
    }
}

#[test]
fn a_picture_goes_without_its_design_where_that_is_asked_for() {
    let bench = Bench::new();
    bench.preset("in/a.toml", "chart.image = 'near.png'");
    for (name, more, carries) in [("a.png", "", true), ("b.png", "--no-design", false)] {
        let render = format!("render in/a.toml -o {name} --size 8x8 --backend cpu {more}");
        let done = bench.run(&render.split_whitespace().collect::<Vec<_>>());
        assert!(done.status.success(), "{}", errors(&done));
        assert_eq!(files::carries_design(&bench.at(name)), carries);
    }
    let pixels = |name: &str| image::open(bench.at(name)).unwrap().into_rgb8();
    assert_eq!(pixels("a.png"), pixels("b.png"));
}

#[test]
fn pictures_say_how_large_they_are_what_they_show_and_what_made_them() {
    let bench = Bench::new();
    bench.preset("in/Möwe.toml", "");
    bench.preset("in/海鸥.toml", "");
    let render = |preset: &str, output: &str, more: &[&str]| {
        let arguments = [
            "render",
            preset,
            "-o",
            output,
            "--size",
            "8x8",
            "--backend",
            "cpu",
        ];
        let done = bench.run(&[&arguments, more].concat());
        assert!(done.status.success(), "{}", errors(&done));
    };
    let info = |name: &str| {
        let file = std::io::BufReader::new(fs::File::open(bench.at(name)).unwrap());
        png_info(file)
    };
    render("in/Möwe.toml", "a.png", &["--dpi", "300"]);
    let of = info("a.png");
    // 300 pixels in 25.4 mm.
    assert_eq!(of.dots, Some((11_811, 11_811)));
    assert!(of.is_srgb);
    let software = concat!("Towel Designer ", env!("CARGO_PKG_VERSION"));
    assert_eq!(
        of.texts,
        [
            ("Title".into(), "Möwe".into()),
            ("Software".into(), software.into())
        ]
    );
    render("in/海鸥.toml", "b.png", &[]);
    let of = info("b.png");
    assert_eq!((of.dots, of.is_srgb), (None, true));
    assert!(
        of.texts.contains(&("Title".into(), "海鸥".into())),
        "{:?}",
        of.texts
    );

    render("in/海鸥.toml", "c.exr", &["--dpi", "72.5"]);
    let meta = exr::prelude::MetaData::read_from_file(bench.at("c.exr"), true).unwrap();
    let header = &meta.headers[0];
    assert_eq!(header.own_attributes.horizontal_density, Some(72.5));
    let primaries = header.shared_attributes.chromaticities.unwrap();
    assert_eq!((primaries.red.0, primaries.white.1), (0.64, 0.329));
    let text =
        |text: &Option<exr::prelude::Text>| text.as_ref().map(|text| text.as_slice().to_vec());
    assert_eq!(
        text(&header.own_attributes.software_name),
        Some(software.as_bytes().to_vec())
    );
    // A picture of a design from a picture is called as that is.
    fs::rename(bench.at("a.png"), bench.at("other.png")).unwrap();
    render("other.png", "a.png", &["--dpi", "300"]);
    assert!(fs::read(bench.at("a.png")).unwrap() == fs::read(bench.at("other.png")).unwrap());

    let refused = bench.run(&["render", "in/Möwe.toml", "-o", "d.png", "--dpi", "0"]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(
        errors(&refused).contains("1 to 100000"),
        "{}",
        errors(&refused)
    );
}

/// What a PNG says of itself.
struct PngInfo {
    dots: Option<(u32, u32)>,
    is_srgb: bool,
    texts: Vec<(String, String)>,
}

fn png_info(mut file: impl std::io::Read) -> PngInfo {
    let mut bytes = Vec::new();
    file.read_to_end(&mut bytes).unwrap();
    let mut info = PngInfo {
        dots: None,
        is_srgb: false,
        texts: Vec::new(),
    };
    let mut rest = &bytes[8..];
    while rest.len() >= 12 {
        let length = u32::from_be_bytes(rest[..4].try_into().unwrap()) as usize;
        let (kind, data) = (&rest[4..8], &rest[8..8 + length]);
        let number = |at: usize| u32::from_be_bytes(data[at..at + 4].try_into().unwrap());
        let cut = |data: &[u8]| data.iter().position(|byte| *byte == 0).unwrap();
        match kind {
            b"pHYs" => {
                assert_eq!(data[8], 1, "metres");
                info.dots = Some((number(0), number(4)));
            }
            b"sRGB" => info.is_srgb = true,
            b"tEXt" => {
                let end = cut(data);
                let latin = |bytes: &[u8]| bytes.iter().map(|byte| char::from(*byte)).collect();
                info.texts
                    .push((latin(&data[..end]), latin(&data[end + 1..])));
            }
            b"iTXt" => {
                let end = cut(data);
                let text = String::from_utf8(data[end + 5..].to_vec()).unwrap();
                info.texts
                    .push((String::from_utf8(data[..end].to_vec()).unwrap(), text));
            }
            _ => {}
        }
        rest = &rest[12 + length..];
    }
    info
}

#[test]
fn no_output_is_an_input_or_another_output() {
    let bench = Bench::new();
    bench.preset("in/ch.toml", "chart.image = 'near.png'");
    let chart = fs::read(bench.at("in/near.png")).unwrap();
    let refuse = |command: &str, says: &str| {
        let done = bench.run(&command.split(' ').collect::<Vec<_>>());
        let message = errors(&done);
        assert_eq!(done.status.code(), Some(2), "{command}: {message}");
        assert!(
            message.contains(says) && message.contains("choose another name"),
            "{command}: {message}"
        );
    };
    let chart_is = "in/near.png: is the chart image of the design";
    refuse("render in/ch.toml -o in/near.png --size 8x8", chart_is);
    refuse(
        "render in/ch.toml -o a.png --stats in/near.png --size 8x8",
        chart_is,
    );
    refuse(
        "render in/ch.toml -o a.png --stats in/ch.toml --size 8x8",
        "in/ch.toml: is the file of the design",
    );
    refuse(
        "render in/ch.toml -o a.png --stats a.png --size 8x8",
        "a.png: is the picture (-o)",
    );
    refuse(
        "render in/ch.toml -o a.png --stats ./A.PNG --size 8x8",
        "A.PNG: is the picture (-o)",
    );
    bench.preset("in/strange.toml", "chart.image = 'loops.json'");
    fs::copy(bench.at("in/near.png"), bench.at("in/loops.json")).unwrap();
    refuse(
        "export loops in/strange.toml -o in/loops.json",
        "in/loops.json: is the chart image",
    );
    fs::copy(bench.at("in/near.png"), bench.at("in/t.exr")).unwrap();
    bench.preset("in/strange.toml", "chart.image = 't.exr'");
    refuse(
        "export turbulence in/strange.toml -o in/t.exr",
        "in/t.exr: is the chart image",
    );
    let layer = "terry-variant-00-layer-00.png";
    fs::copy(bench.at("in/near.png"), bench.at("in").join(layer)).unwrap();
    bench.preset("in/strange.toml", &format!("chart.image = '{layer}'"));
    refuse("export volume in/strange.toml -o in", "is the chart image");
    // A picture that carries its design is the file of that design.
    let render = "render in/ch.toml -o own.png --size 8x8 --backend cpu";
    assert!(
        bench
            .run(&render.split(' ').collect::<Vec<_>>())
            .status
            .success()
    );
    refuse(
        "render own.png -o own.png --size 8x8",
        "own.png: is the file of the design",
    );
    for name in ["in/near.png", "in/loops.json", "in/t.exr"] {
        assert!(
            fs::read(bench.at(name)).unwrap() == chart,
            "{name} was written over"
        );
    }
}
