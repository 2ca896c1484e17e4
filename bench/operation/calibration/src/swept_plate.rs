//! `calibrate plate --from`: the plate's constants from a sweep measured elsewhere.

use std::f64::consts::{FRAC_PI_2, TAU};
use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use calibration_rig::calibration_figures as figures;
use calibration_rig::judged::{Judged, Part};
use calibration_rig::points::{Admittance, signed};
use clap::Args;
use config::{CalibrationFile, Config, Provenance, Quantity, SweepOrigin, sha256};
use metrology::FittedValue;
use num_complex::Complex64;
use plate_sweep::{
    ColumnChoice, FurtherMode, ModalScale, Sweep, SweepFit, SweptConstants, SweptQuantity, text_of,
};

use crate::plate_limits::FitResults;
use crate::plate_procedure::admittance_csv;
use crate::rejected_result::{RejectedResult, in_words};

/// Largest file of a sweep, bytes.
const LARGEST_BYTES: u64 = 64 << 20;
/// Largest relative difference of a modal mass from that of `bench.toml` that is a matter of rounding.
const SAME_MASS: f64 = 0.01;
/// Standard error of the pickup's phase where it was never measured, rad: the largest that a recording may state.
const UNKNOWN_PHASE_RAD: f64 = 0.5;
/// Ratios of a resonance to the configured one that a unit of frequency explains, and their relative tolerance.
const UNIT_RATIOS: [(f64, &str); 3] = [(1e3, "kHz"), (1e6, "MHz"), (TAU, "rad/s")];
const UNIT_TOLERANCE: f64 = 0.01;
/// Distance, in bandwidths, and share of the peak from which another resonance disturbs.
const NEAR_BANDWIDTHS: f64 = 5.0;
const NEAR_SHARE: f64 = 0.1;

/// Options of a sweep measured elsewhere.
#[derive(Debug, Args)]
#[command(next_help_heading = "A sweep measured elsewhere")]
pub struct SweepOptions {
    /// Take the constants from this sweep of an impedance analyser or a vibrometer: a table of text with a frequency and two parts
    /// of the response in each row; no device is opened.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["finger", "along", "across", "drive_v"])]
    pub from: Option<PathBuf>,
    /// Columns of frequency, then real and imaginary part or magnitude and phase.
    #[arg(
        long,
        value_name = "F,A,B",
        requires = "from",
        help = "Columns of frequency, then real and imaginary part or magnitude and phase, by heading or by number from 0, with \
                units in brackets where the file states none, as in f,G,B or \"f[kHz],mag[dB],phase[deg]\" [default: those that \
                the header shows]"
    )]
    pub columns: Option<ColumnChoice>,
    /// Swept quantity: admittance or impedance of the actuators, displacement or velocity over their voltage [default: that
    /// of the header].
    #[arg(long, requires = "from")]
    pub quantity: Option<SweptQuantity>,
    /// Modal mass that gives the force factor, kg [default: plate.modal_mass_kg of bench.toml].
    #[arg(long = "modal-mass", value_name = "KG", requires = "from")]
    pub modal_mass_kg: Option<f64>,
    /// Force factor that gives the modal mass instead, N/V.
    #[arg(
        long = "force-factor",
        value_name = "N_PER_V",
        requires = "from",
        conflicts_with = "modal_mass_kg"
    )]
    pub force_factor_n_per_v: Option<f64>,
}

/// Source of the scale of the mode.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum ScaleSource {
    Configured,
    ModalMass,
    ForceFactor,
}

/// A plate swept elsewhere, on the bench of a configuration.
#[derive(Debug)]
pub struct SweptPlate {
    sweep: Sweep,
    fit: SweepFit,
    origin: SweepOrigin,
    scale: ModalScale,
    source: ScaleSource,
    pickup_phase_rad: Quantity,
    is_phase_known: bool,
    before_hz: Option<f64>,
    config: Config,
}

