//! A backend and the way its pictures reach the window: as pixels, or, where the backend draws on the window's own GPU
//! device, as a texture that never leaves it.

use std::sync::{Arc, Mutex, PoisonError};

use egui::{Color32, ColorImage};
use rayon::prelude::*;
use renderer_core::gpu::{DeviceWatch, GpuBackend, GpuContext};
use renderer_core::image::{Display, Picture};
use renderer_core::render::{Backend, RenderError};

use super::display_table::DisplayTable;
use crate::backend::{BackendChoice, with_kept_pipelines};

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

/// A picture as the window shows it (`egui::Frame` is something else).
#[derive(Debug, Clone)]
pub enum DisplayFrame {
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
        let info = state.adapter.get_info();
        let context = GpuContext::from_device(state.device, state.queue, info, watch).ok()?;
        Some(with_kept_pipelines(context))
    });
    // Draws nothing itself: what it has compiled is there at once for those that do, however often one switches.
    let first: Mutex<Option<GpuBackend>> = Mutex::default();
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
            Some(context) => {
                let mut first = first.lock().unwrap_or_else(PoisonError::into_inner);
                let first = match &mut *first {
                    Some(first) => first,
                    none => none.insert(GpuBackend::new(context.clone())?),
                };
                Renderer::Within(Box::new(first.beside()))
            }
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

    /// Whether its pictures are mixed with their neighbouring pixels where that is asked for.
    pub fn softens(&self) -> bool {
        matches!(self, Self::Apart(_))
    }
}

/// From the linear light of a picture to what the window shows. Keeps the last picture, so that it can be shown with
/// another exposure.
#[derive(Default)]
pub struct DisplayTransform {
    picture: Option<Arc<Picture>>,
    table: DisplayTable,
}

impl DisplayTransform {
    /// The picture that was shown last, unless that is a texture.
    pub fn picture(&self) -> Option<&Arc<Picture>> {
        self.picture.as_ref()
    }

    /// The picture so far. Where `softness` is above 0, pixels that were read back are mixed with their neighbours:
    /// less sharp, less noisy.
    pub fn frame(
        &mut self,
        renderer: &mut Renderer,
        display: Display,
        softness: f32,
    ) -> Result<Option<DisplayFrame>, RenderError> {
        match renderer {
            Renderer::Within(backend) => {
                self.picture = None;
                Ok(backend.show(display)?.cloned().map(DisplayFrame::Texture))
            }
            Renderer::Apart(backend) => {
                let picture = backend.picture()?;
                let shown = match softness > 0.0 {
                    true => softened(&picture, softness),
                    false => picture,
                };
                Ok(self.frame_of(Arc::new(shown), display))
            }
        }
    }

    /// The last picture as another display shows it.
    pub fn last_frame(
        &mut self,
        renderer: &mut Renderer,
        display: Display,
    ) -> Result<Option<DisplayFrame>, RenderError> {
        match renderer {
            Renderer::Within(backend) if self.picture.is_none() => {
                Ok(backend.show(display)?.cloned().map(DisplayFrame::Texture))
            }
            Renderer::Within(_) | Renderer::Apart(_) => {
                self.table.set(display);
                Ok(self.encoded())
            }
        }
    }

    /// A picture from elsewhere, which becomes the last one.
    pub fn frame_of(&mut self, picture: Arc<Picture>, display: Display) -> Option<DisplayFrame> {
        self.picture = Some(picture);
        self.table.set(display);
        self.encoded()
    }

    fn encoded(&self) -> Option<DisplayFrame> {
        let picture = self.picture.as_ref()?;
        let colour = |&[r, g, b, _]: &[f32; 4]| {
            let [r, g, b] = self.table.encode([r, g, b]);
            Color32::from_rgb(r, g, b)
        };
        let pixels = picture.pixels.par_iter().map(colour).collect();
        let size = picture.size.map(|side| side as usize);
        Some(DisplayFrame::Pixels(Arc::new(ColorImage::new(
            size, pixels,
        ))))
    }
}

/// The variance that noise keeps in a picture mixed by so much with the means of its 3 × 3 neighbouring pixels, as a
/// share of what it was, where the noise of every pixel is its own.
pub fn noise_left(softness: f32) -> f32 {
    let each = softness / 9.0;
    (1.0 - softness + each).powi(2) + 8.0 * each.powi(2)
}

/// A picture mixed with the means of its 3 × 3 neighbouring pixels, in linear light; at softness 1 these alone. Edges
/// repeat their last pixels.
pub fn softened(picture: &Picture, softness: f32) -> Picture {
    let [width, height] = picture.size.map(|side| side as usize);
    let row = |y: usize| &picture.pixels[y * width..(y + 1) * width];
    let mut pixels = vec![[0.0; 4]; picture.pixels.len()];
    pixels
        .par_chunks_mut(width.max(1))
        .enumerate()
        .for_each(|(y, soft)| {
            let rows = [
                row(y.saturating_sub(1)),
                row(y),
                row((y + 1).min(height - 1)),
            ];
            for (x, pixel) in soft.iter_mut().enumerate() {
                let columns = [x.saturating_sub(1), x, (x + 1).min(width - 1)];
                *pixel = std::array::from_fn(|c| {
                    let across = rows.map(|row| columns.map(|x| row[x][c]).iter().sum::<f32>());
                    let mean = across.iter().sum::<f32>() / 9.0;
                    rows[1][x][c] + softness * (mean - rows[1][x][c])
                });
            }
        });
    Picture {
        size: picture.size,
        pixels,
        aov: None,
    }
}
