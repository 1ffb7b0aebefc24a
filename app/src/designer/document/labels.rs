//! What a user reads for the names that fields have in files.

/// What a user reads for the name of a field in a file: `yarn_diameter` is "Yarn diameter", and names that only those
/// who write files know have plainer words.
pub fn label_of(field: &str) -> String {
    let plain = match field {
        "fov" => "Angle of view",
        "min" => "Shortest",
        "max" => "Longest",
        "value" => "Length",
        "base_width" => "Root width",
        "root_blend" => "Root fade",
        "variants" => "Different loops",
        "lean_x" => "Lean sideways",
        "lean_y" => "Lean lengthwise",
        "jitter" => "Lean jitter",
        "max_albedo" => "Whiteness",
        "albedo_scale" => "Brightness",
        "frequency" => "Clumps per mm",
        "lacunarity" => "Octave fineness",
        "gain" => "Octave strength",
        "irradiance" => "Strength",
        "radiance" => "Brightness",
        _ => "",
    };
    if !plain.is_empty() {
        return plain.into();
    }
    let mut label = field.replace('_', " ");
    if let Some(first) = label.get_mut(0..1) {
        first.make_ascii_uppercase();
    }
    label
}
