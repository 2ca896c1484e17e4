//! Rules that concern a single key, or the keys of a table that several tables have.

use crate::map_error::MapError;
use crate::pattern::Template;
use crate::raw::RawClock;
use crate::streams::{ArraySource, Clock, Quantity, Rate, TimeBase};
use crate::value::{ArrayName, FoundWord, NumberOr, NumberOrName};

/// Sizes of a factor from the values of an array to SI units: from attonewtons to beyond any converter's counts.
const SCALES: (f64, f64) = (1e-18, 1e18);
/// Rates of a clock against another, ppm: a sampling rate that is off by more is another rate.
const CLOCK_PPM: (f64, f64) = (-1e5, 1e5);

/// Check of a map's rules.
pub(crate) struct Check<'a> {
    pub text: &'a str,
    pub file: &'a str,
    pub errors: Vec<MapError>,
}

const ARRAY: &str = "write the name of the array, such as \"F[:,2]\"";
const RATE: &str = "write a number in Hz, the name of a scalar, or \"file\", or in its place `time` with the name of an array of times";

/// Times as written.
pub(crate) struct RawTime {
    pub rate_hz: Option<NumberOrName>,
    pub time: Option<ArrayName>,
    pub seconds_per_unit: Option<f64>,
}

/// Clock as written.
pub(crate) struct RawClocking {
    pub clock: Option<RawClock>,
    pub offset_s: Option<NumberOr<FoundWord>>,
    pub ppm: Option<NumberOr<FoundWord>>,
}

