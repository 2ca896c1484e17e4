//! Files as another laboratory writes them.

use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

use recording::RecordingReader;

/// Map of the laboratory's files.
pub(crate) const SIGNALS_MAP: &str = r#"
format = 1
files = 'rec_(?<participant>\d+)\.wav'
[carrier]
hz = 35000
[modulation]
hz = 6.0
index = 0.95
[drive]
from = '[:,0]'
rate_hz = "file"
volts_per_unit = 1.0
[pickup]
from = '[:,1]'
quantity = "displacement"
metres_per_unit = 2e-6
phase_rad = 0
[normal]
file = 'force_{participant}.csv'
from = "normal_n"
time = "time_s"
newtons_per_unit = 1.0
tare = "none" # normal
[lateral]
file = 'force_{participant}.csv'
from = "lateral_n"
newtons_per_unit = 1.0
tare = "none" # lateral
[position]
file = 'position_{participant}.csv'
from = "position_m"
time = "time_s"
metres_per_unit = 1.0
[plate]
modal_mass_kg = 8e-3
resonance_hz = 35000
force_factor_n_per_v = 0.13
centre_m = 0.0525
[intervals]
unloaded = "normal < 0.05 N for 0.3 s"
exploration = "30 to 70 mm/s for 0.5 s"
[participants]
table = "people.csv"
"#;

/// Folder of a laboratory with the recording of one participant.
pub(crate) struct Laboratory {
    folder: tempfile::TempDir,
}

impl Laboratory {
    /// Creates the folder with the reference recording in files of its own.
    pub(crate) fn with_reference() -> Self {
        Self::with_forces(|time_s, normal_n, lateral_n| [time_s, normal_n, lateral_n])
    }

    /// Creates the folder with changed forces.
    pub(crate) fn with_forces(change: impl Fn(f64, f64, f64) -> [f64; 3]) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let laboratory = Self { folder };
        let (reference, to) = (laboratory.reference(), laboratory.folder());
        fs::copy(reference.join("signals.wav"), to.join("rec_7.wav")).unwrap();
        fs::copy(reference.join("position.csv"), to.join("position_7.csv")).unwrap();
        let reader = RecordingReader::open(&reference).unwrap();
        let mut table = "time_s;normal_n;lateral_n\n".to_owned();
        for row in reader.force().unwrap() {
            let row = row.unwrap();
            let cells = change(row.time_s, row.normal_n, row.lateral_n)
                .map(|cell| cell.to_string().replace('.', ","));
            writeln!(table, "{}", cells.join(";")).unwrap();
        }
        fs::write(to.join("force_7.csv"), table).unwrap();
        fs::write(
            to.join("people.csv"),
            "participant,age,diet\n07,31,vegetarian\n",
        )
        .unwrap();
        laboratory
    }

    pub(crate) fn folder(&self) -> &Path {
        self.folder.path()
    }

    pub(crate) fn reference(&self) -> PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data/reference/recording-a")
    }

    pub(crate) fn map(&self) -> PathBuf {
        self.folder().join("map.toml")
    }

    pub(crate) fn write_map(&self, text: &str) -> PathBuf {
        fs::write(self.map(), text).unwrap();
        self.map()
    }

    pub(crate) fn study(&self) -> PathBuf {
        self.folder().join("study")
    }

    pub(crate) fn recording(&self) -> PathBuf {
        self.study().join("sub-7/ses-01/trial-001_attempt-1")
    }
}

/// Returns a TDMS file of channels of the group `slow`, each with its values, and the interval and the start of its waveform, s.
pub(crate) fn tdms(channels: &[(&str, &[f64], [f64; 2])]) -> Vec<u8> {
    let text = |bytes: &mut Vec<u8>, text: &str| {
        bytes.extend((text.len() as u32).to_le_bytes());
        bytes.extend(text.bytes());
    };
    let (double, mut objects, mut raw) = (10_u32, Vec::new(), Vec::new());
    for (name, values, [interval_s, start_s]) in channels {
        text(&mut objects, &format!("/'slow'/'{name}'"));
        objects.extend([20, double, 1].iter().flat_map(|word| word.to_le_bytes()));
        objects.extend((values.len() as u64).to_le_bytes());
        objects.extend(2_u32.to_le_bytes());
        for (name, value) in [("wf_increment", interval_s), ("wf_start_offset", start_s)] {
            text(&mut objects, name);
            objects.extend(double.to_le_bytes());
            objects.extend(value.to_le_bytes());
        }
        raw.extend(values.iter().flat_map(|value| value.to_le_bytes()));
    }
    let metadata = objects.len() as u64 + 4;
    let mut bytes = b"TDSm".to_vec();
    bytes.extend([0xE_u32, 4713].iter().flat_map(|word| word.to_le_bytes()));
    bytes.extend((metadata + raw.len() as u64).to_le_bytes());
    bytes.extend(metadata.to_le_bytes());
    bytes.extend((channels.len() as u32).to_le_bytes());
    bytes.extend(objects);
    bytes.extend(raw);
    bytes
}

/// Splits a WAV file of two channels of 32 bits before these frames.
pub(crate) fn split_wav(bytes: &[u8], borders: &[usize]) -> Vec<Vec<u8>> {
    const FRAME_BYTES: usize = 8;
    let data = bytes.windows(4).position(|tag| tag == b"data").unwrap() + 8;
    let (header, samples) = bytes.split_at(data);
    let ends = borders.iter().map(|frame| frame * FRAME_BYTES);
    let mut start = 0;
    let parts = ends.chain([samples.len()]).map(|end| {
        let part = &samples[start..end];
        start = end;
        let mut file = header.to_vec();
        let (length, all) = (part.len() as u32, (data + part.len()) as u32 - 8);
        file[4..8].copy_from_slice(&all.to_le_bytes());
        file[data - 4..data].copy_from_slice(&length.to_le_bytes());
        file.extend_from_slice(part);
        file
    });
    parts.collect()
}
