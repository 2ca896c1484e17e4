//! Verdict on the uniformity of the amplitude along the plate; storage and figure of the profile.

use std::fmt::Write as _;

use crate::plate_procedure::PlateProcedure;
use anyhow::bail;
use calibration_rig::judged::{Calibrates, Judged, Part, SideFile};
use config::{KeptLength, MeasuredProfile, ProfilePlace, Provenance, Quantity, Uniformity};
use jiff::Timestamp;
use plotting::{Axis, Dash, Figure, Ink, Key, Marker, Panel, Series, Width};
use protocols::SelectionRules;
use statistics::error_decimals;

use crate::survey::profile_point::ProfilePoint;
use crate::survey::profile_procedure::ProfileProcedure;
use crate::survey::survey_axis::SurveyAxis;

/// Largest deviation from the mean along a uniform plate (an assumption of this project; 5 % at the ends of the kept 60 mm bias
/// σ_t by 3 %).
pub const UNIFORM: f64 = 0.02;
/// Standard errors within which a deviation cannot be distinguished from the limit.
const SURE: f64 = 2.0;
/// Fewest places within the kept length, its ends included, for a verdict.
const FEWEST_KEPT: usize = 3;

/// Returns the relative deviation of the decisive place from the mean, with its standard error, and the verdict: uniform if no
/// deviation can exceed the limit, not uniform if one certainly does. Of the certain deviations the most significant decides;
/// otherwise the one with the largest upper bound.
pub(crate) fn judge_places(places: &[ProfilePoint]) -> (f64, f64, Uniformity) {
    let departures = departures(places);
    let lower_bound = |&(departure, error): &(f64, f64)| departure.abs() - SURE * error;
    let upper_bound = |&(departure, error): &(f64, f64)| departure.abs() + SURE * error;
    let extreme = |bound: &dyn Fn(&(f64, f64)) -> f64| {
        let candidates = departures.iter().copied();
        candidates.max_by(|a, b| bound(a).total_cmp(&bound(b)))
    };
    let no_departure = (f64::NAN, f64::NAN);
    let (sure, possible) = (
        extreme(&lower_bound).unwrap_or(no_departure),
        extreme(&upper_bound).unwrap_or(no_departure),
    );
    let (verdict, (departure, error)) = if lower_bound(&sure) > UNIFORM {
        (Uniformity::NotUniform, sure)
    } else if upper_bound(&possible) <= UNIFORM {
        (Uniformity::Uniform, possible)
    } else {
        (Uniformity::Undecided, possible)
    };
    (departure, error, verdict)
}

/// Returns each place's deviation from the mean of all, relative to that mean, with its standard error: an uncertain place
/// makes the mean uncertain, and with it all deviations.
fn departures(places: &[ProfilePoint]) -> Vec<(f64, f64)> {
    let n = places.len() as f64;
    let mean = places.iter().map(|place| place.ratio).sum::<f64>() / n;
    let variance: f64 = places.iter().map(|place| place.error.powi(2)).sum();
    let departure = |place: &ProfilePoint| {
        // Weight of another place's error in the deviation, and additional weight of this place's variance.
        let other_weight = place.ratio / mean / n;
        let own_weight = 1.0 - 2.0 * other_weight;
        let squares = own_weight * place.error.powi(2) + other_weight.powi(2) * variance;
        (place.ratio / mean - 1.0, squares.max(0.0).sqrt() / mean)
    };
    places.iter().map(departure).collect()
}

/// Judges the length about `centre_m` from which the published rules cut instances: the places within it, and its two ends,
/// interpolated linearly between the places on either side. Returns `None` if there are too few, or the places do not reach its
/// ends.
pub(crate) fn judge_length(places: &[ProfilePoint], centre_m: f64) -> Option<KeptLength> {
    let length_m = SelectionRules::published(centre_m).central_m;
    let ends_m = [centre_m - length_m / 2.0, centre_m + length_m / 2.0];
    let is_within =
        |place: &&ProfilePoint| place.position_m > ends_m[0] && place.position_m < ends_m[1];
    let mut inner: Vec<ProfilePoint> = places.iter().filter(is_within).copied().collect();
    inner.extend([
        interpolated(places, ends_m[0])?,
        interpolated(places, ends_m[1])?,
    ]);
    (inner.len() >= FEWEST_KEPT).then(|| {
        let (departure, error, verdict) = judge_places(&inner);
        KeptLength {
            length_m,
            verdict,
            largest_departure: Quantity::new(departure, error, inner.len() - 1, "1"),
        }
    })
}

/// Returns the ratio at a position, interpolated linearly between the places on either side, if there are both.
fn interpolated(places: &[ProfilePoint], position_m: f64) -> Option<ProfilePoint> {
    let encloses =
        |pair: &&[ProfilePoint]| (pair[0].position_m..=pair[1].position_m).contains(&position_m);
    let pair = places.windows(2).find(encloses)?;
    let share = (position_m - pair[0].position_m) / (pair[1].position_m - pair[0].position_m);
    let [left, right] = [1.0 - share, share];
    Some(ProfilePoint {
        position_m,
        ratio: left * pair[0].ratio + right * pair[1].ratio,
        error: (left * pair[0].error).hypot(right * pair[1].error),
    })
}

impl Calibrates for ProfileProcedure {
    const NAME: &'static str = PlateProcedure::NAME;

    fn judge_review(&self) -> anyhow::Result<Judged> {
        let (date, operator) = (Timestamp::UNIX_EPOCH, "");
        if self.places.is_empty() {
            self.plate.judge(date, operator)
        } else {
            self.judge(date, operator)
        }
    }

