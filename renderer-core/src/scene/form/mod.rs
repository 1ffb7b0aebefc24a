//! Form: how the cloth lies in space (MODEL.md §14, the paper's future work 3).
//!
//! The cloth is a shell around a surface, S(x, y) + z·n(x, y), with z between the lowest and the highest point of pile
//! and ground. Facets of some blocks each cut it into hexahedra, and each of these is six tetrahedra, in which the map
//! from the flat sheet is affine and continuous from one to the next (shell maps: Porumbescu et al., SIGGRAPH 2005; the
//! six by Kuhn, 1960). So a straight ray through space is a chain of straight pieces through the flat cloth, and
//! everything that is known of flat cloth serves: pile bends with the shell, ground yarns have no seams, and the grid
//! of blocks is walked as ever.
//!
//! Spaces: *sheet* is the flat cloth, *world* where it lies; `world_from_sheet`. In a tetrahedron a place is given in
//! *coordinates* of its hexahedron, from 0 to 1 along x, y and z.
//!
//! Longer than most files because every question about the mesh rests on the same corners and boxes.

mod height;
mod net;
mod profile;
mod surface;

pub use net::{Net, net_through};

use glam::{DMat3, DVec2, DVec3};

use self::surface::Surface;
use super::{Loops, PileReach, SheetGeometry};
use crate::design::{Design, Fault, Form, FormKind};
use crate::geometry::{Interval, Ray, clip_to_box};

/// Angle between neighbouring facets up to which they are made larger, radians: the map's bends hardly show in pile.
const FACET_ANGLE: f64 = 0.1;
/// Most blocks along a facet's side.
const MOST_BLOCKS: u32 = 16;
/// Most facets along a side of the sheet.
const MOST_FACETS: u32 = 1024;
/// Least share of its flat volume that a tetrahedron keeps: below, pile would pass through itself.
const LEAST_VOLUME: f64 = 0.02;
/// Boxes are this much too large, mm and as a share of the farthest corner: f32 rounds.
const ROOMY: f64 = 1e-5;

/// A bent cloth: the corners of its facets, and boxes around them.
#[derive(Debug, Clone, PartialEq)]
pub struct FormMesh {
    /// Facets along x and y.
    pub facets: [u32; 2],
    /// Cells along a facet's sides.
    pub facet_cells: u32,
    /// The first cell of the first facet.
    pub first_cell: [i32; 2],
    /// Lowest and highest z of the flat cloth, mm.
    pub heights: [f64; 2],
    /// World position of the lower and the upper end of each corner, mm: row by row, one more than there are facets.
    pub corners: Vec<[[f32; 3]; 2]>,
    /// Least and greatest corner of boxes, mm: of each facet, row by row; then of every 2 × 2 of them, and so on up to
    /// one.
    pub boxes: Vec<[[f32; 3]; 2]>,
    /// How many boxes each of these levels has along x and y.
    pub levels: Vec<[u32; 2]>,
    sheet: SheetGeometry,
}

/// One of the six tetrahedra of a facet: that in which coordinates fall along these axes, from the first to the third.
pub type KuhnTetrahedron = [usize; 3];

/// The six.
pub const KUHN_TETRAHEDRA: [KuhnTetrahedron; 6] = [
    [0, 1, 2],
    [0, 2, 1],
    [1, 0, 2],
    [1, 2, 0],
    [2, 0, 1],
    [2, 1, 0],
];

/// The map of a tetrahedron: `origin` + `per_coordinate`·coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TetMap {
    /// World position of coordinates 0, mm.
    pub origin: DVec3,
    /// World vectors along x, y and z for coordinates of 1, mm.
    pub per_coordinate: DMat3,
}

impl TetMap {
    /// The world position of coordinates.
    pub fn at(&self, coordinates: DVec3) -> DVec3 {
        self.origin + self.per_coordinate * coordinates
    }

    /// The rotation nearest to the map: x stays in the plane of x and y, and z is its normal. It turns directions of
    /// light and fibres, whose lengths are 1.
    pub fn rotation(&self) -> DMat3 {
        let [x, y] = [self.per_coordinate.x_axis, self.per_coordinate.y_axis];
        let z = x.cross(y).normalize_or(DVec3::Z);
        let x = x.normalize_or(DVec3::X);
        DMat3::from_cols(x, z.cross(x), z)
    }
}

