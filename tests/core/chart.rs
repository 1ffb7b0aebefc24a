//! The chart on the sheet, and what its colours become: lengths, rows of the table, curve (MODEL.md §6).

mod objects;

use renderer_core::design::{
    Chart, ChartImage, Colour, Design, Fit, Length, LengthEntry, LengthMap, PileKind,
};
use renderer_core::scene::{ChartOnSheet, LengthRule, MonotoneCurve, compile, luma};

/// The default design with coarse volumes: these tests are not about them.
fn plain() -> Design {
    let mut design = Design::default();
    (design.pile.layers, design.pile.resolution) = (1, 4);
    design
}

/// An image whose pixel at column x, row y (from the top) is (x, y, 0).
fn numbered(width: usize, height: usize) -> ChartImage {
    let pixels: Vec<[u8; 4]> = (0..width * height)
        .map(|k| [(k % width) as u8, (k / width) as u8, 0, 255])
        .collect();
    ChartImage::new(width, height, &pixels).unwrap()
}

fn chart(pixels: ChartImage, fit: Fit) -> Chart {
    Chart {
        pixels: Some(pixels),
        fit,
        ..Chart::default()
    }
}

/// Column and row of the texel that each cell of a weft uses.
fn row_of_texels(chart: &Chart, [warps, wefts]: [u32; 2], j: usize) -> Vec<[u8; 2]> {
    let on_sheet = ChartOnSheet::pixel_by_pixel(chart, [warps, wefts]);
    let texel = |i| on_sheet.colour(i, j).map(|[x, y, _]| [x, y]).unwrap();
    (0..warps as usize).map(texel).collect()
}

#[test]
fn a_stretched_chart_covers_the_sheet_with_row_0_far() {
    let chart = chart(numbered(4, 2), Fit::Stretch);
    let far = row_of_texels(&chart, [8, 6], 5);
    assert_eq!(far, [0, 0, 1, 1, 2, 2, 3, 3].map(|x| [x, 0]));
    for (j, y) in [(5, 0), (4, 0), (3, 0), (2, 1), (1, 1), (0, 1)] {
        assert_eq!(row_of_texels(&chart, [8, 6], j)[0], [0, y]);
    }
    // Fewer cells than texels: the texel under the cell's middle.
    let fine = self::chart(numbered(9, 9), Fit::Stretch);
    assert_eq!(row_of_texels(&fine, [3, 3], 1), [1, 4, 7].map(|x| [x, 4]));
}

#[test]
fn a_tiled_chart_gives_each_loop_a_pixel() {
    let tiled = chart(numbered(3, 2), Fit::Tile);
    assert_eq!(
        row_of_texels(&tiled, [7, 5], 4),
        [0, 1, 2, 0, 1, 2, 0].map(|x| [x, 0])
    );
    let rows: Vec<u8> = (0..5)
        .map(|j| row_of_texels(&tiled, [7, 5], j)[0][1])
        .collect();
    // From the near edge: the far edge has row 0.
    assert_eq!(rows, [0, 1, 0, 1, 0]);
}

#[test]
fn repeats_are_mirrored_and_dropped() {
    let mirrored = Chart {
        mirror_x: true,
        mirror_y: true,
        ..chart(numbered(3, 4), Fit::Tile)
    };
    assert_eq!(
        row_of_texels(&mirrored, [7, 9], 8),
        [0, 1, 2, 2, 1, 0, 0].map(|x| [x, 0])
    );
    let rows: Vec<u8> = (0..9)
        .rev()
        .map(|j| row_of_texels(&mirrored, [7, 9], j)[0][1])
        .collect();
    assert_eq!(rows, [0, 1, 2, 3, 3, 2, 1, 0, 0]);

    let dropped = Chart {
        half_drop: true,
        ..chart(numbered(3, 4), Fit::Tile)
    };
    // At the far edge the second repeat starts in its middle; half a repeat nearer it has row 0.
    let far = row_of_texels(&dropped, [7, 9], 8);
    assert_eq!(
        far.iter().map(|t| t[1]).collect::<Vec<_>>(),
        [0, 0, 0, 2, 2, 2, 0]
    );
    assert_eq!(row_of_texels(&dropped, [7, 9], 6)[3], [0, 0]);
    assert_eq!(row_of_texels(&dropped, [7, 9], 7)[3], [0, 3]);
}

