//! `recording.toml`: origin of a recording, and conversion of its samples to volts and metres.
//!
//! Peak amplitudes and exp(+iωt) throughout. [`Streams`] are raw signals, envelopes, or forces alone; the tables `channels`,
//! `plate` and `intervals` are fixed; `participant`,
//! `trial`, `hardware`, `software` and `events` are written by this bench and may be absent in a recording made
//! elsewhere.

mod archive_origin;
pub mod assumed_errors;
mod import_origin;
mod interval;
mod manifest_error;
mod origin;
mod origin_text;
mod raw_manifest;
mod recorded_across;
mod recorded_clock;
mod recorded_contact;
mod recorded_profile;
mod recorded_room;
mod recording_event;
mod standard_errors;
mod streams;
#[cfg(test)]
mod tests;
mod transducers;

pub use archive_origin::{Archived, ArchivedFile};
pub use import_origin::{FoundValue, Imported, ImportedMap, ImportedSource, Origin, PlateAlone};
pub use interval::{RecordedInterval, RecordedIntervalKind};
pub use manifest_error::{FORMAT, MAX_ENTRIES, MAX_INTERVALS_S, ManifestError, ManifestReadError};
pub use origin::{
    CalibrationReference, End, MAX_SEED, Participant, RecordedHardware, RecordedScheduling,
    Software, Trial,
};
pub use protocols::Direction;
pub use recorded_across::{FARTHEST_CREST, RecordedAcross, WAVELENGTHS_M, WavelengthSource};
pub use recorded_clock::{ClockDevice, RecordedClock};
pub use recorded_contact::{Body, RecordedContact};
pub use recorded_profile::{PROFILE_RATIOS, RecordedProfile};
pub use recorded_room::{PRESSURE_HPA, RecordedRoom};
pub use recording_event::{EventKind, QUIET_S, RecordingEvent};
pub use standard_errors::StandardErrors;
pub use streams::{Carrier, Modulation, RecordedEnvelopes, RecordedSignals, Streams};
pub use transducers::{RecordedChannels, RecordedDrive, RecordedPickup, RecordedPlate};

use serde::{Deserialize, Serialize};

use manifest_error::{MAX_OVERLAP, require_from_one};
use raw_manifest::RawManifest;
use streams::StreamKeys;

/// Content of `recording.toml`.
///
/// ```
/// use recording::manifest::{Manifest, ManifestError, ManifestReadError};
///
/// let text = r#"
/// format = 1
/// carrier_hz = 35000.0
/// modulation_hz = 6.0
/// modulation_index = 0.95
/// channels.drive = { index = 0, volts_per_unit = 20.0 }
/// channels.pickup = { index = 1, metres_per_unit = 2e-6, phase_rad = 0.0 }
/// plate = { resonance_hz = 35000.0, modal_mass_kg = 0.008, force_factor_n_per_v = 0.13, centre_m = 0.05 }
/// "#;
/// let manifest = Manifest::parse(text, "recording.toml").unwrap();
/// assert_eq!(manifest.plate().unwrap().modal_mass_kg, 0.008);
///
/// let error = Manifest::parse(&text.replace("0.95", "1.5"), "recording.toml").unwrap_err();
/// assert!(matches!(
///     error,
///     ManifestReadError::Rule { line: Some(5), rule: ManifestError::Value { value: 1.5, .. }, .. }
/// ));
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(try_from = "RawManifest", into = "RawManifest")]
pub struct Manifest {
    /// Version of the file's layout; 1.
    pub format: u32,
    /// Streams from which results follow, with their constants.
    pub streams: Streams,
    /// Body that touches the plate.
    pub contact: RecordedContact,
    /// Standard errors of the constants, from the calibration; if absent, the constants are taken as exact.
    pub standard_errors: Option<StandardErrors>,
    /// Room; if absent, its ambient pressure is not known.
    pub room: Option<RecordedRoom>,
    /// Intervals of the recording with a known meaning.
    pub intervals: Vec<RecordedInterval>,
    /// Participant.
    pub participant: Option<Participant>,
    /// Trial, protocol, and the end of the recording.
    pub trial: Option<Trial>,
    /// Hardware of the recording.
    pub hardware: Option<RecordedHardware>,
    /// Program that wrote the recording.
    pub software: Option<Software>,
    /// Origin, if the recording was imported from files of another program.
    pub origin: Option<Origin>,
    /// Clocks by which readings were placed in time; absent in recordings of earlier versions.
    pub clocks: Vec<RecordedClock>,
    /// Events during the recording.
    pub events: Vec<RecordingEvent>,
}

