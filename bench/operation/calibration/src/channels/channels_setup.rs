//! Setup of a calibration of the channels.

use config::Config;

/// Length of the silence for the noise measurement, s.
pub(super) const LISTEN_S: f64 = 1.0;
/// Level of the faint scan, as a share of the read-back that the safety watch takes for silence.
const FAINT: f64 = 0.8;
/// Level of the faint scan if the safety watch has no such floor, V peak.
const FAINT_V: f64 = 0.8;
/// Tones that show the band limit of a path, Hz: half of each common sample rate lies between two of them.
pub(super) const BELOW_HZ: [f64; 8] = [3e3, 7e3, 10e3, 14e3, 18e3, 21e3, 23e3, 26e3];
/// Distance of the scan's tones from the carrier to either side, Hz.
pub(super) const LOOK_STEP_HZ: f64 = 500.0;
/// Length of each tone of the scan, s.
pub(super) const LOOK_DWELL_S: f64 = 0.12;
/// Settling time of all filters in the path, s.
pub(super) const SETTLE_S: f64 = 0.02;

/// Distance of the ladder's tone from the carrier, Hz: at the carrier itself, the values could repeat every few samples.
pub(super) const LADDER_OFFSET_HZ: f64 = 37.0;
/// Length of the tone at each level of the ladder, s.
pub(super) const LADDER_DWELL_S: f64 = 0.08;

/// Number of tones of the upward sweep, and of the downward sweep.
pub(super) const TONES: usize = 21;
/// Distance from the carrier to the outermost tones to either side, Hz.
pub(super) const SPAN_HZ: f64 = 2e3;
/// Length of each tone, s.
pub(super) const DWELL_S: f64 = 0.06;
/// Level of the tones, as a share of the highest level without clipping on any input.
pub(super) const TONES_LEVEL: f64 = 0.7;

/// Delays from a command to its read-back over openings of the streams.
#[derive(Debug, Clone, Default)]
pub struct LoopDelays {
    /// Delay at each opening, s.
    pub seconds: Vec<f64>,
    /// Cause for which the next opening showed none.
    pub fault: Option<String>,
}

/// Setup of a calibration of the channels.
#[derive(Debug, Clone)]
pub struct ChannelsSetup {
    /// Carrier, Hz.
    pub carrier_hz: f64,
    /// Highest level of the ladder, V peak.
    pub highest_v: f64,
    /// Previous calibration of the channels; `None` at the first one.
    pub before: Option<config::MeasuredChannels>,
    /// Delays of the loop.
    pub delays: LoopDelays,
    pub(super) config: Config,
}

/// Number of openings of the streams over which the loop delay is measured.
pub const OPENINGS: usize = 6;

impl ChannelsSetup {
    /// Plans a measurement about the plate's resonance, up to the lower of `limits.drive_v` and the output's full
    /// scale.
    #[must_use]
    pub fn new(config: &Config, calibration: &config::CalibrationFile) -> Self {
        Self {
            carrier_hz: config.plate.resonance_hz,
            highest_v: config.limits.drive_v.min(config.output.volts_per_unit),
            before: calibration.channels.clone(),
            delays: LoopDelays::default(),
            config: config.clone(),
        }
    }

    /// Returns the number of inputs.
    pub(super) fn inputs(&self) -> u16 {
        self.config.audio.input_channels
    }

    /// Returns the index of the drive's input.
    pub(super) fn drive(&self) -> u16 {
        self.config.channels.drive.index
    }

    /// Returns the level of the faint scan, V peak: the safety watch takes it for silence and does not trip on any read-back.
    pub(super) fn faint_v(&self) -> f64 {
        let floor_v = self.config.safety.readback_floor_v;
        let faint_v = if floor_v > 0.0 {
            FAINT * floor_v
        } else {
            FAINT_V
        };
        faint_v.min(self.highest_v)
    }

    /// Returns the expected amplitude of the drive's input at `drive_v`, sample units.
    pub(super) fn expected(&self, drive_v: f64) -> f64 {
        drive_v / self.config.channels.drive.volts_per_unit
    }

    /// Returns the tones of the faint scan about the carrier, Hz.
    pub(super) fn near(&self) -> [f64; 3] {
        [-LOOK_STEP_HZ, 0.0, LOOK_STEP_HZ].map(|offset_hz| self.carrier_hz + offset_hz)
    }

    /// Returns the sample rate, Hz.
    pub(super) fn rate_hz(&self) -> f64 {
        f64::from(self.config.audio.rate_hz)
    }
}
