//! A study of four recordings that can be read, and one that cannot.

use std::fs;
use std::path::{Path, PathBuf};

use envelope_files::{EnvelopeRow, EnvelopeWriter};
use num_complex::Complex64;
use recording::manifest::MINIMAL;
use recording::writer::Ending;
use recording::{AudioFormat, Manifest, RecordingWriter};
use tempfile::TempDir;

/// Study in a temporary folder.
pub struct SmallStudy {
    temporary: TempDir,
}

/// Tables that place the first recording in the study, with an event.
const PLACE: &str = r#"
[participant]
id = "sub-01"
session = 1

[trial]
number = 1
attempt = 1
practice = false
condition = "dry"
protocol = "demo"
protocol_file = "demo.toml"
seed = 7
end = "completed"

[[events]]
kind = "note"
sample = 9600
text = "a remark"
"#;

impl SmallStudy {
    /// Makes the study: a simulated recording (bench/tests/data/reference), silence without forces and positions, forces alone under a
    /// stimulus, envelopes alone, and a folder with a broken description.
    pub fn new() -> Self {
        let temporary = tempfile::tempdir().unwrap();
        let study = Self { temporary };
        let reference =
            Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data/reference/recording-d");
        copy(&reference, &study.recording());
        let manifest = study.recording().join("recording.toml");
        let text = fs::read_to_string(&manifest).unwrap();
        fs::write(&manifest, text + PLACE).unwrap();
        fs::write(
            study.study().join("sub-01/ses-01/demo.toml"),
            protocols::built_in("demo").unwrap(),
        )
        .unwrap();
        let silence = study.study().join("sub-02/ses-01/trial-002_attempt-1");
        write_silence(&silence);
        let manifest = silence.join("recording.toml");
        let text = fs::read_to_string(&manifest).unwrap();
        let place = PLACE
            .replace("sub-01", "sub-02")
            .replace("number = 1", "number = 2")
            .replace("protocol_file = \"demo.toml\"\n", "");
        fs::write(&manifest, text + &place).unwrap();
        for file in ["force.csv", "position.csv"] {
            fs::remove_file(silence.join(file)).unwrap();
        }
        write_forces_alone(&study.study().join("sub-04/ses-01/trial-001_attempt-1"));
        write_envelopes(&study.study().join("sub-05/ses-02/trial-003_attempt-2"));
        let broken = study.study().join("sub-03/ses-01/trial-001_attempt-1");
        fs::create_dir_all(&broken).unwrap();
        fs::write(broken.join("recording.toml"), "format = ").unwrap();
        let description = r#"{ "Name": "Wet and dry", "DatasetType": "raw", "GeneratedBy": [{ "Name": "friction-bench", "Version": "0.1.0" }] }"#;
        fs::write(study.study().join("dataset_description.json"), description).unwrap();
        let participants = "participant_id\tfirst_session_date\tage\tsex\tskin\n\
            sub-01\t2026-01-30\t18-38\tF\tdry\nsub-02\t2026-01-31\t40\tmale\t\nsub-09\tn/a\t50\tn/a\t\n";
        fs::write(study.study().join("participants.tsv"), participants).unwrap();
        study
    }

    /// Returns a folder next to the study.
    pub fn folder(&self, name: &str) -> PathBuf {
        self.temporary.path().join(name)
    }

    /// Returns the folder of the study.
    pub fn study(&self) -> PathBuf {
        self.folder("study")
    }

    /// Returns the simulated recording.
    pub fn recording(&self) -> PathBuf {
        self.study().join("sub-01/ses-01/trial-001_attempt-1")
    }

    /// Makes a recording outside the study.
    pub fn lone_recording(&self) -> PathBuf {
        let folder = self.folder("alone");
        write_silence(&folder);
        folder
    }
}

fn copy(source: &Path, folder: &Path) {
    fs::create_dir_all(folder).unwrap();
    for entry in fs::read_dir(source).unwrap() {
        let entry = entry.unwrap();
        fs::copy(entry.path(), folder.join(entry.file_name())).unwrap();
    }
}

/// Writes a tenth of a second of three silent channels.
fn write_silence(folder: &Path) {
    let manifest = Manifest::parse(MINIMAL, "recording.toml").unwrap();
    let format = AudioFormat {
        sample_rate_hz: 96_000,
        channels: 3,
    };
    fs::create_dir_all(folder.parent().unwrap()).unwrap();
    let mut writer = RecordingWriter::create(folder, manifest, format).unwrap();
    writer.write_audio(&vec![0.25; 3 * 9600]).unwrap();
    writer.finish(Ending::Completed).unwrap();
}

/// Writes two seconds of forces, positions and a stimulus, with one exploration; the friction coefficient is 0.4, and 0.3 under the
/// stimulus.
fn write_forces_alone(folder: &Path) {
    fs::create_dir_all(folder).unwrap();
    let slide = "format = 1\n[[intervals]]\nkind = \"exploration\"\ndirection = \"right_to_left\"\nstart_s = 0.2\nend_s = 1.8\n";
    fs::write(folder.join("recording.toml"), slide).unwrap();
    let mut force = String::from("time_s,normal_n,lateral_n\n");
    let mut position = String::from("time_s,position_m\n");
    let mut stimulus = String::from("time_s,stimulus\n");
    for row in 0..2000 {
        let time_s = f64::from(row) * 1e-3;
        let is_on = row / 100 % 2 == 1;
        let normal_n = 0.5 + 0.1 * (20.0 * time_s).sin();
        let lateral_n = if is_on { 0.3 } else { 0.4 } * normal_n;
        force += &format!("{time_s},{normal_n},{lateral_n}\n");
        position += &format!("{time_s},{}\n", 0.1 - 0.04 * time_s);
        stimulus += &format!("{time_s},{}\n", u8::from(is_on));
    }
    fs::write(folder.join("force.csv"), force).unwrap();
    fs::write(folder.join("position.csv"), position).unwrap();
    fs::write(folder.join("stimulus.csv"), stimulus).unwrap();
}

/// Writes a fifth of a second of envelopes.
fn write_envelopes(folder: &Path) {
    fs::create_dir_all(folder).unwrap();
    let without_channels = MINIMAL.lines().filter(|line| !line.starts_with("channels"));
    let manifest: Vec<&str> = without_channels.collect();
    fs::write(folder.join("recording.toml"), manifest.join("\n")).unwrap();
    let rows: Vec<EnvelopeRow> = (0..2000)
        .map(|row| EnvelopeRow {
            time_s: f64::from(row) * 1e-4,
            drive_v: Complex64::new(10.0, f64::from(row)),
            pickup_m: Complex64::new(0.0, 1e-6),
        })
        .collect();
    let mut writer = EnvelopeWriter::create(&folder.join("envelopes.parquet")).unwrap();
    writer.write(&rows).unwrap();
    writer.finish().unwrap();
}
