//! Extreme numbers: patches, fields of designs, cameras; and that the order of work changes nothing.

mod cameras;
mod families;
mod fields;
mod order;
mod patches;
