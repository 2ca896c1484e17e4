//! Warnings of an analysis, each as a line of printable characters.

use analysis::findings::{RecordingFindings, rejection_counts};
use analysis::{Analysis, RecordingAnalysis};
use attempts::{AttemptAccount, missed_lines};
use escaping::{escaped, escaped_line};
use population::session_clock::session_clocks;
use recording::manifest::assumed_errors::assumed_terms;
use study::exclusions::ExclusionsError;

use crate::found::Found;
use crate::shared_numbers::shared_numbers;
use crate::study_analysis::{StudyAnalysis, excluded_recordings};
use crate::unlike_drives::unlike_drives;

/// Returns the defects of a recording.
#[must_use]
pub fn of_recording(recording: &RecordingAnalysis) -> Vec<String> {
    let path = recording.path.display().to_string();
    let path = escaped_line(&path);
    match &recording.findings {
        Ok(findings) => {
            let flaws = report::warnings(findings).into_iter();
            let reasons = rejections(findings).map(|reasons| format!("no instance: {reasons}"));
            let texts = flaws.chain(reasons);
            texts
                .map(|text| format!("{path}: warning: {}", escaped(&text)))
                .collect()
        }
        Err(error) => vec![format!(
            "{path}: cannot be read: {}",
            escaped(&error.to_string())
        )],
    }
}

/// Returns the kinds of a recording's rejected stretches with their numbers, if it has no instance.
pub(crate) fn rejections(findings: &RecordingFindings) -> Option<String> {
    if !findings.instances.is_empty() {
        return None;
    }
    let kinds = findings.rejected.iter().map(|stretch| &*stretch.kind);
    let counts = rejection_counts(kinds).into_iter();
    let counts: Vec<String> = counts.map(|(kind, n)| format!("{n} {kind}")).collect();
    (!counts.is_empty()).then(|| counts.join(", "))
}

/// Returns the copies, the recordings with the numbers of another one, the conditions with different drives, the accepted trials that are not in the analysis (except
/// unreadable ones, which are defects of a recording), the recordings that are no calibrated measurement on a person made with all
/// stops, the sessions whose forces have a clock of another rate, and the standard errors that are assumed of constants.
#[must_use]
pub fn of_study(study: &StudyAnalysis) -> Vec<String> {
    let copies = study.attempts.copies.iter();
    let copies = copies.map(|copy| {
        let copy = copy.to_string();
        format!("warning: not counted: {}", escaped_line(&copy))
    });
    let shared = shared_numbers(&study.analysed.recordings).into_iter();
    let unlike = unlike_drives(&study.analysed.recordings).into_iter();
    let mixed = shared.chain(unlike);
    let mixed = mixed.map(|line| format!("warning: {}", escaped_line(&line)));
    let provenance = study.analysed.provenance().counts;
    let provenance = provenance
        .iter()
        .map(|count| format!("warning: {}", escaped(&count.to_string())));
    let clocks = session_clocks(&study.analysed);
    let clocks = clocks.iter().filter(|clock| clock.is_fault());
    let clocks = clocks.map(|clock| format!("warning: {}", escaped(&clock.to_string())));
    let unread = study.selection.unread.iter().map(|path| {
        let path = path.display().to_string();
        format!(
            "warning: {}: nothing reads it; exclusions are the lines of exclusions.tsv: put its lines there, or move it away",
            escaped_line(&path)
        )
    });
    let lines = copies
        .chain(unread)
        .chain(mixed)
        .chain(of_account(&study.account))
        .chain(provenance);
    let lines = lines.chain(clocks);
    lines.chain(assumptions(study)).collect()
}

/// Returns the accepted trials and logs of recordings found that are not in their analysis.
///
/// # Errors
/// The exclusions of a study cannot be read.
pub fn of_found(found: &Found) -> Result<Vec<String>, ExclusionsError> {
    let excluded = excluded_recordings(&found.attempts, &found.selection)?;
    let account = found.attempts.account(&Analysis::default(), &excluded);
    Ok(of_account(&account))
}

fn of_account(account: &AttemptAccount) -> Vec<String> {
    let missed = missed_lines(account.missed()).into_iter();
    let missed = missed.map(|line| format!("warning: left out: {}", escaped(&line)));
    let logs = account.unread_logs.iter();
    let logs = logs.map(|log| format!("warning: {}", escaped(log)));
    missed.chain(logs).collect()
}

/// Returns the standard errors that are assumed of the recordings' constants.
fn assumptions(study: &StudyAnalysis) -> Option<String> {
    let findings = study.analysed.findings();
    let budgets = findings.map(|findings| findings.errors.assumptions);
    let terms = assumed_terms(&budgets.collect::<Vec<_>>());
    let is_in_memory = study.analysed.findings().all(|f| f.provenance.in_memory);
    (!terms.is_empty()).then(|| {
        let note = format!(
            "note: the total intervals include standard errors assumed of constants of which a recording neither states nor shows \
             the error: {}; calibrate the bench, or state them in recording.toml ([standard_errors], [room])",
            terms.join(", ")
        );
        match is_in_memory {
            true => report::in_arguments(&note),
            false => note,
        }
    })
}

/// Returns the reasons why an analysis has fewer estimates than recordings.
#[must_use]
pub fn of_outcome(study: &StudyAnalysis) -> Vec<String> {
    let (spoilt, total) = (study.spoilt(), study.analysed.recordings.len());
    let withheld = (spoilt > 0).then(|| {
        format!(
            "warning: the estimates of {spoilt} of {total} recordings are withheld: correct the recordings as the warnings say"
        )
    });
    let is_empty = !study.has_result() && study.is_read();
    let empty =
        is_empty.then(|| "warning: nothing could be estimated: the reasons are above".to_owned());
    withheld.into_iter().chain(empty).collect()
}

/// Returns all warnings, as `analyze --json` prints them on standard error, recordings in their order.
#[must_use]
pub fn all(study: &StudyAnalysis) -> Vec<String> {
    let recordings = study.analysed.recordings.iter();
    let mut lines: Vec<String> = recordings.flat_map(of_recording).collect();
    lines.extend(of_study(study));
    let exclusions = study.selection.to_text();
    lines.extend(exclusions.lines().map(|line| escaped(line).into_owned()));
    lines.extend(of_outcome(study));
    lines
}
