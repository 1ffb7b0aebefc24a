//! The shape of a design as data: every field's name, kind of value and meaning.
//!
//! Reading a preset (types, unknown fields, suggestions), writing one (order and comments), `--set` and the
//! reference all walk this one description; the `section!` and `choice!` macros make it from the declarations.

use super::pattern::ALLOWED_STITCHES;
use super::{ChartImage, Colour, EnvironmentImage, Field, HeightImage, Pattern};

/// What a field holds.
#[derive(Debug, Clone, PartialEq)]
pub enum Shape {
    /// A number with a range.
    Number(Field),
    /// A number whose range depends on where it stands.
    Real,
    /// True or false.
    Switch,
    /// One of some words: as written in files, and what it means.
    Choice(Vec<(String, &'static str)>),
    /// `#rrggbb`.
    Colour,
    /// Any text.
    Text,
    /// One cell of a stitch pattern.
    Stitch,
    /// A list of equal things; `length` where only one length is allowed.
    List {
        /// What each element is.
        of: Box<Shape>,
        /// The only allowed length.
        length: Option<usize>,
    },
    /// Named fields.
    Table(Vec<Entry>),
    /// A field that may be left out.
    Optional(Box<Shape>),
    /// Not part of a file.
    Hidden,
}

/// One field of a table.
#[derive(Debug, Clone, PartialEq)]
pub struct Entry {
    /// Name, as in a preset file.
    pub name: &'static str,
    /// What it does to the cloth or the picture.
    pub what: &'static str,
    /// What it holds.
    pub shape: Shape,
}

/// A type that knows its shape.
pub trait Shaped {
    /// The shape of all values of this type.
    fn shape() -> Shape;
}

impl Shape {
    /// A table of the entries that are part of a file, in the order they are best read: choices first, as they decide
    /// which numbers matter, then numbers, then what may be left out, then lists.
    pub(crate) fn table(entries: Vec<Entry>) -> Self {
        let rank = |entry: &Entry| match &entry.shape {
            Self::Number(_) | Self::Real => 1,
            Self::Optional(of) if **of == Self::Text => 0,
            Self::Optional(_) => 2,
            Self::List { length: None, .. } => 3,
            _ => 0,
        };
        let mut entries = entries;
        entries.retain(|entry| entry.shape != Self::Hidden);
        entries.sort_by_key(rank);
        Self::Table(entries)
    }

    /// What is allowed, as a sentence fragment.
    pub fn allowed(&self) -> String {
        match self {
            Self::Number(field) => field.allowed(),
            Self::Real => "a number".into(),
            Self::Switch => "true or false".into(),
            Self::Choice(choices) => {
                let names: Vec<String> = choices.iter().map(|(n, _)| format!("{n:?}")).collect();
                match names.split_last() {
                    Some((last, rest)) if !rest.is_empty() => {
                        format!("{} or {last}", rest.join(", "))
                    }
                    _ => names.concat(),
                }
            }
            Self::Colour => "\"#rrggbb\"".into(),
            Self::Text => "text in quotes".into(),
            Self::Stitch => ALLOWED_STITCHES.into(),
            Self::List { of, length } => {
                let count = length.map_or_else(String::new, |n| format!("{n} "));
                format!("a list of {count}{}", of.plural())
            }
            Self::Table(entries) => {
                let names: Vec<&str> = entries.iter().map(|entry| entry.name).collect();
                format!("a table of {}", names.join(", "))
            }
            Self::Optional(of) => of.allowed(),
            Self::Hidden => "nothing".into(),
        }
    }

    /// Several of what is allowed.
    fn plural(&self) -> String {
        match self {
            Self::Real => "numbers".into(),
            Self::Table(_) => "tables".into(),
            Self::List { of, length } => {
                let count = length.map_or_else(String::new, |n| format!("{n} "));
                match **of {
                    Self::Stitch => format!("rows of equal length, each cell {}", of.allowed()),
                    _ => format!("lists of {count}{}", of.plural()),
                }
            }
            other => format!("elements, each {}", other.allowed()),
        }
    }
}

macro_rules! shaped {
    ($($type:ty => $shape:expr,)+) => {
        $(impl Shaped for $type {
            fn shape() -> Shape {
                $shape
            }
        })+
    };
}

shaped! {
    f64 => Shape::Real,
    bool => Shape::Switch,
    String => Shape::Text,
    Colour => Shape::Colour,
    ChartImage => Shape::Hidden,
    EnvironmentImage => Shape::Hidden,
    HeightImage => Shape::Hidden,
    Pattern => {
        let list = |of| Shape::List { of: Box::new(of), length: None };
        list(list(Shape::Stitch))
    },
}

impl<T: Shaped> Shaped for Option<T> {
    fn shape() -> Shape {
        match T::shape() {
            Shape::Hidden => Shape::Hidden,
            shape => Shape::Optional(Box::new(shape)),
        }
    }
}

impl<T: Shaped> Shaped for Vec<T> {
    fn shape() -> Shape {
        Shape::List {
            of: Box::new(T::shape()),
            length: None,
        }
    }
}

impl<T: Shaped, const N: usize> Shaped for [T; N] {
    fn shape() -> Shape {
        Shape::List {
            of: Box::new(T::shape()),
            length: Some(N),
        }
    }
}
