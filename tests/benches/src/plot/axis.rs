//! Logarithmic axes and their ticks.

/// A logarithmic axis.
#[derive(Debug, Clone, Copy)]
pub struct Axis {
    /// Logarithms of the values at both ends.
    range: [f64; 2],
    /// Places of both ends, units.
    places: [f64; 2],
}

impl Axis {
    /// Holds all values with a margin.
    pub fn new(values: impl Iterator<Item = f64>, places: [f64; 2]) -> Self {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for value in values.filter(|value| *value > 0.0 && value.is_finite()) {
            low = low.min(value.log10());
            high = high.max(value.log10());
        }
        if low > high {
            (low, high) = (-1.0, 0.0);
        }
        // At least from 1 to 3, so that there are ticks to read.
        let margin = f64::max(0.05 * (high - low) + 0.04, 0.25 - 0.5 * (high - low));
        Self {
            range: [low - margin, high + margin],
            places,
        }
    }

    /// Where a value is, units.
    pub fn place(&self, value: f64) -> f64 {
        let [low, high] = self.range;
        let share = (value.max(1e-12).log10() - low) / (high - low);
        self.places[0] + share * (self.places[1] - self.places[0])
    }

    /// Values 1 to 9 times the powers of ten in the range; whether each has a label.
    pub fn ticks(&self) -> Vec<(f64, bool)> {
        let [low, high] = self.range;
        let labelled: &[i32] = match high - low {
            span if span < 0.8 => &[1, 2, 3, 4, 5, 7],
            span if span < 2.2 => &[1, 2, 5],
            span if span < 3.2 => &[1, 3],
            _ => &[1],
        };
        let decades = low.floor() as i32..=high.ceil() as i32;
        let all = decades.flat_map(|decade| {
            (1..10).map(move |digit| {
                // Divided where possible: 5/10 has fewer stray digits than 5 · 0.1.
                let power = 10_f64.powi(decade.abs());
                let digit_value = f64::from(digit);
                let value = if decade < 0 {
                    digit_value / power
                } else {
                    digit_value * power
                };
                (value, digit)
            })
        });
        all.filter(|(value, _)| (low..=high).contains(&value.log10()))
            .map(|(value, digit)| (value, labelled.contains(&digit)))
            .collect()
    }
}

/// A tick's number: short for large and small ones.
pub fn label(value: f64) -> String {
    if value == 0.0 || (1e-3..1e5).contains(&value) {
        value.to_string()
    } else {
        format!("{value:e}")
    }
}
