//! Verdict on the response under a finger, compared with the bare plate's; its storage and figure.

use std::f64::consts::PI;
use std::fmt::Write as _;

use crate::plate_procedure::PlateProcedure;
use anyhow::bail;
use calibration_rig::judged::{Calibrates, Judged, Part, SideFile};
use config::{MeasuredFinger, MeasuredPlate, Provenance, Quantity};
use jiff::Timestamp;
use metrology::plate_fit::{CHANNEL_MATCH, PlateFit};
use num_complex::Complex64;
use plotting::{Figure, Ink, Marker, Series};
use statistics::with_error;

use crate::survey::finger_procedure::FingerProcedure;

/// Admittance of the plate, bare and under the finger, at one frequency, m/s/N.
struct Pair {
    frequency_hz: f64,
    bare: Complex64,
    loaded: Complex64,
}

impl Calibrates for FingerProcedure {
    const NAME: &'static str = PlateProcedure::NAME;
    const DRIVES_A_FINGER: bool = true;

    fn judge_review(&self) -> anyhow::Result<Judged> {
        // The finger comes after the review of the bare plate.
        self.bare.judge_review()
    }

    fn judge(&self, date: Timestamp, operator: &str) -> anyhow::Result<Judged> {
        let mut judged = self.bare.judge(date, operator)?;
        let Part::Plate { plate, profile, .. } = judged.part else {
            bail!("the bare plate was not measured");
        };
        let pairs = self.pairs(&plate);
        let finger = self.finger(date, operator);
        judged
            .values
            .push(("finger's force", finger.normal_n.clone()));
        judged.remarks.push(format!(
            "under a finger   {} N, {:.1} V{}",
            with_error(finger.normal_n.value, finger.normal_spread_n, 2),
            finger.drive_v,
            shift(&finger, &plate),
        ));
        judged.side_files.push(SideFile {
            stem: "plate-finger",
            table: csv(&pairs),
            figure: None,
        });
        if let Some(figure) = &mut judged.figure {
            draw(figure, &pairs, &finger);
        }
        judged.part = Part::Plate {
            plate,
            finger: Some(Box::new(finger)),
            profile,
            across: None,
        };
        Ok(judged)
    }
}

impl FingerProcedure {
    fn pairs(&self, plate: &MeasuredPlate) -> Vec<Pair> {
        let bare = self.bare.inner();
        let pairs = bare.responses.iter().zip(&self.responses);
        pairs
            .map(|(bare_at, loaded_at)| {
                let frequency_hz = bare_at.frequency_hz;
                let scale = bare.admittance_per_ratio(plate, frequency_hz);
                Pair {
                    frequency_hz,
                    bare: bare_at.ratio * scale,
                    loaded: loaded_at.ratio * scale,
                }
            })
            .collect()
    }

    fn finger(&self, date: Timestamp, operator: &str) -> MeasuredFinger {
        let force = self.force;
        // The response under a finger may not have a single resonance; the table shows it in any case.
        let fit = PlateFit::fit(&self.responses, CHANNEL_MATCH).ok();
        let quantity = |parameter: fn(&PlateFit) -> metrology::FittedValue, unit| {
            let fit = fit.as_ref()?;
            let value = parameter(fit);
            let n = fit.degrees_of_freedom;
            Some(Quantity::new(value.value, value.standard_error, n, unit))
        };
        MeasuredFinger {
            measured: Provenance {
                date,
                operator: operator.to_owned(),
                method: format!(
                    "the tones of the bare plate, {} of them, with a finger resting on it; for comparison alone",
                    self.responses.len()
                ),
            },
            normal_n: Quantity::new(force.mean_n, force.error_n, force.degrees_of_freedom, "N"),
            normal_spread_n: force.spread_n,
            drive_v: self.level_v,
            resonance_hz: quantity(|fit| fit.resonance_hz, "Hz"),
            quality: quantity(|fit| fit.quality, "1"),
        }
    }
}

/// Returns the change of resonance and quality factor as text; empty if the response under the finger has no single resonance.
fn shift(finger: &MeasuredFinger, plate: &MeasuredPlate) -> String {
    match (&finger.resonance_hz, &finger.quality) {
        (Some(resonance_hz), Some(quality)) => format!(
            ": resonance {:+.1} Hz, Q {:.0}",
            resonance_hz.value - plate.resonance_hz.value,
            quality.value
        ),
        _ => String::new(),
    }
}

/// Returns both admittances, and the added impedance of the finger, as CSV.
fn csv(pairs: &[Pair]) -> String {
    let mut text = String::from(
        "frequency_hz,re_bare_m_per_s_per_n,im_bare_m_per_s_per_n,re_finger_m_per_s_per_n,im_finger_m_per_s_per_n,\
         re_added_n_s_per_m,im_added_n_s_per_m\n",
    );
    for pair in pairs {
        let added = pair.loaded.inv() - pair.bare.inv();
        let _ = writeln!(
            text,
            "{},{},{},{},{},{},{}",
            pair.frequency_hz,
            pair.bare.re,
            pair.bare.im,
            pair.loaded.re,
            pair.loaded.im,
            added.re,
            added.im
        );
    }
    text
}

/// Draws the response under the finger next to the bare one.
fn draw(figure: &mut Figure, pairs: &[Pair], finger: &MeasuredFinger) {
    let over_frequency = |value: &dyn Fn(&Pair) -> f64| -> Vec<(f64, f64)> {
        let points = pairs.iter();
        points
            .map(|pair| (pair.frequency_hz * 1e-3, value(pair)))
            .collect()
    };
    let values: [&dyn Fn(&Pair) -> f64; 2] = [&|pair| pair.loaded.norm(), &|pair| {
        pair.loaded.arg() * 180.0 / PI
    }];
    for (panel, value) in figure.panels.iter_mut().zip(values) {
        let series = Series::points(Ink::Blue, Marker::Disc, over_frequency(value));
        panel.series.push(series.with_name("under a finger"));
    }
    figure.title = "Admittance of the plate, bare and under a finger".to_owned();
    figure.caption += &format!(
        " Discs: the same tones at {:.1} V with a finger resting on the plate, {} N (mean and standard deviation).",
        finger.drive_v,
        with_error(finger.normal_n.value, finger.normal_spread_n, 2)
    );
}
