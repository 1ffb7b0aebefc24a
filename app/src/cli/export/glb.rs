//! `export loops` as binary glTF 2.0: each loop's bilinear patch as two triangles with the loop's colour.
//!
//! Vertices are in mm with z up, as everywhere here; the one node turns and scales them to glTF's metres with y up. No
//! normals are written: glTF then shades every triangle flat, and the material is double-sided.

use std::path::Path;

use renderer_core::design::Design;
use renderer_core::scene;
use serde_json::json;

use super::loops::records;
use crate::cli::arguments::BadArgument;
use crate::files;

/// Bytes of one vertex: position 3 × f32, colour 4 × u16.
const VERTEX: usize = 20;
/// Bytes of one loop: four vertices and six u32 indices.
const LOOP: usize = 4 * VERTEX + 6 * 4;

/// Writes the file.
pub fn write(design: &Design, output: &Path) -> anyhow::Result<()> {
    let scene = scene::compile(design)?;
    let count = scene.loops.shapes.len();
    if count == 0 {
        return Err(BadArgument("the design has no loops, and glTF no empty meshes".into()).into());
    }
    // Lengths are u32 in the file; a page is left for the JSON.
    if count > (u32::MAX as usize - 4096) / LOOP {
        let most = (u32::MAX as usize - 4096) / LOOP;
        return Err(BadArgument(format!(
            "the design has {count} loops, a .glb file holds at most {most}; write .json"
        ))
        .into());
    }

    let (mut vertices, mut indices) = (Vec::new(), Vec::new());
    let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    for (index, record) in records(design, &scene).enumerate() {
        let [r, g, b] = record.colour.linear().map(|c| (c * 65535.0).round() as u16);
        for corner in record.corners {
            let position = corner.as_vec3().to_array();
            for (axis, value) in position.into_iter().enumerate() {
                low[axis] = low[axis].min(value);
                high[axis] = high[axis].max(value);
                vertices.extend(value.to_le_bytes());
            }
            for channel in [r, g, b, u16::MAX] {
                vertices.extend(channel.to_le_bytes());
            }
        }
        let first = 4 * index as u32;
        // P0, P1, P2, P3 go around the patch.
        for corner in [0, 1, 2, 0, 2, 3] {
            indices.extend(u32::to_le_bytes(first + corner));
        }
    }
    let half_turn = std::f64::consts::FRAC_1_SQRT_2;
    let description = json!({
        "asset": { "version": "2.0", "generator": concat!("Towel Designer ", env!("CARGO_PKG_VERSION")) },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{
            "mesh": 0,
            "name": "loops",
            "rotation": [-half_turn, 0.0, 0.0, half_turn],
            "scale": [0.001, 0.001, 0.001],
        }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0, "COLOR_0": 1 }, "indices": 2, "material": 0 }] }],
        "materials": [{
            "doubleSided": true,
            "pbrMetallicRoughness": { "metallicFactor": 0.0, "roughnessFactor": 1.0 },
        }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 4 * count, "type": "VEC3", "min": low, "max": high },
            {
                "bufferView": 0, "byteOffset": 12,
                "componentType": 5123, "normalized": true, "count": 4 * count, "type": "VEC4",
            },
            { "bufferView": 1, "componentType": 5125, "count": 6 * count, "type": "SCALAR" },
        ],
        "bufferViews": [
            { "buffer": 0, "byteOffset": 0, "byteLength": vertices.len(), "byteStride": VERTEX, "target": 34962 },
            { "buffer": 0, "byteOffset": vertices.len(), "byteLength": indices.len(), "target": 34963 },
        ],
        "buffers": [{ "byteLength": vertices.len() + indices.len() }],
    });
    let mut text = description.to_string().into_bytes();
    // Chunks are padded to four bytes, JSON with spaces; the binary one is a multiple of four already.
    text.resize(text.len().next_multiple_of(4), b' ');

    files::write_atomically_with(output, |file| {
        let binary = vertices.len() + indices.len();
        let total = 12 + 8 + text.len() + 8 + binary;
        file.write_all(b"glTF")?;
        file.write_all(&2_u32.to_le_bytes())?;
        file.write_all(&(total as u32).to_le_bytes())?;
        file.write_all(&(text.len() as u32).to_le_bytes())?;
        file.write_all(b"JSON")?;
        file.write_all(&text)?;
        file.write_all(&(binary as u32).to_le_bytes())?;
        file.write_all(b"BIN\0")?;
        file.write_all(&vertices)?;
        file.write_all(&indices)
    })?;
    Ok(())
}
