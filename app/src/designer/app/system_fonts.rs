//! Writing that the fonts of the program lack: Chinese, Arabic, Hindi and more are drawn with the system's fonts. They
//! are looked for when the first such character is to be shown, and only the fonts that have one are read.

use std::fs;
use std::sync::{Arc, Mutex, PoisonError};

use egui::{Context, FallbackRequest, FontData, FontInsert, FontProvider};
use fontdb::{Database, FaceInfo, ID, Source, Stretch, Style, Weight};

use super::character_map::has_glyph;

/// Largest font that is read, bytes: collections of all Chinese, Japanese and Korean take 20 MB a weight.
const LARGEST_FONT: u64 = 64 << 20;

/// Fonts, once somebody has asked for them.
struct FontsFound {
    find: Box<dyn Fn() -> Database + Send + Sync>,
    faces: Mutex<Option<Faces>>,
}

/// Faces, those that suit beside the window's own font first.
struct Faces {
    database: Database,
    order: Vec<ID>,
}

/// Has a window draw what its own fonts lack with those of the system.
pub fn use_system_fonts(ctx: &Context) {
    use_fonts(ctx, || {
        let mut database = Database::new();
        database.load_system_fonts();
        database
    });
}

/// Has a window draw what its own fonts lack with others, which are found when they are needed.
pub fn use_fonts(ctx: &Context, find: impl Fn() -> Database + Send + Sync + 'static) {
    ctx.add_font_provider(Arc::new(FontsFound {
        find: Box::new(find),
        faces: Mutex::new(None),
    }));
}

impl FontProvider for FontsFound {
    fn font_for(&self, request: &FallbackRequest<'_>) -> Option<FontInsert> {
        let character = request.cluster.chars().next()?;
        // Nobody panics while holding the lock; if somebody did, the fonts would still be whole.
        let mut faces = self.faces.lock().unwrap_or_else(PoisonError::into_inner);
        let faces = faces.get_or_insert_with(|| Faces::new((self.find)()));
        faces.font_with(character)
    }
}

impl Faces {
    fn new(database: Database) -> Self {
        let mut faces: Vec<&FaceInfo> = database.faces().collect();
        faces.sort_by_cached_key(|face| strangeness(face));
        let order = faces.into_iter().map(|face| face.id).collect();
        Self { database, order }
    }

    /// The first face that has a character.
    fn font_with(&self, character: char) -> Option<FontInsert> {
        let has_it = |id: &ID| {
            let has = |data: &[u8], index| has_glyph(data, index, character);
            self.database.with_face_data(*id, has).unwrap_or(false)
        };
        let id = self.order.iter().copied().find(has_it)?;
        let face = self.database.face(id)?;
        let Source::File(path) = &face.source else {
            return None;
        };
        if fs::metadata(path).ok()?.len() > LARGEST_FONT {
            return None;
        }
        let data = FontData::from_blob(Arc::new(fs::read(path).ok()?), face.index);
        let name = format!(
            "{} {} {}",
            face.post_script_name,
            path.display(),
            face.index
        );
        Some(FontInsert::new(&name, data, Vec::new()))
    }
}

/// How little a face suits beside the window's own: its style and weight, whether it is made for something else than
/// reading, and its name, so that the same machine always chooses the same.
fn strangeness(face: &FaceInfo) -> (bool, bool, bool, u16, bool, String) {
    let name = face.families.first().map_or("", |(name, _)| name.as_str());
    let is_sans = name.contains("Sans") || name.contains("Gothic") || name.contains("UI");
    (
        face.style != Style::Normal,
        face.stretch != Stretch::Normal,
        face.monospaced,
        face.weight.0.abs_diff(Weight::NORMAL.0),
        !is_sans,
        name.to_owned(),
    )
}