impl SweptPlate {
    /// Reads and fits the sweep of `options`; `calibration` is the present one, and `config` the bench with its constants.
    ///
    /// # Errors
    /// The file cannot be read, or has no resonance.
    pub fn read(
        path: &Path,
        options: &SweepOptions,
        about_hz: Option<f64>,
        config: &Config,
        calibration: &CalibrationFile,
    ) -> anyhow::Result<Self> {
        let file = path.display();
        let bytes = bounded_files::read(path, LARGEST_BYTES).map_err(|error| {
            anyhow::anyhow!("cannot read {file}: {}", bounded_files::cause(&error))
        })?;
        let sweep = Sweep::read(&text_of(&bytes), options.columns.as_ref(), options.quantity)
            .with_context(|| file.to_string())?;
        let fit = SweepFit::new(&sweep, about_hz).with_context(|| file.to_string())?;
        let exact = |value: f64, option: &str| {
            if !(value > 0.0 && value.is_finite()) {
                bail!("{option} = {value} is not a positive number");
            }
            Ok(FittedValue {
                value,
                standard_error: 0.0,
            })
        };
        let (scale, source) = match (options.modal_mass_kg, options.force_factor_n_per_v) {
            (None, None) => {
                let value = config.plate.modal_mass_kg;
                let standard_error = value * config.plate.modal_mass_relative_error;
                let mass = FittedValue {
                    value,
                    standard_error,
                };
                (ModalScale::ModalMass(mass), ScaleSource::Configured)
            }
            (Some(mass_kg), _) => {
                let mass = exact(mass_kg, "--modal-mass")?;
                (ModalScale::ModalMass(mass), ScaleSource::ModalMass)
            }
            (None, Some(force_factor)) => {
                let force_factor = exact(force_factor, "--force-factor")?;
                (
                    ModalScale::ForceFactor(force_factor),
                    ScaleSource::ForceFactor,
                )
            }
        };
        let plate_phase = calibration
            .plate
            .as_ref()
            .map(|plate| &plate.pickup_phase_rad);
        let pickup_phase = calibration
            .pickup
            .as_ref()
            .and_then(|pickup| pickup.phase_rad.as_ref());
        let known_phase = plate_phase.or(pickup_phase);
        let configured_rad = config.channels.pickup.phase_rad;
        Ok(Self {
            origin: SweepOrigin {
                file: path
                    .file_name()
                    .unwrap_or_default()
                    .to_string_lossy()
                    .into_owned(),
                sha256: sha256(&bytes),
                columns: sweep.columns().to_owned(),
                quantity: sweep.quantity().to_string(),
                conjugate: fit.is_conjugate,
            },
            is_phase_known: known_phase.is_some(),
            pickup_phase_rad: known_phase
                .cloned()
                .unwrap_or_else(|| Quantity::new(configured_rad, UNKNOWN_PHASE_RAD, 1, "rad")),
            before_hz: calibration
                .plate
                .as_ref()
                .map(|plate| plate.resonance_hz.value),
            sweep,
            fit,
            scale,
            source,
            config: config.clone(),
        })
    }

    /// Judges the sweep, read on `date` by `operator`.
    #[must_use]
    pub fn judge(&self, date: jiff::Timestamp, operator: &str) -> Judged {
        let constants = self.fit.constants(self.scale);
        let plate = self.measured_plate(&constants, date, operator);
        let points: Vec<Admittance> = self
            .fit
            .admittances(&constants)
            .into_iter()
            .map(|(frequency_hz, [measured, fitted])| Admittance {
                frequency_hz,
                measured,
                fitted,
            })
            .collect();
        let modal_mass = self.quantity(constants.modal_mass_kg, "kg");
        let mass = (self.source == ScaleSource::ForceFactor).then_some(("modal mass", modal_mass));
        Judged {
            values: [
                ("resonance", plate.resonance_hz.clone()),
                ("quality", plate.quality.clone()),
                ("damping", plate.damping_n_s_per_m.clone()),
                ("stiffness", plate.stiffness_n_per_m.clone()),
                ("force factor", plate.force_factor_n_per_v.clone()),
            ]
            .into_iter()
            .chain(mass)
            .collect(),
            remarks: self.remarks(&plate),
            faults: in_words(&self.faults(&plate, &constants)),
            stem: "plate",
            table: admittance_csv(&points),
            figure: Some(figures::plate(&points, &plate)),
            side_files: Vec::new(),
            part: Part::Plate {
                plate: Box::new(plate),
                finger: None,
                profile: None,
                across: None,
            },
        }
    }

    fn quantity(&self, fitted: FittedValue, unit: &str) -> Quantity {
        let freedom = self.fit.degrees_of_freedom();
        Quantity::new(fitted.value, fitted.standard_error, freedom, unit)
    }

