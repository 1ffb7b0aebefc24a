// What is specialised: pipeline constants that host code derives from scene and settings (gpu/pipeline_key.rs), so that a
// feature that a picture does not use costs nothing. Constants are shared with gpu/layout.rs.

const METHOD_SINGLE: u32 = 0u;
const METHOD_LAYERED: u32 = 1u;
const METHOD_TRACKED: u32 = 2u;
const METHOD_EXACT: u32 = 3u;

const PHASE_ISOTROPIC: u32 = 0u;
const PHASE_FRAME_LAMBERT: u32 = 1u;
const PHASE_KAJIYA_KAY: u32 = 2u;
const PHASE_GRADIENT_LAMBERT: u32 = 3u;
// Not all materials scatter alike.
const PHASE_OF_MATERIAL: u32 = 4u;

const SKELETON_NONE: u32 = 0u;
const SKELETON_WINDING: u32 = 1u;
const SKELETON_PAPER: u32 = 2u;

const SKY_UNIFORM: u32 = 0u;
const SKY_GRADIENT: u32 = 1u;
const SKY_IMAGE: u32 = 2u;
// Columns of sums of light beside SKY_IMAGE's picture.
const SKY_SUMS: u32 = 2u;
// Share of the directions to a drawn sky that follow the phase.
const PHASE_SHARE: f32 = 0.25;

const SHADING_LAMBERT: u32 = 0u;
const SHADING_PHONG: u32 = 1u;
const SHADING_POULIN_FOURNIER: u32 = 2u;

// Side of the tiles that work is handed out in, pixels.
const TILE: u32 = 16u;
const TILE_PIXELS: u32 = 256u;
// Threads of a workgroup, in every entry point.
const WORKGROUP: u32 = 64u;
const MAX_SUNS: u32 = 8u;
const MAX_AREAS: u32 = 4u;
const MAX_MATERIALS: u32 = 130u;
// Intervals of the table of N_p over [0, π/2].
const HIGHLIGHT_INTERVALS: u32 = 256u;
// Independent scrambles of the random sequence, and so accumulators of each pixel (MODEL.md §10).
const SCRAMBLES: u32 = 4u;
// Where in `totals` shadows begin; steps of their sums and means from 0 to 1; the mark of a mean that is final; how many rays
// make a mean and a final one; and the share that is traced until then.
const SHADOWS_FROM: u32 = 32u;
const SHADOW_STEPS: f32 = 1024.0;
const SHADOW_MEAN_STEPS: f32 = 32767.0;
const SHADOW_FINAL: u32 = 0x80000000u;
const ENOUGH_RAYS: u32 = 16u;
const ALL_RAYS: u32 = 128u;
const TRACED_SHARE: f32 = 0.25;
// Samples of one scramble before the next one's turn.
const RUN: u32 = 8u;

const PI: f32 = 3.14159265358979;
// Beyond every distance in a scene, and small enough that sums and products of two stay finite.
const FAR: f32 = 1.0e15;

// How the first segment of a path and its shadow rays gather light: METHOD_*.
override METHOD: u32 = 0u;
// How pile scatters: PHASE_*.
override PHASE: u32 = 0u;
// More than one scattering is allowed.
override LONG_PATHS: bool = false;
// The light of further scatterings is estimated at some point of a path, not traced.
override PATH_CUTOFF: bool = false;
// Densities blend from layer to layer; else layers are slabs.
override LINEAR_LAYERS: bool = true;
// Layers of the loop volumes.
override LAYERS: u32 = 16u;
// Loops fade in from their roots.
override ROOT_BLEND: bool = true;
// Shape of the ground yarns: SKELETON_*.
override SKELETON: u32 = 1u;
// How ground yarns scatter: SHADING_*.
override SHADING: u32 = 0u;
override SUN_COUNT: u32 = 1u;
override AREA_COUNT: u32 = 0u;
// The environment gives light.
override ENVIRONMENT: bool = true;
// Rays towards lights are followed; else nothing is in their way.
override SHADOWS: bool = true;
// Random numbers are Owen-scrambled Sobol points; else independent.
override OWEN: bool = true;
// How the environment varies with direction: SKY_*.
override SKY: u32 = 0u;
// Directions to it are drawn by its light, which no path meets by itself then.
override DRAWN_SKY: bool = false;
// First samples may take their shadows from a cache.
override CACHED_SHADOWS: bool = false;
// The cloth is bent, or pulled by a net.
override BENT: bool = false;
// The picture shows the cloth at several levels of detail.
override LEVELS: bool = false;
// Also accumulate depth, normal and albedo.
override AOV: bool = false;
// Count rays, cells and tests.
override COUNTERS: bool = false;
// Filter voxels by hand in f32 rather than with the sampler's 8-bit weights.
override FILTER_F32: bool = false;
// Shadow rays end where hardly any light comes through.
override OPAQUE_RAYS: bool = true;
// Ground yarns are looked for only where pile lets something through.
override HIDDEN_GROUND: bool = true;