impl FormMesh {
    /// The mesh of a form, with loops and ground yarns between two heights; `None` for level cloth.
    ///
    /// # Errors
    /// When the form has no room for the pile, or bends so sharply that pile passes through itself.
    pub fn new(
        form: &Form,
        sheet: &SheetGeometry,
        loops: &Loops,
        heights: [f64; 2],
    ) -> Result<Option<Self>, Fault> {
        let pitch = DVec2::new(sheet.pitch_x_mm, sheet.pitch_y_mm);
        let size = DVec2::new(f64::from(sheet.warps), f64::from(sheet.wefts)) * pitch;
        let block_cells = loops.block_cells;
        let block_mm = pitch * f64::from(block_cells);
        let beyond = loops.margin.map(|blocks| f64::from(blocks + MOST_BLOCKS));
        let margin = (DVec2::from_array(beyond) * block_mm).max_element();
        let Some(surface) = Surface::new(form, size, margin, heights)? else {
            return Ok(None);
        };
        let first_cell = loops.margin.map(|blocks| -((blocks * block_cells) as i32));
        let blocks = loops.blocks;
        let sheet_at = |[i, j]: [u32; 2], step: u32| {
            let cell =
                |first: i32, index: u32| f64::from(first) + f64::from(index * step * block_cells);
            let cells = DVec2::new(cell(first_cell[0], i), cell(first_cell[1], j));
            cells * pitch - 0.5 * size
        };
        let step = facet_blocks(&surface, blocks, |place| sheet_at(place, 1));
        let facets = blocks.map(|blocks| blocks.div_ceil(step));
        let [columns, rows] = facets.map(|count| count + 1);
        let [low, high] = heights;
        let corner = |index: u32| {
            let place = sheet_at([index % columns, index / columns], step);
            let (point, normal) = (surface.point(place), surface.normal(place));
            [low, high].map(|z| (point + normal * z).as_vec3().to_array())
        };
        let corners = (0..columns * rows).map(corner).collect();
        let mut mesh = Self {
            facets,
            facet_cells: step * block_cells,
            first_cell,
            heights,
            corners,
            boxes: Vec::new(),
            levels: Vec::new(),
            sheet: *sheet,
        };
        mesh.check(form)?;
        mesh.make_boxes();
        Ok(Some(mesh))
    }

    /// Finds where pile passes through itself.
    fn check(&self, form: &Form) -> Result<(), Fault> {
        let flat = self.facet_mm();
        let flat = flat.x * flat.y * flat.z;
        for facet in self.all_facets() {
            for tetrahedron in KUHN_TETRAHEDRA {
                let volume = self.tet(facet, tetrahedron).per_coordinate.determinant() / flat;
                // NaN, of a net whose points all coincide, is not sound either.
                let is_sound = volume >= LEAST_VOLUME;
                if !is_sound {
                    let at = self.sheet_of(facet, DVec3::splat(0.5));
                    let [low, high] = self.heights;
                    let gentler = "a form with gentler bends, or shorter pile";
                    let (path, value, allowed) = match form.kind {
                        FormKind::Net => ("form.net", format!("{:?}", form.kind.name()), gentler),
                        FormKind::Height => (
                            "form.height",
                            form.height.to_string(),
                            "less height, more of form.smooth, another form.image, or shorter pile",
                        ),
                        _ => ("form.kind", format!("{:?}", form.kind.name()), gentler),
                    };
                    return Err(Fault {
                        path: path.into(),
                        value: format!(
                            "{value}, bent so sharply at {:.0}, {:.0} mm of the cloth that its pile, which stands from \
                             {low:.1} to {high:.1} mm, passes through itself",
                            at.x, at.y,
                        ),
                        allowed: allowed.into(),
                    });
                }
            }
        }
        Ok(())
    }

    /// All facets, row by row.
    pub fn all_facets(&self) -> impl Iterator<Item = [i64; 2]> + use<> {
        let [columns, rows] = self.facets.map(i64::from);
        (0..columns * rows).map(move |index| [index % columns, index / columns])
    }

