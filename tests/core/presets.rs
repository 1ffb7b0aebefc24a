//! Preset files: what is written reads back equal; every fault is found, at its line and column; `--set` paths.
//!
//! Longer than most files because it is the one list of faults a file can have.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use renderer_core::design::preset::{self, PresetFault};
use renderer_core::design::*;

fn faults(text: &str) -> Vec<PresetFault> {
    preset::parse(text).expect_err("the preset has a fault")
}

/// The only fault of a text, as `line:column path | message`.
fn the_fault(text: &str) -> String {
    let faults = faults(text);
    assert_eq!(faults.len(), 1, "{faults:?}");
    let PresetFault {
        line,
        column,
        path,
        message,
    } = &faults[0];
    format!("{line}:{column} {path} | {message}")
}

fn round_trip(design: &Design) {
    let text = preset::write(design).unwrap();
    match preset::parse(&text) {
        Ok(read) => assert_eq!(&read, design, "{text}"),
        Err(faults) => panic!("{faults:?}\n{text}"),
    }
}

#[test]
fn format_alone_is_the_default_towel() {
    assert_eq!(preset::parse("format = 1"), Ok(Design::default()));
}

#[test]
fn every_field_survives_writing_and_reading() {
    round_trip(&Design::default());
    let mut design = Design::default();
    design.sheet.warps_per_cm = 0.1 + 12.2;
    design.weave.pattern = Pattern::filled(5, 3, 9);
    design.weave.back = Back::None;
    design.chart.image = Some("a \"quoted\" näme\\.png".into());
    design.chart.fit = Fit::Tile;
    design.length.map = LengthMap::Lut;
    design.length.curve = vec![[0.0, 1.0], [1.0 / 3.0, 1e-7], [1.0, 0.5]];
    design.length.table = vec![
        LengthEntry::default(),
        LengthEntry {
            density: Some(2.5),
            kind: Some(PileKind::Cut),
            phase: Some(Phase::GradientLambert),
            lean_x: Some(-12.5),
            lean_y: Some(0.0),
            tilt: Some(1.0 / 3.0),
            top_width: Some(2.25),
            yarn_diameter: Some(0.4),
            transmission: Some(0.125),
            specular: Some(1.0),
            exponent: Some(17.5),
            ..LengthEntry::default()
        },
    ];
    design.pile.phase = Phase::KajiyaKay;
    design.turbulence.seed = u32::MAX;
    design.light.sun.clear();
    design.light.area = vec![AreaLight {
        elevation: -12.5,
        colour: Colour([1, 2, 3]),
        ..AreaLight::default()
    }];
    design.light.environment.kind = EnvironmentKind::Image;
    design.light.environment.image = Some("../skies/noon #2.hdr".into());
    design.light.environment.rotation = -12.5;
    design.view.cameras.push(CameraDesign {
        name: "near # not a comment".into(),
        target: [1e6, -0.25, 1e-9],
        orthographic_height: Some(12.0),
        ..CameraDesign::default()
    });
    assert_eq!(design.faults(), []);
    round_trip(&design);
}

#[test]
fn hand_editors_find_units_ranges_and_rows() {
    let text = preset::write(&Design::default()).unwrap();
    let lines = [
        "format = 1",
        "lean_x        = 0.0          # °, -75 to 75: Lean of all loops along the weft: the nap.",
        "    [7, 0],",
        "    [0, 7],",
        "# image    =            # Path of the image, relative to the preset: PNG, JPEG, WebP, GIF, BMP, \
         TIFF, TGA or PPM, by its colour profile or as sRGB. Each palette entry is a yarn: of two with \
         one colour the second is changed by the smallest step. No image means one colour.",
        "[[light.sun]]",
    ];
    for line in lines {
        assert!(
            text.lines().any(|l| l == line),
            "no line {line:?} in\n{text}"
        );
    }
}

