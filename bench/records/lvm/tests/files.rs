//! Files of all forms that the specification has.
#![expect(clippy::unwrap_used, reason = "helpers of tests may fail a test")]

use std::io::Write;

use lvm_files::{LvmError, LvmFile};
use text_lines::TextForm;

fn open(text: &str) -> Result<LvmFile, LvmError> {
    let mut file = tempfile::tempfile().unwrap();
    file.write_all(text.as_bytes()).unwrap();
    LvmFile::open(file, TextForm::find(text.as_bytes()))
}

fn column(file: &LvmFile, name: &str) -> Vec<f64> {
    let index = file.columns().iter().position(|column| column.name == name);
    let index = index.unwrap_or_else(|| panic!("no column {name}: {:?}", file.columns()));
    let mut values = Vec::new();
    let length = file.columns()[index].length;
    file.read(index, 0..length, &mut values).unwrap();
    let mut second = Vec::new();
    file.read(index, 1..length, &mut second).unwrap();
    assert_eq!(values[1..], second);
    values
}

fn rate_hz(file: &LvmFile, name: &str) -> Option<f64> {
    let found = file.columns().iter().find(|column| column.name == name);
    found.unwrap().rate_hz
}

/// Returns the header of a file.
fn file_header(x_columns: &str, multi_headings: &str, decimal: &str) -> String {
    format!(
        "LabVIEW Measurement\t\r\nWriter_Version\t2\r\nSeparator\tTab\r\nDecimal_Separator\t{decimal}\r\n\
         Multi_Headings\t{multi_headings}\r\nX_Columns\t{x_columns}\r\nTime_Pref\tRelative\r\n***End_of_Header***\t\r\n\t\r\n"
    )
}

/// Returns the header of a segment of two channels that begins at a second of a minute.
fn segment(samples: u64, second: &str, delta: &str) -> String {
    format!(
        "Channels\t2\t\t\r\nSamples\t{samples}\t{samples}\t\r\nDate\t2026/03/01\t2026/03/01\t\r\n\
         Time\t10:00:{second}\t10:00:{second}\t\r\nY_Unit_Label\tNewton\tmm\t\r\nX_Dimension\tTime\tTime\t\r\nX0\t0\t0\t\r\n\
         Delta_X\t{delta}\t{delta}\t\r\n***End_of_Header***\t\t\t\r\nX_Value\tFn\tx\tComment\r\n"
    )
}

#[test]
fn without_columns_of_x_the_header_states_the_rate() {
    let text = file_header("No", "No", ",")
        + &segment(3, "00,5", "4,0E-5")
        + "\t0,125\t10,5\r\n\t-0,25\t11\tsensor touched\r\n\t1,234\t12\r\n";
    let file = open(&text).unwrap();
    assert_eq!(column(&file, "Fn"), [0.125, -0.25, 1.234]);
    assert_eq!(column(&file, "x"), [10.5, 11.0, 12.0]);
    assert_eq!(file.columns().len(), 2);
    assert_eq!(rate_hz(&file, "Fn"), Some(25_000.0));
    let units: Vec<_> = file
        .columns()
        .iter()
        .map(|column| column.unit.as_deref())
        .collect();
    assert_eq!(units, [Some("Newton"), Some("mm")]);
    assert_eq!(file.tags()["Delta_X"], "4,0E-5");
}

#[test]
fn samples_of_all_segments_follow_one_another() {
    for (x_columns, x) in [("No", ""), ("One", "0.5")] {
        let row = |fn_n: &str, x_mm: &str| format!("{x}\t{fn_n}\t{x_mm}\r\n");
        let text = file_header(x_columns, "Yes", ".")
            + &segment(2, "00", "0.500000")
            + &row("1", "10")
            + &row("2", "20")
            + "\t\r\n"
            + &segment(2, "01", "0.500000")
            + &row("3", "30")
            + "***Start_Special***\r\nanything\t9\r\n***End_Special***\r\n"
            + &row("4", "40")
            + "\r\n";
        let file = open(&text).unwrap();
        assert_eq!(column(&file, "Fn"), [1.0, 2.0, 3.0, 4.0], "{x_columns}");
        assert_eq!(column(&file, "x"), [10.0, 20.0, 30.0, 40.0]);
        let expected_hz = (x_columns == "No").then_some(2.0);
        assert_eq!(
            rate_hz(&file, "x"),
            expected_hz,
            "x stands still in the other one"
        );
    }
}

#[test]
fn a_gap_between_segments_gives_times_in_place_of_a_rate() {
    let rows = "\t1\t10\r\n\t2\t20\r\n";
    let file = |second: &str| {
        let text = file_header("No", "Yes", ".")
            + &segment(2, "00", "0.250000")
            + rows
            + &segment(2, second, "0.250000")
            + rows;
        open(&text).unwrap()
    };
    let gapped = file("07.5");
    assert_eq!(rate_hz(&gapped, "Fn"), None);
    assert_eq!(column(&gapped, "X_Value"), [0.0, 0.25, 7.5, 7.75]);
    let note = gapped.notes().join("; ");
    assert!(note.contains("segment 2 begins 7.000000 s after"), "{note}");
    let stated_once = file("00");
    assert_eq!(rate_hz(&stated_once, "Fn"), Some(4.0));
    let note = stated_once.notes().join("; ");
    assert!(note.contains("2 segments state one start"), "{note}");
    assert_eq!(rate_hz(&file("00.5"), "Fn"), Some(4.0));
}

