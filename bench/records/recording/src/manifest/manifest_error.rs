//! Rules of `recording.toml`, and errors for their violations.

use std::ops::RangeInclusive;

use strict_toml::TomlError;

/// Version of `recording.toml` that this crate writes and reads.
pub const FORMAT: u32 = 1;

/// Maximum number of intervals, and of events, read from a recording.
pub const MAX_ENTRIES: usize = 10_000;
/// Longest total duration of the intervals of a recording, s.
pub const MAX_INTERVALS_S: f64 = 1800.0;
/// Longest total duration of the intervals, as a multiple of the recording's length; intervals may overlap.
pub(super) const MAX_OVERLAP: f64 = 4.0;

/// Error of reading a `recording.toml`.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ManifestReadError {
    /// The text is not TOML, or has an unknown or missing key.
    #[error(transparent)]
    Toml(#[from] TomlError),
    /// A value violates a rule.
    #[error("{file}{}: {rule}", line.map(|line| format!(", line {line}")).unwrap_or_default())]
    Rule {
        /// The file, as the caller named it.
        file: String,
        /// Line of the key, from 1.
        line: Option<usize>,
        /// Violated rule.
        rule: ManifestError,
    },
}

impl ManifestReadError {
    /// Finds the line of a rule's key in the text.
    pub(crate) fn with_line(rule: ManifestError, text: &str, file: &str) -> Self {
        Self::Rule {
            file: file.to_owned(),
            line: rule.key().and_then(|key| strict_toml::line_of(text, &key)),
            rule,
        }
    }
}

/// Violated rule of the manifest.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ManifestError {
    /// TOML cannot represent a value, such as an integer over 2⁶³ − 1.
    #[error("recording.toml cannot be written: {reason}")]
    NotToml {
        /// Error text of the serialiser.
        reason: String,
    },
    /// This program does not support the version.
    #[error("`format` is {value}, but this program reads format {FORMAT} only")]
    Format {
        /// Version in the file.
        value: u32,
    },
    /// A number is outside its range or is not a number.
    #[error("`{key}` is {value}, allowed are {allowed}")]
    Value {
        /// The key, with its tables.
        key: String,
        /// Value of the key.
        value: f64,
        /// Allowed values in words.
        allowed: String,
    },
    /// A text is not one of those allowed.
    #[error("`{key}` is \"{value}\", allowed is {allowed}")]
    Text {
        /// The key, with its tables.
        key: String,
        /// Value of the key.
        value: String,
        /// Allowed values in words.
        allowed: &'static str,
    },
    /// A list has too many entries.
    #[error("`{key}` has {count} entries; at most {MAX_ENTRIES} are read")]
    TooMany {
        /// The list.
        key: &'static str,
        /// Number of its entries.
        count: usize,
    },
    /// A profile has too few positions, or a different number of ratios.
    #[error(
        "`plate.profile` has {positions} `positions_m` and {ratios} `ratios`; it needs as many of both, and at least 2"
    )]
    ProfilePlaces {
        /// Number of positions.
        positions: usize,
        /// Number of ratios.
        ratios: usize,
    },
    /// The total duration of the intervals is too long.
    #[error(
        "`intervals` last {total_s:.1} s together; at most {limit_s:.1} s are analysed: four times the recording's length, and no more than {MAX_INTERVALS_S} s"
    )]
    IntervalTime {
        /// Total duration within the recording, s.
        total_s: f64,
        /// Longest allowed duration, s.
        limit_s: f64,
    },
    /// An interval ends before it starts.
    #[error("`intervals.{index}` ends at {end_s} s, not after its start at {start_s} s")]
    IntervalOrder {
        /// Position in the list, from 0.
        index: usize,
        /// Start, s.
        start_s: f64,
        /// End, s.
        end_s: f64,
    },
    /// Drive and pickup are on the same channel.
    #[error(
        "`channels.drive.index` and `channels.pickup.index` are both {index}; they must differ"
    )]
    SameChannel {
        /// The channel.
        index: u16,
    },
    /// A calibrated recording without a calibration, or an uncalibrated one with a calibration.
    #[error("`hardware.uncalibrated` is {uncalibrated}, but `hardware.calibration` is {}", if *.uncalibrated { "present" } else { "absent" })]
    Calibration {
        /// The flag.
        uncalibrated: bool,
    },
    /// Waived hardware stops without the person who waived them, or the reverse.
    #[error("`hardware.waived` has {} names, but `hardware.waived_by` is {}", waived.len(), if waived.is_empty() { "present" } else { "absent" })]
    Waiver {
        /// The waived hardware stops.
        waived: Vec<String>,
    },
    /// The audio file has no such channel.
    #[error("`{key}` is {index}, but signals.wav has {channels} channels, counted from 0")]
    NoSuchChannel {
        /// The key.
        key: &'static str,
        /// Value of the key.
        index: u16,
        /// Channels in the audio file.
        channels: u16,
    },
    /// `hardware.channel_names` does not name every channel.
    #[error("`hardware.channel_names` has {names} names, but signals.wav has {channels} channels")]
    ChannelNames {
        /// Number of names.
        names: usize,
        /// Channels in the audio file.
        channels: u16,
    },
    /// `hardware.sample_rate_hz` differs from the audio file's.
    #[error("`hardware.sample_rate_hz` is {hardware_hz}, but signals.wav has {audio_hz} Hz")]
    SampleRate {
        /// Rate in the manifest, Hz.
        hardware_hz: u32,
        /// Rate of the audio file, Hz.
        audio_hz: u32,
    },
    /// `channels.rate_hz` differs from the audio file's.
    #[error(
        "`channels.rate_hz` is {stated_hz}, but signals.wav has {audio_hz} Hz; a stated rate differs from that of the header by \
         less than 1 Hz"
    )]
    StatedRate {
        /// Rate in the manifest, Hz.
        stated_hz: f64,
        /// Rate of the audio file, Hz.
        audio_hz: u32,
    },
    /// A key that the streams need is missing.
    #[error(
        "`{key}` is missing, which {reason} needs; a recording of forces alone has neither `carrier_hz` nor `[channels]` nor \
         `[plate]`"
    )]
    MissingKey {
        /// The key.
        key: &'static str,
        /// Streams that need it.
        reason: &'static str,
    },
    /// Envelopes that refer to a carrier that moves.
    #[error(
        "`carrier_hz` is \"follows\" without `[channels]`; envelopes refer to one frequency, which `carrier_hz` states in Hz"
    )]
    MovingEnvelopes,
    /// The modulated carrier is not below half the sampling rate.
    #[error(
        "sample rate {rate_hz} Hz is not above 2 · (`carrier_hz` {carrier_hz} + `modulation_hz` {modulation_hz}) = {} Hz",
        (2e3 * (.carrier_hz + .modulation_hz)).round() / 1e3
    )]
    Undersampled {
        /// Sample rate, Hz.
        rate_hz: f64,
        /// Carrier, Hz.
        carrier_hz: f64,
        /// Modulation, Hz.
        modulation_hz: f64,
    },
}

