//! Sound devices and their capabilities.

use std::{
    collections::{BTreeMap, BTreeSet},
    fmt,
};

use crate::stream_health::StreamDirection;

/// Sampling rates that a device accepts.
///
/// ```
/// use signalgen::audio::RateRange;
///
/// assert_eq!(RateRange::new(44_100, 192_000).to_string(), "44100–192000 Hz");
/// assert_eq!(RateRange::new(4_000, u32::MAX).to_string(), "any rate");
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum RateRange {
    /// Any rate: the device has no converter, or a layer that resamples.
    Any,
    /// A range of rates.
    Within {
        /// Lowest sample rate, Hz.
        min_hz: u32,
        /// Highest sample rate, Hz.
        max_hz: u32,
    },
}

impl RateRange {
    /// Returns the range that a backend reports, Hz; a highest rate of [`u32::MAX`] stands for any rate.
    #[must_use]
    pub fn new(min_hz: u32, max_hz: u32) -> Self {
        if max_hz == u32::MAX {
            Self::Any
        } else {
            Self::Within { min_hz, max_hz }
        }
    }

    /// Returns whether the device accepts this rate.
    #[must_use]
    pub fn contains(self, rate_hz: u32) -> bool {
        match self {
            Self::Any => true,
            Self::Within { min_hz, max_hz } => (min_hz..=max_hz).contains(&rate_hz),
        }
    }
}

impl fmt::Display for RateRange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Any => f.write_str("any rate"),
            Self::Within { min_hz, max_hz } if min_hz == max_hz => write!(f, "{min_hz} Hz"),
            Self::Within { min_hz, max_hz } => write!(f, "{min_hz}–{max_hz} Hz"),
        }
    }
}

/// One combination of channels, rates and format that a device offers in one direction.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Capability {
    /// Number of channels.
    pub channels: u16,
    /// Sample rates.
    pub rates: RateRange,
    /// Sample format, by the backend's name: one of [`crate::StreamFormat`], or another that this crate does not use.
    pub format: String,
}

/// Capabilities of a device in one direction.
///
/// Displayed in one line; capabilities that differ only in channels are combined: `1–4, 8 ch f32 192000 Hz`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Offer {
    /// The device does not report its capabilities, for example because another program holds it.
    Unreported,
    /// The device reports these; empty if it has only sample formats that cpal cannot express.
    Listed(Vec<Capability>),
}

impl Offer {
    /// Returns the capabilities that the device reports.
    #[must_use]
    pub fn capabilities(&self) -> &[Capability] {
        match self {
            Self::Unreported => &[],
            Self::Listed(capabilities) => capabilities,
        }
    }
}

impl fmt::Display for Offer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unreported => f.write_str("not reported (another program may hold the device)"),
            Self::Listed(capabilities) if capabilities.is_empty() => {
                f.write_str("no usable sample format (JACK may reach the device)")
            }
            Self::Listed(capabilities) => f.write_str(&summarise(capabilities)),
        }
    }
}

fn summarise(capabilities: &[Capability]) -> String {
    let mut kinds: BTreeMap<(&str, RateRange), BTreeSet<u16>> = BTreeMap::new();
    for c in capabilities {
        kinds
            .entry((&c.format, c.rates))
            .or_default()
            .insert(c.channels);
    }
    let lines = kinds
        .into_iter()
        .map(|((format, rates), channels)| format!("{} ch {format} {rates}", runs(&channels)));
    lines.collect::<Vec<_>>().join("; ")
}

/// Returns numbers with consecutive runs shortened: `1–4, 8`.
fn runs(numbers: &BTreeSet<u16>) -> String {
    let mut runs: Vec<(u16, u16)> = Vec::new();
    for &number in numbers {
        match runs.last_mut() {
            Some((_, last)) if number - *last == 1 => *last = number,
            _ => runs.push((number, number)),
        }
    }
    let ranges = runs.into_iter().map(|(first, last)| {
        if first == last {
            first.to_string()
        } else {
            format!("{first}–{last}")
        }
    });
    ranges.collect::<Vec<_>>().join(", ")
}

