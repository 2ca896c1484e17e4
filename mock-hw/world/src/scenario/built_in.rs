//! The scenarios that come with the program.

use super::scenario_error::ScenarioError;
use super::scenario_file::Scenario;

/// Names and texts of the built-in scenarios.
const BUILT_IN: [(&str, &str); 7] = [
    ("nominal", include_str!("../../scenarios/nominal.toml")),
    ("steady", include_str!("../../scenarios/steady.toml")),
    ("noisy", include_str!("../../scenarios/noisy.toml")),
    (
        "population",
        include_str!("../../scenarios/population.toml"),
    ),
    (
        "participant-late",
        include_str!("../../scenarios/participant-late.toml"),
    ),
    (
        "bench-unknown",
        include_str!("../../scenarios/bench-unknown.toml"),
    ),
    ("arduino", include_str!("../../scenarios/arduino.toml")),
];

/// Returns the names of the built-in scenarios.
///
/// ```
/// assert!(mock_world::scenario::built_in_names().contains(&"nominal"));
/// ```
#[must_use]
pub fn built_in_names() -> [&'static str; BUILT_IN.len()] {
    BUILT_IN.map(|(name, _)| name)
}

/// Returns the built-in scenario of that name.
///
/// # Errors
/// [`ScenarioError::UnknownName`], with the names of all built-in scenarios and the one most like `name`.
///
/// ```
/// use mock_world::scenario::{ScenarioError, built_in};
///
/// assert_eq!(built_in("nominal")?.participant.mu0, Some(0.8));
/// let error = built_in("nominl").unwrap_err();
/// assert!(matches!(error, ScenarioError::UnknownName { nearest: Some(name), .. } if name == "nominal"));
/// # Ok::<(), ScenarioError>(())
/// ```
pub fn built_in(name: &str) -> Result<Scenario, ScenarioError> {
    match BUILT_IN.iter().find(|(known, _)| *known == name) {
        Some((_, text)) => Scenario::parse(text, &format!("{name}.toml")),
        None => {
            let known = built_in_names();
            Err(ScenarioError::UnknownName {
                name: name.to_owned(),
                nearest: strict::nearest(name, &known),
                known: known.map(str::to_owned).into(),
            })
        }
    }
}
