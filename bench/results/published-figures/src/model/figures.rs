//! Figures of the model alone: Huloux 2021, Figs. 3, 5, 6, 7b, 8 and 9.

use plotting::{Axis, Dash, Figure, Ink, Key, Panel, Series, Width};

use super::curves::Curves;
use super::parameters::ModelParameters;
use super::rows::{ContactMotion, Impedance, ImpedanceByStiffness};

const AMPLITUDE: &str = "Vibration amplitude (µm)";
const MICRO: f64 = 1e6;

/// Inks and dashes of successive curves.
const STYLES: [(Ink, Dash); 4] = [
    (Ink::Black, Dash::Solid),
    (Ink::Blue, Dash::Dashed),
    (Ink::Vermillion, Dash::DashDotted),
    (Ink::Green, Dash::Dotted),
];

/// Draws the model's figures, in the paper's order.
pub fn draw(parameters: &ModelParameters, curves: &Curves) -> Vec<Figure> {
    vec![
        impedance_by_stiffness(parameters, curves),
        balance(parameters, curves),
        stiffness(parameters, curves),
        impedance(parameters, curves),
        motion(parameters, curves),
        friction(parameters, curves),
    ]
}

/// Returns one curve for each value of a condition, in the order of the rows.
fn family<R>(
    rows: &[R],
    condition: impl Fn(&R) -> f64,
    name: impl Fn(f64) -> String,
    point: impl Fn(&R) -> (f64, f64),
) -> Vec<Series> {
    rows.chunk_by(|row, next| condition(row) == condition(next))
        .zip(STYLES)
        .map(|(rows, (ink, dash))| {
            let points = rows.iter().map(&point).collect();
            Series::line(ink, dash, points).with_name(name(condition(&rows[0])))
        })
        .collect()
}

fn newtons(force_n: f64) -> String {
    format!("{force_n} N")
}

fn micrometres(length_m: f64) -> String {
    // Rounded to hide the binary fraction of a value in metres.
    format!("{} µm", (length_m * 1e9).round() / 1e3)
}

fn finger(parameters: &ModelParameters) -> String {
    let constants = &parameters.assumed;
    format!(
        "σₜ = {}, S = {:.0} mm², E = {:.3} MPa, ν = {}, q₀ = {:.3e} rad/m, p₀ = {:.0} Pa",
        micrometres(parameters.sigma_t_m),
        constants.contact_area_m2 * 1e6,
        constants.young_modulus_pa * 1e-6,
        constants.poisson_ratio,
        constants.q0_rad_per_m,
        constants.ambient_pressure_pa,
    )
}

fn plate_and_tissue(parameters: &ModelParameters) -> String {
    let tissue = &parameters.tissue;
    format!(
        "carrier at the plate's resonance of {} kHz, mₚ = {} g, bₚ = {} N·s/m; skin: mₜ = {} g, kₜ = {} N/m, bₜ = {} N·s/m",
        (parameters.carrier_hz * 10.0).round() / 1e4,
        (parameters.plate_mass_kg * 1e9).round() / 1e6,
        parameters.plate_damping_n_s_per_m,
        (tissue.mass_kg * 1e9).round() / 1e6,
        tissue.stiffness_n_per_m,
        tissue.damping_n_s_per_m,
    )
}

fn impedance_by_stiffness(parameters: &ModelParameters, curves: &Curves) -> Figure {
    let rows = &curves.impedance_by_stiffness;
    let name = |loss_factor: f64| {
        if loss_factor == 0.0 {
            "elastic".to_owned()
        } else {
            format!("η = {loss_factor}")
        }
    };
    let stiffness = || Axis::logarithmic("Contact stiffness (N/µm)").with_range(0.1, 100.0);
    let panel = |x: Axis, y: Axis, value: fn(&ImpedanceByStiffness) -> f64| Panel {
        series: family(
            rows,
            |row| row.loss_factor,
            name,
            |row| (row.k_c_n_per_m / MICRO, value(row)),
        ),
        ..Panel::new(x, y)
    };
    Figure {
        name: "fig03_impedance_by_stiffness".to_owned(),
        title: "Observed impedance and skin motion against contact stiffness".to_owned(),
        caption: format!(
            "Mechanical impedance observed at the plate, (a) real and (b) imaginary part, and (c) ratio of skin to plate velocity against \
             contact stiffness, for an elastic contact and one with loss factor η = {} (Huloux 2021, Fig. 3, Eqs. 9 and 11). Assumed: {}.",
            parameters.assumed.loss_factor,
            plate_and_tissue(parameters),
        ),
        width: Width::Column,
        columns: 1,
        panel_height_mm: 32.0,
        footnote: None,
        key: Key::Above,
        panels: vec![
            panel(
                stiffness().without_labels(),
                Axis::linear("Re Zₘ (N·s/m)").from_zero(),
                |row| row.z_m_re_n_s_per_m,
            ),
            panel(
                stiffness().without_labels(),
                Axis::linear("Im Zₘ (N·s/m)"),
                |row| row.z_m_im_n_s_per_m,
            ),
            panel(
                stiffness(),
                Axis::linear("|ṽₜ/ṽₚ|").from_zero(),
                |row| row.skin_to_plate_velocity,
            ),
        ],
    }
}

