//! One of several candidates, each with a probability in proportion to a weight, from one random number (resampled
//! importance sampling: Talbot, Cline and Egbert 2005; MODEL.md §9).

/// A choice in the making: candidates come one by one.
#[derive(Debug)]
pub(super) struct Resampling<T> {
    /// In [0, 1), independent of all before.
    number: f64,
    sum: f64,
    chosen: Option<(T, f64)>,
}

impl<T> Resampling<T> {
    /// A choice by a number in [0, 1).
    #[inline(always)]
    pub fn new(number: f64) -> Self {
        Self {
            number,
            sum: 0.0,
            chosen: None,
        }
    }

    /// Another candidate, and its weight.
    #[inline(always)]
    pub fn add(&mut self, candidate: T, weight: f64) {
        if weight <= 0.0 {
            return;
        }
        self.sum += weight;
        let chance = weight / self.sum;
        // The number goes on in its part, so that numbers that are spread evenly choose evenly.
        if self.number < chance {
            self.number /= chance;
            self.chosen = Some((candidate, weight));
        } else {
            self.number = (self.number - chance) / (1.0 - chance);
        }
    }

    /// The candidate, and one over the probability that it was chosen; none where none had a weight.
    #[inline(always)]
    pub fn finish(self) -> Option<(T, f64)> {
        let sum = self.sum;
        self.chosen
            .map(|(candidate, weight)| (candidate, sum / weight))
    }
}

/// About what share of the sky's light comes to a point of the pile from a direction, `up` of which is upwards: nearer
/// to the horizon more loops are in its way.
#[inline(always)]
pub(super) fn openness(up: f64) -> f64 {
    up.max(0.0).sqrt()
}

/// The numbers in [0, 1) with which candidate `index` draws a direction: points that fill the square evenly (M. Roberts'
/// R₂), moved by the sample's numbers.
#[inline(always)]
pub(super) fn spread([u, v]: [f64; 2], index: usize) -> [f64; 2] {
    // Numbers from 0 to below 9 are cut faster than rounded down.
    let fraction = |x: f64| x - f64::from(x as i32);
    let at = index as f64;
    [
        fraction(u + at * 0.754_877_666_246_693),
        fraction(v + at * 0.569_840_290_998_053),
    ]
}
