//! The end of a session, for its log and its operator.

use protocols::{Phase, SessionOutcome};
use recording::study::event_log::ExitStatus;
use safety::SafetyState;

/// State of a session at its end.
pub(super) struct EndState<'a> {
    /// Failure of the program, if any.
    pub failure: Option<&'a str>,
    /// State of the safety watch.
    pub safety: &'a SafetyState,
    /// Outcome, if the session reached one.
    pub outcome: Option<&'a SessionOutcome>,
    /// Phase in which it ended.
    pub phase: Phase,
    /// Reason for its last automatic pause.
    pub paused: Option<&'a str>,
    /// Whether an operator was there.
    pub attended: bool,
}

impl EndState<'_> {
    /// Returns why the session ended early; `None` if it is complete.
    pub fn reason(&self) -> Option<String> {
        if let Some(failure) = self.failure {
            return Some(failure.to_owned());
        }
        match (self.safety, self.outcome) {
            (_, Some(SessionOutcome::Completed { .. })) => None,
            (SafetyState::Tripped { trip }, _) => Some(trip.to_string()),
            (_, Some(SessionOutcome::Aborted { .. })) => Some("aborted by the operator".to_owned()),
            (_, None) => Some(match (self.phase, self.paused) {
                (Phase::Paused, Some(paused)) => paused.to_owned(),
                (Phase::Paused, None) if self.attended => "quit while paused".to_owned(),
                (Phase::Paused, None) => {
                    "timed out waiting for the participant; no operator to resume".to_owned()
                }
                _ => "stopped before its end".to_owned(),
            }),
        }
    }

    /// Returns the exit status.
    pub fn status(&self) -> ExitStatus {
        match (self.outcome, self.safety) {
            (Some(SessionOutcome::Completed { .. }), _) => ExitStatus::Success,
            _ if self.failure.is_some() => ExitStatus::Fail,
            (_, SafetyState::Tripped { .. }) => ExitStatus::Fail,
            _ => ExitStatus::Abort,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_session_that_its_operator_quits_in_a_pause_did_not_time_out() {
        let reason = |attended, phase, paused| {
            let end = EndState {
                failure: None,
                safety: &SafetyState::Disarmed,
                outcome: None,
                phase,
                paused,
                attended,
            };
            end.reason().unwrap()
        };
        assert_eq!(reason(true, Phase::Paused, None), "quit while paused");
        assert!(reason(false, Phase::Paused, None).starts_with("timed out"));
        let spent = "the hour's driving time is spent";
        assert_eq!(reason(true, Phase::Paused, Some(spent)), spent);
        assert_eq!(reason(true, Phase::Ready, None), "stopped before its end");
    }
}
