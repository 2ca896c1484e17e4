//! Analysis of a recording: Z_p, the instances, both estimates of each, the model check.

use std::io::ErrorKind;
use std::path::Path;

use plausibility::Implausible;
use protocols::selection::{StretchOutcome, select};
use protocols::{Direction, Protocol, SelectionRules};

use crate::amplitude_profile::AmplitudeProfile;
use crate::analysis_settings::Settings;
use crate::clock_reading;
use crate::consistency;
use crate::crosstalk::{self, SeenCrosstalk};
use crate::demodulation::{self, DemodulatedRecording};
use crate::error_budget::ErrorBudget;
use crate::findings::{RecordingAnalysis, RecordingError, RecordingFindings, RejectedStretch};
use estimation::trial::PlateReadings;

use crate::estimate::{InstanceAnalysis, estimate};
use crate::exploration_findings::{ExplorationFindings, drive_peak_v, pressing_n};
use crate::exploration_series::ExplorationSeries;
use crate::explorations::explorations;
use crate::flaw::Flaw;
use crate::force_clock::ForceClock;
use crate::force_zero::ForceZero;
use crate::forces_alone;
use crate::free_plate::{FreePlate, pickup_flaws};
use crate::measurements::Measurements;
use crate::model_check;
use crate::plate_references;
use crate::recording_series::RecordingSeries;
use crate::sample_statistics::{ByMethod, SampleStatistics};
use crate::under_finger::UnderFinger;
use crate::whole_trial;
use recording::pipeline::PickupOffset;
use recording::{Manifest, RecordingSource};
use study::protocol_copies::second_copy;
use study::provenance::Provenance;

/// Analyses the recording in `folder`, and drops its series.
pub fn analyse(folder: &Path, settings: &Settings) -> RecordingAnalysis {
    analyse_with_series(folder, settings).0
}

/// Analyses the recording in `folder`; returns also its series, which are empty if it cannot be read.
pub fn analyse_with_series(
    folder: &Path,
    settings: &Settings,
) -> (RecordingAnalysis, RecordingSeries) {
    analyse_source(&RecordingSource::folder(folder), settings)
}

/// Analyses a recording, from its folder or from memory, as [`analyse_with_series`] does.
pub fn analyse_source(
    source: &RecordingSource<'_>,
    settings: &Settings,
) -> (RecordingAnalysis, RecordingSeries) {
    let (findings, series) = match findings(source, settings) {
        Ok((findings, series)) => (Ok(findings), series),
        Err(error) => (Err(error), RecordingSeries::default()),
    };
    let findings_read = findings.as_ref().ok();
    let participant =
        findings_read.and_then(|findings: &RecordingFindings| findings.participant.clone());
    let analysis = RecordingAnalysis {
        path: source.path().to_owned(),
        participant,
        findings,
    };
    (analysis, series)
}

/// Returns the flaws of the recording in `folder` that its streams show before anything is estimated.
///
/// # Errors
/// If the recording cannot be read.
pub fn flaws(folder: &Path, settings: &Settings) -> Result<Vec<Flaw>, RecordingError> {
    let checked = checked(&RecordingSource::folder(folder), settings)?;
    let (Checked::Complete(findings, _) | Checked::Estimable(findings, _)) = checked;
    Ok(findings.flaws)
}

/// Recording with streams that were read and checked.
enum Checked {
    /// Recording without an estimate: of forces alone, or with numbers that are withheld.
    Complete(RecordingFindings, RecordingSeries),
    /// Recording to be estimated, with its measurements.
    Estimable(RecordingFindings, Measurements),
}

/// Findings of a recording in the making, with its series.
struct Work {
    findings: RecordingFindings,
    series: RecordingSeries,
}