#[test]
fn format_must_be_there_and_known() {
    let missing = "1:1 format | format is missing, required is a line \"format = 1\"";
    assert!(the_fault("").starts_with(missing));
    let newer = "2:10 format | format is 2, newer than this program";
    assert!(the_fault("# x\nformat = 2").starts_with(newer));
    let others = [("0", "0"), ("'1'", "'1'"), ("1.0", "1.0")];
    for (written, shown) in others {
        assert_eq!(
            the_fault(&format!("format = {written}")),
            format!("1:10 format | format is {shown}, allowed is 1")
        );
    }
}

#[test]
fn each_fault_has_its_place_value_and_what_is_allowed() {
    #[rustfmt::skip]
    let cases = [
        ("[pile]\nlayers = 'many'", "3:10 pile.layers | pile.layers is 'many', allowed is a whole number from 1 to 64"),
        ("[pile]\nlayers = 2.0", "3:10 pile.layers | pile.layers is 2.0, allowed is a whole number from 1 to 64"),
        ("[pile]\ntilt=200", "3:6 pile.tilt | pile.tilt is 200, allowed is 0 to 180 °"),
        ("[pile]\ntilt = -1e400", "3:8 pile.tilt | pile.tilt is -1e400, allowed is 0 to 180 °"),
        ("[pile]\nkind = 'x'", "3:8 pile.kind | pile.kind is 'x', allowed is \"terry\", \"cut\", \"twisted\", \"fur\" \
            or \"grass\""),
        ("[view]\nexposure = nan", "3:12 view.exposure | view.exposure is nan, allowed is -16 to 16 EV"),
        ("[view]\nexposure = -inf", "3:12 view.exposure | view.exposure is -inf, allowed is -16 to 16 EV"),
        ("[skeleton]\nvisible = 1", "3:11 skeleton.visible | skeleton.visible is 1, allowed is true or false"),
        ("[chart]\ncolour = '#12345'", "3:10 chart.colour | chart.colour is '#12345', allowed is \"#rrggbb\""),
        ("[chart]\nimage = 3", "3:9 chart.image | chart.image is 3, allowed is text in quotes"),
        ("pile = 3", "2:8 pile | pile is 3, allowed is a table of kind, "),
        ("[turbulence]\nseed = 4294967296", "3:8 turbulence.seed | turbulence.seed is 4294967296, allowed is a whole \
            number from 0 to 4294967295"),
        ("[turbulence]\nseed = -1", "3:8 turbulence.seed | turbulence.seed is -1, allowed is a whole number from 0 to \
            4294967295"),
        ("light.sun = [{ elevation = 5 }, { elevation = 91 }]", "2:47 light.sun[1].elevation | light.sun[1].elevation \
            is 91, allowed is -90 to 90 °"),
        ("[[view.cameras]]\ntarget = [0, 1]", "3:10 view.cameras[0].target | view.cameras[0].target is [0, 1], \
            allowed is a list of 3 numbers"),
        ("[[view.cameras]]\ntarget = [0, 1, inf]", "3:17 view.cameras[0].target[2] | view.cameras[0].target[2] is \
            inf, allowed is a number"),
        ("[[view.cameras]]\ntarget = [0, 1, 2e6]", "3:17 view.cameras[0].target[2] | view.cameras[0].target[2] is \
            2000000, allowed is -1000000 to 1000000 mm"),
        ("[[view.cameras]]\n[[view.cameras]]\nname = 'default'", "4:8 view.cameras[1].name | view.cameras[1].name is \
            \"default\", allowed is a name that no other camera has"),
        ("[length]\nmap = 'lut'\n[[length.table]]\ndensity = -3", "5:11 length.table[0].density | \
            length.table[0].density is -3, allowed is 0 to 1000000 /mm"),
        ("[length]\nmap = 'lut'\n[[length.table]]\nexponent = 0.5", "5:12 length.table[0].exponent | \
            length.table[0].exponent is 0.5, allowed is 1 to 500"),
        ("[length]\ncurve = [[0, 0], [1, 1], [0.5, 1]]", "3:26 length.curve[2] | length.curve[2] is [0.5, 1], allowed \
            is [brightness, share], each 0 to 1, brightness rising"),
        ("[weave]\npattern = [\n  [7, 0],\n  [0, 5],\n]", "5:7 weave.pattern[1][1] | weave.pattern[1][1] is 5, \
            allowed is 0 (weft over), 1 (warp over), 7 (loop on the front), 8 (loop on the back) or 9 (loops on both)"),
        ("[weave]\npattern = [[7, 0], [0]]", "3:11 weave.pattern | weave.pattern: row 1 of the pattern has 1 cells, \
            but row 0 has 2"),
        ("[weave]\npattern = []", "3:11 weave.pattern | weave.pattern: the pattern has 0 rows of 0 cells, allowed are \
            1 to 512 of each"),
        ("[weave]\npattern = 7", "3:11 weave.pattern | weave.pattern is 7, allowed is a list of rows of equal length, \
            each cell 0 (weft over), "),
        ("[weave]\nback='pattern'\npattern = '''\n7 0'''", "4:11 weave.pattern | weave.pattern is ''' …, allowed is a \
            list of rows of equal length, each cell 0 (weft over), "),
        // Both are in range, but not together; the fault stands where the field is written.
        ("[length]\nmax = 2\nmin = 3", "4:7 length.min | length.min is 3, allowed is at most length.max, 2"),
        ("[length]\nmin = 9", "3:7 length.min | length.min is 9, allowed is at most length.max, 3.5"),
        ("[length]\nvalue = 90\n[pile]\nmax_length = 100", "5:14 pile.max_length | pile.max_length is 100, allowed is \
            a length with which loops reach at most 60 cells"),
        // Not written at all: the fault stands at the nearest table that is.
        ("[length]\nvalue = 90\n[pile]\nwarn = 1", "5:1 pile.warn | pile.warn is not a field"),
        ("[length]\nmap = 'lut'", "2:1 length.table | length.table is empty, allowed is at least one row when \
            length.map is \"lut\""),
    ];
    for (text, expected) in cases {
        let text = format!("format = 1\n{text}");
        let found = the_fault(&text);
        assert!(
            found.starts_with(expected),
            "{text}\ngives    {found}\ninstead of {expected}"
        );
    }
}

