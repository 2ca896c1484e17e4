//! Times in cells: clocks, dates with clocks, durations.

use super::number_cell::MISSING;

/// Names of months, as MATLAB writes them.
const MONTHS: [&str; 12] = [
    "jan", "feb", "mar", "apr", "may", "jun", "jul", "aug", "sep", "oct", "nov", "dec",
];

/// Units of durations, s.
const UNITS_S: [(&str, f64); 14] = [
    ("s", 1.0),
    ("sec", 1.0),
    ("secs", 1.0),
    ("seconds", 1.0),
    ("ms", 1e-3),
    ("min", 60.0),
    ("mins", 60.0),
    ("minutes", 60.0),
    ("h", 3600.0),
    ("hr", 3600.0),
    ("hrs", 3600.0),
    ("hours", 3600.0),
    ("day", 86_400.0),
    ("days", 86_400.0),
];

/// Reason why a cell is not a time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum TimeFault {
    /// The cell has another form.
    #[error("it is not a time")]
    NotTime,
    /// Day and month of its date may be exchanged.
    #[error("its date may have the day or the month first")]
    Ambiguous {
        /// Numbers at the start of the date.
        numbers: [i64; 2],
    },
}

/// Reader of the times of a column, whose dates have one order of day and month.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct TimeCells {
    is_day_first: Option<bool>,
}

impl TimeCells {
    /// Takes the order of day and month from a cell that shows it; returns whether the order is known.
    pub fn decide(&mut self, cell: &str) -> bool {
        if self.is_day_first.is_none() {
            let date = cell.split(['T', ' ']).next().unwrap_or(cell);
            self.is_day_first = numeric_date(date).and_then(|([first, second], _)| {
                let is_decided = (first > 12) != (second > 12);
                is_decided.then_some(first > 12)
            });
        }
        self.is_day_first.is_some()
    }

    /// Reads a time as seconds: `2026-11-26T12:34:56.789+02:00` since 1970, `12:34:56.789` since midnight, `59:58.5` since the
    /// hour, a duration `0.25 sec`; NaN for a missing value.
    ///
    /// # Errors
    /// The cell has another form, or its date has two readings and no cell showed which holds.
    pub fn read(&self, cell: &str) -> Result<f64, TimeFault> {
        if MISSING.contains(&cell.to_ascii_lowercase().as_str()) {
            return Ok(f64::NAN);
        }
        if let Some(duration_s) = duration_s(cell) {
            return Ok(duration_s);
        }
        let Some((date, clock)) = cell.split_once(['T', ' ']) else {
            return zoned_s(cell).ok_or(TimeFault::NotTime);
        };
        if is_half(clock) {
            return zoned_s(cell).ok_or(TimeFault::NotTime);
        }
        let clock_s = zoned_s(clock).ok_or(TimeFault::NotTime)?;
        Ok(self.day(date)? * 86_400.0 + clock_s)
    }

    /// Returns the days from 1970 to a date: `2026-11-26`, `26.11.2026`, `26-Nov-2026`, `26/11/2026` and `11/26/2026`.
    fn day(self, text: &str) -> Result<f64, TimeFault> {
        let parts: Vec<&str> = text.split(['-', '/', '.']).collect();
        let number = |text: &str| text.parse::<i64>().map_err(|_| TimeFault::NotTime);
        if let [year, month, day] = parts[..]
            && year.len() == 4
        {
            return civil_day(number(year)?, number(month)?, number(day)?);
        }
        if let [day, month, year] = parts[..]
            && year.len() == 4
            && let Some(place) = MONTHS
                .iter()
                .position(|name| month.eq_ignore_ascii_case(name))
        {
            return civil_day(number(year)?, place as i64 + 1, number(day)?);
        }
        let Some(([first, second], year)) = numeric_date(text) else {
            return Err(TimeFault::NotTime);
        };
        let is_day_first = match self.is_day_first {
            _ if text.contains('.') || first == second => true,
            Some(is_day_first) => is_day_first,
            None if (first > 12) != (second > 12) => first > 12,
            None => {
                let numbers = [first, second];
                return Err(TimeFault::Ambiguous { numbers });
            }
        };
        match is_day_first {
            true => civil_day(year, second, first),
            false => civil_day(year, first, second),
        }
    }
}

