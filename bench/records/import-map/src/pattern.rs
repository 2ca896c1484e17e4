//! Names of files: the pattern that they match, and names with the text captured from it.

use std::collections::BTreeMap;

use regex::Regex;

/// Groups with a meaning of their own.
pub const KNOWN_GROUPS: [&str; 6] = [
    "participant",
    "session",
    "trial",
    "attempt",
    "condition",
    "part",
];

/// Text captured from a file's path, by the name of the group.
pub type Captures = BTreeMap<String, String>;

/// Pattern of the whole path of a file relative to the map's folder, with `/` between its parts.
#[derive(Debug, Clone)]
pub struct FilePattern {
    regex: Regex,
    /// Text of groups that the map states for all files.
    place: Captures,
}

impl FilePattern {
    /// Reads a regular expression with named groups.
    ///
    /// # Errors
    /// The reason in words.
    pub fn parse(text: &str) -> Result<Self, String> {
        let regex = Regex::new(&format!("^(?:{text})$")).map_err(|error| {
            let message = match error {
                regex::Error::CompiledTooBig(_) => "it is too large".to_owned(),
                error => error.to_string(),
            };
            let reason = message.lines().last().unwrap_or_default();
            format!(
                "is not a regular expression ({}); write . for any character, \\. for a dot, and (?<participant>\\d+) for \
                 the digits of a participant",
                reason.trim_start_matches("error: ")
            )
        })?;
        Ok(Self {
            regex,
            place: Captures::new(),
        })
    }

    /// Makes the pattern of a name with placeholders: `{participant}` stands for any text without `/`, and for digits in the
    /// place of numbers.
    ///
    /// # Errors
    /// The reason in words.
    pub fn from_template(template: &Template) -> Result<Self, String> {
        let mut text = String::new();
        let mut seen = Vec::new();
        for part in &template.parts {
            match part {
                Part::Text(literal) => text += &regex::escape(literal),
                // A name that stands twice is compared by the caller, which fills the template with the captured text.
                Part::Placeholder(name) if seen.contains(&name) => text += "[^/]+?",
                Part::Placeholder(name) => {
                    let class = match name.as_str() {
                        "session" | "trial" | "attempt" | "part" => r"\d+",
                        _ => "[^/]+?",
                    };
                    text += &format!("(?<{name}>{class})");
                    seen.push(name);
                }
            }
        }
        Self::parse(&text)
    }

    /// Adds groups with the same text for all files.
    #[must_use]
    pub fn with_place(mut self, texts: impl Iterator<Item = (&'static str, String)>) -> Self {
        let texts = texts.map(|(name, text)| (name.to_owned(), text));
        self.place.extend(texts);
        self
    }

    /// Returns the names of the groups.
    pub fn groups(&self) -> impl Iterator<Item = &str> {
        let stated = self.place.keys().map(String::as_str);
        self.regex.capture_names().flatten().chain(stated)
    }

    /// Returns the text captured from a path; `None` if the pattern does not match the whole path.
    #[must_use]
    pub fn captures(&self, path: &str) -> Option<Captures> {
        let captures = self.regex.captures(path)?;
        let names = self.regex.capture_names().flatten();
        let captured = names.filter_map(|name| {
            let text = captures.name(name)?.as_str();
            Some((name.to_owned(), text.to_owned()))
        });
        Some(captured.chain(self.place.clone()).collect())
    }
}

/// Part of a name.
#[derive(Debug, Clone, PartialEq, Eq)]
enum Part {
    Text(String),
    Placeholder(String),
}

/// Name of a file in which `{name}` stands for captured text.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Template {
    parts: Vec<Part>,
    text: String,
}

impl Template {
    /// Reads a name with placeholders.
    ///
    /// # Errors
    /// The reason in words: a brace without its partner, or an empty placeholder.
    pub fn parse(text: &str) -> Result<Self, String> {
        let mut parts = Vec::new();
        let mut rest = text;
        while let Some(open) = rest.find('{') {
            let close = rest[open..].find('}').map(|close| open + close);
            let name = close.map(|close| &rest[open + 1..close]);
            let is_name = |name: &&str| {
                let mut letters = name.chars();
                letters
                    .next()
                    .is_some_and(|c| c.is_ascii_alphabetic() || c == '_')
                    && letters.all(|c| c.is_ascii_alphanumeric() || c == '_')
            };
            let (Some(close), Some(name)) = (close, name.filter(is_name)) else {
                return Err(format!(
                    "has a `{{` that begins no placeholder in `{text}`; write the name of a group, such as {{participant}}"
                ));
            };
            if open > 0 {
                parts.push(Part::Text(rest[..open].to_owned()));
            }
            parts.push(Part::Placeholder(name.to_owned()));
            rest = &rest[close + 1..];
        }
        if !rest.is_empty() {
            parts.push(Part::Text(rest.to_owned()));
        }
        match parts.is_empty() {
            true => Err("is empty; write the name of a file".to_owned()),
            false => Ok(Self {
                parts,
                text: text.to_owned(),
            }),
        }
    }

    /// Returns the names of the placeholders.
    pub fn placeholders(&self) -> impl Iterator<Item = &str> {
        self.parts.iter().filter_map(|part| match part {
            Part::Text(_) => None,
            Part::Placeholder(name) => Some(name.as_str()),
        })
    }

    /// Returns the name with captured text; a group that captured none leaves its place empty.
    #[must_use]
    pub fn fill(&self, captures: &Captures) -> String {
        let texts = self.parts.iter().map(|part| match part {
            Part::Text(text) => text.as_str(),
            Part::Placeholder(name) => captures.get(name).map_or("", String::as_str),
        });
        texts.collect()
    }

    /// Returns the name as written.
    #[must_use]
    pub fn as_str(&self) -> &str {
        &self.text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pattern_matches_the_whole_path_and_names_its_groups() {
        let pattern =
            FilePattern::parse(r"day \d/S(?<participant>\d+)_T(?<trial>\d+)\.mat").unwrap();
        let captures = pattern.captures("day 2/S01_T12.mat").unwrap();
        assert_eq!(
            (&*captures["participant"], &*captures["trial"]),
            ("01", "12")
        );
        for other in [
            "S01_T12.mat",
            "day 2/S01_T12.mat.bak",
            "x/day 2/S01_T12.mat",
            "day 2/S01_T12xmat",
        ] {
            assert!(pattern.captures(other).is_none(), "{other}");
        }
        let alternatives = FilePattern::parse("a|b").unwrap();
        assert!(alternatives.captures("a").is_some() && alternatives.captures("ab").is_none());
        let error = FilePattern::parse("S(?<participant").unwrap_err();
        assert!(error.contains("regular expression"), "{error}");
    }

    #[test]
    fn a_name_with_placeholders_is_filled_and_matched() {
        let template = Template::parse("force_S{participant}_T{trial}.csv").unwrap();
        assert_eq!(
            template.placeholders().collect::<Vec<_>>(),
            ["participant", "trial"]
        );
        let pattern = FilePattern::from_template(&template).unwrap();
        let captures = pattern.captures("force_SAB_T07.csv").unwrap();
        assert_eq!(template.fill(&captures), "force_SAB_T07.csv");
        assert!(pattern.captures("force_SAB_Tx.csv").is_none());
        assert!(pattern.captures("force_SAB_T07xcsv").is_none());
        for wrong in ["a{participant", "a{}b", "a{1}", ""] {
            assert!(Template::parse(wrong).is_err(), "{wrong}");
        }
    }
}
