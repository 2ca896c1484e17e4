//! Both methods on one instance: σ_t, Z_t, τ and μ0 with their standard errors.
//!
//! ```text
//! cargo run --release -p estimation --example fit_instance
//! cargo run --release -p estimation --example fit_instance -- --write instance.csv
//! cargo run --release -p estimation --example fit_instance -- instance.csv --start-s 0 --z-p 7.01
//! ```
//!
//! Without a file, an instance is synthesised from the model and the estimates are printed next to the truth. A file has
//! the columns of [`HEADER`], evenly sampled, lead-in included.
#![expect(
    clippy::disallowed_methods,
    clippy::disallowed_types,
    reason = "a program reads files and arguments; the library beside it does not"
)]

use std::error::Error;
use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::io::{self, ErrorKind, Write as _};
use std::process::ExitCode;

use contact::{AssumedConstants, CalibrationErrors, Contact, ModelError, harmonic};
use estimation::dynamic::{self, DynamicOptions};
use estimation::paper::{self, PaperOptions};
use estimation::{FitConditions, InstanceSamples, InstanceSeries};
use num_complex::Complex64;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

const USAGE: &str = "\
usage: fit_instance [--write FILE.csv]
       fit_instance FILE.csv [--start-s S] [--carrier HZ] [--z-p RE[,IM]]

  --write FILE.csv  also write the synthesised instance
  --start-s S       time at which the instance begins; what is before it is lead-in [first time + 0.02]
  --carrier HZ      carrier frequency, Hz [35000]
  --z-p RE[,IM]     impedance of the unloaded plate, N·s/m [7.01,0]";

/// Columns of a file; Z_m plain as published, Z_m corrected for envelope dynamics.
const HEADER: &str = "time_s,re_z_m_plain_n_s_per_m,im_z_m_plain_n_s_per_m,re_z_m_corrected_n_s_per_m,\
im_z_m_corrected_n_s_per_m,amplitude_m,normal_n,mu";

/// Parameters of the synthesised finger.
struct FingerTruth {
    sigma_t_m: f64,
    z_t: Complex64,
    tau_s: f64,
    mu0: f64,
}

const TRUTH: FingerTruth = FingerTruth {
    sigma_t_m: 1.7e-6,
    z_t: Complex64::new(0.47, 3.16),
    tau_s: 1.2e-3,
    mu0: 0.8,
};
const RATE_HZ: f64 = 2000.0;
const LEAD_IN_S: f64 = 0.02;
const MODAL_MASS_KG: f64 = 0.008;
/// Standard deviation of each part of Z_m at an amplitude of 1 µm, N·s/m; it varies as 1/amplitude.
const NOISE_AT_1_UM: f64 = 0.005;
/// Standard deviation of the measured friction.
const MU_NOISE: f64 = 0.002;

/// One instance with its lead-in.
#[derive(Default)]
struct InstanceRecord {
    time_s: Vec<f64>,
    plain: Vec<Complex64>,
    corrected: Vec<Complex64>,
    amplitude_m: Vec<f64>,
    normal_n: Vec<f64>,
    mu: Vec<f64>,
}

impl InstanceRecord {
    /// 20 ms of lead-in and 60 ms of a rising amplitude, 6 Hz at 95 %; the gap follows its equilibrium with a first-order
    /// lag, integrated in small steps from rest 100 ms earlier. Impedance and friction are noisy, with the same noise in
    /// every run.
    fn synthesise(conditions: &FitConditions) -> Result<Self, ModelError> {
        let contact = Contact::new(&conditions.assumed, TRUTH.sigma_t_m)?;
        let omega = conditions.carrier_rad_per_s()?;
        let modulation = TAU * 6.0;
        let amplitude_m = |t: f64| 1.95e-6 * (1.0 + 0.95 * (modulation * t).sin());
        let normal_n = |t: f64| 0.65 * (1.0 + 0.4 * t);
        let (settling, samples, substeps) = (200, 160, 200);
        let step_s = 1.0 / RATE_HZ / f64::from(substeps);
        let first_s = -0.03 - LEAD_IN_S;
        let time_s = |i: i32, j: i32| first_s + f64::from(i) / RATE_HZ + f64::from(j) * step_s;
        let mut gap_m = contact.rest_gap_m(normal_n(time_s(-settling, 0)))?;
        let mut random = ChaCha8Rng::seed_from_u64(1);
        let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
        let mut record = Self::default();
        for i in -settling..samples {
            if i >= 0 {
                let t = time_s(i, 0);
                let (a, n) = (amplitude_m(t), normal_n(t));
                let z_c = contact.impedance_n_s_per_m(contact.stiffness_n_per_m(gap_m, a), omega);
                let noise = NOISE_AT_1_UM * (1e-6 / a) * Complex64::new(normal(), normal());
                let z_m =
                    harmonic::observed(conditions.z_p_corrected_n_s_per_m, TRUTH.z_t, z_c) + noise;
                let growth = 1.95e-6 * 0.95 * modulation * (modulation * t).cos() / a;
                record.time_s.push(t);
                record.corrected.push(z_m);
                record.plain.push(z_m + 2.0 * MODAL_MASS_KG * growth);
                record.amplitude_m.push(a);
                record.normal_n.push(n);
                record.mu.push(
                    (TRUTH.mu0 * contact.friction_ratio(gap_m, n) + MU_NOISE * normal()).abs(),
                );
            }
            for j in 0..substeps {
                // Midpoint rule.
                let slope = |t: f64, gap_m: f64| -> Result<f64, ModelError> {
                    let equilibrium_m = contact.equilibrium_gap_m(amplitude_m(t), normal_n(t))?;
                    Ok((equilibrium_m - gap_m) / TRUTH.tau_s)
                };
                let t = time_s(i, j);
                let half_m = gap_m + 0.5 * step_s * slope(t, gap_m)?;
                gap_m += step_s * slope(t + 0.5 * step_s, half_m)?;
            }
        }
        Ok(record)
    }

