// The scene on the device: the records of renderer-core/src/scene/types.rs and the constants of a scene.
// Host mirrors: gpu/layout.rs (a test compares names, offsets and sizes). Lengths in mm, angles in radians.

struct Sun {
    // Unit vector to the sun's centre; w: 1 − cos(angular radius).
    direction: vec4<f32>,
    // Irradiance on a plane that faces the sun; w unused.
    irradiance: vec4<f32>,
}

// A rectangle that shines on the side where the cloth is.
struct AreaLight {
    // Its middle, world space; w unused.
    centre: vec4<f32>,
    // From there to the middles of two neighbouring sides; w unused.
    half_width: vec4<f32>,
    half_height: vec4<f32>,
    // Unit vector to where it shines; w unused.
    facing: vec4<f32>,
    // Radiance times area; w unused.
    intensity: vec4<f32>,
}

struct Material {
    // Extinction of solid yarn, 1/mm.
    density: f32,
    // Index of the kind of pile.
    kind: u32,
    // k of frame_lambert and gradient_lambert.
    transmission: f32,
    // s of kajiya_kay.
    specular: f32,
    // p of kajiya_kay.
    exponent: f32,
    // Row of highlight_norm.
    highlight_row: u32,
    // PHASE_*.
    phase: u32,
    unused: u32,
}

struct SceneConstants {
    // Size of a cell along x and y.
    pitch: vec2<f32>,
    // Lowest and highest point of the loops.
    z_range: vec2<f32>,
    // Cells along x and y, without the margin.
    sheet: vec2<i32>,
    // Blocks of the grid along x and y, and how many of them lie before block 0, which begins with cell 0.
    blocks: vec2<i32>,
    margin: vec2<i32>,
    // Half the width of all patches at their roots, w₀/2.
    half_base_width: f32,
    // h: thickness of all patches along their normal.
    thickness: f32,
    // Unit of the blocks' height ranges.
    height_unit: f32,
    // How far loops of one face reach to the other side of the sheet's plane at most.
    penetration_depth: f32,
    // Unit of the loops' shapes.
    length_unit: f32,
    // A block is 1 << block_shift cells wide and deep.
    block_shift: u32,
    // Where parts of an entry begin, and how many bits each of its heights has: see scene/loops.rs.
    place_shift: u32,
    masks_shift: u32,
    heights_shift: u32,
    height_bits: u32,
    // Share of the loop from its root over which its density fades in.
    root_blend: f32,
    // Voxels along u and v.
    resolution: f32,
    // 1 / number of slices of the voxel texture.
    per_slice: f32,
    // Volumes of each kind of pile.
    variants: u32,
    // Size of the loop that the volumes were made for, along u, v, w; w: how many mm of the cloth one of the scene's
    // is.
    reference_size: vec4<f32>,
    // Highest density of any material, 1/mm.
    max_density: f32,
    // H: how far ground yarns rise and sink.
    crimp: f32,
    // Radii of warps and wefts.
    yarn_radius: vec2<f32>,
    // How many yarns away warps and wefts reach into a cell; 0 unless they are thicker than their pitch.
    yarn_reach: vec2<i32>,
    // Repeat of the stitch pattern along x and y, cells.
    repeat: vec2<u32>,
    // Share of light in the ground yarns' highlight, and its sharpness, for phong and poulin_fournier.
    skeleton_specular: f32,
    skeleton_exponent: f32,
    // Distance of the axes of their fibres, in radii of a fibre, for poulin_fournier.
    fibre_spacing: f32,
    // Share of looks at the environment that go to the other side of the ground.
    looks_down: f32,
    // BENT: facets along x and y, the first cell of the first, lowest and highest z of the flat cloth, cells along a
    // facet's sides, and levels of boxes.
    form_facets: vec2<i32>,
    form_first_cell: vec2<i32>,
    form_heights: vec2<f32>,
    form_facet_cells: i32,
    form_levels: u32,
    // Albedo of the ground yarns; w unused.
    skeleton_albedo: vec4<f32>,
    // Radiance of the environment where the sky is 1; w: azimuth of the middle of SKY_IMAGE's picture.
    environment: vec4<f32>,
    // SKY_GRADIENT: colours above, around and below; w of the last: sine of the depth at which the ground begins.
    sky_zenith: vec4<f32>,
    sky_horizon: vec4<f32>,
    sky_ground: vec4<f32>,
    // Radiance seen where there is no cloth; w unused.
    background: vec4<f32>,
    suns: array<Sun, MAX_SUNS>,
    areas: array<AreaLight, MAX_AREAS>,
    materials: array<Material, MAX_MATERIALS>,
}