/// A sound device.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DeviceInfo {
    /// Identifier, `host:device`; stable across runs.
    pub id: String,
    /// Descriptive name.
    pub name: String,
    /// Whether no software of the host stands between this device and the converter: an ALSA `hw:` device, or any device of a
    /// host without such layers. Other ALSA devices may resample.
    pub is_raw: bool,
    /// Whether the device belongs to a sound card. ALSA also lists purely software devices, such as `null` and `default`.
    pub is_sound_card: bool,
    /// Capabilities of the output; `None` if the device has no output.
    pub output: Option<Offer>,
    /// Capabilities of the input; `None` if the device has no input.
    pub input: Option<Offer>,
}

impl DeviceInfo {
    /// Returns the capabilities in one direction; `None` if the device does not have that direction.
    #[must_use]
    pub fn offer(&self, direction: StreamDirection) -> Option<&Offer> {
        match direction {
            StreamDirection::Output => self.output.as_ref(),
            StreamDirection::Input => self.input.as_ref(),
        }
    }
}

impl fmt::Display for DeviceInfo {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ({})", self.id, self.name)
    }
}

/// Returns whether an ALSA device, given its id without the host, is the hardware itself, without a layer that resamples.
pub(super) fn is_alsa_hardware(local_id: &str) -> bool {
    local_id.starts_with("hw:")
}

/// Returns whether an ALSA device, given its id without the host, belongs to a card.
pub(super) fn names_an_alsa_card(local_id: &str) -> bool {
    let (layer, location) = local_id.split_once(':').unwrap_or((local_id, ""));
    location.contains("CARD=") || ["hw", "plughw"].contains(&layer)
}

/// Moves sound cards before purely software devices; otherwise keeps the order.
pub(super) fn sound_cards_first(devices: &mut [DeviceInfo]) {
    devices.sort_by_key(|device| !device.is_sound_card);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn capability(channels: u16, min_hz: u32, max_hz: u32, format: &str) -> Capability {
        Capability {
            channels,
            rates: RateRange::new(min_hz, max_hz),
            format: format.to_owned(),
        }
    }

    #[test]
    fn capabilities_that_differ_in_channels_alone_are_listed_together() {
        let offer = Offer::Listed(vec![
            capability(1, 44_100, 192_000, "i32"),
            capability(2, 44_100, 192_000, "i32"),
            capability(8, 44_100, 192_000, "i32"),
            capability(2, 44_100, 44_100, "f32"),
        ]);
        assert_eq!(
            offer.to_string(),
            "2 ch f32 44100 Hz; 1–2, 8 ch i32 44100–192000 Hz"
        );
    }

    #[test]
    fn absurd_ranges_of_rates_are_any_rate() {
        let null = Offer::Listed(vec![
            capability(1, 1, u32::MAX, "i16"),
            capability(2, 4_000, u32::MAX, "i16"),
        ]);
        assert_eq!(null.to_string(), "1–2 ch i16 any rate");
        for rate_hz in [1, 192_000] {
            assert!(RateRange::new(4_000, u32::MAX).contains(rate_hz));
        }
    }

    #[test]
    fn ranges_of_rates_include_both_ends() {
        let rates = RateRange::new(44_100, 192_000);
        assert!(rates.contains(44_100) && rates.contains(192_000));
        assert!(!rates.contains(44_099) && !rates.contains(192_001));
    }

    #[test]
    fn devices_of_software_alone_are_no_sound_cards_and_come_last() {
        let device = |local_id: &str| DeviceInfo {
            id: format!("alsa:{local_id}"),
            name: local_id.to_owned(),
            is_raw: is_alsa_hardware(local_id),
            is_sound_card: names_an_alsa_card(local_id),
            output: None,
            input: None,
        };
        let capabilities = [
            "null",
            "hw:CARD=1,DEV=0",
            "default",
            "pulse",
            "front:CARD=USB,DEV=0",
            "sysdefault:CARD=USB",
            "plughw:0",
            "hw:0,0",
            "speexrate",
        ];
        let mut devices: Vec<DeviceInfo> = capabilities.into_iter().map(device).collect();
        sound_cards_first(&mut devices);
        let names: Vec<&str> = devices.iter().map(|device| device.name.as_str()).collect();
        assert_eq!(
            names,
            [
                "hw:CARD=1,DEV=0",
                "front:CARD=USB,DEV=0",
                "sysdefault:CARD=USB",
                "plughw:0",
                "hw:0,0",
                "null",
                "default",
                "pulse",
                "speexrate",
            ]
        );
        assert_eq!(devices.iter().filter(|d| d.is_sound_card).count(), 5);
    }
}
