//! `[plate.profile]`: amplitude along the plate, relative to the amplitude at the pickup.

use serde::{Deserialize, Serialize};

use super::manifest_error::{MAX_ENTRIES, ManifestError, require, require_finite, require_range};

/// Smallest and largest ratio of a profile; beyond them the finger, or the pickup, would be near a node of the plate.
pub const PROFILE_RATIOS: [f64; 2] = [0.2, 2.0];
/// Smallest number of positions in a profile.
const MIN_POSITIONS: usize = 2;
/// Smallest distance between positions, m.
const MIN_STEP_M: f64 = 1e-6;

/// Amplitude at places along the plate relative to that read by the pickup.
///
/// ```
/// use recording::manifest::RecordedProfile;
///
/// let mut profile = RecordedProfile { positions_m: vec![0.005, 0.0525, 0.1], ratios: vec![0.92, 1.0, 0.92] };
/// assert!(profile.validate().is_ok());
/// profile.ratios.pop();
/// assert!(profile.validate().is_err());
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct RecordedProfile {
    /// Places on the scale of `position.csv`, metres, in order.
    pub positions_m: Vec<f64>,
    /// Amplitude at each place relative to that read by the pickup.
    pub ratios: Vec<f64>,
}

impl RecordedProfile {
    /// Checks that there is a ratio for each position, and the range of each ratio.
    ///
    /// # Errors
    /// The first violated rule.
    pub fn validate(&self) -> Result<(), ManifestError> {
        const POSITIONS: &str = "plate.profile.positions_m";
        const RATIOS: &str = "plate.profile.ratios";
        let places = self.positions_m.len();
        for (key, count) in [(POSITIONS, places), (RATIOS, self.ratios.len())] {
            if count > MAX_ENTRIES {
                return Err(ManifestError::TooMany { key, count });
            }
        }
        if places < MIN_POSITIONS || self.ratios.len() != places {
            return Err(ManifestError::ProfilePlaces {
                positions: places,
                ratios: self.ratios.len(),
            });
        }
        let key_at = |key: &str, index: usize| format!("{key}.{index}");
        for (index, &position_m) in self.positions_m.iter().enumerate() {
            require_finite(&key_at(POSITIONS, index), position_m)?;
        }
        let [least, greatest] = PROFILE_RATIOS;
        for (index, &ratio) in self.ratios.iter().enumerate() {
            require_range(&key_at(RATIOS, index), ratio, least..=greatest)?;
        }
        for (index, pair) in self.positions_m.windows(2).enumerate() {
            let allowed = format!(
                "positions at least {MIN_STEP_M} m beyond the one before, which is {}",
                pair[0]
            );
            let is_increasing = pair[1] - pair[0] >= MIN_STEP_M;
            require(
                is_increasing,
                &key_at(POSITIONS, index + 1),
                pair[1],
                &allowed,
            )?;
        }
        Ok(())
    }
}
