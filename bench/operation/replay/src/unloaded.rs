//! Plate and pickup of the recording, from its last unloaded interval.

use analysis::findings::PlateReading;
use analysis::measurements::Measurements;
use analysis::pickup_correction;
use analysis::unloaded_plate::{self, UnloadedError};
use analysis::vibration::Vibration;
use recording::manifest::RecordedInterval;
use recording::pipeline::PickupOffset;

/// Plate and pickup so far.
#[derive(Debug)]
pub(crate) struct Unloaded {
    /// Deviation of the pickup from its stated values.
    pub(crate) pickup: PickupOffset,
    /// Impedance of the plate, corrected for the deviation, or the reason why it could not be read.
    pub(crate) plate: Result<PlateReading, UnloadedError>,
}

impl Default for Unloaded {
    fn default() -> Self {
        Self {
            pickup: PickupOffset::default(),
            plate: Err(UnloadedError::NoInterval),
        }
    }
}

impl Unloaded {
    /// Reads an unloaded interval; a normal force of `off_n` or more counts as a finger.
    pub(crate) fn read(
        record: &Measurements,
        interval: &RecordedInterval,
        vibration: &Vibration,
        off_n: f64,
    ) -> Self {
        let span_s = [(interval.start_s, interval.end_s)];
        let constants = vibration.plate.constants();
        let drive = (vibration.carrier_hz, &constants);
        let unloaded = Self {
            pickup: pickup_correction::find(record, &span_s, off_n, drive),
            ..Self::default()
        };
        let record = unloaded.corrected(record, vibration);
        let modulation_hz = vibration.modulation.frequency_hz;
        let reading = unloaded_plate::read(&record, &span_s, modulation_hz, off_n);
        Self {
            plate: reading.map(|reading| reading.plate),
            ..unloaded
        }
    }

    /// Returns the record corrected for the deviation of the pickup.
    pub(crate) fn corrected(&self, record: &Measurements, vibration: &Vibration) -> Measurements {
        let constants = vibration.plate.constants();
        let mut record = record.clone();
        let drive = (vibration.carrier_hz, &constants);
        pickup_correction::undo(&mut record.frames, self.pickup, drive);
        record
    }
}
