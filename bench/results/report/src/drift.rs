//! Drift of plate and skin within the recordings.

use analysis::method::Method;
use maud::{Markup, html};

use crate::content::RecordingEntry;
use crate::number::{HERTZ, MICRO, NumberFormat, PLAIN};
use crate::recording_results::{Estimate, Parts};

const MICRO_S: NumberFormat = NumberFormat {
    factor: 1e6,
    decimals: 1,
};

/// Returns the best estimates of the first and of the last instance, and their method.
fn end_estimates<'a>(recording: &RecordingEntry<'a>) -> Option<(Method, [&'a Estimate; 2])> {
    let (first, last) = (
        recording.result.instances.first()?,
        recording.result.instances.last()?,
    );
    Some(match (&first.trial, &last.trial) {
        (Some(first), Some(last)) => (Method::Trial, [&first.estimate, &last.estimate]),
        _ => (
            Method::Dynamic,
            [&first.methods.dynamic, &last.methods.dynamic],
        ),
    })
}

pub(crate) fn drift(recordings: &[RecordingEntry<'_>]) -> Markup {
    let complex = |z: Option<Parts>| {
        z.map_or_else(
            || "–".to_owned(),
            |[re, im]| {
                let sign = if im < 0.0 { "−" } else { "+" };
                let [re, size] = [re, im.abs()].map(|part| PLAIN.value(Some(part)));
                format!("{re} {sign} {size}i")
            },
        )
    };
    html! {
        p {
            "First and last instance of each recording: shift of the plate's resonance from that of the unloaded plate, and \
             parameters of the skin. Z" sub { "p" } " is the impedance of the unloaded plate; the last two columns are the pickup's \
             deviation from its calibration, which is corrected before all estimates. The figure of the resonance shows every \
             instance."
        }
        div.wide { table {
            thead { tr {
                th { "Recording" } th.n { "Z" sub { "p" } " (N·s/m)" } th { "Method" } th.n { "Resonance shift (Hz)" }
                th.n { "σ" sub { "t" } " (µm)" } th.n { "Im Z" sub { "t" } " (N·s/m)" }
                th.n { "Pickup’s phase (rad)" } th.n { "Pickup’s delay (µs)" }
            } }
            tbody { @for recording in recordings {
                @let pickup = recording.result.pickup_undone.as_ref();
                @let z_p = recording.result.z_p_n_s_per_m.dynamic.or(recording.result.z_p_n_s_per_m.paper);
                tr {
                    th scope="row" { a href={ "#" (recording.anchor()) } { (recording.name()) } }
                    td.n { (complex(z_p)) }
                    @match end_estimates(recording) {
                        Some((method, ends)) => {
                            td { (method.name()) }
                            td.n { (course(HERTZ, ends.map(|estimate| estimate.resonance_shift_hz))) }
                            td.n { (course(MICRO, ends.map(|estimate| estimate.sigma_t_m))) }
                            td.n { (course(PLAIN, ends.map(|estimate| Some(estimate.z_t_n_s_per_m[1])))) }
                        },
                        None => { td {} td.n { "–" } td.n { "–" } td.n { "–" } },
                    }
                    td.n { (PLAIN.value(pickup.map(|pickup| pickup.phase_rad))) }
                    td.n { (MICRO_S.value(pickup.map(|pickup| pickup.delay_s))) }
                }
            } }
        } }
        (model_check(recordings))
    }
}

fn course(format: NumberFormat, [first, last]: [Option<f64>; 2]) -> String {
    format!("{} → {}", format.value(first), format.value(last))
}

/// Returns the differences of the normal force, sensed from impedance and amplitude, from the measured force.
fn model_check(recordings: &[RecordingEntry<'_>]) -> Markup {
    let percent = NumberFormat {
        factor: 100.0,
        decimals: 0,
    };
    let micro = NumberFormat {
        factor: 1e6,
        decimals: 1,
    };
    let checked_recordings: Vec<_> = recordings
        .iter()
        .filter(|recording| !recording.result.model_check.is_empty())
        .collect();
    html! {
        @if !checked_recordings.is_empty() {
            h3 { "Normal force from impedance and amplitude" }
            p {
                "Normal force computed over the whole recording with the parameters of the first instance by " b { "dynamic" }
                "; difference from the measured force, median and 90th percentile. If it grows, the model does not fit with the \
                 assumed skin, or something changed during the recording."
            }
            div.wide { table {
                thead { tr {
                    th { "Recording" } th.n { "Amplitude (µm)" } th.n { "Samples" } th.n { "Median (%)" } th.n { "90 % (%)" }
                } }
                tbody { @for recording in checked_recordings {
                    @for (index, band) in recording.result.model_check.iter().enumerate() {
                        tr.first[index == 0] {
                            @if index == 0 {
                                th scope="row" rowspan=(recording.result.model_check.len()) { (recording.name()) }
                            }
                            td.n { (micro.value(Some(band.amplitude_from_m))) " to " (micro.value(Some(band.amplitude_to_m))) }
                            td.n { (band.n) }
                            td.n { (percent.value(Some(band.force_relative_difference_median))) }
                            td.n { (percent.value(Some(band.force_relative_difference_p90))) }
                        }
                    }
                } }
            } }
        }
    }
}
