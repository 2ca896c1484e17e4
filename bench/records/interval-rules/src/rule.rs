//! A rule, read from text.

use std::fmt;

use statistics::significant;

use crate::error::RuleError;
use crate::quantity::Quantity;

/// Condition on the filtered value, in N or m/s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Condition {
    /// Magnitude below the limit: a touch with the force upside down does not count as an unloaded plate.
    Below(f64),
    /// Above the limit: the normal force with its sign, so that a force upside down does not count as a touch; the others by magnitude.
    Above(f64),
    /// Magnitude within both limits.
    Within(f64, f64),
}

/// A condition on one quantity, and the time for which it must hold without interruption.
///
/// ```
/// let rule = interval_rules::Rule::parse("normal < 50 mN for 300 ms")?;
/// assert_eq!(rule.condition(), interval_rules::Condition::Below(0.05));
/// assert_eq!(rule.to_string(), "normal < 0.05 N for 0.3 s");
/// # Ok::<(), interval_rules::RuleError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rule {
    quantity: Quantity,
    condition: Condition,
    duration_s: f64,
}

impl Rule {
    /// Reads a rule: `normal|lateral|speed < X UNIT for Y s`, with `<` or `>`, or `A to B mm/s for Y s`.
    ///
    /// # Errors
    /// If the text is not a rule; the error names the word and the correct form.
    pub fn parse(text: &str) -> Result<Self, RuleError> {
        let (condition, duration) = text.split_once(" for ").ok_or_else(|| {
            let text = text.to_owned();
            match Words::new(&text).0.len() {
                3.. => RuleError::NoDuration { text },
                _ => RuleError::Form { text },
            }
        })?;
        let duration_s = Duration { text }.read(duration)?;
        let (quantity, condition) = Limits { text }.read(condition)?;
        Ok(Self {
            quantity,
            condition,
            duration_s,
        })
    }

    /// Returns the quantity that the rule limits.
    #[must_use]
    pub fn quantity(&self) -> Quantity {
        self.quantity
    }

    /// Returns the condition, in N or m/s.
    #[must_use]
    pub fn condition(&self) -> Condition {
        self.condition
    }

    /// Returns the time for which the condition must hold, s.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        self.duration_s
    }

    /// Returns whether a filtered value, in N or m/s, meets the condition.
    pub(crate) fn admits(&self, value: f64) -> bool {
        match (self.condition, self.quantity) {
            (Condition::Below(limit), _) => value.abs() < limit,
            (Condition::Above(limit), Quantity::Normal) => value > limit,
            (Condition::Above(limit), Quantity::Lateral | Quantity::Speed) => value.abs() > limit,
            (Condition::Within(from, to), _) => (from..=to).contains(&value.abs()),
        }
    }
}

impl fmt::Display for Rule {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = match self.quantity {
            Quantity::Normal => "normal",
            Quantity::Lateral => "lateral",
            Quantity::Speed => "speed",
        };
        match self.condition {
            Condition::Below(limit) => write!(f, "{name} < {}", self.quantity.text(limit))?,
            Condition::Above(limit) => write!(f, "{name} > {}", self.quantity.text(limit))?,
            Condition::Within(from, to) => {
                write!(
                    f,
                    "{} to {}",
                    significant(from * 1e3),
                    self.quantity.text(to)
                )?;
            }
        }
        write!(f, " for {} s", significant(self.duration_s))
    }
}

/// Words of a rule: numbers apart from the unit that follows without a space, `<` and `>` apart from both neighbours.
struct Words<'a>(Vec<&'a str>);

impl<'a> Words<'a> {
    fn new(text: &'a str) -> Self {
        let mut words = Vec::new();
        for word in text.split_whitespace() {
            let mut rest = word;
            while let Some(index) = boundary(rest) {
                let (head, tail) = rest.split_at(index);
                words.push(head);
                rest = tail;
            }
            words.push(rest);
        }
        Self(words)
    }
}

/// Returns the index at which the first word of `text` ends, if it is not its whole length.
fn boundary(text: &str) -> Option<usize> {
    let is_comparison = |c: char| matches!(c, '<' | '>' | '=' | '≤' | '≥');
    let first = text.chars().next()?;
    let end = if is_comparison(first) {
        text.find(|c| !is_comparison(c))
    } else if first.is_ascii_digit() || matches!(first, '.' | '-' | '+' | '−') {
        let exponent = |index: usize| {
            let (head, tail) = text.split_at(index);
            let digits = tail
                .trim_start_matches(['e', 'E'])
                .trim_start_matches(['-', '+']);
            tail.starts_with(['e', 'E'])
                && digits.starts_with(|c: char| c.is_ascii_digit())
                && !head.is_empty()
        };
        let is_number = |c: char| c.is_ascii_digit() || matches!(c, '.' | ',' | '-' | '+' | '−');
        let end = text.find(|c| !is_number(c));
        match end {
            Some(index) if exponent(index) => {
                let tail = &text[index + 1..];
                tail.find(|c| !is_number(c)).map(|more| index + 1 + more)
            }
            end => end,
        }
    } else {
        text.find(is_comparison)
    };
    end.filter(|index| *index > 0)
}

