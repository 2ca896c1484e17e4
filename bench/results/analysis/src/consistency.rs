//! Checks of a recording's streams against each other.

use estimation::trial::{Misfit, SharedFit};
use force_alignment::strokes::{Stroke, lateral_zero};
use force_alignment::{ForceSample, roles};
use plausibility::{Course, Implausible, Slide, StrokeFriction};
use protocols::{Direction, SelectionRules};
use recording::manifest::{Body, EventKind, RecordingEvent};
use recording::{ForceRow, Manifest, RecordingSource};

use crate::demodulation::DemodulatedRecording;
use crate::estimate::InstanceAnalysis;
use crate::exploration_findings::ExplorationFindings;
use crate::explorations::{explorations, spans_s};
use crate::findings::{RecordingError, RecordingFindings};
use crate::flaw::{Channel, Flaw};
use crate::measurements::Measurements;
use crate::method::Method;

/// Smallest zero by strokes that is subtracted, N.
const SMALLEST_ZERO_N: f64 = 0.01;
/// Samples of a spectrum, and frames read at a time.
const SPECTRUM_SAMPLES: usize = 1 << 17;
const BLOCK_FRAMES: usize = 16_384;

/// Returns the implausible forces and positions of a recording, as read.
pub(super) fn implausible(reading: &DemodulatedRecording) -> Vec<Implausible> {
    let DemodulatedRecording {
        manifest, record, ..
    } = reading;
    if let Some(mixed) = plausibility::mixed_columns(&record.force, &slides(manifest)) {
        return vec![mixed];
    }
    let spans_s = spans_s(manifest);
    let slides_s = plausibility::moving_s(&record.position, &spans_s);
    let unloaded_s = manifest.unloaded_s();
    let mut found = plausibility::forces(&record.force, &spans_s, &slides_s, &unloaded_s);
    let modulation = manifest.modulation();
    let modulation_hz = modulation.map(|modulation| modulation.frequency_hz);
    let at_rest = plausibility::at_rest(&record.force, &unloaded_s, modulation_hz);
    if at_rest
        .iter()
        .any(|found| matches!(found, Implausible::Hum { .. }))
    {
        // A hum varies as a finger does.
        found.retain(|reading| !matches!(reading, Implausible::FingerUnloaded { .. }));
    }
    // A steady film carries the finger throughout.
    let is_rest = modulation.is_none_or(|modulation| plausibility::rests(modulation.index));
    found.retain(|reading| is_rest || !reading.is_low_friction());
    found.extend(at_rest);
    found.extend(plausibility::wrapped(&record.force));
    found.extend(plausibility::repeated(&record.force));
    found.extend(plausibility::interpolated(&record.force, &slides_s));
    if manifest.contact.body == Body::Other {
        found.retain(Implausible::is_of_any_body);
        return found;
    }
    let exchanged = modulation.and_then(|modulation| {
        roles::exchanged(&samples(&record.force), &spans_s, modulation.frequency_hz)
    });
    if let Some(shares) = exchanged {
        // Signs and sizes of exchanged columns are those of the other one.
        found.retain(|reading| matches!(reading, Implausible::Constant { .. }));
        found.push(Implausible::Exchanged {
            normal: shares.normal,
            lateral: shares.lateral,
        });
    }
    found.extend(plausibility::positions(&record.position, &slides(manifest)));
    found
}

/// Returns the implausible forces and positions of a recording, taken against the forces' zero and at their corrected times.
pub(super) fn tared(
    reading: &DemodulatedRecording,
    contact_n: f64,
) -> impl Iterator<Item = Implausible> + use<> {
    let DemodulatedRecording {
        manifest, record, ..
    } = reading;
    let sign = plausibility::lateral_sign(&record.force, &slides(manifest), contact_n);
    let streams = (&*record.force, &*record.position);
    let modulation = manifest.modulation();
    let modulation = modulation.map(|found| (found.frequency_hz, found.index));
    let lateral = plausibility::lateral_times(streams, &spans_s(manifest), modulation, contact_n);
    let positions = plausibility::position_jumps(&record.position, &record.force, contact_n);
    sign.into_iter().chain(lateral).chain(positions)
}

