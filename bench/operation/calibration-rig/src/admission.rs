//! Admission of a calibration's tones: within the bench's limits, and inaudible if they are loud.

use config::{AudibleCarrier, Config, Limits};
use devices::drive_control::settings;
use safety::FAINT_V;
use signalgen::{DriveSettings, Program, Waveform};

/// Limits under which a calibration's tones are admitted.
#[derive(Debug, Clone)]
pub(crate) struct Admission {
    settings: DriveSettings,
    limits: Limits,
}

impl Admission {
    pub(crate) fn new(config: &Config) -> anyhow::Result<Self> {
        Ok(Self {
            settings: settings(config)?,
            limits: config.limits.clone(),
        })
    }

    /// Returns the program of `waveform`.
    pub(crate) fn admit(&self, waveform: Waveform) -> anyhow::Result<Program> {
        require_unheard(&self.limits, &waveform)?;
        Ok(self.settings.admit(waveform)?)
    }

    pub(crate) fn ramp_frames(&self) -> usize {
        self.settings.ramp_frames() as usize
    }
}

/// Requires inaudible tones, or a stated reason; the faint tones that test a path are exempt.
fn require_unheard(limits: &Limits, waveform: &Waveform) -> Result<(), AudibleCarrier> {
    let (lowest_hz, loudest_v) = match waveform {
        Waveform::Silence => return Ok(()),
        Waveform::Tone {
            carrier_hz,
            amplitude_v,
        } => (*carrier_hz, *amplitude_v),
        Waveform::Modulated {
            carrier_hz,
            mean_amplitude_v,
            modulation_index,
            ..
        } => (*carrier_hz, mean_amplitude_v * (1.0 + modulation_index)),
        Waveform::Sweep {
            from_hz,
            to_hz,
            amplitude_v,
            ..
        } => (from_hz.min(*to_hz), *amplitude_v),
        Waveform::SteppedTones {
            tones, amplitude_v, ..
        } => {
            let lowest_hz = tones
                .as_slice()
                .iter()
                .copied()
                .fold(f64::INFINITY, f64::min);
            (lowest_hz, *amplitude_v)
        }
    };
    if loudest_v <= FAINT_V {
        return Ok(());
    }
    limits.require_inaudible(lowest_hz)
}

#[cfg(test)]
mod tests {
    use super::*;
    use signalgen::ToneList;

    fn admits(hz: &[f64], amplitude_v: f64, reason: &str) -> bool {
        let text = config::rigs::MOCK_BENCH.replace("[limits]\n", &format!("[limits]\n{reason}\n"));
        let config = Config::parse(&text, "test").unwrap();
        let tones = ToneList::new(hz).unwrap();
        let waveform = Waveform::SteppedTones {
            tones,
            dwell_s: 0.1,
            amplitude_v,
        };
        Admission::new(&config).unwrap().admit(waveform).is_ok()
    }

    /// Hazard 6.
    #[test]
    fn a_calibration_plays_no_loud_tone_that_people_hear_without_a_reason() {
        assert!(admits(&[34e3, 36e3], 10.0, ""));
        assert!(!admits(&[36e3, 15e3], 10.0, ""));
        assert!(admits(&[36e3, 15e3], 2.0, ""), "the faint look at a path");
        let reason = "audible_carrier_because = \"nobody is in the room\"";
        assert!(admits(&[36e3, 15e3], 10.0, reason));
    }
}
