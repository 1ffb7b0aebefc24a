//! How points scatter and what light comes from where (MODEL.md §7 and §8), in f64: phase functions of the pile,
//! surfaces of ground yarns, suns and area lights, the environment, and the approximation of multiple scattering.
//! Without knowledge of rays through cloth, and so shared by all renderers on the host; tests hold it to closed forms
//! and quadrature.

mod light;
pub mod limits;
pub(crate) mod multiple_scattering;
mod scatter;
mod sky;
pub(crate) mod surface;

pub use light::Light;
pub use multiple_scattering::{Visibility, multiple_scattering};
pub use scatter::{EnvironmentSample, Exposure, Lobe, Optics, Vertex};
pub use sky::environment_radiance;
pub use surface::SurfaceOptics;
