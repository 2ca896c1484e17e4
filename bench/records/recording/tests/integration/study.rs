//! A study only grows, is used by one instance at a time, and survives being killed at any point.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::sync::LazyLock;

use proptest::prelude::*;
use protocols::{ParticipantId, Person, PersonDetail};
use recording::RecordingWriter;
use recording::manifest::End;
use recording::study::event_log::{self, DataKey, Descriptor, ExitStatus, Start};
use recording::study::{
    DESCRIPTION_FILE, Document, EventLog, EventLogError, GeneratedBy, LOCK_FILE, PARTICIPANTS_FILE,
    SessionFolder, Study, StudyError, TrialBlock, TrialLabel,
};
use recording::writer::Ending;
use serde_json::{Map, Value, json};

use crate::support::{FORMAT_2, manifest, write_data};

const DATE: &str = "2026-11-21";
const TIME: &str = "2026-11-21T07:00:00Z";

fn open(folder: &Path) -> Result<Study, StudyError> {
    let generator = GeneratedBy {
        name: "friction-bench".to_owned(),
        version: "0.1.0".to_owned(),
    };
    Study::open_or_create(folder, generator)
}

fn participant(id: &str) -> ParticipantId {
    id.parse().unwrap()
}

fn start(resumed: bool) -> Start {
    Start {
        time: TIME.to_owned(),
        resumed,
        participant: "sub-01".to_owned(),
        session: 1,
        protocol: "huloux2021".to_owned(),
        protocol_file: Some("huloux2021.toml".to_owned()),
        protocol_edits: Vec::new(),
        copies: BTreeMap::new(),
        seed: u64::MAX,
        software: "friction-bench".to_owned(),
        version: "0.1.0".to_owned(),
        devices: BTreeMap::from([("audio".to_owned(), "hw:1,0".to_owned())]),
        calibration: None,
        rehearsed: Vec::new(),
        preflight: Value::Null,
        configuration: json!({ "carrier_hz": 35_000.0 }),
    }
}

/// `sub-A` and `sub-a` are the same folder on many disks.
#[test]
fn a_participant_who_differs_in_case_only_is_refused() {
    let room = tempfile::tempdir().unwrap();
    let study = open(&room.path().join("study")).unwrap();
    let begin =
        |id: &str, session| study.begin_session(&participant(id), session, "2026-05-04", "demo");
    drop(begin("sub-A", 1).unwrap());
    for refused in [
        begin("sub-a", 1).map(drop),
        study.next_session(&participant("sub-a")).map(drop),
    ] {
        let message = refused.unwrap_err().to_string();
        assert!(message.starts_with("sub-a and sub-A, which "), "{message}");
    }
    assert_eq!(study.next_session(&participant("sub-A")).unwrap(), 2);
    drop(begin("sub-B", 1).unwrap());
}

fn data(number: u64) -> Map<String, Value> {
    Map::from_iter([("number".to_owned(), number.into())])
}

fn log_a_session(log: &mut EventLog, resumed: bool) {
    log.start(start(resumed)).unwrap();
    let number = DataKey {
        dtype: "integer".to_owned(),
        unit: None,
        source: "protocol".to_owned(),
    };
    log.descriptor(Descriptor {
        stream: "trial".to_owned(),
        data_keys: BTreeMap::from([("number".to_owned(), number)]),
    })
    .unwrap();
    log.event("trial", TIME.to_owned(), 1.5, data(1)).unwrap();
    log.event("trial", TIME.to_owned(), 2.5, data(2)).unwrap();
}

fn begin(study: &Study, id: &str, session: u32) -> Result<SessionFolder, StudyError> {
    study.begin_session(&participant(id), session, DATE, "huloux2021")
}

const fn label(block: TrialBlock, number: u32, attempt: u32) -> TrialLabel {
    TrialLabel {
        block,
        number,
        attempt,
    }
}

#[test]
fn a_new_study_describes_itself() {
    let temp = tempfile::tempdir().unwrap();
    let folder = temp.path().join("pilot");
    let study = open(&folder).unwrap();
    assert_eq!(study.description().name, "pilot");
    let text = fs::read_to_string(folder.join(DESCRIPTION_FILE)).unwrap();
    let value: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(value["DatasetType"], "raw");
    assert_eq!(value["GeneratedBy"][0]["Name"], "friction-bench");
    assert_eq!(value["GeneratedBy"][0]["Version"], "0.1.0");
    drop(study);
    open(&folder).unwrap();
    assert_eq!(
        fs::read_to_string(folder.join(DESCRIPTION_FILE)).unwrap(),
        text
    );
}

