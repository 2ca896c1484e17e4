//! Estimates of the participant's skin and the carrier, by the history of a resumed session.

use contact::uncertain::Uncertain;
use serde_json::Value;
use study::sessions::{CarrierChange, LoggedSession};

use crate::carrier_decision::DecidedCarrier;
use crate::participant_skin::{ParticipantSkin, TrialSkin};

/// State of the live side at the end of a session's earlier part.
#[derive(Debug, Default)]
pub struct Resumed {
    /// S, q0 and η of the earlier trials.
    pub skin: ParticipantSkin,
    /// Carrier chosen earlier, if it differs from the calibrated one.
    pub carrier: Option<DecidedCarrier>,
}

impl Resumed {
    /// Reads the history of the earlier parts; empty for a new session.
    pub fn from_history(history: &LoggedSession) -> Self {
        let mut trials = Vec::new();
        let mut pooled = None;
        for fit in &history.fits {
            trials.extend(fit.data.get("of_trial").and_then(TrialSkin::read));
            let used = fit.data.get("skin");
            let is_measured = |skin: &&Value| skin["trials"].as_u64() > Some(0);
            pooled = used
                .filter(is_measured)
                .and_then(TrialSkin::read)
                .or(pooled);
        }
        // Earlier versions recorded only their mean.
        if trials.is_empty() {
            trials.extend(pooled);
        }
        Self {
            skin: ParticipantSkin::from_trials(trials),
            carrier: history.carrier_change.as_ref().and_then(decided_carrier),
        }
    }
}

fn decided_carrier(change: &CarrierChange) -> Option<DecidedCarrier> {
    let number = |key: &str| {
        change
            .data
            .get(key)?
            .as_f64()
            .filter(|value| value.is_finite())
    };
    Some(DecidedCarrier {
        calibrated_hz: change.calibrated_hz?,
        to_hz: number("to_hz")?,
        drift_hz: Uncertain {
            value: number("drift_hz")?,
            std: number("drift_std_hz")?,
        },
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use contact::AssumedConstants;
    use recording::study::event_log::{Document, LogContent, LogEvent, Start};
    use serde_json::json;

    fn start(resonance_hz: f64) -> Document {
        let start = json!({
            "time": "", "resumed": false, "participant": "sub-01", "session": 1, "protocol": "demo", "seed": 1,
            "software": "", "version": "", "devices": {}, "calibration": null,
            "configuration": { "plate": { "resonance_hz": resonance_hz } },
        });
        Document::Start(Box::new(serde_json::from_value::<Start>(start).unwrap()))
    }

    fn event(data: &Value) -> Document {
        Document::Event(LogEvent {
            stream: "live".to_owned(),
            seq_num: 1,
            time: String::new(),
            audio_s: 1.0,
            data: data.as_object().unwrap().clone(),
        })
    }

    fn skin(area_m2: f64, ln_std: f64) -> Value {
        json!({
            "contact_area_m2": area_m2, "contact_area_ln_std": ln_std, "q0_rad_per_m": 2e4, "q0_ln_std": 0.1,
            "loss_factor": 0.4, "loss_factor_ln_std": 0.05, "trials": 2, "left_out": null,
        })
    }

    fn change_event(to_hz: f64) -> Document {
        event(&json!({
            "event": "carrier_changed", "from_hz": 35000.0, "to_hz": to_hz, "drift_hz": to_hz - 35000.2,
            "drift_std_hz": 0.3, "by": "operator",
        }))
    }

    fn trial_start() -> Document {
        event(&json!({ "event": "trial_began" }))
    }

    fn resumed(documents: &[Document]) -> Resumed {
        let content = LogContent {
            documents: documents.to_vec(),
            torn_lines: Vec::new(),
        };
        Resumed::from_history(&study::sessions::history(&content, 0))
    }

    fn area(documents: &[Document]) -> (usize, f64) {
        let used = resumed(documents)
            .skin
            .used(&AssumedConstants::ESTIMATION, None);
        (used.trials, used.contact_area_m2)
    }

    #[test]
    fn the_trials_before_are_pooled_as_they_were() {
        let fit = |trial: Value| {
            event(&json!({ "event": "fit", "skin": skin(250e-6, 0.02), "of_trial": trial }))
        };
        let (trials, area_m2) = area(&[
            start(35e3),
            fit(skin(200e-6, 0.1)),
            fit(Value::Null),
            start(35e3),
            fit(skin(220e-6, 0.1)),
        ]);
        assert_eq!(trials, 2);
        assert!(
            (area_m2 / (200e-6 * 220e-6_f64).sqrt() - 1.0).abs() < 1e-9,
            "{area_m2}"
        );
        // Impossible values are skipped.
        for invalid in [skin(-1.0, 0.1), skin(2e-4, 5.0), json!({}), json!("?")] {
            assert_eq!(area(&[fit(invalid), fit(skin(220e-6, 0.1))]).0, 1);
        }
        let initial = area(&[]);
        assert_eq!(initial, (0, AssumedConstants::ESTIMATION.contact_area_m2));
    }

    #[test]
    fn an_earlier_version_leaves_its_last_mean() {
        let fit = |area_m2: f64, trials: u64| {
            let mut skin = skin(area_m2, 0.05);
            skin["trials"] = json!(trials);
            event(&json!({ "event": "fit", "skin": skin }))
        };
        let (trials, area_m2) = area(&[fit(200e-6, 1), fit(210e-6, 2), fit(300e-6, 0)]);
        assert_eq!(trials, 1);
        assert!((area_m2 - 210e-6).abs() < 1e-12);
    }

    #[test]
    fn the_last_carrier_stays_unless_a_part_ran_without_it() {
        let to_hz = |documents: &[Document]| {
            let carrier = resumed(documents).carrier;
            carrier.map(|carrier| (carrier.calibrated_hz, carrier.to_hz))
        };
        let (first, second) = (change_event(34_996.0), change_event(34_991.0));
        let one_change = [start(35e3), trial_start(), first.clone()];
        assert_eq!(to_hz(&one_change), Some((35e3, 34_996.0)));
        let two_changes = [&one_change[..], &[trial_start(), second.clone()]].concat();
        assert_eq!(to_hz(&two_changes), Some((35e3, 34_991.0)));
        // The session was killed before any drive, and resumed twice.
        let resumed_twice = [&one_change[..], &[start(35e3)], &[start(35e3)]].concat();
        assert_eq!(to_hz(&resumed_twice), Some((35e3, 34_996.0)));
        let reverted = [&resumed_twice[..], &[trial_start()]].concat();
        assert_eq!(to_hz(&reverted), None);
        // Without a valid start document, the previous carrier is unknown.
        assert_eq!(to_hz(&[first]), None);
        let incomplete = event(&json!({ "event": "carrier_changed", "to_hz": "high" }));
        assert_eq!(to_hz(&[start(35e3), incomplete]), None);
    }
}
