// What is specialised: pipeline constants that host code derives from scene and settings (gpu/pipeline_key.rs), so that
// a feature that a picture does not use costs nothing. Constants that no file here declares are shared with the host
// and declared in renderer-core/src/gpu/constants.rs, from which they are written before every program.

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
override SAMPLED_ENVIRONMENT: bool = false;
// First samples may take their shadows from a cache.
override CACHED_SHADOWS: bool = false;
// Where paths are cut off, some go on to teach how good the estimate is.
override BOUNCED_LIGHT: bool = false;
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
// How much of the environment's light arrives at a path's last point is tracked as along a shadow ray.
override LAST_LOOKS: bool = true;
// Later scatterings than a path's first look for some of the lights only.
override LATER_LIGHTS: bool = true;
