//! Impedance frames of recorded envelopes, read on by time.

use std::f64::consts::PI;
use std::path::Path;

use envelope_files::EvenRows;
use impedance::{ChannelScales, EnvelopeStream, Filter, Zm, ZmFrame};
use num_complex::Complex64;

use crate::findings::RecordingError;
use crate::vibration::Vibration;
use recording::ENVELOPES_FILE;
use recording::manifest::Manifest;
use recording::pipeline::{DemodulationError, PickupOffset};

/// Envelopes of a recording, and the filter and plate by which they become impedances.
pub struct EnvelopeDemodulator {
    rows: EvenRows,
    stream: EnvelopeStream,
    zm: Zm,
    /// Envelopes that were read; those from `next` are still to be filtered.
    read: Vec<[Complex64; 2]>,
    next: usize,
    filtered: u64,
    lost: [u64; 2],
}

impl EnvelopeDemodulator {
    /// Opens the envelopes in `folder`, with the pickup's phase and delay corrected by the offset.
    ///
    /// # Errors
    /// The file cannot be read, or the constants do not fit it.
    pub fn open(
        folder: &Path,
        (manifest, vibration): (&Manifest, &Vibration),
        pickup: PickupOffset,
    ) -> Result<Self, RecordingError> {
        let rows = EvenRows::open(&folder.join(ENVELOPES_FILE))?;
        let filter = Filter::for_envelopes(rows.rate_hz(), vibration.carrier_hz)
            .map_err(DemodulationError::from)?;
        let is_inverted = vibration.plate.force_factor_n_per_v < 0.0;
        let scales = ChannelScales {
            drive_volts_per_unit: 1.0,
            pickup_metres_per_unit: 1.0,
            pickup_phase_rad: pickup.turn_rad + if is_inverted { PI } else { 0.0 },
        };
        let zm = Zm::new(vibration.plate.constants(), scales, &filter)
            .map_err(DemodulationError::from)?
            .with_pickup_delay(pickup.delay_s);
        let mut stream = EnvelopeStream::new(filter, rows.start_s());
        if let Some(archived) = manifest.archived() {
            stream = stream.with_noise([archived.drive_noise_v, archived.pickup_noise_m]);
        }
        Ok(Self {
            stream,
            rows,
            zm,
            read: Vec::new(),
            next: 0,
            filtered: 0,
            lost: [0; 2],
        })
    }

    /// Returns the rate of the envelopes, Hz.
    #[must_use]
    pub fn rate_hz(&self) -> f64 {
        self.rows.rate_hz()
    }

    /// Returns the time of the next envelope, s.
    #[must_use]
    pub fn time_s(&self) -> f64 {
        self.rows.start_s() + self.filtered as f64 / self.rows.rate_hz()
    }

    /// Returns the time of the last row that was read, s.
    #[must_use]
    pub fn end_s(&self) -> f64 {
        self.rows.end_s()
    }

    /// Returns the numbers of envelopes so far: all, and the lost ones of drive and pickup.
    #[must_use]
    pub fn counts(&self) -> (u64, [u64; 2]) {
        (self.filtered, self.lost)
    }

    /// Filters the envelopes up to `until_s` and emits their frames; returns whether further envelopes follow.
    ///
    /// # Errors
    /// The file cannot be read, or its times are uneven.
    pub fn read_until(
        &mut self,
        until_s: f64,
        mut emit: impl FnMut(ZmFrame),
    ) -> Result<bool, RecordingError> {
        loop {
            while let Some(pair) = self.read.get(self.next) {
                if self.time_s() > until_s {
                    return Ok(true);
                }
                for (lost, envelope) in self.lost.iter_mut().zip(pair) {
                    *lost += u64::from(!envelope.is_finite());
                }
                let zm = &self.zm;
                self.stream.push(*pair, &mut |frame| emit(zm.read(frame)));
                self.next += 1;
                self.filtered += 1;
            }
            self.read.clear();
            self.next = 0;
            if self.rows.read(&mut self.read)? == 0 {
                return Ok(false);
            }
        }
    }
}
