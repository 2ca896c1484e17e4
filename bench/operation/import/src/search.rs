//! Values that a recording shows once it is written: the pickup's scale and phase, the clock of the forces.

use std::path::Path;

use force_alignment::Estimate;
use impedance::PlateConstants;
use import_map::{ImportMap, PickupConversion};
use recording::RecordingSource;
use recording::manifest::FoundValue;
use recording::pipeline::PickupOffset;

use crate::alignment::{self, FoundClock};
use crate::constants::{self, StatedPickup, UnloadedPlate};
use crate::data_files;
use crate::readings::{DriveTime, Readings};
use crate::refusal::ImportRefusal;

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
}

/// Writes the files of a recording that depend on the pickup and on the intervals.
pub(crate) type Write<'a> = &'a dyn Fn(StatedPickup, &Readings) -> Result<(), ImportRefusal>;

impl Search<'_> {
    /// Finds the values that the map leaves open; places pickup and readings accordingly.
    pub fn run(
        &self,
        (stated, readings): (&mut StatedPickup, &mut Readings),
        write: Write<'_>,
        found: &mut Vec<FoundValue>,
        notes: &mut Vec<String>,
    ) -> Result<Option<FoundClock>, ImportRefusal> {
        let unloaded_s = readings.intervals.unloaded_s();
        let plate =
            |pickup: StatedPickup, readings: &Readings, key: &'static str, is_whole: bool| {
                let record = self.demodulated(pickup, readings, write, is_whole)?;
                match UnloadedPlate::read(&record, &unloaded_s, self.modulation_hz) {
                    Ok(plate) => Ok((record, plate)),
                    Err(reason) => Err(ImportRefusal::NotFound { key, reason }),
                }
            };
        if constants::is_to_be_found(self.conversion) {
            let (_, unloaded) = plate(*stated, readings, "pickup.phase_rad", false)?;
            let drive = (self.carrier_hz, &self.plate);
            let (pickup, mut values) = unloaded.find(self.conversion, *stated, drive)?;
            *stated = pickup;
            found.append(&mut values);
        }
        let clock = self.map.normal.as_ref().map(|normal| normal.clock);
        let clock = clock.filter(|clock| alignment::is_to_be_found(*clock));
        let Some(clock) = clock else {
            return Ok(None);
        };
        let (Some(normal), Some(lateral)) = (&readings.normal, &readings.lateral) else {
            return Err(ImportRefusal::NotFound {
                key: "normal.offset_s",
                reason: "it needs the normal and the lateral force".to_owned(),
            });
        };
        let (record, unloaded) = plate(*stated, readings, "normal.offset_s", true)?;
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
        let frames = &record.frames[..count];
        let mut placed = alignment::find(
            (normal, lateral),
            clock,
            (frames, unloaded.z_p_n_s_per_m),
            (self.modulation_hz, &slides_s),
            self.common_ppm,
        )?;
        found.append(&mut placed.found);
        notes.append(&mut placed.notes);
        readings.align(self.map, self.drive_time, (placed.offset_s, placed.ppm));
        Ok(Some(placed))
    }

    /// Demodulates the recording as it is: its intervals and their surroundings, or the whole of it.
    fn demodulated(
        &self,
        pickup: StatedPickup,
        readings: &Readings,
        write: Write<'_>,
        is_whole: bool,
    ) -> Result<analysis::measurements::Measurements, ImportRefusal> {
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
