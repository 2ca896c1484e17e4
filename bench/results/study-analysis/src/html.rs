//! Analysis as a small table of HTML.

use crate::study_analysis::StudyAnalysis;
use crate::summary::counts;

/// Most recordings that the table lists.
const LISTED: usize = 20;

/// Returns a small table of the recordings as HTML, for a notebook.
#[must_use]
pub fn table(study: &StudyAnalysis) -> String {
    let mut rows = String::new();
    for recording in study.analysed.recordings.iter().take(LISTED) {
        let name = recording
            .path
            .file_name()
            .unwrap_or(recording.path.as_os_str());
        let cells = match &recording.findings {
            Ok(findings) => [
                findings.instances.len().to_string(),
                findings.rejected.len().to_string(),
                findings.flaws.len().to_string(),
            ],
            Err(_) => ["cannot be read", "", ""].map(str::to_owned),
        };
        let texts = [
            name.to_string_lossy().into_owned(),
            recording.participant.clone().unwrap_or_default(),
        ];
        let texts = texts.into_iter().chain(cells);
        let row: String = texts
            .map(|text| format!("<td>{}</td>", escaping::xml_text(&text)))
            .collect();
        rows += &format!("<tr>{row}</tr>");
    }
    let rest = study.analysed.recordings.len().saturating_sub(LISTED);
    if rest > 0 {
        rows += &format!("<tr><td colspan=\"5\">and {rest} more</td></tr>");
    }
    format!(
        "<table><caption>{}</caption><thead><tr><th>recording</th><th>participant</th><th>instances</th><th>rejected</th>\
         <th>warnings</th></tr></thead><tbody>{rows}</tbody></table>",
        escaping::xml_text(&counts(study))
    )
}

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;
    use std::path::PathBuf;

    use analysis::Settings;
    use study::exclusions::RecordingSelection;

    use super::*;
    use crate::found::Found;

    fn found(names: impl Iterator<Item = String>) -> Found {
        let folder = tempfile::tempdir().unwrap();
        Found {
            name: "a < b".to_owned(),
            selection: RecordingSelection {
                recordings: names.map(|name| folder.path().join(name)).collect(),
                ..RecordingSelection::default()
            },
            ..Found::default()
        }
    }

    #[test]
    fn names_are_texts_and_long_lists_end_with_their_number() {
        let missing = found((0..23).map(|number| format!("<b>{number}")));
        let study = missing.analyse(&Settings::default(), |_| ControlFlow::Continue(()));
        let html = table(&study.unwrap().unwrap());
        assert!(
            html.contains("<td>&lt;b&gt;19</td><td></td><td>cannot be read</td>"),
            "{html}"
        );
        assert!(html.contains("a &lt; b: 23 recordings, 0 instances, 0 warnings"));
        assert!(html.contains("and 3 more") && !html.contains("20</td>"));
    }

    #[test]
    fn an_analysis_that_is_broken_off_has_no_results() {
        let missing = found((0..4).map(|number| number.to_string()));
        let folders: Vec<PathBuf> = missing.recordings().to_vec();
        let study = missing.analyse(&Settings::default(), |analysis| {
            match analysis.path == folders[0] {
                true => ControlFlow::Break(()),
                false => ControlFlow::Continue(()),
            }
        });
        assert!(study.unwrap().is_none());
    }
}