#[test]
fn columns_count_characters_not_bytes() {
    let places: Vec<_> = faults("format = 1\nview = { tone_map = 'ä', exposure = 77 }")
        .into_iter()
        .map(|fault| (fault.line, fault.column, fault.path))
        .collect();
    let expected = [
        (2, 21, "view.tone_map".to_owned()),
        (2, 37, "view.exposure".to_owned()),
    ];
    assert_eq!(places, expected);
}

#[test]
fn unknown_fields_are_refused_with_the_likely_name() {
    #[rustfmt::skip]
    let cases = [
        ("[pile]\ntlit = 3", "3:1 pile.tlit | pile.tlit is not a field; did you mean pile.tilt? Fields of pile are \
            kind, "),
        ("[pile]\nseed = 3", "3:1 pile.seed | pile.seed is not a field; did you mean turbulence.seed? "),
        ("[pille]", "2:2 pille | pille is not a field; did you mean pile? Fields of a preset are sheet, weave, chart, \
            "),
        ("[weave]\nqqqqqq = 3", "3:1 weave.qqqqqq | weave.qqqqqq is not a field. Fields of weave are back, pattern"),
        ("[[light.sun]]\nheight = 3", "3:1 light.sun[0].height | light.sun[0].height is not a field; did you mean \
            skeleton.height? "),
        ("[chart]\npixels = 3", "3:1 chart.pixels | chart.pixels is not a field"),
    ];
    for (text, expected) in cases {
        let found = the_fault(&format!("format = 1\n{text}"));
        assert!(
            found.starts_with(expected),
            "{text}\ngives    {found}\ninstead of {expected}"
        );
    }
}

