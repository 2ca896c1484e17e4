//! Assumptions, the results that depend on them, and the sources of the methods.

use analysis::Settings;
use analysis::method::Method;
use analysis::printed_settings::PrintedSettings;
use maud::{Markup, html};
use recording::manifest::assumed_errors::assumed_terms;

use crate::content::{RecordingEntry, ReportContent};
use crate::instance;
use crate::number::PLAIN;
use crate::priors;
use crate::recording_results::{SensitivityRow, SensitivityRows};

/// Value of a setting.
enum SettingValue {
    Number(f64),
    Choice(bool),
}

use SettingValue::{Choice, Number};

type Value = fn(&Settings) -> SettingValue;

/// Setting in words.
struct Setting {
    key: &'static str,
    value: Value,
    words: &'static str,
    unit: &'static str,
    /// Factor from the SI unit.
    factor: f64,
    source: &'static str,
}

const fn setting(
    (key, value): (&'static str, Value),
    words: &'static str,
    (factor, unit): (f64, &'static str),
    source: &'static str,
) -> Setting {
    Setting {
        key,
        value,
        words,
        unit,
        factor,
        source,
    }
}

const PUBLICATION: &str = "Huloux 2021";
const PROGRAM_CHOICE: &str = "choice of this program";

const SETTINGS: [Setting; 17] = [
    setting(
        ("sigma_q0_rad_per_m", |settings| {
            Number(settings.sigma_q0_rad_per_m)
        }),
        "q₀: wave number of the skin's ridges in the law of asperities (paper, dynamic)",
        (1.0, "rad/m"),
        "not published; 2π over ridges 0.45 mm apart",
    ),
    setting(
        ("poisson_ratio", |settings| Number(settings.poisson_ratio)),
        "ν: Poisson's ratio of the skin",
        (1.0, ""),
        "not published; incompressible",
    ),
    setting(
        ("young_modulus_pa", |settings| {
            Number(settings.young_modulus_pa)
        }),
        "E: Young's modulus of the skin",
        (1e-6, "MPa"),
        "Huloux 2021, stratum corneum",
    ),
    setting(
        ("contact_area_m2", |settings| {
            Number(settings.contact_area_m2)
        }),
        "S: apparent contact area (paper, dynamic)",
        (1e6, "mm²"),
        "Huloux 2021, the value of the fits",
    ),
    setting(
        ("ambient_pressure_pa", |settings| {
            Number(settings.ambient_pressure_pa)
        }),
        "p₀: pressure of the air, where a recording states none",
        (1e-3, "kPa"),
        "standard atmosphere",
    ),
    setting(
        ("loss_factor", |settings| Number(settings.loss_factor)),
        "η: loss factor of the contact (paper, dynamic)",
        (1.0, ""),
        "Huloux 2021, “damping factor 0.3”",
    ),
    setting(
        ("rest_amplitude_m", |settings| {
            Number(settings.rest_amplitude_m)
        }),
        "amplitude below which the plate counts as at rest (paper)",
        (1e6, "µm"),
        PUBLICATION,
    ),
    setting(
        ("rest_lowest_s", |settings| Number(settings.rest_lowest_s)),
        "duration of the lowest amplitudes, which count as rest in an instance that never goes below (paper)",
        (1e3, "ms"),
        PROGRAM_CHOICE,
    ),
    setting(
        ("lead_in_s", |settings| Number(settings.lead_in_s)),
        "time before an instance over which the gap is integrated (dynamic, trial)",
        (1e3, "ms"),
        PROGRAM_CHOICE,
    ),
    setting(
        ("plate_offset", |settings| Choice(settings.plate_offset)),
        "whether the plate's offset since it was unloaded is fitted (dynamic)",
        (1.0, ""),
        PROGRAM_CHOICE,
    ),
    setting(
        ("central_m", |settings| Number(settings.central_m)),
        "length of the central part of the plate that is analysed",
        (1e3, "mm"),
        PUBLICATION,
    ),
    setting(
        ("speed_m_per_s", |settings| Number(settings.speed_m_per_s)),
        "speed of the slider, unless the protocol states another",
        (1e3, "mm/s"),
        PUBLICATION,
    ),
    setting(
        ("speed_tolerance", |settings| {
            Number(settings.speed_tolerance)
        }),
        "allowed relative deviation from that speed",
        (1.0, ""),
        PROGRAM_CHOICE,
    ),
    setting(
        ("instance_s", |settings| Number(settings.instance_s)),
        "length of an instance",
        (1e3, "ms"),
        PUBLICATION,
    ),
    setting(
        ("contact_n", |settings| Number(settings.contact_n)),
        "lowest normal force that counts as contact",
        (1.0, "N"),
        PROGRAM_CHOICE,
    ),
    setting(
        ("smoothing_hz", |settings| Number(settings.smoothing_hz)),
        "cut-off of the zero-phase second-order Butterworth filter on forces, position and paper's impedance",
        (1.0, "Hz"),
        PUBLICATION,
    ),
    setting(
        ("null_sigmas", |settings| Number(settings.null_sigmas)),
        "lowest amplitude with an impedance, in standard deviations of its noise",
        (1.0, ""),
        PROGRAM_CHOICE,
    ),
];

pub(crate) fn assumptions(printed: &PrintedSettings) -> Markup {
    let PrintedSettings {
        settings,
        amplitude_along_plate: amplitude,
        normal_force: force,
        ambient_pressure,
        finger_across_mode,
    } = printed;
    let sources = [
        ("ambient_pressure", ambient_pressure.as_str()),
        ("amplitude_along_plate.dynamic", amplitude.dynamic.as_str()),
        ("amplitude_along_plate.paper", amplitude.paper),
        ("finger_across_mode", finger_across_mode.as_str()),
        ("normal_force.dynamic", force.dynamic),
        ("normal_force.paper", force.paper),
    ];
    html! {
        p {
            "These values were assumed, not measured. The table shows the values used and the sources of the defaults; " code { "--assume" }
            " overrides them. " b { "trial" } " assumes only E, ν and p₀, and fits S, q₀ and η. Only q₀·E/(1 − ν²) is measured, so \
             its q₀ is valid for this E and ν."
        }
        div.wide { table {
            thead { tr { th { "Assumed" } th.n { "Value" } th { "Unit" } th { "Source of the default" } th { "Name" } } }
            tbody {
                @for setting in &SETTINGS {
                    tr {
                        th scope="row" { (setting.words) }
                        td.n { (setting_text((setting.value)(settings), setting.factor)) }
                        td { (setting.unit) } td { (setting.source) } td { code { (setting.key) } }
                    }
                }
            }
        } }
        (priors::table(settings))
        h3 { "Conventions of pressure, amplitude and force" }
        div.wide { table { tbody { @for (key, source) in sources {
            tr { th scope="row" { code { (key) } } td { (source) } }
        } } } }
    }
}

fn setting_text(value: SettingValue, factor: f64) -> String {
    match value {
        Choice(true) => "yes".to_owned(),
        Choice(false) => "no".to_owned(),
        Number(value) => {
            // The value as given, without the rounding error of a change of unit.
            let product = (value * factor * 1e9).round() / 1e9;
            product.to_string().replace('-', "−")
        }
    }
}

type ConstantSensitivity = fn(&SensitivityRows) -> &SensitivityRow;
const CONSTANTS: [(&str, ConstantSensitivity); 4] = [
    ("q₀", |sensitivity| &sensitivity.sigma_q0_rad_per_m),
    ("E", |sensitivity| &sensitivity.young_modulus_pa),
    ("ν", |sensitivity| &sensitivity.poisson_ratio),
    ("S", |sensitivity| &sensitivity.contact_area_m2),
];

/// Returns a sentence on the number of recordings with intervals that include the calibration's errors.
fn errors_note(recordings: &[RecordingEntry<'_>]) -> String {
    let manifests = recordings.iter().filter_map(|recording| recording.manifest);
    let n_stated = manifests
        .filter(|manifest| manifest.standard_errors.is_some())
        .count();
    match (n_stated, recordings.len()) {
        (0, _) => "No recording states the errors of its constants.".to_owned(),
        (k, n) if k == n => {
            "Every interval includes its standard errors, as the recordings state them.".to_owned()
        }
        (k, n) => format!(
            "Its standard errors are stated by {k} of {n} recordings and included in their intervals."
        ),
    }
}

pub(crate) fn dependencies(recordings: &[RecordingEntry<'_>]) -> Markup {
    let median_sensitivities = |method: Method, constant: ConstantSensitivity| {
        let estimates = recordings
            .iter()
            .flat_map(|recording| &recording.result.instances)
            .flat_map(instance::estimates);
        let rows: Vec<&SensitivityRow> = estimates
            .filter(|estimated| estimated.method == method)
            .filter_map(|estimated| estimated.estimate.sensitivity.as_ref().map(constant))
            .collect();
        let values: [fn(&SensitivityRow) -> f64; 2] = [|row| row.ln_sigma_t, |row| row.ln_abs_z_t];
        values.map(|value| {
            let values = rows.iter().map(|row| value(row));
            statistics::median(values.filter(|value| value.is_finite()))
        })
    };
    let of_recordings = recordings.iter().filter(|entry| entry.manifest.is_some());
    let of_recordings = of_recordings.map(|entry| entry.result.assumed_errors);
    let assumed_errors = assumed_terms(&of_recordings.collect::<Vec<_>>());
    let profiles = recordings
        .iter()
        .filter(|recording| recording.result.plate_profile)
        .count();
    let across = recordings
        .iter()
        .filter(|recording| recording.result.plate_across.is_some())
        .count();
    html! {
        ul {
            li { "All results depend on the " a href="#calibration" { "calibration" } ". " (errors_note(recordings)) }
            @if !assumed_errors.is_empty() {
                li { "Standard errors assumed of the constants of which a recording neither states nor shows the error: "
                      (assumed_errors.join(", ")) ". They are in the total intervals of " b { "trial" } " and in the standard errors of "
                      b { "dynamic" } ", and not in the intervals " i { "within the laws" } "." }
            }
            li { b { "paper" } " and " b { "dynamic" } ": σ" sub { "t" } ", Z" sub { "t" } " and τ are conditional on the assumed S, \
                  q₀, E, ν, η and p₀; friction hardly depends on them. The table below gives the sensitivities." }
            li { b { "trial" } ": of the skin, only E and ν are assumed, and its q₀ absorbs them; p₀ is also assumed where a recording does not state it. σ" sub { "t" }
                  ", Z" sub { "t" } " and the plate's shift are fitted for each instance; S, q₀, η, τ, the exponents of S and τ, the \
                  film's averaging time, the friction floor and the lag for each recording, constant within it." }
            li { "Friction is fitted after the contact: μ" sub { "0" } ", the friction floor and the lag of the lateral force are \
                  conditional on the contact, and the contact is independent of them." }
            li { "The 95 % intervals include the noise, the correlation of neighbouring residuals, the priors of " b { "trial" }
                  ", the stated errors of the calibration, and the laws in doubt: the film's loss, trapped air, the film's drive by the \
                  relative motion, the time average under vibration, a plate that softens, the finger's width. Those "
                  i { "within the laws" } " include no errors of the published laws. Standard errors of " b { "dynamic" }
                  " include the scatter of its residuals and the calibration's errors, for the assumed skin; those of " b { "paper" }
                  " include only the scatter." }
            li { "Where the model does not fit (" a href="#flags" { "Flags and warnings" } "), " b { "trial" } " gives no interval." }
            @if profiles > 0 {
                li { "In " (profiles) " of " (recordings.len()) " recordings the amplitude under the finger follows the measured \
                      profile of the plate (dynamic, trial); in the others the plate is assumed uniform." }
            } @else {
                li { "The plate is assumed uniform along its length: no recording has a measured profile." }
            }
            @if across > 0 {
                li { "In " (across) " of " (recordings.len()) " recordings the wavelength of the plate's mode across its width is \
                      known (dynamic, trial); in the others the width of the finger across the mode is not known and is \
                      included in the intervals of " b { "trial" } "." }
            } @else {
                li { "Width of the finger across the plate's mode not known: included in the intervals of " b { "trial" } "." }
            }
        }
        h3 { "Sensitivity to the assumed values" }
        p { "Relative change of σ" sub { "t" } " and |Z" sub { "t" } "| for a relative change of each constant, median over the \
             instances: −0.2 means that 10 % more of the constant gives 2 % less." }
        div.wide { table {
            thead { tr {
                th { "Constant" }
                th.n { "σ" sub { "t" } ", paper" } th.n { "|Z" sub { "t" } "|, paper" }
                th.n { "σ" sub { "t" } ", dynamic" } th.n { "|Z" sub { "t" } "|, dynamic" }
            } }
            tbody { @for (name, constant) in CONSTANTS { tr {
                th scope="row" { (name) }
                @for method in Method::BOTH {
                    @for value in median_sensitivities(method, constant) { td.n { (PLAIN.value(value)) } }
                }
            } } }
        } }
    }
}

pub(crate) fn methods(content: &ReportContent<'_>) -> Markup {
    html! {
        ul {
            li { b { "paper" } ": as published. Each instant is treated as a steady state; Z" sub { "t" } " is read where the plate \
                  hardly moves, and σ" sub { "t" } " is fitted to each instance." }
            li { b { "dynamic" } ": removes the dynamics of the modulation from the impedance, lets the gap lag behind its equilibrium, and \
                  follows the plate's resonance; fitted to each instance." }
            li { b { "trial" } ": the same model, fitted to all instances of a recording together, with S, q₀ and η measured instead of \
                  assumed, and with a friction floor." }
        }
        p {
            "The method is that of N. Huloux, C. Bernard and M. Wiertlewski, " em {
                "Estimating Friction Modulation From the Ultrasonic Mechanical Impedance"
            } ", IEEE Transactions on Haptics 14(2), 2021, doi 10.1109/TOH.2020.3038937. Please cite it for " b { "paper" }
            "; for a number by " b { "dynamic" } " or " b { "trial" } ", state the method, the program and its version: "
            (content.program) "."
        }
    }
}
