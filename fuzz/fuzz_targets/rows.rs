//! Any bytes as `force.csv` beside a sound description and audio: an error, or rows whose time increases.
#![no_main]

use friction_bench::recording::wav::{AudioFormat, header};
use friction_bench::recording::{FORCE_FILE, MANIFEST_FILE, RecordingReader, SIGNALS_FILE};
use libfuzzer_sys::fuzz_target;

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

fuzz_target!(|bytes: &[u8]| {
    let folder = tempfile::tempdir().expect("a folder");
    let write =
        |name, content: &[u8]| std::fs::write(folder.path().join(name), content).expect("written");
    let format = AudioFormat {
        sample_rate_hz: 192_000,
        channels: 2,
    };
    write(MANIFEST_FILE, MANIFEST.as_bytes());
    write(SIGNALS_FILE, &header(format, 0));
    write(FORCE_FILE, bytes);
    let reader = RecordingReader::open(folder.path()).expect("a sound description");
    let Ok(rows) = reader.force() else {
        return;
    };
    let mut last_s = f64::NEG_INFINITY;
    for row in rows.map_while(Result::ok) {
        assert!(row.time_s > last_s);
        last_s = row.time_s;
    }
});
