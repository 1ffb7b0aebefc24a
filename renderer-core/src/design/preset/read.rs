//! Reading a preset: TOML text to a [`Design`], or to all its faults.
//!
//! The text is parsed with positions, then checked against the design's [`Shape`]; entries at fault are reported and
//! taken out, so that one reading finds every fault. What is left goes through serde and [`Design::faults`].

use std::collections::HashSet;
use std::ops::Range;

use serde::Deserialize;
use toml::Spanned;
use toml::de::{DeTable, DeValue, Deserializer};

use super::PresetFault;
use super::faults::{Faults, Found, position};
use super::path::{Step, join, steps, unknown_field};
use super::retired::Retired;
use crate::design::{Colour, Design, Entry, FORMAT, Fault, Metering, Shape, Shaped, Stitch};

/// Reads a preset file's text. The chart image itself is not read.
///
/// # Errors
/// Every fault of the text, in the order of its lines; of very many the first [`MOST_FAULTS`](super::MOST_FAULTS), and
/// how many more there are.
pub fn parse(text: &str) -> Result<Design, Vec<PresetFault>> {
    parse_noting(text).map(|(design, _)| design)
}

/// As [`parse`], with the fields of earlier programs that the file has and that mean nothing any more.
///
/// # Errors
/// As [`parse`].
pub fn parse_noting(text: &str) -> Result<(Design, Vec<PresetFault>), Vec<PresetFault>> {
    match read(text) {
        Ok((design, notes)) => Ok((design, notes.placed(text))),
        Err(faults) => Err(faults.placed(text)),
    }
}

/// Line and column at which the value at `path` is written, or the nearest table around it; (1, 1) in a text that is
/// no TOML.
pub fn position_of(text: &str, path: &str) -> (usize, usize) {
    let (root, _) = DeTable::parse_recoverable(text);
    position(text, locate(root.get_ref(), path))
}

/// The design, and what is to be said of retired fields.
fn read(text: &str) -> Result<(Design, Faults), Faults> {
    let (root, errors) = DeTable::parse_recoverable(text);
    if !errors.is_empty() {
        return Err(errors
            .iter()
            .map(|error| syntax_fault(text, error))
            .collect());
    }
    let (whole, mut root) = (root.span(), root.into_inner());
    check_format(text, &mut root).map_err(Faults::from)?;

    let note = |(retired, at): (&Retired, usize)| Found {
        at,
        message: format!("{} is ignored: {}", retired.path(), retired.now),
        path: retired.path(),
    };
    let retired = Retired::take_out(&mut root);
    let notes: Faults = retired.into_iter().map(note).collect();

    let has_no_meter = exposure_alone(&root);
    let Shape::Table(sections) = Design::shape() else {
        return Ok((Design::default(), notes));
    };
    let mut check = Check::new(text);
    check.table(&sections, &mut root, "");
    let (mut found, places) = (check.faults, check.places);
    let complete = found.is_empty();

    let design = Design::deserialize(Deserializer::from(Spanned::new(whole, root.clone())));
    let mut design = match design {
        Ok(design) => design,
        // The check above lets through only what serde can read, up to conditions on whole values (a ragged pattern).
        Err(error) => {
            found.push(serde_fault(&error, &root));
            return Err(found);
        }
    };
    if has_no_meter {
        design.view.metering = Metering::None;
    }
    let mut faults = design.value_faults();
    if complete {
        // Only then: a relation to a value that could not be read would be one to its default.
        design.push_relation_faults(&mut faults);
    }
    for fault in faults {
        if !parts_of(&fault.path).any(|outer| places.contains(outer)) {
            found.push(Found {
                at: locate(&root, &fault.path),
                message: fault.to_string(),
                path: fault.path,
            });
        }
    }
    if found.is_empty() {
        Ok((design, notes))
    } else {
        Err(found)
    }
}

/// Whether a file gives an exposure and does not say what that counts from, as files did before there was a choice.
fn exposure_alone(root: &DeTable<'_>) -> bool {
    let view = root.get("view").and_then(|view| view.get_ref().as_table());
    view.is_some_and(|view| view.contains_key("exposure") && !view.contains_key("metering"))
}

