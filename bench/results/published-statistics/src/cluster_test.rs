//! p-values of correlations of pairs that come from few people, with several pairs each.
//!
//! Ten trials of one person are not ten people. If 140 trials of 14 people are treated as independent pairs, 13, 33 or 52 % of
//! studies find a non-existent correlation at 5 %, for intraclass correlations of 0.3, 0.6 and 0.9. Here each person
//! contributes one number, the sum of the products of their centred values (ranks, for Spearman); its sign is equally likely
//! to be positive or negative without a correlation. The p-value is the fraction of all arrangements of signs with a sum at
//! least as far from zero as the observed one. It is a randomisation test under an approximate symmetry (Canay, Romano and
//! Shaikh 2017), identical to the wild cluster bootstrap with every arrangement drawn once (Cameron, Gelbach and Miller 2008).
//! It needs no random numbers, and keeps its level with few people, where a bootstrap of pairs and sandwich errors reject too
//! often.

use serde::Serialize;
use statrs::distribution::{ContinuousCDF, StudentsT};

use correlations::Coefficient;

/// Fewest people for a test: of the 32 arrangements of five signs, two always reach the largest distance, so p is never
/// below 0.06.
pub const FEWEST_PEOPLE: usize = 6;
/// Largest number of people for which all arrangements are tried; with more, the sum is nearly normal.
const MAX_EXACT_PEOPLE: usize = 22;

/// Test of a correlation at the level of people.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Clustered {
    /// Two-sided p-value; `None` with fewer than [`FEWEST_PEOPLE`].
    pub p: Option<f64>,
    /// Number of people.
    pub people: usize,
}

/// Tests the correlation of the pairs in which both values are finite; `people[i]` is the person of pair `i`, as a number from
/// 0. `None` if the coefficient is undefined.
pub fn test(coefficient: Coefficient, x: &[f64], y: &[f64], people: &[usize]) -> Option<Clustered> {
    let is_finite_pair = |&i: &usize| x[i].is_finite() && y[i].is_finite();
    let pairs: Vec<usize> = (0..people.len()).filter(is_finite_pair).collect();
    let scores = |values: &[f64]| coefficient.scores(pairs.iter().map(|&i| values[i]).collect());
    let (x, y) = (scores(x), scores(y));
    coefficient.correlate(&x, &y)?;
    let mut sums = std::collections::BTreeMap::<usize, f64>::new();
    for (&pair, (x, y)) in pairs.iter().zip(deviations(&x).zip(deviations(&y))) {
        *sums.entry(people[pair]).or_default() += x * y;
    }
    let sums: Vec<f64> = sums.into_values().collect();
    Some(Clustered {
        p: (sums.len() >= FEWEST_PEOPLE).then(|| p_value(&sums)),
        people: sums.len(),
    })
}

fn deviations(values: &[f64]) -> impl Iterator<Item = f64> {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    values.iter().map(move |value| value - mean)
}

fn p_value(sums: &[f64]) -> f64 {
    if sums.len() > MAX_EXACT_PEOPLE {
        return normal_p_value(sums);
    }
    let observed_sum = sums.iter().sum::<f64>().abs();
    // Arrangements that differ only by rounding count as equal.
    let slack = 1e-9 * sums.iter().map(|sum| sum.abs()).sum::<f64>();
    // One sign is fixed, because the opposite arrangement is as far from zero. A Gray code changes one of the others at a time.
    let arrangements = 1_u64 << (sums.len() - 1);
    let mut signed_sums = sums.to_vec();
    let (mut sum, mut extreme_count) = (sums.iter().sum::<f64>(), 0_u64);
    for number in 1..=arrangements {
        extreme_count += u64::from(sum.abs() >= observed_sum - slack);
        let index = number.trailing_zeros() as usize;
        signed_sums[index] = -signed_sums[index];
        sum += 2.0 * signed_sums[index];
    }
    extreme_count as f64 / arrangements as f64
}

