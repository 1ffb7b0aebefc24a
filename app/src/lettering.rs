//! Outlines of letters, for charts: from the fonts of the system and from the program's own, which is everywhere.

use std::collections::BTreeMap;
use std::sync::OnceLock;

use egui::FontDefinitions;
use fontdb::{Database, FaceInfo, ID, Style, Weight};
use harfrust::{ShapeOptions, ShaperData, UnicodeBuffer};
use renderer_core::design::chart_objects::GlyphPath;
use renderer_core::design::{ChartObject, ObjectKind};
use skrifa::instance::{LocationRef, Size};
use skrifa::outline::{DrawSettings, OutlinePen};
use skrifa::{FontRef, GlyphId, MetadataProvider};

/// The program's own font, as objects name it.
pub const OWN_FONT: &str = "Ubuntu Light";
/// Its name among egui's.
const OWN_FONT_DATA: &str = "Ubuntu-Light";

/// Every font by the name that objects know it by.
struct Fonts {
    database: Database,
    by_name: BTreeMap<String, ID>,
}

/// Looked for when letters are first asked for: that takes a moment.
fn fonts() -> &'static Fonts {
    static FONTS: OnceLock<Fonts> = OnceLock::new();
    FONTS.get_or_init(|| {
        let mut database = Database::new();
        // The first of a name counts.
        if let Some(own) = FontDefinitions::default().font_data.get(OWN_FONT_DATA) {
            let bytes: &[u8] = (*own.font).as_ref();
            database.load_font_data(bytes.to_vec());
        }
        database.load_system_fonts();
        let faces = database.faces();
        let mut by_name = BTreeMap::new();
        for face in faces {
            by_name.entry(name_of(face)).or_insert(face.id);
        }
        Fonts { database, by_name }
    })
}

/// What a face is called: its family, and what of its style is not plain.
fn name_of(face: &FaceInfo) -> String {
    let mut name = face
        .families
        .first()
        .map_or(String::new(), |(name, _)| name.clone());
    let weight = match face.weight {
        Weight(..=250) => " Thin",
        Weight(251..=350) => " Light",
        Weight(351..=450) => "",
        Weight(451..=550) => " Medium",
        Weight(551..=650) => " Semibold",
        Weight(651..=750) => " Bold",
        Weight(_) => " Black",
    };
    if !name.ends_with(weight) {
        name.push_str(weight);
    }
    match face.style {
        Style::Normal => {}
        Style::Italic => name.push_str(" Italic"),
        Style::Oblique => name.push_str(" Oblique"),
    }
    name
}

/// Names of all fonts, in alphabetical order.
pub fn font_names() -> impl Iterator<Item = &'static str> {
    fonts().by_name.keys().map(String::as_str)
}

/// Letters as an outline.
#[derive(Debug, Clone, PartialEq)]
pub struct Lettering {
    /// In units of the font, y upwards.
    pub path: GlyphPath,
    /// The font it was taken from.
    pub font: String,
}

impl Lettering {
    /// A text in a font; the program's own where none is named, or where that is not there.
    ///
    /// # Errors
    /// When there is nothing to draw, or the font lacks a character.
    pub fn new(text: &str, font: Option<&str>) -> Result<Self, String> {
        let fonts = fonts();
        let wanted = font.and_then(|name| fonts.by_name.get_key_value(name));
        let found = wanted.or_else(|| fonts.by_name.get_key_value(OWN_FONT));
        let (name, id) = found
            .or_else(|| fonts.by_name.first_key_value())
            .ok_or("there is no font on this machine")?;
        let path = fonts
            .database
            .with_face_data(*id, |data, index| outline(data, index, text, name))
            .ok_or_else(|| format!("the font {name} cannot be read"))??;
        if path.is_empty() {
            return Err("there is nothing to draw in the text".into());
        }
        Ok(Self {
            path,
            font: name.clone(),
        })
    }

