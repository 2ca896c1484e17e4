//! The plate's mode across its width: as measured, or as configured.

use serde::{Deserialize, Serialize};

use super::plate_constants::Plate;
use crate::quantity::{Provenance, Quantity};

/// Relative standard error of a configured wavelength without a stated error (assumed): free edges alone make the mode that much
/// steeper in the middle than the thin plate's formula.
const CONFIGURED: f64 = 0.1;
/// Ratio of a normal distribution's 95 % interval to its standard deviation, on either side.
const NORMAL_95: f64 = 1.959_964;
/// Standard errors by which a configured and a measured wavelength may differ.
const SURE: f64 = 2.0;

/// Distance from the crest, in wavelengths, up to which the finger's line counts as being on it (assumed): the amplitude there is
/// 5 % lower.
const OFF_CREST: f64 = 0.05;
/// Largest distance from the crest, and largest standard error of it, in wavelengths, that a recording accepts.
pub const FARTHEST_CREST: f64 = 0.125;

/// Glass of the published plate: borosilicate (values of Borofloat 33 by its maker).
const YOUNGS_MODULUS_PA: f64 = 64e9;
const POISSON_RATIO: f64 = 0.2;
const DENSITY_KG_PER_M3: f64 = 2230.0;

/// `[across]`: the amplitude across the plate relative to that of the pickup, and the cosine fitted to it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct MeasuredAcross {
    /// Operator, date and method of the measurement.
    pub measured: Provenance,
    /// Carrier of the measurement, Hz.
    pub carrier_hz: f64,
    /// Level of the tone, V peak.
    pub drive_v: f64,
    /// Whether the amplitude follows a cosine.
    pub verdict: CosineVerdict,
    /// Root mean square residual of the fit over the amplitude at the crest; absent if nothing was fitted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub residual: Option<f64>,
    /// Wavelength λ of the cosine, m; absent if the places do not determine it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wavelength_m: Option<Quantity>,
    /// Distance of the cosine's crest from the line that the finger follows, m; absent without a wavelength.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub crest_m: Option<Quantity>,
    /// Amplitude at the crest relative to the pickup's; absent without a wavelength.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub crest_ratio: Option<Quantity>,
    /// Places in order of their distance.
    pub places: Vec<AcrossPlace>,
}

impl MeasuredAcross {
    /// Returns whether the finger's line lies on the crest, as far as the errors tell; false without a wavelength.
    #[must_use]
    pub fn is_on_crest(&self) -> bool {
        let (Some(wavelength), Some(crest)) = (&self.wavelength_m, &self.crest_m) else {
            return false;
        };
        let farthest_m = FARTHEST_CREST * wavelength.value;
        crest.value.abs() - SURE * crest.standard_error <= OFF_CREST * wavelength.value
            && crest.value.abs() <= farthest_m
            && normal_error(crest) <= farthest_m
    }

    /// Returns the obstacle to using the measured wavelength; `None` if it is used, or without a wavelength.
    #[must_use]
    pub fn obstacle(&self) -> Option<AcrossObstacle> {
        let wavelength = self.wavelength_m.as_ref()?;
        let [shortest_m, longest_m] = Plate::WAVELENGTHS_ACROSS_M;
        if wavelength.value < shortest_m {
            Some(AcrossObstacle::Short)
        } else if wavelength.value > longest_m {
            Some(AcrossObstacle::Long)
        } else if self.is_on_crest() {
            None
        } else {
            Some(AcrossObstacle::OffCrest)
        }
    }
}

/// Obstacle to using a measured wavelength across the plate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AcrossObstacle {
    /// A fingertip is wider than the model's widest contact on this wave.
    Short,
    /// The wave is longer than any plate of the configuration.
    Long,
    /// The line that the finger follows is away from the crest.
    OffCrest,
}

