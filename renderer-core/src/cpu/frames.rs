//! A ray in the coordinates of loops' frames, eight loops at once, in f32: MODEL.md §4's inversion along a line.
//!
//! Projected along n̂ onto the plane of b and c a point has coordinates p = u′(1 + αv′), q = v′(1 + βu′), u′ = u − ½,
//! v′ = v − ½, with αb + βc the part of A in that plane. p, q and the height over the plane are linear along a ray: six
//! products are made once for a loop, and a point costs a square root.

use super::batch::{Batch, Patches};
use super::block_ray::BlockRay;
use super::cloth::Cloth;
use super::lanes::{LANES, Lanes, Vectors};
use crate::geometry::tolerances::WIDENED;

/// Eight frames, each with the part of the ray that may be in it; t in mm from the ray's point.
#[derive(Debug, Clone, Copy)]
#[repr(align(32))]
pub(super) struct Frames {
    /// Start and slope of p, q and height along the ray.
    p: [[f32; LANES]; 2],
    q: [[f32; LANES]; 2],
    height: [[f32; LANES]; 2],
    /// α and β.
    skew: [[f32; LANES]; 2],
    /// A·n̂, mm.
    lift: [f32; LANES],
    /// Outside of these the ray is certainly not in the frame. Lanes without a loop are never in one.
    low: [f32; LANES],
    high: [f32; LANES],
    /// A bit for each lane whose part of the ray holds a point of it.
    pub holding: u32,
    pub index: [u32; LANES],
}

/// The numbers of the lanes.
const NUMBERS: [f32; LANES] = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0];

/// What f32 may round off a place in a frame.
const ROUNDED: f32 = 1e-4;

/// Where eight pieces of a ray are in a frame, from the lowest to the highest of each coordinate.
pub(super) struct Pieces {
    /// A bit for each piece that may be in the frame at all.
    pub inside: u32,
    pub u: [[f32; LANES]; 2],
    pub v: [[f32; LANES]; 2],
    pub w: [[f32; LANES]; 2],
}

/// Where in eight frames a point is.
pub(super) struct Places {
    /// A bit for each frame that it is in: u and v in [0, 1], w in [−½, ½].
    pub inside: u32,
    pub u: [f32; LANES],
    pub v: [f32; LANES],
    pub w: [f32; LANES],
}

/// The part of `part` in which start + slope·t is within −`bound` and `bound`.
#[inline(always)]
fn clip<L: Lanes>([low, high]: [L; 2], [start, slope]: [L; 2], bound: L) -> [L; 2] {
    // A slope below 10⁻⁹ moves less than f32 resolves over any part inside a loop.
    let least = L::splat(1e-9);
    let inverse = L::splat(1.0) / L::select(slope.abs().lt(least), least, slope);
    let (a, b) = ((-bound - start) * inverse, (bound - start) * inverse);
    // NaN leaves what was.
    [a.min(b).max(low), a.max(b).min(high)]
}

/// The ends of what of `part` has c₀ + c₁t + c₂t² within −`most` and `most`: in between there may be more outside.
#[inline(always)]
fn clip_bent<L: Lanes>([low, high]: [L; 2], [c0, c1, c2]: [L; 3], most: L) -> [L; 2] {
    // Turned so that it opens upwards: it is below `most` between two roots, and below −`most` between two others.
    let turn = c2.lt(L::splat(0.0));
    let up = |c: L| L::select(turn, -c, c);
    // `abs`, since a root divided by −0 would lie at the wrong end.
    let (c0, c1, c2) = (up(c0), up(c1), c2.abs());
    let [first, last] = roots(c0 - most, c1, c2);
    let [fall, rise] = roots(c0 + most, c1, c2);
    let (low, high) = (first.max(low), last.min(high));
    let is_below = |t: L| fall.lt(t) & t.lt(rise);
    [
        L::select(is_below(low), rise, low),
        L::select(is_below(high), fall, high),
    ]
}

