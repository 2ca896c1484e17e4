//! Spectrum of the forces without a finger: hum of the mains, and the lack of noise that a low-pass leaves behind.
//!
//! The noise of a sensor and its converter is flat up to the frequencies that the sensor follows. Readings that were low-passed have
//! a noise that falls from the cut-off on, and goes on falling, whereas that of a resting hand falls to the floor of the sensor.

use std::f64::consts::TAU;

use recording::ForceRow;
use statistics::{StraightLine, median};

use crate::Column;
use crate::implausible::Implausible;

/// Shortest interval, s, and fewest and most rows of a spectrum.
const SHORTEST_S: f64 = 0.5;
const FEWEST: usize = 256;
const MOST: usize = 1 << 17;
/// Largest deviation of a row from even spacing, in intervals.
const UNEVEN: f64 = 0.6;
/// Frequencies of the mains and of their rectified ripple, Hz, and the distance of a line from them in resolutions of the spectrum.
const MAINS_HZ: [f64; 4] = [50.0, 60.0, 100.0, 120.0];
const LINE_WIDTH: f64 = 1.5;
/// Smallest amplitude of a hum, N, and of its power over that beside it.
const SMALLEST_HUM_N: f64 = 0.02;
const PROMINENT: f64 = 100.0;
/// Smallest amplitude at the modulation without a finger, N, and in RMS residuals about it; fewest periods.
const SMALLEST_COUPLED_N: f64 = 0.01;
const TONE: f64 = 0.5;
const FEWEST_PERIODS: f64 = 3.0;
/// Bands in frequencies of the modulation: those that friction needs to follow it, and those beyond.
const NEEDED: [f64; 2] = [6.0, 12.0];
const BEYOND: [f64; 2] = [20.0, 40.0];
/// Power in the needed band relative to that below the modulation, and power beyond relative to the needed band, of a low-pass.
const LEAST_NEEDED: f64 = 1e-3;
const LEAST_BEYOND: f64 = 0.1;
/// Relative power at the cut-off.
const CUT_OFF: f64 = 0.05;

/// Power spectrum of a column.
struct Spectrum {
    /// Distance of the lines, Hz.
    step_hz: f64,
    /// Squared amplitude of each line of a steady tone, N².
    powers: Vec<f64>,
}

impl Spectrum {
    fn line(&self, hz: f64) -> usize {
        (hz / self.step_hz).round() as usize
    }

    fn band(&self, from_hz: f64, to_hz: f64) -> &[f64] {
        let (from, to) = (self.line(from_hz).max(2), self.line(to_hz));
        self.powers
            .get(from..to.min(self.powers.len()))
            .unwrap_or_default()
    }

    fn reaches(&self, hz: f64) -> bool {
        self.line(hz) < self.powers.len()
    }
}

