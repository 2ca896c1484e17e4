//! Tables of the bench: calibrations, parts, health, limits.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::{Line, Span};

use super::panel::{note, rows, titled};
use crate::event::{CalibrationFact, SystemHealth};
use crate::state::State;
use drawing::numbers::{signed, thousands};
use drawing::words::{LinePart, fit_parts, wrap};

/// Fill at which a ring buffer is about to overflow.
const RING_FULL: f64 = 0.5;
/// Lag of the recorder above which its data reach the disk too late, s.
const RECORDER_LAG_S: f64 = 1.0;
/// Disk space for about ten minutes of four channels of 32-bit samples at 192 kHz.
const DISK_LOW_BYTES: u64 = 2_000_000_000;
/// Age at which a calibration should be reviewed, days.
const OLD_DAYS: f64 = 30.0;

/// Draws each calibration with its age and operator.
pub(crate) fn calibrations(state: &State, area: Rect, buf: &mut Buffer) {
    let theme = state.ui.theme;
    let title = Line::styled("calibrations", theme.strong());
    let Some(bench) = &state.bench else {
        let body = titled(state, title, &[], area, buf);
        note("no data yet", theme.faint(), body, buf);
        return;
    };
    let plate = Line::styled(bench.plate.clone(), theme.faint());
    let body = titled(state, title, &[plate], area, buf);
    let lines = bench
        .calibrations
        .iter()
        .map(|fact| calibration(state, fact));
    rows(lines.collect(), body, buf);
}

fn calibration<'a>(state: &State, fact: &CalibrationFact) -> Line<'a> {
    let theme = state.ui.theme;
    let name = Span::styled(format!("{:<9}", fact.name), theme.faint());
    let Some(date) = &fact.date else {
        return Line::from(vec![
            name,
            Span::styled("! never measured", theme.warning()),
        ]);
    };
    let (age, style) = match fact.age_days {
        Some(days) if days < 1.0 => ("today".to_owned(), Style::new()),
        Some(days) if days < OLD_DAYS => (format!("{days:.0} d"), Style::new()),
        Some(days) => (format!("{days:.0} d !"), theme.warning()),
        None => ("simulated".to_owned(), theme.faint()),
    };
    Line::from(vec![
        name,
        Span::styled(format!("{age:<10}"), style),
        Span::raw(format!("{date}  {}", fact.operator)),
        Span::styled(format!("  {}", fact.value), theme.faint()),
    ])
}

/// Draws lines and sources with their states.
pub(crate) fn parts(state: &State, area: Rect, buf: &mut Buffer) {
    let theme = state.ui.theme;
    let title = Line::styled("lines and sources", theme.strong());
    let body = titled(state, title, &[], area, buf);
    let Some(bench) = &state.bench else {
        note("no data yet", theme.faint(), body, buf);
        return;
    };
    let mut lines = Vec::new();
    let levels = state.health.as_ref().map(|health| health.lines);
    let lost = state.health.unwrap_or_default().lost;
    for part in &bench.parts {
        let level = levels
            .zip(part.line)
            .and_then(|(states, line)| states.describe(line));
        let is_lost = part.line.is_some_and(|line| lost.includes(line));
        let words = match &level {
            _ if is_lost => format!("LOST: {}", part.words),
            Some((level, _)) => format!("{}, {level}", part.words),
            None => part.words.clone(),
        };
        let (mark, style) = if is_lost {
            ("✗", theme.bad())
        } else if part.well && level.is_none_or(|(_, well)| well) {
            ("✓", theme.good())
        } else {
            ("!", theme.warning())
        };
        let columns = body.width.saturating_sub(14);
        for (i, words) in wrap(&words, columns).into_iter().enumerate() {
            let head = if i == 0 {
                vec![
                    Span::styled(mark, style),
                    Span::styled(format!(" {:<12}", part.name), theme.faint()),
                ]
            } else {
                vec![Span::raw(" ".repeat(14))]
            };
            let mut line = Line::from(head);
            line.push_span(Span::raw(words));
            lines.push(line);
        }
    }
    rows(scrolled(state, lines, body), body, buf);
}

/// Returns the lines that remain below those scrolled away, as many as have room.
fn scrolled<'a>(state: &State, lines: Vec<Line<'a>>, area: Rect) -> Vec<Line<'a>> {
    let first = usize::from(state.ui.scroll).min(lines.len().saturating_sub(area.height.into()));
    lines.into_iter().skip(first).collect()
}

