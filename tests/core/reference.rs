//! The reference renderer against brute force, quadrature and closed forms; its backends.

mod areas;
mod backends;
mod cloth;
mod compositing;
mod energy;
mod light;
mod marching;
mod phases;
mod sampled_environment;
mod sky;
mod surfaces;
mod tracking;
mod walk;
mod yarns;
