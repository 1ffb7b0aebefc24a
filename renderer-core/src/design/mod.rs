//! Design: everything a user can edit, as they edit it (files' units: mm, degrees, sRGB). No wgpu, no egui.
//!
//! [`Design`] is plain data that can be cloned, compared and written as TOML; [`preset`] reads and writes files with
//! faults that name line and column. `scene::compile` turns a valid design into what a renderer draws.

mod arithmetic;
mod camera;
pub mod chart_edit;
mod chart_image;
pub mod chart_objects;
mod colour;
mod environment_image;
mod fields;
mod form;
mod height_image;
mod image_slot;
mod metering;
pub mod nap_edit;
mod pattern;
pub mod preset;
mod quantity;
mod sections;
mod shape;
mod weave_library;

pub use chart_image::{ChartImage, OPAQUE_FROM, TILE, Tile};
pub use colour::{Colour, linear_to_srgb, srgb_to_linear};
pub use environment_image::{EnvironmentFault, EnvironmentImage, EnvironmentReader};
pub use fields::{Fault, Field, Numbers, Warning};
pub use height_image::HeightImage;
pub use image_slot::{ImagePixels, ImageSlot, PixelKind};
pub use pattern::{Anchor, Keep, NewCells, Pattern, STITCHES, Stitch};
pub use quantity::read_number;
pub use sections::*;
pub use shape::{Entry, Shape, Shaped};
pub use weave_library::{LibraryWeave, WEAVE_LIBRARY};

use serde::{Deserialize, Serialize};

/// The preset format this program writes.
pub const FORMAT: u32 = 1;

/// A towel or carpet as its designer describes it. The default is a plain white bath towel.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Design {
    /// Size of the ground weave.
    pub sheet: Sheet,
    /// Stitch pattern.
    pub weave: Weave,
    /// Chart image: colour of each loop.
    pub chart: Chart,
    /// Length of each loop.
    pub length: Length,
    /// The yarn loops and the volume inside them.
    pub pile: Pile,
    /// The smooth disorder of the loops.
    pub turbulence: Turbulence,
    /// What happens to the loops after weaving.
    pub finish: Finish,
    /// Which way the front's pile is brushed.
    pub nap: Nap,
    /// The ground weave's yarns.
    pub skeleton: SkeletonDesign,
    /// How the cloth lies in space.
    pub form: Form,
    /// Lights and background.
    pub light: Light,
    /// Cameras and display.
    pub view: View,
    /// How a final picture is made.
    pub quality: Quality,
}

impl Shaped for Design {
    fn shape() -> Shape {
        let section = |name, what, shape| Entry { name, what, shape };
        Shape::table(vec![
            section("sheet", "Size of the ground weave.", Sheet::shape()),
            section("weave", "Stitch pattern.", Weave::shape()),
            section("chart", "Chart image: colour of each loop.", Chart::shape()),
            section("length", "Length of each loop.", Length::shape()),
            section(
                "pile",
                "The yarn loops and the volume inside them.",
                Pile::shape(),
            ),
            section(
                "turbulence",
                "The smooth disorder of the loops.",
                Turbulence::shape(),
            ),
            section(
                "finish",
                "What happens to the loops after weaving: shears, wear and water.",
                Finish::shape(),
            ),
            section(
                "nap",
                "Which way the front's pile is brushed, by an image.",
                Nap::shape(),
            ),
            section(
                "skeleton",
                "The ground weave's yarns.",
                SkeletonDesign::shape(),
            ),
            section("form", "How the cloth lies in space.", Form::shape()),
            section("light", "Lights and background.", Light::shape()),
            section("view", "Cameras and display.", View::shape()),
            section("quality", "How a final picture is made.", Quality::shape()),
        ])
    }
}

impl Design {
    /// Every value that is not allowed; empty for a design that compiles.
    pub fn faults(&self) -> Vec<Fault> {
        let mut faults = self.value_faults();
        self.push_relation_faults(&mut faults);
        faults
    }

    /// Faults of single values.
    fn value_faults(&self) -> Vec<Fault> {
        let mut faults = Vec::new();
        self.sheet.push_range_faults("sheet", &mut faults);
        self.weave.pattern.push_faults("weave.pattern", &mut faults);
        self.chart.push_faults(&mut faults);
        self.length.push_faults(&mut faults);
        self.pile.push_range_faults("pile", &mut faults);
        self.turbulence.push_range_faults("turbulence", &mut faults);
        self.finish.push_range_faults("finish", &mut faults);
        self.nap.push_range_faults("nap", &mut faults);
        self.skeleton.push_range_faults("skeleton", &mut faults);
        self.form.push_faults(&mut faults);
        self.light.push_faults(&mut faults);
        self.view.push_faults(&mut faults);
        self.quality.push_range_faults("quality", &mut faults);
        faults
    }

