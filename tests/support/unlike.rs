//! The shipped presets that differ in what they ask of a renderer.

use std::path::PathBuf;

use super::scenes::{preset_path, preset_paths};

/// Presets that ask nothing of a renderer that another does not: the same cloth in another light, another bend, another
/// kind of pile in the same volumes. Short tests draw them all the same.
const LIKE_ANOTHER: [&str; 17] = [
    "draped-net",
    "endless-carpet",
    "evening-hall",
    "folded-stack",
    "grass",
    "noon",
    "pulled-loops",
    "relief-carpet",
    "rolled-towel",
    "sculpted-rug",
    "shag-rug",
    "stage-lights",
    "studio-softbox",
    "vacuumed-carpet",
    "waves",
    "wet-towel",
    "window",
];

/// The presets that differ in what they ask of a renderer, for tests that take long over each.
pub fn unlike_preset_paths() -> Vec<PathBuf> {
    let is_like_another = |path: &PathBuf| LIKE_ANOTHER.map(preset_path).contains(path);
    let (alike, unlike): (Vec<_>, Vec<_>) = preset_paths().into_iter().partition(is_like_another);
    assert_eq!(alike.len(), LIKE_ANOTHER.len(), "all of these are shipped");
    unlike
}
