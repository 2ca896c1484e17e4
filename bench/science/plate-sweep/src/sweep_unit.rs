//! Units of a sweep's columns.

use crate::swept_quantity::SweptQuantity;

/// Unit of a column.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum SweepUnit {
    /// A frequency, with its size in hertz.
    Frequency(f64),
    /// A quantity of the response, with its size in the SI unit.
    Response(SweptQuantity, f64),
    /// Decibels, of a quantity and a reference in its SI unit if they are stated.
    Decibels(Option<(SweptQuantity, f64)>),
    /// An angle, with its size in radians.
    Angle(f64),
}

const PREFIXES: [(&str, f64); 9] = [
    ("", 1.0),
    ("G", 1e9),
    ("M", 1e6),
    ("k", 1e3),
    ("m", 1e-3),
    ("µ", 1e-6),
    ("u", 1e-6),
    ("n", 1e-9),
    ("p", 1e-12),
];

impl SweepUnit {
    /// Reads a unit, as in `kHz`, `µS`, `Ohm`, `(mm/s)/V`, `dB re 1 nm/V` or `°`.
    pub(crate) fn parse(text: &str) -> Option<Self> {
        let text = plain(text);
        let lower = text.to_lowercase();
        match lower.as_str() {
            "deg" | "°" | "degree" | "degrees" | "grad°" => {
                return Some(Self::Angle(1f64.to_radians()));
            }
            "rad" | "radian" | "radians" => return Some(Self::Angle(1.0)),
            "mrad" => return Some(Self::Angle(1e-3)),
            "hertz" => return Some(Self::Frequency(1.0)),
            "mhz" if text != "mHz" => return Some(Self::Frequency(1e6)),
            "khz" => return Some(Self::Frequency(1e3)),
            "ghz" => return Some(Self::Frequency(1e9)),
            "hz" => return Some(Self::Frequency(1.0)),
            _ => {}
        }
        if let Some(rest) = lower.strip_prefix("db") {
            let reference = &text[text.len() - rest.len()..];
            let reference = reference
                .trim_start_matches([',', ':'])
                .trim_start_matches("re")
                .trim_start_matches("l")
                .trim_start_matches('1');
            return match reference {
                "" => Some(Self::Decibels(None)),
                unit => match Self::parse(unit)? {
                    Self::Response(quantity, size) => Some(Self::Decibels(Some((quantity, size)))),
                    _ => None,
                },
            };
        }
        prefixed(&text, &["rad/s", "rad/sec", "rads^-1"])
            .map(|size| Self::Frequency(size / std::f64::consts::TAU))
            .or_else(|| prefixed(&text, &["Hz"]).map(Self::Frequency))
            .or_else(|| response_unit(&text))
    }
}

/// Returns a unit without blanks, brackets and signs of multiplication, in one of the ways to write each sign.
fn plain(text: &str) -> String {
    let unified = text
        .replace('\u{3bc}', "µ")
        .replace('\u{2126}', "Ω")
        .replace("⁻¹", "^-1");
    let is_kept = |c: &char| !c.is_whitespace() && !matches!(c, '(' | ')' | '[' | ']' | '·' | '*');
    unified.chars().filter(is_kept).collect()
}

/// Returns the size of a unit with a prefix; `None` for another unit.
fn prefixed(text: &str, units: &[&str]) -> Option<f64> {
    let mut sizes = units.iter().filter_map(|unit| {
        let prefix = text.strip_suffix(unit)?;
        let mut prefixes = PREFIXES.iter();
        prefixes
            .find(|(name, _)| *name == prefix)
            .map(|(_, size)| *size)
    });
    sizes.next()
}

