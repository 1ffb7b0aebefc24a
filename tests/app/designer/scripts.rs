//! Writing that the window's own fonts lack is drawn with others: which font has a character, and that it is found.

use std::sync::Arc;

use egui::{Color32, Context, FontData, FontDefinitions, FontFamily, FontId, RawInput};
use fontdb::Database;
use towel_designer::designer::{has_glyph, use_fonts};

/// A font of egui's by a part of its name.
fn font(name: &str) -> (String, Arc<FontData>) {
    let fonts = FontDefinitions::default().font_data;
    let mut fonts = fonts.into_iter();
    fonts
        .find(|(full, _)| full.contains(name))
        .expect("a font of egui's")
}

/// Fonts of a window that has no other than one.
fn alone(name: &str) -> FontDefinitions {
    let (name, data) = font(name);
    let mut fonts = FontDefinitions::empty();
    for family in [FontFamily::Proportional, FontFamily::Monospace] {
        fonts.families.insert(family, vec![name.clone()]);
    }
    fonts.font_data.insert(name, data);
    fonts
}

/// Shows a text in a window with these fonts, and tells whether they have all of it.
fn is_drawn(ctx: &Context, text: &str) -> bool {
    let mut is_drawn = false;
    let _ = ctx.run_ui(RawInput::default(), |ui| {
        let font = FontId::new(13.0, FontFamily::Proportional);
        is_drawn = ui.ctx().fonts_mut(|fonts| {
            fonts.layout_no_wrap(text.into(), font.clone(), Color32::WHITE);
            fonts.has_glyphs(&font, text)
        });
    });
    is_drawn
}

#[test]
fn the_character_map_of_a_font_is_read_as_the_window_reads_it() {
    for name in ["Hack", "Ubuntu", "egui-icons"] {
        let ctx = Context::default();
        ctx.set_fonts(alone(name));
        let (_, data) = font(name);
        let mut counts = [0, 0];
        let _ = ctx.run_ui(RawInput::default(), |ui| {
            ui.ctx().fonts_mut(|fonts| {
                let known = fonts.characters(&FontFamily::Proportional).clone();
                for character in
                    (' '..='\u{1ffff}').filter(|c| !c.is_control() && !c.is_whitespace())
                {
                    let has = has_glyph(data.bytes(), 0, character);
                    // The window leaves out characters that are never seen.
                    assert!(
                        has || !known.contains_key(&character),
                        "{name} has no {character:?}"
                    );
                    counts[0] += usize::from(has);
                    counts[1] += usize::from(known.contains_key(&character));
                }
            });
        });
        assert!(
            counts[1] >= 5 && counts[0] < counts[1] + 40,
            "{name}: {counts:?}"
        );
    }
}

#[test]
fn broken_fonts_have_no_characters() {
    let (_, data) = font("Hack");
    assert!(has_glyph(data.bytes(), 0, 'a'));
    for end in (0..data.bytes().len()).step_by(997) {
        // Cut off it may still have it, and does not panic.
        let _ = has_glyph(&data.bytes()[..end], 0, 'a');
    }
    for at in 0..4096 {
        let mut changed = data.bytes()[..data.bytes().len().min(1 << 17)].to_vec();
        changed[at] ^= 0xff;
        let _ = has_glyph(&changed, 0, 'a');
        let _ = has_glyph(&changed, 7, '\u{1f40d}');
    }
    assert!(!has_glyph(b"", 0, 'a'));
}

#[test]
fn what_the_windows_fonts_lack_is_drawn_with_others() {
    let folder = tempfile::tempdir().unwrap();
    let ((_, hack), (_, ubuntu)) = (font("Hack"), font("Ubuntu"));
    std::fs::write(folder.path().join("hack.ttf"), hack.bytes()).unwrap();
    let only_hack_has =
        |c: &char| has_glyph(hack.bytes(), 0, *c) && !has_glyph(ubuntu.bytes(), 0, *c);
    let missing = ('\u{2100}'..'\u{3000}')
        .find(only_hack_has)
        .expect("one that Ubuntu lacks")
        .to_string();
    let window = |fonts: Option<std::path::PathBuf>| {
        let ctx = Context::default();
        ctx.set_fonts(alone("Ubuntu"));
        if let Some(folder) = fonts {
            use_fonts(&ctx, move || {
                let mut database = Database::new();
                database.load_fonts_dir(&folder);
                database
            });
        }
        ctx
    };
    assert!(!is_drawn(&window(None), &missing));
    let with_fonts = window(Some(folder.path().into()));
    assert!(is_drawn(&with_fonts, "abc") && is_drawn(&with_fonts, &missing));
    // What no font has is asked for once and stays a box.
    assert!(!is_drawn(&with_fonts, "\u{6bdb}"));
    // A folder without fonts does no harm.
    assert!(!is_drawn(
        &window(Some(folder.path().join("none"))),
        &missing
    ));
}