/// Reads a recording and checks its streams against each other.
fn checked(source: &RecordingSource<'_>, settings: &Settings) -> Result<Checked, RecordingError> {
    let mut reading = demodulation::read(source, PickupOffset::default())?;
    let (rules, protocol_flaw) = source_rules(source, &reading.manifest, settings);
    if reading.vibration.is_none() {
        let (findings, series) = forces_alone::findings(source.path(), reading, rules);
        return Ok(Checked::Complete(findings, series));
    }
    let is_carrier_missing = reading.is_carrier_missing();
    let mut implausible = consistency::implausible(&reading);
    let mut zero = subtract_zero(&mut reading);
    let mut plate = FreePlate::read(&reading, rules.contact_n / 2.0);
    let stated_errors = reading.manifest.standard_errors.unwrap_or_default();
    let pickup = plate.pickup_offset(stated_errors.impedance_relative);
    let pickup = pickup.unwrap_or_default();
    let read_again = |clock: Option<&ForceClock>| -> Result<_, RecordingError> {
        let mut reading = demodulation::read(source, pickup)?;
        reading
            .flaws
            .extend(pickup_flaws(pickup, stated_phase_rad(&reading.manifest)));
        if let Some(clock) = clock {
            clock.correct(&mut reading.record.force);
        }
        let zero = subtract_zero(&mut reading);
        let plate = FreePlate::read(&reading, rules.contact_n / 2.0);
        Ok((reading, zero, plate))
    };
    if pickup != PickupOffset::default() {
        (reading, zero, plate) = read_again(None)?;
    }
    let clock = match clock_reading::read(&reading, plate.z_p()) {
        Ok(clock) if implausible.is_empty() => clock,
        Ok(clock) => clock.map(ForceClock::uncorrected),
        Err(unclear) => {
            if implausible.is_empty() {
                implausible.push(unclear);
            }
            None
        }
    };
    let corrected = clock.as_ref().filter(|clock| clock.is_corrected());
    if corrected.is_some() {
        (reading, zero, plate) = read_again(corrected)?;
    }
    if zero.readings.is_empty() {
        implausible.extend(consistency::strokes_zero(&mut reading));
    }
    if implausible.is_empty() {
        implausible.extend(consistency::tared(&reading, rules.contact_n));
    }
    implausible.extend(clock.iter().flat_map(ForceClock::flaws));
    if is_carrier_missing {
        implausible.extend(consistency::without_carrier(source, &reading)?);
    } else {
        // Noise has no phase.
        implausible.extend(consistency::signal_jumps(&reading, clock.is_some()));
    }
    let DemodulatedRecording {
        manifest,
        vibration,
        record,
        mut flaws,
    } = reading;
    let explorations = explorations(&manifest);
    let exploration_spans_s: Vec<(f64, f64)> = explorations
        .iter()
        .map(|(_, start_s, end_s)| (*start_s, *end_s))
        .collect();
    flaws.extend(implausible.into_iter().map(Flaw::from));
    let room = manifest.room;
    let pressure = room.and_then(|room| plausibility::pressure(room.pressure_hpa));
    flaws.extend(pressure.map(Flaw::from));
    flaws.extend(protocol_flaw);
    flaws.extend(rehearsal_flaw(&manifest));
    flaws.extend(zero.flaws());
    flaws.extend(consistency::steady_elsewhere(&manifest, &record.force));
    let touch = record.force_under_finger(&exploration_spans_s, rules.contact_n);
    let is_unsigned = flaws.contains(&Flaw::Implausible(Implausible::LateralUnsigned));
    // A force that does not turn with the finger would be one of the normal force.
    let crosstalk = match is_unsigned {
        true => SeenCrosstalk::default(),
        false => crosstalk::seen(&record, &explorations, &rules),
    };
    let bounded = crosstalk.is_bounded.then_some(crosstalk.per_normal);
    flaws.extend(bounded.and_then(plausibility::crosstalk).map(Flaw::from));
    let has_pressure = manifest.room.is_some();
    let errors = ErrorBudget::new(stated_errors, (&zero, crosstalk), &touch, has_pressure);
    let mut findings = RecordingFindings {
        path: source.path().to_owned(),
        participant: manifest
            .participant
            .as_ref()
            .map(|participant| participant.id.clone()),
        rules,
        pickup,
        errors,
        zero,
        force_clock: clock,
        z_p: None,
        explorations: Vec::new(),
        instances: Vec::new(),
        trial: None,
        within_laws: None,
        sample_statistics: ByMethod::default(),
        model_check: Vec::new(),
        rejected: Vec::new(),
        flaws,
        provenance: Provenance::new(&manifest, None),
        manifest,
        vibration,
    };
    if explorations.is_empty() {
        findings.flaws.push(Flaw::NoExploration);
    }
    findings.flaws.extend(Flaw::coinciding(&explorations));
    if is_carrier_missing {
        for (direction, start_s, end_s) in explorations {
            findings.reject(
                direction,
                (start_s, end_s),
                "the carrier is not in the signal",
            );
        }
        return Ok(Checked::Complete(findings, RecordingSeries::default()));
    }

    findings.z_p = plate.z_p();
    let has_touch = !explorations.is_empty() && !record.force.is_empty();
    if findings.zero.readings.is_empty() && findings.z_p.is_some() && has_touch {
        findings.flaws.push(Flaw::ForceZeroUnread);
    }
    if let Some(vibration) = &findings.vibration {
        let resonance_hz = vibration.plate.resonance_hz;
        let off_resonance = plausibility::carrier(vibration.carrier_hz, resonance_hz);
        let is_explained =
            |flaw: &Flaw| off_resonance.is_some() && matches!(flaw, Flaw::PlateScatters { .. });
        let impedance_error = findings.errors.known.impedance_relative;
        let plate_flaws = plate.flaws(vibration, impedance_error).into_iter();
        let plate_flaws = plate_flaws.filter(|flaw| !is_explained(flaw));
        findings.flaws.extend(plate_flaws);
        findings.flaws.extend(off_resonance.map(Flaw::from));
    }
    Ok(match findings.withhold() {
        true => Checked::Complete(findings, RecordingSeries::default()),
        false => Checked::Estimable(findings, record),
    })
}

