//! Small scenes that show everything: fat leaning loops on both faces, yarns, gaps, edges of the sheet.

use std::path::{Path, PathBuf};

use renderer_core::design::{Back, Design, Method, Pattern};
use renderer_core::render::{Camera, ClothMaker, Extent, RenderRequest, Settings, Sight};
use renderer_core::scene::Cancel;

/// A towel of 12 × 10 crossings in several colours of loop, some left bare, with thin yarns that leave gaps.
pub fn small_towel() -> Design {
    let mut design = Design::default();
    (design.sheet.warps, design.sheet.wefts) = (12, 10);
    design.weave.pattern =
        Pattern::try_from(vec![vec![7, 0, 9, 0], vec![0, 8, 1, 7], vec![0, 1, 7, 0]]).unwrap();
    design.weave.back = Back::Pattern;
    let pile = &mut design.pile;
    (pile.resolution, pile.layers, pile.variants) = (16, 5, 2);
    (pile.top_width, pile.tilt, pile.twist) = (1.6, 90.0, 120.0);
    let camera = &mut design.view.cameras[0];
    (camera.distance, camera.elevation) = (26.0, 40.0);
    design.quality.method = Method::Single;
    (design.quality.bounces, design.quality.samples) = (1, 1);
    design
}

/// A picture of a design by its first camera.
pub fn request(design: &Design, size: [u32; 2]) -> RenderRequest {
    let camera = Camera::from_design(&design.view.cameras[0]);
    let (extent, never) = (Extent::LIVE, Cancel::never());
    let mut maker = ClothMaker::default();
    let sight = Sight::new(&mut maker, design, &camera, size, extent, &never);
    let settings = Settings::from(&design.quality);
    sight.unwrap().request(size, settings)
}

/// A shipped preset.
pub fn preset_path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../presets/{name}.toml"))
}

/// Presets that ask nothing of a renderer that another does not: the same cloth in another light, another bend, another kind of
/// pile in the same volumes. Short tests draw them all the same.
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

/// Every preset that is shipped.
pub fn preset_paths() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../presets");
    let mut paths: Vec<_> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| {
            path.extension()
                .is_some_and(|extension| extension == "toml")
        })
        .collect();
    paths.sort();
    paths
}
