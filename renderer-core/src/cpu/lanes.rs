//! Eight numbers at once. What is written for [`Lanes`] runs in the widest instructions of the processor
//! (`wide`) and, with the same results to the bit, in plain ones on all others.

use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Sub};

use glam::Vec3A;

/// The instructions that the processor draws with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Instructions {
    /// The widest that it has.
    #[default]
    Widest,
    /// Those that the program was built for. The picture is the same to the bit.
    Plain,
}

/// How many numbers there are.
pub(super) const LANES: usize = 8;

/// Eight f32. Operations are IEEE's, each rounded by itself.
pub(super) trait Lanes:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// Eight truths.
    type Mask: Copy + BitAnd<Output = Self::Mask> + BitOr<Output = Self::Mask>;
    /// Eight u32.
    type Words: Copy;

    fn splat(value: f32) -> Self;
    fn load(values: &[f32; LANES]) -> Self;
    fn store(self, values: &mut [f32; LANES]);
    /// The components of eight records of eight numbers: result `k` holds number `k` of each.
    fn columns(records: [[i16; LANES]; LANES]) -> [Self; LANES];
    /// Eight small numbers.
    fn bytes(values: [u8; LANES]) -> Self;

    fn abs(self) -> Self;
    fn sqrt(self) -> Self;
    /// The smaller; `other` if either is NaN.
    fn min(self, other: Self) -> Self;
    /// The larger; `other` if either is NaN.
    fn max(self, other: Self) -> Self;
    /// False for NaN.
    fn lt(self, other: Self) -> Self::Mask;
    /// False for NaN.
    fn le(self, other: Self) -> Self::Mask;
    /// `yes` where `mask` is true, else `no`.
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;
    /// A bit for each truth.
    fn bits(mask: Self::Mask) -> u32;

    /// The whole parts of numbers from 0 to below 2³¹, as numbers and as words.
    fn whole(self) -> (Self, [u32; LANES]);

    fn load_words(words: &[u32; LANES]) -> Self::Words;
    /// Bits `from` and above of each word, of which as many count as `mask` tells, as a number (below 2³¹).
    fn field(words: Self::Words, from: u32, mask: u32) -> Self;
    /// Whether a word has any of `bits`.
    fn has(words: Self::Words, bits: u32) -> Self::Mask;

    /// The sum of the eight: of numbers four apart first, then two, then one.
    #[inline(always)]
    fn sum(self) -> f32 {
        let mut x = [0.0; LANES];
        self.store(&mut x);
        ((x[0] + x[4]) + (x[2] + x[6])) + ((x[1] + x[5]) + (x[3] + x[7]))
    }

    /// The smallest of the eight.
    #[inline(always)]
    fn least(self) -> f32 {
        let mut values = [0.0; LANES];
        self.store(&mut values);
        values.into_iter().fold(f32::INFINITY, f32::min)
    }
}

/// Eight numbers in plain instructions.
#[derive(Debug, Clone, Copy)]
pub(super) struct Plain([f32; LANES]);

impl Plain {
    #[inline(always)]
    fn zip<T>(self, other: Self, f: impl Fn(f32, f32) -> T) -> [T; LANES] {
        std::array::from_fn(|lane| f(self.0[lane], other.0[lane]))
    }
}

/// Eight truths in plain instructions.
#[derive(Debug, Clone, Copy)]
pub(super) struct PlainMask([bool; LANES]);

impl BitAnd for PlainMask {
    type Output = Self;

    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        Self(std::array::from_fn(|lane| self.0[lane] & other.0[lane]))
    }
}

impl BitOr for PlainMask {
    type Output = Self;

    #[inline(always)]
    fn bitor(self, other: Self) -> Self {
        Self(std::array::from_fn(|lane| self.0[lane] | other.0[lane]))
    }
}

impl Add for Plain {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self(self.zip(other, Add::add))
    }
}

impl Sub for Plain {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self(self.zip(other, Sub::sub))
    }
}

impl Mul for Plain {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self(self.zip(other, Mul::mul))
    }
}

impl Div for Plain {
    type Output = Self;

    #[inline(always)]
    fn div(self, other: Self) -> Self {
        Self(self.zip(other, Div::div))
    }
}

