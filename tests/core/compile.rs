//! What compile leaves out, and that leaving it out changes nothing.

use std::collections::{BTreeMap, BTreeSet};

use renderer_core::design::{
    Back, ChartImage, Design, Filter, Fit, LengthMap, NoiseKind, Pattern, Sheared, preset,
};
use renderer_core::render::{Optimisation, Optimisations};
use renderer_core::sampling::Pcg;
use renderer_core::scene::{CellSet, Compiler, Face, PileReach, Scene, compile};

use crate::support::scenes::small_towel;

/// Whether two scenes hold the same loops and looks, to the bit.
#[track_caller]
fn assert_same_loops(a: &Scene, b: &Scene, what: &str) {
    let (loops, others) = (&*a.loops, &*b.loops);
    assert!(
        loops.counts == others.counts,
        "{what}: {:?} {:?}",
        loops.counts,
        others.counts
    );
    assert!(loops.shapes == others.shapes, "{what}: shapes");
    assert!(loops.entries == others.entries, "{what}: lists");
    assert!(loops.headers == others.headers, "{what}: headers");
    assert!(*a.looks == *b.looks, "{what}: looks");
    assert!(a.volumes.voxels == b.volumes.voxels, "{what}: voxels");
}

/// Designs that leave cells bare by pattern, chart, length and side.
fn designs() -> Vec<(&'static str, Design)> {
    let with = |edit: fn(&mut Design)| {
        let mut design = small_towel();
        edit(&mut design);
        design
    };
    let chart = |design: &mut Design, hole: [u8; 4]| {
        let mut pixels = vec![[200, 170, 90, 255]; 120];
        for texel in (0..120).step_by(3) {
            pixels[texel] = hole;
        }
        design.chart.pixels = ChartImage::new(12, 10, &pixels);
        design.chart.fit = Fit::Tile;
    };
    let mut transparent = small_towel();
    chart(&mut transparent, [0; 4]);
    let mut black = small_towel();
    chart(&mut black, [0, 0, 0, 255]);
    black.length.map = LengthMap::Gray;
    black.length.min = 0.0;
    vec![
        ("pattern", small_towel()),
        ("one side", with(|d| d.weave.back = Back::None)),
        ("mirror", with(|d| d.weave.back = Back::Mirror)),
        ("all bare", with(|d| d.length.value = 0.0)),
        ("filter", with(|d| d.turbulence.filter = Filter::Gaussian)),
        ("worley", with(|d| d.turbulence.kind = NoiseKind::Worley)),
        ("no tilt", with(|d| d.pile.tilt = 0.0)),
        (
            "no twist, no stretch",
            with(|d| (d.pile.twist, d.pile.stretch) = (0.0, 0.0)),
        ),
        ("shorn", with(|d| d.finish.sheared = Sheared::Both)),
        ("pulled", with(|d| d.finish.pulled = 0.3)),
        ("wet", with(|d| d.finish.wetness = 1.0)),
        (
            "napped",
            with(|d| d.nap.pixels = ChartImage::filled(2, 2, [255, 30, 0, 255])),
        ),
        ("transparent chart", transparent),
        ("lengths of zero", black),
    ]
}

#[test]
fn frames_of_bare_cells_are_left_out() {
    for (what, design) in designs() {
        let mut compiler = Compiler::default();
        let scene = compiler.compile(&design).unwrap();
        let both_faces = 2 * u64::from(design.sheet.warps * design.sheet.wefts);
        let report = compiler.last_report();
        assert_eq!(
            report.frames_made + report.frames_left_out,
            both_faces,
            "{what}"
        );
        // Loops that turbulence and jitter make too short are the only others: here none.
        let planted = scene.loops.counts.planted + scene.loops.counts.dropped;
        assert_eq!(report.frames_made, planted, "{what}: {report:?}");
    }
}

