//! The picture as egui draws it: pixels of egui's own textures, or a texture of the window's device that the renderer
//! draws into.

use std::sync::Arc;

use egui::{TextureHandle, TextureId, TextureOptions};

use crate::designer::render_thread::renderer::DisplayFrame;

/// How a picture is enlarged.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Enlarging {
    /// Smoothly.
    Smooth,
    /// Every pixel a square.
    Pixels,
}

/// A texture that shows a [`DisplayFrame`].
pub enum Texture {
    /// egui's own.
    Owned(TextureHandle),
    /// One of the window's device, and egui's name for it.
    Shared(wgpu::Texture, TextureId),
}

impl Texture {
    /// A texture that shows `frame`: the old one if that can be made to.
    pub fn of(
        frame: &DisplayFrame,
        old: Option<Self>,
        ctx: &egui::Context,
        window: Option<&egui_wgpu::RenderState>,
        enlarging: Enlarging,
    ) -> Option<Self> {
        let (options, filter) = match enlarging {
            Enlarging::Smooth => (TextureOptions::LINEAR, wgpu::FilterMode::Linear),
            Enlarging::Pixels => (TextureOptions::NEAREST, wgpu::FilterMode::Nearest),
        };
        match (frame, old) {
            (DisplayFrame::Pixels(image), Some(Self::Owned(mut texture))) => {
                texture.set(Arc::clone(image), options);
                Some(Self::Owned(texture))
            }
            (DisplayFrame::Pixels(image), old) => {
                Self::drop_shared(old, window);
                let texture = ctx.load_texture("picture", Arc::clone(image), options);
                Some(Self::Owned(texture))
            }
            (DisplayFrame::Texture(texture), Some(Self::Shared(shown, id)))
                if *texture == shown =>
            {
                Some(Self::Shared(shown, id))
            }
            (DisplayFrame::Texture(texture), old) => {
                Self::drop_shared(old, window);
                let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
                let window = window?;
                let mut renderer = window.renderer.write();
                let id = renderer.register_native_texture(&window.device, &view, filter);
                Some(Self::Shared(texture.clone(), id))
            }
        }
    }

    /// Frees a texture that egui does not free by itself.
    pub fn drop_shared(old: Option<Self>, window: Option<&egui_wgpu::RenderState>) {
        if let (Some(Self::Shared(_, id)), Some(window)) = (old, window) {
            window.renderer.write().free_texture(&id);
        }
    }

    /// egui's name for it.
    pub fn id(&self) -> TextureId {
        match self {
            Self::Owned(texture) => texture.id(),
            Self::Shared(_, id) => *id,
        }
    }
}

/// A copy of a picture that stays as it is when the renderer goes on.
pub fn kept(frame: &DisplayFrame, window: Option<&egui_wgpu::RenderState>) -> Option<DisplayFrame> {
    match frame {
        DisplayFrame::Pixels(image) => Some(DisplayFrame::Pixels(Arc::clone(image))),
        DisplayFrame::Texture(texture) => {
            let window = window?;
            let copy = window.device.create_texture(&wgpu::TextureDescriptor {
                label: Some("snapshot"),
                size: texture.size(),
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format: texture.format(),
                usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
                view_formats: &[],
            });
            let mut encoder = window
                .device
                .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            encoder.copy_texture_to_texture(
                texture.as_image_copy(),
                copy.as_image_copy(),
                texture.size(),
            );
            window.queue.submit([encoder.finish()]);
            Some(DisplayFrame::Texture(copy))
        }
    }
}
