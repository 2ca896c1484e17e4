//! Recordings and assumptions that the options of an analysis name.

use anyhow::Context;

use crate::cli::Analyze;
use analysis::assumptions::Assumptions;
use attempts::find::TrialFilter;
use study_analysis::Request;

/// Returns the assumptions that the options make.
pub(super) fn assumptions(options: &Analyze) -> anyhow::Result<Assumptions> {
    let files = options.assume_file.iter().map(|path| {
        let file = path.display().to_string();
        let text = bounded_files::read_text(path, bounded_files::TEXT_LIMIT_BYTES)
            .with_context(|| format!("cannot read {file}"))?;
        Ok((file, text))
    });
    Ok(Assumptions {
        files: files.collect::<anyhow::Result<_>>()?,
        values: options.assume.clone(),
        no_offset: options.no_offset,
    })
}

/// Returns the search for the recordings.
pub(super) fn request(options: &Analyze) -> Request {
    Request {
        folders: options.recordings.clone(),
        filter: TrialFilter {
            practice: options.practice,
            rejected: options.include_rejected,
        },
        include_excluded: options.include_excluded,
        exceptions: options.exclude.clone(),
    }
}