    fn judge(&self, date: Timestamp, operator: &str) -> anyhow::Result<Judged> {
        let mut judged = self.plate.judge(date, operator)?;
        let Part::Plate { plate, finger, .. } = judged.part else {
            bail!("the plate was not measured");
        };
        if self.axis != SurveyAxis::Along {
            let (across, remarks, side_file) = self.across_plate(date, operator);
            judged.remarks.extend(remarks);
            judged.side_files.push(side_file);
            judged.part = Part::Plate {
                plate,
                finger,
                profile: None,
                across: Some(Box::new(across)),
            };
            return Ok(judged);
        }
        let profile = self.profile(date, operator);
        judged
            .remarks
            .push(format!("along the plate  {}", words(&profile)));
        judged.side_files.push(SideFile {
            stem: "plate-profile",
            table: csv(&self.places),
            figure: Some(draw(&self.places, &profile)),
        });
        judged.part = Part::Plate {
            plate,
            finger,
            profile: Some(Box::new(profile)),
            across: None,
        };
        Ok(judged)
    }
}

impl ProfileProcedure {
    fn profile(&self, date: Timestamp, operator: &str) -> MeasuredProfile {
        let (departure, error, verdict) = judge_places(&self.places);
        let freedom = self.places.len() - 1;
        MeasuredProfile {
            measured: Provenance {
                date,
                operator: operator.to_owned(),
                method: format!(
                    "a vibrometer at {} places, over the pickup's amplitude; errors hold the readings' scatter, and not what all \
                     places share",
                    self.places.len()
                ),
            },
            carrier_hz: self.carrier_hz(),
            drive_v: self.level_v,
            verdict,
            largest_departure: Quantity::new(departure, error, freedom, "1"),
            kept: judge_length(&self.places, self.config.plate.centre_m),
            places: self
                .places
                .iter()
                .map(|place| ProfilePlace {
                    position_m: place.position_m,
                    ratio: place.ratio,
                    standard_error: place.error,
                })
                .collect(),
        }
    }
}

/// Returns the verdict as text.
fn words(profile: &MeasuredProfile) -> String {
    let percent = |departure: &Quantity| {
        let (value, error) = (100.0 * departure.value, 100.0 * departure.standard_error);
        let decimals = error_decimals(error, 3);
        format!("{value:+.2} ± {error:.decimals$} %")
    };
    let verdict = match &profile.kept {
        Some(length) => format!(
            "{}, {}",
            verdict_words(length.verdict),
            percent(&length.largest_departure)
        ),
        None => {
            "not judged, because its ends, or too few places of it, were not measured".to_owned()
        }
    };
    format!(
        "{}; the departure from the mean that decides is {}, {:.0} % is allowed; within the {:.0} mm that instances are cut \
         from: {verdict}",
        verdict_words(profile.verdict),
        percent(&profile.largest_departure),
        100.0 * UNIFORM,
        1e3 * SelectionRules::published(0.0).central_m,
    )
}

fn verdict_words(verdict: Uniformity) -> &'static str {
    match verdict {
        Uniformity::Uniform => "uniform",
        Uniformity::NotUniform => "NOT UNIFORM",
        Uniformity::Undecided => "undecided: measure longer or more carefully",
    }
}

fn csv(places: &[ProfilePoint]) -> String {
    let mut text = String::from("position_m,ratio,standard_error\n");
    for place in places {
        let _ = writeln!(
            text,
            "{:.6},{},{}",
            place.position_m, place.ratio, place.error
        );
    }
    text
}

fn draw(places: &[ProfilePoint], profile: &MeasuredProfile) -> Figure {
    let mean = places.iter().map(|place| place.ratio).sum::<f64>() / places.len() as f64;
    let curve = |value: &dyn Fn(&ProfilePoint) -> f64| -> Vec<(f64, f64)> {
        let points = places.iter();
        points
            .map(|place| (1e3 * place.position_m, value(place)))
            .collect()
    };
    let error = |place: &ProfilePoint| SURE * place.error;
    let band = places
        .iter()
        .map(|place| {
            let x = 1e3 * place.position_m;
            (x, place.ratio - error(place), place.ratio + error(place))
        })
        .collect();
    let level = |share: f64| curve(&|_| mean * (1.0 + share));
    Figure {
        name: "plate-profile".to_owned(),
        title: "Amplitude along the plate".to_owned(),
        caption: format!(
            "Amplitude by the vibrometer at places along the plate over that of the pickup (circles; band: two standard errors), the \
             mean, and ±{:.0} % about it (dashed; Huloux 2021, section III-B: uniform along the length). {}. Measured {} by {}: {}.",
            100.0 * UNIFORM,
            words(profile),
            calendar::moment(profile.measured.date),
            profile.measured.operator,
            profile.measured.method,
        ),
        width: Width::Column,
        columns: 1,
        panel_height_mm: 44.0,
        footnote: None,
        key: Key::InPanels,
        panels: vec![Panel {
            series: vec![
                Series::band(Ink::Blue, band),
                Series::line(Ink::Grey, Dash::Solid, level(0.0)),
                Series::line(Ink::Grey, Dash::Dashed, level(UNIFORM)),
                Series::line(Ink::Grey, Dash::Dashed, level(-UNIFORM)),
                Series::points(Ink::Black, Marker::Circle, curve(&|place| place.ratio)),
            ],
            ..Panel::new(
                Axis::linear("Position along the plate (mm)"),
                Axis::linear("Amplitude over the pickup's"),
            )
        }],
    }
}
