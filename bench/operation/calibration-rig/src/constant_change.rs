//! Comparison of measured constants with those in force and with the configured ones.
//!
//! A constant that changed by more than its errors was measured well, or its instrument was misread: peak to peak for peak,
//! RMS for peak, another gain, another unit, the other sign.

use config::{CalibrationFile, Config, MeasuredForce, Quantity};
use metrology::volts::UnitSlip;
use statistics::significant;

use crate::judged::Part;

/// Smallest relative change from the constant in force that is questioned: temperature and handling cause less.
const CHANGE: f64 = 0.02;
/// Smallest change from the configured constant that is questioned, as a natural logarithm: it is often a guess.
const DIFFERENCE: f64 = 0.3;
/// Largest relative difference between a ratio and a familiar one.
const FAMILIAR: f64 = 0.03;

/// Familiar ratios of a misread constant to the right one, either way, with their causes; [`UnitSlip`] has those of a sine.
const CAUSES: [(f64, &str); 6] = [
    (10.0, "a gain or a probe of 10"),
    (20.0, "a gain of 20"),
    (100.0, "a gain of 100"),
    (256.0, "24-bit samples read as 32-bit ones"),
    (1e3, "another unit: a factor of 1000"),
    (1e6, "another unit: a factor of a million"),
];

/// Constant with which a measured one is compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Reference {
    InForce,
    Configured,
}

/// Change of a constant against the one in force, or the configured one.
#[derive(Debug, Clone, PartialEq)]
pub struct ConstantChange {
    name: String,
    reference: Reference,
    reference_value: f64,
    unit: String,
    ratio: f64,
    /// Relative 95 % error of the ratio.
    error: f64,
}

impl ConstantChange {
    /// Returns whether the change needs a decision: it exceeds its errors and the usual changes.
    #[must_use]
    pub fn is_questioned(&self) -> bool {
        let change = (self.ratio - 1.0).abs();
        let is_usual = match self.reference {
            Reference::InForce => change <= CHANGE,
            Reference::Configured => self.ratio.ln().abs() <= DIFFERENCE,
        };
        // A ratio that is not a number is questioned.
        !(is_usual || change <= self.error)
    }

    /// Returns the familiar cause of a ratio like this one.
    fn cause(&self) -> Option<String> {
        let is_close = |familiar: f64| (self.ratio / familiar - 1.0).abs() < FAMILIAR;
        if is_close(-1.0) {
            return Some("the other sign, as of an axis or a cable turned round".to_owned());
        }
        let slip = UnitSlip::from_ratio(self.ratio).map(|slip| slip.to_string());
        slip.or_else(|| {
            let mut causes = CAUSES.iter();
            let cause = causes.find(|(gain, _)| is_close(*gain) || is_close(1.0 / gain));
            cause.map(|(_, cause)| (*cause).to_owned())
        })
    }

    /// Returns the comparison in words.
    #[must_use]
    pub fn in_words(&self) -> String {
        let Self {
            name,
            ratio,
            reference_value,
            unit,
            ..
        } = self;
        let reference = match self.reference {
            Reference::InForce => "the one in force",
            Reference::Configured => "the configured one",
        };
        let cause = self.cause().filter(|_| self.is_questioned());
        let cause = cause.map_or_else(String::new, |cause| format!(": {cause}"));
        let value = significant(*reference_value);
        let unit = if unit == "1" {
            String::new()
        } else {
            format!(" {unit}")
        };
        format!("{name} is {ratio:.4} times {reference} ({value}{unit}){cause}")
    }
}

/// Returns `measured` compared with the constant `in_force`, or with the configured one if none is in force; `None` if neither
/// is known.
fn change(
    name: &str,
    measured: &Quantity,
    in_force: Option<&Quantity>,
    configured: Option<f64>,
) -> Option<ConstantChange> {
    let (reference, reference_value, reference_error) = match (in_force, configured) {
        (Some(old), _) => (Reference::InForce, old.value, old.half_width_95()),
        (None, configured) => (Reference::Configured, configured?, 0.0),
    };
    let ratio = measured.value / reference_value;
    let relative = |error: f64, value: f64| error / value.abs();
    let error = relative(measured.half_width_95(), measured.value)
        .hypot(relative(reference_error, reference_value));
    Some(ConstantChange {
        name: name.to_owned(),
        reference,
        reference_value,
        unit: measured.unit.clone(),
        ratio,
        // An unknown error excuses no change.
        error: if error.is_finite() {
            error * ratio.abs()
        } else {
            0.0
        },
    })
}

