//! A backend and the way its pictures reach the window: as pixels, or, where the backend draws on the window's own GPU
//! device, as a texture that never leaves it.

use std::sync::Arc;

use egui::{Color32, ColorImage};
use renderer_core::gpu::{DeviceWatch, GpuBackend, GpuContext};
use renderer_core::image::{Display, Picture};
use renderer_core::render::{Backend, RenderError};

use super::display_table::DisplayTable;
use crate::backend::BackendChoice;

/// Makes a backend of its own.
pub type MakeBackend =
    Arc<dyn Fn(BackendChoice) -> Result<Box<dyn Backend>, RenderError> + Send + Sync>;

/// Makes a renderer for the viewport, on the render thread.
pub type MakeRenderer = Arc<dyn Fn(BackendChoice) -> Result<Renderer, RenderError> + Send + Sync>;

/// A backend that renders for the viewport.
pub enum Renderer {
    /// Somewhere: pictures are read back, and sent to the window's device.
    Apart(Box<dyn Backend>),
    /// On the window's device.
    Within(Box<GpuBackend>),
}

/// A picture as the window shows it.
#[derive(Debug, Clone)]
pub enum Shot {
    /// Pixels.
    Pixels(Arc<ColorImage>),
    /// A texture of the window's device, with sRGB values.
    Texture(wgpu::Texture),
}

/// What makes renderers for a window: the GPU on the window's own device if that can compute, others with `make`.
pub fn for_window(
    make: MakeBackend,
    window: Option<(egui_wgpu::RenderState, DeviceWatch)>,
) -> MakeRenderer {
    let context = window.and_then(|(state, watch)| {
        GpuContext::from_device(state.device, state.queue, state.adapter.get_info(), watch).ok()
    });
    Arc::new(move |choice| {
        // A lost device is lost for good; until the window has a new one, a device apart may do.
        let usable = context
            .as_ref()
            .filter(|context| context.watch.lost().is_none());
        let within = usable.filter(|context| match choice {
            BackendChoice::Auto => !context.is_software(),
            BackendChoice::Gpu => true,
            BackendChoice::Cpu | BackendChoice::Reference => false,
        });
        Ok(match within {
            Some(context) => Renderer::Within(Box::new(GpuBackend::new(context.clone())?)),
            None => Renderer::Apart(make(choice)?),
        })
    })
}

impl Renderer {
    /// The backend.
    pub fn backend(&mut self) -> &mut dyn Backend {
        match self {
            Self::Apart(backend) => &mut **backend,
            Self::Within(backend) => &mut **backend,
        }
    }
}

/// The last picture, kept so that it can be shown with another exposure.
#[derive(Default)]
pub struct Developer {
    picture: Option<Picture>,
    table: DisplayTable,
}

impl Developer {
    /// The picture so far. With `soft`, pixels that were read back are averaged two by two: less sharp, less noisy.
    pub fn shoot(
        &mut self,
        renderer: &mut Renderer,
        display: Display,
        soft: bool,
    ) -> Result<Option<Shot>, RenderError> {
        match renderer {
            Renderer::Within(backend) => Ok(backend.show(display)?.cloned().map(Shot::Texture)),
            Renderer::Apart(backend) => {
                let picture = backend.picture()?;
                self.picture = Some(if soft { averaged(&picture) } else { picture });
                self.table.set(display);
                Ok(self.developed())
            }
        }
    }

    /// The last picture again, with another display.
    pub fn again(
        &mut self,
        renderer: &mut Renderer,
        display: Display,
    ) -> Result<Option<Shot>, RenderError> {
        match renderer {
            Renderer::Within(backend) => Ok(backend.show(display)?.cloned().map(Shot::Texture)),
            Renderer::Apart(_) => {
                self.table.set(display);
                Ok(self.developed())
            }
        }
    }

    fn developed(&self) -> Option<Shot> {
        let picture = self.picture.as_ref()?;
        let colour = |&[r, g, b, _]: &[f32; 4]| {
            let [r, g, b] = self.table.encode([r, g, b]);
            Color32::from_rgb(r, g, b)
        };
        let pixels = picture.pixels.iter().map(colour).collect();
        let size = picture.size.map(|side| side as usize);
        Some(Shot::Pixels(Arc::new(ColorImage::new(size, pixels))))
    }
}

/// A picture of half the size: the mean of every 2 × 2 pixels, in linear light. Odd edges repeat their last pixels.
fn averaged(picture: &Picture) -> Picture {
    let size = picture.size.map(|side| side.div_ceil(2));
    let [width, height] = picture.size.map(|side| side as usize);
    let corners =
        (0..size[1] as usize).flat_map(|y| (0..size[0] as usize).map(move |x| (2 * x, 2 * y)));
    let pixels = corners
        .map(|(x, y)| {
            let (x1, y1) = ((x + 1).min(width - 1), (y + 1).min(height - 1));
            let four =
                [(x, y), (x1, y), (x, y1), (x1, y1)].map(|(x, y)| picture.pixels[y * width + x]);
            std::array::from_fn(|c| four.iter().map(|pixel| pixel[c]).sum::<f32>() / 4.0)
        })
        .collect();
    Picture {
        size,
        pixels,
        aov: None,
    }
}
