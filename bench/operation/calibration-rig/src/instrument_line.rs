//! A line of text from an instrument: a number, its unit, and whether it is a peak, RMS or peak to peak.

use std::fmt;

use config::MeterReads;

/// Smallest magnitude of a number that stands for an overload; SCPI sends 9.9E37.
const OVERLOAD: f64 = 9e37;
/// Words that meters send in place of a number at an overload.
const OVERLOAD_WORDS: [&str; 7] = ["ol", "0l", "ovld", "ovl", "over", "overload", "overrange"];
/// Largest number of words of a unit with its qualifiers, as in `um pk - pk`.
const MOST_WORDS: usize = 4;

/// Names of units in lower case, with their size in SI.
const UNITS: [(&str, Dimension, f64); 28] = [
    ("m", Dimension::Length, 1.0),
    ("meter", Dimension::Length, 1.0),
    ("metre", Dimension::Length, 1.0),
    ("mm", Dimension::Length, 1e-3),
    ("millimeter", Dimension::Length, 1e-3),
    ("millimetre", Dimension::Length, 1e-3),
    ("um", Dimension::Length, 1e-6),
    ("micron", Dimension::Length, 1e-6),
    ("micrometer", Dimension::Length, 1e-6),
    ("micrometre", Dimension::Length, 1e-6),
    ("nm", Dimension::Length, 1e-9),
    ("nanometer", Dimension::Length, 1e-9),
    ("nanometre", Dimension::Length, 1e-9),
    ("pm", Dimension::Length, 1e-12),
    ("picometer", Dimension::Length, 1e-12),
    ("picometre", Dimension::Length, 1e-12),
    ("v", Dimension::Volts, 1.0),
    ("volt", Dimension::Volts, 1.0),
    ("vac", Dimension::Volts, 1.0),
    ("mv", Dimension::Volts, 1e-3),
    ("millivolt", Dimension::Volts, 1e-3),
    ("mvac", Dimension::Volts, 1e-3),
    ("uv", Dimension::Volts, 1e-6),
    ("microvolt", Dimension::Volts, 1e-6),
    ("uvac", Dimension::Volts, 1e-6),
    ("kv", Dimension::Volts, 1e3),
    ("kilovolt", Dimension::Volts, 1e3),
    ("kvac", Dimension::Volts, 1e3),
];

/// Quantity that a line measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Dimension {
    Length,
    Volts,
}

/// Unit of an instrument's lines.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LineUnit {
    dimension: Dimension,
    si: f64,
    /// Quantity of a sine; `None` if the unit states none.
    reads: Option<MeterReads>,
}

impl LineUnit {
    /// Micrometres, peak.
    #[must_use]
    pub fn micrometres() -> Self {
        Self {
            dimension: Dimension::Length,
            si: 1e-6,
            reads: None,
        }
    }

    /// Volts of a meter that reads `reads` of a sine.
    #[must_use]
    pub fn volts(reads: MeterReads) -> Self {
        Self {
            dimension: Dimension::Volts,
            si: 1.0,
            reads: Some(reads),
        }
    }

    /// Returns whether the lines are in volts.
    #[must_use]
    pub fn is_volts(self) -> bool {
        self.dimension == Dimension::Volts
    }

    /// Returns the amplitude of a reading of 1 in SI: the peak of a motion; for volts, in the meter's own quantity.
    fn si_per_reading(self) -> f64 {
        match self.dimension {
            Dimension::Length => self.si * self.reads.map_or(1.0, MeterReads::peak_per_reading),
            Dimension::Volts => self.si,
        }
    }

    /// Returns the quantity of a sine that this unit means: a motion without a qualifier is a peak.
    fn meaning(self) -> MeterReads {
        self.reads.unwrap_or(MeterReads::Peak)
    }

    /// Returns whether a line in `stated` may be read under this unit.
    fn admits(self, stated: Self) -> bool {
        let same_size = (stated.si / self.si - 1.0).abs() < 1e-9;
        let same_reads = stated.reads.is_none_or(|reads| reads == self.meaning());
        self.dimension == stated.dimension && same_size && same_reads
    }
}

impl fmt::Display for LineUnit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut units = UNITS.iter();
        let unit = units.find(|(_, dimension, si)| *dimension == self.dimension && *si == self.si);
        let name = match unit.map_or("", |(name, ..)| name) {
            "um" => "µm",
            "v" => "V",
            "mv" => "mV",
            "uv" => "µV",
            "kv" => "kV",
            name => name,
        };
        f.write_str(name)?;
        match self.reads {
            Some(MeterReads::Rms) => f.write_str(" rms"),
            Some(MeterReads::PeakToPeak) => f.write_str(" pp"),
            Some(MeterReads::Peak) => f.write_str(" peak"),
            None => Ok(()),
        }
    }
}

