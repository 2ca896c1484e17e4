//! A recording as columns in memory, in which mistakes are planted.

use std::fmt::Write;
use std::path::Path;

use analysis::recording_analysis::{analyse_source, analyse_with_series};
use analysis::{RecordingAnalysis, Settings};
use mock_world::scenario::built_in;
use mock_world::trial::{Trial, TrialPlan, TrialRecording};
use recording::manifest::{
    Direction, MINIMAL, RecordedInterval, RecordedIntervalKind, RecordedSignals, Streams,
};
use recording::recorded_arrays::{Readings, RecordedArrays, Samples};
use recording::{ForceRow, Manifest, PositionRow, RecordingReader, RecordingSource};

/// Sampling rate of simulated trials, Hz.
const RATE_HZ: u32 = 96_000;
/// Interval of the stimulus of forces alone, s.
const STIMULUS_S: f64 = 2e-3;

/// Content of a recording.
#[derive(Debug, Clone)]
pub struct Columns {
    pub manifest: Manifest,
    pub rate_hz: u32,
    pub drive: Vec<f32>,
    pub pickup: Vec<f32>,
    pub forces: Vec<ForceRow>,
    pub positions: Vec<PositionRow>,
}

impl Columns {
    /// Returns the recording of a trial of a simulated person.
    pub fn simulated(scenario: &str, seed: u64, strokes: u32) -> Self {
        let plan = TrialPlan {
            rate_hz: RATE_HZ,
            strokes,
            ..TrialPlan::default()
        };
        let scenario = built_in(scenario).unwrap();
        let mut trial = Trial::new(&scenario, &plan, seed, seed).unwrap();
        while trial.advance() {}
        Self::of_trial(trial.finish())
    }

    fn of_trial(trial: TrialRecording) -> Self {
        let mut manifest = Manifest::parse(MINIMAL, "recording.toml").unwrap();
        let (stated, carrier_hz) = (&trial.stated, trial.carrier_hz);
        let signals = signals(&mut manifest);
        signals.carrier = recording::manifest::Carrier::Steady(carrier_hz);
        signals.channels.drive.volts_per_unit = stated.drive_volts_per_unit;
        signals.channels.pickup.metres_per_unit = stated.metres_per_unit;
        signals.channels.pickup.phase_rad = stated.phase_rad(carrier_hz);
        signals.plate.resonance_hz = stated.resonance_hz;
        signals.plate.modal_mass_kg = stated.modal_mass_kg;
        signals.plate.force_factor_n_per_v = stated.force_factor_n_per_v;
        signals.plate.centre_m = stated.centre_m;
        let unloaded = trial
            .unloaded_s
            .iter()
            .map(|&(start_s, end_s)| RecordedInterval {
                kind: RecordedIntervalKind::Unloaded,
                start_s,
                end_s,
            });
        let strokes = trial.strokes.iter().map(|stroke| {
            let direction = if stroke.rightwards {
                Direction::LeftToRight
            } else {
                Direction::RightToLeft
            };
            RecordedInterval {
                kind: RecordedIntervalKind::Exploration(direction),
                start_s: stroke.start_s,
                end_s: stroke.end_s,
            }
        });
        manifest.intervals = unloaded.chain(strokes).collect();
        let normal = trial.normal_n.time_s.iter().zip(&trial.normal_n.values);
        let forces = normal.zip(&trial.lateral_n.values);
        let position = trial.position.time_s.iter().zip(&trial.position.values);
        Self {
            manifest,
            rate_hz: trial.plan.rate_hz,
            drive: trial.drive,
            pickup: trial.pickup,
            forces: forces
                .map(|((time_s, normal_n), lateral_n)| ForceRow {
                    time_s: *time_s,
                    normal_n: *normal_n,
                    lateral_n: *lateral_n,
                })
                .collect(),
            positions: position
                .map(|(time_s, position_m)| PositionRow {
                    time_s: *time_s,
                    position_m: *position_m,
                })
                .collect(),
        }
    }

    /// Reads a folder with drive and pickup as its channels 0 and 1.
    pub fn read(folder: &Path) -> Self {
        let mut reader = RecordingReader::open(folder).unwrap();
        let (mut block, mut samples) = (Vec::new(), [Vec::new(), Vec::new()]);
        while reader.read_block(1 << 16, &mut block).unwrap() > 0 {
            for (channel, samples) in samples.iter_mut().enumerate() {
                samples.extend(block.iter().skip(channel).step_by(2));
            }
        }
        let [drive, pickup] = samples;
        Self {
            manifest: reader.manifest().clone(),
            rate_hz: reader.format().sample_rate_hz,
            drive,
            pickup,
            forces: reader.force().unwrap().map(Result::unwrap).collect(),
            positions: reader.position().unwrap().map(Result::unwrap).collect(),
        }
    }

