//! Sweeps of circuits and oscillators, as analysers and vibrometers write them, and a measured one.
#![expect(
    clippy::unwrap_used,
    reason = "a value that cannot be unwrapped fails the test"
)]

use std::f64::consts::TAU;
use std::fmt::Write as _;

use metrology::FittedValue;
use num_complex::Complex64;
use plate_sweep::{ColumnChoice, ModalScale, Sweep, SweepFault, SweepFit, SweptQuantity};
use rand::{RngExt as _, SeedableRng};
use rand_distr::{Distribution, StandardNormal};

/// Branch of resistor, inductor and capacitor in series.
#[derive(Clone, Copy)]
struct Branch {
    ohm: f64,
    henry: f64,
    farad: f64,
}

impl Branch {
    /// A branch by its resonance, quality and capacitance.
    fn new(hz: f64, quality: f64, farad: f64) -> Self {
        let omega = TAU * hz;
        let henry = 1.0 / (omega * omega * farad);
        Self {
            ohm: omega * henry / quality,
            henry,
            farad,
        }
    }

    fn admittance(self, omega: f64) -> Complex64 {
        let impedance = Complex64::new(self.ohm, omega * self.henry - 1.0 / (omega * self.farad));
        impedance.inv()
    }
}

/// Actuators: branches beside a capacitor with losses, behind the resistance of the leads.
#[derive(Clone)]
struct Circuit {
    branches: Vec<Branch>,
    farad: f64,
    loss: f64,
    lead_ohm: f64,
}

impl Circuit {
    fn one(hz: f64, quality: f64) -> Self {
        Self {
            branches: vec![Branch::new(hz, quality, 12e-12)],
            farad: 4e-9,
            loss: 0.015,
            lead_ohm: 0.0,
        }
    }

    fn admittance(&self, hz: f64) -> Complex64 {
        let omega = TAU * hz;
        let capacitor = Complex64::new(self.loss, 1.0) * omega * self.farad;
        let branches = self.branches.iter().map(|branch| branch.admittance(omega));
        let admittance = capacitor + branches.sum::<Complex64>();
        (admittance.inv() + self.lead_ohm).inv()
    }

    fn sweep(&self, frequencies: &[f64]) -> Vec<(f64, Complex64)> {
        frequencies
            .iter()
            .map(|hz| (*hz, self.admittance(*hz)))
            .collect()
    }
}

fn linear(from_hz: f64, to_hz: f64, count: u32) -> Vec<f64> {
    let step_hz = (to_hz - from_hz) / f64::from(count - 1);
    (0..count)
        .map(|n| from_hz + step_hz * f64::from(n))
        .collect()
}

fn table(header: &str, sign: &str, rows: impl IntoIterator<Item = [f64; 3]>) -> String {
    let mut text = format!("{header}\n");
    for [f, a, b] in rows {
        writeln!(text, "{f}{sign}{a}{sign}{b}").unwrap();
    }
    text
}

fn fit_of(text: &str) -> SweepFit {
    SweepFit::new(&Sweep::read(text, None, None).unwrap(), None).unwrap()
}

const BAR: &str = include_str!("../../../../tests/fixtures/piezo-bar/admittance.txt");

fn choice(text: &str) -> ColumnChoice {
    text.parse().unwrap()
}

fn is_near(value: f64, truth: f64, relative: f64) -> bool {
    (value / truth - 1.0).abs() < relative
}

/// Requires the resonance and the quality of a circuit.
fn require(fit: &SweepFit, hz: f64, quality: f64) {
    assert!(is_near(fit.resonance_hz().value, hz, 1e-6), "{fit:?}");
    assert!(is_near(fit.quality().value, quality, 1e-4), "{fit:?}");
}

#[test]
fn a_measured_sweep_is_fitted_within_its_errors() {
    let fit = fit_of(BAR);
    // By hand: the conductance is largest, 2.60 mS, at 128.1 kHz, and exceeds half of that from 127.5 to 128.9 kHz.
    assert!(is_near(fit.resonance_hz().value, 128.15e3, 1e-3), "{fit:?}");
    assert!(is_near(fit.quality().value, 128.15 / 1.45, 0.05), "{fit:?}");
    let errors = fit.constant_errors();
    assert!(
        fit.residual() > 0.03 && errors.largest() < 0.05,
        "{errors:?}"
    );
    let clamped = fit.clamped.unwrap();
    // The largest conductance is that of the motional branch, ω C Q, with that of the losses.
    let peak = TAU * fit.resonance_hz().value * clamped.motional_f * fit.quality().value;
    assert!(is_near(peak, 2.6e-3, 0.05), "{peak}");
    assert!(!fit.is_conjugate && fit.notes().is_empty(), "{fit:?}");
    // The same from every second and every fifth row, and from the rows turned over.
    for step in [2, 5] {
        let mut rows: Vec<&str> = BAR.lines().skip(1).step_by(step).collect();
        rows.reverse();
        let coarse = fit_of(&format!("f (Hz)\tG (S)\tB (S)\n{}\n", rows.join("\n")));
        let moved_hz = coarse.resonance_hz().value - fit.resonance_hz().value;
        assert!(
            moved_hz.abs() < 3.0 * coarse.resonance_hz().standard_error,
            "{step}: {moved_hz}"
        );
        let change = coarse.quality().value - fit.quality().value;
        assert!(
            change.abs() < 3.0 * coarse.quality().standard_error,
            "{step}: {change}"
        );
    }
}

