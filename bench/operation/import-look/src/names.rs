//! Meanings of names and units in other people's files.

use crate::time_axis::TimeUnit;

/// Roles of arrays in a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Role {
    Drive,
    Pickup,
    Normal,
    Lateral,
    Position,
    Velocity,
    Time,
    /// A quantity that no recording needs: a torque, a temperature, a trigger.
    Other,
}

impl Role {
    /// Returns the role in words; `None` where it has no meaning for a recording.
    pub fn words(self) -> Option<&'static str> {
        Some(match self {
            Self::Drive => "drive",
            Self::Pickup => "pickup",
            Self::Normal => "normal force",
            Self::Lateral => "lateral force",
            Self::Position => "position",
            Self::Velocity => "velocity",
            Self::Time => "time",
            Self::Other => return None,
        })
    }
}

/// Words of names, lower case, by role. A word of one letter or two must be the whole name but for numbers and units.
const WORDS: &[(Role, &[&str])] = &[
    (
        Role::Drive,
        &[
            "drive",
            "drv",
            "excitation",
            "exc",
            "actuator",
            "actuators",
            "piezo",
            "amp",
            "amplifier",
            "volt",
            "voltage",
            "volts",
            "generator",
            "command",
            "u",
            "vin",
            "ua",
        ],
    ),
    (
        Role::Pickup,
        &[
            "pickup",
            "ldv",
            "vib",
            "vibrometer",
            "vibration",
            "polytec",
            "laser",
            "disp",
            "displacement",
            "acc",
            "accel",
            "accelerometer",
            "acceleration",
            "charge",
            "plate",
            "sensing",
            "w",
        ],
    ),
    (
        Role::Normal,
        &[
            "normal",
            "norm",
            "fn",
            "fz",
            "nf",
            "press",
            "pressing",
            "load",
            "normalforce",
            "n",
        ],
    ),
    (
        Role::Lateral,
        &[
            "lateral",
            "lat",
            "ft",
            "fx",
            "tangential",
            "tang",
            "tangent",
            "friction",
            "shear",
            "lateralforce",
            "frictionforce",
            "lf",
            "tf",
        ],
    ),
    (
        Role::Position,
        &[
            "position", "pos", "enc", "encoder", "slider", "stage", "travel", "finger", "counter",
            "count", "counts", "x", "xpos",
        ],
    ),
    (Role::Velocity, &["velocity", "speed", "vel", "v"]),
    (
        Role::Time,
        &[
            "time",
            "times",
            "timestamp",
            "timestamps",
            "t",
            "zeit",
            "temps",
            "tijd",
            "clock",
        ],
    ),
    (
        Role::Other,
        &[
            "tx",
            "ty",
            "tz",
            "mx",
            "my",
            "mz",
            "torque",
            "moment",
            "temp",
            "temperature",
            "humidity",
            "trigger",
            "trig",
            "ttl",
            "sync",
            "fy",
            "rating",
            "block",
            "trial",
            "condition",
        ],
    ),
];

/// Words of scalars that state a rate, Hz, or an interval, s.
const RATES: &[&str] = &[
    "fs",
    "sr",
    "rate",
    "samplerate",
    "samplingrate",
    "samplefrequency",
    "samplingfrequency",
    "fsamp",
    "fsample",
    "freqs",
    "frate",
    "daqrate",
    "ratehz",
    "fshz",
    "samplehz",
];
const INTERVALS: &[&str] = &[
    "dt",
    "deltat",
    "tinc",
    "wfincrement",
    "interval",
    "sampleinterval",
    "samplinginterval",
    "ts",
    "period",
    "step",
];

/// Returns the words of a name, lower case: parted by signs, digits, and capitals after small letters.
pub(crate) fn words(name: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut last = ' ';
    for c in name.chars() {
        let is_boundary = !c.is_alphabetic() || (c.is_uppercase() && last.is_lowercase());
        if is_boundary {
            words.push(String::new());
        }
        if c.is_alphabetic()
            && let Some(word) = words.last_mut()
        {
            word.extend(c.to_lowercase());
        }
        last = c;
    }
    words.retain(|word| !word.is_empty());
    words
}