impl Neg for Plain {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self(self.0.map(Neg::neg))
    }
}

impl Lanes for Plain {
    type Mask = PlainMask;
    type Words = [u32; LANES];

    #[inline(always)]
    fn splat(value: f32) -> Self {
        Self([value; LANES])
    }

    #[inline(always)]
    fn load(values: &[f32; LANES]) -> Self {
        Self(*values)
    }

    #[inline(always)]
    fn store(self, values: &mut [f32; LANES]) {
        *values = self.0;
    }

    #[inline(always)]
    fn columns(records: [[i16; LANES]; LANES]) -> [Self; LANES] {
        std::array::from_fn(|k| Self(std::array::from_fn(|lane| f32::from(records[lane][k]))))
    }

    #[inline(always)]
    fn bytes(values: [u8; LANES]) -> Self {
        Self(values.map(f32::from))
    }

    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0.map(f32::abs))
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.map(f32::sqrt))
    }

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self(self.zip(other, |a, b| if a < b { a } else { b }))
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self(self.zip(other, |a, b| if a > b { a } else { b }))
    }

    #[inline(always)]
    fn lt(self, other: Self) -> PlainMask {
        PlainMask(self.zip(other, |a, b| a < b))
    }

    #[inline(always)]
    fn le(self, other: Self) -> PlainMask {
        PlainMask(self.zip(other, |a, b| a <= b))
    }

    #[inline(always)]
    fn select(mask: PlainMask, yes: Self, no: Self) -> Self {
        Self(std::array::from_fn(|lane| {
            if mask.0[lane] {
                yes.0[lane]
            } else {
                no.0[lane]
            }
        }))
    }

    #[inline(always)]
    fn bits(mask: PlainMask) -> u32 {
        let bit = |(lane, is_true): (usize, bool)| u32::from(is_true) << lane;
        mask.0.into_iter().enumerate().map(bit).sum()
    }

    #[inline(always)]
    fn whole(self) -> (Self, [u32; LANES]) {
        let words = self.0.map(|value| value as u32);
        (Self(words.map(|word| word as f32)), words)
    }

    #[inline(always)]
    fn load_words(words: &[u32; LANES]) -> Self::Words {
        *words
    }

    #[inline(always)]
    fn field(words: Self::Words, from: u32, mask: u32) -> Self {
        Self(words.map(|word| (word >> from & mask) as f32))
    }

    #[inline(always)]
    fn has(words: Self::Words, bits: u32) -> PlainMask {
        PlainMask(words.map(|word| word & bits != 0))
    }
}

/// A vector for each lane: each component holds the eight vectors' numbers.
#[derive(Debug, Clone, Copy)]
pub(super) struct Vectors<L> {
    pub x: L,
    pub y: L,
    pub z: L,
}

impl<L: Lanes> Vectors<L> {
    /// One vector in all lanes.
    #[inline(always)]
    pub fn splat(v: Vec3A) -> Self {
        Self {
            x: L::splat(v.x),
            y: L::splat(v.y),
            z: L::splat(v.z),
        }
    }

    #[inline(always)]
    pub fn dot(self, other: Self) -> L {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    #[inline(always)]
    pub fn cross(self, other: Self) -> Self {
        Self {
            x: self.y * other.z - self.z * other.y,
            y: self.z * other.x - self.x * other.z,
            z: self.x * other.y - self.y * other.x,
        }
    }

    /// Each lane's vector times its number.
    #[inline(always)]
    pub fn scaled(self, by: L) -> Self {
        Self {
            x: self.x * by,
            y: self.y * by,
            z: self.z * by,
        }
    }

    #[inline(always)]
    pub fn plus(self, other: Self) -> Self {
        Self {
            x: self.x + other.x,
            y: self.y + other.y,
            z: self.z + other.z,
        }
    }

    #[inline(always)]
    pub fn minus(self, other: Self) -> Self {
        Self {
            x: self.x - other.x,
            y: self.y - other.y,
            z: self.z - other.z,
        }
    }

    /// |x| + |y| + |z|.
    #[inline(always)]
    pub fn size(self) -> L {
        self.x.abs() + self.y.abs() + self.z.abs()
    }
}