#[test]
fn fields_of_earlier_programs_are_read_and_ignored_with_a_word() {
    let old = |traced: &str, cached: &str| {
        format!(
            "format = 1\n[quality]\ntraced_bounces = {traced}\nsamples = 9\ncached_shadows = {cached}\n"
        )
    };
    let mut expected = Design::default();
    expected.quality.samples = 9;
    let (design, notes) = preset::parse_noting(&old("1", "8")).unwrap();
    assert_eq!(design, expected);
    let notes: Vec<_> = notes.iter().map(ToString::to_string).collect();
    assert_eq!(
        notes,
        [
            "3:18: quality.traced_bounces is ignored: whether bounces are estimated is up to the view, not to the \
             design",
            "5:18: quality.cached_shadows is ignored: whether shadows are shared is up to the view, not to the design"
        ]
    );
    // Earlier programs wrote every field; what was switched off is as it was.
    assert_eq!(
        preset::parse_noting(&old("0", "0")),
        Ok((expected.clone(), vec![]))
    );
    // Other faults are found beside them.
    let faults = faults("format = 1\nquality.traced_bounces = 'x'\nquality.bounces = 0");
    assert_eq!(faults.len(), 1, "{faults:?}");
    assert_eq!(faults[0].path, "quality.bounces");
    // Whoever sets one hears that it does nothing, and it is not written any more.
    let error = preset::set(&expected, "quality.traced_bounces", "1").unwrap_err();
    assert!(
        error
            .message
            .starts_with("quality.traced_bounces is not a field any more: ")
    );
    assert!(!preset::write(&expected).unwrap().contains("traced_bounces"));
}

#[test]
fn every_image_of_a_design_has_its_row() {
    // Every optional text field called `image` is in the table, and nothing else is.
    let text = preset::write(&Design::default()).unwrap();
    let mut section = "";
    let mut fields = vec![];
    for line in text.lines() {
        if let Some(name) = line
            .strip_prefix('[')
            .and_then(|line| line.strip_suffix(']'))
        {
            section = name.trim_matches(['[', ']']);
        } else if line.split_whitespace().take(2).eq(["#", "image"]) {
            fields.push(format!("{section}.image"));
        }
    }
    let mut slots = ImageSlot::ALL.map(ImageSlot::field).to_vec();
    fields.sort();
    slots.sort_unstable();
    assert_eq!(fields, slots);

    for slot in ImageSlot::ALL {
        let pixels = match slot.kind() {
            PixelKind::Colours => ChartImage::filled(1, 1, [9; 4]).map(ImagePixels::Colours),
            PixelKind::Heights => HeightImage::new(1, 1, vec![7]).map(ImagePixels::Heights),
            PixelKind::Light => {
                let mut reader = EnvironmentReader::new(2, 1).unwrap();
                (0..2).for_each(|x| reader.add(x, 0, [0.5; 3]));
                reader.finish().ok().map(ImagePixels::Light)
            }
        };
        assert!(pixels.is_some());
        let mut design = preset::set(&Design::default(), &slot.field(), "a.png").unwrap();
        assert_eq!(slot.path(&design), Some("a.png"));
        slot.set_pixels(&mut design, pixels.clone());
        slot.show(&mut design);
        assert_eq!(
            (slot.pixels(&design), slot.has_pixels(&design)),
            (pixels, true)
        );
        assert_eq!(design.faults(), []);
        for other in ImageSlot::ALL {
            assert_eq!(other.has_pixels(&design), other == slot);
        }
        // A field that names another file leaves no pixels; another field leaves them.
        let bent = preset::set(&design, "pile.tilt", "3").unwrap();
        assert!(slot.has_pixels(&bent));
        assert!(!slot.has_pixels(&preset::set(&design, &slot.field(), "b.png").unwrap()));
        slot.leave_out(&mut design);
        assert_eq!(design, Design::default());
    }
}

#[test]
fn all_faults_are_found_at_once_in_the_order_of_lines() {
    let text = "format = 1
[view]
exposure = nan
[[light.sun]]
elevation = 100
[[light.sun]]
azimuth = 'x'
[pile]
kind = 7
tlit = 3
plies = 0
[weave]
pattern = [[7, 5], [3, 0]]
";
    let places: Vec<_> = faults(text)
        .into_iter()
        .map(|fault| format!("{}:{} {}", fault.line, fault.column, fault.path))
        .collect();
    let expected = [
        "3:12 view.exposure",
        "5:13 light.sun[0].elevation",
        "7:11 light.sun[1].azimuth",
        "9:8 pile.kind",
        "10:1 pile.tlit",
        "11:9 pile.plies",
        "13:16 weave.pattern[0][1]",
        "13:21 weave.pattern[1][0]",
    ];
    assert_eq!(places, expected);
}