impl ManifestError {
    /// Returns the dotted key that the rule concerns.
    fn key(&self) -> Option<String> {
        Some(match self {
            Self::NotToml { .. } => return None,
            Self::Format { .. } => "format".to_owned(),
            Self::Value { key, .. } | Self::Text { key, .. } => key.clone(),
            Self::TooMany { key, .. } => (*key).to_owned(),
            Self::ProfilePlaces { .. } => "plate.profile.positions_m".to_owned(),
            Self::IntervalTime { .. } => "intervals".to_owned(),
            Self::IntervalOrder { index, .. } => format!("intervals.{index}.end_s"),
            Self::SameChannel { .. } => "channels.pickup.index".to_owned(),
            Self::Calibration { .. } => "hardware.uncalibrated".to_owned(),
            Self::Waiver { waived } if waived.is_empty() => "hardware.waived_by".to_owned(),
            Self::Waiver { .. } => "hardware.waived".to_owned(),
            Self::NoSuchChannel { key, .. } => (*key).to_owned(),
            Self::ChannelNames { .. } => "hardware.channel_names".to_owned(),
            Self::SampleRate { .. } => "hardware.sample_rate_hz".to_owned(),
            Self::StatedRate { .. } => "channels.rate_hz".to_owned(),
            // The line of the table that needs the key; without it, none.
            Self::MissingKey { .. } => "channels".to_owned(),
            Self::MovingEnvelopes | Self::Undersampled { .. } => "carrier_hz".to_owned(),
        })
    }
}

pub(super) fn value_error(key: &str, value: f64, allowed: &str) -> ManifestError {
    ManifestError::Value {
        key: key.to_owned(),
        value,
        allowed: allowed.to_owned(),
    }
}

pub(super) fn text_error(key: &str, value: &str, allowed: &'static str) -> ManifestError {
    ManifestError::Text {
        key: key.to_owned(),
        value: value.to_owned(),
        allowed,
    }
}

pub(super) fn require(
    holds: bool,
    key: &str,
    value: f64,
    allowed: &str,
) -> Result<(), ManifestError> {
    if holds {
        Ok(())
    } else {
        Err(value_error(key, value, allowed))
    }
}

pub(super) fn require_finite(key: &str, value: f64) -> Result<(), ManifestError> {
    require(value.is_finite(), key, value, "finite numbers")
}

pub(super) fn require_positive(key: &str, value: f64) -> Result<(), ManifestError> {
    require(
        value.is_finite() && value > 0.0,
        key,
        value,
        "finite numbers above 0",
    )
}

pub(super) fn require_not_negative(key: &str, value: f64) -> Result<(), ManifestError> {
    require(
        value.is_finite() && value >= 0.0,
        key,
        value,
        "finite numbers from 0",
    )
}

pub(super) fn require_not_zero(key: &str, value: f64) -> Result<(), ManifestError> {
    require(
        value.is_finite() && value != 0.0,
        key,
        value,
        "finite numbers other than 0",
    )
}

pub(super) fn require_range(
    key: &str,
    value: f64,
    range: RangeInclusive<f64>,
) -> Result<(), ManifestError> {
    require(
        range.contains(&value),
        key,
        value,
        &format!("{} to {}", range.start(), range.end()),
    )
}

pub(super) fn require_from_one(key: &str, value: u32) -> Result<(), ManifestError> {
    require(value >= 1, key, f64::from(value), "whole numbers from 1")
}