fn findings(
    source: &RecordingSource<'_>,
    settings: &Settings,
) -> Result<(RecordingFindings, RecordingSeries), RecordingError> {
    let (findings, record) = match checked(source, settings)? {
        Checked::Complete(findings, series) => return Ok((findings, series)),
        Checked::Estimable(findings, record) => (findings, record),
    };
    let rules = findings.rules;
    let explorations = explorations(&findings.manifest);
    let mut work = Work {
        findings,
        series: RecordingSeries::default(),
    };
    for (direction, start_s, end_s) in explorations {
        source.require_running()?;
        work.explore(&record, direction, (start_s, end_s), settings);
    }
    source.require_running()?;
    let readings = plate_references::read(&record, rules.contact_n / 2.0);
    work.fit_together(&readings, settings);
    let Work {
        mut findings,
        series,
    } = work;
    let is_crosstalk = { findings.flaws.iter() }
        .any(|flaw| matches!(flaw, Flaw::Implausible(Implausible::Crosstalk { .. })));
    let by_fit = [
        consistency::contact_area(&findings),
        consistency::friction_fit(&findings),
        consistency::strokes_differ(&findings.explorations).filter(|_| !is_crosstalk),
        consistency::friction_jumps(&findings.instances),
    ];
    let by_fit = by_fit.into_iter().flatten().map(Flaw::from);
    findings.flaws.extend(by_fit);
    let hardly_selected = consistency::hardly_selected(&findings, &record);
    findings.flaws.extend(hardly_selected.map(Flaw::from));
    if findings.withhold() {
        return Ok((findings, RecordingSeries::default()));
    }
    findings.sample_statistics = ByMethod::new(|method| {
        SampleStatistics::new(&findings.instances, &series.instances, method)
    });
    if let Some((instance, sampled)) = findings.first_dynamic_instance(&series) {
        findings.model_check = model_check::bands(
            &sampled.finger,
            (instance.start_s, instance.end_s),
            &series.explorations,
            &rules,
        );
        findings
            .flaws
            .extend(model_check::flaw(&findings.model_check));
    }
    Ok((findings, series))
}

/// Returns the stated phase of the pickup, rad; that of envelopes is included in them.
fn stated_phase_rad(manifest: &Manifest) -> f64 {
    let signals = manifest.signals();
    signals.map_or(0.0, |signals| signals.channels.pickup.phase_rad)
}

/// Takes the forces of a recording against its own zero, and returns the zero.
fn subtract_zero(reading: &mut DemodulatedRecording) -> ForceZero {
    let zero = ForceZero::read(&reading.record, &reading.manifest.unloaded_s());
    zero.subtract(&mut reading.record.force);
    zero
}

/// Returns the flaw of a recording during which faults were injected on purpose.
fn rehearsal_flaw(manifest: &Manifest) -> Option<Flaw> {
    let faults = manifest.hardware.as_ref()?.rehearsed.clone();
    (!faults.is_empty()).then_some(Flaw::Rehearsed { faults })
}

/// Returns the selection rules for a recording: in memory, those of its protocol, or else of `settings`.
fn source_rules(
    source: &RecordingSource<'_>,
    manifest: &Manifest,
    settings: &Settings,
) -> (SelectionRules, Option<Flaw>) {
    let Some(arrays) = source.in_memory() else {
        return selection_rules(source.path(), manifest, settings);
    };
    let centre_m = manifest.plate().map_or(0.0, |plate| plate.centre_m);
    let protocol = arrays.protocol();
    let rules = protocol.map_or_else(
        || settings.selection_rules(centre_m),
        |protocol| protocol.selection_rules(centre_m),
    );
    (rules, None)
}

