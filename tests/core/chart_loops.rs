//! How many loops show each pixel of a chart, the yarns counted by them, and loops that take the mean of the pixels
//! around them (MODEL.md §6).

use std::collections::HashMap;
use std::sync::Arc;

use proptest::prelude::*;
use renderer_core::design::chart_edit::{BARE, LoopsPerPixel, YarnCounts};
use renderer_core::design::{
    Back, Chart, ChartImage, Design, Fit, LengthMap, Pattern, STITCHES, Weave, srgb_to_linear,
};
use renderer_core::scene::{ChartOnSheet, ChartYarns, Compiler, Scene, compile};

const RED: [u8; 4] = [200, 30, 40, 255];
const NAVY: [u8; 4] = [20, 30, 90, 255];

fn weave(cols: usize, rows: usize, values: &[u8]) -> Weave {
    Weave {
        pattern: Pattern::from_fn(cols, rows, |i, j| values[j * cols + i]),
        back: Back::Pattern,
    }
}

fn checker() -> Weave {
    weave(2, 2, &[7, 0, 0, 7])
}

fn chart(image: ChartImage, fit: Fit) -> Chart {
    Chart {
        pixels: Some(image),
        fit,
        ..Chart::default()
    }
}

/// A design of so many warps and wefts.
fn design(chart: Chart, weave: Weave, [warps, wefts]: [u32; 2]) -> Design {
    let mut design = Design {
        chart,
        weave,
        ..Design::default()
    };
    (design.sheet.warps, design.sheet.wefts) = (warps, wefts);
    design
}

/// Loops on each pixel, counted one by one.
fn counted(chart: &Chart, weave: &Weave, cells: [u32; 2]) -> HashMap<[usize; 2], u64> {
    let on_sheet = ChartOnSheet::new(chart, weave, cells);
    let image = chart.pixels.as_ref().unwrap();
    let mut loops = HashMap::new();
    for j in 0..cells[1] as usize {
        for i in 0..cells[0] as usize {
            let stitch = weave.pattern.stitch(i as i64, j as i64);
            if let Some(texel) = on_sheet.texel(image, i, j) {
                *loops.entry(texel).or_default() +=
                    u64::from(stitch.front) + u64::from(stitch.back);
            }
        }
    }
    loops
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, ..ProptestConfig::default() })]

    #[test]
    fn loops_on_each_pixel_are_those_that_are_laid_there(
        (cols, rows) in (1_usize..5, 1_usize..5),
        values in prop::collection::vec(prop::sample::select(STITCHES.to_vec()), 16),
        cells in [1_u32..40, 1_u32..40],
        size in [1_usize..50, 1_usize..50],
        fit in prop::sample::select(vec![Fit::Stretch, Fit::Tile, Fit::Place]),
        [mirror_x, mirror_y, half_drop] in [any::<bool>(), any::<bool>(), any::<bool>()],
        offsets in [-30_i32..30, -30_i32..30],
    ) {
        let weave = weave(cols, rows, &values);
        let chart = Chart {
            mirror_x,
            mirror_y,
            half_drop,
            offset_x: offsets[0],
            offset_y: offsets[1],
            ..chart(ChartImage::filled(size[0], size[1], RED).unwrap(), fit)
        };
        let image = chart.pixels.as_ref().unwrap();
        let loops = ChartOnSheet::new(&chart, &weave, cells).loops_per_pixel(&weave, image);
        let expected = counted(&chart, &weave, cells);
        let mut without = 0;
        for y in 0..size[1] {
            for x in 0..size[0] {
                let expected = expected.get(&[x, y]).copied().unwrap_or(0);
                prop_assert_eq!(loops.at(x, y), expected, "pixel {}, {}", x, y);
                without += u64::from(expected == 0);
            }
        }
        let share = without as f64 / (size[0] * size[1]) as f64;
        prop_assert!((loops.share_without() - share).abs() < 1e-12);
    }
}

#[test]
fn a_checked_chart_on_a_checked_pattern_shows_one_of_its_yarns_and_says_so() {
    let checked =
        ChartImage::from_fn(20, 20, |x, y| if (x + y) % 2 == 0 { RED } else { NAVY }).unwrap();
    let design = design(chart(checked.clone(), Fit::Tile), checker(), [20, 20]);
    let mut yarns = ChartYarns::default();
    let loops = |yarns: &mut ChartYarns, design: &Design| -> HashMap<[u8; 4], u64> {
        let counts = yarns.of(design, &checked).unwrap().iter();
        counts.map(|yarn| (yarn.colour, yarn.loops)).collect()
    };
    // Row 0 of the chart is the far weft 19: there the checker has its loops at odd warps.
    assert_eq!(loops(&mut yarns, &design), [(RED, 0), (NAVY, 200)].into());
    let warning = ChartYarns::default()
        .warning(&design)
        .expect("a warning")
        .to_string();
    assert!(
        warning.contains("#c81e28 has 50 % of the pixels and no loop"),
        "{warning}"
    );

    // The pattern changed, the chart not.
    let full = Design {
        weave: weave(1, 1, &[7]),
        ..design.clone()
    };
    assert_eq!(loops(&mut yarns, &full), [(RED, 200), (NAVY, 200)].into());
    assert_eq!(ChartYarns::default().warning(&full), None);
    assert_eq!(loops(&mut yarns, &design), [(RED, 0), (NAVY, 200)].into());
}

