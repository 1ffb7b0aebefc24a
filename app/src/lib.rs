//! Towel Designer: the designer's window and the command line, over `renderer-core`.

pub mod advice;
pub mod backend;
pub mod cli;
pub mod clock;
pub mod denoiser;
pub mod designer;
pub mod files;
pub mod lettering;
pub mod picture_file;