/// Reads a time whose date has one reading.
#[must_use]
pub fn time_s(cell: &str) -> Option<f64> {
    TimeCells::default().read(cell).ok()
}

/// Returns whether a cell is a time, also one whose date has two readings.
pub(super) fn is_time(cell: &str) -> bool {
    TimeCells::default().read(cell) != Err(TimeFault::NotTime)
}

/// Returns a duration: `0.25 sec` of MATLAB, `1 days 00:00:01.5` of pandas.
fn duration_s(cell: &str) -> Option<f64> {
    let (number, rest) = cell.split_once(' ')?;
    let number: f64 = number.replace(',', ".").parse().ok()?;
    let (unit, clock) = rest.split_once(' ').unwrap_or((rest, ""));
    let (_, unit_s) = UNITS_S.iter().find(|(name, _)| *name == unit)?;
    match clock {
        "" => Some(number * unit_s),
        clock if unit.starts_with("day") => {
            let (sign, clock) = match clock.strip_prefix('-') {
                Some(clock) => (-1.0, clock),
                None => (1.0, clock.trim_start_matches('+')),
            };
            Some(number * unit_s + sign * clock_s(clock)?)
        }
        _ => None,
    }
}

/// Returns whether a text is AM or PM.
fn is_half(text: &str) -> bool {
    text.eq_ignore_ascii_case("am") || text.eq_ignore_ascii_case("pm")
}

/// Reads a clock with a half of the day or an offset from UTC, if any.
fn zoned_s(text: &str) -> Option<f64> {
    if let Some(half) = text
        .get(text.len().saturating_sub(2)..)
        .filter(|half| is_half(half))
    {
        let clock = text[..text.len() - 2].trim_end();
        let hours: u32 = clock.split(':').next()?.parse().ok()?;
        if !(1..=12).contains(&hours) {
            // A clock of 24 hours with a needless half.
            return clock_s(clock);
        }
        let is_after_noon = half.eq_ignore_ascii_case("pm");
        let shift = match (hours, is_after_noon) {
            (12, false) => -12.0,
            (1..=11, true) => 12.0,
            _ => 0.0,
        };
        return Some(clock_s(clock)? + shift * 3600.0);
    }
    let text = text
        .trim_end_matches("UTC")
        .trim_end_matches("GMT")
        .trim_end();
    let text = text.strip_suffix('Z').unwrap_or(text);
    let Some(place) = text.rfind(['+', '-', '\u{2212}']) else {
        return clock_s(text);
    };
    let (clock, offset) = text.split_at(place);
    let sign = if offset.starts_with('+') { 1.0 } else { -1.0 };
    let digits: String = offset.chars().skip(1).filter(|c| *c != ':').collect();
    let is_offset =
        matches!(digits.len(), 2 | 4) && digits.bytes().all(|byte| byte.is_ascii_digit());
    if !is_offset {
        return None;
    }
    let hours: f64 = digits[..2].parse().ok()?;
    let minutes: f64 = digits[2..].parse().unwrap_or(0.0);
    Some(clock_s(clock.trim_end())? - sign * (hours * 3600.0 + minutes * 60.0))
}

/// Reads `h:mm:ss` with any decimals, or `mm:ss.0` as a spreadsheet shows it.
fn clock_s(text: &str) -> Option<f64> {
    let parts: Vec<&str> = text.split(':').collect();
    let (hours, minutes, seconds) = match parts[..] {
        [hours, minutes, seconds] => (hours, minutes, seconds),
        [minutes, seconds] if seconds.contains(['.', ',']) => ("0", minutes, seconds),
        _ => return None,
    };
    let is_short = |text: &str| (1..=2).contains(&text.len());
    if !is_short(hours) || !is_short(minutes) || seconds.len() < 2 {
        return None;
    }
    let hours: u32 = hours.parse().ok()?;
    let minutes: u32 = minutes.parse().ok()?;
    let seconds = seconds.replace(',', ".");
    let is_clock = seconds
        .bytes()
        .all(|byte| byte.is_ascii_digit() || byte == b'.');
    let seconds: f64 = seconds.parse().ok().filter(|_| is_clock)?;
    Some(f64::from(hours * 3600 + minutes * 60) + seconds)
}

