//! What the program adds to the GPU renderer: pipelines kept on the disk, and what is left to the processor.

use renderer_core::design::Method;
use renderer_core::gpu::{GpuBackend, GpuContext};
use renderer_core::image::Picture;
use towel_designer::backend::BackendChoice;
use towel_designer::files::keep_pipelines;

use crate::support::drawing::finish;
use crate::support::scenes::{request, small_towel};

const SIZE: [u32; 2] = [40, 35];

/// Bits of all pixels: same request, same bytes.
fn bits(picture: &Picture) -> Vec<[u32; 4]> {
    let pixels = picture.pixels.iter();
    pixels.map(|pixel| pixel.map(f32::to_bits)).collect()
}

#[test]
fn kept_pipelines_are_used_and_broken_ones_passed_over() {
    let folder = tempfile::tempdir().unwrap();
    let picture = || {
        let context = keep_pipelines(GpuContext::headless().unwrap(), folder.path());
        let mut backend = GpuBackend::new(context.clone()).unwrap();
        let picture = finish(&mut backend, &request(&small_towel(), SIZE));
        (bits(&picture), context.pipelines_name())
    };
    let (plain, name) = picture();
    let Some(name) = name else {
        eprintln!("this driver gives out no pipelines");
        return;
    };
    let path = folder.path().join(name);
    let kept = std::fs::read(&path).unwrap();
    assert!(kept.len() > 12, "{}", kept.len());
    eprintln!("{} bytes are kept", kept.len());
    let (mut other, mut flipped) = (kept.clone(), kept.clone());
    other[0] ^= 1;
    *flipped.last_mut().unwrap() ^= 1;
    let broken = [&kept[..5], &kept[..kept.len() - 3], &other, &flipped];
    assert_eq!(picture().0, plain);
    assert_eq!(std::fs::read(&path).unwrap(), kept, "nothing new to keep");
    for bytes in broken {
        std::fs::write(&path, bytes).unwrap();
        assert_eq!(picture().0, plain);
        assert_eq!(std::fs::read(&path).unwrap().len(), kept.len(), "made anew");
    }
    // A folder that cannot be is no reason to fail.
    std::fs::remove_dir_all(folder.path()).unwrap();
    std::fs::write(folder.path(), "not a folder").unwrap();
    assert_eq!(picture().0, plain);
    std::fs::remove_file(folder.path()).unwrap();
    std::fs::create_dir(folder.path()).unwrap();
}

#[test]
fn six_faces_are_left_to_the_processor() {
    for (choice, method, expected) in [
        (BackendChoice::Auto, Method::SixFace, BackendChoice::Cpu),
        (BackendChoice::Auto, Method::Exact, BackendChoice::Auto),
        (BackendChoice::Gpu, Method::SixFace, BackendChoice::Gpu),
    ] {
        assert_eq!(choice.for_method(method), expected);
    }
}