/// A path and all that it is a part of: `light.sun[0]`, `light.sun`, `light`.
fn parts_of(path: &str) -> impl Iterator<Item = &str> {
    std::iter::successors(Some(path), |path| {
        let end = path.rfind(['.', '['])?;
        Some(&path[..end])
    })
}

fn syntax_fault(text: &str, error: &toml::de::Error) -> Found {
    let at = error.span().map_or(0, |span| span.start);
    let mut message = format!("not TOML: {}", error.message().replace('\n', ", "));
    if has_backslash_before(text, at) {
        message += "; in double quotes a backslash \\ begins an escape: write paths with / or in single quotes";
    }
    Found {
        at,
        path: String::new(),
        message,
    }
}

/// Whether a quoted text of this line has a backslash at a byte, or shortly before it: where an escape begins that is
/// none.
fn has_backslash_before(text: &str, at: usize) -> bool {
    /// Bytes of the longest escape, `\U` and eight digits.
    const LONGEST_ESCAPE: usize = 10;
    let bytes = text.as_bytes();
    let near = &bytes[at.saturating_sub(LONGEST_ESCAPE).min(bytes.len())..bytes.len().min(at + 1)];
    let line = near.rsplit(|byte| *byte == b'\n').next();
    line.is_some_and(|line| line.contains(&b'\\'))
}

fn serde_fault(error: &toml::de::Error, root: &DeTable<'_>) -> Found {
    let at = error.span().map_or(0, |span| span.start);
    let path = path_at(root, at);
    Found {
        at,
        message: format!("{path}: {}", error.message()),
        path,
    }
}

/// Takes `format` out of the file and requires it to be the one this program reads.
fn check_format(text: &str, root: &mut DeTable<'_>) -> Result<(), Found> {
    let fault = |at, message| {
        Err(Found {
            at,
            path: "format".into(),
            message,
        })
    };
    let Some(value) = root.remove("format") else {
        let message = format!(
            "format is missing, required is a line \"format = {FORMAT}\" at the top, the version of preset files"
        );
        return fault(0, message);
    };
    let at = value.span().start;
    let written = snippet(text, value.span());
    match integer(value.get_ref()) {
        Some(version) if version == i64::from(FORMAT) => Ok(()),
        Some(version) if version > i64::from(FORMAT) => fault(
            at,
            format!(
                "format is {written}, newer than this program, which reads format {FORMAT}: a newer Towel Designer \
                 is needed"
            ),
        ),
        _ => fault(at, format!("format is {written}, allowed is {FORMAT}")),
    }
}

/// Compares values with shapes, collects faults, and takes entries at fault out of tables.
pub(super) struct Check<'t> {
    text: &'t str,
    /// What is wrong.
    pub faults: Faults,
    /// Paths of the values at fault.
    places: HashSet<String>,
}

impl<'t> Check<'t> {
    pub fn new(text: &'t str) -> Self {
        Self {
            text,
            faults: Faults::default(),
            places: HashSet::new(),
        }
    }

    fn table(&mut self, entries: &[Entry], table: &mut DeTable<'_>, path: &str) {
        let mut at_fault = Vec::new();
        for (key, value) in table.iter_mut() {
            let name = key.get_ref().as_ref();
            let readable = match entries.iter().find(|entry| entry.name == name) {
                Some(entry) => self.value(&entry.shape, value, &join(path, name)),
                None => {
                    self.faults.add(key.span().start, || {
                        let path_and_name = join(path, name);
                        (path_and_name, unknown_field(path, name, entries))
                    });
                    false
                }
            };
            if !readable {
                at_fault.push(name.to_owned());
            }
        }
        for name in at_fault {
            table.remove(name.as_str());
        }
    }

