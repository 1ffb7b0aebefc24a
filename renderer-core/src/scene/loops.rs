//! Records of the loops' shapes, and of the grid that finds them.

use bytemuck::{Pod, Zeroable};

use super::skeleton::Face;
use super::{LoopCounts, LoopLook};

/// The bilinear patch of one loop, relative to its cell's centre (x, y) and the sheet's plane (z), mm.
///
/// MODEL.md §4: P0 = (0, −w₀/2, `root_z0`), P1 = (0, +w₀/2, `root_z1`); with the axis C′ = L·d and the half top
/// edge e, the top corners are P3 = ½(P0+P1) + C′ − e and P2 = ½(P0+P1) + C′ + e. Hence B = P1−P0, A = 2e − B, and in
/// the middle of the patch b = ∂P/∂u = ½B + e, c = ∂P/∂v = C′. The thickness direction is n̂ = (b × c)/|b × c|.
/// w₀ is [`Loops::base_width_mm`]. Loops of the back face have root heights and an axis below the sheet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoopPatch {
    /// C′: from the middle of the root to the middle of the top edge, mm.
    pub axis: [f32; 3],
    /// World height of P0, mm.
    pub root_z0: f32,
    /// e: from the middle of the top edge to P2, mm.
    pub half_top: [f32; 3],
    /// World height of P1, mm.
    pub root_z1: f32,
}

/// A [`LoopPatch`] as scenes store it, in whole [`Loops::length_unit_mm`]. 16 bytes.
///
/// What is stored is the scene: bounds are made from it, and since the unit has at most nine significant bits, every
/// backend gets the same numbers from it to the bit. Against the design each component is off by at most half a unit,
/// and a corner of the patch by at most one and a half units along each axis: 0.15 µm where no loop can get longer than
/// 3.2 mm.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Pod, Zeroable)]
#[repr(C)]
pub struct LoopShape {
    /// C′.
    pub axis: [i16; 3],
    /// World height of P0.
    pub root_z0: i16,
    /// e.
    pub half_top: [i16; 3],
    /// World height of P1.
    pub root_z1: i16,
}

impl LoopShape {
    /// The patch; exact, since 15 bits times nine fit into f32.
    pub fn patch(&self, length_unit_mm: f32) -> LoopPatch {
        let mm = |units: i16| f32::from(units) * length_unit_mm;
        LoopPatch {
            axis: self.axis.map(mm),
            root_z0: mm(self.root_z0),
            half_top: self.half_top.map(mm),
            root_z1: mm(self.root_z1),
        }
    }
}

/// One block of the grid. 16 bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct BlockHeader {
    /// Index of the block's first entry in [`Loops::entries`]; its last is before the next header's first.
    pub entries_start: u32,
    /// Index in [`Loops::shapes`] of the first loop planted here.
    pub first_loop: u32,
    /// Which loops are planted here: bit 2·(y·b + x) is the front loop of the block's cell (x, y), the bit above it the
    /// back loop, b = [`Loops::block_cells`]. Loops follow each other in the order of their bits.
    pub planted: u32,
    /// Lowest (low 16 bits, i16) and highest (high 16 bits, i16) point of any loop inside this block, in units of
    /// [`Loops::height_unit_mm`], rounded outwards. Lowest above highest means that no loop reaches the block.
    pub z_range: u32,
}

impl BlockHeader {
    /// Lowest and highest point of any loop in the block, in height units.
    pub fn z_units(&self) -> [i16; 2] {
        [
            self.z_range as u16 as i16,
            (self.z_range >> 16) as u16 as i16,
        ]
    }

    /// The heights in which the block's entries tell where loops of one face are, mm: the block's range but for what
    /// only the other face's loops reach. Lowest above highest where no loop reaches the block.
    pub fn heights_mm(&self, loops: &Loops, face: Face) -> [f64; 2] {
        self.heights_of(loops.height_unit_mm, loops.penetration_depth_mm, face)
    }

