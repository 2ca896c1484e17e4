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
use rand::SeedableRng;
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

#[test]
fn explore() {
    let show = |name: &str, fit: &SweepFit| {
        println!(
            "{name}: f0 {:?} Q {:?} phase {:?} errors {:?} residual {} band {:?} clamped {:?}",
            fit.resonance_hz(),
            fit.quality(),
            fit.phase_rad(),
            fit.constant_errors(),
            fit.residual(),
            fit.band(),
            fit.clamped
        );
        println!("   others {:?}\n   notes {:?}", fit.others, fit.notes());
    };
    show("bar", &fit_of(BAR));
    for (q, n) in [(20.0, 201), (100.0, 201), (250.0, 401), (1000.0, 2001)] {
        let circuit = Circuit::one(35_162.0, q);
        let rows = circuit.sweep(&linear(30e3, 40e3, n));
        let text = table(
            "f (Hz),G (S),B (S)",
            ",",
            rows.iter().map(|(f, y)| [*f, y.re, y.im]),
        );
        show(&format!("one {q}"), &fit_of(&text));
        let text = table(
            "f (kHz)\t|Z| (kOhm)\tTheta (deg)",
            "\t",
            rows.iter().rev().map(|(f, y)| {
                let z = y.inv();
                [f / 1e3, z.norm() / 1e3, z.arg().to_degrees()]
            }),
        );
        show(&format!("Z {q}"), &fit_of(&text));
        let text = table("f,G,B", ",", rows.iter().map(|(f, y)| [*f, y.re, -y.im]));
        show(&format!("conj {q}"), &fit_of(&text));
    }
}