fn require_format(format: u32) -> Result<(), ManifestError> {
    match format {
        FORMAT => Ok(()),
        value => Err(ManifestError::Format { value }),
    }
}

/// The required keys of a `recording.toml` that describes `signals.wav`.
pub const MINIMAL: &str = include_str!("minimal.toml");
/// Time by which a gap in the drive may precede the report of its output xrun, s.
pub const BEFORE_REPORT_S: f64 = 0.1;
/// Time by which it may follow the report, s: the loop's delay plus the gap itself.
pub const AFTER_REPORT_S: f64 = 0.25;

impl Manifest {
    /// Reads and checks a `recording.toml`; `file` names it in errors.
    ///
    /// # Errors
    /// [`ManifestReadError`] names the key, its line, its value and the allowed values; for unknown keys the nearest
    /// known key.
    pub fn parse(text: &str, file: &str) -> Result<Self, ManifestReadError> {
        let with_line = |rule| ManifestReadError::with_line(rule, text, file);
        let raw: RawManifest = strict_toml::parse(text, file)?;
        let manifest = Self::try_from(raw).map_err(with_line)?;
        let counts = [
            ("intervals", manifest.intervals.len()),
            ("clocks", manifest.clocks.len()),
            ("events", manifest.events.len()),
        ];
        let long_list = counts.into_iter().find(|(_, count)| *count > MAX_ENTRIES);
        let length_result = long_list.map_or(Ok(()), |(key, count)| {
            Err(ManifestError::TooMany { key, count })
        });
        match length_result.and_then(|()| manifest.validate()) {
            Ok(()) => Ok(manifest),
            Err(rule) => Err(with_line(rule)),
        }
    }

    /// Returns the description of `signals.wav`; `None` without raw drive and pickup.
    #[must_use]
    pub fn signals(&self) -> Option<&RecordedSignals> {
        match &self.streams {
            Streams::Signals(signals) => Some(signals),
            Streams::Envelopes(_) | Streams::Forces(_) => None,
        }
    }

    /// Returns the plate; `None` if only forces were recorded.
    #[must_use]
    pub fn plate(&self) -> Option<&RecordedPlate> {
        match &self.streams {
            Streams::Signals(signals) => Some(&signals.plate),
            Streams::Envelopes(envelopes) => Some(&envelopes.plate),
            Streams::Forces(_) => None,
        }
    }

    /// Returns the stated frequency of the carrier, Hz; `None` if it moves, or if only forces were recorded.
    #[must_use]
    pub fn carrier_hz(&self) -> Option<f64> {
        match &self.streams {
            Streams::Signals(signals) => match signals.carrier {
                Carrier::Steady(carrier_hz) => Some(carrier_hz),
                Carrier::Follows => None,
            },
            Streams::Envelopes(envelopes) => Some(envelopes.carrier_hz),
            Streams::Forces(_) => None,
        }
    }

    /// Returns the modulation of drive or stimulus; `None` for forces without a stimulus.
    #[must_use]
    pub fn modulation(&self) -> Option<Modulation> {
        match &self.streams {
            Streams::Signals(signals) => Some(signals.modulation),
            Streams::Envelopes(envelopes) => Some(envelopes.modulation),
            Streams::Forces(modulation) => *modulation,
        }
    }

    /// Returns the text of `recording.toml`; the same manifest always gives the same bytes.
    ///
    /// # Errors
    /// The first violated rule; a manifest that could not be read back is not written.
    pub fn to_toml(&self) -> Result<String, ManifestError> {
        self.validate()?;
        toml::to_string(self).map_err(|error| ManifestError::NotToml {
            reason: error.to_string(),
        })
    }

    /// Returns the intervals without a finger on the plate, s.
    #[must_use]
    pub fn unloaded_s(&self) -> Vec<(f64, f64)> {
        let intervals = self.intervals.iter();
        joined_spans(
            intervals
                .filter(|interval| interval.kind == RecordedIntervalKind::Unloaded)
                .map(|interval| (interval.start_s, interval.end_s)),
        )
    }

    /// Returns the archiving of the recording; `None` if its samples are there, or if it never had any.
    #[must_use]
    pub fn archived(&self) -> Option<&Archived> {
        self.origin.as_ref()?.archived.as_ref()
    }

