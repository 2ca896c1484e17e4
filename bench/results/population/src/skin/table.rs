//! Skin of a study as CSV: a row for each parameter of each recording, each participant and the study.

use std::path::{Path, PathBuf};

use crate::skin::parameters::{NAMES, Ranged, Skin};
use recording::DiskError;
use recording::disk;

/// Name of the file.
pub const SKIN_FILE: &str = "skin.csv";

/// Columns of the table: name, type, SI unit and meaning.
pub const COLUMNS: [(&str, &str, &str, &str); 17] = [
    (
        "level",
        "text",
        "",
        "trial, participant or study; compare rows of one level only",
    ),
    (
        "participant",
        "text",
        "",
        "pseudonym; empty in rows of the study",
    ),
    (
        "recording",
        "text",
        "",
        "folder of the recording, in rows of a trial",
    ),
    (
        "parameter",
        "text",
        "",
        "contact_area_m2, q0_rad_per_m, loss_factor or tau_s; empty in a row of a recording that is left out",
    ),
    (
        "value",
        "real",
        "SI",
        "the trial's fit, the participant's or the study's mean",
    ),
    (
        "low95",
        "real",
        "SI",
        "lower end of the total 95 % interval of value",
    ),
    (
        "high95",
        "real",
        "SI",
        "upper end of the total 95 % interval of value",
    ),
    (
        "n",
        "integer",
        "1",
        "trials of a participant, or participants of the study",
    ),
    (
        "between_ln_std",
        "real",
        "1",
        "standard deviation of the logarithm between trials or participants, in excess of the errors",
    ),
    (
        "shrunken",
        "real",
        "SI",
        "value pulled towards the mean of its level",
    ),
    (
        "shrunken_low95",
        "real",
        "SI",
        "lower end of the 95 % interval of shrunken",
    ),
    (
        "shrunken_high95",
        "real",
        "SI",
        "upper end of the 95 % interval of shrunken",
    ),
    (
        "left_out",
        "text",
        "",
        "reason why a recording is left out, or number of a participant's recordings that are",
    ),
    (
        "low95_within_laws",
        "real",
        "SI",
        "lower end of the interval of value with Eqs. 14 to 19 taken as true",
    ),
    (
        "high95_within_laws",
        "real",
        "SI",
        "upper end of the interval of value with Eqs. 14 to 19 taken as true",
    ),
    (
        "shrunken_low95_within_laws",
        "real",
        "SI",
        "lower end of the interval of shrunken with Eqs. 14 to 19 taken as true",
    ),
    (
        "shrunken_high95_within_laws",
        "real",
        "SI",
        "upper end of the interval of shrunken with Eqs. 14 to 19 taken as true",
    ),
];

/// Row of the table; unknown values are empty.
#[derive(Default)]
struct Row<'a> {
    level: &'static str,
    participant: &'a str,
    recording: String,
    parameter: &'static str,
    value: Option<Ranged>,
    n: Option<usize>,
    between_ln_std: Option<f64>,
    shrunken: Option<Ranged>,
    left_out: String,
}

impl Row<'_> {
    fn cells(&self) -> [String; COLUMNS.len()] {
        let number = |value: Option<f64>| {
            let finite = value.filter(|value| value.is_finite());
            finite.map_or_else(String::new, |value| value.to_string())
        };
        let range_cells = |range: Option<Ranged>| {
            let ends = [0, 1].map(|end| range.map(|range| range.interval95[end]));
            let [low, high] = ends.map(number);
            [number(range.map(|range| range.value)), low, high]
        };
        let cells_within_laws = |range: Option<Ranged>| {
            let ends = range.and_then(|range| range.interval95_within_laws);
            [0, 1].map(|end| number(ends.map(|ends| ends[end])))
        };
        let [low_within_laws, high_within_laws] = cells_within_laws(self.value);
        let [shrunken_low_within_laws, shrunken_high_within_laws] =
            cells_within_laws(self.shrunken);
        let [value, low, high] = range_cells(self.value);
        let [shrunken, shrunken_low, shrunken_high] = range_cells(self.shrunken);
        [
            self.level.to_owned(),
            escaping::to_cell(self.participant),
            escaping::to_cell(&self.recording),
            self.parameter.to_owned(),
            value,
            low,
            high,
            self.n.map_or_else(String::new, |n| n.to_string()),
            number(self.between_ln_std),
            shrunken,
            shrunken_low,
            shrunken_high,
            escaping::to_cell(&self.left_out),
            low_within_laws,
            high_within_laws,
            shrunken_low_within_laws,
            shrunken_high_within_laws,
        ]
    }
}

/// Writes the table into `folder`, replacing an existing one.
///
/// # Errors
/// The operating system refused.
pub fn write(skin: &Skin, folder: &Path) -> Result<PathBuf, DiskError> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    // Writing to memory does not fail.
    let _ = writer.write_record(COLUMNS.map(|(name, ..)| name));
    for row in rows(skin) {
        let _ = writer.write_record(row.cells());
    }
    let bytes = writer.into_inner().unwrap_or_default();
    let path = folder.join(SKIN_FILE);
    disk::replace_file(&path, &bytes)?;
    Ok(path)
}

fn rows(skin: &Skin) -> Vec<Row<'_>> {
    let mut rows = Vec::new();
    for person in &skin.participants {
        for trial in &person.trials {
            let parameters = trial.parameters.as_array().into_iter().zip(NAMES);
            rows.extend(parameters.map(|(estimate, parameter)| Row {
                level: "trial",
                participant: &person.participant,
                recording: trial.path.display().to_string(),
                parameter,
                value: Some(estimate.raw),
                shrunken: estimate.shrunken,
                ..Row::default()
            }));
        }
    }
    rows.extend(skin.left_out.iter().map(|left_out| Row {
        level: "trial",
        participant: left_out.participant.as_deref().unwrap_or_default(),
        recording: left_out.path.display().to_string(),
        left_out: left_out.because.clone(),
        ..Row::default()
    }));
    for person in &skin.participants {
        let parameters = person.parameters.as_array().into_iter().zip(NAMES);
        rows.extend(parameters.map(|(estimate, parameter)| Row {
            level: "participant",
            participant: &person.participant,
            parameter,
            value: estimate.map(|estimate| estimate.mean),
            n: Some(estimate.map_or(0, |estimate| estimate.n_trials)),
            between_ln_std: estimate.and_then(|estimate| estimate.between_trials_ln_std),
            shrunken: estimate.and_then(|estimate| estimate.shrunken),
            left_out: match person.n_left_out {
                0 => String::new(),
                n => format!("{n} of {} trials", n + person.trials.len()),
            },
            ..Row::default()
        }));
    }
    let parameters = skin.study.as_array().into_iter().zip(NAMES);
    rows.extend(parameters.map(|(estimate, parameter)| Row {
        level: "study",
        parameter,
        value: estimate.mean,
        n: Some(estimate.n_participants),
        between_ln_std: estimate.between_participants_ln_std,
        ..Row::default()
    }));
    rows
}