/// Fault 34.
#[test]
fn a_second_instance_is_refused_until_the_first_has_ended() {
    let temp = tempfile::tempdir().unwrap();
    let first = open(temp.path()).unwrap();
    let error = open(temp.path()).unwrap_err();
    let this_process = std::process::id();
    assert!(
        matches!(error, StudyError::InUse { holder: Some(pid), .. } if pid == this_process),
        "{error}"
    );
    drop(first);
    open(temp.path()).unwrap();
}

#[test]
fn a_folder_of_something_else_is_left_alone() {
    let temp = tempfile::tempdir().unwrap();
    fs::write(temp.path().join("thesis.tex"), "x").unwrap();
    let error = open(temp.path()).unwrap_err();
    assert!(matches!(error, StudyError::NotAStudy { .. }), "{error}");
    assert_eq!(temp.path().read_dir().unwrap().count(), 1);
}

#[test]
fn a_study_that_lost_its_description_is_no_new_one() {
    let temp = tempfile::tempdir().unwrap();
    begin(&open(temp.path()).unwrap(), "sub-01", 1).unwrap();
    fs::remove_file(temp.path().join(DESCRIPTION_FILE)).unwrap();
    let error = open(temp.path()).unwrap_err();
    assert!(matches!(error, StudyError::NoDescription { .. }), "{error}");
}

#[test]
fn a_number_with_other_zeros_is_a_slip() {
    let temp = tempfile::tempdir().unwrap();
    let study = open(temp.path()).unwrap();
    begin(&study, "sub-03", 1).unwrap();
    for id in ["sub-3", "sub-003"] {
        let error = begin(&study, id, 1).unwrap_err();
        assert!(matches!(error, StudyError::OtherZeros { .. }), "{error}");
        assert!(!temp.path().join(id).exists());
    }
    for id in ["sub-30", "sub-13", "sub-p3", "sub-a"] {
        begin(&study, id, 1).unwrap();
    }
    begin(&study, "sub-03", 2).unwrap();
}

#[test]
fn a_partly_created_study_is_completed() {
    let temp = tempfile::tempdir().unwrap();
    fs::write(temp.path().join(LOCK_FILE), "1\n").unwrap();
    fs::write(temp.path().join("dataset_description.json.tmp"), "{").unwrap();
    open(temp.path()).unwrap();
}

#[test]
fn a_damaged_description_is_named() {
    let temp = tempfile::tempdir().unwrap();
    fs::write(temp.path().join(DESCRIPTION_FILE), "{").unwrap();
    let error = open(temp.path()).unwrap_err();
    assert!(error.to_string().contains(DESCRIPTION_FILE), "{error}");
}

#[test]
fn participants_have_one_line_each() {
    let temp = tempfile::tempdir().unwrap();
    let study = open(temp.path()).unwrap();
    begin(&study, "sub-01", 1).unwrap();
    begin(&study, "sub-01", 2).unwrap();
    begin(&study, "sub-02", 1).unwrap();
    assert_eq!(
        fs::read_to_string(temp.path().join(PARTICIPANTS_FILE)).unwrap(),
        "participant_id\tfirst_session_date\tprotocol\tage\tsex\thandedness\n\
         sub-01\t2026-11-21\thuloux2021\tn/a\tn/a\tn/a\n\
         sub-02\t2026-11-21\thuloux2021\tn/a\tn/a\tn/a\n"
    );
    let error = study
        .begin_session(&participant("sub-03"), 1, DATE, "a\tb")
        .unwrap_err();
    assert!(matches!(error, StudyError::Tsv { .. }), "{error}");
    assert!(!temp.path().join("sub-03").exists());
}

fn person(age: &str, sex: &str) -> Person {
    let mut person = Person::default();
    person.set(PersonDetail::Age, age).unwrap();
    person.set(PersonDetail::Sex, sex).unwrap();
    person
}

