//! Objects on a chart: where each is drawn, at which size on the cloth, and that all that looks at a design sees the
//! same.

use std::borrow::Cow;

use renderer_core::design::chart_edit::BARE;
use renderer_core::design::chart_objects::{ChartCanvas, GlyphPath, draw_objects};
use renderer_core::design::{
    Chart, ChartImage, ChartObject, Colour, Design, Fit, ObjectKind, Sheet, preset,
};
use renderer_core::scene::{ChartComposer, ChartYarns, Scene, compile};

const RED: [u8; 4] = [200, 30, 30, 255];
const CREAM: [u8; 4] = [250, 250, 240, 255];
const NAVY: [u8; 4] = [20, 30, 90, 255];

/// 10 × 10 cm of cloth, twice as dense one way as the other: pixels of 1 × 0.5 mm.
const SHEET: Sheet = Sheet {
    warps: 100,
    wefts: 200,
    warps_per_cm: 10.0,
    wefts_per_cm: 20.0,
};

fn object(kind: ObjectKind) -> ChartObject {
    ChartObject {
        kind,
        colour: Colour([200, 30, 30]),
        width: 20.0,
        height: 20.0,
        ..ChartObject::default()
    }
}

fn drawn(objects: &[ChartObject]) -> ChartImage {
    let mut image = ChartImage::filled(100, 200, CREAM).unwrap();
    draw_objects(&mut image, objects, &ChartCanvas::of_sheet(&SHEET));
    image
}

/// The pixels of a colour.
fn of(image: &ChartImage, colour: [u8; 4]) -> Vec<[usize; 2]> {
    let rows = 0..image.height();
    rows.flat_map(|y| (0..image.width()).map(move |x| [x, y]))
        .filter(|[x, y]| image.pixel(*x, *y) == colour)
        .collect()
}

/// First and last column and row.
fn reach(pixels: &[[usize; 2]]) -> [[usize; 2]; 2] {
    let axis = |k: usize| {
        let all = || pixels.iter().map(|pixel| pixel[k]);
        [all().min().unwrap(), all().max().unwrap()]
    };
    [axis(0), axis(1)]
}

#[test]
fn shapes_have_their_size_on_the_cloth() {
    let red = |object: &ChartObject| of(&drawn(std::slice::from_ref(object)), RED);
    let rectangle = ChartObject {
        x: 10.0,
        y: -20.0,
        ..object(ObjectKind::Rectangle)
    };
    // 20 mm are 20 columns and 40 rows; 10 mm right of the middle, 20 mm towards the near edge.
    let pixels = red(&rectangle);
    assert_eq!(reach(&pixels), [[50, 69], [120, 159]]);
    assert_eq!(pixels.len(), 20 * 40);

    let ellipse = red(&object(ObjectKind::Ellipse));
    assert_eq!(
        reach(&ellipse),
        [[40, 59], [80, 119]],
        "a circle on the cloth"
    );
    let area = std::f64::consts::PI / 4.0 * 20.0 * 40.0;
    assert!(
        (ellipse.len() as f64 - area).abs() < 0.02 * area,
        "{}",
        ellipse.len()
    );

    let across = ChartObject {
        x: 40.0,
        y: 30.0,
        height: 5.0,
        ..object(ObjectKind::StripeAcross)
    };
    assert_eq!(reach(&red(&across)), [[0, 99], [35, 44]]);
    assert_eq!(red(&across).len(), 100 * 10);
    let along = ChartObject {
        x: -30.0,
        width: 5.0,
        rotation: 30.0,
        ..object(ObjectKind::StripeAlong)
    };
    assert_eq!(red(&along).len(), 200 * 5, "stripes do not turn");

    // A frame of 2 mm.
    let frame = ChartObject {
        border: 2.0,
        ..object(ObjectKind::Rectangle)
    };
    assert_eq!(red(&frame).len(), 20 * 40 - 16 * 32);
    // Thinner than a crossing, a line has no gaps.
    let line = ChartObject {
        width: 80.0,
        height: 0.1,
        rotation: 30.0,
        ..object(ObjectKind::Line)
    };
    let columns: std::collections::HashSet<usize> = red(&line).iter().map(|[x, _]| *x).collect();
    assert!(columns.len() >= 68, "{}", columns.len());
}

