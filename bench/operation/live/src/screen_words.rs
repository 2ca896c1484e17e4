//! Translation of the protocol's types into the screen's, so that neither crate depends on the other.

use impedance::{Mask, ZmFrame};
use num_complex::Complex64;
use protocols::{
    ParticipantView, Phase, Progress, Protocol, RedoReason, SessionEventKind, TrialAnalysis,
    TrialKey, TrialLabel, TrialOutcome, TrialRecord, Verdict,
};
use tui::event::{ComplexImpedance, Live, LogLevel, Masked, NoEstimate, PhaseKind, ValueAndStd};

use crate::live_contact::{LiveContact, NoReading};
use contact::live_estimator::Uncertain;
use safety::at_least;

use crate::attempt_name::attempt_name;

/// Returns the kind of phase for the operator's screen.
pub fn phase_kind(phase: Phase) -> PhaseKind {
    match phase {
        Phase::Consent => PhaseKind::Consent,
        Phase::Welcome => PhaseKind::Idle,
        Phase::Baseline => PhaseKind::Baseline,
        Phase::Hold | Phase::Ready => PhaseKind::Ready,
        Phase::Countdown => PhaseKind::Countdown,
        Phase::Exploration => PhaseKind::Exploration,
        Phase::Lift | Phase::Feedback | Phase::Analysing => PhaseKind::Feedback,
        Phase::Verdict | Phase::Saving => PhaseKind::Verdict,
        Phase::Rest => PhaseKind::Rest,
        Phase::Paused | Phase::Fault => PhaseKind::Paused,
        Phase::Finished | Phase::Aborted => PhaseKind::Finished,
    }
}

/// Returns the participant's instruction for the dead-man switch.
pub fn hold(hold: safety::Hold) -> protocols::DeadManAction {
    match hold {
        safety::Hold::Release => protocols::DeadManAction::Release,
        safety::Hold::Press => protocols::DeadManAction::Press,
        safety::Hold::Held => protocols::DeadManAction::Held,
    }
}

/// Returns the operator's message for an event; `None` if it needs none.
pub fn notice(event: &SessionEventKind) -> Option<(LogLevel, String)> {
    Some(match event {
        SessionEventKind::CommandRefused { because, .. } => {
            (LogLevel::Warning, format!("not now: {because}"))
        }
        SessionEventKind::FingerLiftedEarly => (
            LogLevel::Info,
            "finger lifted during the countdown".to_owned(),
        ),
        SessionEventKind::FingerNotLifted => (
            LogLevel::Warning,
            "the finger stayed on the plate".to_owned(),
        ),
        SessionEventKind::DisplayLost { reason } => (
            LogLevel::Error,
            format!("paused: the participant's display is lost: {reason}"),
        ),
        SessionEventKind::DisplayBack => (
            LogLevel::Info,
            "the participant's display is back".to_owned(),
        ),
        SessionEventKind::RecorderBehind {
            lag_s,
            paused: false,
        } => (LogLevel::Warning, recorder_behind(*lag_s)),
        SessionEventKind::PauseAwaited { .. } => (
            LogLevel::Info,
            "the session pauses after this attempt".to_owned(),
        ),
        SessionEventKind::SafetyTripped { reason } => {
            (LogLevel::Error, format!("drive stopped: {reason}"))
        }
        _ => return None,
    })
}

/// Returns the message that a recorder lags too far behind for a trial to begin.
pub fn recorder_behind(lag_s: f64) -> String {
    format!(
        "the recorder is {lag_s:.1} s behind: no trial begins before it has caught up; look at the study's disk"
    )
}

/// Returns why a session paused automatically before a trial; `None` for any other event.
pub fn automatic_pause(event: &SessionEventKind) -> Option<String> {
    match event {
        SessionEventKind::DrivingTimeSpent { wait_s } => Some(format!(
            "the hour's driving time does not allow another trial: go on in {}",
            at_least(*wait_s)
        )),
        SessionEventKind::RecorderBehind {
            lag_s,
            paused: true,
        } => Some(recorder_behind(*lag_s)),
        SessionEventKind::DeadManNotHeld => {
            Some("the dead-man switch was not released and held in time".to_owned())
        }
        SessionEventKind::DisplayLost { reason } => {
            Some(format!("the participant's display is lost: {reason}"))
        }
        _ => None,
    }
}

