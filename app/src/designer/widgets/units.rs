//! The units that lengths are shown in: metric, or inches where a user prefers them. What a design holds stays metric.

use egui::{Context, Id};
use serde::{Deserialize, Serialize};

/// Which units fields and rulers show.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum UnitSystem {
    /// Millimetres, centimetres, and yarns a centimetre.
    #[default]
    Metric,
    /// Inches, and yarns an inch.
    Inch,
}

/// Millimetres of an inch.
const INCH: f64 = 25.4;

impl UnitSystem {
    fn id() -> Id {
        Id::unique("units that lengths are shown in")
    }

    /// Has the widgets of a window show these units.
    pub fn apply(self, ctx: &Context) {
        ctx.data_mut(|data| data.insert_temp(Self::id(), self));
    }

    /// Those that the widgets of a window show.
    pub fn of(ctx: &Context) -> Self {
        ctx.data(|data| data.get_temp(Self::id()))
            .unwrap_or_default()
    }

    /// What a number in `unit` is shown in, and how many of `unit` one of that is.
    pub fn shown(self, unit: &str) -> (&str, f64) {
        match (self, unit) {
            (Self::Inch, "mm") => ("in", INCH),
            (Self::Inch, "cm") => ("in", INCH / 10.0),
            (Self::Inch, "/cm") => ("/in", 10.0 / INCH),
            (Self::Inch, "turns/cm") => ("turns/in", 10.0 / INCH),
            _ => (unit, 1.0),
        }
    }

    /// The unit of rulers, and its millimetres.
    pub fn of_rulers(self) -> (&'static str, f64) {
        match self {
            Self::Metric => ("cm", 10.0),
            Self::Inch => ("in", INCH),
        }
    }
}

/// What a number in `unit` is called where it is shown.
pub fn shown_unit<'u>(ctx: &Context, unit: &'u str) -> &'u str {
    UnitSystem::of(ctx).shown(unit).0
}