/// Reader of a rule's part after `for`.
struct Duration<'a> {
    text: &'a str,
}

impl Duration<'_> {
    fn read(&self, part: &str) -> Result<f64, RuleError> {
        let text = || self.text.to_owned();
        let words = Words::new(part).0;
        let [number, rest @ ..] = words.as_slice() else {
            return Err(RuleError::NoDuration { text: text() });
        };
        let value = number_of(self.text, number)?;
        let [unit, rest @ ..] = rest else {
            let number = (*number).to_owned();
            return Err(RuleError::NoUnit {
                text: text(),
                number,
                units: "s or ms",
            });
        };
        let unit_s = match *unit {
            "s" => 1.0,
            "ms" => 1e-3,
            unit => {
                let unit = unit.to_owned();
                return Err(RuleError::WrongDurationUnit { text: text(), unit });
            }
        };
        if !rest.is_empty() {
            return Err(RuleError::Trailing {
                text: text(),
                rest: rest.join(" "),
            });
        }
        let duration_s = value * unit_s;
        if !(1e-3..=3600.0).contains(&duration_s) {
            let number = (*number).to_owned();
            return Err(RuleError::OutOfRange {
                text: text(),
                number,
            });
        }
        Ok(duration_s)
    }
}

/// Reader of a rule's part before `for`.
struct Limits<'a> {
    text: &'a str,
}

impl Limits<'_> {
    fn read(&self, part: &str) -> Result<(Quantity, Condition), RuleError> {
        let text = || self.text.to_owned();
        let words = Words::new(part).0;
        let is_number = |word: &str| {
            word.starts_with(|c: char| c.is_ascii_digit() || matches!(c, '.' | '-' | '+' | '−'))
        };
        match words.as_slice() {
            [from, "to", to, unit @ ..] if is_number(from) => {
                let quantity = Quantity::Speed;
                let unit_m_per_s = self.unit(quantity, to, unit)?;
                let from_m_per_s = self.limit(from, unit_m_per_s, true)?;
                let to_m_per_s = self.limit(to, unit_m_per_s, false)?;
                if from_m_per_s >= to_m_per_s {
                    return Err(RuleError::Reversed { text: text() });
                }
                Ok((quantity, Condition::Within(from_m_per_s, to_m_per_s)))
            }
            [first, ..] if is_number(first) => Err(RuleError::Form { text: text() }),
            [name, comparison, number, unit @ ..] => {
                let quantity = match *name {
                    "normal" => Quantity::Normal,
                    "lateral" => Quantity::Lateral,
                    "speed" => Quantity::Speed,
                    word => {
                        let word = word.to_owned();
                        return Err(RuleError::UnknownQuantity { text: text(), word });
                    }
                };
                let condition = match *comparison {
                    "<" => Condition::Below,
                    ">" => Condition::Above,
                    word => {
                        let word = word.to_owned();
                        return Err(RuleError::UnknownComparison { text: text(), word });
                    }
                };
                let limit = self.limit(number, 1.0, false)?;
                Ok((
                    quantity,
                    condition(limit * self.unit(quantity, number, unit)?),
                ))
            }
            _ => Err(RuleError::Form { text: text() }),
        }
    }

    /// Returns the SI value of the unit after `number`.
    fn unit(&self, quantity: Quantity, number: &str, words: &[&str]) -> Result<f64, RuleError> {
        let text = self.text.to_owned();
        match words {
            [] => Err(RuleError::NoUnit {
                text,
                number: number.to_owned(),
                units: quantity.units(),
            }),
            [unit] => quantity.unit(unit).ok_or_else(|| {
                let unit = (*unit).to_owned();
                RuleError::WrongUnit {
                    text,
                    unit,
                    quantity,
                }
            }),
            [_, ..] => Err(RuleError::Form { text }),
        }
    }

    fn limit(&self, number: &str, unit: f64, may_be_zero: bool) -> Result<f64, RuleError> {
        let value = number_of(self.text, number)? * unit;
        let is_allowed = value.is_finite() && (value > 0.0 || (may_be_zero && value == 0.0));
        is_allowed
            .then_some(value)
            .ok_or_else(|| RuleError::OutOfRange {
                text: self.text.to_owned(),
                number: number.to_owned(),
            })
    }
}

