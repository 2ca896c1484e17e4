//! The built-in protocols.

/// Names and texts of the built-in protocols: `huloux2021` is the published one, `consistency` a check of the laws under several
/// drives, `demo` a short form of the published one.
pub const BUILT_IN: [(&str, &str); 3] = [
    ("huloux2021", include_str!("../../huloux2021.toml")),
    ("consistency", include_str!("../../consistency.toml")),
    ("demo", include_str!("../../demo.toml")),
];

/// A commented protocol to write another one from. Lines that begin with `#= ` state the defaults of keys that may be left
/// out.
pub const TEMPLATE: &str = include_str!("../../template.toml");

/// Returns the text of the built-in protocol `name`, or `None` if it does not exist.
pub fn built_in(name: &str) -> Option<&'static str> {
    BUILT_IN
        .iter()
        .find(|(key, _)| *key == name)
        .map(|(_, text)| *text)
}

/// Returns the built-in protocol most likely meant by `name`: the one with the closest spelling, or the only one that
/// contains it or is contained in it. `None` if none is close.
///
/// ```
/// assert_eq!(protocols::nearest_built_in("huloux"), Some("huloux2021"));
/// ```
pub fn nearest_built_in(name: &str) -> Option<&'static str> {
    let names = BUILT_IN.map(|(key, _)| key);
    let nearest = strict_toml::nearest(name, &names)?;
    names.into_iter().find(|key| *key == nearest)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_misspelt_or_shortened_name_suggests_the_protocol() {
        for name in ["huloux", "huloux2012", "hulox2021", "2021"] {
            assert_eq!(nearest_built_in(name), Some("huloux2021"), "{name}");
        }
        assert_eq!(nearest_built_in("dmeo"), Some("demo"));
        assert_eq!(nearest_built_in("consistent"), Some("consistency"));
        assert_eq!(nearest_built_in("study-7.toml"), None);
    }
}
