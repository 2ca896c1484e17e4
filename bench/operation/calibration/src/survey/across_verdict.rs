//! Verdict on the amplitude across the plate; storage and figure of the cosine.

use std::fmt::Write as _;

use calibration_rig::judged::SideFile;
use config::{
    AcrossObstacle, AcrossPlace, CosineVerdict, MeasuredAcross, Provenance, Quantity,
    contradiction, thin_plate_wavelength_m,
};
use jiff::Timestamp;
use metrology::mode_across::CosineFit;
use plotting::{Axis, Dash, Figure, Ink, Key, Marker, Panel, Series, Width};

use crate::survey::cosine::{curve, fit};
use crate::survey::profile_point::ProfilePoint;
use crate::survey::profile_procedure::ProfileProcedure;

/// Largest root mean square residual of a cosine over its amplitude (an assumption of this project: the edges of a free plate cause
/// 3 % within 8 mm of the middle of 22 mm).
pub const COSINE: f64 = 0.05;
/// Relative standard error of all distances together: a ruler's or a stage's scale (assumed).
const DISTANCES: f64 = 2e-3;
/// Standard errors of the drawn bars.
const SURE: f64 = 2.0;

/// Returns the remark on an obstacle to using the wavelength.
fn remark(obstacle: AcrossObstacle) -> String {
    match obstacle {
        AcrossObstacle::OffCrest => {
            "THE FINGER'S LINE IS NOT ON THE CREST: the wavelength is stored and not used; move the plate or the finger's line"
                .to_owned()
        }
        AcrossObstacle::Short | AcrossObstacle::Long => format!(
            "NOT USED: {obstacle}; it is stored. Check the places of the vibrometer, and width_m under [plate]"
        ),
    }
}

/// Returns the verdict on a fit.
pub(crate) fn verdict(fit: Option<&CosineFit>) -> CosineVerdict {
    match fit {
        None => CosineVerdict::Undetermined,
        Some(fit) if fit.relative_residual() > COSINE => CosineVerdict::NotCosine,
        Some(_) => CosineVerdict::Cosine,
    }
}

impl ProfileProcedure {
    /// Returns the measurement across the plate, its remarks, and its table with its figure.
    pub(crate) fn across_plate(
        &self,
        date: Timestamp,
        operator: &str,
    ) -> (MeasuredAcross, Vec<String>, SideFile) {
        let fit = fit(&self.places);
        let across = self.measured(fit.as_ref(), date, operator);
        let words = words(&across);
        let plate = &self.config.plate;
        let mut remarks = vec![format!("across the plate  {words}")];
        remarks.extend(across.obstacle().map(remark));
        remarks.extend(contradiction(plate, &across));
        remarks.extend(plate.thickness_m.map(|thickness_m| {
            let wavelength_m = thin_plate_wavelength_m(thickness_m, self.carrier_hz());
            format!(
                "thin plate        {:.2} mm for {thickness_m} m of glass without edges",
                1e3 * wavelength_m
            )
        }));
        let side_file = SideFile {
            stem: "plate-across",
            table: csv(&self.places, fit.as_ref()),
            figure: Some(draw(&self.places, fit.as_ref(), &across, &words)),
        };
        (across, remarks, side_file)
    }

    fn measured(&self, fit: Option<&CosineFit>, date: Timestamp, operator: &str) -> MeasuredAcross {
        let quantity = |value: fn(&CosineFit) -> [f64; 2], unit: &str| {
            fit.map(|fit| {
                let [value, error] = value(fit);
                Quantity::new(value, error, fit.degrees_of_freedom, unit)
            })
        };
        MeasuredAcross {
            measured: Provenance {
                date,
                operator: operator.to_owned(),
                method: format!(
                    "a vibrometer at {} places, over the pickup's amplitude; a cosine without sign; errors by its residuals \
                     and by the scale of the distances",
                    self.places.len()
                ),
            },
            carrier_hz: self.carrier_hz(),
            drive_v: self.level_v,
            verdict: verdict(fit),
            residual: fit.map(CosineFit::relative_residual),
            wavelength_m: fit.map(|fit| {
                let [wavelength_m, scatter_m] = fit.wavelength_m;
                let error_m = scatter_m.hypot(DISTANCES * wavelength_m);
                let freedom = fit.degrees_of_freedom;
                Quantity::combined(wavelength_m, error_m, scatter_m, freedom, "m")
            }),
            crest_m: quantity(|fit| fit.crest_m, "m"),
            crest_ratio: quantity(|fit| fit.crest, "1"),
            places: self
                .places
                .iter()
                .map(|place| AcrossPlace {
                    across_m: place.position_m,
                    ratio: place.ratio,
                    standard_error: place.error,
                })
                .collect(),
        }
    }
}