/// Returns the selection rules for the recording in `folder`: those of the copy of the session's protocol
/// next to the recording. Without a copy, as for a recording made elsewhere, the rules are those of `settings`; likewise
/// if the copy cannot be read, with a flaw that reports it.
pub fn selection_rules(
    folder: &Path,
    manifest: &Manifest,
    settings: &Settings,
) -> (SelectionRules, Option<Flaw>) {
    // Forces alone are not selected by place.
    let centre_m = manifest.plate().map_or(0.0, |plate| plate.centre_m);
    match protocol_copy(folder, manifest) {
        Ok(Some(protocol)) => {
            let rules = protocol.selection_rules(centre_m);
            (rules, copies_flaw(folder, manifest))
        }
        Ok(None) => (settings.selection_rules(centre_m), None),
        Err(flaw) => (settings.selection_rules(centre_m), Some(flaw)),
    }
}

/// Returns the text of the copy of the session's protocol next to a recording; `None` if there is no copy that can be read.
#[must_use]
pub fn protocol_text(folder: &Path, manifest: &Manifest) -> Option<String> {
    let copy = read_protocol(folder, manifest).ok()?;
    copy.map(|(_, text)| text)
}

/// Reads the copy of the session's protocol next to a recording; `None` if there is no copy.
fn protocol_copy(folder: &Path, manifest: &Manifest) -> Result<Option<Protocol>, Flaw> {
    let copy = read_protocol(folder, manifest)?;
    Ok(copy.map(|(protocol, _)| protocol))
}

/// Reads the copy of the session's protocol next to a recording, and its text.
fn read_protocol(folder: &Path, manifest: &Manifest) -> Result<Option<(Protocol, String)>, Flaw> {
    let Some((trial, session)) = manifest.trial.as_ref().zip(folder.parent()) else {
        return Ok(None);
    };
    let protocol_file = trial.protocol_file.as_deref();
    let name = protocol_file.map_or_else(|| format!("{}.toml", trial.protocol), str::to_owned);
    let path = session.join(&name);
    if Path::new(&name).file_name() != Some(name.as_ref()) {
        let reason = format!(
            "`trial.protocol_file` is {name:?}, and no name of a file in the session's folder"
        );
        return Err(Flaw::ProtocolCopy { path, reason });
    }
    let file = path.display().to_string();
    let protocol = match bounded_files::read_text(&path, bounded_files::TEXT_LIMIT_BYTES) {
        // The recording was made elsewhere; one that names its copy had one.
        Err(error) if error.kind() == ErrorKind::NotFound && protocol_file.is_none() => {
            return Ok(None);
        }
        Err(error) => Err(format!("{file}: {}", bounded_files::cause(&error))),
        Ok(text) => match Protocol::parse(&text, &file) {
            Ok(protocol) => Ok((protocol, text)),
            Err(error) => Err(error.to_string()),
        },
    };
    protocol
        .map(Some)
        .map_err(|reason| Flaw::ProtocolCopy { path, reason })
}

/// Returns the flaw of a recording that does not name its protocol copy although the session has several.
fn copies_flaw(folder: &Path, manifest: &Manifest) -> Option<Flaw> {
    let (trial, session) = manifest.trial.as_ref().zip(folder.parent())?;
    if trial.protocol_file.is_some() {
        return None;
    }
    let second_copy = session.join(second_copy(&trial.protocol));
    second_copy.exists().then(|| Flaw::ProtocolCopies {
        followed: format!("{}.toml", trial.protocol),
    })
}

impl RecordingFindings {
    /// Rejects a stretch for a reason that begins with its kind.
    pub(crate) fn reject(&mut self, direction: Direction, span: (f64, f64), reason: &str) {
        let kind = reason.split(": ").next().unwrap_or(reason);
        self.reject_as(direction, span, (reason, kind));
    }

    fn reject_as(
        &mut self,
        direction: Direction,
        (start_s, end_s): (f64, f64),
        (reason, kind): (&str, &str),
    ) {
        self.rejected.push(RejectedStretch {
            direction,
            start_s,
            end_s,
            reason: reason.to_owned(),
            kind: kind.to_owned(),
        });
    }
}

