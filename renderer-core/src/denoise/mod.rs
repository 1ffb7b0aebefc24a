//! Denoising of finished means by Open Image Denoise 2.x, which is found at run time and never needed.
//!
//! A denoised picture is biased: the filter guesses what lies under the noise, and with ever more samples it comes to
//! what it makes of a picture without noise, not to that picture. So it is mixed with the plain one, by weights that
//! are measured (`mix`), and the more samples there are the more of it is plain.
//!
//! The filter sees colours alone. First-hit albedo and normal are as noisy as the colours themselves, and even their
//! converged means gain less than the mixing does and the samples would that they cost (tests/benches/README.md).
//!
//! | module | what is in it |
//! | --- | --- |
//! | `library` | the C interface, behind safe types |
//! | `search` | where the library is looked for |
//! | `mix` | how much of a picture is denoised, and how far it may still be from the truth |

mod library;
mod mix;
mod search;

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use library::{CPU_DEVICE, DEFAULT_DEVICE, Device, Filter};

pub use library::Library;
pub use mix::{Mix, Step};
pub use search::{FILE_NAMES, Places, Searched, find};

use crate::image::Picture;

/// Why a picture cannot be denoised.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum DenoiseError {
    /// The library is nowhere that it is looked for.
    #[error("Open Image Denoise was not found")]
    NotFound,
    /// The environment says that there is to be none.
    #[error("{} is empty, so Open Image Denoise is not used", Places::LIBRARY)]
    SwitchedOff,
    /// The file is no library that this system can load.
    #[error("{path} cannot be loaded: {reason}", path = .path.display())]
    Load {
        /// The file.
        path: PathBuf,
        /// What the system says.
        reason: String,
    },
    /// The file is a library of something else, or of a version before 2.
    #[error("{path} is not Open Image Denoise 2: it lacks {symbol}", path = .path.display())]
    Symbol {
        /// The file.
        path: PathBuf,
        /// The first function that it lacks.
        symbol: &'static str,
    },
    /// The library is of a version whose interface is not known.
    #[error("{path} is Open Image Denoise {version}, but only versions 2 can be used", path = .path.display())]
    Version {
        /// The file.
        path: PathBuf,
        /// Its version.
        version: String,
    },
    /// The library says what went wrong.
    #[error("Open Image Denoise: {0}")]
    Failed(String),
    /// It was stopped.
    #[error("denoising was cancelled")]
    Cancelled,
}

/// How much work is spent on a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum DenoiseQuality {
    /// About half of the time of the others: for the window.
    Fast,
    /// The most: for final pictures.
    #[default]
    High,
}

impl DenoiseQuality {
    /// The library's `OIDN_QUALITY_FAST` and `OIDN_QUALITY_HIGH`.
    fn number(self) -> i32 {
        match self {
            Self::Fast => 4,
            Self::High => 6,
        }
    }
}

/// Something that takes noise out of pictures.
pub trait Denoise: Send {
    /// What it is and computes on, as in `Open Image Denoise 2.5.1 on CPU`.
    fn name(&self) -> String;

    /// The picture with less noise in its colours, of the same size; coverage stays as it is, and so does the
    /// background where no cloth is near. There are no extra channels.
    ///
    /// Colours times `scale` are what a picture of usual brightness has, with white at 1.
    ///
    /// # Errors
    /// When it fails; [`DenoiseError::Cancelled`] soon after `cancel` has become true.
    fn denoise(
        &mut self,
        picture: &Picture,
        quality: DenoiseQuality,
        scale: f32,
        cancel: &AtomicBool,
    ) -> Result<Picture, DenoiseError>;
}

/// Open Image Denoise on a device of its own.
pub struct Denoiser {
    version: String,
    device: Arc<Device>,
    device_name: String,
    /// The filter of the last size and quality.
    filter: Option<(DenoiseQuality, Filter)>,
}

impl Denoiser {
    /// Makes a device ready: a GPU where the library has one, else the processor.
    ///
    /// # Errors
    /// When the library is of another version, or no device works.
    pub fn new(library: &Arc<Library>) -> Result<Self, DenoiseError> {
        let device = match Device::new(library, DEFAULT_DEVICE) {
            Err(DenoiseError::Failed(error)) => {
                tracing::warn!("Open Image Denoise: {error}; denoising on the processor");
                Device::new(library, CPU_DEVICE)?
            }
            made => made?,
        };
        let interface = match device.kind() {
            CPU_DEVICE => "CPU",
            2 => "SYCL",
            3 => "CUDA",
            4 => "HIP",
            5 => "Metal",
            _ => "a device",
        };
        let device_name = match device.hardware() {
            Some(name) if !name.is_empty() => format!("{interface}: {name}"),
            _ => interface.to_owned(),
        };
        Ok(Self {
            version: device.version(),
            device: Arc::new(device),
            device_name,
            filter: None,
        })
    }

    /// The library's version, as in `2.5.1`.
    pub fn version(&self) -> &str {
        &self.version
    }

    /// Interface and name of what it computes on, as in `CUDA: NVIDIA H200`.
    pub fn device(&self) -> &str {
        &self.device_name
    }
}

impl Denoise for Denoiser {
    fn name(&self) -> String {
        format!(
            "Open Image Denoise {} on {}",
            self.version, self.device_name
        )
    }

    fn denoise(
        &mut self,
        picture: &Picture,
        quality: DenoiseQuality,
        scale: f32,
        cancel: &AtomicBool,
    ) -> Result<Picture, DenoiseError> {
        let kept = self.filter.take();
        let mut filter = match kept {
            Some((of, filter)) if of == quality && filter.size() == picture.size => filter,
            other => {
                // Both at once may be more than the device's memory holds.
                drop(other);
                Filter::new(&self.device, picture.size, quality.number())?
            }
        };
        let mut colours: Vec<[f32; 3]> = picture
            .pixels
            .iter()
            .map(|&[r, g, b, _]| [r, g, b])
            .collect();
        let done = filter.run(&mut colours, scale, cancel);
        self.filter = Some((quality, filter));
        done?;
        Ok(with_colours(picture, &colours))
    }
}

/// A picture with other colours, but for its background.
fn with_colours(picture: &Picture, colours: &[[f32; 3]]) -> Picture {
    let [width, height] = picture.size.map(|side| side as usize);
    let is_bare = |x: usize, y: usize| {
        let rows = y.saturating_sub(1)..(y + 2).min(height);
        let columns = x.saturating_sub(1)..(x + 2).min(width);
        rows.flat_map(|y| columns.clone().map(move |x| y * width + x))
            .all(|index| picture.pixels[index][3] == 0.0)
    };
    let pixel = |index: usize| {
        let before = picture.pixels[index];
        if before[3] == 0.0 && is_bare(index % width, index / width) {
            return before;
        }
        let [r, g, b] = colours[index];
        [r, g, b, before[3]]
    };
    Picture {
        size: picture.size,
        pixels: (0..picture.pixels.len()).map(pixel).collect(),
        aov: None,
    }
}