#[test]
fn objects_are_turned_mirrored_repeated_and_reflected() {
    // A triangle that fills the lower left half of its box.
    let corner = ChartObject {
        outline: Some("M 0 0 L 10 0 L 0 10 Z".into()),
        ..object(ObjectKind::Text)
    };
    let image = drawn(std::slice::from_ref(&corner));
    let is_red = |image: &ChartImage, [x, y]: [f64; 2]| {
        let [column, row] = ChartCanvas::of_sheet(&SHEET).pixel_at([x, y]);
        image.pixel(column as usize, row as usize) == RED
    };
    let quarters = [[-6.0, -6.0], [6.0, -6.0], [6.0, 6.0], [-6.0, 6.0]];
    let filled = |object: &ChartObject| {
        let image = drawn(std::slice::from_ref(object));
        quarters.map(|place| is_red(&image, [place[0] * 0.9, place[1] * 0.9]))
    };
    assert!(is_red(&image, [-8.0, -8.0]) && !is_red(&image, [8.0, 8.0]));
    let with = |change: fn(&mut ChartObject)| {
        let mut changed = corner.clone();
        change(&mut changed);
        changed
    };
    let mirrored = with(|object| object.mirror_x = true);
    assert!(is_red(&drawn(&[mirrored]), [8.0, -8.0]));
    let upper_left = [-8.0, 6.0];
    assert!(is_red(&image, upper_left));
    assert!(!is_red(
        &drawn(&[with(|object| object.mirror_x = true)]),
        upper_left
    ));
    // Turned by a quarter, anticlockwise, the lower left corner is the lower right one.
    assert!(is_red(
        &drawn(&[with(|object| object.rotation = 90.0)]),
        [8.0, -8.0]
    ));
    assert_ne!(
        filled(&corner),
        filled(&with(|object| object.rotation = 180.0))
    );

    let mut stripe = object(ObjectKind::StripeAcross);
    (stripe.y, stripe.height) = (40.0, 2.0);
    (stripe.repeat_y, stripe.step_y, stripe.reflect_y) = (3, -5.0, true);
    let rows: Vec<usize> = of(&drawn(&[stripe]), RED)
        .iter()
        .filter(|[x, _]| *x == 0)
        .map(|[_, y]| *y)
        .collect();
    let from_far = [18_usize, 28, 38].map(|row| row..row + 4);
    let from_near = from_far
        .clone()
        .map(|rows| 200 - rows.end..200 - rows.start);
    let mut expected: Vec<usize> = from_far.into_iter().chain(from_near).flatten().collect();
    expected.sort_unstable();
    assert_eq!(rows, expected);
}

#[test]
fn pictures_keep_their_yarns_and_leave_out_the_transparent_colour() {
    let picture = ChartImage::from_fn(4, 2, |x, y| match (x, y) {
        (0, 0) => NAVY,
        (1, _) => BARE,
        (2, 1) => [254, 255, 255, 255],
        (3, _) => [255; 4],
        _ => RED,
    });
    let mut logo = ChartObject {
        pixels: picture,
        height: 10.0,
        ..object(ObjectKind::Image)
    };
    let image = drawn(std::slice::from_ref(&logo));
    // 5 × 10 pixels each.
    assert_eq!(reach(&of(&image, NAVY)), [[40, 44], [90, 99]]);
    assert_eq!(of(&image, RED).len(), 2 * 50);
    assert_eq!(of(&image, [255; 4]).len(), 2 * 50);
    logo.transparent = Some(Colour::WHITE);
    logo.tolerance = 0.0;
    let image = drawn(std::slice::from_ref(&logo));
    assert_eq!(of(&image, [255; 4]), Vec::<[usize; 2]>::new());
    assert_eq!(of(&image, [254, 255, 255, 255]).len(), 50, "another colour");
    logo.tolerance = 0.05;
    let image = drawn(std::slice::from_ref(&logo));
    assert_eq!(of(&image, [254, 255, 255, 255]), Vec::<[usize; 2]>::new());
    logo.rotation = 180.0;
    let turned = drawn(std::slice::from_ref(&logo));
    assert_eq!(reach(&of(&turned, NAVY)), [[55, 59], [100, 109]]);

    // Many pixels on one: their mean light, or the one in its middle.
    let stripes = ChartImage::from_fn(
        160,
        160,
        |x, _| if x % 2 == 0 { [0, 0, 0, 255] } else { [255; 4] },
    );
    let mut photo = ChartObject {
        pixels: stripes,
        ..object(ObjectKind::Image)
    };
    let colours = |photo: &ChartObject| {
        let image = drawn(std::slice::from_ref(photo));
        let inside = (45..55).flat_map(|x| (90..110).map(move |y| [x, y]));
        inside
            .map(|[x, y]| image.pixel(x, y)[0])
            .collect::<Vec<_>>()
    };
    assert!(colours(&photo).iter().all(|value| [0, 255].contains(value)));
    photo.average = true;
    assert!(
        colours(&photo)
            .iter()
            .all(|value| (150..220).contains(value)),
        "half the light"
    );
    photo.opacity = 0.0;
    assert!(colours(&photo).iter().all(|value| *value == CREAM[0]));
}

