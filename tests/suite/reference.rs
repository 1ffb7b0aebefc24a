//! The reference renderer against brute force, quadrature and closed forms; its backends.

mod backends;
mod cloth;
mod compositing;
mod light;
mod marching;
mod phases;
mod sky;
mod tracking;
mod walk;
mod yarns;