#[test]
fn a_circuit_is_recovered_from_tables_of_all_kinds() {
    let (hz, quality) = (35_162.0, 250.0);
    let circuit = Circuit::one(hz, quality);
    let rows = circuit.sweep(&linear(34e3, 36.4e3, 161));
    let polar = |value: Complex64| (value.norm(), value.arg());
    let texts = [
        table(
            "f (Hz),G (S),B (S)",
            ",",
            rows.iter().map(|(f, y)| [*f, y.re, y.im]),
        ),
        table(
            "Frequency [kHz]\tConductance [mS]\tSusceptance [µS]",
            "\t",
            rows.iter()
                .rev()
                .map(|(f, y)| [f / 1e3, y.re * 1e3, y.im * 1e6]),
        ),
        table(
            "Agilent 4294A\n\n# f/MHz |Z|/kΩ Theta/deg",
            "  ",
            rows.iter().map(|(f, y)| {
                let (size, angle) = polar(y.inv());
                [f / 1e6, size / 1e3, angle.to_degrees()]
            }),
        ),
        table(
            "freq_hz;R;X\nHz;Ohm;Ohm",
            ";",
            rows.iter().map(|(f, y)| [*f, y.inv().re, y.inv().im]),
        )
        .replace('.', ","),
        table(
            "Frequency (rad/s),Y (dB re 1 mS),phase (rad)",
            ",",
            rows.iter().map(|(f, y)| {
                let (size, angle) = polar(*y);
                [TAU * f, 20.0 * (size / 1e-3).log10(), angle]
            }),
        ),
    ];
    for text in &texts {
        let fit = fit_of(text);
        require(&fit, hz, quality);
        let clamped = fit.clamped.unwrap();
        assert!(is_near(clamped.capacitance_f, 4e-9, 1e-3), "{clamped:?}");
        assert!(is_near(clamped.motional_f, 12e-12, 1e-3), "{clamped:?}");
        assert!(is_near(clamped.loss_tangent, 0.015, 1e-2), "{clamped:?}");
    }
    let bare = texts[0].lines().skip(1).collect::<Vec<_>>().join("\n");
    let sweep = Sweep::read(&bare, Some(&choice("f,G,B")), None).unwrap();
    require(&SweepFit::new(&sweep, None).unwrap(), hz, quality);
    let sweep = Sweep::read(
        &bare,
        Some(&choice("0,1,2")),
        Some(SweptQuantity::Admittance),
    );
    require(&SweepFit::new(&sweep.unwrap(), None).unwrap(), hz, quality);
}

/// Displacement over voltage of a mass on a spring with a damper.
fn oscillator(mass_kg: f64, hz: f64, quality: f64, force_factor: f64, at_hz: f64) -> Complex64 {
    let (omega0, omega) = (TAU * hz, TAU * at_hz);
    let impedance = Complex64::new(
        mass_kg * omega0 / quality,
        omega * mass_kg - mass_kg * omega0 * omega0 / omega,
    );
    force_factor / (impedance * Complex64::new(0.0, omega))
}

