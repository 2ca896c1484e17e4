//! Values that a recording shows once it is written: the pickup's scale and phase, the clock of the forces.

use std::path::Path;

use analysis::measurements::Measurements;
use force_alignment::Estimate;
use impedance::PlateConstants;
use import_map::{Clock, ImportMap, Intervals as IntervalSource, PickupConversion};
use recording::RecordingSource;
use recording::manifest::FoundValue;
use recording::pipeline::PickupOffset;

use crate::alignment::{self, FoundClock};
use crate::constants::{self, PICKUP_PHASE, StatedPickup, UnloadedPlate};
use crate::data_files;
use crate::readings::{DriveTime, Readings};
use crate::refusal::ImportRefusal;

/// Movement of the forces from which on the pickup is found again, s: the stretches without a finger end well before it comes.
const STILL_S: f64 = 0.005;
/// Most times that pickup and clock are found.
const MOST_PASSES: usize = 3;

/// A recording in its folder, without its description.
pub(crate) struct Search<'a> {
    /// Map.
    pub map: &'a ImportMap,
    /// Folder of the recording.
    pub folder: &'a Path,
    /// Conversion of the pickup.
    pub conversion: PickupConversion,
    /// Carrier, Hz.
    pub carrier_hz: f64,
    /// Frequency of the modulation, Hz.
    pub modulation_hz: f64,
    /// Plate.
    pub plate: PlateConstants,
    /// Time of the drive.
    pub drive_time: DriveTime,
    /// Common excess of the rate of the forces' clock in all recordings of the session, parts per million.
    pub common_ppm: Option<Estimate>,
    /// Adds the intervals that follow from no rule.
    pub add_intervals: &'a dyn Fn(&mut Readings),
}

/// Writes the files of a recording that depend on the pickup and on the intervals.
pub(crate) type Write<'a> = &'a dyn Fn(StatedPickup, &Readings) -> Result<(), ImportRefusal>;

