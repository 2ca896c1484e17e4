//! Summary of an analysis, as text for a terminal.

use analysis::whole_trial;
use escaping::escaped_line;
use population::law_check::{LawCheck, law_checks};
use published_statistics::{TableFormat, statistics};
use report::count_text;

use crate::study_analysis::StudyAnalysis;
use crate::warnings::rejections;

/// Returns the table of statistics as a text for a terminal of `columns` columns, with the account of the attempts, the descriptive
/// table and the skin.
#[must_use]
pub fn table(study: &StudyAnalysis, columns: Option<u16>) -> String {
    let format = TableFormat::Text { columns };
    account_lines(study)
        + &recordings_without_instances(study)
        + &study.description.to_text(columns)
        + "\n"
        + &statistics(&study.analysed).to_table(format)
        + &skin_lines(study)
}

/// Returns the descriptive table, a line for each recording, the parameters that its instances share, the account of the attempts and
/// the skin.
#[must_use]
pub fn text(study: &StudyAnalysis, columns: Option<u16>) -> String {
    study.description.to_text(columns)
        + &recording_lines(study)
        + &account_lines(study)
        + &skin_lines(study)
}

fn account_lines(study: &StudyAnalysis) -> String {
    lines(study.account.lines())
}

/// Returns the lines of the skin, and of the participants with trials under several conditions.
fn skin_lines(study: &StudyAnalysis) -> String {
    let checks = law_checks(&study.analysed);
    lines(study.skin.lines()) + &lines(checks.iter().flat_map(LawCheck::lines))
}

fn lines(lines: impl IntoIterator<Item = String>) -> String {
    lines.into_iter().map(|line| line + "\n").collect()
}

/// Returns a line for each recording without an instance, with the reasons.
fn recordings_without_instances(study: &StudyAnalysis) -> String {
    let lines = study.analysed.findings().filter_map(|findings| {
        let path = findings.path.display().to_string();
        let text = rejections(findings)?;
        Some(format!(
            "{}: 0 instances, rejected: {text}\n",
            escaped_line(&path)
        ))
    });
    lines.collect()
}

/// Returns a line for each recording, and one for the parameters that its instances share.
fn recording_lines(study: &StudyAnalysis) -> String {
    let mut lines = String::new();
    for recording in &study.analysed.recordings {
        let counts = match &recording.findings {
            Ok(findings) => format!(
                "{}, {}, {}",
                count_text(findings.instances.len(), "instance", "instances"),
                count_text(
                    findings.rejected.len(),
                    "stretch rejected",
                    "stretches rejected"
                ),
                count_text(findings.flaws.len(), "warning", "warnings")
            ),
            Err(_) => "cannot be read".to_owned(),
        };
        lines.push_str(&format!(
            "{}: {counts}\n",
            escaped_line(&recording.path.display().to_string())
        ));
        if let Ok(findings) = &recording.findings {
            lines.extend(rejections(findings).map(|text| format!("  rejected: {text}\n")));
            let trial_lines = whole_trial::lines(findings);
            lines.extend(trial_lines.iter().map(|line| format!("  {line}\n")));
        }
    }
    lines
}

/// Returns the numbers of recordings, instances and warnings.
#[must_use]
pub fn counts(study: &StudyAnalysis) -> String {
    let counted = |count: usize, noun: &str| match count {
        1 => format!("1 {noun}"),
        _ => format!("{count} {noun}s"),
    };
    let warnings = study.analysed.findings().map(|f| f.flaws.len()).sum();
    format!(
        "{}: {}, {}, {}",
        escaped_line(&study.name),
        counted(study.analysed.recordings.len(), "recording"),
        counted(study.analysed.instances().count(), "instance"),
        counted(warnings, "warning")
    )
}
