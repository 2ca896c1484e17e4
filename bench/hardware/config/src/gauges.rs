//! `[force.channels]`: a force sensor with its gauge voltages on inputs of the sound card.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::cal_file::MakersMatrix;
use crate::refusal::{Refused, require_range};
use crate::six_axis::SixAxis;
use crate::sound_card::{Audio, InputMap};

/// Largest number of gauges of a sensor.
const MOST_INPUTS: usize = 16;
/// Numbers of rows of a matrix for two axes, normal and lateral, and for six: Fx, Fy, Fz, Tx, Ty, Tz.
const ROWS: [usize; 2] = [2, 6];

/// `[force.channels]`: a force sensor with gauges on DC-coupled inputs of the sound card.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct Gauges {
    /// Input channels of the gauges, from 0, in the order of the matrix' columns.
    pub inputs: Vec<u16>,
    /// Newtons (and newton metres) per volt of each gauge: rows normal and lateral, or Fx, Fy, Fz, Tx, Ty, Tz.
    pub newtons_per_v: Vec<Vec<f64>>,
    /// Maker's calibration file, in place of the matrix; relative to the folder of `bench.toml` unless its path is absolute.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cal_file: Option<PathBuf>,
    /// Serial number of the sensor; if a maker's file is given, the one in that file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub serial: Option<String>,
    /// Axis of a six-axis matrix that is the normal force, positive when the finger presses.
    pub normal: SixAxis,
    /// Axis of a six-axis matrix that is the lateral force, positive towards increasing position.
    pub lateral: SixAxis,
    /// Gauge volts per sample value: one for all inputs, or one for each.
    pub volts_per_unit: Vec<f64>,
    /// Time between the sampling of one input and the next in `inputs`, s, if they share a converter.
    pub skew_s: f64,
    /// Rate to which the forces are decimated, Hz; the card's rate must be a whole multiple of it.
    pub rate_hz: f64,
    /// |sample| at and above which a gauge counts as saturated, as a share of full scale.
    pub clip_units: f64,
}

impl Default for Gauges {
    fn default() -> Self {
        Self {
            inputs: Vec::new(),
            newtons_per_v: Vec::new(),
            cal_file: None,
            serial: None,
            normal: SixAxis::PRESS,
            lateral: SixAxis::X,
            volts_per_unit: vec![1.0],
            skew_s: 0.0,
            rate_hz: 4000.0,
            clip_units: 0.999,
        }
    }
}

fn refusal(key: &str, why: String) -> Result<(), Refused> {
    let key = format!("force.channels.{key}");
    let why = format!("{key} {why}");
    Err(Refused::new(&key, why))
}

impl Gauges {
    /// Replaces the name of the maker's file by its contents.
    pub(crate) fn read_beside(&mut self, folder: Option<&Path>) -> Result<(), Refused> {
        let Some(path) = self.cal_file.take() else {
            return Ok(());
        };
        if !self.newtons_per_v.is_empty() {
            let why = format!(
                "= \"{}\" and newtons_per_v say the same thing twice: remove one",
                path.display()
            );
            return refusal("cal_file", why);
        }
        let Some(folder) = folder else {
            let why = format!(
                "= \"{}\" is found only next to a bench.toml file",
                path.display()
            );
            return refusal("cal_file", why);
        };
        match MakersMatrix::read(&folder.join(&path)) {
            Ok(makers) => {
                self.newtons_per_v = makers.rows;
                self.serial = self.serial.take().or(makers.serial);
                Ok(())
            }
            Err(error) => {
                let why = format!(
                    "= \"{}\" cannot be used: {}",
                    path.display(),
                    crate::cal_file::in_words(&error)
                );
                refusal("cal_file", why)
            }
        }
    }

    pub(crate) fn check(&self, audio: &Audio, map: &InputMap) -> Result<(), Refused> {
        let count = self.inputs.len();
        if !(2..=MOST_INPUTS).contains(&count) {
            let why = format!(
                "names {count} inputs: name those of the gauges, 2 to {MOST_INPUTS}, such as inputs = [2, 3]"
            );
            return refusal("inputs", why);
        }
        for (i, &input) in self.inputs.iter().enumerate() {
            if input >= audio.input_channels {
                let why = format!(
                    "names input {input}, and audio.input_channels = {}, numbered from 0",
                    audio.input_channels
                );
                return refusal("inputs", why);
            }
            if input == map.drive.index || input == map.pickup.index {
                return refusal(
                    "inputs",
                    format!("names input {input}, which [channels] reads as drive or pickup"),
                );
            }
            if self.inputs[..i].contains(&input) {
                return refusal("inputs", format!("names input {input} twice"));
            }
        }
        if self.volts_per_unit.len() != 1 && self.volts_per_unit.len() != count {
            let why = format!(
                "has {} numbers for {count} inputs: give one for all, or one for each",
                self.volts_per_unit.len()
            );
            return refusal("volts_per_unit", why);
        }
        for &volts in &self.volts_per_unit {
            require_range("force.channels.volts_per_unit", volts, 1e-6, 1e3, "V")?;
        }
        self.check_matrix()?;
        require_range("force.channels.skew_s", self.skew_s, 0.0, 1e-4, "s")?;
        require_range(
            "force.channels.clip_units",
            self.clip_units,
            1e-3,
            1.0,
            "of full scale",
        )?;
        require_range("force.channels.rate_hz", self.rate_hz, 1000.0, 20e3, "Hz")?;
        let frames = f64::from(audio.rate_hz) / self.rate_hz;
        if (frames - frames.round()).abs() > 1e-9 * frames {
            let why = format!(
                "= {} does not divide audio.rate_hz = {}: {} / {} = {frames:.3}; take {:.3} or {:.3}",
                self.rate_hz,
                audio.rate_hz,
                audio.rate_hz,
                self.rate_hz,
                f64::from(audio.rate_hz) / frames.ceil(),
                f64::from(audio.rate_hz) / frames.floor()
            );
            return refusal("rate_hz", why);
        }
        Ok(())
    }