impl Search<'_> {
    /// Finds the values that the map leaves open; places pickup and readings accordingly.
    ///
    /// The pickup's phase stands on stretches without a finger, and the clock of the forces on the slides; both lie where that clock
    /// puts them. So pickup and clock are found again once the forces have moved.
    pub fn run(
        &self,
        (stated, readings): (&mut StatedPickup, &mut Readings),
        write: Write<'_>,
        found: &mut Vec<FoundValue>,
        notes: &mut Vec<String>,
    ) -> Result<Option<FoundClock>, ImportRefusal> {
        let provisional = *stated;
        let clock = self.map.normal.as_ref().map(|normal| normal.clock);
        let clock = clock.filter(|clock| alignment::is_to_be_found(*clock));
        let mut pickup = self.pickup(provisional, readings, write);
        if let (Some(clock), true) = (clock, pickup.is_err()) {
            // A finger may be on the plate where late forces show none.
            let placed = self.clock(clock, provisional, readings, write);
            let Ok(placed) = placed else {
                return pickup.map(|_| None);
            };
            self.align(readings, &placed);
            pickup = self.pickup(provisional, readings, write);
        }
        let mut values;
        (*stated, values) = pickup?;
        let Some(clock) = clock else {
            found.append(&mut values);
            return Ok(None);
        };
        let mut placed = None;
        for _ in 0..MOST_PASSES {
            let before_s = placed_s(readings);
            let next = self.clock(clock, *stated, readings, write)?;
            self.align(readings, &next);
            let moved_s = (placed_s(readings) - before_s).abs();
            placed = Some(next);
            if moved_s < STILL_S {
                break;
            }
            (*stated, values) = self.pickup(provisional, readings, write)?;
        }
        found.append(&mut values);
        if let Some(placed) = &mut placed {
            placed.require_errors()?;
            found.append(&mut placed.found);
            notes.append(&mut placed.notes);
        }
        Ok(placed)
    }

    fn align(&self, readings: &mut Readings, clock: &FoundClock) {
        readings.align(self.map, self.drive_time, (clock.offset_s, clock.ppm));
        if let IntervalSource::Rules { .. } = self.map.intervals {
            (self.add_intervals)(readings);
        }
    }

    fn is_pickup_open(&self) -> bool {
        constants::is_to_be_found(self.conversion)
    }

    /// Returns the pickup with the values that are to be found, if any, and these values.
    fn pickup(
        &self,
        provisional: StatedPickup,
        readings: &Readings,
        write: Write<'_>,
    ) -> Result<(StatedPickup, Vec<FoundValue>), ImportRefusal> {
        if !self.is_pickup_open() {
            return Ok((provisional, Vec::new()));
        }
        let (_, unloaded) = self.plate(provisional, readings, write, PICKUP_PHASE, false)?;
        unloaded.find(self.conversion, provisional, (self.carrier_hz, &self.plate))
    }

    /// Finds the clock of the forces.
    fn clock(
        &self,
        clock: Clock,
        pickup: StatedPickup,
        readings: &Readings,
        write: Write<'_>,
    ) -> Result<FoundClock, ImportRefusal> {
        let (Some(normal), Some(lateral)) = (&readings.normal, &readings.lateral) else {
            return Err(ImportRefusal::NotFound {
                key: "normal.offset_s",
                reason: "it needs the normal and the lateral force".to_owned(),
            });
        };
        let (record, unloaded) = self.plate(pickup, readings, write, "normal.offset_s", true)?;
        let strokes = readings.intervals.strokes();
        let slides_s: Vec<(f64, f64)> = strokes
            .iter()
            .map(|(_, from_s, to_s)| (*from_s, *to_s))
            .collect();
        // The plate alone, after the recording, has no forces.
        let duration_s = self.drive_time.duration_s;
        let count = record
            .frames
            .partition_point(|frame| frame.time_s < duration_s);
        alignment::find(
            (normal, lateral),
            (clock, self.drive_time.first_s),
            (&record.frames[..count], unloaded.z_p_n_s_per_m),
            (self.modulation_hz, &slides_s),
            self.common_ppm,
        )
    }

    /// Demodulates the recording and reads its unloaded plate; `key` names the value that needs it.
    fn plate(
        &self,
        pickup: StatedPickup,
        readings: &Readings,
        write: Write<'_>,
        key: &'static str,
        is_whole: bool,
    ) -> Result<(Measurements, UnloadedPlate), ImportRefusal> {
        let record = self.demodulated(pickup, readings, write, is_whole)?;
        let unloaded_s = readings.intervals.unloaded_s();
        match UnloadedPlate::read(&record, &unloaded_s, self.modulation_hz) {
            Ok(plate) => Ok((record, plate)),
            Err(reason) => Err(ImportRefusal::NotFound { key, reason }),
        }
    }

    /// Demodulates the recording as it is: its intervals and their surroundings, or the whole of it.
    fn demodulated(
        &self,
        pickup: StatedPickup,
        readings: &Readings,
        write: Write<'_>,
        is_whole: bool,
    ) -> Result<Measurements, ImportRefusal> {
        data_files::write(self.folder, readings)?;
        if is_whole {
            let mut covered = readings.clone();
            covered.intervals.cover(self.drive_time.duration_s);
            write(pickup, &covered)?;
        } else {
            write(pickup, readings)?;
        }
        analysis::demodulation::read(
            &RecordingSource::folder(self.folder),
            PickupOffset::default(),
        )
        .map(|reading| reading.record)
        .map_err(|error| ImportRefusal::ReadBack(error.to_string()))
    }
}

/// Returns the time of the first normal force, s; 0 without forces.
fn placed_s(readings: &Readings) -> f64 {
    readings
        .normal
        .as_ref()
        .map_or(0.0, |normal| normal.drive_s(0))
}
