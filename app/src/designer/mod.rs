//! The designer.