#[test]
fn broken_toml_is_reported_with_its_place() {
    assert_eq!(
        the_fault("format = 1\n[pile\n"),
        "2:6  | not TOML: unclosed table, expected `]`"
    );
    assert_eq!(
        the_fault("format = 1\r\n[pile]\r\ntilt = 3\r\ntilt = 4\r\n"),
        "4:1  | not TOML: duplicate key"
    );
}

#[test]
fn set_changes_the_field_it_names_and_no_other() {
    let old = Design::default();
    let check = |path: &str, value: &str, change: &dyn Fn(&mut Design)| {
        let mut expected = old.clone();
        change(&mut expected);
        assert_ne!(expected, old, "{path}");
        assert_eq!(
            preset::set(&old, path, value),
            Ok(expected),
            "{path}={value}"
        );
    };
    check("pile.tilt", "30", &|d| d.pile.tilt = 30.0);
    check("pile.layers", "5", &|d| d.pile.layers = 5);
    check("skeleton.visible", "false", &|d| d.skeleton.visible = false);
    check("light.sun[0].elevation", "-7.5", &|d| {
        d.light.sun[0].elevation = -7.5;
    });
    check("light.sun", "[]", &|d| d.light.sun.clear());
    check("light.area", "[{ distance = 500 }]", &|d| {
        d.light.area = vec![AreaLight {
            distance: 500.0,
            ..AreaLight::default()
        }];
    });
    check("light.environment.radiance", "2", &|d| {
        d.light.environment.radiance = 2.0;
    });
    check("light.environment.kind", "gradient", &|d| {
        d.light.environment.kind = EnvironmentKind::Gradient;
    });
    check("light.environment.zenith", "#0080ff", &|d| {
        d.light.environment.zenith = Colour([0, 128, 255]);
    });
    check("light.environment.image", "sky.hdr", &|d| {
        d.light.environment.image = Some("sky.hdr".into());
    });
    check("view.cameras[0].orthographic_height", "12", &|d| {
        d.view.cameras[0].orthographic_height = Some(12.0);
    });
    check("view.cameras[0].target[2]", "4", &|d| {
        d.view.cameras[0].target[2] = 4.0;
    });
    for filmic in ["filmic", "\"filmic\""] {
        check("view.tone_map", filmic, &|d| {
            d.view.tone_map = ToneMap::Filmic;
        });
    }
    check("chart.colour", "#ff0080", &|d| {
        d.chart.colour = Colour([255, 0, 128]);
    });
    for image in ["2024", "my chart.png"] {
        check("chart.image", image, &|d| {
            d.chart.image = Some(image.into());
        });
    }
    check("weave.pattern", "[[7, 8, 9]]", &|d| {
        d.weave.pattern = Pattern::try_from(vec![vec![7, 8, 9]]).unwrap();
    });
    check("weave.pattern[0][1]", "9", &|d| {
        d.weave.pattern.set(1, 0, 9);
    });
    check("length.table", "[{ length = 2 }]", &|d| {
        d.length.table = vec![LengthEntry {
            length: 2.0,
            ..LengthEntry::default()
        }];
    });
}

