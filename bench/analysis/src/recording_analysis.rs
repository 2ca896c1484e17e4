//! One recording: Z_p, the instances, both estimates of each, the model check.

use std::path::Path;

use protocols::selection::{StretchOutcome, select};
use protocols::{Direction, Protocol, SelectionRules};

use crate::analysed::{RecordingAnalysis, RecordingError, RecordingFindings, Rejected};
use crate::analysis_settings::Settings;
use crate::demodulated::{self, DemodulatedRecording};
use crate::estimate::estimate;
use crate::exploration_findings::ExplorationFindings;
use crate::flaw::Flaw;
use crate::free_plate::{FreePlate, pickup_flaws};
use crate::measurements::Measurements;
use crate::model_check;
use recording::Manifest;
use recording::manifest::RecordedIntervalKind;
use recording::pipeline::PickupOffset;

/// Analyses the recording in `folder`.
pub fn analyse(folder: &Path, settings: &Settings) -> RecordingAnalysis {
    RecordingAnalysis {
        path: folder.to_owned(),
        found: findings(folder, settings),
    }
}

fn findings(folder: &Path, settings: &Settings) -> Result<RecordingFindings, RecordingError> {
    let mut reading = demodulated::read(folder, PickupOffset::default())?;
    let rules = selection_rules(folder, &reading.manifest, settings);
    let carrier_missing = reading.carrier_missing();
    let mut plate = FreePlate::read(&reading, rules.contact_n / 2.0);
    let pickup = plate.pickup_offset().unwrap_or_default();
    if pickup != PickupOffset::default() {
        reading = demodulated::read(folder, pickup)?;
        reading
            .flaws
            .extend(pickup_flaws(pickup, &reading.manifest));
        plate = FreePlate::read(&reading, rules.contact_n / 2.0);
    }
    let DemodulatedRecording {
        manifest,
        record,
        flaws,
    } = reading;
    let mut findings = RecordingFindings {
        path: folder.to_owned(),
        rules,
        pickup,
        z_p: None,
        explorations: Vec::new(),
        instances: Vec::new(),
        model_check: Vec::new(),
        rejected: Vec::new(),
        flaws,
        manifest,
    };
    let explorations = explorations(&findings.manifest);
    if explorations.is_empty() {
        findings.flaws.push(Flaw::NoExploration);
    }
    if carrier_missing {
        for (direction, start_s, end_s) in explorations {
            findings.reject(
                direction,
                (start_s, end_s),
                "the carrier is not in the signal",
            );
        }
        return Ok(findings);
    }

    findings.z_p = plate.z_p();
    findings.flaws.extend(plate.flaws(&findings.manifest));

    for (direction, start_s, end_s) in explorations {
        findings.explore(&record, direction, (start_s, end_s), settings);
    }
    if let Some(first) = findings.instances.first() {
        findings.model_check = model_check::bands(
            &first.finger,
            (first.start_s, first.end_s),
            &findings.explorations,
            &rules,
        );
        findings
            .flaws
            .extend(model_check::flaw(&findings.model_check));
    }
    Ok(findings)
}

/// Direction, start and end of each exploration, in time order.
fn explorations(manifest: &Manifest) -> Vec<(Direction, f64, f64)> {
    let mut explorations: Vec<_> = manifest
        .intervals
        .iter()
        .filter_map(|interval| match interval.kind {
            RecordedIntervalKind::Exploration(direction) => {
                Some((direction, interval.start_s, interval.end_s))
            }
            RecordedIntervalKind::Unloaded => None,
        })
        .collect();
    explorations.sort_by(|a, b| a.1.total_cmp(&b.1));
    explorations
}

/// The rules of the session's own protocol, of which a copy lies beside the recording; otherwise the settings'.
pub fn selection_rules(folder: &Path, manifest: &Manifest, settings: &Settings) -> SelectionRules {
    let centre_m = manifest.plate.centre_m;
    let own = manifest.trial.as_ref().and_then(|trial| {
        let path = folder.parent()?.join(format!("{}.toml", trial.protocol));
        let text = std::fs::read_to_string(&path).ok()?;
        Protocol::parse(&text, &path.display().to_string()).ok()
    });
    own.map_or_else(
        || settings.selection_rules(centre_m),
        |protocol| protocol.selection_rules(centre_m),
    )
}

impl RecordingFindings {
    fn reject(&mut self, direction: Direction, (start_s, end_s): (f64, f64), reason: &str) {
        self.rejected.push(Rejected {
            direction,
            start_s,
            end_s,
            reason: reason.to_owned(),
        });
    }

    /// Estimates what is selected of an exploration, and says of everything else why not.
    fn explore(
        &mut self,
        record: &Measurements,
        direction: Direction,
        span: (f64, f64),
        settings: &Settings,
    ) {
        let series = record.series(span.0, span.1);
        // Frames come from one demodulator, so they are evenly spaced.
        let stretches = select(&series.exploration(direction), &self.rules).unwrap_or_default();
        if stretches.is_empty() {
            self.reject(direction, span, "no stretch of rising amplitude");
        }
        let conditions = self
            .z_p
            .map(|z_p| z_p.conditions(settings.assumed(), self.manifest.carrier_hz));
        for stretch in &stretches {
            let selected = match stretch.outcome {
                StretchOutcome::Accepted(instance) => instance,
                StretchOutcome::Rejected(rejection) => {
                    let span = (stretch.start_s, stretch.end_s);
                    self.reject(direction, span, &rejection.to_string());
                    continue;
                }
            };
            let estimated = match &conditions {
                Some(conditions) => estimate(&series, direction, selected, conditions, settings)
                    .map_err(|error| error.to_string()),
                None => Err("Z_p is not known".to_owned()),
            };
            match estimated {
                Ok(instance) => self.instances.push(instance),
                Err(reason) => {
                    self.reject(direction, (selected.start_s, selected.end_s), &reason);
                }
            }
        }
        let exploration = ExplorationFindings::new(series, direction, span, stretches);
        self.explorations.push(exploration);
    }
}