/// Returns the operator's advice for a phase.
pub fn advice(phase: Phase, is_resumed: bool) -> Option<&'static str> {
    Some(match phase {
        Phase::Consent if is_resumed => {
            "the session goes on: record anew that the participant consents: c"
        }
        Phase::Consent => "consent is not recorded: c",
        Phase::Welcome => "the participant's button or space begins",
        Phase::Baseline => "no finger on the plate",
        Phase::Ready => "the participant places the finger and presses the button",
        Phase::Hold => "the participant releases the dead-man switch, then holds it",
        Phase::Lift => "the participant lifts the finger",
        Phase::Saving => "the recording is being saved",
        _ => return None,
    })
}

/// Returns the present phase of the session.
pub fn phase(session: &protocols::Session, view: &ParticipantView) -> tui::event::PhaseView {
    let protocol = session.protocol();
    let mut phase_view = tui::event::PhaseView::new(phase_kind(session.phase()));
    if let Some(key) = session.current() {
        let practices = protocol.trials.practice;
        phase_view.practice = key.practice;
        phase_view.trial = TrialLabel::new(key, practices).number;
        phase_view.trials = if key.practice {
            practices
        } else {
            protocol.planned_trials() - practices
        };
        phase_view.attempt = key.attempt;
    }
    if let Some(Progress {
        exploration,
        explorations,
        ..
    }) = view.progress
    {
        phase_view.exploration = exploration;
        phase_view.explorations = explorations;
    }
    let left_s = view.countdown_s.or(session.verdict_left_s());
    phase_view.countdown = left_s.map(whole_seconds);
    phase_view.message = advice(session.phase(), session.is_resumed()).map(str::to_owned);
    phase_view.pausing = session.is_pausing();
    phase_view.overrulable = session.is_judged();
    phase_view.repeats = session.verdict_repeats();
    phase_view.stopped = session.phase() == Phase::Fault;
    phase_view.aborted = session.phase() == Phase::Aborted;
    phase_view
}

/// Returns seconds of a countdown, rounded up.
pub(crate) fn whole_seconds(seconds: f64) -> u32 {
    seconds.max(0.0).ceil() as u32
}

pub(crate) fn impedance(z: Complex64) -> Option<ComplexImpedance> {
    z.is_finite().then_some(ComplexImpedance {
        re_n_s_per_m: z.re,
        im_n_s_per_m: z.im,
    })
}

/// Returns the most serious reason why a frame is masked.
fn mask_cause(mask: Mask) -> Option<Masked> {
    [
        (Mask::LOST_SAMPLES, Masked::Lost),
        (Mask::CLIPPED, Masked::Clipped),
        (Mask::ENVELOPE_NULL, Masked::BelowNoise),
    ]
    .into_iter()
    .find_map(|(flag, cause)| mask.contains(flag).then_some(cause))
}

/// Returns live values with the fields of an impedance frame; the caller fills in the others.
pub fn live(frame: &ZmFrame) -> Live {
    Live {
        t_s: frame.time_s,
        z_m_n_s_per_m: impedance(frame.corrected_n_s_per_m),
        z_plain_n_s_per_m: impedance(frame.plain_n_s_per_m),
        amplitude_m: (!frame.mask.contains(Mask::LOST_SAMPLES)).then_some(frame.amplitude_m),
        drive_v: frame.drive_v.is_finite().then(|| frame.drive_v.norm()),
        z_m_std_n_s_per_m: frame
            .mask
            .is_clear()
            .then_some(frame.corrected_std_n_s_per_m),
        masked: mask_cause(frame.mask),
        ..Live::default()
    }
}