#[test]
fn modal_mass_and_force_factor_follow_from_each_other() {
    let (mass_kg, hz, quality, gamma) = (8e-3, 35_162.0, 250.0, 0.13);
    let exact = |value| FittedValue {
        value,
        standard_error: 0.01 * value,
    };
    let frequencies = linear(34.5e3, 35.8e3, 101);
    // Behind a vibrometer with a delay of 3 µs.
    let motion = frequencies.iter().map(|f| {
        (
            *f,
            oscillator(mass_kg, hz, quality, gamma, *f) * Complex64::cis(-TAU * f * 3e-6),
        )
    });
    let motion: Vec<(f64, Complex64)> = motion.collect();
    // The current of the motional branch is γ times the velocity; the actuators have 10 nF.
    let current = frequencies.iter().map(|f| {
        let derivative = Complex64::new(0.0, TAU * f);
        let velocity = derivative * oscillator(mass_kg, hz, quality, gamma, *f);
        [
            *f,
            (gamma * velocity).re,
            (gamma * velocity + derivative * 10e-9).im,
        ]
    });
    let texts = [
        table("f (Hz),G (S),B (S)", ",", current),
        table(
            "f (Hz),real (nm/V),imag (nm/V)",
            ",",
            motion.iter().map(|(f, x)| [*f, x.re * 1e9, x.im * 1e9]),
        ),
        table(
            "f (Hz),Velocity (mm/s/V),Phase (deg)",
            ",",
            motion.iter().map(|(f, x)| {
                let velocity = Complex64::new(0.0, TAU * f) * x;
                [*f, velocity.norm() * 1e3, velocity.arg().to_degrees()]
            }),
        ),
    ];
    for text in texts {
        let fit = fit_of(&text);
        let by_mass = fit.constants(ModalScale::ModalMass(exact(mass_kg)));
        assert!(
            is_near(by_mass.force_factor_n_per_v.value, gamma, 2e-3),
            "{by_mass:?}"
        );
        assert!(is_near(
            by_mass.stiffness_n_per_m.value,
            mass_kg * (TAU * hz).powi(2),
            1e-3
        ));
        assert!(is_near(
            by_mass.damping_n_s_per_m.value,
            TAU * hz * mass_kg / quality,
            1e-3
        ));
        let static_m = gamma / (mass_kg * (TAU * hz).powi(2));
        assert!(
            is_near(by_mass.displacement_m_per_v.value, static_m, 2e-3),
            "{by_mass:?}"
        );
        let by_factor = fit.constants(ModalScale::ForceFactor(exact(gamma)));
        assert!(
            is_near(by_factor.modal_mass_kg.value, mass_kg, 3e-3),
            "{by_factor:?}"
        );
        let relative = |v: FittedValue| v.standard_error / v.value;
        let (power, error) = if fit.clamped.is_some() {
            (0.5, 0.02)
        } else {
            (1.0, 0.01)
        };
        assert!(
            is_near(relative(by_mass.force_factor_n_per_v), 0.01 * power, 0.1),
            "{by_mass:?}"
        );
        assert!(
            is_near(relative(by_factor.modal_mass_kg), error, 0.1),
            "{by_factor:?}"
        );
    }
}

#[test]
fn several_modes_are_seen_and_the_nearest_can_be_chosen() {
    let mut circuit = Circuit::one(35e3, 250.0);
    circuit.branches.push(Branch::new(33.1e3, 300.0, 3e-12));
    circuit.branches.push(Branch::new(35.9e3, 200.0, 2e-12));
    let rows = circuit.sweep(&linear(31e3, 38e3, 1401));
    let text = table(
        "f (Hz),G (S),B (S)",
        ",",
        rows.iter().map(|(f, y)| [*f, y.re, y.im]),
    );
    let sweep = Sweep::read(&text, None, None).unwrap();
    let strongest = SweepFit::new(&sweep, None).unwrap();
    assert!(
        is_near(strongest.resonance_hz().value, 35e3, 3e-5),
        "{:?}",
        strongest.resonance_hz()
    );
    assert!(
        is_near(strongest.quality().value, 250.0, 0.01),
        "{:?}",
        strongest.resonance_hz()
    );
    let has_mode = |hz: f64| {
        let mut modes = strongest.further_modes.iter();
        modes.any(|mode| (mode.resonance_hz - hz).abs() < 10.0)
    };
    assert!(has_mode(33.1e3), "{:?}", strongest.further_modes);
    let second = SweepFit::new(&sweep, Some(33e3)).unwrap();
    assert!(
        is_near(second.resonance_hz().value, 33.1e3, 3e-5),
        "{:?}",
        second.resonance_hz()
    );
}