/// Returns the number that `word` is.
fn number_of(text: &str, word: &str) -> Result<f64, RuleError> {
    let value: Option<f64> = word.replace('−', "-").parse().ok();
    value
        .filter(|value| value.is_finite())
        .ok_or_else(|| RuleError::NotANumber {
            text: text.to_owned(),
            word: word.to_owned(),
        })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn each_quantity_and_unit_is_read() {
        for (text, quantity, condition, duration_s) in [
            (
                "normal < 0.05 N for 0.3 s",
                Quantity::Normal,
                Condition::Below(0.05),
                0.3,
            ),
            (
                "normal<50mN for 300ms",
                Quantity::Normal,
                Condition::Below(0.05),
                0.3,
            ),
            (
                "lateral > 1e-1 N for 2 s",
                Quantity::Lateral,
                Condition::Above(0.1),
                2.0,
            ),
            (
                "speed > 2 cm/s for 0.5 s",
                Quantity::Speed,
                Condition::Above(0.02),
                0.5,
            ),
            (
                "speed < 0.001 m/s for .5 s",
                Quantity::Speed,
                Condition::Below(0.001),
                0.5,
            ),
            (
                "  40 to 60 mm/s   for 0.5 s ",
                Quantity::Speed,
                Condition::Within(0.04, 0.06),
                0.5,
            ),
            (
                "0 to 0.2 m/s for 1 s",
                Quantity::Speed,
                Condition::Within(0.0, 0.2),
                1.0,
            ),
        ] {
            let rule = Rule::parse(text).unwrap();
            assert_eq!(
                (rule.quantity(), rule.duration_s()),
                (quantity, duration_s),
                "{text}"
            );
            let near = |a: f64, b: f64| (a - b).abs() < 1e-12;
            assert!(
                match (rule.condition(), condition) {
                    (Condition::Below(a), Condition::Below(b))
                    | (Condition::Above(a), Condition::Above(b)) => near(a, b),
                    (Condition::Within(a, b), Condition::Within(c, d)) => near(a, c) && near(b, d),
                    _ => false,
                },
                "{text}: {rule}"
            );
            assert_eq!(Rule::parse(&rule.to_string()).unwrap(), rule, "{text}");
        }
    }

    #[test]
    fn each_error_names_the_word_that_is_wrong() {
        for (text, part) in [
            ("", "is not a rule"),
            ("normal", "is not a rule"),
            ("normal < 0.05 N", "states no duration"),
            ("normal < 0.05 N for ", "states no duration"),
            ("force < 0.05 N for 0.3 s", "begins with \"force\""),
            ("normal <= 0.05 N for 0.3 s", "compares by \"<=\""),
            ("normal below 0.05 N for 0.3 s", "compares by \"below\""),
            ("normal < 0,05 N for 0.3 s", "\"0,05\" is not a number"),
            ("normal < low N for 0.3 s", "\"low\" is not a number"),
            (
                "normal < 0.05 for 0.3 s",
                "states no unit after 0.05; add N or mN",
            ),
            (
                "speed < 5 N for 0.3 s",
                "\"N\" is not a unit of the speed; write mm/s, cm/s or m/s",
            ),
            (
                "normal < 5 g for 0.3 s",
                "\"g\" is not a unit of the normal force; write N or mN",
            ),
            ("40 to 60 N for 0.5 s", "\"N\" is not a unit of the speed"),
            ("40 to 60 for 0.5 s", "states no unit after 60"),
            ("60 to 40 mm/s for 0.5 s", "begins above its end"),
            ("40 mm/s to 60 mm/s for 0.5 s", "is not a rule"),
            ("normal < -0.05 N for 0.3 s", "-0.05 is out of range"),
            ("normal < 0.05 N for 0 s", "0 is out of range"),
            (
                "normal < 0.05 N for 0.3",
                "states no unit after 0.3; add s or ms",
            ),
            (
                "normal < 0.05 N for 0.3 min",
                "\"min\" is not a unit of the duration",
            ),
            (
                "normal < 0.05 N for 0.3 s and speed > 1 mm/s",
                "goes on with \"and speed > 1 mm/s\"",
            ),
        ] {
            let error = Rule::parse(text).unwrap_err().to_string();
            assert!(error.contains(part), "{text}: {error}");
        }
    }

    proptest! {
        #[test]
        fn any_text_is_read_or_refused(text in "(normal|lateral|speed|[0-9.,e+−-]{0,4}|to|for|[<>=]|[a-zµ/ ]){0,9}") {
            let _ = Rule::parse(&text);
        }
    }
}
