//! Recordings with samples of drive and pickup.

use std::fs;
use std::path::Path;

use import_map::{
    Carrier, Centre, Drive, Electrical, ImportMap, Modulation, Pickup, Plate, PlateConstants as MapPlate,
    Quantity,
};
use impedance::PlateConstants;
use recording::manifest::{
    FoundValue, RecordedChannels, RecordedDrive, RecordedPickup, RecordedPlate,
};
use recording::{MANIFEST_FILE, SIGNALS_FILE};

use crate::alignment::{self, FoundClock};
use crate::checks;
use crate::constants::{self, StatedPickup, UnloadedPlate};
use crate::data_files;
use crate::derivative::Integrator;
use crate::description::Description;
use crate::figure::{self, Evidence};
use crate::modulation;
use crate::readings::{DriveTime, Readings, require_same_length};
use crate::refusal::ImportRefusal;
use crate::sources::{BLOCK, Column, Sources};
use crate::survey::{self, Channel};
use crate::wav_file::{WavFile, Width};

/// Name of the figure.
pub(crate) const FIGURE_FILE: &str = "import.svg";
/// Rates of recordings, Hz.
const RATES_HZ: (f64, f64) = (80e3, 2e6);

/// Values of the drive's modulation and carrier.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Tone {
    carrier_hz: f64,
    modulation_hz: f64,
    modulation_index: f64,
}

/// Drive and pickup of a file, after the first pass.
struct Signals {
    rate_hz: f64,
    columns: [Column; 2],
    channels: [Channel; 2],
    tone: Tone,
}

/// Parts of a map of signals.
#[derive(Clone, Copy)]
struct SignalMap<'a> {
    carrier: Carrier,
    modulation: Modulation,
    drive: &'a Drive,
    pickup: &'a Pickup,
    plate: &'a Plate,
}

/// Converts a recording into `folder`, which exists; returns its found values and its notes.
pub(crate) fn convert(
    map: &ImportMap,
    sources: &mut Sources<'_>,
    (folder, name): (&Path, &str),
    describe: &Description<'_>,
) -> Result<(Vec<FoundValue>, Vec<String>), ImportRefusal> {
    let Electrical::Signals { carrier, modulation, drive, pickup, plate, baseline } = &map.electrical else {
        unreachable!("the caller chose by the kind of the recording");
    };
    let parts = SignalMap { carrier: *carrier, modulation: *modulation, drive, pickup, plate };
    if *carrier == Carrier::Follows {
        return Err(ImportRefusal::Unsupported {
            key: "carrier.hz",
            reason: "\"follows\" is not converted by this version; write \"found\" if the carrier moves by less than 10 Hz".to_owned(),
        });
    }
    if baseline.is_some() {
        return Err(ImportRefusal::Unsupported {
            key: "baseline.file",
            reason: "is not converted by this version: state stretches without contact of each file in [intervals]".to_owned(),
        });
    }
    let mut found = Vec::new();
    let mut notes = Vec::new();
    let (signals, first_s) = survey(parts, sources, &mut found, &mut notes)?;
    write_signals(folder, sources, &signals, pickup)?;
    let drive_time = DriveTime {
        first_s,
        duration_s: signals.columns[0].len() as f64 / signals.rate_hz,
    };
    let mut readings = Readings::read(map, sources, drive_time)?;
    checks::overlap(&readings, drive_time)?;
    checks::force_rate(map, &readings, signals.tone.modulation_hz, drive_time)?;
    let (resonance_hz, force_factor_n_per_v) = match &plate.constants {
        MapPlate::Stated { resonance_hz, force_factor_n_per_v, .. } => (*resonance_hz, *force_factor_n_per_v),
        MapPlate::Sweep { .. } => {
            return Err(ImportRefusal::Unsupported {
                key: "plate.sweep",
                reason: "is not converted by this version: run `friction-bench calibrate plate --from` and write resonance_hz and force_factor_n_per_v".to_owned(),
            });
        }
    };
    let centre_m = match plate.centre {
        Centre::Stated(metres) => metres,
        Centre::MiddleOfTravel => checks::middle_of_travel(&readings, &mut notes),
    };
    let mut stated = StatedPickup::provisional(pickup.conversion, signals.tone.carrier_hz);
    let mut state = State {
        map,
        parts,
        signals: &signals,
        plate: RecordedPlate {
            resonance_hz,
            modal_mass_kg: plate.modal_mass_kg,
            force_factor_n_per_v,
            centre_m,
            profile: None,
            across: None,
        },
        drive_time,
    };
    checks::exchanged(&signals.channels, signals.tone.modulation_hz, &readings.intervals.unloaded_s())?;
    let clock = state.find(folder, (&mut stated, &mut readings), describe, &mut found, &mut notes)?;
    if plate.centre == Centre::MiddleOfTravel && clock.is_some() {
        state.plate.centre_m = checks::middle_of_travel(&readings, &mut Vec::new());
    }
    found.append(&mut readings.found);
    notes.append(&mut readings.notes);
    data_files::write(folder, &readings)?;
    state.describe(folder, stated, &readings, describe, &found)?;
    let [drive_channel, pickup_channel] = &signals.channels;
    let svg = figure::svg(&Evidence {
        name,
        envelopes: Some([
            (&drive_channel.envelope, drive.volts_per_unit),
            // The samples of a derivative keep their size when they are integrated.
            (&pickup_channel.envelope, stated.metres_per_unit),
        ]),
        readings: &readings,
        clock: clock.as_ref(),
        found: &found,
    });
    write_figure(folder, svg)?;
    Ok((found, notes))
}

