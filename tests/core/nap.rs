//! Nap maps: loops lie as the map says, and combs lay them the way they go.

use renderer_core::design::nap_edit::{
    UPRIGHT, comb, direction, footprints, pixel, smoothed, stripes, upright,
};
use renderer_core::design::{Back, ChartImage, Design, Fit, Pattern};
use renderer_core::scene::{Face, compile};

/// Upright loops on both faces, and a map over them.
fn napped(width: usize, height: usize, pixels: &[[u8; 4]], fit: Fit) -> Design {
    let mut design = Design::default();
    (design.sheet.warps, design.sheet.wefts) = (12, 8);
    design.weave.pattern = Pattern::filled(1, 1, 7);
    design.weave.back = Back::Mirror;
    let pile = &mut design.pile;
    (pile.layers, pile.resolution, pile.variants) = (2, 6, 1);
    (pile.tilt, pile.jitter, pile.lean_x, pile.lean_y) = (0.0, 0.0, 0.0, 0.0);
    design.nap.pixels = ChartImage::new(width, height, pixels);
    design.nap.fit = fit;
    design.nap.strength = 30.0;
    design
}

/// Lean of the loop of a cell along the weft and the warp, degrees.
fn lean(design: &Design, cell: [u32; 2], face: Face) -> [f64; 2] {
    let scene = compile(design).unwrap();
    let index = scene.loops.loop_at(cell, face).unwrap();
    let [x, y, z] = scene.loops.patch(index as usize).axis.map(f64::from);
    let angle = x.hypot(y).atan2(z.abs()).to_degrees();
    let across = x.hypot(y).max(1e-12);
    [angle * x / across, angle * y / across]
}

#[track_caller]
fn assert_leans(design: &Design, cell: [u32; 2], expected: [f64; 2]) {
    let found = lean(design, cell, Face::Front);
    // A map's step is 30°/127, and half a unit of length turns a loop by less than 0.01°.
    let close = [0, 1].map(|k| (found[k] - expected[k]).abs() < 0.13);
    assert!(close[0] && close[1], "{cell:?}: {found:?} not {expected:?}");
}

#[test]
fn loops_of_the_front_lie_as_the_map_says() {
    // Above: to the right, away; below: to the left, towards the near edge.
    let pixels = [
        [255, 128, 0, 255],
        [128, 255, 0, 255],
        [1, 128, 0, 255],
        [128, 1, 0, 255],
    ];
    let design = napped(2, 2, &pixels, Fit::Stretch);
    for (cell, expected) in [
        ([0, 7], [30.0, 0.0]),
        ([11, 7], [0.0, 30.0]),
        ([0, 0], [-30.0, 0.0]),
        ([11, 0], [0.0, -30.0]),
        // A map that covers the cloth is smooth between its pixels: halfway in a cell of the middle.
        ([5, 7], [30.0 * 7.0 / 12.0, 30.0 * 5.0 / 12.0]),
    ] {
        assert_leans(&design, cell, expected);
        assert_eq!(lean(&design, cell, Face::Back), [0.0; 2], "the front alone");
    }
    // Pixel by pixel, again and again.
    let design = napped(2, 2, &pixels, Fit::Tile);
    for (cell, expected) in [
        ([0, 7], [30.0, 0.0]),
        ([3, 5], [0.0, 30.0]),
        ([6, 0], [-30.0, 0.0]),
    ] {
        assert_leans(&design, cell, expected);
    }
    // Once, in the middle; beside it, and where it is transparent, the pile's own lean.
    let mut pixels = pixels;
    pixels[1][3] = 0;
    let mut design = napped(2, 2, &pixels, Fit::Place);
    design.pile.lean_y = 10.0;
    for (cell, expected) in [
        ([0, 0], [0.0, 10.0]),
        ([5, 3], [-30.0, 10.0]),
        ([6, 4], [0.0, 10.0]),
    ] {
        assert_leans(&design, cell, expected);
    }
    design.nap.strength = 0.0;
    assert_leans(&design, [5, 3], [0.0, 10.0]);
}

#[test]
fn a_map_is_no_input_where_it_does_nothing() {
    use renderer_core::scene::Compiler;
    let mut compiler = Compiler::default();
    let mut design = napped(1, 1, &[UPRIGHT], Fit::Stretch);
    design.nap.pixels = None;
    let before = compiler.compile(&design).unwrap();
    design.nap.strength = 12.0;
    design.nap.fit = Fit::Tile;
    let after = compiler.compile(&design).unwrap();
    assert!(std::sync::Arc::ptr_eq(&before, &after));
    design.nap.pixels = ChartImage::filled(1, 1, [255, 128, 255, 255]);
    let mapped = compiler.compile(&design).unwrap();
    let same = mapped.same_sections(&after);
    // Looks follow loops; they are found equal.
    assert_eq!(same, [true, false, true, true, true, true, true, true]);
}

