//! What a calibration of the channels takes from the bench.

use config::Config;

/// Length of the silence that the noise is read from, s.
pub(super) const LISTEN_S: f64 = 1.0;
/// Level of the faint look, as a share of the read-back that the safety watch takes for silence.
const FAINT: f64 = 0.8;
/// Level of the faint look where the safety watch has no such floor, V peak.
const FAINT_V: f64 = 0.8;
/// Tones that show where a path ends, Hz: half of every common sample rate lies between two of them.
pub(super) const BELOW_HZ: [f64; 8] = [3e3, 7e3, 10e3, 14e3, 18e3, 21e3, 23e3, 26e3];
/// Distance of the look's tones from the carrier to either side, Hz.
pub(super) const LOOK_STEP_HZ: f64 = 500.0;
/// Length of each of the look's tones, s.
pub(super) const LOOK_DWELL_S: f64 = 0.12;
/// Time after which every filter on the way has settled, s.
pub(super) const SETTLE_S: f64 = 0.02;

/// Distance of the ladder's tone from the carrier, Hz: at the carrier itself its samples could repeat within a few.
pub(super) const LADDER_OFFSET_HZ: f64 = 37.0;
/// Length of the tone at each level of the ladder, s.
pub(super) const LADDER_DWELL_S: f64 = 0.08;

/// Number of tones on the way up, and on the way down.
pub(super) const TONES: usize = 21;
/// Distance from the carrier to the outermost tones to either side, Hz.
pub(super) const SPAN_HZ: f64 = 2e3;
/// Length of each tone, s.
pub(super) const DWELL_S: f64 = 0.06;
/// Level of the tones, as a share of the highest level at which no input's peaks are cut off.
pub(super) const TONES_LEVEL: f64 = 0.7;

/// What a calibration of the channels takes from the bench.
#[derive(Debug, Clone)]
pub struct ChannelsSetup {
    /// Carrier, Hz.
    pub carrier_hz: f64,
    /// Highest level of the ladder, V peak.
    pub highest_v: f64,
    /// Channels as calibrated before; `None` at the first calibration.
    pub before: Option<config::MeasuredChannels>,
    /// Delay from a command to its read-back at each of several openings of the streams, s.
    pub delays_s: Vec<f64>,
    pub(super) config: Config,
}

/// Openings of the streams over which the loop's delay is measured.
pub const OPENINGS: usize = 6;

impl ChannelsSetup {
    /// Plans a measurement about the plate's resonance, up to the lower of `limits.drive_v` and the output's full
    /// scale.
    #[must_use]
    pub fn new(config: &Config, held: &config::CalibrationFile) -> Self {
        Self {
            carrier_hz: config.plate.resonance_hz,
            highest_v: config.limits.drive_v.min(config.output.volts_per_unit),
            before: held.channels.clone(),
            delays_s: Vec::new(),
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

    /// Returns the level of the faint look, V peak: the safety watch takes it for silence and stops nothing, whatever
    /// comes back.
    pub(super) fn faint_v(&self) -> f64 {
        let floor_v = self.config.safety.readback_floor_v;
        let faint_v = if floor_v > 0.0 {
            FAINT * floor_v
        } else {
            FAINT_V
        };
        faint_v.min(self.highest_v)
    }

    /// Returns the amplitude that the drive's input should read at `drive_v`, sample units.
    pub(super) fn expected(&self, drive_v: f64) -> f64 {
        drive_v / self.config.channels.drive.volts_per_unit
    }

    /// Returns the faint look's tones about the carrier, Hz.
    pub(super) fn near(&self) -> [f64; 3] {
        [-LOOK_STEP_HZ, 0.0, LOOK_STEP_HZ].map(|off| self.carrier_hz + off)
    }

    /// Returns the sample rate, Hz.
    pub(super) fn rate_hz(&self) -> f64 {
        f64::from(self.config.audio.rate_hz)
    }
}
