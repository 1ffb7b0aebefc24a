//! All that was found of a preset.

use crate::measure::Findings;
use crate::{backends, costs, distances, first_picture, growth, optimisations, variants};

/// A preset's results, of the parts that were asked for.
#[derive(Debug, Clone, Default)]
pub struct Measured {
    /// The preset's name.
    pub name: String,
    /// For each target.
    pub findings: Vec<Findings>,
    /// For each optimisation.
    pub optimisations: Vec<optimisations::OptimisationRow>,
    /// For each backend.
    pub backends: Vec<backends::BackendRow>,
    /// With loops and pixels.
    pub growth: Option<growth::Growth>,
    /// For each kind of edit.
    pub first_pictures: Option<first_picture::FirstPictures>,
    /// For each kind of light.
    pub lights: Vec<variants::VariantRow>,
    /// For each kind of pile and each finish.
    pub piles: Vec<variants::VariantRow>,
    /// For each form.
    pub forms: Vec<variants::VariantRow>,
    /// For each distance.
    pub distances: Vec<distances::DistanceRow>,
    /// For each stage.
    pub costs: Vec<costs::Cost>,
}