#[test]
fn the_details_of_a_participant_are_filled_in_once_and_stay() {
    let temp = tempfile::tempdir().unwrap();
    let study = open(temp.path()).unwrap();
    let (first, second) = (participant("sub-01"), participant("sub-02"));
    begin(&study, "sub-01", 1).unwrap();
    begin(&study, "sub-02", 1).unwrap();
    study.describe(&first, &person("31", "n/a")).unwrap();
    study.describe(&first, &person("32", "female")).unwrap();
    // Describing a participant does not add one.
    study
        .describe(&participant("sub-03"), &person("40", "male"))
        .unwrap();
    assert_eq!(
        fs::read_to_string(temp.path().join(PARTICIPANTS_FILE)).unwrap(),
        "participant_id\tfirst_session_date\tprotocol\tage\tsex\thandedness\n\
         sub-01\t2026-11-21\thuloux2021\t31\tfemale\tn/a\n\
         sub-02\t2026-11-21\thuloux2021\tn/a\tn/a\tn/a\n"
    );
    assert_eq!(study.person(&first).unwrap(), person("31", "female"));
    assert_eq!(study.person(&second).unwrap(), Person::default());
}

#[test]
fn a_table_of_an_earlier_version_or_with_a_laboratorys_own_columns_is_continued() {
    let temp = tempfile::tempdir().unwrap();
    let study = open(temp.path()).unwrap();
    let table = temp.path().join(PARTICIPANTS_FILE);
    // The file was edited in a spreadsheet, and its last line is torn.
    fs::write(
        &table,
        "\u{feff}participant_id\tgroup\tfirst_session_date\tprotocol\r\nsub-01\tdry\t2026-01-31\tdemo\r\nsub-02\twet",
    )
    .unwrap();
    begin(&study, "sub-03", 1).unwrap();
    study
        .describe(&participant("sub-01"), &person("31", "male"))
        .unwrap();
    assert_eq!(
        fs::read_to_string(&table).unwrap(),
        "\u{feff}participant_id\tgroup\tfirst_session_date\tprotocol\tage\tsex\r\n\
         sub-01\tdry\t2026-01-31\tdemo\t31\tmale\r\n\
         sub-02\twet\tn/a\tn/a\tn/a\tn/a\r\n\
         sub-03\tn/a\t2026-11-21\thuloux2021\tn/a\tn/a\r\n"
    );
}

#[test]
fn a_table_of_another_program_keeps_its_columns_cells_and_line_ends() {
    for end in ["\n", "\r\n", "\r"] {
        let temp = tempfile::tempdir().unwrap();
        let study = open(temp.path()).unwrap();
        let path = temp.path().join(PARTICIPANTS_FILE);
        let text = [
            "sex\tparticipant_id\tage\tsite",
            "F\tsub-01\t18-38\t\"a \"\"b\"\"\"",
        ]
        .join(end)
            + end;
        fs::write(&path, &text).unwrap();
        begin(&study, "sub-02", 1).unwrap();
        // Cells in other words are not overwritten.
        study
            .describe(&participant("sub-01"), &person("31", "male"))
            .unwrap();
        study
            .describe(&participant("sub-02"), &person("31", "n/a"))
            .unwrap();
        let expected = format!("{text}n/a\tsub-02\t31\tn/a{end}");
        assert_eq!(fs::read_to_string(&path).unwrap(), expected);
    }
}

#[test]
fn a_table_that_is_none_is_named_and_left_as_it_is() {
    for text in [
        &b"name\tage\nsub-01\t3\n"[..],
        b"participant_id,age\nsub-01,3\n",
        b"participant_id\tage\nsub-01  3\n",
        b"participant_id\tage\nsub-01\t3\t4\n",
        b"\xff\xfe",
        b"",
    ] {
        let temp = tempfile::tempdir().unwrap();
        let study = open(temp.path()).unwrap();
        let table = temp.path().join(PARTICIPANTS_FILE);
        fs::write(&table, text).unwrap();
        let error = begin(&study, "sub-01", 1).unwrap_err();
        assert!(matches!(error, StudyError::Table { .. }), "{error}");
        assert_eq!(fs::read(&table).unwrap(), text);
    }
}

/// Fault 31.
#[test]
fn a_session_is_never_begun_twice_and_the_error_says_what_to_do() {
    let temp = tempfile::tempdir().unwrap();
    let study = open(temp.path()).unwrap();
    let sub = participant("sub-01");
    assert_eq!(study.next_session(&sub).unwrap(), 1);
    let session = begin(&study, "sub-01", 1).unwrap();
    assert!(session.folder().ends_with("sub-01/ses-01"));
    begin(&study, "sub-01", 7).unwrap();
    assert_eq!(study.next_session(&sub).unwrap(), 8);
    let error = begin(&study, "sub-01", 1).unwrap_err().to_string();
    assert!(
        error.contains("--resume") && error.contains("session 8 by `--new-session`"),
        "{error}"
    );
}

