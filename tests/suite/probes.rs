//! Parts of the shaders on their own: WGSL appended to the tracing program runs them on chosen inputs.
