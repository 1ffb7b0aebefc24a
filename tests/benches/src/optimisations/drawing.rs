//! Optimisations of backends: pictures drawn with them and without.

use std::sync::Arc;
use std::time::Instant;

use renderer_core::design::Design;
use renderer_core::image::metrics;
use renderer_core::render::{Backend, Optimisation, RenderRequest, convergence};
use renderer_core::scene::Scene;
use towel_designer::clock::Spent;

use super::{Difference, LONGEST_FIRST, Side, Trial};
use crate::drawing::{self, Drawn};

/// The error target, as a share of the error at the fewest samples that can end a tile: some tiles end there, others go
/// on to four times as many samples and more.
const TARGET: f64 = 0.6;
/// Most samples of a turn with a target.
const MOST_FOR_TARGET: u32 = 256;

/// A picture of some samples, or one up to an error.
pub struct Sampling {
    request: RenderRequest,
    optimisation: Optimisation,
}

impl Sampling {
    /// With so many samples that a turn can be timed; `None` if time is up before the first.
    ///
    /// # Errors
    /// When the backend fails.
    pub fn new(
        design: &Design,
        scene: &Arc<Scene>,
        size: [u32; 2],
        optimisation: Optimisation,
        backend: &mut dyn Backend,
        deadline: Instant,
    ) -> anyhow::Result<Option<Self>> {
        let mut request = drawing::request(design, scene, size, 1)?;
        let until = deadline.max(Instant::now() + LONGEST_FIRST);
        let Some(first) = drawing::draw(backend, &request, Some(until))? else {
            return Ok(None);
        };
        request.settings.samples = drawing::samples_for(first.samples.wall);
        Ok(Some(Self {
            request,
            optimisation,
        }))
    }

    /// Up to an error that some tiles have long before others; `None` where time is up before it is known, or where
    /// there is nothing but background.
    ///
    /// # Errors
    /// When the backend fails.
    pub fn to_error(
        design: &Design,
        scene: &Arc<Scene>,
        size: [u32; 2],
        optimisation: Optimisation,
        backend: &mut dyn Backend,
        deadline: Instant,
    ) -> anyhow::Result<Option<Self>> {
        // So many samples of all pixels would take too long.
        let size = size.map(|side| side.div_ceil(2));
        let mut request = drawing::request(design, scene, size, convergence::FEWEST_FOR_ERROR)?;
        let first = drawing::draw(backend, &request, Some(deadline))?;
        let estimate = first.and_then(|first| first.estimate);
        let Some(estimate) = estimate.filter(|estimate| *estimate > 0.0) else {
            return Ok(None);
        };
        request.settings.error = TARGET * estimate;
        request.settings.samples = MOST_FOR_TARGET;
        Ok(Some(Self {
            request,
            optimisation,
        }))
    }

    fn side(&self, with: bool) -> RenderRequest {
        let mut request = self.request.clone();
        if !with {
            request.settings.optimisations =
                request.settings.optimisations.without(self.optimisation);
        }
        request
    }

    /// Draws from nothing, even where the backend has this picture already.
    fn draw(
        backend: &mut dyn Backend,
        request: &RenderRequest,
        deadline: Option<Instant>,
    ) -> anyhow::Result<Option<Drawn>> {
        let mut other = request.clone();
        other.settings.seed = !request.settings.seed;
        backend.begin(&other)?;
        drawing::draw(backend, request, deadline)
    }
}

impl Trial for Sampling {
    fn turn(
        &mut self,
        backend: &mut dyn Backend,
        with: bool,
        deadline: Instant,
    ) -> anyhow::Result<Option<Spent>> {
        let drawn = Self::draw(backend, &self.side(with), Some(deadline))?;
        Ok(drawn.map(|drawn| drawn.samples))
    }

    fn compare(&mut self, backend: &mut dyn Backend) -> anyhow::Result<([Side; 2], Difference)> {
        let mut sides = [Side::default(); 2];
        let mut pictures = Vec::new();
        for (side, with) in sides.iter_mut().zip([true, false]) {
            side.counters = drawing::count(backend, &self.side(with))?;
            pictures.push(backend.picture()?);
        }
        let mut other = self.side(true);
        other.settings.seed = !other.settings.seed;
        Self::draw(backend, &other, None)?;
        pictures.push(backend.picture()?);
        let difference = match &pictures[..] {
            [with, without, other] => Difference {
                rel_rmse: metrics::rel_rmse(without, with)?,
                largest: metrics::max_abs_difference(without, with)?,
                between_seeds: metrics::rel_rmse(other, with)?,
            },
            _ => Difference::default(),
        };
        Ok((sides, difference))
    }

    fn work(&self) -> String {
        match self.request.settings.error {
            error if error > 0.0 => {
                let [width, height] = self.request.size;
                format!("{width} × {height} pixels up to error {error:.3}")
            }
            _ => match self.request.settings.samples {
                1 => "1 sample".into(),
                samples => format!("{samples} samples"),
            },
        }
    }
}