impl Check<'_> {
    pub fn missing(
        &mut self,
        table: Option<&'static str>,
        key: &'static str,
        remedy: &'static str,
    ) {
        self.errors.push(MapError::Missing {
            file: self.file.to_owned(),
            table,
            key,
            remedy,
        });
    }

    pub fn wrong(&mut self, key: &str, fault: impl Into<String>) {
        let table = key.split_once('.').map_or(key, |(table, _)| table);
        let line =
            strict_toml::line_of(self.text, key).or_else(|| strict_toml::line_of(self.text, table));
        self.errors.push(MapError::Value {
            file: self.file.to_owned(),
            line,
            key: key.to_owned(),
            fault: fault.into(),
        });
    }

    pub fn require<T>(
        &mut self,
        table: &'static str,
        key: &'static str,
        value: Option<T>,
        remedy: &'static str,
    ) -> Option<T> {
        if value.is_none() {
            self.missing(Some(table), key, remedy);
        }
        value
    }

    /// Returns a number within its range.
    pub fn number(
        &mut self,
        key: &str,
        value: f64,
        (low, high): (f64, f64),
        unit: &str,
    ) -> Option<f64> {
        match strict_toml::require_range(key, value, low, high, unit) {
            Ok(()) => Some(value),
            Err(_) => {
                let unit = if unit.is_empty() {
                    String::new()
                } else {
                    format!(" {unit}")
                };
                self.wrong(
                    key,
                    format!("= {value}{unit} is outside {low} to {high}{unit}"),
                );
                None
            }
        }
    }

    /// Returns a scale, which is a number other than 0.
    pub fn scale(
        &mut self,
        table: &'static str,
        key: &'static str,
        value: Option<f64>,
    ) -> Option<f64> {
        let remedy = "write the factor by which a value of the array is multiplied; a negative one turns its direction";
        let value = self.require(table, key, value, remedy)?;
        let key = format!("{table}.{key}");
        if value == 0.0 || value.is_nan() {
            self.wrong(
                &key,
                format!("= {value} makes every value the same; {remedy}"),
            );
            return None;
        }
        self.number(&key, value.abs(), SCALES, "").map(|_| value)
    }

    pub fn finite(&mut self, key: &str, value: f64) -> Option<f64> {
        if !value.is_finite() {
            self.wrong(key, format!("= {value} is not a finite number"));
        }
        value.is_finite().then_some(value)
    }

    pub fn quantity(&mut self, key: &str, value: Option<NumberOr<FoundWord>>) -> Option<Quantity> {
        match value {
            None => Some(Quantity::Stated(0.0)),
            Some(NumberOr::Word(FoundWord::Found)) => Some(Quantity::Found),
            Some(NumberOr::Number(value)) => self.finite(key, value).map(Quantity::Stated),
        }
    }

    pub fn template(&mut self, key: &str, text: Option<&str>) -> Result<Option<Template>, ()> {
        let Some(text) = text else { return Ok(None) };
        match Template::parse(text) {
            Ok(template) => Ok(Some(template)),
            Err(fault) => {
                self.wrong(key, fault);
                Err(())
            }
        }
    }

    pub fn source(
        &mut self,
        table: &'static str,
        file: Option<&str>,
        from: Option<ArrayName>,
    ) -> Option<ArraySource> {
        let file = self.template(&format!("{table}.file"), file);
        let ArrayName(name) = self.require(table, "from", from, ARRAY)?;
        Some(ArraySource {
            file: file.ok()?,
            name,
        })
    }

    /// Returns the times of a stream; `following` are those that it has if it states none.
    pub fn time(
        &mut self,
        table: &'static str,
        raw: RawTime,
        following: Option<&TimeBase>,
    ) -> Option<TimeBase> {
        let RawTime {
            rate_hz,
            time,
            seconds_per_unit,
        } = raw;
        if let (Some(_), None) = (seconds_per_unit, &time) {
            self.wrong(
                &format!("{table}.seconds_per_unit"),
                "is the unit of `time`, which is missing",
            );
            return None;
        }
        match (rate_hz, time) {
            (Some(_), Some(_)) => {
                self.wrong(
                    &format!("{table}.rate_hz"),
                    "and `time` both state the times: delete one",
                );
                None
            }
            (Some(NumberOrName::Number(hz)), None) => {
                let hz = self.number(&format!("{table}.rate_hz"), hz, (1e-2, 1e8), "Hz")?;
                Some(TimeBase::Rate(Rate::Hz(hz)))
            }
            (Some(NumberOrName::Name(name)), None) => Some(TimeBase::Rate(match name.as_str() {
                "file" => Rate::File,
                _ => Rate::Scalar(name),
            })),
            (None, Some(ArrayName(name))) => {
                let key = format!("{table}.seconds_per_unit");
                let seconds_per_unit = match seconds_per_unit {
                    None => None,
                    Some(unit_s) => Some(self.number(&key, unit_s, (1e-15, 1e6), "s")?),
                };
                Some(TimeBase::Column {
                    name,
                    seconds_per_unit,
                })
            }
            (None, None) => match following {
                Some(time) => Some(time.clone()),
                None => self.require(table, "rate_hz", None, RATE),
            },
        }
    }

    pub fn clock(
        &mut self,
        table: &'static str,
        raw: RawClocking,
        following: Option<Clock>,
    ) -> Option<Clock> {
        let RawClocking {
            clock,
            offset_s,
            ppm,
        } = raw;
        if let (None, None, None, Some(following)) = (clock, offset_s, ppm, following) {
            return Some(following);
        }
        for (key, value) in [("offset_s", offset_s), ("ppm", ppm)] {
            if table != "normal" && value == Some(NumberOr::Word(FoundWord::Found)) {
                self.wrong(
                    &format!("{table}.{key}"),
                    "is found for [normal], and the other streams follow it: delete it here, or write a number",
                );
                return None;
            }
        }
        let is_drives = match clock {
            Some(clock) => clock == RawClock::Same,
            None => following.is_some_and(|clock| clock.is_drives),
        };
        let inherited = following.filter(|_| clock.is_none());
        let offset = self.quantity(&format!("{table}.offset_s"), offset_s);
        let rate = self.quantity(&format!("{table}.ppm"), ppm);
        let (offset, rate) = (offset?, rate?);
        if let Quantity::Stated(ppm) = rate {
            self.number(&format!("{table}.ppm"), ppm, CLOCK_PPM, "")?;
        }
        if is_drives && ppm.is_some() && rate != Quantity::Stated(0.0) {
            self.wrong(
                &format!("{table}.ppm"),
                "contradicts clock = \"same\": write clock = \"own\" for samples on a clock of their own, or delete ppm",
            );
            return None;
        }
        Some(Clock {
            is_drives,
            offset_s: match (offset_s, inherited) {
                (None, Some(clock)) => clock.offset_s,
                _ => offset,
            },
            ppm: match (ppm, inherited) {
                (None, Some(clock)) => clock.ppm,
                _ => rate,
            },
        })
    }
}
