//! Eight loops of a block against a ray at once: their patches, and which of them the ray may cross at all. Most that
//! heights and subcells leave over it passes by; a scalar solve of the rest finds where.

use super::block_ray::{BlockRay, Listed};
use super::cloth::Cloth;
use super::lanes::{LANES, Lanes, Vectors};

/// Rounding of the coefficients below, per square of the sizes of what they are products of: some ten roundings of f32.
const ROUNDING: f32 = 2e-6;

/// Loops that are looked at together.
#[derive(Debug)]
pub(super) struct Batch {
    index: [u32; LANES],
    /// Where their cells' centres are from that of the block's first, mm.
    x: [f32; LANES],
    y: [f32; LANES],
    count: usize,
}

/// The patches of the loops of a batch; lanes without a loop hold any patch. Vectors as in [`super::patch::Patch`].
pub(super) struct Patches<L> {
    pub middle: Vectors<L>,
    pub along_u: Vectors<L>,
    pub along_v: Vectors<L>,
    pub twist: Vectors<L>,
}

impl Batch {
    #[inline(always)]
    pub fn new() -> Self {
        Self {
            index: [0; LANES],
            x: [0.0; LANES],
            y: [0.0; LANES],
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
    pub fn push(&mut self, listed: Listed) {
        let lane = self.count & (LANES - 1);
        self.index[lane] = listed.index;
        [self.x[lane], self.y[lane]] = listed.cell;
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
            cell: [self.x[lane], self.y[lane]],
        }
    }

    /// Indices of the loops; of any loop in lanes without one.
    #[inline(always)]
    pub fn indices(&self) -> [u32; LANES] {
        self.index
    }

    /// Forgets all.
    #[inline(always)]
    pub fn clear(&mut self) {
        self.count = 0;
    }

    /// The loops' patches, seen from where the ray enters the block.
    #[inline(always)]
    pub fn patches<L: Lanes>(&self, cloth: &Cloth, part: &BlockRay) -> Patches<L> {
        let shapes = &cloth.scene.loops.shapes;
        let mut records = [[0; LANES]; LANES];
        for (record, &index) in records.iter_mut().zip(&self.index) {
            *record = bytemuck::cast(shapes[index as usize]);
        }
        let [ax, ay, az, z0, ex, ey, ez, z1] = L::columns(records);
        let unit = L::splat(cloth.length_unit);
        let half = L::splat(0.5);
        let half_unit = unit * half;
        let units = Vectors {
            x: ax,
            y: ay,
            z: az,
        };
        let axis = units.scaled(unit);
        let units = Vectors {
            x: ex,
            y: ey,
            z: ez,
        };
        let half_top = units.scaled(unit);
        let half_base = Vectors {
            x: L::splat(0.0),
            y: L::splat(0.5 * cloth.base_width),
            z: (z1 - z0) * half_unit,
        };
        let root = Vectors {
            x: L::load(&self.x),
            y: L::load(&self.y),
            z: (z0 + z1) * half_unit,
        };
        Patches {
            middle: root
                .plus(axis.scaled(half))
                .minus(Vectors::splat(part.point)),
            along_u: half_base.plus(half_top),
            along_v: axis,
            twist: half_top.minus(half_base).scaled(L::splat(2.0)),
        }
    }

    /// A bit for each loop that the ray may cross: 0 for those whose patch has no point (u, v) in [0, 1]² on the ray's
    /// line.
    ///
    /// With the line's point m nearest to the patch's middle, a crossing (u′, v′) makes (m + u′b)·((c + u′A) × d)
    /// vanish, and the same with b and c exchanged for v′. Neither quadratic can where its constant outweighs the rest
    /// in [−½, ½].
    #[inline(always)]
    pub fn crossed<L: Lanes>(&self, cloth: &Cloth, part: &BlockRay) -> u32 {
        let Patches {
            middle: to_middle,
            along_u,
            along_v,
            twist,
        } = self.patches::<L>(cloth, part);
        let half = L::splat(0.5);
        let direction = Vectors::splat(part.direction);
        let middle = to_middle.minus(direction.scaled(to_middle.dot(direction)));

        let u_cross = along_u.cross(direction);
        let v_cross = along_v.cross(direction);
        let twist_cross = twist.cross(direction);
        let bent = middle.dot(twist_cross);
        let size = middle.size() + along_v.size() + along_u.size();
        let rounding = size * size * L::splat(ROUNDING);
        // Constant, linear and square coefficients for u′ and for v′.
        let [u0, u1, u2] = [
            middle.dot(v_cross),
            bent + along_u.dot(v_cross),
            along_u.dot(twist_cross),
        ];
        let [v0, v1, v2] = [
            middle.dot(u_cross),
            bent + along_v.dot(u_cross),
            along_v.dot(twist_cross),
        ];
        let quarter = L::splat(0.25);
        let u_excess = u0.abs() - (u1.abs() * half + u2.abs() * quarter);
        let v_excess = v0.abs() - (v1.abs() * half + v2.abs() * quarter);
        let missed = rounding.lt(u_excess) | rounding.lt(v_excess);
        !L::bits(missed) & self.all()
    }
}