#[test]
fn set_refuses_what_a_file_may_not_say() {
    #[rustfmt::skip]
    let cases = [
        ("pile.tilt", "x", "pile.tilt is x, allowed is 0 to 180 °"),
        ("pile.tilt", "nan", "pile.tilt is nan, allowed is 0 to 180 °"),
        ("pile.tilt", "", "pile.tilt is , allowed is 0 to 180 °"),
        ("pile.tlit", "3", "pile.tlit is not a field; did you mean pile.tilt?"),
        ("pile", "3", "pile is a table, name one of its fields: kind, "),
        ("sheet.warps", "3\nwefts = 2", "sheet.warps is 3 …, allowed is a whole number"),
        ("view.tone_map", "film", "view.tone_map is film, allowed is \"none\" or \"filmic\""),
        ("weave.pattern[0][1]", "5", "weave.pattern[0][1] is 5, allowed is 0 (weft over)"),
        ("weave.pattern", "[[7, 0], [0]]", "row 1 of the pattern has 1 cells, but row 0 has 2"),
        ("light.sun[1].elevation", "1", "there is no light.sun[1]: light.sun has 1 elements, counted from 0"),
        ("light.sun.elevation", "1", "light.sun is a list, write light.sun[0].elevation"),
        ("light.sun", "[{ elevaton = 1 }]", "light.sun[0].elevaton is not a field; did you mean \
            light.sun[0].elevation?"),
        ("length.table[0].length", "1", "length.table is empty"),
        ("pile.tilt[0]", "1", "pile.tilt is not a list"),
        ("pile.tilt.x", "1", "pile.tilt has no fields"),
        ("a..b", "1", "a path is written section.field or section.list[0].field"),
        ("light.sun[x]", "1", "a path is written"),
        ("chart.pixels", "1", "chart.pixels is not a field"),
        ("format", "1", "format is not a field"),
    ];
    for (path, value, expected) in cases {
        let error = preset::set(&Design::default(), path, value).expect_err(path);
        assert!(
            error.message.starts_with(expected),
            "{path}={value}\ngives    {}\ninstead of {expected}",
            error.message
        );
    }
}

#[test]
fn set_keeps_the_chart_unless_it_names_another() {
    let mut design = Design::default();
    design.chart.image = Some("a.png".into());
    design.chart.pixels = ChartImage::new(1, 1, &[[1, 2, 3, 4]]);
    let tilted = preset::set(&design, "pile.tilt", "3").unwrap();
    assert_eq!(tilted.chart.pixels, design.chart.pixels);
    let other = preset::set(&design, "chart.image", "b.png").unwrap();
    assert_eq!(other.chart.pixels, None);
}

fn at_top(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(name)
}

#[test]
fn the_reference_lists_every_field_as_the_code_has_it() {
    const BEGIN: &str = "<!-- preset reference: begin -->\n";
    const END: &str = "<!-- preset reference: end -->\n";
    let path = at_top("presets/README.md");
    let page = fs::read_to_string(&path).unwrap();
    let (before, rest) = page.split_once(BEGIN).unwrap();
    let (found, after) = rest.split_once(END).unwrap();
    let expected = reference();
    if found != expected && std::env::var_os("UPDATE_SNAPSHOTS").is_some() {
        fs::write(&path, format!("{before}{BEGIN}{expected}{END}{after}")).unwrap();
        return;
    }
    assert!(
        found == expected,
        "the reference in presets/README.md is not what the code says; write it anew with UPDATE_SNAPSHOTS=true"
    );
}

/// The preset reference in Markdown: a table for each section.
fn reference() -> String {
    // A design in which every list has an element to take defaults from.
    let mut design = Design::default();
    design.length.table.push(LengthEntry::default());
    design.light.area.push(AreaLight::default());
    design.chart.object.push(ChartObject::default());
    design.chart.yarn.push(NamedYarn::default());
    let defaults = toml::Table::try_from(&design).unwrap();
    let Shape::Table(sections) = Design::shape() else {
        panic!("a design is a table");
    };
    let mut text = String::from(
        "\nA preset begins with `format = 1`. Every field may be left out and then has its default; lengths are in \
         mm, angles\nin degrees, colours `\"#rrggbb\"` (sRGB). `--set` names fields by the same paths, as in `--set \
             light.sun[0].elevation=30`.\n",
    );
    for section in &sections {
        let Shape::Table(fields) = &section.shape else {
            panic!("{} is a table", section.name);
        };
        let heading = format!("[{}]", section.name);
        let values = defaults[section.name].as_table().unwrap();
        reference_table(
            &mut text,
            &heading,
            section.name,
            section.what,
            fields,
            values,
        );
    }
    text + "\n"
}