    /// Whether serde can read the value, apart from what was taken out.
    pub fn value(&mut self, shape: &Shape, value: &mut Spanned<DeValue<'_>>, path: &str) -> bool {
        let span = value.span();
        let fits = match (shape, value.get_mut()) {
            (Shape::Optional(of), _) => return self.value(of, value, path),
            (Shape::Table(entries), DeValue::Table(table)) => {
                self.table(entries, table, path);
                true
            }
            (Shape::List { of, length }, DeValue::Array(array)) => {
                if length.is_none_or(|length| length == array.len()) {
                    // Not `all`: every element is to be checked.
                    return array
                        .iter_mut()
                        .enumerate()
                        .fold(true, |fits, (index, element)| {
                            self.value(of, element, &format!("{path}[{index}]")) && fits
                        });
                }
                false
            }
            (Shape::Number(field), value) => number(value).is_some_and(|number| {
                let whole = !field.integer || matches!(value, DeValue::Integer(_));
                whole && (field.min..=field.max).contains(&number)
            }),
            (Shape::Real, value) => number(value).is_some_and(f64::is_finite),
            (Shape::Switch, DeValue::Boolean(_)) | (Shape::Text, DeValue::String(_)) => true,
            (Shape::Choice(choices), DeValue::String(text)) => {
                choices.iter().any(|(name, _)| name == text)
            }
            (Shape::Colour, DeValue::String(text)) => Colour::try_from(text.to_string()).is_ok(),
            (Shape::Stitch, value) => integer(value)
                .and_then(|value| u8::try_from(value).ok())
                .is_some_and(|value| Stitch::from_value(value).is_some()),
            _ => false,
        };
        if !fits {
            self.places.insert(path.into());
            self.faults.add(span.start, || {
                let fault = Fault {
                    path: path.into(),
                    value: snippet(self.text, span.clone()),
                    allowed: shape.allowed(),
                };
                let message = fault.to_string();
                (fault.path, message)
            });
        }
        fits
    }
}

fn integer(value: &DeValue<'_>) -> Option<i64> {
    let integer = value.as_integer()?;
    i64::from_str_radix(integer.as_str(), integer.radix()).ok()
}

fn number(value: &DeValue<'_>) -> Option<f64> {
    match value {
        DeValue::Float(float) => float.as_str().parse().ok(),
        _ => integer(value).map(|integer| integer as f64),
    }
}

/// A value as the user wrote it, cut to one line of a length that a message can hold.
fn snippet(text: &str, span: Range<usize>) -> String {
    const LONGEST: usize = 60;
    let written = text.get(span).unwrap_or_default();
    let first_line = written.lines().next().unwrap_or_default();
    let cut: String = first_line.chars().take(LONGEST).collect();
    if cut.len() < written.len() {
        cut + " …"
    } else {
        cut
    }
}

/// Where the value at `path` is written; the nearest table around it if it is not.
fn locate(root: &DeTable<'_>, path: &str) -> usize {
    let mut at = 0;
    let mut table = Some(root);
    let mut value: Option<&Spanned<DeValue<'_>>> = None;
    for step in steps(path).unwrap_or_default() {
        value = match step {
            Step::Name(name) => table.and_then(|table| table.get(name)),
            Step::Index(index) => value.and_then(|value| value.get_ref().as_array()?.get(index)),
        };
        let Some(value) = value else { break };
        at = value.span().start;
        table = value.get_ref().as_table();
    }
    at
}

/// Path of the innermost value that byte `at` of the text lies in.
fn path_at(root: &DeTable<'_>, at: usize) -> String {
    fn inside(value: &Spanned<DeValue<'_>>, at: usize) -> bool {
        value.span().contains(&at)
    }
    let mut path = String::new();
    let mut table = Some(root);
    while let Some((key, value)) = table.and_then(|table| {
        // A `[section]` header spans less than its fields, so tables are entered by what they hold.
        table.iter().find(|(_, value)| {
            let holds = |table: &DeTable<'_>| !path_at(table, at).is_empty();
            inside(value, at) || value.get_ref().as_table().is_some_and(holds)
        })
    }) {
        path = join(&path, key.get_ref());
        table = value.get_ref().as_table();
    }
    path
}
