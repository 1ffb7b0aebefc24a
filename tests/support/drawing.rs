//! Drawing to the end.

use std::sync::atomic::AtomicBool;
use std::time::Duration;

use renderer_core::image::Picture;
use renderer_core::render::{Backend, RenderRequest};

/// Draws a request to its end.
pub fn finish(backend: &mut dyn Backend, request: &RenderRequest) -> Picture {
    finish_in_slices(backend, request, Duration::from_secs(5))
}

/// Draws a request to its end, a slice of time after the other.
pub fn finish_in_slices(
    backend: &mut dyn Backend,
    request: &RenderRequest,
    slice: Duration,
) -> Picture {
    backend.begin(request).unwrap();
    let never = AtomicBool::new(false);
    while !backend.advance(slice, &never).unwrap().done {}
    backend.picture().unwrap()
}
