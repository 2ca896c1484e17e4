//! Kind of signal that a vector is, and its words.

use statistics::significant;

use crate::carrier::{CLIPPED, Carrier, carrier};
use crate::excerpt::{Excerpt, Extremes};
use crate::slow::{Counts, Slow, Steps, Travel, slow};
use crate::time_axis::{TimeAxis, TimeUnit, time_axis};

/// Kind of signal.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) enum Nature {
    /// The file cannot be read there, for this reason.
    Unread(String),
    /// No value is finite.
    #[default]
    Lost,
    Constant,
    Time(TimeAxis),
    /// Increases in equal steps, in a unit that is not one of time.
    Ramp(TimeAxis),
    Carrier(Carrier),
    Slow(Slow),
}

/// Returns the kind of an excerpt's signal, sampled at `rate_hz` if that is known; `may_be_time` unless its unit is another.
pub(crate) fn nature(
    excerpt: &Excerpt,
    extremes: Option<&Extremes>,
    rate_hz: Option<f64>,
    may_be_time: bool,
) -> Nature {
    let Some(extremes) = extremes else {
        return Nature::Lost;
    };
    if extremes.least == extremes.greatest {
        return Nature::Constant;
    }
    if let Some(axis) = time_axis(excerpt.longest()) {
        return if may_be_time {
            Nature::Time(axis)
        } else {
            Nature::Ramp(axis)
        };
    }
    match carrier(excerpt.longest(), rate_hz) {
        Some(carrier) => Nature::Carrier(carrier),
        None => Nature::Slow(slow(excerpt, rate_hz)),
    }
}

/// Returns a frequency with its unit, or as a part of an unknown rate.
pub(crate) fn frequency_text(frequency: f64, rate_hz: Option<f64>) -> String {
    match rate_hz {
        Some(_) => format!("{} Hz", grouped(frequency)),
        None => format!(
            "{} of the rate",
            significant((frequency * 1e5).round() / 1e5)
        ),
    }
}

/// Returns a number with at most six digits, those before the decimal point in groups of three.
pub(crate) fn grouped(value: f64) -> String {
    let text = significant(value);
    let (whole, rest) = match text.find(['.', 'e']) {
        Some(index) => text.split_at(index),
        None => (text.as_str(), ""),
    };
    let digits = whole.trim_start_matches('-');
    if digits.len() < 5 || !digits.chars().all(|c| c.is_ascii_digit()) {
        return text;
    }
    let mut result = String::from(if whole.starts_with('-') { "-" } else { "" });
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            result.push('\u{a0}');
        }
        result.push(digit);
    }
    result + rest
}

fn percent(share: f64) -> String {
    format!("{} %", significant((share * 100.0).round()))
}

/// Largest modulation index that is printed.
const MOST_INDEX: f64 = 1.5;

impl Nature {
    /// Returns the roles that the kind suggests, in words; `None` where it suggests none.
    pub fn suggestion(&self) -> Option<&'static str> {
        match self {
            Self::Unread(_) | Self::Lost | Self::Constant | Self::Time(_) | Self::Ramp(_) => None,
            Self::Carrier(_) => Some("drive or pickup"),
            Self::Slow(Slow::Levels(_)) => Some("trigger or marks"),
            Self::Slow(Slow::Counts(_)) => Some("encoder"),
            Self::Slow(Slow::Travel(_)) => Some("position"),
            Self::Slow(Slow::Steps(steps)) if steps.modulation.is_some() => {
                Some("friction under modulation, the lateral force")
            }
            Self::Slow(Slow::Steps(steps)) if steps.is_one_way() => {
                Some("a force at contact, normal?")
            }
            Self::Slow(Slow::Steps(_)) => Some("a force both ways, lateral?"),
            Self::Slow(Slow::Oscillation(_)) => Some("an envelope"),
            Self::Slow(Slow::Noise) => None,
        }
    }

    /// Returns the kind in words.
    pub fn text(&self, rate_hz: Option<f64>, length: u64, unit: Option<TimeUnit>) -> String {
        match self {
            Self::Unread(reason) => format!("not read: {reason}"),
            Self::Lost => "no finite value".to_owned(),
            Self::Constant => "constant".to_owned(),
            Self::Time(axis) => time_text(*axis, length, unit),
            Self::Ramp(_) => "increases in equal steps".to_owned(),
            Self::Carrier(carrier) => carrier_text(carrier, rate_hz),
            Self::Slow(slow) => slow_text(slow, rate_hz),
        }
    }
}

fn time_text(axis: TimeAxis, length: u64, unit: Option<TimeUnit>) -> String {
    let (likely, is_sure) = axis.likely_unit(length);
    let used = unit.unwrap_or(likely);
    let Some(seconds) = used.seconds() else {
        return "counts up by 1: numbers of samples".to_owned();
    };
    let doubt = if unit.is_some() || is_sure { "" } else { "?" };
    let rate = grouped(1.0 / (axis.interval * seconds));
    let jitter = match axis.jitter {
        jitter if jitter < 1e-3 => "steady".to_owned(),
        jitter => format!("jitter {} of an interval", percent(jitter)),
    };
    format!("time in {}{doubt}: {rate} Hz, {jitter}", used.symbol())
}

