//! Means since the last reading shown to the operator.

use crate::known::Instrument;
use crate::operator::LiveReading;
use crate::watched_inputs::WatchedInputs;

/// Sums since the last reading shown to the operator.
#[derive(Default)]
pub(super) struct Meter {
    pub(super) frames: usize,
    /// Sum and sum of squares of the drive's and of the pickup's input.
    sums: [(f64, f64); 2],
    level: f64,
    pub(super) force: (f64, f64, u32),
    pub(super) known_m: Option<f64>,
}

impl Meter {
    pub(super) fn take(&mut self, block: &[f32], channels: usize, watched: [usize; 2]) {
        for frame in block.chunks_exact(channels) {
            for (sums, &channel) in self.sums.iter_mut().zip(&watched) {
                let value = f64::from(frame[channel]);
                *sums = (sums.0 + value, sums.1 + value * value);
            }
        }
        let peak = block.iter().fold(0.0f32, |peak, x| peak.max(x.abs()));
        self.level = self.level.max(f64::from(peak));
        self.frames += block.len() / channels;
    }

    /// Returns the means since the last reading, and the latest reading of `instrument`; restarts the sums.
    pub(super) fn reading(
        &mut self,
        watched: &WatchedInputs,
        instrument: Option<&Instrument>,
    ) -> LiveReading {
        let [drive, pickup] = self.amplitudes();
        let (normal, lateral, count) = self.force;
        let mean = |sum: f64| (count > 0).then(|| sum / f64::from(count));
        let (known_m, known_v) = self.known(instrument);
        let reading = LiveReading {
            normal_n: mean(normal),
            lateral_n: mean(lateral),
            drive_v: drive * watched.volts_per_unit,
            amplitude_m: pickup * watched.metres_per_unit,
            level: self.level,
            known_m,
            known_v,
            ..LiveReading::default()
        };
        *self = Self {
            known_m: self.known_m,
            ..Self::default()
        };
        reading
    }

    /// Returns the peak amplitudes of drive and pickup, sample units.
    fn amplitudes(&self) -> [f64; 2] {
        let n = self.frames as f64;
        self.sums
            .map(|(sum, squares)| (2.0 * (squares / n - (sum / n).powi(2)).max(0.0)).sqrt())
    }

    /// Returns the latest reading of `instrument`, in metres or in volts.
    fn known(&self, instrument: Option<&Instrument>) -> (Option<f64>, Option<f64>) {
        match instrument {
            Some(meter) if meter.reads_volts() => (None, self.known_m),
            _ => (self.known_m, None),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::io::empty;
    use std::path::Path;

    use config::MeterReads;

    use super::*;
    use crate::instrument_line::LineUnit;

    #[test]
    fn a_reading_in_volts_is_shown_as_no_amplitude() {
        let meter = Meter {
            known_m: Some(2.5),
            ..Meter::default()
        };
        let instrument = |unit| Instrument::with_port(Box::new(empty()), Path::new("x"), unit);
        let amplitude = instrument(LineUnit::micrometres());
        assert_eq!(meter.known(Some(&amplitude)), (Some(2.5), None));
        let volts = instrument(LineUnit::volts(MeterReads::Rms));
        assert_eq!(meter.known(Some(&volts)), (None, Some(2.5)));
    }
}
