//! Long paths on software Vulkan, which ends the loops of neighbouring threads together after 65,535 rounds and reports
//! nothing: then a pixel depends on the pixels beside it. In pictures of 24 samples that cost 0.44 % of the light.

use crate::support::device::gpu;
use crate::support::drawing::finish;
use crate::support::scenes::{load_design, preset_path, request};

/// Upper left corners of the parts that are drawn, of 64 × 64 pixels.
const CORNERS: [[u32; 2]; 4] = [[16, 24], [40, 20], [20, 44], [44, 40]];

/// Side of a part, pixels.
const SIDE: u32 = 8;

/// Samples a pixel. One in eleven to fifty was wrong where threads were run in step, so that of 60 at least one is,
/// with a chance of 0.7 and more for each of the presets.
const SAMPLES: u32 = 16;

/// Presets whose paths need the most rounds: many scatterings in crowded terry, and few among long blades.
const PRESETS: [&str; 2] = ["studio-softbox", "grass"];

#[test]
fn a_pixel_is_the_same_alone_as_among_others() {
    let mut backend = gpu();
    for name in PRESETS {
        let mut design = load_design(&preset_path(name));
        design.quality.samples = SAMPLES;
        let mut request = request(&design, [64, 64]);
        for [x, y] in CORNERS {
            let [alone, among_others] = [1, SIDE].map(|side| {
                request.crop = [x, y, side, side];
                finish(&mut backend, &request).pixels[0]
            });
            assert_eq!(alone, among_others, "{name}, pixel {x}, {y}");
        }
    }
}
