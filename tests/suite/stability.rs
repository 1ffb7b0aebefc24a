//! Extreme numbers: patches, fields of designs, cameras; and that the order of work changes nothing.

mod families;
mod patches;
