//! Binning in the wide instructions that most x86 processors of the last ten years have (AVX2), looked for when the
//! program runs; on all others in those that the program was built for. Each operation is rounded by itself either way,
//! so that the lists are the same to the bit.

use std::ops::Range;

use super::binning::{Band, Binning};

/// [`Binning::band`] in the widest instructions that the processor has.
pub(super) fn band(binning: &Binning<'_>, rows: Range<i64>) -> Band {
    #[cfg(target_arch = "x86_64")]
    if let Some(band) = avx2::band(binning, rows.clone()) {
        return band;
    }
    binning.band(rows)
}

#[cfg(target_arch = "x86_64")]
#[expect(
    unsafe_code,
    reason = "instructions that were looked for before the first of them is reached"
)]
mod avx2 {
    use std::ops::Range;

    use super::{Band, Binning};

    /// `None` on a processor that has not all of the instructions.
    pub fn band(binning: &Binning<'_>, rows: Range<i64>) -> Option<Band> {
        #[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
        fn in_avx2(binning: &Binning<'_>, rows: Range<i64>) -> Band {
            binning.band(rows)
        }
        let has_all = is_x86_feature_detected!("avx2")
            && is_x86_feature_detected!("bmi1")
            && is_x86_feature_detected!("bmi2")
            && is_x86_feature_detected!("lzcnt")
            && is_x86_feature_detected!("popcnt");
        // SAFETY: the processor has each of the features that the function is compiled for.
        has_all.then(|| unsafe { in_avx2(binning, rows) })
    }
}