    /// What [`Self::heights_mm`] gives, from [`Loops::height_unit_mm`] and [`Loops::penetration_depth_mm`] before there
    /// are [`Loops`].
    pub(super) fn heights_of(
        &self,
        unit_mm: f32,
        penetration_depth_mm: f32,
        face: Face,
    ) -> [f64; 2] {
        let [low, high] = self.z_units().map(|z| f64::from(z) * f64::from(unit_mm));
        let penetration_depth = f64::from(penetration_depth_mm);
        match face {
            Face::Front => [low.max(-penetration_depth), high],
            Face::Back => [low, high.min(penetration_depth)],
        }
    }

    /// Index in [`Loops::shapes`] of the loop with bit `place`, which is planted here.
    pub fn loop_index(&self, place: u32) -> u32 {
        self.first_loop + (self.planted & ((1 << place) - 1)).count_ones()
    }
}

/// One loop that reaches into a block, packed as [`EntryLayout`] says. 4 bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
#[repr(transparent)]
pub struct BlockEntry(pub u32);

/// What a [`BlockEntry`] tells of a loop and of its part in a block.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct EntryParts {
    /// The loop's own block minus the block that lists it, along x and y.
    pub offset: [i32; 2],
    /// The loop's bit in [`BlockHeader::planted`] of its own block.
    pub place: u32,
    /// Occupancy mask of the block in 2×2: which quarters the loop's volume reaches: bit x + 2y is the one at (x, y).
    pub mask_2x2: u32,
    /// Occupancy mask of the block in 3×3: which parts the loop's patch (w = 0) reaches: bit x + 3y is the one at (x,
    /// y). None where only the rest of the volume reaches the block.
    pub mask_3x3: u32,
    /// Lowest and highest point of the volume's part in the block, in steps of [`BlockHeader::heights_mm`], rounded
    /// outwards: the lowest from its step's low end, the highest to its step's high end.
    pub heights: [u32; 2],
}

/// How many bits the parts of a scene's entries have: what near loops do not need to tell whose they are is left to
/// tell where they are.
///
/// From the lowest bit: the offset along x and y (`offset_bits` each, signed), the place (`place_bits`), the 2×2 mask
/// (4 bits), the 3×3 mask (9 bits), the heights (`height_bits` each).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct EntryLayout {
    /// 2 to 5.
    pub offset_bits: u32,
    /// 1, 3 or 5 for blocks of 1, 2 or 4 cells a side.
    pub place_bits: u32,
    /// 2 to 7.
    pub height_bits: u32,
}

impl EntryLayout {
    /// Blocks that any layout can count from the block that lists a loop to the loop's own.
    pub const FARTHEST: i64 = 15;
    /// Bits of the two occupancy masks.
    const MASK_BITS: u32 = 13;

    /// The layout for blocks of `block_cells` cells a side (1, 2 or 4) and loops that reach `farthest` blocks, at most
    /// [`Self::FARTHEST`].
    pub fn new(block_cells: u32, farthest: i64) -> Self {
        debug_assert!((0..=Self::FARTHEST).contains(&farthest));
        let place_bits = 1 + 2 * block_cells.ilog2();
        let offset_bits = (farthest as u32 + 1).next_power_of_two().ilog2() + 1;
        let left = 32 - Self::MASK_BITS - place_bits - 2 * offset_bits;
        Self {
            offset_bits,
            place_bits,
            height_bits: (left / 2).min(7),
        }
    }

    /// Steps of a block's heights.
    pub fn height_steps(self) -> u32 {
        1 << self.height_bits
    }

    /// Where the place begins, and behind it masks and heights.
    pub fn place_shift(self) -> u32 {
        2 * self.offset_bits
    }

    /// Where the occupancy masks begin, 2×2 before 3×3.
    pub fn masks_shift(self) -> u32 {
        self.place_shift() + self.place_bits
    }

    /// Where the heights begin.
    pub fn heights_shift(self) -> u32 {
        self.masks_shift() + Self::MASK_BITS
    }

