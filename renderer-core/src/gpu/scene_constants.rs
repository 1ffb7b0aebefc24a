//! The numbers of a scene, as the tracing program reads them.

use bytemuck::Zeroable;

use crate::scene::{Scene, Sky};

use super::constants::{self, MAX_AREAS, MAX_MATERIALS, MAX_SUNS};
use super::layout::{AreaLight, Material, SceneConstants, Sun};
use super::scene_textures::exponents;

fn rgb(colour: [f64; 3]) -> [f32; 4] {
    [colour[0] as f32, colour[1] as f32, colour[2] as f32, 0.0]
}

/// What is uniform over a scene.
pub fn scene_constants(scene: &Scene) -> SceneConstants {
    let (sheet, loops, volumes) = (&scene.sheet, &scene.loops, &scene.volumes);
    let (pile, skeleton, lights) = (&scene.pile, &scene.skeleton, &scene.lights);
    let form = scene.form.as_ref();
    let slices = volumes.layers * volumes.variants * volumes.kinds.len() as u32;
    let [u, v, w] = volumes.reference_size_mm;
    let reach = |radius: f32, pitch: f64| {
        // Yarns k places away reach into the cell while k·pitch − radius < ½ pitch.
        (f64::from(radius) / pitch - 0.5).ceil().max(0.0) as i32
    };
    let mut suns = [Sun {
        direction: [0.0; 4],
        irradiance: [0.0; 4],
    }; MAX_SUNS as usize];
    for (slot, sun) in suns.iter_mut().zip(&lights.suns) {
        slot.direction = rgb(sun.direction);
        slot.direction[3] = (2.0 * (sun.angular_radius / 2.0).sin().powi(2)) as f32;
        slot.irradiance = rgb(sun.irradiance);
    }
    let mut areas = [AreaLight::zeroed(); MAX_AREAS as usize];
    for (slot, area) in areas.iter_mut().zip(&lights.areas) {
        let [half_width, half_height] = area.half_sides.map(rgb);
        *slot = AreaLight {
            centre: rgb(area.centre),
            half_width,
            half_height,
            facing: rgb(area.facing),
            intensity: rgb(area.intensity),
        };
    }
    let rows = exponents(pile);
    let mut materials = [Material::zeroed(); MAX_MATERIALS as usize];
    for (slot, material) in materials.iter_mut().zip(&pile.materials) {
        let row = rows.iter().position(|&row| row == material.exponent);
        *slot = Material {
            density: material.density_per_mm,
            kind: material.kind,
            transmission: material.transmission,
            specular: material.specular,
            exponent: material.exponent,
            highlight_row: row.unwrap_or(0) as u32,
            phase: constants::phase(material.phase),
            unused: 0,
        };
    }
    let mut environment = rgb(lights.environment);
    let ([zenith, horizon, ground], middle) = match &lights.sky {
        Sky::Uniform => ([[0.0; 3]; 3], 0.0),
        Sky::Gradient {
            zenith,
            horizon,
            ground,
        } => ([*zenith, *horizon, *ground], 0.0),
        Sky::Image { middle, .. } => ([[0.0; 3]; 3], *middle),
    };
    environment[3] = middle as f32;
    let mut sky_ground = rgb(ground);
    sky_ground[3] = Sky::HAZE as f32;
    SceneConstants {
        pitch: [sheet.pitch_x_mm as f32, sheet.pitch_y_mm as f32],
        z_range: loops.z_range_mm,
        sheet: [sheet.warps as i32, sheet.wefts as i32],
        blocks: loops.blocks.map(|blocks| blocks as i32),
        margin: loops.margin.map(|blocks| blocks as i32),
        half_base_width: 0.5 * loops.base_width_mm,
        thickness: loops.thickness_mm,
        height_unit: loops.height_unit_mm,
        penetration_depth: loops.penetration_depth_mm,
        length_unit: loops.length_unit_mm,
        block_shift: loops.block_cells.ilog2(),
        place_shift: loops.entry_layout.place_shift(),
        masks_shift: loops.entry_layout.masks_shift(),
        heights_shift: loops.entry_layout.heights_shift(),
        height_bits: loops.entry_layout.height_bits,
        root_blend: volumes.root_blend,
        reference_size: [u, v, w, scene.sheet.cloth_scale() as f32],
        resolution: volumes.resolution as f32,
        per_slice: 1.0 / slices.max(1) as f32,
        variants: volumes.variants,
        max_density: pile
            .materials
            .iter()
            .fold(0.0, |most, material| most.max(material.density_per_mm)),
        crimp: skeleton.crimp_mm,
        yarn_radius: [skeleton.warp_radius_mm, skeleton.weft_radius_mm],
        yarn_reach: [
            reach(skeleton.warp_radius_mm, sheet.pitch_x_mm),
            reach(skeleton.weft_radius_mm, sheet.pitch_y_mm),
        ],
        repeat: skeleton.repeat,
        skeleton_specular: skeleton.specular,
        skeleton_exponent: skeleton.exponent,
        fibre_spacing: 2.0 * skeleton.fibre_spacing,
        looks_down: skeleton.worth_looking_down(&scene.sheet),
        form_facets: form.map_or([0; 2], |form| form.facets.map(|count| count as i32)),
        form_first_cell: form.map_or([0; 2], |form| form.first_cell),
        form_heights: form.map_or([0.0; 2], |form| form.heights.map(|mm| mm as f32)),
        form_facet_cells: form.map_or(1, |form| form.facet_cells as i32),
        form_levels: form.map_or(0, |form| form.levels.len() as u32),
        skeleton_albedo: rgb(skeleton.albedo.map(f64::from)),
        environment,
        sky_zenith: rgb(zenith),
        sky_horizon: rgb(horizon),
        sky_ground,
        background: rgb(lights.background),
        suns,
        areas,
        materials,
    }
}
