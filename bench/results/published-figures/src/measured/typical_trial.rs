//! Fig. 11: a typical trial in time.

use std::f64::consts::TAU;
use std::ops::RangeInclusive;

use contact::self_sensed;
use num_complex::Complex64;

use crate::measured::elements::{
    ABS_Z_M, EstimatedQuantity, GAP, MICRO, assumption_note, ink, line, overlap_note,
    recording_name, trial_note,
};
use crate::measured::figure_selection::FigureSelection;
use analysis::estimate::{InstanceAnalysis, Method};
use analysis::exploration_findings::ExplorationFindings;
use analysis::exploration_series::ExplorationSeries;
use analysis::findings::{Analysis, RecordingFindings};
use analysis::recording_series::{EstimateSeries, RecordingSeries, SampledInstance};
use plotting::{Axis, Figure, Key, Panel, Series};
use plotting::{Dash, Ink, Width};

/// Draws the exploration with the most instances; `None` for a recording without exploration.
pub(super) fn figure(
    findings: &RecordingFindings,
    recording: &RecordingSeries,
    analysed: &Analysis,
    selection: &FigureSelection,
) -> Option<Figure> {
    let explorations = findings.explorations.iter().zip(&recording.explorations);
    let (slide, exploration) = explorations
        .filter(|(_, series)| !series.time_s.is_empty())
        .rev()
        .max_by_key(|(slide, _)| instances(findings, slide).count())?;
    let instances: Vec<&InstanceAnalysis> = instances(findings, slide).collect();
    let time_s = &exploration.time_s;
    let ends = (time_s[0], time_s[time_s.len() - 1]);
    let time_course = |values: &[f64], factor: f64| -> Vec<(f64, f64)> {
        time_s
            .iter()
            .zip(values)
            .map(|(&t, &value)| (t, factor * value))
            .collect()
    };
    let panel = |axis: Axis, series: Vec<Series>| Panel {
        series,
        shaded_ranges: instances.iter().map(|i| (i.start_s, i.end_s)).collect(),
        ..Panel::new(
            Axis::linear("Time (s)")
                .with_range(ends.0, ends.1)
                .without_labels(),
            axis,
        )
    };

    let mut amplitude = vec![Series::line(
        Ink::Black,
        Dash::Solid,
        time_course(&exploration.amplitude_m, MICRO),
    )];
    // `trial` uses the same data as `dynamic`, and both curves coincide.
    let correcting_method = [Method::Dynamic, Method::Trial];
    let correcting_method = correcting_method
        .into_iter()
        .find(|method| selection.methods.contains(method));
    let profile_method = correcting_method.filter(|_| {
        findings
            .plate()
            .is_some_and(|plate| plate.profile.is_some())
    });
    if let Some(method) = profile_method {
        let finger_amplitude = time_course(exploration.method_amplitude_m(method), MICRO);
        amplitude.push(line(method, finger_amplitude));
    }
    let lateral: Vec<f64> = exploration
        .lateral_n
        .iter()
        .map(|force| force.abs())
        .collect();
    let curve = |method: Method, value: &dyn Fn(Complex64, f64) -> f64| {
        let frames = exploration
            .z_m(method)
            .iter()
            .zip(exploration.method_amplitude_m(method));
        let values: Vec<f64> = frames.map(|(&z, &a)| value(z, a)).collect();
        line(method, time_course(&values, 1.0))
    };
    let has_own_reading =
        |method: &Method| *method == Method::Paper || Some(*method) == correcting_method;
    let reading_methods = selection.methods.iter().copied().filter(has_own_reading);
    let modulus: Vec<Series> = reading_methods
        .map(|method| curve(method, &|z_m, _| z_m.norm()))
        .collect();
    // Mean of the impedances that the instances subtract; for `dynamic` and `trial` it includes the plate's offset.
    let z_p = |method: Method| -> Option<Complex64> {
        let plate_impedances = instances.iter().filter_map(|i| i.estimate(method));
        let plate_impedances: Vec<Complex64> = plate_impedances
            .map(|estimate| estimate.z_p_n_s_per_m)
            .collect();
        if instances.is_empty() {
            findings.z_p.map(|plate| plate.z_p(method))
        } else if plate_impedances.is_empty() {
            None
        } else {
            Some(plate_impedances.iter().sum::<Complex64>() / plate_impedances.len() as f64)
        }
    };
    let reaction = selection.methods.iter().filter_map(|&method| {
        let (z_p, carrier_hz) = z_p(method).zip(findings.carrier_hz())?;
        Some(curve(method, &|z_m, amplitude_m| {
            let v_p = TAU * carrier_hz * amplitude_m;
            ((z_m - z_p) * v_p).norm()
        }))
    });
    let reaction: Vec<Series> = reaction.collect();
    let mut forces = Vec::new();
    if correcting_method.is_some() {
        forces.extend(
            sensed_normal_n((findings, recording), exploration).map(|force_n| {
                Series::line(Ink::Orange, Dash::Dashed, time_course(&force_n, 1.0))
                    .with_name("normal force, self-sensed")
            }),
        );
    }
    forces.extend([
        Series::line(
            Ink::Black,
            Dash::Solid,
            time_course(&exploration.normal_n, 1.0),
        )
        .with_name("normal force"),
        Series::line(Ink::Grey, Dash::Solid, time_course(&lateral, 1.0)).with_name("lateral force"),
    ]);
    let estimated_instances = findings.instances.iter().zip(&recording.instances);
    let estimated_instances: Vec<(&InstanceAnalysis, &SampledInstance)> = estimated_instances
        .filter(|(instance, _)| span(slide).contains(&instance.start_s))
        .collect();
    let mut friction = estimates(
        &estimated_instances,
        selection,
        |series| (&series.mu, &series.mu_std),
        1.0,
    );
    let measured_mu = time_course(&exploration.mu, 1.0);
    friction
        .push(Series::line(Ink::Black, Dash::Dotted, measured_mu).with_name("measured friction"));
    let gap = estimates(
        &estimated_instances,
        selection,
        |series| (&series.gap_m, &series.gap_std_m),
        MICRO,
    );

    let mut panels = vec![
        panel(Axis::linear("Amplitude (µm)").from_zero(), amplitude),
        panel(Axis::linear(ABS_Z_M), modulus),
        panel(Axis::linear("Force (N)").from_zero(), forces),
        panel(Axis::linear("|f̃| (N)").from_zero(), reaction),
        panel(Axis::linear("Friction μ").from_zero(), friction),
        panel(Axis::linear(GAP).from_zero(), gap),
    ];
    if let Some(lowest_panel) = panels.last_mut() {
        lowest_panel.x.has_labels = true;
    }
    Some(Figure {
        name: "fig11_typical_trial".to_owned(),
        title: "A typical trial in time".to_owned(),
        caption: format!(
            "{} exploration of {} in time: (a) vibration amplitude (peak){}; (b) modulus of the observed impedance{}; (c) \
             normal and lateral force{}; (d) amplitude of the finger's reaction force (Eq. 10); (e) friction, measured \
             (dotted) and estimated; (f) levitation gap, estimated (Huloux 2021, Fig. 11). Instances shaded grey, standard \
             errors in the tint of their curve, those of trial with the laws in doubt.{} {}{}",
            match slide.direction {
                protocols::Direction::LeftToRight => "Left-to-right",
                protocols::Direction::RightToLeft => "Right-to-left",
            },
            recording_name(findings),
            if profile_method.is_some() {
                " at the pickup, and under the finger by the plate's measured profile"
            } else {
                ""
            },
            match (
                selection.methods.contains(&Method::Paper),
                correcting_method
            ) {
                (true, Some(method)) => format!(
                    ", as the published method (paper) reads it and freed of envelope dynamics ({})",
                    method.name()
                ),
                _ => String::new(),
            },
            if correcting_method.is_some() {
                ", and the normal force sensed from impedance and amplitude alone with the finger of the first instance as \
                 dynamic has it"
            } else {
                ""
            },
            overlap_note(selection),
            trial_note(findings, selection),
            assumption_note(analysed, selection),
        ),
        width: Width::Page,
        columns: 1,
        panel_height_mm: 25.0,
        footnote: None,
        key: Key::Above,
        panels,
    })
}