#[test]
fn mistakes_are_corrected_or_refused_by_name() {
    let (hz, quality) = (35_162.0, 250.0);
    let rows = Circuit::one(hz, quality).sweep(&linear(34e3, 36.4e3, 161));
    let text = |header: &str, row: &dyn Fn(f64, Complex64) -> [f64; 3]| {
        table(header, ",", rows.iter().map(|(f, y)| row(*f, *y)))
    };
    let fault = |text: &str, choice_text: Option<&str>, quantity| {
        let choice = choice_text.map(choice);
        let fit = Sweep::read(text, choice.as_ref(), quantity)
            .and_then(|sweep| SweepFit::new(&sweep, None));
        fit.unwrap_err()
    };
    let plain = text("f (Hz),G (S),B (S)", &|f, y| [f, y.re, y.im]);

    // Phases of exp(−iωt), and a current of the other sign: corrected, and said.
    let turned = fit_of(&text("f (Hz),G (S),B (S)", &|f, y| [f, y.re, -y.im]));
    require(&turned, hz, quality);
    assert!(turned.is_conjugate && turned.notes()[0].contains("other sign"));
    let reversed = fit_of(&text("f (Hz),G (S),B (S)", &|f, y| [f, -y.re, -y.im]));
    require(&reversed, hz, quality);
    assert!(reversed.notes()[0].contains("conductance is negative"));
    assert!(is_near(reversed.clamped.unwrap().capacitance_f, 4e-9, 1e-3));

    let decibels = text("f (Hz),Y,phase (deg)", &|f, y| {
        [f, 20.0 * y.norm().log10(), y.arg().to_degrees()]
    });
    assert!(matches!(
        fault(&decibels, None, None),
        SweepFault::NegativeMagnitude { line: 2, .. }
    ));
    let stated = Sweep::read(&decibels, Some(&choice("f,Y[dB],phase")), None).unwrap();
    require(&SweepFit::new(&stated, None).unwrap(), hz, quality);
    let linear_db = text("f (Hz),Y (dB),phase (deg)", &|f, y| {
        [f, y.norm(), y.arg().to_degrees()]
    });
    assert!(matches!(
        fault(&linear_db, None, None),
        SweepFault::NoQuantity | SweepFault::NotDecibels { .. }
    ));

    let degrees = text("f (Hz),Y (S),phase", &|f, y| {
        [f, y.norm(), y.arg().to_degrees()]
    });
    assert!(matches!(
        fault(&degrees, None, None),
        SweepFault::NoAngle { .. }
    ));
    let wrong = fault(&degrees, Some("f,Y,phase[rad]"), None);
    assert!(
        matches!(wrong, SweepFault::OtherAngle { other: "deg", .. }),
        "{wrong}"
    );
    let radians = text("f (Hz),Y (S),phase (deg)", &|f, y| [f, y.norm(), y.arg()]);
    assert!(matches!(
        fault(&radians, None, None),
        SweepFault::OtherAngle { other: "rad", .. }
    ));

    let kilohertz = text("f,G,B", &|f, y| [f / 1e3, y.re, y.im]);
    let unit = fault(&kilohertz, None, None);
    assert!(unit.to_string().contains("f[kHz]"), "{unit}");
    let stated = Sweep::read(&kilohertz, Some(&choice("f[kHz],G,B")), None).unwrap();
    require(&SweepFit::new(&stated, None).unwrap(), hz, quality);

    let outside = Circuit::one(hz, quality).sweep(&linear(34e3, 35.1e3, 101));
    let outside = table(
        "f (Hz),G (S),B (S)",
        ",",
        outside.iter().map(|(f, y)| [*f, y.re, y.im]),
    );
    let end = fault(&outside, None, None);
    assert!(
        matches!(end, SweepFault::BeyondTheEnd { edge_hz, .. } if edge_hz > 35e3),
        "{end}"
    );
    let empty = Circuit::one(60e3, quality).sweep(&linear(34e3, 36.4e3, 161));
    let empty = table(
        "f (Hz),G (S),B (S)",
        ",",
        empty.iter().map(|(f, y)| [*f, y.re, y.im]),
    );
    assert!(matches!(
        fault(&empty, None, None),
        SweepFault::NoResonance { .. }
    ));

    let dual = text("f,a,b", &|f, y| [f, y.inv().re, y.inv().im]);
    let dual = fault(&dual, Some("f,a,b"), Some(SweptQuantity::Admittance));
    assert!(
        matches!(
            dual,
            SweepFault::OtherDual {
                likely: SweptQuantity::Impedance,
                ..
            }
        ),
        "{dual}"
    );
    assert!(matches!(
        fault(&plain, None, Some(SweptQuantity::Impedance)),
        SweepFault::UnknownColumns { .. }
    ));
    assert!(matches!(
        fault(&plain, Some("f,G,B"), Some(SweptQuantity::Impedance)),
        SweepFault::OtherQuantity { .. }
    ));
    assert!(matches!(
        fault(&plain, Some("f,B,G"), None),
        SweepFault::OtherKind { .. }
    ));
    assert!(matches!(
        fault(&plain, Some("f,G,C"), None),
        SweepFault::NoColumn { .. }
    ));
    let metres = text("f (Hz),real (nm),imag (nm)", &|f, y| [f, y.re, y.im]);
    let displacement = Some(SweptQuantity::Displacement);
    let unit = fault(&metres, Some("0,1,2"), displacement);
    assert!(
        matches!(&unit, SweepFault::UnknownUnit { unit } if unit == "nm"),
        "{unit}"
    );
    let few = plain.lines().take(6).collect::<Vec<_>>().join("\n");
    assert_eq!(fault(&few, None, None), SweepFault::TooFew { count: 5 });
}