    /// Returns the plate alone that an import added after the recording; `None` without.
    #[must_use]
    pub fn plate_alone(&self) -> Option<PlateAlone> {
        self.origin.as_ref()?.imported.as_ref()?.plate_alone
    }

    /// Returns the length of the recording itself, s, of which all samples last `duration_s`.
    #[must_use]
    pub fn own_duration_s(&self, duration_s: f64) -> f64 {
        self.plate_alone()
            .map_or(duration_s, |alone| alone.after_s.min(duration_s))
    }

    /// Returns the rate of the samples in which the events count, Hz, of a recording with a stream at `stream_hz`.
    #[must_use]
    pub fn event_rate_hz(&self, stream_hz: f64) -> f64 {
        self.archived()
            .map_or(stream_hz, |archived| archived.sample_rate_hz)
    }

    /// Returns the stretches with the force sensor at the end of its range, s; in order and disjoint.
    #[must_use]
    pub fn saturated_s(&self, rate_hz: f64) -> Vec<(f64, f64)> {
        self.spans_s(EventKind::ForceOverRange, |sample, frames| {
            let end = sample.saturating_add(frames.unwrap_or(1));
            (sample as f64 / rate_hz, end as f64 / rate_hz)
        })
    }

    /// Returns the stretches in which an output xrun may have interrupted the drive, s; in order and disjoint. Recordings
    /// of versions that did not locate the gap state only the time of the xrun's report.
    #[must_use]
    pub fn drive_gaps_s(&self, rate_hz: f64) -> Vec<(f64, f64)> {
        let mut spans_s = self.spans_s(EventKind::OutputXrun, |sample, frames| {
            let report_s = sample as f64 / rate_hz;
            match frames {
                Some(frames) => (report_s, sample.saturating_add(frames) as f64 / rate_hz),
                None => (report_s - BEFORE_REPORT_S, report_s + AFTER_REPORT_S),
            }
        });
        // The drive continued without a gap.
        spans_s.retain(|(from_s, to_s)| to_s > from_s);
        spans_s
    }

    fn spans_s(
        &self,
        kind: EventKind,
        span_s: impl Fn(u64, Option<u64>) -> (f64, f64),
    ) -> Vec<(f64, f64)> {
        let events = self.events.iter().filter(|event| event.kind == kind);
        joined_spans(events.map(|event| span_s(event.sample, event.frames)))
    }

    /// Checks every rule that concerns the manifest alone.
    ///
    /// # Errors
    /// The first violated rule.
    pub fn validate(&self) -> Result<(), ManifestError> {
        require_format(self.format)?;
        self.streams.validate()?;
        if let Some(errors) = &self.standard_errors {
            errors.validate()?;
        }
        if let Some(room) = self.room {
            room.validate()?;
        }
        for (index, interval) in self.intervals.iter().enumerate() {
            interval.validate(index)?;
        }
        if let Some(participant) = &self.participant {
            require_from_one("participant.session", participant.session)?;
        }
        if let Some(trial) = &self.trial {
            trial.validate()?;
        }
        if let Some(hardware) = &self.hardware {
            hardware.validate()?;
        }
        if let Some(origin) = &self.origin {
            origin.validate()?;
        }
        for (index, clock) in self.clocks.iter().enumerate() {
            clock.validate(index)?;
        }
        Ok(())
    }

    /// Checks the intervals against the length of the audio, s.
    ///
    /// # Errors
    /// [`ManifestError::IntervalTime`]: their total duration is too long for their analysis to end in time.
    pub fn validate_length(&self, duration_s: f64) -> Result<(), ManifestError> {
        let clamped_s = |time_s: f64| time_s.clamp(0.0, duration_s);
        let intervals = self.intervals.iter();
        let total_s: f64 = intervals
            .map(|interval| clamped_s(interval.end_s) - clamped_s(interval.start_s))
            .sum();
        let limit_s = (MAX_OVERLAP * duration_s).min(MAX_INTERVALS_S);
        if total_s > limit_s {
            return Err(ManifestError::IntervalTime { total_s, limit_s });
        }
        Ok(())
    }

