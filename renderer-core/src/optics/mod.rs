//! How points scatter and what light comes from where (MODEL.md §7 and §8), in f64: phase functions of the pile, surfaces of
//! ground yarns, light, the environment, and the estimate of bounced light. Without knowledge of rays through cloth, and so
//! shared by all renderers on the host; tests hold it to closed forms and quadrature.

mod bounced;
mod light;
mod scatter;
mod sky;
mod surface;

pub use bounced::{Seen, bounced};
pub use light::Light;
pub use scatter::{FromSky, Lobe, Optics, Vertex};
pub use sky::environment_radiance;
pub use surface::SurfaceOptics;
