//! The strips: live values over one time axis, drawn by a sweep like an oscilloscope's, which leaves older values where
//! they are.

use ratatui::buffer::Buffer;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::Style;
use ratatui::text::{Line, Span};

use super::live_values::{live_style, stale};
use super::panel::{note, titled};
use crate::event::{Live, NoEstimate, ValueAndStd};
use crate::state::State;
use crate::strip::{Select, Strip, Weight, magnitude, read};
use drawing::numbers::{number, signed};
use drawing::plot::{self, Plot, Trace};

/// Empty fraction of the sweep ahead of its head.
const GAP: f64 = 0.03;

/// Draws all strips, one below the other.
pub(crate) fn render_all(state: &State, area: Rect, buf: &mut Buffer) {
    let rows = Strip::ALL.map(|strip| match strip {
        Strip::Impedance | Strip::Friction => Constraint::Fill(5),
        _ => Constraint::Fill(4),
    });
    let areas = Layout::vertical(rows).split(area);
    for (strip, area) in Strip::ALL.into_iter().zip(areas.iter()) {
        render(state, strip, *area, buf);
    }
}

/// Draws one strip.
pub(crate) fn render(state: &State, strip: Strip, area: Rect, buf: &mut Buffer) {
    let right = match (&state.ui.frozen, strip) {
        (Some(_), _) => cursors(state, strip),
        (None, Strip::Amplitude) => {
            let span_s = state.ui.window.seconds();
            Line::styled(format!("sweep {span_s} s"), state.ui.theme.faint())
        }
        _ => Line::default(),
    };
    // The word stands where its cursors have no room: the values of the title are old ones.
    let hold = match &state.ui.frozen {
        Some(_) => Line::styled("HELD", state.ui.theme.warning()),
        None => Line::default(),
    };
    let body = titled(
        state,
        title(state, strip, area.width),
        &[stale(state), right, hold],
        area,
        buf,
    );
    curves(state, strip, body, buf);
}

fn curves(state: &State, strip: Strip, area: Rect, buf: &mut Buffer) {
    let theme = state.ui.theme;
    let history = state.shown_history();
    let Some(last) = history.back() else {
        note("no data yet", theme.faint(), area, buf);
        return;
    };
    let Some(axis) = state.axes.get(strip as usize).copied().flatten() else {
        let missing = match strip {
            Strip::Gap | Strip::Friction => missing_estimate(state),
            _ => None,
        };
        note(
            missing.as_deref().unwrap_or("no data yet"),
            theme.faint(),
            area,
            buf,
        );
        return;
    };
    let window_s = state.ui.window.seconds();
    let frozen = state.ui.frozen.as_ref();
    let is_stale = state.live_stale_s().is_some() && frozen.is_none();
    // Frozen strips run from left to right; otherwise the newest values are at the head of the sweep.
    let gap_s = if frozen.is_some() {
        0.0
    } else {
        GAP * window_s
    };
    let from_s = last.t_s - window_s + gap_s;
    let place = |t_s: f64| match frozen {
        Some(_) => t_s - from_s,
        None => t_s.rem_euclid(window_s),
    };
    let first = history.partition_point(|live| live.t_s < from_s);
    let trace = |select: Select, style: Style| {
        let mut points = Vec::with_capacity(history.len() - first + 1);
        let mut previous_x = f64::NEG_INFINITY;
        for live in history.range(first..) {
            let x = place(live.t_s);
            if x < previous_x {
                points.push((x, None));
            }
            points.push((x, select(live)));
            previous_x = x;
        }
        Trace { points, style }
    };
    let curves = strip.series().iter().map(|(select, weight)| {
        let style = match weight {
            _ if is_stale => theme.faint(),
            Weight::First => theme.first_curve(),
            Weight::Second => theme.second_curve(),
            Weight::Faint => theme.faint(),
        };
        trace(*select, style)
    });
    Plot {
        x: (0.0, window_s),
        axis,
        band: state.force_band_n.filter(|_| strip == Strip::Force),
        spans: spans(state, (from_s, last.t_s), place),
        cursors: frozen.map_or(Vec::new(), |frozen| {
            frozen.times_s(window_s).map(place).to_vec()
        }),
        curves: curves.collect(),
    }
    .render(theme, area, buf);
}

