//! Why and how a session ended, and the event of a stop in its recording.

use protocols::{Phase, SessionEventKind, SessionOutcome};
use recording::manifest::EventKind;
use recording::study::event_log::ExitStatus;
use safety::{SafetyState, Trip, at_least};

/// Returns why a session paused by itself before a trial; `None` for any other event.
pub(super) fn pause(event: &SessionEventKind) -> Option<String> {
    match event {
        SessionEventKind::DrivingTimeSpent { wait_s } => Some(format!(
            "the hour's driving time does not allow another trial: go on in {}",
            at_least(*wait_s)
        )),
        SessionEventKind::DeadManNotHeld => {
            Some("the dead-man switch was not released and held in time".to_owned())
        }
        _ => None,
    }
}

/// Returns why a session ended early, `paused` being why it last paused by itself; `None` if it did not.
pub(super) fn reason(
    failure: Option<&str>,
    safety: &SafetyState,
    ended: Option<&SessionOutcome>,
    phase: Phase,
    paused: Option<&str>,
) -> Option<String> {
    if let Some(failure) = failure {
        return Some(failure.to_owned());
    }
    match (safety, ended) {
        (_, Some(SessionOutcome::Completed { .. })) => None,
        (SafetyState::Tripped { trip }, _) => Some(trip.to_string()),
        (_, Some(SessionOutcome::Aborted { .. })) => Some("aborted by the operator".to_owned()),
        (_, None) => Some(match (phase, paused) {
            (Phase::Paused, Some(paused)) => paused.to_owned(),
            (Phase::Paused, None) => {
                "timed out waiting for the participant; no operator to resume".to_owned()
            }
            _ => "stopped before its end".to_owned(),
        }),
    }
}

/// Returns the exit status of a session.
pub(super) fn status(
    failed: bool,
    safety: &SafetyState,
    ended: Option<&SessionOutcome>,
) -> ExitStatus {
    match (ended, safety) {
        (Some(SessionOutcome::Completed { .. }), _) => ExitStatus::Success,
        _ if failed => ExitStatus::Fail,
        (_, SafetyState::Tripped { .. }) => ExitStatus::Fail,
        _ => ExitStatus::Abort,
    }
}

/// Returns the event of a stop, by its reason.
pub(super) fn stop_kind(safety: &SafetyState) -> EventKind {
    match safety {
        SafetyState::Tripped {
            trip: Trip::EmergencyStop | Trip::Operator,
        } => EventKind::EmergencyStop,
        SafetyState::Tripped {
            trip: Trip::Readback { .. } | Trip::ReadbackMissing | Trip::AliveWhileDisarmed { .. },
        } => EventKind::ReadbackMismatch,
        _ => EventKind::Safe,
    }
}
