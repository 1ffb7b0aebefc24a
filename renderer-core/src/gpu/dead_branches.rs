//! Shader text without the branches that a pipeline's constants rule out.
//!
//! Drivers find such branches too, but late: first they inline every function at every call, those of the other methods
//! and lights among them, which is most of the time that they take. So `if` statements whose condition is known are cut
//! from the text, with what follows where the branch taken leaves its block. What is cut becomes blanks: lines and
//! columns stay.

use std::collections::HashMap;
use std::ops::Range;

/// The text of a program with these values of its `override` constants, without the branches that are never taken.
pub fn without_dead_branches(text: &str, overrides: &[(&str, f64)]) -> String {
    let tokens = tokens(text);
    let mut pruner = Pruner {
        text,
        known: constants(text, &tokens),
        tokens,
        cut: Vec::new(),
    };
    pruner.known.extend(overrides.iter().copied());
    pruner.block(0);
    let mut bytes = text.as_bytes().to_vec();
    for range in pruner.cut {
        bytes[range]
            .iter_mut()
            .filter(|byte| **byte != b'\n')
            .for_each(|byte| *byte = b' ');
    }
    // Cuts begin and end at tokens, which are ASCII; comments between them are blanked byte by byte.
    String::from_utf8_lossy(&bytes).into_owned()
}

/// Places of words, numbers and signs; comments are none.
fn tokens(text: &str) -> Vec<Range<usize>> {
    let bytes = text.as_bytes();
    let is_word = |byte: u8| byte.is_ascii_alphanumeric() || byte == b'_' || byte == b'.';
    let (mut tokens, mut at) = (Vec::new(), 0);
    while at < bytes.len() {
        let start = at;
        at += if bytes[at..].starts_with(b"//") {
            bytes[at..]
                .iter()
                .take_while(|byte| **byte != b'\n')
                .count()
        } else if is_word(bytes[at]) {
            bytes[at..]
                .iter()
                .take_while(|byte| is_word(**byte))
                .count()
        } else if TWO_SIGNS.iter().any(|signs| bytes[at..].starts_with(signs)) {
            2
        } else {
            1
        };
        if !bytes[start..].starts_with(b"//") && !bytes[start].is_ascii_whitespace() {
            tokens.push(start..at);
        }
    }
    tokens
}

/// Signs that belong together.
const TWO_SIGNS: [&[u8]; 10] = [
    b"==", b"!=", b"<=", b">=", b"&&", b"||", b"->", b"+=", b"-=", b"*=",
];

/// What the module's own constants are worth, where that is written as a number.
fn constants<'a>(text: &'a str, tokens: &[Range<usize>]) -> HashMap<&'a str, f64> {
    let word = |index: usize| tokens.get(index).map_or("", |token| &text[token.clone()]);
    let declared =
        |index: &usize| word(*index) == "const" && word(index + 4) == "=" && word(index + 6) == ";";
    let found = (0..tokens.len()).filter(declared);
    found
        .filter_map(|index| Some((word(index + 1), number(word(index + 5))?)))
        .collect()
}

/// A literal's value.
fn number(word: &str) -> Option<f64> {
    match word {
        "true" => Some(1.0),
        "false" => Some(0.0),
        _ if !word.starts_with(|c: char| c.is_ascii_digit()) => None,
        _ => word.trim_end_matches(['u', 'i', 'f']).parse().ok(),
    }
}

struct Pruner<'a> {
    text: &'a str,
    tokens: Vec<Range<usize>>,
    /// Values of constants, and of names in the blocks around.
    known: HashMap<&'a str, f64>,
    /// Bytes that are to go.
    cut: Vec<Range<usize>>,
}

/// What is known of the end of a block.
#[derive(Clone, Copy, PartialEq)]
enum End {
    /// What follows the block may be come to.
    GoesOn,
    /// It never is.
    Leaves,
}

