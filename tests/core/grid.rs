//! The grid that finds loops: lists and height ranges of blocks.

use renderer_core::design::{Back, Design, Pattern, Pile};
use renderer_core::sampling::Pcg;
use renderer_core::scene::{EntryLayout, EntryParts, Face, PlantedLoop, Scene, compile};

use crate::support::scenes::{load_design, preset_path};

/// A block's entry for a loop, with its heights in mm.
struct Listed {
    entry: EntryParts,
    z: [f64; 2],
}

/// What the list of the block that holds `cell` says of the loop `planted`.
fn listed(scene: &Scene, planted: PlantedLoop, cell: [i64; 2]) -> Option<Listed> {
    let loops = &*scene.loops;
    let block = loops.block_of(cell);
    let index = loops
        .header_index(block)
        .unwrap_or_else(|| panic!("{planted:?} reaches cell {cell:?} outside the grid"));
    let own = planted.cell.map(i64::from);
    let entries = loops.entries_of(index).iter();
    let mut entries = entries.map(|&entry| loops.entry_layout.unpack(entry));
    let entry = entries.find(|entry| {
        let home = [0, 1].map(|k| block[k] + i64::from(entry.offset[k]));
        home == loops.block_of(own)
            && loops.cell_in_block(home, entry.place) == own
            && Face::of_place(entry.place) == planted.face
    })?;
    let [low, high] = loops.headers[index].heights_mm(loops, planted.face);
    let step = (high - low) / f64::from(loops.entry_layout.height_steps());
    let z = [entry.heights[0], entry.heights[1] + 1];
    Some(Listed {
        entry,
        z: z.map(|steps| low + f64::from(steps) * step),
    })
}

/// The bit of the subcell of a block, n along each side, that a point in `cell` is in; `place` is the point's in its
/// cell, from 0 to 1.
fn subcell(scene: &Scene, cell: [i64; 2], place: [f64; 2], n: i64) -> u32 {
    let b = i64::from(scene.loops.block_cells);
    let [x, y] = [0, 1].map(|k| {
        let in_block = (cell[k].rem_euclid(b) as f64 + place[k]) / b as f64;
        (in_block * n as f64).floor() as i64
    });
    1 << (x + n * y)
}

/// Checks that points inside loops' volumes are listed in their block, in the quadrant that they are in and within the
/// entry's heights, and points on their patches in their ninth.
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
        let shape = loops.patch(planted.index as usize);
        assert_eq!(shape.face(), planted.face);
        let [p0, p1, p2, p3] = shape.corners(loops.base_width_mm);
        // Half of the points lie on the volume's edges, where bounds fail first.
        let mut share = || {
            let x = next();
            if next() < 0.5 { x.round() } else { x }
        };
        let (u, v, w) = (share(), share(), share() - 0.5);
        let patch = p0 + u * (p1 - p0) + v * (p3 - p0) + u * v * (p0 - p1 + p2 - p3);
        let normal = shape.normal(loops.base_width_mm);
        for (point, on_patch) in [
            (patch, true),
            (patch + w * f64::from(loops.thickness_mm) * normal, false),
        ] {
            let place = [
                point.x / sheet.pitch_x_mm + 0.5,
                point.y / sheet.pitch_y_mm + 0.5,
            ];
            let cell = [0, 1].map(|k| i64::from(planted.cell[k]) + place[k].floor() as i64);
            let place = place.map(|place| place - place.floor());
            let Listed { entry, z } = listed(scene, planted, cell)
                .unwrap_or_else(|| panic!("{planted:?} is not listed in the block of {cell:?}"));
            assert!(
                z[0] <= point.z && point.z <= z[1],
                "{planted:?} at {point} is outside {z:?} in the block of {cell:?}"
            );
            let quadrant = subcell(scene, cell, place, 2);
            assert!(
                entry.mask_2x2 & quadrant != 0,
                "{planted:?} at {point}: {entry:?}"
            );
            let ninth = subcell(scene, cell, place, 3);
            assert!(
                !on_patch || entry.mask_3x3 & ninth != 0,
                "{planted:?} at {point}: {entry:?}"
            );
            let [low, high] = loops.z_range_mm.map(f64::from);
            assert!(low <= point.z + 1e-4 && point.z <= high + 1e-4);
        }
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
        let shapes = 0..scene.loops.shapes.len();
        let faces = shapes.map(|index| scene.loops.patch(index).face());
        faces.filter(|&other| other == face).count()
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
    // An upright loop's outline is 0.4 × 1.5 mm about the middle of a cell of 1 mm, its patch's is 0 × 1.5 mm.
    let scene = compile(&upright()).unwrap();
    let (sheet, loops) = (&*scene.sheet, &*scene.loops);
    check_footprints(
        &scene,
        [[-0.2, 0.2], [-0.75, 0.75]],
        [[0.0, 0.0], [-0.75, 0.75]],
    );
    assert_eq!(loops.margin, [0, 1]);
    let all: Vec<_> = (0..sheet.wefts)
        .flat_map(|j| loops.planted_in_row(sheet, j))
        .collect();
    assert_eq!(all.len(), loops.shapes.len());

    // A lean of 1 rad along x with length 3: the axis goes 2.5 mm along x, and the thickness adds 0.2·cos 1 to either
    // side.
    let mut leaning = upright();
    leaning.pile.lean_x = 1.0_f64.to_degrees();
    let scene = compile(&leaning).unwrap();
    let (sin, cos) = 1.0_f64.sin_cos();
    let (ahead, beside) = (3.0 * sin, 0.2 * cos);
    check_footprints(
        &scene,
        [[-beside, ahead + beside], [-0.75, 0.75]],
        [[0.0, ahead], [-0.75, 0.75]],
    );
    // Heights: over the cells from 1.5 mm on, that is the block two cells to the right, the volume's lowest point is on
    // its lower side, 1.5·cot 1 − 0.2/sin 1 above the root; the top edge's upper side ends at 3 cos 1 + 0.2 sin 1.
    let loops = &*scene.loops;
    assert_eq!(loops.block_cells, 2);
    let own = PlantedLoop {
        index: loops.loop_at([4, 4], Face::Front).expect("is planted"),
        cell: [4, 4],
        face: Face::Front,
    };
    let root = f64::from(loops.patch(own.index as usize).root_z0);
    let Listed { z, .. } = listed(&scene, own, [6, 4]).expect("reaches two cells to the right");
    let [z0, z1] = z.map(|z| z - root);
    let (bottom, top) = (1.5 / 1.0_f64.tan() - 0.2 / sin, 3.0 * cos + 0.2 * sin);
    // Rounded outwards to steps of the block's heights.
    let index = loops.header_index(loops.block_of([6, 4])).unwrap();
    let [low, high] = loops.headers[index].heights_mm(loops, Face::Front);
    let step = (high - low) / f64::from(loops.entry_layout.height_steps()) + 1e-3;
    assert!(z0 <= bottom && z0 > bottom - step, "{z0}, not {bottom}");
    assert!(z1 >= top && z1 < top + step, "{z1}, not {top}");
}