/// Returns the changes of the constants of `part` against those `in_force`, or against `configured` where none is in force.
#[must_use]
pub fn changes(
    part: &Part,
    in_force: &CalibrationFile,
    configured: &Config,
) -> Vec<ConstantChange> {
    let compared = match part {
        Part::Pickup(pickup) => vec![change(
            "the pickup's sensitivity",
            &pickup.metres_per_unit,
            in_force.pickup.as_ref().map(|old| &old.metres_per_unit),
            Some(configured.channels.pickup.metres_per_unit),
        )],
        Part::Plate { plate, .. } => vec![change(
            "the plate's force factor",
            &plate.force_factor_n_per_v,
            in_force.plate.as_ref().map(|old| &old.force_factor_n_per_v),
            Some(configured.plate.force_factor_n_per_v),
        )],
        Part::Force { force, .. } => force_changes(force, in_force.force.as_ref()),
        Part::Channels(channels) => {
            let old = in_force.channels.as_ref();
            let round_trip = old.map(|old| &old.round_trip);
            let round_trip = change(
                "the level read back",
                &channels.round_trip,
                round_trip,
                None,
            );
            let inputs = channels.inputs.iter().map(|input| {
                let gain = old.and_then(|old| old.input(input.index));
                let name = format!("the gain of input {}", input.index);
                change(&name, &input.gain, gain.map(|old| &old.gain), None)
            });
            std::iter::once(round_trip).chain(inputs).collect()
        }
        Part::Output(output) => {
            let old = in_force.output.as_ref();
            let commanded = old.map(|old| &old.per_commanded);
            let read_back = old.map(|old| &old.per_read_back);
            vec![
                change(
                    "the meter's volts per volt commanded",
                    &output.per_commanded,
                    commanded,
                    None,
                ),
                change(
                    "the meter's volts per volt read back",
                    &output.per_read_back,
                    read_back,
                    None,
                ),
            ]
        }
    };
    compared.into_iter().flatten().collect()
}

/// Returns the changes of the force sensor's sensitivities; a configured sensor reads newtons.
fn force_changes(
    force: &MeasuredForce,
    old: Option<&MeasuredForce>,
) -> Vec<Option<ConstantChange>> {
    // A tare keeps the matrix.
    if old.is_some_and(|old| old.measured == force.measured) {
        return Vec::new();
    }
    let axis = |name, sensitivity: fn(&MeasuredForce) -> &Quantity| {
        change(name, sensitivity(force), old.map(sensitivity), Some(1.0))
    };
    vec![
        axis("the normal axis' sensitivity", |force| {
            &force.normal_per_normal
        }),
        axis("the lateral axis' sensitivity", |force| {
            &force.lateral_per_lateral
        }),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sensitivity(value: f64) -> Quantity {
        Quantity::new(value, 2e-3 * value.abs(), 30, "m")
    }

    fn against_the_one_in_force(ratio: f64) -> ConstantChange {
        let old = sensitivity(4e-6);
        change("it", &sensitivity(4e-6 * ratio), Some(&old), Some(1.0)).unwrap()
    }

    #[test]
    fn a_change_beyond_its_errors_is_questioned_and_its_ratio_explained() {
        for ratio in [1.0, 1.015, 0.99] {
            assert!(!against_the_one_in_force(ratio).is_questioned(), "{ratio}");
        }
        for (ratio, cause) in [
            (1.05, ""),
            (2.01, "peak to peak"),
            (0.707, "RMS"),
            (10.1, "gain or a probe of 10"),
            (0.05, "gain of 20"),
            (1.0 / 256.0, "24-bit"),
            (1e-3, "unit"),
            (-1.0, "sign"),
            (f64::NAN, ""),
        ] {
            let change = against_the_one_in_force(ratio);
            assert!(change.is_questioned(), "{ratio}");
            assert!(change.in_words().contains(cause), "{}", change.in_words());
        }
    }

    #[test]
    fn a_configured_constant_is_a_guess() {
        let questioned = |ratio: f64| {
            let change = change("it", &sensitivity(5e-6 * ratio), None, Some(5e-6));
            change.unwrap().is_questioned()
        };
        for ratio in [0.8, 1.25, 1.01] {
            assert!(!questioned(ratio), "{ratio}");
        }
        for ratio in [2.0, 0.707, -1.0, 1e-3] {
            assert!(questioned(ratio), "{ratio}");
        }
    }

    #[test]
    fn a_change_within_large_errors_is_not_questioned() {
        let coarse = |value| Quantity::new(value, 0.2 * value, 30, "m");
        let change = change("it", &coarse(1.2), Some(&coarse(1.0)), None);
        assert!(!change.unwrap().is_questioned());
    }
}
