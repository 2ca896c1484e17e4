//! Plausibility of readings: forces that no finger makes, and channels read at a fraction of their scale.
//!
//! A recording made elsewhere may contain millinewtons under `normal_n`, or the sensor's own sign. The estimates would be wrong
//! by that factor, and some of them would still converge.

mod motion;
mod plate;
mod tone;

use force_alignment::TellingFactor;
use recording::ForceRow;
use statistics::significant;

pub use motion::{Slide, lateral_sign, positions};
pub use plate::{Quantity, envelopes, pickup_quantity, plate_scale};
pub use tone::without_carrier;

/// Largest force of a finger, N; the bench's own limit is 20 N.
const LARGEST_N: f64 = 20.0;
/// Smallest force of a finger that touches, N.
const SMALLEST_N: f64 = 1e-3;
/// Usual forces of a sliding finger, N, by which a unit is recognised.
const USUAL_N: [f64; 2] = [0.05, 5.0];
/// Smallest and largest ratio of the lateral to the normal force of a finger that slides over a plate at rest.
const FRICTION: [f64; 2] = [0.1, 5.0];
/// Smallest and largest ratio beyond which no friction has a meaning.
const ANY_FRICTION: [f64; 2] = [0.02, 20.0];
/// Largest zero of a sensor, N, three times that with which a session may begin.
const LARGEST_ZERO_N: f64 = 0.15;
/// Smallest and largest contact area of a finger pad, m²: two and a half standard deviations about the median of 164 mm².
const CONTACT_AREA_M2: [f64; 2] = [45e-6, 600e-6];
/// The median, m², and the factor of a force beyond which no estimate has a meaning; the area that fits grows with its cube.
const USUAL_AREA_M2: f64 = 164e-6;
const GREATEST_FORCE_FACTOR: f64 = 2.0;
/// Fewest readings from which a force is judged.
const FEWEST: usize = 50;
/// Share of the readings beyond the quantile that stands for the pressing finger.
const TAIL: f64 = 0.1;
/// Ratio of the pull to the push above which the normal force has the other sign.
const OPPOSITE: f64 = 5.0;
/// Largest distance of a carrier from the plate's resonance, relative; at Q = 200 the plate moves a quarter as far there.
const CARRIER_DISTANCE: f64 = 0.01;
/// Share of full scale that 24-bit samples reach if they are read as 32-bit ones.
const SMALL_SHARE: f32 = 1.0 / 256.0;

/// Units in which a force may be given in place of newtons: newtons per unit, name, and remedy.
const UNITS: [(f64, &str, &str); 6] = [
    (1e-3, "millinewtons", "divide by 1000"),
    (9.806_65e-3, "grams", "multiply by 0.00980665"),
    (1e-6, "micronewtons", "divide by 1000000"),
    (9.806_65e-6, "milligrams", "multiply by 0.00000980665"),
    (1e3, "kilonewtons", "multiply by 1000"),
    (1e6, "meganewtons", "multiply by 1000000"),
];

/// Value of a column in a row.
type Column = fn(&ForceRow) -> f64;

