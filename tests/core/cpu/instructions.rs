//! The wide instructions of some processors draw what plain ones draw, to the bit. Where there are none both are plain.

use renderer_core::cpu::{CpuBackend, Instructions};
use renderer_core::design::Method;
use renderer_core::render::Backend;

use super::scenes::{CAMERAS, LOOPS};
use crate::support::device::finish;
use crate::support::scenes::{request, small_towel};

#[test]
fn wide_and_plain_instructions_draw_the_same_bits() {
    for method in [Method::Single, Method::Layered, Method::Tracked] {
        for (what, edit) in LOOPS.iter().chain(&CAMERAS[1..]) {
            let mut design = small_towel();
            (design.quality.method, design.quality.bounces) = (method, 3);
            edit(&mut design);
            let mut request = request(&design, [48, 40]);
            request.settings.counters = true;
            let [wide, plain] = [Instructions::Widest, Instructions::Plain].map(|instructions| {
                let mut cpu = CpuBackend::with_instructions(instructions);
                let bits = |x: &[f32; 4]| x.map(f32::to_bits);
                let picture = finish(&mut cpu, &request);
                let pixels: Vec<_> = picture.pixels.iter().map(bits).collect();
                (pixels, cpu.counters().unwrap())
            });
            assert!(wide.1.rays > 0, "{what}: nothing was drawn");
            assert_eq!(wide.1, plain.1, "{what} by {method:?}");
            assert!(wide.0 == plain.0, "{what} by {method:?}: other pixels");
        }
    }
}

/// One closure that is not inlined into the function with the wide instructions turns every sum of eight numbers into a
/// call, and draws the same bits at half the pace: then the program has these functions, else only their instructions.
#[test]
#[cfg(all(target_arch = "x86_64", target_os = "linux"))]
fn no_sum_of_eight_numbers_is_a_call() {
    let program = std::fs::read(std::env::current_exe().unwrap()).unwrap();
    // Put together here, since what is written out would be found in this program.
    let has = |parts: [&str; 2]| {
        let name = parts.concat().into_bytes();
        program.windows(name.len()).any(|bytes| bytes == name)
    };
    assert!(
        has(["in_", "avx2"]),
        "the program has no names of functions"
    );
    for sum in ["add_ps", "mul_ps"] {
        assert!(!has(["_mm256_", sum]), "{sum} is called");
    }
}
