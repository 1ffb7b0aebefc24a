//! How much longer it takes, reported so that the number can be believed: it counts down with the clock and gives way
//! to what is newly known only slowly.

use std::time::Duration;

/// An estimate of the time left.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct TimeLeft {
    elapsed: f64,
    left: Option<f64>,
}

/// Below this share and this time nothing is known yet.
const FIRST_SHARE: f64 = 0.002;
const FIRST_SECONDS: f64 = 1.0;
/// How fast the estimate follows: the part of the time so far within which most of a difference is taken over.
const PATIENCE: f64 = 0.25;

impl TimeLeft {
    /// What is expected before anything is done.
    pub fn expecting(time: Duration) -> Self {
        Self {
            elapsed: 0.0,
            left: Some(time.as_secs_f64()),
        }
    }

    /// Share of the whole time that has passed; 0 while nothing is known.
    pub fn share(&self) -> f64 {
        let whole = self.left.map(|left| self.elapsed + left);
        whole
            .filter(|whole| *whole > 0.0)
            .map_or(0.0, |whole| self.elapsed / whole)
    }

    /// Takes note that `share` of the work was done after `elapsed`.
    pub fn note(&mut self, elapsed: Duration, share: f64) {
        let now = elapsed.as_secs_f64();
        if share < FIRST_SHARE || now < FIRST_SECONDS {
            // A large picture's first sample may take minutes: what was expected counts down.
            let passed = (now - self.elapsed).max(0.0);
            self.left = self.left.map(|left| (left - passed).max(1.0));
            self.elapsed = now;
            return;
        }
        let by_rate = now * (1.0 - share.min(1.0)) / share;
        self.left = Some(match self.left {
            None => by_rate,
            Some(left) => {
                let passed = (now - self.elapsed).max(0.0);
                let counted_down = (left - passed).max(0.0);
                let weight = 1.0 - (-passed / (PATIENCE * now).max(0.5)).exp();
                counted_down + (by_rate - counted_down) * weight
            }
        });
        self.elapsed = now;
    }

    /// The time left; `None` while nothing is known.
    pub fn seconds(&self) -> Option<f64> {
        self.left
    }

    /// The time left as one says it: in steps that get coarser the more there is.
    pub fn text(&self) -> String {
        let Some(left) = self.left else {
            return "estimating the time left…".into();
        };
        let whole = |step: f64| (left / step).ceil() * step;
        if left < 1.5 {
            "about a second left".into()
        } else if left < 20.0 {
            format!("{:.0} s left", left.ceil())
        } else if left < 90.0 {
            format!("{:.0} s left", whole(5.0))
        } else if left < 5400.0 {
            format!("{:.0} min left", (left / 60.0).ceil())
        } else {
            format!("{:.1} h left", left / 3600.0)
        }
    }
}
