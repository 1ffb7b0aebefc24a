//! The grid that finds loops: lists and height ranges of cells.

use glam::DVec3;
use renderer_core::design::{Back, Design, Pattern, Pile};
use renderer_core::sampling::Pcg;
use renderer_core::scene::{Face, Scene, compile};

/// Checks that points inside loops' volumes are listed in their cell, inside the entry's and the cell's height range.
fn check_grid_holds_volumes(scene: &Scene, points: usize) {
    let (sheet, loops) = (&*scene.sheet, &*scene.loops);
    let planted: Vec<_> = (0..sheet.wefts)
        .flat_map(|j| loops.planted_in_row(sheet, j))
        .collect();
    assert_eq!(planted.len(), loops.shapes.len());
    let mut random = Pcg::new(7, 0);
    let mut next = || f64::from(random.next_float());
    for k in 0..points {
        // The first loops are at the sheet's near edge; the others anywhere.
        let planted = planted[if k % 2 == 0 {
            k / 2 % planted.len()
        } else {
            (next() * planted.len() as f64) as usize
        }];
        let shape = &loops.shapes[planted.index as usize];
        let [p0, p1, p2, p3] = shape.corners(loops.base_width_mm);
        // Half of the points lie on the volume's edges, where bounds fail first.
        let mut share = || {
            let x = next();
            if next() < 0.5 { x.round() } else { x }
        };
        let (u, v, w) = (share(), share(), share() - 0.5);
        let patch = p0 + u * (p1 - p0) + v * (p3 - p0) + u * v * (p0 - p1 + p2 - p3);
        let normal = shape.normal(loops.base_width_mm);
        let point: DVec3 = patch + w * f64::from(loops.thickness_mm) * normal;
        let di = (point.x / sheet.pitch_x_mm + 0.5).floor() as i64;
        let dj = (point.y / sheet.pitch_y_mm + 0.5).floor() as i64;
        let cell = [
            i64::from(planted.cell[0]) + di,
            i64::from(planted.cell[1]) + dj,
        ];
        let index = loops
            .header_index(sheet, cell[0], cell[1])
            .unwrap_or_else(|| panic!("{planted:?} reaches cell {cell:?} outside the grid"));
        let header = &loops.headers[index];
        let own = loops
            .header_index(sheet, planted.cell[0].into(), planted.cell[1].into())
            .map(|own| loops.headers[own].first_loop);
        let wanted = [-di as i32, -dj as i32];
        let entry = loops
            .entries_of(header)
            .iter()
            .find(|entry| {
                entry.cell_offset() == wanted
                    && own.map(|first| first + entry.slot()) == Some(planted.index)
            })
            .unwrap_or_else(|| panic!("{planted:?} is not listed in cell {cell:?}"));
        let unit = f64::from(loops.height_unit_mm);
        let [low, high] = header.z_units().map(|z| f64::from(z) * unit);
        let [z0, z1] = entry
            .z_steps()
            .map(|step| low + (high - low) * f64::from(step) / 255.0);
        assert!(
            z0 <= point.z && point.z <= z1,
            "{planted:?} at {point} is outside {z0}..{z1} of cell {cell:?}"
        );
        assert!(
            f64::from(loops.z_range_mm[0]) <= z0 + 1e-4
                && z1 <= f64::from(loops.z_range_mm[1]) + 1e-4
        );
    }
}

/// The default design with coarse volumes: these tests are not about them.
fn plain() -> Design {
    let mut design = Design::default();
    (design.pile.layers, design.pile.resolution) = (1, 4);
    design.pile.variants = 1;
    design
}

/// A sheet so small that most loops hang over its edge.
fn small(pile: &Pile) -> Design {
    let mut design = plain();
    design.pile = Pile {
        layers: 1,
        resolution: 4,
        variants: 1,
        ..pile.clone()
    };
    design.sheet.warps = 14;
    design.sheet.wefts = 11;
    design
}

#[test]
fn every_point_of_every_loop_is_found() {
    check_grid_holds_volumes(&compile(&plain()).unwrap(), 100_000);
}

#[test]
fn every_point_is_found_on_both_faces_of_other_weaves() {
    let mut design = small(&Pile::default());
    design.weave.pattern = Pattern::try_from(vec![vec![9, 0, 8], vec![1, 7, 0]]).unwrap();
    design.weave.back = Back::Pattern;
    let scene = compile(&design).unwrap();
    let faces = |face: Face| {
        let shapes = scene.loops.shapes.iter();
        shapes.filter(|shape| shape.face() == face).count()
    };
    assert!(faces(Face::Front) > 40 && faces(Face::Back) > 40);
    check_grid_holds_volumes(&scene, 50_000);
}

#[test]
fn every_point_of_long_tilted_pile_is_found() {
    let mut shag = small(&Pile {
        tilt: 180.0,
        twist: 143.0,
        jitter: 90.0,
        top_width: 3.5,
        thickness: 2.0,
        max_length: 30.0,
        ..Pile::default()
    });
    shag.length.value = 25.0;
    check_grid_holds_volumes(&compile(&shag).unwrap(), 200_000);
}

