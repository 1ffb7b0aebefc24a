//! Writing a preset: every field of a design, aligned, each with a comment that says unit, range and meaning.

use std::fmt::Write;

use toml::{Table, Value};

use crate::design::{Design, Entry, FORMAT, Shape, Shaped};

/// Assignments longer than this have their comment on the line above.
const LONGEST_ASSIGNMENT: usize = 48;

/// The text of a preset file, which [`parse`](super::parse) reads back as an equal design (without chart pixels).
///
/// # Errors
/// None for any design that can be built; serde's signature leaves no other way to say so.
pub fn write(design: &Design) -> Result<String, toml::ser::Error> {
    let values = Table::try_from(design)?;
    let mut text = format!(
        "# Towel Designer preset. Lengths in mm, angles in degrees, colours \"#rrggbb\" (sRGB).\nformat = {FORMAT}\n"
    );
    if let Shape::Table(sections) = Design::shape() {
        for section in &sections {
            if let (Shape::Table(entries), Some(Value::Table(values))) =
                (&section.shape, values.get(section.name))
            {
                let _ = write!(text, "\n# {}\n[{}]\n", section.what, section.name);
                fields(&mut text, section.name, entries, values, true);
            }
        }
    }
    Ok(text)
}

/// The fields of one table, those that are tables themselves behind the others.
fn fields(text: &mut String, path: &str, entries: &[Entry], values: &Table, comments: bool) {
    let mut lines = Vec::new();
    for entry in entries {
        match values.get(entry.name) {
            None => lines.push(FieldLine::left_out(entry)),
            Some(value) if is_table(&entry.shape, value) => {}
            Some(value) => lines.push(FieldLine::assignment(entry, value)),
        }
    }
    let name_width = widest(lines.iter().map(|line| &line.name));
    let mut assignments: Vec<(String, &str)> = Vec::new();
    for line in &lines {
        let assignment = format!("{:name_width$} = {}", line.name, line.value);
        assignments.push((assignment.trim_end().to_owned(), &line.comment));
    }
    let short = |assignment: &String| {
        assignment.chars().count() <= LONGEST_ASSIGNMENT && !assignment.contains('\n')
    };
    let width = widest(assignments.iter().map(|(a, _)| a).filter(|a| short(a)));
    for (assignment, comment) in &assignments {
        let _ = match (comments, short(assignment)) {
            (false, _) => writeln!(text, "{assignment}"),
            (true, true) => writeln!(text, "{assignment:width$}  # {comment}"),
            (true, false) => writeln!(text, "# {comment}\n{assignment}"),
        };
    }
    for entry in entries {
        let path = format!("{path}.{}", entry.name);
        match (required(&entry.shape), values.get(entry.name)) {
            (Shape::Table(entries), Some(Value::Table(values))) => {
                let _ = write!(text, "\n# {}\n[{path}]\n", entry.what);
                fields(text, &path, entries, values, true);
            }
            (Shape::List { of, .. }, Some(Value::Array(elements))) => {
                if let Shape::Table(entries) = &**of {
                    for (index, element) in elements.iter().enumerate() {
                        let heading = if index == 0 { entry.what } else { "" };
                        tables_element(text, &path, heading, entries, element);
                    }
                }
            }
            _ => {}
        }
    }
}

/// One `[[list]]` element; only the first says what its fields are.
fn tables_element(text: &mut String, path: &str, heading: &str, entries: &[Entry], value: &Value) {
    if let Value::Table(values) = value {
        let first = !heading.is_empty();
        text.push('\n');
        if first {
            let _ = writeln!(text, "# {heading}");
        }
        let _ = writeln!(text, "[[{path}]]");
        fields(text, path, entries, values, first);
    }
}

/// The shape of a value that is there.
fn required(shape: &Shape) -> &Shape {
    match shape {
        Shape::Optional(of) => of,
        shape => shape,
    }
}

/// Whether a value is written under its own heading.
fn is_table(shape: &Shape, value: &Value) -> bool {
    match (required(shape), value) {
        (Shape::Table(_), _) => true,
        (Shape::List { of, .. }, Value::Array(elements)) => {
            matches!(**of, Shape::Table(_)) && !elements.is_empty()
        }
        _ => false,
    }
}

/// One line of a table before it is aligned.
struct FieldLine {
    name: String,
    value: String,
    comment: String,
}

impl FieldLine {
    fn assignment(entry: &Entry, value: &Value) -> Self {
        let value = match value {
            Value::Array(rows) if is_grid(&entry.shape) => {
                let rows: Vec<String> = rows.iter().map(|row| format!("    {row},\n")).collect();
                format!("[\n{}]", rows.concat())
            }
            value => value.to_string(),
        };
        Self {
            name: entry.name.into(),
            value,
            comment: comment(entry),
        }
    }

    /// A field without a value, as a comment that shows that it exists.
    fn left_out(entry: &Entry) -> Self {
        Self {
            name: format!("# {}", entry.name),
            value: String::new(),
            comment: comment(entry),
        }
    }
}

/// Whether the value is a stitch pattern, which reads best with a row on a line.
fn is_grid(shape: &Shape) -> bool {
    matches!(shape, Shape::List { of: rows, .. }
        if matches!(&**rows, Shape::List { of: cells, .. } if **cells == Shape::Stitch))
}

/// `mm, 0.05 to 50: what it does`.
fn comment(entry: &Entry) -> String {
    let allowed = match &entry.shape {
        Shape::Number(field) if field.unit.is_empty() => format!("{} to {}", field.min, field.max),
        Shape::Number(field) => format!("{}, {} to {}", field.unit, field.min, field.max),
        shape @ (Shape::Choice(_) | Shape::Colour) => shape.allowed(),
        _ => return entry.what.into(),
    };
    format!("{allowed}: {}", entry.what)
}

fn widest<'a>(texts: impl Iterator<Item = &'a String>) -> usize {
    texts.map(|text| text.chars().count()).max().unwrap_or(0)
}