/// Reading that no finger and no sound channel makes.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Implausible {
    /// The normal force is too large or too small.
    #[error(
        "force.csv: normal_n reads {} N while the finger slides, {} any finger's: {}",
        significant(*normal_n),
        if *normal_n > LARGEST_N { "more than" } else { "less than" },
        unit_remedy(*normal_n)
    )]
    Size {
        /// Size of the force at the 90th percentile, N.
        normal_n: f64,
    },
    /// The normal force is negative while the finger presses.
    #[error(
        "force.csv: normal_n is negative while the finger presses ({} N): it has the sensor's sign; multiply it by -1",
        significant(*normal_n)
    )]
    Sign {
        /// Force at the 10th percentile, N.
        normal_n: f64,
    },
    /// A column has one value throughout.
    #[error(
        "force.csv: {column} is {value} in each of {rows} rows: the sensor sent nothing new, or the column was filled in; \
         look at its cable and at the program that wrote the file"
    )]
    Constant {
        /// Name of the column.
        column: &'static str,
        /// Its value.
        value: f64,
        /// Number of rows.
        rows: usize,
    },
    /// The lateral force does not fit the normal force.
    #[error(
        "force.csv: lateral_n is {} times normal_n while the finger slides, and friction is {} to {}: look at the units and the \
         gains of both columns",
        significant(*ratio), FRICTION[0], FRICTION[1]
    )]
    Friction {
        /// Ratio of the lateral to the normal force.
        ratio: f64,
    },
    /// The carrier is far from the plate's resonance.
    #[error(
        "carrier_hz = {carrier_hz:.0} is {:.0} Hz from resonance_hz = {resonance_hz:.0}: the plate hardly moves there, so its \
         impedance is uncertain and amplitudes are small",
        (carrier_hz - resonance_hz).abs()
    )]
    Carrier {
        /// Carrier, Hz.
        carrier_hz: f64,
        /// Stated resonance of the plate, Hz.
        resonance_hz: f64,
    },
    /// A channel uses a small part of its range.
    #[error(
        "signals.wav: the {channel} never exceeds 1/{:.0} of full scale: 24-bit samples that were read as 32-bit ones \
         (multiply them by 256), or an input with too little gain",
        1.0 / level
    )]
    SmallShare {
        /// Name of the channel.
        channel: String,
        /// Largest |sample|, as a share of full scale.
        level: f32,
    },
    /// The normal force is far from zero without a finger.
    #[error(
        "force.csv: normal_n reads {} N in the intervals without a finger: it is untared, subtract that reading; or something \
         rested on the plate",
        significant(*normal_n)
    )]
    Untared {
        /// Median without a finger, N.
        normal_n: f64,
    },
    /// The columns of normal and lateral force are exchanged.
    #[error(
        "force.csv: normal_n follows the modulation, by {:.0} % of its mean, and lateral_n by {:.0} %, but the film modulates \
         friction: the columns are exchanged; exchange their names",
        normal * 100.0, lateral * 100.0
    )]
    Exchanged {
        /// Modulated share of the column `normal_n`.
        normal: f64,
        /// Modulated share of the column `lateral_n`.
        lateral: f64,
    },
    /// The lateral force has the other sign.
    #[error(
        "force.csv: lateral_n is negative while the finger slides towards growing positions: it has the sensor's sign; multiply it \
         by -1 (friction is taken by its size, so that the estimates remain)"
    )]
    LateralSign,
    /// The forces come late or early.
    #[error(
        "force.csv: the forces come {:.1} ± {:.1} ms {} against drive and pickup, as contact and friction show; analysed with their \
         times corrected: add {:+.4} s to time_s, and look for a trigger or a filter in the path of the sensor",
        late_s.abs() * 1e3, half_width95_s * 1e3, if *late_s > 0.0 { "late" } else { "early" }, -late_s
    )]
    ForcesLate {
        /// Delay, s.
        late_s: f64,
        /// Half width of its 95 % interval, s.
        half_width95_s: f64,
    },
    /// The forces are on a clock of another rate.
    #[error(
        "force.csv: its times are on a clock that is {:.0} ± {:.0} ppm {} against that of signals.wav; analysed with their times \
         corrected: multiply time_s by {:.6}, and state the true rate of the sensor",
        ppm.abs(), half_width95_ppm, if *ppm > 0.0 { "slow" } else { "fast" }, 1.0 + 1e-6 * ppm
    )]
    ForcesClock {
        /// Excess of true over stated time, ppm.
        ppm: f64,
        /// Half width of its 95 % interval, ppm.
        half_width95_ppm: f64,
    },
    /// The position is in another unit.
    #[error(
        "position.csv: the finger travels {} m at {} m/s, more than any finger on a plate: {}",
        significant(*travel_m), significant(*speed_m_per_s), motion::unit_remedy(*travel_m)
    )]
    PositionUnit {
        /// Longest travel in an exploration, m.
        travel_m: f64,
        /// Median speed, m/s.
        speed_m_per_s: f64,
    },
    /// The position runs against the stated directions.
    #[error(
        "position.csv: position_m falls in every exploration stated as left_to_right, and grows in every one stated as \
         right_to_left: it runs backwards; multiply it by -1 and state centre_m on that scale, or exchange the directions"
    )]
    Backwards,
    /// The position does not change.
    #[error(
        "position.csv: position_m has one value throughout each exploration: the encoder sent nothing new, or the column was \
         filled in; look at its cable and at the program that wrote the file"
    )]
    PositionStill,
    /// Drive and pickup are exchanged.
    #[error(
        "signals.wav: the pickup's envelope is {:.1} ms ahead of the drive's, but a plate follows its drive: drive and pickup are \
         exchanged; exchange channels.drive.index and channels.pickup.index",
        lead_s * 1e3
    )]
    ChannelsExchanged {
        /// Lead of the envelope that is stated to be the pickup's, s.
        lead_s: f64,
    },
    /// A scale of drive or pickup is off by a telling factor.
    #[error(
        "the unloaded plate answers to the modulation as if its modal mass were {} times the stated one: a scale is off by {factor}; \
         check volts_per_unit, force_factor_n_per_v and metres_per_unit (peak), and modal_mass_kg",
        significant(*ratio)
    )]
    ScaleFactor {
        /// Ratio of the modal mass by the plate's answer to the stated one.
        ratio: f64,
        /// Factor.
        factor: TellingFactor,
    },
    /// A scale of drive or pickup is far off.
    #[error(
        "the unloaded plate answers to the modulation as if its modal mass were {} times the stated one: check volts_per_unit, \
         force_factor_n_per_v, metres_per_unit and modal_mass_kg",
        significant(*ratio)
    )]
    Scale {
        /// Ratio of the modal mass by the plate's answer to the stated one.
        ratio: f64,
    },
    /// The stated modulation is not in the drive.
    #[error(
        "the drive's envelope is modulated at modulation_hz = {stated_hz} by {:.0} % only: state the frequency of the modulation, \
         or correct the sample rate",
        share * 100.0
    )]
    OtherModulation {
        /// Stated frequency, Hz.
        stated_hz: f64,
        /// Share of the envelope's mean that is at that frequency.
        share: f64,
    },
    /// The pickup reads another quantity than the displacement.
    #[error(
        "pickup: its phase is that of {}, not of a displacement: {}",
        quantity.words().0, quantity.words().1
    )]
    PickupQuantity {
        /// The quantity.
        quantity: Quantity,
    },
    /// The self-sensed normal force fits the measured one only with a contact area that no finger has.
    #[error(
        "the self-sensed normal force is that of normal_n only with a contact of {} mm², and a finger pad's is {:.0} to {:.0}: normal_n \
         is some {:.1} times too large, or another scale is off; look at its unit and its gain",
        significant(area_m2 * 1e6), CONTACT_AREA_M2[0] * 1e6, CONTACT_AREA_M2[1] * 1e6, force_factor(*area_m2)
    )]
    ContactArea {
        /// Contact area, m².
        area_m2: f64,
    },
    /// A channel has one value throughout.
    #[error(
        "signals.wav: the {channel} is {value} in each sample: a dead channel; look at its cable, its index and the program that \
         wrote the file"
    )]
    DeadChannel {
        /// Name of the channel.
        channel: String,
        /// Its value.
        value: String,
    },
    /// The signal's strongest tone is far from the stated carrier.
    #[error(
        "signals.wav: the strongest tone of the drive is at {found_hz:.0} Hz, and carrier_hz = {stated_hz:.0} is not in it: state \
         the carrier, or correct the sample rate if it is {} times that of the data",
        significant(found_hz / stated_hz)
    )]
    OtherCarrier {
        /// Frequency of the strongest tone, Hz.
        found_hz: f64,
        /// Stated carrier, Hz.
        stated_hz: f64,
    },
}

