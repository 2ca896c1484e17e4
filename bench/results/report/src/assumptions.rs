//! Assumptions, the results that depend on them, and the sources of the methods.

use analysis::Settings;
use analysis::method::Method;
use analysis::printed_settings::PrintedSettings;
use analysis::results::{SensitivityRow, SensitivityRows};
use maud::{Markup, html};

use crate::content::{Content, RecordingEntry};
use crate::instance;
use crate::number::PLAIN;
use crate::priors;

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
        "p₀: pressure of the air",
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
        "amplitudes below this count as rest (paper)",
        (1e6, "µm"),
        PUBLICATION,
    ),
    setting(
        ("rest_lowest_s", |settings| Number(settings.rest_lowest_s)),
        "length of the lowest amplitudes that counts as rest in an instance that never goes below (paper)",
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
        "the plate's offset since it was unloaded is fitted (dynamic)",
        (1.0, ""),
        PROGRAM_CHOICE,
    ),
    setting(
        ("central_m", |settings| Number(settings.central_m)),
        "length about the plate's centre that is kept",
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
        "allowed departure from it, as a part of it",
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
        "normal force from which on the finger is on the plate",
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
        "amplitudes under this many standard deviations of their noise have no impedance",
        (1.0, ""),
        PROGRAM_CHOICE,
    ),
];

pub(crate) fn assumptions(printed: &PrintedSettings) -> Markup {
    let PrintedSettings {
        settings,
        amplitude_along_plate: amplitude,
        normal_force: force,
    } = printed;
    let sources = [
        ("amplitude_along_plate.dynamic", amplitude.dynamic.as_str()),
        ("amplitude_along_plate.paper", amplitude.paper),
        ("normal_force.dynamic", force.dynamic),
        ("normal_force.paper", force.paper),
    ];
    html! {
        p {
            "These numbers were not measured here. The column of sources says where their defaults come from; " code { "--assume" }
            " replaces them, and this table shows what was in force. " b { "trial" }
            " assumes E, ν and p₀ alone, and fits S, q₀ and η. Only q₀·E/(1 − ν²) is measured, so its q₀ is that for this E and ν."
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
        h3 { "How amplitude and force are taken" }
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
        (0, _) => "No recording states the errors of its constants: they are taken as exact, and no interval here holds an error \
                   of theirs."
            .to_owned(),
        (k, n) if k == n => "Its standard errors, as the recordings state them, are in every interval.".to_owned(),
        (k, n) => format!(
            "Its standard errors are in the intervals of {k} of {n} recordings, which state them; the others' constants are \
             taken as exact."
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
    let profiles = recordings
        .iter()
        .filter(|recording| recording.result.plate_profile)
        .count();
    html! {
        ul {
            li { "Everything rests on the " a href="#calibration" { "calibration" } ". " (errors_note(recordings)) }
            li { b { "paper" } " and " b { "dynamic" } ": σ" sub { "t" } ", Z" sub { "t" } " and τ are conditional on the assumed S, \
                  q₀, E, ν, η and p₀; friction hardly is. The table gives by how much." }
            li { b { "trial" } ": nothing of the skin is assumed but E and ν, which its q₀ absorbs; p₀ is assumed. σ" sub { "t" }
                  ", Z" sub { "t" } " and the plate's shift belong to an instance; S, q₀, η, τ, the exponents of S and τ, the film's mean, the floor and the lag to a recording, \
                  and are taken not to change within it." }
            li { "Friction is fitted after the contact, and has no say in it: μ" sub { "0" } ", the floor and the lag are conditional \
                  on the contact; the contact is not conditional on them." }
            li { "The 95 % intervals hold the noise, what neighbouring residuals share, the priors of " b { "trial" } " and the stated \
                  errors of the calibration; not a law that is not the model's. Standard errors of " b { "dynamic" } " hold the \
                  scatter of its residuals and the calibration's errors, for the assumed skin; those of " b { "paper" } " the \
                  scatter alone." }
            li { "Where the model does not fit (" a href="#flags" { "Flags and warnings" } "), " b { "trial" } " gives no interval." }
            @if profiles > 0 {
                li { "In " (profiles) " of " (recordings.len()) " recordings the amplitude under the finger follows the measured \
                      profile of the plate (dynamic, trial); in the others the plate is taken for uniform." }
            } @else {
                li { "The plate is taken for uniform along its length: no recording has a measured profile." }
            }
        }
        h3 { "Sensitivity to what is assumed" }
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

pub(crate) fn methods(content: &Content<'_>) -> Markup {
    html! {
        ul {
            li { b { "paper" } ": as published. Each instant is taken for a steady state; Z" sub { "t" } " is read where the plate \
                  hardly moves, σ" sub { "t" } " is fitted to each instance." }
            li { b { "dynamic" } ": frees the impedance of the modulation's own dynamics, lets the gap lag behind its equilibrium, and \
                  follows the plate's resonance; fitted to each instance." }
            li { b { "trial" } ": the same model, fitted to all instances of a recording together, with S, q₀ and η measured instead of \
                  assumed, and a floor of friction." }
        }
        p {
            "The method is that of N. Huloux, C. Bernard and M. Wiertlewski, " em {
                "Estimating Friction Modulation From the Ultrasonic Mechanical Impedance"
            } ", IEEE Transactions on Haptics 14(2), 2021, doi 10.1109/TOH.2020.3038937. Please cite it for " b { "paper" }
            "; where a number is by " b { "dynamic" } " or " b { "trial" } ", say so, and name the program and its version: "
            (content.program) "."
        }
    }
}
