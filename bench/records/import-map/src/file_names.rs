//! Reading of the names of files: the map's pattern, and the names with placeholders.

use std::collections::BTreeSet;

use crate::check::Check;
use crate::pattern::{FilePattern, KNOWN_GROUPS, Template};
use crate::raw::RawMap;

/// Keys of files that a recording has once, even if it is split over several files.
const WHOLE_FILES: [&str; 2] = ["intervals.marks", "baseline.file"];

impl Check<'_> {
    pub fn pattern(&mut self, raw: &RawMap) -> Option<FilePattern> {
        let stream_files = self.stream_files(raw);
        let parsed = match &raw.files {
            Some(text) => FilePattern::parse(text),
            None => match stream_files.first() {
                Some((_, template)) => FilePattern::from_template(template),
                None => {
                    self.missing(
                        None,
                        "files",
                        r"write a regular expression for the files' names, such as files = 'S(?<participant>\d+)_T(?<trial>\d+)\.mat'",
                    );
                    return None;
                }
            },
        };
        let pattern = match parsed {
            Ok(pattern) => pattern,
            Err(fault) => {
                self.wrong("files", fault);
                return None;
            }
        };
        for (name, _) in raw.place.texts() {
            if pattern.groups().any(|group| group == name) {
                self.wrong(
                    &format!("place.{name}"),
                    format!("is stated, and `files` captures {name} too: leave one of them out"),
                );
            }
        }
        let pattern = pattern.with_place(raw.place.texts());
        let groups: BTreeSet<String> = pattern.groups().map(str::to_owned).collect();
        let used: BTreeSet<String> = stream_files
            .iter()
            .flat_map(|(_, template)| template.placeholders().map(str::to_owned))
            .collect();
        for (key, template) in &stream_files {
            for name in template
                .placeholders()
                .filter(|name| !groups.contains(*name))
            {
                let known: Vec<String> = groups.iter().cloned().collect();
                let nearest = strict_toml::nearest(name, &known);
                let nearest = nearest
                    .map(|nearest| format!(", did you mean {{{nearest}}}?"))
                    .unwrap_or_default();
                self.wrong(
                    key,
                    format!("names {{{name}}}, which `files` does not capture{nearest}"),
                );
            }
        }
        for (key, template) in &stream_files {
            let is_whole = WHOLE_FILES.contains(key);
            if is_whole && template.placeholders().any(|name| name == "part") {
                self.wrong(
                    key,
                    "names {part}, and it is of the whole recording: leave {part} out".to_owned(),
                );
            }
        }
        let known = KNOWN_GROUPS.map(str::to_owned);
        for group in groups
            .iter()
            .filter(|group| !known.contains(group) && !used.contains(*group))
        {
            let nearest = strict_toml::nearest(group, &known);
            let nearest = nearest
                .map(|nearest| format!(", did you mean `{nearest}`?"))
                .unwrap_or_default();
            self.wrong(
                "files",
                format!(
                    "captures `{group}`, which nothing uses{nearest}; known: {}",
                    KNOWN_GROUPS.join(", ")
                ),
            );
        }
        Some(pattern)
    }

    /// Returns the names of files with placeholders, the streams' first, with their keys.
    fn stream_files(&mut self, raw: &RawMap) -> Vec<(&'static str, Template)> {
        let names = [
            (
                "drive.file",
                raw.drive.as_ref().and_then(|table| table.file.as_deref()),
            ),
            (
                "envelopes.file",
                raw.envelopes
                    .as_ref()
                    .and_then(|table| table.file.as_deref()),
            ),
            (
                "normal.file",
                raw.normal.as_ref().and_then(|table| table.file.as_deref()),
            ),
            (
                "lateral.file",
                raw.lateral.as_ref().and_then(|table| table.file.as_deref()),
            ),
            (
                "pickup.file",
                raw.pickup.as_ref().and_then(|table| table.file.as_deref()),
            ),
            (
                "position.file",
                raw.position
                    .as_ref()
                    .and_then(|table| table.file.as_deref()),
            ),
            (
                "velocity.file",
                raw.velocity
                    .as_ref()
                    .and_then(|table| table.file.as_deref()),
            ),
            (
                "intervals.marks",
                raw.intervals
                    .as_ref()
                    .and_then(|table| table.marks.as_deref()),
            ),
            (
                "baseline.file",
                raw.baseline.as_ref().map(|table| table.file.as_str()),
            ),
        ];
        let parsed =
            |(key, text): (&'static str, Option<&str>)| Some((key, Template::parse(text?).ok()?));
        names.into_iter().filter_map(parsed).collect()
    }
}