impl Implausible {
    /// Returns whether the plate's impedance cannot be used until it is corrected.
    #[must_use]
    pub fn spoils_plate(&self) -> bool {
        matches!(
            self,
            Self::ChannelsExchanged { .. } | Self::ScaleFactor { .. } | Self::Scale { .. }
        )
    }

    /// Returns the name of the flaw, for the reason why a stretch has no estimate.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::Size { .. } => "normal force in another unit",
            Self::Sign { .. } => "normal force upside down",
            Self::Constant { .. } => "dead channel of the force sensor",
            Self::Friction { .. } => "scale of the forces",
            Self::Carrier { .. } => "carrier far from the resonance",
            Self::SmallShare { .. } => "level of a channel",
            Self::Untared { .. } => "normal force untared",
            Self::Exchanged { .. } => "normal and lateral force exchanged",
            Self::LateralSign => "lateral force upside down",
            Self::ForcesLate { .. } => "forces late or early",
            Self::ForcesClock { .. } => "rate of the forces",
            Self::PositionUnit { .. } => "position in another unit",
            Self::Backwards => "position backwards",
            Self::PositionStill => "dead position",
            Self::ChannelsExchanged { .. } => "drive and pickup exchanged",
            Self::ScaleFactor { .. } | Self::Scale { .. } => "scale of drive or pickup",
            Self::OtherModulation { .. } => "modulation not that of the data",
            Self::PickupQuantity { .. } => "quantity of the pickup",
            Self::ContactArea { .. } => "scale of the normal force",
            Self::DeadChannel { .. } => "dead channel",
            Self::OtherCarrier { .. } => "carrier not that of the data",
        }
    }

    /// Returns whether the estimates cannot be used until it is corrected.
    #[must_use]
    pub fn spoils_estimates(&self) -> bool {
        match self {
            Self::Friction { ratio } => !(ANY_FRICTION[0]..=ANY_FRICTION[1]).contains(ratio),
            Self::ContactArea { area_m2 } => {
                let factor = force_factor(*area_m2);
                factor.max(factor.recip()) > GREATEST_FORCE_FACTOR
            }
            Self::Size { .. }
            | Self::Sign { .. }
            | Self::Constant { .. }
            | Self::Untared { .. }
            | Self::Exchanged { .. }
            | Self::PositionUnit { .. }
            | Self::Backwards
            | Self::PositionStill
            | Self::ChannelsExchanged { .. }
            | Self::ScaleFactor { .. }
            | Self::Scale { .. } => true,
            Self::Carrier { .. }
            | Self::SmallShare { .. }
            | Self::LateralSign
            | Self::ForcesLate { .. }
            | Self::ForcesClock { .. }
            | Self::PickupQuantity { .. }
            | Self::OtherModulation { .. }
            | Self::DeadChannel { .. }
            | Self::OtherCarrier { .. } => false,
        }
    }
}

