//! Changes of a whole chart that take longer than a frame may: worked out on a thread, taken over when done.

use egui::Context;
use renderer_core::design::{Chart, ChartImage};

use crate::designer::tasks::{Poll, Task};

/// At most one change at work.
#[derive(Default)]
pub struct ChartWork(Option<ChartChange>);

struct ChartChange {
    name: String,
    of: ChartImage,
    task: Task<Option<ChartImage>>,
}

impl ChartWork {
    /// Starts to change `image`; `name` is what the history calls it. One that is at work is given up.
    pub fn start(
        &mut self,
        ctx: &Context,
        name: impl Into<String>,
        image: &ChartImage,
        change: impl FnOnce(&ChartImage) -> Option<ChartImage> + Send + 'static,
    ) {
        let there = image.clone();
        self.0 = Some(ChartChange {
            name: name.into(),
            of: image.clone(),
            task: Task::start(ctx, move || change(&there)),
        });
    }

    /// Whether something is at work.
    pub fn is_busy(&self) -> bool {
        self.0.is_some()
    }

    /// Takes over what is done, and returns its name. A chart that has become another meanwhile stays as it is.
    pub fn take(&mut self, chart: &mut Chart) -> Option<String> {
        let result = match self.0.as_ref()?.task.poll() {
            Poll::Pending => return None,
            Poll::Ready(result) => result,
            Poll::Lost => None,
        };
        let job = self.0.take()?;
        let is_same = chart.pixels.as_ref().is_some_and(|now| now.is(&job.of));
        let changed = result.filter(|changed| is_same && *changed != job.of)?;
        put(chart, changed);
        Some(job.name)
    }
}

/// Makes pixels that were changed here the chart: they are in no file.
pub fn put(chart: &mut Chart, pixels: ChartImage) {
    chart.image = None;
    chart.pixels = Some(pixels);
}
