//! The sections of a design, one struct each, in the order one designs: sheet, weave, chart, length, pile, turbulence,
//! finish, nap, skeleton, form, light, view, quality. Field names are those of preset files.
//!
//! Longer than most files because it is the one list of all editable fields.

use serde::{Deserialize, Serialize};

use super::chart_objects::GlyphPath;
use super::fields::{Fault, Field, Numbers, section};
use super::{ChartImage, Colour, EnvironmentImage, HeightImage, Pattern, Shape, Shaped};

section! {
    /// Size of the ground weave (MODEL.md §1).
    Sheet, SheetFields {
        numbers {
            /// How many warp yarns the cloth is wide.
            warps: u32 = 120, 1..=100_000, "yarns";
            /// How many weft yarns the cloth is long.
            wefts: u32 = 140, 1..=100_000, "yarns";
            /// How closely the warp yarns stand; more makes the cloth narrower and the pile denser.
            warps_per_cm: f64 = 13.3, 0.5..=60.0, "/cm";
            /// How closely the weft yarns stand; more makes the cloth shorter and the pile denser.
            wefts_per_cm: f64 = 14.8, 0.5..=60.0, "/cm";
        }
        others {}
    }
}

impl Sheet {
    /// Most crossings of warps and wefts that a sheet may have: a carpet of twenty by twenty metres at ten loops a
    /// centimetre.
    pub const MAX_CELLS: f64 = 4e8;
    /// Most crossings that are made at once: a carpet of four by four metres. With loops on both faces of every
    /// crossing the scene and its frames take some 10 GB.
    pub const MAX_CELLS_AT_ONCE: f64 = 16e6;
    /// Farthest that a loop may reach, in cells: what a cell list entry can address.
    pub const MAX_REACH_CELLS: f64 = 60.0;

    /// Distance between warps, mm.
    pub fn pitch_x(&self) -> f64 {
        10.0 / self.warps_per_cm
    }

    /// Distance between wefts, mm.
    pub fn pitch_y(&self) -> f64 {
        10.0 / self.wefts_per_cm
    }

    /// What is wrong with the number of crossings for what makes all of them at once.
    pub fn fault_of_all_cells(&self) -> Option<Fault> {
        self.fault_of_cells(
            Self::MAX_CELLS_AT_ONCE,
            " for what needs the whole cloth at once",
        )
    }

    /// What is wrong with the number of crossings where there may be so many; `when` tells where.
    pub(super) fn fault_of_cells(&self, most: f64, when: &str) -> Option<Fault> {
        let cells = f64::from(self.warps) * f64::from(self.wefts);
        (cells > most).then(|| Fault {
            path: "sheet.wefts".into(),
            value: self.wefts.to_string(),
            allowed: format!("at most {most} crossings with {} warps{when}", self.warps),
        })
    }
}

/// `FrameLambert` as `frame_lambert`: what serde's `rename_all` makes of a variant's name.
fn snake_case(variant: &str) -> String {
    let mut name = String::new();
    for c in variant.chars() {
        if c.is_ascii_uppercase() && !name.is_empty() {
            name.push('_');
        }
        name.push(c.to_ascii_lowercase());
    }
    name
}