/// Returns the units in which `force_n` would be a usual force of a finger, in words with their remedies.
fn unit_remedy(force_n: f64) -> String {
    let [least_n, most_n] = USUAL_N;
    let units = UNITS.iter();
    let fitting = units.filter(|(newtons, ..)| (least_n..=most_n).contains(&(newtons * force_n)));
    let words: Vec<String> = fitting
        .map(|(_, unit, remedy)| format!("it looks like {unit}: {remedy}"))
        .collect();
    if words.is_empty() {
        return "it looks like volts or counts of the sensor: multiply them by its sensitivity; or no finger was on the plate"
            .to_owned();
    }
    words.join(", or ")
}

/// Returns the implausible forces among `rows`, which a finger made in `explorations_s` and not in `unloaded_s`.
#[must_use]
pub fn forces(
    rows: &[ForceRow],
    explorations_s: &[(f64, f64)],
    unloaded_s: &[(f64, f64)],
) -> Vec<Implausible> {
    let columns: [(&str, Column); 2] = [
        ("normal_n", |row| row.normal_n),
        ("lateral_n", |row| row.lateral_n),
    ];
    let constants = columns.map(|(column, value)| constant(rows, column, value));
    let [is_normal_constant, is_lateral_constant] = [0, 1].map(|axis| constants[axis].is_some());
    let mut findings: Vec<Implausible> = constants.into_iter().flatten().collect();
    let readings = |spans_s: &[(f64, f64)], value: Column| {
        let is_inside = |row: &&ForceRow| {
            let mut spans = spans_s.iter();
            spans.any(|(start_s, end_s)| (*start_s..=*end_s).contains(&row.time_s))
        };
        let values = rows.iter().filter(is_inside).map(value);
        let mut values: Vec<f64> = values.filter(|value| value.is_finite()).collect();
        values.sort_by(f64::total_cmp);
        values
    };
    let unloaded_n = |value: Column| statistics::quantile(&readings(unloaded_s, value), 0.5);
    let (without_finger, touched) = (
        unloaded_n(columns[0].1),
        readings(explorations_s, columns[0].1),
    );
    if let Some(untared) = untared(without_finger, &touched) {
        // Signs and sizes are relative to a zero that the recording does not show.
        findings.push(untared);
        return findings;
    }
    let [normal, lateral] = columns.map(|(_, value)| {
        let zero_n = unloaded_n(value).unwrap_or_default();
        let mut under_finger = readings(explorations_s, value);
        under_finger
            .iter_mut()
            .for_each(|force_n| *force_n -= zero_n);
        under_finger
    });
    if normal.len() < FEWEST || is_normal_constant {
        return findings;
    }
    let quantile = |values: &[f64], share| statistics::quantile(values, share).unwrap_or_default();
    let (pull_n, push_n) = (quantile(&normal, TAIL), quantile(&normal, 1.0 - TAIL));
    let press_n = push_n.max(-pull_n);
    if press_n > SMALLEST_N && push_n < -pull_n / OPPOSITE {
        findings.push(Implausible::Sign { normal_n: pull_n });
    }
    if !(SMALLEST_N..=LARGEST_N).contains(&press_n) {
        findings.push(Implausible::Size { normal_n: press_n });
        return findings;
    }
    let friction_n = quantile(&lateral, 1.0 - TAIL).max(-quantile(&lateral, TAIL));
    let ratio = friction_n / press_n;
    let [least, most] = FRICTION;
    if lateral.len() >= FEWEST && !is_lateral_constant && !(least..=most).contains(&ratio) {
        findings.push(Implausible::Friction { ratio });
    }
    findings
}

