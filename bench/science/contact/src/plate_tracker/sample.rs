use num_complex::Complex64;

/// One demodulated sample of the plate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlateSample {
    /// Time, s.
    pub time_s: f64,
    /// Z_m corrected for envelope dynamics, as the pickup reads it, N·s/m.
    pub z_m_corrected_n_s_per_m: Complex64,
    /// Standard deviation of each part of the impedance from noise, N·s/m.
    pub z_m_std_n_s_per_m: f64,
}

/// Load on the plate under a finger.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FingerLoad {
    /// Vibration amplitude under the finger, peak, m.
    pub amplitude_m: f64,
    /// Ratio of the amplitude under the finger to the pickup's.
    pub amplitude_ratio: f64,
    /// Normal force, N.
    pub normal_n: f64,
}
