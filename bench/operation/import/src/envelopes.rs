//! Recordings with complex envelopes of drive and pickup, as a lock-in amplifier keeps them.

use std::f64::consts::{PI, SQRT_2, TAU};
use std::path::Path;

use envelope_files::{EnvelopeRow, EnvelopeWriter};
use force_alignment::Estimate;
use import_map::{
    ComplexArrays, Convention, Electrical, Envelopes, ImportMap, LockInFilter, Modulation,
    Quantity, TimeBase,
};
use num_complex::Complex64;
use recording::ENVELOPES_FILE;
use recording::manifest::{self, FoundValue, RecordedEnvelopes, RecordedPlate, Streams};

use crate::analysis_flaws;
use crate::checks;
use crate::constants::{PICKUP_PHASE, StatedPickup};
use crate::converted::Converted;
use crate::data_files;
use crate::description::Description;
use crate::figure::{self, Evidence};
use crate::plate;
use crate::readings::{DriveTime, Readings};
use crate::refusal::ImportRefusal;
use crate::search::Search;
use crate::sources::{BLOCK, Sources};
use crate::survey::Envelope;

/// Greatest number of values, which are held in memory.
const MOST_VALUES: u64 = 60_000_000;
/// Greatest gain by which a filter is undone: beyond, the ends of the recording are amplified more than signals.
const GREATEST_GAIN: f64 = 2000.0;
/// Greatest RMS of the noise that undoing a filter may add, as a share of the envelope's.
const ADDED_NOISE: f64 = 1e-4;
/// Part of the band, below half the rate, that shows the noise behind the filter.
const NOISE_BAND: (f64, f64) = (0.8, 0.95);
/// Frequency up to which the envelopes must reach for σ_t and Z_t of every method to be within 1 % of those of sampled signals, Hz.
const NEEDED_HZ: f64 = 750.0;
/// Periods of the modulation's frequency up to which they must reach.
const NEEDED_HARMONICS: f64 = 20.0;
/// Time by which the ends are continued while a filter is undone, in time constants.
const PADDING_TAU: f64 = 40.0;