fn instances<'a>(
    findings: &'a RecordingFindings,
    exploration: &ExplorationFindings,
) -> impl Iterator<Item = &'a InstanceAnalysis> {
    let span = span(exploration);
    findings
        .instances
        .iter()
        .filter(move |i| span.contains(&i.start_s))
}

/// Returns the time of an exploration, s.
fn span(exploration: &ExplorationFindings) -> RangeInclusive<f64> {
    exploration.start_s..=exploration.end_s
}

/// Returns the normal force self-sensed from impedance and amplitude, N.
fn sensed_normal_n(
    (findings, series): (&RecordingFindings, &RecordingSeries),
    exploration: &ExplorationSeries,
) -> Option<Vec<f64>> {
    let force = self_sensed::normal_force(
        findings.first_finger(series)?,
        exploration.interval_s()?,
        &exploration.under_finger.z_m_n_s_per_m,
        &exploration.under_finger.amplitude_m,
    );
    force.ok().map(|force| force.normal_n)
}

/// Returns curves and standard errors of the methods, broken between instances.
fn estimates(
    instances: &[(&InstanceAnalysis, &SampledInstance)],
    selection: &FigureSelection,
    quantity: EstimatedQuantity,
    factor: f64,
) -> Vec<Series> {
    let band_and_curve = |&method: &Method| {
        let mut curve = Vec::new();
        let mut band = Vec::new();
        let estimated = instances.iter().filter_map(|(instance, samples)| {
            instance.estimate(method)?;
            samples.estimate(method)
        });
        for EstimateSeries {
            contact: series, ..
        } in estimated
        {
            let (values, stds) = quantity(series);
            for ((&t, value), std) in series.time_s.iter().zip(values).zip(stds) {
                let (value, std) = (factor * value, factor * std);
                curve.push((t, value));
                band.push((t, value - std, value + std));
            }
            curve.push((f64::NAN, f64::NAN));
            band.push((f64::NAN, f64::NAN, f64::NAN));
        }
        (Series::band(ink(method), band), line(method, curve))
    };
    let has_estimate = |method: &&Method| {
        let mut analyses = instances.iter();
        instances.is_empty() || analyses.any(|(i, _)| i.estimate(**method).is_some())
    };
    let (bands, curves): (Vec<Series>, Vec<Series>) = selection
        .methods
        .iter()
        .filter(has_estimate)
        .map(band_and_curve)
        .unzip();
    bands.into_iter().chain(curves).collect()
}
