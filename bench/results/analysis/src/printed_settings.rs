//! Settings as printed in results and tables: every assumed number, and how each method uses the amplitude and the
//! normal force, and where the ambient pressure and the wavelength across the plate come from.

use serde::Serialize;

use crate::analysis_settings::Settings;
use crate::findings::Analysis;

/// Statement on recordings without a wavelength.
const UNKNOWN_WIDTH: &str =
    "width of the finger across the mode not known: included in interval95 of trial";
/// Statement on recordings with one.
const KNOWN_WAVELENGTH: &str = "wavelength across the plate as recorded: plate.across";

/// Content of `settings`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PrintedSettings {
    /// Assumed numbers.
    #[serde(flatten)]
    pub settings: Settings,
    /// Source of the amplitude.
    pub amplitude_along_plate: AmplitudeSource,
    /// Normal force.
    pub normal_force: ForceSource,
    /// Source of the ambient pressure, in words.
    pub ambient_pressure: String,
    /// Source of the wavelength across the plate, in words, or the lack of it.
    pub finger_across_mode: String,
}

/// Normal force used by each method.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ForceSource {
    /// Force used by `paper`.
    pub paper: &'static str,
    /// Force used by `dynamic`.
    pub dynamic: &'static str,
}

/// Source of the amplitude under the finger for each method.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AmplitudeSource {
    /// Amplitude used by `paper`.
    pub paper: &'static str,
    /// Amplitude used by `dynamic`.
    pub dynamic: String,
}

impl PrintedSettings {
    /// Returns the settings of an analysis.
    pub fn new(analysed: &Analysis) -> Self {
        let (mut recordings, mut profiles, mut pressures, mut wavelengths) = (0, 0, 0, 0);
        for findings in analysed.findings() {
            let plate = findings.plate();
            recordings += 1;
            profiles += usize::from(plate.is_some_and(|plate| plate.profile.is_some()));
            pressures += usize::from(findings.manifest.room.is_some());
            wavelengths += usize::from(plate.is_some_and(|plate| plate.across.is_some()));
        }
        Self {
            normal_force: ForceSource {
                paper: "low-passed, as published",
                dynamic: "without its sensor's noise as its spectrum tells; low-passed where it does not",
            },
            settings: analysed.settings,
            amplitude_along_plate: AmplitudeSource {
                paper: "uniform, as published: that at the pickup",
                dynamic: match profiles {
                    0 => "uniform: no recording has plate.profile".to_owned(),
                    _ if profiles == recordings => "as measured: plate.profile".to_owned(),
                    _ => format!(
                        "as measured, plate.profile, in {profiles} of {recordings} recordings; uniform in the others"
                    ),
                },
            },
            ambient_pressure: match pressures {
                0 => "assumed: no recording has room.pressure_hpa".to_owned(),
                _ if pressures == recordings => "as measured: room.pressure_hpa".to_owned(),
                _ => format!(
                    "as measured, room.pressure_hpa, in {pressures} of {recordings} recordings; assumed in the others"
                ),
            },
            finger_across_mode: match wavelengths {
                0 => UNKNOWN_WIDTH.to_owned(),
                _ if wavelengths == recordings => KNOWN_WAVELENGTH.to_owned(),
                _ => format!(
                    "{KNOWN_WAVELENGTH}, in {wavelengths} of {recordings} recordings; in the others {UNKNOWN_WIDTH}"
                ),
            },
        }
    }
}