    fn from_csv(text: &str) -> Result<Self, String> {
        let mut lines = text.lines();
        let header = lines.next().unwrap_or_default();
        if header != HEADER {
            return Err(format!("the header is {header:?}, expected {HEADER:?}"));
        }
        let mut record = Self::default();
        for (number, line) in (2..).zip(lines) {
            let cells: Result<Vec<f64>, _> = line.split(',').map(str::parse).collect();
            let cells = cells.map_err(|error| format!("line {number}: {error}"))?;
            let &[time_s, p_re, p_im, c_re, c_im, amplitude_m, normal_n, mu] = cells.as_slice()
            else {
                return Err(format!(
                    "line {number} has {} cells, expected 8",
                    cells.len()
                ));
            };
            record.time_s.push(time_s);
            record.plain.push(Complex64::new(p_re, p_im));
            record.corrected.push(Complex64::new(c_re, c_im));
            record.amplitude_m.push(amplitude_m);
            record.normal_n.push(normal_n);
            record.mu.push(mu);
        }
        Ok(record)
    }

    fn to_csv(&self) -> String {
        let mut text = format!("{HEADER}\n");
        for i in 0..self.time_s.len() {
            let (plain, corrected) = (self.plain[i], self.corrected[i]);
            let (a, n, mu) = (self.amplitude_m[i], self.normal_n[i], self.mu[i]);
            // Writing to a string does not fail.
            let _ = writeln!(
                text,
                "{},{},{},{},{},{a},{n},{mu}",
                self.time_s[i], plain.re, plain.im, corrected.re, corrected.im
            );
        }
        text
    }

    fn series(&self, start_s: f64) -> Result<InstanceSeries<'_>, estimation::FitError> {
        let start = self.time_s.partition_point(|t| *t < start_s - 1e-9);
        let samples = InstanceSamples {
            time_s: &self.time_s,
            z_m_plain_n_s_per_m: &self.plain,
            z_m_corrected_n_s_per_m: &self.corrected,
            amplitude_m: &self.amplitude_m,
            normal_n: &self.normal_n,
            mu: &self.mu,
        };
        InstanceSeries::new(samples, start)
    }
}

/// Arguments of the command line.
struct Arguments {
    file: Option<String>,
    write: Option<String>,
    start_s: Option<f64>,
    conditions: FitConditions,
}

fn parse(mut arguments: impl Iterator<Item = String>) -> Result<Arguments, String> {
    let (mut file, mut write, mut start_s) = (None, None, None);
    let (mut carrier_hz, mut z_p) = (35_000.0, Complex64::new(7.01, 0.0));
    while let Some(argument) = arguments.next() {
        if !argument.starts_with("--") && file.is_none() {
            file = Some(argument);
            continue;
        }
        let mut value = || {
            let next = arguments.next();
            next.ok_or_else(|| format!("{argument} needs a value"))
        };
        let number = |text: &str| {
            let parsed = text.parse::<f64>();
            parsed.map_err(|_| format!("{argument} {text:?} is not a number"))
        };
        match argument.as_str() {
            "--write" => write = Some(value()?),
            "--start-s" => start_s = Some(number(&value()?)?),
            "--carrier" => carrier_hz = number(&value()?)?,
            "--z-p" => {
                let text = value()?;
                let (re, im) = text.split_once(',').unwrap_or((&text, "0"));
                z_p = Complex64::new(number(re)?, number(im)?);
            }
            _ => return Err(format!("unexpected argument {argument:?}")),
        }
    }
    if file.is_some() && write.is_some() {
        return Err("--write writes the synthesised instance: leave out the file".to_owned());
    }
    Ok(Arguments {
        file,
        write,
        start_s,
        conditions: FitConditions {
            assumed: AssumedConstants::ESTIMATION,
            carrier_hz,
            z_p_plain_n_s_per_m: z_p,
            z_p_corrected_n_s_per_m: z_p,
            calibration: CalibrationErrors::default(),
            assumed_errors: CalibrationErrors::default(),
            mode_across: None,
        },
    })
}

