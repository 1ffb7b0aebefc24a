//! `export turbulence`: the four channels of the smooth disorder, one pixel a cell, the far edge at the top.

use std::path::Path;

use renderer_core::design::Design;
use renderer_core::image::encode_exr_channels;
use renderer_core::scene::{CHANNELS, SheetGeometry, TurbulenceField};

use crate::files;

/// Writes the file. Its channels are `tilt_x` and `tilt_y`, in the designer "tilt sideways" and "tilt lengthwise",
/// `stretch` and `twist`.
pub fn write(design: &Design, output: &Path) -> anyhow::Result<()> {
    let sheet = SheetGeometry::new(design);
    let field = TurbulenceField::new(&sheet, &design.turbulence);
    let names = CHANNELS.map(|name| name.replace(' ', "_"));
    let channel = |c: usize| -> Vec<f32> {
        let rows = field.values().chunks(field.warps().max(1)).rev();
        rows.flatten().map(|value| value[c]).collect()
    };
    let channels = names.iter().enumerate();
    let channels = channels
        .map(|(c, name)| (name.as_str(), channel(c)))
        .collect();
    let file = encode_exr_channels([sheet.warps, sheet.wefts], channels)?;
    files::write_atomically(output, &file)?;
    Ok(())
}
