//! Pictures that are not rendered.

use renderer_core::image::Picture;

/// A picture whose pixels are all different.
pub fn gradient(size: [u32; 2]) -> Picture {
    let pixel = |k: u32| {
        let k = k as f32;
        [0.1 + k / 64.0, 0.9 - k / 100.0, (k * 0.37).fract(), 1.0]
    };
    Picture {
        size,
        pixels: (0..size[0] * size[1]).map(pixel).collect(),
        aov: None,
    }
}

/// A picture of one colour.
pub fn uniform(size: [u32; 2], pixel: [f32; 4]) -> Picture {
    Picture {
        size,
        pixels: vec![pixel; (size[0] * size[1]) as usize],
        aov: None,
    }
}

/// A picture that is brighter by a factor.
pub fn scaled(picture: &Picture, by: f32) -> Picture {
    let mut scaled = picture.clone();
    for pixel in &mut scaled.pixels {
        *pixel = pixel.map(|value| value * by);
    }
    scaled
}