/// Fault 35.
#[test]
fn a_killed_or_aborted_session_can_be_resumed_and_an_ended_one_cannot() {
    let temp = tempfile::tempdir().unwrap();
    let study = open(temp.path()).unwrap();
    let sub = participant("sub-01");
    let error = study.resume_session(&sub, 1).unwrap_err();
    assert!(matches!(error, StudyError::NoSession { .. }), "{error}");

    let mut session = begin(&study, "sub-01", 1).unwrap();
    log_a_session(session.log(), false);
    drop(session);
    let mut session = study.resume_session(&sub, 1).unwrap();
    assert_eq!(session.earlier_log().documents.len(), 4);
    assert_eq!(session.earlier_log().stop(), None, "killed");
    log_a_session(session.log(), true);
    session
        .log()
        .stop(TIME.to_owned(), ExitStatus::Abort, Some("ill".to_owned()))
        .unwrap();
    drop(session);

    let mut session = study.resume_session(&sub, 1).unwrap();
    let stop = session.earlier_log().stop().unwrap().clone();
    assert_eq!((stop.exit_status, stop.num_events), (ExitStatus::Abort, 4));
    log_a_session(session.log(), true);
    session
        .log()
        .stop(TIME.to_owned(), ExitStatus::Success, None)
        .unwrap();
    drop(session);
    let error = study.resume_session(&sub, 1).unwrap_err();
    assert!(
        matches!(error, StudyError::SessionEnded { next: 2, .. }),
        "{error}"
    );
}

/// Fault 31.
#[test]
fn trials_are_listed_as_recorded_and_never_overwritten() {
    let temp = tempfile::tempdir().unwrap();
    let study = open(temp.path()).unwrap();
    let session = begin(&study, "sub-01", 1).unwrap();
    let record = |label, ending: Option<Ending>| {
        let folder = session.trial_folder(label).unwrap();
        let mut writer = RecordingWriter::create(&folder, manifest(), FORMAT_2).unwrap();
        write_data(&mut writer);
        if let Some(ending) = ending {
            writer.finish(ending).unwrap();
        }
    };
    let labels = [
        label(TrialBlock::Practice, 1, 1),
        label(TrialBlock::Main, 2, 1),
        label(TrialBlock::Main, 2, 2),
        label(TrialBlock::Main, 10, 1),
    ];
    record(labels[3], None);
    record(labels[0], Some(Ending::Completed));
    record(labels[2], Some(Ending::Completed));
    let reason = "paused".to_owned();
    record(labels[1], Some(Ending::Interrupted { reason }));
    session.snapshot("huloux2021.toml", "x").unwrap();

    let trials = session.recorded_trials().unwrap();
    assert_eq!(trials.iter().map(|t| t.label).collect::<Vec<_>>(), labels);
    let ends: Vec<_> = trials
        .iter()
        .map(|t| t.manifest.as_ref().unwrap().trial.as_ref().unwrap().end)
        .collect();
    assert_eq!(
        ends,
        [
            Some(End::Completed),
            Some(End::Interrupted),
            Some(End::Completed),
            None
        ]
    );
    let error = session.trial_folder(labels[1]).unwrap_err();
    assert!(error.to_string().contains("never overwritten"), "{error}");
}

#[test]
fn a_damaged_trial_is_listed_with_its_damage() {
    let temp = tempfile::tempdir().unwrap();
    let study = open(temp.path()).unwrap();
    let session = begin(&study, "sub-01", 1).unwrap();
    fs::create_dir(session.trial_folder(label(TrialBlock::Main, 1, 1)).unwrap()).unwrap();
    let trials = session.recorded_trials().unwrap();
    assert!(trials[0].manifest.is_err());
}

#[test]
fn snapshots_are_kept_and_numbered_when_they_differ() {
    let temp = tempfile::tempdir().unwrap();
    let study = open(temp.path()).unwrap();
    let session = begin(&study, "sub-01", 1).unwrap();
    let snapshot_name = |contents| {
        let path = session.snapshot("bench.toml", contents).unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), contents);
        path.file_name().unwrap().to_str().unwrap().to_owned()
    };
    assert_eq!(snapshot_name("a"), "bench.toml");
    assert_eq!(snapshot_name("a"), "bench.toml");
    assert_eq!(snapshot_name("b"), "bench.2.toml");
    assert_eq!(snapshot_name("b"), "bench.2.toml");
    for name in ["", "..", "../x", "/etc/x", "a/b", "a\\b", "a/"] {
        let error = session.snapshot(name, "x").unwrap_err();
        assert!(matches!(error, StudyError::SnapshotName { .. }), "{error}");
    }
}

