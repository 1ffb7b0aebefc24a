//! Reducing a chart to a few yarns: how many, whether they are mixed, and a preview on the cloth before it is done.

use egui::{Button, Color32, ComboBox, Context, Sense, Ui, vec2};
use renderer_core::design::chart_edit::{Dither, MOST_YARNS, choose_yarns, reduce_to};
use renderer_core::design::{Chart, ChartImage};

use crate::designer::chart_editor::work::put;
use crate::designer::tasks::{Poll, Task};
use crate::designer::widgets::{NumberField, row, subheading};

/// What is asked for.
#[derive(Clone, PartialEq)]
struct Reduction {
    image: ChartImage,
    yarns: usize,
    dither: Dither,
}

/// What comes out.
struct Reduced {
    wanted: Reduction,
    yarns: Vec<[u8; 3]>,
    image: ChartImage,
}

/// The form and what it shows.
pub struct State {
    is_open: bool,
    yarns: usize,
    dither: Dither,
    work: Option<(Reduction, Task<Reduced>)>,
    done: Option<Reduced>,
}

impl Default for State {
    fn default() -> Self {
        Self {
            is_open: false,
            yarns: 6,
            dither: Dither::None,
            work: None,
            done: None,
        }
    }
}

impl State {
    /// The chart as it would be, while the form is open: the cloth shows it.
    pub fn preview(&self, chart: &Chart) -> Option<&ChartImage> {
        let done = self.done.as_ref().filter(|_| self.is_open)?;
        let pixels = chart.pixels.as_ref()?;
        done.wanted.image.is(pixels).then_some(&done.image)
    }

    fn close(&mut self) {
        self.is_open = false;
        self.work = None;
        self.done = None;
    }
}

/// Shows the form, or the button that opens it. Returns what the history is to call a change made here.
pub fn show(ui: &mut Ui, state: &mut State, chart: &mut Chart) -> Option<String> {
    let Some(image) = chart.pixels.clone() else {
        state.close();
        return None;
    };
    if !state.is_open {
        ui.add_space(2.0);
        let open = ui.button("Reduce to yarns…");
        if open
            .on_hover_text(
                "Finds the few colours that show the chart best, and previews it on the cloth.",
            )
            .clicked()
        {
            state.is_open = true;
        }
        return None;
    }
    subheading(ui, "Reduce to yarns");
    form(ui, state);
    let wanted = Reduction {
        image,
        yarns: state.yarns,
        dither: state.dither,
    };
    work(ui.ctx(), state, &wanted);
    swatches(ui, state);
    let mut name = None;
    ui.horizontal(|ui| {
        let done = state.done.take_if(|done| same(&done.wanted, &wanted));
        let apply = ui.add_enabled(done.is_some(), Button::new("Apply"));
        let is_applied = apply
            .accessible_name("Apply the reduction")
            .on_hover_text("Makes what the preview shows the chart.")
            .clicked();
        match (is_applied, done) {
            (true, Some(done)) => {
                name = Some(match done.yarns.len() {
                    1 => "reduce to 1 yarn".into(),
                    yarns => format!("reduce to {yarns} yarns"),
                });
                if done.image != wanted.image {
                    put(chart, done.image);
                }
                state.close();
            }
            (_, Some(done)) => state.done = Some(done),
            (_, None) => {}
        }
        let cancel = ui.button("Cancel").accessible_name("Cancel the reduction");
        if cancel.on_hover_text("Leaves the chart as it is.").clicked() {
            state.close();
        }
        if state.work.is_some() {
            ui.spinner();
        }
    });
    name
}

fn form(ui: &mut Ui, state: &mut State) {
    let what = "How many yarns the chart may have; fewer are easier to weave.";
    row(ui, "Number", what, |ui, _| {
        let yarns = NumberField::new(&mut state.yarns, "yarns", 1..=MOST_YARNS).speed(0.1);
        yarns
            .show(ui)
            .accessible_name("Number of yarns")
            .on_hover_text(what);
        ui.weak("yarns");
    });
    let what = "Whether yarns are mixed loop by loop where none of them is the colour.";
    row(ui, "Dithering", what, |ui, label| {
        let text = |dither| match dither {
            Dither::None => "none",
            Dither::Ordered => "regular pattern",
            Dither::Diffusion => "diffusion",
        };
        let combo = ComboBox::from_id_salt("dithering")
            .selected_text(text(state.dither))
            .width(ui.available_width())
            .show_ui(ui, |ui| {
                for (choice, what) in [
                    (
                        Dither::None,
                        "Each pixel takes the nearest yarn: flat areas, sharp edges.",
                    ),
                    (
                        Dither::Ordered,
                        "Yarns are mixed in a pattern of 8 × 8 pixels.",
                    ),
                    (
                        Dither::Diffusion,
                        "Yarns are mixed irregularly: the finest shades, and grain.",
                    ),
                ] {
                    ui.selectable_value(&mut state.dither, choice, text(choice))
                        .on_hover_text(what);
                }
            });
        combo.response.labelled_by(label.id).on_hover_text(what);
    });
}

fn same(a: &Reduction, b: &Reduction) -> bool {
    (a.yarns, a.dither) == (b.yarns, b.dither) && a.image.is(&b.image)
}

/// Starts what is asked for unless it is at work or done, and takes what is done.
fn work(ctx: &Context, state: &mut State, wanted: &Reduction) {
    if let Some((_, task)) = &state.work {
        match task.poll() {
            Poll::Pending => {}
            Poll::Ready(done) => {
                state.done = Some(done);
                state.work = None;
            }
            Poll::Lost => state.work = None,
        }
    }
    let is_done = state
        .done
        .as_ref()
        .is_some_and(|done| same(&done.wanted, wanted));
    // One at a time: while a number is dragged, what it was meanwhile is passed over.
    if is_done || state.work.is_some() {
        return;
    }
    let there = wanted.clone();
    let task = Task::start(ctx, move || {
        let yarns = choose_yarns(&there.image, there.yarns);
        let image = reduce_to(&there.image, &yarns, there.dither);
        Reduced {
            wanted: there,
            yarns,
            image,
        }
    });
    state.work = Some((wanted.clone(), task));
}

fn swatches(ui: &mut Ui, state: &State) {
    let Some(done) = &state.done else { return };
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing = vec2(3.0, 3.0);
        for &[r, g, b] in &done.yarns {
            let (rect, response) = ui.allocate_exact_size(vec2(18.0, 18.0), Sense::hover());
            ui.painter()
                .rect_filled(rect, 2.0, Color32::from_rgb(r, g, b));
            response.on_hover_text(format!("#{r:02x}{g:02x}{b:02x}"));
        }
    });
}
