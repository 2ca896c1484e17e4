//! Tables of a recording, compared with its results and with each other.
#![cfg(feature = "parquet")]
#![expect(
    clippy::unwrap_used,
    reason = "a helper that fails fails its test, as in the tests themselves"
)]

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

use analysis::findings::RejectedStretch;
use analysis::{
    Analysis, KeptSeries, RecordingAnalysis, RecordingSeries, SeriesSource, SeriesStore, Settings,
};
use attempts::Attempts;
use ciborium::Value as Cbor;
use descriptive::Description;
use estimation::trial::Misfit;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::Field;
use report::recording_results::Recording;
use serde_json::Value;
use series_spool::SeriesSpool;
use study::exclusions::RecordingSelection;
use tables::{Content, METADATA_KEYS};

/// Returns the analysis of a simulation in which every assumption is wrong (bench/tests/data/reference/README.md).
fn unknown_skin() -> (Analysis, KeptSeries) {
    let folder =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data/reference/recording-d");
    analysis::analyse_with_series(&[folder], &Settings::default(), |_| ())
}

/// Returns the place of a column's name at which `_within_laws` is inserted: before its unit, or before `_std` and `_ln_std`.
fn name_end(name: &str, is_std: bool) -> usize {
    let place = match is_std {
        true => name.find("_ln_std").or_else(|| name.find("_std")),
        false => ["_rad_per_m", "_m2", "_s", "_hz"]
            .iter()
            .find_map(|unit| Some(name.strip_suffix(unit)?.len())),
    };
    place.unwrap_or(name.len())
}

/// Writes the tables of an analysis into `folder`.
fn write((analysed, series): &(Analysis, KeptSeries), folder: &Path) {
    write_from((analysed, series), folder);
}

fn write_from((analysed, series): (&Analysis, &dyn SeriesSource), folder: &Path) {
    let content = Content {
        analysed,
        series,
        description: &Description::new(analysed),
        attempts: &Attempts::default(),
        selection: &RecordingSelection::default(),
    };
    content.write(folder).unwrap();
}

/// Rows of a table, each by the names of its columns.
fn table(file: &Path) -> Vec<Vec<(String, Field)>> {
    let reader = SerializedFileReader::new(fs::File::open(file).unwrap()).unwrap();
    let rows = reader.get_row_iter(None).unwrap();
    rows.map(|row| row.unwrap().into_columns()).collect()
}