    pub fn signals(&mut self) -> &mut RecordedSignals {
        signals(&mut self.manifest)
    }

    /// Returns start and end of the first exploration, s.
    pub fn exploration_s(&self) -> (f64, f64) {
        let is_exploration = |interval: &&RecordedInterval| {
            matches!(interval.kind, RecordedIntervalKind::Exploration(_))
        };
        let first = self.manifest.intervals.iter().find(is_exploration).unwrap();
        (first.start_s, first.end_s)
    }

    /// Returns the analysis of the forces, the positions and the drive's voltage as a stimulus, without drive and pickup.
    pub fn analyse_forces_alone(&self) -> RecordingAnalysis {
        let folder = tempfile::tempdir().unwrap();
        let mut text = "format = 1\n".to_owned();
        for interval in &self.manifest.intervals {
            let kind = match interval.kind {
                RecordedIntervalKind::Unloaded => "kind = \"unloaded\"",
                RecordedIntervalKind::Exploration(Direction::LeftToRight) => {
                    "kind = \"exploration\"\ndirection = \"left_to_right\""
                }
                RecordedIntervalKind::Exploration(Direction::RightToLeft) => {
                    "kind = \"exploration\"\ndirection = \"right_to_left\""
                }
            };
            let (start_s, end_s) = (interval.start_s, interval.end_s);
            writeln!(
                text,
                "[[intervals]]\n{kind}\nstart_s = {start_s}\nend_s = {end_s}"
            )
            .unwrap();
        }
        let mut force = "time_s,normal_n,lateral_n\n".to_owned();
        for row in &self.forces {
            writeln!(force, "{},{},{}", row.time_s, row.normal_n, row.lateral_n).unwrap();
        }
        let mut position = "time_s,position_m\n".to_owned();
        for row in &self.positions {
            writeln!(position, "{},{}", row.time_s, row.position_m).unwrap();
        }
        let frames = (STIMULUS_S * f64::from(self.rate_hz)) as usize;
        let mut stimulus = "time_s,stimulus\n".to_owned();
        for (index, block) in self.drive.chunks(frames).enumerate() {
            let peak = block
                .iter()
                .fold(0.0_f32, |peak, sample| peak.max(sample.abs()));
            writeln!(stimulus, "{},{peak}", (index as f64 + 0.5) * STIMULUS_S).unwrap();
        }
        let files = [
            ("recording.toml", text),
            ("force.csv", force),
            ("position.csv", position),
            ("stimulus.csv", stimulus),
        ];
        for (name, content) in files {
            std::fs::write(folder.path().join(name), content).unwrap();
        }
        analyse_with_series(folder.path(), &Settings::default()).0
    }

    /// Returns the analysis, or the rule of the description that refuses the columns.
    pub fn analyse(&self) -> Result<RecordingAnalysis, String> {
        let force = |value: fn(&ForceRow) -> f64| self.forces.iter().map(value).collect::<Vec<_>>();
        let position =
            |value: fn(&PositionRow) -> f64| self.positions.iter().map(value).collect::<Vec<_>>();
        let force_s = force(|row| row.time_s);
        let (normal_n, lateral_n) = (force(|row| row.normal_n), force(|row| row.lateral_n));
        let (position_s, position_m) = (position(|row| row.time_s), position(|row| row.position_m));
        let channels = [Samples::Single(&self.drive), Samples::Single(&self.pickup)];
        let arrays = RecordedArrays::new(self.manifest.clone(), self.rate_hz, channels)
            .map_err(|error| error.to_string())?;
        let readings = |time_s, values| Some(Readings { time_s, values });
        let arrays = arrays
            .with_forces(
                readings(&force_s, &normal_n),
                readings(&force_s, &lateral_n),
            )
            .with_position(readings(&position_s, &position_m));
        let source = RecordingSource::arrays(&arrays);
        Ok(analyse_source(&source, &Settings::default()).0)
    }
}

fn signals(manifest: &mut Manifest) -> &mut RecordedSignals {
    match &mut manifest.streams {
        Streams::Signals(signals) => signals,
        Streams::Envelopes(_) | Streams::Forces(_) => panic!("a recording without signals"),
    }
}
