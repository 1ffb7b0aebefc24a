//! What a picture needs of the shaders: the values of their `override` constants. Pipelines are cached by it.

use crate::design::{Interpolation, Method, Phase, SkeletonHeight, SkeletonShading};
use crate::render::{Optimisation, Settings};
use crate::sampling::Sampler;
use crate::scene::{Scene, Sky};

use super::constants;

/// The features that a scene and its settings use; the rest costs nothing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct PipelineKey {
    /// How the first segment gathers light.
    pub method: Method,
    /// How pile scatters.
    pub phase: Option<Phase>,
    /// More than one scattering is allowed.
    pub long_paths: bool,
    /// Light of further scatterings is estimated.
    pub path_cutoff: bool,
    /// Layers blend.
    pub linear_layers: bool,
    /// Layers of the volumes.
    pub layers: u32,
    /// Loops fade in from their roots.
    pub root_blend: bool,
    /// The ground weave, if it is drawn.
    pub skeleton: Option<SkeletonHeight>,
    /// How ground yarns scatter.
    pub shading: SkeletonShading,
    /// Number of suns.
    pub suns: u32,
    /// Number of area lights.
    pub areas: u32,
    /// The environment gives light.
    pub environment: bool,
    /// Rays towards lights are followed.
    pub shadows: bool,
    /// Random numbers are Owen-scrambled Sobol points; else independent.
    pub owen: bool,
    /// How it varies: `SKY_*`.
    pub sky: u32,
    /// Directions to it are drawn by its light.
    pub sampled_environment: bool,
    /// First samples may take their shadows from a cache, which the device has room for.
    pub cached_shadows: bool,
    /// Where paths are cut off, some go on to teach how good the estimate is; with `cached_shadows`.
    pub bounced_light: bool,
    /// The cloth is bent.
    pub bent: bool,
    /// The picture shows the cloth at several levels of detail.
    pub levels: bool,
    /// Depth, normal and albedo are accumulated.
    pub aov: bool,
    /// Work is counted.
    pub counters: bool,
    /// Voxels are filtered in f32.
    pub filter_f32: bool,
    /// Shadow rays end where hardly any light comes through.
    pub opaque_rays: bool,
    /// Ground yarns are looked for only where pile lets something through.
    pub hidden_ground: bool,
    /// The last ray of a path by `tracked` is a shadow ray to the environment.
    pub last_looks: bool,
    /// Later scatterings than a path's first look for some of the lights only.
    pub later_lights: bool,
}

impl PipelineKey {
    /// What `scene` drawn with `settings` needs, without a cache of shadows and at one level of detail.
    pub fn new(scene: &Scene, settings: &Settings, filter_f32: bool) -> Self {
        // What the scene's numbers turn off as well, so that it need not be left out.
        let every = !settings.optimisations.has(Optimisation::UnusedShading);
        let environment = every || scene.lights.environment.iter().any(|&c| c > 0.0);
        Self {
            method: settings.method,
            phase: scene.pile.shared_phase(),
            long_paths: every || settings.path_cutoff().unwrap_or(settings.bounces) > 1,
            path_cutoff: every || settings.path_cutoff().is_some(),
            linear_layers: scene.volumes.interpolation == Interpolation::Linear,
            layers: scene.volumes.layers,
            root_blend: scene.volumes.root_blend > 0.0,
            skeleton: scene.skeleton.visible.then_some(scene.skeleton.height),
            shading: scene.skeleton.shading,
            suns: if every {
                constants::MAX_SUNS
            } else {
                scene.lights.suns.len() as u32
            },
            areas: if every {
                constants::MAX_AREAS
            } else {
                scene.lights.areas.len() as u32
            },
            shadows: settings.shadows,
            owen: settings.sampler == Sampler::Owen,
            environment,
            sky: match scene.lights.sky {
                Sky::Gradient { .. } if environment => constants::SKY_GRADIENT,
                Sky::Image { .. } if environment => constants::SKY_IMAGE,
                _ => constants::SKY_UNIFORM,
            },
            sampled_environment: environment && scene.lights.sky.importance_table().is_some(),
            cached_shadows: false,
            bounced_light: false,
            bent: scene.form.is_some(),
            levels: false,
            aov: settings.aov,
            counters: settings.counters,
            filter_f32,
            opaque_rays: settings.optimisations.has(Optimisation::OpaqueRays),
            hidden_ground: settings.optimisations.has(Optimisation::HiddenGround),
            last_looks: settings.method == Method::Tracked
                && settings.optimisations.has(Optimisation::LastLooks),
            later_lights: settings.optimisations.has(Optimisation::LaterLights),
        }
    }

    /// Names and values of the `override` constants of shaders/settings.wgsl.
    pub fn constants(&self) -> Vec<(&'static str, f64)> {
        let method = match self.method {
            Method::Single => constants::METHOD_SINGLE,
            Method::Layered => constants::METHOD_LAYERED,
            Method::Tracked => constants::METHOD_TRACKED,
            // Of these two the backend refuses `six-face`.
            Method::Exact | Method::SixFace => constants::METHOD_EXACT,
        };
        let phase = self
            .phase
            .map_or(constants::PHASE_OF_MATERIAL, constants::phase);
        let skeleton = match self.skeleton {
            None => constants::SKELETON_NONE,
            Some(SkeletonHeight::Winding) => constants::SKELETON_WINDING,
            Some(SkeletonHeight::Paper) => constants::SKELETON_PAPER,
        };
        let shading = match self.shading {
            SkeletonShading::Lambert => constants::SHADING_LAMBERT,
            SkeletonShading::Phong => constants::SHADING_PHONG,
            SkeletonShading::PoulinFournier => constants::SHADING_POULIN_FOURNIER,
        };
        let flag = |name, on: bool| (name, f64::from(u8::from(on)));
        vec![
            ("METHOD", method.into()),
            ("PHASE", phase.into()),
            flag("LONG_PATHS", self.long_paths),
            flag("PATH_CUTOFF", self.path_cutoff),
            flag("LINEAR_LAYERS", self.linear_layers),
            ("LAYERS", self.layers.into()),
            flag("ROOT_BLEND", self.root_blend),
            ("SKELETON", skeleton.into()),
            ("SHADING", shading.into()),
            ("SUN_COUNT", self.suns.into()),
            ("AREA_COUNT", self.areas.into()),
            flag("ENVIRONMENT", self.environment),
            flag("SHADOWS", self.shadows),
            flag("OWEN", self.owen),
            ("SKY", self.sky.into()),
            flag("SAMPLED_ENVIRONMENT", self.sampled_environment),
            flag("CACHED_SHADOWS", self.cached_shadows),
            flag("BOUNCED_LIGHT", self.bounced_light),
            flag("BENT", self.bent),
            flag("LEVELS", self.levels),
            flag("AOV", self.aov),
            flag("COUNTERS", self.counters),
            flag("FILTER_F32", self.filter_f32),
            flag("OPAQUE_RAYS", self.opaque_rays),
            flag("HIDDEN_GROUND", self.hidden_ground),
            flag("LAST_LOOKS", self.last_looks),
            flag("LATER_LIGHTS", self.later_lights),
        ]
    }
}