/// Checks quadrants and ninths of all lists where every loop's volume and patch cover the same box seen from above, mm
/// from the middle of the loop's cell.
fn check_footprints(scene: &Scene, volume: [[f64; 2]; 2], patch: [[f64; 2]; 2]) {
    let (sheet, loops) = (&*scene.sheet, &*scene.loops);
    let b = loops.block_cells as f64;
    let pitch = [sheet.pitch_x_mm, sheet.pitch_y_mm];
    let mut entries = 0;
    for planted in (0..sheet.wefts).flat_map(|j| loops.planted_in_row(sheet, j)) {
        let reached = |block: [i64; 2], n: i64, span: [[f64; 2]; 2]| {
            let subcells = (0..n * n).filter(|k| {
                [k % n, k / n].into_iter().enumerate().all(|(axis, index)| {
                    let size = b * pitch[axis] / n as f64;
                    let middle = (f64::from(planted.cell[axis]) + 0.5) * pitch[axis];
                    let low = block[axis] as f64 * b * pitch[axis] + index as f64 * size - middle;
                    // A touch counts, but for rounding no border is touched here.
                    low <= span[axis][1] && low + size >= span[axis][0]
                })
            });
            subcells.fold(0, |bits, k| bits | 1 << k)
        };
        let [i, j] = loops.block_of(planted.cell.map(i64::from));
        for block in (-4..=4).flat_map(|y| (-4..=4).map(move |x| [i + x, j + y])) {
            let (quadrants, ninths) = (reached(block, 2, volume), reached(block, 3, patch));
            if quadrants == 0 {
                continue;
            }
            entries += 1;
            let cell = block.map(|index| index * i64::from(loops.block_cells));
            let Listed { entry, .. } = listed(scene, planted, cell).expect("is listed");
            assert_eq!(entry.mask_2x2, quadrants, "{planted:?} in {block:?}");
            assert_eq!(entry.mask_3x3, ninths, "{planted:?} in {block:?}");
        }
    }
    assert_eq!(loops.entries.len(), entries);
}

#[test]
fn a_far_cell_of_a_wide_carpet_is_like_a_near_one() {
    let mut design = upright();
    design.pile.lean_x = 33.0;
    design.sheet.warps = 100_000;
    design.sheet.wefts = 6;
    let scene = compile(&design).unwrap();
    let loops = &*scene.loops;
    let first = loops.shapes[0];
    assert!(loops.shapes.iter().all(|shape| *shape == first));
    let cell = |i: i64| {
        let index = loops.header_index(loops.block_of([i, 3])).unwrap();
        let entries = loops.entries_of(index);
        assert!(!entries.is_empty());
        (loops.headers[index].z_range, entries.to_vec())
    };
    assert_eq!(cell(52), cell(99_952));
    assert_eq!(cell(54), cell(99_954));
}

