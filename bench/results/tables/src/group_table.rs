//! Tables of groups of instances: trials, participants, and all levels of the description.

use std::collections::BTreeSet;
use std::sync::Arc;

use analysis::method::Method;
use descriptive::{Description, Group, Level, Quantity};
use study::provenance::{Concern, Provenance};

use crate::column::{Column, Columns};
use crate::null_reason;
use crate::trial_entry::{TrialEntry, TrialRow, drive_columns, key_columns, provenance_columns};

/// Row of a trial.
struct DescribedTrial<'a> {
    entry: &'a TrialEntry<'a>,
    group: &'a Group,
}

impl TrialRow for DescribedTrial<'_> {
    fn entry(&self) -> &TrialEntry<'_> {
        self.entry
    }
}

/// Row of a group, with its trials.
struct DescribedGroup<'a> {
    group: &'a Group,
    trials: Vec<&'a TrialEntry<'a>>,
}

impl DescribedGroup<'_> {
    fn provenances(&self) -> impl Iterator<Item = &Provenance> {
        self.trials.iter().map(|trial| &trial.findings.provenance)
    }
}

/// Returns the columns of the table of trials.
pub(crate) fn trials<'a>(
    entries: &'a [TrialEntry<'a>],
    description: &'a Description,
) -> Vec<Column> {
    let row = |entry: &'a TrialEntry<'a>| {
        let mut groups = description.level(Level::Trial);
        let group = groups.find(|group| group.trial.as_ref() == Some(&entry.key))?;
        Some(DescribedTrial { entry, group })
    };
    let gap_method = description.gap_method;
    let rows: Vec<DescribedTrial<'_>> = entries.iter().filter_map(row).collect();
    let mut columns = Columns::new(&rows);
    key_columns(&mut columns);
    drive_columns(&mut columns);
    provenance_columns(&mut columns);
    columns.integer("n_instances", "number of instances", |row| {
        row.group.n_instances as i64
    });
    columns.integer("n_rejected", "number of rejected stretches", |row| {
        row.entry.findings.rejected.len() as i64
    });
    mean_columns(&mut columns, "mean over the instances", |row| row.group);
    null_reason::column(&mut columns, |row| {
        null_reason::of_group(row.group, &[row.entry], gap_method)
    });
    columns.into_list()
}

/// Returns the columns of the table of participants: a row for each participant and condition.
pub(crate) fn participants(entries: &[TrialEntry<'_>], description: &Description) -> Vec<Column> {
    let has_conditions = description
        .level(Level::ParticipantInCondition)
        .next()
        .is_some();
    let level = match has_conditions {
        true => Level::ParticipantInCondition,
        false => Level::Participant,
    };
    let rows = described(description.level(level), entries);
    let mut columns = Columns::new(&rows);
    columns.text(
        "participant",
        "pseudonym, preceded by the study if several are analysed",
        |row| text(row.group.participant.as_deref()),
    );
    columns.text(
        "condition",
        "name of the protocol's condition; empty if not known",
        |row| text(row.group.condition.as_deref()),
    );
    count_columns(&mut columns);
    group_provenance(&mut columns);
    mean_columns(&mut columns, "mean over the participant's trials", |row| {
        row.group
    });
    group_reasons(&mut columns, description.gap_method);
    columns.into_list()
}

/// Returns the columns of the table of all levels.
pub(crate) fn levels(entries: &[TrialEntry<'_>], description: &Description) -> Vec<Column> {
    let rows = described(description.groups.iter(), entries);
    let mut columns = Columns::new(&rows);
    columns.text(
        "level",
        "study, condition, participant, participant in condition, or trial; compare rows of one level only",
        |row| row.group.level.name().into(),
    );
    columns.text(
        "participant",
        "pseudonym; empty for a group of several",
        |row| text(row.group.participant.as_deref()),
    );
    columns.text(
        "condition",
        "condition; empty for a group of several",
        |row| text(row.group.condition.as_deref()),
    );
    let key = |row: &DescribedGroup<'_>, part: fn(&descriptive::TrialKey) -> i64| {
        row.group.trial.as_ref().map_or(0, part)
    };
    columns.integer(
        "session",
        "number of the session of a trial, otherwise 0",
        |row| key(row, |trial| trial.session),
    );
    columns.integer(
        "trial",
        "number of a trial, negative for practice; otherwise 0",
        |row| key(row, |trial| trial.trial),
    );
    columns.integer(
        "attempt",
        "number of the attempt at a trial, otherwise 0",
        |row| key(row, |trial| trial.attempt),
    );
    columns.text(
        "over",
        "units that the means count: instances, trials or participants",
        |row| row.group.over.name().into(),
    );
    columns.integer("n", "number of these units", |row| row.group.n() as i64);
    count_columns(&mut columns);
    group_provenance(&mut columns);
    mean_columns(&mut columns, "mean over the n units", |row| row.group);
    group_reasons(&mut columns, description.gap_method);
    columns.into_list()
}

fn text(text: Option<&str>) -> Arc<str> {
    text.unwrap_or_default().into()
}

/// Returns the groups, each with its trials.
fn described<'a>(
    groups: impl Iterator<Item = &'a Group>,
    entries: &'a [TrialEntry<'a>],
) -> Vec<DescribedGroup<'a>> {
    let row = |group: &'a Group| {
        let is_member = |entry: &&TrialEntry<'_>| {
            let key = &entry.key;
            let (participant, condition) = (&group.participant, &group.condition);
            (participant.is_none() || *participant == key.participant)
                && condition
                    .as_ref()
                    .is_none_or(|condition| *condition == key.condition)
                && group.trial.as_ref().is_none_or(|trial| trial == key)
        };
        let members = entries.iter().filter(is_member);
        DescribedGroup {
            group,
            trials: members.collect(),
        }
    };
    groups.map(row).collect()
}