    fn measured_plate(
        &self,
        constants: &SweptConstants,
        date: jiff::Timestamp,
        operator: &str,
    ) -> config::MeasuredPlate {
        let channels = &self.config.channels;
        let (resonance, quality) = (self.fit.resonance_hz(), self.fit.quality());
        // The sweep's hertz are those of its instrument, and the bench's those of its card.
        let clock = 1e-6 * self.config.calibration.clock_ppm * resonance.value;
        let freedom = self.fit.degrees_of_freedom();
        let metres_per_unit = channels.pickup.metres_per_unit;
        let peak =
            constants.displacement_m_per_v.value * quality.value * channels.drive.volts_per_unit
                / metres_per_unit;
        let unloaded = Complex64::from_polar(peak, -self.pickup_phase_rad.value - FRAC_PI_2);
        let (count, [from_hz, to_hz]) = self.fit.band();
        config::MeasuredPlate {
            measured: Provenance {
                date,
                operator: operator.to_owned(),
                method: format!(
                    "sweep of the {} measured elsewhere ({}, SHA-256 {}…, columns {}): {count} frequencies from {from_hz:.0} to {to_hz:.0} Hz; least squares of a second-order mode with {}; errors hold scatter, model and {} ppm of the clocks; {}; the pickup's phase is not measured by it",
                    self.origin.quantity,
                    self.origin.file,
                    &self.origin.sha256[..12.min(self.origin.sha256.len())],
                    self.origin.columns,
                    if self.sweep.quantity().is_electrical() {
                        "the clamped capacitance"
                    } else {
                        "residual terms"
                    },
                    self.config.calibration.clock_ppm,
                    match self.source {
                        ScaleSource::Configured => "force factor by the modal mass of bench.toml",
                        ScaleSource::ModalMass => "force factor by --modal-mass",
                        ScaleSource::ForceFactor => "modal mass by --force-factor",
                    }
                ),
            },
            resonance_hz: Quantity::of_parts(
                resonance.value,
                resonance.standard_error.hypot(clock),
                &[(resonance.standard_error, freedom)],
                "Hz",
            ),
            quality: self.quantity(quality, "1"),
            damping_n_s_per_m: self.quantity(constants.damping_n_s_per_m, "N·s/m"),
            stiffness_n_per_m: self.quantity(constants.stiffness_n_per_m, "N/m"),
            force_factor_n_per_v: self.quantity(constants.force_factor_n_per_v, "N/V"),
            pickup_phase_rad: self.pickup_phase_rad.clone(),
            force_phase_rad: None,
            unloaded_ratio: [unloaded.re, unloaded.im],
            residual: self.fit.residual(),
            drift_hz: self.drift_hz(),
            metres_per_unit,
            sweep: Some(self.origin.clone()),
        }
    }

    fn drift_hz(&self) -> Option<f64> {
        self.before_hz
            .map(|before_hz| self.fit.resonance_hz().value - before_hz)
    }

    /// Returns the results in addition to the constants, a line each.
    fn remarks(&self, plate: &config::MeasuredPlate) -> Vec<String> {
        let [from_hz, to_hz] = self.sweep.range_hz();
        let (count, band) = self.fit.band();
        let mut remarks = vec![
            format!(
                "sweep            {} from {from_hz:.0} to {to_hz:.0} Hz, columns {}; fitted with {count} frequencies from {:.0} to {:.0} Hz",
                self.origin.quantity, self.origin.columns, band[0], band[1]
            ),
            format!(
                "residual         {:.1e} of the largest response",
                plate.residual
            ),
        ];
        if let Some(clamped) = self.fit.clamped {
            remarks.push(format!(
                "capacitance      {:.4e} F clamped, loss tangent {:.4}; {:.4e} F motional",
                clamped.capacitance_f, clamped.loss_tangent, clamped.motional_f
            ));
        }
        remarks.extend(self.fit.further_modes.iter().map(mode_in_words));
        let notes = self.sweep.notes().iter().chain(self.fit.notes());
        remarks.extend(notes.map(|note| format!("WARNING          {note}")));
        if let Some(drift_hz) = plate.drift_hz {
            remarks.push(format!(
                "drift            {} Hz since the calibration before",
                signed(drift_hz, 2)
            ));
        }
        let highest_hz = 0.5 * f64::from(self.config.audio.rate_hz);
        if plate.resonance_hz.value >= highest_hz {
            remarks.push(format!(
                "WARNING          the resonance is above {highest_hz:.0} Hz, the highest frequency of a card at audio.rate_hz = {}: this bench cannot drive it; another card can, or name another mode with --about-hz",
                self.config.audio.rate_hz
            ));
        }
        if self.source == ScaleSource::Configured {
            remarks.push(format!(
                "modal mass       {} kg of bench.toml, on which the force factor, damping and stiffness stand; a sweep does not give it: state another with --modal-mass, or the force factor with --force-factor",
                self.config.plate.modal_mass_kg
            ));
        }
        let phase = if self.is_phase_known {
            "the calibration so far"
        } else {
            "bench.toml"
        };
        remarks.push(format!(
            "not measured     the pickup's sensitivity and phase, which stay as in {phase} ({:.3} rad): `friction-bench calibrate plate` on the bench measures the phase",
            plate.pickup_phase_rad.value
        ));
        remarks
    }