#[test]
fn lost_lines_and_photographs_are_warned_of_and_plain_stripes_are_not() {
    let warning = |image: ChartImage, fit, cells| {
        let mut warned = design(chart(image, fit), checker(), cells);
        let warning = ChartYarns::default()
            .warning(&warned)
            .map(|w| w.to_string());
        warned.chart.average = true;
        let averaged = ChartYarns::default()
            .warning(&warned)
            .map(|w| w.to_string());
        (warning.unwrap_or_default(), averaged)
    };
    // A line of one pixel of ten that no loop's middle meets.
    let line = ChartImage::from_fn(500, 40, |x, _| if x == 3 { NAVY } else { RED }).unwrap();
    let (text, averaged) = warning(line, Fit::Stretch, [50, 50]);
    assert!(
        text.contains("#141e5a has 0.2 % of the pixels and no loop"),
        "{text}"
    );
    assert_eq!(averaged, None);
    let photograph = ChartImage::from_fn(100, 100, |x, y| [x as u8, y as u8, 0, 255]).unwrap();
    let (text, averaged) = warning(photograph.clone(), Fit::Stretch, [50, 50]);
    assert!(
        text.contains("88 % of the chart's pixels lie on no loop"),
        "{text}"
    );
    assert_eq!(averaged, None);
    let (text, _) = warning(photograph, Fit::Stretch, [200, 200]);
    assert_eq!(text, "", "each pixel has two loops");
    let stripes = ChartImage::from_fn(40, 40, |x, _| if x / 4 % 2 == 0 { NAVY } else { RED });
    let (text, _) = warning(stripes.unwrap(), Fit::Tile, [80, 80]);
    assert_eq!(text, "");
}

#[test]
fn bare_places_count_and_a_cloth_without_loops_is_not_the_charts_fault() {
    let half = ChartImage::from_fn(10, 10, |x, _| if x < 5 { BARE } else { RED }).unwrap();
    let design = design(chart(half.clone(), Fit::Tile), checker(), [10, 10]);
    let mut yarns = ChartYarns::default();
    let counts = yarns.of(&design, &half).unwrap();
    assert_eq!(
        counts.iter().map(|yarn| yarn.loops).collect::<Vec<_>>(),
        [25, 25]
    );
    let none = Design {
        weave: weave(1, 1, &[1]),
        ..design
    };
    assert_eq!(ChartYarns::default().warning(&none), None);
}

#[test]
fn painting_recounts_loops_too() {
    let mut image = ChartImage::filled(300, 200, RED).unwrap();
    let loops = |image: &ChartImage| {
        let chart = chart(image.clone(), Fit::Tile);
        Arc::new(
            ChartOnSheet::new(&chart, &checker(), [300, 200]).loops_per_pixel(&checker(), image),
        )
    };
    let mut counts = YarnCounts::default();
    let of =
        |counts: &mut YarnCounts, image: &ChartImage, loops: &Arc<LoopsPerPixel>| -> Vec<u64> {
            counts
                .of(image, loops)
                .unwrap()
                .iter()
                .map(|yarn| yarn.loops)
                .collect()
        };
    let loops = loops(&image);
    assert_eq!(of(&mut counts, &image, &loops), [30_000]);
    image.fill_row(150, 0..200, NAVY);
    assert_eq!(of(&mut counts, &image, &loops), [29_900, 100]);
    assert_eq!(
        of(&mut counts, &image, &Arc::new(LoopsPerPixel::Alike)),
        [59_800, 200]
    );
}

fn light(colour: [u8; 3]) -> f64 {
    srgb_to_linear(f64::from(colour[1]) / 255.0)
}

