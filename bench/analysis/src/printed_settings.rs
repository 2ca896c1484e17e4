//! Settings as printed in results and tables: every assumed number, and how each method uses the amplitude and the
//! normal force.

use serde::Serialize;

use crate::analysed::Analysed;
use crate::analysis_settings::Settings;

/// Content of `settings`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PrintedSettings {
    #[serde(flatten)]
    settings: Settings,
    amplitude_along_plate: AmplitudeTaken,
    normal_force: ForceTaken,
}

/// Normal force used by each method.
#[derive(Debug, Clone, PartialEq, Serialize)]
struct ForceTaken {
    paper: &'static str,
    dynamic: &'static str,
}

/// Source of the amplitude under the finger for each method.
#[derive(Debug, Clone, PartialEq, Serialize)]
struct AmplitudeTaken {
    paper: &'static str,
    dynamic: String,
}

impl PrintedSettings {
    /// Returns the settings of an analysis.
    pub fn of(analysed: &Analysed) -> Self {
        let (mut recordings, mut measured) = (0, 0);
        for found in analysed.findings() {
            recordings += 1;
            measured += usize::from(found.plate().profile.is_some());
        }
        Self {
            normal_force: ForceTaken {
                paper: "low-passed, as published",
                dynamic: "without its sensor's noise as its spectrum tells; low-passed where it does not",
            },
            settings: analysed.settings,
            amplitude_along_plate: AmplitudeTaken {
                paper: "uniform, as published: that at the pickup",
                dynamic: match measured {
                    0 => "uniform: no recording has plate.profile".to_owned(),
                    _ if measured == recordings => "as measured: plate.profile".to_owned(),
                    _ => format!(
                        "as measured, plate.profile, in {measured} of {recordings} recordings; uniform in the others"
                    ),
                },
            },
        }
    }
}
