//! Ground truth written by the simulated apparatus; the bench never reads it.

use std::collections::BTreeMap;
use std::path::Path;

use config::CalibrationFile;
use mock_world::scenario::Scenario;
use num_complex::Complex64;

/// The skin and its contact as simulated, averaged over the time that the finger slides.
pub struct Skin {
    /// Asperity scale, m.
    pub sigma_t_m: f64,
    /// Tissue impedance, N·s/m.
    pub z_t: Complex64,
    /// Apparent contact area, m².
    pub contact_area_m2: f64,
    /// Time constant of levitation, s.
    pub lag_s: f64,
    /// Shift of the plate's resonance since the session began, Hz.
    pub resonance_shift_hz: f64,
    /// Constants of the contact, as the person's seed drew them: `contact_area_m2` at 1 N, `q0_rad_per_m`, `floor`…
    pub pad: BTreeMap<String, f64>,
}

impl Skin {
    /// Reads the apparatus's files in `folder`.
    pub fn read(folder: &Path) -> Self {
        let series = std::fs::read_to_string(folder.join("truth.csv")).expect("the truth");
        let mut lines = series
            .lines()
            .map(|line| line.split(',').collect::<Vec<_>>());
        let header = lines.next().expect("a header");
        let column_index = |name: &str| {
            let column_index = header.iter().position(|column| *column == name);
            column_index.unwrap_or_else(|| panic!("no column {name}"))
        };
        let (gap, velocity) = (column_index("gap_m"), column_index("velocity_m_per_s"));
        let columns = [
            "sigma_t_m",
            "re_z_t_n_s_per_m",
            "im_z_t_n_s_per_m",
            "contact_area_m2",
            "lag_s",
            "resonance_shift_hz",
        ]
        .map(column_index);
        let (mut n, mut sums) = (0.0, [0.0; 6]);
        for line in lines {
            let value = |column: usize| line[column].parse::<f64>().expect("a number");
            // gap_m is NaN off the plate; velocity tells sliding from waiting.
            if value(gap).is_finite() && value(velocity).abs() > 0.02 {
                n += 1.0;
                for (sum, column) in sums.iter_mut().zip(columns) {
                    *sum += value(column);
                }
            }
        }
        assert!(n > 500.0, "{n} samples of sliding in {}", folder.display());
        let [
            sigma_t_m,
            re,
            im,
            contact_area_m2,
            lag_s,
            resonance_shift_hz,
        ] = sums.map(|sum| sum / n);
        Self {
            sigma_t_m,
            z_t: Complex64::new(re, im),
            contact_area_m2,
            lag_s,
            resonance_shift_hz,
            pad: pad(folder),
        }
    }
}

/// Course of the true values, one row per millisecond.
pub struct Course {
    columns: BTreeMap<String, Vec<f64>>,
}

impl Course {
    /// Reads the apparatus's files in `folder`.
    pub fn read(folder: &Path) -> Self {
        let series = std::fs::read_to_string(folder.join("truth.csv")).expect("the truth");
        let mut lines = series.lines();
        let names: Vec<&str> = lines.next().expect("a header").split(',').collect();
        let mut columns = vec![Vec::new(); names.len()];
        for line in lines {
            for (column, value) in columns.iter_mut().zip(line.split(',')) {
                column.push(value.parse().expect("a number"));
            }
        }
        let names = names.into_iter().map(str::to_owned);
        Self {
            columns: names.zip(columns).collect(),
        }
    }

    fn row(&self, time_s: f64) -> usize {
        self.columns["time_s"].partition_point(|row_s| *row_s < time_s)
    }

    /// Returns a column's mean between two times.
    pub fn mean(&self, column: &str, from_s: f64, to_s: f64) -> f64 {
        let rows = &self.columns[column][self.row(from_s)..self.row(to_s)];
        rows.iter().sum::<f64>() / rows.len() as f64
    }

    /// Returns the first and the last time of the rows around a time in which a column's values are admitted, s.
    pub fn stretch(&self, column: &str, around_s: f64, admits: impl Fn(f64) -> bool) -> (f64, f64) {
        let (times_s, values) = (&self.columns["time_s"], &self.columns[column]);
        let middle = self.row(around_s);
        let is_outside = |row: &usize| !admits(values[*row]);
        let before = (0..middle).rev().find(is_outside);
        let after = (middle..values.len()).find(is_outside);
        let (first, end) = (
            before.map_or(0, |row| row + 1),
            after.unwrap_or(values.len()),
        );
        assert!(first < end, "{column} is not admitted at {around_s} s");
        (times_s[first], times_s[end - 1])
    }

    /// Returns the times between which the plate is free after `from_s`, ending a tenth of a second before the next finger.
    pub fn free_s(&self, from_s: f64) -> (f64, f64) {
        let (times_s, gaps_m) = (&self.columns["time_s"], &self.columns["gap_m"]);
        let mut rows = (self.row(from_s)..times_s.len()).skip_while(|row| gaps_m[*row].is_finite());
        let begin = rows.next().expect("the plate becomes free");
        let end = rows.find(|row| gaps_m[*row].is_finite());
        (
            times_s[begin],
            times_s[end.unwrap_or(times_s.len() - 1)] - 0.1,
        )
    }

