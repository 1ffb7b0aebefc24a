//! Small scenes that show everything: fat leaning loops on both faces, yarns, gaps, edges of the sheet.

use std::path::{Path, PathBuf};

use renderer_core::design::{
    Back, ChartImage, Design, EnvironmentImage, EnvironmentReader, HeightImage, Metering, Method,
    Pattern, Sun, preset,
};
use renderer_core::geometry::Camera;
use renderer_core::render::{RenderRequest, Settings};
use renderer_core::scene::Cancel;
use renderer_core::scene::lod::{LodBudget, LodCompiler, LodView};

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
    // A small, strong sun, and light as it is: shadows show, and numbers are those of the lights.
    design.light.sun = vec![Sun::default()];
    design.view.metering = Metering::None;
    design.quality.method = Method::Single;
    (design.quality.bounces, design.quality.samples) = (1, 1);
    design
}

/// A design to draw, and how much of its light is estimated.
#[derive(Clone, Copy)]
pub struct Case<'a> {
    /// What is drawn.
    pub design: &'a Design,
    /// Scatterings after which the light of further ones is estimated; 0 traces all.
    pub traced_bounces: u32,
}

impl<'a> From<&'a Design> for Case<'a> {
    fn from(design: &'a Design) -> Self {
        Self {
            design,
            traced_bounces: 0,
        }
    }
}

/// A picture of a design by its first camera.
pub fn request<'a>(case: impl Into<Case<'a>>, size: [u32; 2]) -> RenderRequest {
    let Case {
        design,
        traced_bounces,
    } = case.into();
    let camera = Camera::from_design(&design.view.cameras[0]);
    let (extent, never) = (LodBudget::LIVE, Cancel::never());
    let mut maker = LodCompiler::default();
    let view = LodView::new(&mut maker, design, &camera, size, extent, &never);
    let settings = Settings {
        traced_bounces,
        ..Settings::from(&design.quality)
    };
    RenderRequest::new(view.unwrap(), size, settings)
}

/// A shipped preset.
pub fn preset_path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../presets/{name}.toml"))
}

/// A preset with its images. The suite of the program sees to it that the program reads every shipped preset as this.
pub fn load_design(path: &Path) -> Design {
    let text = std::fs::read_to_string(path).unwrap();
    let mut design = preset::parse(&text).unwrap();
    let folder = path.parent().unwrap();
    let open = |name: &String| image::open(folder.join(name)).unwrap();
    let coloured = |name: &String| {
        let image = open(name).into_rgba8();
        let (width, height) = (image.width() as usize, image.height() as usize);
        let pixels: Vec<[u8; 4]> = image.pixels().map(|pixel| pixel.0).collect();
        ChartImage::new(width, height, &pixels).unwrap()
    };
    let grey = |name: &String| {
        let image = open(name).into_luma16();
        let (width, height) = (image.width() as usize, image.height() as usize);
        HeightImage::new(width, height, image.into_raw()).unwrap()
    };
    let surroundings = |name: &String| -> EnvironmentImage {
        let image = open(name).into_rgb32f();
        let (width, height) = (image.width() as usize, image.height() as usize);
        let mut reader = EnvironmentReader::new(width, height).unwrap();
        for (x, y, pixel) in image.enumerate_pixels() {
            reader.add(x as usize, y as usize, pixel.0);
        }
        reader.finish().unwrap()
    };
    design.chart.pixels = design.chart.image.as_ref().map(coloured);
    design.nap.pixels = design.nap.image.as_ref().map(coloured);
    design.form.pixels = design.form.image.as_ref().map(grey);
    design.light.environment.pixels = design.light.environment.image.as_ref().map(surroundings);
    design
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
