//! Designs whose paths are closed by an estimate, as in the view's draft light.

use renderer_core::design::Design;

use super::scenes::Case;

/// A design whose light is estimated after so many scatterings.
pub fn closed(design: &Design, traced_bounces: u32) -> Case<'_> {
    Case {
        design,
        traced_bounces,
    }
}