/// Between which two c₀ + c₁t + c₂t² with c₂ ≥ 0 is below 0, the lower first; +∞ and −∞ where it never is.
#[inline(always)]
fn roots<L: Lanes>(c0: L, c1: L, c2: L) -> [L; 2] {
    let zero = L::splat(0.0);
    let discriminant = c1 * c1 - L::splat(4.0) * c0 * c2;
    let root = discriminant.max(zero).sqrt();
    let is_falling = c1.lt(zero);
    let q = L::splat(-0.5) * (c1 + L::select(is_falling, -root, root));
    let (a, b) = (q / c2, c0 / q);
    // Without roots it is below 0 everywhere or nowhere.
    let has_roots = zero.lt(discriminant);
    let infinity = L::splat(f32::INFINITY);
    let nowhere = L::select(c0.lt(zero), -infinity, infinity);
    [
        L::select(has_roots, L::select(is_falling, b, a), nowhere),
        L::select(has_roots, L::select(is_falling, a, b), -nowhere),
    ]
}

#[inline(always)]
fn stored<L: Lanes>(lanes: L) -> [f32; LANES] {
    let mut values = [0.0; LANES];
    lanes.store(&mut values);
    values
}

/// Bounds of x in x·(1 + `factor`·y) = `value`, within −½ and ½, where y is within `others`.
#[inline(always)]
fn solved<L: Lanes>(value: [L; 2], factor: L, others: [L; 2]) -> [L; 2] {
    let (half, one) = (L::splat(0.5), L::splat(1.0));
    let (a, b) = (factor * others[0], factor * others[1]);
    let by = [one / (one + a), one / (one + b)];
    let (low, high) = (value[0], value[1]);
    [
        (low * by[0]).min(low * by[1]).max(-half),
        (high * by[0]).max(high * by[1]).min(half),
    ]
}

/// Bounds of start + slope·t between `from` and `to`.
#[inline(always)]
fn between<L: Lanes>([start, slope]: [f32; 2], from: L, to: L) -> [L; 2] {
    let (start, slope) = (L::splat(start), L::splat(slope));
    let (a, b) = (start + slope * from, start + slope * to);
    [a.min(b), a.max(b)]
}

/// Whether bounds leave anything from −½ to ½.
#[inline(always)]
fn holds_some<L: Lanes>([low, high]: [L; 2]) -> L::Mask {
    let wide = L::splat(0.5 + ROUNDED);
    low.le(wide) & (-wide).le(high)
}

/// Bounds widened by what rounding may do to them, but within −½ and ½; those where they do not hold.
#[inline(always)]
fn rounded_out<L: Lanes>([low, high]: [L; 2], they_hold: L::Mask) -> [L; 2] {
    let (rounded, half) = (L::splat(ROUNDED), L::splat(0.5));
    [
        L::select(they_hold, low - rounded, -half).max(-half),
        L::select(they_hold, high + rounded, half).min(half),
    ]
}

/// Bounds of a product.
#[inline(always)]
fn product<L: Lanes>([a, b]: [L; 2], [c, d]: [L; 2]) -> [L; 2] {
    let (ac, ad, bc, bd) = (a * c, a * d, b * c, b * d);
    [ac.min(ad).min(bc.min(bd)), ac.max(ad).max(bc.max(bd))]
}

impl Frames {
    /// No loops.
    pub const NONE: Self = Self {
        p: [[0.0; LANES]; 2],
        q: [[0.0; LANES]; 2],
        height: [[0.0; LANES]; 2],
        skew: [[0.0; LANES]; 2],
        lift: [0.0; LANES],
        low: [f32::INFINITY; LANES],
        high: [f32::NEG_INFINITY; LANES],
        holding: 0,
        index: [0; LANES],
    };