#[test]
fn a_placed_chart_lies_once_where_it_should() {
    let colours = |chart: &Chart, [warps, wefts]: [u32; 2]| -> Vec<Vec<[u8; 3]>> {
        let on_sheet = ChartOnSheet::pixel_by_pixel(chart, [warps, wefts]);
        // From the far edge, as one looks at a picture.
        let rows = (0..wefts as usize).rev();
        rows.map(|j| {
            (0..warps as usize)
                .map(|i| on_sheet.colour(i, j).unwrap())
                .collect()
        })
        .collect()
    };
    let mut placed = Chart {
        colour: Colour([9, 9, 9]),
        ..chart(numbered(3, 2), Fit::Place)
    };
    let (o, t) = ([9, 9, 9], |x, y| [x, y, 0]);
    // In the middle: one warp left, one right; one weft far, one near.
    assert_eq!(
        colours(&placed, [5, 4]),
        [
            [o, o, o, o, o],
            [o, t(0, 0), t(1, 0), t(2, 0), o],
            [o, t(0, 1), t(1, 1), t(2, 1), o],
            [o, o, o, o, o],
        ]
    );
    (placed.offset_x, placed.offset_y) = (2, 1);
    assert_eq!(
        colours(&placed, [5, 4]),
        [
            [o, o, o, t(0, 0), t(1, 0)],
            [o, o, o, t(0, 1), t(1, 1)],
            [o, o, o, o, o],
            [o, o, o, o, o],
        ]
    );
    // Larger than the cloth: its middle part; far away: nothing of it.
    (placed.offset_x, placed.offset_y) = (0, 0);
    assert_eq!(colours(&placed, [1, 2]), [[t(1, 0)], [t(1, 1)]]);
    placed.offset_x = -100_000;
    assert_eq!(colours(&placed, [2, 1]), [[o, o]]);

    // What is transparent shows the cloth, not its bare ground.
    let pixels = [[1, 2, 3, 255], [4, 5, 6, 0]];
    placed.pixels = ChartImage::new(2, 1, &pixels);
    placed.offset_x = 0;
    assert_eq!(colours(&placed, [4, 1]), [[o, [1, 2, 3], o, o]]);
}

#[test]
fn transparent_texels_plant_nothing() {
    let pixels = [[9, 9, 9, 127], [9, 9, 9, 128]];
    let mut design = plain();
    (design.sheet.warps, design.sheet.wefts) = (8, 4);
    design.chart = chart(ChartImage::new(2, 1, &pixels).unwrap(), Fit::Stretch);
    let scene = compile(&design).unwrap();
    let planted: Vec<_> = (0..4)
        .flat_map(|j| scene.loops.planted_in_row(&scene.sheet, j))
        .collect();
    assert_eq!(planted.len(), 16, "half of 16 crossings on two faces");
    assert!(planted.iter().all(|planted| planted.cell[0] >= 4));
}

#[test]
fn gray_lengths_follow_luma_through_the_curve() {
    assert!((luma([255, 255, 255]) - 1.0).abs() < 1e-12);
    assert!((luma([255, 0, 0]) - 0.2126).abs() < 1e-12);
    assert!((luma([0, 128, 0]) - 0.7152 * 128.0 / 255.0).abs() < 1e-12);
    let rule = LengthRule::new(&Length {
        map: LengthMap::Gray,
        min: 1.0,
        max: 5.0,
        curve: vec![[0.0, 1.0], [1.0, 0.0]],
        ..Length::default()
    });
    // A falling line: white is short.
    for gray in [0_u8, 51, 102, 255] {
        let expected = 5.0 - 4.0 * f64::from(gray) / 255.0;
        assert!((rule.length_mm([gray; 3]) - expected).abs() < 1e-12);
    }
    assert_eq!(rule.row([0; 3]), None);
}