/// Returns the findings of the forces in the longest of the intervals `unloaded_s`; the film modulates friction at `modulation_hz`, if
/// it is known.
#[must_use]
pub fn at_rest(
    rows: &[ForceRow],
    unloaded_s: &[(f64, f64)],
    modulation_hz: Option<f64>,
) -> Vec<Implausible> {
    let longest = unloaded_s
        .iter()
        .max_by(|a, b| (a.1 - a.0).total_cmp(&(b.1 - b.0)));
    let Some(&(start_s, end_s)) = longest else {
        return Vec::new();
    };
    let first = rows.partition_point(|row| row.time_s < start_s);
    let end = rows.partition_point(|row| row.time_s <= end_s);
    let inside = rows.get(first..end.min(first + MOST)).unwrap_or_default();
    let columns: [(&'static str, Column); 2] = [
        ("normal_n", |row| row.normal_n),
        ("lateral_n", |row| row.lateral_n),
    ];
    let spectra = columns.map(|(name, value)| (name, spectrum(inside, value)));
    let spectra = spectra
        .iter()
        .filter_map(|(name, spectrum)| Some((*name, spectrum.as_ref()?)));
    let hums = spectra
        .clone()
        .filter_map(|(name, spectrum)| hum(name, spectrum));
    let smoothed = spectra.filter_map(|(name, spectrum)| smoothed(name, spectrum, modulation_hz?));
    let coupled = columns.iter().filter_map(|(name, value)| {
        let amplitude_n = coupled_n(inside, *value, modulation_hz?)?;
        Some(Implausible::Coupled {
            column: (*name).into(),
            amplitude_n,
        })
    });
    hums.chain(smoothed).chain(coupled).collect()
}

/// Returns the amplitude at the modulation of readings without a finger, N, if the amplifier's voltage is in them: by whole periods, about
/// their straight line.
fn coupled_n(rows: &[ForceRow], value: Column, modulation_hz: f64) -> Option<f64> {
    let (first_s, last_s) = (rows.first()?.time_s, rows.last()?.time_s);
    let periods = ((last_s - first_s) * modulation_hz).floor();
    let end_s = first_s + periods / modulation_hz;
    let inside: Vec<(f64, f64)> = rows
        .iter()
        .map(|row| (row.time_s - first_s, value(row)))
        .filter(|(time_s, force_n)| first_s + time_s < end_s && force_n.is_finite())
        .collect();
    if periods < FEWEST_PERIODS || inside.len() < FEWEST {
        return None;
    }
    let n = inside.len() as f64;
    let mean = |value: &dyn Fn(&(f64, f64)) -> f64| inside.iter().map(value).sum::<f64>() / n;
    let line = StraightLine::fit(&inside)?;
    let rest = |row: &(f64, f64)| row.1 - line.at(row.0);
    let omega = TAU * modulation_hz;
    let cosine = 2.0 * mean(&|row| rest(row) * (omega * row.0).cos());
    let sine = 2.0 * mean(&|row| rest(row) * (omega * row.0).sin());
    let amplitude_n = cosine.hypot(sine);
    let residual = |row: &(f64, f64)| {
        rest(row) - cosine * (omega * row.0).cos() - sine * (omega * row.0).sin()
    };
    let residual_n = mean(&|row| residual(row).powi(2)).sqrt();
    // What is left of a touch or of a hand is not a tone.
    let is_tone = amplitude_n > TONE * residual_n;
    (amplitude_n >= SMALLEST_COUPLED_N && is_tone).then_some(amplitude_n)
}

/// Returns the spectrum of evenly spaced rows about their straight line.
fn spectrum(rows: &[ForceRow], value: Column) -> Option<Spectrum> {
    let (first, last) = (rows.first()?, rows.last()?);
    let duration_s = last.time_s - first.time_s;
    if rows.len() < FEWEST || duration_s < SHORTEST_S {
        return None;
    }
    let n = rows.len() as f64;
    let step_s = duration_s / (n - 1.0);
    let place = |row: &ForceRow| (row.time_s - first.time_s) / step_s;
    let is_even = |(index, row): (usize, &ForceRow)| (place(row) - index as f64).abs() < UNEVEN;
    if !rows.iter().enumerate().all(is_even) || !rows.iter().all(|row| value(row).is_finite()) {
        return None;
    }
    let points: Vec<(f64, f64)> = { rows.iter() }
        .map(|row| (row.time_s, value(row)))
        .collect();
    let line = StraightLine::fit(&points)?;
    let values: Vec<f64> = points
        .iter()
        .map(|(time_s, force_n)| force_n - line.at(*time_s))
        .collect();
    Some(Spectrum {
        step_hz: 1.0 / (n * step_s),
        powers: fourier::tone_powers(&values),
    })
}

fn hum(column: &'static str, spectrum: &Spectrum) -> Option<Implausible> {
    MAINS_HZ.into_iter().find_map(|mains_hz| {
        if !spectrum.reaches(1.5 * mains_hz) {
            return None;
        }
        let reach_hz = LINE_WIDTH * spectrum.step_hz;
        let near = spectrum.band(mains_hz - reach_hz, mains_hz + reach_hz + spectrum.step_hz);
        let power = near.iter().copied().reduce(f64::max)?;
        let beside = median(
            spectrum
                .band(0.4 * mains_hz, 1.4 * mains_hz)
                .iter()
                .copied(),
        )?;
        let amplitude_n = power.sqrt();
        (amplitude_n >= SMALLEST_HUM_N && power > PROMINENT * beside).then(|| Implausible::Hum {
            column: column.into(),
            amplitude_n,
            hz: mains_hz,
        })
    })
}

fn smoothed(column: &'static str, spectrum: &Spectrum, modulation_hz: f64) -> Option<Implausible> {
    let band = |[from, to]: [f64; 2]| spectrum.band(from * modulation_hz, to * modulation_hz);
    let lowest_hz = 2.0 * spectrum.step_hz;
    if lowest_hz > 0.7 * modulation_hz || !spectrum.reaches(BEYOND[1] * modulation_hz) {
        return None;
    }
    let below = spectrum.band(lowest_hz, 1.3 * modulation_hz);
    let below = below.iter().sum::<f64>() / below.len() as f64;
    let needed = median(band(NEEDED).iter().copied())?;
    let beyond = median(band(BEYOND).iter().copied())?;
    if needed >= LEAST_NEEDED * below || beyond >= LEAST_BEYOND * needed || beyond.is_nan() {
        return None;
    }
    let mean = |hz: f64| {
        let band = spectrum.band(hz, 1.4 * hz + spectrum.step_hz);
        band.iter().sum::<f64>() / band.len() as f64
    };
    let lines = spectrum.line(lowest_hz)..spectrum.line(NEEDED[0] * modulation_hz);
    let cut_off = lines
        .map(|line| line as f64 * spectrum.step_hz)
        .find(|hz| mean(*hz) < CUT_OFF * below);
    Some(Implausible::Smoothed {
        column: column.into(),
        cut_off_hz: cut_off.unwrap_or(NEEDED[0] * modulation_hz),
        modulation_hz,
    })
}

#[cfg(test)]
mod tests {
    use impedance::smoothing::LowPass;

    use super::*;

    /// Readings at 1 kHz with noise of 2 mN, by a generator of Numerical Recipes, that rest from 0 to 1.5 s.
    fn noise() -> Vec<f64> {
        let mut state = 12_345_u32;
        let mut next = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(state) / f64::from(u32::MAX) - 0.5
        };
        (0..3000)
            .map(|_| 0.004 * (next() + next() + next()))
            .collect()
    }

    fn rows(forces: &[f64]) -> Vec<ForceRow> {
        let row = |(n, force): (usize, &f64)| ForceRow {
            time_s: n as f64 * 1e-3,
            normal_n: *force,
            lateral_n: 0.5 * force,
        };
        forces.iter().enumerate().map(row).collect()
    }

    fn low_passed(cut_off_hz: f64) -> Vec<f64> {
        let filter = LowPass::new(cut_off_hz, 1e3).unwrap();
        filter.zero_phase(&noise()).unwrap()
    }

    fn words(forces: &[f64]) -> Vec<String> {
        let found = at_rest(&rows(forces), &[(0.0, 1.5)], Some(6.0));
        found.iter().map(ToString::to_string).collect()
    }

    #[test]
    fn a_low_pass_below_the_harmonics_of_the_modulation_is_named() {
        for cut_off_hz in [8.0, 10.0, 15.0] {
            let found = words(&low_passed(cut_off_hz));
            assert!(
                found.len() == 2
                    && found[0].contains("without a finger normal_n has hardly any noise"),
                "{cut_off_hz}: {found:?}"
            );
        }
        assert_eq!(words(&low_passed(100.0)), [""; 0], "of the sensor");
    }

    #[test]
    fn noise_drift_a_resting_hand_and_a_coarse_sensor_are_not_filtered() {
        assert_eq!(words(&noise()), [""; 0]);
        let with = |added: fn(f64) -> f64| -> Vec<f64> {
            let forces = noise();
            let times = (0..).map(|n| f64::from(n) * 1e-3);
            forces
                .iter()
                .zip(times)
                .map(|(force, time_s)| force + added(time_s))
                .collect()
        };
        assert_eq!(words(&with(|time_s| 0.2 * time_s)), [""; 0]);
        let hand = |time_s: f64| 0.5 + 0.1 * (5.0 * time_s).sin() + 0.02 * (20.0 * time_s).sin();
        assert_eq!(words(&with(hand)), [""; 0]);
        let coarse = noise()
            .into_iter()
            .map(|force| (force / 0.01).round() * 0.01);
        assert_eq!(words(&coarse.collect::<Vec<f64>>()), [""; 0]);
        assert_eq!(words(&[0.0; 3000]), [""; 0]);
        assert_eq!(at_rest(&[], &[(0.0, 1.0)], Some(6.0)), []);
    }

    #[test]
    fn hum_is_named_with_its_amplitude() {
        for mains_hz in [50.0, 60.0] {
            let forces: Vec<f64> = noise()
                .iter()
                .enumerate()
                .map(|(n, force)| force + 0.1 * (TAU * mains_hz * n as f64 * 1e-3).sin())
                .collect();
            let found = words(&forces);
            assert!(
                found.len() == 2
                    && found[0].contains(&format!("normal_n has a hum of 0.10 N at {mains_hz} Hz")),
                "{found:?}"
            );
        }
    }

    #[test]
    fn the_drives_voltage_in_a_force_is_named() {
        let rows = |coupled_n: f64| -> Vec<ForceRow> {
            let forces = noise();
            let row = |(n, force): (usize, &f64)| {
                let time_s = n as f64 * 1e-3;
                ForceRow {
                    time_s,
                    normal_n: force + coupled_n * (1.0 + (TAU * 6.0 * time_s).sin()),
                    lateral_n: *force,
                }
            };
            forces.iter().enumerate().map(row).collect()
        };
        let found = |coupled_n: f64| at_rest(&rows(coupled_n), &[(0.0, 1.4)], Some(6.0));
        assert!(found(0.001).is_empty());
        let found = found(0.03);
        let [
            Implausible::Coupled {
                column,
                amplitude_n,
            },
        ] = &found[..]
        else {
            panic!("{found:?}");
        };
        assert_eq!(column, "normal_n");
        assert!((amplitude_n - 0.03).abs() < 2e-3, "{amplitude_n}");
    }
}