    /// Returns the reasons to put nothing in force.
    fn faults(
        &self,
        plate: &config::MeasuredPlate,
        constants: &SweptConstants,
    ) -> Vec<RejectedResult> {
        let resonance_hz = plate.resonance_hz.value;
        let results = FitResults {
            residual: plate.residual,
            errors: self.fit.constant_errors(),
            quality: plate.quality.value,
            drift_hz: plate.drift_hz,
        };
        let mut faults = results.faults(&self.config.calibration);
        let configured_hz = self.config.plate.resonance_hz;
        let ratio = resonance_hz / configured_hz;
        let is_close = |unit_ratio: f64| (ratio / unit_ratio).ln().abs() < UNIT_TOLERANCE;
        let unit = UNIT_RATIOS
            .iter()
            .find(|(unit_ratio, _)| is_close(*unit_ratio) || is_close(unit_ratio.recip()));
        if let Some((_, unit)) = unit {
            faults.push(RejectedResult::SweepUnit {
                resonance_hz,
                ratio,
                configured_hz,
                unit,
            });
        }
        let configured_kg = self.config.plate.modal_mass_kg;
        let mass_kg = constants.modal_mass_kg.value;
        let is_other = (mass_kg / configured_kg - 1.0).abs() > SAME_MASS;
        if self.source != ScaleSource::Configured && is_other {
            faults.push(RejectedResult::SweepMass {
                mass_kg,
                configured_kg,
            });
        }
        faults
    }
}

/// Returns another resonance in words, with a warning if it disturbs.
fn mode_in_words(mode: &FurtherMode) -> String {
    let is_near = mode.bandwidths.abs() < NEAR_BANDWIDTHS && mode.share > NEAR_SHARE;
    format!(
        "{}{:.1} Hz, Q {:.0}, {:.2} times the peak, {:+.1} bandwidths away{}",
        if is_near {
            "WARNING          another mode at "
        } else {
            "another mode     "
        },
        mode.resonance_hz,
        mode.quality,
        mode.share,
        mode.bandwidths,
        if is_near {
            ": it takes part in the plate's motion at the carrier; move supports or choose another mode"
        } else {
            ""
        }
    )
}

#[cfg(test)]
mod tests {
    use std::fmt::Write as _;

    use super::*;
    use config::{Identity, rigs};

    const HZ: f64 = 35_150.0;

    fn bench() -> (Config, CalibrationFile) {
        let config = Config::parse(rigs::MOCK_BENCH, "test").unwrap();
        let identity = Identity::from_config(&config, String::new(), String::new());
        (config, CalibrationFile::new(identity))
    }

    fn options(columns: Option<&str>) -> SweepOptions {
        SweepOptions {
            from: None,
            columns: columns.map(|text| text.parse().unwrap()),
            quantity: None,
            modal_mass_kg: None,
            force_factor_n_per_v: None,
        }
    }

    /// Velocity over volts of a mass on a spring with a damper, m/s/V, as a vibrometer exports it.
    fn sweep(mass_kg: f64, quality: f64, force_factor: f64, unit_hz: f64) -> String {
        let mut text = "Frequency,real (m/s/V),imag (m/s/V)\n".to_owned();
        for n in -60..=60 {
            let hz = HZ + 4.0 * HZ / quality * f64::from(n) / 60.0;
            let ratio = hz / HZ;
            let damper = TAU * HZ * mass_kg / quality;
            let reactance = TAU * HZ * mass_kg * (ratio - 1.0 / ratio);
            let velocity = force_factor / Complex64::new(damper, reactance);
            writeln!(text, "{},{:e},{:e}", hz / unit_hz, velocity.re, velocity.im).unwrap();
        }
        text
    }

