//! Tables as CSV (RFC 4180), units in the header.

/// What a part of the bench found, beside the names of the presets.
pub type OfPresets<'a, T> = [(&'a str, &'a T)];

/// A whole file: the header, then its rows.
pub fn table(header: &str, rows: impl IntoIterator<Item = String>) -> String {
    let lines: Vec<String> = [header.to_owned()].into_iter().chain(rows).collect();
    lines.join("\r\n") + "\r\n"
}

/// A number, or nothing.
pub fn optional(value: Option<f64>) -> String {
    value.map_or_else(String::new, number)
}

/// Six significant digits: more than any of this is known to.
pub fn number(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    let digits = 5 - value.abs().log10().floor() as i32;
    let scale = 10_f64.powi(digits);
    // Shortest text of the rounded value.
    ((value * scale).round() / scale).to_string()
}

/// Text, in quotes where it needs them.
pub fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_owned()
    }
}
