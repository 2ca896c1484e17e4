//! Meanings of names in other people's files.

use crate::name_parts::{leaf, words};
use crate::units::without_unit;

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
            "theta",
            "phase",
            "phi",
            "angle",
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

/// Returns the part of a scalar's name beside the word of a rate: `x` of `x_fs`; empty without one.
pub(crate) fn beside_rate_word(name: &str) -> String {
    let words = words(&leaf(name));
    let is_rate = |word: &str| RATES.contains(&word) || INTERVALS.contains(&word);
    let filler = ["hz", "sampling", "sample", "s", "ms", "khz"];
    words
        .into_iter()
        .filter(|word| !is_rate(word) && !filler.contains(&word.as_str()))
        .collect()
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