    fn judged(text: &str, options: &SweepOptions, previous_hz: Option<f64>) -> Judged {
        let temp = tempfile::tempdir().unwrap();
        let path = temp.path().join("sweep.csv");
        std::fs::write(&path, text).unwrap();
        let (config, mut calibration) = bench();
        let read = |calibration: &CalibrationFile| {
            SweptPlate::read(&path, options, None, &config, calibration).unwrap()
        };
        let date = jiff::Timestamp::UNIX_EPOCH;
        if let Some(hz) = previous_hz {
            let Part::Plate { mut plate, .. } = read(&calibration).judge(date, "A. Tester").part
            else {
                panic!("no plate");
            };
            plate.resonance_hz.value = hz;
            plate.pickup_phase_rad = Quantity::new(0.3, 0.01, 5, "rad");
            calibration.plate = Some(*plate);
        }
        read(&calibration).judge(date, "A. Tester")
    }

    fn plate(judged: &Judged) -> &config::MeasuredPlate {
        match &judged.part {
            Part::Plate { plate, .. } => plate,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn a_sweep_becomes_the_plate_of_a_calibration() {
        let (config, _) = bench();
        let mass_kg = config.plate.modal_mass_kg;
        let text = sweep(mass_kg, 250.0, 0.12, 1.0);
        let judged = judged(&text, &options(None), Some(HZ + 20.0));
        assert!(judged.faults.is_empty(), "{:?}", judged.faults);
        let plate = plate(&judged);
        let close = |value: f64, truth: f64| (value / truth - 1.0).abs() < 1e-3;
        assert!(close(plate.resonance_hz.value, HZ) && close(plate.quality.value, 250.0));
        assert!(close(plate.force_factor_n_per_v.value, 0.12), "{plate:?}");
        assert!((plate.drift_hz.unwrap() + 20.0).abs() < 0.1);
        // The phase that no sweep measures stays.
        assert!((plate.pickup_phase_rad.value - 0.3).abs() < 1e-12);
        let origin = plate.sweep.as_ref().unwrap();
        assert_eq!(
            (origin.file.as_str(), origin.quantity.as_str()),
            ("sweep.csv", "velocity")
        );
        assert_eq!(origin.sha256, sha256(text));
        // At the resonance the velocity is γ/b_p per volt.
        let [re, im] = plate.unloaded_ratio;
        let peak_m = 0.12 / plate.damping_n_s_per_m.value / (TAU * HZ);
        let units = peak_m * config.channels.drive.volts_per_unit / plate.metres_per_unit;
        assert!(close(re.hypot(im), units), "{re} {im} {units}");
        assert!(
            judged
                .remarks
                .iter()
                .any(|remark| remark.contains("--modal-mass"))
        );
        assert_eq!(judged.table.lines().count(), 1 + 61);
    }

    #[test]
    fn a_measured_bar_passes() {
        let bar = include_str!("../../../../tests/fixtures/piezo-bar/admittance.txt");
        let judged = judged(bar, &options(Some("f,G,B")), None);
        assert!(judged.faults.is_empty(), "{:?}", judged.faults);
        assert!(
            judged
                .remarks
                .iter()
                .any(|remark| remark.starts_with("capacitance"))
        );
        assert!(
            judged
                .remarks
                .iter()
                .any(|remark| remark.contains("audio.rate_hz"))
        );
    }

    #[test]
    fn sweeps_of_other_plates_and_units_are_refused_by_name() {
        let (config, _) = bench();
        let mass_kg = config.plate.modal_mass_kg;
        let fault = |text: &str, options: &SweepOptions, previous_hz| {
            let faults = judged(text, options, previous_hz).faults;
            assert_eq!(faults.len(), 1, "{faults:?}");
            faults[0].clone()
        };
        let damped = fault(&sweep(mass_kg, 20.0, 0.12, 1.0), &options(None), None);
        assert!(
            damped.contains("Q = 20.0") && damped.contains("calibration.quality"),
            "{damped}"
        );
        let good = sweep(mass_kg, 250.0, 0.12, 1.0);
        let moved = fault(&good, &options(None), Some(HZ + 300.0));
        assert!(moved.contains("calibration.drift_hz"), "{moved}");
        let heavier = SweepOptions {
            modal_mass_kg: Some(2.0 * mass_kg),
            ..options(None)
        };
        let mass = fault(&good, &heavier, None);
        assert!(mass.contains("plate.modal_mass_kg"), "{mass}");
        let by_factor = SweepOptions {
            force_factor_n_per_v: Some(0.12),
            ..options(None)
        };
        let by_factor = judged(&good, &by_factor, None);
        assert!(by_factor.faults.is_empty(), "{:?}", by_factor.faults);
        let (name, mass) = by_factor.values.last().unwrap();
        assert!(
            *name == "modal mass" && (mass.value / mass_kg - 1.0).abs() < 1e-3,
            "{mass}"
        );
    }
}
