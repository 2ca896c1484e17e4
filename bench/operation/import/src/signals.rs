//! Recordings with samples of drive and pickup.

use std::path::Path;

use force_alignment::Estimate;
use import_map::{
    Carrier, Centre, Drive, Electrical, ImportMap, Modulation, Pickup, Quantity, Template, TimeBase,
};
use recording::SIGNALS_FILE;
use recording::manifest::{
    self, FoundValue, PlateAlone, RecordedChannels, RecordedDrive, RecordedPickup, RecordedPlate,
    RecordedSignals, Streams,
};

use crate::analysis_flaws;
use crate::checks;
use crate::constants::StatedPickup;
use crate::converted::Converted;
use crate::data_files;
use crate::derivative::Integrator;
use crate::description::Description;
use crate::figure::{self, Evidence};
use crate::plate;
use crate::readings::{DriveTime, Readings, require_same_length};
use crate::refusal::ImportRefusal;
use crate::search::Search;
use crate::sources::{BLOCK, Column, Sources};
use crate::survey::{self, Channel};
use crate::wav_file::{WavFile, Width};

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
}

/// Converts a recording into `folder`, which exists.
pub(crate) fn convert(
    map: &ImportMap,
    sources: &mut Sources<'_>,
    (folder, name): (&Path, &str),
    describe: &Description<'_>,
    common_ppm: Option<Estimate>,
) -> Result<Converted, ImportRefusal> {
    let Electrical::Signals {
        carrier,
        modulation,
        drive,
        pickup,
        plate,
        baseline,
    } = &map.electrical
    else {
        unreachable!("the caller chose by the kind of the recording");
    };
    let parts = SignalMap {
        carrier: *carrier,
        modulation: *modulation,
        drive,
        pickup,
    };
    let mut found = Vec::new();
    let mut notes = Vec::new();
    let (signals, first_s) = survey(parts, sources, &mut found, &mut notes)?;
    let baseline = match baseline {
        None => None,
        Some(template) => {
            let baseline = Baseline::find(sources, template, parts, signals.rate_hz)?;
            if matches!(carrier, Carrier::Constant(_)) {
                baseline.require_carrier(sources, &signals)?;
            }
            Some(baseline)
        }
    };
    write_signals(folder, sources, (&signals, baseline.as_ref()), pickup)?;
    let drive_time = DriveTime {
        first_s,
        duration_s: signals.columns[0].len() as f64 / signals.rate_hz,
        start_s: sources.start_s(&drive.time, &drive.source)?,
    };
    let mut readings = Readings::read(map, sources, drive_time)?;
    let add_intervals = |readings: &mut Readings| {
        if let Some(baseline) = &baseline {
            baseline.add_interval(&signals, readings);
        }
    };
    add_intervals(&mut readings);
    notes.extend(checks::overlap(&readings, drive_time)?);
    notes.extend(checks::position_rate(map, &readings, drive_time));
    checks::force_rate(map, &readings, signals.tone.modulation_hz, drive_time)?;
    let recorded_plate = plate::recorded(
        plate,
        signals.tone.carrier_hz,
        sources,
        &readings,
        &mut found,
        &mut notes,
    )?;
    let mut stated = StatedPickup::provisional(pickup.conversion, signals.tone.carrier_hz);
    let mut state = State {
        parts,
        signals: &signals,
        plate: recorded_plate,
    };
    checks::exchanged(
        [&signals.channels[0].envelope, &signals.channels[1].envelope],
        signals.tone.modulation_hz,
        &readings.intervals.unloaded_s(),
    )?;
    let search = Search {
        map,
        folder,
        conversion: pickup.conversion,
        carrier_hz: signals.tone.carrier_hz,
        modulation_hz: signals.tone.modulation_hz,
        plate: state.plate.constants(),
        drive_time,
        common_ppm,
        add_intervals: &add_intervals,
    };
    let write =
        |pickup, readings: &Readings| state.describe(folder, pickup, readings, describe, &[]);
    let clock = search
        .run((&mut stated, &mut readings), &write, &mut found, &mut notes)
        .map_err(|error| {
            analysis_flaws::refusal(error, folder, readings.intervals.summary.as_deref())
        })?;
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
    notes.extend(match &clock {
        Some(_) => analysis_flaws::remarks(folder),
        None => analysis_flaws::require_times(folder)?,
    });
    figure::write(folder, svg)?;
    Ok(Converted {
        found,
        notes,
        ppm: clock.and_then(|clock| clock.own_ppm),
    })
}

