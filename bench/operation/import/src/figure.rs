//! Figure of an imported recording: its streams, and the found values with their evidence.

use std::fs;
use std::path::Path;

use plotting::{Axis, Dash, Figure, FigureError, Ink, Key, Panel, Series, Width};
use recording::manifest::{FoundValue, RecordedIntervalKind};

use crate::alignment::FoundClock;
use crate::readings::Readings;
use crate::refusal::ImportRefusal;
use crate::series::Samples;
use crate::survey::Envelope;

/// Name of the figure.
pub(crate) const FIGURE_FILE: &str = "import.svg";
/// Points of a curve.
const POINTS: usize = 600;

/// Content of the figure.
pub(crate) struct Evidence<'a> {
    /// Recording's name.
    pub name: &'a str,
    /// Envelopes of drive and pickup, with their units per sample, V and m.
    pub envelopes: Option<[(&'a Envelope, f64); 2]>,
    /// Forces, position and intervals.
    pub readings: &'a Readings,
    /// Found clock of the forces.
    pub clock: Option<&'a FoundClock>,
    /// All found values.
    pub found: &'a [FoundValue],
}

/// Returns the figure as SVG.
pub(crate) fn svg(evidence: &Evidence<'_>) -> Result<String, FigureError> {
    let readings = evidence.readings;
    let mut panels = Vec::new();
    if let Some([(drive, volts), (pickup, metres)]) = evidence.envelopes {
        let mut panel = panel("Drive (V)", readings);
        panel
            .series
            .push(Series::line(Ink::Blue, Dash::Solid, crests(drive, volts)));
        panels.push(panel);
        let mut panel = self::panel("Plate (µm)", readings);
        panel.series.push(Series::line(
            Ink::Vermillion,
            Dash::Solid,
            crests(pickup, 1e6 * metres),
        ));
        panels.push(panel);
    }
    if readings.normal.is_some() || readings.lateral.is_some() {
        let mut panel = panel("Force (N)", readings);
        let forces = [
            (&readings.normal, Ink::Blue, Dash::Solid, "normal"),
            (&readings.lateral, Ink::Vermillion, Dash::Dashed, "lateral"),
        ];
        for (samples, ink, dash, name) in forces {
            if let Some(samples) = samples {
                panel
                    .series
                    .push(Series::line(ink, dash, means(samples, 1.0)).with_name(name));
            }
        }
        panels.push(panel);
    }
    if let Some(position) = &readings.position {
        let mut panel = panel("Position (mm)", readings);
        panel
            .series
            .push(Series::line(Ink::Green, Dash::Solid, means(position, 1e3)));
        panels.push(panel);
    }
    if let Some(clock) = evidence.clock
        && let Some(curves) = &clock.curves
    {
        let points = curves.friction.iter();
        let points = points.map(|point| (point.delay_s, point.residual));
        panels.push(plotting::residual_over_shift([points.collect()]));
    }
    let lines: Vec<String> = evidence.found.iter().map(line).collect();
    let caption = match lines.is_empty() {
        true => "All values are stated by the map; none was found in the data.".to_owned(),
        false => format!("Found in the data: {}.", lines.join("; ")),
    };
    let figure = Figure {
        name: "import".to_owned(),
        title: format!("Import of {}", evidence.name),
        caption: format!(
            "{caption} Shaded: unloaded stretches and explorations ({} and {}).",
            count(readings, true),
            count(readings, false)
        ),
        width: Width::Page,
        columns: 1,
        panel_height_mm: 32.0,
        footnote: lines
            .first()
            .map(|_| lines.join("; "))
            .filter(|text| text.len() < 160),
        key: Key::InPanels,
        panels,
    };
    figure.to_svg()
}

fn count(readings: &Readings, is_unloaded: bool) -> usize {
    let kinds = readings
        .intervals
        .intervals
        .iter()
        .map(|interval| interval.kind);
    kinds
        .filter(|kind| (*kind == RecordedIntervalKind::Unloaded) == is_unloaded)
        .count()
}

fn panel(label: &str, readings: &Readings) -> Panel {
    let intervals = readings.intervals.intervals.iter();
    Panel {
        shaded_ranges: intervals
            .map(|interval| (interval.start_s, interval.end_s))
            .collect(),
        ..Panel::new(Axis::linear("Time (s)"), Axis::linear(label))
    }
}

/// Describes a found value with its error.
pub(crate) fn line(found: &FoundValue) -> String {
    let FoundValue {
        name,
        value,
        error,
        unit,
        ..
    } = found;
    let unit = if unit.is_empty() {
        String::new()
    } else {
        format!(" {unit}")
    };
    match error {
        Some(error) if *error > 0.0 => {
            // Two digits of the error.
            let digits = (1 - error.log10().floor() as i32).clamp(0, 15) as usize;
            match value.abs() < 1e-3 || value.abs() >= 1e6 {
                true => format!("{name} = {value:.5e} ± {error:.1e}{unit}"),
                false => format!("{name} = {value:.digits$} ± {error:.digits$}{unit}"),
            }
        }
        _ => format!("{name} = {value}{unit}"),
    }
}

fn crests(envelope: &Envelope, unit: f64) -> Vec<(f64, f64)> {
    let group = envelope.values.len().div_ceil(POINTS).max(1);
    let chunks = envelope.values.chunks(group).enumerate();
    chunks
        .map(|(index, values)| {
            let crest = values.iter().map(|value| value.norm()).fold(0.0, f64::max);
            (envelope.time_s(index * group), unit.abs() * crest)
        })
        .collect()
}

fn means(samples: &Samples, unit: f64) -> Vec<(f64, f64)> {
    let group = samples.len().div_ceil(POINTS).max(1);
    (0..samples.len())
        .step_by(group)
        .map(|start| {
            let part = &samples.values[start..(start + group).min(samples.len())];
            (
                samples.drive_s(start),
                unit * part.iter().sum::<f64>() / part.len() as f64,
            )
        })
        .collect()
}

/// Writes the figure of a recording.
pub(crate) fn write(folder: &Path, svg: Result<String, FigureError>) -> Result<(), ImportRefusal> {
    let svg = svg.map_err(|error| ImportRefusal::ReadBack(error.to_string()))?;
    let path = folder.join(FIGURE_FILE);
    fs::write(&path, svg).map_err(|error| ImportRefusal::system(&path, &error))
}
