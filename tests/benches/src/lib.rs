//! What Towel Designer costs, measured: presets on the bench, edits, and the pace of the window.
//!
//! ```text
//! bench    tables, plots and a summary of what presets cost
//! edits    from an edit to the picture of it
//! quiet    from an edit until its picture is quiet, with denoising and without
//! pace     how smoothly the window goes while it renders
//! ```
//!
//! These are programs of developers. They use the designer's library; nothing of the designer uses them.

pub mod backends;
pub mod bench;
pub mod coarse_preview;
pub mod command;
pub mod conditions;
pub mod costs;
pub mod csv;
pub mod distances;
pub mod drawing;
pub mod edits;
pub mod error_table;
pub mod first_picture;
pub mod flip;
pub mod growth;
pub mod measure;
pub mod measured;
pub mod optimisations;
pub mod pace;
pub mod pareto;
pub mod parts;
pub mod plan;
pub mod plot;
pub mod quiet;
pub mod summary;
pub mod truth;
pub mod units;
pub mod variants;
pub mod window_pace;
pub mod written;
