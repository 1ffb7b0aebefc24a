//! What the program knows about every number a user can edit: unit, range, default and what it does to the cloth.
//!
//! The `section!` macro declares a part of a [`Design`](super::Design) once; serde, `Default`, validation, the
//! sliders of the designer, preset files and the reference in presets/README.md all read that one declaration.

use std::fmt;

/// One editable number of a design.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Field {
    /// Name within its section, as in a preset file.
    pub name: &'static str,
    /// Unit as shown behind the number, e.g. `mm`; empty for plain numbers.
    pub unit: &'static str,
    /// Value of a design that does not mention the field.
    pub default: f64,
    /// Smallest allowed value.
    pub min: f64,
    /// Largest allowed value.
    pub max: f64,
    /// True where only whole numbers are allowed.
    pub integer: bool,
    /// What the number does to the cloth, in words for a designer.
    pub what: &'static str,
}

/// A value that a design may not have.
#[derive(Debug, Clone, PartialEq)]
pub struct Fault {
    /// Where, as a preset path: `pile.layers`, `weave.pattern[2][5]`, `light.sun[0].elevation`.
    pub path: String,
    /// The value found, as a user would write it.
    pub value: String,
    /// What is allowed there.
    pub allowed: String,
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} is {}, allowed is {}",
            self.path, self.value, self.allowed
        )
    }
}

/// Something about a design that is allowed but probably not meant.
#[derive(Debug, Clone, PartialEq)]
pub struct Warning {
    /// The part of the design it is about, as a preset path: `turbulence.frequency`, `pile`.
    pub path: String,
    /// A sentence for the designer.
    pub text: String,
}

impl Warning {
    /// A warning about the part at `path`.
    pub fn new(path: &str, text: impl Into<String>) -> Self {
        Self {
            path: path.into(),
            text: text.into(),
        }
    }
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

/// A part of a design that is made of numbers with ranges (and other fields that serde alone can check).
pub trait Numbers {
    /// Every number with its field, in file order.
    fn numbers(&self) -> Vec<(&'static Field, f64)>;

    /// Appends a fault for every number outside its range; NaN and infinity are outside every range.
    fn push_range_faults(&self, path: &str, faults: &mut Vec<Fault>) {
        for (field, value) in self.numbers() {
            if !(value >= field.min && value <= field.max) {
                faults.push(Fault {
                    path: format!("{path}.{}", field.name),
                    value: value.to_string(),
                    allowed: field.allowed(),
                });
            }
        }
    }
}

impl Field {
    /// The allowed range as a sentence fragment: `0.05 to 50 mm`.
    pub fn allowed(&self) -> String {
        let kind = if self.integer {
            "a whole number from "
        } else {
            ""
        };
        let space = if self.unit.is_empty() { "" } else { " " };
        format!("{kind}{} to {}{space}{}", self.min, self.max, self.unit)
    }
}

/// True for the number types that hold whole numbers; lets `section!` fill [`Field::integer`].
pub trait IsInteger {
    /// Whether the type holds whole numbers only.
    const INTEGER: bool;
}
impl IsInteger for f64 {
    const INTEGER: bool = false;
}
impl IsInteger for u32 {
    const INTEGER: bool = true;
}
impl IsInteger for i32 {
    const INTEGER: bool = true;
}

/// Declares a section: its struct, its defaults, its field table and its range check.
///
/// `numbers` have a range and a unit and their doc comment is the tooltip; `others` are whatever serde can read.
macro_rules! section {
    (
        $(#[$meta:meta])*
        $name:ident, $fields:ident {
            numbers {
                $(
                    $(#[doc = $doc:literal])+
                    $number:ident: $type:ty = $default:expr, $min:literal ..= $max:literal, $unit:literal;
                )*
            }
            others {
                $(
                    $(#[doc = $other_doc:literal])+ $(#[serde($($serde:tt)+)])?
                    $other:ident: $other_type:ty = $other_default:expr;
                )*
            }
        }
    ) => {
        $(#[$meta])*
        #[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
        #[serde(default, deny_unknown_fields)]
        pub struct $name {
            $( $(#[doc = $doc])+ pub $number: $type, )*
            $( $(#[doc = $other_doc])+ $(#[serde($($serde)+)])? pub $other: $other_type, )*
        }

        impl Default for $name {
            fn default() -> Self {
                Self { $( $number: $default, )* $( $other: $other_default, )* }
            }
        }

        #[doc = concat!("The field table of [`", stringify!($name), "`].")]
        #[derive(Debug)]
        pub struct $fields {
            $(
                #[doc = concat!("Range, unit and meaning of `", stringify!($number), "`.")]
                pub $number: $crate::design::Field,
            )*
        }

        impl $name {
            /// Range, unit, default and meaning of every number of this section.
            pub const FIELDS: $fields = $fields {
                $( $number: $crate::design::Field {
                    name: stringify!($number),
                    unit: $unit,
                    default: $default as f64,
                    min: $min as f64,
                    max: $max as f64,
                    integer: <$type as $crate::design::fields::IsInteger>::INTEGER,
                    what: concat!($($doc),+).trim_ascii(),
                }, )*
            };
        }

        impl $crate::design::Numbers for $name {
            fn numbers(&self) -> Vec<(&'static $crate::design::Field, f64)> {
                vec![ $( (&Self::FIELDS.$number, self.$number as f64), )* ]
            }
        }

        impl $crate::design::Shaped for $name {
            fn shape() -> $crate::design::Shape {
                $crate::design::Shape::table(vec![
                    $( $crate::design::Entry {
                        name: stringify!($number),
                        what: Self::FIELDS.$number.what,
                        shape: $crate::design::Shape::Number(Self::FIELDS.$number),
                    }, )*
                    $( $crate::design::Entry {
                        name: stringify!($other),
                        what: concat!($($other_doc),+).trim_ascii(),
                        shape: <$other_type as $crate::design::Shaped>::shape(),
                    }, )*
                ])
            }
        }
    };
}
pub(crate) use section;
