//! The fast renderer of the processor, held to the reference as the GPU is: the same samples for `single` and
//! `layered`, the same distribution for `tracked`. That slices, threads and crops change nothing is tested in
//! `reference::backends` and `stability::order`, extreme designs and cameras in `stability`.

mod cloths;
mod expectation;
mod far;
mod instructions;
mod optimisations;
mod presets;
mod scenes;