impl std::fmt::Display for AcrossObstacle {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [shortest_mm, longest_mm] = Plate::WAVELENGTHS_ACROSS_M.map(|m| 1e3 * m);
        match self {
            Self::Short => write!(
                f,
                "the wavelength is below {shortest_mm} mm, and a fingertip is wider than the model's widest contact on it"
            ),
            Self::Long => write!(f, "the wavelength is above {longest_mm} mm"),
            Self::OffCrest => {
                f.write_str("the line that the finger follows is not on the mode's crest")
            }
        }
    }
}

/// Returns the standard deviation of the normal distribution with the same 95 % interval as a quantity.
fn normal_error(quantity: &Quantity) -> f64 {
    quantity.half_width_95() / NORMAL_95
}

/// `[[across.places]]`: one place.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct AcrossPlace {
    /// Distance from the line that the finger follows, m; positive on the side away from the participant.
    pub across_m: f64,
    /// Amplitude at this place relative to that of the pickup.
    pub ratio: f64,
    /// Standard error of the ratio, without errors common to all places.
    pub standard_error: f64,
}

/// Whether the amplitude across a plate follows a cosine.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum CosineVerdict {
    /// The residuals are within the limit.
    Cosine,
    /// The residuals exceed the limit; the error of the wavelength includes them.
    NotCosine,
    /// The places determine no wavelength.
    Undetermined,
}

/// The mode under a finger: its amplitude follows cos(2π(y − y0)/λ) with the distance y from the finger's line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModeAcross {
    /// Wavelength λ across the plate at the carrier, m.
    pub wavelength_m: f64,
    /// Its standard error, m: that of a normal distribution with the same 95 % interval.
    pub standard_error_m: f64,
    /// Distance y0 of the crest from the finger's line, m; 0 on a configured mode.
    pub crest_m: f64,
    /// Its standard error, m, likewise.
    pub crest_standard_error_m: f64,
    /// Source of the wavelength.
    pub source: WavelengthSource,
}

/// Source of a wavelength across the plate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WavelengthSource {
    /// `calibrate plate --across`.
    Measured,
    /// `plate.wavelength_across_m`.
    Configured,
}

impl ModeAcross {
    /// Returns the mode as measured, or else as configured; `None` if neither is known, or if the measured one has an
    /// [obstacle](MeasuredAcross::obstacle), since a configured mode then is not that under the finger either.
    #[must_use]
    pub fn new(plate: &Plate, across: Option<&MeasuredAcross>) -> Option<Self> {
        match across.filter(|across| across.wavelength_m.is_some()) {
            Some(across) if across.obstacle().is_none() => Self::measured(across),
            Some(_) => None,
            None => Self::configured(plate),
        }
    }

    fn measured(across: &MeasuredAcross) -> Option<Self> {
        let (wavelength, crest) = (across.wavelength_m.as_ref()?, across.crest_m.as_ref()?);
        Some(Self {
            wavelength_m: wavelength.value,
            standard_error_m: normal_error(wavelength),
            crest_m: crest.value,
            crest_standard_error_m: normal_error(crest),
            source: WavelengthSource::Measured,
        })
    }

    fn configured(plate: &Plate) -> Option<Self> {
        let wavelength_m = plate.wavelength_across_m?;
        Some(Self {
            wavelength_m,
            standard_error_m: wavelength_m
                * plate.wavelength_across_relative_error.unwrap_or(CONFIGURED),
            crest_m: 0.0,
            crest_standard_error_m: 0.0,
            source: WavelengthSource::Configured,
        })
    }
}

/// Returns the contradiction between the configured and the measured wavelength, in one line, if there is one.
#[must_use]
pub fn contradiction(plate: &Plate, across: &MeasuredAcross) -> Option<String> {
    let configured = ModeAcross::configured(plate)?;
    let measured = ModeAcross::measured(across)?;
    let error_m = configured.standard_error_m.hypot(measured.standard_error_m);
    let difference_m = configured.wavelength_m - measured.wavelength_m;
    (difference_m.abs() > SURE * error_m).then(|| {
        format!(
            "plate.wavelength_across_m = {:.2} mm contradicts the measured {:.2} ± {:.2} mm, which is used: correct it, or take it \
             out",
            1e3 * configured.wavelength_m,
            1e3 * measured.wavelength_m,
            1e3 * measured.standard_error_m,
        )
    })
}