impl<'a> Pruner<'a> {
    fn word(&self, index: usize) -> &'a str {
        self.tokens
            .get(index)
            .map_or("", |token| &self.text[token.clone()])
    }

    /// Cuts these tokens and what is between them.
    fn cut(&mut self, tokens: Range<usize>) {
        if !tokens.is_empty() {
            self.cut
                .push(self.tokens[tokens.start].start..self.tokens[tokens.end - 1].end);
        }
    }

    /// The token behind the one that closes what `open` opens.
    fn behind(&self, open: usize) -> usize {
        let mut depth = 0;
        for index in open..self.tokens.len() {
            match self.word(index) {
                "{" | "(" | "[" => depth += 1,
                "}" | ")" | "]" => depth -= 1,
                _ => {}
            }
            if depth == 0 {
                return index + 1;
            }
        }
        self.tokens.len()
    }

    /// Goes through a block from its first statement; the end of the block, and whether what is behind it is come to.
    fn block(&mut self, from: usize) -> (usize, End) {
        let outside = self.known.clone();
        let (mut index, mut starts_statement, mut end) = (from, true, End::GoesOn);
        while index < self.tokens.len() && self.word(index) != "}" {
            let word = self.word(index);
            if word == "if" {
                (index, end) = self.branches(index);
            } else if word == "{" {
                let (close, _) = self.block(index + 1);
                index = close + 1;
            } else {
                if starts_statement && matches!(word, "return" | "break" | "continue") {
                    end = End::Leaves;
                }
                if word == "var" {
                    self.known.remove(self.word(index + 1));
                }
                if word == "let" && self.word(index + 2) == "=" {
                    let name = self.word(index + 1);
                    let (value, behind) = Condition { pruner: self }.either(index + 3);
                    // A name that hides another must not have its value.
                    match value.filter(|_| self.word(behind) == ";") {
                        Some(value) => self.known.insert(name, value),
                        None => self.known.remove(name),
                    };
                }
                starts_statement = word == ";";
                index += 1;
                if end == End::Leaves && word == ";" {
                    break;
                }
                continue;
            }
            starts_statement = true;
            if end == End::Leaves {
                break;
            }
        }
        let mut close = index;
        while close < self.tokens.len() && self.word(close) != "}" {
            close = self.behind(close);
        }
        self.cut(index..close);
        self.known = outside;
        (close, end)
    }

    /// Goes through an `if` with all its `else`; the token behind, and whether what follows is come to.
    fn branches(&mut self, from: usize) -> (usize, End) {
        let mut index = from;
        // Whether a condition stands before that may be true, and where the last branch ended that is kept.
        let mut is_first = true;
        loop {
            // At `if`, or at the `{` behind a last `else`; an `else` before it stands at `index - 1`.
            let (condition, open) = if self.word(index) == "if" {
                let (value, _) = Condition { pruner: self }.either(index + 1);
                (
                    value,
                    (index..).find(|at| self.word(*at) == "{").unwrap_or(index),
                )
            } else {
                (Some(1.0), index)
            };
            let behind = self.behind(open);
            let goes_on = self.word(behind) == "else";
            match condition {
                Some(0.0) => {
                    // Gone with the `else` before it; without one, with the `else` behind it.
                    let start = if is_first { index } else { index - 1 };
                    let stop = if is_first && goes_on {
                        behind + 1
                    } else {
                        behind
                    };
                    self.cut(start..stop);
                    if !goes_on {
                        return (behind, End::GoesOn);
                    }
                }
                Some(_) => {
                    // What is left is a block of its own, or a last `else`.
                    self.cut(index..open);
                    let (_, end) = self.block(open + 1);
                    let stop = self.behind_chain(behind);
                    self.cut(behind..stop);
                    return (stop, if is_first { end } else { End::GoesOn });
                }
                None => {
                    self.block(open + 1);
                    if !goes_on {
                        return (behind, End::GoesOn);
                    }
                    is_first = false;
                }
            }
            index = behind + 1;
        }
    }

    /// The token behind all `else` that follow.
    fn behind_chain(&self, mut index: usize) -> usize {
        while self.word(index) == "else" {
            let open = (index..).find(|at| self.word(*at) == "{").unwrap_or(index);
            index = self.behind(open);
        }
        index
    }
}

/// Evaluates conditions: the value, if it is known whatever is not, and the token behind.
struct Condition<'p, 'a> {
    pruner: &'p Pruner<'a>,
}

type Found = (Option<f64>, usize);

impl Condition<'_, '_> {
    fn either(&self, from: usize) -> Found {
        let (mut value, mut at) = self.both(from);
        while self.pruner.word(at) == "||" {
            let (other, behind) = self.both(at + 1);
            value = match (value, other) {
                (Some(0.0), other) => other,
                (value, Some(0.0)) => value,
                (Some(_), _) | (_, Some(_)) => Some(1.0),
                (None, None) => None,
            };
            at = behind;
        }
        (value, at)
    }

    fn both(&self, from: usize) -> Found {
        let (mut value, mut at) = self.compared(from);
        while self.pruner.word(at) == "&&" {
            let (other, behind) = self.compared(at + 1);
            value = match (value, other) {
                (Some(0.0), _) | (_, Some(0.0)) => Some(0.0),
                (Some(_), other) => other,
                (None, _) => None,
            };
            at = behind;
        }
        (value, at)
    }

    fn compared(&self, from: usize) -> Found {
        let (value, at) = self.sum(from);
        let sign = self.pruner.word(at);
        let compare: fn(f64, f64) -> bool = match sign {
            "==" => |a, b| a == b,
            "!=" => |a, b| a != b,
            "<" => |a, b| a < b,
            ">" => |a, b| a > b,
            "<=" => |a, b| a <= b,
            ">=" => |a, b| a >= b,
            _ => return (value, at),
        };
        let (other, behind) = self.sum(at + 1);
        let compared = value
            .zip(other)
            .map(|(a, b)| f64::from(u8::from(compare(a, b))));
        (compared, behind)
    }

    /// Sums and products are not worked out.
    fn sum(&self, from: usize) -> Found {
        let (mut value, mut at) = self.single(from);
        while matches!(
            self.pruner.word(at),
            "+" | "-" | "*" | "/" | "%" | "&" | "|" | "^"
        ) {
            (_, at) = self.single(at + 1);
            value = None;
        }
        (value, at)
    }

    fn single(&self, from: usize) -> Found {
        let word = self.pruner.word(from);
        match word {
            "!" => {
                let (value, behind) = self.single(from + 1);
                (value.map(|value| f64::from(u8::from(value == 0.0))), behind)
            }
            "-" | "&" | "*" | "~" => (None, self.single(from + 1).1),
            "(" => {
                let (value, inside) = self.either(from + 1);
                let behind = self.pruner.behind(from);
                let is_whole = inside + 1 == behind;
                self.suffix(value.filter(|_| is_whole), behind)
            }
            _ => {
                let value = number(word).or_else(|| self.pruner.known.get(word).copied());
                self.suffix(value, from + 1)
            }
        }
    }

    /// Calls, elements and members are not known.
    fn suffix(&self, value: Option<f64>, mut at: usize) -> Found {
        let mut value = value;
        loop {
            let word = self.pruner.word(at);
            if matches!(word, "(" | "[") {
                at = self.pruner.behind(at);
            } else if word.starts_with('.') {
                at += 1;
            } else {
                return (value, at);
            }
            value = None;
        }
    }
}