fn reference_table(
    text: &mut String,
    heading: &str,
    path: &str,
    what: &str,
    fields: &[Entry],
    values: &toml::Table,
) {
    let _ = write!(
        text,
        "\n### `{heading}`\n\n{what}\n\n| field | default | allowed | unit | meaning |\n| --- | --- | --- | --- | --- \
         |\n"
    );
    let mut tables = Vec::new();
    for field in fields {
        let path = format!("{path}.{}", field.name);
        match (&field.shape, values.get(field.name)) {
            (Shape::Table(fields), Some(toml::Value::Table(values))) => {
                tables.push((format!("[{path}]"), path, field.what, fields, values));
                continue;
            }
            (Shape::List { of, .. }, Some(toml::Value::Array(elements))) => {
                if let (Shape::Table(fields), Some(toml::Value::Table(values))) =
                    (&**of, elements.first())
                {
                    tables.push((format!("[[{path}]]"), path, field.what, fields, values));
                    continue;
                }
            }
            _ => {}
        }
        let (allowed, unit) = match &field.shape {
            Shape::Number(number) => {
                let whole = if number.integer { "whole, " } else { "" };
                let unit = if number.unit.is_empty() {
                    "–"
                } else {
                    number.unit
                };
                (format!("{whole}{} to {}", number.min, number.max), unit)
            }
            shape => (shape.allowed(), "–"),
        };
        let default = match values.get(field.name) {
            Some(value) => format!("`{value}`"),
            None => "left out".into(),
        };
        let _ = writeln!(
            text,
            "| `{}` | {default} | {allowed} | {unit} | {} |",
            field.name, field.what
        );
    }
    for (heading, path, what, fields, values) in tables {
        reference_table(text, &heading, &path, what, fields, values);
    }
}

#[test]
fn no_text_makes_the_reader_panic_or_blame_a_place_that_is_not_there() {
    let sound = preset::write(&Design::default()).unwrap();
    let pieces = [
        "[",
        "]",
        "[[",
        "{",
        "}",
        "=",
        "\"",
        "'''",
        "\n",
        "nan",
        "-1e999",
        "9999999999999999999999",
        "ä",
        "#",
        ".",
        ",",
        "\u{0}",
        "0x7f",
        "1979-05-27",
        "true",
        "pattern",
        "light.sun",
        "\r",
        "\u{feff}",
    ];
    // Any fixed sequence will do.
    let mut state = 1_u64;
    let mut random = |below: usize| {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % below
    };
    let mut refused = 0;
    for _ in 0..1500 {
        let mut text: Vec<char> = sound.chars().collect();
        for _ in 0..=random(3) {
            let (at, length) = (random(text.len()), random(12));
            let until = (at + length).min(text.len());
            let piece = pieces[random(pieces.len())].chars();
            text.splice(at..until, piece);
        }
        let text: String = text.into_iter().collect();
        let Err(faults) = preset::parse(&text) else {
            continue;
        };
        refused += 1;
        assert!(!faults.is_empty());
        let lines: Vec<&str> = text.split('\n').collect();
        for fault in faults {
            let line = lines.get(fault.line - 1);
            let columns = line.map_or(0, |line| line.chars().count() + 1);
            assert!((1..=columns).contains(&fault.column), "{fault} in\n{text}");
            assert!(!fault.message.contains('\n'), "{fault}");
        }
    }
    assert!(refused > 500, "only {refused} of 1500 were damaged");
    // Deep nesting ends in a fault, not in a stack overflow.
    for open in ["[", "{a="] {
        let deep = format!("format = 1\nx = {}", open.repeat(100_000));
        assert!(!faults(&deep).is_empty());
    }
}

#[test]
fn a_byte_order_mark_and_windows_line_ends_do_no_harm() {
    let text = preset::write(&Design::default()).unwrap();
    let windows = format!("\u{feff}{}", text.replace('\n', "\r\n"));
    assert_eq!(preset::parse(&windows), Ok(Design::default()));
}
