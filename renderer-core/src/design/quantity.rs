//! Numbers as people type them: with a decimal point or comma, grouped, as fractions, in other units of the same kind.
//!
//! What has one meaning is read, what has two or none is refused with a reason: `10,5` is ten and a half, `1.234,5` is
//! a thousand and more, `1,234` may be either where parts are allowed. A number without a unit is in the field's own.

use std::f64::consts::PI;

use super::arithmetic::{Term, has_operator, read_sum};

/// Units that measure the same thing, each by its names and its size in one of them.
struct Kind {
    /// What they measure, in the plural.
    what: &'static str,
    units: &'static [(&'static [&'static str], f64)],
}

/// Millimetres of an inch.
const INCH: f64 = 25.4;

const KINDS: &[Kind] = &[
    Kind {
        what: "lengths",
        units: &[
            (&["mm", "millimetre", "millimetres"], 1.0),
            (&["cm", "centimetre", "centimetres"], 10.0),
            (&["m", "metre", "metres"], 1000.0),
            (&["µm", "μm", "um"], 1e-3),
            (&["in", "inch", "inches", "\"", "″", "”", "''"], INCH),
            (&["ft", "foot", "feet", "'", "′", "’"], 12.0 * INCH),
        ],
    },
    Kind {
        what: "angles",
        units: &[
            (&["°", "º", "deg", "degree", "degrees"], 1.0),
            (&["rad", "radian", "radians"], 180.0 / PI),
            (&["turn", "turns"], 360.0),
        ],
    },
    Kind {
        what: "densities",
        units: &[
            (&["/cm", "per cm", "ends/cm", "picks/cm"], 1.0),
            (&["/mm", "per mm"], 10.0),
            (&["/m", "per m"], 0.01),
            (
                &["/in", "per in", "/inch", "per inch", "/\"", "epi", "ppi"],
                10.0 / INCH,
            ),
        ],
    },
    Kind {
        what: "twists",
        units: &[
            (&["turns/cm", "/cm"], 1.0),
            (&["turns/m", "/m", "tpm"], 0.01),
            (&["turns/in", "turns/inch", "/in", "tpi"], 10.0 / INCH),
        ],
    },
    Kind {
        what: "frequencies",
        units: &[(&["cycles/mm", "/mm"], 1.0), (&["cycles/cm", "/cm"], 0.1)],
    },
    Kind {
        what: "resolutions",
        units: &[
            (&["dpi", "ppi", "/in", "px/in"], 1.0),
            (&["dpcm", "/cm", "px/cm"], INCH / 10.0),
            (&["/mm", "px/mm"], INCH),
        ],
    },
    Kind {
        what: "times",
        units: &[
            (&["s", "sec", "second", "seconds"], 1.0),
            (&["min", "minute", "minutes"], 60.0),
            (&["h", "hour", "hours"], 3600.0),
        ],
    },
    Kind {
        what: "shares",
        units: &[(&[""], 1.0), (&["%", "percent", "per cent"], 0.01)],
    },
];

/// Reads what was typed where a number in `unit` is expected, a whole one if `integer`; what it is in that unit. Sums
/// and products of numbers are read too: `140 cm / 3`.
///
/// # Errors
/// Why it cannot be read, as a sentence.
pub fn read_number(text: &str, unit: &str, integer: bool) -> Result<f64, String> {
    let plain: String = text.chars().map(plain).collect();
    let typed = plain.trim();
    if typed.is_empty() {
        return Err("A number is missing.".into());
    }
    let refused = |why: String| format!("“{}” {why}.", text.trim());
    let single = read_one(typed, unit, integer).map(|term| term.value);
    let value = match single {
        Err(_) if has_operator(typed) => read_sum(
            typed,
            &|operand| read_one(operand, unit, integer),
            &|name| in_unit(name, unit),
        ),
        single => single,
    };
    let value = value.map_err(&refused)?;
    if !value.is_finite() {
        return Err(refused("is too large for a number".into()));
    }
    if !integer {
        return Ok(value);
    }
    // What units leave of rounding is no part.
    let whole = value.round();
    if (value - whole).abs() > 1e-9 * whole.abs().max(1.0) {
        return Err(refused("is no whole number".into()));
    }
    Ok(whole)
}

/// Reads one number with its unit, or several as in `5' 6"`; what is wrong, as the end of a sentence about it.
fn read_one(typed: &str, unit: &str, integer: bool) -> Result<Term, String> {
    let mut rest = typed;
    let sign = match rest.strip_prefix(['-', '+']) {
        Some(unsigned) if rest.starts_with('-') => {
            rest = unsigned.trim_start();
            -1.0
        }
        Some(unsigned) => {
            rest = unsigned.trim_start();
            1.0
        }
        None => 1.0,
    };
    let mut sum = 0.0;
    let mut parts = 0;
    let mut has_unit = false;
    while !rest.is_empty() {
        let (number, behind) = leading_number(rest, integer)?;
        let end = behind.find(|c: char| c.is_ascii_digit());
        let (name, next) = behind.split_at(end.unwrap_or(behind.len()));
        let name = name.trim();
        if name.is_empty() && (parts > 0 || !next.is_empty()) {
            return Err("is more than one number".into());
        }
        has_unit |= !name.is_empty();
        let factor = if name.is_empty() {
            1.0
        } else {
            in_unit(name, unit)?
        };
        sum += number * factor;
        parts += 1;
        rest = next;
    }
    Ok(Term {
        value: sign * sum,
        has_unit,
    })
}

/// How many of a field's unit one of the named is.
fn in_unit(name: &str, unit: &str) -> Result<f64, String> {
    let lower = name.to_lowercase();
    if lower == unit.to_lowercase() || !unit.is_empty() && lower == unit.trim_end_matches('s') {
        return Ok(1.0);
    }
    let size = |kind: &Kind, name: &str| {
        let mut units = kind.units.iter();
        units
            .find(|(names, _)| names.contains(&name))
            .map(|(_, size)| *size)
    };
    let kinds = KINDS
        .iter()
        .filter_map(|kind| Some((kind, size(kind, unit)?)));
    // A field's unit is the first name of its kind; others of the same name measure something else.
    let own = kinds.min_by_key(|(kind, _)| {
        kind.units
            .iter()
            .position(|(names, _)| names[0] == unit)
            .is_none()
    });
    let Some((kind, own)) = own else {
        return Err(match unit {
            "" => format!("has a unit, {name}, where a plain number is expected"),
            unit => format!("has the unit {name}; here it is {unit}"),
        });
    };
    size(kind, &lower).map(|size| size / own).ok_or_else(|| {
        let names: Vec<&str> = kind
            .units
            .iter()
            .map(|(names, _)| names[0])
            .filter(|name| !name.is_empty())
            .collect();
        format!(
            "has the unit {name}; units of {} are {}",
            kind.what,
            names.join(", ")
        )
    })
}

/// The number that a text begins with, and what follows it.
fn leading_number(text: &str, integer: bool) -> Result<(f64, &str), String> {
    let no_number = || "is no number".to_owned();
    let digits = |text: &str| text.chars().take_while(char::is_ascii_digit).count();
    // Digits with what may stand between them.
    let mut end = text
        .char_indices()
        .find(|(at, c)| {
            let is_mark = matches!(c, '.' | ',')
                || matches!(c, '\'' | ' ') && digits(&text[at + 1..]) == 3 && {
                    let behind = text[at + 4..].trim_start();
                    !behind.starts_with('/')
                        && *at > 0
                        && text[..*at].ends_with(|c: char| c.is_ascii_digit())
                };
            !(c.is_ascii_digit() || is_mark)
        })
        .map_or(text.len(), |(at, _)| at);
    let token = &text[..end];
    let mut value = if token.contains(|c: char| c.is_ascii_digit()) {
        grouped(token, integer)?
    } else if token.is_empty() && text.starts_with(is_vulgar) {
        0.0
    } else {
        return Err(no_number());
    };
    let mut rest = &text[end..];
    // 2.5e-3
    if let Some(power) = rest.strip_prefix(['e', 'E']) {
        let signed = power.strip_prefix(['-', '+']).unwrap_or(power);
        let count = digits(signed);
        if count > 0 {
            let length = power.len() - signed.len() + count;
            let exponent: i32 = power[..length].parse().map_err(|_| no_number())?;
            // Through text: a power of ten times a number would round twice.
            value = format!("{value}e{exponent}")
                .parse()
                .map_err(|_| no_number())?;
            end += 1 + length;
            rest = &text[end..];
        }
    }
    if let Some(vulgar) = rest.trim_start().chars().next().filter(|c| is_vulgar(*c)) {
        let rest = &rest.trim_start()[vulgar.len_utf8()..];
        return Ok((value + vulgar_value(vulgar), rest));
    }
    // 3/4, or 1 3/4.
    let after = rest.trim_start();
    if let Some(below) = after
        .strip_prefix('/')
        .map(str::trim_start)
        .filter(|below| digits(below) > 0)
    {
        return fraction(value, below);
    }
    let above = digits(after);
    if above > 0 && rest.starts_with(' ') {
        let below = after[above..]
            .trim_start()
            .strip_prefix('/')
            .map(str::trim_start);
        if let Some(below) = below.filter(|below| digits(below) > 0) {
            let above: f64 = after[..above].parse().map_err(|_| no_number())?;
            let (part, rest) = fraction(above, below)?;
            return Ok((value + part, rest));
        }
    }
    Ok((value, rest))
}

/// A number over the whole number that a text begins with.
fn fraction(above: f64, text: &str) -> Result<(f64, &str), String> {
    let count = text.chars().take_while(char::is_ascii_digit).count();
    let below: f64 = text[..count]
        .parse()
        .map_err(|_| "is no number".to_owned())?;
    if below == 0.0 {
        return Err("divides by 0".into());
    }
    Ok((above / below, &text[count..]))
}

/// Digits with points, commas, apostrophes and spaces between them.
fn grouped(token: &str, integer: bool) -> Result<f64, String> {
    let token = token.replace(['\'', ' '], "");
    let count = |mark: char| token.matches(mark).count();
    let last = token.rfind(['.', ',']);
    let mark = last.and_then(|at| token[at..].chars().next());
    let (Some(at), Some(mark)) = (last, mark) else {
        return number(&token);
    };
    let other = if mark == '.' { ',' } else { '.' };
    let (head, tail) = (&token[..at], &token[at + 1..]);
    if count(other) > 0 {
        // 1.234,5: the last one is the decimal mark, and stands once.
        if count(mark) > 1 || !is_in_groups(head, other) {
            return Err("is no number".into());
        }
        return number(&format!("{}.{tail}", head.replace(other, "")));
    }
    if count(mark) > 1 {
        if !is_in_groups(&token, mark) {
            return Err("is no number".into());
        }
        return number(&token.replace(mark, ""));
    }
    let may_be_group = is_in_groups(&token, mark);
    if may_be_group && integer {
        return number(&token.replace(mark, ""));
    }
    if may_be_group && mark == ',' {
        return Err(format!(
            "may be {head}.{tail} or {head}{tail}: write one of these"
        ));
    }
    number(&format!("{head}.{tail}"))
}

/// Whether digits are separated in groups of three behind one to three that do not begin with 0.
fn is_in_groups(digits: &str, mark: char) -> bool {
    let mut groups = digits.split(mark);
    let first = groups.next().unwrap_or_default();
    (1..=3).contains(&first.len())
        && !first.starts_with('0')
        && groups.all(|group| group.len() == 3)
}

fn number(text: &str) -> Result<f64, String> {
    // "5." and ".5" are numbers to people.
    let text = format!("0{}", text.trim_end_matches('.'));
    text.parse().map_err(|_| "is no number".into())
}

/// Characters of other scripts and keyboards as the plain ones they stand for.
fn plain(c: char) -> char {
    let digit = |zero: u32| char::from_digit(u32::from(c) - zero, 10).unwrap_or(c);
    match c {
        '\u{ff10}'..='\u{ff19}' => digit(0xff10),
        '\u{660}'..='\u{669}' => digit(0x660),
        '\u{6f0}'..='\u{6f9}' => digit(0x6f0),
        '\u{966}'..='\u{96f}' => digit(0x966),
        '．' => '.',
        '，' | '٫' => ',',
        '％' | '٪' => '%',
        '−' | '–' | '－' => '-',
        '＋' => '+',
        '⁄' | '∕' | '／' => '/',
        '٬' => '\'',
        c if c.is_whitespace() => ' ',
        c => c,
    }
}

const VULGAR: [(char, f64); 9] = [
    ('½', 1.0 / 2.0),
    ('⅓', 1.0 / 3.0),
    ('⅔', 2.0 / 3.0),
    ('¼', 1.0 / 4.0),
    ('¾', 3.0 / 4.0),
    ('⅛', 1.0 / 8.0),
    ('⅜', 3.0 / 8.0),
    ('⅝', 5.0 / 8.0),
    ('⅞', 7.0 / 8.0),
];

fn is_vulgar(c: char) -> bool {
    VULGAR.iter().any(|(vulgar, _)| *vulgar == c)
}

fn vulgar_value(c: char) -> f64 {
    VULGAR
        .iter()
        .find(|(vulgar, _)| *vulgar == c)
        .map_or(0.0, |(_, value)| *value)
}