#[test]
fn what_lies_higher_hides_and_opacity_mixes() {
    let rectangle = object(ObjectKind::Rectangle);
    let mut above = ChartObject {
        colour: Colour([20, 30, 90]),
        ..object(ObjectKind::Ellipse)
    };
    let both = drawn(&[rectangle.clone(), above.clone()]);
    let [red, navy] = [RED, NAVY].map(|colour| of(&both, colour).len());
    assert_eq!(red + navy, 20 * 40);
    above.opacity = 0.5;
    let mixed = drawn(&[rectangle.clone(), above.clone()]);
    assert_eq!(of(&mixed, NAVY).len(), 0);
    assert_eq!(of(&mixed, RED).len(), red);
    let seen = mixed.pixel(50, 100);
    assert!(
        (NAVY[0]..RED[0]).contains(&seen[0]) && seen != RED,
        "{seen:?}"
    );
    above.opacity = 1.0;
    above.bare = true;
    assert_eq!(of(&drawn(&[rectangle, above]), BARE).len(), navy);
}

/// Whether as many loops stand in both, of the same colours.
fn alike(a: &Scene, b: &Scene) -> bool {
    a.loops.counts == b.loops.counts && *a.looks == *b.looks
}

fn towel() -> Design {
    let mut design = Design {
        sheet: SHEET,
        ..Design::default()
    };
    design.chart.pixels =
        ChartImage::from_fn(10, 4, |x, y| if (x + y) % 2 == 0 { CREAM } else { NAVY });
    design
}

#[test]
fn a_scene_sees_objects_as_if_they_were_painted() {
    let mut composer = ChartComposer::default();
    for fit in [Fit::Stretch, Fit::Tile, Fit::Place] {
        for average in [false, true] {
            let mut design = towel();
            (design.chart.fit, design.chart.average) = (fit, average);
            assert!(matches!(composer.design(&design), Cow::Borrowed(_)));
            let plain = compile(&design).unwrap();
            design.chart.object = vec![ChartObject {
                width: 3.0,
                height: 2.0,
                ..object(ObjectKind::Rectangle)
            }];
            let composed = composer.design(&design).into_owned();
            assert_eq!(composed.chart.object, []);
            let scene = compile(&design).unwrap();
            assert!(
                alike(&scene, &compile(&composed).unwrap()),
                "{fit:?} {average}"
            );
            assert!(!alike(&scene, &plain), "{fit:?} {average}");
            // Of no effect on the cloth are objects beside it, whatever the chart is made of.
            design.chart.object[0].x = 500.0;
            let beside = compile(&design).unwrap();
            assert!(alike(&beside, &plain), "{fit:?} {average}");
        }
    }
}

