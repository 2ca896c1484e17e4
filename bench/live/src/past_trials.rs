//! The trials of a session's earlier parts, as its log keeps them.

use std::collections::BTreeMap;

use protocols::{Protocol, SessionEventKind, TrialKey, TrialOutcome, TrialRecord};
use recording::study::TrialLabel;
use recording::study::event_log::{Document, LogEvent};
use serde_json::Value;
use tui::event::{FitView, TrialVerdict, ValueAndStd};

use crate::screen_words;

/// Returns the verdicts on the attempts of `records`, and what their fits gave by the log's `documents`.
pub fn past_trials(
    records: &[TrialRecord],
    documents: &[Document],
    protocol: &Protocol,
) -> Vec<tui::Event> {
    let practice = protocol.trials.practice;
    let verdicts = records
        .iter()
        .map(|record| tui::Event::Verdict(settled(record, protocol)));
    // A fit names its trial alone; it is of the attempt that began last.
    let mut begun: BTreeMap<String, TrialKey> = BTreeMap::new();
    let mut fits = Vec::new();
    for event in documents.iter().filter_map(|document| match document {
        Document::Event(event) => Some(event),
        _ => None,
    }) {
        let kind = serde_json::from_value(Value::Object(event.data.clone()));
        if let Ok(SessionEventKind::TrialBegan { key }) = kind {
            begun.insert(label(&key, practice), key);
        } else if let Some(key) = fitted(event).and_then(|of| begun.get(of)) {
            fits.push(tui::Event::Fit(fit(event, key, practice)));
        }
    }
    verdicts.chain(fits).collect()
}

/// Returns how a fit names the trial of `key`.
fn label(key: &TrialKey, practice: u32) -> String {
    let number = TrialLabel::new(key, practice).number;
    let sort = if key.practice { "practice" } else { "trial" };
    format!("{sort} {number}")
}

fn fitted(event: &LogEvent) -> Option<&str> {
    let text = |key: &str| event.data.get(key).and_then(Value::as_str);
    text("event").filter(|name| *name == "fit")?;
    text("of")
}

fn fit(event: &LogEvent, key: &TrialKey, practice: u32) -> FitView {
    let number = |name: &str| event.data.get(name).and_then(Value::as_f64);
    let estimate = |value: &str, std: &str| {
        Some(ValueAndStd {
            value: number(value)?,
            std: number(std).unwrap_or(f64::NAN),
        })
    };
    FitView {
        trial: TrialLabel::new(key, practice).number,
        practice: key.practice,
        attempt: key.attempt,
        sigma_t_m: estimate("sigma_t_m", "sigma_t_std_m"),
        mu0: estimate("mu0", "mu0_std"),
        drift_hz: estimate("plate_drift_hz", "plate_drift_std_hz"),
        no_fit: event
            .data
            .get("no_fit")
            .and_then(Value::as_str)
            .map(str::to_owned),
        curves: None,
    }
}

/// Returns the judgement of an attempt as it was settled.
pub fn settled(record: &TrialRecord, protocol: &Protocol) -> TrialVerdict {
    let (reasons, settled, accepted) = match &record.outcome {
        TrialOutcome::Accepted => (&[][..], None, true),
        TrialOutcome::AcceptedAnyway { reasons } if record.key.practice => {
            (&reasons[..], None, true)
        }
        TrialOutcome::AcceptedAnyway { reasons } => {
            (&reasons[..], Some("kept by the operator".to_owned()), true)
        }
        TrialOutcome::Redo { reasons } if reasons.is_empty() => {
            (&[][..], Some("repeated by the operator".to_owned()), false)
        }
        TrialOutcome::Redo { reasons } => (&reasons[..], None, false),
        TrialOutcome::GivenUp { reasons } => (
            &reasons[..],
            Some("given up: no repetition was left".to_owned()),
            false,
        ),
        TrialOutcome::Interrupted { interruption } => {
            (&[][..], Some(interruption.to_string()), false)
        }
    };
    let reasons = reasons.iter().map(ToString::to_string).collect();
    TrialVerdict {
        accepted,
        settled,
        ..screen_words::judged(&record.key, protocol, reasons, record.analysis.as_ref())
    }
}
