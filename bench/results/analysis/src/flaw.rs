//! Defects of recordings that can still be analysed, and the remedies.

use std::path::PathBuf;

use num_complex::Complex64;

use crate::explorations::coinciding;
use crate::measurements::LONGEST_GAP_S;
use crate::unloaded_plate::UnloadedError;
use plausibility::zero_stretch::Axis;
use plausibility::{EqualTail, Implausible};
use protocols::Direction;
use recording::{FileName, file_name, reader};
use serde::{Deserialize, Serialize};
use statistics::significant;

pub use plausibility::Channel;

/// Stream that a recording lacks, with the results that lack it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, thiserror::Error)]
pub enum MissingStream {
    /// Forces.
    #[error(
        "force.csv is missing: there are no friction, no fits and no check of the self-sensed force; amplitudes and impedances stand"
    )]
    Forces,
    /// Positions.
    #[error(
        "position.csv is missing: there are no speed, no place on the plate and no selected instances, so no fits; amplitudes, \
         impedances and friction over time stand"
    )]
    Positions,
    /// Drive and pickup.
    #[error(
        "neither signals.wav nor envelopes.parquet: there are no amplitudes, impedances, gaps and fits; friction stands"
    )]
    Vibration,
}

/// Defect of a recording that can still be analysed, fully or in part.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[non_exhaustive]
pub enum Flaw {
    /// A file has a defect.
    #[error(transparent)]
    File(#[from] reader::Warning),
    /// Faults were injected on purpose during the recording.
    #[error("a rehearsal, not data: faults were injected: {}", .faults.join(", "))]
    Rehearsed {
        /// Injected faults, as requested.
        faults: Vec<String>,
    },
    /// The copy of the session's protocol cannot be read, so the settings' selection rules were used.
    #[error(
        "the copy of the session's protocol cannot be read, so instances were selected by the settings' rules: {reason}"
    )]
    ProtocolCopy {
        /// Path of the copy.
        path: PathBuf,
        /// Reason of the failure; names the file and, if known, the line.
        reason: String,
    },
    /// The session has several copies of its protocol, and the recording does not name the one that it followed.
    #[error(
        "the session was resumed with an edited protocol, and the recording does not name the copy that it followed: instances were selected by {followed}"
    )]
    ProtocolCopies {
        /// Copy with the rules that selected the instances.
        followed: String,
    },
    /// Samples are NaN or infinite.
    #[error("{channel}: {samples} samples are NaN or infinite; affected results are left out")]
    LostSamples {
        /// Channel of the samples.
        channel: Channel,
        /// Number of samples.
        samples: u64,
    },
    /// The converter's limit was reached.
    #[error(
        "{channel} clipped: {samples} samples at ±{level} of full scale; affected results are left out"
    )]
    Clipped {
        /// Channel that clipped.
        channel: Channel,
        /// Samples at the limit.
        samples: u64,
        /// The limit, in sample values.
        level: f32,
    },
    /// The carrier is not in the signal.
    #[error(
        "{channel}: the carrier of {} Hz is not in the signal ({ratio_db:.0} dB of all else)",
        significant(*.carrier_hz)
    )]
    CarrierMissing {
        /// Channel of the signal.
        channel: Channel,
        /// The carrier, Hz.
        carrier_hz: f64,
        /// Ratio of the carrier's power to that of the rest, dB.
        ratio_db: f64,
    },
    /// The signal contains much besides the carrier: DC, hum, other tones, noise.
    #[error("{channel}: the carrier is only {ratio_db:.0} dB above all else in the signal")]
    CarrierWeak {
        /// Channel of the signal.
        channel: Channel,
        /// Ratio of the carrier's power to that of the rest, dB.
        ratio_db: f64,
    },
    /// The drive's carrier differs from the stated frequency.
    #[error(
        "drive: the carrier is at {measured_hz:.1} Hz, not at {stated_hz:.1} Hz as recording.toml says; farther than 300 Hz away the amplitude would read low"
    )]
    CarrierElsewhere {
        /// Measured frequency, Hz.
        measured_hz: f64,
        /// Stated frequency, Hz.
        stated_hz: f64,
    },
    /// Readings are such as no finger and no sound channel makes.
    #[error(transparent)]
    Implausible(#[from] Implausible),
    /// Readings lie outside the recording's time.
    #[error(
        "{file}: its times run from {from_s:.3} to {to_s:.3} s, but the recording from 0 to {duration_s:.3} s: is it on another clock? time_s counts from the first sample of signals.wav"
    )]
    ElsewhereInTime {
        /// Name of the file.
        #[serde(deserialize_with = "file_name")]
        file: FileName,
        /// Time of the first row, s.
        from_s: f64,
        /// Time of the last row, s.
        to_s: f64,
        /// Length of the audio, s.
        duration_s: f64,
    },
    /// Readings are too far apart.
    #[error(
        "{file}: its rows are {:.0} ms apart; where readings are more than {:.0} ms apart nothing is estimated",
        step_s * 1e3, LONGEST_GAP_S * 1e3
    )]
    Sparse {
        /// Name of the file.
        #[serde(deserialize_with = "file_name")]
        file: FileName,
        /// Median interval of the rows, s.
        step_s: f64,
    },
    /// The forces end in zeros.
    #[error(
        "force.csv: normal_n and lateral_n are exactly 0 in the last {rows} rows, from {from_s:.3} s on: the program that wrote the file \
         filled it up, or the sensor stopped; delete these rows"
    )]
    ZeroTail {
        /// Number of rows.
        rows: usize,
        /// Time of the first one, s.
        from_s: f64,
    },
    /// The forces end in equal rows.
    #[error(
        "force.csv: normal_n and lateral_n stay at {} and {} N in the last {rows} rows, from {from_s:.3} s on: the sensor stopped, or the \
         program that wrote the file repeated its last values; delete these rows",
        significant(*normal_n), significant(*lateral_n)
    )]
    HeldTail {
        /// Number of rows.
        rows: usize,
        /// Time of the first one, s.
        from_s: f64,
        /// Normal force in each, N.
        normal_n: f64,
        /// Lateral force in each, N.
        lateral_n: f64,
    },
    /// The force sensor's zero is off.
    #[error(
        "the force sensor read {:+.0} mN (normal) and {:+.0} mN (lateral) while no finger was on the plate; the estimates are \
         corrected for it: tare the sensor with `friction-bench calibrate force --tare` before the next session",
        normal_n * 1e3, lateral_n * 1e3
    )]
    ForceZero {
        /// Largest reading of the normal axis without a finger, N.
        normal_n: f64,
        /// Largest reading of the lateral axis without a finger, N.
        lateral_n: f64,
    },
    /// The recording does not show the force sensor's zero.
    #[error(
        "the force sensor's zero cannot be read: the plate is nowhere free for 0.2 s, or the sensor reads more than 150 mN there; \
         forces are taken as read, and ± 50 mN of each axis are in the total intervals: leave the plate free for a second before \
         and after each trial, and tare the sensor with `friction-bench calibrate force --tare`"
    )]
    ForceZeroUnread,
    /// No unloaded interval of forces alone shows the force sensor's zero.
    #[error(
        "no unloaded interval shows the force sensor's zero: forces are taken as read, and a lateral zero of 10 mN changes the friction \
         under 0.5 N by 0.02: mark 0.2 s or more without a contact as an unloaded interval"
    )]
    ForcesAsRead,
    /// The force sensor's zero changed during the recording by more than its errors.
    #[error(
        "the force sensor's zero moved by {:+.0} mN ({axis}) between two stretches without a finger; forces between them are known \
         no better than that: look for a cable or an arm that rests on the plate, or for a sensor that warms up",
        change_n * 1e3
    )]
    ForceZeroMoves {
        /// Change of the axis, N.
        change_n: f64,
        /// Axis.
        #[serde(default)]
        axis: Axis,
    },
    /// The force sensor's zero drifts in the only stretch that shows it.
    #[error(
        "the force sensor's zero drifts by {:+.0} mN/s ({axis}) without a finger, and is seen at one time only: forces far from it are off by \
         as much times the time to it; let the sensor settle, and leave the plate free for a second after each trial",
        drift_n_per_s * 1e3
    )]
    ForceZeroDrifts {
        /// Drift of the axis, N/s.
        drift_n_per_s: f64,
        /// Axis.
        axis: Axis,
    },
    /// Z_p could not be read.
    #[error(transparent)]
    Unloaded(#[from] UnloadedError),
    /// A finger was on the plate during part of the unloaded interval.
    #[error(
        "finger on the plate during {touched_s:.2} s of the unloaded interval, which are left out"
    )]
    Touched {
        /// Length of the contact, s.
        touched_s: f64,
    },
    /// The unloaded plate's impedance changes.
    #[error(
        "the unloaded plate's impedance scatters by {scatter_n_s_per_m:.2} N·s/m: was a finger on it?"
    )]
    PlateScatters {
        /// RMS about the mean, N·s/m.
        scatter_n_s_per_m: f64,
    },
    /// The pickup's phase differs from the stated one.
    #[error(
        "pickup: the unloaded plate answers to the modulation as with phase_rad = {found_rad:.3}, but recording.toml \
         states {stated_rad:.3}; analysed with the value found: state it, or look for a swapped or delayed channel"
    )]
    PickupPhase {
        /// Stated phase, rad.
        stated_rad: f64,
        /// Phase from the plate's response, rad.
        found_rad: f64,
    },
    /// The pickup's envelope is late relative to the drive's.
    #[error(
        "pickup: the unloaded plate answers to the modulation as if the pickup were {:.0} µs {}",
        delay_s.abs() * 1e6,
        if *delay_s > 0.0 {
            "late; analysed with that delay: look for a filter or a delay in its channel, and check modal_mass_kg and the scales of both \
             channels"
        } else {
            "early, which no filter makes; analysed with that delay: check modal_mass_kg and the scales of both channels, and look for a \
             filter in the drive's channel"
        }
    )]
    PickupLate {
        /// Delay, s.
        delay_s: f64,
    },
    /// The unloaded plate is lighter or heavier than stated, or the pickup later than any channel can be.
    #[error(
        "the unloaded plate answers to the modulation as if its modal mass were {mass_ratio:.3} times the stated one, or the pickup {:+.2} ms late; analysed as stated: check volts_per_unit, force_factor_n_per_v, metres_per_unit (peak, not peak to peak or RMS), modal_mass_kg, and whether the channels are swapped or not aligned",
        delay_s * 1e3
    )]
    PlateMass {
        /// Ratio of the modal mass from the plate's response to the stated one.
        mass_ratio: f64,
        /// Delay of the pickup with the same effect, s.
        delay_s: f64,
    },
    /// The unloaded plate's impedance has the wrong phase, because of the pickup or the resonance.
    #[error(
        "the unloaded plate's impedance is {z_p_n_s_per_m:.2} N·s/m, but carrier_hz, resonance_hz and modal_mass_kg make its imaginary part {expected_im_n_s_per_m:+.2}: check the pickup's phase_rad, and the resonance"
    )]
    PlateReactance {
        /// Z_p as read, N·s/m.
        z_p_n_s_per_m: Complex64,
        /// ω m_p − k_p/ω, N·s/m.
        expected_im_n_s_per_m: f64,
    },
    /// The resonance differs from the stated frequency.
    #[error(
        "the plate's resonance is at {measured_hz:.0} Hz by the unloaded plate's impedance, not at {stated_hz:.0} Hz as recording.toml says; Z_p is read with the plate as it was"
    )]
    ResonanceElsewhere {
        /// Measured frequency, Hz.
        measured_hz: f64,
        /// Stated frequency, Hz.
        stated_hz: f64,
    },
    /// The model with the assumed skin does not describe the measurement.
    #[error(
        "with the parameters that dynamic fits to the first instance, the self-sensed normal force is {:.0} % off the \
         measured one (90th percentile) at amplitudes of {:.1} to {:.1} µm: the skin differs from the one that dynamic \
         assumes, or it changed during the trial",
        difference * 100.0, amplitude_from_m * 1e6, amplitude_to_m * 1e6
    )]
    ModelParts {
        /// 90th percentile of |self-sensed − measured|/measured in the worst band.
        difference: f64,
        /// Smallest amplitude of the band, m.
        amplitude_from_m: f64,
        /// Largest amplitude of the band, m.
        amplitude_to_m: f64,
    },
    /// The recording has no exploration to analyse.
    #[error("no exploration interval")]
    NoExploration,
    /// Two explorations are the same stretch of the recording.
    #[error(
        "recording.toml: the explorations from {:.2} to {:.2} s and from {:.2} to {:.2} s coincide; each instance counts \
         once, but the friction of both is given: state each exploration once in [[intervals]]",
        first_s.0, first_s.1, second_s.0, second_s.1
    )]
    CoincidingExplorations {
        /// Start and end of one, s.
        first_s: (f64, f64),
        /// Start and end of the other, s.
        second_s: (f64, f64),
    },
    /// A stream was not recorded.
    #[error(transparent)]
    Missing(#[from] MissingStream),
    /// The carrier moves and was followed.
    #[error(
        "drive: the carrier moves from {lowest_hz:.0} to {highest_hz:.0} Hz and is followed; impedances are referred to \
         {reference_hz:.0} Hz by the plate's constants, and phase and delay of the pickup are taken as stated"
    )]
    CarrierFollowed {
        /// Lowest frequency, Hz.
        lowest_hz: f64,
        /// Highest frequency, Hz.
        highest_hz: f64,
        /// Frequency to which the impedances are referred, Hz.
        reference_hz: f64,
    },
    /// The recording has envelopes in place of samples.
    #[error(
        "envelopes.parquet in place of signals.wav: there is no check of the converter: clipping, offsets, hum and foreign tones do \
         not show"
    )]
    ConverterUnchecked,
    /// The envelopes were low-passed, and the low-pass is not undone.
    #[error(
        "envelopes.parquet: the noise of both envelopes falls to {:.1} % from 150 to 600 Hz, as a lock-in's time constant leaves it, and \
         σ_t, gap and Z_t are off by it: state low_pass = {{ order, tau_s }} in [envelopes] of the map, or record with a shorter time constant",
        100.0 * remaining
    )]
    EnvelopesFiltered {
        /// Power of the noise at some 600 Hz relative to that at 150 Hz.
        remaining: f64,
    },
    /// The normal force is as steady elsewhere as without a finger.
    #[error(
        "force.csv: normal_n is as steady at {} N from {from_s:.1} to {to_s:.1} s as without a finger: its zero moved, or a weight lay \
         on the plate; state that stretch as unloaded too, by marks or by a rule with a larger force, or tare the sensor and record again",
        significant(*normal_n)
    )]
    SteadyElsewhere {
        /// Start of the stretch, s.
        from_s: f64,
        /// End of the stretch, s.
        to_s: f64,
        /// Mean normal force, N.
        normal_n: f64,
    },
    /// The samples had a flaw when the recording was archived.
    #[error("of the samples, before they were archived: {warning}")]
    Archived {
        /// The flaw, in words.
        warning: String,
    },
}

impl From<EqualTail> for Flaw {
    fn from(tail: EqualTail) -> Self {
        let (rows, from_s, [normal_n, lateral_n]) = (tail.rows, tail.from_s, tail.forces_n);
        if tail.is_zero() {
            Self::ZeroTail { rows, from_s }
        } else {
            Self::HeldTail {
                rows,
                from_s,
                normal_n,
                lateral_n,
            }
        }
    }
}

impl Flaw {
    /// Returns the flaw of explorations, in time order, of which two coincide.
    pub(crate) fn coinciding(explorations: &[(Direction, f64, f64)]) -> Option<Self> {
        let [first_s, second_s] = coinciding(explorations)?;
        Some(Self::CoincidingExplorations { first_s, second_s })
    }
}
