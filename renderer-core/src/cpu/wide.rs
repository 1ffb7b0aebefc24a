//! The wide instructions that most x86 processors of the last ten years have (AVX2): eight lanes, and what the baseline
//! lacks in rounding and counting bits. Looked for when the program runs; on all other processors the same code runs in
//! the instructions that the program was built for.
//!
//! Lanes are fast only in code that is inlined into the function with these instructions, to the last closure: an
//! iterator's `find_map` around a ray's segments was not, every sum of eight became a call, and a sample took 1.4 times
//! as long. So what calls code in lanes is a loop, and profiles should show no `_mm256_add_ps`.

use super::lanes::{Instructions, Plain};
use super::{Scratch, Tracer};
use crate::render::accumulation::Sample;

/// Sample `number` of `pixel`.
pub(super) fn sample(
    tracer: &Tracer,
    pixel: [u32; 2],
    number: u32,
    scratch: &mut Scratch,
) -> Sample {
    #[cfg(target_arch = "x86_64")]
    if tracer.instructions == Instructions::Widest
        && let Some(sample) = avx2::sample(tracer, pixel, number, scratch)
    {
        return sample;
    }
    tracer.sample_in::<Plain>(pixel, number, scratch)
}

#[cfg(target_arch = "x86_64")]
#[expect(
    unsafe_code,
    reason = "instructions that were looked for before the first of them is reached"
)]
mod avx2 {
    use std::arch::x86_64::*;
    use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Sub};

    use crate::cpu::lanes::{LANES, Lanes};
    use crate::cpu::{Scratch, Tracer};
    use crate::render::accumulation::Sample;

    /// [`Tracer::sample_in`] in eight lanes; `None` on a processor that has not all of the instructions.
    #[inline(always)]
    pub fn sample(
        tracer: &Tracer,
        pixel: [u32; 2],
        number: u32,
        scratch: &mut Scratch,
    ) -> Option<Sample> {
        #[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
        fn in_avx2(tracer: &Tracer, pixel: [u32; 2], number: u32, scratch: &mut Scratch) -> Sample {
            tracer.sample_in::<Avx2>(pixel, number, scratch)
        }
        let has_all = is_x86_feature_detected!("avx2")
            && is_x86_feature_detected!("bmi1")
            && is_x86_feature_detected!("bmi2")
            && is_x86_feature_detected!("lzcnt")
            && is_x86_feature_detected!("popcnt");
        // SAFETY: the processor has each of the features that the function is compiled for.
        has_all.then(|| unsafe { in_avx2(tracer, pixel, number, scratch) })
    }

    /// Eight numbers in one register. Named in this module only, by `in_avx2`, so that no other code can make one: all
    /// `unsafe` below relies on that.
    #[derive(Debug, Clone, Copy)]
    struct Avx2(__m256);

    /// Eight truths: all bits of a lane or none.
    #[derive(Debug, Clone, Copy)]
    struct Mask(__m256);

    impl BitAnd for Mask {
        type Output = Self;

        #[inline(always)]
        fn bitand(self, other: Self) -> Self {
            // SAFETY: see [`Avx2`].
            Self(unsafe { _mm256_and_ps(self.0, other.0) })
        }
    }

    impl BitOr for Mask {
        type Output = Self;

        #[inline(always)]
        fn bitor(self, other: Self) -> Self {
            // SAFETY: see [`Avx2`].
            Self(unsafe { _mm256_or_ps(self.0, other.0) })
        }
    }

    impl Add for Avx2 {
        type Output = Self;

        #[inline(always)]
        fn add(self, other: Self) -> Self {
            // SAFETY: see [`Avx2`].
            Self(unsafe { _mm256_add_ps(self.0, other.0) })
        }
    }

    impl Sub for Avx2 {
        type Output = Self;

        #[inline(always)]
        fn sub(self, other: Self) -> Self {
            // SAFETY: see [`Avx2`].
            Self(unsafe { _mm256_sub_ps(self.0, other.0) })
        }
    }

    impl Mul for Avx2 {
        type Output = Self;

        #[inline(always)]
        fn mul(self, other: Self) -> Self {
            // SAFETY: see [`Avx2`].
            Self(unsafe { _mm256_mul_ps(self.0, other.0) })
        }
    }

    impl Div for Avx2 {
        type Output = Self;

        #[inline(always)]
        fn div(self, other: Self) -> Self {
            // SAFETY: see [`Avx2`].
            Self(unsafe { _mm256_div_ps(self.0, other.0) })
        }
    }

    impl Neg for Avx2 {
        type Output = Self;

        #[inline(always)]
        fn neg(self) -> Self {
            // SAFETY: see [`Avx2`].
            Self(unsafe { _mm256_xor_ps(self.0, _mm256_set1_ps(-0.0)) })
        }
    }

    impl Lanes for Avx2 {
        type Mask = Mask;
        type Words = __m256i;

        #[inline(always)]
        fn splat(value: f32) -> Self {
            // SAFETY: see [`Avx2`].
            Self(unsafe { _mm256_set1_ps(value) })
        }

        #[inline(always)]
        fn load(values: &[f32; LANES]) -> Self {
            // SAFETY: see [`Avx2`]; there are eight.
            Self(unsafe { _mm256_loadu_ps(values.as_ptr()) })
        }

        #[inline(always)]
        fn store(self, values: &mut [f32; LANES]) {
            // SAFETY: see [`Avx2`]; there is room for eight.
            unsafe { _mm256_storeu_ps(values.as_mut_ptr(), self.0) }
        }

        #[inline(always)]
        fn columns(records: [[i16; LANES]; LANES]) -> [Self; LANES] {
            // SAFETY: see [`Avx2`]; each record has 16 bytes.
            unsafe {
                let row = |lane: usize| {
                    let words = _mm_loadu_si128(records[lane].as_ptr().cast());
                    _mm256_cvtepi32_ps(_mm256_cvtepi16_epi32(words))
                };
                // Pairs of rows, then fours, then halves of the registers: the usual transposition.
                let pair = |low: usize, high: usize| {
                    let (a, b) = (row(low), row(high));
                    (_mm256_unpacklo_ps(a, b), _mm256_unpackhi_ps(a, b))
                };
                let four = |(a, b): (__m256, __m256), (c, d): (__m256, __m256)| {
                    [
                        _mm256_shuffle_ps::<0x44>(a, c),
                        _mm256_shuffle_ps::<0xee>(a, c),
                        _mm256_shuffle_ps::<0x44>(b, d),
                        _mm256_shuffle_ps::<0xee>(b, d),
                    ]
                };
                let first = four(pair(0, 1), pair(2, 3));
                let second = four(pair(4, 5), pair(6, 7));
                let low = |k: usize| Self(_mm256_permute2f128_ps::<0x20>(first[k], second[k]));
                let high = |k: usize| Self(_mm256_permute2f128_ps::<0x31>(first[k], second[k]));
                [
                    low(0),
                    low(1),
                    low(2),
                    low(3),
                    high(0),
                    high(1),
                    high(2),
                    high(3),
                ]
            }
        }

        #[inline(always)]
        fn bytes(values: [u8; LANES]) -> Self {
            // SAFETY: see [`Avx2`]; there are eight.
            unsafe {
                let words = _mm256_cvtepu8_epi32(_mm_loadl_epi64(values.as_ptr().cast()));
                Self(_mm256_cvtepi32_ps(words))
            }
        }

        #[inline(always)]
        fn abs(self) -> Self {
            // SAFETY: see [`Avx2`].
            Self(unsafe { _mm256_andnot_ps(_mm256_set1_ps(-0.0), self.0) })
        }

        #[inline(always)]
        fn sqrt(self) -> Self {
            // SAFETY: see [`Avx2`].
            Self(unsafe { _mm256_sqrt_ps(self.0) })
        }

        #[inline(always)]
        fn min(self, other: Self) -> Self {
            // SAFETY: see [`Avx2`].
            Self(unsafe { _mm256_min_ps(self.0, other.0) })
        }

        #[inline(always)]
        fn max(self, other: Self) -> Self {
            // SAFETY: see [`Avx2`].
            Self(unsafe { _mm256_max_ps(self.0, other.0) })
        }

        #[inline(always)]
        fn lt(self, other: Self) -> Mask {
            // SAFETY: see [`Avx2`].
            Mask(unsafe { _mm256_cmp_ps::<_CMP_LT_OQ>(self.0, other.0) })
        }

        #[inline(always)]
        fn le(self, other: Self) -> Mask {
            // SAFETY: see [`Avx2`].
            Mask(unsafe { _mm256_cmp_ps::<_CMP_LE_OQ>(self.0, other.0) })
        }

        #[inline(always)]
        fn select(mask: Mask, yes: Self, no: Self) -> Self {
            // SAFETY: see [`Avx2`].
            Self(unsafe { _mm256_blendv_ps(no.0, yes.0, mask.0) })
        }

        #[inline(always)]
        fn bits(mask: Mask) -> u32 {
            // SAFETY: see [`Avx2`].
            unsafe { _mm256_movemask_ps(mask.0) as u32 }
        }

        #[inline(always)]
        fn whole(self) -> (Self, [u32; LANES]) {
            let mut words = [0; LANES];
            // SAFETY: see [`Avx2`]; there is room for eight.
            unsafe {
                let whole = _mm256_cvttps_epi32(self.0);
                _mm256_storeu_si256(words.as_mut_ptr().cast(), whole);
                (Self(_mm256_cvtepi32_ps(whole)), words)
            }
        }

        #[inline(always)]
        fn load_words(words: &[u32; LANES]) -> __m256i {
            // SAFETY: see [`Avx2`]; there are eight.
            unsafe { _mm256_loadu_si256(words.as_ptr().cast()) }
        }

        #[inline(always)]
        fn field(words: __m256i, from: u32, mask: u32) -> Self {
            // SAFETY: see [`Avx2`].
            unsafe {
                let shifted = _mm256_srl_epi32(words, _mm_cvtsi32_si128(from as i32));
                let kept = _mm256_and_si256(shifted, _mm256_set1_epi32(mask as i32));
                Self(_mm256_cvtepi32_ps(kept))
            }
        }

        #[inline(always)]
        fn has(words: __m256i, bits: u32) -> Mask {
            // SAFETY: see [`Avx2`].
            unsafe {
                let kept = _mm256_and_si256(words, _mm256_set1_epi32(bits as i32));
                let lacks = _mm256_cmpeq_epi32(kept, _mm256_setzero_si256());
                let all = _mm256_set1_epi32(-1);
                Mask(_mm256_castsi256_ps(_mm256_xor_si256(lacks, all)))
            }
        }

        #[inline(always)]
        fn sum(self) -> f32 {
            // SAFETY: see [`Avx2`].
            unsafe {
                let low = _mm256_castps256_ps128(self.0);
                let fours = _mm_add_ps(low, _mm256_extractf128_ps::<1>(self.0));
                let pairs = _mm_add_ps(fours, _mm_movehl_ps(fours, fours));
                let one = _mm_add_ss(pairs, _mm_shuffle_ps::<1>(pairs, pairs));
                _mm_cvtss_f32(one)
            }
        }

        #[inline(always)]
        fn least(self) -> f32 {
            // SAFETY: see [`Avx2`].
            unsafe {
                let halves = _mm_min_ps(
                    _mm256_castps256_ps128(self.0),
                    _mm256_extractf128_ps::<1>(self.0),
                );
                let pairs = _mm_min_ps(halves, _mm_movehl_ps(halves, halves));
                let one = _mm_min_ss(pairs, _mm_shuffle_ps::<1>(pairs, pairs));
                _mm_cvtss_f32(one)
            }
        }
    }
}