/// Returns the role that a name states, and the word that states it.
pub(crate) fn role(name: &str) -> Option<(Role, String)> {
    let leaf = leaf(name);
    let stem = without_unit(&leaf);
    let mut words = words(&stem);
    let joined: String = words.concat();
    words.push(joined.clone());
    // The first word with a meaning decides: `normal force drive` is rare, `friction position` too.
    let is_word = |word: &str, known: &str| {
        word == known && (known.len() > 2 || joined.trim_start_matches("ch") == known)
    };
    words.iter().find_map(|word| {
        let entry = WORDS
            .iter()
            .find(|(_, known)| known.iter().any(|known| is_word(word, known)));
        entry.map(|(role, _)| (*role, word.clone()))
    })
}

/// Meaning of a scalar for the rate of the arrays.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum RateWord {
    /// Rate, Hz.
    Rate,
    /// Interval, s.
    Interval,
}

/// Returns whether a scalar's name states a rate or an interval.
pub(crate) fn rate_word(name: &str) -> Option<RateWord> {
    let leaf = leaf(name);
    let words = words(&leaf);
    let joined: String = words.concat();
    let is_among = |list: &[&str]| {
        list.contains(&joined.as_str())
            || words
                .iter()
                .any(|word| word.len() > 1 && list.contains(&word.as_str()))
            || words
                .windows(2)
                .any(|pair| list.contains(&pair.concat().as_str()))
    };
    if is_among(RATES) {
        Some(RateWord::Rate)
    } else if is_among(INTERVALS) {
        Some(RateWord::Interval)
    } else {
        None
    }
}

/// Returns the last part of a name: of `S.force.Fn` and `/daq/Fn` that is `Fn`.
pub(crate) fn leaf(name: &str) -> String {
    let name = name
        .rsplit_once('[')
        .map_or(name, |(stem, _)| if stem.is_empty() { name } else { stem });
    // The slash of a unit parts no names.
    let parts: Vec<&str> = name.split_inclusive(['/', '.', '@']).collect();
    let is_end = |index: usize| {
        index + 1 == parts.len()
            || !(parts[index].ends_with("m/") && parts[index + 1].starts_with('s'))
    };
    let last = (0..parts.len())
        .rev()
        .find(|index| !parts[*index].trim_matches(['/', '.', '@', ' ']).is_empty());
    let Some(last) = last else {
        return name.to_owned();
    };
    let mut first = last;
    while first > 0 && !is_end(first - 1) {
        first -= 1;
    }
    parts[first..=last]
        .concat()
        .trim_end_matches(['/', '.', '@'])
        .to_owned()
}

/// Quantity and SI value of a unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum UnitMeaning {
    Newtons(f64),
    Volts(f64),
    Metres(f64),
    MetresPerSecond(f64),
    MetresPerSquareSecond(f64),
    Coulombs(f64),
    Time(TimeUnit),
    Counts,
}

/// Returns the meaning of a unit.
pub(crate) fn unit_meaning(unit: &str) -> Option<UnitMeaning> {
    use UnitMeaning::{
        Coulombs, Counts, Metres, MetresPerSecond, MetresPerSquareSecond, Newtons, Time, Volts,
    };
    // The standard acceleration of free fall, m/s²: a gram-force is 9.80665 mN.
    const G_MN: f64 = 9.806_65e-3;
    let unit = unit.trim().replace(['μ', 'µ'], "u").replace(' ', "");
    Some(match unit.as_str() {
        "N" | "newton" | "newtons" | "Newton" | "Newtons" => Newtons(1.0),
        "mN" => Newtons(1e-3),
        "uN" => Newtons(1e-6),
        "kN" => Newtons(1e3),
        "gf" | "gram" | "grams" | "g" => Newtons(G_MN),
        "kgf" | "kg" => Newtons(1e3 * G_MN),
        "V" | "volt" | "volts" | "Volt" | "Volts" => Volts(1.0),
        "mV" => Volts(1e-3),
        "kV" => Volts(1e3),
        "m" => Metres(1.0),
        "cm" => Metres(1e-2),
        "mm" => Metres(1e-3),
        "um" => Metres(1e-6),
        "nm" => Metres(1e-9),
        "m/s" | "ms^-1" | "m*s^-1" => MetresPerSecond(1.0),
        "cm/s" => MetresPerSecond(1e-2),
        "mm/s" => MetresPerSecond(1e-3),
        "um/s" => MetresPerSecond(1e-6),
        "m/s^2" | "m/s2" | "m/s²" | "ms^-2" => MetresPerSquareSecond(1.0),
        "pC" => Coulombs(1e-12),
        "nC" => Coulombs(1e-9),
        "counts" | "count" | "ticks" | "pulses" | "cts" => Counts,
        other => Time(TimeUnit::parse(other)?),
    })
}