/// Returns the kept spans between two times, at their positions on the strips.
fn spans(state: &State, (from_s, to_s): (f64, f64), place: impl Fn(f64) -> f64) -> Vec<plot::Span> {
    let window_s = state.ui.window.seconds();
    let mut spans = Vec::new();
    let recent = state.crops.iter().rev().take(4);
    for (crop, stretch) in recent.flat_map(|crop| crop.stretches.iter().map(move |s| (crop, s))) {
        let begins_s = (crop.start_s + stretch.start_s).max(from_s);
        let ends_s = (crop.start_s + stretch.end_s).min(to_s);
        if !stretch.accepted || ends_s <= begins_s {
            continue;
        }
        let (from, to) = (place(begins_s), place(ends_s));
        let is_accepted = true;
        if from <= to {
            spans.push(plot::Span {
                from,
                to,
                is_accepted,
            });
        } else {
            // The span wraps around the end of the sweep.
            spans.push(plot::Span {
                from,
                to: window_s,
                is_accepted,
            });
            spans.push(plot::Span {
                from: 0.0,
                to,
                is_accepted,
            });
        }
    }
    spans
}

/// Returns the values at the cursors, and their difference.
fn cursors(state: &State, strip: Strip) -> Line<'static> {
    let window_s = state.ui.window.seconds();
    let (Some(frozen), Some((select, _))) = (&state.ui.frozen, strip.series().last()) else {
        return Line::default();
    };
    let [a_s, b_s] = frozen.times_s(window_s);
    let [a, b] = [a_s, b_s].map(|t_s| frozen.value_at(t_s).and_then(select));
    let difference = a.zip(b).map(|(a, b)| b - a);
    let mut words = format!(
        "HELD A {} B {} Δ {}",
        number(a, 1.0, 2),
        number(b, 1.0, 2),
        number(difference, 1.0, 2)
    );
    if strip == Strip::Amplitude {
        words = format!("{words} in {} ms", number(Some(b_s - a_s), 1e3, 0));
    }
    Line::styled(words, state.ui.theme.warning())
}

/// Returns the strip's name and present values, as far as they fit.
fn title(state: &State, strip: Strip, columns: u16) -> Line<'static> {
    let theme = state.ui.theme;
    let (name, parts) = parts(state, strip);
    let mut line = Line::from(Span::styled(name, theme.strong()));
    for (part, (words, weight)) in parts.into_iter().enumerate() {
        let style = match weight {
            Weight::First => live_style(state, theme.first_curve()),
            Weight::Second => live_style(state, theme.second_curve()),
            Weight::Faint => theme.faint(),
        };
        let span = Span::styled(format!(" {words}"), style);
        let room = usize::from(columns).saturating_sub(line.width() + 1);
        if span.width() <= room {
            line.push_span(span);
            continue;
        }
        // The first part is cut off rather than left out.
        if part == 0 && room > 8 {
            let cut: String = span.content.chars().take(room - 1).collect();
            line.push_span(Span::styled(cut + "…", style));
        }
        break;
    }
    line
}

