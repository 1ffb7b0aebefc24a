//! Which measurements are worth their cost: nothing else is both cheaper and more accurate.

/// One measurement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// What it cost, s.
    pub cost: f64,
    /// Its error; for an error below the truth's noise that noise, which is all that is known.
    pub error: f64,
}

impl Point {
    /// Whether this one leaves no reason to take `other`.
    pub fn beats(&self, other: &Self) -> bool {
        let no_worse = self.cost <= other.cost && self.error <= other.error;
        no_worse && (self.cost < other.cost || self.error < other.error)
    }
}

/// The Pareto front: indices of the points that none beats, by rising cost. Of equal points the first.
pub fn front(points: &[Point]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..points.len())
        .filter(|&index| points[index].error.is_finite())
        .collect();
    order.sort_by(|&a, &b| {
        let (a, b) = (&points[a], &points[b]);
        a.cost.total_cmp(&b.cost).then(a.error.total_cmp(&b.error))
    });
    let mut lowest = f64::INFINITY;
    order.retain(|&index| {
        let better = points[index].error < lowest;
        lowest = lowest.min(points[index].error);
        better
    });
    order
}

/// The cheapest point whose error is at most `error`.
pub fn cheapest(points: &[Point], error: f64) -> Option<usize> {
    let mut front = front(points).into_iter();
    front.find(|&index| points[index].error <= error)
}

/// For a group of measurements of which none is on the front: how much less the front costs at the same error or a
/// smaller one, in the group's best case; `None` if the group has a place on the front.
///
/// A group that is dominated by a factor next to 1 is as good as another; one of 5 is never worth it.
pub fn domination(points: &[Point], group: &[usize]) -> Option<f64> {
    let front = front(points);
    if group.iter().any(|index| front.contains(index)) {
        return None;
    }
    let factor = |&index: &usize| {
        let better = cheapest(points, points[index].error)?;
        Some(points[index].cost / points[better].cost)
    };
    group.iter().filter_map(factor).reduce(f64::min)
}