impl Work {
    /// Estimates the instances selected from an exploration, and records why every other stretch was rejected.
    fn explore(
        &mut self,
        record: &Measurements,
        direction: Direction,
        span: (f64, f64),
        settings: &Settings,
    ) {
        let series = record.series(span.0, span.1);
        let findings = &mut self.findings;
        let z_p = findings.z_p.map(|z_p| z_p.corrected_n_s_per_m);
        let profile = findings
            .plate()
            .map_or_else(AmplitudeProfile::default, AmplitudeProfile::from);
        let under_finger = UnderFinger::new(&series, &profile, z_p);
        // Frames come from one demodulator, so they are evenly spaced.
        let stretches = select(&series.exploration(direction), &findings.rules).unwrap_or_default();
        if stretches.is_empty() {
            findings.reject(direction, span, "no stretch of rising amplitude");
        }
        let conditions = findings.conditions(settings);
        let modal_mass_kg = findings
            .plate()
            .map_or(f64::NAN, |plate| plate.modal_mass_kg);
        for stretch in &stretches {
            let instance = match stretch.outcome {
                StretchOutcome::Accepted(instance) => instance,
                StretchOutcome::Rejected(rejection) => {
                    let span = (stretch.start_s, stretch.end_s);
                    let reason = rejection.to_string();
                    findings.reject_as(direction, span, (&reason, rejection.kind()));
                    continue;
                }
            };
            let counted = findings.instances.iter().find(|counted| {
                instance.start_s < counted.end_s && counted.start_s < instance.end_s
            });
            if let Some(counted) = counted {
                let reason = format!(
                    "counted already, in another exploration: {:.2} to {:.2} s",
                    counted.start_s, counted.end_s
                );
                findings.reject(direction, (instance.start_s, instance.end_s), &reason);
                continue;
            }
            let analysis = match &conditions {
                Some(conditions) => {
                    let exploration_key = (findings.explorations.len(), direction);
                    let plate = (conditions, modal_mass_kg);
                    estimate(
                        (&series, &under_finger),
                        exploration_key,
                        instance,
                        plate,
                        settings,
                    )
                }
                .map_err(|error| error.to_string()),
                None => Err("Z_p is not known".to_owned()),
            };
            match analysis {
                Ok((instance, samples)) => {
                    findings.instances.push(instance);
                    self.series.instances.push(samples);
                }
                Err(reason) => {
                    findings.reject(direction, (instance.start_s, instance.end_s), &reason);
                }
            }
        }
        let drive_peak_v = drive_peak_v(&series);
        let least_n = pressing_n(&findings.manifest, &findings.rules);
        let series = ExplorationSeries::new(series, under_finger);
        findings.explorations.push(ExplorationFindings {
            drive_peak_v,
            stretches,
            ..ExplorationFindings::new(&series, direction, span, least_n)
        });
        self.series.explorations.push(series);
    }

    /// Fits all instances together. Those that `paper` or `dynamic` cannot use are kept only if this fit can use them.
    fn fit_together(&mut self, readings: &PlateReadings, settings: &Settings) {
        let findings = &self.findings;
        let Some((conditions, plate)) =
            findings.conditions(settings).zip(findings.plate().cloned())
        else {
            return;
        };
        let fit = |work: &mut Self| {
            let plate = (&conditions, &plate);
            let findings = &mut work.findings;
            let instances = (&mut findings.instances[..], &mut work.series.instances[..]);
            let fits = whole_trial::fit(instances, plate, readings, settings).ok();
            (findings.trial, findings.within_laws) = match fits {
                Some(fits) => (Some(fits.total), fits.within_laws),
                None => (None, None),
            };
        };
        fit(self);
        if self.drop_unusable() {
            fit(self);
        }
    }