fn response_unit(text: &str) -> Option<SweepUnit> {
    const SIEMENS: &[&str] = &["S", "siemens", "Siemens", "mho", "Mho", "A/V"];
    const OHM: &[&str] = &["Ω", "ohm", "Ohm", "OHM", "ohms", "Ohms", "V/A"];
    const INVERSE: [&str; 2] = ["1/", "^-1"];
    if let Some(size) = prefixed(text, SIEMENS) {
        return Some(SweepUnit::Response(SweptQuantity::Admittance, size));
    }
    if let Some(size) =
        prefixed(text, OHM).or_else(|| prefixed(text, &["Kohm", "KΩ", "KOhm"]).map(|_| 1e3))
    {
        return Some(SweepUnit::Response(SweptQuantity::Impedance, size));
    }
    let inverse = text
        .strip_prefix(INVERSE[0])
        .or_else(|| text.strip_suffix(INVERSE[1]));
    if let Some(size) = inverse.and_then(|unit| prefixed(unit, OHM)) {
        return Some(SweepUnit::Response(SweptQuantity::Admittance, size.recip()));
    }
    // Metres, or metres per second, over volts.
    let motion = text
        .replace("s^-1V^-1", "/s/V")
        .replace("V^-1", "/V")
        .replace("/sV", "/s/V")
        .replace("/Vs", "/s/V");
    let (motion, volts) = motion.rsplit_once('/')?;
    let volts = prefixed(volts, &["V", "Vp", "Vpk"])?;
    let velocity = motion.strip_suffix("/s");
    let quantity = match velocity {
        Some(_) => SweptQuantity::Velocity,
        None => SweptQuantity::Displacement,
    };
    let metres = prefixed(velocity.unwrap_or(motion), &["m"])?;
    Some(SweepUnit::Response(quantity, metres / volts))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{PI, TAU};

    #[test]
    fn units_are_read_as_instruments_write_them() {
        let response = |quantity, size| Some(SweepUnit::Response(quantity, size));
        use SweptQuantity::{Admittance, Displacement, Impedance, Velocity};
        for (text, unit) in [
            ("Hz", Some(SweepUnit::Frequency(1.0))),
            ("KHZ", Some(SweepUnit::Frequency(1e3))),
            ("MHz", Some(SweepUnit::Frequency(1e6))),
            ("rad/s", Some(SweepUnit::Frequency(1.0 / TAU))),
            ("mS", response(Admittance, 1e-3)),
            ("uS", response(Admittance, 1e-6)),
            ("\u{3bc}S", response(Admittance, 1e-6)),
            ("1/kΩ", response(Admittance, 1e-3)),
            ("Ω⁻¹", response(Admittance, 1.0)),
            ("\u{2126}", response(Impedance, 1.0)),
            ("kOhm", response(Impedance, 1e3)),
            ("Kohm", response(Impedance, 1e3)),
            ("MΩ", response(Impedance, 1e6)),
            ("µm/V", response(Displacement, 1e-6)),
            ("nm / V", response(Displacement, 1e-9)),
            ("(mm/s)/V", response(Velocity, 1e-3)),
            ("mm/(s·V)", response(Velocity, 1e-3)),
            ("m s⁻¹ V⁻¹", response(Velocity, 1.0)),
            ("dB", Some(SweepUnit::Decibels(None))),
            (
                "dB re 1 mS",
                Some(SweepUnit::Decibels(Some((Admittance, 1e-3)))),
            ),
            (
                "dB (m/V)",
                Some(SweepUnit::Decibels(Some((Displacement, 1.0)))),
            ),
            ("dBΩ", Some(SweepUnit::Decibels(Some((Impedance, 1.0))))),
            ("°", Some(SweepUnit::Angle(PI / 180.0))),
            ("Degrees", Some(SweepUnit::Angle(PI / 180.0))),
            ("rad", Some(SweepUnit::Angle(1.0))),
            ("s", None),
            ("V", None),
            ("m", None),
            ("Y", None),
            ("", None),
        ] {
            let read = SweepUnit::parse(text);
            let (read, unit) = (format!("{read:.12?}"), format!("{unit:.12?}"));
            assert_eq!(read, unit, "{text:?}");
        }
    }
}
