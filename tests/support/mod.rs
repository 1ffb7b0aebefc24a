//! What tests of pictures share: a device without a window, small scenes, rendering to the end, comparators.

pub mod agreement;
pub mod compare;
pub mod device;
pub mod display;
pub mod file_drop;
pub mod patches;
pub mod png;
pub mod probe;
pub mod same_sample;
pub mod scenes;