    /// How wide the letters are for each unit of their height.
    pub fn proportion(&self) -> f64 {
        self.path.bounds().map_or(1.0, |bounds| {
            let [width, height] = bounds.size();
            width / height.max(f64::MIN_POSITIVE)
        })
    }
}

/// Gives an object that is a text without an outline the one of its font. Returns what is to be said of it, as the end
/// of a sentence about the object.
pub fn outline_text(object: &mut ChartObject) -> Option<String> {
    if object.kind != ObjectKind::Text || object.outline.is_some() {
        return None;
    }
    let text = object.text.as_deref().unwrap_or_default();
    match Lettering::new(text, object.font.as_deref()) {
        Err(why) => Some(format!("draws nothing: {why}")),
        Ok(lettering) => {
            object.outline = Some(lettering.path.write());
            let asked = object.font.replace(lettering.font.clone());
            let asked = asked.filter(|asked| *asked != lettering.font)?;
            Some(format!(
                "is drawn with the font {}: there is no {asked} on this machine",
                lettering.font
            ))
        }
    }
}

/// A text's outline, lines below each other.
fn outline(data: &[u8], index: u32, text: &str, name: &str) -> Result<GlyphPath, String> {
    let font =
        FontRef::from_index(data, index).map_err(|error| format!("the font {name}: {error}"))?;
    let shaper_data = ShaperData::new(&font);
    let shaper = shaper_data.shaper(&font).build();
    let glyphs = font.outline_glyphs();
    let metrics = font.metrics(Size::unscaled(), LocationRef::default());
    let line_height = f64::from(metrics.ascent - metrics.descent + metrics.leading);
    let mut pen = Pen::default();
    for (number, line) in text.lines().enumerate() {
        let mut buffer = UnicodeBuffer::new();
        buffer.push_str(line);
        buffer.guess_segment_properties();
        let shaped = shaper.shape(buffer, ShapeOptions::new());
        let mut at = [0.0, -(number as f64) * line_height];
        for (info, position) in shaped.glyph_infos().iter().zip(shaped.glyph_positions()) {
            if info.glyph_id == 0 {
                let missing = line[info.cluster as usize..].chars().next();
                let missing = missing.unwrap_or_default();
                return Err(format!("the font {name} has no “{missing}”"));
            }
            pen.offset = [
                at[0] + f64::from(position.x_offset),
                at[1] + f64::from(position.y_offset),
            ];
            if let Some(glyph) = glyphs.get(GlyphId::new(info.glyph_id)) {
                let settings = DrawSettings::unhinted(Size::unscaled(), LocationRef::default());
                let drawn = glyph.draw(settings, &mut pen);
                drawn.map_err(|error| format!("the font {name}: {error}"))?;
            }
            at[0] += f64::from(position.x_advance);
            at[1] += f64::from(position.y_advance);
        }
    }
    Ok(pen.path)
}

/// Takes a glyph's outline, moved to where it stands.
#[derive(Default)]
struct Pen {
    path: GlyphPath,
    offset: [f64; 2],
}

impl Pen {
    fn at(&self, x: f32, y: f32) -> [f64; 2] {
        [self.offset[0] + f64::from(x), self.offset[1] + f64::from(y)]
    }
}

impl OutlinePen for Pen {
    fn move_to(&mut self, x: f32, y: f32) {
        let to = self.at(x, y);
        self.path.move_to(to);
    }

    fn line_to(&mut self, x: f32, y: f32) {
        let to = self.at(x, y);
        self.path.line_to(to);
    }

    fn quad_to(&mut self, cx: f32, cy: f32, x: f32, y: f32) {
        let (control, to) = (self.at(cx, cy), self.at(x, y));
        self.path.quadratic_to(control, to);
    }

    fn curve_to(&mut self, cx0: f32, cy0: f32, cx1: f32, cy1: f32, x: f32, y: f32) {
        let (first, second, to) = (self.at(cx0, cy0), self.at(cx1, cy1), self.at(x, y));
        self.path.cubic_to(first, second, to);
    }

    fn close(&mut self) {
        self.path.close();
    }
}