    /// The frames of a batch, and a bit for each that the ray may be in; it is never in the others.
    #[inline(always)]
    pub fn new<L: Lanes>(batch: &Batch, cloth: &Cloth, part: &BlockRay) -> (Self, u32) {
        let Patches {
            middle,
            along_u,
            along_v,
            twist,
        } = batch.patches::<L>(cloth, part);
        let direction = Vectors::splat(part.direction);
        let product = along_u.cross(along_v);
        let per_area = L::splat(1.0) / product.dot(product).max(L::splat(1e-30));
        let normal = product.scaled(per_area.sqrt());
        let unit = product.scaled(per_area);
        let duals = [along_v.cross(unit), unit.cross(along_u)];
        let p = [-middle.dot(duals[0]), direction.dot(duals[0])];
        let q = [-middle.dot(duals[1]), direction.dot(duals[1])];
        let height = [-middle.dot(normal), direction.dot(normal)];
        let (alpha, beta) = (twist.dot(duals[0]), twist.dot(duals[1]));
        let lift = twist.dot(normal);

        // |u′| and |v′| stay within ½, and with them p and q.
        let (half, quarter) = (L::splat(0.5), L::splat(0.25));
        let part = [L::splat(0.0), L::splat(part.length)];
        let part = clip(part, p, half + quarter * alpha.abs());
        let part = clip(part, q, half + quarter * beta.abs());
        // And |w|, with w·h = height − u′v′·lift. u′v′ is pq but for (1 + αv′)(1 + βu′), and at most ¼.
        let (half_alpha, half_beta) = (half * alpha.abs(), half * beta.abs());
        let differ = half_alpha + half_beta + half_alpha * half_beta;
        let most = L::splat(0.5 * WIDENED * cloth.thickness) + quarter * lift.abs() * differ;
        let bent = [
            height[0] - lift * p[0] * q[0],
            height[1] - lift * (p[0] * q[1] + p[1] * q[0]),
            -lift * p[1] * q[1],
        ];
        let [low, high] = clip_bent(part, bent, most);

        // Lanes without a loop hold any frame.
        let is_met = low.lt(high) & L::load(&NUMBERS).lt(L::splat(batch.len() as f32));
        let frames = Self {
            p: [stored(p[0]), stored(p[1])],
            q: [stored(q[0]), stored(q[1])],
            height: [stored(height[0]), stored(height[1])],
            skew: [stored(alpha), stored(beta)],
            lift: stored(lift),
            low: stored(L::select(is_met, low, L::splat(f32::INFINITY))),
            high: stored(high),
            holding: 0,
            index: batch.indices(),
        };
        (frames, L::bits(is_met))
    }

    /// How long the part of the ray is that may be in the frame of `lane`, mm.
    #[inline(always)]
    pub fn length(&self, lane: usize) -> f32 {
        let lane = lane & (LANES - 1);
        self.high[lane] - self.low[lane]
    }

    /// Where eight equal pieces of the ray's part in one frame are in it; u and v from 0 to 1, w from −½ to ½.
    ///
    /// p, q and height are linear along the ray: their ends in a piece bound them. From u′ = p/(1 + αv′) and v′ = q/(1
    /// + βu′) follow bounds of u′ and v′, better ones each time, and from those of their product that of w.
    #[inline(always)]
    pub fn pieces<L: Lanes>(&self, lane: usize, thickness: f32) -> Pieces {
        let lane = lane & (LANES - 1);
        let (half, one) = (L::splat(0.5), L::splat(1.0));
        let step = self.length(lane) * (1.0 / LANES as f32);
        let from = L::splat(self.low[lane]) + L::load(&NUMBERS) * L::splat(step);
        let to = from + L::splat(step);
        let p = between([self.p[0][lane], self.p[1][lane]], from, to);
        let q = between([self.q[0][lane], self.q[1][lane]], from, to);
        let height = between([self.height[0][lane], self.height[1][lane]], from, to);
        let (alpha, beta) = (L::splat(self.skew[0][lane]), L::splat(self.skew[1][lane]));
        let anywhere = [-half, half];
        let v = solved(q, beta, anywhere);
        let u = solved(p, alpha, v);
        let v = solved(q, beta, u);
        let bent = product([L::splat(self.lift[lane]); 2], product(u, v));
        let per_thickness = L::splat(1.0 / thickness);
        let w = [
            (height[0] - bent[1]) * per_thickness,
            (height[1] - bent[0]) * per_thickness,
        ];
        // A frame so skewed that it almost folds bounds nothing.
        let is_bounded = half.lt(one - half * alpha.abs()) & half.lt(one - half * beta.abs());
        let inside = holds_some(u) & holds_some(v) & holds_some(w);
        let [u, v, w] = [
            rounded_out(u, is_bounded),
            rounded_out(v, is_bounded),
            rounded_out(w, is_bounded),
        ];
        Pieces {
            inside: L::bits(inside) | !L::bits(is_bounded) & 0xff,
            u: [stored(u[0] + half), stored(u[1] + half)],
            v: [stored(v[0] + half), stored(v[1] + half)],
            w: [stored(w[0]), stored(w[1])],
        }
    }