#[test]
fn a_sheet_without_loops_has_an_empty_grid() {
    let mut design = upright();
    design.length.value = 0.0;
    let scene = compile(&design).unwrap();
    let loops = &scene.loops;
    assert!(loops.shapes.is_empty() && loops.entries.is_empty());
    assert!(scene.looks.is_empty());
    // One more ends the last list.
    let b = loops.block_cells;
    let blocks = 14_u32.div_ceil(b) * 11_u32.div_ceil(b);
    assert_eq!(loops.headers.len(), blocks as usize + 1);
    assert_eq!(loops.z_range_mm, [0.0, 0.0]);
    assert!(loops.headers.iter().all(|header| {
        let [low, high] = header.z_units();
        low > high && header.planted == 0
    }));
}

#[test]
fn entries_keep_what_is_packed_into_them() {
    let mut random = Pcg::new(3, 0);
    let mut below = |end: i64| (f64::from(random.next_float()) * end as f64) as i64;
    for block_cells in [1, 2, 4] {
        for farthest in 0..=EntryLayout::FARTHEST {
            let layout = EntryLayout::new(block_cells, farthest);
            let bits = 2 * (layout.offset_bits + layout.height_bits) + layout.place_bits + 13;
            assert!(bits <= 32 && layout.height_bits >= 2, "{layout:?}");
            for _ in 0..200 {
                let mut offset = || (below(2 * farthest + 1) - farthest) as i32;
                let parts = EntryParts {
                    offset: [offset(), offset()],
                    place: below(2 * i64::from(block_cells).pow(2)) as u32,
                    mask_2x2: below(16) as u32,
                    mask_3x3: below(512) as u32,
                    heights: [0; 2].map(|_| below(layout.height_steps().into()) as u32),
                };
                assert_eq!(layout.unpack(layout.pack(parts)), parts, "{layout:?}");
            }
        }
    }
}

#[test]
fn shapes_are_off_by_half_a_unit_at_most() {
    use renderer_core::scene::{FrameSettings, Jitter, LoopInput, loop_hash, loop_shape};
    let design = plain();
    let scene = compile(&design).unwrap();
    let (sheet, loops) = (&*scene.sheet, &*scene.loops);
    let unit = f64::from(loops.length_unit_mm);
    // The longest component, of a loop of 2.8 mm stretched by 15 % and 8 % more at random, is stored in 15 bits; nine
    // bits of the unit may cost 1/256.
    assert!(unit < 2.8 * 1.23 / 32_767.0 * 1.004, "{unit}");
    assert_eq!(
        loops.length_unit_mm.to_bits() & 0x7fff,
        0,
        "nine significant bits"
    );
    // Without turbulence: what is left of the design is known here.
    let mut still = design.clone();
    (still.pile.tilt, still.pile.twist, still.pile.stretch) = (0.0, 0.0, 0.0);
    let scene = compile(&still).unwrap();
    let loops = &scene.loops;
    let unit = f64::from(loops.length_unit_mm);
    let settings = FrameSettings::new(&still.pile);
    let mut worst = 0.0_f64;
    for planted in (0..sheet.wefts).flat_map(|j| loops.planted_in_row(sheet, j)) {
        let stored = loops.patch(planted.index as usize);
        let [i, j] = planted.cell;
        let input = LoopInput {
            face: planted.face,
            root_heights: [stored.root_z0, stored.root_z1]
                .map(|z| f64::from(z) * planted.face.sign()),
            length: still.length.value,
            turbulence: [0.0; 4],
            jitter: Jitter::new(loop_hash(still.turbulence.seed, i, j, planted.face)),
            finish: Default::default(),
        };
        let asked = loop_shape(&settings, &input, &mut Default::default()).unwrap();
        let pairs = stored.axis.into_iter().chain(stored.half_top);
        let pairs = pairs.zip(asked.axis.into_iter().chain(asked.half_top));
        for (stored, asked) in pairs {
            worst = worst.max((f64::from(stored) - f64::from(asked)).abs());
        }
    }
    // f32's rounding of what was asked for comes on top, and that roots are already rounded here.
    assert!(
        worst <= 0.51 * unit && worst > 0.4 * unit,
        "{worst}, unit {unit}"
    );
}

#[test]
fn the_farthest_loops_are_found() {
    // As far as a design may ask for: 60 cells of 10/7 mm.
    let mut design = small(&Pile {
        max_length: 100.0,
        lean_x: 74.0,
        jitter: 5.0,
        ..Pile::default()
    });
    (design.sheet.warps_per_cm, design.sheet.wefts_per_cm) = (7.0, 7.0);
    design.length.value = 60.0;
    (design.pile.stretch, design.pile.length_jitter) = (0.0, 0.0);
    while design.faults().is_empty() {
        design.length.value += 1.0;
    }
    design.length.value -= 1.0;
    let scene = compile(&design).unwrap();
    assert_eq!(scene.loops.block_cells, 4);
    assert_eq!(scene.loops.entry_layout.offset_bits, 5);
    check_grid_holds_volumes(&scene, 50_000);
}

#[test]
fn records_stay_small() {
    // The budget is 64 bytes a loop; of these the second has the most crowded loops of all presets.
    for name in ["paper-fig1", "hotel-white"] {
        let design = load_design(&preset_path(name));
        let scene = compile(&design).unwrap();
        let bytes = scene.loops.bytes_per_loop();
        assert!(bytes <= 64.0, "{name}: {bytes} bytes a loop");
    }
}