    fn make_boxes(&mut self) {
        let corners = [0, 1]
            .map(|x| [0, 1].map(|y| [0, 1].map(|z| DVec3::new(x as f64, y as f64, z as f64))));
        let of_facet = |facet: [i64; 2]| {
            let mut bounds = [DVec3::INFINITY, DVec3::NEG_INFINITY];
            for coordinates in corners.as_flattened().as_flattened() {
                let at = self.corner(facet, *coordinates);
                bounds = [bounds[0].min(at), bounds[1].max(at)];
            }
            let room = ROOMY * (1.0 + bounds[0].abs().max(bounds[1].abs()).max_element());
            [bounds[0] - room, bounds[1] + room].map(|corner| corner.as_vec3().to_array())
        };
        let mut level: Vec<_> = self.all_facets().map(of_facet).collect();
        let mut counts = self.facets;
        let mut boxes = Vec::new();
        let mut levels = Vec::new();
        loop {
            boxes.extend_from_slice(&level);
            levels.push(counts);
            if counts == [1, 1] {
                break;
            }
            let halved = counts.map(|count| count.div_ceil(2));
            let merged = |index: u32| {
                let [x, y] = [index % halved[0], index / halved[0]].map(|index| 2 * index);
                let mut bounds = [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]];
                for (i, j) in [(x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1)] {
                    if i < counts[0] && j < counts[1] {
                        let [low, high] = level[(j * counts[0] + i) as usize];
                        for axis in 0..3 {
                            bounds[0][axis] = bounds[0][axis].min(low[axis]);
                            bounds[1][axis] = bounds[1][axis].max(high[axis]);
                        }
                    }
                }
                bounds
            };
            level = (0..halved[0] * halved[1]).map(merged).collect();
            counts = halved;
        }
        (self.boxes, self.levels) = (boxes, levels);
    }

    /// Least and greatest corner of the box around all of the cloth, world, mm.
    pub fn bounds(&self) -> [DVec3; 2] {
        let [low, high] = self.boxes.last().copied().unwrap_or_default();
        [low, high].map(|corner| corner.map(f64::from).into())
    }

    /// Size of a facet's hexahedron in the flat sheet, mm.
    pub fn facet_mm(&self) -> DVec3 {
        let pitch = DVec2::new(self.sheet.pitch_x_mm, self.sheet.pitch_y_mm);
        let [low, high] = self.heights;
        (pitch * f64::from(self.facet_cells)).extend(high - low)
    }

    /// Sheet position of the lowest corner of a facet's hexahedron, mm.
    fn facet_low(&self, facet: [i64; 2]) -> DVec3 {
        let [x, y] = [0, 1].map(|axis| {
            let cell = i64::from(self.first_cell[axis]) + facet[axis] * i64::from(self.facet_cells);
            let (count, pitch) = match axis {
                0 => (self.sheet.warps, self.sheet.pitch_x_mm),
                _ => (self.sheet.wefts, self.sheet.pitch_y_mm),
            };
            (cell as f64 - 0.5 * f64::from(count)) * pitch
        });
        DVec3::new(x, y, self.heights[0])
    }

    /// Sheet position of coordinates of a facet, mm.
    pub fn sheet_of(&self, facet: [i64; 2], coordinates: DVec3) -> DVec3 {
        self.facet_low(facet) + coordinates * self.facet_mm()
    }

    /// The facet that holds a sheet position, and its coordinates of that; of positions beyond the cloth the nearest
    /// facet.
    pub fn cell_coordinates_of(&self, sheet: DVec3) -> ([i64; 2], DVec3) {
        let size = self.facet_mm();
        let place = (sheet - self.facet_low([0, 0])) / size;
        let facet = [0, 1]
            .map(|axis| (place[axis].floor() as i64).clamp(0, i64::from(self.facets[axis]) - 1));
        let coordinates = place - DVec3::new(facet[0] as f64, facet[1] as f64, 0.0);
        (facet, coordinates)
    }

    /// Whether there is such a facet.
    pub fn has(&self, facet: [i64; 2]) -> bool {
        (0..2).all(|axis| (0..i64::from(self.facets[axis])).contains(&facet[axis]))
    }

    /// World position of a corner of a facet's hexahedron; coordinates are 0 or 1.
    fn corner(&self, [i, j]: [i64; 2], coordinates: DVec3) -> DVec3 {
        let (i, j) = (i + coordinates.x as i64, j + coordinates.y as i64);
        let index = j * (i64::from(self.facets[0]) + 1) + i;
        let corner = self.corners[index as usize][coordinates.z as usize];
        corner.map(f64::from).into()
    }

    /// The map of one of a facet's tetrahedra.
    pub fn tet(&self, facet: [i64; 2], tetrahedron: KuhnTetrahedron) -> TetMap {
        let mut coordinates = DVec3::ZERO;
        let origin = self.corner(facet, coordinates);
        let mut per_coordinate = DMat3::ZERO;
        let mut last = origin;
        for axis in tetrahedron {
            coordinates[axis] = 1.0;
            let next = self.corner(facet, coordinates);
            *per_coordinate.col_mut(axis) = next - last;
            last = next;
        }
        TetMap {
            origin,
            per_coordinate,
        }
    }

    /// The tetrahedron of a facet that holds coordinates.
    pub fn tetrahedron_of(coordinates: DVec3) -> KuhnTetrahedron {
        let mut tetrahedron = [0, 1, 2];
        tetrahedron.sort_by(|&a, &b| coordinates[b].total_cmp(&coordinates[a]));
        tetrahedron
    }

    /// The tetrahedron that holds a world position, if any does.
    pub fn holding(&self, point: DVec3) -> Option<([i64; 2], KuhnTetrahedron)> {
        let facets =
            self.facets_where(|[low, high]| low.cmple(point).all() && point.cmple(high).all());
        let mut tets = facets
            .into_iter()
            .flat_map(|facet| KUHN_TETRAHEDRA.map(|tetrahedron| (facet, tetrahedron)));
        tets.find(|&(facet, tetrahedron)| {
            let map = self.tet(facet, tetrahedron);
            let coordinates = map.per_coordinate.inverse() * (point - map.origin);
            let [first, second, third] = tetrahedron.map(|axis| coordinates[axis]);
            first <= 1.0 && second <= first && third <= second && third >= 0.0
        })
    }

    /// Where a ray of the world first meets the front from in front, or the back from behind: the surface through the
    /// flat cloth's points of a height of the front, or of one of the back, mm. The sheet position (x, y), and whether
    /// it is the front.
    pub fn pick(&self, ray: &Ray, [front, back]: [f64; 2]) -> Option<(DVec2, bool)> {
        let mut nearest: Option<(f64, DVec2, bool)> = None;
        for facet in self.facets_along(ray) {
            for tetrahedron in KUHN_TETRAHEDRA {
                let map = self.tet(facet, tetrahedron);
                let coordinates_per_mm = map.per_coordinate.inverse();
                let origin = coordinates_per_mm * (ray.origin - map.origin);
                let slope = coordinates_per_mm * ray.direction;
                let is_front = slope.z < 0.0;
                let height = if is_front { front } else { back };
                let share = (height - self.heights[0]) / (self.heights[1] - self.heights[0]);
                let t = (share - origin.z) / slope.z;
                let coordinates = origin + slope * t;
                let is_here = Self::tetrahedron_of(coordinates) == tetrahedron
                    && coordinates.min_element() >= 0.0
                    && coordinates.max_element() <= 1.0;
                if is_here && t > 0.0 && nearest.is_none_or(|(last, ..)| t < last) {
                    nearest = Some((t, self.sheet_of(facet, coordinates).truncate(), is_front));
                }
            }
        }
        nearest.map(|(_, at, is_front)| (at, is_front))
    }

    /// The facets whose boxes a ray of the world meets, in no order.
    pub fn facets_along(&self, ray: &Ray) -> Vec<[i64; 2]> {
        let whole = Interval::new(0.0, f64::INFINITY);
        self.facets_where(|[low, high]| !clip_to_box(ray, whole, low, high).is_empty())
    }

    /// The facets whose boxes, and all boxes around these, are `wanted`, which is given their least and greatest
    /// corner, world, mm.
    fn facets_where(&self, wanted: impl Fn([DVec3; 2]) -> bool) -> Vec<[i64; 2]> {
        let mut facets = Vec::new();
        self.add_facets_where(&wanted, self.levels.len() - 1, [0, 0], &mut facets);
        facets
    }

    fn add_facets_where(
        &self,
        wanted: &impl Fn([DVec3; 2]) -> bool,
        level: usize,
        [x, y]: [u32; 2],
        facets: &mut Vec<[i64; 2]>,
    ) {
        let [columns, rows] = self.levels[level];
        if x >= columns || y >= rows {
            return;
        }
        let bounds = self.boxes[self.first_box(level) + (y * columns + x) as usize];
        if !wanted(bounds.map(|corner| corner.map(f64::from).into())) {
            return;
        }
        if level == 0 {
            facets.push([i64::from(x), i64::from(y)]);
            return;
        }
        for [i, j] in [[0, 0], [1, 0], [0, 1], [1, 1]] {
            self.add_facets_where(wanted, level - 1, [2 * x + i, 2 * y + j], facets);
        }
    }

    /// Index of the first box of a level.
    pub fn first_box(&self, level: usize) -> usize {
        let counts = self.levels[..level].iter();
        counts
            .map(|&[columns, rows]| columns as usize * rows as usize)
            .sum()
    }

    /// Calls `visit` with the faces of a facet's tetrahedra that are the cloth's outside: which tetrahedron, the face's
    /// corners, and the corner opposite to it, world, mm.
    pub fn outer_faces(
        &self,
        facet: [i64; 2],
        mut visit: impl FnMut(KuhnTetrahedron, [DVec3; 3], DVec3),
    ) {
        let is_border = |axis: usize, side: i64| {
            let mut beyond = facet;
            if axis < 2 {
                beyond[axis] += side;
            }
            axis == 2 || !self.has(beyond)
        };
        for tetrahedron in KUHN_TETRAHEDRA {
            let [first, _, third] = tetrahedron;
            let (ahead, behind) = (is_border(first, 1), is_border(third, -1));
            if ahead || behind {
                let mut coordinates = DVec3::ZERO;
                let mut corners = [self.corner(facet, coordinates); 4];
                for (corner, axis) in corners[1..].iter_mut().zip(tetrahedron) {
                    coordinates[axis] = 1.0;
                    *corner = self.corner(facet, coordinates);
                }
                let [a, b, c, d] = corners;
                if ahead {
                    visit(tetrahedron, [b, c, d], a);
                }
                if behind {
                    visit(tetrahedron, [a, b, c], d);
                }
            }
        }
    }

    /// How directions of the sheet are turned into those of the world at a sheet position.
    pub fn rotation_at(&self, sheet: DVec3) -> DMat3 {
        let (facet, coordinates) = self.cell_coordinates_of(sheet);
        self.tet(facet, Self::tetrahedron_of(coordinates))
            .rotation()
    }

    /// World position of a sheet position.
    pub fn world_of(&self, sheet: DVec3) -> DVec3 {
        let (facet, coordinates) = self.cell_coordinates_of(sheet);
        self.tet(facet, Self::tetrahedron_of(coordinates))
            .at(coordinates)
    }

    /// Bytes of the mesh.
    pub fn bytes(&self) -> u64 {
        (size_of_val(&*self.corners) + size_of_val(&*self.boxes)) as u64
    }
}