    /// Rejects each instance that has no estimate by `trial` and is unusable by `paper` or `dynamic`; returns whether any were
    /// rejected and others remain.
    fn drop_unusable(&mut self) -> bool {
        let Self { findings, series } = self;
        let usability_error = |instance: &InstanceAnalysis| match instance.trial {
            Some(_) => None,
            None => instance.usability_error(),
        };
        let instances = std::mem::take(&mut findings.instances);
        let samples = std::mem::take(&mut series.instances);
        let mut has_unusable = false;
        for (instance, samples) in instances.into_iter().zip(samples) {
            match usability_error(&instance) {
                None => {
                    findings.instances.push(instance);
                    series.instances.push(samples);
                }
                Some(error) => {
                    has_unusable = true;
                    let span = (instance.start_s, instance.end_s);
                    findings.reject(instance.direction, span, &error.to_string());
                }
            }
        }
        findings
            .rejected
            .sort_by(|a, b| a.start_s.total_cmp(&b.start_s));
        has_unusable && !findings.instances.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use protocols::built_in;
    use recording::manifest::MINIMAL;
    use recording::{AudioFormat, RecordingWriter};

    use super::*;

    const TRIAL: &str = r#"
[trial]
number = 1
attempt = 1
practice = false
condition = "6 Hz"
protocol = "own"
seed = 1
"#;

    fn manifest() -> Manifest {
        Manifest::parse(&format!("{MINIMAL}{TRIAL}"), "recording.toml").unwrap()
    }

    fn settings() -> Settings {
        Settings {
            contact_n: 0.123,
            ..Settings::default()
        }
    }

    #[test]
    fn the_rules_come_from_the_recordings_protocol_or_else_the_settings() {
        let session = tempfile::tempdir().unwrap();
        let folder = session.path().join("trial-001_attempt-1");
        let manifest = manifest();
        let copy = session.path().join("own.toml");
        let rules = || selection_rules(&folder, &manifest, &settings());
        let settings_rules = settings().selection_rules(0.05);

        assert_eq!(
            rules(),
            (settings_rules, None),
            "no copy, as made elsewhere"
        );

        let text = built_in("huloux2021").unwrap();
        std::fs::write(&copy, text).unwrap();
        let protocol = Protocol::parse(text, "own.toml").unwrap();
        let protocol_rules = protocol.selection_rules(0.05);
        assert_ne!(protocol_rules, settings_rules);
        assert_eq!(rules(), (protocol_rules, None));

        // The session was resumed after an edit: it is unknown which of the two copies the recording followed.
        let edited_copy = session.path().join("own.2.toml");
        std::fs::write(
            &edited_copy,
            text.replacen("central_m = 0.060", "central_m = 0.030", 1),
        )
        .unwrap();
        let (first_rules, flaw) = rules();
        assert_eq!(first_rules, protocol_rules);
        assert!(
            matches!(flaw, Some(Flaw::ProtocolCopies { .. })),
            "{flaw:?}"
        );
        // The first copy was read, although the second was followed.
        let mut named_manifest = manifest.clone();
        let mut rules_for_copy = |name: &str| {
            named_manifest.trial.as_mut().unwrap().protocol_file = Some(name.to_owned());
            selection_rules(&folder, &named_manifest, &settings())
        };
        assert_eq!(rules_for_copy("own.toml"), (protocol_rules, None));
        let (second_rules, flaw) = rules_for_copy("own.2.toml");
        assert_eq!((second_rules.central_m, flaw), (0.030, None));
        for file in ["own.3.toml", "../own.toml", "", ".."] {
            let (fallback_rules, flaw) = rules_for_copy(file);
            assert_eq!(fallback_rules, settings_rules);
            assert!(matches!(flaw, Some(Flaw::ProtocolCopy { .. })), "{file}");
        }
        std::fs::remove_file(edited_copy).unwrap();

        // Truncated in the middle, and with bytes that are not text.
        let truncated = text.as_bytes()[..text.len() / 2].to_vec();
        for content in [truncated, vec![0xff; 64]] {
            std::fs::write(&copy, content).unwrap();
            let (fallback_rules, flaw) = rules();
            assert_eq!(fallback_rules, settings_rules);
            let Some(Flaw::ProtocolCopy { path, reason }) = flaw else {
                panic!("{flaw:?}");
            };
            assert_eq!(path, copy);
            assert!(reason.contains("own.toml"), "{reason}");
        }
    }

    #[test]
    fn an_analysis_lists_a_damaged_protocol_copy_among_the_flaws() {
        let session = tempfile::tempdir().unwrap();
        let folder = session.path().join("trial-001_attempt-1");
        let manifest = manifest();
        let format = AudioFormat {
            sample_rate_hz: 96_000,
            channels: 2,
        };
        let mut writer = RecordingWriter::create(&folder, manifest, format).unwrap();
        writer.write_audio(&[0.0; 2 * 9600]).unwrap();
        writer.finish(recording::writer::Ending::Completed).unwrap();
        let has_copy_flaw = |analysis: RecordingAnalysis| {
            let flaws = analysis.findings.unwrap().flaws;
            flaws
                .iter()
                .any(|flaw| matches!(flaw, Flaw::ProtocolCopy { .. }))
        };
        assert!(!has_copy_flaw(analyse(&folder, &settings())));
        std::fs::write(session.path().join("own.toml"), "format = ").unwrap();
        assert!(has_copy_flaw(analyse(&folder, &settings())));
    }
}
