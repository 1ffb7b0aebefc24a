//! Paths to fields, `light.sun[0].elevation`, and the names a mistyped one may have meant.

use super::retired::Retired;
use crate::design::{Entry, Shape};

/// One step of a path.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Step<'a> {
    Name(&'a str),
    Index(usize),
}

/// The steps of a path; `None` if it is not written as one.
pub(super) fn steps(path: &str) -> Option<Vec<Step<'_>>> {
    let mut steps = Vec::new();
    for part in path.split('.') {
        let (name, mut indices) = part.split_at(part.find('[').unwrap_or(part.len()));
        if name.is_empty() {
            return None;
        }
        steps.push(Step::Name(name));
        while !indices.is_empty() {
            let (index, rest) = indices.strip_prefix('[')?.split_once(']')?;
            steps.push(Step::Index(index.parse().ok()?));
            indices = rest;
        }
    }
    Some(steps)
}

/// `path.name`, or `name` at the top.
pub(super) fn join(path: &str, name: &str) -> String {
    if path.is_empty() {
        name.into()
    } else {
        format!("{path}.{name}")
    }
}

/// Says that `name` is no field of the table at `path`, what it may have meant, and which fields there are.
pub(super) fn unknown_field(path: &str, name: &str, entries: &[Entry]) -> String {
    let whole = join(path, name);
    if let Some(retired) = Retired::at(&whole) {
        return format!("{whole} is not a field any more: {}", retired.now);
    }
    let mut message = format!("{whole} is not a field");
    if let Some(near) = nearest(path, name, entries) {
        message += &format!("; did you mean {near}?");
    } else {
        message += ".";
    }
    let names: Vec<&str> = entries.iter().map(|entry| entry.name).collect();
    let place = if path.is_empty() { "a preset" } else { path };
    message + &format!(" Fields of {place} are {}", names.join(", "))
}

/// The path of the field most like `name`: in its own table, or by its exact name in another section.
fn nearest(path: &str, name: &str, entries: &[Entry]) -> Option<String> {
    let here = entries
        .iter()
        .map(|entry| (edits(name, entry.name), entry.name))
        // Up to a third of the letters may differ, and at least two: `tlit`, `sensity`, `warps_per_inch`.
        .filter(|(edits, near)| *edits <= 2.max(near.len() / 3) && *edits < near.len())
        .min_by_key(|(edits, _)| *edits);
    if let Some((_, near)) = here {
        return Some(join(path, near));
    }
    let Shape::Table(sections) = <crate::design::Design as crate::design::Shaped>::shape() else {
        return None;
    };
    sections.iter().find_map(|section| match &section.shape {
        Shape::Table(fields) => fields
            .iter()
            .find(|field| field.name == name)
            .map(|field| join(section.name, field.name)),
        _ => None,
    })
}

/// Letters to insert, delete, replace or swap with their neighbour to get from one word to the other (optimal string
/// alignment distance).
fn edits(a: &str, b: &str) -> usize {
    let (a, b): (Vec<char>, Vec<char>) = (a.chars().collect(), b.chars().collect());
    let mut rows = vec![vec![0; b.len() + 1]; a.len() + 1];
    for i in 0..=a.len() {
        for j in 0..=b.len() {
            rows[i][j] = if i == 0 || j == 0 {
                i + j
            } else {
                let replaced = rows[i - 1][j - 1] + usize::from(a[i - 1] != b[j - 1]);
                let best = replaced.min(rows[i - 1][j] + 1).min(rows[i][j - 1] + 1);
                if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                    best.min(rows[i - 2][j - 2] + 1)
                } else {
                    best
                }
            };
        }
    }
    rows[a.len()][b.len()]
}