#[test]
fn the_table_of_estimates_agrees_with_the_results() {
    let folder = tempfile::tempdir().unwrap();
    let analysed = unknown_skin();
    write(&analysed, folder.path());
    let recording = serde_json::to_value(Recording::from(&analysed.0.recordings[0])).unwrap();
    let shared = &recording["trial"];
    let rows = table(&folder.path().join("estimates.parquet"));
    let instances = recording["instances"].as_array().unwrap();
    assert_eq!(rows.len(), 3 * instances.len());
    let mut comparisons = 0;
    for row in rows {
        let field = |name: &str| {
            let cell = row.iter().find(|(column, _)| column == name);
            &cell.unwrap_or_else(|| panic!("no column {name}")).1
        };
        let real = |name: &str| match field(name) {
            Field::Double(value) => *value,
            cell => panic!("{name} is {cell:?}"),
        };
        let (Field::Str(method), Field::Long(number)) = (field("method"), field("instance")) else {
            panic!("{row:?}");
        };
        // This skin is none that `dynamic` assumes.
        assert_eq!(field("model_misfit"), &Field::Bool(method == "dynamic"));
        if method != "trial" {
            let estimate = &instances[*number as usize - 1][method];
            let signs = estimate["misfit"].as_array().unwrap().iter();
            let signs: Vec<&str> = signs.map(|sign| sign.as_str().unwrap()).collect();
            assert_eq!(field("misfit"), &Field::Str(signs.join("; ")));
            assert_eq!(estimate["model_misfit"], method == "dynamic");
            for name in ["area_force_exponent", "film_mean_s", "lag_gap_exponent"] {
                assert_eq!(real(name), 0.0, "{name}");
            }
            for name in ["q0_ln_std", "film_mean_ln_std", "shared_tau_s"] {
                assert!(real(name).is_nan(), "{name}");
            }
            continue;
        }
        let trial = &instances[*number as usize - 1]["trial"];
        assert_eq!(field("verdict"), &Field::Str("converged".to_owned()));
        assert_eq!(shared["verdict"], "converged");
        assert_eq!(field("misfit"), &Field::Str(String::new()));
        let assert_close = |name: &str, value: f64, result: &Value| {
            let expected = result.as_f64().unwrap();
            let slack = 1e-6 * expected.abs().max(1e-9);
            assert!(
                (value - expected).abs() <= slack,
                "{name}: {value} {result}"
            );
        };
        // Ends of the interval, computed as docs/RECORDING.md describes.
        let ends = |column: &str, std: &str| {
            let (value, deviations) = (real(column), 1.959_964 * real(std));
            [-deviations, deviations].map(|distance| match std.ends_with("_ln_std") {
                true => value * distance.exp(),
                false => value + distance,
            })
        };
        let mut assert_column = |column: &str, std: &str, result: &Value, key: &str| {
            assert_close(column, real(column), &result[key]);
            for (suffix, intervals) in [
                ("", &result["interval95"]),
                ("_within_laws", &result["interval95_within_laws"]),
            ] {
                let [column, std] = [(column, false), (std, true)].map(|(name, is_std)| {
                    let place = name_end(name, is_std);
                    format!("{}{suffix}{}", &name[..place], &name[place..])
                });
                let [low, high] = ends(&column, &std);
                assert_close(&std, low, &intervals[key][0]);
                assert_close(&std, high, &intervals[key][1]);
                comparisons += 1;
            }
        };
        for (column, std) in [
            ("contact_area_m2", "contact_area_ln_std"),
            ("q0_rad_per_m", "q0_ln_std"),
            ("loss_factor", "loss_factor_ln_std"),
            ("area_force_exponent", "area_force_exponent_std"),
            ("lag_gap_exponent", "lag_gap_exponent_std"),
            ("friction_floor", "friction_floor_std"),
            ("lateral_lag_s", "lateral_lag_std_s"),
        ] {
            assert_column(column, std, shared, column);
        }
        assert_column("shared_tau_s", "shared_tau_ln_std", shared, "tau_s");
        assert_column("mu0", "mu0_std", trial, "mu0");
        let shift = "resonance_shift_hz";
        assert_column(shift, "resonance_shift_std_hz", trial, shift);
        assert_close("tau_s", real("tau_s"), &trial["tau_s"]);
    }
    assert_eq!(comparisons, 2 * 10 * instances.len());
}

/// Returns a value of a map.
fn entry<'a>(map: &'a mut Cbor, key: &str) -> &'a mut Cbor {
    let mut entries = map.as_map_mut().unwrap().iter_mut();
    let value = entries.find_map(|(name, value)| (name.as_text() == Some(key)).then_some(value));
    value.unwrap()
}

/// Returns the analysis with the σ_t of the first instance by `trial`, and of every instance by `paper`, such as no skin has.
fn rough((analysed, series): &(Analysis, KeptSeries)) -> Analysis {
    let mut recordings: Vec<RecordingAnalysis> = Vec::new();
    for recording in &analysed.recordings {
        // Unlike JSON, CBOR keeps NaN.
        let findings = recording.findings.as_ref().unwrap();
        let mut findings = Cbor::serialized(findings).unwrap();
        let instances = entry(&mut findings, "instances").as_array_mut().unwrap();
        for (number, instance) in instances.iter_mut().enumerate() {
            *entry(entry(instance, "paper"), "sigma_t_m") = 0.31.into();
            if number == 0 {
                *entry(entry(instance, "trial"), "sigma_t_m") = 0.31.into();
            }
        }
        recordings.push(RecordingAnalysis {
            path: recording.path.clone(),
            participant: recording.participant.clone(),
            findings: Ok(findings.deserialized().unwrap()),
        });
    }
    analysis::complete(recordings, &analysed.settings, series).unwrap()
}

