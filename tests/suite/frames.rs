//! Loop frames, their grid, and the sections of a scene (MODEL.md §4, §6; ARCHITECTURE.md, State).

use glam::DVec3;
use renderer_core::design::Design;
use renderer_core::sampling::Pcg;
use renderer_core::scene::{Scene, compile};

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

#[test]
fn grid_lists_every_point_of_every_loop() {
    let scene = compile(&Design::default()).expect("the default compiles");
    check_grid_holds_volumes(&scene, 200_000);
}

#[test]
#[ignore = "a measurement"]
fn measure() {
    for (warps, wefts) in [(120, 140), (240, 280), (960, 1120)] {
        let mut design = Design::default();
        design.sheet.warps = warps;
        design.sheet.wefts = wefts;
        let mut best = f64::INFINITY;
        let mut scene = None;
        for _ in 0..3 {
            let start = std::time::Instant::now();
            scene = Some(compile(&design).expect("compiles"));
            best = best.min(start.elapsed().as_secs_f64());
        }
        let loops = &scene.expect("compiled").loops;
        let count = loops.shapes.len() as f64;
        eprintln!(
            "{warps} x {wefts}: {:.2} us/loop, {:.1} bytes/loop, {:.2} entries/loop, {:.2} entries/cell, {:?}, z {:?}, margin {:?}",
            best * 1e6 / count,
            loops.bytes_per_loop(),
            loops.entries.len() as f64 / count,
            loops.entries.len() as f64 / loops.headers.len() as f64,
            loops.counts,
            loops.z_range_mm,
            loops.margin,
        );
    }
}