/// Returns the verdict as text, with 95 % intervals.
fn words(across: &MeasuredAcross) -> String {
    let (Some(wavelength), Some(crest), Some(residual)) =
        (&across.wavelength_m, &across.crest_m, across.residual)
    else {
        return "no wavelength: the amplitude hardly changes, or the places do not determine it"
            .to_owned();
    };
    let mm = |quantity: &Quantity| {
        let [value, error] = [quantity.value, quantity.standard_error].map(|m| 1e3 * m);
        Quantity::new(value, error, quantity.degrees_of_freedom, "mm").to_string()
    };
    format!(
        "{} of wavelength {}, its crest at {} from the finger's line; residuals of {:.1} % of the crest, {:.0} % are allowed",
        match across.verdict {
            CosineVerdict::NotCosine => "NOT A COSINE; the nearest is one",
            CosineVerdict::Cosine | CosineVerdict::Undetermined => "a cosine",
        },
        mm(wavelength),
        mm(crest),
        100.0 * residual,
        100.0 * COSINE,
    )
}

fn csv(places: &[ProfilePoint], fit: Option<&CosineFit>) -> String {
    let mut text = String::from("across_m,ratio,standard_error,residual\n");
    for (i, place) in places.iter().enumerate() {
        let residual = fit.map_or(f64::NAN, |fit| fit.residuals[i]);
        let _ = writeln!(
            text,
            "{:.6},{},{},{residual}",
            place.position_m, place.ratio, place.error
        );
    }
    text
}

fn draw(
    places: &[ProfilePoint],
    fit: Option<&CosineFit>,
    across: &MeasuredAcross,
    words: &str,
) -> Figure {
    let points = places
        .iter()
        .map(|place| (1e3 * place.position_m, place.ratio))
        .collect();
    let bars = places
        .iter()
        .map(|place| {
            let x = 1e3 * place.position_m;
            let error = SURE * place.error;
            (x, place.ratio - error, place.ratio + error)
        })
        .collect();
    let mut series = vec![Series::bars(Ink::Blue, bars)];
    if let Some(fit) = fit {
        let curve = curve(places, fit);
        series.push(Series::line(Ink::Vermillion, Dash::Solid, curve));
    }
    series.push(Series::points(Ink::Black, Marker::Circle, points));
    Figure {
        name: "plate-across".to_owned(),
        title: "Amplitude across the plate".to_owned(),
        caption: format!(
            "Amplitude by the vibrometer at places across the plate over that of the pickup (circles; bars: two standard errors of the \
             readings), and the fitted cosine, without sign (line). The finger slides along 0. {}. Measured {} by {}: {}.",
            capital(words),
            calendar::moment(across.measured.date),
            across.measured.operator,
            across.measured.method,
        ),
        width: Width::Column,
        columns: 1,
        panel_height_mm: 44.0,
        footnote: None,
        key: Key::InPanels,
        panels: vec![Panel {
            series,
            ..Panel::new(
                Axis::linear("Distance from the finger's line (mm)"),
                Axis::linear("Amplitude over the pickup's"),
            )
        }],
    }
}

/// Returns the text with a capital first letter.
fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| {
        first.to_uppercase().chain(letters).collect()
    })
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    fn places(shape: impl Fn(f64) -> f64) -> Vec<ProfilePoint> {
        (0..9)
            .map(|i| {
                let position_m = -8e-3 + 2e-3 * f64::from(i);
                ProfilePoint {
                    position_m,
                    ratio: shape(position_m).abs(),
                    error: 1e-4,
                }
            })
            .collect()
    }

    #[test]
    fn a_cosine_another_shape_and_a_flat_plate_are_told_apart() {
        let cosine = fit(&places(|y| (TAU * y / 0.022).cos()));
        assert_eq!(verdict(cosine.as_ref()), CosineVerdict::Cosine);
        // Two modes of which the second is twice as short.
        let mixed = fit(&places(|y| {
            (TAU * y / 0.022).cos() + 0.3 * (TAU * y / 0.012).sin()
        }));
        assert_ne!(verdict(mixed.as_ref()), CosineVerdict::Cosine);
        assert_eq!(
            verdict(fit(&places(|_| 1.0)).as_ref()),
            CosineVerdict::Undetermined
        );
    }

    #[test]
    fn a_figure_needs_no_wavelength() {
        let flat = places(|_| 1.0);
        let across = MeasuredAcross {
            measured: Provenance {
                date: Timestamp::UNIX_EPOCH,
                operator: "A. Tester".to_owned(),
                method: "test".to_owned(),
            },
            carrier_hz: 35e3,
            drive_v: 5.0,
            verdict: CosineVerdict::Undetermined,
            residual: None,
            wavelength_m: None,
            crest_m: None,
            crest_ratio: None,
            places: Vec::new(),
        };
        let text = words(&across);
        let figure = draw(&flat, None, &across, &text);
        assert_eq!(figure.panels[0].series.len(), 2);
        assert!(
            figure.caption.contains("No wavelength"),
            "{}",
            figure.caption
        );
        assert!(
            csv(&flat, None)
                .lines()
                .nth(1)
                .is_some_and(|row| row.ends_with("NaN"))
        );
    }
}