#[test]
fn a_loop_is_the_same_whatever_stands_around_it() {
    // The axis and turn of each loop, by its cell and face.
    let loops = |design: &Design| -> BTreeMap<([u32; 2], bool), String> {
        let scene = compile(design).unwrap();
        let (sheet, loops) = (&*scene.sheet, &*scene.loops);
        let planted = (0..sheet.wefts).flat_map(|j| loops.planted_in_row(sheet, j));
        let patch = |index: u32| format!("{:?}", loops.patch(index as usize));
        planted
            .map(|one| ((one.cell, one.face == Face::Back), patch(one.index)))
            .collect()
    };
    let edits: [fn(&mut Design); 4] = [
        |_| (),
        |d| (d.turbulence.filter, d.pile.tilt) = (Filter::Box, 60.0),
        |d| (d.turbulence.filter, d.turbulence.kind) = (Filter::Gaussian, NoiseKind::Worley),
        |d| (d.turbulence.filter, d.finish.pulled) = (Filter::Gaussian, 0.3),
    ];
    for (number, edit) in edits.into_iter().enumerate() {
        let mut full = small_towel();
        edit(&mut full);
        let mut holed = full.clone();
        for (design, hole) in [(&mut full, 255), (&mut holed, 0)] {
            let pixels: Vec<_> = (0..120)
                .map(|texel| [200, 170, 90, if texel % 3 == 0 { hole } else { 255 }])
                .collect();
            design.chart.pixels = ChartImage::new(12, 10, &pixels);
            design.chart.fit = Fit::Tile;
        }
        let (all, some) = (loops(&full), loops(&holed));
        assert!(!some.is_empty() && some.len() < all.len(), "edit {number}");
        for (place, patch) in &some {
            assert_eq!(all.get(place), Some(patch), "edit {number}, {place:?}");
        }
    }
}

fn without(skip: Optimisation) -> Optimisations {
    Optimisations::ALL.without(skip)
}

#[test]
fn sections_are_kept_by_default_and_that_changes_nothing() {
    let edits: [fn(&mut Design); 8] = [
        |_| (),
        |d| d.weave.pattern = Pattern::filled(1, 1, 9),
        |d| d.pile.tilt = 0.0,
        |d| d.pile.tilt = 50.0,
        |d| d.turbulence.filter = Filter::Box,
        |d| d.turbulence.seed = 9,
        |d| d.light.background.0 = [9, 9, 9],
        |d| d.sheet.warps = 70,
    ];
    let mut design = small_towel();
    let (mut keeping, mut forgetting) = (
        Compiler::default(),
        Compiler::new(without(Optimisation::UnchangedSections).into()),
    );
    for (number, edit) in edits.into_iter().enumerate() {
        edit(&mut design);
        let (a, b) = (
            keeping.compile(&design).unwrap(),
            forgetting.compile(&design).unwrap(),
        );
        assert_same_loops(&a, &b, &format!("edit {number}"));
        assert_same_loops(
            &a,
            &compile(&design).unwrap(),
            &format!("edit {number}, alone"),
        );
        assert_eq!(forgetting.last_report().sections_kept(), 0);
        let kept = keeping.last_report().sections_kept();
        assert_eq!(kept > 0, number > 0, "edit {number} keeps {kept}");
    }
}

