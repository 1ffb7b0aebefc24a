//! `export volume`: the volumes inside the loops as pictures, one PNG a layer, the loop's top at the top.
//!
//! Alpha is the density ρ, gray the shade that multiplies the albedo (black where there is no density).

use std::fs;
use std::io;
use std::path::Path;

use renderer_core::design::Design;
use renderer_core::image::encode_png_gray_alpha;
use renderer_core::scene::{self, Volumes};

use crate::files::{self, FileError};

/// Writes `KIND-variant-NN-layer-NN.png` for every layer of every volume into the folder `output`, which is made if it
/// does not exist. Of kinds that are there with yarns of several diameters the later ones are `KIND-2` and so on.
pub fn write(design: &Design, output: &Path) -> anyhow::Result<()> {
    if !output.is_dir() {
        let made = match output.exists() {
            true => Err(io::Error::other("is a file, and a folder is needed")),
            false => fs::create_dir(output),
        };
        made.map_err(|source| FileError::Write {
            path: output.to_owned(),
            source,
        })?;
    }
    let scene = scene::compile(design)?;
    let volumes = &*scene.volumes;
    for (k, kind) in volumes.kinds.iter().enumerate() {
        let same = volumes.kinds[..=k]
            .iter()
            .filter(|other| *other == kind)
            .count();
        let kind = match same {
            1 => kind.name(),
            number => format!("{}-{number}", kind.name()),
        };
        for variant in 0..volumes.variants {
            for layer in 0..volumes.layers {
                let name = format!("{kind}-variant-{variant:02}-layer-{layer:02}.png");
                let file = encode_png_gray_alpha(
                    [volumes.resolution; 2],
                    &gray_alpha(volumes, k, variant, layer),
                )?;
                files::write_atomically(&output.join(name), &file)?;
            }
        }
    }
    Ok(())
}

/// Shade and density of a layer, row by row from the loop's top.
fn gray_alpha(volumes: &Volumes, kind: usize, variant: u32, layer: u32) -> Vec<[u8; 2]> {
    let [resolution, layers, variants, variant, layer] = [
        volumes.resolution,
        volumes.layers,
        volumes.variants,
        variant,
        layer,
    ]
    .map(|n| n as usize);
    let first = ((kind * variants + variant) * layers + layer) * resolution * resolution;
    let texels = &volumes.voxels[first..first + resolution * resolution];
    let rows = texels.chunks(resolution).rev();
    rows.flatten()
        .map(|&[density, shaded]| {
            let shade = f64::from(shaded) / f64::from(density.max(1));
            [(shade.min(1.0) * 255.0).round() as u8, density]
        })
        .collect()
}