/// Returns the finding of a normal force far from zero without a finger, relative to the `touched` readings' change from it.
fn untared(unloaded_n: Option<f64>, touched: &[f64]) -> Option<Implausible> {
    let normal_n = unloaded_n?;
    let pressed_n = statistics::quantile(touched, 0.5)? - normal_n;
    // A force in another unit has a zero in it too.
    let is_far = normal_n.abs() > LARGEST_ZERO_N && normal_n.abs() > 0.1 * pressed_n.abs();
    (is_far && touched.len() >= FEWEST).then_some(Implausible::Untared { normal_n })
}

/// Returns the factor by which a normal force is too large if the usual area of a finger pad becomes `area_m2` by it.
fn force_factor(area_m2: f64) -> f64 {
    (area_m2 / USUAL_AREA_M2).cbrt()
}

/// Returns the finding of a contact area that no finger has.
#[must_use]
pub fn contact_area(area_m2: f64) -> Option<Implausible> {
    let [least_m2, most_m2] = CONTACT_AREA_M2;
    (!(least_m2..=most_m2).contains(&area_m2)).then_some(Implausible::ContactArea { area_m2 })
}

/// Returns the finding of a column that has one value in all its rows.
fn constant(rows: &[ForceRow], column: &'static str, value: Column) -> Option<Implausible> {
    let mut values = rows.iter().map(value).filter(|value| value.is_finite());
    let first = values.next()?;
    let (rows, is_constant) = values.fold((1, true), |(rows, is_constant), value| {
        (rows + 1, is_constant && value == first)
    });
    (is_constant && rows >= FEWEST).then_some(Implausible::Constant {
        column,
        value: first,
        rows,
    })
}