fn report(arguments: &Arguments) -> Result<String, Box<dyn Error>> {
    let conditions = &arguments.conditions;
    let record = match &arguments.file {
        None => InstanceRecord::synthesise(conditions)?,
        Some(file) => {
            let file_error = |error: &dyn std::fmt::Display| format!("{file}: {error}");
            let text = std::fs::read_to_string(file).map_err(|error| file_error(&error))?;
            InstanceRecord::from_csv(&text).map_err(|error| file_error(&error))?
        }
    };
    if let Some(file) = &arguments.write {
        std::fs::write(file, record.to_csv()).map_err(|error| format!("{file}: {error}"))?;
    }
    let first_s = record.time_s.first().copied().unwrap_or_default();
    let series = record.series(arguments.start_s.unwrap_or(first_s + LEAD_IN_S))?;
    let paper = paper::fit(&series, conditions, &PaperOptions::default())?;
    let dynamic = dynamic::fit(&series, conditions, &DynamicOptions::default())?;

    let estimate = |value: f64, error: f64| statistics::with_error(value, error, 4);
    let truth = arguments.file.is_none().then_some(&TRUTH);
    let mut text = String::new();
    let mut row = |name: &str, truth: Option<f64>, paper: String, dynamic: String| {
        let truth = truth.map_or(String::new(), |truth| format!("{truth:.4}"));
        // Writing to a string does not fail.
        let _ = writeln!(text, "{name:<14} {truth:>8} {paper:>20} {dynamic:>20}");
    };
    row("", None, "paper".to_owned(), "dynamic".to_owned());
    row(
        "sigma_t, um",
        truth.map(|t| t.sigma_t_m * 1e6),
        estimate(paper.sigma_t_m * 1e6, paper.sigma_t_std_m * 1e6),
        estimate(dynamic.sigma_t_m * 1e6, dynamic.sigma_t_std_m * 1e6),
    );
    row(
        "Re Z_t, N s/m",
        truth.map(|t| t.z_t.re),
        estimate(paper.z_t_n_s_per_m.re, paper.z_t_std_n_s_per_m.re),
        estimate(dynamic.z_t_n_s_per_m.re, dynamic.z_t_std_n_s_per_m.re),
    );
    row(
        "Im Z_t, N s/m",
        truth.map(|t| t.z_t.im),
        estimate(paper.z_t_n_s_per_m.im, paper.z_t_std_n_s_per_m.im),
        estimate(dynamic.z_t_n_s_per_m.im, dynamic.z_t_std_n_s_per_m.im),
    );
    row(
        "tau, ms",
        truth.map(|t| t.tau_s * 1e3),
        "0, by assumption".to_owned(),
        estimate(dynamic.tau_s * 1e3, dynamic.tau_std_s * 1e3),
    );
    row(
        "mu0",
        truth.map(|t| t.mu0),
        estimate(paper.mu0, paper.mu0_std),
        estimate(dynamic.mu0, dynamic.mu0_std),
    );
    row(
        "RMS error mu",
        None,
        format!("{:.4}", paper.agreement.rms_mu),
        format!("{:.4}", dynamic.agreement.rms_mu),
    );
    row(
        "verdict",
        None,
        paper.verdict.to_string(),
        dynamic.verdict.to_string(),
    );
    Ok(text)
}

fn main() -> ExitCode {
    // Standard error may be closed.
    let print_error = |error: &dyn std::fmt::Display| {
        let _ = writeln!(io::stderr(), "fit_instance: {error}");
    };
    let arguments = match parse(std::env::args().skip(1)) {
        Ok(arguments) => arguments,
        Err(error) => {
            print_error(&format!("{error}\n\n{USAGE}"));
            return ExitCode::from(2);
        }
    };
    match report(&arguments) {
        Ok(text) => match io::stdout().write_all(text.as_bytes()) {
            // A reader such as `head` may close the pipe early.
            Err(error) if error.kind() != ErrorKind::BrokenPipe => {
                print_error(&error);
                ExitCode::FAILURE
            }
            _ => ExitCode::SUCCESS,
        },
        Err(error) => {
            print_error(&error);
            ExitCode::FAILURE
        }
    }
}