/// Writes the figure of a recording.
pub(crate) fn write_figure(
    folder: &Path,
    svg: Result<String, plotting::FigureError>,
) -> Result<(), ImportRefusal> {
    let svg = svg.map_err(|error| ImportRefusal::ReadBack(error.to_string()))?;
    let path = folder.join(FIGURE_FILE);
    fs::write(&path, svg).map_err(|error| ImportRefusal::system(&path, &error))
}

/// Reads drive and pickup once: rate, carrier, modulation, and the state of the channels.
fn survey(
    parts: SignalMap<'_>,
    sources: &mut Sources<'_>,
    found: &mut Vec<FoundValue>,
    notes: &mut Vec<String>,
) -> Result<(Signals, f64), ImportRefusal> {
    let columns = [sources.column(&parts.drive.source)?, sources.column(&parts.pickup.source)?];
    require_same_length(&columns[0], &columns[1])?;
    let (rate_hz, first_s) = sources.even_times(&parts.drive.time, &columns[0], "drive")?;
    if !(RATES_HZ.0..=RATES_HZ.1).contains(&rate_hz) {
        return Err(ImportRefusal::Rate {
            key: "drive.rate_hz".to_owned(),
            hz: rate_hz,
            remedy: "recordings have 80 kHz to 2 MHz; what a lock-in amplifier kept is [envelopes]",
        });
    }
    if (columns[0].len() as f64) < 0.2 * rate_hz {
        return Err(ImportRefusal::Short { name: columns[0].name(), length: columns[0].len() });
    }
    let strongest_hz = survey::strongest_tone(sources, &columns[0], rate_hz)?;
    let reference_hz = match (parts.carrier, strongest_hz) {
        (_, Some(hz)) => hz,
        (Carrier::Constant(Quantity::Stated(hz)), None) => hz,
        (_, None) => return Err(ImportRefusal::NoCarrier { name: columns[0].name() }),
    };
    let drive_channel = survey::channel(sources, &columns[0], rate_hz, reference_hz)?;
    let pickup_channel = survey::channel(sources, &columns[1], rate_hz, reference_hz)?;
    for (stream, channel, column) in [("drive", &drive_channel, &columns[0]), ("pickup", &pickup_channel, &columns[1])] {
        let range = channel.range;
        if range.least >= range.greatest {
            return Err(ImportRefusal::Dead { stream, name: column.name(), value: range.least });
        }
        if range.is_clipped() {
            notes.push(format!(
                "{stream} ({}) is clipped: {} runs of equal samples at {} or {}; the analysis leaves these stretches out",
                column.name(), range.flat_runs, range.least, range.greatest
            ));
        }
        if range.lost > 0 {
            notes.push(format!("{stream} ({}) lacks {} samples, which are not numbers", column.name(), range.lost));
        }
    }
    let measured = survey::carrier(&drive_channel.envelope);
    if strongest_hz.is_none() && measured.is_none() {
        return Err(ImportRefusal::NoCarrier { name: columns[0].name() });
    }
    let modulated = modulation::find(&drive_channel.envelope);
    let tone = checks::tone((parts.carrier, parts.modulation), (measured, modulated), rate_hz, found)?;
    Ok((
        Signals {
            rate_hz,
            columns,
            channels: [drive_channel, pickup_channel],
            tone: Tone {
                carrier_hz: tone[0],
                modulation_hz: tone[1],
                modulation_index: tone[2],
            },
        },
        first_s,
    ))
}

