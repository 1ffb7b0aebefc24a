//! gpu

mod adapters;

pub use adapters::{AdapterSummary, adapters};
