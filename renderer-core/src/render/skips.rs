//! Work that renderers leave out because it cannot be seen. Every skip has a name, a counter in [`super::Counters`], and a
//! switch, so that its gain can be measured and its picture compared.

use std::fmt;
use std::str::FromStr;

/// One kind of work that is left out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum Skip {
    /// Cells whose loops are all above or below the ray, and loops in them that are. Exact.
    EmptyCells,
    /// Loops that a ray has met in an earlier cell are not tested again. Exact.
    RepeatedTests,
    /// Tiles of the picture that hold nothing but background. Exact.
    BackgroundTiles,
    /// Tiles whose error is below the target while others' is not. Biased a little, since who is lucky early stops early.
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
    /// Frames of loops that pattern, chart or length leave out. Exact.
    UnplantedLoops,
    /// Everything, once the picture is done.
    Idle,
}

impl Skip {
    /// All of them.
    pub const ALL: [Self; 10] = [
        Self::EmptyCells,
        Self::RepeatedTests,
        Self::BackgroundTiles,
        Self::ConvergedTiles,
        Self::OpaqueRays,
        Self::HiddenGround,
        Self::UnusedShading,
        Self::UnchangedSections,
        Self::UnplantedLoops,
        Self::Idle,
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
            Self::UnplantedLoops => "unplanted-loops",
            Self::Idle => "idle",
        }
    }

    fn bit(self) -> u16 {
        1 << self as u8
    }
}

impl fmt::Display for Skip {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Skip {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        Self::ALL
            .into_iter()
            .find(|skip| skip.name() == name)
            .ok_or_else(|| {
                let names = Self::ALL.map(Self::name).join(", ");
                format!("no skip is called \"{name}\"; there are {names}")
            })
    }
}

/// Which work is left out; all of it unless told otherwise.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Skips(u16);

impl Default for Skips {
    fn default() -> Self {
        Self::ALL
    }
}

impl Skips {
    /// All.
    pub const ALL: Self = Self(u16::MAX);

    /// Whether this work is left out.
    pub fn has(self, skip: Skip) -> bool {
        self.0 & skip.bit() != 0
    }

    /// All of these but `skip`.
    #[must_use]
    pub fn without(self, skip: Skip) -> Self {
        Self(self.0 & !skip.bit())
    }
}
