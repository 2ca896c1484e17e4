//! The readers on the fuzzer's seeds and on damaged copies of them, without a fuzzer: see `fuzz/README.md`.

use std::path::{Path, PathBuf};

use rand::{RngExt, SeedableRng};

#[path = "../../../fuzz/readers.rs"]
mod readers;

/// Number of damaged copies of each seed.
const COPIES: u64 = 300;

/// Bytes of numbers, of structure and of neither, which decide a reader's path.
const TELLING: &[u8] = b"\0\x01\x7f\xff\n\r,.-eE\"=[]#09nif";

fn damaged(seed: &[u8], number: u64) -> Vec<u8> {
    let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(number);
    let mut bytes = seed.to_vec();
    for _ in 0..random.random_range(1..=4) {
        let offset = random.random_range(0..=bytes.len());
        let length = random.random_range(0..=(bytes.len() - offset).min(16));
        match random.random_range(0..5) {
            0 => bytes.truncate(offset),
            1 => drop(bytes.drain(offset..offset + length)),
            2 => {
                let copy = bytes[offset..offset + length].to_vec();
                bytes.splice(offset..offset, copy);
            }
            3 => bytes.insert(offset, TELLING[random.random_range(0..TELLING.len())]),
            _ => {
                for byte in &mut bytes[offset..offset + length.min(1)] {
                    *byte = random.random();
                }
            }
        }
    }
    bytes
}

fn replay(target: &str, reads: fn(&[u8]) -> bool) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../fuzz/seeds")
        .join(target);
    let seeds: Vec<PathBuf> = std::fs::read_dir(&folder)
        .expect("seeds")
        .map(|entry| entry.expect("a seed").path())
        .collect();
    assert!(!seeds.is_empty(), "no seeds in {}", folder.display());
    for path in seeds {
        let seed = std::fs::read(&path).expect("a seed");
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        assert_eq!(reads(&seed), name.starts_with("sound"), "{target}/{name}");
        for number in 0..COPIES {
            reads(&damaged(&seed, number));
        }
    }
}

#[test]
fn wav_files() {
    replay("wav", readers::wav);
}

#[test]
fn manifests() {
    replay("manifest", readers::manifest);
}

#[test]
fn protocol_files() {
    replay("protocol", readers::protocol);
}

#[test]
fn bench_descriptions() {
    replay("config", readers::config);
}

#[test]
fn calibrations() {
    replay("calibration", readers::calibration);
}

#[test]
fn rows_of_forces_and_positions() {
    replay("force_rows", readers::force_rows);
    replay("position_rows", readers::position_rows);
}

#[test]
fn lines_of_force_sensors() {
    replay("force_frames", readers::force_frames);
    replay("force_lines", readers::force_lines);
}

#[test]
fn lines_and_tables_of_known_amplitudes() {
    replay("vibrometer", readers::vibrometer);
    replay("known_amplitudes", readers::known_amplitudes);
}

#[test]
fn logs_of_sessions() {
    replay("event_log", readers::event_log);
}

#[test]
fn presses_of_the_estop() {
    replay("estop_press", readers::estop_press);
}

#[test]
fn exclusions() {
    replay("exclusions", readers::exclusions);
}

#[test]
fn driving_records() {
    replay("driving_times", readers::driving_times);
    replay("plate_warmth", readers::plate_warmth);
}

#[test]
fn scenarios() {
    replay("scenario", readers::scenario);
}

#[test]
fn lines_of_a_field_box() {
    replay("field_box", readers::field_box);
}