impl std::str::FromStr for LineUnit {
    type Err = LineFault;

    /// Reads a unit of length, as in `nm`, `um rms` or `mm pp`.
    fn from_str(text: &str) -> Result<Self, LineFault> {
        match unit_of(&words(text)) {
            StatedUnit::Known(unit) if unit.dimension == Dimension::Length => Ok(unit),
            StatedUnit::Refused(fault) => Err(fault),
            _ => Err(LineFault::UnknownUnit {
                unit: text.to_owned(),
            }),
        }
    }
}

/// A number read from a line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct LineReading {
    /// Value in SI: the peak of a motion, m, or the meter's own quantity, V.
    pub si: f64,
    /// Whether the number had a decimal comma.
    pub decimal_comma: bool,
}

/// Reasons for refusing a line with a number.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum LineFault {
    /// The instrument is over its range.
    #[error("reports an overload ({text:?}): choose a larger range")]
    Overload {
        /// Text sent in place of a reading.
        text: String,
    },
    /// The unit is known, but not the expected one.
    #[error(
        "sends {stated}, but {expected} is expected: {}",
        unit_remedy(*stated, *expected)
    )]
    OtherUnit {
        /// Unit in the line.
        stated: LineUnit,
        /// Configured unit.
        expected: LineUnit,
    },
    /// The quantity is a velocity or an acceleration.
    #[error(
        "sends a velocity or an acceleration ({unit}): set it to displacement, or connect its output to an input \
         (--reference-channel, --reference-m-per-s-per-v)"
    )]
    Rate {
        /// Unit in the line.
        unit: String,
    },
    /// The unit is unknown.
    #[error(
        "sends the unit {unit:?}, which is not known: m, mm, um, nm and pm, or V, mV, uV and kV are, each also as rms, pp or peak"
    )]
    UnknownUnit {
        /// Unit in the line.
        unit: String,
    },
    /// A comma could separate decimals or columns.
    #[error(
        "sends {text:?}: a decimal comma, or two columns? Set it to decimal points, or let it send the unit after the number"
    )]
    AmbiguousComma {
        /// Number in the line.
        text: String,
    },
}

fn unit_remedy(stated: LineUnit, expected: LineUnit) -> String {
    if stated.dimension != expected.dimension {
        return "choose the other quantity on the instrument, or another port".to_owned();
    }
    match stated.dimension {
        Dimension::Volts => "set the unit on the meter, or correct --reads".to_owned(),
        Dimension::Length => {
            format!("set the unit on the instrument, or give --instrument-unit \"{stated}\"")
        }
    }
}

enum StatedUnit {
    Absent,
    Known(LineUnit),
    Refused(LineFault),
}

/// Reads a line under the `expected` unit, which a line without a unit has; `None` if it contains no number.
pub(crate) fn read(line: &[u8], expected: LineUnit) -> Result<Option<LineReading>, LineFault> {
    let text = decoded(line);
    let text = text.trim();
    let lower = text.to_lowercase();
    let first = lower.split_whitespace().next().unwrap_or_default();
    let signless = first.trim_start_matches(['+', '-']);
    let overload = || LineFault::Overload {
        text: text.to_owned(),
    };
    if OVERLOAD_WORDS.contains(&signless.trim_end_matches('.'))
        || ["inf", "nan", "infinity"].contains(&signless)
    {
        return Err(overload());
    }
    let length = number_length(text);
    let (number, rest) = text.split_at(length);
    if !is_text(text) || !may_follow_number(rest) {
        return Ok(None);
    }
    let decimal_comma = number.contains(',');
    let Ok(value) = number.replace(',', ".").parse::<f64>() else {
        return Ok(None);
    };
    if !value.is_finite() || value.abs() >= OVERLOAD {
        return Err(overload());
    }
    let unit = match unit_of(&words(rest)) {
        StatedUnit::Refused(fault) => return Err(fault),
        StatedUnit::Known(stated) if !expected.admits(stated) => {
            return Err(LineFault::OtherUnit { stated, expected });
        }
        StatedUnit::Known(_) => Some(expected),
        StatedUnit::Absent => None,
    };
    if decimal_comma && unit.is_none() {
        return Err(LineFault::AmbiguousComma {
            text: number.to_owned(),
        });
    }
    Ok(Some(LineReading {
        si: value * expected.si_per_reading(),
        decimal_comma,
    }))
}