#[test]
fn every_point_of_wide_short_and_of_pointed_loops_is_found() {
    for (base_width, top_width, length) in [(6.0, 0.3, 1.0), (0.3, 6.0, 1.0), (4.0, 4.0, 0.4)] {
        let mut design = small(&Pile {
            base_width,
            top_width,
            tilt: 120.0,
            twist: 143.0,
            ..Pile::default()
        });
        design.length.value = length;
        check_grid_holds_volumes(&compile(&design).unwrap(), 50_000);
    }
}

/// Upright loops without any disorder on cells of 1 mm.
fn upright() -> Design {
    let mut design = small(&Pile {
        base_width: 1.5,
        top_width: 1.5,
        thickness: 0.4,
        lean_y: 0.0,
        tilt: 0.0,
        twist: 0.0,
        stretch: 0.0,
        jitter: 0.0,
        twist_jitter: 0.0,
        length_jitter: 0.0,
        ..Pile::default()
    });
    design.length.value = 3.0;
    design.sheet.warps_per_cm = 10.0;
    design.sheet.wefts_per_cm = 10.0;
    design.weave.back = Back::None;
    design
}

#[test]
fn lists_are_as_short_as_the_loops_outline() {
    // An upright loop's outline is 0.4 × 1.5 mm about the middle of a cell of 1 mm: its own cell and the two beside it
    // along y, no other.
    let scene = compile(&upright()).unwrap();
    let loops = &scene.loops;
    assert_eq!(loops.entries.len(), 3 * loops.shapes.len());
    assert_eq!(loops.margin, [0, 1]);
    // A lean of 1 rad along x with length 3: the box is 2.5 + 0.4·cos 1 mm wide, so four cells, and higher on one side.
    let mut leaning = upright();
    leaning.pile.lean_x = 1.0_f64.to_degrees();
    let scene = compile(&leaning).unwrap();
    let (sheet, loops) = (&*scene.sheet, &*scene.loops);
    assert_eq!(loops.entries.len(), 12 * loops.shapes.len());
    // Two cells from the root, 1.5 to 2.5 mm, the axis is between (1.5 and 2.5)·cot 1 above the roots, and half the
    // thickness of 0.2/sin 1 measured upright lies above and below; the top edge ends at 3 cos 1 + 0.2 sin 1.
    let header = loops.headers[loops.header_index(sheet, 4, 4).unwrap()];
    let root = f64::from(loops.shapes[0].root_z0);
    let unit = f64::from(loops.height_unit_mm);
    let [low, high] = header.z_units().map(|z| f64::from(z) * unit);
    let entry = loops
        .entries_of(&header)
        .iter()
        .find(|entry| entry.cell_offset() == [-2, 0])
        .expect("the loop two cells to the left reaches here");
    let [z0, z1] = entry
        .z_steps()
        .map(|step| low + (high - low) * f64::from(step) / 255.0 - root);
    let upright_thickness = 0.2 / 1.0_f64.sin();
    let bottom = 1.5 / 1.0_f64.tan() - upright_thickness;
    let top = 3.0 * 1.0_f64.cos() + 0.2 * 1.0_f64.sin();
    // Heights are kept in 255ths of the cell's range, rounded outwards.
    let step = (high - low) / 255.0 + 2.0 * unit;
    assert!(
        z0 <= bottom && z0 > bottom - 2.0 * step,
        "{z0}, not {bottom}"
    );
    assert!(z1 >= top && z1 < top + 2.0 * step, "{z1}, not {top}");
}

#[test]
fn a_far_cell_of_a_wide_carpet_is_like_a_near_one() {
    let mut design = upright();
    design.pile.lean_x = 33.0;
    design.sheet.warps = 100_000;
    design.sheet.wefts = 6;
    let scene = compile(&design).unwrap();
    let (sheet, loops) = (&*scene.sheet, &*scene.loops);
    let first = loops.shapes[0];
    assert!(loops.shapes.iter().all(|shape| *shape == first));
    let cell = |i: i64| {
        let header = loops.headers[loops.header_index(sheet, i, 3).unwrap()];
        (header.z_range, loops.entries_of(&header).to_vec())
    };
    assert_eq!(cell(50), cell(99_950));
    assert_eq!(cell(51), cell(99_951));
}

#[test]
fn a_sheet_without_loops_has_an_empty_grid() {
    let mut design = upright();
    design.length.value = 0.0;
    let scene = compile(&design).unwrap();
    assert!(scene.loops.shapes.is_empty() && scene.loops.entries.is_empty());
    assert!(scene.looks.is_empty());
    assert_eq!(scene.loops.headers.len(), 14 * 11);
    assert_eq!(scene.loops.z_range_mm, [0.0, 0.0]);
    let empty = |header: &renderer_core::scene::CellHeader| {
        let [low, high] = header.z_units();
        low > high
    };
    assert!(scene.loops.headers.iter().all(empty));
}

#[test]
fn entries_keep_what_is_packed_into_them() {
    use renderer_core::scene::CellEntry;
    for (di, dj) in [(0, 0), (-128, -64), (127, 63), (-1, 5), (60, -60)] {
        for second in [false, true] {
            let entry = CellEntry::new(di, dj, second, 3, 254);
            assert_eq!(entry.cell_offset(), [di, dj]);
            assert_eq!(entry.slot(), u32::from(second));
            assert_eq!(entry.z_steps(), [3, 254]);
        }
    }
}
