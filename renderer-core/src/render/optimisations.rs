//! Work that renderers leave out because it cannot be seen, and noise that they take away. Every optimisation has a name
//! and a switch, so that its gain can be measured and its picture compared; what leaves out work that can be counted has
//! a counter in [`super::Counters`].

use std::fmt;
use std::str::FromStr;

use crate::scene::CompilerOptions;

/// One kind of work that is left out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum Optimisation {
    /// Cells whose loops are all above or below the ray, and loops in them that are. Exact.
    EmptyCells,
    /// Loops that a ray has met in an earlier cell are not tested again. Exact.
    RepeatedTests,
    /// Tiles of the picture that hold nothing but background. Exact.
    BackgroundTiles,
    /// Tiles whose error is below the target while others' is not. Biased a little, since who is lucky early stops
    /// early.
    ConvergedTiles,
    /// The rest of a shadow ray that hardly any light comes through. Unbiased, or below 10⁻⁴ of the light.
    OpaqueRays,
    /// What lies behind a ground weave without gaps, and ground yarns that pile hides or the ray passes above or below.
    /// Exact.
    HiddenGround,
    /// What this scene's shading does not use: code is specialised for what is used. Exact.
    UnusedShading,
    /// Parts of a scene whose inputs did not change. Exact.
    UnchangedSections,
    /// Points of pile that send hardly any light to the eye: where `tracked` follows paths to their first scattering
    /// only, each light takes of several points along a camera ray the one that an estimate of its light chooses.
    /// Unbiased.
    WeighedEvents,
    /// The end of a path of `tracked` whose last ray only looks for the environment: how much of that arrives is tracked
    /// as along a shadow ray. Unbiased.
    LastLooks,
    /// Some of the lights at later scatterings than a path's first: those that are looked for count for the others, too.
    /// Unbiased.
    LaterLights,
}

impl Optimisation {
    /// All of them.
    pub const ALL: [Self; 11] = [
        Self::EmptyCells,
        Self::RepeatedTests,
        Self::BackgroundTiles,
        Self::ConvergedTiles,
        Self::OpaqueRays,
        Self::HiddenGround,
        Self::UnusedShading,
        Self::UnchangedSections,
        Self::WeighedEvents,
        Self::LastLooks,
        Self::LaterLights,
    ];

    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::EmptyCells => "empty-cells",
            Self::RepeatedTests => "repeated-tests",
            Self::BackgroundTiles => "background-tiles",
            Self::ConvergedTiles => "converged-tiles",
            Self::OpaqueRays => "opaque-rays",
            Self::HiddenGround => "hidden-ground",
            Self::UnusedShading => "unused-shading",
            Self::UnchangedSections => "unchanged-sections",
            Self::WeighedEvents => "weighed-events",
            Self::LastLooks => "last-looks",
            Self::LaterLights => "later-lights",
        }
    }

    fn bit(self) -> u16 {
        1 << self as u8
    }
}

impl fmt::Display for Optimisation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Optimisation {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        Self::ALL
            .into_iter()
            .find(|one| one.name() == name)
            .ok_or_else(|| {
                let names = Self::ALL.map(Self::name).join(", ");
                format!("no optimisation is called \"{name}\"; there are {names}")
            })
    }
}

/// Which work is left out; all of it by default.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Optimisations(u16);

impl From<Optimisations> for CompilerOptions {
    fn from(optimisations: Optimisations) -> Self {
        Self {
            keeps_unchanged: optimisations.has(Optimisation::UnchangedSections),
        }
    }
}

impl Default for Optimisations {
    fn default() -> Self {
        Self::ALL
    }
}

impl Optimisations {
    /// All.
    pub const ALL: Self = Self(u16::MAX);

    /// Whether this work is left out.
    pub fn has(self, one: Optimisation) -> bool {
        self.0 & one.bit() != 0
    }

    /// All of these but `one`.
    #[must_use]
    pub fn without(self, one: Optimisation) -> Self {
        Self(self.0 & !one.bit())
    }
}
