//! Tables as text of many kinds.

use std::fs;
use std::path::Path;

use source_files::{Attribute, Element, Format, SourceFile};

fn open(folder: &Path, text: impl AsRef<[u8]>) -> SourceFile {
    let path = folder.join("table.txt");
    fs::write(&path, text).unwrap();
    SourceFile::open(&path).unwrap_or_else(|error| panic!("{error}"))
}

fn refused(folder: &Path, text: impl AsRef<[u8]>) -> String {
    let path = folder.join("table.csv");
    fs::write(&path, text).unwrap();
    SourceFile::open(&path).unwrap_err().to_string()
}

fn column(source: &mut SourceFile, name: &str) -> Vec<f64> {
    let vector = source
        .locate(name)
        .unwrap_or_else(|error| panic!("{error}"));
    let mut values = Vec::new();
    source
        .read(&vector, 0..vector.len(), &mut values)
        .unwrap_or_else(|error| panic!("{error}"));
    values
}

fn names(source: &SourceFile) -> Vec<&str> {
    source
        .arrays()
        .iter()
        .map(|info| info.name.as_str())
        .collect()
}

#[test]
fn one_table_reads_the_same_from_any_program() {
    let folder = tempfile::tempdir().unwrap();
    for text in [
        "t,F\n0,0.5\n1,-1.25\n2,3\n",
        "\u{feff}t;F\r\n0;0,5\r\n1;-1,25\r\n2;3\r\n",
        "sep=;\nt;F\n0;0.5\n1;-1.25\n2;3\n",
        "t\tF\r0\t0,5\r1\t-1,25\r2\t3\r",
        "  t    F\n  0   0.5\n  1 -1.25\n  2  3\n",
        "t 0,5 F\nt F\n0 0,5\n1 -1,25\n2 3\n",
        "# exported by a program\n# t F\n0 0.5\n1 -1.25\n2 3\n",
        "% t,F\n0,0.5\n1,-1.25\n2,3\n",
        "\"t\",\"F\"\n\"0\",\"0.5\"\n\"1\",\"-1.25\"\n\"2\",\"3\"",
        "Rate:,1000\nOperator,somebody\n\nt,F\ns,N\n0,0.5\n1,-1.25\n2,3\n\n",
        "t,F\n0,0.5\n# a remark\n1,-1.25\n\n2,3\nend of file\n",
        "t,F,\n0,0.5,\n1,-1.25,\n2,3,\n",
    ] {
        let mut source = open(folder.path(), text);
        assert_eq!(names(&source), ["t", "F"], "{text:?}");
        assert_eq!(column(&mut source, "t"), [0.0, 1.0, 2.0], "{text:?}");
        assert_eq!(column(&mut source, "F"), [0.5, -1.25, 3.0], "{text:?}");
        assert_eq!(column(&mut source, "1"), [0.5, -1.25, 3.0], "{text:?}");
    }
}

#[test]
fn units_stand_below_or_in_the_names() {
    let folder = tempfile::tempdir().unwrap();
    for text in [
        "time,force\ns,mN\n0,1.5\n1,2.5\n",
        "time [s];force [mN]\n0;1,5\n1;2,5\n",
        "time (s)\tforce (mN)\n0\t1.5\n1\t2.5\n",
        "time,force\n[s],[mN]\n0,1.5\n1,2.5\n",
    ] {
        let mut source = open(folder.path(), text);
        let units: Vec<_> = source
            .arrays()
            .iter()
            .map(|info| info.unit.as_deref())
            .collect();
        assert_eq!(units, [Some("s"), Some("mN")], "{text:?}");
        assert_eq!(column(&mut source, "force"), [1.5, 2.5]);
    }
}

