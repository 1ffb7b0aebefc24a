//! The files of shaders/, put together in order behind the constants that they share with the host; errors are given by
//! file and line.

use super::constants::prelude;
use super::dead_branches::without_dead_branches;
use crate::render::RenderError;

/// A shader file: name and text.
pub type Part = (&'static str, &'static str);

macro_rules! parts {
    ($($name:literal)+) => { &[$(($name, include_str!(concat!("../../../shaders/", $name)))),+] };
}

/// The program that adds samples, in the order in which its parts build on each other.
pub const TRACE: &[Part] = parts![
    "settings.wgsl" "scene.wgsl" "sampling.wgsl" "counters.wgsl" "walk.wgsl" "block.wgsl" "patch.wgsl" "volume.wgsl"
    "skeleton.wgsl" "surface.wgsl" "phase.wgsl" "lights.wgsl" "events.wgsl" "single.wgsl" "layered.wgsl"
    "composite.wgsl" "loop_line.wgsl" "met.wgsl" "tracked.wgsl" "camera.wgsl" "form.wgsl" "picture.wgsl" "levels.wgsl"
    "multiple_scattering.wgsl" "shadow_cache.wgsl" "bounced_light.wgsl" "exact.wgsl" "trace.wgsl" "baseline.wgsl"
];
/// The program that shows or returns the mean.
pub const RESOLVE: &[Part] = parts!["settings.wgsl" "picture.wgsl" "resolve.wgsl"];
/// The program that estimates the error.
pub const ERROR: &[Part] = parts!["settings.wgsl" "picture.wgsl" "error.wgsl"];

/// The program that makes learned shadows known.
pub const FINALISE: &[Part] = parts!["settings.wgsl" "counters.wgsl" "finalise.wgsl"];

/// Several files as one WGSL module.
#[derive(Debug, Clone)]
pub struct Composed {
    /// The module's text.
    pub text: String,
    /// Name and first line (from 0) of each part.
    starts: Vec<(&'static str, usize)>,
}

impl Composed {
    /// Puts the shared constants and `parts` one behind the other.
    pub fn new(parts: &[Part]) -> Self {
        let mut text = prelude();
        let mut starts = vec![("generated constants", 0)];
        let mut line = text.lines().count();
        for &(name, part) in parts {
            starts.push((name, line));
            line += part.lines().count();
            text.push_str(part);
            if !part.ends_with('\n') && !part.is_empty() {
                text.push('\n');
            }
        }
        Self { text, starts }
    }

    /// The program without what these values of its `override` constants rule out, at the same lines.
    #[must_use]
    pub fn specialised(&self, overrides: &[(&str, f64)]) -> Self {
        Self {
            text: without_dead_branches(&self.text, overrides),
            starts: self.starts.clone(),
        }
    }

    /// File and line (from 1) of a line (from 1) of the module.
    pub fn place(&self, line: u32) -> (&'static str, u32) {
        let line = (line as usize).saturating_sub(1);
        let part = self
            .starts
            .iter()
            .rev()
            .find(|&&(_, start)| start <= line)
            .copied()
            .unwrap_or(("", 0));
        (part.0, (line - part.1.min(line)) as u32 + 1)
    }

    /// Compiles the module, or says in which file and line it is wrong.
    pub(super) fn compile(&self, device: &wgpu::Device) -> Result<wgpu::ShaderModule, RenderError> {
        let scope = device.push_error_scope(wgpu::ErrorFilter::Validation);
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: self.starts.last().map(|(name, _)| *name),
            source: wgpu::ShaderSource::Wgsl(self.text.as_str().into()),
        });
        let Some(error) = pollster::block_on(scope.pop()) else {
            return Ok(module);
        };
        let info = pollster::block_on(module.get_compilation_info());
        let messages: Vec<String> = info
            .messages
            .iter()
            .filter_map(|message| {
                let (file, line) = self.place(message.location?.line_number);
                Some(format!("shaders/{file}:{line}: {}", message.message))
            })
            .collect();
        Err(RenderError::Device(if messages.is_empty() {
            error.to_string()
        } else {
            messages.join("\n")
        }))
    }
}