/// About the box around the cloth of a design that is not level, world, mm: of some points of its surface, as high and
/// as low as its loops may be. `None` also for designs with faults, and for forms that have no room for the pile.
pub fn bent_box(design: &Design) -> Option<[DVec3; 2]> {
    /// Points along each side.
    const POINTS: u32 = 48;
    if !design.faults().is_empty() {
        return None;
    }
    let reach = PileReach::of(design);
    let sheet = &reach.sheet;
    let size = DVec2::new(
        f64::from(sheet.warps) * sheet.pitch_x_mm,
        f64::from(sheet.wefts) * sheet.pitch_y_mm,
    );
    let heights = [reach.low_mm[2], reach.high_mm[2]];
    let surface = Surface::new(&design.form, size, 0.0, heights).ok()??;
    let mut bounds = [DVec3::INFINITY, DVec3::NEG_INFINITY];
    for index in 0..(POINTS + 1).pow(2) {
        let share = DVec2::new(
            f64::from(index % (POINTS + 1)),
            f64::from(index / (POINTS + 1)),
        ) / f64::from(POINTS);
        let at = (share - 0.5) * size;
        let (point, normal) = (surface.point(at), surface.normal(at));
        for height in heights {
            let end = point + normal * height;
            bounds = [bounds[0].min(end), bounds[1].max(end)];
        }
    }
    Some(bounds)
}

/// How many blocks a facet is wide and deep: as many as keep the angle between neighbours small.
fn facet_blocks(
    surface: &Surface,
    [columns, rows]: [u32; 2],
    sheet_at: impl Fn([u32; 2]) -> DVec2,
) -> u32 {
    let mut sharpest = 0.0_f64;
    // Normals along some rows and columns, where the form bends alike beside them.
    let most_lines = if surface.bends_alike() { 16 } else { u32::MAX };
    for (rows, columns, across) in [(rows, columns, false), (columns, rows, true)] {
        let every = rows.div_ceil(most_lines).max(1);
        for line in (0..=rows).step_by(every as usize) {
            let normal = |index| {
                let place = if across { [line, index] } else { [index, line] };
                surface.normal(sheet_at(place))
            };
            let mut last = normal(0);
            for index in 1..=columns {
                let next = normal(index);
                sharpest = sharpest.max(last.angle_between(next));
                last = next;
            }
        }
    }
    let by_angle = (FACET_ANGLE / sharpest.max(1e-9)).min(f64::from(MOST_BLOCKS)) as u32;
    let by_count = columns.max(rows).div_ceil(MOST_FACETS);
    by_angle.max(1).max(by_count)
}