/// Draws limits looser than their defaults, and properties that have not been measured.
pub(crate) fn limits(state: &State, area: Rect, buf: &mut Buffer) {
    let theme = state.ui.theme;
    let title = Line::styled("looser than default, or unverified", theme.strong());
    let body = titled(state, title, &[], area, buf);
    let Some(bench) = &state.bench else {
        note("no data yet", theme.faint(), body, buf);
        return;
    };
    if bench.loosened.is_empty() && bench.unverified.is_empty() {
        rows(vec![Line::styled("nothing", theme.faint())], body, buf);
        return;
    }
    let remarks = bench.loosened.iter().chain(&bench.unverified);
    let lines: Vec<Line> = remarks
        .flat_map(|words| {
            let lines = wrap(words, body.width.saturating_sub(2)).into_iter();
            lines.enumerate().map(|(i, words)| {
                let mark = if i == 0 { "! " } else { "  " };
                Line::from(vec![Span::styled(mark, theme.warning()), Span::raw(words)])
            })
        })
        .collect();
    rows(scrolled(state, lines, body), body, buf);
}

/// One value; a bad one is marked by a symbol as well as by colour.
struct HealthValue {
    name: &'static str,
    value: String,
    bad: bool,
}

/// Number of values in the table of health.
pub(crate) const VALUES: u16 = 14;

/// Draws rates, losses, clocks, disk and processor.
pub(crate) fn health(state: &State, area: Rect, buf: &mut Buffer) {
    let theme = state.ui.theme;
    let title = Line::styled("rates and health", theme.strong());
    let Some(health) = &state.health else {
        let body = titled(state, title, &[], area, buf);
        note("no data yet", theme.faint(), body, buf);
        return;
    };
    let frames = format!("{} audio frames", thousands(health.frames));
    let frames = Line::styled(frames, theme.faint());
    let body = titled(state, title, &[frames], area, buf);
    let columns = if body.width >= 76 { 2 } else { 1 };
    let cell = body.width / columns;
    let rows_per_column = VALUES.div_ceil(columns);
    let hidden = rows_per_column.saturating_sub(body.height);
    let mut values = values(health);
    if hidden > 0 {
        values.sort_by_key(|value| !value.bad);
    }
    let first = state.ui.scroll.min(hidden);
    for (i, value) in (0u16..).zip(values) {
        let (row, column) = (i % rows_per_column, i / rows_per_column);
        let Some(row) = row.checked_sub(first).filter(|row| *row < body.height) else {
            continue;
        };
        let area = Rect::new(body.x + column * cell, body.y + row, cell, 1);
        let style = if value.bad { theme.bad() } else { Style::new() };
        let sign = if value.bad { " !" } else { "" };
        let line = Line::from(vec![
            Span::styled(format!("{:<18}", value.name), theme.faint()),
            Span::styled(format!("{}{sign}", value.value), style),
        ]);
        drawing::words::render_line(line, area, buf);
    }
}

fn values(health: &SystemHealth) -> Vec<HealthValue> {
    let mut values = measured_values(health);
    let fault = values.iter().find(|value| value.bad);
    let value = fault.map_or("yes".to_owned(), |fault| format!("no: {}", fault.name));
    values.push(HealthValue {
        name: "all well",
        bad: fault.is_some(),
        value,
    });
    values
}