    /// Packs an entry whose parts are within their bits.
    pub fn pack(self, parts: EntryParts) -> BlockEntry {
        let within = |value: u32, bits: u32| {
            debug_assert!(value >> bits == 0, "{parts:?} in {self:?}");
            value
        };
        let offset = |blocks: i32| {
            let half = 1 << (self.offset_bits - 1);
            debug_assert!((-half..half).contains(&blocks), "{parts:?} in {self:?}");
            blocks as u32 & ((1 << self.offset_bits) - 1)
        };
        let [z0, z1] = parts.heights.map(|z| within(z, self.height_bits));
        BlockEntry(
            offset(parts.offset[0])
                | offset(parts.offset[1]) << self.offset_bits
                | within(parts.place, self.place_bits) << self.place_shift()
                | within(parts.mask_2x2, 4) << self.masks_shift()
                | within(parts.mask_3x3, 9) << (self.masks_shift() + 4)
                | z0 << self.heights_shift()
                | z1 << (self.heights_shift() + self.height_bits),
        )
    }

    /// What is packed into an entry.
    pub fn unpack(self, entry: BlockEntry) -> EntryParts {
        let field = |shift: u32, bits: u32| entry.0 >> shift & ((1 << bits) - 1);
        let offset = |shift: u32| {
            (entry.0 << (32 - shift - self.offset_bits)) as i32 >> (32 - self.offset_bits)
        };
        EntryParts {
            offset: [offset(0), offset(self.offset_bits)],
            place: field(self.place_shift(), self.place_bits),
            mask_2x2: field(self.masks_shift(), 4),
            mask_3x3: field(self.masks_shift() + 4, 9),
            heights: [
                field(self.heights_shift(), self.height_bits),
                field(self.heights_shift() + self.height_bits, self.height_bits),
            ],
        }
    }
}

/// Shapes of all loops and the grid that finds them.
///
/// The grid's blocks are squares of [`Self::block_cells`]² cells, block (0, 0) beginning with cell (0, 0). Blocks to
/// the left and in front of it, and behind the sheet's other two borders, list the loops that hang over them.
#[derive(Debug, Clone)]
pub struct Loops {
    /// One shape a loop, ordered by block (row by row), within one by its bit in [`BlockHeader::planted`].
    pub shapes: Vec<LoopShape>,
    /// Unit of [`LoopShape`], mm; nine significant bits.
    pub length_unit_mm: f32,
    /// One header a block, row by row, and a last one for the end of the last list.
    pub headers: Vec<BlockHeader>,
    /// Lists of all blocks, one behind the other.
    pub entries: Vec<BlockEntry>,
    /// How entries are packed.
    pub entry_layout: EntryLayout,
    /// Cells along each side of a block: 1, 2 or 4.
    pub block_cells: u32,
    /// Blocks of the grid along x and y.
    pub blocks: [u32; 2],
    /// How many of them lie before block 0, along x and y.
    pub margin: [u32; 2],
    /// Width of all patches at their roots, w₀, mm.
    pub base_width_mm: f32,
    /// Thickness of all patches along n̂, mm.
    pub thickness_mm: f32,
    /// Unit of [`BlockHeader::z_range`], mm.
    pub height_unit_mm: f32,
    /// How far loops of one face reach to the other side of the sheet's plane at most, mm.
    pub penetration_depth_mm: f32,
    /// Lowest and highest point of any loop, mm; [0, 0] when there are none.
    pub z_range_mm: [f32; 2],
    /// What compile had to do to some loops.
    pub counts: LoopCounts,
}

impl Loops {
    /// Bytes of loop shapes, lists and bounds.
    pub fn bytes(&self) -> usize {
        size_of_val(&*self.shapes) + size_of_val(&*self.headers) + size_of_val(&*self.entries)
    }

    /// Bytes of loop shapes, looks, lists and bounds for each loop; 0 when there are none.
    pub fn bytes_per_loop(&self) -> f64 {
        let bytes = self.bytes() + self.shapes.len() * size_of::<LoopLook>();
        if self.shapes.is_empty() {
            0.0
        } else {
            bytes as f64 / self.shapes.len() as f64
        }
    }
}