/// Writes `signals.wav`.
fn write_signals(
    folder: &Path,
    sources: &mut Sources<'_>,
    signals: &Signals,
    pickup: &Pickup,
) -> Result<(), ImportRefusal> {
    let is_integrated = pickup.conversion.quantity.derivatives() > 0;
    let widths = match is_integrated {
        true => &[Width::Double][..],
        false => &[Width::Single, Width::Double][..],
    };
    for width in widths {
        if write_signals_as(*width, folder, sources, signals, pickup)? {
            return Ok(());
        }
    }
    Ok(())
}

/// Writes `signals.wav` with samples of a width; returns `false` if a sample needs a greater one.
fn write_signals_as(
    width: Width,
    folder: &Path,
    sources: &mut Sources<'_>,
    signals: &Signals,
    pickup: &Pickup,
) -> Result<bool, ImportRefusal> {
    let path = folder.join(SIGNALS_FILE);
    let system = |error: std::io::Error| ImportRefusal::system(&path, &error);
    let [drive_column, pickup_column] = &signals.columns;
    let count = drive_column.len();
    let rate_hz = signals.rate_hz.round() as u32;
    let mut file = WavFile::create(&path, rate_hz, width, count).map_err(system)?;
    let mut integrator = Integrator::new(pickup.conversion.quantity, signals.tone.carrier_hz, signals.rate_hz);
    let (mut drive, mut raw, mut displacement) = (Vec::new(), Vec::new(), Vec::new());
    for start in (0..count).step_by(BLOCK as usize) {
        let end = (start + BLOCK).min(count);
        sources.read(drive_column, start..end, &mut drive)?;
        raw.clear();
        sources.read(pickup_column, start..end, &mut raw)?;
        integrator.apply(&raw, &mut displacement);
        if end == count {
            integrator.finish(&mut displacement);
        }
        let ready = drive.len().min(displacement.len());
        if !file.append(&drive[..ready], &displacement[..ready]).map_err(system)? {
            return Ok(false);
        }
        drive.drain(..ready);
        displacement.drain(..ready);
    }
    file.finish().map_err(system)?;
    Ok(true)
}

/// Recording of which the signals are written.
struct State<'a> {
    map: &'a ImportMap,
    parts: SignalMap<'a>,
    signals: &'a Signals,
    plate: RecordedPlate,
    drive_time: DriveTime,
}