    /// Makes `lane`, which is free, a part of the one that `from` is in `others`: its `first` of eight pieces, and so
    /// many more.
    #[inline(always)]
    pub fn put_part(&mut self, lane: usize, others: &Self, from: usize, first: u32, count: u32) {
        let from = from & (LANES - 1);
        let step = others.length(from) * (1.0 / LANES as f32);
        // The ends of neighbouring parts are the same number.
        let at = |piece: u32| match piece {
            0 => others.low[from],
            8 => others.high[from],
            _ => others.low[from] + piece as f32 * step,
        };
        self.put(lane, others, from, [at(first), at(first + count)]);
    }

    /// Makes `lane`, which is free, the one that `from` is in `others`, with that part of the ray.
    #[inline(always)]
    fn put(&mut self, lane: usize, others: &Self, from: usize, [low, high]: [f32; 2]) {
        let (lane, from) = (lane & (LANES - 1), from & (LANES - 1));
        for end in 0..2 {
            self.p[end][lane] = others.p[end][from];
            self.q[end][lane] = others.q[end][from];
            self.height[end][lane] = others.height[end][from];
            self.skew[end][lane] = others.skew[end][from];
        }
        self.lift[lane] = others.lift[from];
        (self.low[lane], self.high[lane]) = (low, high);
        self.index[lane] = others.index[from];
    }

    /// Notes whose part of the ray holds `t`; where that changes next.
    #[inline(always)]
    pub fn hold<L: Lanes>(&mut self, t: f32) -> f32 {
        let t = L::splat(t);
        let (low, high) = (L::load(&self.low), L::load(&self.high));
        let begun = low.le(t);
        let never = L::splat(f32::INFINITY);
        self.holding = L::bits(begun & t.lt(high));
        L::select(begun, L::select(t.lt(high), high, never), low).least()
    }

    /// (u, v, w) at `t`. Exact for convex frames.
    ///
    /// From p and q: βu′² + (1 + δ)u′ − p = 0 and αv′² + (1 − δ)v′ − q = 0 with δ = αq − βp. Both have the discriminant
    /// (1 + δ)² + 4βp = (1 − δ)² + 4αq; of their roots those are taken that vanish with p and q.
    #[inline(always)]
    pub fn places<L: Lanes>(&self, t: f32, per_thickness: f32) -> Places {
        let t = L::splat(t);
        let p = L::load(&self.p[0]) + L::load(&self.p[1]) * t;
        let q = L::load(&self.q[0]) + L::load(&self.q[1]) * t;
        let height = L::load(&self.height[0]) + L::load(&self.height[1]) * t;
        let (alpha, beta) = (L::load(&self.skew[0]), L::load(&self.skew[1]));
        let (zero, half, one) = (L::splat(0.0), L::splat(0.5), L::splat(1.0));
        let (alpha_q, beta_p) = (alpha * q, beta * p);
        let delta = alpha_q - beta_p;
        let sum = alpha_q + beta_p;
        let discriminant = one + delta * delta + (sum + sum);
        let root = one + discriminant.max(zero).sqrt();
        let u = (p + p) / (root + delta);
        let v = (q + q) / (root - delta);
        let w = (height - u * v * L::load(&self.lift)) * L::splat(per_thickness);
        let inside = zero.le(discriminant) & u.abs().le(half) & v.abs().le(half) & w.abs().le(half);
        Places {
            inside: L::bits(inside),
            u: stored(u + half),
            v: stored(v + half),
            w: stored(w),
        }
    }
}