/// Reads drive and pickup once: rate, carrier, modulation, and the state of the channels.
fn survey(
    parts: SignalMap<'_>,
    sources: &mut Sources<'_>,
    found: &mut Vec<FoundValue>,
    notes: &mut Vec<String>,
) -> Result<(Signals, f64), ImportRefusal> {
    let columns = [
        sources.column(&parts.drive.source)?,
        sources.column(&parts.pickup.source)?,
    ];
    require_same_length(&columns[0], &columns[1])?;
    let (rate_hz, first_s) = sources.even_times(&parts.drive.time, &columns[0], "drive")?;
    if let TimeBase::Rate(_) = &parts.drive.time
        && let [Some(drive_s), Some(pickup_s)] = columns.each_ref().map(Column::start_s)
        && (pickup_s - drive_s).abs() * rate_hz >= 0.5
    {
        return Err(ImportRefusal::Starts {
            first: columns[0].name(),
            second: columns[1].name(),
            apart_s: pickup_s - drive_s,
        });
    }
    if !(RATES_HZ.0..=RATES_HZ.1).contains(&rate_hz) {
        return Err(ImportRefusal::Rate {
            key: "drive.rate_hz".to_owned(),
            hz: rate_hz,
            remedy: "recordings have 80 kHz to 2 MHz; what a lock-in amplifier kept is [envelopes]",
        });
    }
    if (columns[0].len() as f64) < 0.2 * rate_hz {
        return Err(ImportRefusal::Short {
            name: columns[0].name(),
            length: columns[0].len(),
        });
    }
    let strongest_hz = survey::strongest_tone(sources, &columns[0], rate_hz)?;
    let reference_hz = match (parts.carrier, strongest_hz) {
        (_, Some(hz)) => hz,
        (Carrier::Constant(Quantity::Stated(hz)), None) => hz,
        (_, None) => {
            return Err(ImportRefusal::NoCarrier {
                name: columns[0].name(),
            });
        }
    };
    let drive_channel = survey::channel(sources, &columns[0], rate_hz, reference_hz)?;
    let pickup_channel = survey::channel(sources, &columns[1], rate_hz, reference_hz)?;
    for (stream, channel, column) in [
        ("drive", &drive_channel, &columns[0]),
        ("pickup", &pickup_channel, &columns[1]),
    ] {
        let range = channel.range;
        if range.least() >= range.greatest() {
            return Err(ImportRefusal::Dead {
                stream: stream.to_owned(),
                name: column.name(),
                value: range.least(),
            });
        }
        if let Some(clipping) = range.clipping() {
            notes.push(format!(
                "{stream} ({}) is clipped: {} samples are at {} or {}; the analysis leaves these stretches out",
                column.name(),
                clipping.samples,
                range.least(),
                range.greatest()
            ));
        }
        if range.lost() > 0 {
            notes.push(format!(
                "{stream} ({}) lacks {} samples, which are not numbers",
                column.name(),
                range.lost()
            ));
        }
    }
    let measured = survey::carrier(&drive_channel.envelope);
    if strongest_hz.is_none() && measured.is_none() {
        return Err(ImportRefusal::NoCarrier {
            name: columns[0].name(),
        });
    }
    let modulated = drive_channel
        .envelope
        .modulation(parts.drive.volts_per_unit);
    let tone = checks::tone(
        (parts.carrier, parts.modulation),
        (measured, modulated),
        rate_hz,
        found,
    )?;
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

/// The plate alone, recorded once a session; it follows the recording's own samples.
struct Baseline {
    columns: [Column; 2],
    frames: u64,
    /// Lost frames between the recording and the plate alone.
    gap_frames: u64,
}

/// Longest stretch of the plate alone that is added to a recording, s, and the gap before it.
const BASELINE_S: f64 = 3.0;
const GAP_S: f64 = 0.05;
/// Distance of two carriers, Hz: that to which a spectrum of some seconds shows them, and by which the plate's impedance moves little.
const OTHER_CARRIER_HZ: f64 = 4.0;

impl Baseline {
    fn find(
        sources: &mut Sources<'_>,
        template: &Template,
        parts: SignalMap<'_>,
        rate_hz: f64,
    ) -> Result<Self, ImportRefusal> {
        let file = sources.file_name(template);
        let files = std::slice::from_ref(&file);
        let columns = [
            sources.column_in(files, &parts.drive.source.name)?,
            sources.column_in(files, &parts.pickup.source.name)?,
        ];
        require_same_length(&columns[0], &columns[1])?;
        let (baseline_hz, _) = sources.even_times(&parts.drive.time, &columns[0], "drive")?;
        if (baseline_hz / rate_hz - 1.0).abs() > 1e-6 {
            return Err(ImportRefusal::OtherRate {
                key: "the rate of the recording".to_owned(),
                stated_hz: rate_hz,
                file,
                file_hz: baseline_hz,
            });
        }
        Ok(Self {
            frames: columns[0].len().min((BASELINE_S * rate_hz) as u64),
            gap_frames: (GAP_S * rate_hz) as u64,
            columns,
        })
    }

    /// Requires the drive of the plate alone to have the recording's carrier, which is constant.
    fn require_carrier(
        &self,
        sources: &mut Sources<'_>,
        signals: &Signals,
    ) -> Result<(), ImportRefusal> {
        let carrier_hz = signals.tone.carrier_hz;
        let found_hz = survey::strongest_tone(sources, &self.columns[0], signals.rate_hz)?;
        let samples = self.columns[0].len().min(survey::SPECTRUM_SAMPLES);
        let distance_hz = OTHER_CARRIER_HZ.max(2.0 * signals.rate_hz / samples as f64);
        match found_hz.filter(|found_hz| (found_hz - carrier_hz).abs() > distance_hz) {
            Some(found_hz) => Err(ImportRefusal::BaselineCarrier {
                file: self.columns[0].place().to_string(),
                found_hz,
                carrier_hz,
            }),
            None => Ok(()),
        }
    }

    fn add_interval(&self, signals: &Signals, readings: &mut Readings) {
        let own_frames = signals.columns[0].len();
        let start = own_frames + self.gap_frames;
        let time_s = |frame: u64| frame as f64 / signals.rate_hz;
        let alone = PlateAlone {
            after_s: time_s(own_frames),
            from_s: time_s(start),
        };
        let why = format!("the plate alone, from {}", self.columns[0].place());
        let end_s = time_s(start + self.frames);
        readings.intervals.add_plate_alone(alone, end_s, why);
    }
}

/// Writes `signals.wav`.
fn write_signals(
    folder: &Path,
    sources: &mut Sources<'_>,
    signals: (&Signals, Option<&Baseline>),
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
    (signals, baseline): (&Signals, Option<&Baseline>),
    pickup: &Pickup,
) -> Result<bool, ImportRefusal> {
    let path = folder.join(SIGNALS_FILE);
    let system = |error: std::io::Error| ImportRefusal::system(&path, &error);
    let count = signals.columns[0].len();
    let extra = baseline.map_or(0, |baseline| baseline.gap_frames + baseline.frames);
    let rate_hz = signals.rate_hz.round() as u32;
    let mut file = WavFile::create(&path, rate_hz, width, count + extra).map_err(system)?;
    if !copy(
        &mut file,
        &path,
        sources,
        (&signals.columns, count),
        (signals, pickup),
    )? {
        return Ok(false);
    }
    if let Some(baseline) = baseline {
        let lost = vec![f64::NAN; baseline.gap_frames as usize];
        file.append(&lost, &lost).map_err(system)?;
        if !copy(
            &mut file,
            &path,
            sources,
            (&baseline.columns, baseline.frames),
            (signals, pickup),
        )? {
            return Ok(false);
        }
    }
    file.finish().map_err(system)?;
    Ok(true)
}

/// Appends the first `count` samples of drive and pickup; returns `false` if a sample needs a greater width.
fn copy(
    file: &mut WavFile,
    path: &Path,
    sources: &mut Sources<'_>,
    (columns, count): (&[Column; 2], u64),
    (signals, pickup): (&Signals, &Pickup),
) -> Result<bool, ImportRefusal> {
    let quantity = pickup.conversion.quantity;
    let mut integrator = Integrator::new(quantity, signals.tone.carrier_hz, signals.rate_hz);
    let (mut drive, mut raw, mut displacement) = (Vec::new(), Vec::new(), Vec::new());
    for start in (0..count).step_by(BLOCK as usize) {
        let end = (start + BLOCK).min(count);
        sources.read(&columns[0], start..end, &mut drive)?;
        raw.clear();
        sources.read(&columns[1], start..end, &mut raw)?;
        integrator.apply(&raw, &mut displacement);
        if end == count {
            integrator.finish(&mut displacement);
        }
        let ready = drive.len().min(displacement.len());
        let is_written = file
            .append(&drive[..ready], &displacement[..ready])
            .map_err(|error| ImportRefusal::system(path, &error))?;
        if !is_written {
            return Ok(false);
        }
        drive.drain(..ready);
        displacement.drain(..ready);
    }
    Ok(true)
}

/// Recording of which the signals are written.
struct State<'a> {
    parts: SignalMap<'a>,
    signals: &'a Signals,
    plate: RecordedPlate,
}

impl State<'_> {
    /// Writes `recording.toml`.
    fn describe(
        &self,
        folder: &Path,
        pickup: StatedPickup,
        readings: &Readings,
        describe: &Description<'_>,
        found: &[FoundValue],
    ) -> Result<(), ImportRefusal> {
        let Tone {
            carrier_hz,
            modulation_hz,
            modulation_index,
        } = self.signals.tone;
        let rate_hz = self.signals.rate_hz;
        let channels = RecordedChannels {
            rate_hz: (rate_hz.fract() != 0.0).then_some(rate_hz),
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
        let streams = Streams::Signals(RecordedSignals {
            carrier: match self.parts.carrier {
                Carrier::Follows => manifest::Carrier::Follows,
                Carrier::Constant(_) => manifest::Carrier::Steady(carrier_hz),
            },
            modulation: manifest::Modulation {
                frequency_hz: modulation_hz,
                index: modulation_index,
            },
            channels,
            plate: self.plate.clone(),
        });
        describe.write(folder, streams, &readings.intervals, found)
    }
}
