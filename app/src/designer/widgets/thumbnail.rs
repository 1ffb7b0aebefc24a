//! Thumbnails made from data, kept as textures for as long as the data stays the same.

use egui::{ColorImage, Response, Sense, TextureHandle, TextureOptions, Ui, Vec2};

/// A texture and the inputs it was made from.
pub struct Thumbnail<K> {
    made: Option<(K, TextureHandle)>,
}

impl<K> Default for Thumbnail<K> {
    fn default() -> Self {
        Self { made: None }
    }
}

impl<K: PartialEq> Thumbnail<K> {
    /// The texture for `key`, made anew by `make` if the key differs from the last.
    pub fn texture(
        &mut self,
        ui: &Ui,
        name: &str,
        key: K,
        make: impl FnOnce(&K) -> ColorImage,
    ) -> TextureHandle {
        if let Some((last, texture)) = &self.made
            && *last == key
        {
            return texture.clone();
        }
        let texture = ui
            .ctx()
            .load_texture(name, make(&key), TextureOptions::NEAREST);
        self.made = Some((key, texture.clone()));
        texture
    }
}

/// Shows a texture at `size` points with a thin outline; `name` is what a screen reader says.
pub fn show_thumbnail(ui: &mut Ui, texture: &TextureHandle, size: Vec2, name: &str) -> Response {
    let image = egui::Image::new((texture.id(), size))
        .fit_to_exact_size(size)
        .alt_text(name)
        .sense(Sense::hover());
    let response = ui.add(image);
    ui.painter().rect_stroke(
        response.rect,
        0.0,
        ui.visuals().widgets.noninteractive.bg_stroke,
        egui::StrokeKind::Outside,
    );
    response
}