/// Returns the p-value from the distribution of a studentised sum.
fn normal_p_value(sums: &[f64]) -> f64 {
    let t = sums.iter().sum::<f64>().abs() / sums.iter().map(|sum| sum * sum).sum::<f64>().sqrt();
    let freedom = (sums.len() - 1) as f64;
    StudentsT::new(0.0, 1.0, freedom).map_or(f64::NAN, |student| 2.0 * student.sf(t))
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use rand::{Rng, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    const TRIALS: usize = 10;

    fn normal(rng: &mut impl Rng) -> f64 {
        StandardNormal.sample(rng)
    }

    /// Returns values of people with the given intraclass correlation.
    fn values(rng: &mut impl Rng, people: usize, icc: f64) -> Vec<f64> {
        let person_values = |rng: &mut _| {
            let person_mean = normal(rng);
            let trial = |_| icc.sqrt() * person_mean + (1.0 - icc).sqrt() * normal(rng);
            (0..TRIALS).map(trial).collect::<Vec<_>>()
        };
        (0..people).flat_map(|_| person_values(rng)).collect()
    }

    /// Returns the fractions of studies without a correlation in which the clustered and the pooled test find one at 5 %.
    fn rejection_rates(
        coefficient: Coefficient,
        people: usize,
        icc: f64,
        studies: usize,
    ) -> (f64, f64) {
        let mut rng = ChaCha8Rng::seed_from_u64(140);
        let pair_people: Vec<usize> = (0..people * TRIALS).map(|i| i / TRIALS).collect();
        let (mut clustered, mut pooled) = (0, 0);
        for _ in 0..studies {
            let (x, y) = (values(&mut rng, people, icc), values(&mut rng, people, icc));
            let p = test(coefficient, &x, &y, &pair_people).unwrap().p.unwrap();
            clustered += usize::from(p <= 0.05);
            pooled += usize::from(coefficient.correlate(&x, &y).unwrap().p <= 0.05);
        }
        (
            clustered as f64 / studies as f64,
            pooled as f64 / studies as f64,
        )
    }

    #[test]
    fn the_level_is_kept_where_pooled_trials_of_the_same_people_do_not_keep_it() {
        for (icc, least_pooled) in [(0.0, 0.03), (0.3, 0.10), (0.6, 0.28), (0.9, 0.46)] {
            for coefficient in [Coefficient::Spearman, Coefficient::Pearson] {
                let (clustered, pooled) = rejection_rates(coefficient, 14, icc, 4000);
                assert!((0.03..=0.07).contains(&clustered), "{icc}: {clustered}");
                assert!(pooled > least_pooled, "{icc}: {pooled}");
            }
        }
        let (smallest_group, _) = rejection_rates(Coefficient::Spearman, FEWEST_PEOPLE, 0.6, 2000);
        assert!((0.01..=0.07).contains(&smallest_group), "{smallest_group}");
        let (large_group, _) =
            rejection_rates(Coefficient::Spearman, MAX_EXACT_PEOPLE + 3, 0.6, 2000);
        assert!((0.03..=0.07).contains(&large_group), "{large_group}");
    }

    #[test]
    fn an_existing_correlation_is_found() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let people: Vec<usize> = (0..140).map(|i| i / TRIALS).collect();
        let x = values(&mut rng, 14, 0.3);
        let y: Vec<f64> = x.iter().map(|x| x + normal(&mut rng)).collect();
        let clustered = test(Coefficient::Spearman, &x, &y, &people).unwrap();
        assert!(
            clustered.p.unwrap() < 0.001 && clustered.people == 14,
            "{clustered:?}"
        );
    }

    #[test]
    fn the_p_value_is_the_fraction_of_all_arrangements() {
        // Among 32 pairs of opposite arrangements of 1, 2, 4, 8, 16, 32, one other sum is as large as 61 = 63 - 2.
        assert_relative_eq!(p_value(&[-1.0, 2.0, 4.0, 8.0, 16.0, 32.0]), 2.0 / 32.0);
        assert_relative_eq!(p_value(&[1.0; 6]), 1.0 / 32.0);
    }

    #[test]
    fn five_people_are_too_few_and_constant_values_are_not_tested() {
        let x: Vec<f64> = (0..50).map(f64::from).collect();
        let people: Vec<usize> = (0..50).map(|i| i / 10).collect();
        let clustered = test(Coefficient::Pearson, &x, &x, &people).unwrap();
        assert_eq!(clustered, Clustered { p: None, people: 5 });
        assert_eq!(test(Coefficient::Pearson, &[1.0; 50], &x, &people), None);
    }
}
