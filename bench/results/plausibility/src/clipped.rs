//! Forces cut off at the end of a range: of the sensor, its amplifier or its converter.

/// Fewest readings at the limit, and fewest stretches of them: a force that is held by chance comes there once.
const FEWEST: usize = 50;
const FEWEST_RUNS: usize = 4;
/// Fewest consecutive readings of a stretch.
const SHORTEST_RUN: usize = 3;
/// Shares of the readings beyond half the limit between which those at it lie: a load that rests has all of them there.
const SHARES: [f64; 2] = [0.01, 0.8];
/// Number of steps between zero and the limit from which on a converter resolves the top of a force.
const FEWEST_STEPS: f64 = 100.0;
/// Width of a band below the limit, relative to it, and the ratio of the readings at the limit to those in either of two such bands:
/// the crests of a sine have 2.4 times as many in the first band as in the second.
const BAND: f64 = 1e-3;
const RATIO: usize = 8;

/// Limit at which readings were cut off.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limit {
    /// Reading at the limit.
    pub value: f64,
    /// Number of readings there.
    pub count: usize,
}

/// Returns the limit at which readings in their order were cut off, if they were.
#[must_use]
pub fn limit(values: &[f64]) -> Option<Limit> {
    let upper = upper_limit(values);
    upper.or_else(|| {
        let turned: Vec<f64> = values.iter().map(|value| -value).collect();
        upper_limit(&turned).map(|limit| Limit {
            value: -limit.value,
            ..limit
        })
    })
}

fn upper_limit(values: &[f64]) -> Option<Limit> {
    let finite = values.iter().copied().filter(|value| value.is_finite());
    let greatest = finite.fold(f64::NEG_INFINITY, f64::max);
    if greatest.is_nan() || greatest <= 0.0 {
        return None;
    }
    let runs = values.chunk_by(|a, b| (*a == greatest) == (*b == greatest));
    let runs = runs.filter(|run| run[0] == greatest && run.len() >= SHORTEST_RUN);
    if runs.count() < FEWEST_RUNS {
        return None;
    }
    let high = values
        .iter()
        .copied()
        .filter(|value| *value > greatest / 2.0);
    let mut high: Vec<f64> = high.collect();
    high.sort_by(f64::total_cmp);
    let count = high.len() - high.partition_point(|value| *value < greatest);
    let share = count as f64 / high.len() as f64;
    if count < FEWEST || !(SHARES[0]..=SHARES[1]).contains(&share) {
        return None;
    }
    let steps = high.windows(2).map(|pair| pair[1] - pair[0]);
    let step = steps.filter(|step| *step > 0.0).fold(greatest, f64::min);
    if step > greatest / FEWEST_STEPS {
        return None;
    }
    let band = (BAND * greatest).max(1.01 * step);
    let below = |bands: f64| high.partition_point(|value| *value < greatest - bands * band);
    let top = high.len() - count;
    let neighbours = [top - below(1.0), below(1.0) - below(2.0)];
    let is_cut = neighbours
        .into_iter()
        .all(|neighbour| count > RATIO * neighbour);
    is_cut.then_some(Limit {
        value: greatest,
        count,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const RATE_HZ: f64 = 1e4;

    /// Friction of a stroke under modulation from 1 to 3 s, with noise, before a converter with this step.
    fn friction(amplitude: f64, step: f64) -> Vec<f64> {
        let value = |n: u32| {
            let time_s = f64::from(n) / RATE_HZ;
            let noise = 0.002 * (1.7 * f64::from(n)).sin();
            let pressed = f64::from((1.0..3.0).contains(&time_s));
            let modulated = 0.6 + 0.4 * (std::f64::consts::TAU * 6.0 * time_s).sin();
            let value = amplitude * pressed * modulated + noise;
            if step > 0.0 {
                (value / step).round() * step
            } else {
                value
            }
        };
        (0..40_000).map(value).collect()
    }

    fn cut(values: &[f64], limit: f64) -> Vec<f64> {
        values
            .iter()
            .map(|value| value.clamp(-limit, limit))
            .collect()
    }

    #[test]
    fn a_force_beyond_the_range_is_cut_off_at_either_end() {
        for step in [0.0, 0.001] {
            let values = friction(0.5, step);
            let found = limit(&cut(&values, 0.35)).unwrap();
            assert!(
                (found.value - 0.35).abs() < 1e-12 && found.count > 1000,
                "{found:?}"
            );
            let turned: Vec<f64> = cut(&values, 0.35).iter().map(|value| -value).collect();
            assert!((limit(&turned).unwrap().value + 0.35).abs() < 1e-12);
        }
    }

    #[test]
    fn crests_rests_and_coarse_converters_are_not_cut_off() {
        for step in [0.0, 1e-4, 0.001, 0.005, 0.02, 0.1] {
            assert_eq!(limit(&friction(0.5, step)), None, "{step}");
        }
        // Without noise, every crest is the same.
        let tone = |step: f64| {
            let sine = |n: u32| {
                (0.5 * (std::f64::consts::TAU * 6.0 * f64::from(n) / RATE_HZ).sin() / step).round()
                    * step
            };
            (0..40_000).map(sine).collect::<Vec<f64>>()
        };
        for step in [1e-6, 1e-4, 0.001, 0.004] {
            assert_eq!(limit(&tone(step)), None, "{step}");
        }
        // A weight that is put down ten times.
        let weight =
            |n: u32| f64::from(u8::from(n % 4000 > 1500)) * 0.65 + 1e-5 * f64::from(n % 7 / 6);
        let weights: Vec<f64> = (0..40_000).map(weight).collect();
        assert_eq!(limit(&weights), None);
        assert_eq!(limit(&[]), None);
        assert_eq!(limit(&[f64::NAN; 100]), None);
        assert_eq!(limit(&[0.5; 100]), None);
    }
}
