//! The loops that a block lists, and which of them a ray may meet there.

use super::batch::Batch;
use super::block_ray::{BlockRay, Listed};
use super::cloth::Cloth;
use super::lanes::{LANES, Lanes};
use super::walk::SquareSpan;
use crate::geometry::Ray;
use crate::scene::{BlockEntry, EntryLayout};

/// What of a loop a ray may meet.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum LoopPart {
    /// Its patch, w = 0: all that `single` asks for. Entries have a mask of it, 3×3 in the block.
    Patch,
    /// Its volume, with a mask of 2×2 in the block.
    Volume,
}

/// A ray's part in a block, cut where it goes from one of the block's subcells to the next.
#[derive(Debug, Clone, Copy)]
struct Pieces {
    /// The bit of each subcell passed, and the lowest and highest point of the ray in it.
    list: [(u32, [f32; 2]); 5],
    count: usize,
    /// All bits.
    subcells: u32,
    /// The quadrant and the height at which the ray starts: of a loop that holds the start, a part lies ahead even
    /// where its patch lies behind.
    start: Option<(u32, f32)>,
}

/// A block's list, and what of it can be met.
#[derive(Debug, Clone, Copy)]
pub(super) struct Block<'a> {
    cloth: &'a Cloth,
    square: [i64; 2],
    entries: &'a [BlockEntry],
    /// The heights in which entries tell where loops of the front and of the back are, mm.
    of_face: [[f32; 2]; 2],
}

impl Cloth {
    /// The block of a span.
    #[inline(always)]
    pub fn block(&self, square: [i64; 2]) -> Block<'_> {
        let loops = &self.scene.loops;
        let header = self.grid.header(square);
        let [first, next] = [&loops.headers[header], &loops.headers[header + 1]];
        let [low, high] = first.z_units();
        let unit = loops.height_unit_mm;
        let (low, high) = (f32::from(low) * unit, f32::from(high) * unit);
        let penetration_depth = loops.penetration_depth_mm;
        Block {
            cloth: self,
            square,
            entries: &loops.entries[first.entries_start as usize..next.entries_start as usize],
            of_face: [
                [low.max(-penetration_depth), high],
                [low, high.min(penetration_depth)],
            ],
        }
    }

    /// A ray in a block.
    #[inline(always)]
    pub fn in_block(&self, ray: &Ray, span: &SquareSpan) -> BlockRay {
        let first_cell = [
            span.square[0] * self.grid.block_cells,
            span.square[1] * self.grid.block_cells,
        ];
        BlockRay {
            point: (ray.at(span.enter) - self.grid.cell_centre(first_cell)).as_vec3a(),
            direction: ray.direction.as_vec3a(),
            length: (span.leave - span.enter) as f32,
        }
    }

    /// Cuts a ray's part in a block; `starts` tells that the ray begins with it.
    #[inline(always)]
    fn pieces(&self, part: &BlockRay, subcells: i32, starts: bool) -> Pieces {
        let n = subcells as f32;
        // In subcells from the block's low corner, which is half a cell from the centre of its first cell.
        let per_mm = self.blocks_per_mm * n;
        let place = (part.point.truncate() + self.pitch * 0.5) * per_mm;
        let way = part.direction.truncate() * per_mm;
        let subcell = |x: f32| (x as i32).clamp(0, subcells - 1);
        let (mut x, mut y) = (subcell(place.x), subcell(place.y));
        let mut pieces = Pieces {
            list: [(0, [0.0; 2]); 5],
            count: 0,
            subcells: 0,
            start: None,
        };
        if starts {
            let half = 0.5 * n;
            let quadrant = u32::from(place.x >= half) + 2 * u32::from(place.y >= half);
            pieces.start = Some((1 << quadrant, part.point.z));
        }
        let (x_step, y_step) = (
            if way.x > 0.0 { 1 } else { -1 },
            if way.y > 0.0 { 1 } else { -1 },
        );
        let (x_per, y_per) = (1.0 / way.x, 1.0 / way.y);
        let mut z = part.point.z;
        loop {
            let x_edge = (x + i32::from(x_step > 0)) as f32;
            let y_edge = (y + i32::from(y_step > 0)) as f32;
            let leaves = |edge: f32, place: f32, per: f32| {
                // A ray across an axis never comes to its edges.
                if per.is_infinite() {
                    f32::INFINITY
                } else {
                    (edge - place) * per
                }
            };
            let x_leave = leaves(x_edge, place.x, x_per);
            let y_leave = leaves(y_edge, place.y, y_per);
            let across_x = x_leave < y_leave;
            let leave = if across_x { x_leave } else { y_leave };
            let inner = leave < part.length && pieces.count < 4;
            let end = if inner { leave.max(0.0) } else { part.length };
            let z_end = part.point.z + part.direction.z * end;
            let bit = 1 << (x + subcells * y);
            pieces.list[pieces.count] = (bit, [z.min(z_end), z.max(z_end)]);
            pieces.count += 1;
            pieces.subcells |= bit;
            if !inner {
                return pieces;
            }
            z = z_end;
            if across_x {
                x = (x + x_step).clamp(0, subcells - 1);
            } else {
                y = (y + y_step).clamp(0, subcells - 1);
            }
        }
    }
}

