//! Tables with the rows of a fast signal, in which a slow one has a value here and there.

use std::fs;

use crate::import_all;
use crate::laboratory::{Laboratory, SIGNALS_MAP};

#[test]
fn forces_of_a_merged_table_are_those_of_a_table_of_their_own() {
    let (apart, merged) = (Laboratory::with_reference(), Laboratory::with_reference());
    assert!(import_all(&apart, SIGNALS_MAP)[0].outcome.is_ok());

    let path = merged.folder().join("force_7.csv");
    let table = fs::read_to_string(&path).unwrap();
    let (header, rows) = table.trim_end().split_once('\n').unwrap();
    let mut text = format!("{header}\n");
    let mut before_s: Option<f64> = None;
    for row in rows.lines() {
        let (time, forces) = row.split_once(';').unwrap();
        let time_s: f64 = time.replace(',', ".").parse().unwrap();
        if let Some(before_s) = before_s {
            for share in [0.25, 0.5, 0.75] {
                let gaps = ";".repeat(forces.matches(';').count());
                let between_s = before_s + share * (time_s - before_s);
                let time = format!("{between_s:.9}").replace('.', ",");
                text += &format!("{time};{gaps}\n");
            }
        }
        text += &format!("{row}\n");
        before_s = Some(time_s);
    }
    fs::write(&path, text).unwrap();
    let reports = import_all(&merged, SIGNALS_MAP);
    assert!(reports[0].outcome.is_ok(), "{reports:?}");
    let forces =
        |laboratory: &Laboratory| fs::read(laboratory.recording().join("force.csv")).unwrap();
    assert!(forces(&apart) == forces(&merged), "other forces");
}