/// Converts a recording into `folder`, which exists.
pub(crate) fn convert(
    map: &ImportMap,
    sources: &mut Sources<'_>,
    (folder, name): (&Path, &str),
    describe: &Description<'_>,
    common_ppm: Option<Estimate>,
) -> Result<Converted, ImportRefusal> {
    let Electrical::Envelopes {
        carrier_hz,
        modulation,
        envelopes,
        plate,
    } = &map.electrical
    else {
        unreachable!("the caller chose by the kind of the recording");
    };
    let carrier_hz = *carrier_hz;
    let (mut found, mut notes) = (Vec::new(), Vec::new());
    let (mut channels, drive_time) = read(sources, envelopes, carrier_hz)?;
    let drive = (&channels[0], envelopes.volts_per_unit);
    let tone = modulation_of(drive, *modulation, &mut found)?;
    if let Some(filter) = envelopes.low_pass {
        for channel in &mut channels {
            undo(channel, filter, tone.frequency_hz)?;
        }
    }
    let reach_hz = 0.5 / channels[0].step_s;
    if reach_hz < NEEDED_HZ {
        notes.push(format!(
            "the envelopes reach {reach_hz:.0} Hz to either side of the carrier: below {NEEDED_HZ} Hz, sigma_t and Z_t of `trial` may be off by some percent; keep envelopes at a higher rate"
        ));
    }
    integrate(
        &mut channels[1],
        envelopes.conversion.quantity.derivatives(),
        carrier_hz,
    );
    let mut readings = Readings::read(map, sources, drive_time)?;
    notes.extend(checks::overlap(&readings, drive_time)?);
    notes.extend(checks::position_rate(map, &readings, drive_time));
    checks::force_rate(map, &readings, tone.frequency_hz, drive_time)?;
    let recorded_plate = plate::recorded(
        plate, carrier_hz, sources, &readings, &mut found, &mut notes,
    )?;
    let mut stated = StatedPickup::provisional(envelopes.conversion, carrier_hz);
    checks::exchanged(
        [&channels[0], &channels[1]],
        tone.frequency_hz,
        &readings.intervals.unloaded_s(),
    )?;
    let search = Search {
        map,
        folder,
        conversion: envelopes.conversion,
        carrier_hz,
        modulation_hz: tone.frequency_hz,
        plate: recorded_plate.constants(),
        drive_time,
        common_ppm,
        add_intervals: &|_| {},
    };
    let streams = |plate: &RecordedPlate| {
        Streams::Envelopes(RecordedEnvelopes {
            carrier_hz,
            modulation: tone,
            plate: plate.clone(),
        })
    };
    let write = |pickup: StatedPickup, readings: &Readings| {
        write_rows(folder, &channels, envelopes.volts_per_unit, pickup)?;
        describe.write(folder, streams(&recorded_plate), &readings.intervals, &[])
    };
    let clock = search
        .run((&mut stated, &mut readings), &write, &mut found, &mut notes)
        .map_err(|error| {
            analysis_flaws::refusal(error, folder, readings.intervals.summary.as_deref())
        })?;
    notes.extend(unlike_phases(&found));
    found.append(&mut readings.found);
    notes.append(&mut readings.notes);
    write_rows(folder, &channels, envelopes.volts_per_unit, stated)?;
    data_files::write(folder, &readings)?;
    describe.write(
        folder,
        streams(&recorded_plate),
        &readings.intervals,
        &found,
    )?;
    let svg = figure::svg(&Evidence {
        name,
        envelopes: Some([
            (&channels[0], envelopes.volts_per_unit),
            (&channels[1], stated.metres_per_unit),
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

/// Greatest phase between drive and pickup of one instrument that has no other cause, rad: cables and filters turn both alike.
const GREATEST_PHASE_RAD: f64 = 0.5;

/// Returns the remark on a found phase that one lock-in amplifier does not make.
fn unlike_phases(found: &[FoundValue]) -> Option<String> {
    let mut phases = found.iter().filter(|value| value.name == PICKUP_PHASE);
    let phase_rad = phases
        .find(|value| value.value.abs() > GREATEST_PHASE_RAD)?
        .value;
    Some(format!(
        "{PICKUP_PHASE} = {phase_rad:.2} rad was found, and a lock-in amplifier turns drive and pickup nearly alike: look at convention \
         (exp(-iwt)), at X and Y that are exchanged, at a phase in degrees that is read as radians, and at quantity"
    ))
}

/// Reads both envelopes, peak and exp(+iωt), in the units of their arrays.
fn read(
    sources: &mut Sources<'_>,
    envelopes: &Envelopes,
    carrier_hz: f64,
) -> Result<([Envelope; 2], DriveTime), ImportRefusal> {
    let files = sources.file_names(envelopes.file.as_ref());
    let drive = read_complex(sources, &files, &envelopes.drive)?;
    let pickup = read_complex(sources, &files, &envelopes.pickup)?;
    let column = sources.column_in(&files, first_name(&envelopes.drive))?;
    if drive.len() != pickup.len() {
        return Err(ImportRefusal::Lengths {
            first: "envelopes.drive".to_owned(),
            first_length: drive.len() as u64,
            second: "envelopes.pickup".to_owned(),
            second_length: pickup.len() as u64,
        });
    }
    for (stream, arrays, values) in [
        ("envelopes.drive", &envelopes.drive, &drive),
        ("envelopes.pickup", &envelopes.pickup, &pickup),
    ] {
        let first = values[0];
        if values.iter().all(|value| *value == first || value.is_nan()) {
            return Err(ImportRefusal::Dead {
                stream: stream.to_owned(),
                name: first_name(arrays).to_owned(),
                value: first.norm(),
            });
        }
    }
    let (rate_hz, first_s) = sources.even_times(&envelopes.time, &column, "envelopes")?;
    let start_s = column
        .start_s()
        .filter(|_| matches!(envelopes.time, TimeBase::Rate(_)));
    let factor = if envelopes.is_rms { SQRT_2 } else { 1.0 };
    let channels = [drive, pickup].map(|values| Envelope {
        first_s: 0.0,
        step_s: 1.0 / rate_hz,
        reference_hz: carrier_hz,
        values: values
            .into_iter()
            .map(|value| {
                factor
                    * match envelopes.convention {
                        Convention::Positive => value,
                        Convention::Negative => value.conj(),
                    }
            })
            .collect(),
    });
    let duration_s = channels[0].values.len() as f64 / rate_hz;
    Ok((
        channels,
        DriveTime {
            first_s,
            duration_s,
            start_s,
        },
    ))
}

/// Returns the name of the array, or of the first of two.
fn first_name(arrays: &ComplexArrays) -> &str {
    match arrays {
        ComplexArrays::Complex(name)
        | ComplexArrays::Parts { real: name, .. }
        | ComplexArrays::Polar {
            amplitude: name, ..
        } => name,
    }
}

fn read_complex(
    sources: &mut Sources<'_>,
    files: &[String],
    arrays: &ComplexArrays,
) -> Result<Vec<Complex64>, ImportRefusal> {
    let mut real = |name: &str| -> Result<Vec<f64>, ImportRefusal> {
        let column = sources.column_in(files, name)?;
        require_few(column.len(), column.name())?;
        let mut values = Vec::new();
        sources.for_each_block(&column, |_, block| {
            values.extend_from_slice(block);
            Ok(())
        })?;
        Ok(values)
    };
    let pairs = match arrays {
        ComplexArrays::Complex(name) => {
            let column = sources.column_in(files, name)?;
            require_few(column.len(), column.name())?;
            let mut values = Vec::new();
            for start in (0..column.len()).step_by(BLOCK as usize) {
                sources.read_complex(
                    &column,
                    start..(start + BLOCK).min(column.len()),
                    &mut values,
                )?;
            }
            return Ok(values);
        }
        ComplexArrays::Parts {
            real: re,
            imaginary,
        } => [(real(re)?, re), (real(imaginary)?, imaginary)],
        ComplexArrays::Polar {
            amplitude, phase, ..
        } => [(real(amplitude)?, amplitude), (real(phase)?, phase)],
    };
    let [(first, first_name), (second, second_name)] = pairs;
    if first.len() != second.len() {
        return Err(ImportRefusal::Lengths {
            first: first_name.clone(),
            first_length: first.len() as u64,
            second: second_name.clone(),
            second_length: second.len() as u64,
        });
    }
    let rad_per_unit = match arrays {
        ComplexArrays::Polar { rad_per_unit, .. } => Some(*rad_per_unit),
        ComplexArrays::Complex(_) | ComplexArrays::Parts { .. } => None,
    };
    if rad_per_unit == Some(1.0)
        && let Some(greatest) = degrees(&second)
    {
        return Err(ImportRefusal::Degrees {
            name: second_name.clone(),
            greatest,
        });
    }
    let value = |(a, b)| match rad_per_unit {
        Some(rad_per_unit) => Complex64::from_polar(a, b * rad_per_unit),
        None => Complex64::new(a, b),
    };
    Ok(first.into_iter().zip(second).map(value).collect())
}

/// Returns the greatest size of a phase that is in degrees. Radians are within a turn, or go on beyond it, and then by less than
/// half a turn from sample to sample.
fn degrees(phases: &[f64]) -> Option<f64> {
    let greatest = phases
        .iter()
        .fold(0.0_f64, |most, phase| most.max(phase.abs()));
    let mut steps = phases.windows(2).map(|pair| (pair[1] - pair[0]).abs());
    let has_jump = steps.any(|step| step > 1.01 * PI);
    (greatest > TAU && has_jump).then_some(greatest)
}

fn require_few(length: u64, name: String) -> Result<(), ImportRefusal> {
    match length {
        0..2 => Err(ImportRefusal::Short { name, length }),
        2..=MOST_VALUES => Ok(()),
        _ => Err(ImportRefusal::Long {
            name,
            length,
            limit: MOST_VALUES,
        }),
    }
}

/// Compares the modulation with the drive's amplitude.
fn modulation_of(
    (drive, volts_per_unit): (&Envelope, f64),
    modulation: Modulation,
    found: &mut Vec<FoundValue>,
) -> Result<manifest::Modulation, ImportRefusal> {
    let carrier = import_map::Carrier::Constant(Quantity::Stated(drive.reference_hz));
    let rate_hz = 1.0 / drive.step_s;
    let tone = checks::tone(
        (carrier, modulation),
        (None, drive.modulation(volts_per_unit)),
        rate_hz,
        found,
    )?;
    Ok(manifest::Modulation {
        frequency_hz: tone[1],
        index: tone[2],
    })
}

/// Returns the frequency up to which a low-pass can be undone, Hz: where the gain, or the noise that it adds, is greatest.
fn reach_hz(envelope: &Envelope, LockInFilter { order, tau_s }: LockInFilter) -> f64 {
    let rate_hz = 1.0 / envelope.step_s;
    let size = envelope.values.len().next_power_of_two();
    let finite = envelope.values.iter().filter(|value| value.is_finite());
    let power = finite.map(|value| value.norm_sqr()).sum::<f64>() / envelope.values.len() as f64;
    let noise = noise_power(&continuous(&envelope.values, |value| value.re), size)
        + noise_power(&continuous(&envelope.values, |value| value.im), size);
    let mut added = 0.0;
    for bin in 0..=size / 2 {
        let hz = bin as f64 * rate_hz / size as f64;
        let gain = Complex64::new(1.0, TAU * hz * tau_s).powu(order).norm();
        added += noise * (gain * gain - 1.0) * 2.0 / size as f64;
        if gain > GREATEST_GAIN || added > ADDED_NOISE * ADDED_NOISE * power {
            return hz;
        }
    }
    rate_hz / 2.0
}

/// Returns a part of the values, with a straight line in place of lost ones.
fn continuous(values: &[Complex64], part: impl Fn(&Complex64) -> f64) -> Vec<f64> {
    let mut parts: Vec<f64> = Vec::with_capacity(values.len());
    let mut lost = 0;
    for value in values.iter().map(part) {
        if !value.is_finite() {
            lost += 1;
            continue;
        }
        let before = parts.last().copied().unwrap_or(value);
        let step = (value - before) / f64::from(lost + 1);
        parts.extend((1..=lost).map(|n| before + step * f64::from(n)));
        parts.push(value);
        lost = 0;
    }
    let last = parts.last().copied().unwrap_or(0.0);
    parts.resize(values.len(), last);
    parts
}

/// Returns the power of noise of equal density in the whole band that has the density near its end.
fn noise_power(values: &[f64], size: usize) -> f64 {
    let forward = fourier::forward(size);
    let mut input = vec![0.0; size];
    let mut window_power = 0.0;
    for (n, (x, value)) in input.iter_mut().zip(values).enumerate() {
        let window = 0.5 - 0.5 * (TAU * (n as f64 + 0.5) / values.len() as f64).cos();
        window_power += window * window;
        *x = window * value;
    }
    let mut spectrum = forward.make_output_vec();
    // The transform made the buffer, so it fits.
    let _ = forward.process(&mut input, &mut spectrum);
    let [from, to] = [NOISE_BAND.0, NOISE_BAND.1].map(|share| (share * (size / 2) as f64) as usize);
    let density = statistics::median(spectrum[from..=to].iter().map(Complex64::norm_sqr));
    // The median of the power of noise is ln 2 of its mean.
    density.unwrap_or(0.0) / std::f64::consts::LN_2 / window_power
}

/// Undoes a lock-in amplifier's low-pass: multiplies the spectrum by (1 + iΩτ)^order as far as it can be undone.
fn undo(
    envelope: &mut Envelope,
    filter: LockInFilter,
    modulation_hz: f64,
) -> Result<(), ImportRefusal> {
    let LockInFilter { order, tau_s } = filter;
    let rate_hz = 1.0 / envelope.step_s;
    let reach_hz = reach_hz(envelope, filter);
    let needed_hz = (NEEDED_HARMONICS * modulation_hz)
        .max(NEEDED_HZ)
        .min(rate_hz / 2.0);
    if reach_hz < needed_hz {
        return Err(ImportRefusal::LowPass {
            reach_hz,
            needed_hz,
        });
    }
    let padding = ((PADDING_TAU * tau_s * rate_hz).ceil() as usize).max(16);
    let count = envelope.values.len();
    let size = (count + 2 * padding).next_power_of_two();
    let (forward, inverse) = (fourier::forward(size), fourier::inverse(size));
    let mut parts = [Vec::new(), Vec::new()];
    for (index, part) in parts.iter_mut().enumerate() {
        let values = continuous(&envelope.values, |value| {
            if index == 0 { value.re } else { value.im }
        });
        let (first, last) = (values[0], values[count - 1]);
        // Beyond its ends the signal is turned about them, so that its slope is continuous.
        let before = |n: usize| 2.0 * first - values[n.min(count - 1)];
        let after = |n: usize| 2.0 * last - values[(count - 1).saturating_sub(n)];
        let mut input: Vec<f64> = (1..=padding).rev().map(before).collect();
        input.extend(&values);
        input.extend((1..=padding).map(after));
        // From there back to the first value, so that the period has no step.
        let (from, to) = (after(padding), before(padding));
        let rest = size - input.len();
        let share = |n: usize| (n + 1) as f64 / (rest + 1) as f64;
        input.extend((0..rest).map(|n| from + (to - from) * share(n)));
        let mut spectrum = forward.make_output_vec();
        // The transform made the buffers, so they fit.
        let _ = forward.process(&mut input, &mut spectrum);
        for (bin, value) in spectrum.iter_mut().enumerate() {
            let hz = bin as f64 * rate_hz / size as f64;
            let edge = ((hz / reach_hz - 0.7) / 0.3).clamp(0.0, 1.0);
            let window = 0.5 + 0.5 * (TAU / 2.0 * edge).cos();
            *value *= window * Complex64::new(1.0, TAU * hz * tau_s).powu(order) / size as f64;
        }
        if let Some(first) = spectrum.first_mut() {
            first.im = 0.0;
        }
        if let Some(last) = spectrum.last_mut() {
            last.im = 0.0;
        }
        let mut output = inverse.make_output_vec();
        let _ = inverse.process(&mut spectrum, &mut output);
        *part = output[padding..padding + count].to_vec();
    }
    let [real, imaginary] = parts;
    for (value, (re, im)) in envelope
        .values
        .iter_mut()
        .zip(real.into_iter().zip(imaginary))
    {
        if value.is_finite() {
            *value = Complex64::new(re, im);
        }
    }
    Ok(())
}

/// Turns the envelope of a velocity or acceleration into that of the displacement, in the unit of the input over ω for each
/// derivative: x̃ = ṽ/(iω) − (dṽ/dt)/(iω)² to first order.
fn integrate(envelope: &mut Envelope, derivatives: u32, carrier_hz: f64) {
    if derivatives == 0 {
        return;
    }
    let values = envelope.values.clone();
    let last = values.len() - 1;
    let i_omega_s = Complex64::I * TAU * carrier_hz * envelope.step_s;
    let order = f64::from(derivatives);
    for (index, value) in envelope.values.iter_mut().enumerate() {
        let (before, after) = (index.saturating_sub(1), (index + 1).min(last));
        let slope = (values[after] - values[before]) / (after - before).max(1) as f64;
        *value = Complex64::I.powu(derivatives).inv() * (values[index] - order * slope / i_omega_s);
    }
}

fn write_rows(
    folder: &Path,
    channels: &[Envelope; 2],
    volts_per_unit: f64,
    pickup: StatedPickup,
) -> Result<(), ImportRefusal> {
    let path = folder.join(ENVELOPES_FILE);
    let refusal = |error: envelope_files::EnvelopeError| ImportRefusal::ReadBack(error.to_string());
    let turn = pickup.metres_per_unit * Complex64::cis(pickup.phase_rad);
    let mut writer = EnvelopeWriter::create(&path).map_err(refusal)?;
    let [drive, displacement] = channels;
    let mut rows = Vec::new();
    for (index, (drive_value, pickup_value)) in
        drive.values.iter().zip(&displacement.values).enumerate()
    {
        rows.push(EnvelopeRow {
            time_s: drive.time_s(index),
            drive_v: volts_per_unit * drive_value,
            pickup_m: turn * pickup_value,
        });
        if rows.len() == BLOCK as usize {
            writer.write(&rows).map_err(refusal)?;
            rows.clear();
        }
    }
    writer.write(&rows).map_err(refusal)?;
    writer.finish().map_err(refusal)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn envelope(value: impl Fn(f64) -> Complex64) -> Envelope {
        let step_s = 1e-4;
        Envelope {
            first_s: 0.0,
            step_s,
            reference_hz: 35e3,
            values: (0..30_000).map(|n| value(f64::from(n) * step_s)).collect(),
        }
    }

    /// A filtered line e^{iΩt} is the line over (1 + iΩτ)^order.
    #[test]
    fn a_low_pass_is_undone_within_its_reach() {
        for (order, tau_s) in [(1, 3e-5), (2, 3e-4), (4, 1e-3)] {
            let lines = [(0.0, 1.0), (6.0, 0.475), (-6.0, 0.475), (25.0, 0.02)];
            let sum = |t: f64, is_filtered: bool| {
                let line = |(hz, amplitude): (f64, f64)| {
                    let omega = TAU * hz;
                    let gain = if is_filtered {
                        Complex64::new(1.0, omega * tau_s).powu(order).inv()
                    } else {
                        Complex64::ONE
                    };
                    gain * amplitude * Complex64::cis(omega * t)
                };
                lines.into_iter().map(line).sum::<Complex64>()
            };
            let mut filtered = envelope(|t| sum(t, true));
            undo(&mut filtered, LockInFilter { order, tau_s }, 6.0).unwrap();
            for index in 50..29_950 {
                let error = (filtered.values[index] - sum(filtered.time_s(index), false)).norm();
                assert!(error < 1e-3, "order {order}, {index}: {error}");
            }
        }
        let mut slow = envelope(|_| Complex64::ONE);
        assert!(
            undo(
                &mut slow,
                LockInFilter {
                    order: 4,
                    tau_s: 0.05
                },
                6.0
            )
            .is_err()
        );
    }

    /// The same filter is undone in doubles and refused in 16 bits; lost values stay lost.
    #[test]
    fn a_low_pass_is_undone_as_far_as_the_noise_allows() {
        let filter = LockInFilter {
            order: 4,
            tau_s: 1e-3,
        };
        let smooth = |t: f64| Complex64::from(0.3 + 0.2 * (TAU * 6.0 * t).sin());
        let mut clean = envelope(smooth);
        clean.values[7000] = Complex64::new(f64::NAN, f64::NAN);
        assert!((reach_hz(&clean, filter) - 1052.0).abs() < 2.0);
        undo(&mut clean, filter, 6.0).unwrap();
        assert!(clean.values[7000].re.is_nan() && clean.values[6999].re.is_finite());
        let mut rounded = envelope(|t| {
            let parts = [smooth(t).re, 0.1 * (TAU * 1.7 * t).sin()];
            let [re, im] = parts.map(|part| (part * 32_768.0).round() / 32_768.0);
            Complex64::new(re, im)
        });
        let reach_hz = reach_hz(&rounded, filter);
        assert!((200.0..NEEDED_HZ).contains(&reach_hz), "{reach_hz}");
        assert!(undo(&mut rounded, filter, 6.0).is_err());
    }

    #[test]
    fn a_phase_in_degrees_is_told_from_one_in_radians() {
        let phase = |n: i32| 0.4 * (f64::from(n) * 0.01).sin() + 2.9;
        let wrapped = |phase: f64| Complex64::cis(phase).arg();
        let radians: Vec<f64> = (0..3000).map(|n| wrapped(phase(n))).collect();
        assert_eq!(degrees(&radians), None);
        let unwrapped: Vec<f64> = (0..3000).map(|n| f64::from(n) * 0.05).collect();
        assert_eq!(degrees(&unwrapped), None);
        let in_degrees: Vec<f64> = radians.iter().map(|phase| phase.to_degrees()).collect();
        assert!(degrees(&in_degrees).is_some_and(|greatest| (170.0..180.0).contains(&greatest)));
    }

    #[test]
    fn a_velocitys_envelope_becomes_the_displacements() {
        let omega = TAU * 35e3;
        let displacement = |t: f64| Complex64::from(1.0 + 0.9 * (TAU * 6.0 * t).sin());
        let slope = |t: f64| Complex64::from(0.9 * TAU * 6.0 * (TAU * 6.0 * t).cos());
        let mut velocity = envelope(|t| Complex64::I * displacement(t) + slope(t) / omega);
        integrate(&mut velocity, 1, 35e3);
        for index in 1..29_999 {
            let error = (velocity.values[index] - displacement(velocity.time_s(index))).norm();
            assert!(error < 1e-6, "{index}: {error}");
        }
    }
}
