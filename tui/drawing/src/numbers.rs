//! Numbers and times as text.

/// Returns `value` times `scale` as text, or a dash for `None`.
#[must_use]
pub fn number(value: Option<f64>, scale: f64, decimals: usize) -> String {
    match value {
        Some(value) => signed(format!("{:.decimals$}", value * scale)),
        None => "–".to_owned(),
    }
}

/// Returns `digits` with a typographic minus sign, omitted before zero.
///
/// ```
/// use drawing::numbers::signed;
///
/// assert_eq!(signed("-0.004".to_owned()), "−0.004");
/// assert_eq!(signed("-0.000".to_owned()), "0.000");
/// ```
#[must_use]
pub fn signed(digits: String) -> String {
    match digits.strip_prefix('-') {
        Some(rest) if rest.bytes().all(|b| b == b'0' || b == b'.') => rest.to_owned(),
        Some(rest) => format!("−{rest}"),
        None => digits,
    }
}

/// Returns `count` with its digits in groups of three.
#[must_use]
pub fn thousands(count: u64) -> String {
    let digits = count.to_string();
    let mut groups = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            groups.push(' ');
        }
        groups.push(digit);
    }
    groups
}

/// Describes a time in the past.
#[must_use]
pub fn ago(s: f64) -> String {
    match s {
        ..1.0 => "just now".to_owned(),
        ..60.0 => format!("{s:.0} s ago"),
        _ => format!("{:.0} min ago", s / 60.0),
    }
}
