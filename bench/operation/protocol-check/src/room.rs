//! Conditions of the room, as the bench is configured.

use config::Config;

/// Returns the remark about an ambient pressure that is hardly one in hPa.
#[must_use]
pub fn unusual_pressure(config: &Config) -> Option<String> {
    let finding = plausibility::pressure(config.room.pressure_hpa?)?;
    Some(finding.to_string())
}