/// Returns `live` with gap, friction and self-sensed force from the last reading of the contact, and the plate's drift.
pub fn with_contact(live: Live, contact: &LiveContact) -> Live {
    let estimate = |uncertain: Uncertain| ValueAndStd {
        value: uncertain.value,
        std: uncertain.std,
    };
    let reading = contact.latest();
    Live {
        gap_m: reading.map(|reading| estimate(reading.gap_m)),
        mu: reading.map(|reading| estimate(reading.mu)),
        sensed_normal_n: reading
            .and_then(|reading| reading.self_sensed_normal_n)
            .map(estimate),
        plate_drift_hz: contact.drift_hz().map(estimate),
        z_p_n_s_per_m: contact.plate_n_s_per_m().and_then(impedance),
        no_estimate: contact.missing_reason().map(|missing| match missing {
            NoReading::NoFit => NoEstimate::NoFit,
            NoReading::NoForce => NoEstimate::NoForce,
            NoReading::NoFinger => NoEstimate::NoFinger,
            NoReading::Masked => NoEstimate::Masked,
            NoReading::OffModel => NoEstimate::OffModel,
        }),
        ..live
    }
}

/// Formats the drift of the plate's resonance with its sign.
pub fn drift(drift_hz: Option<Uncertain>) -> String {
    drift_hz.map_or_else(
        || "unknown".to_owned(),
        |Uncertain { value, std }| {
            let decimals = statistics::error_decimals(std, 1);
            let scale = 10_f64.powi(decimals as i32);
            // Adding zero turns a negative zero positive.
            let value = (value * scale).round() / scale + 0.0;
            format!("{value:+.decimals$} ± {std:.decimals$} Hz")
        },
    )
}

/// Returns the verdict on a trial.
pub fn verdict(
    key: &TrialKey,
    protocol: &Protocol,
    verdict: &Verdict,
    analysis: Option<&TrialAnalysis>,
) -> tui::event::TrialVerdict {
    let reasons = match verdict {
        Verdict::Accepted => &[][..],
        Verdict::Redo { reasons } => reasons,
    };
    judged(key, protocol, reasons, analysis)
}

/// Returns the verdict on a trial: accepted if `reasons` is empty, otherwise rejected.
pub fn judged(
    key: &TrialKey,
    protocol: &Protocol,
    reasons: &[RedoReason],
    analysis: Option<&TrialAnalysis>,
) -> tui::event::TrialVerdict {
    let normal_n: Vec<Option<f64>> = analysis
        .map(|analysis| {
            let explorations = analysis.explorations.iter();
            explorations
                .map(|exploration| exploration.mean_normal_n)
                .collect()
        })
        .unwrap_or_default();
    let forces: Vec<f64> = normal_n.iter().flatten().copied().collect();
    let attempt = attempt_name(TrialLabel::new(key, protocol.trials.practice));
    tui::event::TrialVerdict {
        trial: attempt.trial,
        practice: attempt.practice,
        attempt: attempt.attempt,
        accepted: reasons.is_empty(),
        interrupted: false,
        reasons: reasons.iter().map(ToString::to_string).collect(),
        brief: protocols::brief_reasons(reasons),
        instances: analysis.map_or(0, |analysis| analysis.instances() as u32),
        mean_normal_n: (!forces.is_empty())
            .then(|| forces.iter().sum::<f64>() / forces.len() as f64),
        normal_n,
        settled: None,
        condition: (protocol.conditions.len() > 1).then(|| key.condition.clone()),
    }
}

/// Returns a text on an attempt with a verdict that the operator overruled; `None` for other attempts.
pub fn overruled(record: &TrialRecord, protocol: &Protocol) -> Option<String> {
    let trial = TrialLabel::new(&record.key, protocol.trials.practice).trial_name();
    match &record.outcome {
        TrialOutcome::AcceptedAnyway { reasons } if !record.key.practice => {
            let reasons: Vec<String> = reasons.iter().map(ToString::to_string).collect();
            let reasons = reasons.join("; ");
            Some(format!("{trial} kept by the operator, although: {reasons}"))
        }
        TrialOutcome::Redo { reasons } if reasons.is_empty() => {
            Some(format!("{trial} was accepted; the operator repeats it"))
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_resumed_session_says_why_it_asks_for_consent_again() {
        let [first, resumed] =
            [false, true].map(|is_resumed| advice(Phase::Consent, is_resumed).unwrap());
        assert!(first.contains("not recorded") && !first.contains("anew"));
        assert!(resumed.contains("goes on") && resumed.contains("anew"));
    }
}