#[test]
fn a_file_of_labview_has_its_header_and_its_interval() {
    let folder = tempfile::tempdir().unwrap();
    let text = "LabVIEW Measurement\t\nWriter_Version\t2\nSeparator\tTab\nDecimal_Separator\t.\n***End_of_Header***\t\n\t\nChannels\t2\t\t\n\
                Samples\t3\t3\t\nDelta_X\t0.000500\t0.000500\t\n***End_of_Header***\t\t\t\nX_Value\tVoltage\tForce\tComment\n\
                0.000000\t1.5\t-2.5\n0.000500\t1.25\t-2.25\n0.001000\t1.125\t-2.125\n";
    let mut source = open(folder.path(), text);
    assert_eq!(column(&mut source, "Force"), [-2.5, -2.25, -2.125]);
    assert_eq!(column(&mut source, "X_Value"), [0.0, 5e-4, 1e-3]);
    assert_eq!(source.format(), Format::Lvm);
    assert_eq!(source.stated_rate_hz(), Some(2000.0));
    let units: Vec<_> = source
        .arrays()
        .iter()
        .map(|info| info.unit.clone())
        .collect();
    assert_eq!(units, [Some("s".to_owned()), None, None]);
    let bare = text.replace("Separator\tTab", "Separator\tTab\nX_Columns\tNo");
    let source = open(folder.path(), bare.replace("\n0.00", "\n\t0.00"));
    let force = source.locate("Force").unwrap();
    assert_eq!(force.rate_hz(), Some(2000.0));
    let word = text.replace("-2.25", "off");
    let mut source = open(folder.path(), word);
    let force = source.locate("Force").unwrap();
    let error = source
        .read(&force, 0..3, &mut Vec::new())
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("line 13, column `Force`: \"off\" is not a number"),
        "{error}"
    );
}

#[test]
fn text_of_utf_16_is_read() {
    let folder = tempfile::tempdir().unwrap();
    let text = "\u{feff}Zeit [s]\tKraft [µN]\r\n0\t1,5\r\n0,001\t2,5\r\n0,002\t3,5\r\n";
    let little: Vec<u8> = text.encode_utf16().flat_map(u16::to_le_bytes).collect();
    let big: Vec<u8> = text.encode_utf16().flat_map(u16::to_be_bytes).collect();
    for bytes in [little, big] {
        let mut source = open(folder.path(), bytes);
        assert_eq!(names(&source), ["Zeit [s]", "Kraft [µN]"]);
        assert_eq!(column(&mut source, "Kraft"), [1.5, 2.5, 3.5]);
    }
}

#[test]
fn two_columns_of_time_have_their_lengths() {
    let folder = tempfile::tempdir().unwrap();
    let text = "Time,Force,Time,Position\n0,1,0,10\n0.1,2,0.5,20\n0.2,3,,\n0.3,4,,\n";
    let mut source = open(folder.path(), text);
    assert_eq!(names(&source), ["Time", "Force", "Time.1", "Position"]);
    assert_eq!(column(&mut source, "Position"), [10.0, 20.0]);
    assert_eq!(column(&mut source, "Time.1"), [0.0, 0.5]);
    assert_eq!(column(&mut source, "Force").len(), 4);
    assert!(
        source
            .notes()
            .iter()
            .any(|note| note.contains("2 columns seem to be times"))
    );
}

#[test]
fn rows_without_values_keep_their_places() {
    let folder = tempfile::tempdir().unwrap();
    let mut source = open(
        folder.path(),
        "t,F,mark\n0,1,\n,,\n2,3,\n3,4,9\n4,5,\n5,6,\n,,\n,,\n",
    );
    let times = column(&mut source, "t");
    assert!(
        times.len() == 6 && times[1].is_nan() && times[2] == 2.0,
        "{times:?}"
    );
    let marks = column(&mut source, "mark");
    assert!(
        marks.len() == 4 && marks[2].is_nan() && marks[3] == 9.0,
        "{marks:?}"
    );
    let mut bare = open(folder.path(), "0;1;7\n1;2\n2;3\n3;4\n");
    assert_eq!(column(&mut bare, "1"), [1.0, 2.0, 3.0, 4.0]);
    assert_eq!(column(&mut bare, "2"), [7.0]);
    let mut late = open(folder.path(), "t,F\nNaN,NaN\n1,2\n2,3\n");
    assert_eq!(column(&mut late, "F").len(), 3);
    let rows_of_r = "\"x\"\t\"F\"\n\"1\"\t0\t5\n\"2\"\t1\t6\n";
    assert_eq!(column(&mut open(folder.path(), rows_of_r), "F"), [5.0, 6.0]);
}