impl<'a> Block<'a> {
    /// Lowest and highest point of any loop in the block, mm.
    #[inline(always)]
    pub fn heights(&self) -> [f32; 2] {
        let [front, back] = self.of_face;
        [front[0].min(back[0]), front[1].max(back[1])]
    }

    /// Whether a ray passes above or below all loops of the block.
    #[inline(always)]
    pub fn is_missed(&self, [low, high]: [f32; 2]) -> bool {
        let own = self.heights();
        !(low <= own[1] && high >= own[0])
    }

    /// The loops of which a ray may meet this part; `starts` tells that the ray begins in the block. All loops if
    /// nothing is `skipped`.
    #[inline(always)]
    pub fn met_by(
        &self,
        ray: &BlockRay,
        part: LoopPart,
        starts: bool,
        skipped: bool,
    ) -> MetLoops<'a> {
        let subcells = match part {
            LoopPart::Patch => 3,
            LoopPart::Volume => 2,
        };
        let layout = self.cloth.scene.loops.entry_layout;
        let masks_shift = layout.masks_shift();
        let subcells_shift = match part {
            LoopPart::Patch => masks_shift + 4,
            LoopPart::Volume => masks_shift,
        };
        let pieces = (self.cloth).pieces(ray, subcells, starts && part == LoopPart::Patch);
        let start = pieces.start.map_or(0, |(quadrant, _)| quadrant);
        let per_step = 1.0 / layout.height_steps() as f32;
        let [front, back] = self.of_face;
        MetLoops {
            block: *self,
            layout,
            reached: if skipped {
                pieces.subcells << subcells_shift | start << masks_shift
            } else {
                u32::MAX
            },
            pieces,
            subcells_shift,
            steps_mm: [
                (front[1] - front[0]) * per_step,
                (back[1] - back[0]) * per_step,
            ],
            skipped,
            next: 0,
            first: 0,
            met: 0,
        }
    }
}

/// The loops of a block that a ray may meet, looked for among eight entries at a time.
#[derive(Debug)]
pub(super) struct MetLoops<'a> {
    block: Block<'a>,
    layout: EntryLayout,
    pieces: Pieces,
    /// Where an entry tells the subcells, of which the pieces have as many.
    subcells_shift: u32,
    /// The bits of the subcells passed, and of the quadrant in which the ray starts, where entries have them.
    reached: u32,
    /// A step of the heights of either face's loops.
    steps_mm: [f32; 2],
    skipped: bool,
    /// The next entry to be looked at.
    next: usize,
    /// The first of the last eight that were, and a bit for each of these that is met and not yet given out.
    first: usize,
    met: u32,
}

