//! Damaged files: each is read or refused, and nothing panics or hangs.

use std::fs;
use std::path::Path;

use proptest::prelude::*;
use proptest::sample::Index;
use proptest::test_runner::{Config, TestRunner};
use source_files::SourceFile;

use crate::other_programs::write_files;

/// Files of every format, short ones first choice of a fuzzer.
const FILES: [&str; 19] = [
    "v4.mat",
    "v5.mat",
    "v7.mat",
    "rows.npy",
    "columns.npy",
    "records.npy",
    "stored.npz",
    "deflated.npz",
    "i16.wav",
    "f64.rf64",
    "f64.w64",
    "i16.flac",
    "i24.flac",
    "english.csv",
    "german.csv",
    "tabs.tsv",
    "blanks.txt",
    "snappy.parquet",
    "gzip.parquet",
];

/// Values that are read of each array.
const MOST_VALUES: u64 = 5000;

/// Damage of a file.
#[derive(Debug, Clone)]
enum Damage {
    Byte(Index, u8),
    Word(Index, u32),
    Cut(Index),
    Remove(Index, u8),
    Repeat(Index, u8),
}

fn damages() -> impl Strategy<Value = Vec<Damage>> {
    let word = prop_oneof![
        Just(0),
        Just(u32::MAX),
        Just(i32::MAX as u32),
        any::<u32>(),
        0u32..300
    ];
    // Headers are short, and are hit as often as all that follows.
    let damage = prop_oneof![
        (any::<Index>(), any::<u8>()).prop_map(|(place, byte)| Damage::Byte(place, byte)),
        (any::<Index>(), word).prop_map(|(place, word)| Damage::Word(place, word)),
        any::<Index>().prop_map(Damage::Cut),
        (any::<Index>(), any::<u8>()).prop_map(|(place, count)| Damage::Remove(place, count)),
        (any::<Index>(), any::<u8>()).prop_map(|(place, count)| Damage::Repeat(place, count)),
    ];
    prop::collection::vec(damage, 1..4)
}

fn damaged(bytes: &[u8], damages: &[Damage], is_early: bool) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    for damage in damages {
        if bytes.len() < 8 {
            break;
        }
        let most = if is_early {
            bytes.len().min(600)
        } else {
            bytes.len()
        };
        let place = |index: &Index| index.index(most - 4);
        match damage {
            Damage::Byte(index, byte) => bytes[place(index)] = *byte,
            Damage::Word(index, word) => {
                let place = place(index);
                bytes[place..place + 4].copy_from_slice(&word.to_le_bytes());
            }
            Damage::Cut(index) => bytes.truncate(place(index)),
            Damage::Remove(index, count) => {
                let place = place(index);
                let end = (place + usize::from(*count)).min(bytes.len());
                bytes.drain(place..end);
            }
            Damage::Repeat(index, count) => {
                let place = place(index);
                let end = (place + usize::from(*count)).min(bytes.len());
                let part = bytes[place..end].to_vec();
                bytes.splice(place..place, part);
            }
        }
    }
    bytes
}

/// Opens a file and reads of every array.
fn read_all(path: &Path) {
    let mut source = match SourceFile::open(path) {
        Ok(source) => source,
        Err(error) => {
            let text = error.to_string();
            assert!(text.contains("damaged") && text.len() > 20, "{text}");
            return;
        }
    };
    let names: Vec<String> = source
        .arrays()
        .iter()
        .take(40)
        .map(|info| info.name.clone())
        .collect();
    for name in names {
        let column = format!("{name}[:,0]");
        let Ok(vector) = source.locate(&name).or_else(|_| source.locate(&column)) else {
            let _ = source.text(&name);
            continue;
        };
        let mut values = Vec::new();
        let early = 0..vector.len().min(MOST_VALUES);
        let _ = source.read_complex(&vector, early, &mut values);
        let late = vector.len().saturating_sub(10)..vector.len();
        let _ = source.read_complex(&vector, late, &mut values);
        let _ = source.scalar(&name);
    }
}

#[test]
fn damaged_files_are_read_or_refused() {
    // A campaign tries as many as it has time for.
    let cases: u32 =
        std::env::var("FRICTION_BENCH_DAMAGED_FILES").map_or(20, |cases| cases.parse().unwrap());
    let folder = tempfile::tempdir().unwrap();
    write_files(folder.path());
    for file in FILES {
        let bytes = fs::read(folder.path().join(file)).unwrap();
        let path = folder.path().join(format!("damaged-{file}"));
        let started = std::time::Instant::now();
        let mut runner = TestRunner::new(Config {
            cases,
            max_shrink_iters: 200,
            failure_persistence: None,
            ..Config::default()
        });
        runner
            .run(&(damages(), any::<bool>()), |(damages, is_early)| {
                fs::write(&path, damaged(&bytes, &damages, is_early)).unwrap();
                read_all(&path);
                Ok(())
            })
            .unwrap_or_else(|error| panic!("{file}: {error}"));
        println!("TIME {file} {:?}", started.elapsed());
    }
}