    /// Faults of fields that are each in range but not together.
    fn push_relation_faults(&self, faults: &mut Vec<Fault>) {
        faults.extend(self.fault_of_size());
        let mut fault = |path: &str, value: f64, allowed: String| {
            faults.push(Fault {
                path: path.into(),
                value: value.to_string(),
                allowed,
            });
        };
        if self.length.min > self.length.max {
            fault(
                "length.min",
                self.length.min,
                format!("at most length.max, {}", self.length.max),
            );
        }
        let reach = self.reach_mm();
        let limit = Sheet::MAX_REACH_CELLS * self.sheet.pitch_x().min(self.sheet.pitch_y());
        if reach > limit {
            fault(
                "pile.max_length",
                self.pile.max_length,
                format!(
                    "a length with which loops reach at most {} cells ({limit:.1} mm; they reach {reach:.1} mm)",
                    Sheet::MAX_REACH_CELLS
                ),
            );
        }
        let turbulence = &self.turbulence;
        if turbulence.filter != Filter::None
            && turbulence.filter_radius > f64::from(self.sheet.warps.max(self.sheet.wefts))
        {
            fault(
                "turbulence.filter_radius",
                turbulence.filter_radius,
                "at most the sheet's larger side in cells".into(),
            );
        }
        self.push_area_faults(faults);
    }

    /// Whether part of the cloth can be made without the rest: level cloth whose loops do not depend on each other.
    pub fn has_parts(&self) -> bool {
        self.form.kind == FormKind::Flat && !self.turbulence.is_filtered()
    }

    /// What is wrong with the cloth's size: only cloth that has parts is made in regions.
    fn fault_of_size(&self) -> Option<Fault> {
        if self.has_parts() {
            return self.sheet.fault_of_cells(Sheet::MAX_CELLS, "");
        }
        let unless = if self.form.kind == FormKind::Flat {
            "; more when turbulence.filter is \"none\""
        } else {
            "; more when form.kind is \"flat\""
        };
        self.sheet.fault_of_cells(Sheet::MAX_CELLS_AT_ONCE, unless)
    }

    /// Faults of area lights that stand in the cloth: what lies behind one would be in the way of rays to it.
    fn push_area_faults(&self, faults: &mut Vec<Fault>) {
        for (index, area) in self.light.area.iter().enumerate() {
            let nearest = self.nearest_area_mm(area.azimuth, area.elevation);
            if area.distance < nearest {
                faults.push(Fault {
                    path: format!("light.area[{index}].distance"),
                    value: area.distance.to_string(),
                    allowed: format!(
                        "at least {nearest} mm from azimuth {}° and elevation {}°, so that the whole cloth is \
                         before the light",
                        area.azimuth, area.elevation
                    ),
                });
            }
        }
    }

    /// The least distance at which an area light in that direction (degrees) has the whole cloth before it, whole mm.
    pub fn nearest_area_mm(&self, azimuth: f64, elevation: f64) -> f64 {
        let skeleton = &self.skeleton;
        let ground = skeleton.warp_radius.max(skeleton.weft_radius) + skeleton.crimp;
        let reach = self.reach_mm();
        if let Some(radius) = self.form.radius_mm(&self.sheet) {
            return (radius + reach + ground).ceil();
        }
        let half_sides = [
            0.5 * f64::from(self.sheet.warps) * self.sheet.pitch_x(),
            0.5 * f64::from(self.sheet.wefts) * self.sheet.pitch_y(),
        ];
        let across = elevation.to_radians().cos().abs();
        let (sine, cosine) = azimuth.to_radians().sin_cos();
        let along = (half_sides[0] + reach) * cosine.abs() + (half_sides[1] + reach) * sine.abs();
        let up = (reach + ground) * elevation.to_radians().sin().abs();
        (along * across + up).ceil()
    }

    /// The farthest that any part of a loop can be from its cell's centre, mm.
    pub fn reach_mm(&self) -> f64 {
        let longest =
            self.length.longest() * (1.0 + self.pile.stretch) * (1.0 + self.pile.length_jitter)
                + self.finish.longer_mm();
        let tops = self.length.rows().iter().filter_map(|row| row.top_width);
        let width = tops.fold(self.pile.base_width.max(self.pile.top_width), f64::max);
        longest.min(self.pile.max_length) + width + self.pile.thickness
    }

    /// Things that are allowed but probably not meant.
    pub fn warnings(&self) -> Vec<Warning> {
        let mut warnings = Vec::new();
        let highest = self.turbulence.frequency
            * self
                .turbulence
                .lacunarity
                .powi(self.turbulence.octaves as i32 - 1);
        let limit = 0.5 / self.sheet.pitch_x().max(self.sheet.pitch_y());
        if highest > limit {
            let text = format!(
                "the highest turbulence octave has {highest:.2} cycles/mm, above {limit:.2}, half a cycle a cell: \
                 neighbouring loops look unrelated"
            );
            warnings.push(Warning::new("turbulence.frequency", text));
        }
        for (index, object) in self.chart.object.iter().enumerate() {
            let missing = match object.kind {
                ObjectKind::Image if object.pixels.is_none() => "image",
                ObjectKind::Text if object.outline.is_none() => "outline of its text",
                _ => continue,
            };
            let text = format!(
                "object {} of the chart has no {missing}: it draws nothing",
                index + 1
            );
            warnings.push(Warning::new(&format!("chart.object[{index}]"), text));
        }
        if let Some(image) = &self.light.environment.pixels
            && image.mended() > 0
        {
            let text = format!(
                "{} pixels of the environment's image are darker than 0 or brighter than {}: they are taken as that",
                image.mended(),
                EnvironmentImage::BRIGHTEST
            );
            warnings.push(Warning::new("light.environment.image", text));
        }
        warnings
    }
}
