//! A constant load that fades: what a capacitor between a gauge and its converter makes of it.

/// Readings that are averaged before the largest is looked for.
const PIECE: usize = 40;
/// Share of its weight that a load must have read before it faded.
const LEAST_RISE: f64 = 0.3;
/// Share of the largest reading under a load below which it has faded.
const FADED: f64 = 0.5;
/// Windows that must each read less than the one before, where a load is still fading.
const FALLING_WINDOWS: usize = 5;

/// Readings under one load, of a sensor that may be AC-coupled.
#[derive(Debug, Clone)]
pub struct Fading {
    zero_n: f64,
    most_n: f64,
    windows: Vec<f64>,
}

impl Fading {
    /// Begins with a load that is placed on a sensor that reads `zero_n` without it.
    #[must_use]
    pub fn new(zero_n: f64) -> Self {
        Self {
            zero_n,
            most_n: 0.0,
            windows: Vec::new(),
        }
    }

    /// Takes readings while the load is placed.
    pub fn rise(&mut self, readings_n: &[f64]) {
        for piece in readings_n.chunks_exact(PIECE) {
            let mean_n = piece.iter().sum::<f64>() / piece.len() as f64;
            self.most_n = self.most_n.max((mean_n - self.zero_n).abs());
        }
    }

    /// Takes a window of readings while the load lies there.
    pub fn window(&mut self, readings_n: &[f64]) {
        self.rise(readings_n);
        let mean_n = readings_n.iter().sum::<f64>() / readings_n.len().max(1) as f64;
        self.windows.push((mean_n - self.zero_n).abs());
    }

    /// Returns the largest and the latest reading if a load of `weight_n` has faded, or does so still.
    #[must_use]
    pub fn faded(&self, weight_n: f64) -> Option<[f64; 2]> {
        let last_n = *self.windows.last()?;
        let falls = self.windows.len() >= FALLING_WINDOWS
            && self.windows.windows(2).all(|pair| pair[1] < pair[0]);
        let fades = self.most_n >= LEAST_RISE * weight_n && (last_n < FADED * self.most_n || falls);
        fades.then_some([self.most_n, last_n])
    }
}