@group(0) @binding(0) var<uniform> scene: SceneConstants;
// Eight i16 a loop: axis and root_z0, half_top and root_z1, in units of length_unit.
@group(0) @binding(1) var<storage, read> loop_shapes: array<vec4<u32>>;
// One vec2 a loop: red and green, blue and variant and material.
@group(0) @binding(2) var<storage, read> loop_looks: array<vec2<u32>>;
// entries_start, first_loop, planted, z_range.
@group(0) @binding(3) var<storage, read> block_headers: array<vec4<u32>>;
@group(0) @binding(4) var<storage, read> block_entries: array<u32>;
// For each cell of the stitch repeat: which yarn is over here and at its four neighbours, see skeleton.wgsl.
@group(0) @binding(5) var<storage, read> stitches: array<u32>;
// N_p(θ_v) of kajiya_kay at HIGHLIGHT_INTERVALS + 1 angles from 0 to π/2, a row for each exponent in use.
@group(0) @binding(6) var highlight_norm: texture_2d<f32>;
// Density ρ and ρ·shade; slice = (kind · variants + variant) · layers + layer.
@group(0) @binding(7) var voxels: texture_3d<f32>;
// ρ·ttᵀ: (xx, yy, zz, xy) and (xz, yz, –, –), when the phase function needs it.
@group(0) @binding(8) var tangents_a: texture_3d<f32>;
@group(0) @binding(9) var tangents_b: texture_3d<f32>;
@group(0) @binding(10) var voxel_sampler: sampler;
// SKY_IMAGE: equirectangular, row 0 at the zenith. w: the share of its row's light up to a texel and with it; behind
// the last texel that of the light of the upper half and of the lower half up to a row, counted from the pole.
@group(0) @binding(11) var sky_picture: texture_2d<f32>;
// BENT: in rows of FORM_ROW, world positions of the lower and the upper end of the facets' corners, then least and
// greatest corners of boxes.
@group(0) @binding(12) var form_mesh: texture_2d<f32>;

// Where light is scattered; `cell` and `point` as in Ray.
const NOTHING: u32 = 0u;
const PILE: u32 = 1u;
const GROUND: u32 = 2u;
struct Scatter {
    // NOTHING, PILE or GROUND.
    what: u32,
    cell: vec2<i32>,
    point: vec3<f32>,
    // Distance from the ray's origin.
    t: f32,
    // n̂ of the loop or outward normal of the ground yarn.
    normal: vec3<f32>,
    // Of pile, the unit tangent of the fibre for PHASE_KAJIYA_KAY; out of the yarn, −∇ρ/|∇ρ|, for
    // PHASE_GRADIENT_LAMBERT. Of a ground yarn, the direction along it; 0 on its cut ends.
    axis: vec3<f32>,
    // How much of a surface it is, for PHASE_GRADIENT_LAMBERT: 0 scatters evenly.
    surfaceness: f32,
    // Single-scatter or diffuse albedo.
    albedo: vec3<f32>,
    // Index of the loop's material.
    material: u32,
}

fn no_scatter() -> Scatter {
    return Scatter(NOTHING, vec2<i32>(), vec3<f32>(), 0.0, vec3<f32>(), vec3<f32>(), 0.0, vec3<f32>(), 0u);
}

// How a material scatters: a constant unless materials differ.
fn phase_of(material: u32) -> u32 {
    if PHASE == PHASE_OF_MATERIAL {
        return scene.materials[material].phase;
    }
    return PHASE;
}