/// Declares an enum whose variants are written in files in lower case with underscores, or as given after `written`,
/// and listed for menus.
macro_rules! choice {
    (@name $variant:ident) => { snake_case(stringify!($variant)) };
    (@name $variant:ident $written:literal) => { $written.into() };
    ($(#[$meta:meta])* $name:ident {
        $( $(#[doc = $doc:literal])+ $variant:ident = $label:literal $(written $written:literal)?, )+
    }) => {
        $(#[$meta])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
        #[serde(rename_all = "snake_case")]
        pub enum $name { $( $(#[doc = $doc])+ $(#[serde(rename = $written)])? $variant, )+ }

        impl $name {
            /// All choices, in menu order.
            pub const ALL: &'static [Self] = &[$(Self::$variant,)+];

            /// What a menu calls this choice.
            pub fn label(self) -> &'static str {
                match self { $(Self::$variant => $label,)+ }
            }

            /// What this choice does to the cloth or the picture.
            pub fn what(self) -> &'static str {
                match self { $(Self::$variant => concat!($($doc),+).trim_ascii(),)+ }
            }

            /// How preset files and the command line write this choice.
            pub fn name(self) -> String {
                match self { $(Self::$variant => choice!(@name $variant $($written)?),)+ }
            }
        }

        impl Shaped for $name {
            fn shape() -> Shape {
                Shape::Choice(Self::ALL.iter().map(|choice| (choice.name(), choice.what())).collect())
            }
        }
    };
}

choice! {
    /// What stands on the back of the cloth.
    Back {
        /// The back repeats the front's loops.
        Mirror = "mirror",
        /// The back follows the pattern's 8s and 9s.
        Pattern = "pattern",
        /// The back is bare.
        None = "none",
    }
}

section! {
    /// The stitch pattern and what it means for the back.
    Weave, WeaveFields {
        numbers {}
        others {
            /// The repeat: 0 weft over, 1 warp over, 7 loop on the front, 8 on the back, 9 on both. Row 0 is the near
            /// edge.
            pattern: Pattern = terry_checker();
            /// What stands on the back.
            back: Back = Back::Mirror;
        }
    }
}

/// Loops on every second crossing, alternate rows shifted by one.
fn terry_checker() -> Pattern {
    let mut pattern = Pattern::filled(2, 2, 0);
    pattern.set(0, 0, 7);
    pattern.set(1, 1, 7);
    pattern
}

choice! {
    /// How chart texels are laid over the cells.
    Fit {
        /// The chart covers the whole sheet once.
        Stretch = "stretch",
        /// One pixel is one crossing; the chart repeats.
        Tile = "tile",
        /// One pixel is one crossing; the chart lies on the cloth once. Around it, and where it is transparent, the
        /// cloth has its own colour.
        Place = "place once",
    }
}

section! {
    /// The chart image: colour of each loop (and through [`Length`] its length and material).
    Chart, ChartFields {
        numbers {
            /// When placed: how many warps the chart's middle lies right of the cloth's.
            offset_x: i32 = 0, -100_000..=100_000, "warps";
            /// When placed: how many wefts the chart's middle lies beyond the cloth's, away from the near edge.
            offset_y: i32 = 0, -100_000..=100_000, "wefts";
        }
        others {
            /// Path of the image, relative to the preset: PNG, JPEG, WebP, GIF, BMP, TIFF, TGA or PPM, by its colour
            /// profile or as sRGB. Each palette entry is a yarn: of two with one colour the second is changed by the
            /// smallest step. No image means one colour.
            #[serde(skip_serializing_if = "Option::is_none")]
            image: Option<String> = None;
            /// How texels are laid over the cells.
            fit: Fit = Fit::Stretch;
            /// When stretched: a loop's colour is the mean of the pixels around it, as far as it is from loop to loop.
            /// For photographs; without it a loop has the colour of the one pixel at its middle.
            average: bool = false;
            /// When tiling: every second repeat along the weft is mirrored.
            mirror_x: bool = false;
            /// When tiling: every second repeat along the warp is mirrored.
            mirror_y: bool = false;
            /// When tiling: every second column of repeats is shifted by half a repeat.
            half_drop: bool = false;
            /// Colour of all loops where there is no image, also around one that is placed: what the finished cloth
            /// reflects.
            colour: Colour = Colour::WHITE;
            /// Names of yarns, by their colours on the chart.
            #[serde(skip_serializing_if = "Vec::is_empty")]
            yarn: Vec<NamedYarn> = Vec::new();
            /// Lines to align objects by: how far each lies right of the chart's middle, mm.
            #[serde(skip_serializing_if = "Vec::is_empty")]
            guides_x: Vec<f64> = Vec::new();
            /// Lines to align objects by: how far each lies beyond the chart's middle, away from the near edge, mm.
            #[serde(skip_serializing_if = "Vec::is_empty")]
            guides_y: Vec<f64> = Vec::new();
            /// What lies on the chart, the lowest first: drawn over the image, or over the colour where there is none,
            /// and editable until it is flattened.
            #[serde(skip_serializing_if = "Vec::is_empty")]
            object: Vec<ChartObject> = Vec::new();
            /// The decoded image; read and written by the program's file layer, never by serde.
            #[serde(skip)]
            pixels: Option<ChartImage> = None;
        }
    }
}

section! {
    /// What a designer calls a yarn of the chart.
    NamedYarn, NamedYarnFields {
        numbers {}
        others {
            /// Its colour on the chart.
            colour: Colour = Colour::WHITE;
            /// Its name: of a shade card, say.
            name: String = String::new();
        }
    }
}

choice! {
    /// What an object of a chart is.
    ObjectKind {
        /// A rectangle.
        Rectangle = "rectangle",
        /// An ellipse.
        Ellipse = "ellipse",
        /// A straight line, as long as it is wide; its height is how thick it is, at least a crossing.
        Line = "line",
        /// A stripe from side to side; its height is how broad it is.
        StripeAcross = "stripe across",
        /// A stripe from the near edge to the far one; its width is how broad it is.
        StripeAlong = "stripe along",
        /// Letters.
        Text = "text",
        /// A picture.
        Image = "image",
    }
}

section! {
    /// Something on a chart, in mm of the cloth: x to the right and y away from the near edge, from the chart's
    /// middle. It has the same size whatever the weave; how many loops that is, follows from it.
    ChartObject, ChartObjectFields {
        numbers {
            /// How far its middle lies right of the chart's.
            x: f64 = 0.0, -1_000_000.0..=1_000_000.0, "mm";
            /// How far its middle lies beyond the chart's, away from the near edge.
            y: f64 = 0.0, -1_000_000.0..=1_000_000.0, "mm";
            /// How wide it is, before it is turned.
            width: f64 = 50.0, 0.01..=1_000_000.0, "mm";
            /// How high it is, before it is turned.
            height: f64 = 50.0, 0.01..=1_000_000.0, "mm";
            /// Turns it about its middle, anticlockwise.
            rotation: f64 = 0.0, -360.0..=360.0, "°";
            /// Width of the outline that a rectangle or an ellipse is drawn as; 0 fills it.
            border: f64 = 0.0, 0.0..=1_000_000.0, "mm";
            /// How much of what lies below it hides; less than 1 mixes colours that are no yarns.
            opacity: f64 = 1.0, 0.0..=1.0, "";
            /// How far a colour may be from the transparent one and still count as it: distance in Oklab.
            tolerance: f64 = 0.05, 0.0..=1.0, "";
            /// How often it stands side by side.
            repeat_x: u32 = 1, 1..=500, "times";
            /// How often it stands one beyond the other.
            repeat_y: u32 = 1, 1..=500, "times";
            /// How far the middle of one repeat lies right of the one before.
            step_x: f64 = 100.0, -1_000_000.0..=1_000_000.0, "mm";
            /// How far the middle of one repeat lies beyond the one before.
            step_y: f64 = 100.0, -1_000_000.0..=1_000_000.0, "mm";
        }
        others {
            /// What it is.
            kind: ObjectKind = ObjectKind::Rectangle;
            /// Its colour, unless it is an image.
            colour: Colour = Colour([0x1f, 0x3a, 0x6e]);
            /// Plants no loops, so that the ground weave is seen, instead of having a colour.
            bare: bool = false;
            /// Exchanges its left and right.
            mirror_x: bool = false;
            /// Exchanges its far and near side.
            mirror_y: bool = false;
            /// It and its repeats stand once more, mirrored about the chart's middle from left to right.
            reflect_x: bool = false;
            /// It and its repeats stand once more, mirrored about the chart's middle from the near to the far side.
            reflect_y: bool = false;
            /// An image's loops have the mean colour of the pixels around them: for photographs. Without it a loop has
            /// the colour of the one pixel at its middle.
            average: bool = false;
            /// Path of the image, relative to the preset, read as `chart.image` is.
            #[serde(skip_serializing_if = "Option::is_none")]
            image: Option<String> = None;
            /// What is written.
            #[serde(skip_serializing_if = "Option::is_none")]
            text: Option<String> = None;
            /// Name of the font that the text's outline was taken from.
            #[serde(skip_serializing_if = "Option::is_none")]
            font: Option<String> = None;
            /// Outline of the text, so that it looks the same where the font is missing: M x y, L x y, Q x y x y,
            /// C x y x y x y and Z, y upwards; its bounds are stretched over the object. Left out, it is made from the
            /// font.
            #[serde(skip_serializing_if = "Option::is_none")]
            outline: Option<String> = None;
            /// The colour of an image that counts as transparent.
            #[serde(skip_serializing_if = "Option::is_none")]
            transparent: Option<Colour> = None;
            /// The decoded image; read and written by the program's file layer, never by serde.
            #[serde(skip)]
            pixels: Option<ChartImage> = None;
        }
    }
}

impl ChartObject {
    /// Most objects of a chart.
    pub const MAX: usize = 200;
}

impl Chart {
    /// Most yarns with names.
    pub const MOST_NAMES: usize = 256;

    /// What a yarn is called, if it has a name.
    pub fn name_of(&self, colour: Colour) -> Option<&str> {
        let named = self.yarn.iter().find(|yarn| yarn.colour == colour)?;
        Some(&named.name)
    }

    /// Gives a yarn a name; an empty one takes it away.
    pub fn set_name(&mut self, colour: Colour, name: &str) {
        let known = self.yarn.iter().position(|yarn| yarn.colour == colour);
        match (known, name.is_empty()) {
            (Some(index), true) => drop(self.yarn.remove(index)),
            (Some(index), false) => self.yarn[index].name = name.into(),
            (None, true) => {}
            (None, false) => self.yarn.push(NamedYarn {
                colour,
                name: name.into(),
            }),
        }
    }

    pub(super) fn push_faults(&self, faults: &mut Vec<Fault>) {
        self.push_range_faults("chart", faults);
        let mut fault = |path: String, value: String, allowed: String| {
            faults.push(Fault {
                path,
                value,
                allowed,
            });
        };
        if self.object.len() > ChartObject::MAX {
            fault(
                "chart.object".into(),
                format!("{} objects", self.object.len()),
                format!("at most {} objects", ChartObject::MAX),
            );
        }
        if self.yarn.len() > Self::MOST_NAMES {
            fault(
                "chart.yarn".into(),
                format!("{} names", self.yarn.len()),
                format!("at most {} names", Self::MOST_NAMES),
            );
        }
        for (name, guides) in [("guides_x", &self.guides_x), ("guides_y", &self.guides_y)] {
            for (index, guide) in guides.iter().enumerate() {
                if !(-1e6..=1e6).contains(guide) {
                    fault(
                        format!("chart.{name}[{index}]"),
                        guide.to_string(),
                        "-1000000 to 1000000 mm".into(),
                    );
                }
            }
        }
        for (index, object) in self.object.iter().enumerate() {
            if let Some(Err(what)) = object.outline.as_deref().map(GlyphPath::read) {
                fault(
                    format!("chart.object[{index}].outline"),
                    what,
                    GlyphPath::ALLOWED.into(),
                );
            }
        }
        for (index, object) in self.object.iter().enumerate() {
            object.push_range_faults(&format!("chart.object[{index}]"), faults);
        }
    }
}

choice! {
    /// How a texel becomes a loop length.
    LengthMap {
        /// All loops have the same length.
        Constant = "all the same",
        /// Length follows the texel's brightness through a curve.
        Gray = "by brightness",
        /// Each colour of the chart has its own length and material.
        Lut = "by colour",
    }
}

choice! {
    /// What a loop is made of.
    PileKind {
        /// Uncut loops: an arch of twisted plies.
        Terry = "terry loop",
        /// Cut loops: a tuft of fibres (velour, velvet, cut carpet).
        Cut = "cut tuft",
        /// Cut strands of twisted plies that keep their twist (frieze, shag).
        Twisted = "twisted strand",
        /// Tapered hairs: guard hairs above a short undercoat. All have the yarn's section together.
        Fur = "tuft of fur",
        /// Flat blades as wide as the yarn, as many as there are plies.
        Grass = "tuft of grass",
    }
}

impl PileKind {
    /// Whether its yarn is twisted from plies that show.
    pub fn is_plied(self) -> bool {
        matches!(self, Self::Terry | Self::Twisted)
    }

    /// What [`Pile::plies`] counts in it, one and several, if anything.
    pub fn plies_are(self) -> Option<[&'static str; 2]> {
        match self {
            Self::Terry | Self::Twisted => Some(["ply", "plies"]),
            Self::Grass => Some(["blade", "blades"]),
            Self::Cut | Self::Fur => None,
        }
    }
}

section! {
    /// One row of the table from chart colour to length and material.
    LengthEntry, LengthEntryFields {
        numbers {
            /// Length of loops of this colour; 0 plants none.
            length: f64 = 3.0, 0.0..=100.0, "mm";
            /// Multiplies how much light loops of this colour give back.
            albedo_scale: f64 = 1.0, 0.0..=1.0, "";
        }
        others {
            /// The chart colour this row is for; texels use the nearest row.
            colour: Colour = Colour::WHITE;
            /// Density of the yarn instead of `pile.density`, 1/mm.
            #[serde(skip_serializing_if = "Option::is_none")]
            density: Option<f64> = None;
            /// Kind of pile instead of `pile.kind`.
            #[serde(skip_serializing_if = "Option::is_none")]
            kind: Option<PileKind> = None;
            /// How a point of the pile scatters light instead of `pile.phase`.
            #[serde(skip_serializing_if = "Option::is_none")]
            phase: Option<Phase> = None;
            /// Lean along the weft instead of `pile.lean_x`, degrees.
            #[serde(skip_serializing_if = "Option::is_none")]
            lean_x: Option<f64> = None;
            /// Lean along the warp instead of `pile.lean_y`, degrees.
            #[serde(skip_serializing_if = "Option::is_none")]
            lean_y: Option<f64> = None;
            /// How far the turbulence tips loops over instead of `pile.tilt`, degrees.
            #[serde(skip_serializing_if = "Option::is_none")]
            tilt: Option<f64> = None;
            /// Width of a loop at its top instead of `pile.top_width`, mm.
            #[serde(skip_serializing_if = "Option::is_none")]
            top_width: Option<f64> = None;
            /// Thickness of the yarn instead of `pile.yarn_diameter`, mm; what the width and thickness of a loop leave
            /// no room for is cut off.
            #[serde(skip_serializing_if = "Option::is_none")]
            yarn_diameter: Option<f64> = None;
            /// Share of light that passes through instead of `pile.transmission`, for frame and gradient Lambert.
            #[serde(skip_serializing_if = "Option::is_none")]
            transmission: Option<f64> = None;
            /// Share of light in the highlight instead of `pile.specular`, for Kajiya-Kay.
            #[serde(skip_serializing_if = "Option::is_none")]
            specular: Option<f64> = None;
            /// Sharpness of the highlight instead of `pile.exponent`, for Kajiya-Kay.
            #[serde(skip_serializing_if = "Option::is_none")]
            exponent: Option<f64> = None;
        }
    }
}

section! {
    /// Length of each loop (MODEL.md §6).
    Length, LengthFields {
        numbers {
            /// Length of all loops when the map is constant.
            value: f64 = 2.8, 0.0..=100.0, "mm";
            /// Length where the chart is black.
            min: f64 = 1.5, 0.0..=100.0, "mm";
            /// Length where the chart is white.
            max: f64 = 3.5, 0.0..=100.0, "mm";
        }
        others {
            /// How a texel becomes a length.
            map: LengthMap = LengthMap::Constant;
            /// Points (brightness, share of the way from min to max), each in 0 to 1, brightness rising.
            curve: Vec<[f64; 2]> = vec![[0.0, 0.0], [1.0, 1.0]];
            /// Rows from colour to length and material.
            #[serde(skip_serializing_if = "Vec::is_empty")]
            table: Vec<LengthEntry> = Vec::new();
        }
    }
}

impl LengthEntry {
    /// The numbers that a row may have instead of the pile's, with the pile's fields; `None` where it has the pile's.
    pub fn own_numbers(&self) -> [(Field, Option<f64>); 9] {
        let fields = Pile::FIELDS;
        [
            (fields.density, self.density),
            (fields.lean_x, self.lean_x),
            (fields.lean_y, self.lean_y),
            (fields.tilt, self.tilt),
            (fields.top_width, self.top_width),
            (fields.yarn_diameter, self.yarn_diameter),
            (fields.transmission, self.transmission),
            (fields.specular, self.specular),
            (fields.exponent, self.exponent),
        ]
    }

    /// Whether its loops stand in another way than the pile's.
    pub fn has_own_frame(&self) -> bool {
        [self.lean_x, self.lean_y, self.tilt, self.top_width]
            .iter()
            .any(Option::is_some)
    }

    /// The pile with what loops of this row have of their own.
    pub fn of_pile(&self, pile: &Pile) -> Pile {
        Pile {
            density: self.density.unwrap_or(pile.density),
            lean_x: self.lean_x.unwrap_or(pile.lean_x),
            lean_y: self.lean_y.unwrap_or(pile.lean_y),
            tilt: self.tilt.unwrap_or(pile.tilt),
            top_width: self.top_width.unwrap_or(pile.top_width),
            yarn_diameter: self.yarn_diameter.unwrap_or(pile.yarn_diameter),
            transmission: self.transmission.unwrap_or(pile.transmission),
            specular: self.specular.unwrap_or(pile.specular),
            exponent: self.exponent.unwrap_or(pile.exponent),
            kind: self.kind.unwrap_or(pile.kind),
            phase: self.phase.unwrap_or(pile.phase),
            ..pile.clone()
        }
    }
}

impl Length {
    /// Most rows of the table.
    pub const MAX_ROWS: usize = 64;
    /// Most points of the curve.
    pub const MAX_POINTS: usize = 32;

    /// The rows that loops follow: none unless lengths come from the table.
    pub fn rows(&self) -> &[LengthEntry] {
        match self.map {
            LengthMap::Lut => &self.table,
            LengthMap::Constant | LengthMap::Gray => &[],
        }
    }

    /// The longest loop the map can give, before stretch, mm.
    pub fn longest(&self) -> f64 {
        match self.map {
            LengthMap::Constant => self.value,
            LengthMap::Gray => self.max,
            LengthMap::Lut => self.table.iter().fold(
                self.value * f64::from(u8::from(self.table.is_empty())),
                |l, e| l.max(e.length),
            ),
        }
    }

    pub(super) fn push_faults(&self, faults: &mut Vec<Fault>) {
        self.push_range_faults("length", faults);
        let mut fault = |path: String, value: String, allowed: String| {
            faults.push(Fault {
                path,
                value,
                allowed,
            });
        };
        let mut last = f64::NEG_INFINITY;
        for (index, &[x, y]) in self.curve.iter().enumerate() {
            if !((0.0..=1.0).contains(&x) && (0.0..=1.0).contains(&y) && x > last) {
                fault(
                    format!("length.curve[{index}]"),
                    format!("[{x}, {y}]"),
                    "[brightness, share], each 0 to 1, brightness rising".into(),
                );
            }
            last = x;
        }
        if !(2..=Self::MAX_POINTS).contains(&self.curve.len()) {
            fault(
                "length.curve".into(),
                format!("{} points", self.curve.len()),
                format!("2 to {} points", Self::MAX_POINTS),
            );
        }
        if self.table.len() > Self::MAX_ROWS {
            fault(
                "length.table".into(),
                format!("{} rows", self.table.len()),
                format!("at most {} rows", Self::MAX_ROWS),
            );
        }
        if self.map == LengthMap::Lut && self.table.is_empty() {
            fault(
                "length.table".into(),
                "empty".into(),
                "at least one row when length.map is \"lut\"".into(),
            );
        }
        for (index, row) in self.table.iter().enumerate() {
            row.push_range_faults(&format!("length.table[{index}]"), faults);
            for (field, value) in row.own_numbers() {
                if let Some(value) = value.filter(|value| !(field.min..=field.max).contains(value))
                {
                    faults.push(Fault {
                        path: format!("length.table[{index}].{}", field.name),
                        value: value.to_string(),
                        allowed: field.allowed(),
                    });
                }
            }
        }
    }
}

choice! {
    /// How densities blend from one layer of a loop's volume to the next.
    Interpolation {
        /// Layers blend into each other.
        Linear = "linear",
        /// Layers are slabs, as in the paper.
        Nearest = "nearest",
    }
}

choice! {
    /// How a point of the pile scatters light.
    Phase {
        /// Equally to all sides.
        Isotropic = "isotropic",
        /// As a small Lambertian surface that faces the loop's normal; part of the light is let through.
        FrameLambert = "frame Lambert",
        /// As a small Lambertian surface that faces out of the yarn, down the slope of its density; part of the light
        /// is let through.
        GradientLambert = "gradient Lambert",
        /// As a fibre: diffuse about its direction, with a highlight cone (Kajiya and Kay).
        KajiyaKay = "Kajiya-Kay",
    }
}

section! {
    /// The yarn loops and the volume inside them (MODEL.md §4, §5).
    Pile, PileFields {
        numbers {
            /// Width of a loop at its root: leg spacing plus yarn diameter.
            base_width: f64 = 1.9, 0.05..=50.0, "mm";
            /// Width of a loop at its top; smaller than the root gives pointed, larger gives spread loops.
            top_width: f64 = 1.9, 0.05..=50.0, "mm";
            /// Thickness of a loop's volume, front to back: a little more than the yarn.
            thickness: f64 = 0.92, 0.01..=50.0, "mm";
            /// Diameter of the loop's yarn; thicker yarn fills the gaps and looks softer.
            yarn_diameter: f64 = 0.75, 0.02..=20.0, "mm";
            /// How many plies the yarn is twisted from, each a ridge along the loop; how many blades a tuft of grass
            /// has.
            plies: u32 = 2, 1..=8, "";
            /// Turns of the plies in a centimetre of yarn; more turns give a harder, cord-like loop.
            twist_per_cm: f64 = 4.0, 0.0..=40.0, "turns/cm";
            /// How many fibres a yarn shows; fewer give coarse, stringy yarn.
            fibres: u32 = 60, 1..=2000, "";
            /// Share of stray fibres around the yarn: the fuzz of the cloth.
            hairiness: f64 = 0.3, 0.0..=1.0, "";
            /// How many different loops there are, so that neighbours differ.
            variants: u32 = 8, 1..=64, "";
            /// Slabs of the volume across its thickness; the paper uses 5.
            layers: u32 = 16, 1..=64, "";
            /// Voxels of the volume along its width and its length.
            resolution: u32 = 32, 4..=128, "voxels";
            /// How strongly solid yarn absorbs and scatters; more makes harder edges, less makes airy pile.
            density: f64 = 10.0, 0.0..=1_000_000.0, "/mm";
            /// Most light that one scattering may give back; white cotton is about 0.98. Cloth of 0.985 reflects 0.61
            /// at most, of which 64 bounces show 0.6 and 16 bounces 0.48; brighter chart colours are darkened to that.
            max_albedo: f64 = 0.985, 0.0..=1.0, "";
            /// No loop gets longer than this, whatever chart and stretch say.
            max_length: f64 = 20.0, 0.0..=100.0, "mm";
            /// Share of the loop, from its root, over which it fades into the ground weave.
            root_blend: f64 = 0.1, 0.0..=1.0, "";
            /// Lean of all loops along the weft: the nap.
            lean_x: f64 = 0.0, -75.0..=75.0, "°";
            /// Lean of all loops along the warp: the nap.
            lean_y: f64 = 20.0, -75.0..=75.0, "°";
            /// How far the turbulence tips loops over; clumps of loops share a lie.
            tilt: f64 = 63.0, 0.0..=180.0, "°";
            /// How far the turbulence turns loops about their own axis.
            twist: f64 = 80.0, -143.0..=143.0, "°";
            /// Share by which the turbulence lengthens and shortens loops.
            stretch: f64 = 0.15, 0.0..=1.0, "";
            /// Independent random lean of each loop, on top of the turbulence.
            jitter: f64 = 14.0, 0.0..=90.0, "°";
            /// Independent random twist of each loop.
            twist_jitter: f64 = 14.0, 0.0..=143.0, "°";
            /// Independent random share of each loop's length.
            length_jitter: f64 = 0.08, 0.0..=1.0, "";
            /// Share of light that passes through, for frame and gradient Lambert.
            transmission: f64 = 0.5, 0.0..=1.0, "";
            /// Share of light in the highlight, for Kajiya-Kay.
            specular: f64 = 0.1, 0.0..=1.0, "";
            /// Sharpness of the highlight, for Kajiya-Kay.
            exponent: f64 = 12.0, 1.0..=500.0, "";
        }
        others {
            /// What a loop is made of.
            kind: PileKind = PileKind::Terry;
            /// How layers blend.
            interpolation: Interpolation = Interpolation::Linear;
            /// How a point of the pile scatters light.
            phase: Phase = Phase::Isotropic;
        }
    }
}

choice! {
    /// The noise behind the turbulence.
    NoiseKind {
        /// Soft Perlin noise summed over octaves.
        Fbm = "fbm (Perlin)",
        /// Perlin noise folded at zero: ridges and creases.
        Turbulence = "turbulence (folded Perlin)",
        /// Simplex noise: rounder clumps.
        Simplex = "simplex",
        /// Distance to scattered points: cells with steep borders.
        Worley = "Worley (cells)",
    }
}

choice! {
    /// Smoothing of the turbulence over neighbouring cells.
    Filter {
        /// No smoothing.
        None = "none",
        /// Mean of a square of cells.
        Box = "box",
        /// Weighted mean that fades with distance.
        Gaussian = "Gaussian",
    }
}

section! {
    /// The smooth disorder of the loops (MODEL.md §3, the paper's figure 11).
    Turbulence, TurbulenceFields {
        numbers {
            /// Clumps a millimetre; lower gives broader clumps that share a lie.
            frequency: f64 = 0.25, 0.0001..=10.0, "cycles/mm";
            /// How many layers of ever finer disorder are summed.
            octaves: u32 = 2, 1..=10, "";
            /// How much finer each octave is than the one before.
            lacunarity: f64 = 2.0, 1.0..=4.0, "";
            /// How much weaker each octave is than the one before.
            gain: f64 = 0.5, 0.0..=1.0, "";
            /// Another number gives another towel of the same kind.
            seed: u32 = 1, 0..=4_294_967_295.0, "";
            /// Reach of the smoothing.
            filter_radius: f64 = 2.0, 0.0..=64.0, "cells";
        }
        others {
            /// The noise behind it.
            kind: NoiseKind = NoiseKind::Fbm;
            /// Smoothing over neighbouring cells.
            filter: Filter = Filter::None;
        }
    }
}

impl Turbulence {
    /// Whether neighbours are blended, so that every loop depends on others.
    pub fn is_filtered(&self) -> bool {
        self.filter != Filter::None
    }
}

choice! {
    /// Which faces of the cloth are shorn.
    Sheared {
        /// Neither face.
        None = "neither face",
        /// The front is shorn: the usual velour towel, terry on its back.
        Front = "front",
        /// The back is shorn.
        Back = "back",
        /// Both faces are shorn.
        Both = "both faces",
    }
}

section! {
    /// What happens to the loops after weaving: shears, wear and water.
    Finish, FinishFields {
        numbers {
            /// Height over the ground weave's middle at which shears cut; loops that reach it become tufts of even
            /// height, lower ones stay loops.
            shear_height: f64 = 2.0, 0.05..=100.0, "mm";
            /// Share of loops that are pulled out of the cloth; shorn tufts are not.
            pulled: f64 = 0.0, 0.0..=1.0, "";
            /// By how much pulled loops are longer; `pile.max_length` still holds.
            pulled_length: f64 = 4.0, 0.0..=50.0, "mm";
            /// How wet the cloth is, 1 soaked: darker, and its loops thinner and gathered in clumps.
            wetness: f64 = 0.0, 0.0..=1.0, "";
            /// Distance of the clumps that water gathers loops in.
            clump_size: f64 = 4.0, 0.1..=200.0, "mm";
        }
        others {
            /// Which faces of the cloth are shorn.
            sheared: Sheared = Sheared::None;
        }
    }
}

section! {
    /// Which way the front's pile is brushed, by an image.
    Nap, NapFields {
        numbers {
            /// How far loops lean where the map says all the way, on top of `pile.lean_x` and `pile.lean_y`.
            strength: f64 = 45.0, 0.0..=75.0, "°";
        }
        others {
            /// Path of the map, relative to the preset: red is the lean along the weft, green along the warp, 128 none,
            /// as in normal maps of tangent space; it concerns the front alone. No map means no lean but the pile's.
            #[serde(skip_serializing_if = "Option::is_none")]
            image: Option<String> = None;
            /// How the map is laid over the cells: stretched it is smooth between its pixels.
            fit: Fit = Fit::Stretch;
            /// The decoded image; read and written by the program's file layer, never by serde.
            #[serde(skip)]
            pixels: Option<ChartImage> = None;
        }
    }
}

impl Finish {
    /// By how much loops get longer at most, mm.
    pub fn longer_mm(&self) -> f64 {
        if self.pulled > 0.0 {
            self.pulled_length
        } else {
            0.0
        }
    }
}

choice! {
    /// How the height of a ground yarn follows over and under.
    SkeletonHeight {
        /// A round yarn that winds over and under.
        Winding = "winding",
        /// The paper's equation 2: cross-section times sine, flat between and hollow below.
        Paper = "paper's product",
    }
}

choice! {
    /// How a ground yarn scatters light.
    SkeletonShading {
        /// As a matt surface.
        Lambert = "Lambert",
        /// As a matt surface with a highlight.
        Phong = "Phong",
        /// As fibres side by side along the yarn, which hide and shade each other (Poulin and Fournier).
        PoulinFournier = "Poulin-Fournier",
    }
}

section! {
    /// The ground weave's yarns (MODEL.md §7).
    SkeletonDesign, SkeletonFields {
        numbers {
            /// Radius of the warp yarns; thin yarns leave gaps that let light through.
            warp_radius: f64 = 0.22, 0.005..=10.0, "mm";
            /// Radius of the weft yarns; thin yarns leave gaps that let light through.
            weft_radius: f64 = 0.22, 0.005..=10.0, "mm";
            /// How far the yarns rise and sink where they cross; 0 keeps them flat.
            crimp: f64 = 0.22, 0.0..=10.0, "mm";
            /// Share of light in the ground yarns' highlight, for Phong and Poulin-Fournier.
            specular: f64 = 0.1, 0.0..=1.0, "";
            /// Sharpness of the highlight, for Phong and Poulin-Fournier.
            exponent: f64 = 20.0, 1.0..=500.0, "";
            /// Distance of neighbouring fibres in their diameters, for Poulin-Fournier; 1 lets them touch.
            fibre_spacing: f64 = 1.2, 1.0..=100.0, "";
        }
        others {
            /// How the height follows over and under.
            height: SkeletonHeight = SkeletonHeight::Winding;
            /// How a ground yarn scatters light.
            shading: SkeletonShading = SkeletonShading::Lambert;
            /// Colour of the ground yarns: what their surface gives back at one scattering, unlike chart colours, which
            /// are those of finished cloth.
            colour: Colour = Colour([240, 238, 232]);
            /// Whether the ground weave is drawn.
            visible: bool = true;
        }
    }
}

choice! {
    /// How the cloth lies.
    FormKind {
        /// Level.
        Flat = "flat",
        /// In waves.
        Wave = "waves",
        /// Rolled up from its far end.
        Roll = "rolled up",
        /// Over a rail; from there it hangs down in folds.
        Hanging = "over a rail",
        /// Folded back and forth to a stack.
        Stack = "folded stack",
        /// As a net of points that can be dragged pulls it.
        Net = "net of points",
        /// As high as a grey picture is bright.
        Height = "height picture",
    }
}

choice! {
    /// Which way the cloth is bent.
    BentAlong {
        /// Along the warps: its length goes up and down, rolls up or hangs.
        Warp = "along the warps",
        /// Along the wefts: its width does.
        Weft = "along the wefts",
    }
}

section! {
    /// How the cloth lies in space (the paper's future work 3). Cloth is bent, not stretched; a net of points may
    /// stretch it, and a height picture does: it moves each point of level cloth straight up, so that on a slope of
    /// angle a the cloth is 1/cos a times as long as flat, and its loops stand so much farther apart; their lengths
    /// stay.
    Form, FormFields {
        numbers {
            /// Radius of the rail that the cloth hangs over, or of the roll's hollow middle.
            radius: f64 = 30.0, 0.5..=10_000.0, "mm";
            /// Distance from one wave, or one fold of hanging cloth, to the next, measured along the cloth.
            wavelength: f64 = 60.0, 1.0..=100_000.0, "mm";
            /// How steep waves and hanging folds are where they are steepest; 0 has none.
            steepness: f64 = 35.0, 0.0..=80.0, "°";
            /// Share of the cloth that is rolled up.
            rolled: f64 = 0.6, 0.0..=1.0, "";
            /// How many layers a folded stack has.
            layers: u32 = 4, 2..=64, "";
            /// Air between the pile of one layer and the next, in rolls and stacks.
            gap: f64 = 1.0, 0.2..=1000.0, "mm";
            /// How far the cloth lies higher where the height picture is white than where it is black, which stays
            /// where level cloth is; less than 0 lays it lower.
            height: f64 = 20.0, -10_000.0..=10_000.0, "mm";
            /// Distance over which heights of the picture blend: details below it vanish, and so do the steps between
            /// greys.
            smooth: f64 = 6.0, 0.5..=1000.0, "mm";
        }
        others {
            /// How the cloth lies.
            kind: FormKind = FormKind::Flat;
            /// Which way the cloth is bent.
            along: BentAlong = BentAlong::Warp;
            /// Rolls have the front inside; else the back.
            front_inside: bool = false;
            /// Rows of points [x, y, z] in mm, from the near edge to the far one, each from left to right: 4 to 12 rows
            /// of 4 to 12 points that pull a smooth surface, which begins and ends in the outermost.
            #[serde(skip_serializing_if = "Vec::is_empty")]
            net: Vec<Vec<[f64; 3]>> = Vec::new();
            /// Path of the height picture, relative to the preset: PNG, TIFF or PGM (8 or 16 bits), or as a chart, laid
            /// over the whole cloth. Colours count as their grey, what is transparent as black; numbers are taken as
            /// the file has them, whatever its colour profile.
            #[serde(skip_serializing_if = "Option::is_none")]
            image: Option<String> = None;
            /// The decoded picture; read by the program's file layer, never by serde.
            #[serde(skip)]
            pixels: Option<HeightImage> = None;
        }
    }
}

section! {
    /// A sun: parallel light from a disc in the sky.
    Sun, SunFields {
        numbers {
            /// Direction the light comes from, about the cloth's normal: 0° from +x (weft), 90° from +y (warp).
            azimuth: f64 = 130.0, -360.0..=360.0, "°";
            /// Height of the sun over the cloth's plane.
            elevation: f64 = 50.0, -90.0..=90.0, "°";
            /// Light that falls on a plane that faces the sun; π lights white paper to 1.
            irradiance: f64 = 1.5, 0.0..=1000.0, "";
            /// Apparent diameter of the sun; larger gives softer shadows.
            angular_diameter: f64 = 10.0, 0.0..=120.0, "°";
        }
        others {
            /// Colour of the light.
            colour: Colour = Colour::WHITE;
        }
    }
}

section! {
    /// A softbox or a window: a rectangle that faces the cloth's middle and shines on that side. Cameras do not see it.
    AreaLight, AreaLightFields {
        numbers {
            /// Direction of its middle about the cloth's normal: 0° is +x (weft), 90° is +y (warp).
            azimuth: f64 = 130.0, -360.0..=360.0, "°";
            /// Height of its middle over the cloth's plane.
            elevation: f64 = 50.0, -90.0..=90.0, "°";
            /// From the cloth's middle to its own. The whole cloth has to be on the side that it shines on.
            distance: f64 = 1000.0, 10.0..=100_000.0, "mm";
            /// Its level side; larger gives softer shadows.
            width: f64 = 800.0, 1.0..=100_000.0, "mm";
            /// Its other side.
            height: f64 = 800.0, 1.0..=100_000.0, "mm";
            /// Light that falls on a plane that faces it in the cloth's middle; π lights white paper to 1.
            irradiance: f64 = 1.5, 0.0..=1000.0, "";
        }
        others {
            /// Colour of the light.
            colour: Colour = Colour::WHITE;
        }
    }
}

choice! {
    /// Light from all around.
    EnvironmentKind {
        /// As bright from everywhere.
        Constant = "constant",
        /// A sky that changes smoothly from the zenith to the horizon, over the ground's colour.
        Gradient = "sky gradient",
        /// A picture of the surroundings.
        Image = "image",
    }
}

section! {
    /// Light from all around.
    Environment, EnvironmentFields {
        numbers {
            /// Brightness of the surroundings; multiplies colours and images alike.
            radiance: f64 = 0.6, 0.0..=1000.0, "";
            /// Turns the image about the cloth's normal, the way azimuths grow; at 0 its middle lies beyond the far
            /// edge.
            rotation: f64 = 0.0, -360.0..=360.0, "°";
        }
        others {
            /// How it varies with direction.
            kind: EnvironmentKind = EnvironmentKind::Constant;
            /// Its colour, where it is constant.
            colour: Colour = Colour::WHITE;
            /// Colour of the gradient straight above the cloth.
            zenith: Colour = Colour([200, 220, 255]);
            /// Colour of the gradient all around in the cloth's plane.
            horizon: Colour = Colour([255, 250, 240]);
            /// Colour of the gradient below the cloth.
            ground: Colour = Colour([120, 112, 100]);
            /// Path of the image, relative to the preset: equirectangular, .hdr or .exr with linear light, or as a
            /// chart, by its colour profile or as sRGB; up to 8192 × 4096 pixels, averaged down to 1024 × 512.
            #[serde(skip_serializing_if = "Option::is_none")]
            image: Option<String> = None;
            /// The decoded image; read by the program's file layer, never by serde.
            #[serde(skip)]
            pixels: Option<EnvironmentImage> = None;
        }
    }
}

section! {
    /// Lights and background (MODEL.md §8).
    Light, LightFields {
        numbers {}
        others {
            /// Suns; none leaves the environment alone.
            sun: Vec<Sun> = vec![broad_sun()];
            /// Softboxes and windows.
            #[serde(skip_serializing_if = "Vec::is_empty")]
            area: Vec<AreaLight> = Vec::new();
            /// Light from all around.
            environment: Environment = Environment::default();
            /// Colour seen where there is no cloth; it gives no light.
            background: Colour = Colour([247, 246, 240]);
        }
    }
}

/// The sun of a plain towel: broad and soft beside the light from all around, as by a large window.
fn broad_sun() -> Sun {
    Sun {
        azimuth: 120.0,
        elevation: 48.0,
        irradiance: 0.9,
        angular_diameter: 25.0,
        ..Sun::default()
    }
}

impl Light {
    /// Most suns.
    pub const MAX_SUNS: usize = 8;
    /// Most area lights.
    pub const MAX_AREAS: usize = 4;

    pub(super) fn push_faults(&self, faults: &mut Vec<Fault>) {
        for (index, sun) in self.sun.iter().enumerate() {
            sun.push_range_faults(&format!("light.sun[{index}]"), faults);
        }
        if self.sun.len() > Self::MAX_SUNS {
            let allowed = format!("at most {} suns", Self::MAX_SUNS);
            faults.push(Fault {
                path: "light.sun".into(),
                value: format!("{} suns", self.sun.len()),
                allowed,
            });
        }
        for (index, area) in self.area.iter().enumerate() {
            area.push_range_faults(&format!("light.area[{index}]"), faults);
        }
        if self.area.len() > Self::MAX_AREAS {
            faults.push(Fault {
                path: "light.area".into(),
                value: format!("{} area lights", self.area.len()),
                allowed: format!("at most {} area lights", Self::MAX_AREAS),
            });
        }
        let environment = &self.environment;
        environment.push_range_faults("light.environment", faults);
        if environment.kind == EnvironmentKind::Image && environment.image.is_none() {
            faults.push(Fault {
                path: "light.environment.image".into(),
                value: "left out".into(),
                allowed: "the path of an image when light.environment.kind is \"image\"".into(),
            });
        }
    }
}

choice! {
    /// How linear light becomes a displayed colour.
    ToneMap {
        /// Hard clip at white.
        None = "none",
        /// Highlights roll off softly.
        Filmic = "filmic",
    }
}

choice! {
    /// What exposure counts from.
    Metering {
        /// A light meter lies level in the cloth's middle: white cloth shows as white under any light.
        Incident = "white cloth shows white" written "incident",
        /// No meter: radiance 1 shows as white.
        None = "the light as it is" written "none",
    }
}

section! {
    /// A saved view of the cloth.
    CameraDesign, CameraFields {
        numbers {
            /// Direction from the target to the eye about the cloth's normal; −90° looks along the warp from the near
            /// edge.
            azimuth: f64 = -90.0, -360.0..=360.0, "°";
            /// Height of the eye over the cloth's plane; negative looks at the back.
            elevation: f64 = 50.0, -90.0..=90.0, "°";
            /// Distance of the eye from the target.
            distance: f64 = 220.0, 0.01..=1_000_000.0, "mm";
            /// Vertical angle of view, for perspective.
            fov: f64 = 30.0, 0.1..=150.0, "°";
        }
        others {
            /// Name in menus and for --camera.
            name: String = "default".into();
            /// Point looked at, mm.
            target: [f64; 3] = [0.0, 0.0, 0.0];
            /// Height of the picture in mm of cloth; makes the view orthographic.
            #[serde(skip_serializing_if = "Option::is_none")]
            orthographic_height: Option<f64> = None;
        }
    }
}

section! {
    /// Cameras and display.
    View, ViewFields {
        numbers {
            /// Brightness of the displayed picture beside what `view.metering` says, in stops; does not change the
            /// light.
            exposure: f64 = 0.0, -16.0..=16.0, "EV";
        }
        others {
            /// What exposure counts from: a light meter, or the light as it is. A file that gives `view.exposure` alone
            /// is taken to say "none": there was no meter once.
            metering: Metering = Metering::Incident;
            /// How linear light becomes a displayed colour.
            tone_map: ToneMap = ToneMap::None;
            /// The view that the design was saved in, which a file opens with and pictures show unless told otherwise;
            /// left out, that is the first of the saved views.
            #[serde(skip_serializing_if = "Option::is_none")]
            current: Option<CameraDesign> = None;
            /// Saved views.
            cameras: Vec<CameraDesign> = vec![CameraDesign::default()];
        }
    }
}

impl View {
    /// The view that a file opens with.
    pub fn opening(&self) -> Option<&CameraDesign> {
        self.current.as_ref().or(self.cameras.first())
    }

    pub(super) fn push_faults(&self, faults: &mut Vec<Fault>) {
        self.push_range_faults("view", faults);
        let mut fault = |path: String, value: String, allowed: &str| {
            faults.push(Fault {
                path,
                value,
                allowed: allowed.into(),
            });
        };
        if self.cameras.is_empty() {
            fault("view.cameras".into(), "empty".into(), "at least one camera");
        }
        for (path, camera) in self.with_paths() {
            camera.push_place_faults(&path, &mut fault);
        }
        for (index, camera) in self.cameras.iter().enumerate() {
            let path = format!("view.cameras[{index}]");
            if self.cameras[..index]
                .iter()
                .any(|other| other.name == camera.name)
            {
                fault(
                    format!("{path}.name"),
                    format!("{:?}", camera.name),
                    "a name that no other camera has",
                );
            }
        }
        for (path, camera) in self.with_paths() {
            camera.push_range_faults(&path, faults);
        }
    }

    /// All views, each with the path of its fields.
    fn with_paths(&self) -> impl Iterator<Item = (String, &CameraDesign)> {
        let current = self.current.iter().map(|it| ("view.current".into(), it));
        let saved = self.cameras.iter().enumerate();
        current.chain(saved.map(|(index, camera)| (format!("view.cameras[{index}]"), camera)))
    }
}

impl CameraDesign {
    /// Faults of what is no part of its own table of numbers: path, value and what is allowed of each.
    fn push_place_faults(&self, path: &str, fault: &mut impl FnMut(String, String, &str)) {
        let height = self.orthographic_height;
        if let Some(height) = height.filter(|height| !(1e-3..=1e6).contains(height)) {
            fault(
                format!("{path}.orthographic_height"),
                height.to_string(),
                "0.001 to 1000000 mm",
            );
        }
        let axes = self.target.iter().enumerate();
        for (axis, value) in axes.filter(|(_, value)| !(-1e6..=1e6).contains(*value)) {
            fault(
                format!("{path}.target[{axis}]"),
                value.to_string(),
                "-1000000 to 1000000 mm",
            );
        }
    }
}

choice! {
    /// How a ray gathers light from the loops it crosses (MODEL.md §9).
    Method {
        /// One intersection a loop: the paper's method, fastest.
        Single = "single",
        /// One intersection a layer: closer near silhouettes.
        Layered = "layered",
        /// The ray's whole way through each loop, cut at every voxel and layer: the truth as steps get small.
        Exact = "exact",
        /// Kajiya's general form, which the paper's method replaces: six surfaces a loop, marched. A yardstick, not for
        /// the GPU.
        SixFace = "six faces (Kajiya)" written "six-face",
        /// Random free paths through the summed densities: unbiased, and light may bounce.
        Tracked = "tracked",
    }
}

choice! {
    /// Where the random numbers of paths come from (MODEL.md §10). Free paths of `tracked` are independent either way.
    Sampler {
        /// Numbers that cover their range evenly: less noise at the same time.
        Owen = "Owen-scrambled Sobol",
        /// Independent numbers, for comparison.
        Random = "random",
    }
}

section! {
    /// How a final picture is made.
    Quality, QualityFields {
        numbers {
            /// How many times light may scatter; many bounces make white pile glow.
            bounces: u32 = 16, 1..=64, "";
            /// Samples a pixel at which a final picture is done.
            samples: u32 = 256, 1..=1_048_576, "";
            /// Estimated error at which a final picture is done; 0 waits for all samples.
            error: f64 = 0.0, 0.0..=1.0, "";
            /// Longest step through a loop, for the methods exact and six-face: smaller is closer to the truth, and
            /// slower.
            step: f64 = 0.05, 0.0005..=10.0, "mm";
            /// Another number gives other noise.
            seed: u32 = 0, 0..=4_294_967_295.0, "";
        }
        others {
            /// How a ray gathers light.
            method: Method = Method::Tracked;
            /// Where random numbers come from.
            sampler: Sampler = Sampler::Owen;
            /// Pile and ground weave shade each other; without, light reaches every point they scatter it from.
            shadows: bool = true;
        }
    }
}

impl From<Sampler> for crate::sampling::Sampler {
    fn from(sampler: Sampler) -> Self {
        match sampler {
            Sampler::Owen => Self::Owen,
            Sampler::Random => Self::Random,
        }
    }
}