#[test]
fn a_log_reads_back_document_by_document() {
    let temp = tempfile::tempdir().unwrap();
    let path = temp.path().join("events.jsonl");
    let mut log = EventLog::create(path.clone()).unwrap();
    log_a_session(&mut log, false);
    log.stop(TIME.to_owned(), ExitStatus::Fail, Some("fault".to_owned()))
        .unwrap();
    let content = event_log::read(&path).unwrap();
    assert_eq!(
        content.documents[0],
        Document::Start(Box::new(start(false)))
    );
    let Document::Event(event) = &content.documents[3] else {
        panic!("an event expected");
    };
    assert_eq!((event.seq_num, event.audio_s), (2, 2.5));
    assert_eq!(event.data, data(2));
    assert_eq!(content.stop().unwrap().num_events, 2);
    // The log is readable line by line without this project: pandas.read_json(lines=True) and jq.
    let text = fs::read_to_string(&path).unwrap();
    let kinds: Vec<Value> = text
        .lines()
        .map(|line| serde_json::from_str::<Value>(line).unwrap()["document"].clone())
        .collect();
    assert_eq!(kinds, ["start", "descriptor", "event", "event", "stop"]);
    assert!(EventLog::create(path).is_err(), "never overwritten");
}

#[test]
fn a_torn_line_is_left_out_only_where_a_killed_process_leaves_one() {
    let temp = tempfile::tempdir().unwrap();
    let path = temp.path().join("events.jsonl");
    let mut log = EventLog::create(path.clone()).unwrap();
    log_a_session(&mut log, false);
    drop(log);
    let intact = fs::read(&path).unwrap();
    fs::write(&path, &intact[..intact.len() - 10]).unwrap();

    let (mut log, before) = EventLog::open(path.clone()).unwrap();
    assert_eq!((before.documents.len(), before.torn_lines), (3, vec![4]));
    log.start(start(true)).unwrap();
    log.event("trial", TIME.to_owned(), 0.0, data(2)).unwrap();
    let content = event_log::read(&path).unwrap();
    assert_eq!((content.documents.len(), content.torn_lines), (5, vec![4]));

    let damaged = String::from_utf8(intact)
        .unwrap()
        .replacen("descriptor", "descripto", 1);
    fs::write(&path, damaged).unwrap();
    let error = event_log::read(&path).unwrap_err();
    assert!(
        matches!(error, EventLogError::Line { line: 2, .. }),
        "{error}"
    );
}

#[test]
fn a_removed_log_is_an_error() {
    let temp = tempfile::tempdir().unwrap();
    let path = temp.path().join("events.jsonl");
    let mut log = EventLog::create(path.clone()).unwrap();
    fs::remove_file(&path).unwrap();
    assert!(log.start(start(false)).is_err());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn a_log_cut_anywhere_keeps_all_whole_lines(share in 0.0..=1.0) {
        let temp = tempfile::tempdir().unwrap();
        let path = temp.path().join("events.jsonl");
        // Made once, because its syncs are slow.
        static WHOLE: LazyLock<Vec<u8>> = LazyLock::new(|| {
            let temp = tempfile::tempdir().unwrap();
            let path = temp.path().join("events.jsonl");
            log_a_session(&mut EventLog::create(path.clone()).unwrap(), false);
            fs::read(&path).unwrap()
        });
        let intact = &*WHOLE;
        let cut = &intact[..(share * intact.len() as f64) as usize];
        fs::write(&path, cut).unwrap();
        let lines = cut.iter().filter(|byte| **byte == b'\n').count();
        let documents = event_log::read(&path).unwrap().documents.len();
        // A line that lacks only its line break is complete.
        prop_assert!(documents == lines || documents == lines + 1);
        let (mut log, _) = EventLog::open(path.clone()).unwrap();
        log.start(start(true)).unwrap();
        prop_assert_eq!(event_log::read(&path).unwrap().documents.len(), documents + 1);
    }
}