fn carrier_text(carrier: &Carrier, rate_hz: Option<f64>) -> String {
    let mut text = format!("carrier {}", frequency_text(carrier.frequency_hz, rate_hz));
    match &carrier.modulation {
        Some(modulation) => {
            let frequency = match rate_hz {
                Some(_) => format!(
                    "{} Hz",
                    significant((modulation.frequency_hz * 100.0).round() / 100.0)
                ),
                None => format!("{:.3e} of the rate", modulation.frequency_hz),
            };
            text += &format!(", modulated at {frequency}, {}", percent(modulation.index));
        }
        None => text += ", not modulated",
    }
    if carrier.clipped_share > CLIPPED {
        text += &format!(
            "; clipped: {} of its values are its extremes",
            percent(carrier.clipped_share)
        );
    }
    text
}

fn slow_text(slow: &Slow, rate_hz: Option<f64>) -> String {
    match slow {
        Slow::Levels(levels) => {
            let levels: Vec<String> = levels.iter().map(|level| significant(*level)).collect();
            format!("only {}", levels.join(" and "))
        }
        Slow::Counts(Counts { travel, wrap_bits }) => {
            let wrap = wrap_bits.map_or(String::new(), |bits| {
                format!(", beginning again after {bits} bits")
            });
            format!("counts, {}{wrap}", strokes(travel))
        }
        Slow::Travel(travel) => format!("moves smoothly, {}", strokes(travel)),
        Slow::Steps(steps) => steps_text(steps, rate_hz),
        Slow::Oscillation(found) => {
            let frequency = match rate_hz {
                Some(_) => format!(
                    "{} Hz",
                    significant((found.frequency_hz * 100.0).round() / 100.0)
                ),
                None => format!("{:.3e} of the rate", found.frequency_hz),
            };
            // The index has no meaning about a mean near zero.
            match found.index {
                index if index > MOST_INDEX => format!("oscillates at {frequency}"),
                index => format!("oscillates at {frequency}, {}", percent(index)),
            }
        }
        Slow::Noise => "noise about its mean".to_owned(),
    }
}

fn strokes(travel: &Travel) -> String {
    let range = significant(
        (travel.range * 1e4 / magnitude(travel.range)).round() * magnitude(travel.range) / 1e4,
    );
    match travel.strokes {
        1 => format!("1 stroke, range {range}"),
        count => format!("{count} strokes, range {range}"),
    }
}

/// Returns the power of ten next above a positive value.
fn magnitude(value: f64) -> f64 {
    10_f64.powi(value.abs().max(f64::MIN_POSITIVE).log10().ceil() as i32)
}

fn steps_text(steps: &Steps, rate_hz: Option<f64>) -> String {
    let rest = rounded(steps.rest, steps.up.max(steps.down));
    let times = match steps.count {
        1 => "once".to_owned(),
        count => format!("{count} times"),
    };
    let modulated = steps.modulation.map_or(String::new(), |sinusoid| {
        let hz = rate_hz.map(|_| {
            format!(
                " at {} Hz",
                significant((sinusoid.frequency_hz * 100.0).round() / 100.0)
            )
        });
        format!(", oscillating{} in between", hz.unwrap_or_default())
    });
    let extreme = |excursion: f64| rounded(steps.rest + excursion, excursion.abs());
    if steps.is_one_way() {
        let to = if steps.balance > 0.0 {
            extreme(steps.up)
        } else {
            extreme(-steps.down)
        };
        format!("steps from {rest} to {to}, {times}{modulated}")
    } else {
        let (low, high) = (extreme(-steps.down), extreme(steps.up));
        format!("steps from {rest} to {low} and {high}, {times}{modulated}")
    }
}

/// Returns a value to three digits of `scale`.
fn rounded(value: f64, scale: f64) -> String {
    let unit = magnitude(scale) / 1e3;
    // The sum turns −0 into 0.
    significant((value / unit).round() * unit + 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::periodicity::Periodicity;

    #[test]
    fn numbers_are_grouped() {
        for (value, text) in [
            (35_000.0, "35\u{a0}000"),
            (6.0, "6"),
            (1_000.0, "1000"),
            (192_000.5, "192\u{a0}000"),
            (-12_345.6, "-12\u{a0}345.6"),
        ] {
            assert_eq!(grouped(value), text);
        }
    }

    #[test]
    fn a_carrier_is_worded_as_the_manual_shows() {
        let modulation = Periodicity {
            frequency_hz: 6.002,
            index: 0.951,
            phase_rad: 0.0,
        };
        let carrier = Carrier {
            frequency_hz: 35_000.04,
            amplitude: 1.0,
            modulation: Some(modulation),
            unsteadiness: 0.0,
            distortion: None,
            clipped_share: 0.0,
        };
        let nature = Nature::Carrier(carrier);
        let text = format!(
            "{}: {}",
            nature.text(Some(192e3), 1_000, None),
            nature.suggestion().unwrap()
        );
        assert_eq!(
            text.replace('\u{a0}', " "),
            "carrier 35 000 Hz, modulated at 6 Hz, 95 %: drive or pickup"
        );
    }

    #[test]
    fn steps_and_times_are_worded() {
        let steps = Steps {
            rest: 0.0123,
            is_rest_certain: true,
            up: 0.6,
            down: 0.004,
            count: 3,
            balance: 0.99,
            modulation: None,
        };
        assert_eq!(
            steps_text(&steps, None),
            "steps from 0.012 to 0.612, 3 times"
        );
        let axis = TimeAxis {
            interval: 1e-4,
            jitter: 0.02,
        };
        let text = time_text(axis, 100_000, None);
        assert_eq!(
            text.replace('\u{a0}', " "),
            "time in s: 10 000 Hz, jitter 2 % of an interval"
        );
    }
}
