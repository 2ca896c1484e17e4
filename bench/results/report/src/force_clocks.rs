//! Clocks of the forces: offset and rate of each recording, common rates, and the residual over the shift.

use maud::{Markup, html};
use plotting::{Figure, FigureError, Key, Width};

use crate::content::RecordingEntry;
use crate::drawing::drawing;
use crate::number::{MILLI, NumberFormat};
use crate::recording_results::ForceClockRow;
use crate::results::Results;

/// Recordings of a panel.
const PANEL_RECORDINGS: usize = 4;
/// Most panels.
const MOST_PANELS: usize = 12;
const PPM: NumberFormat = NumberFormat {
    factor: 1.0,
    decimals: 0,
};

/// Returns the section; `None` if no recording shows the clock of its forces.
pub(crate) fn force_clocks(
    results: &Results<'_>,
    recordings: &[RecordingEntry<'_>],
) -> Result<Option<Markup>, FigureError> {
    let clocks: Vec<(&RecordingEntry<'_>, &ForceClockRow)> = recordings
        .iter()
        .filter_map(|recording| Some((recording, recording.result.force_clock.as_ref()?)))
        .collect();
    if clocks.is_empty() {
        return Ok(None);
    }
    let figure = drawing(&figure(&clocks))?;
    let corrected = |is_corrected: bool| {
        if is_corrected {
            "corrected"
        } else {
            "as recorded"
        }
    };
    Ok(Some(html! {
        p {
            "Clock of the forces against that of drive and pickup, as each recording shows it: t = t" sub { "file" } " + offset + rate \
             · (t" sub { "file" } " − middle of the slides). The offset is negative if the forces come late; ± is the half width \
             of the 95 % interval. An offset or a rate is corrected if it exceeds both its interval and 1 ms."
        }
        div.wide { table {
            thead { tr {
                th { "Recording" } th.n { "Offset (ms)" } th.n { "±" } th { "" } th.n { "Rate (ppm)" } th.n { "±" } th { "" }
            } }
            tbody { @for (recording, clock) in &clocks { tr {
                th scope="row" { a href={ "#" (recording.anchor()) } { (recording.name()) } }
                td.n { (MILLI.value(Some(clock.offset_s))) }
                td.n { (MILLI.value(Some(statistics::NORMAL_95 * clock.std.offset_s))) }
                td { (corrected(clock.offset_corrected)) }
                td.n { (PPM.value(Some(clock.ppm))) }
                td.n { (PPM.value(Some(statistics::NORMAL_95 * clock.std.ppm))) }
                td { (corrected(clock.rate_corrected)) }
            } } }
        } }
        @for session in &results.force_clocks {
            p {
                (session.participant.as_deref().unwrap_or("–")) ", session " (session.session) ": "
                (PPM.value(Some(session.ppm))) " ± " (PPM.value(Some(statistics::NORMAL_95 * session.ppm_std)))
                " ppm over " (session.recordings) " recordings together."
                @if session.is_fault() { " " b { "State the true rate of the sensor: it is not corrected." } }
            }
        }
        figure {
            (figure)
            figcaption {
                "Share of the friction’s variance that the amplitude leaves unexplained, over further delays of the forces; 0 is the \
                 delay found. Up to " (PANEL_RECORDINGS) " recordings a panel, in the order of the table"
                @if clocks.len() > PANEL_RECORDINGS * MOST_PANELS { "; the first " (PANEL_RECORDINGS * MOST_PANELS) } "."
            }
        }
    }))
}

fn figure(clocks: &[(&RecordingEntry<'_>, &ForceClockRow)]) -> Figure {
    let panels = clocks.chunks(PANEL_RECORDINGS).take(MOST_PANELS);
    let panel = |clocks: &[(&RecordingEntry<'_>, &ForceClockRow)]| {
        plotting::residual_over_shift(clocks.iter().map(|(_, clock)| clock.residual.clone()))
    };
    let panels: Vec<_> = panels.map(panel).collect();
    Figure {
        name: "force-clocks".to_owned(),
        title: "Clocks of the forces".to_owned(),
        caption: "Residual of friction over the delay of the forces.".to_owned(),
        width: Width::Page,
        columns: panels.len().min(2),
        panel_height_mm: 40.0,
        footnote: None,
        key: Key::InPanels,
        panels,
    }
}