fn parts(state: &State, strip: Strip) -> (&'static str, Vec<(String, Weight)>) {
    let history = state.shown_history();
    let read = |select: Select| read(history, select);
    let mean =
        |select: Select, decimals| number(read(select).map(|(mean, ..)| mean), 1.0, decimals);
    match strip {
        Strip::Amplitude => {
            let range = match read(|l| l.amplitude_m.map(|m| m * 1e6)) {
                Some((_, low, high)) => format!("{low:.2}–{high:.2}"),
                None => "–".to_owned(),
            };
            let drive = match read(|l| l.drive_v) {
                Some((_, low, high)) => format!("{low:.0}–{high:.0}"),
                None => "–".to_owned(),
            };
            let parts = vec![
                (format!("{range} μm"), Weight::First),
                (format!(" drive {drive} V"), Weight::Faint),
            ];
            ("amplitude", parts)
        }
        Strip::Impedance => {
            let corrected = mean(|l| l.z_m_n_s_per_m.map(magnitude), 2);
            let plain = mean(|l| l.z_plain_n_s_per_m.map(magnitude), 2);
            let drift = super::live_values::drift(state);
            let mut parts = vec![
                (format!("{corrected} N·s/m"), Weight::First),
                (format!(" uncorrected {plain}"), Weight::Faint),
            ];
            if drift != "–" {
                parts.push((format!(" drift {drift}"), Weight::Faint));
            }
            ("|Z_m|", parts)
        }
        Strip::Force => {
            let parts = vec![
                (
                    format!("normal {} N", mean(|l| l.normal_n, 2)),
                    Weight::First,
                ),
                (
                    format!(" lateral {} N", mean(|l| l.lateral_n, 2)),
                    Weight::Second,
                ),
            ];
            ("force", parts)
        }
        Strip::Friction => {
            let measured_text = match read(|l| l.measured_mu) {
                Some((mu, ..)) => format!("measured {mu:.2}"),
                None => "measured – (not sliding)".to_owned(),
            };
            let estimate_text = estimate(state, |l| l.mu, 1.0).map_or_else(
                |reason| (reason, Weight::Faint),
                |words| (words, Weight::First),
            );
            (
                "μ",
                vec![
                    (measured_text, Weight::Second),
                    (format!(" {}", estimate_text.0), estimate_text.1),
                ],
            )
        }
        Strip::Gap => {
            let gap = match estimate(state, |l| l.gap_m, 1e6) {
                Ok(words) => (format!("{words} μm"), Weight::First),
                Err(reason) => (reason, Weight::Faint),
            };
            let sensed = read(|l| l.sensed_normal_n.map(|sensed| sensed.value));
            let mut parts = vec![gap];
            if let Some((sensed, ..)) = sensed {
                parts.push((
                    format!(" self-sensed force {} N", number(Some(sensed), 1.0, 2)),
                    Weight::Faint,
                ));
            }
            ("gap", parts)
        }
    }
}

/// Returns an estimate and half its 95 % confidence interval, or why it is missing.
fn estimate(
    state: &State,
    select: fn(&Live) -> Option<ValueAndStd>,
    scale: f64,
) -> Result<String, String> {
    let history = state.shown_history();
    let to = history.len();
    let from = to.saturating_sub(32);
    let values: Vec<ValueAndStd> = history.range(from..to).filter_map(select).collect();
    let count = values.len() as f64;
    if values.is_empty() {
        let reason = missing_estimate(state).unwrap_or_else(|| "–".to_owned());
        return Err(format!("estimated: {reason}"));
    }
    let mean = values.iter().map(|e| e.value).sum::<f64>() / count * scale;
    let half = 1.96 * values.iter().map(|e| e.std).sum::<f64>() / count * scale;
    let decimals = statistics::error_decimals(half, 2);
    Ok(format!(
        "estimated {} ± {half:.decimals$}",
        signed(format!("{mean:.decimals$}"))
    ))
}

/// Returns why gap and friction are not estimated.
pub(crate) fn missing_estimate(state: &State) -> Option<String> {
    let reason = state.shown_history().back()?.no_estimate?;
    Some(match reason {
        NoEstimate::NoFit => match state.fits.iter().rev().find_map(|fit| {
            let cause = fit.no_fit.as_ref()?;
            let sort = if fit.practice { "practice" } else { "trial" };
            Some(format!("no fit of {sort} {}: {cause}", fit.trial))
        }) {
            Some(words) => words,
            None if state.session.protocol.is_none() => "needs the fit of a trial".to_owned(),
            None => "after the first fit".to_owned(),
        },
        NoEstimate::NoFinger => "no finger on the plate".to_owned(),
        NoEstimate::NoForce => "the normal force is not measured".to_owned(),
        NoEstimate::Masked => "masked".to_owned(),
        NoEstimate::OffModel => "outside the model".to_owned(),
    })
}
