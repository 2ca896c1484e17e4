//! Files of a recording in a dataset.

use std::collections::BTreeSet;
use std::fs::File;
use std::io::{BufWriter, Write};

use flate2::Compression;
use flate2::write::GzEncoder;

use crate::bids::names::{DatasetNames, protocol_file, source_files, with_extension};
use crate::bids::rows::{append_number, cell, write_even, write_streams};
use crate::bids::sidecars;
use crate::column::ColumnValues;
use crate::content::RecordingContent;
use crate::export_error::ExportError;
use crate::fill_error::FillError;
use crate::identity::RecordingIdentity;
use crate::marks::{direction_name, event_words, interval_name, sample_time_s};
use crate::recorded_tables::{POSITIONS, STIMULUS, TimedTable};
use crate::target_folder::{FileState, TargetFolder};

/// Header of a table of events.
const EVENT_COLUMNS: &str = "onset\tduration\ttrial_type\tdirection\tcondition\n";
/// Channels of the positions.
const CHANNELS: &str = "name\tcomponent\ttype\ttracked_point\tunits\n\
    time_s\tn/a\tLATENCY\tn/a\ts\n\
    position_m\tx\tPOS\tfinger\tm\n";

/// Writes the files of a recording; `with_signals` says whether the samples are copied.
///
/// # Errors
/// The recording has no place in a dataset or cannot be read, or a file cannot be written.
pub(crate) fn write(
    content: &RecordingContent,
    target: &TargetFolder,
    with_signals: bool,
) -> Result<Vec<FileState>, ExportError> {
    let names = DatasetNames::new(&content.identity)?;
    let folder = &content.identity.folder;
    let mut states = vec![target.put_text(&names.events(), &events(content))?];
    for timed in &content.streams.timed {
        let TimedTable { table, times } = timed;
        let name = match table.name {
            POSITIONS => continue,
            STIMULUS => names.stimulus(),
            recording => names.physio(recording),
        };
        let sidecar = sidecars::series(content, table, (times.rate_hz, times.first_s));
        states.push(target.put_text(&with_extension(&name, ".json"), &sidecar)?);
        states.push(
            target.put(&with_extension(&name, ".tsv.gz"), folder, |out| {
                compressed(out, |out| write_streams(table, out))
            })?,
        );
    }
    if let Some(friction) = &content.friction
        && let Some(interval_s) = friction.interval_s
        && let Some(first_s) = first(friction.table.columns.first().map(|c| &c.values))
    {
        let (name, table) = (names.physio("friction"), &friction.table);
        let sidecar = sidecars::series(content, table, (1.0 / interval_s, first_s));
        states.push(target.put_text(&with_extension(&name, ".json"), &sidecar)?);
        states.push(
            target.put(&with_extension(&name, ".tsv.gz"), folder, |out| {
                compressed(out, |out| write_even(table, interval_s, out))
            })?,
        );
    }
    if let Some(TimedTable { table, times }) = content.streams.timed(POSITIONS) {
        let sidecar = sidecars::motion(content, *times);
        states.push(target.put_text(&names.motion("motion.json"), &sidecar)?);
        states.push(target.put_text(&names.motion("channels.tsv"), CHANNELS)?);
        states.push(target.put(&names.motion("motion.tsv"), folder, |out| {
            write_streams(table, out)
        })?);
    }
    for file in source_files(folder, with_signals) {
        let copy = names.source.join(&file);
        states.push(target.copy(&folder.join(file), &copy, folder)?);
    }
    Ok(states)
}

/// Copies the protocols of the recordings, which those of a session share.
///
/// # Errors
/// A file cannot be read or written.
pub(crate) fn copy_protocols(
    identities: &[RecordingIdentity],
    target: &TargetFolder,
) -> Result<(), ExportError> {
    let mut copied = BTreeSet::new();
    for identity in identities {
        let folder = &identity.folder;
        let (Ok(names), Some((file, session))) = (
            DatasetNames::new(identity),
            protocol_file(folder).zip(folder.parent()),
        ) else {
            continue;
        };
        let copy = names.source_session.join(&file);
        if copied.insert(copy.clone()) {
            target.copy(&session.join(file), &copy, folder)?;
        }
    }
    Ok(())
}

fn first(values: Option<&ColumnValues>) -> Option<f64> {
    match values {
        Some(ColumnValues::Real(values)) => values.first().copied(),
        _ => None,
    }
}

/// Writes a file in gzip; its header has neither a name nor a time, as BIDS wants it.
fn compressed(
    out: &mut BufWriter<File>,
    fill: impl FnOnce(&mut dyn Write) -> Result<(), FillError>,
) -> Result<(), FillError> {
    let mut encoder = GzEncoder::new(out, Compression::default());
    fill(&mut encoder)?;
    encoder.finish()?;
    Ok(())
}

/// Returns the table of intervals and events, in time order.
fn events(content: &RecordingContent) -> String {
    let manifest = &content.manifest;
    let mut rows: Vec<(f64, f64, String, &str)> = Vec::new();
    for interval in &manifest.intervals {
        let (kind, direction) = interval_name(interval.kind);
        let length_s = interval.end_s - interval.start_s;
        rows.push((
            interval.start_s,
            length_s,
            kind.to_owned(),
            direction_name(direction),
        ));
    }
    for event in &manifest.events {
        let rate_hz = content.streams.rate_hz;
        let time_s = sample_time_s(event.sample, rate_hz);
        let length_s = event.frames.map(|frames| sample_time_s(frames, rate_hz));
        rows.push((
            time_s,
            length_s.unwrap_or(f64::NAN),
            event_words(event.kind).0.to_owned(),
            "",
        ));
    }
    rows.sort_by(|a, b| a.0.total_cmp(&b.0));
    let condition = manifest.trial.as_ref().map_or("", |trial| &trial.condition);
    let mut text = EVENT_COLUMNS.to_owned();
    for (start_s, length_s, kind, direction) in rows {
        append_number(&mut text, start_s);
        text.push('\t');
        append_number(&mut text, length_s);
        text += &format!("\t{kind}\t{}\t{}\n", cell(direction), cell(condition));
    }
    text
}