#[test]
fn directions_are_written_as_they_are_read() {
    for k in 0..64 {
        let (sin, cos) = (f64::from(k) * 0.1).sin_cos();
        let way = [0.9 * cos, 0.9 * sin];
        let read = direction(pixel(way));
        assert!(
            (0..2).all(|k| (read[k] - way[k]).abs() <= 0.5 / 127.0 + 1e-12),
            "{way:?} {read:?}"
        );
    }
    assert_eq!(direction(UPRIGHT), [0.0; 2]);
    assert_eq!(direction([255, 0, 0, 127]), [0.0; 2], "transparent");
    assert_eq!(direction(pixel([5.0, 0.0])), [1.0, 0.0]);
}

#[test]
fn a_comb_lays_pile_the_way_it_goes() {
    let blank = ChartImage::filled(60, 40, UPRIGHT).unwrap();
    let mut map = blank.clone();
    comb(&mut map, [10.0, 20.0], [50.0, 20.0], 12.0);
    assert_eq!(
        direction(map.pixel(30, 20)).map(|v| (v * 10.0).round()),
        [10.0, 0.0]
    );
    let edge = direction(map.pixel(30, 24))[0];
    assert!(edge > 0.05 && edge < 0.7, "{edge}");
    assert_eq!(map.pixel(30, 27), UPRIGHT);
    assert_eq!(map.pixel(2, 20), UPRIGHT);
    // Up the picture is away from the near edge; combing the other way brushes it over.
    let mut map = blank.clone();
    comb(&mut map, [30.0, 35.0], [30.0, 5.0], 12.0);
    assert!(direction(map.pixel(30, 20))[1] > 0.95);
    comb(&mut map, [30.0, 5.0], [30.0, 35.0], 12.0);
    assert!(direction(map.pixel(30, 20))[1] < -0.95);
    // Beyond the map, and over no way at all.
    let mut map = blank.clone();
    comb(&mut map, [-500.0, -40.0], [-400.0, -30.0], 9.0);
    comb(&mut map, [3.0, 3.0], [3.0, 3.0], 9.0);
    assert_eq!(map, blank);
}

#[test]
fn ready_maps_are_stripes_and_steps() {
    let mut design = Design::default();
    (design.sheet.warps, design.sheet.wefts) = (300, 220);
    (design.sheet.warps_per_cm, design.sheet.wefts_per_cm) = (2.5, 2.5);
    let blank = upright(&design.sheet).unwrap();
    assert_eq!([blank.width(), blank.height()], [300, 220]);
    let striped = stripes(&blank, &design.sheet);
    let ways: Vec<f64> = (0..300)
        .map(|x| direction(striped.pixel(x, 110))[1])
        .collect();
    let turns = ways
        .windows(2)
        .filter(|pair| pair[0] * pair[1] < 0.0)
        .count();
    // 1.2 m have four lanes of 280 mm and a bit.
    assert!((3..=6).contains(&turns), "{turns}");
    let laid = ways.iter().filter(|way| way.abs() > 0.9).count();
    assert!(laid > 240, "most of a lane lies all the way: {laid}");

    let trodden = footprints(&striped, &design.sheet);
    let changed = |x: usize, y: usize| trodden.pixel(x, y) != striped.pixel(x, y);
    let count = (0..220)
        .flat_map(|y| (0..300).map(move |x| (x, y)))
        .filter(|&(x, y)| changed(x, y))
        .count();
    // Two soles of 285 × 105 mm, two thirds of their box, 16 mm² a pixel.
    let expected = 2.0 * 285.0 * 105.0 / 16.0 * 0.66;
    assert!(
        (count as f64 - expected).abs() < 0.25 * expected,
        "{count} not {expected}"
    );

    let smooth = smoothed(&striped);
    let step = |map: &ChartImage| {
        let way = |x| direction(map.pixel(x, 110))[1];
        (0..299)
            .map(|x| f64::abs(way(x + 1) - way(x)))
            .fold(0.0, f64::max)
    };
    assert!(step(&smooth) < 0.8 * step(&striped));
}
