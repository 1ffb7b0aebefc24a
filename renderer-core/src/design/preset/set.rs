//! Changing one field by its path: `--set light.sun[0].elevation=30`.

use serde::Deserialize;
use toml::de::{DeValue, ValueDeserializer};
use toml::{Spanned, Table, Value};

use super::path::{Step, join, steps, unknown_field};
use super::read::Check;
use crate::design::{Design, ImageSlot, Shape, Shaped, read_number};

/// Why a field could not be set.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{path}={value}: {message}")]
pub struct SetError {
    /// The path given.
    pub path: String,
    /// The value given.
    pub value: String,
    /// What is wrong and what is allowed.
    pub message: String,
}

/// The design with the field at `path` set to `value`: a TOML value, text without its quotes, or a number as
/// [`read_number`] reads it, as in `length.value=1/4 in`.
///
/// Relations between fields are not checked here, since the next call may mend them; ask [`Design::faults`] at the end.
/// A changed path of an image leaves no pixels: the caller loads the image.
///
/// # Errors
/// When the path names no field, or the field does not take the value.
pub fn set(design: &Design, path: &str, value: &str) -> Result<Design, SetError> {
    changed(design, path, value).map_err(|message| SetError {
        path: path.into(),
        value: value.into(),
        message,
    })
}

fn changed(design: &Design, path: &str, text: &str) -> Result<Design, String> {
    let steps = steps(path).ok_or("a path is written section.field or section.list[0].field")?;
    let design_shape = Design::shape();
    let shape = shape_at(&design_shape, &steps)?;
    if let Shape::Table(entries) = shape {
        let names: Vec<&str> = entries.iter().map(|entry| entry.name).collect();
        return Err(format!(
            "{path} is a table, name one of its fields: {}",
            names.join(", ")
        ));
    }
    let typed = typed_number(text, shape);
    let number = typed
        .as_ref()
        .and_then(|typed| typed.as_ref().ok())
        .map(f64::to_string);
    let text = number.as_deref().unwrap_or(text);
    let mut value = parsed(text, shape);
    let mut check = Check::new(text);
    if !check.value(shape, &mut value, path) || !check.faults.is_empty() {
        let mut messages = check.faults.messages();
        messages.extend(typed.and_then(Result::err));
        return Err(messages.join("; "));
    }
    let unreadable = |error: toml::de::Error| error.message().to_owned();
    let value = Value::deserialize(ValueDeserializer::from(value)).map_err(unreadable)?;

    let mut tree = Value::Table(Table::try_from(design).map_err(|error| error.to_string())?);
    replace(&mut tree, &steps, value)?;
    let mut new = Design::deserialize(tree).map_err(unreadable)?;
    for slot in ImageSlot::of(design) {
        if slot.path(&new) == slot.path(design) {
            slot.set_pixels(&mut new, slot.pixels(design));
        }
    }
    Ok(new)
}

/// What was typed where a number belongs, if it is none of TOML's but begins as people's do.
fn typed_number(text: &str, shape: &Shape) -> Option<Result<f64, String>> {
    let shape = match shape {
        Shape::Optional(of) => of,
        shape => shape,
    };
    let Shape::Number(field) = shape else {
        return None;
    };
    let begins = text.trim_start_matches(['-', '+', '.', ',', ' ', '(']);
    let is_typed = begins.starts_with(|c: char| c.is_numeric()) && DeValue::parse(text).is_err();
    is_typed.then(|| read_number(text, field.unit, field.integer))
}

/// The value that `text` writes. Where the field holds text, quotes may be left out: `view.tone_map=filmic`.
fn parsed<'a>(text: &'a str, shape: &Shape) -> Spanned<DeValue<'a>> {
    let bare = || Spanned::new(0..text.len(), DeValue::String(text.into()));
    let of = match shape {
        Shape::Optional(of) => of,
        shape => shape,
    };
    let takes_text = matches!(of, Shape::Text | Shape::Colour | Shape::Choice(_));
    match DeValue::parse(text) {
        Ok(value) if value.get_ref().is_str() || !takes_text => value,
        _ => bare(),
    }
}

/// The shape of the field that the steps lead to.
fn shape_at<'s>(root: &'s Shape, steps: &[Step<'_>]) -> Result<&'s Shape, String> {
    let (mut shape, mut path) = (root, String::new());
    for step in steps {
        let inner = match shape {
            Shape::Optional(of) => of,
            shape => shape,
        };
        match (step, inner) {
            (Step::Name(name), Shape::Table(entries)) => {
                let entry = entries.iter().find(|entry| entry.name == *name);
                shape = &entry
                    .ok_or_else(|| unknown_field(&path, name, entries))?
                    .shape;
                path = join(&path, name);
            }
            (Step::Index(index), Shape::List { of, .. }) => {
                shape = of;
                path += &format!("[{index}]");
            }
            (Step::Name(name), Shape::List { .. }) => {
                return Err(format!("{path} is a list, write {path}[0].{name}"));
            }
            (Step::Name(_), _) => return Err(format!("{path} has no fields")),
            (Step::Index(_), _) => return Err(format!("{path} is not a list")),
        }
    }
    Ok(shape)
}

/// Puts `value` where the steps lead.
fn replace(tree: &mut Value, steps: &[Step<'_>], value: Value) -> Result<(), String> {
    let (mut place, mut path) = (tree, String::new());
    for (depth, step) in steps.iter().enumerate() {
        let missing = match step {
            Step::Name(name) => {
                path = join(&path, name);
                // An optional field, or an empty list, is not in the tree until it has a value.
                if let (Value::Table(table), true) = (&mut *place, depth + 1 == steps.len()) {
                    table.insert((*name).into(), value);
                    return Ok(());
                }
                format!("{path} is empty")
            }
            Step::Index(index) => {
                let count = place.as_array().map_or(0, Vec::len);
                let message = format!(
                    "there is no {path}[{index}]: {path} has {count} elements, counted from 0"
                );
                path += &format!("[{index}]");
                message
            }
        };
        place = match step {
            Step::Name(name) => place.get_mut(*name),
            Step::Index(index) => place.get_mut(*index),
        }
        .ok_or(missing)?;
    }
    *place = value;
    Ok(())
}