#[test]
fn no_loop_is_beyond_the_reach() {
    let mut random = Pcg::new(11, 0);
    let mut compiled = 0;
    for _ in 0..150 {
        let mut design = small_towel();
        for (path, low, high) in [
            ("pile.lean_x", -75.0, 75.0),
            ("pile.lean_y", -75.0, 75.0),
            ("pile.tilt", 0.0, 180.0),
            ("pile.twist", -143.0, 143.0),
            ("pile.stretch", 0.0, 1.0),
            ("pile.jitter", 0.0, 90.0),
            ("pile.length_jitter", 0.0, 1.0),
            ("pile.base_width", 0.1, 4.0),
            ("pile.top_width", 0.1, 4.0),
            ("pile.thickness", 0.05, 2.0),
            ("length.value", 0.1, 6.0),
            ("skeleton.crimp", 0.0, 1.0),
            ("finish.pulled", -1.0, 1.0),
            ("finish.pulled_length", 0.0, 6.0),
            ("nap.strength", 0.0, 75.0),
            ("finish.wetness", -1.0, 1.0),
        ] {
            let mut value = low + (high - low) * f64::from(random.next_float());
            if path.starts_with("finish") {
                // Half of the designs have none of it.
                value = value.max(0.0);
            }
            design = preset::set(&design, path, &value.to_string()).unwrap();
        }
        if random.next_float() < 0.5 {
            let way = std::array::from_fn(|_| (255.0 * random.next_float()) as u8);
            let [r, g] = way;
            design.nap.pixels = ChartImage::filled(1, 1, [r, g, 255, 255]);
        }
        let reach = PileReach::of(&design);
        let Ok(scene) = compile(&design) else {
            continue;
        };
        compiled += 1;
        let loops = &scene.loops;
        for shape in &loops.shapes {
            let patch = shape.patch(loops.length_unit_mm);
            let half = 0.5 * f64::from(loops.thickness_mm);
            let normal = patch.normal(loops.base_width_mm).abs() * half;
            for corner in patch.corners(loops.base_width_mm) {
                let (low, high) = ((corner - normal).to_array(), (corner + normal).to_array());
                for axis in 0..3 {
                    assert!(
                        reach.low_mm[axis] <= low[axis] && high[axis] <= reach.high_mm[axis],
                        "axis {axis}: {shape:?} beyond {reach:?}"
                    );
                }
            }
        }
        let blocks = |cells: i64| (cells as u32).div_ceil(loops.block_cells);
        let margin = reach.margin().map(blocks);
        assert!(loops.margin[0] <= margin[0] && loops.margin[1] <= margin[1]);
    }
    assert!(compiled > 100, "only {compiled} compiled");
}

#[test]
fn sets_of_cells_are_sets_of_cells() {
    let mut random = Pcg::new(3, 0);
    let mut number = |below: i64| (f64::from(random.next_float()) * below as f64) as i64;
    for _ in 0..200 {
        // Around the ends of words.
        let (warps, wefts) = (1 + number(140), 1 + number(9));
        let mut set = CellSet::none(warps as usize, wefts as usize);
        let mut plain = BTreeSet::new();
        for _ in 0..1 + number(6) {
            let (j, first) = (number(wefts), number(warps + 20) - 10);
            let last = first + number(70) - 3;
            set.insert(j as usize, first..=last);
            plain.extend((first.max(0)..=last.min(warps - 1)).map(|i| (j, i)));
        }
        let cells = |set: &CellSet| -> BTreeSet<(i64, i64)> {
            let row = |j: i64| set.row(j as usize).map(move |i| (j, i as i64));
            (0..wefts).flat_map(row).collect()
        };
        assert_eq!(cells(&set), plain);
        assert_eq!((set.len(), set.is_empty()), (plain.len(), plain.is_empty()));
        let step = 1 + number(9) as usize;
        let every: BTreeSet<_> = plain.iter().copied().step_by(step).collect();
        assert_eq!(cells(&set.every(step)), every, "every {step}");
        let (j, first, last) = (
            number(wefts),
            number(warps + 20) - 10,
            number(warps + 20) - 10,
        );
        let meets = plain
            .range((j, first)..)
            .next()
            .is_some_and(|&(row, i)| row == j && i <= last);
        assert_eq!(
            set.meets(j as usize, first..=last),
            meets,
            "{j} {first} {last} {plain:?}"
        );

        let (x, y) = ([-number(5), number(70)], [-number(3), number(3)]);
        let around = |&(j, i): &(i64, i64)| {
            (j + y[0]..=j + y[1]).flat_map(move |j| (i + x[0]..=i + x[1]).map(move |i| (j, i)))
        };
        let on_sheet = |&(j, i): &(i64, i64)| (0..wefts).contains(&j) && (0..warps).contains(&i);
        let spread: BTreeSet<_> = plain.iter().flat_map(around).filter(on_sheet).collect();
        let grown = set.spread(x, y);
        assert_eq!(cells(&grown), spread);
        assert_eq!(grown.holds(&set), plain.is_subset(&spread));
        assert_eq!(cells(&grown.clone().and(&set)), &spread & &plain);
        assert_eq!(cells(&grown.or(&set)), &spread | &plain);
    }
}
