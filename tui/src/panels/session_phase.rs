//! The current phase of the session, in one line.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::Line;

use crate::event::{PhaseKind, SafetyView, TrialVerdict};
use crate::state::State;
use drawing::words::{LinePart, fit_parts, render_line};

pub(crate) fn render(state: &State, area: Rect, buf: &mut Buffer) {
    render_line(line(state, area.width.into()), area, buf);
}

/// Returns the phase and its place in the session, as far as they fit into `columns`.
pub(crate) fn line(state: &State, columns: usize) -> Line<'static> {
    let (phase, plain) = (&state.phase, Style::new());
    let mut parts = match phase.kind {
        PhaseKind::Verdict => verdict_parts(state),
        PhaseKind::Paused if !state.session.replayed => pause_parts(state),
        kind => {
            let countdown = phase.countdown.map(|left_s| format!(" {left_s} s"));
            let name = match kind {
                _ if phase.aborted => "aborted",
                PhaseKind::Monitoring if state.session.replayed => "replay",
                kind => name(kind),
            };
            let text = format!("{name}{}", countdown.unwrap_or_default());
            vec![LinePart::new(0, text, state.ui.theme.strong())]
        }
    };
    parts.extend(
        phase
            .pausing
            .then(|| LinePart::new(3, "pauses after this attempt", plain)),
    );
    parts.extend(place_parts(state));
    parts.extend(
        phase
            .message
            .as_ref()
            .map(|text| LinePart::new(5, text, plain)),
    );
    fit_parts(parts, columns, state.ui.theme.faint())
}

/// Returns the verdict, its reasons, the outcome and the key that overrules it.
fn verdict_parts(state: &State) -> Vec<LinePart> {
    let (phase, theme, plain) = (&state.phase, state.ui.theme, Style::new());
    let Some(verdict) = open_verdict(state) else {
        return vec![LinePart::new(0, "saving the recording", theme.strong())];
    };
    let outcome = match (verdict.accepted, phase.repeats, phase.practice) {
        (false, true, _) => "repeats",
        (false, false, false) => "given up",
        _ => "goes on",
    };
    let key = match (verdict.accepted, phase.practice) {
        (false, false) => "o keeps it",
        _ => "r repeats it",
    };
    let mut parts = judgement_parts(state, verdict);
    let left = phase
        .countdown
        .map(|left_s| format!("{outcome} in {left_s} s"));
    parts.extend(left.map(|text| LinePart::new(2, text, plain)));
    parts.push(LinePart::new(3, key, plain));
    parts
}

/// Returns the verdict that can be overruled.
fn open_verdict(state: &State) -> Option<&TrialVerdict> {
    let is_open = |verdict: &&TrialVerdict| verdict.name() == state.phase.name();
    let verdict = state.verdict.as_ref().filter(is_open);
    verdict.filter(|_| state.phase.overrulable)
}

/// Returns whether a trial is accepted, and the reasons if it is not.
fn judgement_parts(state: &State, verdict: &TrialVerdict) -> Vec<LinePart> {
    let theme = state.ui.theme;
    if verdict.accepted {
        let force = verdict.mean_normal_n.map(|n| format!("force {n:.2} N"));
        let force = force.map(|text| LinePart::new(4, text, Style::new()).after(": "));
        return std::iter::once(LinePart::new(0, "ACCEPTED", theme.good()))
            .chain(force)
            .collect();
    }
    let word = if verdict.practice {
        "PRACTICE"
    } else {
        "REJECTED"
    };
    let mut parts = vec![LinePart::new(0, word, theme.bad())];
    parts.extend(reason_parts(verdict, theme.bad(), ": "));
    parts
}

/// Returns the reasons of a rejection in a few words; the first one follows after `separator`.
pub(crate) fn reason_parts(
    verdict: &TrialVerdict,
    style: Style,
    separator: &'static str,
) -> Vec<LinePart> {
    let mut parts = Vec::new();
    for (reason, texts) in verdict.brief.iter().enumerate() {
        for (i, text) in texts.iter().enumerate() {
            let (rank, separator) = match (reason, i) {
                (0, 0) => (1, separator),
                (0, 1) => (4, ", "),
                (0, _) => (7, ", "),
                (_, 0) => (8, "; "),
                _ => (9, ", "),
            };
            parts.push(LinePart::new(rank, text, style).after(separator));
        }
    }
    parts
}

/// Returns the pause, an open verdict, and the key that ends the pause.
fn pause_parts(state: &State) -> Vec<LinePart> {
    let (theme, plain) = (state.ui.theme, Style::new());
    let (text, style, key) = match (state.safety, state.phase.stopped) {
        (Some(SafetyView::Tripped), _) if state.is_device_lost() => {
            ("STOPPED", theme.bad(), "a device is lost: x cannot re-arm")
        }
        (Some(SafetyView::Tripped), _) => {
            ("STOPPED", theme.bad(), "find the cause, then x re-arms")
        }
        (Some(SafetyView::Driving), _) => ("PAUSED", theme.warning(), "p goes on"),
        (_, true) => ("READY, drive off", theme.warning(), "p goes on"),
        (_, false) => ("PAUSED, drive off", theme.warning(), "p goes on"),
    };
    let mut parts = vec![LinePart::new(0, text, style), LinePart::new(1, key, plain)];
    if let Some(verdict) = open_verdict(state) {
        let judgement = judgement_parts(state, verdict).into_iter();
        parts.extend(judgement.map(|part| LinePart {
            rank: part.rank + 2,
            ..part
        }));
        let key = (!verdict.accepted && !state.phase.practice).then_some("o keeps it");
        parts.extend(key.map(|key| LinePart::new(4, key, plain)));
    }
    parts
}

/// Returns the trial, its attempt, exploration and condition.
fn place_parts(state: &State) -> Vec<LinePart> {
    let phase = &state.phase;
    let mut texts = Vec::new();
    let live = state.live().filter(|_| state.session.replayed);
    texts.extend(live.map(|live| (1, format!("at {:.1} s", live.t_s))));
    if phase.trial > 0 {
        let sort = if phase.practice { "practice" } else { "trial" };
        texts.push((5, format!("{sort} {}/{}", phase.trial, phase.trials)));
        if phase.attempt > 1 {
            texts.push((6, format!("attempt {}", phase.attempt)));
        }
        if phase.exploration > 0 {
            let text = format!("exploration {}/{}", phase.exploration, phase.explorations);
            texts.push((6, text));
        }
    }
    texts.extend(phase.condition.clone().map(|text| (8, text)));
    let parts = texts.into_iter();
    parts
        .map(|(rank, text)| LinePart::new(rank, text, Style::new()))
        .collect()
}

/// Returns the name of the phase.
fn name(kind: PhaseKind) -> &'static str {
    match kind {
        PhaseKind::Idle => "idle",
        PhaseKind::Consent => "consent",
        PhaseKind::Baseline => "baseline, no finger",
        PhaseKind::Ready => "waiting for the participant",
        PhaseKind::Countdown => "countdown",
        PhaseKind::Exploration => "exploring",
        PhaseKind::Feedback => "feedback",
        PhaseKind::Verdict => "verdict",
        PhaseKind::Rest => "rest",
        PhaseKind::Paused => "PAUSED",
        PhaseKind::Monitoring => "monitoring",
        PhaseKind::Finished => "finished",
    }
}
