//! Up to four loops of a block against a ray at once: which of them it may cross at all. Most that heights and quadrants leave
//! over it passes by; a scalar solve of the rest finds where.

use glam::{Vec3A, Vec4};

use super::block::{BlockRay, Listed};
use super::cloth::Cloth;
use super::lanes::{LANES, Vectors};

/// Rounding of the coefficients below, per square of the sizes of what they are products of: some ten roundings of f32.
const ROUNDING: f32 = 2e-6;

/// Loops that are looked at together.
#[derive(Debug)]
pub(super) struct Batch {
    index: [u32; LANES],
    /// Where their cells' centres are from that of the block's first, mm.
    x: [f32; LANES],
    y: [f32; LANES],
    /// Their shapes: axis, half top edge and root heights, in units of length.
    axis: [[f32; LANES]; 3],
    half_top: [[f32; LANES]; 3],
    roots: [[f32; LANES]; 2],
    count: usize,
}

impl Batch {
    #[inline(always)]
    pub fn new() -> Self {
        Self {
            index: [0; LANES],
            x: [0.0; LANES],
            y: [0.0; LANES],
            axis: [[0.0; LANES]; 3],
            half_top: [[0.0; LANES]; 3],
            roots: [[0.0; LANES]; 2],
            count: 0,
        }
    }

    #[inline(always)]
    pub fn is_full(&self) -> bool {
        self.count == LANES
    }

    #[inline(always)]
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    #[inline(always)]
    pub fn len(&self) -> usize {
        self.count
    }

    /// Adds a loop; there is room.
    #[inline(always)]
    pub fn push(&mut self, cloth: &Cloth, listed: Listed) {
        let lane = self.count & (LANES - 1);
        let shape = &cloth.scene.loops.shapes[listed.index as usize];
        self.index[lane] = listed.index;
        self.x[lane] = listed.cell.x;
        self.y[lane] = listed.cell.y;
        self.axis[0][lane] = f32::from(shape.axis[0]);
        self.axis[1][lane] = f32::from(shape.axis[1]);
        self.axis[2][lane] = f32::from(shape.axis[2]);
        self.half_top[0][lane] = f32::from(shape.half_top[0]);
        self.half_top[1][lane] = f32::from(shape.half_top[1]);
        self.half_top[2][lane] = f32::from(shape.half_top[2]);
        self.roots[0][lane] = f32::from(shape.root_z0);
        self.roots[1][lane] = f32::from(shape.root_z1);
        self.count += 1;
    }

    /// A bit for each loop.
    #[inline(always)]
    pub fn all(&self) -> u32 {
        (1 << self.count) - 1
    }

    /// The loop of a lane.
    #[inline(always)]
    pub fn loop_of(&self, lane: usize) -> Listed {
        let lane = lane & (LANES - 1);
        Listed {
            index: self.index[lane],
            cell: Vec3A::new(self.x[lane], self.y[lane], 0.0),
        }
    }

    /// Forgets all.
    #[inline(always)]
    pub fn clear(&mut self) {
        self.count = 0;
    }

    /// A bit for each loop that the ray may cross: 0 for those whose patch has no point (u, v) in [0, 1]² on the ray's line.
    ///
    /// With the line's point m nearest to the patch's middle, a crossing (u′, v′) makes (m + u′b)·((c + u′A) × d) vanish, and
    /// the same with b and c exchanged for v′. Neither quadratic can where its constant outweighs the rest in [−½, ½].
    #[inline(always)]
    pub fn crossed(&self, cloth: &Cloth, part: &BlockRay) -> u32 {
        let unit = Vec4::splat(cloth.length_unit);
        let half_unit = unit * 0.5;
        let lanes = |fields: [f32; LANES]| Vec4::from_array(fields);
        let [ax, ay, az] = [self.axis[0], self.axis[1], self.axis[2]];
        let [ex, ey, ez] = [self.half_top[0], self.half_top[1], self.half_top[2]];
        let axis = Vectors {
            x: lanes(ax) * unit,
            y: lanes(ay) * unit,
            z: lanes(az) * unit,
        };
        let half_top = Vectors {
            x: lanes(ex) * unit,
            y: lanes(ey) * unit,
            z: lanes(ez) * unit,
        };
        let (z0, z1) = (lanes(self.roots[0]), lanes(self.roots[1]));
        let half_base = Vectors {
            x: Vec4::ZERO,
            y: Vec4::splat(0.5 * cloth.base_width),
            z: (z1 - z0) * half_unit,
        };
        let root = Vectors {
            x: lanes(self.x),
            y: lanes(self.y),
            z: (z0 + z1) * half_unit,
        };
        let half = Vec4::splat(0.5);
        let along_u = half_base.plus(half_top);
        let twist = half_top.minus(half_base).scaled(Vec4::splat(2.0));
        let to_middle = root
            .plus(axis.scaled(half))
            .minus(Vectors::splat(part.point));
        let direction = Vectors::splat(part.direction);
        let middle = to_middle.minus(direction.scaled(to_middle.dot(direction)));

        let u_cross = along_u.cross(direction);
        let v_cross = axis.cross(direction);
        let twist_cross = twist.cross(direction);
        let bent = middle.dot(twist_cross);
        let size = middle.size() + axis.size() + along_u.size();
        let rounding = size * size * ROUNDING;
        // Constant, linear and square coefficients for u′ and for v′.
        let [u0, u1, u2] = [
            middle.dot(v_cross),
            bent + along_u.dot(v_cross),
            along_u.dot(twist_cross),
        ];
        let [v0, v1, v2] = [
            middle.dot(u_cross),
            bent + axis.dot(u_cross),
            axis.dot(twist_cross),
        ];
        let u_excess = u0.abs() - (u1.abs() * half + u2.abs() * 0.25);
        let v_excess = v0.abs() - (v1.abs() * half + v2.abs() * 0.25);
        let missed = u_excess.cmpgt(rounding) | v_excess.cmpgt(rounding);
        !missed.bitmask() & self.all()
    }
}
