//! Detection of a constant load with a decaying reading, as caused by a capacitor between gauge and converter.

/// Number of readings averaged before the maximum is taken.
const PIECE: usize = 40;
/// Smallest reading before the decay, as a share of the load's weight.
const LEAST_RISE: f64 = 0.3;
/// Share of the largest reading under a load below which the load has faded.
const FADED: f64 = 0.5;
/// Number of windows that must each read less than the previous one while a load is still fading.
const FALLING_WINDOWS: usize = 5;

/// Readings under one load, of a sensor that may be AC-coupled.
#[derive(Debug, Clone)]
pub struct Fading {
    zero_n: f64,
    most_n: f64,
    windows: Vec<f64>,
}

impl Fading {
    /// Starts with a sensor that reads `zero_n` before the load is placed.
    #[must_use]
    pub fn new(zero_n: f64) -> Self {
        Self {
            zero_n,
            most_n: 0.0,
            windows: Vec::new(),
        }
    }

    /// Adds readings while the load is being placed.
    pub fn rise(&mut self, readings_n: &[f64]) {
        for piece in readings_n.chunks_exact(PIECE) {
            let mean_n = piece.iter().sum::<f64>() / piece.len() as f64;
            self.most_n = self.most_n.max((mean_n - self.zero_n).abs());
        }
    }

    /// Adds a window of readings with the load in place.
    pub fn window(&mut self, readings_n: &[f64]) {
        self.rise(readings_n);
        let mean_n = readings_n.iter().sum::<f64>() / readings_n.len().max(1) as f64;
        self.windows.push((mean_n - self.zero_n).abs());
    }

    /// Returns the largest and the latest reading if a load of `weight_n` has faded or is still fading.
    #[must_use]
    pub fn faded(&self, weight_n: f64) -> Option<[f64; 2]> {
        let last_n = *self.windows.last()?;
        let is_falling = self.windows.len() >= FALLING_WINDOWS
            && self.windows.windows(2).all(|pair| pair[1] < pair[0]);
        let is_fading =
            self.most_n >= LEAST_RISE * weight_n && (last_n < FADED * self.most_n || is_falling);
        is_fading.then_some([self.most_n, last_n])
    }
}
