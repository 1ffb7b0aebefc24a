//! Optimisations of the compiler: scenes made with them and without, and pictures of these.

use std::sync::Arc;
use std::time::Instant;

use renderer_core::design::{Colour, Design};
use renderer_core::image::metrics;
use renderer_core::render::{Backend, Optimisation, Optimisations};
use renderer_core::scene::{CompileReport, Compiler, Scene};
use towel_designer::clock::{Spent, timed};

use super::{Difference, Side, Trial};
use crate::drawing;

/// A scene made after an edit of the light.
pub struct Recompiling<'a> {
    design: &'a Design,
    edited: Design,
    size: [u32; 2],
    optimisation: Optimisation,
}

impl<'a> Recompiling<'a> {
    /// Of a design.
    ///
    /// # Errors
    /// When it has no scene.
    pub fn new(
        design: &'a Design,
        size: [u32; 2],
        optimisation: Optimisation,
    ) -> anyhow::Result<Self> {
        let mut edited = design.clone();
        let background = &mut edited.light.background;
        *background = match *background {
            Colour::WHITE => Colour([200; 3]),
            _ => Colour::WHITE,
        };
        Ok(Self {
            design,
            edited,
            size,
            optimisation,
        })
    }

    fn compile(&self, with: bool) -> anyhow::Result<(Arc<Scene>, CompileReport, Spent)> {
        let optimisations = match with {
            true => Optimisations::ALL,
            false => Optimisations::ALL.without(self.optimisation),
        };
        let mut compiler = Compiler::new(optimisations.into());
        compiler.compile(self.design)?;
        let mut spent = Spent::zero();
        let scene = timed(&mut spent, || compiler.compile(&self.edited))?;
        Ok((scene, *compiler.last_report(), spent))
    }
}

impl Trial for Recompiling<'_> {
    fn turn(
        &mut self,
        _: &mut dyn Backend,
        with: bool,
        _: Instant,
    ) -> anyhow::Result<Option<Spent>> {
        let (_, _, spent) = self.compile(with)?;
        Ok(Some(spent))
    }

    fn compare(&mut self, backend: &mut dyn Backend) -> anyhow::Result<([Side; 2], Difference)> {
        let mut sides = [Side::default(); 2];
        let mut pictures = Vec::new();
        for (side, with) in sides.iter_mut().zip([true, false]) {
            let (scene, report, _) = self.compile(with)?;
            let request = drawing::request(self.design, &scene, self.size, 1)?;
            drawing::draw(backend, &request, None)?;
            pictures.push(backend.picture()?);
            side.sections_kept = report.sections_kept();
        }
        let difference = match &pictures[..] {
            [with, without] => Difference {
                rel_rmse: metrics::rel_rmse(without, with)?,
                largest: metrics::max_abs_difference(without, with)?,
                // Both are of one seed, and nothing but the scene could differ.
                between_seeds: 0.0,
            },
            _ => Difference::default(),
        };
        Ok((sides, difference))
    }

    fn work(&self) -> String {
        "compile after an edit of the light".into()
    }
}
