//! A calibration's live readings: the main one large if there is room, the others next to it.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::{Line, Span};

use super::live_values::{TO_MICRO, live_style};
use super::panel::rows;
use crate::calibration_page::{CalibrationPage, CalibrationReadings, MainReading};
use crate::state::State;
use drawing::digits;
use drawing::numbers::number;
use drawing::words::{LinePart, fit_parts, render_line};

/// A reading with its name, value and unit.
struct NamedValue {
    name: &'static str,
    value: String,
    unit: &'static str,
}

/// Returns one reading as text.
fn named_value(reading: &CalibrationReadings, watched: MainReading) -> NamedValue {
    let (name, value, unit) = match watched {
        MainReading::Amplitude => ("pickup", number(reading.amplitude_m, TO_MICRO, 3), "µm"),
        MainReading::NormalForce => ("normal", number(reading.normal_n, 1.0, 3), "N"),
        MainReading::LateralForce => ("lateral", number(reading.lateral_n, 1.0, 3), "N"),
        MainReading::Level => ("level", number(reading.level, 100.0, 1), "%"),
        MainReading::DriveVolts => ("drive", number(reading.drive_v, 1.0, 2), "V peak"),
    };
    NamedValue { name, value, unit }
}

/// Returns all readings, the main one first.
fn values(state: &State, watched: MainReading) -> Vec<NamedValue> {
    let reading = state.readings.unwrap_or_default();
    let mut figures: Vec<NamedValue> = [
        MainReading::DriveVolts,
        MainReading::Amplitude,
        MainReading::NormalForce,
        MainReading::LateralForce,
        MainReading::Level,
    ]
    .into_iter()
    .filter(|kind| *kind != watched)
    .map(|kind| named_value(&reading, kind))
    .collect();
    figures.insert(0, named_value(&reading, watched));
    for (reference, name, scale, places, unit) in [
        (reading.known_m, "instrument", TO_MICRO, 4, "µm"),
        (reading.known_v, "meter", 1.0, 3, "V"),
    ] {
        if reference.is_some() {
            let value = number(reference, scale, places);
            figures.insert(1, NamedValue { name, value, unit });
        }
    }
    figures
}

/// Draws the main reading in large digits and the others next to it, or all in one row if the width is too small.
pub(crate) fn large(state: &State, calibration: &CalibrationPage, area: Rect, buf: &mut Buffer) {
    let theme = state.ui.theme;
    let figures = values(state, calibration.watched);
    let Some((watched, rest)) = figures.split_first() else {
        return;
    };
    let columns = digits::columns(&watched.value);
    let left_columns = columns + 12;
    if area.width < left_columns + 24 {
        return small(state, calibration, area, buf);
    }
    let style = live_style(state, theme.first_curve());
    digits::render(&watched.value, style, area, buf);
    let name = Rect {
        x: area.x + columns,
        width: left_columns - columns,
        ..area
    };
    let unit = [
        Line::styled(watched.name, theme.faint()),
        Line::default(),
        Line::default(),
        Line::default(),
        Line::styled(watched.unit, style),
    ];
    rows(unit.into(), name, buf);
    let list = Rect {
        x: area.x + left_columns,
        width: area.width - left_columns,
        ..area
    };
    let style = live_style(state, Style::new());
    let lines = rest.iter().map(|figure| {
        Line::from(vec![
            Span::styled(format!("{:<11}", figure.name), theme.faint()),
            Span::styled(format!("{:>8} {}", figure.value, figure.unit), style),
        ])
    });
    rows(lines.collect(), list, buf);
}

/// Draws all readings in one row.
pub(crate) fn small(state: &State, calibration: &CalibrationPage, area: Rect, buf: &mut Buffer) {
    if area.is_empty() {
        return;
    }
    let theme = state.ui.theme;
    let mut parts = Vec::new();
    for (rank, figure) in (0..).zip(values(state, calibration.watched)) {
        let style = if rank == 0 {
            live_style(state, theme.first_curve())
        } else {
            live_style(state, Style::new())
        };
        let text = format!("{} {} {}", figure.name, figure.value, figure.unit);
        parts.push(LinePart::new(rank, text, style).after("   "));
    }
    render_line(
        fit_parts(parts, area.width.into(), theme.faint()),
        area,
        buf,
    );
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibration_page::CalibrationReadings;
    use drawing::theme::Theme;

    #[test]
    fn a_meter_reads_volts_and_an_instrument_micrometres() {
        let text_with = |known_m, known_v| {
            let mut state = State::new(Theme::Mono);
            state.readings = Some(CalibrationReadings {
                known_m,
                known_v,
                ..CalibrationReadings::default()
            });
            let values = values(&state, MainReading::Amplitude);
            let value = &values[1];
            format!("{} {} {}", value.name, value.value, value.unit)
        };
        assert_eq!(text_with(Some(1.3488e-6), None), "instrument 1.3488 µm");
        assert_eq!(text_with(None, Some(2.783)), "meter 2.783 V");
    }
}