#[test]
fn a_gap_by_a_model_that_does_not_hold_is_withheld_where_it_is_described() {
    let folder = tempfile::tempdir().unwrap();
    let (mut analysed, series) = unknown_skin();
    let rows = |name: &str| csv_rows(&folder.path().join(format!("{name}.csv")));
    write_from((&analysed, &series), folder.path());
    let estimates = rows("estimates");
    let sound = rows("instances");
    assert!(!sound.is_empty() && sound.iter().all(|row| !row["gap_at_crest_m"].is_empty()));
    let findings = analysed.recordings[0].findings.as_mut().unwrap();
    let sign = Misfit::Friction { rms_mu: 0.05 };
    findings.trial.as_mut().unwrap().misfit.push(sign);
    write_from((&analysed, &series), folder.path());
    for table in ["instances", "trials", "participants"] {
        for row in rows(table) {
            assert_eq!(row["gap_at_crest_m"], "", "{table}: {row:?}");
            assert!(!row["mu_at_crest"].is_empty(), "{table}: {row:?}");
            let reason = &row["null_because"];
            assert!(
                reason.contains("the model does not hold"),
                "{table}: {row:?}"
            );
        }
    }
    for (row, sound) in rows("estimates").into_iter().zip(estimates) {
        let is_trial = row["method"] == "trial";
        let is_empty = is_trial || sound["gap_at_crest_m"].is_empty();
        assert_eq!(row["gap_at_crest_m"].is_empty(), is_empty, "{row:?}");
    }
}

#[test]
fn a_withheld_number_has_its_reason_in_every_table() {
    let folder = tempfile::tempdir().unwrap();
    let sound = unknown_skin();
    let analysed = rough(&sound);
    write_from((&analysed, &sound.1), folder.path());
    let rows = |name: &str| csv_rows(&folder.path().join(format!("{name}.csv")));
    let reason = "a σ_t of 3.1e-1 m";
    let [first, second] = [0, 1].map(|row| rows("instances").remove(row));
    for (empty, full) in [
        (&first["sigma_t_m"], &second["sigma_t_m"]),
        (&first["gap_at_crest_m"], &second["gap_at_crest_m"]),
    ] {
        assert!(empty.is_empty() && !full.is_empty(), "{first:?}");
    }
    let is_stated =
        |row: &BTreeMap<String, String>, words: &str| row["null_because"].contains(words);
    assert!(is_stated(&first, reason), "{first:?}");
    assert_eq!(second["null_because"], "");
    // The mean leaves the instance out, and nobody has a mean by `paper`.
    for row in rows("estimates") {
        let is_paper = row["method"] == "paper";
        assert_eq!(row["averaged_sigma_t_m"].is_empty(), is_paper, "{row:?}");
        assert_eq!(is_stated(&row, "averaged_sigma_t_m: "), is_paper, "{row:?}");
        let mean_m: f64 = row["averaged_sigma_t_m"].parse().unwrap_or_default();
        assert!(mean_m < 1e-4, "{row:?}");
    }
    let samples = rows("samples");
    let first_by_paper = samples.iter().find(|row| row["method"] == "paper").unwrap();
    assert!(
        is_stated(first_by_paper, "gap_m, film_force_n: "),
        "{first_by_paper:?}"
    );
    assert!(is_stated(first_by_paper, "columns with averaged: "));
    let result = serde_json::to_value(Recording::from(&analysed.recordings[0])).unwrap();
    let instance = &result["instances"][0];
    assert_eq!(instance["trial"]["interval95"]["sigma_t_m"], Value::Null);
    for (estimate, key) in [
        (&instance["trial"], "sigma_t_null_because"),
        (&instance["paper"]["averaged"], "sigma_t_null_because"),
    ] {
        assert_eq!(estimate["sigma_t_m"], Value::Null);
        assert!(
            estimate[key].as_str().unwrap().contains("σ_t"),
            "{estimate}"
        );
    }
}