fn balance(parameters: &ModelParameters, curves: &Curves) -> Figure {
    let film = family(
        &curves.squeeze,
        |row| row.amplitude_m,
        |amplitude_m| format!("fₛ at {}", micrometres(amplitude_m)),
        |row| (row.gap_m * MICRO, row.film_n),
    );
    let film_loads = curves
        .balance
        .chunk_by(|row, next| row.normal_n == next.normal_n)
        .enumerate()
        .map(|(number, rows)| {
            let points = rows
                .iter()
                .map(|row| (row.gap_m * MICRO, row.left_to_film_n));
            let line = Series::line(Ink::Grey, Dash::Solid, points.collect());
            if number == 0 {
                line.with_name("⟨f⟩ − fᵣ")
            } else {
                line
            }
        });
    let greatest_n = curves
        .balance
        .iter()
        .map(|row| row.normal_n)
        .fold(0.0, f64::max);
    let greatest_m = curves
        .squeeze
        .iter()
        .map(|row| row.gap_m)
        .fold(0.0, f64::max);
    let forces = Panel {
        series: film_loads.chain(film).collect(),
        ..Panel::new(
            Axis::linear("Gap (µm)").with_range(0.0, greatest_m * MICRO),
            Axis::linear("Force (N)").with_range(0.0, 1.7 * greatest_n),
        )
    };
    let gap = Panel {
        series: family(
            &curves.gap,
            |row| row.normal_n,
            newtons,
            |row| (row.amplitude_m * MICRO, row.gap_m * MICRO),
        ),
        ..Panel::new(
            Axis::linear(AMPLITUDE).with_range(0.0, 10.0),
            Axis::linear("Gap (µm)").from_zero(),
        )
    };
    Figure {
        name: "fig05_force_balance_and_gap".to_owned(),
        title: "Force balance and levitation gap".to_owned(),
        caption: format!(
            "(a) Force of the squeeze film fₛ at four vibration amplitudes, and what asperities, which carry fᵣ, leave of \
             normal forces ⟨f⟩ of 0.5 N and 1 N to it; the skin floats where the curves cross. (b) Gap in equilibrium against \
             vibration amplitude and normal force (Huloux 2021, Fig. 5, Eqs. 14–17). Amplitudes are peak values. Assumed: \
             {}.",
            finger(parameters),
        ),
        width: Width::Page,
        columns: 2,
        panel_height_mm: 55.0,
        footnote: None,
        key: Key::InPanels,
        panels: vec![forces, gap],
    }
}

fn stiffness(parameters: &ModelParameters, curves: &Curves) -> Figure {
    Figure {
        name: "fig06_stiffness".to_owned(),
        title: "Contact stiffness against vibration amplitude and normal force".to_owned(),
        caption: format!(
            "Contact stiffness in equilibrium against vibration amplitude (peak) for four normal forces (Huloux 2021, Fig. 6, Eq. 18). \
             Assumed: {}.",
            finger(parameters),
        ),
        width: Width::Column,
        columns: 1,
        panel_height_mm: 52.0,
        footnote: None,
        key: Key::InPanels,
        panels: vec![Panel {
            series: family(
                &curves.stiffness,
                |row| row.normal_n,
                newtons,
                |row| (row.amplitude_m * MICRO, row.k_c_n_per_m / MICRO),
            ),
            ..Panel::new(
                Axis::linear(AMPLITUDE).with_range(0.0, 10.0),
                Axis::logarithmic("Contact stiffness (N/µm)"),
            )
        }],
    }
}