#[test]
fn averaged_loops_share_out_all_light_of_the_chart() {
    // Three picks: two loops in four warps, in one weft of three.
    let terry = weave(4, 3, &[1, 9, 0, 9, 1, 0, 0, 0, 0, 1, 1, 1]);
    for weave in [checker(), terry, weave(1, 1, &[7])] {
        let noise = |x: usize, y: usize| [0, (x * 91 + y * 57 + x * y * 13) as u8, 0, 255];
        let image = ChartImage::from_fn(97, 61, noise).unwrap();
        let chart = Chart {
            average: true,
            ..chart(image, Fit::Stretch)
        };
        // Whole repeats, and rectangles that the edge cuts as often on the one side as on the other.
        let [warps, wefts] = [48_u32, 36];
        let on_sheet = ChartOnSheet::new(&chart, &weave, [warps, wefts]);
        let stands = |i: u32, j: u32| weave.pattern.stitch(i.into(), j.into()).front;
        let cells = (0..wefts).flat_map(|j| (0..warps).map(move |i| (i, j)));
        let colours: Vec<f64> = cells
            .filter(|&(i, j)| stands(i, j))
            .map(|(i, j)| light(on_sheet.colour(i as usize, j as usize).unwrap()))
            .collect();
        let mean = colours.iter().sum::<f64>() / colours.len() as f64;
        let pixels = (0..61).flat_map(|y| (0..97).map(move |x| noise(x, y)));
        let expected = pixels.map(|[r, g, b, _]| light([r, g, b])).sum::<f64>() / (97.0 * 61.0);
        // Rectangles at the edges count their pixels more than others do: a sixteenth of the loops, a few per cent each.
        assert!((mean - expected).abs() < 0.01, "{mean} {expected}");
    }
}

#[test]
fn the_mean_is_of_light_and_bare_pixels_have_none() {
    let checked = ChartImage::from_fn(20, 20, |x, y| {
        if (x + y) % 2 == 0 {
            [255; 4]
        } else {
            [0, 0, 0, 255]
        }
    });
    let averaged = |image: ChartImage| Chart {
        average: true,
        ..chart(image, Fit::Stretch)
    };
    let chart = averaged(checked.unwrap());
    let on_sheet = ChartOnSheet::new(&chart, &checker(), [20, 20]);
    // Half the light of white, as sRGB has it; the rectangle is two pixels wide: one whole, two halves.
    assert_eq!(on_sheet.colour(10, 10), Some([188; 3]));
    // A quarter of the rectangle is bare, then three quarters: the colour is that of the rest.
    for (bare, colour) in [(4, Some([200, 30, 40])), (12, None)] {
        let image = ChartImage::from_fn(16, 1, |x, _| if x < bare { [0, 255, 0, 0] } else { RED });
        let chart = averaged(image.unwrap());
        let on_sheet = ChartOnSheet::new(&chart, &weave(1, 1, &[7]), [1, 1]);
        assert_eq!(on_sheet.colour(0, 0), colour);
    }
}

#[test]
fn only_stretched_charts_are_averaged_and_plain_areas_keep_their_colour() {
    let stripes = |x: usize, _| if x < 16 { RED } else { NAVY };
    let image = ChartImage::from_fn(32, 32, stripes).unwrap();
    for (fit, blends) in [
        (Fit::Stretch, true),
        (Fit::Tile, false),
        (Fit::Place, false),
    ] {
        let chart = Chart {
            average: true,
            ..chart(image.clone(), fit)
        };
        let on_sheet = ChartOnSheet::new(&chart, &checker(), [32, 32]);
        assert_eq!(on_sheet.colour(3, 3), Some([200, 30, 40]));
        assert_eq!(on_sheet.colour(30, 3), Some([20, 30, 90]));
        // Two pixels wide around the middle of pixel 15: a quarter lies beyond the edge of the colours.
        assert_eq!(
            on_sheet.colour(15, 3) != Some([200, 30, 40]),
            blends,
            "{fit:?}"
        );
    }
}

#[test]
fn averaged_lengths_follow_the_pattern() {
    let image = ChartImage::from_fn(64, 64, |x, y| {
        [[(x * 37 + y * 91) as u8; 3].as_slice(), &[255]]
            .concat()
            .try_into()
            .unwrap()
    });
    let mut design = design(chart(image.unwrap(), Fit::Stretch), checker(), [16, 16]);
    (design.pile.layers, design.pile.resolution) = (1, 4);
    design.chart.average = true;
    design.length.map = LengthMap::Gray;
    let mut compiler = Compiler::default();
    compiler.compile(&design).unwrap();
    // Loops in the same cells, and more of them: each has less of the chart.
    design.weave = weave(2, 2, &[7, 7, 0, 7]);
    let kept = compiler.compile(&design).unwrap();
    let anew = compile(&design).unwrap();
    let lengths = |scene: &Scene| -> Vec<[f32; 3]> {
        let loops = &scene.loops;
        (0..scene.looks.len())
            .map(|k| loops.patch(k).axis)
            .collect()
    };
    assert_eq!(lengths(&kept), lengths(&anew));
    assert!(*kept.looks == *anew.looks);
}