/// Returns the flexural wavelength of a thin plate of borosilicate glass, m.
///
/// A straight-crested wave on a plate of thickness h bends it with the stiffness D = E h³/(12 (1 − ν²)) per width. Its equation
/// of motion, D ∂⁴u/∂y⁴ + ρ h ∂²u/∂t² = 0, gives D k⁴ = ρ h ω² for u = cos(k y) cos(ω t), so that
/// λ = 2π/k = 2π (D/(ρ h))^(1/4)/√ω (Cremer, Heckl and Petersson 2005, section 3.4). Shear and rotary inertia shorten λ, by about
/// 4 % where λ is nine times h; free edges make the mode steeper between them.
///
/// ```
/// let wavelength_m = config::thin_plate_wavelength_m(3.3e-3, 35e3);
/// assert!((wavelength_m - 30.6e-3).abs() < 0.1e-3);
/// ```
#[must_use]
pub fn thin_plate_wavelength_m(thickness_m: f64, carrier_hz: f64) -> f64 {
    let stiffness =
        YOUNGS_MODULUS_PA * thickness_m.powi(3) / (12.0 * (1.0 - POISSON_RATIO.powi(2)));
    let omega = std::f64::consts::TAU * carrier_hz;
    let fourth_root = (stiffness / (DENSITY_KG_PER_M3 * thickness_m))
        .sqrt()
        .sqrt();
    std::f64::consts::TAU * fourth_root / omega.sqrt()
}

