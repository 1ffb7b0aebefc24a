//! `export volume`: the volumes inside the loops as pictures, one PNG a layer, the loop's top at the top.
//!
//! Each is gray with alpha, 8 bits a channel, not premultiplied: A = 255·ρ, rounded, ρ the density as a share of solid
//! yarn; L = 255·shade, rounded, the shade that multiplies the loop's albedo, and 0 where ρ is 0. In a picture of n × n
//! pixels the pixel in column x, row y (both from 0, the first at the top left) is the voxel around u = (x + ½)/n,
//! v = 1 − (y + ½)/n; column 0 begins at u = 0, row 0 ends at v = 1, the loop's top. Of m layers, layer l is the slab
//! around w = (l + ½)/m − ½, so that layer 0 begins at w = −½.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use renderer_core::design::{Design, PileKind};
use renderer_core::image::encode_png_gray_alpha;
use renderer_core::scene::{self, Volumes};

use crate::files::{self, FileError, UsedFile};

/// Writes `KIND-variant-NN-layer-NN.png` for every layer of every volume into the folder `output`, which is made if it
/// does not exist. Of kinds that are there with yarns of several diameters the later ones are `KIND-2` and so on. None
/// of them may be one of the files that were `read`.
pub fn write(design: &Design, read: &[UsedFile], output: &Path) -> anyhow::Result<()> {
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
    let layers = layers(volumes, output);
    for (path, _) in &layers {
        files::check_apart(read, &[UsedFile::new(path, "a layer of a volume")])?;
    }
    for (path, [kind, variant, layer]) in layers {
        let pixels = gray_alpha(volumes, kind, variant, layer);
        let file = encode_png_gray_alpha([volumes.resolution; 2], &pixels)?;
        files::write_atomically(&path, &file)?;
    }
    Ok(())
}

/// The file of every layer, and of which kind, variant and layer it is.
fn layers(volumes: &Volumes, folder: &Path) -> Vec<(PathBuf, [usize; 3])> {
    let mut files = Vec::new();
    for (k, kind) in kind_names(volumes).iter().enumerate() {
        for variant in 0..volumes.variants {
            for layer in 0..volumes.layers {
                let name = format!("{}-layer-{layer:02}.png", volume_name(kind, variant));
                files.push((folder.join(name), [k, variant as usize, layer as usize]));
            }
        }
    }
    files
}

/// What files call each kind of volumes: the kind, with a number where an earlier one of it has another diameter of
/// yarn.
pub fn kind_names(volumes: &Volumes) -> Vec<String> {
    let kinds = volumes.kinds.iter().enumerate();
    let name = |(k, kind): (usize, &PileKind)| {
        let earlier = volumes.kinds[..k].iter().filter(|other| *other == kind);
        match earlier.count() {
            0 => kind.name(),
            earlier => format!("{}-{}", kind.name(), earlier + 1),
        }
    };
    kinds.map(name).collect()
}

/// What files call a volume of the kind of that name.
pub fn volume_name(kind: &str, variant: u32) -> String {
    format!("{kind}-variant-{variant:02}")
}

/// Shade and density of a layer, row by row from the loop's top.
fn gray_alpha(volumes: &Volumes, kind: usize, variant: usize, layer: usize) -> Vec<[u8; 2]> {
    let [resolution, layers, variants] =
        [volumes.resolution, volumes.layers, volumes.variants].map(|n| n as usize);
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