/// Returns the flaw of a normal force that is as steady elsewhere as without a finger; the forces are taken against their zero.
pub(super) fn steady_elsewhere(manifest: &Manifest, force: &[ForceRow]) -> Option<Flaw> {
    let moved = plausibility::moved_zero(force, &manifest.unloaded_s())
        .filter(|_| manifest.contact.body == Body::Finger)?;
    Some(Flaw::SteadyElsewhere {
        from_s: moved.from_s,
        to_s: moved.to_s,
        normal_n: moved.normal_n,
    })
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
pub(super) fn contact_area(findings: &RecordingFindings) -> Option<Implausible> {
    let fit = findings.trial.as_ref()?;
    plausibility::contact_area(fit.contact_area_m2.value)
}

/// Returns the flaw of a friction that follows the amplitude as no finger's does. Forces without a clock have a flaw of their own.
pub(super) fn friction_fit(findings: &RecordingFindings) -> Option<Implausible> {
    let fit = findings.trial.as_ref()?;
    let (lag_s, floor) = (fit.lateral_lag_s?.value, fit.friction_floor?.value);
    let rms_mu = friction_rms(fit).filter(|_| findings.force_clock.is_some());
    plausibility::friction_fit(rms_mu, lag_s, floor)
}

/// Returns the flaws that leave a recording of a finger without an instance, or with few.
pub(super) fn hardly_selected(
    findings: &RecordingFindings,
    record: &Measurements,
) -> impl Iterator<Item = Implausible> + use<> {
    let is_finger = findings.manifest.contact.body != Body::Other;
    let is_empty = findings.instances.is_empty();
    let (rules, slides) = (&findings.rules, slides(&findings.manifest));
    let speed = |tolerance: f64| rules.speed_m_per_s * (1.0 + tolerance);
    let course = Course {
        centre_m: rules.centre_m,
        central_m: rules.central_m,
        speeds_m_per_s: [-rules.speed_tolerance, rules.speed_tolerance].map(speed),
    };
    let is_sliding = |time_s: f64| {
        let mut slides = slides.iter();
        slides.any(|slide| (slide.start_s..=slide.end_s).contains(&time_s))
    };
    let frames = record.frames.iter();
    let forces = record.force.iter();
    let has_misfit = findings
        .trial
        .as_ref()
        .is_some_and(|fit| !fit.misfit.is_empty());
    let reasons = [
        plausibility::off_course(&record.position, &slides, &course).filter(|_| is_empty),
        plausibility::light_touch(&record.force, &slides, rules.contact_n)
            .or_else(|| plausibility::small_forces(&record.force, &slides).filter(|_| has_misfit)),
        plausibility::amplitude(
            frames.filter(|frame| is_sliding(frame.time_s)),
            forces.filter(|row| is_sliding(row.time_s)),
            rules.contact_n,
            findings.instances.iter().any(has_estimate),
        ),
        unplaced_forces(findings),
    ];
    let reasons = reasons.into_iter().flatten();
    reasons.filter(move |_| is_finger)
}

/// Returns the flaw of strokes there and back with unlike friction under one amplitude.
pub(super) fn strokes_differ(explorations: &[ExplorationFindings]) -> Option<Implausible> {
    let strokes = explorations.iter().map(|found| StrokeFriction {
        grows: found.direction == Direction::LeftToRight,
        mu: found.stroke.mu,
        amplitude_m: found.stroke.amplitude_m,
        speed_m_per_s: found.stroke.speed_m_per_s,
    });
    plausibility::strokes_differ(&strokes.collect::<Vec<_>>())
}

/// Returns the flaw of instances whose friction at rest jumps.
pub(super) fn friction_jumps(instances: &[InstanceAnalysis]) -> Option<Implausible> {
    let at_rest = |found: &InstanceAnalysis| Some((found.start_s, found.trial.as_ref()?.mu0));
    plausibility::friction_jumps(&{ instances.iter() }.filter_map(at_rest).collect::<Vec<_>>())
}

/// Returns the flaw of forces alone with an exploration in which no finger presses, or with less than a touch in all of them.
pub(super) fn unpressed(
    manifest: &Manifest,
    record: &Measurements,
    explorations: &[ExplorationFindings],
    rules: &SelectionRules,
) -> Option<Implausible> {
    if manifest.contact.body != Body::Finger {
        return None;
    }
    let slides = slides(manifest);
    let mut pairs = explorations.iter().zip(&slides);
    let unpressed = pairs.find(|(found, _)| found.samples > 0 && found.stroke.n == 0);
    let Some((_, &slide)) = unpressed else {
        return plausibility::light_touch(&record.force, &slides, rules.contact_n);
    };
    let light = plausibility::light_touch(&record.force, &[slide], rules.contact_n);
    light.or_else(|| {
        let normal_n = record.mean_normal_n(slide.start_s, slide.end_s)?;
        (normal_n < 0.0).then_some(Implausible::Sign { normal_n })
    })
}

fn has_estimate(instance: &InstanceAnalysis) -> bool {
    let mut methods = Method::ALL.into_iter();
    methods.any(|method| instance.estimate(method).is_some())
}

/// Returns the flaw of forces with times that nothing confirms, where friction is not that which follows from the impedance.
fn unplaced_forces(findings: &RecordingFindings) -> Option<Implausible> {
    let rms_mu = friction_rms(findings.trial.as_ref()?)?;
    let is_unplaced = findings.force_clock.is_none();
    is_unplaced.then_some(Implausible::ForcesUnplaced { rms_mu })
}

/// Returns the RMS difference of friction from that which follows from the impedance, if it is a sign of misfit.
fn friction_rms(fit: &SharedFit) -> Option<f64> {
    fit.misfit.iter().find_map(|sign| match sign {
        Misfit::Friction { rms_mu } => Some(*rms_mu),
        _ => None,
    })
}

/// Returns the flaws of drive and pickup that jump. `is_clock_known` if the forces have one delay throughout. An xrun of the bench is
/// known, and the phase of a carrier that moves is no constant.
pub(super) fn signal_jumps(
    reading: &DemodulatedRecording,
    is_clock_known: bool,
) -> impl Iterator<Item = Implausible> + use<> {
    let DemodulatedRecording {
        manifest,
        vibration,
        record,
        ..
    } = reading;
    let is_xrun =
        |event: &RecordingEvent| matches!(event.kind, EventKind::InputXrun | EventKind::OutputXrun);
    let moves = vibration.as_ref().is_none_or(|vibration| vibration.moves);
    let is_steady = !moves && !manifest.events.iter().any(is_xrun);
    let modulation_hz = manifest.modulation().map(|found| found.frequency_hz);
    let (frames, spans_s) = (&*record.frames, spans_s(manifest));
    let lost = is_steady
        .then(|| plausibility::lost_samples(frames, &spans_s, modulation_hz, is_clock_known));
    lost.flatten()
        .into_iter()
        .chain(plausibility::level_jump(frames, modulation_hz))
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
        found.filter(|reading| {
            is_missing && (channel == Channel::Drive || matches!(reading, Implausible::DeadChannel { .. }))
        })
    });
    Ok(found.collect())
}

fn slides(manifest: &Manifest) -> Vec<Slide> {
    let slide = |(direction, start_s, end_s): (Direction, f64, f64)| Slide {
        grows: direction == Direction::LeftToRight,
        start_s,
        end_s,
    };
    explorations(manifest).into_iter().map(slide).collect()
}

pub(super) fn samples(rows: &[ForceRow]) -> Vec<ForceSample> {
    let sample = |row: &ForceRow| ForceSample {
        time_s: row.time_s,
        normal: row.normal_n,
        lateral: row.lateral_n,
    };
    rows.iter().map(sample).collect()
}

impl RecordingFindings {
    /// Withholds the estimates if a flaw makes them meaningless, states it as the reason for each exploration, and returns true.
    pub(super) fn withhold(&mut self) -> bool {
        let Some(reason) = self.withheld_reason() else {
            return false;
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
        true
    }
}