/// A circuit drawn at random, with up to two further modes, and its sweep with noise.
struct DrawnSweep {
    hz: f64,
    quality: f64,
    farad: f64,
    sweep: Sweep,
}

impl DrawnSweep {
    fn new(rng: &mut rand_chacha::ChaCha8Rng) -> Self {
        let mut uniform = || -> f64 { rng.random() };
        let hz = 1.2e3 * 10f64.powf(3.9 * uniform());
        let quality = 20.0 * 10f64.powf(2.0 * uniform());
        let bandwidth_hz = hz / quality;
        let per_bandwidth = 2.5 * 10f64.powf(uniform());
        let noise = [0.0, 1e-3, 5e-3][(3.0 * uniform()) as usize];
        let mut reach = || bandwidth_hz * (4.0 + 16.0 * uniform());
        let (from_hz, to_hz) = ((hz - reach()).max(0.3 * hz), hz + reach());
        let count = ((to_hz - from_hz) / bandwidth_hz * per_bandwidth) as u32 + 2;
        let farad = 1e-12 * 10f64.powf(1.5 * uniform());
        let mut circuit = Circuit {
            branches: vec![Branch::new(hz, quality, farad)],
            farad: farad / (0.005 * 10f64.powf(uniform())),
            loss: 0.02 * uniform(),
            lead_ohm: 0.0,
        };
        for _ in 0..(3.0 * uniform()) as usize {
            let sign = if uniform() < 0.5 { -1.0 } else { 1.0 };
            let other_hz = (hz + sign * (3.0 + 20.0 * uniform()) * bandwidth_hz).max(0.2 * hz);
            let other = Branch::new(
                other_hz,
                quality * (0.5 + uniform()),
                0.5 * farad * uniform(),
            );
            circuit.branches.push(other);
        }
        let ratio = (to_hz / from_hz).powf(f64::from(count - 1).recip());
        let frequencies = if uniform() < 0.3 {
            (0..count).map(|n| from_hz * ratio.powi(n as i32)).collect()
        } else {
            linear(from_hz, to_hz, count)
        };
        let rows = circuit.sweep(&frequencies);
        let largest = rows.iter().map(|(_, y)| y.norm()).fold(0.0, f64::max);
        let mut white = || -> f64 { StandardNormal.sample(rng) };
        let values: Vec<Complex64> = rows
            .iter()
            .map(|(_, y)| {
                y + Complex64::new(white(), white()) * noise * largest.min(10.0 * y.norm())
            })
            .collect();
        Self {
            hz,
            quality,
            farad,
            sweep: Sweep::new(SweptQuantity::Admittance, &frequencies, &values).unwrap(),
        }
    }
}

#[test]
fn circuits_from_1_khz_to_10_mhz_are_known_within_their_intervals() {
    const CIRCUITS: usize = 60;
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(32);
    let mut covered = [0; 3];
    let mut found = 0;
    for _ in 0..CIRCUITS {
        let drawn = DrawnSweep::new(&mut rng);
        let Ok(fit) = SweepFit::new(&drawn.sweep, None) else {
            continue;
        };
        found += 1;
        assert!(!fit.is_conjugate);
        let errors = fit.constant_errors();
        let misses = [
            2.0 * drawn.quality * (fit.resonance_hz().value / drawn.hz - 1.0),
            fit.quality().value / drawn.quality - 1.0,
            fit.clamped.unwrap().motional_f / drawn.farad - 1.0,
        ];
        let errors = [errors.resonance, errors.quality, errors.static_ratio];
        for ((covered, miss), error) in covered.iter_mut().zip(misses).zip(errors) {
            *covered += usize::from(miss.abs() <= 2.0 * error);
            assert!(
                miss.abs() < 5.0 * error,
                "{} Hz, Q {}: {miss} ± {error}",
                drawn.hz,
                drawn.quality
            );
        }
    }
    assert!(found >= CIRCUITS - 2, "{found} of {CIRCUITS}");
    assert!(
        covered.iter().all(|n| 100 * n >= 94 * found),
        "{covered:?} of {found}"
    );
}
