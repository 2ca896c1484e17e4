//! Checks of a recording's streams against each other, and the clock of its forces.

use force_alignment::strokes::{Stroke, lateral_zero};
use force_alignment::{Film, ForceSample, Unaligned, align, roles};
use plausibility::{Implausible, Slide};
use protocols::Direction;
use recording::manifest::Body;
use recording::{ForceRow, Manifest, PositionRow, RecordingSource};

use crate::demodulation::DemodulatedRecording;
use crate::explorations::explorations;
use crate::findings::{RecordingError, RecordingFindings};
use crate::flaw::{Channel, Flaw};
use crate::plate_reading::PlateReading;

/// Delay of the forces, s, beyond its 95 % interval, from which it is corrected: fits allow a lag of 5 ms.
const SMALLEST_DELAY_S: f64 = 1e-3;
/// Delay beyond which one of several is no agreement, s.
const UNCLEAR_DELAY_S: f64 = 5e-3;
/// Smallest zero by strokes that is subtracted, N.
const SMALLEST_ZERO_N: f64 = 0.01;
/// Slip of the forces at either end of the slides, s, beyond the rate's 95 % interval, and standard errors of the rate, beyond
/// which it is corrected.
const SMALLEST_SLIP_S: f64 = 1e-3;
const CERTAIN_ERRORS: f64 = 4.0;
/// Share of the way at each end of an exploration in which the finger starts and stops.
const WAY_SHARE: f64 = 0.1;
/// Samples of a spectrum, and frames read at a time.
const SPECTRUM_SAMPLES: usize = 1 << 17;
const BLOCK_FRAMES: usize = 16_384;

/// Clock of the forces where it differs from that of drive and pickup.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ForceClock {
    centre_s: f64,
    late: Option<Interval95>,
    ppm: Option<Interval95>,
}

/// Value and half width of its 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Interval95 {
    value: f64,
    half_width: f64,
}

impl ForceClock {
    /// Reads the clock of a recording's forces; `None` where it agrees with drive and pickup, or cannot be told.
    ///
    /// # Errors
    /// The forces are off by one of several delays.
    pub(super) fn read(
        reading: &DemodulatedRecording,
        plate: Option<PlateReading>,
    ) -> Result<Option<Self>, Implausible> {
        let Some((plate, modulation)) = plate.zip(reading.manifest.modulation()) else {
            return Ok(None);
        };
        let DemodulatedRecording {
            manifest, record, ..
        } = reading;
        let slides_s = moving_s(&record.position, &spans_s(manifest));
        let film = Film {
            frames: &record.frames,
            z_p_n_s_per_m: plate.corrected_n_s_per_m,
            modulation_hz: modulation.frequency_hz,
            slides_s: &slides_s,
        };
        let is_off = |delay_s: f64| delay_s.abs() > UNCLEAR_DELAY_S;
        let alignment = match align(&film, &samples(&record.force)) {
            Ok(alignment) => alignment,
            Err(Unaligned::Ambiguous { first_s, second_s })
                if is_off(first_s) && is_off(second_s) =>
            {
                return Err(Implausible::ForcesUnclear { first_s, second_s });
            }
            Err(_) => return Ok(None),
        };
        let (delay_s, rate, ppm) = (alignment.delay_s, alignment.rate, alignment.ppm());
        let is_late = delay_s.value.abs() > SMALLEST_DELAY_S + delay_s.half_width95();
        let certain_rate = rate.value.abs() - rate.half_width95();
        let slip_s = 0.5 * alignment.length_s * certain_rate;
        let is_off = rate.value.abs() > CERTAIN_ERRORS * rate.std && slip_s > SMALLEST_SLIP_S;
        let stated = |estimate: force_alignment::Estimate| Interval95 {
            value: estimate.value,
            half_width: estimate.half_width95(),
        };
        Ok((is_late || is_off).then_some(Self {
            centre_s: alignment.centre_s,
            late: is_late.then_some(stated(delay_s)),
            ppm: is_off.then_some(stated(ppm)),
        }))
    }

