//! A recording in memory has the findings of its folder, to the last bit.

#![expect(
    clippy::unwrap_used,
    reason = "a helper that fails fails its test, as in the tests themselves"
)]

use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

use analysis::findings::{RecordingError, RecordingFindings};
use analysis::recording_analysis::{analyse, analyse_source};
use analysis::{RecordingAnalysis, Settings};
use recording::reader::ReadError;
use recording::recorded_arrays::{Readings, RecordedArrays, Samples};
use recording::{ForceRow, Manifest, PositionRow, RecordingReader, RecordingSource};

/// Content of a folder, as columns.
struct Columns {
    manifest: Manifest,
    sample_rate_hz: u32,
    signals: [Vec<f32>; 2],
    force: Vec<ForceRow>,
    position: Vec<PositionRow>,
}

impl Columns {
    fn read(folder: &Path) -> Self {
        let mut reader = RecordingReader::open(folder).unwrap();
        let (mut block, mut signals) = (Vec::new(), [Vec::new(), Vec::new()]);
        while reader.read_block(10_007, &mut block).unwrap() > 0 {
            for (channel, samples) in signals.iter_mut().enumerate() {
                samples.extend(block.iter().skip(channel).step_by(2));
            }
        }
        Self {
            manifest: reader.manifest().clone(),
            sample_rate_hz: reader.format().sample_rate_hz,
            signals,
            force: reader.force().unwrap().map(Result::unwrap).collect(),
            position: reader.position().unwrap().map(Result::unwrap).collect(),
        }
    }

    /// Analyses the columns, with samples in double precision if `is_double`.
    fn analyse(&self, is_double: bool, stop: &AtomicBool) -> RecordingAnalysis {
        let doubles = self
            .signals
            .each_ref()
            .map(|samples| samples.iter().map(|x| f64::from(*x)).collect::<Vec<_>>());
        let [drive, pickup] = [0, 1].map(|channel| match is_double {
            true => Samples::Double(&doubles[channel]),
            false => Samples::Single(&self.signals[channel]),
        });
        let force = |value: fn(&ForceRow) -> f64| self.force.iter().map(value).collect::<Vec<_>>();
        let position =
            |value: fn(&PositionRow) -> f64| self.position.iter().map(value).collect::<Vec<_>>();
        let force_s = force(|row| row.time_s);
        let (normal, lateral) = (force(|row| row.normal_n), force(|row| row.lateral_n));
        let (position_s, position_m) = (position(|row| row.time_s), position(|row| row.position_m));
        let readings = |time_s, values| Some(Readings { time_s, values });
        let arrays =
            RecordedArrays::new(self.manifest.clone(), self.sample_rate_hz, [drive, pickup])
                .unwrap()
                .with_forces(readings(&force_s, &normal), readings(&force_s, &lateral))
                .with_position(readings(&position_s, &position_m));
        let source = RecordingSource::arrays(&arrays).with_stop(stop);
        analyse_source(&source, &Settings::default()).0
    }
}

fn reference() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data/reference/recording-a")
}

/// Returns all findings as text, which has every digit of every number.
fn text(analysis: RecordingAnalysis) -> String {
    let mut findings = analysis.findings.unwrap();
    findings.path = PathBuf::new();
    format!("{findings:?}")
}

#[test]
fn a_recording_in_memory_has_the_findings_of_its_folder() {
    let columns = Columns::read(&reference());
    let from_folder = text(analyse(&reference(), &Settings::default()));
    assert!(from_folder.len() > 50_000, "{}", from_folder.len());
    let running = AtomicBool::new(false);
    for is_double in [false, true] {
        let from_memory = text(columns.analyse(is_double, &running));
        assert!(from_memory == from_folder, "double: {is_double}");
    }
}

#[test]
fn a_stop_ends_the_analysis() {
    let columns = Columns::read(&reference());
    let findings: Result<RecordingFindings, _> =
        columns.analyse(false, &AtomicBool::new(true)).findings;
    assert!(matches!(
        findings,
        Err(RecordingError::Read(ReadError::Stopped))
    ));
}