/// Returns the unit at a name's end: in brackets, or after `_` or a blank.
pub(crate) fn unit_in_name(name: &str) -> Option<String> {
    let leaf = leaf(name);
    let bracketed = [('[', ']'), ('(', ')')]
        .into_iter()
        .find_map(|(open, close)| {
            let (_, unit) = name.trim_end().strip_suffix(close)?.rsplit_once(open)?;
            (unit_meaning(unit).is_some() && unit.parse::<u64>().is_err())
                .then(|| unit.trim().to_owned())
        });
    bracketed.or_else(|| {
        let (stem, unit) = leaf.rsplit_once(['_', ' '])?;
        // A gram or a metre as the last letter of a name is more often an index.
        let is_unit = unit_meaning(unit).is_some() && !matches!(unit, "g" | "kg");
        let unit = unit.replace("mps", "m/s");
        (is_unit && !stem.is_empty()).then_some(unit)
    })
}

/// Returns a name without the unit at its end.
fn without_unit(name: &str) -> String {
    match unit_in_name(name) {
        Some(unit) => name
            .trim_end_matches([']', ')', ' '])
            .trim_end_matches(unit.as_str())
            .to_owned(),
        None => name.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_state_roles() {
        for (name, expected) in [
            ("drive", Some(Role::Drive)),
            ("DriveVoltage", Some(Role::Drive)),
            ("U", Some(Role::Drive)),
            ("S.daq.ldv_1", Some(Role::Pickup)),
            ("/force/Fn", Some(Role::Normal)),
            ("Fz [N]", Some(Role::Normal)),
            ("normal_force_mN", Some(Role::Normal)),
            ("Friction [uN]", Some(Role::Lateral)),
            ("F_t", Some(Role::Lateral)),
            ("Ft_N", Some(Role::Lateral)),
            ("enc", Some(Role::Position)),
            ("x", Some(Role::Position)),
            ("fingerPos (mm)", Some(Role::Position)),
            ("speed_mm/s", Some(Role::Velocity)),
            ("Time [s]", Some(Role::Time)),
            ("t", Some(Role::Time)),
            ("Tz", Some(Role::Other)),
            ("out[:,0]", None),
            ("data", None),
            ("x_of_y", None),
        ] {
            assert_eq!(role(name).map(|(role, _)| role), expected, "{name}");
        }
    }

    #[test]
    fn units_are_found_at_the_end_of_names() {
        for (name, unit) in [
            ("Fz [N]", Some("N")),
            ("Position (mm)", Some("mm")),
            ("F_mN", Some("mN")),
            ("v_mm/s", Some("mm/s")),
            ("Fn", None),
            ("S[2]", None),
            ("x_1", None),
        ] {
            assert_eq!(unit_in_name(name).as_deref(), unit, "{name}");
        }
        assert_eq!(unit_meaning("µN"), Some(UnitMeaning::Newtons(1e-6)));
        assert_eq!(unit_meaning("bananas"), None);
    }

    #[test]
    fn scalars_state_rates_and_intervals() {
        for (name, word) in [
            ("fs", Some(RateWord::Rate)),
            ("S.sr", Some(RateWord::Rate)),
            ("sampleRate", Some(RateWord::Rate)),
            ("Sampling_Rate_Hz", Some(RateWord::Rate)),
            ("force_fs", Some(RateWord::Rate)),
            ("/g/x@fs", Some(RateWord::Rate)),
            ("dt", Some(RateWord::Interval)),
            ("delta_t", Some(RateWord::Interval)),
            ("mass", None),
            ("offset", None),
        ] {
            assert_eq!(rate_word(name), word, "{name}");
        }
    }
}