#[test]
fn a_trial_and_a_participant_without_an_instance_have_its_reason() {
    let folder = tempfile::tempdir().unwrap();
    let (mut analysed, series) = unknown_skin();
    for recording in &mut analysed.recordings {
        recording.participant = Some("sub-01".to_owned());
        let findings = recording.findings.as_mut().unwrap();
        findings.participant = Some("sub-01".to_owned());
        findings.instances.clear();
        findings.rejected = (0..3)
            .map(|number| RejectedStretch {
                direction: protocols::Direction::LeftToRight,
                start_s: f64::from(number),
                end_s: f64::from(number) + 0.1,
                reason: "speed 91 mm/s".to_owned(),
                kind: "speed".to_owned(),
            })
            .collect();
    }
    write(&(analysed, series), folder.path());
    for name in ["trials", "participants", "descriptive"] {
        let rows = csv_rows(&folder.path().join(format!("{name}.csv")));
        assert!(!rows.is_empty(), "{name}");
        for row in rows {
            assert_eq!(row["fall_of_mu"], "");
            assert_eq!(
                row["null_because"], "means: every stretch was rejected: speed (3)",
                "{name}"
            );
        }
    }
}

/// Rows of a CSV table, each by the names of its columns.
fn csv_rows(file: &Path) -> Vec<BTreeMap<String, String>> {
    let mut reader = csv::Reader::from_path(file).unwrap();
    let rows = reader.deserialize();
    rows.map(|row| row.unwrap()).collect()
}

/// Key of each table within a study of known participants; a recording made elsewhere is numbered.
const KEYS: [(&str, &[&str]); 8] = [
    (
        "explorations",
        &["participant", "session", "trial", "attempt", "exploration"],
    ),
    (
        "friction",
        &[
            "participant",
            "session",
            "trial",
            "attempt",
            "exploration",
            "time_s",
        ],
    ),
    (
        "instances",
        &["participant", "session", "trial", "attempt", "instance"],
    ),
    (
        "estimates",
        &[
            "participant",
            "session",
            "trial",
            "attempt",
            "instance",
            "method",
        ],
    ),
    (
        "samples",
        &[
            "participant",
            "session",
            "trial",
            "attempt",
            "instance",
            "method",
            "time_s",
        ],
    ),
    ("trials", &["participant", "session", "trial", "attempt"]),
    ("participants", &["participant", "condition"]),
    (
        "descriptive",
        &[
            "level",
            "participant",
            "condition",
            "session",
            "trial",
            "attempt",
        ],
    ),
];

#[test]
fn no_two_rows_share_their_key_and_csv_and_parquet_agree() {
    let folder = tempfile::tempdir().unwrap();
    let reference = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data/reference");
    // Twice the same recording under two names: without participant and trial, only their order tells them apart.
    let copy = folder.path().join("copy");
    fs::create_dir(&copy).unwrap();
    for entry in fs::read_dir(reference.join("recording-d")).unwrap() {
        let entry = entry.unwrap();
        fs::copy(entry.path(), copy.join(entry.file_name())).unwrap();
    }
    let folders = [reference.join("recording-d"), copy];
    let analysed = analysis::analyse_with_series(&folders, &Settings::default(), |_| ());
    let tables = folder.path().join("tables");
    write(&analysed, &tables);
    // Series that were in a file make the same tables.
    let spool = SeriesSpool::new(0);
    for number in 0..folders.len() {
        let series = analysed.1.read(number).unwrap();
        spool.put(number, RecordingSeries::clone(&series)).unwrap();
    }
    let from_file = folder.path().join("from-file");
    write_from((&analysed.0, &spool), &from_file);
    for name in ["samples.csv", "samples.parquet", "friction.csv"] {
        let [one, other] = [&tables, &from_file].map(|folder| fs::read(folder.join(name)).unwrap());
        assert!(one == other, "{name}");
    }
    let mut dictionary = BTreeSet::new();
    for row in csv_rows(&tables.join("columns.csv")) {
        assert!(dictionary.insert((row["table"].clone(), row["column"].clone())));
    }
    for (name, key) in KEYS {
        let rows = csv_rows(&tables.join(format!("{name}.csv")));
        let keys = rows
            .iter()
            .map(|row| key.iter().map(|column| row[*column].clone()).collect());
        let distinct: BTreeSet<Vec<String>> = keys.collect();
        assert_eq!(
            distinct.len(),
            rows.len(),
            "{name}: two rows share their key"
        );
        let path = tables.join(format!("{name}.parquet"));
        let packed = table(&path);
        assert_eq!(packed.len(), rows.len(), "{name}");
        for (packed, row) in packed.iter().zip(&rows) {
            assert_eq!(packed.len(), row.len(), "{name}");
            for (column, field) in packed {
                assert!(
                    dictionary.contains(&(name.to_owned(), column.clone())),
                    "{name}.{column}"
                );
                let cell = &row[column];
                let is_equal = match field {
                    Field::Double(value) if value.is_nan() => cell.is_empty(),
                    Field::Double(value) => cell.parse() == Ok(*value),
                    Field::Long(value) => cell.parse() == Ok(*value),
                    Field::Bool(value) => cell.parse() == Ok(*value),
                    Field::Str(text) => escaping::from_cell(cell) == text,
                    other => panic!("{name}.{column}: {other:?}"),
                };
                assert!(is_equal, "{name}.{column}: {cell:?} and {field:?}");
            }
        }
        let reader = SerializedFileReader::new(fs::File::open(&path).unwrap()).unwrap();
        let pairs = reader
            .metadata()
            .file_metadata()
            .key_value_metadata()
            .unwrap();
        let keys: Vec<&str> = pairs.iter().map(|pair| pair.key.as_str()).collect();
        assert_eq!(keys, METADATA_KEYS, "{name}");
    }
    let written = ["skin"].into_iter().chain(KEYS.map(|(name, _)| name));
    let written: BTreeSet<&str> = written.collect();
    let listed: BTreeSet<&str> = dictionary.iter().map(|(table, _)| table.as_str()).collect();
    assert_eq!(listed, written);
    assert_readable_by_jasp_and_spss(&tables);
}