fn measured_values(health: &SystemHealth) -> Vec<HealthValue> {
    let entry = |name, value, bad| HealthValue { name, value, bad };
    let dash = || "–".to_owned();
    let lost = health.lost;
    let count = |count, is_lost: bool| if is_lost { dash() } else { thousands(count) };
    let force_rate_hz = health.force_rate_hz.filter(|_| !lost.force_sensor);
    let drift = health.clock_drift_ppm.filter(|_| !lost.any());
    let residual_s = health.clock_residual_s;
    let deviation =
        residual_s.map_or_else(String::new, |off_s| format!(", {:.2} ms off", 1e3 * off_s));
    vec![
        entry(
            "audio",
            match lost.sound_card {
                true => dash(),
                false => format!("{:.3} of nominal", health.speed),
            },
            lost.sound_card,
        ),
        entry(
            "audio frames lost",
            thousands(health.lost_frames),
            health.lost_frames > 0,
        ),
        entry("xruns in", health.xruns_in.to_string(), health.xruns_in > 0),
        entry(
            "xruns out",
            health.xruns_out.to_string(),
            health.xruns_out > 0,
        ),
        entry(
            "force readings",
            force_rate_hz.map_or_else(dash, |hz| format!("{hz:.0} Hz")),
            is_force_missing(health),
        ),
        entry(
            "force faults",
            count(health.force_faults, lost.force_sensor),
            health.force_faults > 0 || lost.force_sensor,
        ),
        entry(
            "encoder skipped",
            count(health.encoder_skipped, lost.encoder),
            health.encoder_skipped > 0 || lost.encoder,
        ),
        entry(
            "clock drift",
            drift.map_or_else(dash, |ppm| {
                signed(format!("{ppm:+.0}")) + " ppm" + &deviation
            }),
            health.clock_off,
        ),
        entry(
            "audio buffer",
            format!("{:.0} % full", 100.0 * health.ring_fill),
            health.ring_fill > RING_FULL,
        ),
        entry(
            "recorder lag",
            format!("{:.2} s", health.recorder_lag_s),
            health.recorder_lag_s > RECORDER_LAG_S,
        ),
        entry(
            "disk",
            match health.disk_sessions {
                Some(1) => "room for 1 session".to_owned(),
                Some(sessions) => format!("room for {} sessions", thousands(sessions)),
                None => dash(),
            },
            health.disk_sessions.is_some_and(|sessions| sessions < 2),
        ),
        entry(
            "disk free",
            health
                .disk_free_bytes
                .map_or_else(dash, |bytes| format!("{:.0} GB", bytes as f64 / 1e9)),
            health
                .disk_free_bytes
                .is_some_and(|bytes| bytes < DISK_LOW_BYTES),
        ),
        entry(
            "processor",
            health
                .cores
                .map_or_else(dash, |cores| format!("{:.0} % of a core", 100.0 * cores)),
            false,
        ),
    ]
}

/// Whether nothing was lost or is about to be lost.
pub(crate) fn is_well(health: &SystemHealth) -> bool {
    health.lost_frames + health.force_faults + health.encoder_skipped == 0
        && health.xruns_in + health.xruns_out == 0
        && health.ring_fill <= RING_FULL
        && health.recorder_lag_s <= RECORDER_LAG_S
        && health
            .disk_free_bytes
            .is_none_or(|bytes| bytes >= DISK_LOW_BYTES)
        && !health.clock_off
        && !health.lost.any()
        && !is_force_missing(health)
}

/// Whether the force sensor sends no readings although it has sent some before.
fn is_force_missing(health: &SystemHealth) -> bool {
    health.lost.force_sensor || health.force_rate_hz == Some(0.0)
}

/// Draws the health in one line, for the other pages.
pub(crate) fn one_line(state: &State, area: Rect, buf: &mut Buffer) {
    let theme = state.ui.theme;
    let Some(health) = &state.health else {
        return;
    };
    let (mark, style) = if is_well(health) {
        ("✓ bench well", theme.good())
    } else {
        ("! bench: see page 4", theme.bad())
    };
    let mut parts = vec![LinePart::new(0, mark, style)];
    let losses = [
        (1, "audio frames lost", health.lost_frames),
        (2, "force faults", health.force_faults),
        (3, "encoder steps skipped", health.encoder_skipped),
        (3, "xruns", health.xruns_in + health.xruns_out),
    ];
    for (rank, name, count) in losses.into_iter().filter(|(.., count)| *count > 0) {
        let text = format!("{name} {}", thousands(count));
        parts.push(LinePart::new(rank, text, theme.faint()));
    }
    let lost = [
        (health.lost.sound_card, "sound card LOST"),
        (is_force_missing(health), "no force readings"),
        (health.lost.encoder, "encoder LOST"),
    ];
    for (_, text) in lost.iter().filter(|(is_lost, _)| *is_lost) {
        parts.push(LinePart::new(1, *text, theme.bad()));
    }
    if losses.iter().all(|(.., count)| *count == 0) && !health.lost.any() {
        parts.push(LinePart::new(1, "nothing lost", theme.faint()));
    }
    if let Some(sessions) = health.disk_sessions {
        let text = format!("room for {} sessions", thousands(sessions));
        parts.push(LinePart::new(4, text, theme.faint()));
    }
    let line = fit_parts(parts, area.width.into(), theme.faint());
    drawing::words::render_line(line, area, buf);
}