#[test]
fn each_channel_may_have_its_own_x_and_length() {
    let text = file_header("Multi", "No", ".")
        + "Channels\t3\t\t\t\t\t\r\nSamples\t3\t\t2\t\t0\t\r\nY_Unit_Label\tN\t\tmm\t\tV\t\r\nX_Dimension\tTime\t\tTime\t\tTime\t\r\n\
           X0\t0\t\t1\t\t0\t\r\nDelta_X\t0.5\t\t1\t\t1\t\r\n***End_of_Header***\t\r\nX_Value\tFn\tX_Value\tx\tX_Value\tU\tComment\r\n\
           0\t1\t1\t10\r\n0.5\t2\t2\t20\r\n1\t3\t\t\r\n";
    let file = open(&text).unwrap();
    assert_eq!(column(&file, "X_Value"), [0.0, 0.5, 1.0]);
    assert_eq!(column(&file, "X_Value.1"), [1.0, 2.0]);
    assert_eq!(column(&file, "x"), [10.0, 20.0]);
    let columns = file.columns();
    assert_eq!(
        (columns[1].rate_hz, columns[3].rate_hz),
        (Some(2.0), Some(1.0))
    );
    assert_eq!(
        (columns[3].start_s, columns[3].unit.as_deref()),
        (1.0, Some("mm"))
    );
    assert!(
        file.notes()
            .iter()
            .any(|note| note.ends_with("left out: `X_Value.2`, `U`"))
    );
}

#[test]
fn commas_may_separate_cells() {
    let text = "LabVIEW Measurement,\nSeparator,Comma\nX_Columns,One\n***End_of_Header***,\n,\nChannels,1,\nSamples,2,\nDelta_X,0.001,\n\
                ***End_of_Header***,,\nX_Value,Fn,Comment\n0.000,1.5\n0.001,2.5\n";
    let file = open(text).unwrap();
    assert_eq!(column(&file, "Fn"), [1.5, 2.5]);
    assert_eq!(rate_hz(&file, "Fn"), Some(1000.0));
    let commas = text.replace("X_Columns", "Decimal_Separator,,\nX_Columns");
    let refusal = open(&commas).err().unwrap().to_string();
    assert!(refusal.contains("are decimal signs too"), "{refusal}");
}

#[test]
fn contradictions_are_named() {
    let few_digits =
        file_header("No", "No", ".") + &segment(2, "00", "0.000977") + "\t1\t2\r\n\t1\t2\r\n";
    let notes = open(&few_digits).unwrap().notes().join("; ");
    assert!(notes.contains("between 1023.0 and 1024.1 Hz"), "{notes}");
    let cut = file_header("No", "No", ".") + &segment(9, "00", "0.001") + "\t1\t2\r\n\t1\t2\r\n\t1";
    let file = open(&cut).unwrap();
    let notes = file.notes().join("; ");
    assert_eq!(column(&file, "Fn").len(), 2);
    assert!(notes.contains("the last line is cut off"), "{notes}");
    assert!(
        notes.contains("states 9 samples of `Fn`, and 2 are there"),
        "{notes}"
    );
    let other_x = file_header("One", "No", ".")
        + &segment(1, "00", "1.0")
        + "0\t1\t2\r\n0.3\t1\t2\r\n1.2\t1\t2\r\n";
    assert_eq!(rate_hz(&open(&other_x).unwrap(), "Fn"), None);
    let form = file_header("Two", "No", ".") + &segment(1, "00", "1.0");
    assert!(
        open(&form)
            .err()
            .unwrap()
            .to_string()
            .contains("`X_Columns Two`")
    );
    let no_end = "LabVIEW Measurement\t\nSeparator\tTab\n";
    assert!(
        open(no_end)
            .err()
            .unwrap()
            .to_string()
            .contains("header does not end")
    );
    let word = file_header("No", "No", ".") + &segment(2, "00", "0.001") + "\t1\t2\r\n\tone\t2\r\n";
    let file = open(&word).unwrap();
    let refusal = file.read(0, 0..2, &mut Vec::new()).unwrap_err().to_string();
    assert!(
        refusal.starts_with("line 21, column Fn: \"one\""),
        "{refusal}"
    );
}

#[test]
fn damaged_files_are_read_or_refused() {
    let rows = "0\t1,5\t10\r\n0,5\t2\t20\r\n";
    for x_columns in ["No", "One", "Multi"] {
        let whole = file_header(x_columns, "Yes", ",")
            + &segment(2, "00", "5,0E-1")
            + rows
            + "\t\r\n"
            + &segment(2, "01", "5,0E-1")
            + rows;
        let read = |text: &str| {
            let Ok(file) = open(text) else { return };
            for (index, column) in file.columns().iter().enumerate() {
                let mut values = Vec::new();
                if file.read(index, 0..column.length, &mut values).is_ok() {
                    assert_eq!(values.len() as u64, column.length, "{text:?}");
                }
            }
        };
        for place in 0..whole.len() {
            read(&whole[..place]);
            for other in ["\t", "\n", "-", "9999999999", "x"] {
                read(&format!(
                    "{}{other}{}",
                    &whole[..place],
                    &whole[place + 1..]
                ));
            }
        }
    }
}
