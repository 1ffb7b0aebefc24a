//! Pictures as other programs write them: which way up, of which colours, whole or not.

mod colours;
mod damaged;
mod fuzz;
mod light;
mod palettes;
mod upright;

use std::fs;
use std::path::PathBuf;

use renderer_core::design::{ChartImage, EnvironmentImage, HeightImage, ImagePixels, ImageSlot};
use towel_designer::files::{LoadedImage, load_image};

/// A folder that pictures are written to.
struct PictureFolder(tempfile::TempDir);

impl PictureFolder {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn put(&self, name: &str, bytes: &[u8]) -> PathBuf {
        let path = self.0.path().join(name);
        // Some file systems wait for the disk where a file is written over, but not for a new one.
        let _ = fs::remove_file(&path);
        fs::write(&path, bytes).unwrap();
        path
    }

    /// Reads bytes as an image of a design; the error is its message.
    fn read(&self, slot: ImageSlot, bytes: &[u8]) -> Result<LoadedImage, String> {
        load_image(slot, &self.put("picture", bytes)).map_err(|error| error.to_string())
    }

    /// A chart of which nothing is to be said.
    fn chart(&self, bytes: &[u8]) -> ChartImage {
        let (chart, warnings) = self.chart_and_warnings(bytes);
        assert_eq!(warnings, [""; 0]);
        chart
    }

    fn chart_and_warnings(&self, bytes: &[u8]) -> (ChartImage, Vec<String>) {
        let loaded = self.read(ImageSlot::Chart, bytes).unwrap();
        (colours(loaded.pixels), loaded.warnings)
    }

    fn sky(&self, bytes: &[u8]) -> Result<EnvironmentImage, String> {
        let loaded = self.read(ImageSlot::Environment, bytes)?;
        assert_eq!(loaded.warnings, [""; 0]);
        match loaded.pixels {
            ImagePixels::Light(image) => Ok(image),
            other => panic!("{other:?}"),
        }
    }
}

fn colours(pixels: ImagePixels) -> ChartImage {
    match pixels {
        ImagePixels::Colours(image) => image,
        other => panic!("{other:?}"),
    }
}

fn heights(pixels: ImagePixels) -> HeightImage {
    match pixels {
        ImagePixels::Heights(image) => image,
        other => panic!("{other:?}"),
    }
}

/// All pixels of a chart, row by row.
fn all(chart: &ChartImage) -> Vec<[u8; 4]> {
    let row = |y| (0..chart.width()).map(move |x| chart.pixel(x, y));
    (0..chart.height()).flat_map(row).collect()
}