#[test]
fn missing_values_are_nan_and_times_are_seconds() {
    let folder = tempfile::tempdir().unwrap();
    let text = "when,F,ok,who\n00:00:01.500,1,True,a\n00:00:02.500,,False,b\n00:00:03.500,NaN,True,c\n00:01:00.000,4,True,d\n";
    let mut source = open(folder.path(), text);
    assert_eq!(source.arrays()[0].element, Element::Time);
    assert_eq!(column(&mut source, "when"), [1.5, 2.5, 3.5, 60.0]);
    let forces = column(&mut source, "F");
    assert!(forces[1].is_nan() && forces[2].is_nan() && forces[3] == 4.0);
    assert_eq!(column(&mut source, "ok"), [1.0, 0.0, 1.0, 1.0]);
    let error = source.locate("who").unwrap_err().to_string();
    assert!(error.contains("`who` is a text"), "{error}");
}

#[test]
fn values_above_the_table_are_attributes() {
    let folder = tempfile::tempdir().unwrap();
    let text = "# fs = 12500\n# operator: somebody\nt,F\n0,1\n1,2\n";
    let mut source = open(folder.path(), text);
    assert_eq!(source.scalar("@fs").unwrap(), 12_500.0);
    let operator = Attribute::Text("somebody".to_owned());
    assert!(
        source
            .attributes()
            .any(|(name, value)| name == "@operator" && *value == operator)
    );
}

#[test]
fn letters_of_western_europe_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let mut source = open(folder.path(), b"Weg [\xb5m];Kraft\n0,5;1\n1,5;2\n");
    assert_eq!(source.arrays()[0].name, "Weg [µm]");
    assert_eq!(column(&mut source, "Weg"), [0.5, 1.5]);
    assert!(
        source
            .notes()
            .iter()
            .any(|note| note.contains("Western Europe"))
    );
}

#[test]
fn a_cell_that_is_no_number_is_named_with_its_line_and_column() {
    let folder = tempfile::tempdir().unwrap();
    let rows: String = (0..3000)
        .map(|row| match row {
            2500 => "2500,broken\n".to_owned(),
            row => format!("{row},{}.5\n", row % 7),
        })
        .collect();
    let mut source = open(folder.path(), format!("t,F\n{rows}"));
    let vector = source.locate("F").unwrap();
    let mut values = Vec::new();
    source.read(&vector, 0..2500, &mut values).unwrap();
    assert_eq!(values.len(), 2500);
    let error = source
        .read(&vector, 2400..2600, &mut values)
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("line 2502, column `F`: \"broken\" is not a number"),
        "{error}"
    );
}

#[test]
fn the_first_cell_of_a_column_that_is_no_number_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let rows =
        |bad: &str| format!("t;F;x\n0,0;0,5;10,1\n0,1;0,6;{bad}\n0,2;0,7;{bad}\n0,3;0,8;10,4\n");
    for (cell, words) in [
        ("10. Jan", "a spreadsheet may have made a date of it"),
        ("10.000,0", "groups of thousands"),
        ("10,2 mm", "it may have a unit"),
        ("#####", "its column was too narrow"),
    ] {
        let mut source = open(folder.path(), rows(cell));
        let error = match source.locate("x") {
            Ok(vector) => source.read(&vector, 0..4, &mut Vec::new()).unwrap_err(),
            Err(error) => error,
        };
        let error = error.to_string();
        let place = format!("line 3, column `x`: {cell:?} is not");
        assert!(error.contains(&place) && error.contains(words), "{error}");
        assert_eq!(column(&mut source, "F"), [0.5, 0.6, 0.7, 0.8]);
    }
    let all = "t,x\n0,\"10,000.0\"\n1,\"10,001.0\"\n2,\"10,002.0\"\n";
    let error = open(folder.path(), all)
        .locate("x")
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("line 2, column `x`: \"10,000.0\""),
        "{error}"
    );
}

