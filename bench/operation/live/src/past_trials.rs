//! Trials of a session's earlier parts, by its history.

use protocols::{Protocol, TrialLabel, TrialOutcome, TrialRecord};
use serde_json::Value;
use study::sessions::LoggedFit;
use tui::event::{FitView, TrialVerdict, ValueAndStd};

use crate::screen_words;

/// Returns the verdicts on the attempts of `records`, and the fits of attempts that the log names.
pub fn past_trials(
    records: &[TrialRecord],
    fits: &[LoggedFit],
    protocol: &Protocol,
) -> Vec<tui::Event> {
    let verdicts = records
        .iter()
        .map(|record| tui::Event::Verdict(settled(record, protocol)));
    let fits = fits
        .iter()
        .filter_map(|logged_fit| Some(tui::Event::Fit(fit(logged_fit, logged_fit.attempt?))));
    verdicts.chain(fits).collect()
}

fn fit(event: &LoggedFit, attempt: TrialLabel) -> FitView {
    let number = |name: &str| event.data.get(name).and_then(Value::as_f64);
    let estimate = |value: &str, std: &str| {
        Some(ValueAndStd {
            value: number(value)?,
            std: number(std).unwrap_or(f64::NAN),
        })
    };
    FitView {
        trial: attempt.number,
        practice: attempt.is_practice(),
        attempt: attempt.attempt,
        sigma_t_m: estimate("sigma_t_m", "sigma_t_std_m"),
        mu0: estimate("mu0", "mu0_std"),
        drift_hz: estimate("plate_drift_hz", "plate_drift_std_hz"),
        no_fit: event
            .data
            .get("no_fit")
            .and_then(Value::as_str)
            .map(str::to_owned),
        details: Vec::new(),
        curves: None,
    }
}

/// Returns the verdict on an attempt as it was settled.
pub fn settled(record: &TrialRecord, protocol: &Protocol) -> TrialVerdict {
    let (reasons, settled, accepted) = match &record.outcome {
        TrialOutcome::Accepted => (&[][..], None, true),
        TrialOutcome::AcceptedAnyway { reasons } if record.key.practice => {
            // A practice trial is never repeated for its verdict, which stands all the same.
            (&reasons[..], None, false)
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
    TrialVerdict {
        accepted,
        interrupted: matches!(record.outcome, TrialOutcome::Interrupted { .. }),
        settled,
        ..screen_words::judged(&record.key, protocol, reasons, record.analysis.as_ref())
    }
}

#[cfg(test)]
mod tests {
    use protocols::{Interruption, RedoReason, SessionEventKind, TrialKey, built_in};
    use recording::study::event_log::{Document, LogContent, LogEvent};
    use serde_json::json;

    use super::*;

    fn key(number: u32, attempt: u32) -> TrialKey {
        TrialKey {
            number,
            attempt,
            practice: number == 1,
            condition: "vibration".to_owned(),
        }
    }

    fn event(data: &Value) -> Document {
        Document::Event(LogEvent {
            stream: "protocol".to_owned(),
            seq_num: 1,
            time: String::new(),
            audio_s: 1.0,
            data: data.as_object().unwrap().clone(),
        })
    }

    fn protocol() -> Protocol {
        let text = built_in("demo").unwrap();
        Protocol::parse(text, "demo.toml").unwrap()
    }

    fn attempt_start(number: u32, attempt: u32) -> Document {
        let kind = SessionEventKind::TrialBegan {
            key: key(number, attempt),
        };
        event(&serde_json::to_value(kind).unwrap())
    }

    /// A fit follows its attempt, before or after the next attempt at the same trial begins; it belongs to the last one that
    /// has begun.
    #[test]
    fn a_fit_belongs_to_the_attempt_that_began_before_it() {
        let fit = |label: &str, sigma_t_m: f64| {
            event(
                &json!({ "event": "fit", "of": label, "sigma_t_m": sigma_t_m, "sigma_t_std_m": 1e-8 }),
            )
        };
        let documents = [
            attempt_start(1, 1),
            fit("practice 1", 1.5e-6),
            attempt_start(2, 1),
            attempt_start(2, 2),
            fit("trial 1", 1.7e-6),
            fit("trial 9", 1.9e-6),
            event(&json!({ "event": "fit", "of": 3 })),
        ];
        let content = LogContent {
            documents: documents.into(),
            torn_lines: Vec::new(),
        };
        let protocol = protocol();
        let history = study::sessions::history(&content, protocol.trials.practice);
        let events = past_trials(&[], &history.fits, &protocol);
        let fits: Vec<_> = events
            .iter()
            .filter_map(|event| match event {
                tui::Event::Fit(fit) => Some((
                    (fit.trial, fit.practice, fit.attempt),
                    fit.sigma_t_m.as_ref().unwrap().value,
                )),
                _ => None,
            })
            .collect();
        assert_eq!(fits, [((1, true, 1), 1.5e-6), ((1, false, 2), 1.7e-6)]);
    }

    #[test]
    fn a_rejected_practice_trial_stays_rejected_in_a_resumed_session() {
        let record = TrialRecord {
            key: key(1, 1),
            outcome: TrialOutcome::AcceptedAnyway {
                reasons: vec![RedoReason::NotAnalysed],
            },
            analysis: None,
        };
        let verdict = settled(&record, &protocol());
        assert!(verdict.practice && !verdict.accepted);
        assert_eq!((verdict.reasons.len(), verdict.settled), (1, None));
    }

    #[test]
    fn an_attempt_is_shown_as_it_was_settled() {
        let reasons = || vec![RedoReason::NotAnalysed];
        let settlement = "kept by the operator";
        for (outcome, accepted, words, reason_count) in [
            (TrialOutcome::Accepted, true, None, 0),
            (
                TrialOutcome::AcceptedAnyway { reasons: reasons() },
                true,
                Some(settlement),
                1,
            ),
            (TrialOutcome::Redo { reasons: reasons() }, false, None, 1),
            (
                TrialOutcome::Redo {
                    reasons: Vec::new(),
                },
                false,
                Some("repeated by the operator"),
                0,
            ),
            (
                TrialOutcome::GivenUp { reasons: reasons() },
                false,
                Some("given up: no repetition was left"),
                1,
            ),
            (
                TrialOutcome::Interrupted {
                    interruption: Interruption::Paused,
                },
                false,
                Some("paused by the operator"),
                0,
            ),
        ] {
            let record = TrialRecord {
                key: key(2, 1),
                outcome,
                analysis: None,
            };
            let verdict = settled(&record, &protocol());
            assert_eq!(
                (
                    verdict.accepted,
                    verdict.settled.as_deref(),
                    verdict.reasons.len()
                ),
                (accepted, words, reason_count),
                "{record:?}"
            );
        }
    }
}