/// Words that are no names of variables in SPSS.
const RESERVED_BY_SPSS: [&str; 13] = [
    "all", "and", "by", "eq", "ge", "gt", "le", "lt", "ne", "not", "or", "to", "with",
];
/// Longest name of a variable and longest text in SPSS, bytes.
const SPSS_NAME_BYTES: usize = 64;
const SPSS_TEXT_BYTES: usize = 32_767;

/// Fails unless each CSV table of the folder is as JASP and SPSS read it: UTF-8 without a mark, one row of names, commas, decimal
/// points, one row a line, and empty cells for missing values.
fn assert_readable_by_jasp_and_spss(folder: &Path) {
    let dictionary = csv_rows(&folder.join("columns.csv"));
    for (table, _) in KEYS {
        let bytes = fs::read(folder.join(format!("{table}.csv"))).unwrap();
        let text = String::from_utf8(bytes).unwrap();
        assert!(!text.starts_with('\u{feff}'), "{table}");
        // Every row has as many cells as the first one, or the reader refuses it.
        let mut reader = csv::Reader::from_reader(text.as_bytes());
        let names = reader.headers().unwrap().clone();
        let types = names.iter().map(|name| {
            let is_it =
                |row: &&BTreeMap<String, String>| row["table"] == table && row["column"] == name;
            dictionary.iter().find(is_it).unwrap()["type"].as_str()
        });
        let types: Vec<&str> = types.collect();
        let mut distinct = BTreeSet::new();
        for name in &names {
            let is_word = |c: char| c.is_ascii_alphanumeric() || c == '_';
            assert!(
                name.starts_with(|c: char| c.is_ascii_alphabetic())
                    && name.chars().all(is_word)
                    && !name.ends_with('_')
                    && name.len() <= SPSS_NAME_BYTES
                    && !RESERVED_BY_SPSS.contains(&name),
                "{table}.{name}"
            );
            assert!(distinct.insert(name.to_lowercase()), "{table}.{name}");
        }
        let mut lines = 1;
        for row in reader.records() {
            lines += 1;
            for ((cell, type_name), name) in row.unwrap().iter().zip(&types).zip(&names) {
                let is_read = match *type_name {
                    "real" => {
                        let is_number = |cell: &str| cell.parse().is_ok_and(f64::is_finite);
                        cell.is_empty() || is_number(cell)
                    }
                    "integer" => cell.parse::<i64>().is_ok(),
                    "boolean" => ["true", "false"].contains(&cell),
                    _ => !cell.contains(['\n', '\r', '\t']) && cell.len() <= SPSS_TEXT_BYTES,
                };
                assert!(is_read, "{table}.{name}: {cell:?}");
            }
        }
        assert_eq!(text.lines().count(), lines, "{table}");
    }
}
