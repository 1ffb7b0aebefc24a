//! The tests of the program: a module a concern.

#![allow(
    clippy::unwrap_used,
    clippy::disallowed_methods,
    reason = "a test that cannot go on fails, and says where; directions of tests are not 0, and NaN fails them"
)]

mod advice;
mod bundles;
mod chart_files;
mod cli;
mod damaged_designs;
mod denoising;
mod designer;
mod environment;
mod gpu;
mod height;
mod inputs;
#[cfg(target_os = "linux")]
mod killed;
mod nap;
mod outside;
mod picture_file;
mod pictures;
mod presets;
mod recovery;
mod repacked;
mod window;
#[cfg(target_os = "linux")]
mod writing;

/// What the tests share: a display that nobody sees, small scenes, rendering to the end.
#[path = "../support"]
mod support {
    pub mod display;
    pub mod drawing;
    #[cfg(target_os = "linux")]
    pub mod faults;
    pub mod file_drop;
    pub mod folders;
    pub mod mutate;
    pub mod picture_files;
    pub mod png;
    pub mod scenes;
}
