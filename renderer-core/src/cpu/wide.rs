//! The wide instructions that most x86 processors of the last ten years have (AVX2): twice as many lanes, and what the
//! baseline lacks in rounding and counting bits. Looked for when the program runs; on all other processors the same code runs
//! in the instructions that the program was built for.

use super::{Scratch, Tracer};
use crate::render::accumulation::Sample;

/// [`Tracer::sample_here`] in the widest instructions there are.
#[cfg(target_arch = "x86_64")]
#[expect(
    unsafe_code,
    reason = "calling code for instructions that were looked for"
)]
pub(super) fn sample(
    tracer: &Tracer,
    pixel: [u32; 2],
    number: u32,
    scratch: &mut Scratch,
) -> Sample {
    #[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
    fn in_avx2(tracer: &Tracer, pixel: [u32; 2], number: u32, scratch: &mut Scratch) -> Sample {
        tracer.sample_here(pixel, number, scratch)
    }
    let has_all = is_x86_feature_detected!("avx2")
        && is_x86_feature_detected!("bmi1")
        && is_x86_feature_detected!("bmi2")
        && is_x86_feature_detected!("lzcnt")
        && is_x86_feature_detected!("popcnt");
    if has_all {
        // SAFETY: the processor has each of the features that the function is compiled for.
        unsafe { in_avx2(tracer, pixel, number, scratch) }
    } else {
        tracer.sample_here(pixel, number, scratch)
    }
}

/// [`Tracer::sample_here`].
#[cfg(not(target_arch = "x86_64"))]
pub(super) fn sample(
    tracer: &Tracer,
    pixel: [u32; 2],
    number: u32,
    scratch: &mut Scratch,
) -> Sample {
    tracer.sample_here(pixel, number, scratch)
}