#[test]
fn the_table_gives_the_nearest_colours_length_and_material() {
    let row = |colour, length, density, kind| LengthEntry {
        colour: Colour(colour),
        length,
        albedo_scale: 0.5,
        density,
        kind,
        ..LengthEntry::default()
    };
    let length = Length {
        map: LengthMap::Lut,
        table: vec![
            row([200, 30, 30], 2.0, None, None),
            row([30, 30, 200], 4.0, Some(3.0), Some(PileKind::Cut)),
            row([255, 255, 255], 0.0, None, None),
            row([0, 140, 20], 3.0, None, None),
        ],
        ..Length::default()
    };
    let rule = LengthRule::new(&length);
    for (colour, row) in [
        ([200, 30, 30], 0),
        ([160, 60, 50], 0),
        ([60, 80, 190], 1),
        ([0, 0, 60], 1),
        ([230, 230, 220], 2),
        ([40, 150, 40], 3),
        // As light as the green row, but red.
        ([210, 60, 20], 0),
        // In sRGB this blue is nearer to white; in Oklab its hue counts.
        ([120, 140, 255], 1),
    ] {
        assert_eq!(rule.row(colour), Some(row), "{colour:?}");
        assert_eq!(rule.length_mm(colour), length.table[row].length);
    }

    let mut design = plain();
    (design.sheet.warps, design.sheet.wefts) = (6, 2);
    let pixels = [[200, 30, 30, 255], [30, 30, 200, 255], [255, 255, 255, 255]];
    design.chart = chart(ChartImage::new(3, 1, &pixels).unwrap(), Fit::Stretch);
    design.length = length;
    let scene = compile(&design).unwrap();
    // White plants nothing: two thirds of 6 crossings, both faces.
    assert_eq!(scene.loops.shapes.len(), 8);
    assert_eq!(scene.volumes.kinds, [PileKind::Terry, PileKind::Cut]);
    assert_eq!(scene.volumes.reference_size_mm[1], 4.0);
    for j in 0..2 {
        for planted in scene.loops.planted_in_row(&scene.sheet, j) {
            let look = scene.looks[planted.index as usize];
            let material = scene.pile.materials[usize::from(look.material)];
            if planted.cell[0] < 2 {
                assert_eq!((material.density_per_mm, material.kind), (10.0, 0));
                assert!(look.albedo[0] > look.albedo[2]);
            } else {
                assert_eq!((material.density_per_mm, material.kind), (3.0, 1));
                assert!(look.albedo[0] < look.albedo[2]);
            }
            // The row's scale halves whatever the colour asks for.
            assert!(look.albedo.iter().all(|&a| a <= 32768));
        }
    }
}

