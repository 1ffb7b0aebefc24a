//! How points scatter and what light comes from where (MODEL.md §7 and §8), in f64: phase functions of the pile, surfaces of
//! ground yarns, lamps, the environment, and the estimate of bounced light. Without knowledge of rays through cloth, and so
//! shared by all renderers on the host; tests hold it to closed forms and quadrature.

mod bounced;
mod lamps;
mod scatter;
mod sky;
mod surface;

pub use bounced::{Seen, bounced};
pub use lamps::Lamp;
pub use scatter::{FromSky, Lobe, Optics, Vertex};
pub use sky::environment_radiance;
pub use surface::SurfaceOptics;