    /// Returns a column's value at a time, interpolated linearly between rows.
    pub fn value(&self, column: &str, time_s: f64) -> f64 {
        let (times_s, values) = (&self.columns["time_s"], &self.columns[column]);
        let row = self.row(time_s).clamp(1, times_s.len() - 1);
        let fraction = (time_s - times_s[row - 1]) / (times_s[row] - times_s[row - 1]);
        values[row - 1] + fraction * (values[row] - values[row - 1])
    }
}

/// Returns the start of a recording, s of audio since the apparatus was switched on, from the session's log.
pub fn recording_began_s(recording: &Path) -> f64 {
    let events = recording.with_file_name("events.jsonl");
    let events = std::fs::read_to_string(events).expect("a log");
    let name = recording.file_name().expect("a name").to_string_lossy();
    let time_s = events.lines().find_map(|line| {
        let event: serde_json::Value = serde_json::from_str(line).expect("JSON");
        let data = &event["data"];
        let key = &data["key"];
        let label = format!(
            "trial-{:03}_attempt-{}",
            key["number"].as_u64()?,
            key["attempt"]
        );
        (data["event"] == "trial_began" && label == name).then(|| event["audio_s"].as_f64())?
    });
    time_s.expect("the trial in the log")
}

fn pad(folder: &Path) -> BTreeMap<String, f64> {
    let text = std::fs::read(folder.join("truth.json")).expect("the constants");
    let constants: serde_json::Value = serde_json::from_slice(&text).expect("JSON");
    serde_json::from_value(constants["fingertip"]["pad"].clone()).expect("numbers by name")
}

/// Rate of the simulated sound card, Hz.
const RATE_HZ: f64 = 192_000.0;

/// Constants that calibrations must find.
pub struct Bench {
    /// Plate displacement per sample value of the pickup.
    pub metres_per_unit: f64,
    /// Resonance f0 of the plate, Hz.
    pub resonance_hz: f64,
    /// Its quality factor Q.
    pub quality: f64,
    /// Force factor γ.
    pub force_factor_n_per_v: f64,
    /// Phase to add to the pickup's samples: the pickup's phase, minus the lag of its channel's sampling behind the drive's.
    pub pickup_phase_rad: f64,
    /// Correction matrix of the force sensor: true normal and lateral force per normal and lateral reading, N/N.
    pub force: [[f64; 2]; 2],
    /// Initial reading without load, N.
    pub tare_n: [f64; 2],
}

impl Bench {
    /// Returns the bench of `scenario` as `seed` realises it.
    pub fn realise(scenario: &str, seed: u64) -> Self {
        let bench = Scenario::parse(scenario, "scenario")
            .expect("a scenario")
            .draw(seed);
        let omega = bench.plate.omega_rad_per_s();
        let [[a, b], [c, d]] = bench.force_sensor.response();
        let det = a * d - b * c;
        Self {
            metres_per_unit: bench.pickup.metres_per_unit,
            resonance_hz: bench.plate.resonance_hz,
            quality: omega * bench.plate.modal_mass_kg / bench.plate.damping_n_s_per_m,
            force_factor_n_per_v: bench.plate.force_factor_n_per_v,
            pickup_phase_rad: bench.pickup.phase_rad - omega * bench.converter.skew(1) / RATE_HZ,
            force: [[d / det, -b / det], [-c / det, a / det]],
            tare_n: [
                bench.force_sensor.normal_offset_n,
                bench.force_sensor.lateral_offset_n,
            ],
        }
    }

    /// Replaces the measured values by the true ones.
    pub fn put_into(&self, calibration: &mut CalibrationFile) {
        let pickup = calibration.pickup.as_mut().expect("a calibrated pickup");
        pickup.metres_per_unit.value = self.metres_per_unit;
        let plate = calibration.plate.as_mut().expect("a calibrated plate");
        plate.resonance_hz.value = self.resonance_hz;
        plate.quality.value = self.quality;
        plate.force_factor_n_per_v.value = self.force_factor_n_per_v;
        plate.pickup_phase_rad.value = self.pickup_phase_rad;
        let force = calibration.force.as_mut().expect("a calibrated sensor");
        force.normal_per_normal.value = self.force[0][0];
        force.normal_per_lateral.value = self.force[0][1];
        force.lateral_per_normal.value = self.force[1][0];
        force.lateral_per_lateral.value = self.force[1][1];
        force.normal_tare.value = self.tare_n[0];
        force.lateral_tare.value = self.tare_n[1];
    }
}

/// Returns whether enough of `count` 95 % intervals contain the truth: nine of ten, less one.
pub fn has_coverage(hits: usize, count: usize) -> bool {
    10 * (hits + 1) > 9 * count
}