/// Returns the first two numbers and the year of a date that ends with its year.
fn numeric_date(text: &str) -> Option<([i64; 2], i64)> {
    let parts: Vec<&str> = text.split(['-', '/', '.']).collect();
    let [first, second, year] = parts[..] else {
        return None;
    };
    let is_date = year.len() == 4 && first.len() <= 2 && second.len() <= 2;
    let numbers = [first.parse().ok()?, second.parse().ok()?];
    Some((numbers, year.parse().ok()?)).filter(|_| is_date)
}

/// Returns the days from 1970 to a date.
fn civil_day(year: i64, month: i64, day: i64) -> Result<f64, TimeFault> {
    let is_leap = year % 4 == 0 && (year % 100 != 0 || year % 400 == 0);
    let days = match month {
        2 if is_leap => 29,
        2 => 28,
        4 | 6 | 9 | 11 => 30,
        1..=12 => 31,
        _ => return Err(TimeFault::NotTime),
    };
    if !(1..=days).contains(&day) {
        return Err(TimeFault::NotTime);
    }
    // Days of the civil calendar, counted from March.
    let (year, month) = if month > 2 {
        (year, month - 3)
    } else {
        (year - 1, month + 9)
    };
    let days = year * 365 + year.div_euclid(4) - year.div_euclid(100) + year.div_euclid(400);
    Ok((days + (153 * month + 2) / 5 + day - 1 - 719_468) as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_seconds() {
        let second_of_2026 = 1_795_651_201.0;
        for (cell, seconds) in [
            ("01:00:01.5", 3601.5),
            ("1:00:01", 3601.0),
            ("59:58.5", 3598.5),
            ("1970-01-02 00:00:00", 86_400.0),
            ("2000-03-01 00:00:00", 951_868_800.0),
            ("2026-11-26T00:00:01Z", second_of_2026),
            ("2026-11-26T02:00:01+02:00", second_of_2026),
            ("2026-11-25T18:30:01-0530", second_of_2026),
            ("2026-11-26 00:00:01+00:00", second_of_2026),
            ("2026-11-26 00:00:01 UTC", second_of_2026),
            ("26.11.2026 00:00:01,0", second_of_2026),
            ("26-Nov-2026 00:00:01", second_of_2026),
            ("11/26/2026 12:00:01 AM", second_of_2026),
            ("26/11/2026 0:00:01", second_of_2026),
            ("12:00:01 PM", 43_201.0),
            ("1:00:01.5 pm", 46_801.5),
            ("0.001 sec", 0.001),
            ("1,5 min", 90.0),
            ("1 days 00:00:00.250000", 86_400.25),
            ("-1 days +23:59:59.5", -0.5),
        ] {
            assert_eq!(time_s(cell), Some(seconds), "{cell}");
        }
        for cell in [
            "12:34",
            "26.11.26 12:00:00",
            "1.5",
            "a:bb:cc",
            "4 N",
            "13/13/2026 10:00:00",
            "10:00:00+2",
            "31.02.2026 10:00:00",
            "2025-02-29 00:00:00",
            "31-Apr-2026 00:00:00",
        ] {
            assert_eq!(time_s(cell), None, "{cell}");
        }
    }

    #[test]
    fn a_day_above_12_decides_the_order() {
        let cell = "03/04/2026 00:00:00";
        let ambiguous = TimeFault::Ambiguous { numbers: [3, 4] };
        let mut times = TimeCells::default();
        assert_eq!(times.read(cell), Err(ambiguous));
        assert!(!times.decide(cell) && times.decide("13/04/2026 00:00:00"));
        assert_eq!(times.read(cell), Ok(time_s("2026-04-03 00:00:00").unwrap()));
        let mut times = TimeCells::default();
        assert!(times.decide("04/13/2026 00:00:00"));
        assert_eq!(times.read(cell), Ok(time_s("2026-03-04 00:00:00").unwrap()));
        assert_eq!(times.read("13/04/2026 00:00:00"), Err(TimeFault::NotTime));
    }
}