/// Returns the wavelength across the plate in one line: as it is used and its source, or the estimate of a thin plate, or the lack
/// of both.
#[must_use]
pub fn wavelength_in_words(plate: &Plate, across: Option<&MeasuredAcross>) -> String {
    let formula = plate.thickness_m.map(|thickness_m| {
        let wavelength_m = thin_plate_wavelength_m(thickness_m, plate.resonance_hz);
        format!(
            "a thin glass plate of plate.thickness_m = {thickness_m} m has {:.2} mm",
            1e3 * wavelength_m
        )
    });
    if let Some(obstacle) = across.and_then(MeasuredAcross::obstacle) {
        return format!("not used: {obstacle}");
    }
    match ModeAcross::new(plate, across) {
        Some(mode) => format!(
            "{:.2} ± {:.2} mm, {}{}",
            1e3 * mode.wavelength_m,
            1e3 * mode.standard_error_m,
            match mode.source {
                WavelengthSource::Measured => "measured",
                WavelengthSource::Configured => "from plate.wavelength_across_m",
            },
            formula.map_or(String::new(), |formula| format!("; {formula}"))
        ),
        None => format!(
            "not known: measure it with `friction-bench calibrate plate --across 9`{}",
            formula.map_or(String::new(), |formula| format!(
                ", or set plate.wavelength_across_m; {formula}"
            ))
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Config;
    use crate::calibration_file::CalibrationFile;
    use crate::identity::Identity;

    fn plate(keys: &str) -> Result<Plate, crate::ConfigError> {
        let is_kept = |line: &&str| !line.starts_with("width_m");
        let lines: Vec<&str> = crate::rigs::MOCK_BENCH.lines().filter(is_kept).collect();
        let table = format!("[plate]\n{keys}\n");
        let text = lines.join("\n").replacen("[plate]\n", &table, 1);
        Config::parse(&text, "bench.toml").map(|config| config.plate)
    }

    fn measured(wavelength_m: Option<Quantity>) -> MeasuredAcross {
        MeasuredAcross {
            measured: Provenance {
                date: jiff::Timestamp::UNIX_EPOCH,
                operator: "A. Tester".to_owned(),
                method: "test".to_owned(),
            },
            carrier_hz: 35e3,
            drive_v: 5.0,
            verdict: CosineVerdict::Cosine,
            residual: Some(0.01),
            crest_m: wavelength_m
                .as_ref()
                .map(|_| Quantity::new(1e-4, 1e-4, 6, "m")),
            crest_ratio: wavelength_m
                .as_ref()
                .map(|_| Quantity::new(1.0, 0.01, 6, "1")),
            wavelength_m,
            places: vec![AcrossPlace {
                across_m: -0.008,
                ratio: 0.7,
                standard_error: 1e-3,
            }],
        }
    }

    #[test]
    fn a_measured_wavelength_is_preferred_and_an_undetermined_one_is_none() {
        let configured = plate("wavelength_across_m = 0.022").unwrap();
        let mode = ModeAcross::new(&configured, None).unwrap();
        assert_eq!(mode.source, WavelengthSource::Configured);
        assert!((mode.standard_error_m - 0.0022).abs() < 1e-12);
        let stated =
            plate("wavelength_across_m = 0.022\nwavelength_across_relative_error = 0.05").unwrap();
        let mode = ModeAcross::new(&stated, None).unwrap();
        assert!((mode.standard_error_m - 0.0011).abs() < 1e-12);

        let across = measured(Some(Quantity::new(0.0245, 2e-4, 6, "m")));
        let mode = ModeAcross::new(&configured, Some(&across)).unwrap();
        assert_eq!(mode.source, WavelengthSource::Measured);
        assert_eq!(mode.wavelength_m, 0.0245);
        // Student's t of 6 degrees of freedom: 2.447.
        assert!((mode.standard_error_m - 2e-4 * 2.447 / 1.96).abs() < 1e-7);
        assert_eq!(mode.crest_m, 1e-4);
        assert!((mode.crest_standard_error_m - 1e-4 * 2.447 / 1.96).abs() < 1e-7);
        let undetermined = measured(None);
        let mode = ModeAcross::new(&configured, Some(&undetermined)).unwrap();
        assert_eq!(mode.source, WavelengthSource::Configured);
        assert_eq!(
            ModeAcross::new(&plate("").unwrap(), Some(&undetermined)),
            None
        );
        assert_eq!(ModeAcross::new(&plate("").unwrap(), None), None);
    }

    #[test]
    fn a_finger_away_from_the_crest_has_no_mode_even_if_one_is_configured() {
        let configured = plate("wavelength_across_m = 0.022").unwrap();
        let mut across = measured(Some(Quantity::new(0.022, 2e-4, 6, "m")));
        for (crest_m, is_known) in [
            (1.0e-3, true),
            (1.2e-3, true),
            (1.4e-3, false),
            (5.5e-3, false),
        ] {
            for sign in [-1.0, 1.0] {
                across.crest_m = Some(Quantity::new(sign * crest_m, 1e-4, 6, "m"));
                let mode = ModeAcross::new(&configured, Some(&across));
                assert_eq!(mode.is_some(), is_known, "{crest_m}");
            }
        }
        assert!(!measured(None).is_on_crest());
    }

    #[test]
    fn an_uncertain_crest_far_from_the_fingers_line_is_not_used() {
        let mut across = measured(Some(Quantity::new(0.022, 2e-4, 6, "m")));
        for (crest_m, error_m, obstacle) in [
            (2.7e-3, 1e-3, None),
            (2.8e-3, 1e-3, Some(AcrossObstacle::OffCrest)),
            (0.0, 3e-3, Some(AcrossObstacle::OffCrest)),
        ] {
            across.crest_m = Some(Quantity::new(crest_m, error_m, 6, "m"));
            assert_eq!(across.obstacle(), obstacle, "{crest_m} ± {error_m}");
        }
    }

    #[test]
    fn a_measured_wave_shorter_than_a_finger_is_not_used_and_the_reason_is_stated() {
        let configured = plate("wavelength_across_m = 0.022").unwrap();
        for (wavelength_m, is_used) in [(7.9e-3, false), (8.1e-3, true), (0.51, false)] {
            let across = measured(Some(Quantity::new(wavelength_m, 1e-4, 6, "m")));
            let mode = ModeAcross::new(&configured, Some(&across));
            assert_eq!(mode.is_some(), is_used, "{wavelength_m}");
            let words = wavelength_in_words(&configured, Some(&across));
            assert_eq!(
                words.contains("not used: the wavelength"),
                !is_used,
                "{words}"
            );
        }
    }

    #[test]
    fn a_contradiction_beyond_the_errors_is_stated() {
        let across = measured(Some(Quantity::new(0.0245, 2e-4, 6, "m")));
        let stated = |keys: &str| contradiction(&plate(keys).unwrap(), &across);
        assert_eq!(stated(""), None);
        // 2.5 mm of an assumed 2.2 mm.
        assert_eq!(stated("wavelength_across_m = 0.022"), None);
        let sure = stated("wavelength_across_m = 0.022\nwavelength_across_relative_error = 0.05");
        assert!(
            sure.unwrap()
                .contains("22.00 mm contradicts the measured 24.50")
        );
        assert!(stated("wavelength_across_m = 0.035").is_some());
    }

    #[test]
    fn a_thin_plate_of_twice_the_thickness_has_a_wavelength_longer_by_the_square_root_of_two() {
        let thin = thin_plate_wavelength_m(2e-3, 35e3);
        let thick = thin_plate_wavelength_m(4e-3, 35e3);
        assert!((thick / thin - 2.0_f64.sqrt()).abs() < 1e-12);
        let low = thin_plate_wavelength_m(2e-3, 35e3 / 4.0);
        assert!((low / thin - 2.0).abs() < 1e-12);
    }

    #[test]
    fn the_wavelength_is_stated_with_its_source_or_with_the_way_to_measure_it() {
        let words = |keys: &str| wavelength_in_words(&plate(keys).unwrap(), None);
        assert!(words("").contains("--across 9"));
        assert!(words("thickness_m = 3.3e-3").contains("30.58"));
        let configured = words("wavelength_across_m = 0.022");
        assert_eq!(
            configured,
            "22.00 ± 2.20 mm, from plate.wavelength_across_m"
        );
    }

    #[test]
    fn every_key_across_the_plate_has_a_range() {
        for (key, low, high) in [
            ("width_m", 4e-3, 0.5),
            ("thickness_m", 1e-4, 0.02),
            ("wavelength_across_m", 8e-3, 0.5),
            ("wavelength_across_relative_error", 1e-3, 0.5),
        ] {
            for end in [low, high] {
                assert!(plate(&format!("{key} = {end:?}")).is_ok(), "{key} = {end}");
            }
            for wrong in [0.99 * low, 1.01 * high, -low, f64::NAN] {
                let number = format!("{wrong:?}").to_lowercase();
                let error = plate(&format!("{key} = {number}")).unwrap_err().to_string();
                assert!(error.contains(&format!("plate.{key}")), "{error}");
            }
        }
    }

    #[test]
    fn a_calibration_across_reads_back_and_absent_keys_stay_absent() {
        for wavelength_m in [Some(Quantity::new(0.0245, 2e-4, 6, "m")), None] {
            let across = measured(wavelength_m);
            let config = Config::parse(crate::rigs::MOCK_BENCH, "bench.toml").unwrap();
            let identity = Identity::from_config(&config, String::new(), String::new());
            let mut file = CalibrationFile::new(identity);
            file.across = Some(across);
            let text = file.to_text().unwrap();
            let (copy, _) = CalibrationFile::parse(&text, std::path::Path::new("test")).unwrap();
            assert_eq!(copy, file);
        }
        let copy = toml::to_string(&plate("").unwrap()).unwrap();
        assert!(
            !copy.contains("across") && !copy.contains("width_m"),
            "{copy}"
        );
    }
}
