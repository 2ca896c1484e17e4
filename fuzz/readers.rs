//! Fuzz properties of every reader of a file or a line: any input gives a value or an error that names the fault, never a
//! panic. Each function reads one input, checks the value's invariants, and returns whether there was a value.
//!
//! Included by the fuzz targets and by `bench/tests/integration/fuzz_seeds.rs`, which replays the seeds.

use std::cell::RefCell;
use std::io::{Cursor, ErrorKind, Read};
use std::path::{Path, PathBuf};

use calibration_rig::instrument_line::LineUnit;
use calibration_rig::known::{Instrument, read_table};
use config::{CalibrationFile, Config, ForceProtocol};
use devices::dose_account::{AccountPaths, DoseAccount};
use devices::estop_press::{EstopPress, EstopPressError};
use devices::plate_warmth::PlateWarmth;
use devices::{AccountOwner, Boot};
use field_box_wire::{FromBox, Listener};
use jiff::Timestamp;
use mock_world::scenario::Scenario;
use protocols::Protocol;
use recording::study::event_log;
use recording::{
    FORCE_FILE, MANIFEST_FILE, Manifest, POSITION_FILE, RecordingReader, SIGNALS_FILE,
};
use safety::PlateHeat;
use sha2::{Digest, Sha256};
use sources::serial::{ForceSample, decoder};
use study::exclusions::EXCLUSIONS_FILE;
use wav_files::{AudioFormat, WavReader, header};

const MANIFEST: &str = r#"format = 1
carrier_hz = 35000.0
modulation_hz = 6.0
modulation_index = 0.95
[channels.drive]
index = 0
volts_per_unit = 1.0
[channels.pickup]
index = 1
metres_per_unit = 2.0e-6
phase_rad = 0.0
[plate]
resonance_hz = 35000.0
modal_mass_kg = 0.008
force_factor_n_per_v = 0.13
centre_m = 0.0525
"#;

/// Computer that cannot distinguish its boots.
const BOOT: Boot = Boot {
    id: None,
    up_s: 0.0,
    machine: None,
};

/// Reads bytes as `signals.wav`: the file has as many frames as its header promises.
pub fn wav(bytes: &[u8]) -> bool {
    let Ok((mut reader, _)) = WavReader::new(Cursor::new(bytes)) else {
        return false;
    };
    let frame_count = reader.frames();
    let (mut read_count, mut block) = (0, Vec::new());
    while let Ok(frames) = reader.read_block(1024, &mut block) {
        if frames == 0 {
            break;
        }
        read_count += frames as u64;
    }
    assert_eq!(read_count, frame_count);
    true
}

/// Reads bytes as `recording.toml`: the value survives writing and reading back.
pub fn manifest(bytes: &[u8]) -> bool {
    let parse = |text: &str| Manifest::parse(text, MANIFEST_FILE);
    let Some(manifest) = text(bytes).and_then(|text| parse(text).ok()) else {
        return false;
    };
    let toml = manifest.to_toml().expect("what was read can be written");
    assert_eq!(
        parse(&toml).expect("what was written can be read"),
        manifest
    );
    true
}

/// Reads bytes as a protocol file.
pub fn protocol(bytes: &[u8]) -> bool {
    text(bytes).is_some_and(|text| Protocol::parse(text, "protocol.toml").is_ok())
}

/// Reads bytes as `bench.toml`.
pub fn config(bytes: &[u8]) -> bool {
    text(bytes).is_some_and(|text| Config::parse(text, "bench.toml").is_ok())
}

/// Reads bytes as `calibration.toml` after its hash: the value survives writing and reading back.
pub fn calibration(bytes: &[u8]) -> bool {
    let parse = |text: &str| CalibrationFile::parse(text, Path::new("calibration.toml"));
    let Some(body) = text(bytes) else {
        return false;
    };
    let hash: String = Sha256::digest(body)
        .iter()
        .map(|byte| format!("{byte:02x}"))
        .collect();
    let Ok((calibration, _)) = parse(&format!("sha256 = \"{hash}\"\n{body}")) else {
        return false;
    };
    let toml = calibration.to_text().expect("what was read can be written");
    let (copy, _) = parse(&toml).expect("what was written can be read");
    // Compared as text because NaN is not equal to itself.
    assert_eq!(format!("{copy:?}"), format!("{calibration:?}"));
    true
}

/// Reads bytes as `force.csv`: times increase from row to row.
pub fn force_rows(bytes: &[u8]) -> bool {
    read_with_sound_files(FORCE_FILE, bytes, |reader| {
        let rows = reader.force().ok()?;
        Some(count_increasing(
            rows.map_while(Result::ok).map(|row| row.time_s),
        ))
    })
}

