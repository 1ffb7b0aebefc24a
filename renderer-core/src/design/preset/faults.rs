//! The faults found in a text: the first of them with their places, and how many there are. A text that is wrong
//! throughout takes no more memory for its messages than one with a hundred faults, and no more time than reading it.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use super::PresetFault;

/// Most faults of one text that are reported; those behind them are only counted.
pub const MOST_FAULTS: usize = 100;

/// A fault and the byte of the text it is at.
#[derive(Debug)]
pub(super) struct Found {
    pub at: usize,
    pub path: String,
    pub message: String,
}

/// Faults in whatever order they are found.
#[derive(Debug, Default)]
pub(super) struct Faults {
    /// Those nearest to the text's beginning; the last of them on top.
    first: BinaryHeap<Placed>,
    /// How many were found.
    count: usize,
}

/// A fault, and which one it was of those found: those at the same place stay in this order.
#[derive(Debug)]
struct Placed(Found, usize);

impl Placed {
    fn order(&self) -> (usize, usize) {
        (self.0.at, self.1)
    }
}

impl Ord for Placed {
    fn cmp(&self, other: &Self) -> Ordering {
        self.order().cmp(&other.order())
    }
}

impl PartialOrd for Placed {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Placed {
    fn eq(&self, other: &Self) -> bool {
        self.order() == other.order()
    }
}

impl Eq for Placed {}

impl Faults {
    /// Adds a fault at a byte; its path and its message are made only if it is reported.
    pub fn add(&mut self, at: usize, describe: impl FnOnce() -> (String, String)) {
        self.count += 1;
        let is_full = self.first.len() == MOST_FAULTS;
        if is_full && self.first.peek().is_some_and(|last| last.0.at <= at) {
            return;
        }
        if is_full {
            self.first.pop();
        }
        let (path, message) = describe();
        self.first
            .push(Placed(Found { at, path, message }, self.count));
    }

    /// Adds a fault.
    pub fn push(&mut self, found: Found) {
        self.add(found.at, || (found.path, found.message));
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// The messages, in the order of the text.
    pub fn messages(self) -> Vec<String> {
        let reported = self.first.into_sorted_vec().into_iter();
        reported.map(|Placed(found, _)| found.message).collect()
    }

    /// The faults with their lines and columns in the text, in its order; at last how many are not among them.
    pub fn placed(self, text: &str) -> Vec<PresetFault> {
        let more = self.count - self.first.len();
        let mut places = Places::new(text);
        let reported = self.first.into_sorted_vec().into_iter();
        let mut faults: Vec<PresetFault> = reported
            .map(|Placed(found, _)| {
                let (line, column) = places.of(found.at);
                PresetFault {
                    line,
                    column,
                    path: found.path,
                    message: found.message,
                }
            })
            .collect();
        if more > 0 {
            faults.push(PresetFault {
                line: places.line,
                column: places.column,
                path: String::new(),
                message: format!("and {more} more faults behind this place"),
            });
        }
        faults
    }
}

impl From<Found> for Faults {
    fn from(found: Found) -> Self {
        Self::from_iter([found])
    }
}

impl FromIterator<Found> for Faults {
    fn from_iter<I: IntoIterator<Item = Found>>(all: I) -> Self {
        let mut faults = Self::default();
        all.into_iter().for_each(|found| faults.push(found));
        faults
    }
}

/// Goes through a text once and tells the line and the column of bytes that do not go back, both from 1; columns count
/// characters.
struct Places<'t> {
    text: &'t str,
    at: usize,
    line: usize,
    column: usize,
}

impl<'t> Places<'t> {
    fn new(text: &'t str) -> Self {
        Self {
            text,
            at: 0,
            line: 1,
            column: 1,
        }
    }

    fn of(&mut self, at: usize) -> (usize, usize) {
        if let Some(passed) = self.text.get(self.at..at) {
            if let Some(newline) = passed.rfind('\n') {
                self.line += passed.matches('\n').count();
                self.column = 1 + passed[newline + 1..].chars().count();
            } else {
                self.column += passed.chars().count();
            }
            self.at = at;
        }
        (self.line, self.column)
    }
}

/// Line and column of a byte.
pub(super) fn position(text: &str, at: usize) -> (usize, usize) {
    Places::new(text).of(at)
}
