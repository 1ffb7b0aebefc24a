//! Every shipped preset: the same samples as the reference, by the comparator and within the limits of the GPU's.

use renderer_core::cpu::CpuBackend;
use renderer_core::design::Method;

use crate::gpu_backend::assert_changes_are_drawn_as_by_a_new_backend;
use crate::same_sample::{MOST_FLIPS, PART, compare_presets};
use crate::support::scenes::preset_paths;
use crate::support::unlike::unlike_preset_paths;

const METHODS: [Method; 2] = [Method::Single, Method::Layered];

#[test]
fn a_part_of_every_preset_is_the_references() {
    let (crop, flips) = PART;
    compare_presets(
        preset_paths(),
        &mut CpuBackend::default(),
        &METHODS,
        &[1, 4],
        Some(crop),
        flips,
    );
}

#[test]
#[ignore = "long: about 90 s"]
fn unlike_presets_are_the_references_picture() {
    compare_presets(
        unlike_preset_paths(),
        &mut CpuBackend::default(),
        &METHODS,
        &[1, 4],
        None,
        MOST_FLIPS,
    );
}

/// What is derived from a scene is kept while its sections are the same.
#[test]
fn a_changed_scene_is_drawn_as_by_a_new_backend() {
    assert_changes_are_drawn_as_by_a_new_backend(&|| Box::new(CpuBackend::default()));
}