    /// Returns the flaws of the clock.
    pub(super) fn flaws(&self) -> impl Iterator<Item = Implausible> + use<> {
        let late = self.late.map(|late| Implausible::ForcesLate {
            late_s: late.value,
            half_width95_s: late.half_width,
        });
        let rate = self.ppm.map(|ppm| Implausible::ForcesClock {
            ppm: ppm.value,
            half_width95_ppm: ppm.half_width,
        });
        late.into_iter().chain(rate)
    }

    /// Puts the readings on the clock of drive and pickup.
    pub(super) fn correct(&self, rows: &mut [ForceRow]) {
        let late_s = self.late.map_or(0.0, |late| late.value);
        let ratio = 1.0 + 1e-6 * self.ppm.map_or(0.0, |ppm| ppm.value);
        for row in rows {
            row.time_s = self.centre_s + (row.time_s - late_s - self.centre_s) * ratio;
        }
    }
}

/// Returns the implausible forces and positions of a recording, as read.
pub(super) fn implausible(reading: &DemodulatedRecording) -> Vec<Implausible> {
    let DemodulatedRecording {
        manifest, record, ..
    } = reading;
    let spans_s = spans_s(manifest);
    let mut found = plausibility::forces(&record.force, &spans_s, &manifest.unloaded_s());
    if manifest.contact.body == Body::Other {
        // The ranges of a finger do not apply.
        found.retain(|found| {
            matches!(
                found,
                Implausible::Constant { .. } | Implausible::Sign { .. }
            )
        });
        return found;
    }
    let modulation = manifest.modulation();
    let exchanged = modulation.and_then(|modulation| {
        roles::exchanged(&samples(&record.force), &spans_s, modulation.frequency_hz)
    });
    if let Some(shares) = exchanged {
        // Signs and sizes of exchanged columns are those of the other one.
        found.retain(|found| matches!(found, Implausible::Constant { .. }));
        found.push(Implausible::Exchanged {
            normal: shares.normal,
            lateral: shares.lateral,
        });
    }
    found.extend(plausibility::positions(&record.position, &slides(manifest)));
    found
}

/// Returns the implausible forces of a recording, taken against its zero.
pub(super) fn tared(reading: &DemodulatedRecording, contact_n: f64) -> Option<Implausible> {
    plausibility::lateral_sign(&reading.record.force, &slides(&reading.manifest), contact_n)
}

/// Subtracts the zero of the lateral force that strokes there and back show from the readings, and returns its flaw.
pub(super) fn strokes_zero(reading: &mut DemodulatedRecording) -> Option<Implausible> {
    let stroke = |slide: &Slide| Stroke {
        grows: slide.grows,
        start_s: slide.start_s,
        end_s: slide.end_s,
    };
    let strokes: Vec<Stroke> = slides(&reading.manifest).iter().map(stroke).collect();
    let forces = samples(&reading.record.force);
    let zero = lateral_zero(
        &forces,
        &strokes,
        reading.manifest.modulation()?.frequency_hz,
    )?;
    if zero.value.abs() < SMALLEST_ZERO_N + zero.half_width95() {
        return None;
    }
    for row in &mut reading.record.force {
        row.lateral_n -= zero.value;
    }
    Some(Implausible::StrokesZero {
        zero_n: zero.value,
        half_width95_n: zero.half_width95(),
    })
}

/// Returns the flaw of a contact area that no finger has.
pub(super) fn contact_area(findings: &RecordingFindings) -> Option<Flaw> {
    let fit = findings.trial.as_ref()?;
    plausibility::contact_area(fit.contact_area_m2.value).map(Flaw::from)
}