impl MetLoops<'_> {
    /// Adds loops to a batch until it is full, or none is left: then the answer is false. Loops that are not `wanted`
    /// are left out.
    #[inline(always)]
    pub fn fill<L: Lanes>(
        &mut self,
        batch: &mut Batch,
        mut wanted: impl FnMut(u32) -> bool,
    ) -> bool {
        loop {
            while self.met == 0 {
                if self.next >= self.block.entries.len() {
                    return false;
                }
                self.look_at_eight::<L>();
            }
            if batch.is_full() {
                return true;
            }
            let entry = self.block.entries[self.first + self.met.trailing_zeros() as usize];
            self.met &= self.met - 1;
            let listed = self.listed(entry);
            if wanted(listed.index) {
                batch.push(listed);
            }
        }
    }

    /// Which of the next eight entries show loops that one of the pieces may meet.
    #[inline(always)]
    fn look_at_eight<L: Lanes>(&mut self) {
        self.first = self.next;
        self.next += LANES;
        let entries = self.block.entries;
        let mut words = [0; LANES];
        // Entries behind the last show nothing.
        match entries.get(self.first..self.next) {
            Some(eight) => words.copy_from_slice(bytemuck::cast_slice(eight)),
            None => {
                let rest: &[u32] = bytemuck::cast_slice(&entries[self.first..]);
                words[..rest.len()].copy_from_slice(rest);
            }
        }
        let words = L::load_words(&words);
        // Most entries end here.
        self.met = L::bits(L::has(words, self.reached));
        if self.met != 0 && self.skipped {
            self.met = L::bits(self.shown::<L>(words));
        }
    }

    /// Whether one of the pieces passes a subcell that the loop reaches, at its heights.
    #[inline(always)]
    fn shown<L: Lanes>(&self, words: L::Words) -> L::Mask {
        let layout = &self.layout;
        let pieces = &self.pieces;
        let [front, back] = self.block.of_face;
        let is_back = L::has(words, 1 << layout.place_shift());
        let floor = L::select(is_back, L::splat(back[0]), L::splat(front[0]));
        let step_mm = L::select(
            is_back,
            L::splat(self.steps_mm[1]),
            L::splat(self.steps_mm[0]),
        );
        let (heights, bits) = (layout.heights_shift(), layout.height_bits);
        let steps = |from: u32| L::field(words, from, (1 << bits) - 1);
        let low = floor + steps(heights) * step_mm;
        let high = floor + (steps(heights + bits) + L::splat(1.0)) * step_mm;
        let (quadrant, z) = pieces.start.unwrap_or_default();
        let start = quadrant << layout.masks_shift();
        let mut shown = passes::<L>(words, start, [low, high], [z, z]);
        for &(subcell, heights) in &pieces.list[..pieces.count] {
            let bit = subcell << self.subcells_shift;
            shown = shown | passes::<L>(words, bit, [low, high], heights);
        }
        shown
    }

    /// The loop of an entry.
    #[inline(always)]
    fn listed(&self, entry: BlockEntry) -> Listed {
        let cloth = self.block.cloth;
        let loops = &cloth.scene.loops;
        let side = cloth.grid.block_cells as i32;
        let bits = self.layout.offset_bits;
        let [right, up] = [
            (entry.0 << (32 - bits)) as i32 >> (32 - bits),
            (entry.0 << (32 - 2 * bits)) as i32 >> (32 - bits),
        ];
        let place = entry.0 >> self.layout.place_shift() & ((1 << self.layout.place_bits) - 1);
        let home = [
            self.block.square[0] + i64::from(right),
            self.block.square[1] + i64::from(up),
        ];
        // Blocks are 1, 2 or 4 cells wide.
        let cell = place as i32 >> 1;
        let (x, y) = (cell & (side - 1), cell >> side.trailing_zeros());
        Listed {
            index: loops.headers[cloth.grid.header(home)].loop_index(place),
            cell: [
                (right * side + x) as f32 * cloth.pitch.x,
                (up * side + y) as f32 * cloth.pitch.y,
            ],
        }
    }
}

/// Whether entries have a bit, and their heights any of a piece's.
#[inline(always)]
fn passes<L: Lanes>(
    words: L::Words,
    bit: u32,
    [low, high]: [L; 2],
    [lowest, highest]: [f32; 2],
) -> L::Mask {
    L::has(words, bit) & L::splat(lowest).le(high) & low.le(L::splat(highest))
}