#[test]
fn a_first_row_with_a_flaw_is_no_header() {
    let folder = tempfile::tempdir().unwrap();
    for flaw in ["10. Jan", "OVER"] {
        let rows: String = (1..40).map(|i| format!("{i};0.5;{i}\n")).collect();
        let mut source = open(folder.path(), format!("t;F;x\n0;0.25;{flaw}\n{rows}"));
        assert_eq!(names(&source), ["t", "F", "x"]);
        assert_eq!(column(&mut source, "F")[..2], [0.25, 0.5]);
        let vector = source.locate("x").unwrap();
        let error = source
            .read(&vector, 0..2, &mut Vec::new())
            .unwrap_err()
            .to_string();
        assert!(error.contains("line 2, column `x`"), "{error}");
    }
    let wavelengths = "t;400;500\n0;1;2\n1;2;3\n2;3;4\n";
    assert_eq!(
        names(&open(folder.path(), wavelengths)),
        ["t", "400", "500"]
    );
}

#[test]
fn times_with_dates_of_any_country_are_read() {
    let folder = tempfile::tempdir().unwrap();
    for time in [
        "2026-11-02T10:00:0#.500+02:00",
        "2026-11-02 08:00:0#.500000+00:00",
        "02.11.2026 08:00:0#,5",
        "02-Nov-2026 08:00:0#.5",
        "13/11/2026 08:00:0#.5",
        "11/13/2026 8:00:0#.5 AM",
        "8:00:0#.5",
        "00:0#.5",
        "0.#5 sec",
        "0 days 00:00:0#.500000",
    ] {
        let rows: String = (0..5)
            .map(|i| format!("{};{i}\n", time.replace('#', &i.to_string())))
            .collect();
        let mut source = open(folder.path(), format!("t;F\n{rows}"));
        assert_eq!(source.arrays()[0].element, Element::Time, "{time}");
        let times = column(&mut source, "t");
        let step = if time.ends_with("sec") { 0.1 } else { 1.0 };
        for (i, time_s) in times.iter().enumerate() {
            assert!(
                (time_s - times[0] - step * i as f64).abs() < 1e-6,
                "{time}: {times:?}"
            );
        }
    }
    let midnight = "t;F\n12/10/2026 23:59:59.5;0\n13/10/2026 00:00:00.5;1\n";
    let times = column(&mut open(folder.path(), midnight), "t");
    assert_eq!(times[1] - times[0], 1.0);
    let mut source = open(
        folder.path(),
        "t;F\n03/04/2026 10:00:00;0\n03/04/2026 10:00:01;1\n",
    );
    let vector = source.locate("t").unwrap();
    let error = source
        .read(&vector, 0..2, &mut Vec::new())
        .unwrap_err()
        .to_string();
    let words = "\"03/04/2026 10:00:00\" may be day 3 of month 4 or day 4 of month 3";
    assert!(
        error.contains("line 2, column `t`") && error.contains(words),
        "{error}"
    );
}

#[test]
fn what_is_no_table_is_refused_with_its_remedy() {
    let folder = tempfile::tempdir().unwrap();
    for (text, words) in [
        (
            "these are only words\nof a text\n",
            "text without a table of numbers",
        ),
        ("", "an empty file"),
        (
            "t,F\n0,5,1,5\n1,5,2,5\n2,5,3,5\n",
            "commas seem to be decimal signs",
        ),
        ("{\"a\": \"b\"}\n", "text without a table of numbers"),
    ] {
        let error = refused(folder.path(), text);
        assert!(
            error.contains(words) && error.contains("table.csv"),
            "{error}"
        );
    }
}
