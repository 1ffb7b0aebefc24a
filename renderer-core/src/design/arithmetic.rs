//! Sums and products of typed numbers: `70 + 2*3`, `140 cm / 3`, `(12 + 8) mm`.

/// What a part of a sum comes to.
#[derive(Clone, Copy)]
pub(super) struct Term {
    /// In the unit that is asked for.
    pub value: f64,
    /// Whether a unit stood there.
    pub has_unit: bool,
}

/// Reads sums and products; `operand` reads a number with its unit, `unit` how many of what is asked for one of a unit
/// is.
///
/// # Errors
/// What is wrong, as the end of a sentence about the text.
pub(super) fn read_sum(
    text: &str,
    operand: &dyn Fn(&str) -> Result<Term, String>,
    unit: &dyn Fn(&str) -> Result<f64, String>,
) -> Result<f64, String> {
    let mut reader = Reader {
        text,
        at: 0,
        depth: 0,
        operand,
        unit,
    };
    let sum = reader.sum()?;
    match reader.peek() {
        None => Ok(sum.value),
        Some(_) => Err("is no number".into()),
    }
}

/// Whether a text may be a sum or a product.
pub(super) fn has_operator(text: &str) -> bool {
    text.contains(['+', '-', '*', '×', '·', '÷', '/', '(', ')'])
}

/// Parentheses within each other.
const MOST_NESTED: usize = 20;

struct Reader<'a> {
    text: &'a str,
    at: usize,
    depth: usize,
    operand: &'a dyn Fn(&str) -> Result<Term, String>,
    unit: &'a dyn Fn(&str) -> Result<f64, String>,
}

impl<'a> Reader<'a> {
    fn peek(&mut self) -> Option<char> {
        let rest = &self.text[self.at..];
        self.at += rest.len() - rest.trim_start().len();
        self.text[self.at..].chars().next()
    }

    fn take(&mut self, among: &[char]) -> Option<char> {
        let next = self.peek().filter(|next| among.contains(next))?;
        self.at += next.len_utf8();
        Some(next)
    }

    fn sum(&mut self) -> Result<Term, String> {
        let mut sum = self.product()?;
        while let Some(sign) = self.take(&['+', '-']) {
            let next = self.product()?;
            if sum.has_unit != next.has_unit {
                return Err("has a unit in one part of the sum and none in another".into());
            }
            sum.value += if sign == '-' { -next.value } else { next.value };
        }
        Ok(sum)
    }

    fn product(&mut self) -> Result<Term, String> {
        let mut product = self.factor()?;
        while let Some(sign) = self.take(&['*', '×', '·', '÷', '/']) {
            let next = self.factor()?;
            let divides = matches!(sign, '÷' | '/');
            if next.has_unit && (divides || product.has_unit) {
                let what = if divides {
                    "divides by"
                } else {
                    "multiplies with"
                };
                return Err(format!("{what} a number that has a unit"));
            }
            if divides && next.value == 0.0 {
                return Err("divides by 0".into());
            }
            product.value = match divides {
                true => product.value / next.value,
                false => product.value * next.value,
            };
            product.has_unit |= next.has_unit;
        }
        Ok(product)
    }

    fn factor(&mut self) -> Result<Term, String> {
        let sign = self.take(&['+', '-']);
        let mut factor = match self.take(&['(']) {
            Some(_) => self.parentheses()?,
            None => {
                let operand = self.operand_text();
                if operand.is_empty() {
                    return Err("is no number".into());
                }
                (self.operand)(operand)?
            }
        };
        if sign == Some('-') {
            factor.value = -factor.value;
        }
        Ok(factor)
    }

    /// What stands in parentheses that are open already, and the unit behind them.
    fn parentheses(&mut self) -> Result<Term, String> {
        self.depth += 1;
        if self.depth > MOST_NESTED {
            return Err("has too many parentheses".into());
        }
        let mut inside = self.sum()?;
        self.depth -= 1;
        self.take(&[')']).ok_or("lacks a )")?;
        let unit = self.operand_text();
        if !unit.is_empty() {
            if inside.has_unit {
                return Err("has units in parentheses and behind them".into());
            }
            inside.value *= (self.unit)(unit)?;
            inside.has_unit = true;
        }
        Ok(inside)
    }

    /// The text up to the next operator.
    fn operand_text(&mut self) -> &'a str {
        self.peek();
        let (start, mut last) = (self.at, None::<char>);
        let text = self.text;
        let rest = &text[start..];
        let mut end = rest.len();
        for (at, c) in rest.char_indices() {
            let behind = rest[at + c.len_utf8()..].trim_start();
            let next = behind.chars().next();
            let is_operator = match c {
                '*' | '×' | '·' | '÷' | '(' | ')' | '+' => true,
                // 2e-3
                '-' => {
                    !(at > 1
                        && matches!(last, Some('e' | 'E'))
                        && is_digit(rest[..at - 1].chars().last()))
                }
                // 1/4 is a number and /in a unit; in "70 cm / 2" it divides.
                '/' => matches!(next, Some('(')) || is_digit(next) && !is_digit(last),
                _ => false,
            };
            if is_operator {
                end = at;
                break;
            }
            last = Some(c);
        }
        self.at += end;
        rest[..end].trim()
    }
}

fn is_digit(c: Option<char>) -> bool {
    c.is_some_and(|c| c.is_ascii_digit())
}