/// Returns the text of a line in UTF-8, or in Latin-1, in which many instruments send µ.
fn decoded(line: &[u8]) -> String {
    match std::str::from_utf8(line) {
        Ok(text) => text.to_owned(),
        Err(_) => line.iter().map(|&byte| char::from(byte)).collect(),
    }
}

/// Returns whether a line has only characters that instruments send; others are those of a disturbed line or of another baud.
fn is_text(text: &str) -> bool {
    let is_known = |c: char| (' '..='~').contains(&c) || c == '\t' || "µμ°²√Ω".contains(c);
    text.chars().all(is_known)
}

/// Returns whether what follows the digits of a number ends it: a separator, a unit or nothing.
fn may_follow_number(rest: &str) -> bool {
    let next = rest.chars().next();
    next.is_none_or(|c| c.is_whitespace() || c.is_alphabetic() || ",;()[]_%\"'".contains(c))
}

/// Returns the length of the number at the start of `text`, in bytes: sign, digits with a decimal point or comma, exponent.
fn number_length(text: &str) -> usize {
    let bytes = text.as_bytes();
    let digits = |start: usize| {
        let tail = bytes.get(start..).unwrap_or_default();
        tail.iter().take_while(|byte| byte.is_ascii_digit()).count()
    };
    let mut end = usize::from(bytes.first().is_some_and(|byte| b"+-".contains(byte)));
    end += digits(end);
    if bytes.get(end).is_some_and(|byte| b".,".contains(byte)) {
        let decimals = digits(end + 1);
        let is_point = bytes.get(end) == Some(&b'.');
        if is_point || decimals > 0 {
            end += 1 + decimals;
        }
    }
    if bytes.get(end).is_some_and(|byte| b"eE".contains(byte)) {
        let sign = usize::from(bytes.get(end + 1).is_some_and(|byte| b"+-".contains(byte)));
        let exponent = digits(end + 1 + sign);
        if exponent > 0 {
            end += 1 + sign + exponent;
        }
    }
    end
}

/// Returns the words after a number, in lower case with `u` for µ.
fn words(text: &str) -> Vec<String> {
    let text = text.replace(['µ', 'μ'], "u").to_lowercase();
    let words = text.split(|c: char| c.is_whitespace() || ",;()[]_".contains(c));
    let words = words.filter(|word| !word.is_empty());
    words.map(str::to_owned).collect()
}

/// Returns the unit that the words after a number state.
fn unit_of(words: &[String]) -> StatedUnit {
    let Some(first) = words.first() else {
        return StatedUnit::Absent;
    };
    // A further column of numbers states no unit.
    if !first.starts_with(|c: char| c.is_alphabetic()) {
        return StatedUnit::Absent;
    }
    let refused = |unit: &str| {
        StatedUnit::Refused(
            if unit.contains("/s") || unit.ends_with("s-1") || unit.ends_with("s^-1") {
                LineFault::Rate {
                    unit: unit.to_owned(),
                }
            } else {
                LineFault::UnknownUnit {
                    unit: unit.to_owned(),
                }
            },
        )
    };
    for count in (1..=words.len().min(MOST_WORDS)).rev() {
        let Some(joined) = words.get(..count).map(<[String]>::concat) else {
            continue;
        };
        let Some(mut unit) = known_unit(&joined) else {
            continue;
        };
        // A qualifier may stand behind further columns.
        let later = words.iter().skip(count).find_map(|word| qualifier(word));
        unit.reads = unit.reads.or(later);
        return StatedUnit::Known(unit);
    }
    refused(first)
}

/// Returns the unit of a word such as `um`, `umrms`, `vpk-pk` or `microns`.
fn known_unit(word: &str) -> Option<LineUnit> {
    UNITS.iter().find_map(|&(name, dimension, si)| {
        let rest = word.strip_prefix(name)?;
        let rest = rest
            .strip_prefix('s')
            .filter(|_| name.len() > 4)
            .unwrap_or(rest);
        let reads = match rest.trim_matches(['.', '-']) {
            "" => None,
            rest => Some(qualifier(rest)?),
        };
        Some(LineUnit {
            dimension,
            si,
            reads,
        })
    })
}