    /// Checks the manifest against the audio that it describes, and returns the audio's rate, Hz: the stated one, or else that of
    /// the file.
    ///
    /// # Errors
    /// A channel does not exist, or the sampling rate differs from the stated one or is too low for the modulated
    /// carrier.
    pub fn validate_audio(
        &self,
        sample_rate_hz: u32,
        channel_count: u16,
    ) -> Result<f64, ManifestError> {
        let rate_hz = self.validate_signals(sample_rate_hz, channel_count)?;
        if let Some(hardware) = &self.hardware {
            if hardware.sample_rate_hz != sample_rate_hz {
                return Err(ManifestError::SampleRate {
                    hardware_hz: hardware.sample_rate_hz,
                    audio_hz: sample_rate_hz,
                });
            }
            if hardware.channel_names.len() != usize::from(channel_count) {
                return Err(ManifestError::ChannelNames {
                    names: hardware.channel_names.len(),
                    channels: channel_count,
                });
            }
        }
        Ok(rate_hz)
    }

    /// Checks the manifest against the signals that it describes, which may be some of the channels of the hardware, and returns
    /// their rate, Hz.
    ///
    /// # Errors
    /// As [`Manifest::validate_audio`].
    pub fn validate_signals(
        &self,
        sample_rate_hz: u32,
        channel_count: u16,
    ) -> Result<f64, ManifestError> {
        let mut rate_hz = f64::from(sample_rate_hz);
        if let Some(signals) = self.signals() {
            let channels = &signals.channels;
            for (key, index) in [
                ("channels.drive.index", channels.drive.index),
                ("channels.pickup.index", channels.pickup.index),
            ] {
                if index >= channel_count {
                    return Err(ManifestError::NoSuchChannel {
                        key,
                        index,
                        channels: channel_count,
                    });
                }
            }
            if let Some(stated_hz) = channels.rate_hz {
                // A WAV header has a whole number.
                if (stated_hz - rate_hz).abs() >= 1.0 {
                    return Err(ManifestError::StatedRate {
                        stated_hz,
                        audio_hz: sample_rate_hz,
                    });
                }
                rate_hz = stated_hz;
            }
            if let Carrier::Steady(carrier_hz) = signals.carrier {
                let modulation_hz = signals.modulation.frequency_hz;
                if rate_hz <= 2.0 * (carrier_hz + modulation_hz) {
                    return Err(ManifestError::Undersampled {
                        rate_hz,
                        carrier_hz,
                        modulation_hz,
                    });
                }
            }
        }
        Ok(rate_hz)
    }
}

/// Returns spans in order, joined where they overlap or touch.
#[must_use]
pub fn joined_spans(spans: impl IntoIterator<Item = (f64, f64)>) -> Vec<(f64, f64)> {
    let mut spans: Vec<_> = spans.into_iter().collect();
    spans.sort_by(|a, b| a.0.total_cmp(&b.0));
    spans.dedup_by(|next, span| {
        let is_joined = next.0 <= span.1;
        if is_joined {
            span.1 = span.1.max(next.1);
        }
        is_joined
    });
    spans
}

impl TryFrom<RawManifest> for Manifest {
    type Error = ManifestError;

    fn try_from(raw: RawManifest) -> Result<Self, ManifestError> {
        // An unsupported version is named before keys that it may not have.
        require_format(raw.format)?;
        let streams = Streams::from_keys(StreamKeys {
            carrier: raw.carrier_hz,
            modulation_hz: raw.modulation_hz,
            modulation_index: raw.modulation_index,
            channels: raw.channels,
            plate: raw.plate,
        })?;
        Ok(Self {
            format: raw.format,
            streams,
            contact: raw.contact.unwrap_or_default(),
            standard_errors: raw.standard_errors,
            room: raw.room,
            intervals: raw.intervals,
            participant: raw.participant,
            trial: raw.trial,
            hardware: raw.hardware,
            software: raw.software,
            origin: raw.origin,
            clocks: raw.clocks,
            events: raw.events,
        })
    }
}

impl From<Manifest> for RawManifest {
    fn from(manifest: Manifest) -> Self {
        let keys = manifest.streams.into_keys();
        Self {
            format: manifest.format,
            carrier_hz: keys.carrier,
            modulation_hz: keys.modulation_hz,
            modulation_index: keys.modulation_index,
            channels: keys.channels,
            plate: keys.plate,
            contact: (manifest.contact != RecordedContact::default()).then_some(manifest.contact),
            standard_errors: manifest.standard_errors,
            room: manifest.room,
            intervals: manifest.intervals,
            participant: manifest.participant,
            trial: manifest.trial,
            hardware: manifest.hardware,
            software: manifest.software,
            origin: manifest.origin,
            clocks: manifest.clocks,
            events: manifest.events,
        }
    }
}