impl State<'_> {
    fn constants(&self) -> PlateConstants {
        self.plate.constants()
    }

    /// Writes `recording.toml`.
    fn describe(
        &self,
        folder: &Path,
        pickup: StatedPickup,
        readings: &Readings,
        describe: &Description<'_>,
        found: &[FoundValue],
    ) -> Result<(), ImportRefusal> {
        let Tone { carrier_hz, modulation_hz, modulation_index } = self.signals.tone;
        let channels = RecordedChannels {
            drive: RecordedDrive {
                index: 0,
                volts_per_unit: self.parts.drive.volts_per_unit,
                clip_units: None,
            },
            pickup: RecordedPickup {
                index: 1,
                metres_per_unit: pickup.metres_per_unit,
                phase_rad: pickup.phase_rad,
                clip_units: None,
            },
        };
        let tone = [carrier_hz, modulation_hz, modulation_index];
        let manifest = describe.signals(tone, (channels, self.plate.clone()), &readings.intervals, found);
        let path = folder.join(MANIFEST_FILE);
        fs::write(&path, manifest.to_toml()?).map_err(|error| ImportRefusal::system(&path, &error))
    }

    /// Finds what the unloaded plate and the friction show: the pickup's scale and phase, the clock of the forces.
    fn find(
        &self,
        folder: &Path,
        (stated, readings): (&mut StatedPickup, &mut Readings),
        describe: &Description<'_>,
        found: &mut Vec<FoundValue>,
        notes: &mut Vec<String>,
    ) -> Result<Option<FoundClock>, ImportRefusal> {
        let conversion = self.parts.pickup.conversion;
        let clock = self.map.normal.as_ref().map(|normal| normal.clock);
        let asks_for_clock = clock.filter(|clock| alignment::is_to_be_found(*clock));
        if !constants::is_to_be_found(conversion) && asks_for_clock.is_none() {
            return Ok(None);
        }
        let carrier_hz = self.signals.tone.carrier_hz;
        let modulation_hz = self.signals.tone.modulation_hz;
        let drive = (carrier_hz, &self.constants());
        let demodulated = |pickup: StatedPickup, readings: &Readings, is_whole: bool| {
            data_files::write(folder, readings)?;
            let mut all = readings.clone();
            if is_whole {
                all.intervals.cover(self.drive_time.duration_s);
            }
            self.describe(folder, pickup, &all, describe, &[])?;
            analysis::demodulation::read(folder, recording::pipeline::PickupOffset::default())
                .map_err(|error| ImportRefusal::ReadBack(error.to_string()))
        };
        let unloaded_s = readings.intervals.unloaded_s();
        if constants::is_to_be_found(conversion) {
            let record = demodulated(*stated, readings, false)?.record;
            let plate = UnloadedPlate::read(&record, &unloaded_s, modulation_hz).map_err(|reason| {
                ImportRefusal::NotFound { key: "pickup.phase_rad", reason }
            })?;
            let (pickup, mut values) = plate.find(conversion, *stated, drive)?;
            *stated = pickup;
            found.append(&mut values);
        }
        let (Some(clock), Some(normal), Some(lateral)) = (asks_for_clock, &readings.normal, &readings.lateral) else {
            return Ok(None);
        };
        let record = demodulated(*stated, readings, true)?.record;
        let plate = UnloadedPlate::read(&record, &unloaded_s, modulation_hz).map_err(|reason| {
            ImportRefusal::NotFound { key: "normal.offset_s", reason }
        })?;
        let slides_s: Vec<(f64, f64)> = readings.intervals.strokes().iter().map(|(_, from_s, to_s)| (*from_s, *to_s)).collect();
        let mut placed = alignment::find(
            (normal, lateral),
            clock,
            (&record.frames, plate.z_p_n_s_per_m),
            (modulation_hz, &slides_s),
        )?;
        found.append(&mut placed.found.clone());
        notes.append(&mut placed.notes);
        readings.align(self.map, self.drive_time, (placed.offset_s, placed.ppm));
        Ok(Some(placed))
    }
}