/// Reads bytes as `position.csv`: times increase from row to row.
pub fn position_rows(bytes: &[u8]) -> bool {
    read_with_sound_files(POSITION_FILE, bytes, |reader| {
        let rows = reader.position().ok()?;
        Some(count_increasing(
            rows.map_while(Result::ok).map(|row| row.time_s),
        ))
    })
}

/// Decodes bytes of a serial line in the binary format; the first byte sets the chunk size of the rest.
pub fn force_frames(bytes: &[u8]) -> bool {
    force_line(ForceProtocol::Frames, bytes)
}

/// Decodes bytes from a field box: each decoded message encodes to bytes that decode to the same message.
pub fn field_box(bytes: &[u8]) -> bool {
    let mut listener = Listener::default();
    let messages: Vec<FromBox> = bytes
        .iter()
        .filter_map(|&byte| listener.hear(byte)?.ok())
        .collect();
    for message in &messages {
        let mut second_listener = Listener::default();
        let encoded = message.encode();
        let mut decoded = encoded
            .iter()
            .filter_map(|&byte| second_listener.hear(byte));
        assert_eq!(decoded.next(), Some(Ok(*message)));
    }
    !messages.is_empty()
}

/// Decodes bytes of a serial line in the text format; the first byte sets the chunk size of the rest.
pub fn force_lines(bytes: &[u8]) -> bool {
    force_line(ForceProtocol::Lines, bytes)
}

/// Checks that the chunk size has no effect, forces are finite, and device times of the text format increase.
fn force_line(protocol: ForceProtocol, bytes: &[u8]) -> bool {
    let Some((&chunk_size, bytes)) = bytes.split_first() else {
        return false;
    };
    let decode = |chunk_size: usize| -> (Vec<ForceSample>, _) {
        let (mut decoder, mut samples) = (decoder(protocol), Vec::new());
        for chunk in bytes.chunks(chunk_size) {
            decoder.decode(chunk, &mut samples);
        }
        (samples, decoder.faults())
    };
    let reference = decode(bytes.len().max(1));
    assert_eq!(decode(usize::from(chunk_size).max(1)), reference);
    let (samples, _) = reference;
    for sample in &samples {
        assert!(sample.normal_n.is_finite() && sample.lateral_n.is_finite());
    }
    if protocol == ForceProtocol::Lines {
        assert!(samples.is_sorted_by(|a, b| a.device_us < b.device_us));
    }
    !samples.is_empty()
}

/// Serial port that returns at most `chunk_size` bytes per read.
struct Port {
    bytes: Cursor<Vec<u8>>,
    chunk_size: usize,
}

impl Read for Port {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let length = buffer.len().min(self.chunk_size);
        match self.bytes.read(&mut buffer[..length])? {
            0 => Err(ErrorKind::WouldBlock.into()),
            n => Ok(n),
        }
    }
}

/// Decodes bytes from a vibrometer; the first byte sets the chunk size, which has no effect. Amplitudes are finite.
pub fn vibrometer(bytes: &[u8]) -> bool {
    let Some((&chunk_size, bytes)) = bytes.split_first() else {
        return false;
    };
    let decode = |chunk_size: usize| {
        let mut amplitudes_m = Vec::new();
        let port = Port {
            bytes: Cursor::new(bytes.to_vec()),
            chunk_size,
        };
        let unit = LineUnit::micrometres();
        let mut instrument = Instrument::with_port(Box::new(port), Path::new("vibrometer"), unit);
        let is_sound = (0..=bytes.len() / chunk_size)
            .all(|_| instrument.poll(|m| amplitudes_m.push(m)).is_ok());
        (amplitudes_m, is_sound)
    };
    let reference = decode(512);
    assert_eq!(decode(usize::from(chunk_size).max(1)), reference);
    let (amplitudes_m, is_sound) = reference;
    assert!(
        amplitudes_m
            .iter()
            .all(|amplitude_m| amplitude_m.is_finite())
    );
    is_sound && !amplitudes_m.is_empty()
}

/// Reads bytes as a table of known amplitudes.
pub fn known_amplitudes(bytes: &[u8]) -> bool {
    read_in_file(bytes, |path| read_table(path).is_ok())
}

/// Reads bytes as a session's log.
pub fn event_log(bytes: &[u8]) -> bool {
    read_in_file(bytes, |path| {
        event_log::read(path).is_ok_and(|log| !log.documents.is_empty())
    })
}