/// Returns the reasons why channels lack their carrier.
///
/// # Errors
/// The audio cannot be read.
pub(super) fn without_carrier(
    source: &RecordingSource<'_>,
    reading: &DemodulatedRecording,
) -> Result<Vec<Implausible>, RecordingError> {
    let manifest = &reading.manifest;
    let Some((signals, vibration)) = manifest.signals().zip(reading.vibration.as_ref()) else {
        return Ok(Vec::new());
    };
    let mut reader = source.signals()?;
    let channels = usize::from(reader.format().channels);
    let rate_hz = reader.rate_hz();
    let start_s = spans_s(manifest).first().map_or(0.0, |span| span.0);
    let (mut passed, mut samples, mut block) = (0, [Vec::new(), Vec::new()], Vec::new());
    let indices = [signals.channels.drive.index, signals.channels.pickup.index];
    while samples[0].len() < SPECTRUM_SAMPLES && reader.read_block(BLOCK_FRAMES, &mut block)? > 0 {
        passed += block.len() / channels;
        if passed as f64 > start_s * rate_hz {
            for (samples, index) in samples.iter_mut().zip(indices) {
                let values = block.iter().skip(usize::from(index)).step_by(channels);
                samples.extend(values.map(|value| f64::from(*value)));
            }
        }
    }
    let named = [Channel::Drive, Channel::Pickup].into_iter().zip(&samples);
    let found = named.filter_map(|(channel, samples)| {
        let is_missing = |flaw: &Flaw| matches!(flaw, Flaw::CarrierMissing { channel: missing, .. } if *missing == channel);
        let is_missing = reading.flaws.iter().any(is_missing);
        let found = plausibility::without_carrier(&channel.to_string(), samples, rate_hz, vibration.carrier_hz);
        found.filter(|found| {
            is_missing && (channel == Channel::Drive || matches!(found, Implausible::DeadChannel { .. }))
        })
    });
    Ok(found.collect())
}

fn spans_s(manifest: &Manifest) -> Vec<(f64, f64)> {
    let explorations = explorations(manifest).into_iter();
    explorations
        .map(|(_, start_s, end_s)| (start_s, end_s))
        .collect()
}

/// Returns the parts of explorations in which the finger is on its way: without the first and the last tenth of it.
fn moving_s(rows: &[PositionRow], spans_s: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let moving = |&(start_s, end_s): &(f64, f64)| {
        let start = rows.partition_point(|row| row.time_s < start_s);
        let end = rows.partition_point(|row| row.time_s < end_s);
        let inside = rows.get(start..end).unwrap_or_default();
        let (Some(first), Some(last)) = (inside.first(), inside.last()) else {
            return (start_s, end_s);
        };
        let way_m = last.position_m - first.position_m;
        let passed_s = |share: f64| {
            let is_past = |row: &&PositionRow| (row.position_m - first.position_m) / way_m >= share;
            inside.iter().find(is_past).map(|row| row.time_s)
        };
        let moving_s = passed_s(WAY_SHARE).zip(passed_s(1.0 - WAY_SHARE));
        moving_s
            .filter(|(from_s, to_s)| from_s < to_s)
            .unwrap_or((start_s, end_s))
    };
    spans_s.iter().map(moving).collect()
}

fn slides(manifest: &Manifest) -> Vec<Slide> {
    let slide = |(direction, start_s, end_s): (Direction, f64, f64)| Slide {
        grows: direction == Direction::LeftToRight,
        start_s,
        end_s,
    };
    explorations(manifest).into_iter().map(slide).collect()
}

fn samples(rows: &[ForceRow]) -> Vec<ForceSample> {
    let sample = |row: &ForceRow| ForceSample {
        time_s: row.time_s,
        normal: row.normal_n,
        lateral: row.lateral_n,
    };
    rows.iter().map(sample).collect()
}

impl RecordingFindings {
    /// Withholds the estimates, which a flaw makes meaningless, and states it as the reason for each exploration.
    pub(super) fn withhold(&mut self) {
        let Some(reason) = self.withheld_reason() else {
            return;
        };
        if self.implausible().any(Implausible::spoils_plate) {
            self.z_p = None;
        }
        self.instances.clear();
        (self.trial, self.within_laws) = (None, None);
        self.explorations.clear();
        self.rejected.clear();
        for (direction, start_s, end_s) in explorations(&self.manifest) {
            self.reject(direction, (start_s, end_s), &reason);
        }
    }
}