    fn check_matrix(&self) -> Result<(), Refused> {
        let (rows, count) = (self.newtons_per_v.len(), self.inputs.len());
        if rows == 0 {
            let why = "is missing: type the sensor's matrix, or name the maker's file in cal_file"
                .to_owned();
            return refusal("newtons_per_v", why);
        }
        if !ROWS.contains(&rows) {
            let why = format!(
                "has {rows} rows: two (normal, lateral) or six (Fx, Fy, Fz, Tx, Ty, Tz) are needed"
            );
            return refusal("newtons_per_v", why);
        }
        for (row, values) in self.newtons_per_v.iter().enumerate() {
            if values.len() != count {
                let why = format!(
                    "has {} columns in row {}, and there are {count} inputs",
                    values.len(),
                    row + 1
                );
                return refusal("newtons_per_v", why);
            }
            if let Some(outlier) = values.iter().find(|value| !(-1e6..=1e6).contains(*value)) {
                return refusal(
                    "newtons_per_v",
                    format!("holds {outlier} in row {}", row + 1),
                );
            }
        }
        if rows == 6 && self.normal.is_along(self.lateral) {
            let why = format!(
                "= \"{}\" and normal = \"{}\" lie along one axis: name two across each other",
                self.lateral, self.normal
            );
            return refusal("lateral", why);
        }
        let [normal, lateral] = self.newtons_per_unit();
        let square = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let (nn, ll, nl) = (
            square(&normal, &normal),
            square(&lateral, &lateral),
            square(&normal, &lateral),
        );
        // Two parallel rows read the same force.
        let determinant = nn * ll - nl * nl;
        if determinant.is_nan() || determinant <= 1e-6 * nn * ll {
            let why =
                "reads the same of normal and lateral force: two rows are alike, or one is zero"
                    .to_owned();
            return refusal("newtons_per_v", why);
        }
        Ok(())
    }

    /// Returns newtons per sample value of each input, for the normal and for the lateral force.
    #[must_use]
    pub fn newtons_per_unit(&self) -> [Vec<f64>; 2] {
        let volts = |input: usize| match self.volts_per_unit.as_slice() {
            [all] => *all,
            each => each.get(input).copied().unwrap_or(f64::NAN),
        };
        let scaled = |row: usize, sign: f64| -> Vec<f64> {
            let values = self.newtons_per_v.get(row).into_iter().flatten();
            values
                .enumerate()
                .map(|(input, newtons)| sign * newtons * volts(input))
                .collect()
        };
        if self.newtons_per_v.len() == ROWS[0] {
            [scaled(0, 1.0), scaled(1, 1.0)]
        } else {
            [self.normal, self.lateral].map(|axis| scaled(axis.index(), axis.sign()))
        }
    }