fn count_columns(columns: &mut Columns<'_, DescribedGroup<'_>>) {
    columns.integer(
        "n_participants",
        "number of known participants with instances",
        |row| row.group.n_participants as i64,
    );
    columns.integer("n_sessions", "number of sessions with instances", |row| {
        row.group.n_sessions as i64
    });
    columns.integer("n_trials", "number of trials with instances", |row| {
        row.group.n_trials as i64
    });
    columns.integer("n_instances", "number of instances", |row| {
        row.group.n_instances as i64
    });
}

fn group_provenance(columns: &mut Columns<'_, DescribedGroup<'_>>) {
    columns.integer("n_recordings", "number of analysed recordings", |row| {
        row.trials.len() as i64
    });
    let counted = |row: &DescribedGroup<'_>, counts: &dyn Fn(&Provenance) -> bool| {
        row.provenances()
            .filter(|provenance| counts(provenance))
            .count() as i64
    };
    columns.integer(
        "n_calibrated",
        "number of recordings that name the calibration of their constants",
        |row| counted(row, &|provenance| provenance.calibrated),
    );
    columns.integer(
        "n_simulated",
        "number of recordings of a simulated bench",
        |row| counted(row, &|provenance| provenance.has(Concern::Simulated)),
    );
    columns.integer(
        "n_rehearsed",
        "number of recordings with faults injected on purpose",
        |row| counted(row, &|provenance| provenance.has(Concern::Rehearsed)),
    );
    columns.text(
        "waived",
        "hardware stops waived in any recording, joined by `; `",
        |row| {
            let stops = row.provenances().flat_map(|provenance| &provenance.waived);
            let stops: BTreeSet<&str> = stops.map(String::as_str).collect();
            stops.into_iter().collect::<Vec<_>>().join("; ").into()
        },
    );
}

fn group_reasons(columns: &mut Columns<'_, DescribedGroup<'_>>, gap_method: Method) {
    null_reason::column(columns, |row| {
        null_reason::of_group(row.group, &row.trials, gap_method)
    });
}

/// Adds the means and the ends of their intervals.
fn mean_columns<R>(columns: &mut Columns<'_, R>, over: &str, group: impl Fn(&R) -> &Group + Copy) {
    for quantity in Quantity::ALL {
        let (names, unit) = (quantity.names(), quantity.unit());
        let meaning = format!("{over} of the {}", quantity.meaning());
        columns.real(names.value, unit, meaning, move |row| {
            group(row).mean(quantity).value
        });
        for (end, name, side) in [(0, names.low95, "lower"), (1, names.high95, "upper")] {
            let value = names.value;
            let meaning = format!(
                "{side} end of the 95 % interval of {value} by Student's t; NaN over fewer than two"
            );
            columns.real(name, unit, meaning, move |row| {
                group(row).mean(quantity).ends()[end]
            });
        }
    }
}