#[test]
fn rows_stand_and_are_spun_as_they_say() {
    let mut design = plain();
    (design.sheet.warps, design.sheet.wefts) = (6, 2);
    let pixels = [[200, 30, 30, 255], [30, 30, 200, 255], [0, 140, 20, 255]];
    design.chart = chart(ChartImage::new(3, 1, &pixels).unwrap(), Fit::Stretch);
    let pile = &mut design.pile;
    (pile.tilt, pile.twist, pile.jitter, pile.twist_jitter) = (0.0, 0.0, 0.0, 0.0);
    (pile.lean_x, pile.lean_y) = (10.0, 0.0);
    let row = |colour| LengthEntry {
        colour: Colour(colour),
        ..LengthEntry::default()
    };
    design.length.map = LengthMap::Lut;
    design.length.table = vec![
        row([200, 30, 30]),
        LengthEntry {
            lean_x: Some(-40.0),
            top_width: Some(0.5),
            yarn_diameter: Some(0.4),
            ..row([30, 30, 200])
        },
        LengthEntry {
            lean_x: Some(0.0),
            lean_y: Some(25.0),
            tilt: Some(50.0),
            ..row([0, 140, 20])
        },
    ];
    let scene = compile(&design).unwrap();
    let mut tilted = Vec::new();
    for planted in (0..2).flat_map(|j| scene.loops.planted_in_row(&scene.sheet, j)) {
        let patch = scene.loops.patch(planted.index as usize);
        let [x, y, z] = patch.axis.map(f64::from);
        let lean = |across: f64| (across / z.abs()).atan().to_degrees();
        let top = 2.0 * f64::from(patch.half_top[1]);
        let material = scene.looks[planted.index as usize].material;
        let kind = scene.pile.materials[usize::from(material)].kind;
        // Half a unit of length, 0.05 µm, turns a loop of 2 mm by far less.
        match planted.cell[0] {
            0 | 1 => {
                assert!((lean(x) - 10.0).abs() < 0.01 && y == 0.0, "{patch:?}");
                assert!((top - 1.9).abs() < 1e-3 && kind == 0);
            }
            2 | 3 => {
                assert!((lean(x) + 40.0).abs() < 0.01 && y == 0.0, "{patch:?}");
                assert!((top - 0.5).abs() < 1e-3 && kind == 1);
            }
            _ => {
                assert_eq!(kind, 0);
                tilted.push(lean(y));
            }
        }
    }
    // Turbulence tips the last row's loops apart, which the pile alone has none of.
    let spread = tilted
        .iter()
        .fold(0.0_f64, |most, a| most.max((a - 25.0).abs()));
    assert!(spread > 1.0, "{tilted:?}");
    // The second row's volumes have thinner yarn: less than half of the section is yarn.
    let volumes = &scene.volumes;
    assert_eq!(volumes.kinds, [PileKind::Terry; 2]);
    let mass = |kind: usize| -> u64 {
        let each = volumes.voxels.len() / 2;
        let voxels = &volumes.voxels[kind * each..(kind + 1) * each];
        voxels.iter().map(|&[density, _]| u64::from(density)).sum()
    };
    assert!(2 * mass(1) < mass(0), "{} {}", mass(1), mass(0));
}

#[test]
fn variants_are_all_used_and_neighbours_differ() {
    let design = plain();
    let scene = compile(&design).unwrap();
    let mut counts = [0; 8];
    for look in scene.looks.iter() {
        counts[usize::from(look.variant)] += 1;
    }
    let expected = scene.looks.len() as f64 / 8.0;
    for count in counts {
        // Five standard deviations of a binomial count.
        assert!(
            (f64::from(count) - expected).abs() < 5.0 * expected.sqrt(),
            "{counts:?}"
        );
    }
}

#[test]
fn the_curve_passes_its_points_and_never_leaves_them() {
    let points = [
        [0.0, 0.1],
        [0.2, 0.15],
        [0.3, 0.9],
        [0.7, 0.9],
        [0.8, 0.2],
        [1.0, 1.0],
    ];
    let curve = MonotoneCurve::new(&points);
    for [x, y] in points {
        assert!((curve.value(x) - y).abs() < 1e-12);
    }
    for pair in points.windows(2) {
        let ([x0, y0], [x1, y1]) = (pair[0], pair[1]);
        let mut last = y0;
        for k in 1..=100 {
            let y = curve.value(x0 + (x1 - x0) * f64::from(k) / 100.0);
            // Monotone between two points, to rounding.
            assert!((y - last) * (y1 - y0) >= -1e-12, "{pair:?}");
            last = y;
        }
    }
    assert_eq!(curve.value(-1.0), 0.1);
    assert_eq!(curve.value(2.0), 1.0);
    // Smooth: slopes on both sides of an inner point agree.
    for x in [0.2, 0.3, 0.8] {
        let slope = |h: f64| (curve.value(x + h) - curve.value(x)) / h;
        assert!((slope(1e-6) - slope(-1e-6)).abs() < 1e-3);
    }
}

#[test]
fn curves_of_two_points_are_lines_and_steps_stay_finite() {
    let line = MonotoneCurve::new(&[[0.0, 0.0], [1.0, 1.0]]);
    for k in 0..=10 {
        let x = f64::from(k) / 10.0;
        assert!((line.value(x) - x).abs() < 1e-12);
    }
    let step = MonotoneCurve::new(&[[0.0, 0.0], [0.5, 0.0], [0.5 + 1e-15, 1.0], [1.0, 1.0]]);
    for k in 0..=1000 {
        let y = step.value(f64::from(k) / 1000.0);
        assert!((0.0..=1.0).contains(&y), "{y}");
    }
}