fn impedance(parameters: &ModelParameters, curves: &Curves) -> Figure {
    let panel = |x: Axis, y: Axis, value: fn(&Impedance) -> f64| Panel {
        series: family(
            &curves.impedance,
            |row| row.normal_n,
            newtons,
            |row| (row.amplitude_m * MICRO, value(row)),
        ),
        ..Panel::new(x, y)
    };
    let amplitude = || Axis::linear(AMPLITUDE).with_range(0.0, 10.0);
    Figure {
        name: "fig07b_impedance".to_owned(),
        title: "Observed impedance against vibration amplitude and normal force".to_owned(),
        caption: format!(
            "Mechanical impedance observed at the plate, (a) real and (b) imaginary part, against vibration amplitude (peak) \
             for four normal forces (Huloux 2021, Fig. 7b, Eqs. 9 and 18). Assumed: {}, η = {}; {}.",
            finger(parameters),
            parameters.assumed.loss_factor,
            plate_and_tissue(parameters),
        ),
        width: Width::Column,
        columns: 1,
        panel_height_mm: 38.0,
        footnote: None,
        key: Key::Above,
        panels: vec![
            panel(
                amplitude().without_labels(),
                Axis::linear("Re Zₘ (N·s/m)"),
                |row| row.z_m_re_n_s_per_m,
            ),
            panel(amplitude(), Axis::linear("Im Zₘ (N·s/m)"), |row| {
                row.z_m_im_n_s_per_m
            }),
        ],
    }
}

fn motion(parameters: &ModelParameters, curves: &Curves) -> Figure {
    let duration_s = curves
        .motion
        .iter()
        .map(|row| row.time_s)
        .fold(0.0, f64::max);
    let time = || Axis::linear("Time (µs)").with_range(0.0, duration_s * MICRO);
    let conditions = curves
        .motion
        .chunk_by(|row, next| row.normal_n == next.normal_n && row.amplitude_m == next.amplitude_m);
    let lowest_row = conditions.clone().count().saturating_sub(2);
    let panels = conditions
        .enumerate()
        .map(|(index, rows)| {
            let curve = |ink, dash, position: fn(&ContactMotion) -> f64| {
                let points = rows
                    .iter()
                    .map(|row| (row.time_s * MICRO, position(row) * MICRO));
                Series::line(ink, dash, points.collect())
            };
            let row = &rows[0];
            Panel {
                series: vec![
                    curve(Ink::Vermillion, Dash::Solid, |row| row.skin_m).with_name("skin"),
                    curve(Ink::Black, Dash::Dashed, |row| row.plate_m).with_name("plate"),
                ],
                notes: vec![format!(
                    "{}, {}",
                    newtons(row.normal_n),
                    micrometres(row.amplitude_m)
                )],
                ..Panel::new(
                    if index < lowest_row {
                        time().without_labels()
                    } else {
                        time()
                    },
                    Axis::linear("Position (µm)"),
                )
            }
        })
        .collect();
    Figure {
        name: "fig08_motion".to_owned(),
        title: "Motion of skin and plate within the carrier's period".to_owned(),
        caption: format!(
            "Position of plate and skin, from the plate's mean position, over two periods of the carrier, at normal forces of \
             1 N (a, b) and 5 N (c, d) and vibration amplitudes of 1 µm (a, c) and 10 µm (b, d) (Huloux 2021, Fig. 8, Eqs. 11 \
             and 17). Assumed: {}, η = {}; {}.",
            finger(parameters),
            parameters.assumed.loss_factor,
            plate_and_tissue(parameters),
        ),
        width: Width::Page,
        columns: 2,
        panel_height_mm: 38.0,
        footnote: None,
        key: Key::Above,
        panels,
    }
}

fn friction(parameters: &ModelParameters, curves: &Curves) -> Figure {
    Figure {
        name: "fig09_friction".to_owned(),
        title: "Friction against vibration amplitude".to_owned(),
        caption: format!(
            "Coefficient of friction against vibration amplitude (peak) at normal forces of 1 N and 5 N (Huloux 2021, Fig. 9, Eq. 19). \
             Assumed: μ₀ = {}, {}.",
            parameters.mu0,
            finger(parameters),
        ),
        width: Width::Column,
        columns: 1,
        panel_height_mm: 48.0,
        footnote: None,
        key: Key::InPanels,
        panels: vec![Panel {
            series: family(
                &curves.friction,
                |row| row.normal_n,
                newtons,
                |row| (row.amplitude_m * MICRO, row.mu),
            ),
            ..Panel::new(
                Axis::linear(AMPLITUDE).with_range(0.0, 10.0),
                Axis::linear("Friction coefficient μ").from_zero(),
            )
        }],
    }
}
