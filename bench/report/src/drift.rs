//! Drift of plate and skin within the recordings.

use maud::{Markup, html};

use crate::content::Of;
use crate::number::{HERTZ, In, MICRO, PLAIN};
use crate::results::{Estimate, Interval};

const MICRO_S: In = In {
    factor: 1e6,
    decimals: 1,
};

/// Returns the best estimates of the first and of the last instance, and the name of their method.
fn ends<'a>(of: &Of<'a>) -> Option<(&'static str, [&'a Estimate; 2])> {
    let (first, last) = (of.result.instances.first()?, of.result.instances.last()?);
    let trial = first.trial.as_ref().zip(last.trial.as_ref());
    let by_trial = trial.map(|(first, last)| ("trial", [first, last]));
    by_trial.or_else(|| Some(("dynamic", [first.dynamic.as_ref()?, last.dynamic.as_ref()?])))
}

pub(crate) fn drift(recordings: &[Of<'_>]) -> Markup {
    let complex = |z: Option<Interval>| {
        z.map_or_else(
            || "–".to_owned(),
            |[re, im]| {
                let sign = if im.is_some_and(|im| im < 0.0) {
                    "−"
                } else {
                    "+"
                };
                let size = im.map(f64::abs);
                format!("{} {sign} {}i", PLAIN.value(re), PLAIN.value(size))
            },
        )
    };
    html! {
        p {
            "From the first to the last instance of each recording: the plate's resonance less that of the unloaded plate, and the \
             skin. Beside it the unloaded plate's impedance, and how far the pickup was from what its calibration states, which is \
             corrected before anything else. The figure of the resonance shows every instance."
        }
        div.wide { table {
            thead { tr {
                th { "Recording" } th.n { "Z" sub { "p" } " (N·s/m)" } th { "By" } th.n { "Resonance shift (Hz)" }
                th.n { "σ" sub { "t" } " (µm)" } th.n { "Im Z" sub { "t" } " (N·s/m)" }
                th.n { "Pickup’s phase (rad)" } th.n { "Pickup’s delay (µs)" }
            } }
            tbody { @for of in recordings {
                @let pickup = of.result.pickup_undone.as_ref();
                @let z_p = of.result.z_p_n_s_per_m.dynamic.or(of.result.z_p_n_s_per_m.paper);
                tr {
                    th scope="row" { a href={ "#" (of.anchor()) } { (of.name()) } }
                    td.n { (complex(z_p)) }
                    @match ends(of) {
                        Some((method, ends)) => {
                            td { (method) }
                            td.n { (course(HERTZ, ends.map(|of| of.resonance_shift_hz))) }
                            td.n { (course(MICRO, ends.map(|of| of.sigma_t_m))) }
                            td.n { (course(PLAIN, ends.map(|of| of.z_t_n_s_per_m.and_then(|z| z[1])))) }
                        },
                        None => { td {} td.n { "–" } td.n { "–" } td.n { "–" } },
                    }
                    td.n { (PLAIN.value(pickup.and_then(|of| of.phase_rad))) }
                    td.n { (MICRO_S.value(pickup.and_then(|of| of.delay_s))) }
                }
            } }
        } }
        (model_check(recordings))
    }
}

fn course(shown: In, [first, last]: [Option<f64>; 2]) -> String {
    format!("{} → {}", shown.value(first), shown.value(last))
}

/// Returns the differences of the normal force, sensed from impedance and amplitude, from the measured force.
fn model_check(recordings: &[Of<'_>]) -> Markup {
    let percent = In {
        factor: 100.0,
        decimals: 0,
    };
    let micro = In {
        factor: 1e6,
        decimals: 1,
    };
    let with: Vec<_> = recordings
        .iter()
        .filter(|of| !of.result.model_check.is_empty())
        .collect();
    html! {
        @if !with.is_empty() {
            h3 { "The normal force, sensed from impedance and amplitude" }
            p {
                "With the parameters that " b { "dynamic" } " finds in the first instance, over the whole recording; its difference \
                 from the measured force, median and 90th percentile. Where it grows the model does not hold with the assumed \
                 skin, or something changed on the way."
            }
            div.wide { table {
                thead { tr {
                    th { "Recording" } th.n { "Amplitude (µm)" } th.n { "Samples" } th.n { "Median (%)" } th.n { "90 % (%)" }
                } }
                tbody { @for of in with {
                    @for (at, band) in of.result.model_check.iter().enumerate() {
                        tr.first[at == 0] {
                            @if at == 0 {
                                th scope="row" rowspan=(of.result.model_check.len()) { (of.name()) }
                            }
                            td.n { (micro.value(band.amplitude_from_m)) " to " (micro.value(band.amplitude_to_m)) }
                            td.n { (band.n) }
                            td.n { (percent.value(band.force_relative_difference_median)) }
                            td.n { (percent.value(band.force_relative_difference_p90)) }
                        }
                    }
                } }
            } }
        }
    }
}