/// Returns the finding of a carrier far from the plate's resonance.
#[must_use]
pub fn carrier(carrier_hz: f64, resonance_hz: f64) -> Option<Implausible> {
    let is_off = (carrier_hz / resonance_hz - 1.0).abs() > CARRIER_DISTANCE;
    is_off.then_some(Implausible::Carrier {
        carrier_hz,
        resonance_hz,
    })
}

/// Returns the finding of a channel with `level` as its largest |sample|, as a share of full scale.
#[must_use]
pub fn channel(name: &str, level: f32) -> Option<Implausible> {
    (level > 0.0 && level < SMALL_SHARE).then(|| Implausible::SmallShare {
        channel: name.to_owned(),
        level,
    })
}

/// Compiles and runs the example in the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExample;

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows at 1 kHz of a finger that presses with about 0.7 N from 1 to 3 s, scaled.
    fn rows(normal_scale: f64, lateral_scale: f64) -> Vec<ForceRow> {
        let row = |i: u32| {
            let time_s = f64::from(i) * 1e-3;
            let ripple = 1.0 + 0.2 * (40.0 * time_s).sin();
            let press_n = if time_s < 1.0 {
                0.001 * ripple
            } else {
                0.7 * ripple
            };
            ForceRow {
                time_s,
                normal_n: normal_scale * press_n,
                lateral_n: lateral_scale * 0.5 * press_n,
            }
        };
        (0..3000).map(row).collect()
    }

    fn words(rows: &[ForceRow]) -> String {
        let findings = forces(rows, &[(1.0, 3.0)], &[(0.0, 0.9)]);
        let words: Vec<String> = findings.iter().map(ToString::to_string).collect();
        words.join("\n")
    }

    #[test]
    fn the_forces_of_a_finger_are_plausible_with_any_zero() {
        assert_eq!(words(&rows(1.0, 1.0)), "");
        assert_eq!(words(&rows(0.1, -0.1)), "", "a light touch, to the left");
        let mut shifted = rows(1.0, 1.0);
        shifted.iter_mut().for_each(|row| row.normal_n -= 30.0);
        let shifted = words(&shifted);
        assert!(
            shifted.contains("reads -30.0 N in the intervals without a finger")
                && !shifted.contains("multiply it by"),
            "{shifted}"
        );
        let touch = &rows(1e3, 1e3)[990..1030];
        assert_eq!(words(touch), "", "too few readings");
    }

    #[test]
    fn another_unit_is_named_with_its_remedy() {
        for (scale, unit) in [
            (1e3, "millinewtons: divide by 1000"),
            (101.97, "grams: multiply by 0.00980665"),
            (1e-3, "kilonewtons: multiply by 1000"),
            (8.4e12, "counts"),
        ] {
            let words = words(&rows(scale, scale));
            assert!(words.contains(unit), "{scale}: {words}");
            assert!(!words.contains("negative"), "{words}");
        }
        let both = words(&rows(-1e3, 1e3));
        assert!(
            both.contains("millinewtons") && both.contains("multiply it by -1"),
            "{both}"
        );
    }

    #[test]
    fn another_sign_a_constant_column_and_an_impossible_friction_are_named() {
        assert!(words(&rows(-1.0, 1.0)).contains("multiply it by -1"));
        assert!(words(&rows(1.0, 1e3)).contains("lateral_n is"));
        let mut constant = rows(1.0, 1.0);
        constant.iter_mut().for_each(|row| row.lateral_n = 0.25);
        assert!(words(&constant).contains("lateral_n is 0.25 in each of 3000 rows"));
    }

    #[test]
    fn a_channel_below_a_256th_of_full_scale_is_named() {
        assert_eq!(channel("pickup", 0.3), None);
        assert_eq!(channel("pickup", 0.0), None, "silence");
        let finding = channel("pickup", 0.3 / 256.0).unwrap();
        assert!(
            finding.to_string().contains("1/853 of full scale"),
            "{finding}"
        );
        assert!(!finding.spoils_estimates());
    }
}