#[test]
fn objects_alone_lie_on_cloth_of_one_colour_and_count_as_yarns() {
    let mut design = Design {
        sheet: SHEET,
        ..Design::default()
    };
    design.chart.colour = Colour([250, 250, 240]);
    design.chart.fit = Fit::Place;
    design.chart.object = vec![ChartObject {
        height: 25.0,
        ..object(ObjectKind::StripeAcross)
    }];
    design.chart.guides_x = vec![3.0];
    let yarns = ChartYarns::default().of_design(&design).unwrap();
    let shares: Vec<_> = yarns
        .iter()
        .map(|yarn| (yarn.colour, yarn.pixels))
        .collect();
    assert_eq!(shares, [(CREAM, 15_000), (RED, 5_000)]);
    let chart = ChartComposer::default().chart(&design);
    assert_eq!((chart.guides_x, chart.fit), (vec![], Fit::Stretch));

    // What was drawn is kept, and shared where it is the same.
    let mut composer = ChartComposer::default();
    let first = composer.chart(&design).pixels.unwrap();
    assert!(composer.chart(&design).pixels.unwrap().is(&first));
    design.chart.object[0].y += 0.5;
    let moved = composer.chart(&design).pixels.unwrap();
    assert_ne!(moved, first);
}

#[test]
fn outlines_of_letters_are_read_as_they_are_written() {
    let text = "M 0 0 L 100 0 Q 120 50 100 100 C 80 120 20 120 0 100 Z M 20 20 L 20 40 L 40 40 Z";
    let path = GlyphPath::read(text).unwrap();
    assert_eq!(path.write(), text);
    let bounds = path.bounds().unwrap();
    assert_eq!((bounds.low, bounds.size()), ([0.0, 0.0], [110.0, 115.0]));
    for (text, what) in [
        ("L 0 0", "L at its beginning"),
        ("M 0", "M without numbers"),
        ("M 0 x", "\"x\" for a number"),
        ("M 0 NaN", "\"NaN\" for a number"),
        ("M 0 0 A 1 1", "\"A\""),
    ] {
        assert_eq!(GlyphPath::read(text), Err(what.into()), "{text}");
    }
    // What winds the other way is a hole.
    let ring = ChartObject {
        outline: Some("M 0 0 L 4 0 L 4 4 L 0 4 Z M 1 1 L 1 3 L 3 3 L 3 1 Z".into()),
        ..object(ObjectKind::Text)
    };
    assert_eq!(of(&drawn(&[ring]), RED).len(), 20 * 40 * 3 / 4);
}

#[test]
fn presets_keep_objects_and_say_what_is_wrong_with_them() {
    let mut design = towel();
    design.chart.pixels = None;
    design.chart.guides_y = vec![-12.5];
    design.chart.object = vec![
        object(ObjectKind::StripeAlong),
        ChartObject {
            kind: ObjectKind::Image,
            image: Some("logo.png".into()),
            transparent: Some(Colour::WHITE),
            ..ChartObject::default()
        },
    ];
    let text = preset::write(&design).unwrap();
    assert!(
        text.contains("[[chart.object]]") && text.contains("= \"stripe_along\""),
        "{text}"
    );
    assert_eq!(preset::parse(&text).unwrap(), design);
    let moved = preset::set(&design, "chart.object[0].x", "2 cm").unwrap();
    assert_eq!(moved.chart.object[0].x, 20.0);
    let faults = preset::parse(
        "format = 1\n[[chart.object]]\nkind = \"circle\"\nopacity = 2\noutline = \"M 1\"",
    )
    .unwrap_err();
    let messages: Vec<String> = faults.iter().map(ToString::to_string).collect();
    assert!(
        messages[0].contains("3:8") && messages[0].contains("ellipse"),
        "{messages:?}"
    );
    assert!(
        messages[1].contains("chart.object[0].opacity is 2, allowed is 0 to 1"),
        "{messages:?}"
    );
    assert!(
        messages[2].contains("chart.object[0].outline is M without numbers"),
        "{messages:?}"
    );
    let too_many = Chart {
        object: vec![ChartObject::default(); ChartObject::MAX + 1],
        ..Chart::default()
    };
    let faults = Design {
        chart: too_many,
        ..Design::default()
    }
    .faults();
    assert_eq!(faults[0].path, "chart.object");
    let warned = Design {
        chart: Chart {
            object: vec![object(ObjectKind::Image)],
            ..Chart::default()
        },
        ..Design::default()
    };
    assert!(
        warned
            .warnings()
            .iter()
            .any(|warning| warning.path == "chart.object[0]")
    );
}