    pub(crate) fn identity(&self) -> String {
        let mut hash = Sha256::new();
        for value in self.newtons_per_unit().iter().flatten() {
            hash.update(value.to_le_bytes());
        }
        let digest = hash.finalize();
        let sensor = self.serial.as_deref().unwrap_or("a sensor");
        format!(
            "{sensor} on inputs {:?}, matrix {:02x}{:02x}{:02x}{:02x}",
            self.inputs, digest[0], digest[1], digest[2], digest[3]
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Config, ConfigError, Sensor};

    /// Returns the simulated bench's description with gauges on its inputs.
    fn with_gauges(lines: &str) -> String {
        let text = crate::rigs::MOCK_BENCH.replace("channels = 4 ", "channels = 8 ");
        let (head, rest) = text.split_once("[force]\n").unwrap();
        let (_, tail) = rest.split_once("\n\n").unwrap();
        format!("{head}[force]\nsource = \"channels\"\n[force.channels]\n{lines}\n\n{tail}")
    }

    fn parsed(lines: &str) -> Result<Gauges, ConfigError> {
        let config = Config::parse(&with_gauges(lines), "bench.toml")?;
        match config.force.unwrap().sensor {
            Sensor::Channels(gauges) => Ok(gauges),
            other => panic!("{other:?}"),
        }
    }

    const TWO: &str = "inputs = [2, 3]\nnewtons_per_v = [[2.0, 0.1], [0.0, -3.0]]\n";

    #[test]
    fn newtons_per_sample_value_are_those_of_the_rows_or_of_the_axes() {
        let two_gauges = parsed(&format!("{TWO}volts_per_unit = [10.0, 5.0]")).unwrap();
        assert_eq!(
            two_gauges.newtons_per_unit(),
            [vec![20.0, 0.5], vec![0.0, -15.0]]
        );
        let text = "inputs = [2, 3]\nnewtons_per_v = [[1.0, 0.0], [5.0, 5.0], [0.0, 4.0], [0.0, 0.0], [0.0, 0.0], [0.0, 0.0]]";
        let six_gauges = parsed(&format!("{text}\nvolts_per_unit = [2.0]")).unwrap();
        assert_eq!(
            six_gauges.newtons_per_unit(),
            [vec![-0.0, -8.0], vec![2.0, 0.0]]
        );
        assert!(
            six_gauges
                .identity()
                .starts_with("a sensor on inputs [2, 3], matrix ")
        );
        assert_ne!(six_gauges.identity(), two_gauges.identity());
    }

    #[test]
    fn an_impossible_sensor_is_refused_with_its_line() {
        let bench_with = |line: &str| format!("{TWO}{line}");
        for (lines, word) in [
            (String::new(), "names 0 inputs"),
            ("inputs = [2]".to_owned(), "names 1 inputs"),
            (TWO.replace("[2, 3]", "[2, 8]"), "audio.input_channels = 8"),
            (TWO.replace("[2, 3]", "[2, 1]"), "drive or pickup"),
            (TWO.replace("[2, 3]", "[2, 2]"), "twice"),
            ("inputs = [2, 3]".to_owned(), "newtons_per_v is missing"),
            (TWO.replace("[2.0, 0.1]", "[2.0]"), "1 columns in row 1"),
            (TWO.replace("[2.0, 0.1], ", ""), "has 1 rows"),
            (TWO.replace("0.1", "nan"), "NaN in row 1"),
            (
                TWO.replace("[0.0, -3.0]", "[-4.0, -0.2]"),
                "two rows are alike",
            ),
            (TWO.replace("[0.0, -3.0]", "[0.0, 0.0]"), "one is zero"),
            (bench_with("volts_per_unit = []"), "0 numbers for 2 inputs"),
            (
                bench_with("volts_per_unit = [1.0, 0.0]"),
                "volts_per_unit = 0",
            ),
            (bench_with("skew_s = 1.0"), "skew_s = 1"),
            (bench_with("clip_units = 0.0"), "clip_units = 0"),
            (bench_with("rate_hz = 100.0"), "rate_hz = 100"),
            (bench_with("rate_hz = 5000.0"), "192000 / 5000 = 38.400"),
            (bench_with("rat_hz = 4000.0"), "rate_hz"),
            (
                bench_with("cal_file = \"FT1.cal\""),
                "say the same thing twice",
            ),
            (
                "inputs = [2, 3]\ncal_file = \"FT1.cal\"".to_owned(),
                "only next to a bench.toml file",
            ),
        ] {
            let message = parsed(&lines).unwrap_err().to_string();
            assert!(
                message.contains(word) && message.contains("force.channels")
                    || message.contains("rat_hz"),
                "{message}"
            );
            let has_line = !message.contains("is missing") && !lines.is_empty();
            assert_eq!(message.contains(", line "), has_line, "{message}");
        }
    }

    #[test]
    fn the_makers_file_is_read_from_the_folder_of_the_configuration() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("bench.toml");
        let inputs = "inputs = [2, 3]\ncal_file = \"FT00007.cal\"";
        std::fs::write(&path, with_gauges(inputs)).unwrap();
        let absent = Config::read(&path).unwrap_err().to_string();
        assert!(
            absent.contains("FT00007.cal") && absent.contains("line "),
            "{absent}"
        );
        let rows: String = ["Fx", "Fy", "Fz", "Tx", "Ty", "Tz"]
            .iter()
            .enumerate()
            .map(|(i, axis)| format!("<UserAxis Name=\"{axis}\" values=\"{i} 1.5\"/>"))
            .collect();
        let file = format!(
            "<FTSensor Serial=\"FT00007\"><Calibration ForceUnits=\"N\">{rows}</Calibration></FTSensor>"
        );
        std::fs::write(folder.path().join("FT00007.cal"), file).unwrap();
        let config = Config::read(&path).unwrap();
        let identity = config.force.as_ref().unwrap().identity(None);
        assert!(
            identity.starts_with("FT00007 on inputs [2, 3]"),
            "{identity}"
        );
        // The printed configuration no longer needs the file.
        let copy = Config::parse(&config.to_toml().unwrap(), "copy").unwrap();
        assert_eq!(copy, config);
    }
}
