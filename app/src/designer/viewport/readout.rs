//! What lies under the pointer: the cell of the weave, the loop that stands in it, its yarn's colour.

use egui::Color32;
use glam::DVec2;
use renderer_core::design::Design;
use renderer_core::geometry::{Camera, Ray};
use renderer_core::scene::lod::{Level, LodCloth};
use renderer_core::scene::{ChartOnSheet, Face, Scene};

/// A cell under the pointer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Readout {
    /// Warp and weft, from 0 at the left of the near edge.
    pub cell: [u32; 2],
    /// Length of the loop on the side that is seen, mm; `None` where none stands.
    pub loop_mm: Option<f64>,
    /// Colour of its yarn in the chart.
    pub colour: Option<[u8; 3]>,
}

impl Readout {
    /// What a camera's ray through a pixel meets: the plane, or of bent cloth the surface, through the middle of the
    /// pile on the side that is seen, since it is loops one points at, not the ground below them.
    pub fn new(
        design: &Design,
        cloth: &LodCloth,
        camera: &Camera,
        pixel: DVec2,
        size: [u32; 2],
    ) -> Option<Self> {
        let row = (pixel.y.max(0.0) as u32).min(size[1].saturating_sub(1));
        let view = cloth.view(design, camera, size);
        let Level { scene, camera } = view.at_row(row, size[1]);
        let (origin, direction) = camera.ray(pixel, size);
        let z_range = scene.loops.z_range_mm.map(f64::from);
        let heights = [z_range[1].max(0.0) / 2.0, z_range[0].min(0.0) / 2.0];
        let (at, is_front) = if let Some(form) = &*scene.form {
            form.pick(&Ray { origin, direction }, heights)?
        } else {
            let is_front = direction.z < 0.0;
            let height = heights[usize::from(!is_front)];
            let distance = (height - origin.z) / direction.z;
            if !(distance.is_finite() && distance > 0.0) {
                return None;
            }
            ((origin + direction * distance).truncate(), is_front)
        };
        let sheet = &scene.sheet;
        let cell = |at: f64, pitch: f64, count: u32| {
            let cell = (at / pitch + f64::from(count) / 2.0).floor();
            (cell >= 0.0 && cell < f64::from(count)).then_some(cell as u32)
        };
        let i = cell(at.x, sheet.pitch_x_mm, sheet.warps)?;
        let j = cell(at.y, sheet.pitch_y_mm, sheet.wefts)?;
        let face = if is_front { Face::Front } else { Face::Back };
        // The design may already be another than that of the scene in the picture.
        let [warps, wefts] = sheet.whole_cells();
        let is_same = [design.sheet.warps, design.sheet.wefts] == [warps, wefts];
        let chart = ChartOnSheet::new(&design.chart, &design.weave, [warps, wefts]);
        let [warp, weft] = sheet.original(i as usize, j as usize);
        Some(Self {
            cell: [warp, weft].map(|index| index as u32),
            loop_mm: loop_mm(scene, [i, j], face),
            colour: chart.colour(warp, weft).filter(|_| is_same),
        })
    }

    /// "warp 12, weft 140 · loop 2.8 mm".
    pub fn text(&self) -> String {
        let [warp, weft] = self.cell.map(|index| index + 1);
        let what = match self.loop_mm {
            Some(mm) => format!("loop {mm:.1} mm"),
            None => "no loop".into(),
        };
        format!("warp {warp}, weft {weft} · {what}")
    }

    /// Colour of the loop's yarn.
    pub fn yarn(&self) -> Option<Color32> {
        let [r, g, b] = self.colour.filter(|_| self.loop_mm.is_some())?;
        Some(Color32::from_rgb(r, g, b))
    }
}

/// Length of the loop that stands on a side of a cell, from its root to the middle of its top, mm.
fn loop_mm(scene: &Scene, cell: [u32; 2], face: Face) -> Option<f64> {
    let index = scene.loops.loop_at(cell, face)?;
    let [x, y, z] = scene.loops.patch(index as usize).axis.map(f64::from);
    Some((x * x + y * y + z * z).sqrt())
}