/// Returns the quantity of a sine that a word names.
fn qualifier(word: &str) -> Option<MeterReads> {
    let letters: String = word.chars().filter(|c| c.is_alphanumeric()).collect();
    match &*letters {
        "rms" | "eff" | "acrms" => Some(MeterReads::Rms),
        "pp" | "pkpk" | "ptp" | "p2p" | "pktopk" | "peaktopeak" | "peakpeak" | "ss" => {
            Some(MeterReads::PeakToPeak)
        }
        "pk" | "peak" | "0p" | "0pk" | "op" | "zp" | "p" | "peak0" => Some(MeterReads::Peak),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn micrometres(line: &str) -> Result<Option<f64>, LineFault> {
        let reading = read(line.as_bytes(), LineUnit::micrometres())?;
        Ok(reading.map(|reading| (reading.si * 1e12).round() * 1e-6))
    }

    #[test]
    fn a_line_is_read_only_in_the_expected_unit() {
        for (line, um) in [
            ("1.25", 1.25),
            ("+1.25E+00", 1.25),
            ("1.25um", 1.25),
            ("1.25 µm", 1.25),
            ("1.25 UM PK", 1.25),
            ("1.25 microns, 35012.5", 1.25),
            ("1,25 um", 1.25),
            ("1.25;35012.5", 1.25),
            ("1.25 um 35012.5 Hz peak", 1.25),
        ] {
            assert_eq!(micrometres(line), Ok(Some(um)), "{line}");
        }
        let latin_1 = read(b"1.25 \xb5m", LineUnit::micrometres()).unwrap();
        assert!(latin_1.is_some_and(|reading| (reading.si - 1.25e-6).abs() < 1e-18));
        for line in [
            "",
            "ready",
            "#begin",
            "-",
            "peak 1.25 um",
            "0.4.2",
            "0.4:2",
            "0.4\u{1}",
        ] {
            assert_eq!(micrometres(line), Ok(None), "{line}");
        }
        // Regression test: a byte of a disturbed line ended the number before it.
        for line in [&b"0.4\xb600"[..], b"0.4\xff", b"0.4\x0012"] {
            assert_eq!(read(line, LineUnit::micrometres()), Ok(None), "{line:?}");
        }
        for (line, names) in [
            ("0.00125 mm", "sends mm, but µm"),
            ("1250 nm", "\"nm\""),
            ("1.25e-6 m", "sends m,"),
            ("1250000 pm", "sends pm"),
            ("0.88 um rms", "sends µm rms"),
            ("2.5 umpp", "\"µm pp\""),
            ("2.5 um pk-pk", "pp"),
            ("2.5 um 35012.5 Hz rms", "rms"),
            ("0.275 m/s", "velocity"),
            ("275 mm/s rms", "velocity"),
            ("1.25 V", "sends V"),
            ("1.25 dB", "\"db\""),
            ("9.9E37", "overload"),
            ("-9.90000E+37 um", "overload"),
            ("OVLD", "overload"),
            ("OL", "overload"),
            ("inf", "overload"),
            ("1,25", "decimal comma"),
            ("1,25,35012", "decimal comma"),
        ] {
            let fault = micrometres(line).expect_err(line).to_string();
            assert!(fault.contains(names), "{line}: {fault}");
        }
    }

    #[test]
    fn a_configured_unit_converts_to_a_peak_in_metres() {
        for (unit, line, m) in [
            ("nm", "420 nm", 420e-9),
            ("nm", "420", 420e-9),
            ("mm", "0.00042 mm pk", 420e-9),
            ("m", "4.2e-7", 420e-9),
            ("um rms", "0.3 um rms", 0.3e-6 * std::f64::consts::SQRT_2),
            ("um pp", "0.84", 420e-9),
        ] {
            let unit: LineUnit = unit.parse().unwrap();
            let reading = read(line.as_bytes(), unit).unwrap().unwrap();
            assert!(
                (reading.si / m - 1.0).abs() < 1e-9,
                "{unit} {line}: {reading:?}"
            );
        }
        for (unit, line) in [
            ("um rms", "0.3 um pp"),
            ("um pp", "0.3 um rms"),
            ("nm", "0.42 um"),
        ] {
            let unit: LineUnit = unit.parse().unwrap();
            assert!(read(line.as_bytes(), unit).is_err(), "{unit} {line}");
        }
        for unit in ["V", "mm/s", "dB", ""] {
            assert!(unit.parse::<LineUnit>().is_err(), "{unit}");
        }
    }

    #[test]
    fn a_meter_that_states_another_quantity_than_configured_is_refused() {
        let rms = LineUnit::volts(MeterReads::Rms);
        for line in ["7.07 V", "7.07", "7.07 VAC", "7.07 Vrms", "7.07 V RMS"] {
            let reading = read(line.as_bytes(), rms).unwrap().unwrap();
            assert!((reading.si - 7.07).abs() < 1e-12, "{line}");
        }
        for line in ["20 Vpp", "10 V peak", "7070 mV", "7.07 VDC", "7.07 um"] {
            assert!(read(line.as_bytes(), rms).is_err(), "{line}");
        }
    }
}
