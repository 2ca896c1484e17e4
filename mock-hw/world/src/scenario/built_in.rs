//! Scenarios built into the program.

use super::scenario_error::ScenarioError;
use super::scenario_file::Scenario;

/// Names and texts of the built-in scenarios. Each of `laws/` breaks one law of the published model.
const BUILT_IN: [(&str, &str); 21] = [
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
    (
        "population-unkind",
        include_str!("../../scenarios/population-unkind.toml"),
    ),
    ("arduino", include_str!("../../scenarios/arduino.toml")),
    ("gauges", include_str!("../../scenarios/gauges.toml")),
    ("field-box", include_str!("../../scenarios/field-box.toml")),
    (
        "finger-wide",
        include_str!("../../scenarios/finger-wide.toml"),
    ),
    ("net-ft", include_str!("../../scenarios/net-ft.toml")),
    (
        "laws/asperities-gaussian",
        include_str!("../../scenarios/laws/asperities-gaussian.toml"),
    ),
    (
        "laws/adhesion",
        include_str!("../../scenarios/laws/adhesion.toml"),
    ),
    (
        "laws/film-leaks",
        include_str!("../../scenarios/laws/film-leaks.toml"),
    ),
    (
        "laws/lag-gap-dependent",
        include_str!("../../scenarios/laws/lag-gap-dependent.toml"),
    ),
    (
        "laws/friction-viscous",
        include_str!("../../scenarios/laws/friction-viscous.toml"),
    ),
    (
        "laws/friction-load",
        include_str!("../../scenarios/laws/friction-load.toml"),
    ),
    (
        "laws/tissue-force",
        include_str!("../../scenarios/laws/tissue-force.toml"),
    ),
    (
        "laws/contact-dashpot",
        include_str!("../../scenarios/laws/contact-dashpot.toml"),
    ),
    (
        "laws/plate-softens",
        include_str!("../../scenarios/laws/plate-softens.toml"),
    ),
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

/// Returns the text of the built-in scenario `name`; `None` without one of this name.
///
/// ```
/// assert!(mock_world::scenario::built_in_text("field-box").is_some_and(|text| text.contains("interface")));
/// ```
#[must_use]
pub fn built_in_text(name: &str) -> Option<&'static str> {
    let mut scenarios = BUILT_IN.iter();
    scenarios.find_map(|(key, text)| (*key == name).then_some(*text))
}

/// Returns the built-in scenario `name`.
///
/// # Errors
/// [`ScenarioError::UnknownName`], with the names of all built-in scenarios and the one most similar to `name`.
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
    match built_in_text(name) {
        Some(text) => Scenario::parse(text, &format!("{name}.toml")),
        None => {
            let names = built_in_names();
            let (laws, plain_names): (Vec<&str>, Vec<&str>) =
                names.iter().partition(|name| name.starts_with("laws/"));
            // An unknown name more likely means a whole scenario than a law, unless it begins with `laws/` or ends a law's
            // name.
            let law = strict_toml::nearest(name, &laws);
            let is_law = |law: &String| name.starts_with("laws/") || law.ends_with(name);
            let nearest = law
                .clone()
                .filter(is_law)
                .or_else(|| strict_toml::nearest(name, &plain_names))
                .or(law);
            Err(ScenarioError::UnknownName {
                name: name.to_owned(),
                nearest,
                names: names.map(str::to_owned).into(),
            })
        }
    }
}
