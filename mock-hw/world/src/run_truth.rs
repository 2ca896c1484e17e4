//! Truth of a run, written for tests; the bench never reads it.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use serde::Serialize;

use crate::fingertip::Fingertip;
use crate::scenario::Scenario;

/// Constants of a run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TruthConstants {
    /// Audio frames per second of true time.
    pub frames_per_s: f64,
    /// Impedance γU/ṽ at the pickup without a finger, at the plate's resonance, before any drift: real and imaginary part,
    /// N·s/m.
    pub z_p_n_s_per_m: [f64; 2],
    /// Initial skin and its contact with the plate; these replace the values of the scenario. The series follows their drift.
    pub fingertip: Fingertip,
    /// Scenario with the constants drawn from the seed.
    pub scenario: Scenario,
}

/// The truth at one moment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TruthSample {
    /// True time since the simulation began, s.
    pub time_s: f64,
    /// Index of the input frame at that moment, from the latest setting of the audio rate.
    pub frame: u64,
    /// Asperity scale σ_t, m.
    pub sigma_t_m: f64,
    /// Tissue impedance at the plate's resonance, real and imaginary part, N·s/m.
    pub z_t_n_s_per_m: [f64; 2],
    /// Friction coefficient without vibration, at the speed, load and age of the contact at that moment.
    pub mu0: f64,
    /// Mean gap, m; NaN while the finger is off the plate.
    pub gap_m: f64,
    /// Contact stiffness k_c, N/m; 0 while the finger is off the plate.
    pub k_c_n_per_m: f64,
    /// Friction coefficient of full sliding; NaN while the finger is off the plate.
    pub mu: f64,
    /// Normal force, N.
    pub normal_n: f64,
    /// Lateral force, N, positive towards increasing position.
    pub lateral_n: f64,
    /// Position of the finger along the plate, m.
    pub position_m: f64,
    /// Velocity of the finger along the plate, m/s.
    pub velocity_m_per_s: f64,
    /// Peak amplitude of the plate under the finger, on the mode's crest across the plate, averaged over some carrier periods, m.
    pub amplitude_m: f64,
    /// Shift of the carrier mode's resonance from its initial value, Hz.
    pub resonance_shift_hz: f64,
    /// Damping b_p of the carrier mode, N·s/m.
    pub damping_n_s_per_m: f64,
    /// Apparent contact area S, m²; 0 while the finger is off the plate.
    pub contact_area_m2: f64,
    /// Amplitude of the carrier mode under the finger relative to that at the pickup; 1 while the finger is off the plate.
    pub amplitude_ratio: f64,
    /// Time constant of levitation at the present gap, s; NaN while the finger is off the plate.
    pub lag_s: f64,
}

/// Writes `truth.json` (constants) and `truth.csv` (series) into a folder.
#[derive(Debug)]
pub struct TruthWriter {
    series: BufWriter<File>,
}

impl TruthWriter {
    /// Creates both files in `folder`, which must exist and not contain them yet.
    ///
    /// # Errors
    /// `AlreadyExists` if a file exists, and other errors of the file system.
    pub fn create(folder: &Path, constants: &TruthConstants) -> io::Result<Self> {
        let mut json = File::create_new(folder.join("truth.json"))?;
        serde_json::to_writer_pretty(&mut json, constants)?;
        json.write_all(b"\n")?;
        let mut series = BufWriter::new(File::create_new(folder.join("truth.csv"))?);
        writeln!(
            series,
            "time_s,frame,sigma_t_m,re_z_t_n_s_per_m,im_z_t_n_s_per_m,mu0,gap_m,k_c_n_per_m,mu,normal_n,lateral_n,\
             position_m,velocity_m_per_s,amplitude_m,resonance_shift_hz,damping_n_s_per_m,contact_area_m2,\
             amplitude_ratio,lag_s"
        )?;
        Ok(Self { series })
    }

    /// Appends samples to the series.
    ///
    /// # Errors
    /// Errors of the file system.
    pub fn record(&mut self, samples: &[TruthSample]) -> io::Result<()> {
        for s in samples {
            let [re, im] = s.z_t_n_s_per_m;
            writeln!(
                self.series,
                "{:.6},{},{:e},{re},{im},{},{:e},{:e},{},{},{},{},{},{:e},{:.4},{:.5},{:e},{:.5},{:e}",
                s.time_s,
                s.frame,
                s.sigma_t_m,
                s.mu0,
                s.gap_m,
                s.k_c_n_per_m,
                s.mu,
                s.normal_n,
                s.lateral_n,
                s.position_m,
                s.velocity_m_per_s,
                s.amplitude_m,
                s.resonance_shift_hz,
                s.damping_n_s_per_m,
                s.contact_area_m2,
                s.amplitude_ratio,
                s.lag_s
            )?;
        }
        Ok(())
    }

    /// Writes all buffered data.
    ///
    /// # Errors
    /// Errors of the file system.
    pub fn finish(mut self) -> io::Result<()> {
        self.series.flush()
    }
}
