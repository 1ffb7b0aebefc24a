//! A scene on the device. Sections are compared by identity: what is the same `Arc` as before keeps its buffers.

use crate::render::RenderError;
use crate::scene::Scene;

use super::GpuContext;
use super::scene_bindings::{Resource, SCENE_BINDINGS, SceneBinding};

/// Buffers and textures of one scene, and the scene they were made from.
#[derive(Debug)]
pub struct SceneBuffers {
    scene: Scene,
    /// In the order of [`SCENE_BINDINGS`].
    resources: Vec<Resource>,
    /// All of them as group 0 of the tracing program.
    pub group: wgpu::BindGroup,
}

impl SceneBuffers {
    /// Brings `scene` to the device as a group of this layout, taking over from `old` what has not changed.
    ///
    /// # Errors
    /// When a part of the scene is beyond the device.
    pub fn new(
        context: &GpuContext,
        layout: &wgpu::BindGroupLayout,
        scene: &Scene,
        old: Option<&Self>,
    ) -> Result<Self, RenderError> {
        context.guarded(|| Self::upload(context, layout, scene, old))?
    }

    fn upload(
        context: &GpuContext,
        layout: &wgpu::BindGroupLayout,
        scene: &Scene,
        old: Option<&Self>,
    ) -> Result<Self, RenderError> {
        let resource = |(place, binding): (usize, &SceneBinding)| match old {
            Some(old) if (binding.is_same)(&old.scene, scene) => Ok(old.resources[place].clone()),
            _ => (binding.make)(context, scene),
        };
        let bindings = SCENE_BINDINGS.iter().enumerate();
        let resources = bindings.map(resource).collect::<Result<Vec<_>, _>>()?;
        let entries: Vec<_> = (0..)
            .zip(&resources)
            .map(|(binding, resource)| wgpu::BindGroupEntry {
                binding,
                resource: resource.as_binding(),
            })
            .collect();
        let descriptor = wgpu::BindGroupDescriptor {
            label: Some("scene"),
            layout,
            entries: &entries,
        };
        let group = context.device.create_bind_group(&descriptor);
        Ok(Self {
            scene: scene.clone(),
            resources,
            group,
        })
    }

    /// Whether a scene's loops are there.
    pub fn has_loops_of(&self, scene: &Scene) -> bool {
        self.scene.loops == scene.loops
    }

    /// Bytes of some scenes on the device; what they share counts once.
    pub fn bytes(scenes: &[Self]) -> u64 {
        let mut counted: Vec<&Resource> = Vec::new();
        for resource in scenes.iter().flat_map(|scene| &scene.resources) {
            if !counted.iter().any(|other| other.is(resource)) {
                counted.push(resource);
            }
        }
        counted.into_iter().map(Resource::bytes).sum()
    }
}
