//! What a form may be, beyond the ranges of its numbers, and how far bent cloth reaches.

use std::ops::RangeInclusive;

use super::fields::{Fault, Numbers};
use super::{Form, FormKind, Sheet};

impl Form {
    /// Least and most rows of a net, and points of a row.
    pub const NET_SIZES: RangeInclusive<usize> = 4..=12;
    /// Farthest that a point of a net may be from the middle along each axis, mm.
    pub const FARTHEST_MM: f64 = 1e5;

    /// Farthest that the ground weave of bent cloth can be from the origin, mm; `None` for level cloth.
    pub fn radius_mm(&self, sheet: &Sheet) -> Option<f64> {
        let width = f64::from(sheet.warps) * sheet.pitch_x();
        let length = f64::from(sheet.wefts) * sheet.pitch_y();
        // A curve that reaches from side to side of a box is no shorter than the box's diagonal.
        let bent = 0.5 * width.hypot(length);
        match self.kind {
            FormKind::Flat => None,
            FormKind::Wave | FormKind::Roll | FormKind::Stack => Some(bent),
            // Folds come out of the plane by less than a fifth of their length.
            FormKind::Hanging => Some(bent + 0.2 * self.wavelength),
            // The surface stays between the points that pull it.
            FormKind::Net => {
                let points = self.net.iter().flatten();
                let farthest = points.map(|[x, y, z]| x.hypot(*y).hypot(*z));
                Some(farthest.fold(0.0, f64::max))
            }
            FormKind::Height => Some(bent.hypot(self.height)),
        }
    }

    pub(super) fn push_faults(&self, faults: &mut Vec<Fault>) {
        self.push_range_faults("form", faults);
        let mut fault = |path: String, value: String, allowed: String| {
            faults.push(Fault {
                path,
                value,
                allowed,
            });
        };
        if self.kind == FormKind::Height && self.image.is_none() && self.pixels.is_none() {
            fault(
                "form.image".into(),
                "left out".into(),
                "the path of a picture when form.kind is \"height\"".into(),
            );
        }
        let (least, most) = (Self::NET_SIZES.start(), Self::NET_SIZES.end());
        let Some(first) = self.net.first() else {
            if self.kind == FormKind::Net {
                fault(
                    "form.net".into(),
                    "empty".into(),
                    format!("{least} to {most} rows of points when form.kind is \"net\""),
                );
            }
            return;
        };
        if !Self::NET_SIZES.contains(&self.net.len()) {
            fault(
                "form.net".into(),
                format!("{} rows", self.net.len()),
                format!("{least} to {most} rows"),
            );
        }
        for (index, row) in self.net.iter().enumerate() {
            let path = format!("form.net[{index}]");
            if !Self::NET_SIZES.contains(&row.len()) || row.len() != first.len() {
                fault(
                    path.clone(),
                    format!("{} points", row.len()),
                    format!("{least} to {most} points, in all rows as many"),
                );
            }
            let values = row.iter().enumerate().flat_map(|(point, at)| {
                at.iter()
                    .enumerate()
                    .map(move |(axis, value)| (point, axis, value))
            });
            for (point, axis, value) in values {
                // NaN is in no range.
                if !(-Self::FARTHEST_MM..=Self::FARTHEST_MM).contains(value) {
                    fault(
                        format!("{path}[{point}][{axis}]"),
                        value.to_string(),
                        format!("{} to {} mm", -Self::FARTHEST_MM, Self::FARTHEST_MM),
                    );
                }
            }
        }
    }
}