/// Reads bytes as a study's list of exclusions: the list survives writing and reading back.
pub fn exclusions(bytes: &[u8]) -> bool {
    FILE.with_borrow(|(folder, _)| {
        let study = folder.path().join("study");
        std::fs::create_dir_all(&study).expect("a folder");
        let path = study.join(EXCLUSIONS_FILE);
        std::fs::write(&path, bytes).expect("written");
        let Ok(document) = study::exclusions::read(&study) else {
            return false;
        };
        // The first write replaces control characters by spaces, so compare the second write with it.
        let tsv = study::exclusions::to_tsv(&document.list);
        std::fs::write(&path, &tsv).expect("written");
        let copy = study::exclusions::read(&study).expect("what was written is read");
        assert_eq!(study::exclusions::to_tsv(&copy.list), tsv);
        !document.list.is_empty()
    })
}

/// Reads bytes as the record of driving times, of a participant and of a bench.
pub fn driving_times(bytes: &[u8]) -> bool {
    read_in_file(bytes, |path| {
        let participant = AccountPaths {
            participant: Some(path.to_owned()),
            bench: path.with_file_name("no-bench"),
        };
        let bench = AccountPaths {
            participant: None,
            bench: path.to_owned(),
        };
        let open_account = |paths, owner| {
            let account = DoseAccount::open(Some(paths), owner, 3600.0, 1.0).ok()?;
            let remaining_s = account.remaining_s(&BOOT, Timestamp::UNIX_EPOCH);
            assert!((0.0..=3600.0).contains(&remaining_s), "{remaining_s}");
            Some(())
        };
        let participant_account = open_account(participant, AccountOwner::Named);
        let bench_account = open_account(bench, AccountOwner::Unnamed);
        participant_account.or(bench_account).is_some()
    })
}

/// Reads bytes as the record of a plate's warmth: the temperature rise is not negative at any time.
pub fn plate_warmth(bytes: &[u8]) -> bool {
    let heat = PlateHeat {
        force_factor_n_per_v: 0.13,
        omega_rad_per_s: 2.2e5,
        capacity_j_per_k: 14.0,
        loss_w_per_k: 0.1,
        room_c: 22.0,
        limit_c: 40.0,
    };
    read_in_file(bytes, |path| {
        let Ok(warmth) = PlateWarmth::open(Some(path.to_owned()), heat) else {
            return false;
        };
        for now in [Timestamp::MIN, Timestamp::UNIX_EPOCH, Timestamp::MAX] {
            let rise_k = warmth.rise_k(&BOOT, now);
            assert!(rise_k >= 0.0, "{rise_k}");
        }
        true
    })
}

/// Reads bytes as a scenario of the simulated apparatus.
pub fn scenario(bytes: &[u8]) -> bool {
    text(bytes).is_some_and(|text| Scenario::parse(text, "scenario.toml").is_ok())
}

/// Reads bytes as the record of an e-stop press: required at a usual date and at the earliest and latest timestamps.
pub fn estop_press(bytes: &[u8]) -> bool {
    read_in_file(bytes, |path| {
        let require_at = |now| EstopPress::require(path, "/dev/gpiochip0, line 17", now, 24.0);
        let now = "2026-01-01T12:00:00Z".parse().expect("a date");
        for extreme in [Timestamp::MIN, Timestamp::MAX] {
            assert!(require_at(extreme).is_err());
        }
        // The seeds do not name this computer.
        matches!(require_at(now), Ok(_) | Err(EstopPressError::OtherComputer))
    })
}

fn text(bytes: &[u8]) -> Option<&str> {
    std::str::from_utf8(bytes).ok()
}

thread_local! {
    /// A folder for each thread, with the path of a file in it.
    static FILE: RefCell<(tempfile::TempDir, PathBuf)> = RefCell::new({
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("file");
        (folder, path)
    });
}

fn read_in_file(bytes: &[u8], read: impl Fn(&Path) -> bool) -> bool {
    FILE.with_borrow(|(_, path)| {
        std::fs::write(path, bytes).expect("written");
        read(path)
    })
}

fn read_with_sound_files(
    file: &str,
    bytes: &[u8],
    rows: impl Fn(&RecordingReader) -> Option<usize>,
) -> bool {
    let folder = tempfile::tempdir().expect("a folder");
    let write =
        |name, content: &[u8]| std::fs::write(folder.path().join(name), content).expect("written");
    let format = AudioFormat {
        sample_rate_hz: 192_000,
        channels: 2,
    };
    write(MANIFEST_FILE, MANIFEST.as_bytes());
    write(SIGNALS_FILE, &header(format, 0));
    write(file, bytes);
    let reader = RecordingReader::open(folder.path()).expect("a sound description");
    rows(&reader).is_some_and(|rows| rows > 0)
}

/// Returns the number of `times_s`, which must increase.
fn count_increasing(times_s: impl Iterator<Item = f64>) -> usize {
    let (mut rows, mut last_s) = (0, f64::NEG_INFINITY);
    for time_s in times_s {
        assert!(time_s > last_s);
        (rows, last_s) = (rows + 1, time_s);
    }
    rows
}
